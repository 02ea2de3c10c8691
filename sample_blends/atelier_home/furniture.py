# SPDX-License-Identifier: GPL-3.0-or-later
"""Furniture of the studio and of the bath, marked with what residents do there."""

from math import cos, pi, radians, sin

import bpy
from angen_home.common import books, chair, curtain, plant, table, table_lamp
from angen_home.meshes import MeshBuilder, place

from .shell import BATH_X, DEEP, LONG, WINDOW

PATH, BATH = "Atelier/Furniture", "Atelier/Bath"
TOP = 0.9
LEAF = 0.018  # thickness of the doors of cupboards


def mark(obj: bpy.types.Object, use: str, yaw: float | None = None) -> bpy.types.Object:
    """Mark an object with its use and the yaw of a person there; return it.

    `yaw` is in degrees; None: any direction with free floor.
    """
    obj.angen_place.use = use
    if yaw is not None:
        # The yaw counts from the object's own front, -Y.
        obj.angen_place.facing = radians(yaw + 90.0) - obj.rotation_euler.z
    return obj


def point(name: str, use: str, at: tuple[float, float, float], yaw: float) -> bpy.types.Object:
    """Add a marked empty for a use without an object."""
    obj = place(name, None, "Atelier/Places", at)
    obj.empty_display_type, obj.empty_display_size = "CIRCLE", 0.1
    return mark(obj, use, yaw)


def _block(
    name: str, low: tuple[float, float, float], high: tuple[float, float, float], material: str,
    path: str = PATH,
) -> bpy.types.Object:  # fmt: skip
    """Add a box whose origin is the centre of its lower face."""
    x, y = ((a + b) / 2 for a, b in zip(low[:2], high[:2], strict=True))
    b = MeshBuilder(material)
    b.box((low[0] - x, low[1] - y, 0.0), (high[0] - x, high[1] - y, high[2] - low[2]), 0.008)
    return place(name, b, path, (x, y, low[2]))


def _cupboard_door(
    name: str, hinge: float, edge: float, y: float, z: tuple[float, float], material: str,
    carcass: bpy.types.Object,
) -> None:  # fmt: skip
    """Add a door, marked, from x = `hinge` to `edge`, whose front is at `y`; it has no handle."""
    b = MeshBuilder(material)
    low, high = sorted((0.0, edge - hinge))
    b.box((low, 0.0, 0.0), (high, LEAF, z[1] - z[0]), 0.0)
    x0, y0, z0 = carcass.location
    # The hinge is at the front, the face to which the door opens.
    door = place(name, b, PATH, (hinge - x0, y - y0, z[0] - z0), parent=carcass)
    mark(door, "CUPBOARD", 90.0)


def _bed(name: str, y: float, cloth: str) -> None:
    """Add a bed 0.9 m wide, its head at the west wall."""
    b = MeshBuilder("pine")
    b.box((0.03, y, 0.0), (2.05, y + 0.9, 0.28), 0.01)
    b.box((0.0, y - 0.02, 0.0), (0.04, y + 0.92, 0.95), 0.01)
    b.cushion((0.06, y + 0.02, 0.28), (2.02, y + 0.88, 0.5), 0.05, 0.004, "linen")
    b.cushion((0.7, y - 0.01, 0.47), (2.03, y + 0.91, 0.53), 0.03, 0.008, cloth)
    b.cushion((0.1, y + 0.15, 0.48), (0.55, y + 0.75, 0.58), 0.05, 0.03, "linen")
    mark(place(name, b, PATH), "LIE", 180.0)


