# SPDX-License-Identifier: GPL-3.0-or-later
"""The building: walls as clean unions of the plan's boxes, floors, ceiling, landing, ground."""

from itertools import pairwise
from random import Random

import numpy as np

from . import plan
from .meshes import MeshBuilder, place

# The face of a wall inside a room takes the paint of the room.
WALL_MATERIALS = {
    "workroom": "paint white",
    "kitchen": "paint white",
    "bedroom": "paint white",
    "bathroom": "tiles white",
    "closet": "paint white",
    "hall": "paint warm",
    "living room": "paint warm",
    "balcony": "facade",
}
# A wall in another colour: room, axis of its normal, direction of the normal.
ACCENTS = {
    ("bedroom", 0, -1): "paint blue",  # behind the bed's head
    ("living room", 1, -1): "paint sage",  # behind the sofa
    ("workroom", 1, 1): "paint sand",  # behind the screens
}
FLOOR_MATERIALS = {
    "workroom": "oak floor",
    "kitchen": "tiles kitchen",
    "bedroom": "oak floor",
    "bathroom": "tiles grey",
    "closet": "tiles grey",
    "hall": "oak floor",
    "living room": "oak floor",
    "balcony": "deck",
}
FLOOR_FINISH = 0.012  # thickness of the finish on the slab
CEILING_Z = plan.WALL_TOP - 0.005  # below the tops of walls, which show the plan from above


def room_at(x: float, y: float) -> str | None:
    """Return the room on whose floor a point lies."""
    for name, rectangles in plan.ROOMS.items():
        for x0, y0, x1, y1 in rectangles:
            if x0 <= x <= x1 and y0 <= y <= y1:
                return name
    return None


def _indoors(x: float, y: float) -> bool:
    return any(a < x < c and b < y < d for a, b, c, d in plan.FLOOR_SLABS)


def wall_material(at: np.ndarray, axis: int, side: int) -> str:
    """Return the material of a piece of wall with centre `at` that faces along ±`axis`."""
    if axis == 2:
        return "wall cut" if side > 0 and at[2] > 2.9 else "paint white"
    out = at.copy()
    out[axis] += 0.03 * side
    room = room_at(out[0], out[1])
    if room is None:
        return "paint white" if _indoors(out[0], out[1]) else "facade"
    return ACCENTS.get((room, axis, side), WALL_MATERIALS[room])


def add_walls(name: str, boxes: tuple[plan.Box, ...]) -> None:
    """Add the union of some walls as one object: outside faces only, merged where possible.

    All walls share one grid of cells, so that faces between two groups vanish too.
    """
    everything = (*plan.OUTER_WALLS, *plan.INNER_WALLS, *plan.BALCONY_WALLS)
    rooms = [r for rectangles in plan.ROOMS.values() for r in rectangles]
    xs = {c for b in everything for c in (b.x0, b.x1)} | {c for r in rooms for c in r[::2]}
    ys = {c for b in everything for c in (b.y0, b.y1)} | {c for r in rooms for c in r[1::2]}
    zs = {c for b in everything for c in (b.z0, b.z1)}
    lines = [np.array(sorted(s)) for s in (xs, ys, zs)]
    filled = _cells(everything, lines)
    own = _cells(boxes, lines)
    builder = MeshBuilder()
    for axis in range(3):
        for side in (-1, 1):
            neighbour = np.zeros_like(filled)
            source = [slice(None)] * 3
            target = [slice(None)] * 3
            target[axis] = slice(0, -1) if side > 0 else slice(1, None)
            source[axis] = slice(1, None) if side > 0 else slice(0, -1)
            neighbour[tuple(target)] = filled[tuple(source)]
            _add_faces(builder, own & ~neighbour, lines, axis, side)
    place(name, builder, "Home/Walls")


