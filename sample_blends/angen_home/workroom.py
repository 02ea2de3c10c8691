# SPDX-License-Identifier: GPL-3.0-or-later
"""Workroom: two desks with computers, screens and speakers, office chairs, shelf."""

from math import cos, pi, sin

from . import plan
from .common import FLOOR, books, picture, plant, shelf_unit, table_lamp
from .meshes import MeshBuilder, moved, place

PATH = "Home/Furniture/Workroom"


def _screen() -> MeshBuilder:
    """Return a 25-inch screen on a foot that faces +y."""
    b = MeshBuilder("black plastic")
    b.lathe([(0, 0), (0.1, 0), (0.11, 0.006), (0.1, 0.012), (0, 0.014)], segments=20)
    b.box((-0.025, -0.03, 0.01), (0.025, -0.012, 0.3), 0.005)
    b.box((-0.28, -0.015, 0.12), (0.28, 0.012, 0.46), 0.006)
    b.box((-0.272, 0.012, 0.13), (0.272, 0.0132, 0.452), 0.0, "screen")
    return b


def _tower() -> MeshBuilder:
    """Return a computer standing on its long side, 0.5 × 0.2 × 0.5."""
    b = MeshBuilder("black plastic")
    b.box((-0.248, -0.098, 0), (0.248, 0.098, 0.5), 0.008)
    b.box((-0.18, 0.098, 0.06), (0.18, 0.1, 0.44), 0.002, "black glass")
    for z in (0.36, 0.4):
        b.box((0.2, 0.098, z), (0.235, 0.1005, z + 0.012), 0.001, "sensor green")
    return b


def _speaker() -> MeshBuilder:
    b = MeshBuilder("walnut z")
    b.box((-0.049, -0.051, 0), (0.049, 0.049, 0.24), 0.005)
    b.matrix = moved(0, 0.049, 0)
    for z, r in ((0.08, 0.038), (0.18, 0.02)):
        b.tube([(0, -0.002, z), (0, 0.002, z)], r, 18, "black plastic")
        b.tube([(0, 0.0015, z), (0, 0.003, z)], r * 0.55, 14, "grey plastic")
    b.matrix = moved()
    return b


def office_chair(cloth: str) -> MeshBuilder:
    """Return a swivel chair that faces +y, on z = 0."""
    b = MeshBuilder("black plastic")
    for k in range(5):
        a = 2 * pi * k / 5 + 0.3
        b.tube([(0, 0, 0.11), (0.27 * cos(a), 0.27 * sin(a), 0.07)], 0.018, 8)
        b.lathe([(0, 0), (0.02, 0.005), (0.028, 0.03), (0.02, 0.055), (0, 0.06)],
                (0.27 * cos(a), 0.27 * sin(a), 0), 10)  # fmt: skip
    b.cylinder((0, 0, 0.08), 0.03, 0.33, 12, "chrome")
    b.cushion((-0.23, -0.23, 0.40), (0.23, 0.24, 0.47), 0.035, 0.01, cloth)
    b.tube([(0, -0.18, 0.4), (0, -0.27, 0.44), (0, -0.28, 0.7)], 0.016, 8)
    b.cushion((-0.21, -0.29, 0.55), (0.21, -0.235, 0.98), 0.027, 0.015, cloth, 3)
    for s in (-1, 1):
        b.tube([(s * 0.2, 0, 0.41), (s * 0.27, -0.02, 0.45), (s * 0.27, -0.02, 0.64)], 0.013, 8)
        b.box((s * 0.27 - 0.03, -0.13, 0.64), (s * 0.27 + 0.03, 0.1, 0.665), 0.01)
    return b


