# SPDX-License-Identifier: GPL-3.0-or-later
"""Lenses as tables of zones, computed from their lenslets and the elements behind them.

The elements are in a plane at the focal length of the lenslets, and face −Z. A lenslet in direction
a projects a point e of this plane (in focal lengths) into the direction a − e. Hardly any maker
publishes a zone table. So each lens here states what is published and what is assumed.
"""

from __future__ import annotations

import csv
import io
import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...geometry.pixels import blurred_quantiles
from ...kind import Preset, parts_with
from ...logs.error import InputError
from ...model import Array

# The detection zones of a lens, as a table that users can write, and as rays.

COLUMNS = ("azimuth", "elevation", "width", "height", "polarity", "gain")
POLARITIES = {"+": 1, "+1": 1, "1": 1, "-": -1, "−": -1, "-1": -1}
WIDEST = math.radians(90.0)
MAX_ZONES = 2000
# The rays in a zone form a lattice in which no two rays share a column or a row.
GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0


@dataclass(frozen=True)
class Zone:
    """The field of view of one element through one lenslet: a rectangle of angles, in radians.

    Attributes
    ----------
    azimuth
        The azimuth of the centre, counter-clockwise seen from +Y; 0 along −Z.
    elevation
        The elevation of the centre above the sensor's horizon.
    width, height
        The angles between the left and right edge, and the lower and upper edge.
    polarity
        The polarity of the element, +1 or −1.
    gain
        The area of the lenslet, relative to the areas of the other lenslets.
    """

    azimuth: float
    elevation: float
    width: float
    height: float
    polarity: int
    gain: float = 1.0

    @property
    def axis(self) -> Array:
        """The unit vector (3,) to the centre in the sensor's frame (looks along −Z, +Y up)."""
        level = math.cos(self.elevation)
        return np.array(
            [
                -math.sin(self.azimuth) * level,
                math.sin(self.elevation),
                -math.cos(self.azimuth) * level,
            ]
        )

    @property
    def right(self) -> Array:
        """The horizontal unit vector (3,) to the right of the axis."""
        return np.array([math.cos(self.azimuth), 0.0, -math.sin(self.azimuth)])

    @property
    def solid_angle(self) -> float:
        """The solid angle of the zone in sr, as of a pyramid with these two angles at its apex."""
        return 4.0 * math.asin(math.sin(self.width / 2) * math.sin(self.height / 2))


Zones = tuple[Zone, ...]


class ZoneRays(NamedTuple):
    """The rays of all zones of a lens.

    Attributes
    ----------
    directions
        Unit vectors (n, 3) in the sensor's frame.
    weights
        The solid angle (n,) in sr around each ray, times the polarity and the gain of its zone.
    zone
        The index (n,) of each ray's zone.
    """

    directions: Array
    weights: Array
    zone: NDArray[np.intp]


# Keyed by lens and number of rays: without the cache, each update takes 3 ms more.
@lru_cache(maxsize=64)
def zone_rays(zones: Zones, count: int, blur: float = 0.0) -> ZoneRays:
    """Return `count` rays in each zone.

    Each ray stands for the same share of the zone's sensitivity. With a `blur` of 0 the rays are
    spread evenly between the zone's edges. Otherwise the sensitivity is that of the sharp zone,
    blurred by a Gaussian whose standard deviation is `blur` (rad).
    """
    i = np.arange(count) + 0.5
    across, along = np.asarray([i / count, (i * GOLDEN) % 1.0], np.float64)
    sigma = math.tan(blur)
    directions = np.empty((len(zones), count, 3))
    weights = np.empty((len(zones), count))
    for row, zone in enumerate(zones):
        wide, high = (2.0 * math.tan(angle / 2) for angle in (zone.width, zone.height))
        x = wide * blurred_quantiles(across, sigma / wide)
        y = high * blurred_quantiles(along, sigma / high)
        up = np.cross(zone.right, zone.axis)
        ahead = zone.axis + np.outer(x, zone.right) + np.outer(y, up)
        directions[row] = ahead / np.linalg.norm(ahead, axis=1)[:, None]
        weights[row] = zone.polarity * zone.gain * zone.solid_angle / count
    flat = directions.reshape(-1, 3)
    made = ZoneRays(flat, weights.reshape(-1), np.repeat(np.arange(len(zones)), count))
    for array in made:
        array.flags.writeable = False
    return made


# Keyed by the text: without the cache, each update takes 0.6 ms more.
@lru_cache(maxsize=64)
def read_table(text: str) -> Zones:
    """Return the zones of a lens table. Raise InputError if the text is invalid.

    Each row has azimuth, elevation, width and height in degrees, the polarity (+ or -) and
    optionally a gain other than 1. Empty rows, a header and text after # are ignored.
    """
    zones: list[Zone] = []
    for number, line in enumerate(text.splitlines(), 1):
        cells = next(csv.reader([line.partition("#")[0]]), [])
        cells = [cell.strip() for cell in cells]
        if not any(cells) or (not zones and cells[0].lower() == COLUMNS[0]):
            continue
        zones.append(_read_row(number, cells))
    if not zones:
        raise InputError(f"the lens table is empty: give a row for each zone: {', '.join(COLUMNS)}")
    if len(zones) > MAX_ZONES:
        raise InputError(f"the lens table has {len(zones)} zones: at most {MAX_ZONES} are possible")
    return tuple(zones)


