# SPDX-License-Identifier: GPL-3.0-or-later
"""The cells of a coverage map, what is noticed in each, and what that makes of rooms."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..model import Array
from .motions import HEADINGS, Motion, Start

# A cell is covered where this share of the directions that a body can take is noticed.
ENOUGH = 0.5
NO_ROOM = "no room"


@dataclass(frozen=True)
class Cells:
    """Squares of `size` m on the floor: middles `at` (n, 3), the `room` each is in (n names), the
    number of its `storey` (n,); how far a body can move (n, 8), from `Motion.lengths`."""

    size: float
    at: Array
    room: tuple[str, ...]
    storey: NDArray[np.intp]
    lengths: Array

    def __len__(self) -> int:
        return len(self.at)

    @property
    def rooms(self) -> list[str]:
        """By name; what belongs to none comes last."""
        return sorted(set(self.room), key=lambda name: (name == NO_ROOM, name))

    def of(self, rooms: Iterable[str]) -> Cells:
        """The cells of these rooms."""
        wanted = set(rooms)
        rows = np.array([name in wanted for name in self.room], bool)
        names = tuple(name for name in self.room if name in wanted)
        return Cells(self.size, self.at[rows], names, self.storey[rows], self.lengths[rows])

    def starts(self) -> tuple[Start, NDArray[np.intp], NDArray[np.intp]]:
        """All motions that are possible, and the cell and the direction of each."""
        cell, direction = np.nonzero(self.lengths > 0.0)
        start = Start(self.at[cell], HEADINGS[direction], self.lengths[cell, direction])
        return start, cell, direction


@dataclass(frozen=True)
class RoomCoverage:
    """Cells of a room and how many of them no, one, several detectors cover; m² of a cell."""

    name: str
    cells: int
    dead: int
    once: int
    overlap: int
    area: float

    @property
    def share(self) -> float:
        return 1.0 - self.dead / self.cells


@dataclass(frozen=True)
class CoverageMap:
    """`strength` (detectors, cells, 8): signal against threshold for each direction, 0 where the
    body cannot go."""

    motion: Motion
    cells: Cells
    sensors: tuple[str, ...]
    strength: NDArray[np.float32]

    @property
    def noticed(self) -> Array:
        """(detectors, cells): share of the possible directions that the detector notices."""
        possible = np.maximum((self.cells.lengths > 0.0).sum(axis=1), 1)
        share: Array = (self.strength > 1.0).sum(axis=2) / possible
        return share

    @property
    def covered(self) -> NDArray[np.bool_]:
        """(detectors, cells)."""
        return covered_by(self.noticed)

    @property
    def count(self) -> NDArray[np.intp]:
        """(cells,): how many detectors cover each."""
        number: NDArray[np.intp] = self.covered.sum(axis=0)
        return number

    @property
    def best(self) -> Array:
        """(cells,): share of directions that at least one detector notices."""
        possible = np.maximum((self.cells.lengths > 0.0).sum(axis=1), 1)
        share: Array = (self.strength > 1.0).any(axis=0).sum(axis=1) / possible
        return share

    @property
    def margin(self) -> Array:
        """(cells,): the signal against the threshold, of the best detector, in the median of the
        possible directions: above 1 is noticed."""
        best = self.strength.max(axis=0, initial=0.0).astype(np.float64)
        best[self.cells.lengths <= 0.0] = np.nan
        median: Array = np.nanmedian(best, axis=1) if len(best) else np.empty(0)
        return median

    def rooms(self) -> list[RoomCoverage]:
        count, names = self.count, np.array(self.cells.room, object)
        return [self._room(name, count[names == name]) for name in self.cells.rooms]

    def total(self) -> RoomCoverage:
        return self._room("all", self.count)

    def _room(self, name: str, count: NDArray[np.intp]) -> RoomCoverage:
        dead, once = int((count == 0).sum()), int((count == 1).sum())
        return RoomCoverage(
            name, len(count), dead, once, len(count) - dead - once, self.cells.size**2
        )


def covered_by(noticed: Array) -> NDArray[np.bool_]:
    covered: NDArray[np.bool_] = noticed >= ENOUGH - 1e-9
    return covered


COLUMNS = ("x_m", "y_m", "floor_m", "room", "directions", "covered_by", "noticed", "margin")


def map_csv(coverage: CoverageMap) -> str:
    """A row for each cell: its middle, how many directions are possible, how many detectors cover
    it, the share of directions noticed by any, the margin; then the share of each detector."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow([*COLUMNS, *coverage.sensors])
    cells, noticed = coverage.cells, coverage.noticed
    possible = (cells.lengths > 0.0).sum(axis=1)
    rows = zip(coverage.count.tolist(), coverage.best.tolist(), coverage.margin.tolist(),
               strict=True)  # fmt: skip
    for i, (count, best, margin) in enumerate(rows):
        x, y, z = (f"{v:.4f}".replace("-0.0000", "0.0000") for v in cells.at[i].tolist())
        shares = [f"{v:.4g}" for v in noticed[:, i].tolist()]
        facts = [cells.room[i], int(possible[i]), count, f"{best:.4g}", f"{margin:.4g}"]
        writer.writerow([x, y, z, *facts, *shares])
    return out.getvalue()


def table(coverage: CoverageMap) -> str:
    """What rooms and detectors make of it, as lines to read."""
    rows = [("room", "area m²", "covered", "dead m²", "overlap"), *room_rows(coverage)]
    return columns(rows)


def room_rows(coverage: CoverageMap) -> list[tuple[str, ...]]:
    """Of each room and of all: name, area, and what is covered, dead and covered twice of it."""
    return [
        (
            room.name,
            f"{room.cells * room.area:.1f}",
            f"{100 * room.share:.1f} %",
            f"{room.dead * room.area:.1f}",
            f"{100 * room.overlap / room.cells:.1f} %",
        )
        for room in [*coverage.rooms(), coverage.total()]
    ]


def columns(rows: Sequence[Sequence[str]]) -> str:
    """Aligned: the first column to the left, the others to the right."""
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    lines = [
        "  ".join(
            cell.ljust(width) if i == 0 else cell.rjust(width)
            for i, (cell, width) in enumerate(zip(row, widths, strict=True))
        )
        for row in rows
    ]
    return "\n".join(line.rstrip() for line in lines) + "\n"
