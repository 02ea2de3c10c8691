# SPDX-License-Identifier: GPL-3.0-or-later
"""The parameters of presence radars."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...logs.wording import METRES, Advice, Lengths
from ...model import Array
from ...parameters import Choice, Parameters, parameter
from ...radio.substances import LIGHT_SPEED

LD2410 = "Hi-Link, HLK-LD2410 user manual V1.02"
LD2410_SERIAL = "Hi-Link, LD2410C serial communication protocol V1.09: factory settings"
MEASURED = "measured with an LD2410B: docs/presence_radar.md"
# The scales of energies.
AMPLITUDE, DECIBELS = "AMPLITUDE", "DECIBELS"
MAX_RAYS = 100_000
MAX_GATES = 1_000
# m/s. What seems faster has jumped, as a replaced instance does, and does not count as moving.
FASTEST = 10.0
# A threshold that no energy exceeds, and one that switches a gate off.
NEVER, OFF = 100.0, 0.0
# rad, m. Much narrower fields of view and longer ranges give powers that are no longer numbers.
# NARROWEST is 1°, in the digits of single precision that Blender keeps.
NARROWEST, FARTHEST = 0.01745329, 100.0

# The parameters with a number for each gate: of movement, and of who only breathes.
THRESHOLDS = "moving_thresholds", "still_thresholds"
FLOORS = "moving_floors", "still_floors"


@dataclass(frozen=True)
class RadarParameters(Parameters):
    """The parameters of a presence radar."""

    frequency: float = parameter(
        24.125, "Frequency", "Carrier frequency", unit="GHz", minimum=1.0, maximum=100.0,
        source=LD2410, short="Carrier",
    )  # fmt: skip
    horizontal_fov: float = parameter(
        math.radians(120),
        "Horizontal field of view",
        "Angle between the directions in which the antenna has half of its gain. Outside, it falls "
        "on, up to 1.5 times this angle and at most 78° from the axis. Datasheets: detection "
        "angle, azimuth",
        unit="rad",
        minimum=NARROWEST,
        maximum=math.radians(178),
        source=LD2410,
        short="Horizontal",
    )
    vertical_fov: float = parameter(
        math.radians(120),
        "Vertical field of view",
        "The same angle in the vertical plane. Datasheets: pitch angle",
        unit="rad",
        minimum=NARROWEST,
        maximum=math.radians(178),
        source=LD2410,
        short="Vertical",
    )
    rays_across: int = parameter(
        60, "Rays across", "Rays in a row. More rays detect smaller and farther bodies", minimum=1
    )
    rays_up: int = parameter(30, "Rays up", "Rows of rays", minimum=1)
    range_min: float = parameter(0.0, "Range min", "Anything nearer is not detected", unit="m")
    range_max: float = parameter(
        6.0,
        "Range max",
        "Middle of the last gate. Anything farther by more than half a gate is not detected. "
        "Datasheets: farthest gate",
        unit="m",
        maximum=FARTHEST,
        positive=True,
        source=LD2410,
    )
    gate_length: float = parameter(
        0.75,
        "Gate length",
        "Distance between the middles of gates: c/2B, with B the bandwidth of the sweep. Gate 0 is "
        "around 0 m. Bodies closer together than this are one target. Datasheets: distance "
        "resolution",
        unit="m",
        minimum=0.01,
        source=LD2410,
        short="Gate",
    )
    range_scale: float = parameter(
        1.0,
        "Distance scale",
        "Reported distance over true distance, of a module whose sweep is wider than it assumes. "
        "All distances and gates of this sensor are reported ones",
        minimum=0.5,
        maximum=2.0,
        source=MEASURED,
        short="Scale",
    )
    moving_range: float = parameter(
        6.0,
        "Range of moving",
        "A person who walks straight ahead has the Moving energy at this distance, on the mean",
        unit="m",
        minimum=0.1,
        maximum=FARTHEST,
        source=LD2410,
        short="Moving",
    )
    moving_energy: float = parameter(
        15.0,
        "Moving energy",
        "The energy (0 to 100, no unit) of a walking person at the Range of moving: usually the "
        "factory threshold of its gate",
        minimum=1.0,
        maximum=100.0,
        source=LD2410_SERIAL,
        short="Walk energy",
    )
    still_range: float = parameter(
        5.0,
        "Range of still",
        "A person straight ahead who only breathes has the Still energy at this distance",
        unit="m",
        minimum=0.1,
        maximum=FARTHEST,
        source=LD2410,
        short="Still",
    )
    still_energy: float = parameter(
        20.0,
        "Still energy",
        "The energy (0 to 100, no unit) of a breathing person at the Range of still: usually the "
        "factory threshold of its gate",
        minimum=1.0,
        maximum=100.0,
        source=LD2410_SERIAL,
        short="Still energy",
    )
    scale: str = parameter(
        AMPLITUDE,
        "Energy scale",
        "How the module reports energies",
        choices=(
            Choice(
                AMPLITUDE, "Amplitude", "In proportion to the amplitude of the echoes (LD2410)", 0
            ),
            Choice(DECIBELS, "Decibels", "One point for each decibel (LD2410S, LD2420)", 1),
        ),
        source=MEASURED,
        short="Energies in",
    )
    moving_thresholds: str = parameter(
        "50 50 40 30 20 15 15 15 15",
        "Moving thresholds",
        "The energy (0 to 100, no unit) above which movement is detected, for each gate from "
        "gate 0. Gates without a number have the last one. 100: never. 0: the gate is off. "
        "Datasheets: motion sensitivity",
        source=LD2410_SERIAL,
        short="Moving above",
    )
    still_thresholds: str = parameter(
        "0 0 40 40 30 30 20 20 20",
        "Still thresholds",
        "The same for who only breathes. Datasheets: static sensitivity",
        source=LD2410_SERIAL,
        short="Still above",
    )
    moving_floors: str = parameter(
        "0",
        "Moving floors",
        "The energy (0 to 100, no unit) of movement in an empty room, for each gate from gate 0. "
        "It adds to what is there. Gates without a number have the last one",
        source=MEASURED,
        short="Moving floors",
    )
    still_floors: str = parameter(
        "0",
        "Still floors",
        "The same for the energy of who only breathes",
        source=MEASURED,
        short="Still floors",
    )
    movement_starts: bool = parameter(
        False,
        "Movement starts presence",
        "Only movement switches presence on, and breathing keeps it. The first update counts both",
        source=MEASURED,
        short="Movement first",
    )
    integration_time: float = parameter(
        0.1,
        "Integration time",
        "Time T over which the radar measures a speed. The slower than λ/2T anything moves, the "
        "less it counts as moving",
        unit="s",
        minimum=0.001,
        maximum=10.0,
        short="Integration",
    )
    still_time: float = parameter(
        2.0,
        "Still time",
        "Time constant T of the mean that gives the still energies. What moves faster than λ/2T "
        "counts, such as a breathing chest",
        unit="s",
        minimum=0.01,
        source=MEASURED,
    )
    tail_share: float = parameter(
        0.02,
        "Tail share",
        "Amplitude of the echoes by way of the room, in a gate length behind a body, as a share of "
        "its own echo",
        maximum=2.0,
        source="a room 0.02, a flat 0.3 to 0.5: docs/presence_radar.md",
        short="Tail",
    )
    tail_length: float = parameter(
        1.5,
        "Tail length",
        "Way behind a body over which the amplitude of these echoes falls to 1/e",
        unit="m",
        minimum=0.01,
        source="five LD2410C in a flat, 1.25 to 1.7 m: docs/presence_radar.md",
    )
    max_targets: int = parameter(
        0,
        "Targets",
        "Most targets with a position and a speed. 0: the module reports none",
        maximum=100,
    )
    angle_resolution: float = parameter(
        math.radians(20),
        "Angle resolution",
        "Bodies in the same gate that are closer together than this angle are one target",
        unit="rad",
        positive=True,
        maximum=math.pi,
        short="Angle",
    )
    hold_time: float = parameter(
        5.0,
        "Hold time",
        "How long presence stays on after the last detection. Datasheets: unmanned duration",
        unit="s",
        source=LD2410_SERIAL,
    )
    report_step: float = parameter(
        0.25,
        "Report step",
        "Least change of the distance that the event log records",
        unit="m",
        short="Report by",
    )
    energy_noise: float = parameter(
        0.0,
        "Energy noise",
        "Standard deviation of the energy (0 to 100, no unit) of each gate, beside that of floors",
        maximum=100.0,
    )
    floor_noise: float = parameter(
        0.2,
        "Floor noise",
        "Standard deviation of the floors from update to update, as a share of each",
        maximum=2.0,
        source=MEASURED,
    )
    fading: bool = parameter(
        True,
        "Fading",
        "Echoes of many scatterers add up to another amplitude at each update, with the Rayleigh "
        "distribution. Off: always the mean",
    )
    range_noise: float = parameter(0.0, "Range noise", "Standard deviation of distances", unit="m")
    angle_noise: float = parameter(
        0.0, "Angle noise", "Standard deviation of the targets' directions", unit="rad"
    )

    @property
    def wavelength(self) -> float:
        """The wavelength in m."""
        return LIGHT_SPEED / (self.frequency * 1e9)

    @property
    def moving_corner(self) -> float:
        """The radial speed in m/s of which half the amplitude counts: λ/2T of integration_time."""
        return self.wavelength / (2.0 * self.integration_time)

    @property
    def still_corner(self) -> float:
        """The same speed for the still energies: λ/2T of still_time."""
        return self.wavelength / (2.0 * self.still_time)

    @property
    def gates(self) -> int:
        """The number of gates from gate 0; the middle of the last can be beyond range_max."""
        return math.ceil(self.range_max / self.gate_length - 1e-6) + 1

    @property
    def bin_length(self) -> float:
        """The true distance in m between the middles of gates."""
        return self.gate_length / self.range_scale

    @property
    def reach(self) -> float:
        """The true distance in m beyond which nothing is detected."""
        return (self.range_max + self.gate_length / 2.0) / self.range_scale

    def by_gate(self, name: str) -> Array:
        """Return a number (gates,) for each gate from the text in the parameter `name`.

        Raise ValueError if the text has no numbers from 0 to 100.
        """
        numbers = [float(word) for word in getattr(self, name).replace(",", " ").split()]
        if not numbers or not all(0.0 <= number <= NEVER for number in numbers):
            raise ValueError(name)
        last = [numbers[-1]] * max(0, self.gates - len(numbers))
        return np.array([*numbers, *last][: self.gates])

    def contradictions(self, lengths: Lengths = METRES) -> list[str]:
        """Return contradictions between ranges, texts that are no thresholds, and too many rays."""
        problems = self.must_be_smaller("range_min", "range_max", lengths)
        if problems:
            return problems
        if self.range_max / self.gate_length > MAX_GATES:
            least = lengths.typed(self.range_max / MAX_GATES)
            return [f"gate_length gives more than {MAX_GATES} gates: take at least {least}"]
        if self.rays_across * self.rays_up > MAX_RAYS:
            return [
                f"{self.rays_across} times {self.rays_up} rays are more than {MAX_RAYS}: "
                "take fewer rays"
            ]
        for name in (*THRESHOLDS, *FLOORS):
            try:
                self.by_gate(name)
            except ValueError:
                text = getattr(self, name)
                problems.append(f"{name} is '{text}': write numbers from 0 to 100, such as 40 30")
        return problems

    def unreachable(self, lengths: Lengths = METRES) -> list[Advice]:
        """Return advice if presence can never go on, or never off."""
        moving, still = map(self.by_gate, THRESHOLDS)
        starts = moving if self.movement_starts else np.concatenate([moving, still])
        if ((starts == NEVER) | (starts == OFF)).all():
            what = "moving thresholds" if self.movement_starts else "thresholds"
            return [
                Advice(
                    f"All {what} are 100, which no energy exceeds, or 0, which switches gates "
                    "off: presence never goes on",
                    "Lower the thresholds of the gates to use",
                )
            ]
        for name, floors in zip(THRESHOLDS, FLOORS, strict=True):
            needed, floor = self.by_gate(name), self.by_gate(floors)
            above = np.flatnonzero((floor > needed) & (needed > OFF))
            if len(above):
                return [
                    Advice(
                        f"The floor of gate {above[0]} is above its threshold in {name}: presence "
                        "never goes off",
                        "Raise the threshold",
                    )
                ]
        return []
