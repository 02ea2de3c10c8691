# SPDX-License-Identifier: GPL-3.0-or-later
"""The cells of a coverage map, the motions detected in each, the coverage of rooms, and the choice
of detectors that together cover the most."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..model import Array
from ..wording import aligned
from .motions import HEADINGS, Motion, Start

# A cell is covered if a detector detects this share of the possible directions of motion.
ENOUGH = 0.5
NO_ROOM = "no room"


@dataclass(frozen=True)
class Cells:
    """Squares of `size` m on the floor: their middles `at` (n, 3), the names of their `room` (n),
    the number of their `storey` (n,), and how far a body can move, `lengths` (n, 8), by
    `Motion.lengths`."""

    size: float
    at: Array
    room: tuple[str, ...]
    storey: NDArray[np.intp]
    lengths: Array

    def __len__(self) -> int:
        return len(self.at)

    @property
    def rooms(self) -> list[str]:
        """The rooms by name; NO_ROOM comes last."""
        return sorted(set(self.room), key=lambda name: (name == NO_ROOM, name))

    def of(self, rooms: Iterable[str]) -> Cells:
        """The cells of these rooms."""
        wanted = set(rooms)
        rows = np.array([name in wanted for name in self.room], bool)
        names = tuple(name for name in self.room if name in wanted)
        return Cells(self.size, self.at[rows], names, self.storey[rows], self.lengths[rows])

    def starts(self) -> tuple[Start, NDArray[np.intp], NDArray[np.intp]]:
        """All possible motions, and the cell and direction of each."""
        cell, direction = np.nonzero(self.lengths > 0.0)
        start = Start(self.at[cell], HEADINGS[direction], self.lengths[cell, direction])
        return start, cell, direction


@dataclass(frozen=True)
class RoomCoverage:
    """The number of a room's cells, how many of them no, one and several detectors cover (`dead`,
    `once`, `overlap`), and the `area` of a cell in m²."""

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
    """`strength` (detectors, cells, 8): the signal divided by the threshold for each direction, 0
    where the body cannot move."""

    motion: Motion
    cells: Cells
    sensors: tuple[str, ...]
    strength: NDArray[np.float32]

    @property
    def noticed(self) -> Array:
        """(detectors, cells): the share of the possible directions that the detector detects."""
        possible = np.maximum((self.cells.lengths > 0.0).sum(axis=1), 1)
        share: Array = (self.strength > 1.0).sum(axis=2) / possible
        return share

    @property
    def covered(self) -> NDArray[np.bool_]:
        """(detectors, cells): whether the detector covers the cell."""
        return covered_by(self.noticed)

    @property
    def count(self) -> NDArray[np.intp]:
        """(cells,): how many detectors cover each cell."""
        number: NDArray[np.intp] = self.covered.sum(axis=0)
        return number

    @property
    def best(self) -> Array:
        """(cells,): the share of the possible directions that at least one detector detects."""
        possible = np.maximum((self.cells.lengths > 0.0).sum(axis=1), 1)
        share: Array = (self.strength > 1.0).any(axis=0).sum(axis=1) / possible
        return share

    @property
    def margin(self) -> Array:
        """(cells,): the median over the possible directions of the best detector's signal divided
        by its threshold."""
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
    """A row for each cell: its middle, its room, the number of possible directions, the number of
    detectors that cover it, the share of directions detected by any, the margin, and the share of
    each detector."""
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
    """The coverage of each room as a text table."""
    rows = [("room", "area m²", "covered", "dead m²", "overlap"), *room_rows(coverage)]
    return "\n".join(aligned(rows)) + "\n"


def room_rows(coverage: CoverageMap) -> list[tuple[str, ...]]:
    """For each room and for all: name, area, and the covered, dead and overlapping part."""
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


# Chooses detectors that together cover the most: greedily, then by swaps, with a proven bound.
#
# The coverage of k sets is submodular. So the greedy choice reaches at least 1 − 1/e of the
# optimum (Nemhauser, Wolsey, Fisher 1978). A tighter bound for the given sets: the optimum covers
# at most the coverage of any choice plus the k largest gains beyond it (Minoux 1978; Leskovec et
# al. 2007).

# Rounds of swaps. Each round improves the choice, so that they end long before.
MOST_ROUNDS = 100
# Gains closer than this are equal.
TIE = 1e-9

Sets = NDArray[np.bool_]


@dataclass(frozen=True)
class ChosenPlaces:
    """The rows `chosen` in the order of their gains; the weight that they cover (`covered`), that
    which the greedy choice covered (`greedy`), and a `bound` that no choice of as many exceeds."""

    chosen: tuple[int, ...]
    covered: float
    greedy: float
    bound: float
    swaps: int

    @property
    def assured(self) -> float:
        """A lower bound of the share of the optimum that is reached."""
        return self.covered / self.bound if self.bound > 0.0 else 1.0


def choose(sets: Sets, count: int, weights: Array | None = None, seed: int = 0) -> ChosenPlaces:
    """Chooses at most `count` of the sets (m, n), which cover items (n,) of `weights`. The seed
    decides between equally good sets. Raises ValueError."""
    if count < 1:
        raise ValueError(f"a number of {count}: at least 1 must be chosen")
    worth = np.ones(sets.shape[1]) if weights is None else np.asarray(weights, np.float64)
    if (worth < 0.0).any():
        raise ValueError("weights must be 0 or more")
    order = np.random.default_rng(seed).permutation(len(sets))
    shuffled = sets[order]
    bounds = [float(worth[sets.any(axis=0)].sum())]
    bounds.append(_online_bound(shuffled, [], count, worth))
    chosen = _greedy(shuffled, count, worth, bounds)
    greedy = _value(shuffled, chosen, worth)
    chosen, swaps = _swapped(shuffled, chosen, worth)
    bounds.append(_online_bound(shuffled, chosen, count, worth))
    covered = _value(shuffled, chosen, worth)
    ranked = _ranked(shuffled, chosen, worth)
    rows = tuple(int(order[i]) for i in ranked)
    return ChosenPlaces(rows, covered, greedy, max(min(bounds), covered), swaps)


def _value(sets: Sets, chosen: list[int], worth: Array) -> float:
    return float(worth[sets[chosen].any(axis=0)].sum())


def _gains(sets: Sets, taken: NDArray[np.bool_], worth: Array) -> Array:
    gains: Array = sets @ np.where(taken, 0.0, worth)
    return gains


def _best(gains: Array) -> int:
    """The first set of the largest gain."""
    return int(np.flatnonzero(gains >= gains.max() - TIE)[0])


def _greedy(sets: Sets, count: int, worth: Array, bounds: list[float]) -> list[int]:
    """The sets of the largest gain, one after the other; adds the bound of each step to
    `bounds`."""
    taken = np.zeros(sets.shape[1], bool)
    chosen: list[int] = []
    while len(chosen) < min(count, len(sets)):
        gains = _gains(sets, taken, worth)
        best = _best(gains)
        if gains[best] <= TIE:
            break
        chosen.append(best)
        taken |= sets[best]
        bounds.append(_online_bound(sets, chosen, count, worth))
    return chosen


def _online_bound(sets: Sets, chosen: list[int], count: int, worth: Array) -> float:
    taken: Sets = np.asarray(sets[chosen].any(axis=0))
    gains = np.sort(_gains(sets, taken, worth))[::-1]
    return float(worth[taken].sum() + gains[:count].sum())


def _swapped(sets: Sets, chosen: list[int], worth: Array) -> tuple[list[int], int]:
    """The choice after swapping single sets as long as that covers more, and the number of
    swaps."""
    chosen = list(chosen)
    swaps = 0
    for _ in range(MOST_ROUNDS):
        better = False
        for place in range(len(chosen)):
            others = chosen[:place] + chosen[place + 1 :]
            taken: Sets = np.asarray(sets[others].any(axis=0))
            gains = _gains(sets, taken, worth)
            best = _best(gains)
            if gains[best] > gains[chosen[place]] + TIE:
                chosen[place] = best
                swaps += 1
                better = True
        if not better:
            break
    return chosen, swaps


def _ranked(sets: Sets, chosen: list[int], worth: Array) -> list[int]:
    """The chosen sets in the order of their gains."""
    left, ranked = list(chosen), []
    taken = np.zeros(sets.shape[1], bool)
    while left:
        gains = _gains(sets[left], taken, worth)
        best = left.pop(_best(gains))
        taken |= sets[best]
        ranked.append(best)
    return ranked
