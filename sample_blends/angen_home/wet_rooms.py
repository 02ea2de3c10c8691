# SPDX-License-Identifier: GPL-3.0-or-later
"""Bathroom (toilet, washbasin, shower) and closet (washing machine, shelves)."""

from math import cos, pi, sin

from . import plan
from .common import FLOOR, curtain
from .meshes import MeshBuilder, moved, place

BATH = "Home/Furniture/Bathroom"
CLOSET = "Home/Furniture/Closet"


def _oval(b: MeshBuilder, rings: list[tuple[float, float, float, float]], material: str) -> None:
    """Add a body of oval rings (half width, half depth, y of the centre, z), open at both ends."""
    segments = 24

    def point(u: float, v: float) -> tuple[float, float, float]:
        a, d, y, z = rings[round(v * (len(rings) - 1))]
        t = 2 * pi * u
        return (a * cos(t), y + d * sin(t), z)

    b.surface(point, segments, len(rings) - 1, material)


def add_toilet() -> None:
    """Add a toilet with cistern that faces +y, its seat at the plan's seat height."""
    box = plan.FURNITURE["Toilet"]
    seat_z = plan.TOILET_SEAT_Z - FLOOR
    b = MeshBuilder("ceramic")
    _oval(b, [(0.11, 0.2, 0.36, 0.0), (0.105, 0.19, 0.36, 0.12), (0.13, 0.22, 0.38, 0.24),
              (0.175, 0.25, 0.39, 0.34), (0.183, 0.255, 0.39, seat_z - 0.03),
              (0.13, 0.2, 0.40, seat_z - 0.03), (0.1, 0.15, 0.4, seat_z - 0.14),
              (0.01, 0.01, 0.4, seat_z - 0.2)], "ceramic")  # fmt: skip
    b.box((-0.09, 0.0, 0.0), (0.09, 0.3, 0.3), 0.03)
    b.cushion((-0.185, 0.005, 0.33), (0.185, 0.175, 0.78), 0.04, 0.0, None, 2)
    b.cushion((-0.19, 0.0, 0.77), (0.19, 0.18, 0.81), 0.02, 0.0, None, 2)
    b.cylinder((0, 0.09, 0.805), 0.025, 0.01, 14, "chrome")
    toilet = place("Toilet", b, BATH, ((box.x0 + box.x1) / 2, box.y0, FLOOR))
    s = MeshBuilder("white plastic")
    z0, z1 = seat_z - 0.028, seat_z
    rings = [
        (0.125, 0.185, 0.405, z0),
        (0.187, 0.257, 0.392, z0),
        (0.19, 0.258, 0.392, z1 - 0.008),
        (0.182, 0.25, 0.392, z1),
        (0.13, 0.19, 0.405, z1),
        (0.125, 0.185, 0.405, z0),
    ]
    _oval(s, rings, "white plastic")
    place("Toilet seat", s, BATH, parent=toilet)
    lid = MeshBuilder("white plastic")
    lid.cushion((-0.18, 0.178, seat_z), (0.18, 0.2, seat_z + 0.42), 0.011, 0.0, None, 2)
    place("Toilet lid", lid, BATH, parent=toilet)
    roll = MeshBuilder("paper")
    roll.tube([(0, -0.055, 0), (0, 0.055, 0)], 0.052, 16)
    roll.tube([(0, -0.07, 0), (0, 0.07, 0)], 0.008, 8, "chrome")
    place("Toilet paper", roll, BATH, (5.82, 0.36, 0.75), 90.0)


