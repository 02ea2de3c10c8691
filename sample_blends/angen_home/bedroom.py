# SPDX-License-Identifier: GPL-3.0-or-later
"""Bedroom: bed, shelves, desk with laptop and lamp, armchair."""

from math import cos, sin

from . import plan
from .common import FLOOR, books, chair, curtain, picture, plant, shelf_unit, table_lamp
from .meshes import MeshBuilder, place

PATH = "Home/Furniture/Bedroom"


def add_bed() -> None:
    """Add a wide bed with its head at the east wall: frame, mattress, duvet, two pillows."""
    box = plan.FURNITURE["Bed"]
    x0, y0, x1, y1 = box.x0, box.y0, box.x1, box.y1
    b = MeshBuilder("oak")
    b.box((x1 - 0.05, y0, FLOOR), (x1, y1, box.z1), 0.015, "oak y")
    b.box((x0, y0, FLOOR + 0.16), (x0 + 0.04, y1, FLOOR + 0.32), 0.01, "oak y")
    for y in (y0, y1 - 0.035):
        b.box((x0 + 0.04, y, FLOOR + 0.16), (x1 - 0.05, y + 0.035, FLOOR + 0.32), 0.008)
    for x in (x0 + 0.03, x1 - 0.2):
        for y in (y0 + 0.04, y1 - 0.1):
            b.box((x, y, FLOOR), (x + 0.06, y + 0.06, FLOOR + 0.17), 0.005, "oak z")
    b.box((x0 + 0.04, y0 + 0.035, FLOOR + 0.22), (x1 - 0.05, y1 - 0.035, FLOOR + 0.27), 0.0)
    bed = place("Bed", b, PATH)
    m = MeshBuilder("linen")
    top = plan.BED_TOP_Z - 0.03
    m.cushion((x0 + 0.05, y0 + 0.04, FLOOR + 0.27), (x1 - 0.06, y1 - 0.04, top), 0.05, 0.004)
    place("Mattress", m, PATH, parent=bed)
    d = MeshBuilder("duvet")

    def cover(u: float, v: float) -> tuple[float, float, float]:
        x = x0 + 0.06 + u * 1.4
        y = y0 + 0.0 + v * (y1 - y0)
        edge = min(v, 1 - v)
        drop = max(0.0, 1 - edge / 0.07)
        wave = 0.008 * sin(9 * u + 3 * v) + 0.006 * sin(17 * v + 4 * u)
        fold = 0.035 * max(0.0, 1 - (1 - u) / 0.09) if drop < 0.9 else 0.0
        return (x, y + 0.012 * sin(11 * u) * drop, top + 0.035 + wave + fold - 0.2 * drop**2)

    d.surface(cover, 30, 28)
    place("Duvet", d, PATH, parent=bed)
    pillow = MeshBuilder("linen")
    pillow.cushion((-0.2, -0.3, 0), (0.2, 0.3, 0.1), 0.05, 0.03)
    mesh = pillow.build("Pillow")
    for name, y in (("south", 0.7), ("north", 1.4)):
        obj = place(f"Pillow {name}", mesh, PATH, (x1 - 0.29, y, top + 0.015), 3.0, bed)
        obj.rotation_euler.y = -0.16
    throw = MeshBuilder("fabric mustard")

    def blanket(u: float, v: float) -> tuple[float, float, float]:
        x, y, z = cover(0.03 + 0.3 * u, v)
        return (x, y + (0.006 if v > 0.5 else -0.006), z + 0.012)

    throw.surface(blanket, 8, 28)
    place("Throw", throw, PATH, parent=bed)


