# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of a building: its size, openings in its walls, doors, files and names."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator
from typing import Any

import numpy as np

from ...sensor_logic.kind import LIGHT
from ...sensor_logic.logs.wording import capital, named
from ...sensor_logic.model import Array
from ..advice import lacking
from ..advice import sensing as advice
from ..scene.animation import motion_paths
from ..scene.instances import chain
from ..scene.rays.caster import NOTHING
from ..scene.rays.solids import SURFACE_TYPES, invertible
from .examined import Examined, Found

# m. A home is too large if it and its median object are larger than this, and too small if both are
# smaller.
LARGE, LARGE_THINGS = 100.0, 8.0
SMALL, SMALL_THINGS = 3.0, 0.1
# m. The usual length of a home, of the median object in it, and of a door and a room upright.
USUAL, USUAL_THING = 12.0, 1.0
USUAL_DOOR, USUAL_ROOM = 2.05, 2.5
# m. Doors or rooms higher than this belong to a home that is too large.
HIGH_DOOR, HIGH_ROOM = 4.5, 5.5
# m. The usual height of rooms, and the least fraction of the floor on which a home has it.
ROOMS, ROOMS_SHARE = (1.9, 4.0), 0.25
# Vertical lines through the home: as many along each axis, and the most faces on one. Nothing
# higher than SKY m is a part of a home of other size, nor a gap of less than LEAST_GAP m a room.
LINES, FACES, SKY, LEAST_GAP = 24, 16, 60.0, 1.0
# The share of the lines on which a home with ceilings has a gap.
COVERED = 0.4
# Two faces of a solid are nearer to each other than this share of its width: those of a slab.
SLAB = 1.0 / 12.0
# m. An object that is longer, thinner and higher than this is a wall. If all objects are lower than
# LOW, nobody can walk upright between the walls.
WALL_LONG, WALL_THIN, WALL_HIGH, LOW = 1.5, 0.4, 0.3, 1.9
UPRIGHT = 2.4
# Metres in other units that files often have.
UNITS = {"millimetres": 0.001, "centimetres": 0.01, "inches": 0.0254, "feet": 0.3048}
# The same for a home that is ten times too large.
TENTHS = "tenths of a metre"
# The penalty that `_unit_penalty` adds for units in which homes are rarely drawn.
RARE = {"inches": 1.5, "feet": 1.5}
BUNDLE, BUNDLE_HIGH = -40, -45
DIRECTIONS = 600
# A room is open if more than this fraction of the directions from a sensor lead out of the home. An
# open door, or a window without a pane, is a smaller fraction.
OPEN = 0.08
SIDES = ("+X", "-X", "+Y", "-Y", "above", "below")


def scale(home: Examined) -> Iterator[Found]:
    """Yield a finding if the home is too large or small, or too low to walk in."""
    # Of a home that is only a scan, surfaces are no more than what was added to it.
    scans = [bounds for one in home.bare for bounds in one.bounds]
    lo = np.concatenate([home.home.lo, *(bounds[:1] for bounds in scans)])
    hi = np.concatenate([home.home.hi, *(bounds[1:] for bounds in scans)])
    is_finite = np.isfinite(lo).all(axis=1) & np.isfinite(hi).all(axis=1)
    if not is_finite.any():
        return
    sizes = (hi - lo)[is_finite].max(axis=1)
    whole = float((hi[is_finite].max(axis=0) - lo[is_finite].min(axis=0)).max())
    things = float(np.median(sizes))
    large = whole > LARGE and things > LARGE_THINGS
    small = whole < SMALL / 2 or (whole < SMALL and things < SMALL_THINGS)
    too = (
        f"The home is too large: {_length(whole)} from end to end, and half of its objects are "
        f"larger than {_length(things)}"
        if large
        else f"The home is too small: {_length(whole)} from end to end, and half of its objects "
        f"are smaller than {_length(things)}"
    )
    sky = np.inf if large else SKY
    high = _too_high(home, (hi - lo)[is_finite], sky) if not small else None
    if high is not None:
        part, height, usual = high
        unit = min((*UNITS, TENTHS), key=lambda name: abs(math.log(_factor(name) * height / usual)))
        said = f"The home is too large: its {part} are {_length(height)} high"
        yield too if large else said, _smaller(home, unit)
    elif large:
        unit = min(UNITS, key=lambda name: _unit_penalty(name, whole, things))
        yield too, _smaller(home, unit)
    elif small:
        yield too, _larger(home, things)
    else:
        yield from _low_walls(home, (hi - lo)[is_finite])


