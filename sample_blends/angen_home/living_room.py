# SPDX-License-Identifier: GPL-3.0-or-later
"""Living room: sofa group, television, dining table, bookcase, curtains, plants."""

from random import Random

from . import plan
from .common import (
    FLOOR,
    books,
    chair,
    curtain,
    picture,
    plant,
    shelf_unit,
    table,
)
from .meshes import MeshBuilder, place

PATH = "Home/Furniture/Living room"


def _middle(name: str) -> tuple[float, float, float]:
    """Return the centre of a piece of furniture on the floor."""
    box = plan.FURNITURE[name]
    return ((box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2, FLOOR)


def add_sofa() -> None:
    """Add a sofa for two with its back to the north wall, with cushions as separate objects."""
    at = _middle("Sofa")
    seat, deck = plan.SOFA_SEAT_Z - FLOOR, 0.30 - FLOOR
    b = MeshBuilder("fabric grey blue")
    b.box((-0.925, -0.44, 0.1), (0.925, 0.46, deck), 0.02)
    for s in (-1, 1):
        b.cushion((s * 0.925, -0.46, 0.1), (s * 0.775, 0.46, 0.56), 0.06, 0.008)
    b.cushion((-0.8, 0.28, 0.12), (0.8, 0.46, 0.74), 0.06, 0.01)
    for x in (-0.86, 0.86):
        for y in (-0.38, 0.38):
            b.cylinder((x, y, 0.0), 0.02, 0.1, 10, "oak z", 0.026)
    sofa = place("Sofa", b, PATH, at)
    for name, x in (("west", -0.3875), ("east", 0.3875)):
        c = MeshBuilder("fabric grey blue")
        c.cushion((x - 0.385, -0.45, deck + 0.012), (x + 0.385, 0.24, seat), 0.045, 0.006)
        place(f"Sofa seat cushion {name}", c, PATH, parent=sofa)
        c = MeshBuilder("fabric grey blue")
        c.cushion((x - 0.38, 0.14, seat), (x + 0.38, 0.30, seat + 0.37), 0.06, 0.025)
        place(f"Sofa back cushion {name}", c, PATH, parent=sofa)
    for name, x, cloth, yaw in (
        ("mustard", 0.58, "fabric mustard", 14.0), ("rust", -0.62, "fabric rust", -12.0),
    ):  # fmt: skip
        c = MeshBuilder(cloth)
        c.cushion((-0.22, -0.018, 0.0), (0.22, 0.018, 0.42), 0.018, 0.065, None, 7)
        obj = place(f"Pillow {name}", c, PATH, (x, 0.06, seat + 0.02), yaw, sofa)
        obj.rotation_euler.x = -0.22


def add_coffee_table() -> None:
    """Add a low table with a bowl, a book and a cup on a rug."""
    x, y, z = _middle("Coffee table")
    b = MeshBuilder("oak")
    b.box((-0.5, -0.275, 0.385), (0.5, 0.275, 0.415), 0.01)
    b.box((-0.46, -0.235, 0.14), (0.46, 0.235, 0.158), 0.005)
    for sx in (-1, 1):
        for sy in (-1, 1):
            b.cylinder((sx * 0.44, sy * 0.215, 0), 0.018, 0.39, 10, "oak z", 0.024)
    top = place("Coffee table", b, PATH, (x, y, z))
    b = MeshBuilder("blue ceramic")
    b.lathe([(0, 0.012), (0.05, 0), (0.06, 0.0), (0.13, 0.07), (0.125, 0.072), (0.05, 0.02),
             (0, 0.018)], segments=24)  # fmt: skip
    for k, (ax, ay) in enumerate(((0.03, 0.02), (-0.04, 0.03), (0.0, -0.045))):
        fruit = ("orange", "green", "red")[k]
        b.lathe([(0, 0), (0.025, 0.008), (0.036, 0.034), (0.026, 0.06), (0, 0.066)],
                (ax, ay, 0.025), 12, fruit)  # fmt: skip
    place("Fruit bowl", b, PATH, (-0.12, 0.02, 0.415), parent=top)
    b = MeshBuilder("paper")
    b.box((-0.11, -0.15, 0), (0.11, 0.15, 0.018), 0.002, "fabric rust")
    b.box((-0.1, -0.13, 0.018), (0.1, 0.13, 0.034), 0.002, "fabric grey blue")
    place("Magazines", b, PATH, (0.27, 0.03, 0.415), 12.0, top)
    rug = MeshBuilder("rug")
    rug.box((-1.3, -0.9, 0), (1.3, 0.9, 0.01), 0.004)
    place("Rug living room", rug, PATH, (x, y + 0.1, FLOOR))


def add_television() -> None:
    """Add a bench with drawers, the screen and a small speaker."""
    x, y, z = _middle("TV bench")
    b = MeshBuilder("oak")
    b.box((-0.75, -0.2, 0.13), (0.75, 0.2, 0.5), 0.006)
    b.box((-0.235, 0.2, 0.16), (0.235, 0.215, 0.47), 0.004, "black plastic")
    for sx in (-0.66, 0.66):
        for sy in (-0.14, 0.14):
            b.cylinder((sx, sy, 0), 0.014, 0.13, 8, "black metal", 0.02)
    bench = place("TV bench", b, PATH, (x, y, z))
    for s, side in ((-1, "left"), (1, "right")):
        drawer, x = MeshBuilder("lacquer"), s * 0.493
        drawer.box((x - 0.235, 0.2, 0.16), (x + 0.235, 0.215, 0.47), 0.004)
        # Its box, which is inside the bench.
        drawer.box((x - 0.22, -0.16, 0.18), (x + 0.22, 0.199, 0.19), 0.0, "oak")
        for edge in (x - 0.22, x + 0.21):
            drawer.box((edge, -0.16, 0.19), (edge + 0.01, 0.199, 0.41), 0.0, "oak")
        drawer.box((x - 0.21, -0.16, 0.19), (x + 0.21, -0.15, 0.41), 0.0, "oak")
        place(f"TV bench drawer {side}", drawer, PATH, parent=bench, hinge=(x, 0.2, 0.16))
    b = MeshBuilder("black plastic")
    b.box((-0.56, -0.02, 0.07), (0.56, 0.012, 0.71), 0.006)
    b.box((-0.548, 0.012, 0.084), (0.548, 0.0135, 0.698), 0, "television")
    b.box((-0.05, -0.03, 0.015), (0.05, -0.01, 0.2), 0.004)
    b.box((-0.2, -0.1, 0), (0.2, 0.1, 0.014), 0.005)
    place("Television", b, PATH, (0, -0.02, 0.5), parent=bench)
    b = MeshBuilder("fabric grey")
    b.cushion((-0.06, -0.06, 0), (0.06, 0.06, 0.17), 0.03, 0.0, None, 2)
    place("Speaker living room", b, PATH, (0.65, 0.0, 0.5), parent=bench)


def add_dining() -> None:
    """Add a table for four under the pendant lamp."""
    at = _middle("Dining table")
    dining = place("Dining table", table(1.3, 0.8, 0.74), PATH, at)
    mesh = chair("fabric grey").build("Dining chair")
    for i in range(1, 5):
        x, y, z = _middle(f"Dining chair {i}")
        # The north chairs face south, the south chairs north.
        place(f"Dining chair {i}", mesh, PATH, (x, y, z), 180.0 if i < 3 else 0.0)
    b = MeshBuilder("blue ceramic")
    b.lathe([(0, 0), (0.045, 0), (0.065, 0.07), (0.05, 0.16), (0.025, 0.19), (0.03, 0.22),
             (0.024, 0.22), (0.02, 0.19), (0, 0.1)], segments=20)  # fmt: skip
    rnd = Random(4)
    for _ in range(9):
        dx, dy = rnd.uniform(-0.09, 0.09), rnd.uniform(-0.09, 0.09)
        h = rnd.uniform(0.32, 0.42)
        b.tube([(0, 0, 0.12), (dx * 0.3, dy * 0.3, 0.25), (dx, dy, h)], 0.003, 5, "leaf")
        b.lathe([(0, 0), (0.016, 0.006), (0.024, 0.022), (0.014, 0.032), (0, 0.03)],
                (dx, dy, h - 0.01), 8, "flower" if rnd.random() < 0.6 else "yellow")  # fmt: skip
    place("Flowers", b, PATH, (0.0, 0.02, 0.74), parent=dining)
    runner = MeshBuilder("linen")
    runner.box((-0.5, -0.16, 0), (0.5, 0.16, 0.003), 0.001)
    place("Table runner", runner, PATH, (0, 0, 0.74), parent=dining)


def add_bookcase() -> None:
    """Add five boards of books and things."""
    box = plan.FURNITURE["Bookcase"]
    x, z = (box.x0 + box.x1) / 2, FLOOR
    depth, height = box.y1 - box.y0, box.z1 - FLOOR
    b = shelf_unit(1.0, depth, height, 6, "oak")
    for i in range(5):
        low = 0.05 + (height - 0.072) * i / 5 + 0.022
        start, end = ((-0.47, 0.2), (-0.12, 0.46), (-0.47, 0.46), (-0.47, 0.05), (-0.3, 0.3))[i]
        books(b, start, end, low, depth - 0.02, 0.03, 10 + i)
    place("Bookcase", b, PATH, (x, box.y0, z))
    level = [FLOOR + 0.05 + (height - 0.072) * i / 5 + 0.022 for i in range(6)]
    b = MeshBuilder("wicker")
    b.cushion((-0.14, -0.11, 0), (0.14, 0.11, 0.2), 0.03, 0.0, None, 2)
    place("Basket", b, PATH, (x + 0.33, box.y0 + 0.15, level[0]))
    place("Plant bookcase", plant(7, 0.3, 12, 0.06, 0.1, "white paint", 0.04, "leaf light"), PATH,
          (x - 0.32, box.y0 + 0.16, level[5]))  # fmt: skip
    b = MeshBuilder("blue ceramic")
    b.lathe([(0, 0), (0.05, 0), (0.08, 0.09), (0.04, 0.17), (0.03, 0.2), (0.035, 0.21)],
            segments=18)  # fmt: skip
    place("Vase bookcase", b, PATH, (x + 0.3, box.y0 + 0.15, level[3]))


def add_decoration() -> None:
    """Add curtains, plants, pictures."""
    window = next(w for w in plan.WINDOWS if w.name == "living room")
    face = window.x0
    rail = MeshBuilder("black metal")
    rail.rod((0, window.y0 - 0.3, 0), (0, window.y1 + 0.1, 0), 0.011, 10)
    for y in (window.y0 - 0.22, window.y1 + 0.06):
        rail.rod((0, y, 0), (0.09, y, 0), 0.007, 6)
    place("Curtain rail", rail, PATH, (face - 0.09, 0, 2.42))
    height = 2.42 - FLOOR - 0.02
    mesh = curtain(0.42, height, 5, 0.035, "linen").build("Curtain")
    place("Curtain south", mesh, PATH, (face - 0.09, window.y0 - 0.28, FLOOR + 0.02), 90.0)
    place("Curtain north", mesh, PATH, (face - 0.09, window.y1 - 0.34, FLOOR + 0.02), 90.0)
    x, y, z = _middle("Plant living room")
    tall = plant(3, 1.35, 22, 0.17, 0.32, "terracotta", 0.13, reach=0.28)
    place("Plant living room", tall, PATH, (x, y, z))
    for name, px, size, what in (
        ("sea", 8.55, (0.5, 0.7), "print a"), ("dunes", 9.15, (0.5, 0.7), "print b"),
        ("meadow", 9.75, (0.5, 0.7), "print c"),
    ):  # fmt: skip
        place(f"Picture {name}", picture(*size, what), PATH, (px, 6.998, 1.62))
    place("Picture dining", picture(0.9, 0.6, "print b", "oak"), PATH, (7.6, 3.002, 1.6), 180.0)


def add_living_room() -> None:
    """Add all objects of this module."""
    add_sofa()
    add_coffee_table()
    add_television()
    add_dining()
    add_bookcase()
    add_decoration()
