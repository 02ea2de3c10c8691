# SPDX-License-Identifier: GPL-3.0-or-later
"""Kitchen: worktop with sink and stove, wall cupboards with shutters, fridge with a door, table."""

from math import radians

from . import plan
from .common import FLOOR, chair, plant, table
from .meshes import MeshBuilder, moved, place

PATH = "Home/Furniture/Kitchen"
WALL_Y = 6.0
BASE_FRONT = 5.42  # carcass front of the base cupboards
TOP_Z = 0.92  # worktop's upper face
CUPBOARD = (1.45, 2.15)  # wall cupboards' bottom and top
CUPBOARD_FRONT = 5.66
FRONT = 0.018  # thickness of doors and drawers


def _front(x0: float, x1: float, z0: float, z1: float) -> MeshBuilder:
    """Return a closed front of the base cupboards with a bar handle near its top."""
    b, y = MeshBuilder("kitchen front"), BASE_FRONT
    b.box((x0 + 0.002, y - FRONT, z0 + 0.002), (x1 - 0.002, y, z1 - 0.002), 0.003)
    _handle(b, (x0 + x1) / 2, y - FRONT, z1 - 0.05)
    return b


def _tray(b: MeshBuilder, x0: float, x1: float, z0: float, z1: float) -> None:
    """Add the box of a drawer behind its front; shut, it is inside the carcass."""
    left, right, front, back = x0 + 0.02, x1 - 0.02, BASE_FRONT + 0.002, BASE_FRONT + 0.45
    low, floor, high = z0 + 0.02, z0 + 0.03, z1 - 0.06
    b.box((left, front, low), (right, back, floor), 0.0, "oak")
    b.box((left, front, floor), (left + 0.012, back, high), 0.0, "oak")
    b.box((right - 0.012, front, floor), (right, back, high), 0.0, "oak")
    b.box((left + 0.012, back - 0.012, floor), (right - 0.012, back, high), 0.0, "oak")


def _handle(b: MeshBuilder, x: float, y: float, z: float) -> None:
    b.rod((x - 0.07, y - 0.025, z), (x + 0.07, y - 0.025, z), 0.005, 6, "brass")
    for s in (-0.055, 0.055):
        b.rod((x + s, y, z), (x + s, y - 0.025, z), 0.004, 6, "brass")


def add_base() -> None:
    """Add base cupboards, worktop with a sink let in, tap, tiles behind."""
    b = MeshBuilder("lacquer")
    plinth, carcass_top = FLOOR + 0.1, TOP_Z - 0.03
    sink, stove, end = (0.66, 1.24), (1.75, 2.35), 2.86
    for x0, x1 in ((0.0, stove[0]), (stove[1], end)):
        b.box((x0, BASE_FRONT, plinth), (x1, WALL_Y, carcass_top), 0.002)
        b.box((x0, BASE_FRONT + 0.05, FLOOR), (x1, WALL_Y, plinth), 0.0, "black plastic")
    place("Base cupboards", b, PATH)
    doors = ((0.0, 0.6, 0.0), (0.6, 1.3, 0.6), (2.35, 2.86, 2.86))
    for number, (x0, x1, hinge) in enumerate(doors, 1):
        place(f"Base cupboard door {number}", _front(x0, x1, plinth, carcass_top), PATH,
              hinge=(hinge, BASE_FRONT, plinth))  # fmt: skip
    for number, (z0, z1) in enumerate(((plinth, 0.45), (0.45, 0.68), (0.68, carcass_top)), 1):
        drawer = _front(1.3, 1.75, z0, z1)
        _tray(drawer, 1.3, 1.75, z0, z1)
        place(f"Kitchen drawer {number}", drawer, PATH, hinge=(1.525, BASE_FRONT, z0))
    # The worktop has holes for the sink and the stove.
    t = MeshBuilder("worktop")
    y0, y1 = 5.385, WALL_Y
    hole = (sink[0] + 0.03, 5.5, sink[1] - 0.03, 5.88)
    for lo, hi in (
        ((0.0, y0), (hole[0], y1)), ((hole[2], y0), (stove[0], y1)), ((stove[1], y0), (end, y1)),
        ((hole[0], y0), (hole[2], hole[1])), ((hole[0], hole[3]), (hole[2], y1)),
    ):  # fmt: skip
        t.box((*lo, carcass_top), (*hi, TOP_Z), 0.002)
    place("Worktop", t, PATH)
    s = MeshBuilder("steel")
    a, c, d, e = hole
    s.box((a, c, TOP_Z - 0.18), (d, e, TOP_Z - 0.17), 0.0)
    for lo, hi in (((a, c), (a + 0.008, e)), ((d - 0.008, c), (d, e)), ((a, c), (d, c + 0.008)),
                   ((a, e - 0.008), (d, e))):  # fmt: skip
        s.box((*lo, TOP_Z - 0.18), (*hi, TOP_Z + 0.003), 0.0)
    s.lathe([(0, 0), (0.03, 0), (0.03, 0.004), (0.02, 0.004), (0, 0.001)],
            ((a + d) / 2, (c + e) / 2, TOP_Z - 0.17), 16, "black metal")  # fmt: skip
    place("Kitchen sink", s, PATH)
    tap = MeshBuilder("chrome")
    tap.cylinder((0, 0, 0), 0.026, 0.03, 14)
    tap.tube([(0, 0, 0.02), (0, 0, 0.26), (0, -0.03, 0.31), (0, -0.09, 0.33), (0, -0.15, 0.31),
              (0, -0.17, 0.25)], 0.012, 10)  # fmt: skip
    tap.rod((0, 0, 0.05), (0.07, -0.01, 0.09), 0.007, 8)
    place("Tap", tap, PATH, ((a + d) / 2, 5.93, TOP_Z))
    splash = MeshBuilder("tiles splash")
    splash.box((0.0, WALL_Y - 0.008, TOP_Z), (end, WALL_Y, CUPBOARD[0]), 0.0)
    place("Splash tiles", splash, PATH)


