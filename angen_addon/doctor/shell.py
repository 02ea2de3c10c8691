# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of a home's size, and of what rays pass where a wall should be."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from ...sensor_logic.model import Array
from ...sensor_logic.wording import named
from ..scene.rays.caster import NOTHING
from ..scene.rays.solids import SURFACE_TYPES
from .examined import Examined, Found

# m: no home is larger than the first, with half of its things larger than the second; none is
# smaller than the third.
LARGE, LARGE_THINGS = 100.0, 8.0
SMALL, SMALL_THINGS = 3.0, 0.1
# m: how large a home is about, and half of the things in it.
USUAL, USUAL_THING = 12.0, 1.0
# m: what is longer and thinner than this, and higher than that, is a wall; where nothing is higher
# than the last, nobody walks upright between them.
WALL_LONG, WALL_THIN, WALL_HIGH, LOW = 1.5, 0.4, 0.3, 1.9
UPRIGHT = 2.4
# Metres in what files are often drawn in.
UNITS = {"millimetres": 0.001, "centimetres": 0.01, "inches": 0.0254, "feet": 0.3048}
# Files in these are rarer than in metric units: by so much the size must speak for them.
RARE = {"inches": 1.5, "feet": 1.5}
BUNDLE = -40
WAYS = 600
# Of all ways from a sensor, so many lead out of a home that is open somewhere: an open door or a
# window without a pane is less.
OPEN = 0.08
SIDES = ("+X", "-X", "+Y", "-Y", "above", "below")


def scale(home: Examined) -> Iterator[Found]:
    """A home that is some 100 times too large or too small, or too low to walk in."""
    lo, hi = home.home.lo, home.home.hi
    there = np.isfinite(lo).all(axis=1) & np.isfinite(hi).all(axis=1)
    if not there.any():
        return
    sizes = (hi - lo)[there].max(axis=1)
    whole = float((hi[there].max(axis=0) - lo[there].min(axis=0)).max())
    things = float(np.median(sizes))
    large = whole > LARGE and things > LARGE_THINGS
    small = whole < SMALL / 2 or (whole < SMALL and things < SMALL_THINGS)
    if not (large or small):
        yield from _low_walls(home, (hi - lo)[there])
        return
    much = "large" if large else "small"
    yield (
        f"The home is too {much}: {_length(whole)} from end to end, and half of its things are "
        f"{'larger' if large else 'smaller'} than {_length(things)}",
        _other_unit(home.metres, whole, things, large),
    )


def _low_walls(home: Examined, size: Array) -> Iterator[Found]:
    """A home at half its size, as games' files often are; by the sizes (n, 3) of its things."""
    along, across = size[:, :2].max(axis=1), size[:, :2].min(axis=1)
    walls = (along > WALL_LONG) & (across < WALL_THIN) & (size[:, 2] > WALL_HIGH)
    highest = float(size[walls, 2].max(initial=0.0))
    if walls.sum() > 1 and size[:, 2].max() < LOW:
        yield (
            f"The walls are no higher than {_length(highest)}: nobody walks upright between them",
            f"Scale all of it up {UPRIGHT / highest:.2g} times under one empty, or set Unit Scale "
            f"to {home.metres * UPRIGHT / highest:.2g} (Scene tab, Units)",
        )


def _length(metres: float) -> str:
    return f"{metres:.3g} m" if metres >= 0.1 else f"{metres * 1000:.3g} mm"


def _other_unit(metres: float, whole: float, things: float, large: bool) -> str:
    if large:
        unit = min(UNITS, key=lambda name: _unlikely(name, whole, things))
        return (
            f"If it was drawn in {unit}, set Unit Scale to {metres * UNITS[unit]:g} (Scene tab, "
            "Units), or scale all of it down by that and apply the scale"
        )
    factor = 10.0 ** round(math.log10(1.0 / things)) if things > 0.0 else 100.0
    return (
        f"Set Unit Scale to {metres * factor:g} (Scene tab, Units), or scale all of it up "
        f"{factor:g} times and apply the scale"
    )


