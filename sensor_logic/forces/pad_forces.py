# SPDX-License-Identifier: GPL-3.0-or-later
"""The forces on one pressure pad.

They follow from the balance of all bodies that rest on the pad, directly or through other bodies.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from ..arrays import Array
from ..logs.wording import percent
from .balance import GROUND, Balance, Joint, Load, Points, balance
from .covered import ALIGNED
from .directions import FLAT
from .island import (
    Group,
    Island,
    collect,
    gaps,
    moving_node,
    points_of,
    points_on_pad,
    shape_groups,
    standing_groups,
)
from .shapes import Shape, perpendiculars
from .world import Constraint, Key, PadForces, Partner, RequiredLoad, World

# The contact points of stiff bodies that touch, even if heights differ very little.
#
# The physics engine leaves a simulated body slightly tilted or above its supports, whose heights
# are exact. So the bodies are first lowered as far as their contacts allow, with very stiff
# springs. Then there is no gap to the supports, but there is one to a floor half a millimetre below
# a pad.

# In m. The largest gap of a touching point once the bodies have settled, and the same for a moving
# body, whose contacts shift within a frame.
TOUCHING, MOVING = 2e-5, 3e-4
# In m. Surfaces whose heights differ by less count as level. With a larger difference, up to
# UNCERTAIN times TOUCHING, it is uncertain which surface carries a body at rest.
LEVEL, UNCERTAIN = 1e-6, 4.0
# The rounding error of positions in single precision, per metre of distance from the origin.
ROUNDING = 4.0 * 2.0**-24
# In m. The mean indentation of the stiff springs.
INDENTATION = 1e-6
# The slack of points that do not touch, in mean indentations.
OFF = 1e4


@dataclass(frozen=True)
class Settled:
    """The result of `settled`: contact points after the bodies were lowered onto their supports.

    Attributes
    ----------
    points
        The points. The slack is 0 for points that touch, and large for the others.
    level
        The height difference (n,) in m up to which the supports at each point count as level.
    uncertain
        The height difference (n,) in m up to which it is uncertain which support carries the body.
    converged
        Whether the solver converged.
    """

    points: Points
    level: Array
    uncertain: Array
    converged: bool = True


def settled(
    loads: Sequence[Load], points: Points, gaps: Array, joints: Sequence[Joint] = ()
) -> Settled:
    """Lower the bodies onto their supports, and return the contact points with their new slack.

    `gaps` (n,) in m are the distances between the bodies in their present poses. They are NaN for
    points that always touch.
    """
    moves = np.array([*(load.softness[3:].any() for load in loads), False], bool)
    moves = moves[points.a] | moves[points.b]
    rounding = ROUNDING * np.abs(np.einsum("ni,ni->n", points.places, points.normals))
    uncertain = np.where(moves, MOVING, UNCERTAIN * TOUCHING) + UNCERTAIN * rounding
    known = np.isfinite(gaps)
    if not known.any() or np.ptp(gaps[known]) <= TOUCHING / 4.0:
        return Settled(points, LEVEL + rounding, uncertain)
    slack = np.where(known, gaps, 0.0) / INDENTATION
    stiff = replace(points, stiffness=np.ones(len(gaps)), slack=slack)
    found = balance(loads, stiff, joints)
    left = -INDENTATION * found.depths
    limits = np.where(moves, MOVING, TOUCHING) + rounding
    slack = np.where(known & (left > limits), OFF, 0.0)
    return Settled(replace(points, slack=slack), LEVEL + rounding, uncertain, found.settled)


def height_between(one: Shape, two: Shape, places: Array, normal: Array) -> float:
    """Return the largest height difference in m between the faces of two shapes at `places` (n, 3).

    The face of a shape is the one with the outward normal `normal` (3,), extended beyond its edges.
    Return inf if a shape has no such face.
    """
    heights = []
    for shape in (one, two):
        facing = shape.normals @ normal
        if not len(facing) or facing.max() < FLAT:
            return math.inf
        face = int(facing.argmax())
        from_places = shape.vertices[shape.faces[face][0]] - places
        heights.append(from_places @ shape.normals[face] / facing[face] + shape.radius)
    return float(np.abs(heights[0] - heights[1]).max())


# The largest share of a body's required load that its contacts may leave unexplained.
RESIDUAL = 0.02
# Residuals are shares of the required force, or of this share of the weight if that is more.
LEAST_NEED = 0.2
# An animated body that requires less than this share of its weight is in free fall.
LEAST_WEIGHT = 0.05
# The same for a body without weight, as a share of the total load of the island, which such a body
# can transmit.
LEAST_SHARE = 1e-3
# The factor of moments in the residual of a body whose `softness` is not 0 for moments.
BLURRED = 0.1
# In m. An unsupported weight this near to the side of a pad, or above it, may belong on the pad.
BESIDE, ABOVE = 0.25, 2.0
# Stiffness factors of joints. If the pad's force differs between them, it is unknown.
SOFT_JOINT, HARD_JOINT = 1e-3, 1e3
TINY = 1e-12
SHARE_KNOWN = 0.02


@dataclass
class _Attempt:
    """The bodies that one search for contacts connects with the pad, and the forces on them.

    Attributes
    ----------
    residuals
        For each body, the fraction of its required load that no contact provides.
    undecided, unresolved
        Why the forces are uncertain, or empty: because of constraints, or of heights.
    """

    island: Island
    groups: list[Group]
    balance: Balance | None
    residuals: dict[Key, float]
    converged: bool = True
    undecided: str = ""
    unresolved: str = ""

    @property
    def worst(self) -> float:
        return max(self.residuals.values(), default=0.0)


def pad_forces(pad: Key, world: World) -> PadForces:
    """Return the forces on the pad with the key `pad`."""
    problem = _unsupported_weight(pad, world)
    if problem:
        return PadForces(problem=problem, usable=False)
    attempt = _attempt(pad, world, {}, 0)
    if attempt.worst > RESIDUAL:
        attempt = _search_wider(pad, world, attempt)
    return _result(pad, world, attempt)


def _unsupported_weight(pad: Key, world: World) -> str:
    """Return a problem text if a body near the pad has a weight but no support, else ""."""
    for key in world.animated_near(pad, BESIDE, ABOVE):
        required = world.required_load(key)
        heavy = required.load.wrench[:3] @ world.up > LEAST_WEIGHT * required.mass * world.gravity
        if heavy and not world.supports_of(key):
            return f"nothing supports '{world.node(key).name}', so its weight cannot be computed"
    return ""


def _search_wider(pad: Key, world: World, attempt: _Attempt) -> _Attempt:
    """Return the best of `attempt` and of attempts with a wider search for contacts.

    A body may have touched another one between two frames. So each body with an unexplained load is
    searched as far around as it moves in a frame. This is tried in this frame, the next and the
    previous one.
    """
    best = attempt
    reach = {
        key: 1.2 * world.required_load(key).reach
        for key, residual in attempt.residuals.items()
        if residual > RESIDUAL
    }
    for when in (0, 1, -1):
        tried = _attempt(pad, world, reach, when)
        if tried.worst < 0.9 * best.worst:
            best = tried
    return best


def _attempt(pad: Key, world: World, reach: dict[Key, float], when: int) -> _Attempt:
    island = collect(pad, world, reach, when)
    groups = shape_groups(pad, island, world) + standing_groups(island, world)
    if not island.bodies:
        return _Attempt(island, groups, None, {})
    order = {key: index for index, key in enumerate(island.bodies)}
    loads = [_load(world.required_load(key), when) for key in island.bodies]
    joints = [_joint(link, order, 1.0) for link in island.constraints]
    lying = settled(loads, points_of(groups, order, world), gaps(groups), joints)
    points = lying.points
    found = balance(loads, points, joints)
    whole = sum(float(np.linalg.norm(load.wrench[:3])) for load in loads)
    least = max(LEAST_SHARE * whole, TINY)
    residuals = {
        key: _residual(world, key, found.missing[index], least) for key, index in order.items()
    }
    attempt = _Attempt(island, groups, found, residuals, found.settled and lying.converged)
    attempt.unresolved = _height_uncertainty(pad, world, attempt, lying)
    if island.constraints:
        attempt.undecided = _joint_uncertainty(pad, attempt, loads, points, order)
    return attempt


def _load(required: RequiredLoad, when: int) -> Load:
    return replace(required.load, centre=required.centres[1 + when])


def _residual(world: World, key: Key, missing: Array, least: float) -> float:
    """Return the fraction of a body's required load that its contacts do not provide.

    `missing` (6,) is the part of the wrench that they do not provide. The required load counts as
    at least `least` newtons. For an animated body only the vertical force counts, because its
    muscles exert the rest.
    """
    required = world.required_load(key)
    least = max(LEAST_NEED * required.mass * world.gravity, least)
    force = required.load.wrench[:3]
    if world.node(key).animated:
        return abs(float(missing[:3] @ world.up)) / max(abs(float(force @ world.up)), least)
    moment = float(np.linalg.norm(missing[3:])) / required.load.size
    if required.load.softness[3:].any():
        moment *= BLURRED
    left = float(np.linalg.norm(missing[:3])) + moment
    return left / max(float(np.linalg.norm(force)), least)


def _joint(link: Constraint, order: dict[Key, int], stiffness: float) -> Joint:
    ends = [GROUND if key is None else order.get(key, GROUND) for key in (link.one, link.two)]
    return Joint(ends[0], ends[1], link.place, link.forces, link.moments, stiffness)


def _joint_uncertainty(
    pad: Key, attempt: _Attempt, loads: Sequence[Load], points: Points, order: dict[Key, int]
) -> str:
    """Return a problem text if the pad's force depends on the stiffness of constraints, else ""."""
    on_pad = points_on_pad(pad, attempt.groups)
    totals = []
    for stiffness in (SOFT_JOINT, HARD_JOINT):
        joints = [_joint(link, order, stiffness) for link in attempt.island.constraints]
        found = balance(loads, points, joints)
        attempt.converged &= found.settled
        totals.append(np.abs(found.forces[on_pad]).sum())
    if abs(totals[0] - totals[1]) <= SHARE_KNOWN * max(totals):
        return ""
    names = ", ".join(f"'{link.name}'" for link in attempt.island.constraints)
    return f"the share of the weight that the rigid-body constraints carry is unknown: {names}"


