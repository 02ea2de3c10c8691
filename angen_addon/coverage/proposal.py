# SPDX-License-Identifier: GPL-3.0-or-later
"""Proposes poses for a number of detectors in rooms; a generator, as for maps."""

from __future__ import annotations

import math
from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...sensor_logic.coverage.detect import DetectorView
from ...sensor_logic.coverage.detectors import PirParameters
from ...sensor_logic.coverage.grid import Cells, CoverageMap
from ...sensor_logic.coverage.motions import Motion
from ...sensor_logic.coverage.placement import ChosenPlaces, choose
from ...sensor_logic.error import AngenError
from ...sensor_logic.model import Array
from ..scene.home import EvaluatedHome
from ..scene.sensors import Sensor
from ..scene.warmth import Warmth
from .candidates import Candidate, candidates
from .cells import saying
from .floor import cells_of
from .maps import Enough, MapProgress, at_most, at_once, check_cell
from .views import detectors, view_from, view_of

# Rays pass through no object: candidates are none yet.
NOBODY = -1
MOST_CANDIDATES = 5000
# Of the work, what is needed to tell how much each candidate covers at most.
FIRST_SHARE = 0.5
# So many candidates beside those that are chosen are looked at before the next choice.
NEXT_BEST = 4


@dataclass(frozen=True)
class Wish:
    """How many detectors with which parameters (`rate` updates a second) to hang where: `rooms`
    by name (none: all), `mounting` WALL, CEILING or BOTH, `height` m above the floor on walls,
    `spacing` m between candidates; `beside` the detectors that are there."""

    count: int
    parameters: PirParameters
    rate: float
    rooms: tuple[str, ...] = ()
    mounting: str = "WALL"
    height: float = 2.3
    spacing: float = 0.5
    seed: int = 0
    beside: bool = False


@dataclass(frozen=True)
class Proposal:
    """`chosen` candidates, the one of the largest gain first, named `names`; the `map` of what
    they cover; `tried` candidates. Weights of `choice` are cells."""

    chosen: tuple[Candidate, ...]
    names: tuple[str, ...]
    choice: ChosenPlaces
    map: CoverageMap
    tried: int
    before: int

    def summary(self) -> str:
        """The result in a sentence or two, for a report."""
        all_cells, choice = len(self.map.cells), self.choice
        covered = (choice.covered + self.before) / all_cells
        bound = min(1.0, (choice.bound + self.before) / all_cells)
        return (
            f"{len(self.chosen)} of {self.tried} candidates cover {100 * covered:.1f} % of the "
            f"floor. No choice of as many covers more than {100 * bound:.1f} %: "
            f"this is at least {math.floor(1000 * choice.assured + 1e-9) / 10:g} % of the best"
        )


def propose(
    depsgraph: Any, sensors: Sequence[Sensor], wish: Wish, motion: Motion, size: float
) -> Generator[MapProgress | Proposal, None, None]:
    """Yields stages, and last the proposal. Raises AngenError, and Enough where that is thrown in
    before any candidate was looked at closely."""
    check_cell(size)
    _check(wish)
    home = EvaluatedHome(depsgraph)
    cells = None
    for told in cells_of(home, sensors, motion, size, wish.rooms):
        if isinstance(told, str):
            yield MapProgress(0.0, told)
        else:
            cells = told
    assert cells is not None
    looking = candidates(home, cells, wish.mounting, wish.height, wish.spacing)
    found = yield from saying(MapProgress(0.05, "looking for walls and ceilings"), looking)
    if not found:
        raise AngenError(
            f"no wall or ceiling was found to hang a detector on {wish.height:g} m above the "
            "floor: take another height or mounting"
        )
    if len(found) > MOST_CANDIDATES:
        raise AngenError(
            f"{len(found)} candidates are too many: take fewer rooms or a larger spacing"
        )
    weights = np.ones(len(cells))
    if wish.beside:
        for sensor in detectors(sensors):
            there = at_once({sensor.name: view_of(home, sensor)}, cells, motion)
            weights[there.count > 0] = 0.0
            yield MapProgress(0.05, "looking what is covered")
    search = _Search(home, cells, motion, wish, found, weights)
    choice = yield from search.run()
    chosen = tuple(found[i] for i in choice.chosen)
    names = tuple(f"Proposed PIR {i + 1}" for i in range(len(chosen)))
    views = {name: search.view(candidate) for name, candidate in zip(names, chosen, strict=True)}
    covered = at_once(views, cells, motion)
    before = int((weights == 0.0).sum())
    yield Proposal(chosen, names, choice, covered, len(found), before)


