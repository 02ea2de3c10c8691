# SPDX-License-Identifier: GPL-3.0-or-later
"""The one table of sensor kinds. A new kind is a file beside this one and an entry here."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from .light import LightParameters, LightSensor
from .motion_detector import MotionDetector
from .optical_switch import OpticalSwitchParameters, SlottedSwitch
from .parameters import Parameters
from .pir import PirParameters
from .pressure import PressurePad, PressureParameters

NO_KIND = "NONE"


@dataclass(frozen=True)
class Field:
    """A published quantity: its name in logs and its Python type (bool, float, int or str).

    `step` names the parameter that tells by how much it must change to be an event; else any
    change is one. `optional`: left out of a file in which it would be empty throughout.
    """

    name: str
    type: type
    step: str = ""
    optional: bool = False


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
    value_unit: str
    active_label: str
    idle_label: str
    parameters: type[Parameters]
    events: tuple[Field, ...]
    samples: tuple[Field, ...]
    model: Callable[[], Any]
    motion: bool = False
    light: bool = False


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
            "rad",
            "Motion",
            "Still",
            PirParameters,
            events=(Field("moved", bool),),
            samples=(
                Field("angle_rad", float),
                Field("moved", bool),
                Field("signal", float, optional=True),
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
            "m",
            "Open",
            "Closed",
            OpticalSwitchParameters,
            events=(Field("open", bool),),
            samples=(Field("open", bool), Field("range_m", float)),
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
            "N",
            "Pressed",
            "Free",
            PressureParameters,
            events=(
                Field("pressed", bool),
                Field("force_n", float, step="report_step"),
                Field("partners", str),
                Field("valid", bool),
            ),
            samples=(
                Field("force_n", float),
                Field("pressed", bool),
                Field("valid", bool),
                Field("residual", float),
                Field("resistance_ohm", float),
                Field("voltage_v", float),
                Field("adc", int),
                Field("partners", str),
                Field("cop_x_m", float),
                Field("cop_y_m", float),
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
            "%",
            "Lit",
            "Dark",
            LightParameters,
            events=(
                Field("luminance_percent", float, step="report_step"),
                Field("illuminance_lux", float, step="report_step"),
                Field("lit", bool),
            ),
            samples=(
                Field("luminance_percent", float),
                Field("illuminance_lux", float),
                Field("resistance_ohm", float),
                Field("voltage_v", float),
                Field("lit", bool),
            ),
            model=LightSensor,
            light=True,
        ),
    )
}
