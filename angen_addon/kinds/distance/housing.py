# SPDX-License-Identifier: GPL-3.0-or-later
"""Housings of distance sensors; chips have the sizes of ST's data sheets, boards usual ones."""

from __future__ import annotations

from ...authoring.housing import Housing, looking


def _chip(across: float, up: float, deep: float) -> Housing:
    """A chip of this size (m) on a board of 25 × 18 mm, as sold as modules."""
    x, y = across / 2, up / 2
    housing = Housing().box((-x, -y, 0.0), (x, y, deep))
    return looking(housing.box((-0.0125, -0.009, deep), (0.0125, 0.009, deep + 0.0016)))


def _hc_sr04() -> Housing:
    """45 × 20 × 15 mm with two transducers of 16 mm, 26 mm apart, as sold (hackster.io)."""
    housing = Housing()
    for x in (-0.013, 0.013):
        barrel = Housing().lathe([(0.008, 0.0), (0.008, 0.012)])
        moved = [(px + x, py, pz) for px, py, pz in barrel.points]
        first = len(housing.points)
        housing.points += moved
        housing.faces += [tuple(first + i for i in face) for face in barrel.faces]
    return looking(housing.box((-0.0225, -0.01, 0.012), (0.0225, 0.01, 0.015)))


HOUSINGS = {
    "": lambda: _chip(0.0049, 0.0025, 0.00156),
    "VL53L5CX": lambda: _chip(0.0064, 0.003, 0.0015),
    "HC_SR04": _hc_sr04,
}