def add_sleeping() -> None:
    """Add two beds and a chest of drawers between them, behind a low shelf."""
    _bed("Bed of Karin", 5.55, "fabric rust")
    _bed("Bed of Olle", 3.75, "fabric grey blue")
    chest = MeshBuilder("oak")
    for low, high in (
        ((0.0, 4.78, 0.0), (0.44, 4.8, 0.75)), ((0.0, 5.42, 0.0), (0.44, 5.44, 0.75)),
        ((0.0, 4.78, 0.75), (0.46, 5.44, 0.78)), ((0.0, 4.8, 0.0), (0.02, 5.42, 0.75)),
        ((0.02, 4.8, 0.02), (0.44, 5.42, 0.36)),
    ):  # fmt: skip
        chest.box(low, high, 0.0)
    place("Chest", chest, PATH)
    drawer = _block("Chest drawer", (0.03, 4.81, 0.4), (0.45, 5.41, 0.72), "oak")
    mark(drawer, "DRAWER", 180.0)
    shelf = MeshBuilder("oak")
    shelf.box((0.0, 3.2, 0.0), (1.7, 3.22, 1.2), 0.0)
    for z in (0.0, 0.4, 0.8, 1.18):
        shelf.box((0.0, 3.22, z), (1.7, 3.5, z + 0.02), 0.0)
    for x in (0.0, 0.84, 1.68):
        shelf.box((x, 3.22, 0.0), (x + 0.02, 3.5, 1.2), 0.0)
    for seed, (x, z) in enumerate(((0.05, 0.42), (0.9, 0.82), (0.06, 0.82))):
        books(shelf, x, x + 0.6, z, 0.2, 3.25, seed + 3)
    mark(place("Bookshelf", shelf, PATH), "USE", 90.0)
    wardrobe = _block("Wardrobe", (7.0, 3.5 + LEAF, 0.0), (8.2, 4.09, 2.1), "white paint")
    mark(wardrobe, "USE", 90.0)
    for side, first, last in (("left", 7.0, 7.6), ("right", 8.2, 7.6)):
        _cupboard_door(
            f"Wardrobe door {side}", first, last, 3.5, (0.0, 2.1), "white paint", wardrobe
        )


def add_kitchen() -> None:
    """Add a line along the north wall: fridge, counter, sink, stove."""
    counter = MeshBuilder("kitchen front")
    counter.box((2.9, 5.9 + LEAF, 0.08), (4.2, DEEP, TOP - 0.03), 0.0)
    counter.box((4.8, 5.9 + LEAF, 0.08), (5.6, DEEP, TOP - 0.03), 0.0)
    for first, last in ((2.9, 4.2), (4.8, 5.6)):
        counter.box((first, 5.96, 0.0), (last, DEEP, 0.08), 0.0, "black plastic")
        counter.box((first, 5.88, TOP - 0.03), (last, DEEP, TOP), 0.0, "oak")
    worktop = mark(place("Worktop", counter, PATH), "USE", 90.0)
    for k, (hinge, edge) in enumerate(((2.9, 3.55), (4.2, 3.55), (4.8, 5.2), (5.6, 5.2)), 1):
        heights = (0.08, TOP - 0.03)
        _cupboard_door(f"Cupboard door {k}", hinge, edge, 5.9, heights, "kitchen front", worktop)
    sink = MeshBuilder("steel")
    sink.box((3.2, 6.0, TOP - 0.001), (3.8, 6.35, TOP + 0.004), 0.0)
    sink.tube([(3.5, 6.42, TOP), (3.5, 6.42, TOP + 0.25), (3.5, 6.25, TOP + 0.27)], 0.012, 8)
    mark(place("Kitchen tap", sink, PATH), "TAP", 90.0)
    stove = MeshBuilder("white plastic")
    stove.box((4.205, 5.9, 0.0), (4.795, DEEP, TOP - 0.005), 0.004)
    stove.box((4.205, 5.9, TOP - 0.005), (4.795, DEEP, TOP), 0.0, "black glass")
    mark(place("Stove", stove, PATH), "APPLIANCE", 90.0)
    fridge = MeshBuilder("white plastic")
    for low, high in (
        ((2.25, 5.9, 0.05), (2.28, DEEP, 1.85)), ((2.82, 5.9, 0.05), (2.85, DEEP, 1.85)),
        ((2.28, 6.46, 0.05), (2.82, DEEP, 1.85)), ((2.28, 5.9, 1.82), (2.82, 6.46, 1.85)),
        ((2.28, 5.9, 0.05), (2.82, 6.46, 0.1)), ((2.28, 5.95, 0.9), (2.82, 6.46, 0.91)),
    ):  # fmt: skip
        fridge.box(low, high, 0.0)
    mark(place("Fridge", fridge, PATH), "APPLIANCE", 90.0)
    leaf = MeshBuilder("white plastic")
    leaf.box((0.0, 0.0, 0.05), (0.6, 0.05, 1.85), 0.004)
    leaf.rod((0.55, -0.04, 0.9), (0.55, -0.04, 1.3), 0.009, 8, "steel")
    door = mark(place("Fridge door", leaf, PATH, (2.25, 5.84, 0.0)), "DOOR")
    # The handle stands out as far as the door is thick, which marks the side.
    door.angen_place.angle, door.angen_place.other_side = radians(105.0), True
    kettle = MeshBuilder("steel")
    kettle.lathe([(0, 0), (0.08, 0), (0.085, 0.12), (0.06, 0.18), (0, 0.19)], segments=14)
    mark(place("Kettle", kettle, PATH, (5.2, 6.2, TOP)), "APPLIANCE", 90.0)
    mark(_block("Cat bowl", (6.0, 6.15, 0.0), (6.2, 6.35, 0.05), "blue ceramic"), "USE", 90.0)


