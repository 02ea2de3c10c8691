# SPDX-License-Identifier: GPL-3.0-or-later
"""Hall, balcony and landing: coat hooks, bench, cabinet, mats, chairs and plants outside."""

from math import cos, pi, sin

from . import plan
from .common import FLOOR, picture, plant
from .meshes import MeshBuilder, place

HALL = "Home/Furniture/Hall"
BALCONY = "Home/Furniture/Balcony"


def _coat(cloth: str, length: float, swing: float) -> MeshBuilder:
    """Return a hanging coat with sleeves; hook at the origin, the wall towards +x."""
    b = MeshBuilder(cloth)

    def body(u: float, v: float) -> tuple[float, float, float]:
        # Around the coat (u) from collar to hem (v).
        t = 2 * pi * u
        wide = 0.05 + 0.16 * min(1.0, v * 5) ** 0.6 + 0.05 * v
        deep = 0.03 + 0.055 * min(1.0, v * 4) + 0.03 * v
        fold = 1 + 0.09 * v * sin(6 * t + swing)
        return (-0.115 + deep * cos(t) * fold, wide * sin(t) * fold, -0.02 - length * v)

    b.surface(body, 28, 10)
    for s in (-1, 1):
        b.tube(
            [(-0.115, 0.15 * s, -0.1), (-0.12, 0.215 * s, -0.25), (-0.125, 0.235 * s, -0.45),
             (-0.13, 0.24 * s, -0.66)], 0.05, 10,
        )  # fmt: skip
    b.tube([(-0.06, -0.06, -0.03), (-0.12, -0.075, -0.0), (-0.15, 0.0, -0.01),
            (-0.12, 0.075, 0.0), (-0.06, 0.06, -0.03)], 0.022, 8)  # fmt: skip
    b.tube([(-0.1, 0, -0.01), (-0.07, 0, 0.02), (-0.05, 0, 0.0)], 0.004, 5, "black metal")
    return b


def add_hall() -> None:
    """Add hooks with a coat, bench with shoes, cabinet, mirror, mats."""
    wall = 6.2
    hooks = MeshBuilder("oak y")
    hooks.box((wall - 0.022, 7.1, 1.62), (wall, 8.2, 1.72), 0.005)
    for y in (7.2, 7.4, 7.6, 7.8, 7.98, 8.12):
        hooks.tube([(wall - 0.02, y, 1.69), (wall - 0.07, y, 1.68), (wall - 0.085, y, 1.71)],
                   0.007, 8, "black metal")  # fmt: skip
        hooks.tube([(wall - 0.02, y, 1.65), (wall - 0.05, y, 1.63), (wall - 0.055, y, 1.65)],
                   0.006, 8, "black metal")  # fmt: skip
    hooks.box((wall - 0.24, 7.1, 1.86), (wall, 8.2, 1.88), 0.004)
    for y in (7.2, 8.1):
        hooks.box((wall - 0.2, y - 0.01, 1.72), (wall, y + 0.01, 1.86), 0.003)
    place("Coat hooks", hooks, HALL)
    place("Coat", _coat("fabric coat", 0.95, 0.0), HALL, (wall - 0.015, 7.98, 1.70))
    place("Jacket", _coat("fabric rust", 0.66, 1.4), HALL, (wall - 0.015, 7.4, 1.70))
    hat = MeshBuilder("fabric grey")
    hat.lathe([(0.0, 0.0), (0.15, 0.0), (0.155, 0.008), (0.09, 0.015), (0.085, 0.08), (0.06, 0.11),
               (0, 0.11)], segments=24)  # fmt: skip
    place("Hat", hat, HALL, (wall - 0.13, 7.75, 1.88))
    box = plan.FURNITURE["Shoe bench"]
    b = MeshBuilder("oak y")
    x0, x1, y0, y1 = box.x0, box.x1, box.y0, box.y1
    b.box((x0, y0, box.z1 - 0.065), (x1, y1, box.z1 - 0.04), 0.005)
    b.cushion((x0 + 0.01, y0 + 0.01, box.z1 - 0.04), (x1 - 0.01, y1 - 0.01, box.z1), 0.02, 0.004,
              "fabric grey", 3)  # fmt: skip
    b.box((x0 + 0.02, y0 + 0.02, 0.2), (x1, y1 - 0.02, 0.22), 0.003)
    for y in (y0 + 0.02, y1 - 0.045):
        b.box((x0 + 0.01, y, FLOOR), (x1, y + 0.025, box.z1 - 0.065), 0.004, "oak z")
    place("Shoe bench", b, HALL)
    shoe = MeshBuilder("black plastic")
    for s in (-0.055, 0.055):
        shoe.cushion((-0.13, s - 0.042, 0), (0.13, s + 0.042, 0.055), 0.027, 0, "fabric rust", 2)
        shoe.cushion((-0.13, s - 0.038, 0.03), (0.01, s + 0.038, 0.1), 0.03, 0, "fabric rust", 2)
    mesh = shoe.build("Shoes")
    place("Shoes", mesh, HALL, (6.03, 7.22, FLOOR), 180.0)
    place("Shoes on the board", mesh, HALL, (6.04, 7.42, 0.22), 176.0)
    _cabinet()
    runner = MeshBuilder("runner")
    runner.box((-0.4, -1.6, 0), (0.4, 1.6, 0.004), 0.001)
    place("Runner hall", runner, HALL, (4.85, 4.9, FLOOR))
    mat = MeshBuilder("mat")
    mat.box((-0.4, -0.25, 0), (0.4, 0.25, 0.004), 0.001)
    mesh = mat.build("Door mat")
    place("Door mat inside", mesh, HALL, (4.93, 7.95, FLOOR))
    place("Door mat outside", mesh, HALL, (4.93, 8.8, FLOOR))
    landing = plan.FURNITURE["Landing plant"]
    place("Landing plant", plant(33, 1.1, 16, 0.14, 0.28, "white paint", 0.11, reach=0.24), HALL,
          ((landing.x0 + landing.x1) / 2, (landing.y0 + landing.y1) / 2, FLOOR))  # fmt: skip
    place("Picture hall", picture(0.7, 0.5, "print a", "oak"), HALL, (5.85, 3.002, 1.6), 180.0)