def add_washbasin() -> None:
    """Add a basin on a cupboard, tap, mirror."""
    box = plan.FURNITURE["Washbasin"]
    w, d, top = box.x1 - box.x0, box.y1 - box.y0, box.z1 - FLOOR
    b = MeshBuilder("lacquer")
    b.box((-w / 2 + 0.02, 0.0, 0.2), (w / 2 - 0.02, d - 0.03, top - 0.12), 0.004)
    rim, deep = top, top - 0.11
    c = "ceramic"
    hole = (-w / 2 + 0.04, 0.12, w / 2 - 0.04, d - 0.035)
    b.box((-w / 2, 0, deep - 0.015), (w / 2, d, deep), 0.004, c)
    for x0, y0, x1, y1 in (
        (-w / 2, 0, w / 2, hole[1]), (-w / 2, hole[3], w / 2, d),
        (-w / 2, hole[1], hole[0], hole[3]), (hole[2], hole[1], w / 2, hole[3]),
    ):  # fmt: skip
        b.box((x0, y0, deep), (x1, y1, rim), 0.008, c)
    b.lathe([(0, 0), (0.02, 0), (0.02, 0.003), (0, 0.002)], (0, 0.22, deep), 14, "chrome")
    x = (box.x0 + box.x1) / 2
    basin = place("Washbasin", b, BATH, (x, box.y0, FLOOR))
    for s, side in ((-1, "left"), (1, "right")):
        door, edge = MeshBuilder("lacquer"), (w / 2 - 0.022) * s
        door.box((0.002 * s, d - 0.03, 0.21), (edge, d - 0.012, top - 0.125), 0.004)
        door.rod((0.03 * s, d - 0.002, 0.45), (0.03 * s, d - 0.002, 0.58), 0.005, 6, "chrome")
        place(f"Washbasin cupboard door {side}", door, BATH, parent=basin,
              hinge=(edge, d - 0.03, 0.21))  # fmt: skip
    tap = MeshBuilder("chrome")
    tap.cylinder((0, 0, 0), 0.022, 0.09, 14)
    tap.tube([(0, 0, 0.075), (0, 0.06, 0.1), (0, 0.12, 0.09), (0, 0.125, 0.07)], 0.011, 10)
    tap.rod((0, 0, 0.09), (0, 0.05, 0.125), 0.006, 8)
    place("Tap bathroom", tap, BATH, (0, 0.06, top), parent=basin)
    cup = MeshBuilder("blue ceramic")
    cup.lathe([(0, 0), (0.03, 0), (0.034, 0.1), (0.03, 0.1), (0.026, 0.01)], segments=16)
    for k, colour in enumerate(("red", "green")):
        a = 2.0 * k
        cup.rod((0, 0, 0.02), (0.03 * cos(a), 0.03 * sin(a), 0.19), 0.004, 6, colour)
    place("Tooth mug", cup, BATH, (0.17, 0.06, top), parent=basin)
    m = MeshBuilder("chrome")
    m.box((-0.3, 0, 0), (0.3, 0.012, 0.75), 0.003)
    m.box((-0.292, 0.012, 0.008), (0.292, 0.0132, 0.742), 0.0, "mirror")
    place("Mirror bathroom", m, BATH, (x, box.y0, 1.12))


def add_shower() -> None:
    """Add a corner with a glass screen, a tray, rail and head."""
    tray = MeshBuilder("ceramic")
    tray.box((5.91, 0.3, FLOOR - 0.01), (6.7, 1.6, FLOOR + 0.012), 0.003, "tiles grey")
    tray.lathe([(0, 0), (0.05, 0), (0.05, 0.003), (0, 0.002)], (6.3, 0.6, FLOOR + 0.012), 18,
               "chrome")  # fmt: skip
    place("Shower floor", tray, BATH)
    box = plan.FURNITURE["Shower screen"]
    b = MeshBuilder("glass")
    b.box((box.x0 + 0.006, box.y0, FLOOR + 0.02), (box.x1 - 0.006, box.y1, box.z1), 0.0)
    for y in (box.y0, box.y1 - 0.015):
        b.box((box.x0, y, FLOOR + 0.01), (box.x1, y + 0.015, box.z1), 0.002, "chrome")
    place("Shower screen", b, BATH)
    y, z = box.y1 - 0.01, box.z1 - 0.02
    rail = MeshBuilder("chrome")
    rail.rod((box.x0 + 0.01, y, z), (6.7, y, z), 0.009, 8)
    place("Shower rail", rail, BATH)
    s = MeshBuilder("chrome")
    s.rod((0, 0, 0.9), (0, 0, 1.85), 0.011, 10)
    for z in (0.92, 1.83):
        s.rod((0.06, 0, z), (0, 0, z), 0.011, 8)
    s.tube([(0, 0, 1.78), (-0.06, 0, 1.86), (-0.13, 0, 1.86)], 0.011, 8)
    s.lathe([(0, 0), (0.06, 0), (0.065, 0.008), (0.02, 0.025), (0, 0.03)], (-0.14, 0, 1.835), 20)
    s.tube([(0.02, -0.03, 0.98), (-0.03, -0.06, 0.6), (-0.04, -0.02, 0.75), (-0.01, 0, 1.3),
            (-0.02, 0, 1.76)], 0.007, 8)  # fmt: skip
    s.tube([(0.03, -0.12, 0.98), (0.03, 0.12, 0.98)], 0.022, 12)
    place("Shower", s, BATH, (6.64, 0.65, FLOOR))