def _height_uncertainty(pad: Key, world: World, attempt: _Attempt, lowered: Settled) -> str:
    """Return a problem text if it is uncertain how much of a weight the pad carries, else "".

    It is uncertain if a body rests on the pad and on a fixed surface of nearly, but not exactly,
    the same height. `lowered` is the result of `settled`.
    """
    assert attempt.balance is not None
    sides = []
    start = 0
    for group in attempt.groups:
        part = slice(start, start := start + len(group.places))
        pressed = float(np.linalg.norm(attempt.balance.forces[part], axis=1).sum())
        for body, under, below, sign in (
            (group.a, group.b, group.shapes[1:], 1.0),
            (group.b, group.a, group.shapes[:1], -1.0),
        ):
            if below and moving_node(world.node(body), world).weighs:
                sides.append((body, under, below[0], group, sign, part, pressed))
    for body, under, shape, group, sign, part, pressed in sides:
        for same, other, beside, along, turn, _, pressed_by in sides if under == pad else ():
            normal = sign * group.normals[0]
            if same != body or other == pad or world.node(other).weighs:
                continue
            if turn * along.normals[0] @ normal < ALIGNED:
                continue
            step = height_between(shape, beside, group.places, normal)
            shared = min(pressed, pressed_by) > SHARE_KNOWN * max(pressed, pressed_by)
            if shared and lowered.level[part].max() < step < lowered.uncertain[part].max():
                return (
                    f"'{world.node(pad).name}' and '{world.node(other).name}' differ in height by "
                    f"{1000.0 * step:.1g} mm, too little to tell how they share the weight of "
                    f"'{world.node(body).name}': make the pad thicker, or level with it"
                )
    return ""