def _factor(unit: str) -> float:
    return UNITS.get(unit, 0.1)


def _too_high(home: Examined, size: Array, sky: float) -> tuple[str, float, float] | None:
    """Return which part of a home is too high, its height and its usual height in m; or None.

    `size` (n, 3) is the size of each object in m. What is higher than `sky` (m) is no part of it.
    """
    if next(leaves(home), None) is not None:
        return None
    doors = [float(np.sort(size)[-1]) for obj, size in _doors(home) if _is_upright(size)]
    if doors and np.median(doors) > HIGH_DOOR:
        return "doors", float(np.median(doors)), USUAL_DOOR
    rooms, share = _room_heights(home, sky)
    if share > COVERED:
        high = float(np.median(rooms)) if len(rooms) else 0.0
        return ("rooms", high, USUAL_ROOM) if high > HIGH_ROOM else None
    # Without ceilings, the walls tell.
    along, across = size[:, :2].max(axis=1), size[:, :2].min(axis=1)
    is_wall = (along > size[:, 2] / 3.0) & (across < size[:, 2] / 6.0) & (size[:, 2] > WALL_HIGH)
    walls = size[is_wall, 2]
    high = float(np.median(walls)) if len(walls) > 1 else 0.0
    return ("walls", high, USUAL_ROOM) if high > HIGH_ROOM else None


def _is_upright(size: Array) -> bool:
    """Return whether a door of a size (3,) has the proportions of a leaf."""
    thick, wide, high = np.sort(size).tolist()
    return bool(thick < wide / 4.0 and 1.3 * wide < high < 4.5 * wide)


def _room_heights(home: Examined, sky: float) -> tuple[Array, float]:
    """Return the heights (n,) of rooms on vertical lines, and the share of the lines with one.

    It is the largest gap on a line between two faces that are not those of a slab. If many lines
    have one as high as usual rooms, all heights are the usual one.
    """
    lo, hi = home.home.lo / home.metres, home.home.hi / home.metres
    is_part = np.isfinite(lo).all(axis=1) & ((hi - lo)[:, 2] * home.metres < sky)
    if not is_part.any():
        return np.empty(0), 0.0
    low, high = lo[is_part].min(axis=0), hi[is_part].max(axis=0)
    steps = (np.arange(LINES) + 0.5) / LINES
    x, y = np.meshgrid(*(low[axis] + steps * (high - low)[axis] for axis in (0, 1)))
    z = np.full(x.size, high[2] + 1e-3 / home.metres)
    down = np.tile([0.0, 0.0, -1.0], (x.size, 1))
    length = np.full(x.size, float(high[2] - low[2]) + 1.0)
    solids = home.home.caster.solids.solids
    is_sky = [s.number for s in solids if not is_part[s.row]]
    numbers = np.array([s.number for s in solids])
    # Of each solid, a smaller gap between two of its faces is the thickness of a slab.
    slab = SLAB * (hi - lo)[:, :2].min(axis=1)
    by_number = np.argsort(numbers)
    above, over, gaps = np.full(x.size, np.nan), np.full(x.size, NOTHING), []
    for _ in range(FACES):
        origins = np.stack([x.ravel(), y.ravel(), z], axis=1)
        ranges, hit = home.home.caster.cast_solids(0, BUNDLE_HIGH, origins, down, length)
        is_hit = hit != NOTHING
        at = np.where(is_hit, z - ranges, np.nan)
        is_face = is_hit & ~np.isin(hit, is_sky)
        row = by_number[np.searchsorted(numbers, hit, sorter=by_number) % len(numbers)]
        is_gap = is_face & ((hit != over) | (above - at > slab[row]))
        gaps.append(np.where(is_gap, (above - at) * home.metres, np.nan))
        above, over = np.where(is_face, at, above), np.where(is_face, hit, over)
        # A millimetre below the face.
        z = np.where(is_hit, at - 1e-3 / home.metres, z)
        if not is_hit.any():
            break
    largest = np.nan_to_num(np.array(gaps)).max(axis=0)
    rooms = largest[largest > LEAST_GAP]
    share = len(rooms) / max(int(np.isfinite(above).sum()), 1)
    usual = (rooms > ROOMS[0]) & (rooms < ROOMS[1])
    return (np.full(1, USUAL_ROOM) if usual.sum() > ROOMS_SHARE * len(rooms) else rooms), share


