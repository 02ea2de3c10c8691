# SPDX-License-Identifier: GPL-3.0-or-later
"""Lenses as tables of zones, built from lenslets and the elements behind them.

A lenslet whose middle lies in direction a, a focal length from the elements, projects the point e
of the element plane (in focal lengths, facing −Z) into direction a − e. Hardly any maker publishes
a zone table: each lens here says what is published and what is assumed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ....kind import Preset
from .zones import Zone, Zones


@dataclass(frozen=True)
class Element:
    """An element's middle, width and height in focal lengths, along X and Y; and its polarity."""

    x: float
    y: float
    width: float
    height: float
    polarity: int


@dataclass(frozen=True)
class Lens:
    """A lens with its zones. `detection_distance` in m; `source`: the published facts; `assumed`:
    the others. Files store `number`: it is never reused."""

    identifier: str
    number: int
    label: str
    detection_distance: float
    zones: Zones
    source: str
    assumed: str


def dual(focal: float) -> tuple[Element, ...]:
    """Two elements of 1 × 2 mm side by side, 2 mm apart, behind a focal length in mm."""
    return tuple(Element(s * 1.0 / focal, 0.0, 1.0 / focal, 2.0 / focal, s) for s in (1, -1))


def quad(focal: float, crossed: bool = False) -> tuple[Element, ...]:
    """Four elements of 0.6 × 0.6 mm, 0.4 mm apart; left and right differ in polarity, or, where
    `crossed`, each from both its neighbours."""
    return tuple(
        Element(x * 0.5 / focal, y * 0.5 / focal, 0.6 / focal, 0.6 / focal, x * y if crossed else x)
        for x in (1, -1)
        for y in (1, -1)
    )


def seen_through(
    azimuth: float, elevation: float, elements: tuple[Element, ...], gain: float = 1.0
) -> Zones:
    """The zones of one lenslet whose middle is at these angles (radians)."""
    lenslet = Zone(azimuth, elevation, 0.0, 0.0, 1)
    zones = []
    for element in elements:
        there = lenslet.axis - np.array([element.x, element.y, 0.0])
        there /= np.linalg.norm(there)
        # The flat elements are foreshortened.
        zone = Zone(
            math.atan2(-there[0], -there[2]),
            math.asin(there[1]),
            2.0 * math.atan(element.width / 2 * math.cos(azimuth)),
            2.0 * math.atan(element.height / 2 * math.cos(elevation)),
            element.polarity,
            gain,
        )
        zones.append(zone)
    return tuple(zones)


def tier(
    elevation: float,
    count: int,
    spacing: float,
    elements: tuple[Element, ...],
    gain: float = 1.0,
) -> Zones:
    """The zones of `count` lenslets in a row at `elevation`, `spacing` apart (degrees)."""
    azimuths = [(i - (count - 1) / 2) * spacing for i in range(count)]
    parts = [
        seen_through(math.radians(azimuth), math.radians(elevation), elements, gain)
        for azimuth in azimuths
    ]
    return sum(parts, ())


def ring(off_axis: float, count: int, elements: tuple[Element, ...], stretch: float = 1.0) -> Zones:
    """The zones of `count` lenslets in a ring around the sensor's axis, `off_axis` degrees from it;
    the ring's width is `stretch` times its height."""
    zones: Zones = ()
    for i in range(count):
        roll = 2 * math.pi * i / count
        side, up = math.cos(roll) * stretch, math.sin(roll)
        away = math.radians(off_axis) * math.hypot(side, up)
        roll = math.atan2(up, side)
        x, y = math.sin(away) * math.cos(roll), math.sin(away) * math.sin(roll)
        zones += seen_through(math.atan2(-x, math.cos(away)), math.asin(y), elements)
    return zones


ASSUMED_ROWS = "number and places of the lenslets"
PAPIRS_ELEMENTS = "Panasonic PaPIRs catalogue 2016: four elements of 0.6 × 0.6 mm, 0.4 mm apart"

# So that the standard target just triggers at 6 m and 3 m where it does at 12 m in the first step.
GAIN_6M, GAIN_3M = 0.428, 0.269

