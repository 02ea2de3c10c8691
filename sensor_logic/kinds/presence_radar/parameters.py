# SPDX-License-Identifier: GPL-3.0-or-later
"""The parameters of presence radars."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...model import Array
from ...parameters import Parameters, parameter
from ...radio.substances import LIGHT_SPEED
from ...wording import METRES, Advice, Lengths

LD2410 = "Hi-Link, HLK-LD2410 user manual V1.02"
LD2410_SERIAL = "Hi-Link, LD2410 serial communication protocol: factory settings"
MAX_RAYS = 100_000
MAX_GATES = 1_000
# m/s. What seems faster has jumped, as a replaced instance does, and does not count as moving.
FASTEST = 10.0
# A threshold that no energy exceeds.
NEVER = 100.0
# rad, m. Much narrower fields of view and longer ranges give powers that are no longer numbers.
# NARROWEST is 1°, in the digits of single precision that Blender keeps.
NARROWEST, FARTHEST = 0.01745329, 100.0


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
        "Angle between the directions in which the antenna has half of its gain. Nothing outside "
        "is detected. Datasheets: detection angle, azimuth",
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
        "End of the last gate. Anything farther is not detected. Datasheets: farthest gate",
        unit="m",
        maximum=FARTHEST,
        positive=True,
        source=LD2410,
    )
    gate_length: float = parameter(
        0.75,
        "Gate length",
        "Length of a distance gate: c/2B, with B the bandwidth of the sweep. Bodies closer "
        "together than this are one target. Datasheets: distance resolution",
        unit="m",
        minimum=0.01,
        source=LD2410,
        short="Gate",
    )
    moving_range: float = parameter(
        6.0,
        "Range of moving",
        "A walking person straight ahead is just detected at this distance",
        unit="m",
        minimum=0.1,
        maximum=FARTHEST,
        source=LD2410,
        short="Moving",
    )
    still_range: float = parameter(
        5.0,
        "Range of still",
        "A person straight ahead who only breathes is just detected at this distance",
        unit="m",
        minimum=0.1,
        maximum=FARTHEST,
        source=LD2410,
        short="Still",
    )
    moving_thresholds: str = parameter(
        "50 40 30 20 15 15 15 15",
        "Moving thresholds",
        "The energy (0 to 100) above which movement is detected, for each gate from the nearest. "
        "Gates without a number have the last one. 100: never. Datasheets: motion sensitivity",
        source=LD2410_SERIAL,
        short="Moving above",
    )
    still_thresholds: str = parameter(
        "0 40 40 30 30 20 20 20",
        "Still thresholds",
        "The same for breathing. Datasheets: static sensitivity",
        source=LD2410_SERIAL,
        short="Still above",
    )
    integration_time: float = parameter(
        0.1,
        "Integration time",
        "Time T over which the radar measures a speed. Anything slower than λ/2T does not count as "
        "moving",
        unit="s",
        minimum=0.001,
        maximum=10.0,
        short="Integration",
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
        "Standard deviation of the energy of each gate, on its scale to 100",
        maximum=100.0,
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
    def minimum_speed(self) -> float:
        """The least radial speed in m/s that counts as moving: λ/2T."""
        return self.wavelength / (2.0 * self.integration_time)

    @property
    def gates(self) -> int:
        """The number of distance gates up to range_max; the last one can end beyond it."""
        return max(1, math.ceil(self.range_max / self.gate_length - 1e-6))

    def thresholds(self, name: str) -> Array:
        """Return the thresholds of all gates from the text in the parameter `name`.

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
        for name in ("moving_thresholds", "still_thresholds"):
            try:
                self.thresholds(name)
            except ValueError:
                text = getattr(self, name)
                problems.append(f"{name} is '{text}': write numbers from 0 to 100, such as 40 30")
        return problems

    def unreachable(self, lengths: Lengths = METRES) -> list[Advice]:
        """Return advice if no gate can detect anything, or if nothing counts as moving."""
        if self.minimum_speed > FASTEST:
            return [
                Advice(
                    f"Only speeds above {self.minimum_speed:.3g} m/s would count as moving, but "
                    f"above {FASTEST:g} m/s they are jumps: nothing counts as moving",
                    "Increase the integration time or the frequency",
                )
            ]
        both = [self.thresholds(name) for name in ("moving_thresholds", "still_thresholds")]
        if any((one < NEVER).any() for one in both):
            return []
        return [
            Advice(
                "All thresholds are 100, which no energy exceeds: presence never goes on",
                "Lower the thresholds of the gates to use",
            )
        ]