def _read_row(number: int, cells: list[str]) -> Zone:
    here = f"row {number} of the lens table"
    if len(cells) == len(COLUMNS) - 1:
        cells = [*cells, "1"]
    if len(cells) != len(COLUMNS):
        raise InputError(f"{here} has {len(cells)} columns: it must have {', '.join(COLUMNS)}")
    polarity = POLARITIES.get(cells[4])
    if polarity is None:
        raise InputError(f"{here}: polarity is '{cells[4]}': it must be + or -")
    numbers = {}
    for name, cell in zip(COLUMNS, cells, strict=True):
        if name != "polarity":
            try:
                numbers[name] = float(cell)
            except ValueError:
                numbers[name] = math.nan
            if not math.isfinite(numbers[name]):
                raise InputError(f"{here}: {name} is '{cell}': it must be a number")
    azimuth, elevation, width, height, gain = numbers.values()
    if abs(azimuth) > 180.0 or abs(elevation) > 90.0:
        name, value, most = (
            ("azimuth", azimuth, 180) if abs(azimuth) > 180.0 else ("elevation", elevation, 90)
        )
        raise InputError(f"{here}: {name} is {value:g}°: it must be from −{most}° to {most}°")
    for name, value in (("width", width), ("height", height)):
        if not 0.0 < math.radians(value) <= WIDEST:
            raise InputError(f"{here}: {name} is {value:g}°: it must be above 0° and at most 90°")
    if gain <= 0.0:
        raise InputError(f"{here}: gain is {gain:g}: it must be above 0")
    return Zone(
        math.radians(azimuth),
        math.radians(elevation),
        math.radians(width),
        math.radians(height),
        polarity,
        gain,
    )


def write_table(zones: Zones) -> str:
    """Return the zones as a lens table that `read_table` can read."""
    out = io.StringIO()
    out.write(",".join(COLUMNS) + "\n")
    for zone in zones:
        angles = (zone.azimuth, zone.elevation, zone.width, zone.height)
        cells = [f"{math.degrees(angle):.3f}".replace("-0.000", "0.000") for angle in angles]
        out.write(",".join([*cells, "+" if zone.polarity > 0 else "-", f"{zone.gain:g}"]) + "\n")
    return out.getvalue()


@dataclass(frozen=True)
class Element:
    """A pyroelectric element behind a lens; lengths along X and Y are in focal lengths."""

    x: float
    y: float
    width: float
    height: float
    polarity: int


@dataclass(frozen=True)
class Lens:
    """A lens with its zones.

    Attributes
    ----------
    number
        The number that blend files store for the lens; it is never reused.
    detection_distance
        The distance in m at which the detector just detects its standard target: that of Panasonic,
        or a person for the HC-SR501.
    source
        The publication, and the values that it gives.
    assumed
        The values that no publication gives.
    """

    identifier: str
    number: int
    label: str
    detection_distance: float
    zones: Zones
    source: str
    assumed: str


def dual(focal: float) -> tuple[Element, ...]:
    """Return two elements of 1 × 2 mm, centres 2 mm apart, for the focal length `focal` in mm."""
    return tuple(Element(s * 1.0 / focal, 0.0, 1.0 / focal, 2.0 / focal, s) for s in (1, -1))


def quad(focal: float, crossed: bool = False) -> tuple[Element, ...]:
    """Return four elements of 0.6 × 0.6 mm, 0.4 mm apart, for the focal length `focal` in mm.

    The left and the right elements differ in polarity. If `crossed` is True, the upper and the
    lower elements of each side also differ.
    """
    return tuple(
        Element(x * 0.5 / focal, y * 0.5 / focal, 0.6 / focal, 0.6 / focal, x * y if crossed else x)
        for x in (1, -1)
        for y in (1, -1)
    )