def add_stove() -> None:
    """Add a stove with four plates, its oven, and the hood above."""
    x0, x1, y0 = 1.753, 2.347, BASE_FRONT - 0.02
    b = MeshBuilder("steel")
    b.box((x0, y0 + 0.02, FLOOR + 0.06), (x1, WALL_Y - 0.01, TOP_Z - 0.012), 0.004, "lacquer")
    b.box((x0, y0, TOP_Z - 0.012), (x1, WALL_Y - 0.01, TOP_Z + 0.004), 0.004, "black glass")
    for x, y, r in ((1.9, 5.56, 0.09), (2.2, 5.56, 0.075), (1.9, 5.82, 0.075), (2.2, 5.82, 0.09)):
        b.lathe([(r - 0.004, 0), (r, 0.001), (r, 0.0005)], (x, y, TOP_Z + 0.004), 24,
                "grey plastic")  # fmt: skip
    b.box((x0 + 0.004, y0, 0.76), (x1 - 0.004, y0 + 0.02, TOP_Z - 0.014), 0.003)
    for i in range(5):
        b.matrix = moved(1.83 + 0.11 * i, y0, 0.83)
        b.tube([(0, 0, 0), (0, -0.025, 0)], 0.018, 12, "black plastic")
    b.matrix = moved()
    b.box((x0 + 0.004, y0, 0.3), (x1 - 0.004, y0 + 0.02, 0.75), 0.003)
    b.box((x0 + 0.06, y0 - 0.002, 0.36), (x1 - 0.06, y0 + 0.002, 0.64), 0.001, "black glass")
    b.rod((x0 + 0.08, y0 - 0.04, 0.7), (x1 - 0.08, y0 - 0.04, 0.7), 0.009, 10, "chrome")
    for x in (x0 + 0.1, x1 - 0.1):
        b.rod((x, y0, 0.7), (x, y0 - 0.04, 0.7), 0.006, 8, "chrome")
    b.box((x0 + 0.004, y0, FLOOR + 0.06), (x1 - 0.004, y0 + 0.02, 0.29), 0.003)
    place("Stove", b, PATH)
    pot = MeshBuilder("red")
    pot.lathe([(0, 0), (0.085, 0), (0.095, 0.01), (0.095, 0.11), (0.1, 0.112), (0.1, 0.12),
               (0.03, 0.14), (0, 0.143)], segments=24)  # fmt: skip
    pot.lathe([(0, 0.14), (0.012, 0.143), (0.018, 0.16), (0, 0.168)], segments=12,
              material="black plastic")  # fmt: skip
    for s in (-1, 1):
        pot.tube([(s * 0.093, -0.03, 0.09), (s * 0.125, -0.02, 0.095), (s * 0.125, 0.02, 0.095),
                  (s * 0.093, 0.03, 0.09)], 0.006, 6)  # fmt: skip
    place("Pot", pot, PATH, (1.9, 5.82, TOP_Z + 0.005))
    hood = MeshBuilder("steel")
    hood.box((1.77, 5.55, 1.5), (2.33, WALL_Y - 0.01, 1.56), 0.004)
    hood.box((1.93, 5.75, 1.56), (2.17, WALL_Y - 0.01, 2.3), 0.004)
    place("Cooker hood", hood, PATH)


