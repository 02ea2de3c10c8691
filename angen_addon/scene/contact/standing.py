# SPDX-License-Identifier: GPL-3.0-or-later
"""What an animated body stands, sits or lies on.

It is not simulated, so its surface meets what it rests on by eye only: a little above, or sunk
in. Its weight goes straight down from its underside to what that meets first.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....sensor_logic.contact.feet import held_by_pads
from ....sensor_logic.contact.underside import Samples, clustered, firmness, looks_up, underside
from ....sensor_logic.contact.world import Ground, Standing
from ..rays.caster import NOTHING
from ..rays.solids import Solid, Solids
from . import columns
from .carried import Body, parts_of, same_parts
from .things import GROUND, Key, Thing, Things

Array = NDArray[np.float64]
Rows = NDArray[np.intp]
# m: a body may be sunk this deep into what is soft; a pad this near to another surface is the
# one that is stood on.
DEPTH = 0.15
FLUSH = 0.001
# Rays start this little below the body's own upper side.
SKIN = 1e-4


@dataclass(frozen=True)
class Surroundings:
    """What a body is looked at among, at one frame: the solids, their surfaces, and the things that
    they belong to; the direction `up` (3,), and metres in a unit."""

    depsgraph: Any
    solids: Solids
    surfaces: columns.Surfaces
    things: Things
    up: Array
    metres: float

    def is_pad(self, row: int) -> bool:
        """Whether a solid is of a pad."""
        key = self.things.of_solid[self.solids.solids[row].number]
        return key in self.things.by_key and self.things.by_key[key].pad


def standing(around: Surroundings, thing: Thing, body: Body) -> list[Standing]:
    """The supports of an animated body, as the solids are now."""
    solids, up, metres = around.solids, around.up, around.metres
    rows = around.things.supports_of(thing, solids)
    reach = np.abs(up) * DEPTH + thing.tolerance
    lo, hi = body.lo - reach, body.hi + reach
    near = (solids.lo[rows] * metres <= hi) & (solids.hi[rows] * metres >= lo)
    rows = rows[near.all(axis=1)]
    if thing.laid:
        rows = rows[~_lies_on_it(around, rows, body)]
    there = [part for row in rows.tolist() for part in parts_of(solids.solids[row], solids)]
    there += [up, np.array(thing.tolerance)]
    if body.stood is None or not same_parts(body.stood[0], there):
        body.stood = there, _look_below(around, thing, body, rows)
    return body.stood[1]


def _lies_on_it(around: Surroundings, rows: Rows, body: Body) -> NDArray[np.bool_]:
    """Which solids lie on a pad, sunk through it: what has a weight and its middle above it."""
    solids, things, up = around.solids, around.things, around.up
    keys = [things.of_solid[solids.solids[row].number] for row in rows.tolist()]
    weighs = [key in things.by_key and things.by_key[key].weighs for key in keys]
    middles = (solids.lo[rows] + solids.hi[rows]) @ up * around.metres / 2.0
    above: NDArray[np.bool_] = middles > max(body.lo @ up, body.hi @ up)
    return above & np.array(weighs, bool)


def _look_below(around: Surroundings, thing: Thing, body: Body, rows: Rows) -> list[Standing]:
    looks = _looks_down(around, thing.tolerance, body, rows) if len(rows) else None
    if looks is None:
        return []
    samples, height, down = looks
    solids, up, tolerance = around.solids, around.up, thing.tolerance
    is_pad = np.array([around.is_pad(row) for row in rows.tolist()], bool)
    ranges, met = _met_below(around, tolerance, body, down, rows[~is_pad])
    if is_pad.any():
        pad_ranges, pad_met = _met_below(around, tolerance, body, down, rows[is_pad])
        first = (pad_met != NOTHING) & (pad_ranges <= ranges + FLUSH)
        ranges, met = np.where(first, pad_ranges, ranges), np.where(first, pad_met, met)
    gaps = np.where(met != NOTHING, ranges - height, np.inf)
    firm = firmness(gaps, tolerance)
    areas = samples.areas * firm
    stood = firm > 0.0
    on_pad = np.isin(met, [solids.solids[row].number for row in rows[is_pad].tolist()])
    if thing.stiff and (on_pad & stood).any():
        areas[stood] = held_by_pads(
            samples.points[stood], gaps[stood], areas[stood], on_pad[stood], up
        )
    below = samples.points - up * np.where(firm > 0.0, gaps, 0.0)[:, None]
    return _by_support(solids, around.things, samples.points, below, areas, met)


def _looks_down(
    around: Surroundings, tolerance: float, body: Body, rows: Rows
) -> tuple[Samples, Array, columns.Columns] | None:
    """Of a body's underside above some solids: the samples, how far above each rays start, and the
    rays; None where there is none."""
    solids, up, metres = around.solids, around.up, around.metres
    reach = np.abs(up) * DEPTH + tolerance
    # Beyond the body's own bounds it does not matter how far they reach.
    area_lo = np.maximum((solids.lo[rows] * metres - reach).min(axis=0), body.lo)
    area_hi = np.minimum((solids.hi[rows] * metres + reach).max(axis=0), body.hi)
    bounds = [area_lo, area_hi, up]
    if body.beneath is None or not same_parts(body.beneath[0], bounds):
        found = underside(body.triangles, body.closed, up, area_lo, area_hi)
        body.beneath = bounds, found, _room_above(body, found.points, up)
        body.below.clear()
        body.columns = None
    _, samples, height = body.beneath
    if not len(samples.points):
        return None
    if body.columns is None or body.columns[0] != tolerance:
        starts = samples.points + up * height[:, None]
        body.columns = tolerance, columns.Columns(starts, -up, height + tolerance)
    return samples, height, body.columns[1]


def _met_below(
    around: Surroundings, tolerance: float, body: Body, down: columns.Columns, rows: Rows
) -> tuple[Array, NDArray[np.int64]]:
    """How far rays get to the nearest of some solids, and the number of that."""
    ranges, met = down.length.copy(), np.full(len(down.length), NOTHING, np.int64)
    for row in rows.tolist():
        solid = around.solids.solids[row]
        version = int(around.solids.version[row]), tolerance
        known = body.below.get(solid.number)
        if known is None or known[0] != version:
            known = body.below[solid.number] = version, down.meet(_upper_side(around, solid))
        nearer = known[1] < ranges
        ranges[nearer], met[nearer] = known[1][nearer], solid.number
    return ranges, met


def _upper_side(around: Surroundings, solid: Solid) -> columns.Triangles:
    """What of a solid others can lie on: not the underside of what has a weight and an inside. A
    cushion would else hang on the person who is sunk into it."""
    depsgraph, things = around.depsgraph, around.things
    found = around.surfaces.of(depsgraph, solid, around.metres)
    other = things.by_key.get(things.of_solid[solid.number])
    if other is None or not other.carried:
        return found
    if not other.is_closed([part.geometry.triangles(depsgraph) for part in other.surfaces]):
        return found
    chosen = looks_up(found.corners, around.up)
    return columns.Triangles(found.corners[chosen], found.lo[chosen], found.hi[chosen])


def _room_above(body: Body, points: Array, up: Array) -> Array:
    """How far (n,) above each point the body is still itself: rays must not start beyond it."""
    length = np.full(len(points), DEPTH)
    if not len(points):
        return length
    far = columns.meet(columns.with_bounds(body.triangles), points + up * SKIN, up, length)
    return np.minimum(far, length)


def _by_support(
    solids: Solids,
    things: Things,
    points: Array,
    below: Array,
    areas: Array,
    met: NDArray[np.int64],
) -> list[Standing]:
    """The supports of points (n, 3), each with what it stands for and the number of the solid that
    it met, at `below` (n, 3)."""
    found: dict[Key, NDArray[np.bool_]] = {}
    ground = []
    known = {solid.number: solid for solid in solids.solids}
    for number in np.unique(met[areas > 0.0]).tolist():
        key = things.of_solid.get(number, GROUND)
        mask = (met == number) & (areas > 0.0)
        found[key] = found[key] | mask if key in found else mask
        if key == GROUND:
            places, _ = clustered(below[mask], areas[mask])
            ground.append(Ground(known[number].original.name, number, places))
    return [
        Standing(key, *clustered(points[mask], areas[mask]), tuple(ground) if key == GROUND else ())
        for key, mask in found.items()
    ]