def lenslet_zones(
    azimuth: float, elevation: float, elements: tuple[Element, ...], gain: float = 1.0
) -> Zones:
    """Return the zones of one lenslet, one for each element.

    `azimuth` and `elevation` of the lenslet's centre are in radians.
    """
    lenslet = Zone(azimuth, elevation, 0.0, 0.0, 1)
    zones = []
    for element in elements:
        ahead = lenslet.axis - np.array([element.x, element.y, 0.0])
        ahead /= np.linalg.norm(ahead)
        # Flat elements appear foreshortened from the side.
        zone = Zone(
            math.atan2(-ahead[0], -ahead[2]),
            math.asin(ahead[1]),
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
    """Return the zones of a horizontal row of `count` lenslets.

    The row is at `elevation` degrees. `spacing` is the angle in degrees between neighbours.
    """
    azimuths = [(i - (count - 1) / 2) * spacing for i in range(count)]
    parts = [
        lenslet_zones(math.radians(azimuth), math.radians(elevation), elements, gain)
        for azimuth in azimuths
    ]
    return sum(parts, ())


def ring(off_axis: float, count: int, elements: tuple[Element, ...], stretch: float = 1.0) -> Zones:
    """Return the zones of a ring of `count` lenslets, `off_axis` degrees from the sensor's axis.

    With a `stretch` other than 1, the ring is an ellipse, `stretch` times as wide as high.
    """
    zones: Zones = ()
    for i in range(count):
        roll = 2 * math.pi * i / count
        side, up = math.cos(roll) * stretch, math.sin(roll)
        away = math.radians(off_axis) * math.hypot(side, up)
        roll = math.atan2(up, side)
        x, y = math.sin(away) * math.cos(roll), math.sin(away) * math.sin(roll)
        zones += lenslet_zones(math.atan2(-x, math.cos(away)), math.asin(y), elements)
    return zones


ASSUMED_ROWS = "number and places of the lenslets"
PAPIRS_ELEMENTS = "Panasonic PaPIRs catalogue 2016: four elements of 0.6 × 0.6 mm, 0.4 mm apart"

# Gains at which the standard target just triggers at 6 m (second step) and 3 m (third step), as it
# does at 12 m in the first step.
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
            "no product: a usual wall lens, rows of 9, 7 and 5 lenslets, focal length 25 mm, "
            "elements of 1 × 2 mm",
            "all of it",
        ),
        Lens(
            "HC_SR501",
            1,
            "HC-SR501 dome",
            5.0,
            ring(0, 1, dual(11.5))
            + ring(25, 6, dual(11.5))
            + ring(47, 12, dual(11.5))
            + ring(66, 16, dual(11.5)),
            "module data sheet: 7 m, dome of 23 mm, sensor LHi 778. Measured: it sees a person who "
            "crosses at 5 m and not at 6 m, and trunks at 45° to 75° beside its axis at 1 m",
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


# Every preset of a part sets these parameters, so that none keeps values of an earlier preset.
pyroelectric_part = parts_with(
    model="PYROELECTRIC",
    lens_table=None,
    zone_rays=12,
    lens_blur=0.0,
    target="PLATE",
    target_contrast=4.0,
    low_cut=0.3,
    high_cut=8.0,
    hold_time=0.0,
    blocking_time=0.0,
    warm_up_time=0.0,
    retrigger=True,
    blanking_time=0.0,
    message_delay=0.0,
)
SHARP = "sharp edges of the zones, band from 0.3 to 8 Hz"
PLATE = "the distance is that of a plate of 0.7 × 0.25 m, 4 K warmer"


def _preset(identifier: str, label: str, timing: str, **values: Any) -> Preset:
    """Return the preset of the lens with the same identifier; `timing` is the source of times."""
    lens = LENSES[identifier]
    source = f"{lens.source}. {timing}. Assumed: {lens.assumed}; {SHARP}; {PLATE}"
    distance = lens.detection_distance
    return pyroelectric_part(
        identifier, label, source, lens=identifier, range_max=distance, **values
    )


def _hc_sr501(identifier: str, label: str, distance: float, trimmer: str) -> Preset:
    """Return a preset of the HC-SR501 that just detects a walking person at `distance` (m)."""
    lens = LENSES["HC_SR501"]
    source = (
        f"{lens.source}. Distance: measured, {trimmer}. Pulse of 3.46 s, the shortest: measured. "
        "Block time 2.5 s, 1 minute of initialization: module data sheet. "
        f"Assumed: {lens.assumed}; blur of 1°; the person is 1.7 × 0.4 m and 3 K warmer; band from "
        "1.6 to 16 Hz (10 kΩ with 10 µF, 1 MΩ with 10 nF, as usual with the BISS0001)"
    )
    return pyroelectric_part(
        identifier,
        label,
        source,
        lens="HC_SR501",
        range_max=distance,
        zone_rays=24,
        lens_blur=math.radians(1.0),
        target="PERSON",
        target_contrast=3.0,
        low_cut=1.6,
        high_cut=16.0,
        hold_time=3.46,
        blocking_time=2.5,
        warm_up_time=60.0,
    )


NO_TIMES = "Its times are not known: none is set"
STABLE = "30 s to stabilize"
LENS_PRESETS: tuple[Preset, ...] = (
    _hc_sr501("HC_SR501", "HC-SR501", 5.0, "trimmer in the middle"),
    _hc_sr501("HC_SR501_MAX", "HC-SR501, trimmer at its end", 7.0, "trimmer at its end"),
    _preset("EKMC1601111", "Panasonic EKMC1601111 (5 m)", STABLE, warm_up_time=30.0),
    _preset("EKMC1603111", "Panasonic EKMC1603111 (12 m)", STABLE, warm_up_time=30.0),
    _preset("EKMC1604111", "Panasonic EKMC1604111 (wall)", STABLE, warm_up_time=30.0),
    _preset("CEILING", "Ceiling, 360°", NO_TIMES),
    _preset("PET_IMMUNE", "Pet-immune", NO_TIMES),
    _preset("CURTAIN", "Curtain", NO_TIMES),
    _preset("SPACETI_WALL", "Spaceti room occupancy (wall)", NO_TIMES),
)
