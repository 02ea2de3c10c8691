# SPDX-License-Identifier: GPL-3.0-or-later
"""The detection zones of a lens: as a table that users can write, and as rays."""

from __future__ import annotations

import csv
import io
import math
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....error import InputError
from ....model import Array

COLUMNS = ("azimuth", "elevation", "width", "height", "polarity", "gain")
POLARITIES = {"+": 1, "+1": 1, "1": 1, "-": -1, "−": -1, "-1": -1}
WIDEST = math.radians(90.0)
MAX_ZONES = 2000
# Rays in a zone form a lattice in which no two share a column or a row.
GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0


@dataclass(frozen=True)
class Zone:
    """The field of view of one element behind one lenslet: a rectangle of angles (radians).

    `azimuth` of its middle is counter-clockwise seen from +Y, 0 along −Z; `elevation` is above
    the sensor's horizon; `polarity`, +1 or −1, is the element's; `gain` is the lenslet's area
    relative to the others.
    """

    azimuth: float
    elevation: float
    width: float
    height: float
    polarity: int
    gain: float = 1.0

    @property
    def axis(self) -> Array:
        """(3,) unit vector to its middle, in the sensor's frame (looks along −Z, +Y up)."""
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
        """(3,) horizontal unit vector to its right."""
        return np.array([math.cos(self.azimuth), 0.0, -math.sin(self.azimuth)])

    @property
    def solid_angle(self) -> float:
        """Solid angle in sr of a pyramid with these two angles at its apex."""
        return 4.0 * math.asin(math.sin(self.width / 2) * math.sin(self.height / 2))


Zones = tuple[Zone, ...]


class ZoneRays(NamedTuple):
    """Unit `directions` (n, 3) in the sensor's frame; their signed `weights` (n,) in sr; and the
    number of the `zone` (n,) that each belongs to."""

    directions: Array
    weights: Array
    zone: NDArray[np.intp]


# One entry per lens and number of rays; without the cache 3 ms more per update.
@lru_cache(maxsize=64)
def zone_rays(zones: Zones, count: int) -> ZoneRays:
    """`count` rays in each zone, spread evenly."""
    i = np.arange(count) + 0.5
    across, along = 2.0 * i / count - 1.0, 2.0 * ((i * GOLDEN) % 1.0) - 1.0
    directions = np.empty((len(zones), count, 3))
    weights = np.empty((len(zones), count))
    for row, zone in enumerate(zones):
        x = across * math.tan(zone.width / 2)
        y = along * math.tan(zone.height / 2)
        up = np.cross(zone.right, zone.axis)
        there = zone.axis + np.outer(x, zone.right) + np.outer(y, up)
        directions[row] = there / np.linalg.norm(there, axis=1)[:, None]
        weights[row] = zone.polarity * zone.gain * zone.solid_angle / count
    flat = directions.reshape(-1, 3)
    made = ZoneRays(flat, weights.reshape(-1), np.repeat(np.arange(len(zones)), count))
    for array in made:
        array.flags.writeable = False
    return made


# One entry per text; without the cache 0.6 ms more per update.
@lru_cache(maxsize=64)
def read_table(text: str) -> Zones:
    """The zones of a table: each row has azimuth, elevation, width, height (degrees), polarity
    (+ or -) and, if it is not 1, gain. Empty rows, a header and text after # are ignored.

    Raises InputError.
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
    """The table that `read_table` reads, in degrees."""
    out = io.StringIO()
    out.write(",".join(COLUMNS) + "\n")
    for zone in zones:
        angles = (zone.azimuth, zone.elevation, zone.width, zone.height)
        cells = [f"{math.degrees(angle):.3f}".replace("-0.000", "0.000") for angle in angles]
        out.write(",".join([*cells, "+" if zone.polarity > 0 else "-", f"{zone.gain:g}"]) + "\n")
    return out.getvalue()