def add_desks() -> None:
    """Add desks with computer, screen, two speakers, keyboard and mouse, as in the figures."""
    screen, tower = _screen().build("Screen"), _tower().build("Computer")
    speaker = _speaker().build("Speaker")
    keys = MeshBuilder("grey plastic")
    keys.box((-0.2, -0.06, 0), (0.2, 0.06, 0.016), 0.005, "black plastic")
    for row in range(4):
        y = -0.042 + 0.028 * row
        keys.box((-0.188, y - 0.011, 0.015), (0.188, y + 0.011, 0.02), 0.002)
    keyboard = keys.build("Keyboard")
    m = MeshBuilder("black plastic")
    m.cushion((-0.03, -0.05, 0), (0.03, 0.05, 0.034), 0.017, 0.0, None, 2)
    mouse = m.build("Mouse")
    for i, (computer_x, right_x, left_x) in enumerate(
        ((0.527, 0.445, 1.445), (2.287, 2.095, 3.295))
    ):
        n = i + 1
        box = plan.FURNITURE[f"Workroom desk {n}"]
        b = MeshBuilder("oak")
        b.box((box.x0, box.y0, box.z1 - 0.028), (box.x1, box.y1, box.z1), 0.005)
        for x in (box.x0 + 0.06, box.x1 - 0.1):
            b.box((x, box.y0 + 0.05, FLOOR), (x + 0.04, box.y0 + 0.09, box.z1 - 0.028), 0.004,
                  "black metal")  # fmt: skip
            b.box((x, box.y1 - 0.1, FLOOR), (x + 0.04, box.y1 - 0.06, box.z1 - 0.028), 0.004,
                  "black metal")  # fmt: skip
            b.box((x, box.y0 + 0.05, FLOOR), (x + 0.04, box.y1 - 0.06, FLOOR + 0.03), 0.004,
                  "black metal")  # fmt: skip
        place(f"Workroom desk {n}", b, PATH)
        z = box.z1
        place(f"Computer {n}", tower, PATH, (computer_x, 6.46, z))
        screen_x = computer_x + 0.553 if n == 1 else computer_x + 0.573
        place(f"Screen {n}", screen, PATH, (screen_x, 6.62, z))
        place(f"Speaker {n} right", speaker, PATH, (right_x, 6.745, z))
        place(f"Speaker {n} left", speaker, PATH, (left_x, 6.745, z))
        place(f"Keyboard {n}", keyboard, PATH, (screen_x, 6.87, z))
        place(f"Mouse {n}", mouse, PATH, (screen_x + 0.28, 6.87, z))
    for n, cloth, yaw in ((1, "fabric grey blue", 176.0), (2, "fabric rust", 168.0)):
        box = plan.FURNITURE[f"Office chair {n}"]
        place(f"Office chair {n}", office_chair(cloth), PATH,
              ((box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2, FLOOR), yaw)  # fmt: skip


def add_workroom() -> None:
    """Add all objects of this module."""
    add_desks()
    place("Window lamp workroom", table_lamp(0.62, "black metal"), PATH,
          (-0.13, 8.05, plan.WINDOW_SILL + 0.022))  # fmt: skip
    box = plan.FURNITURE["Workroom shelf"]
    width, depth, height = box.x1 - box.x0, box.y1 - box.y0, box.z1 - FLOOR
    b = shelf_unit(width, depth, height, 3, "oak")
    for k in range(2):
        z = 0.05 + (height - 0.072) * k / 2 + 0.022
        books(b, -width / 2 + 0.03, width / 2 - (0.1 if k else 0.5), z, depth - 0.02, 0.02, 71 + k)
    b.box((0.25, 0.02, 0.072), (0.6, 0.26, 0.3), 0.006, "wicker")
    place("Workroom shelf", b, PATH, ((box.x0 + box.x1) / 2, box.y0, FLOOR))
    printer = MeshBuilder("white plastic")
    printer.box((-0.2, -0.12, 0), (0.2, 0.12, 0.14), 0.02)
    printer.box((-0.15, -0.16, 0.03), (0.15, -0.1, 0.045), 0.004, "grey plastic")
    printer.box((-0.12, -0.155, 0.045), (0.12, -0.1, 0.05), 0.0, "paper")
    place("Printer", printer, PATH, (2.35, 8.15, box.z1))
    place("Plant workroom", plant(15, 0.45, 14, 0.08, 0.15, "blue ceramic", 0.06), PATH,
          (3.0, 8.16, box.z1))  # fmt: skip
    place("Picture workroom", picture(0.6, 0.8, "print c", "oak"), PATH, (2.6, 8.298, 1.65))
    rug = MeshBuilder("fabric grey")
    rug.box((-0.8, -0.35, 0), (0.8, 0.35, 0.01), 0.004)
    place("Rug workroom", rug, PATH, (1.75, 7.6, FLOOR))
