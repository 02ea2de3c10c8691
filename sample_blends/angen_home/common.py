# SPDX-License-Identifier: GPL-3.0-or-later
"""Furniture that several rooms use: chairs, tables, plants, pictures, curtains, books."""

from math import cos, pi, sin
from random import Random

from . import plan
from .meshes import MeshBuilder, moved

FLOOR = plan.FLOOR_Z


def chair(seat: str = "fabric grey") -> MeshBuilder:
    """Return a dining chair, 0.42 wide, 0.56 deep (y −0.28…0.28), back at y = −0.28, on z = 0."""
    b = MeshBuilder("oak z")
    for x in (-0.18, 0.18):
        b.tube([(x, 0.245, 0.0), (x * 0.97, 0.235, 0.43)], 0.016, 8)
        b.tube(
            [(x * 1.05, -0.262, 0.0), (x * 0.97, -0.22, 0.43), (x * 0.95, -0.245, 0.62),
             (x * 0.92, -0.266, 0.86)], 0.016, 8,
        )  # fmt: skip
        b.rod((x * 0.97, 0.235, 0.4), (x * 0.97, -0.22, 0.4), 0.013, 6)
    for y in (0.235, -0.22):
        b.rod((-0.175, y, 0.4), (0.175, y, 0.4), 0.013, 6)
    b.cushion((-0.205, -0.22, 0.415), (0.205, 0.275, 0.465), 0.022, 0.008, seat, 3)
    # A curved back rest.
    for side, offset in ((1, 0.0), (-1, -0.02)):
        b.surface(
            lambda u, v, side=side, offset=offset: (
                (u - 0.5) * 0.37 * side,
                -0.252 - 0.035 * (1 - (2 * u - 1) ** 2) - 0.015 * v + offset + 0.02,
                0.66 + 0.2 * v,
            ),
            8, 2, "oak",
        )  # fmt: skip
    return b


def table(width: float, depth: float, height: float, wood: str = "oak") -> MeshBuilder:
    """Return a table about the origin on z = 0."""
    b = MeshBuilder(wood)
    x, y = width / 2, depth / 2
    b.box((-x, -y, height - 0.03), (x, y, height), 0.006)
    inset = 0.07
    for sx in (-1, 1):
        for sy in (-1, 1):
            b.matrix = moved(sx * (x - inset), sy * (y - inset))
            b.cylinder((0, 0, 0), 0.018, height - 0.03, 10, "oak z", 0.028)
    b.matrix = moved()
    for sy in (-1, 1):
        yy = sy * (y - inset)
        b.box((-x + inset, yy - 0.009, height - 0.1), (x - inset, yy + 0.009, height - 0.03), 0.003)
    for sx in (-1, 1):
        xx = sx * (x - inset)
        b.box((xx - 0.009, -y + inset, height - 0.1), (xx + 0.009, y - inset, height - 0.03), 0.003)
    return b


def leaf_blade(
    b: MeshBuilder,
    base: tuple[float, float, float],
    yaw: float,
    rise: float,
    reach: float,
    length: float,
    width: float,
    material: str = "leaf",
) -> None:
    """Add an arching leaf from `base`; `rise` 0…1 from lying to standing; `reach` m at most."""

    def point(u: float, v: float) -> tuple[float, float, float]:
        w = width * max(0.0, sin(pi * (0.06 + 0.94 * v))) ** 0.8 * (u - 0.5)
        far = v * min(reach, length * (1 - 0.62 * rise))
        height = length * (v * (0.35 + 0.75 * rise) - v * v * (0.85 - 0.55 * rise))
        height += 0.25 * abs(w)
        c, s = cos(yaw), sin(yaw)
        return (base[0] + far * c - w * s, base[1] + far * s + w * c, base[2] + height)

    b.surface(point, 2, 6, material)


def plant(
    seed: int, height: float, leaves: int, pot_radius: float, pot_height: float,
    pot: str = "terracotta", width: float = 0.1, material: str = "leaf", reach: float = 1.0,
) -> MeshBuilder:  # fmt: skip
    """Return a pot plant about the origin on z = 0, the same for the same seed."""
    rnd = Random(seed)
    b = MeshBuilder(pot)
    r, h = pot_radius, pot_height
    b.lathe(
        [(0, 0), (r * 0.72, 0), (r * 0.97, h * 0.8), (r, h * 0.8), (r, h), (r * 0.9, h),
         (r * 0.86, h * 0.86)], segments=20,
    )  # fmt: skip
    b.lathe([(r * 0.88, h * 0.86), (0, h * 0.88)], segments=20, material="soil")
    for i in range(leaves):
        yaw = 2.4 * i + rnd.uniform(-0.3, 0.3)
        t = (i + 0.5) / leaves
        length = (height - h) * rnd.uniform(0.55, 0.8) * (1.05 - 0.35 * t)
        low = h * 0.86 + (height - h) * 0.42 * t
        top = (0.02 * cos(yaw), 0.02 * sin(yaw), low)
        b.rod((0.25 * r * cos(yaw), 0.25 * r * sin(yaw), h * 0.84), top, 0.005, 5, "leaf light")
        leaf_blade(b, top, yaw, 0.35 + 0.5 * t, reach, length, width, material)
    return b