class _Search:
    """Which candidates together cover the most. What each covers at most is told far sooner than
    what it does: only those are looked at closely that are the best as far as is known."""

    def __init__(
        self,
        home: EvaluatedHome,
        cells: Cells,
        motion: Motion,
        wish: Wish,
        found: Sequence[Candidate],
        weights: Array,
    ) -> None:
        self._home, self._cells, self._motion, self._wish = home, cells, motion, wish
        self._found, self._weights = found, weights
        self._warmth = Warmth(home.caster)
        # (candidates, cells): what each covers, or at most where it is not `exact`.
        self._sets = np.zeros((len(found), len(cells)), bool)
        self._exact = np.zeros(len(found), bool)

    def view(self, candidate: Candidate) -> DetectorView:
        wish = self._wish
        return view_from(
            self._home, self._warmth, wish.parameters, candidate.pose, wish.rate, NOBODY
        )

    def run(self) -> Generator[MapProgress, None, ChosenPlaces]:
        for i, candidate in enumerate(self._found):
            view = self.view(candidate)
            self._sets[i] = at_most({"": view}, self._cells, self._motion).covered[0]
            share = FIRST_SHARE * (i + 1) / len(self._found)
            yield MapProgress(0.05 + share, f"candidate {i + 1} of {len(self._found)}")
        while True:
            choice = self._choose(np.arange(len(self._found)))
            if self._exact[list(choice.chosen)].all():
                return choice
            try:
                yield from self._look_closely(choice)
            except Enough:
                if not self._exact.any():
                    raise
                best = self._choose(np.flatnonzero(self._exact))
                return replace(best, bound=max(choice.bound, best.covered))

    def _choose(self, rows: NDArray[np.intp]) -> ChosenPlaces:
        """Chooses among these candidates."""
        wish = self._wish
        choice = choose(self._sets[rows], wish.count, self._weights, wish.seed)
        return replace(choice, chosen=tuple(int(rows[i]) for i in choice.chosen))

    def _look_closely(self, choice: ChosenPlaces) -> Iterator[MapProgress]:
        """Looks closely at the chosen candidates, and at a few that may be chosen next."""
        worth = np.where(self._exact, -1.0, self._sets @ self._weights)
        next_best = np.argsort(-worth, kind="stable")[:NEXT_BEST].tolist()
        for i in dict.fromkeys([*choice.chosen, *next_best]):
            if self._exact[i]:
                continue
            view = self.view(self._found[i])
            self._sets[i] = at_once({"": view}, self._cells, self._motion).covered[0]
            self._exact[i] = True
            known = np.flatnonzero(self._exact)
            best = float((self._sets[known] @ self._weights).max())
            yield MapProgress(
                0.05 + FIRST_SHARE + (0.95 - FIRST_SHARE) * min(1.0, best / choice.bound),
                f"{len(known)} looked at closely; the best so far covers "
                f"{self._percent(best)}, no choice more than {self._percent(choice.bound)}",
            )

    def _percent(self, worth: float) -> str:
        before = float((self._weights == 0.0).sum())
        return f"{100 * min(1.0, (worth + before) / len(self._cells)):.0f} %"


def _check(wish: Wish) -> None:
    if wish.count < 1:
        raise AngenError(f"{wish.count} detectors: it must be at least 1")
    if not 0.1 <= wish.spacing <= 5.0:
        raise AngenError(f"a spacing of {wish.spacing:g} m: it must be from 0.1 m to 5 m")
    problems = wish.parameters.problems()
    if problems:
        raise AngenError(f"the detector to place: {problems[0]}")