def _cabinet() -> None:
    """Add a slim cabinet with a bowl for keys under a round mirror."""
    box = plan.FURNITURE["Hall cabinet"]
    width, depth, height = box.y1 - box.y0, box.x1 - box.x0 - 0.014, box.z1 - FLOOR
    b = MeshBuilder("oak")
    b.box((-width / 2, 0, 0.14), (width / 2, depth, height), 0.006)
    for s in (-1, 1):
        b.cylinder((s * 0.36, depth / 2, 0), 0.014, 0.14, 8, "black metal", 0.02)
    # Built facing −y; stands with its back to the wall at x = 3.7.
    cabinet = place("Hall cabinet", b, HALL, (box.x1 - 0.012, (box.y0 + box.y1) / 2, FLOOR), 90.0)
    for s, side in ((-1, "left"), (1, "right")):
        door, edge = MeshBuilder("lacquer"), s * (width / 2 - 0.012)
        door.box((s * 0.005, -0.012, 0.16), (edge, 0, height - 0.03), 0.004)
        door.tube([(s * 0.04, -0.012, 0.55), (s * 0.04, -0.03, 0.55)], 0.012, 10, "brass")
        place(f"Hall cabinet door {side}", door, HALL, parent=cabinet, hinge=(edge, 0, 0.16))
    bowl = MeshBuilder("blue ceramic")
    bowl.lathe([(0, 0.008), (0.03, 0), (0.04, 0), (0.085, 0.04), (0.08, 0.04), (0.03, 0.012),
                (0, 0.012)], segments=20)  # fmt: skip
    bowl.tube([(-0.03, 0, 0.02), (0.03, 0.01, 0.025)], 0.006, 6, "brass")
    place("Key bowl", bowl, HALL, (0.2, 0.14, height), parent=cabinet)
    mirror = MeshBuilder("brass")
    mirror.tube([(0, 0.0, 0), (0, -0.022, 0)], 0.33, 40)
    mirror.tube([(0, -0.02, 0), (0, -0.0235, 0)], 0.315, 40, "mirror")
    place("Mirror hall", mirror, HALL, (3.7, (box.y0 + box.y1) / 2, 1.55), 90.0)
    small = plant(41, 0.34, 12, 0.06, 0.11, "white paint", 0.045)
    place("Plant hall", small, HALL, (-0.28, 0.14, height), parent=cabinet)


def add_balcony() -> None:
    """Add a slatted chair, a small table, plants in pots."""
    box = plan.FURNITURE["Balcony chair"]
    b = MeshBuilder("pine")
    for s in (-1, 1):
        b.tube([(s * 0.26, 0.26, 0), (s * 0.26, 0.22, 0.56)], 0.016, 8, "black metal")
        b.tube([(s * 0.26, -0.28, 0), (s * 0.26, -0.2, 0.42), (s * 0.26, -0.27, 0.84)], 0.016, 8,
               "black metal")  # fmt: skip
        b.box((s * 0.26 - 0.03, -0.22, 0.56), (s * 0.26 + 0.03, 0.26, 0.58), 0.005, "pine y")
        b.rod((s * 0.26, 0.23, 0.4), (s * 0.26, -0.2, 0.4), 0.012, 6, "black metal")
    for i in range(6):
        y = -0.17 + 0.078 * i
        b.box((-0.26, y - 0.032, 0.405), (0.26, y + 0.032, 0.423), 0.004)
    for i in range(4):
        z = 0.5 + 0.095 * i
        y = -0.2 - 0.07 * (z - 0.42) / 0.42
        b.box((-0.26, y - 0.008, z), (0.26, y + 0.012, z + 0.07), 0.004)
    place("Balcony chair", b, BALCONY,
          ((box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2, FLOOR), -45.0)  # fmt: skip
    box = plan.FURNITURE["Balcony table"]
    b = MeshBuilder("black metal")
    b.cylinder((0, 0, 0.52), 0.22, 0.018, 28)
    b.rod((0, 0, 0.02), (0, 0, 0.52), 0.016, 10)
    b.cylinder((0, 0, 0), 0.14, 0.018, 20)
    place("Balcony table", b, BALCONY, ((box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2, FLOOR))
    for i, (x, y, seed, height, pot) in enumerate((
        (11.95, 3.3, 51, 1.2, "terracotta"), (11.72, 3.16, 52, 0.8, "white paint"),
        (11.98, 6.74, 53, 0.6, "blue ceramic"),
    )):  # fmt: skip
        name = f"Balcony plant {i + 1}"
        size = 0.17 - 0.025 * i
        green = "leaf" if i % 2 == 0 else "leaf light"
        reach = 0.26 - 0.05 * i
        grown = plant(seed, height, 18 - 3 * i, size, 0.3 - 0.05 * i, pot, 0.08, green, reach)
        place(name, grown, BALCONY, (x, y, FLOOR))