def _cells(boxes: tuple[plan.Box, ...], lines: list[np.ndarray]) -> np.ndarray:
    """Return which cells of the grid lie in any of the boxes."""
    middles = [(line[1:] + line[:-1]) / 2 for line in lines]
    filled = np.zeros([len(m) for m in middles], bool)
    for box in boxes:
        low, high = (box.x0, box.y0, box.z0), (box.x1, box.y1, box.z1)
        inside = [(m > a) & (m < b) for m, a, b in zip(middles, low, high, strict=True)]
        filled |= inside[0][:, None, None] & inside[1][None, :, None] & inside[2][None, None, :]
    return filled


def _add_faces(
    builder: MeshBuilder, open_cells: np.ndarray, lines: list[np.ndarray], axis: int, side: int
) -> None:
    """Add the open faces of one direction, merged greedily to rectangles of one material."""
    u, w = (axis + 1) % 3, (axis + 2) % 3
    cells = np.moveaxis(open_cells, (axis, u, w), (0, 1, 2))
    names: dict[tuple[int, int, int], str] = {}
    for layer, i, j in np.argwhere(cells):
        at = np.zeros(3)
        at[axis] = lines[axis][layer + (side > 0)]
        at[u] = (lines[u][i] + lines[u][i + 1]) / 2
        at[w] = (lines[w][j] + lines[w][j + 1]) / 2
        names[int(layer), int(i), int(j)] = wall_material(at, axis, side)
    for key in sorted(names):
        if key not in names:
            continue
        layer, i, j = key
        material = names[key]
        j1 = j
        while names.get((layer, i, j1 + 1)) == material:
            j1 += 1
        i1 = i
        while all(names.get((layer, i1 + 1, k)) == material for k in range(j, j1 + 1)):
            i1 += 1
        for a in range(i, i1 + 1):
            for b in range(j, j1 + 1):
                del names[layer, a, b]
        corners = []
        for cu, cw in ((i, j), (i1 + 1, j), (i1 + 1, j1 + 1), (i, j1 + 1)):
            p = [0.0, 0.0, 0.0]
            p[axis] = lines[axis][layer + (side > 0)]
            p[u], p[w] = lines[u][cu], lines[w][cw]
            corners.append(p)
        builder.polygon(corners if side > 0 else corners[::-1], material)


def add_floors() -> None:
    """Add the slab and each room's finish, whose upper face lies at FLOOR_Z."""
    slab = MeshBuilder("concrete")
    for x0, y0, x1, y1 in plan.FLOOR_SLABS:
        slab.box((x0, y0, -0.25), (x1, y1, plan.FLOOR_Z - FLOOR_FINISH), 0.0)
    place("Floor slab", slab, "Home/Floors")
    for room, rectangles in plan.ROOMS.items():
        finish = MeshBuilder(FLOOR_MATERIALS[room])
        for x0, y0, x1, y1 in rectangles:
            finish.box((x0, y0, plan.FLOOR_Z - FLOOR_FINISH - 0.002), (x1, y1, plan.FLOOR_Z), 0.0)
        place(f"Floor {room}", finish, "Home/Floors")


def add_ceiling() -> None:
    """Add a sheet over all rooms that faces down; see the material for the view from above."""
    sheet = MeshBuilder("ceiling")
    z = CEILING_Z
    for x0, y0, x1, y1 in plan.FLOOR_SLABS:
        sheet.polygon([(x0, y1, z), (x1, y1, z), (x1, y0, z), (x0, y0, z)])
    obj = place("Ceiling", sheet, "Home/Ceiling")
    obj.display_type = "WIRE"  # the solid view shows the rooms, renders and rays see the ceiling


