# SPDX-License-Identifier: GPL-3.0-or-later
"""Find the surfaces that an animated body stands, sits or lies on.

Animators place a body on a surface by eye: it may hover a little, or sink in. Its weight goes
straight down from its underside to the first surface below. Objects without a mass, such as a
duvet, a mattress or a seat, pass it on straight down, as soft things do, to what they lie on: a
pad or a body with a mass.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....sensor_logic.forces.pad_forces import held_by_pads
from ....sensor_logic.forces.underside import Samples, clustered, firmness, looks_up, underside
from ....sensor_logic.forces.world import BareSurface, Support
from ....sensor_logic.model import Array
from ..rays.caster import NOTHING
from ..rays.solids import Solid, Solids
from . import posed_bodies
from .bodies import GROUND, ContactBodies, ContactBody, Key
from .posed_bodies import PosedBody, surface_state, unchanged

Rows = NDArray[np.intp]
# m: the largest depth to which a body sinks into soft surfaces.
DEPTH = 0.15
# m: the thickest mattress or seat through which a weight still reaches a pad below.
THICKEST = 0.35
# m: the pad takes the weight where another surface is at most this far above it.
FLUSH = 0.001
# m: the distance from the underside at which rays up through the body start.
SKIN = 1e-4


@dataclass(frozen=True)
class Surroundings:
    """The evaluated scene at one frame, for the search for supports.

    Attributes
    ----------
    depsgraph
        The evaluated depsgraph.
    solids
        The solids of the scene.
    surfaces
        The triangles of the solids.
    bodies
        The bodies to which the solids belong.
    up
        The upward unit vector (3,).
    metres
        The length of a Blender unit, in m.
    """

    depsgraph: Any
    solids: Solids
    surfaces: posed_bodies.WorldTriangles
    bodies: ContactBodies
    up: Array
    metres: float

    def is_pad(self, row: int) -> bool:
        """Return whether the solid with the index `row` in `solids` belongs to a pad."""
        key = self.bodies.of_solid[self.solids.solids[row].number]
        return key in self.bodies.by_key and self.bodies.by_key[key].pad

    def bears(self, row: int) -> bool:
        """Return whether the solid with the index `row` is a pad, or part of a body with a mass."""
        body = self.bodies.by_key.get(self.bodies.of_solid[self.solids.solids[row].number])
        return body is not None and (body.pad or body.weighs)


def find_supports(around: Surroundings, body: ContactBody, posed: PosedBody) -> list[Support]:
    """Return the surfaces on which an animated body or a loose pad rests at the present frame."""
    solids, up, metres = around.solids, around.up, around.metres
    every = around.bodies.supports_of(body, solids)
    reach = np.abs(up) * DEPTH + body.tolerance
    lo, hi = posed.lo - reach, posed.hi + reach
    near = (solids.lo[every] * metres <= hi) & (solids.hi[every] * metres >= lo)
    rows = every[near.all(axis=1)]
    if body.loose_pad:
        rows = rows[~_lie_on_pad(around, rows, posed)]
    lo, hi = np.minimum(lo, lo - up * THICKEST), np.maximum(hi, hi - up * THICKEST)
    deep = (solids.lo[every] * metres <= hi) & (solids.hi[every] * metres >= lo)
    layers = _layers(around, body, posed, every[deep.all(axis=1)])
    parts = [*rows.tolist(), *layers.covers.tolist(), *layers.bearers.tolist()]
    state = [part for row in parts for part in surface_state(solids.solids[row], solids)]
    state += [up, np.array([body.tolerance, len(rows), len(layers.covers)])]
    if posed.supports is None or not unchanged(posed.supports[0], state):
        posed.supports = state, _find_below(around, body, posed, rows, layers)
    return posed.supports[1]


@dataclass(frozen=True)
class _Layers:
    """The rows of the solids below a body through which its weight can pass on, and to which.

    Attributes
    ----------
    covers
        The solids without a mass. None if there are no `bearers`.
    bearers
        The pads, and the solids of bodies with a mass.
    """

    covers: Rows
    bearers: Rows


def _layers(around: Surroundings, body: ContactBody, posed: PosedBody, rows: Rows) -> _Layers:
    """Sort the solids `rows` below a body into covers and bearers."""
    bears = np.array([around.bears(row) for row in rows.tolist()], bool)
    bearers = rows[bears]
    if body.loose_pad and len(bearers):
        bearers = bearers[~_lie_on_pad(around, bearers, posed)]
    return _Layers(rows[~bears] if len(bearers) else rows[:0], bearers)


def _lie_on_pad(around: Surroundings, rows: Rows, posed: PosedBody) -> NDArray[np.bool_]:
    """Return the mask of the solids `rows` that lie on the loose pad `posed`.

    They have a weight, and their middle is above the pad. So a solid counts even if it reaches down
    through the pad.
    """
    solids, bodies, up = around.solids, around.bodies, around.up
    keys = [bodies.of_solid[solids.solids[row].number] for row in rows.tolist()]
    weighs = [key in bodies.by_key and bodies.by_key[key].weighs for key in keys]
    middles = (solids.lo[rows] + solids.hi[rows]) @ up * around.metres / 2.0
    above: NDArray[np.bool_] = middles > max(posed.lo @ up, posed.hi @ up)
    return above & np.array(weighs, bool)


def _find_below(
    around: Surroundings, body: ContactBody, posed: PosedBody, rows: Rows, layers: _Layers
) -> list[Support]:
    cast = _rays_down(around, body.tolerance, posed, rows) if len(rows) else None
    if cast is None:
        return []
    samples, height, down = cast
    solids, up, tolerance = around.solids, around.up, body.tolerance
    is_pad = np.array([around.is_pad(row) for row in rows.tolist()], bool)
    ranges, numbers = _nearest_below(around, tolerance, posed, down, rows[~is_pad])
    if is_pad.any():
        pad_ranges, pad_numbers = _nearest_below(around, tolerance, posed, down, rows[is_pad])
        first = (pad_numbers != NOTHING) & (pad_ranges <= ranges + FLUSH)
        ranges, numbers = np.where(first, pad_ranges, ranges), np.where(first, pad_numbers, numbers)
    gaps = np.where(numbers != NOTHING, ranges - height, np.inf)
    firm = firmness(gaps, tolerance)
    areas = samples.areas * firm
    stood = firm > 0.0
    covers = [solids.solids[row].number for row in layers.covers.tolist()]
    passed = np.flatnonzero(stood & np.isin(numbers, covers))
    if len(passed):
        surface = samples.points[passed] - up * gaps[passed, None]
        borne = _passed_on(around, surface, tolerance, layers)
        numbers[passed] = np.where(borne != NOTHING, borne, numbers[passed])
    pads = [row for row in (*rows.tolist(), *layers.bearers.tolist()) if around.is_pad(row)]
    on_pad = np.isin(numbers, [solids.solids[row].number for row in pads])
    if body.stiff and (on_pad & stood).any():
        areas[stood] = held_by_pads(
            samples.points[stood], gaps[stood], areas[stood], on_pad[stood], up
        )
    below = samples.points - up * np.where(firm > 0.0, gaps, 0.0)[:, None]
    return _by_support(solids, around.bodies, samples.points, below, areas, numbers)


def _rays_down(
    around: Surroundings, tolerance: float, posed: PosedBody, rows: Rows
) -> tuple[Samples, Array, posed_bodies.ParallelRays] | None:
    """Return samples of a body's underside, and rays through the samples down to the solids `rows`.

    `posed` is the body, and `tolerance` the largest gap in m. The result is None if the body has no
    underside above these solids.

    Returns
    -------
    tuple
        Samples (n,), the height (n,) above each sample at which its ray starts, and the rays.
    """
    solids, up, metres = around.solids, around.up, around.metres
    reach = np.abs(up) * DEPTH + tolerance
    # Only the part within the body's bounds counts: the result does not depend on a floor's size.
    area_lo = np.maximum((solids.lo[rows] * metres - reach).min(axis=0), posed.lo)
    area_hi = np.minimum((solids.hi[rows] * metres + reach).max(axis=0), posed.hi)
    bounds = [area_lo, area_hi, up]
    if posed.underside is None or not unchanged(posed.underside[0], bounds):
        found = underside(posed.triangles, posed.closed, up, area_lo, area_hi)
        posed.underside = bounds, found, _height_above(posed, found.points, up)
        posed.gaps.clear()
        posed.down = None
    _, samples, height = posed.underside
    if not len(samples.points):
        return None
    if posed.down is None or posed.down[0] != tolerance:
        starts = samples.points + up * height[:, None]
        posed.down = tolerance, posed_bodies.ParallelRays(starts, -up, height + tolerance)
    return samples, height, posed.down[1]


def _nearest_below(
    around: Surroundings,
    tolerance: float,
    posed: PosedBody,
    down: posed_bodies.ParallelRays,
    rows: Rows,
) -> tuple[Array, NDArray[np.int64]]:
    """Return the distances (n,) that rays go down to the nearest solid, and its number (n,).

    `posed` is the body from which the rays `down` start, and `rows` are the rows of the solids.
    `tolerance` is the largest gap in m.
    """
    ranges, numbers = down.length.copy(), np.full(len(down.length), NOTHING, np.int64)
    for row in rows.tolist():
        solid = around.solids.solids[row]
        version = int(around.solids.version[row]), tolerance
        known = posed.gaps.get(solid.number)
        if known is None or known[0] != version:
            known = posed.gaps[solid.number] = (
                version,
                down.hit_distances(_upper_side(around, solid)),
            )
        nearer = known[1] < ranges
        ranges[nearer], numbers[nearer] = known[1][nearer], solid.number
    return ranges, numbers


def _passed_on(
    around: Surroundings, points: Array, tolerance: float, layers: _Layers
) -> NDArray[np.int64]:
    """Return the numbers (n,) of the bearers to which weights pass on, or NOTHING.

    Weights go straight down from `points` (n, 3), in m, on covers. They pass through gaps of up to
    `tolerance` m, and below an open surface through DEPTH: a sheet that stands for a duvet has no
    thickness of its own.
    """
    up, solids = around.up, around.solids
    reached = np.full(len(points), NOTHING, np.int64)
    starts = points + SKIN * up
    far = np.full(len(points), THICKEST)
    rays = posed_bodies.ParallelRays(starts, -up, far)
    for row in layers.bearers.tolist():
        ranges = rays.hit_distances(_upper_side(around, solids.solids[row]))
        nearer = ranges < far
        far[nearer], reached[nearer] = ranges[nearer], solids.solids[row].number
    below = np.flatnonzero(reached != NOTHING)
    if not len(below):
        return reached
    rays = posed_bodies.ParallelRays(starts[below], -up, far[below])
    parts = []
    for row in layers.covers.tolist():
        solid = solids.solids[row]
        ray, depth, out = rays.hits(around.surfaces.of(around.depsgraph, solid, around.metres))
        facing = around.surfaces.facing(around.depsgraph, solid, around.metres)
        # Two triangles at whose common edge a ray hits are one hit.
        _, once = np.unique(np.column_stack([ray, depth, out > 0.0]), axis=0, return_index=True)
        parts.append((ray[once], depth[once], -facing * np.sign(out[once])))
    ray, depth, enters = (np.concatenate(values) for values in zip(*parts, strict=True))
    reached[below[_has_gap(ray, depth, enters, far[below], tolerance)]] = NOTHING
    return reached


def _has_gap(
    ray: NDArray[np.intp], depth: Array, enters: Array, far: Array, tolerance: float
) -> NDArray[np.bool_]:
    """Return whether each of n rays crosses a gap that is too wide for a weight to pass.

    Parameters
    ----------
    ray, depth, enters
        The hits (k,) of the rays: the index of the ray, its distance in m, and 1 where the ray
        enters a closed surface, −1 where it leaves one, 0 at an open surface.
    far
        The distances (n,) in m at which the rays end.
    tolerance
        The widest gap in m, except below open surfaces.
    """
    order = np.lexsort((depth, ray))
    ray, depth, enters = ray[order], depth[order], enters[order]
    begin = np.searchsorted(ray, np.arange(len(far)))
    place = np.arange(len(ray)) - begin[ray]
    shape = len(far), int(place.max(initial=-1)) + 2
    # The rest of each row is the end of the ray, so the last gap is empty.
    depths = np.repeat(far[:, None], shape[1], axis=1)
    turns, widest = np.zeros(shape), np.full(shape, tolerance)
    depths[ray, place], turns[ray, place] = depth, enters
    widest[ray[enters == 0.0], place[enters == 0.0]] = DEPTH
    layers = np.cumsum(turns, axis=1)
    # A ray that leaves a surface which it has not entered began inside.
    layers -= np.minimum(np.minimum.accumulate(layers, axis=1), 0.0)
    gaps = np.diff(depths, axis=1, append=far[:, None])
    open_air: NDArray[np.bool_] = np.logical_or.reduce((layers <= 0.0) & (gaps > widest), axis=1)
    return open_air


def _upper_side(around: Surroundings, solid: Solid) -> posed_bodies.Triangles:
    """Return the triangles of a solid on which other bodies can lie.

    For a closed animated body these are only the triangles that face up. With the others, a cushion
    would hang on the person who has sunk into it.
    """
    depsgraph, bodies = around.depsgraph, around.bodies
    found = around.surfaces.of(depsgraph, solid, around.metres)
    other = bodies.by_key.get(bodies.of_solid[solid.number])
    if other is None or not other.animated:
        return found
    if not other.is_closed([part.geometry.triangles(depsgraph) for part in other.solids]):
        return found
    chosen = looks_up(found.corners, around.up)
    return posed_bodies.Triangles(found.corners[chosen], found.lo[chosen], found.hi[chosen])


def _height_above(posed: PosedBody, points: Array, up: Array) -> Array:
    """Return how far (n,) the body extends above each of `points` (n, 3), in m.

    Rays down must start within that height, so that they start inside the body.
    """
    length = np.full(len(points), DEPTH)
    if not len(points):
        return length
    far = posed_bodies.hit_distances(
        posed_bodies.with_bounds(posed.triangles), points + up * SKIN, up, length
    )
    return np.minimum(far, length)


def _by_support(
    solids: Solids,
    bodies: ContactBodies,
    points: Array,
    below: Array,
    areas: Array,
    numbers: NDArray[np.int64],
) -> list[Support]:
    """Return one support for each body below an underside, and one for the ground.

    Parameters
    ----------
    solids, bodies
        The solids of the scene, and the bodies to which they belong.
    points
        Points (n, 3) on the underside, in m.
    below
        Points (n, 3) in m that the rays from `points` hit.
    areas
        Areas (n,) in m² that the points represent, times their `firmness`. This factor falls with
        the gap between the point and the hit surface, as in an elastic layer.
    numbers
        Numbers (n,) of the hit solids.
    """
    found: dict[Key, NDArray[np.bool_]] = {}
    ground = []
    known = {solid.number: solid for solid in solids.solids}
    for number in np.unique(numbers[areas > 0.0]).tolist():
        key = bodies.of_solid.get(number, GROUND)
        mask = (numbers == number) & (areas > 0.0)
        found[key] = found[key] | mask if key in found else mask
        if key == GROUND:
            places, own = clustered(below[mask], areas[mask])
            share = float(own.sum() / areas.sum())
            ground.append(BareSurface(known[number].original.name, number, places, share))
    return [
        Support(key, *clustered(points[mask], areas[mask]), tuple(ground) if key == GROUND else ())
        for key, mask in found.items()
    ]