def _unlikely(unit: str, whole: float, things: float) -> float:
    """How far a home drawn in this unit, of that length and with half of its things below the other
    one, is from a usual home."""
    size = math.log(whole * UNITS[unit] / USUAL) ** 2
    return size + math.log(things * UNITS[unit] / USUAL_THING) ** 2 + RARE.get(unit, 0.0)


def hidden_but_rendered(home: Examined) -> Iterator[Found]:
    """What pictures show and sensors do not meet."""
    hidden = [
        obj.name
        for obj in home.view_layer.objects
        if obj is not None
        and obj.type in SURFACE_TYPES
        and not (obj.hide_render or obj.angen_ignored)
        and not obj.visible_get(view_layer=home.view_layer)
    ]
    if hidden:
        yield (
            "Hidden from the viewport but rendered, so that no sensor meets it: "
            f"{named(sorted(hidden))}",
            "Show it (eye or monitor icon in the Outliner, of its collection too), or hide it from "
            "renders as well (camera icon)",
        )


def without_faces(home: Examined) -> Iterator[Found]:
    """Meshes of edges alone."""
    bare = []
    for obj in home.shown():
        if obj.type == "MESH" and not obj.is_instancer:
            mesh = obj.evaluated_get(home.depsgraph).data
            makes_more = any(m.type in {"NODES", "PARTICLE_SYSTEM"} for m in obj.modifiers)
            if len(mesh.edges) and not len(mesh.polygons) and not makes_more:
                bare.append(obj.name)
    if bare:
        yield (
            f"No faces, so that every ray passes: {named(sorted(bare))}",
            "Fill the edges with faces (Edit Mode, F), or tick Ignored by sensors if it is a mark",
        )


def holes(home: Examined) -> Iterator[Found]:
    """Rooms that rays leave without meeting anything."""
    ways = _all_ways()
    open_to: dict[str, list[str]] = {}
    for sensor in [s for s in home.sensors if s.kind.in_room]:
        origin = np.array(sensor.world_matrix(home.depsgraph).translation, np.float64)
        origins = np.tile(origin, (len(ways), 1))
        far = np.full(len(ways), _reach(home, origin))
        met = home.home.caster.cast_met(sensor.uid, BUNDLE, origins, ways, far)[1]
        out = met == NOTHING
        if out.mean() > OPEN:
            open_to.setdefault(_side(ways[out]), []).append(sensor.name)
    for side, sensors in open_to.items():
        place = side if side in {"above", "below"} else f"towards {side}"
        yield (
            f"The room is open {place}, seen from {named(sensors)}: rays leave the home there",
            "Close it with faces: a ceiling, a floor, panes in windows; or show what closes it",
        )


def _all_ways() -> Array:
    """(n, 3): unit vectors in all directions, evenly."""
    at = np.arange(WAYS) + 0.5
    up = 1.0 - 2.0 * at / WAYS
    turn = np.pi * (1.0 + math.sqrt(5.0)) * at
    level = np.sqrt(1.0 - up * up)
    return np.stack([np.cos(turn) * level, np.sin(turn) * level, up], axis=1)


def _reach(home: Examined, origin: Array) -> float:
    """Blender units beyond which there is nothing."""
    lo, hi = home.home.caster.solids.lo, home.home.caster.solids.hi
    there = np.isfinite(lo).all(axis=1) & np.isfinite(hi).all(axis=1)
    if not there.any():
        return 1.0
    corners = np.concatenate([lo[there], hi[there]])
    return 2.0 * float(np.abs(corners - origin).max()) + 1.0


def _side(ways: Array) -> str:
    """Where most of the ways lead."""
    axis = np.abs(ways).argmax(axis=1)
    counts = [
        int(((axis == number // 2) & ((ways[:, number // 2] < 0) == bool(number % 2))).sum())
        for number in range(6)
    ]
    return SIDES[int(np.argmax(counts))]
