# SPDX-License-Identifier: GPL-3.0-or-later
"""What an animated body stands, sits or lies on.

It is not simulated, so its surface meets what it rests on by eye only: a little above, or sunk
in. Its weight goes straight down from its underside to what that meets first.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ....sensor_logic.contact.feet import held_by_pads
from ....sensor_logic.contact.underside import clustered, firmness, looks_up, underside
from ....sensor_logic.contact.world import Ground, Standing
from ..rays.caster import NOTHING
from ..rays.solids import Solid, Solids
from . import columns
from .carried import Body, parts_of, same_parts
from .things import GROUND, Key, Thing, Things

Array = np.typing.NDArray[np.float64]
# m: a body may be sunk this deep into what is soft; a pad this near to another surface is the
# one that is stood on.
DEPTH = 0.15
FLUSH = 0.001
# Rays start this little below the body's own upper side.
SKIN = 1e-4


def standing(
    depsgraph: Any,
    solids: Solids,
    surfaces: columns.Surfaces,
    things: Things,
    thing: Thing,
    body: Body,
    up: Array,
    metres: float,
) -> list[Standing]:
    """The supports of an animated body, as the solids are now."""
    tolerance = thing.tolerance
    pads = {key for key, other in things.by_key.items() if other.pad}
    rows = things.supports_of(thing, solids)
    reach = np.abs(up) * DEPTH + tolerance
    lo, hi = body.lo - reach, body.hi + reach
    near = (solids.lo[rows] * metres <= hi) & (solids.hi[rows] * metres >= lo)
    rows = rows[near.all(axis=1)]
    if thing.laid:
        rows = rows[~_lies_on_it(solids, things, rows, body, up, metres)]
    there = [part for row in rows.tolist() for part in parts_of(solids.solids[row], solids)]
    there += [up, np.array(tolerance)]
    if body.stood is None or not same_parts(body.stood[0], there):
        body.stood = (
            there,
            _look_below(depsgraph, solids, surfaces, things, thing, body, rows, pads, up, metres),
        )
    return body.stood[1]


def _lies_on_it(
    solids: Solids,
    things: Things,
    rows: np.typing.NDArray[np.intp],
    body: Body,
    up: Array,
    metres: float,
) -> np.typing.NDArray[np.bool_]:
    """Which solids lie on a pad, sunk through it: what has a weight and its middle above it."""
    keys = [things.of_solid[solids.solids[row].number] for row in rows.tolist()]
    weighs = [key in things.by_key and things.by_key[key].weighs for key in keys]
    middles = (solids.lo[rows] + solids.hi[rows]) @ up * metres / 2.0
    above: np.typing.NDArray[np.bool_] = middles > max(body.lo @ up, body.hi @ up)
    return above & np.array(weighs, bool)


def _look_below(
    depsgraph: Any,
    solids: Solids,
    surfaces: columns.Surfaces,
    things: Things,
    thing: Thing,
    body: Body,
    rows: np.typing.NDArray[np.intp],
    pads: set[Key],
    up: Array,
    metres: float,
) -> list[Standing]:
    if not len(rows):
        return []
    tolerance = thing.tolerance
    reach = np.abs(up) * DEPTH + tolerance
    # Beyond the body's own bounds it does not matter how far they reach.
    area_lo = np.maximum((solids.lo[rows] * metres - reach).min(axis=0), body.lo)
    area_hi = np.minimum((solids.hi[rows] * metres + reach).max(axis=0), body.hi)
    bounds = [area_lo, area_hi, up]
    if body.beneath is None or not same_parts(body.beneath[0], bounds):
        found = underside(body.triangles, body.closed, up, area_lo, area_hi)
        above = _room_above(body, found.points, up)
        body.beneath = bounds, found, above
        body.below.clear()
        body.columns = None
    _, samples, height = body.beneath
    if not len(samples.points):
        return []
    length = height + tolerance
    if body.columns is None or body.columns[0] != tolerance:
        starts = samples.points + up * height[:, None]
        body.columns = tolerance, columns.Columns(starts, -up, length)
    down = body.columns[1]

    def cast(rows: np.typing.NDArray[np.intp]) -> tuple[Array, Any]:
        """Ranges to the nearest of some solids, and the number of that."""
        ranges, met = length.copy(), np.full(len(length), NOTHING, np.int64)
        for row in rows.tolist():
            solid = solids.solids[row]
            version = int(solids.version[row]), tolerance
            known = body.below.get(solid.number)
            if known is None or known[0] != version:
                far = down.meet(_upper_side(depsgraph, surfaces, things, solid, up, metres))
                known = body.below[solid.number] = version, far
            nearer = known[1] < ranges
            ranges[nearer], met[nearer] = known[1][nearer], solid.number
        return ranges, met

    is_pad = np.array([things.of_solid[solids.solids[r].number] in pads for r in rows], bool)
    ranges, met = cast(rows[~is_pad])
    if is_pad.any():
        pad_ranges, pad_met = cast(rows[is_pad])
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
    return _by_support(solids, things, samples.points, below, areas, met)


def _upper_side(
    depsgraph: Any,
    surfaces: columns.Surfaces,
    things: Things,
    solid: Solid,
    up: Array,
    metres: float,
) -> columns.Triangles:
    """What of a solid others can lie on: not the underside of what has a weight and an inside. A
    cushion would else hang on the person who is sunk into it."""
    found = surfaces.of(depsgraph, solid, metres)
    other = things.by_key.get(things.of_solid[solid.number])
    if other is None or not other.carried:
        return found
    if not other.is_closed([part.geometry.triangles(depsgraph) for part in other.surfaces]):
        return found
    chosen = looks_up(found.corners, up)
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
    met: np.typing.NDArray[np.int64],
) -> list[Standing]:
    """The supports of points (n, 3), each with what it stands for and the number of the solid that
    it met, at `below` (n, 3)."""
    found: dict[Key, np.typing.NDArray[np.bool_]] = {}
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