def add_bath_things() -> None:
    """Add towels on a rail, basket, mat."""
    rail = MeshBuilder("chrome")
    for z in (0.0, 0.12):
        rail.rod((-0.28, -0.07, z), (0.28, -0.07, z), 0.008, 8)
    for x in (-0.26, 0.26):
        rail.rod((x, 0, 0.06), (x, -0.07, 0.0), 0.006, 6)
        rail.rod((x, -0.07, 0.0), (x, -0.07, 0.12), 0.006, 6)
    place("Towel rail", rail, BATH, (3.7, 1.05, 1.3), 90.0)
    cloth = curtain(0.4, 0.62, 3, 0.008, "towel")
    place("Towel", cloth, BATH, (3.7 + 0.083, 0.86, 0.82), 90.0)
    box = plan.FURNITURE["Laundry basket"]
    b = MeshBuilder("wicker")
    b.lathe([(0, 0), (0.12, 0), (0.145, 0.02), (0.15, 0.5), (0.145, 0.515), (0.12, 0.53),
             (0, 0.54)], segments=24)  # fmt: skip
    place("Laundry basket", b, BATH, ((box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2, FLOOR))
    mat = MeshBuilder("towel")
    mat.box((-0.3, -0.2, 0), (0.3, 0.2, 0.004), 0.001)
    place("Bath mat", mat, BATH, (4.9, 0.92, FLOOR))


def add_closet() -> None:
    """Add a washing machine, shelves with boxes and towels above it, a broom."""
    box = plan.FURNITURE["Washing machine"]
    at = ((box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2, FLOOR)
    b = MeshBuilder("white plastic")
    b.box((-0.28, -0.3, 0.0), (0.3, 0.3, box.z1 - FLOOR), 0.012)
    b.box((-0.29, -0.29, 0.73), (-0.28, 0.29, 0.85), 0.004, "grey plastic")
    b.matrix = moved(-0.28, 0, 0.4, 90.0)
    # After the turn the drum's door lies in the local x–z plane and faces +y.
    b.tube([(0, -0.005, 0), (0, 0.018, 0)], 0.19, 28, "chrome")
    b.tube([(0, 0.0, 0), (0, 0.021, 0)], 0.15, 24, "black glass")
    b.tube([(0.12, 0.0, 0.385), (0.12, 0.03, 0.385)], 0.03, 16, "white plastic")
    b.matrix = moved()
    place("Washing machine", b, CLOSET, at)
    shelf = MeshBuilder("pine y")
    for z in (1.25, 1.65, 2.05):
        shelf.box((6.3, 1.8, z), (6.7, 2.7, z + 0.022), 0.003)
    place("Closet shelves", shelf, CLOSET)
    things = MeshBuilder("wicker")
    for y, z, what in ((1.83, 1.272, "wicker"), (2.2, 1.272, "paper"), (1.9, 2.072, "paper")):
        things.box((6.36, y, z), (6.66, y + 0.3, z + 0.22), 0.01, what)
    for k, what in enumerate(("towel", "linen", "fabric rust", "towel")):
        things.cushion((6.38, 1.86, 1.672 + 0.06 * k), (6.66, 2.16, 1.732 + 0.06 * k), 0.025, 0,
                       what, 2)  # fmt: skip
    things.cylinder((6.5, 2.45, 1.672), 0.06, 0.24, 16, "blue", 0.05)
    things.cylinder((6.5, 2.6, 1.672), 0.045, 0.2, 14, "yellow", 0.035)
    place("Closet things", things, CLOSET)
    broom = MeshBuilder("pine z")
    broom.rod((6.12, 2.72, FLOOR + 0.1), (6.15, 2.77, 1.4), 0.012, 8)
    broom.box((6.0, 2.69, FLOOR), (6.19, 2.74, FLOOR + 0.12), 0.01, "red")
    place("Broom", broom, CLOSET)


def add_wet_rooms() -> None:
    """Add all objects of this module."""
    add_toilet()
    add_washbasin()
    add_shower()
    add_bath_things()
    add_closet()
