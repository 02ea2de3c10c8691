# SPDX-License-Identifier: GPL-3.0-or-later
"""Walls, floor, roof, glass and doors, in metres.

Before the home is turned, x runs along its long side. The finished floor is at z = 0.
"""

from math import radians

import bpy
from angen_home.meshes import MeshBuilder, place

LONG, DEEP, HIGH, WALL, THIN = 9.0, 6.5, 3.2, 0.25, 0.1
HEAD = 2.1
# The bath's corner, and its doorway in the wall towards the studio.
BATH_X, BATH_Y, BATH_DOOR = 6.6, 4.2, (4.35, 5.2)
# Openings: from and to along the wall, sill, head.
WINDOW, NORTH_WINDOW = (0.8, 4.0, 0.5, 2.3), (4.2, 5.6, 1.25, 2.2)
TERRACE, ENTRANCE = (4.7, 6.3, 0.0, 2.15), (1.2, 2.1, 0.0, HEAD)
Opening = tuple[float, float, float, float]


def _wall(
    b: MeshBuilder, ends: tuple[float, float], faces: tuple[float, float], along_x: bool,
    openings: tuple[Opening, ...] = (),
) -> None:  # fmt: skip
    """Add a wall between `ends` along one axis and `faces` along the other, with openings."""

    def box(first: float, last: float, low: float, high: float) -> None:
        if last - first > 1e-6 and high - low > 1e-6:
            a, c = (first, faces[0]), (last, faces[1])
            if not along_x:
                a, c = a[::-1], c[::-1]
            b.box((*a, low), (*c, high), 0.0)

    here = ends[0]
    for first, last, sill, head in sorted(openings):
        box(here, first, 0.0, HIGH)
        box(first, last, 0.0, sill)
        box(first, last, head, HIGH)
        here = last
    box(here, ends[1], 0.0, HIGH)


def add_shell() -> None:
    """Add all parts that do not move."""
    outer = MeshBuilder("paint white")
    span = (-WALL, LONG + WALL)
    _wall(outer, span, (-WALL, 0.0), True, (WINDOW, TERRACE))
    _wall(outer, span, (DEEP, DEEP + WALL), True, (NORTH_WINDOW,))
    _wall(outer, (0.0, DEEP), (-WALL, 0.0), False)
    _wall(outer, (0.0, DEEP), (LONG, LONG + WALL), False, (ENTRANCE,))
    place("Outer walls", outer, "Atelier/Walls")
    inner = MeshBuilder("paint blue")
    doorway = ((*BATH_DOOR, 0.0, HEAD),)
    _wall(inner, (BATH_Y, DEEP), (BATH_X - THIN, BATH_X), False, doorway)
    _wall(inner, (BATH_X - THIN, LONG), (BATH_Y - THIN, BATH_Y), True)
    place("Bath walls", inner, "Atelier/Walls")
    floor = MeshBuilder("oak floor")
    floor.box((-WALL, -WALL, -0.2), (LONG + WALL, DEEP + WALL, 0.0), 0.0)
    place("Floor", floor, "Atelier/Walls")
    tiles = MeshBuilder("tiles grey")
    tiles.box((BATH_X, BATH_Y, 0.0), (LONG, DEEP, 0.008), 0.0)
    place("Bath floor", tiles, "Atelier/Walls")
    roof = MeshBuilder("ceiling")
    roof.box((-WALL, -WALL, HIGH), (LONG + WALL, DEEP + WALL, HIGH + 0.2), 0.0)
    place("Ceiling", roof, "Atelier/Roof")
    deck = MeshBuilder("deck")
    deck.box((4.0, -2.6, -0.1), (8.0, -WALL, -0.005), 0.0)
    deck.box((LONG + WALL, 0.5, -0.1), (LONG + 2.0, 2.8, -0.005), 0.0)
    place("Terrace", deck, "Atelier/Walls")
    ground = MeshBuilder("ground")
    ground.box((-8.0, -9.0, -0.4), (17.0, 15.0, -0.12), 0.0)
    place("Ground", ground, "Atelier/Walls")
    _add_glass()


def _add_glass() -> None:
    for name, (first, last, sill, head), y in (
        ("Window south", WINDOW, -WALL / 2), ("Window north", NORTH_WINDOW, DEEP + WALL / 2),
    ):  # fmt: skip
        b = MeshBuilder("glass")
        b.box((first, y - 0.004, sill), (last, y + 0.004, head), 0.0)
        bars = 3
        for k in range(bars + 1):
            x = first + (last - first) * k / bars
            b.box((x - 0.03, y - 0.035, sill), (x + 0.03, y + 0.035, head), 0.0, "black metal")
        for z in (sill + 0.03, head - 0.03):
            b.box((first, y - 0.035, z - 0.03), (last, y + 0.035, z + 0.03), 0.0, "black metal")
        place(name, b, "Atelier/Windows")
    first, last, _, head = TERRACE
    b = _pane((first + last) / 2, last, head)
    place("Terrace pane", b, "Atelier/Windows", (0.0, -0.16, 0.0))


def _pane(first: float, last: float, head: float) -> MeshBuilder:
    """Return glass in a frame of metal, 5 cm thick, about y = 0."""
    b = MeshBuilder("glass")
    b.box((first + 0.05, -0.004, 0.05), (last - 0.05, 0.004, head - 0.05), 0.0)
    left, right, top = first + 0.06, last - 0.06, head - 0.06
    for lo, hi in (
        ((first, 0.0), (left, head)), ((right, 0.0), (last, head)),
        ((left, 0.0), (right, 0.06)), ((left, top), (right, head)),
    ):  # fmt: skip
        b.box((lo[0], -0.025, lo[1]), (hi[0], 0.025, hi[1]), 0.0, "black metal")
    return b


def add_doors() -> None:
    """Add the hinged front door, the sliding bath door and the glass terrace door, with marks."""
    leaf = MeshBuilder("walnut z")
    width = ENTRANCE[1] - ENTRANCE[0] - 0.01
    # Its origin is the hinge, on the face to which it opens: inside.
    leaf.box((0.0, 0.0, 0.005), (0.05, width, HEAD - 0.01), 0.0)
    leaf.rod((-0.05, width - 0.1, 1.05), (-0.05, width - 0.22, 1.05), 0.009, 8, "steel")
    leaf.rod((-0.05, width - 0.1, 1.05), (0.0, width - 0.1, 1.05), 0.008, 8, "steel")
    front = place("Front door", leaf, "Atelier/Doors", (LONG, ENTRANCE[0] + 0.005, 0.0))
    front.angen_place.use, front.angen_place.entrance = "DOOR", True
    front.angen_place.angle = radians(95.0)
    # The handle stands out as far as the door is thick, which marks the side: it opens inwards.
    front.angen_place.other_side = True
    bath = MeshBuilder("oak z")
    low, high = BATH_DOOR
    bath.box((0.0, 0.0, 0.01), (0.046, high - low + 0.16, HEAD + 0.03), 0.0)
    door = place("Bath door", bath, "Atelier/Doors", (BATH_X - THIN - 0.05, low - 0.08, 0.0))
    _slides(door, 0.93)
    first, last, _, head = TERRACE
    middle = (first + last) / 2
    b = _pane(0.0, middle - first + 0.03, head)
    _slides(place("Terrace door", b, "Atelier/Doors", (first, -0.1, 0.0)), 0.74)


def _slides(leaf: bpy.types.Object, way: float) -> None:
    """Mark a leaf as a sliding door."""
    mark = leaf.angen_place
    mark.use, mark.motion, mark.slide, mark.other_side = "DOOR", "SLIDING", way, True