def _result(pad: Key, world: World, attempt: _Attempt) -> PadForces:
    problems = [world.required_load(key).problem for key in attempt.island.bodies]
    problems = [*problems, attempt.undecided, attempt.unresolved]
    if attempt.balance is None:
        return PadForces()
    found: dict[Key, list[tuple[Array, Array, Array]]] = {}
    start = 0
    for group in attempt.groups:
        forces = attempt.balance.forces[start : start + len(group.places)]
        start += len(group.places)
        if group.a == pad:
            found.setdefault(group.b, []).append((group.places, forces, group.areas))
        elif group.b == pad:
            found.setdefault(group.a, []).append((group.places, -forces, group.areas))
    partners = []
    for key, parts in found.items():
        node = world.node(key)
        places, forces, areas = (np.concatenate(side) for side in zip(*parts, strict=True))
        area = float(areas[forces.any(axis=1)].sum())
        partners.append(Partner(node.name, node.objects, places, forces, area))
    if attempt.worst > RESIDUAL:
        worst = max(attempt.residuals, key=attempt.residuals.__getitem__)
        problems.append(
            f"the contacts of '{world.node(worst).name}' explain only "
            f"{percent(max(0.0, 1.0 - attempt.worst))} of its motion and weight"
        )
    elif not attempt.converged:
        problems.append("the computation of the contact forces did not converge")
    problem = next((problem for problem in problems if problem), "")
    bodies = len(attempt.island.bodies)
    return PadForces(tuple(partners), attempt.worst, problem, not problem, bodies)