def add_wall_cupboards() -> None:
    """Add wall cupboards, two of them open inside behind shutters on hinges."""
    z0, z1 = CUPBOARD
    b = MeshBuilder("lacquer")
    t = 0.018
    for x0, x1 in ((0.1, 0.9), (0.9, 1.7), (2.4, 2.86)):
        b.box((x0, CUPBOARD_FRONT, z0), (x0 + t, WALL_Y, z1), 0.001)
        b.box((x1 - t, CUPBOARD_FRONT, z0), (x1, WALL_Y, z1), 0.001)
        b.box((x0 + t, WALL_Y - 0.01, z0), (x1 - t, WALL_Y, z1), 0.0)
        for z in (z0, (z0 + z1) / 2 - t / 2, z1 - t):
            b.box((x0 + t, CUPBOARD_FRONT, z), (x1 - t, WALL_Y - 0.01, z + t), 0.001)
    place("Wall cupboards", b, PATH)
    # Shutters: name, x of the hinge, direction of the leaf from the hinge, width.
    for name, x, way, width in (
        ("1", 0.1, 1, 0.4), ("2", 0.9, -1, 0.4), ("3", 0.9, 1, 0.4), ("4", 1.7, -1, 0.4),
        ("5", 2.86, -1, 0.46),
    ):  # fmt: skip
        s = MeshBuilder("kitchen front")
        lo, hi = sorted((0.002 * way, (width - 0.002) * way))
        s.box((lo, -FRONT, 0.002), (hi, 0, z1 - z0 - 0.002), 0.003)
        x_bar = (width - 0.035) * way
        s.rod((x_bar, -FRONT - 0.022, 0.05), (x_bar, -FRONT - 0.022, 0.19), 0.005, 6, "brass")
        for z in (0.065, 0.175):
            s.rod((x_bar, -FRONT, z), (x_bar, -FRONT - 0.022, z), 0.004, 6, "brass")
        place(f"Cupboard shutter {name}", s, PATH, (x, CUPBOARD_FRONT, z0))
    dishes = MeshBuilder("ceramic")
    for x, z, count in ((0.3, z0 + t, 6), (0.65, z0 + t, 4), (1.25, z0 + t, 5)):
        for i in range(count):
            dishes.lathe([(0, 0), (0.06, 0), (0.1, 0.014), (0.096, 0.015), (0, 0.006)],
                         (x, 5.83, z + 0.012 * i), 18)  # fmt: skip
    for i in range(5):
        dishes.cylinder((0.2 + 0.13 * i, 5.82, (z0 + z1) / 2 + t / 2), 0.032, 0.1, 12, None, 0.038)
    place("Dishes", dishes, PATH)


def add_fridge() -> None:
    """Add a fridge, hollow, with shelves, food, a bottle, and a door on its left hinge."""
    box = plan.FURNITURE["Fridge"]
    width, depth, height = box.x1 - box.x0, box.y1 - box.y0, box.z1 - FLOOR
    door, wall = 0.06, 0.035
    b = MeshBuilder("white plastic")
    b.box((0, door, 0.06), (wall, depth, height), 0.004)
    b.box((width - wall, door, 0.06), (width, depth, height), 0.004)
    b.box((wall, door, height - wall), (width - wall, depth, height), 0.004)
    b.box((wall, depth - wall, 0.06), (width - wall, depth, height - wall), 0.0)
    b.box((wall, door, 0.06), (width - wall, depth - wall, 0.12), 0.0)
    b.box((0.03, door + 0.03, 0), (width - 0.03, depth, 0.06), 0.0, "black plastic")
    for z in (0.42, 0.75, 1.05, 1.35, 1.6):
        b.box((wall, door + 0.03, z), (width - wall, depth - wall, z + 0.008), 0.0, "frosted glass")
    fridge = place("Fridge", b, PATH, (box.x0, box.y0, FLOOR))
    food = MeshBuilder("milk")
    for x in (0.12, 0.2):
        food.box((x - 0.035, 0.2, 0.76), (x + 0.035, 0.27, 0.95), 0.004, "milk")
        food.box((x - 0.0355, 0.199, 0.82), (x + 0.0355, 0.271, 0.87), 0.0, "blue")
    food.cylinder((0.34, 0.28, 0.758), 0.045, 0.14, 14, "yellow")
    food.cylinder((0.46, 0.3, 0.758), 0.035, 0.11, 14, "red")
    food.box((0.1, 0.15, 1.058), (0.3, 0.36, 1.12), 0.01, "orange")
    food.cylinder((0.42, 0.26, 1.058), 0.06, 0.08, 16, "green")
    food.box((0.12, 0.16, 1.358), (0.45, 0.4, 1.43), 0.01, "paper")
    for x in (0.15, 0.28, 0.41):
        food.lathe([(0, 0), (0.03, 0.01), (0.042, 0.04), (0.03, 0.07), (0, 0.075)],
                   (x, 0.28, 0.428), 10, ("red", "green", "orange")[int(x * 7) % 3])  # fmt: skip
    place("Food", food, PATH, parent=fridge)
    d = MeshBuilder("white plastic")
    d.box((0.002, 0.0, 0.08), (width - 0.002, door - 0.006, height - 0.002), 0.012)
    d.box((0.03, door - 0.008, 0.11), (width - 0.03, door - 0.001, height - 0.03), 0.0,
          "grey plastic")  # fmt: skip
    d.rod((width - 0.05, -0.035, 0.85), (width - 0.05, -0.035, 1.35), 0.009, 8, "steel")
    for z in (0.88, 1.32):
        d.rod((width - 0.05, 0, z), (width - 0.05, -0.035, z), 0.007, 8, "steel")
    obj = place("Fridge door", d, PATH, (box.x0, box.y0, FLOOR))
    obj["open_yaw"] = radians(-105.0)
    bottle = MeshBuilder("green")
    bottle.lathe(
        [(0, 0), (0.030, 0), (0.034, 0.006), (0.034, 0.13), (0.028, 0.16), (0.014, 0.19),
         (0.013, 0.215), (0.015, 0.217), (0.015, 0.23), (0, 0.23)], segments=16,
    )  # fmt: skip
    bottle.cylinder((0, 0, 0.035), 0.0345, 0.075, 16, "paper")
    place("Bottle", bottle, PATH, (3.17, 5.53, 0.816))