def add_desk() -> None:
    """Add the desk at the window with laptop, lamp and chair; a vase on the sill."""
    box = plan.FURNITURE["Bedroom desk"]
    b = MeshBuilder("pine y")
    b.box((box.x0, box.y0, box.z1 - 0.03), (box.x1, box.y1, box.z1), 0.005)
    for y in (box.y0 + 0.05, box.y1 - 0.09):
        for x in (box.x0 + 0.04, box.x1 - 0.08):
            b.box((x, y, FLOOR), (x + 0.04, y + 0.04, box.z1 - 0.03), 0.004, "white paint")
    b.box((box.x0 + 0.03, box.y1 - 0.42, box.z1 - 0.16), (box.x1 - 0.03, box.y1 - 0.05,
          box.z1 - 0.03), 0.004, "white paint")  # fmt: skip
    place("Bedroom desk", b, PATH)
    b = MeshBuilder("grey plastic")
    b.box((-0.12, -0.16, 0), (0.12, 0.16, 0.014), 0.004, "steel")
    b.box((-0.06, -0.14, 0.0135), (0.05, 0.14, 0.0155), 0.0, "black plastic")
    lean = 0.3
    for side, what, off in ((1, "screen", 0.001), (-1, "steel", -0.006)):
        ring = []
        for y, h in ((-0.16, 0.0), (0.16, 0.0), (0.16, 0.215), (-0.16, 0.215)):
            inset = 0.0 if what == "steel" else 0.006 * (1 if h == 0 else -1)
            up = h + inset
            wide = y * (1 if what == "steel" else 0.96)
            ring.append((off - 0.12 - sin(lean) * up, wide, 0.012 + cos(lean) * up))
        b.polygon(ring if side > 0 else ring[::-1], what)
    place("Laptop", b, PATH, (0.4, 2.12, box.z1))
    place("Desk lamp bedroom", table_lamp(0.46), PATH, (0.4, 2.6, box.z1))
    place("Bedroom vase", plant(21, 0.45, 10, 0.07, 0.17, "blue ceramic", 0.045), PATH,
          (-0.1, 2.53, plan.WINDOW_SILL + 0.022))  # fmt: skip
    c = plan.FURNITURE["Bedroom chair"]
    place("Bedroom chair", chair("fabric green"), PATH,
          ((c.x0 + c.x1) / 2, (c.y0 + c.y1) / 2, FLOOR), 90.0)  # fmt: skip


def add_shelves() -> None:
    """Add two shelves side by side with books, boxes and a plant."""
    for i, seed in ((1, 31), (2, 52)):
        box = plan.FURNITURE[f"Bedroom shelf {i}"]
        width, depth, height = box.x1 - box.x0, box.y1 - box.y0, box.z1 - FLOOR
        b = shelf_unit(width, depth, height, 5, "pine")
        level = [0.05 + (height - 0.072) * k / 4 + 0.022 for k in range(4)]
        half = width / 2 - 0.03
        for k in range(4):
            start, end = ((-half, half), (-half, 0.1), (-0.1, half), (-half, half * 0.6))[
                (k + i) % 4
            ]
            books(b, start, end, level[k], depth - 0.02, 0.02, seed + k, 0.28)
        for x, k in ((0.3, (5 - i) % 4),) if i == 1 else ((-0.33, 0), (0.33, 3)):
            b.box((x - 0.13, 0.02, level[k]), (x + 0.13, 0.3, level[k] + 0.2), 0.006, "wicker")
        place(f"Bedroom shelf {i}", b, PATH, ((box.x0 + box.x1) / 2, box.y0, FLOOR))
    place("Plant shelf", plant(9, 0.34, 14, 0.075, 0.13, "white paint", 0.05), PATH,
          (1.6, 2.8, plan.FURNITURE["Bedroom shelf 1"].z1))  # fmt: skip


def add_armchair() -> None:
    """Add a soft chair in the corner, turned into the room."""
    box = plan.FURNITURE["Armchair"]
    b = MeshBuilder("fabric green")
    b.cushion((-0.26, -0.2, 0.26), (0.26, 0.32, 0.42), 0.06, 0.015)
    b.cushion((-0.28, -0.32, 0.24), (0.28, -0.16, 0.92), 0.07, 0.02)
    for s in (-1, 1):
        b.cushion((s * 0.34, -0.3, 0.2), (s * 0.24, 0.28, 0.58), 0.05, 0.005)
        for y in (-0.25, 0.22):
            b.cylinder((s * 0.26, y, 0), 0.014, 0.24, 8, "oak z", 0.02)
    place("Armchair", b, PATH, ((box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2, FLOOR), -40.0)


def add_bedroom() -> None:
    """Add all objects of this module."""
    add_bed()
    add_desk()
    add_shelves()
    add_armchair()
    rug = MeshBuilder("fabric cream")
    rug.box((-0.75, -0.3, 0), (0.75, 0.3, 0.012), 0.005)
    place("Rug bedroom", rug, PATH, (2.35, 2.2, FLOOR))
    window = plan.WINDOWS[0]
    rail = MeshBuilder("black metal")
    rail.rod((0.06, window.y0 - 0.25, 0), (0.06, window.y1 + 0.25, 0), 0.01, 8)
    for y in (window.y0 - 0.2, window.y1 + 0.2):
        rail.rod((0, y, 0), (0.06, y, 0), 0.007, 6)
    place("Curtain rail bedroom", rail, PATH, (0, 0, 2.38))
    mesh = curtain(0.3, 1.6, 4, 0.028, "fabric cream").build("Curtain short")
    place("Curtain bedroom south", mesh, PATH, (0.06, window.y0 - 0.22, 0.77), 90.0)
    place("Curtain bedroom north", mesh, PATH, (0.06, window.y1 - 0.06, 0.77), 90.0)
    place("Picture bedroom", picture(1.0, 0.5, "print a", "oak"), PATH, (3.498, 1.05, 1.55), -90.0)