# The supports of a stiff body's feet: a pad higher than the floor carries a whole leg.

Mask = npt.NDArray[np.bool_]
# In m. Parts of an underside farther apart than about this are separate feet.
APART = 0.05
DIRECTIONS = 32


def held_by_pads(points: Array, gaps: Array, areas: Array, on_pad: Mask, up: Array) -> Array:
    """Return the areas (n,) in m² of an underside's points, with whole legs assigned to pads.

    A leg can stand on a pad that is smaller than the leg and higher than the floor around it. If
    the pad is beneath the middle of the leg, the pad carries the whole leg, because the other legs
    keep the body upright. The points on the pad then get the area of the leg's other points, whose
    area becomes 0. A body with a single foot keeps its areas: it may be a cushion, which sinks to
    the floor.

    Parameters
    ----------
    points
        The points (n, 3) in m.
    gaps
        Their gaps (n,) in m above their supports.
    areas
        Their areas (n,) in m².
    on_pad
        Whether each point (n,) is above a pad.
    up
        The direction (3,) upwards.
    """
    held = areas.copy()
    axes = np.stack(perpendiculars(up))
    seen = points @ axes.T
    feet = _feet(seen, max(APART, 2.0 * float(np.sqrt(areas.mean()))))
    for foot in range(int(feet.max()) + 1 if feet.any() else 0):
        on_foot = feet == foot
        pad = on_foot & on_pad
        if not pad.any():
            continue
        lower = on_foot & ~on_pad & (gaps > gaps[pad].min() + TOUCHING)
        middle = areas[on_foot] @ seen[on_foot] / areas[on_foot].sum()
        # Each point represents the area around it.
        around = 0.75 * float(np.sqrt(areas[on_foot].mean()))
        if lower.any() and _is_in_hull(seen[pad], middle, around):
            held[pad] *= 1.0 + areas[lower].sum() / areas[pad].sum()
            held[lower] = 0.0
    return held


def _is_in_hull(places: Array, place: Array, around: float) -> bool:
    """Return whether `place` (2,) is in the convex hull of `places` (n, 2).

    The hull is extended by `around`.
    """
    angles = np.arange(DIRECTIONS) * 2.0 * np.pi / DIRECTIONS
    ways = np.stack([np.cos(angles), np.sin(angles)])
    return bool((((places - place) @ ways).max(axis=0) > -around).all())


def _feet(points: Array, apart: float) -> npt.NDArray[np.intp]:
    """Return the index (n,) of the foot that each point (n, 2) belongs to.

    Points belong to the same foot if they are in the same or in neighbouring cells, `apart` m wide.
    """
    cells = np.floor(points / apart).astype(int)
    left = {tuple(cell) for cell in cells.tolist()}
    number: dict[tuple[int, ...], int] = {}
    foot = 0
    while left:
        waiting = [left.pop()]
        while waiting:
            cell = waiting.pop()
            number[cell] = foot
            beside = {(cell[0] + i, cell[1] + j) for i in (-1, 0, 1) for j in (-1, 0, 1)} & left
            left -= beside
            waiting += beside
        foot += 1
    return np.array([number[tuple(cell)] for cell in cells.tolist()], np.intp)