def _low_walls(home: Examined, size: Array) -> Iterator[Found]:
    """Yield a finding if the walls have about half of a real height, as in many files for games.

    `size` (n, 3) is the size of each object in m.
    """
    along, across = size[:, :2].max(axis=1), size[:, :2].min(axis=1)
    walls = (along > WALL_LONG) & (across < WALL_THIN) & (size[:, 2] > WALL_HIGH)
    highest = float(size[walls, 2].max(initial=0.0))
    if walls.sum() > 1 and size[:, 2].max() < LOW:
        yield (
            f"The walls are no higher than {_length(highest)}, so nobody can walk upright between "
            "them",
            f"Parent the whole home to an empty and scale that {UPRIGHT / highest:.2g} times, or "
            f"{_unit_scale_of(home, f'{home.metres * UPRIGHT / highest:.2g}')}",
        )


def _length(metres: float) -> str:
    return f"{metres:.3g} m" if metres >= 0.1 else f"{metres * 1000:.3g} mm"


def _smaller(home: Examined, unit: str) -> str:
    return (
        f"If it was drawn in {unit}, {_unit_scale_of(home, f'{home.metres * _factor(unit):g}')}, "
        "or scale the whole home by that factor and apply the scale"
    )


def _larger(home: Examined, things: float) -> str:
    # A factor of 1 would change nothing, so it is at least 10.
    factor = 10.0 ** max(round(math.log10(1.0 / things)), 1) if things > 0.0 else 100.0
    return (
        f"{capital(_unit_scale_of(home, f'{home.metres * factor:g}'))}, or scale the whole home up "
        f"{factor:g} times and apply the scale"
    )


def _unit_scale_of(home: Examined, scale: str) -> str:
    """Return how to set a unit scale, which counts for nothing without a unit system."""
    if home.scene.unit_settings.system == "NONE":
        return f"set Unit System to Metric and Unit Scale to {scale} (Scene tab, Units)"
    return f"set Unit Scale to {scale} (Scene tab, Units)"


def _unit_penalty(unit: str, length: float, object_size: float) -> float:
    """Return how unlikely (0 or more) it is that the home was drawn in this unit.

    `length` is the length of the home, and `object_size` the size of its median object.
    """
    size = math.log(length * UNITS[unit] / USUAL) ** 2
    return size + math.log(object_size * UNITS[unit] / USUAL_THING) ** 2 + RARE.get(unit, 0.0)


# m. Coordinates with larger steps of single precision are too coarse for doors and beams.
STEP = 1e-3


def coarse(home: Examined) -> Iterator[Found]:
    """Yield a finding if objects are so far from the origin that their coordinates are coarse."""
    steps = {solid.name: step for solid, step in _steps(home) if np.isfinite(step) and step > STEP}
    if steps:
        names, worst = sorted(steps), max(steps.values())
        yield (
            "Objects that are so far from the origin, in the scene or in their meshes, that "
            f"Blender rounds their points to {_length(worst)}: {named(names)}",
            "Take the offset out before the import, in the program that the home is from; of an "
            "IFC file by scripts/foreign_homes/ifc_to_obj.py. Moving it here restores nothing",
            tuple(names),
        )


