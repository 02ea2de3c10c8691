# SPDX-License-Identifier: GPL-3.0-or-later
"""The cells of a coverage map, the coverage of rooms, and the choice of the best positions."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..logs.wording import aligned
from ..model import Array
from .motions import HEADINGS, Motion, Start

# A detector covers a cell if it detects this share of the possible directions of motion.
ENOUGH = 0.5
NO_ROOM = "no room"


@dataclass(frozen=True)
class Cells:
    """Square cells of the floor, `size` m wide.

    Attributes
    ----------
    at
        The centres (n, 3) of the cells in m.
    room
        The name of the room of each cell, n names.
    storey
        The index (n,) of the storey of each cell.
    lengths
        How far a body can move from the centre of each cell in each of 8 directions, (n, 8). The
        unit is as in `Motion.lengths`.
    """

    size: float
    at: Array
    room: tuple[str, ...]
    storey: NDArray[np.intp]
    lengths: Array

    def __len__(self) -> int:
        return len(self.at)

    @property
    def rooms(self) -> list[str]:
        """The names of the rooms; NO_ROOM comes last."""
        return sorted(set(self.room), key=lambda name: (name == NO_ROOM, name))

    def of(self, rooms: Iterable[str]) -> Cells:
        """Return the cells in the rooms with these names."""
        wanted = set(rooms)
        rows = np.array([name in wanted for name in self.room], bool)
        names = tuple(name for name in self.room if name in wanted)
        return Cells(self.size, self.at[rows], names, self.storey[rows], self.lengths[rows])

    def starts(self) -> tuple[Start, NDArray[np.intp], NDArray[np.intp]]:
        """Return all possible motions, and the indices of the cell and the direction of each."""
        cell, direction = np.nonzero(self.lengths > 0.0)
        start = Start(self.at[cell], HEADINGS[direction], self.lengths[cell, direction])
        return start, cell, direction


@dataclass(frozen=True)
class RoomCoverage:
    """The coverage of a room.

    Attributes
    ----------
    cells
        The number of cells in the room.
    dead, once, overlap
        The numbers of cells that no detector covers, that one covers, and that several cover.
    area
        The area of a cell in m².
    """

    name: str
    cells: int
    dead: int
    once: int
    overlap: int
    area: float

    @property
    def share(self) -> float:
        """The fraction of the cells that at least one detector covers."""
        return 1.0 - self.dead / self.cells


@dataclass(frozen=True)
class CoverageMap:
    """A coverage map: the cells, and how well detectors detect a motion in each of them.

    `strength` (detectors, cells, 8) is the largest signal for a motion in each of 8 directions,
    divided by the threshold. It is 0 if the body cannot move in that direction.
    """

    motion: Motion
    cells: Cells
    sensors: tuple[str, ...]
    strength: NDArray[np.float32]

    @property
    def noticed(self) -> Array:
        """The fraction (detectors, cells) of the possible directions in which a motion is detected.

        A direction is possible if the body can move in it.
        """
        possible = np.maximum((self.cells.lengths > 0.0).sum(axis=1), 1)
        share: Array = (self.strength > 1.0).sum(axis=2) / possible
        return share

    @property
    def covered(self) -> NDArray[np.bool_]:
        """Whether each detector covers each cell, (detectors, cells)."""
        return covered_by(self.noticed)

    @property
    def count(self) -> NDArray[np.intp]:
        """The number (cells,) of detectors that cover each cell."""
        number: NDArray[np.intp] = self.covered.sum(axis=0)
        return number

    @property
    def best(self) -> Array:
        """The fraction (cells,) of the possible directions in which any detector detects a motion.

        A direction is possible if the body can move in it.
        """
        possible = np.maximum((self.cells.lengths > 0.0).sum(axis=1), 1)
        share: Array = (self.strength > 1.0).any(axis=0).sum(axis=1) / possible
        return share

    @property
    def margin(self) -> Array:
        """The signal in each cell (cells,), divided by the threshold.

        It is the median over the directions in which the body can move. In each direction, the
        detector with the largest signal counts.
        """
        best = self.strength.max(axis=0, initial=0.0).astype(np.float64)
        best[self.cells.lengths <= 0.0] = np.nan
        median: Array = np.nanmedian(best, axis=1) if len(best) else np.empty(0)
        return median

    def rooms(self) -> list[RoomCoverage]:
        """Return the coverage of each room."""
        count, names = self.count, np.array(self.cells.room, object)
        return [self._room(name, count[names == name]) for name in self.cells.rooms]

    def total(self) -> RoomCoverage:
        """Return the coverage of all cells together."""
        return self._room("all", self.count)

    def _room(self, name: str, count: NDArray[np.intp]) -> RoomCoverage:
        dead, once = int((count == 0).sum()), int((count == 1).sum())
        return RoomCoverage(
            name, len(count), dead, once, len(count) - dead - once, self.cells.size**2
        )


def covered_by(noticed: Array) -> NDArray[np.bool_]:
    """Return whether a cell is covered, given the fraction of directions that are detected."""
    covered: NDArray[np.bool_] = noticed >= ENOUGH - 1e-9
    return covered


COLUMNS = ("x_m", "y_m", "floor_m", "room", "directions", "covered_by", "noticed", "margin")


def map_csv(coverage: CoverageMap) -> str:
    """Return the map as CSV with a row for each cell.

    The columns are:

    - the centre, in three columns, and the room
    - the number of possible directions
    - the number of detectors that cover the cell
    - the fraction of directions in which any detector detects a motion
    - the margin, as in `CoverageMap.margin`
    - the fraction of directions in which each detector detects a motion, a column for each
    """
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
    """Return the coverage of each room as a text table."""
    rows = [("room", "area m²", "covered", "dead m²", "overlap"), *room_rows(coverage)]
    return "\n".join(aligned(rows)) + "\n"


def room_rows(coverage: CoverageMap) -> list[tuple[str, ...]]:
    """Return the rows of a table as texts: one row for each room, then one for all rooms.

    A row has the name, the area, and the covered, the dead and the overlapping part.
    """
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


# The choice of detectors that together cover the most: greedy, then by swaps, with a proven bound.
#
# The coverage of k sets is submodular. So the greedy choice reaches at least 1 − 1/e of the
# optimum (Nemhauser, Wolsey, Fisher 1978). A tighter bound holds for the given sets: the optimum
# covers at most what any choice covers, plus the k largest gains that could be added to that
# choice (Minoux 1978; Leskovec et al. 2007).

# The most rounds of swaps. In practice no swap improves the choice long before.
MOST_ROUNDS = 100
# Gains closer than this are equal.
TIE = 1e-9

Sets = NDArray[np.bool_]


@dataclass(frozen=True)
class ChosenPlaces:
    """The result of `choose`: sets of covered cells, each for a possible position of a detector.

    Attributes
    ----------
    chosen
        The indices of the chosen sets in `sets`, the one with the largest gain first.
    covered
        The total weight of the items that the chosen sets cover.
    greedy
        The total weight that the greedy choice covers, before any swap.
    bound
        An upper limit of `covered` for any choice of as many sets.
    swaps
        The number of swaps after the greedy choice.
    """

    chosen: tuple[int, ...]
    covered: float
    greedy: float
    bound: float
    swaps: int

    @property
    def assured(self) -> float:
        """A lower bound of `covered` as a fraction of the optimum: `covered` / `bound`."""
        return self.covered / self.bound if self.bound > 0.0 else 1.0


def choose(sets: Sets, count: int, weights: Array | None = None, seed: int = 0) -> ChosenPlaces:
    """Choose at most `count` sets that together cover items of the largest total weight.

    A set is a possible position of a detector. The items are the cells that it can cover.

    Parameters
    ----------
    sets
        Whether each set covers each item, (m, n).
    weights
        The weights (n,) of the items, at least 0; None means equal weights.
    seed
        The seed of the random choice between equally good sets.

    Raises
    ------
    ValueError
        If `count` is below 1 or a weight is negative.

    References
    ----------
    .. [1] Nemhauser, Wolsey, Fisher 1978: the bound of the greedy choice.
    .. [2] Minoux 1978; Leskovec et al. 2007: the bound for the given sets.
    """
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
    """Return the index of the largest gain, the first of equal ones."""
    return int(np.flatnonzero(gains >= gains.max() - TIE)[0])


def _greedy(sets: Sets, count: int, worth: Array, bounds: list[float]) -> list[int]:
    """Return the indices of the sets that the greedy choice takes, in order.

    Each set is the one that adds most to the covered weight. After each set, append an upper bound
    of the optimum to `bounds`.
    """
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
    """Replace chosen sets one by one by better ones, until none is better.

    Return the new choice and the number of replacements.
    """
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
    """Return the chosen sets in the order in which a greedy choice would take them."""
    left, ranked = list(chosen), []
    taken = np.zeros(sets.shape[1], bool)
    while left:
        gains = _gains(sets[left], taken, worth)
        best = left.pop(_best(gains))
        taken |= sets[best]
        ranked.append(best)
    return ranked