LENSES: dict[str, Lens] = {
    lens.identifier: lens
    for lens in (
        Lens(
            "THREE_TIERS",
            0,
            "Three tiers",
            5.0,
            tier(0, 9, 12, dual(25)) + tier(-22, 7, 14, dual(25)) + tier(-45, 5, 18, dual(25)),
            "no part: a usual wall lens of 9, 7 and 5 lenslets of 25 mm, elements of 1 × 2 mm",
            "all of it",
        ),
        Lens(
            "HC_SR501",
            1,
            "HC-SR501 dome",
            7.0,
            ring(0, 1, dual(11.5)) + ring(25, 6, dual(11.5)) + ring(47, 12, dual(11.5)),
            "module data sheet: 7 m, below 120°, dome of 23 mm, sensor LHi 778; 110° cone at "
            "radiolocman.com",
            f"{ASSUMED_ROWS}; focal length half of the dome's diameter; elements of 1 × 2 mm",
        ),
        Lens(
            "EKMC1601111",
            2,
            "Panasonic EKMC1601111 (standard)",
            5.0,
            sum((tier(e, 4, 26.0, quad(4.8)) for e in (32.6, 10.9, -10.9, -32.6)), ()),
            f"Panasonic: 5 m, 94° × 82°. {PAPIRS_ELEMENTS}",
            f"{ASSUMED_ROWS} (4 × 4), focal length (so that the zones fill these angles), "
            "polarities",
        ),
        Lens(
            "EKMC1603111",
            3,
            "Panasonic EKMC1603111 (long distance)",
            12.0,
            ring(0, 1, quad(10))
            + ring(15, 6, quad(10), 1.11)
            + ring(28, 8, quad(10), 1.11)
            + ring(42.7, 8, quad(10), 1.11),
            f"Panasonic: 12 m, 102° × 92°. {PAPIRS_ELEMENTS}",
            f"{ASSUMED_ROWS}, focal length 10 mm, polarities",
        ),
        Lens(
            "EKMC1604111",
            4,
            "Panasonic EKMC1604111 (wall)",
            12.0,
            tier(1.9, 9, 12.4, quad(10))
            + tier(-20, 5, 22, quad(10), GAIN_6M)
            + tier(-45.7, 3, 36, quad(10), GAIN_3M),
            "Panasonic data sheet: first, second and third step 12, 6 and 3 m, 105° wide, from "
            f"6.6° above to 49° below, 68 zones. {PAPIRS_ELEMENTS}",
            "9, 5 and 3 lenslets of 10 mm; gains so that each step has its distance; polarities",
        ),
        Lens(
            "CEILING",
            5,
            "Ceiling, 360°",
            4.65,
            ring(0, 1, quad(5, True))
            + ring(20, 6, quad(5, True))
            + ring(38, 12, quad(5, True))
            + ring(54, 16, quad(5, True)),
            "Leviton ODC0S instructions: 360°, 530 square feet: from a ceiling of 2.44 m the edge "
            "is 58° off the axis and 4.65 m away",
            f"{ASSUMED_ROWS}; elements as Panasonic's, crossed, focal length 5 mm; the ceiling's "
            "height",
        ),
        Lens(
            "PET_IMMUNE",
            6,
            "Pet-immune (pet alley)",
            8.0,
            tier(0, 9, 12, dual(25)) + tier(-8.7, 9, 12, dual(25)),
            "ERA E2 sensor manual: 8 m, mounted 2 to 2.2 m up, ignores pets below 25 kg",
            "the lens: two tiers whose lower edge, −11.2°, is 0.5 m above the floor at 8 m",
        ),
        Lens(
            "CURTAIN",
            7,
            "Curtain",
            15.0,
            sum((tier(e, 1, 0, dual(38)) for e in range(0, -80, -10)), ()),
            "Ajax: MotionProtect Curtain 15 m; horizontal angle 4.5° of its sister DualCurtain",
            "8 lenslets below each other, focal length so that both elements see 4.5°",
        ),
        Lens(
            "SPACETI_WALL",
            8,
            "Spaceti room occupancy (wall)",
            9.6,
            tier(8.03, 9, 12, dual(25))
            + tier(-13, 7, 14, dual(25))
            + tier(-34, 7, 14, dual(25))
            + tier(-54.5, 5, 18, dual(25)),
            "Spaceti help page: 9.6 m; aims 23.0° and ends 56.3° below the horizon",
            f"{ASSUMED_ROWS}; elements of 1 × 2 mm, focal length 25 mm",
        ),
    )
}


def _preset(
    lens: str, label: str, hold: float, block: float, warm_up: float, timing: str
) -> Preset:
    known = LENSES[lens]
    values = {
        "model": "PYROELECTRIC",
        "lens": lens,
        "lens_table": None,
        "range_max": known.detection_distance,
        "hold_time": hold,
        "blocking_time": block,
        "warm_up_time": warm_up,
        "retrigger": True,
        "blanking_time": 0.0,
        "message_delay": 0.0,
    }
    source = f"{known.source}. {timing}. Assumed: {known.assumed}"
    return Preset(lens, label, values, source)


NO_TIMES = "Its times are not known: none is set"
LENS_PRESETS: tuple[Preset, ...] = (
    _preset(
        "HC_SR501",
        "HC-SR501",
        0.3,
        2.5,
        60.0,
        "Delay from 0.3 s, block time 2.5 s, 1 minute of initialization",
    ),
    _preset("EKMC1601111", "Panasonic EKMC1601111 (5 m)", 0.0, 0.0, 30.0, "30 s to stabilize"),
    _preset("EKMC1603111", "Panasonic EKMC1603111 (12 m)", 0.0, 0.0, 30.0, "30 s to stabilize"),
    _preset("EKMC1604111", "Panasonic EKMC1604111 (wall)", 0.0, 0.0, 30.0, "30 s to stabilize"),
    _preset("CEILING", "Ceiling, 360°", 0.0, 0.0, 0.0, NO_TIMES),
    _preset("PET_IMMUNE", "Pet-immune", 0.0, 0.0, 0.0, NO_TIMES),
    _preset("CURTAIN", "Curtain", 0.0, 0.0, 0.0, NO_TIMES),
    _preset("SPACETI_WALL", "Spaceti room occupancy (wall)", 0.0, 0.0, 0.0, NO_TIMES),
)