def _steps(home: Examined) -> Iterator[tuple[Any, float]]:
    """Yield each solid with the step in m of its coordinates in single precision.

    Of large objects, such as terrain, the point that is nearest to the origin counts. Coordinates
    that a parent or an instance takes back to the origin were rounded before.
    """
    solids = home.home.caster.solids
    origins: dict[Any, float] = {}
    for solid in solids.solids:
        size = np.linalg.norm(solids.matrix[solid.row][:3, :3], axis=0).max()
        in_mesh = _step(solid.geometry.lo, solid.geometry.hi) * size
        in_scene = _step(solids.lo[solid.row], solids.hi[solid.row])
        for over in chain(solid.original):
            if over not in origins:
                at = np.array(over.evaluated_get(home.depsgraph).matrix_world.translation)
                origins[over] = _step(at, at)
        before = max(origins[over] for over in chain(solid.original))
        yield solid, max(in_mesh, in_scene, before) * home.metres


def _step(lo: Array, hi: Array) -> float:
    """Return the step of single precision at the point of bounds (3,), (3,) nearest to zero."""
    nearest = np.where(lo * hi > 0.0, np.minimum(np.abs(lo), np.abs(hi)), 0.0)
    return float(np.spacing(nearest.max().astype(np.float32)))


def hidden_but_rendered(home: Examined) -> Iterator[Found]:
    """Yield a finding if objects are hidden in the viewport but shown in renders."""
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
            "Objects that are hidden in the viewport but shown in renders, so that no sensor sees "
            f"them: {named(sorted(hidden))}",
            "Show them and their collections (eye and monitor icons in the Outliner), or hide "
            "them in renders too (camera icon)",
            tuple(sorted(hidden)),
        )


def background_sets(home: Examined) -> Iterator[Found]:
    """Yield a finding for each background set, since no sensor sees the objects in it."""
    if home.sensors:
        yield from advice.background_sets(home.scene)


# By kind of what has no faces: its name, and how to make faces of it.
FACELESS = {
    "EDGES": ("Meshes without faces", "Fill the edges with faces (Edit Mode, F)"),
    "POINTS": (
        "Point clouds",
        "Make a mesh of the scan in the scanner's program, or by Geometry Nodes (Points to Volume, "
        "Volume to Mesh)",
    ),
    "CURVES": ("Curves without a surface", "Give them a Bevel or Extrude (Data tab, Geometry)"),
    "HAIR": ("Hair", "Put a mesh where the hair is to hide something from sensors"),
    "VOLUME": ("Volumes", "Make a mesh of it: a new mesh with the modifier Volume to Mesh"),
    "DRAWING": ("Grease pencil drawings", "Make a mesh of it (Object, Convert), and fill it"),
}


def without_faces(home: Examined) -> Iterator[Found]:
    """Yield a finding for each kind of visible objects that have no faces."""
    for kind, (what, mend) in FACELESS.items():
        bare = sorted({one.name for one in home.bare if one.kind == kind})
        if bare:
            yield (
                f"{what}, through which every ray passes: {named(bare)}",
                f"{mend}; or tick Ignored by sensors if it only marks something",
                tuple(bare),
            )


def flattened(home: Examined) -> Iterator[Found]:
    """Yield a finding if surfaces have scale 0 along an axis, because rays pass through them.

    Surfaces with keyframes of their scale are left out: they may be meant to shrink.
    """
    flat = [
        obj.name
        for obj, matrix in home.seen
        if obj.type in SURFACE_TYPES
        and np.isfinite(matrix).all()
        and not invertible(matrix)
        and not any("scale" in path for part in chain(obj) for path in motion_paths(part))
    ]
    if flat:
        yield (
            "Objects whose scale is 0 along an axis, so that rays and light pass through them: "
            f"{named(sorted(flat))}",
            "Apply the scale (Ctrl+A), which keeps the shape, or set that scale to 1 (sidebar, "
            "Item)",
        )