def add_table() -> None:
    """Add the breakfast table at the window, things on worktop and sill."""
    box = plan.FURNITURE["Kitchen table"]
    at = ((box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2, FLOOR)
    small = place("Kitchen table", table(0.75, 0.7, 0.74, "pine"), PATH, at)
    mesh = chair("fabric mustard").build("Kitchen chair")
    for i, yaw in ((1, 0.0), (2, 90.0)):
        c = plan.FURNITURE[f"Kitchen chair {i}"]
        place(f"Kitchen chair {i}", mesh, PATH,
              ((c.x0 + c.x1) / 2, (c.y0 + c.y1) / 2, FLOOR), yaw)  # fmt: skip
    cup = MeshBuilder("ceramic")
    cup.lathe([(0, 0), (0.03, 0), (0.038, 0.09), (0.034, 0.09), (0.028, 0.01), (0, 0.01)],
              segments=18)  # fmt: skip
    cup.tube([(0.036, 0, 0.075), (0.06, 0, 0.065), (0.06, 0, 0.035), (0.034, 0, 0.02)], 0.005, 6)
    cup_mesh = cup.build("Cup")
    place("Cup", cup_mesh, PATH, (0.1, 0.05, 0.74), 30.0, small)
    place("Cup worktop", cup_mesh, PATH, (1.4, 5.55, TOP_Z), -60.0)
    herbs = plant(11, 0.28, 14, 0.06, 0.11, "white paint", 0.035, "leaf light").build("Herbs")
    for i, y in enumerate((3.62, 4.95)):
        place(f"Herbs {i + 1}", herbs, PATH, (-0.1, y, plan.WINDOW_SILL + 0.022), 70.0 * i)
    kettle = MeshBuilder("steel")
    kettle.lathe([(0, 0), (0.085, 0), (0.09, 0.01), (0.065, 0.18), (0.03, 0.2), (0, 0.205)],
                 segments=20)  # fmt: skip
    kettle.tube([(0.06, 0, 0.18), (0.12, 0, 0.18), (0.125, 0, 0.1), (0.085, 0, 0.04)], 0.01, 8,
                "black plastic")  # fmt: skip
    place("Kettle", kettle, PATH, (0.35, 5.75, TOP_Z))
    board = MeshBuilder("pine")
    board.box((-0.17, -0.115, 0), (0.17, 0.115, 0.018), 0.006)
    board.cushion((-0.1, -0.05, 0.018), (0.12, 0.05, 0.1), 0.04, 0.0, "oak", 2)
    place("Bread board", board, PATH, (2.6, 5.66, TOP_Z), 8.0)


def add_kitchen() -> None:
    """Add all objects of this module."""
    add_base()
    add_stove()
    add_wall_cupboards()
    add_fridge()
    add_table()