def add_skirting() -> None:
    """Add skirting boards along the walls of the dry rooms, with gaps at doorways."""
    depth, top = 0.012, plan.FLOOR_Z + 0.07
    for room in ("workroom", "kitchen", "bedroom", "hall", "living room"):
        board = MeshBuilder("white paint")
        for x0, y0, x1, y1 in plan.ROOMS[room]:
            for axis, fixed, sign, a, b in (
                (0, x0, 1, y0, y1), (0, x1, -1, y0, y1), (1, y0, 1, x0, x1), (1, y1, -1, x0, x1)
            ):  # fmt: skip
                for start, end in _wall_runs(axis, fixed - 0.02 * sign, a, b):
                    lo, hi = [0.0, 0.0, plan.FLOOR_Z], [0.0, 0.0, top]
                    lo[axis], hi[axis] = fixed, fixed + depth * sign
                    lo[1 - axis], hi[1 - axis] = start, end
                    board.box(lo, hi, 0.004)
        place(f"Skirting {room}", board, "Home/Walls")


def _wall_runs(axis: int, fixed: float, a: float, b: float) -> list[tuple[float, float]]:
    """Return the stretches between a and b, on a line just inside a wall, that have a wall."""
    walls = [w for w in (*plan.OUTER_WALLS, *plan.INNER_WALLS) if w.z0 == 0]
    marks = {a, b}
    for w in walls:
        marks |= {c for c in ((w.y0, w.y1) if axis == 0 else (w.x0, w.x1)) if a < c < b}
    runs: list[tuple[float, float]] = []
    ordered = sorted(marks)
    for start, end in pairwise(ordered):
        middle = (start + end) / 2
        x, y = (fixed, middle) if axis == 0 else (middle, fixed)
        if not any(w.x0 < x < w.x1 and w.y0 < y < w.y1 for w in walls):
            continue
        if runs and abs(runs[-1][1] - start) < 1e-9:
            runs[-1] = (runs[-1][0], end)
        else:
            runs.append((start, end))
    return runs


def add_outside() -> None:
    """Add the landing before the entrance, and the ground."""
    x0, y0, x1, y1 = plan.LANDING
    landing = MeshBuilder("concrete")
    landing.box((x0, y0, -0.25), (x1, y1, plan.FLOOR_Z), 0.0)
    place("Landing", landing, "Home/Floors")
    railing = MeshBuilder("black metal")
    corners = [(x0 + 0.05, y0 + 0.1), (x0 + 0.05, y1 - 0.05), (x1 - 0.05, y1 - 0.05)]
    for (ax, ay), (bx, by) in pairwise(corners):
        for z in (0.2, 1.02):
            railing.rod((ax, ay, z), (bx, by, z), 0.018 if z > 1 else 0.01, 8)
        count = 14 if ax == bx else 24
        for i in range(count + 1):
            t = i / count
            x, y = ax + t * (bx - ax), ay + t * (by - ay)
            railing.rod((x, y, plan.FLOOR_Z), (x, y, 1.02), 0.008, 6)
    place("Landing railing", railing, "Home/Walls")
    ground = MeshBuilder("ground")
    ground.polygon([(-60, -60, -0.25), (70, -60, -0.25), (70, 70, -0.25), (-60, 70, -0.25)])
    place("Ground", ground, "Home/Floors")
    hedge = MeshBuilder("hedge")
    rnd = Random(8)
    for x, y, count in ((-9.0, 4.0, 16), (20.0, 5.0, 12)):
        for i in range(count):
            r = rnd.uniform(1.3, 2.4)
            at = (x + rnd.uniform(-1.5, 1.5), y + (i - count / 2) * 2.1, -0.6)
            hedge.lathe(
                [(r * 0.8, 0), (r, 0.5 * r), (r * 0.92, r), (r * 0.6, 1.5 * r), (0, 1.75 * r)],
                at, 10,
            )  # fmt: skip
    place("Hedges", hedge, "Home/Floors")


def add_building() -> None:
    """Add all objects of this module."""
    add_walls("Outer walls", plan.OUTER_WALLS)
    add_walls("Inner walls", plan.INNER_WALLS)
    add_walls("Balcony walls", plan.BALCONY_WALLS)
    add_floors()
    add_ceiling()
    add_skirting()
    add_outside()