def holes(home: Examined) -> Iterator[Found]:
    """Yield a finding for each side, such as "above", on which rays leave rooms and the home."""
    directions = _all_directions()
    open_to: dict[str, list[str]] = {}
    for sensor in [s for s in home.sensors if s.kind.in_room]:
        origin = np.array(sensor.world_matrix(home.depsgraph).translation, np.float64)
        origins = np.tile(origin, (len(directions), 1))
        far = np.full(len(directions), _reach(home, origin))
        hit = home.home.caster.cast_solids(sensor.uid, BUNDLE, origins, directions, far)[1]
        out = hit == NOTHING
        if out.mean() > OPEN:
            open_to.setdefault(_main_side(directions[out]), []).append(sensor.name)
    for side, sensors in open_to.items():
        place = side if side in {"above", "below"} else f"towards {side}"
        yield (
            f"The room of {named(sensors)} is open {place}: rays leave the home there",
            "Close it with faces (a ceiling, a floor, panes in windows), or show the objects that "
            "close it",
            tuple(sensors),
        )


def _all_directions() -> Array:
    """Return unit vectors (n, 3) that are evenly distributed over all directions."""
    at = np.arange(DIRECTIONS) + 0.5
    up = 1.0 - 2.0 * at / DIRECTIONS
    turn = np.pi * (1.0 + math.sqrt(5.0)) * at
    level = np.sqrt(1.0 - up * up)
    return np.stack([np.cos(turn) * level, np.sin(turn) * level, up], axis=1)


def _reach(home: Examined, origin: Array) -> float:
    """Return the length (Blender units) of a ray from `origin` that ends outside the home."""
    lo, hi = home.home.caster.solids.lo, home.home.caster.solids.hi
    is_finite = np.isfinite(lo).all(axis=1) & np.isfinite(hi).all(axis=1)
    if not is_finite.any():
        return 1.0
    corners = np.concatenate([lo[is_finite], hi[is_finite]])
    return 2.0 * float(np.abs(corners - origin).max()) + 1.0