def add_living() -> None:
    """Add a round table with three chairs; sofa, armchair and television; desk at the east wall."""
    b = MeshBuilder("oak")
    b.cylinder((0, 0, 0.71), 0.55, 0.03, 32)
    b.cylinder((0, 0, 0.0), 0.05, 0.71, 12, "black metal")
    b.cylinder((0, 0, 0.0), 0.3, 0.02, 24, "black metal")
    place("Table", b, PATH, (4.3, 4.1, 0.0))
    mesh = chair("fabric green").build("Chair")
    for name, angle in (("west", 180.0), ("south", -80.0), ("east", 15.0)):
        x, y = 4.3 + 0.72 * cos(radians(angle)), 4.1 + 0.72 * sin(radians(angle))
        yaw = angle + 180.0
        # The chair's back is at its own -Y.
        mark(place(f"Chair {name}", mesh, PATH, (x, y, 0.0), yaw - 90.0), "SIT", yaw)
    sofa = MeshBuilder("fabric mustard")
    sofa.box((2.95, 0.7, 0.08), (3.8, 2.6, 0.28), 0.02)
    sofa.cushion((3.55, 0.7, 0.2), (3.82, 2.6, 0.82), 0.06, 0.01)
    for y in (0.7, 2.44):
        sofa.cushion((2.93, y, 0.1), (3.8, y + 0.16, 0.58), 0.06, 0.008)
    for y in (0.87, 1.66):
        sofa.cushion((2.93, y, 0.27), (3.56, y + 0.77, 0.45), 0.05, 0.006)
    place("Sofa", sofa, PATH)
    point("Sofa south", "SIT", (3.25, 1.25, 0.45), 180.0)
    point("Sofa north", "SIT", (3.25, 2.05, 0.45), 180.0)
    seat = MeshBuilder("fabric rust")
    seat.cushion((-0.36, -0.36, 0.15), (0.36, 0.36, 0.42), 0.06, 0.008)
    seat.cushion((-0.38, -0.42, 0.15), (0.38, -0.24, 0.9), 0.07, 0.01)
    mark(place("Armchair", seat, PATH, (1.35, 2.55, 0.0), 200.0), "SIT", -70.0)
    low = table(0.9, 0.5, 0.42)
    mark(place("Coffee table", low, PATH, (1.75, 1.35, 0.0), 90.0), "USE", 0.0)
    bench = _block("Television", (0.0, 0.7, 0.0), (0.38, 2.1, 0.45), "walnut")
    screen = MeshBuilder("television")
    screen.box((-0.02, -0.6, 0.5), (0.02, 0.6, 1.18), 0.004)
    place("Screen", screen, PATH, (0.0, 0.0, 0.0), 0.0, bench)
    mark(bench, "APPLIANCE", 180.0)
    mark(
        place("Desk", table(1.3, 0.65, 0.73, "pine"), PATH, (LONG - 0.34, 3.05, 0.0), 90.0),
        "USE",
        0.0,
    )
    mark(place("Desk chair", mesh, PATH, (LONG - 0.78, 3.05, 0.0), -90.0), "SIT", 0.0)
    place("Desk lamp", table_lamp(0.45), PATH, (LONG - 0.2, 2.6, 0.73))
    mark(place("Fig tree", plant(4, 1.6, 22, 0.2, 0.36, reach=0.4), PATH, (4.35, 0.4, 0.0)), "USE")
    basket = MeshBuilder("wicker")
    basket.lathe([(0.0, 0.03), (0.2, 0.03), (0.26, 0.12), (0.28, 0.12), (0.25, 0.0), (0, 0)],
                 segments=20)  # fmt: skip
    place("Cat basket", basket, PATH, (0.5, 0.4, 0.0))
    point("Window place", "STAND", (2.2, 0.5, 0.0), -90.0)
    for name, x in (("west", WINDOW[0] - 0.55), ("east", WINDOW[1] + 0.05)):
        cloth = curtain(0.5, 2.35, 4, 0.05, "linen")
        mark(place(f"Curtain {name}", cloth, PATH, (x, 0.1, 0.1)), "CURTAIN")


