# SPDX-License-Identifier: GPL-3.0-or-later
"""Proposes poses for a number of detectors in rooms; a generator, as for maps."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...sensor_logic.coverage.grid import CoverageMap
from ...sensor_logic.coverage.motions import Motion
from ...sensor_logic.coverage.placement import Choice, choose
from ...sensor_logic.kinds.pir.range_scan import PirParameters
from ..plan.home import Home
from ..scene_probe.warmth import Warmth
from ..sensors import Sensor, SensorError
from .candidates import Candidate, candidates
from .floor import cells_of
from .maps import Stage, at_once, check_cell
from .views import detectors, view_from, view_of

# Rays pass through no object: candidates are none yet.
NOBODY = -1
MOST_CANDIDATES = 5000
CANDIDATES_SHARE = 0.9


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
    choice: Choice
    map: CoverageMap
    tried: int
    before: int

    def told(self) -> str:
        """In a sentence or two, for a report."""
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
) -> Iterator[Stage | Proposal]:
    """Yields stages, and last the proposal. Raises SensorError."""
    check_cell(size)
    _check(wish)
    home = Home(depsgraph)
    cells = None
    for told in cells_of(home, sensors, motion, size, wish.rooms):
        if isinstance(told, str):
            yield Stage(0.0, told)
        else:
            cells = told
    assert cells is not None
    yield Stage(0.05, "looking for walls and ceilings")
    found = candidates(home, cells, wish.mounting, wish.height, wish.spacing)
    if not found:
        raise SensorError(
            f"no wall or ceiling was found to hang a detector on {wish.height:g} m above the "
            "floor: take another height or mounting"
        )
    if len(found) > MOST_CANDIDATES:
        raise SensorError(
            f"{len(found)} candidates are too many: take fewer rooms or a larger spacing"
        )
    weights = np.ones(len(cells))
    if wish.beside:
        there = {s.name: view_of(home, s) for s in detectors(sensors)}
        weights[at_once(there, cells, motion).count > 0] = 0.0
    warmth = Warmth(home.caster)
    sets = np.zeros((len(found), len(cells)), bool)
    for i, candidate in enumerate(found):
        view = view_from(home, warmth, wish.parameters, candidate.pose, wish.rate, NOBODY)
        sets[i] = at_once({"": view}, cells, motion).covered[0]
        yield Stage(
            0.05 + CANDIDATES_SHARE * (i + 1) / len(found), f"candidate {i + 1} of {len(found)}"
        )
    choice = choose(sets, wish.count, weights, wish.seed)
    chosen = tuple(found[i] for i in choice.chosen)
    names = tuple(f"Proposed PIR {i + 1}" for i in range(len(chosen)))
    views = {
        name: view_from(home, warmth, wish.parameters, candidate.pose, wish.rate, NOBODY)
        for name, candidate in zip(names, chosen, strict=True)
    }
    covered = at_once(views, cells, motion)
    before = int((weights == 0.0).sum())
    yield Proposal(chosen, names, choice, covered, len(found), before)


def _check(wish: Wish) -> None:
    if wish.count < 1:
        raise SensorError(f"{wish.count} detectors: it must be at least 1")
    if not 0.1 <= wish.spacing <= 5.0:
        raise SensorError(f"a spacing of {wish.spacing:g} m: it must be from 0.1 m to 5 m")
    problems = wish.parameters.problems()
    if problems:
        raise SensorError(f"the detector to place: {problems[0]}")