def _main_side(directions: Array) -> str:
    """Return the side, such as "above", to which most of the directions (n, 3) point."""
    axis = np.abs(directions).argmax(axis=1)
    counts = [
        int(((axis == number // 2) & ((directions[:, number // 2] < 0) == bool(number % 2))).sum())
        for number in range(6)
    ]
    return SIDES[int(np.argmax(counts))]


# Checks of doors.

WORD = re.compile(r"door|tür|tuer|dörr|porte|puerta|deur", re.IGNORECASE)
# Parts and surroundings of doors, whose names also contain the word.
PARTS = (
    "frame", "mat", "handle", "knob", "lock", "bell", "flag", "hinge", "jamb", "lining", "panel",
    "stop", "glass", "outdoor", "indoor",
)  # fmt: skip
PART = re.compile("|".join(PARTS), re.IGNORECASE)
# m. Limits of the height, width and thickness of a door's leaf.
HEIGHT, WIDTH, THICK = (1.6, 3.0), (0.4, 1.8), 0.3
# An origin is not at a hinge if its distance from the middle, relative to the width, is less.
MIDDLE = 0.3
# m. A switch that is this near to a leaf belongs to the door.
NEAR = 0.5


def leaves(home: Examined) -> Iterator[tuple[Any, Array, Array]]:
    """Yield each door leaf with its bounding box: the corners (3,) in world space, in m."""
    sizes = dict(_doors(home))
    for obj, matrix in home.seen:
        if obj not in sizes:
            continue
        thick, wide, high = np.sort(sizes[obj]).tolist()
        if not (HEIGHT[0] <= high <= HEIGHT[1] and WIDTH[0] <= wide <= WIDTH[1] and thick <= THICK):
            continue
        corners = np.array(obj.bound_box, np.float64)
        placed = (corners @ matrix[:3, :3].T + matrix[:3, 3]) * home.metres
        yield obj, placed.min(axis=0), placed.max(axis=0)


def _doors(home: Examined) -> Iterator[tuple[Any, Array]]:
    """Yield the objects that are called doors, each with its size (3,) in m."""
    for obj in dict.fromkeys(obj for obj, _ in home.seen):
        if obj.type == "MESH" and WORD.search(obj.name) and not PART.search(obj.name):
            corners = np.array(obj.bound_box, np.float64)
            yield obj, (corners.max(axis=0) - corners.min(axis=0)) * _scale(obj) * home.metres


def without_hinges(home: Examined) -> Iterator[Found]:
    """Yield a finding if door leaves would rotate about their middle instead of a hinge."""
    bad = []
    for leaf, *_ in leaves(home):
        moved = [part for part in chain(leaf) if any(motion_paths(part))]
        slides = moved and not any("rotation" in path for path in motion_paths(moved[0]))
        if not slides and _is_in_middle(leaf, moved[0] if moved else leaf, home):
            bad.append(leaf.name)
    if bad:
        yield (
            "Doors that would turn about their middle, since their origin is not at the hinge: "
            f"{named(sorted(bad))}",
            "Put the 3D cursor on the hinge's edge, then Object, Set Origin, Origin to 3D Cursor; "
            "or Fit Door with Switch, which finds the hinge",
            tuple(sorted(bad)),
        )


def standing_still(home: Examined) -> Iterator[Found]:
    """Yield a finding if no door that has a door contact or switch ever moves."""
    switches = [
        np.array(s.world_matrix(home.depsgraph).translation, np.float64) * home.metres
        for s in home.sensors
        if s.kind.publishes("opening")
    ]
    watched = [
        leaf
        for leaf, lo, hi in leaves(home)
        if any(((at >= lo - NEAR) & (at <= hi + NEAR)).all() for at in switches)
    ]
    parts = [part for leaf in watched for part in chain(leaf)]
    if watched and not any(
        part in home.moved_without_keys or any(motion_paths(part)) for part in parts
    ):
        yield (
            "Doors with a switch on them that are not animated: "
            f"{named(sorted(leaf.name for leaf in watched))}",
            "Insert keyframes of the leaf's rotation (I in the 3D view): shut, open, shut again",
            tuple(sorted(leaf.name for leaf in watched)),
        )


def _is_in_middle(leaf: Any, pivot: Any, home: Examined) -> bool:
    """Return whether the object `pivot` has its origin near the middle of the leaf's width."""
    corners = np.array(leaf.bound_box, np.float64)
    lo, hi = corners.min(axis=0), corners.max(axis=0)
    place = leaf.evaluated_get(home.depsgraph).matrix_world.inverted_safe() @ (
        pivot.evaluated_get(home.depsgraph).matrix_world.translation
    )
    size = (hi - lo) * _scale(leaf)
    wide = int(np.argsort(size)[1])
    off = abs(place[wide] - (lo[wide] + hi[wide]) / 2.0) / max(hi[wide] - lo[wide], 1e-9)
    return bool(off < MIDDLE)


def _scale(obj: Any) -> Array:
    return np.abs(np.array(obj.matrix_world.to_scale(), np.float64))


# Checks of files and of names.


def missing_data(home: Examined) -> Iterator[Found]:
    """Yield a finding for each missing file, failing driver and sensor of an unknown kind."""
    for text, mend in lacking.lacks(home.view_layer, bool(home.requiring(LIGHT))):
        yield capital(text), capital(mend)


def same_names(home: Examined) -> Iterator[Found]:
    """Yield a finding for each name that several sensors have, so that logs mix them up."""
    for name, count in Counter(sensor.name for sensor in home.sensors).items():
        if count > 1:
            files = [s.library or "this file" for s in home.sensors if s.name == name]
            yield (
                f"{count} sensors are called '{name}' (from {', '.join(files)})",
                "Rename one (F2), so that each name in the log means one sensor",
                (name,),
            )