def picture(width: float, height: float, print_name: str, rim: str = "black metal") -> MeshBuilder:
    """Return a framed print in the x–z plane about the origin, facing −y, its wall at y = 0."""
    b = MeshBuilder(rim)
    x, z, t = width / 2, height / 2, 0.02
    b.box((-x, -0.025, -z), (-x + t, 0, z), 0.003)
    b.box((x - t, -0.025, -z), (x, 0, z), 0.003)
    b.box((-x + t, -0.025, -z), (x - t, 0, -z + t), 0.003)
    b.box((-x + t, -0.025, z - t), (x - t, 0, z), 0.003)
    b.box((-x + t, -0.012, -z + t), (x - t, 0, z - t), 0, "paper")
    m = 0.12 * min(width, height)
    b.box((-x + m, -0.0135, -z + m), (x - m, -0.012, z - m), 0, print_name)
    return b


def curtain(width: float, height: float, folds: int, depth: float, cloth: str) -> MeshBuilder:
    """Return a hanging curtain in the x–z plane: x 0…width, z 0…height."""
    b = MeshBuilder(cloth)

    def point(u: float, v: float) -> tuple[float, float, float]:
        swing = depth * (0.55 + 0.45 * (1 - v)) * sin(2 * pi * folds * u + 0.5 * sin(5 * u))
        return (width * (u + 0.012 * (1 - v) * sin(9 * u)), swing, height * v)

    b.surface(point, folds * 8, 5)
    return b


BOOK_COLOURS = ("red", "blue", "green", "paper", "orange", "fabric grey blue", "yellow",
                "white paint", "black plastic", "towel")  # fmt: skip


def books(
    b: MeshBuilder, x0: float, x1: float, z: float, depth: float, front: float, seed: int,
    limit: float = 0.3,
) -> None:  # fmt: skip
    """Add a row of books from x0 to x1 on a board at z, with spines at y = front that face −y."""
    rnd = Random(seed)
    x = x0
    while x < x1 - 0.05:
        thick = rnd.uniform(0.018, 0.045)
        high = min(limit, rnd.uniform(0.17, 0.28))
        deep = min(depth, rnd.uniform(0.13, 0.2))
        inset = rnd.uniform(0.0, 0.015)
        b.box((x, front + inset, z), (x + thick, front + inset + deep, z + high), 0,
              rnd.choice(BOOK_COLOURS))  # fmt: skip
        x += thick + 0.001


def shelf_unit(
    width: float, depth: float, height: float, boards: int, wood: str, back: bool = True
) -> MeshBuilder:
    """Return an open shelf about x, y 0…depth behind its front at y = 0, on z = 0."""
    b = MeshBuilder(wood)
    x, t = width / 2, 0.022
    b.box((-x, 0, 0), (-x + t, depth, height), 0.002, f"{wood} z")
    b.box((x - t, 0, 0), (x, depth, height), 0.002, f"{wood} z")
    if back:
        b.box((-x + t, depth - 0.008, 0.05), (x - t, depth, height), 0)
    for i in range(boards):
        z = 0.05 + (height - t - 0.05) * i / (boards - 1)
        b.box((-x + t, 0.002, z), (x - t, depth - 0.008, z + t), 0.002)
    b.box((-x + t, 0.012, 0), (x - t, 0.03, 0.05), 0)
    return b


def table_lamp(height: float, foot: str = "brass") -> MeshBuilder:
    """Return a small lamp with a cloth shade about the origin on z = 0."""
    b = MeshBuilder(foot)
    h = height
    b.lathe([(0, 0), (0.07, 0), (0.075, 0.008), (0.07, 0.018), (0.018, 0.03), (0.012, 0.05),
             (0.012, h * 0.62)], segments=16)  # fmt: skip
    shade(b, (0, 0, h * 0.6), 0.13, 0.09, h * 0.4)
    return b


def shade(
    b: MeshBuilder, at: tuple[float, float, float], low: float, high: float, height: float,
    material: str = "shade",
) -> None:  # fmt: skip
    """Add a lamp shade, open above and below."""
    b.lathe([(low, 0.0), (high, height)], at, 24, material)