def add_entry() -> None:
    """Add a bench and hooks by the front door; a bench on the terrace."""
    mark(_block("Shoe bench", (7.9, 0.0, 0.0), (8.7, 0.35, 0.45), "oak"), "SIT", 90.0)
    hooks = MeshBuilder("oak")
    hooks.box((6.9, 0.0, 1.6), (7.7, 0.03, 1.72), 0.004)
    for k in range(5):
        hooks.rod((7.0 + 0.15 * k, 0.03, 1.64), (7.0 + 0.15 * k, 0.1, 1.67), 0.008, 6, "brass")
    mark(place("Coat hooks", hooks, PATH), "USE", -90.0)
    mark(_block("Terrace bench", (6.6, -2.4, 0.0), (7.8, -1.95, 0.44), "pine"), "SIT", 90.0)
    point("Outside", "STAND", (LONG + 1.2, 1.65, 0.0), 180.0)


def add_bath() -> None:
    """Add toilet, basin, shower and washing machine."""
    b = MeshBuilder("ceramic")
    b.cushion((6.98, 6.3, 0.35), (7.42, DEEP, 0.85), 0.03, 0.0, None, 2)
    b.lathe([(0.12, 0.0), (0.13, 0.3), (0.19, 0.4), (0.19, 0.42), (0.0, 0.42)], (7.2, 6.05, 0.008))
    mark(place("Toilet", b, BATH), "SIT", -90.0)
    basin = MeshBuilder("ceramic")
    basin.box((8.55, 4.95, 0.72), (LONG, 5.5, 0.87), 0.02)
    basin.cylinder((8.85, 5.22, 0.008), 0.07, 0.72)
    basin.tube([(8.9, 5.22, 0.87), (8.9, 5.22, 1.0), (8.78, 5.22, 1.0)], 0.012, 8, "chrome")
    mark(place("Washbasin", basin, BATH), "TAP", 0.0)
    mirror = MeshBuilder("mirror")
    mirror.box((LONG - 0.015, 4.9, 1.2), (LONG - 0.002, 5.55, 1.9), 0.0)
    place("Mirror", mirror, BATH)
    tray = MeshBuilder("ceramic")
    tray.box((8.0, 5.6, 0.008), (LONG, DEEP, 0.03), 0.0)
    place("Shower tray", tray, BATH)
    screen = MeshBuilder("glass")
    screen.box((7.98, 5.95, 0.03), (7.995, DEEP, 2.0), 0.0)
    place("Shower screen", screen, BATH)
    head = MeshBuilder("chrome")
    head.tube([(8.97, 6.1, 1.0), (8.95, 6.1, 2.1), (8.7, 6.1, 2.12)], 0.012, 8)
    head.cylinder((8.7, 6.1, 2.08), 0.1, 0.03)
    place("Shower", head, BATH)
    point("Shower place", "STAND", (8.5, 5.98, 0.03), 0.0)
    machine = _block("Washing machine", (8.3, 4.22, 0.008), (8.9, 4.8, 0.85), "white plastic", BATH)
    mark(machine, "APPLIANCE", -90.0)
    towels = curtain(0.5, 0.7, 3, 0.02, "towel")
    mark(place("Towels", towels, BATH, (BATH_X + 0.06, 5.6, 0.85), 90.0), "USE", 180.0)


def turn(yaw: float, at: tuple[float, float, float]) -> None:
    """Turn all objects without a parent by an angle (degrees) about z, and move them."""
    from mathutils import Matrix

    bpy.context.view_layer.update()
    whole = Matrix.Translation(at) @ Matrix.Rotation(yaw * pi / 180, 4, "Z")
    for obj in bpy.context.scene.objects:
        if obj.parent is None:
            obj.matrix_world = whole @ obj.matrix_world
    bpy.context.view_layer.update()
