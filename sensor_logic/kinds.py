# SPDX-License-Identifier: GPL-3.0-or-later
"""The one table of sensor kinds. A new kind is a file beside this one and an entry here."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from . import quantities
from .light import FOUR_WALL, ILLUMINANCE, LightParameters, LightSensor
from .motion_detector import MotionDetector
from .optical_switch import OpticalSwitchParameters, SlottedSwitch
from .parameters import READING, Parameters, Spec, UsedWhen, is_chosen
from .pir import PYRO, SCAN, PirParameters
from .pressure import PressurePad, PressureParameters
from .quantities import METRES, OF_THRESHOLD, Lengths

NO_KIND = "NONE"


@dataclass(frozen=True)
class Field:
    """A published quantity: its name in logs and its Python type (bool, float, int or str).

    `unit` is what it is counted in (SI, radians; empty: a plain number), `decimals` how many of
    them are shown. `step` names the parameter that tells by how much it must change to be an
    event; else any change is one. `optional`: left out of a file in which it would be empty
    throughout. `used_when`: with which choices of parameters it is measured. `quantity`: what it
    measures, by which the formats of other tools know it ("motion", "force" …).
    """

    name: str
    type: type
    unit: str = ""
    decimals: int | None = None
    step: str = ""
    optional: bool = False
    used_when: UsedWhen = ()
    quantity: str = ""

    def text(self, value: float, lengths: Lengths = METRES) -> str:
        """A value of it with its unit, as every place shows it."""
        return quantities.measured(value, self.unit, self.decimals, lengths)

    def short(self, value: float, lengths: Lengths = METRES) -> str:
        """The same in three or four digits."""
        return quantities.short(value, self.unit, lengths)


@dataclass(frozen=True)
class Kind:
    """A kind of sensor. `number` is what files store; `attribute` is where its parameters are.

    `active_label` and `idle_label` are the words for its binary reading. `events` are the fields
    whose changes the event log tells, `samples` the columns of its own file. `model` makes what
    senses for one sensor. `motion`: its reading needs the frames before and after its own;
    `light`: it needs a picture of the light.
    """

    identifier: str
    number: int
    label: str
    tip: str
    icon: str
    attribute: str
    update_rate: float
    active_label: str
    idle_label: str
    parameters: type[Parameters]
    events: tuple[Field, ...]
    samples: tuple[Field, ...]
    model: Callable[[], Any]
    motion: bool = False
    light: bool = False

    @property
    def fields(self) -> dict[str, Field]:
        """Everything that it publishes, by name."""
        return {field.name: field for field in (*self.samples, *self.events)}

    def reading(self, parameters: Any) -> Field:
        """What its main reading, the output `value`, is with these parameters: the first number
        that is measured."""
        return next(
            f for f in self.samples if f.type is float and is_chosen(parameters, f.used_when)
        )

    def unit_of(self, spec: Spec, parameters: Any) -> str:
        """What a parameter is counted in: of some, such as a threshold, that is the unit of what
        is read."""
        return self.reading(parameters).unit if spec.unit == READING else spec.unit


FORCE = Field("force_n", float, "N", 2, step="report_step", quantity="force")
PERCENT = Field(
    "luminance_percent", float, "%", 1, step="report_step", quantity="luminance", **FOUR_WALL
)
LUX = Field(
    "illuminance_lux", float, "lx", step="report_step", quantity="illuminance", **ILLUMINANCE
)

KINDS: dict[str, Kind] = {
    kind.identifier: kind
    for kind in (
        Kind(
            "PIR",
            1,
            "Motion detector (PIR)",
            "Passive infrared motion detector",
            "LIGHT_AREA",
            "pir",
            10.0,
            "Motion",
            "Still",
            PirParameters,
            events=(Field("moved", bool, quantity="motion"),),
            samples=(
                Field("angle_rad", float, "rad", 0, **SCAN),
                Field("moved", bool),
                Field("signal", float, OF_THRESHOLD, 0, optional=True, **PYRO),
            ),
            model=MotionDetector,
        ),
        Kind(
            "OPTICAL_SWITCH",
            2,
            "Optical switch",
            "Slotted optical switch, for doors and shutters",
            "SNAP_EDGE",
            "optical_switch",
            1.0,
            "Open",
            "Closed",
            OpticalSwitchParameters,
            events=(Field("open", bool, quantity="opening"),),
            samples=(Field("open", bool), Field("range_m", float, "m", 3)),
            model=SlottedSwitch,
        ),
        Kind(
            "PRESSURE",
            3,
            "Pressure sensor",
            "Pressure sensor under furniture",
            "TRIA_DOWN_BAR",
            "pressure",
            1.0,
            "Pressed",
            "Free",
            PressureParameters,
            events=(
                Field("pressed", bool, quantity="occupancy"),
                FORCE,
                Field("partners", str, quantity="names"),
                Field("valid", bool, quantity="validity"),
            ),
            samples=(
                FORCE,
                Field("pressed", bool),
                Field("valid", bool),
                Field("residual", float),
                Field("resistance_ohm", float, "Ω"),
                Field("voltage_v", float, "V", 2),
                Field("adc", int),
                Field("partners", str),
                Field("cop_x_m", float, "m", 3),
                Field("cop_y_m", float, "m", 3),
                Field("problem", str),
            ),
            model=PressurePad,
            motion=True,
        ),
        Kind(
            "LIGHT",
            4,
            "Light sensor",
            "Light sensor: luminance or illuminance",
            "LIGHT_SUN",
            "light",
            1.0,
            "Lit",
            "Dark",
            LightParameters,
            events=(
                PERCENT,
                LUX,
                Field("lit", bool, quantity="light"),
            ),
            samples=(
                PERCENT,
                LUX,
                Field("resistance_ohm", float, "Ω"),
                Field("voltage_v", float, "V", 2),
                Field("lit", bool),
            ),
            model=LightSensor,
            light=True,
        ),
    )
}
