# SPDX-License-Identifier: GPL-3.0-or-later
"""Forks of slotted switches. The default one fits around a flag on a door. Parts whose outer sizes
are unknown have their own gap, and otherwise the sizes of Vishay's (data sheet 83764)."""

from __future__ import annotations

from ...authoring.housing import Housing


def fork(gap: float, across: float, along: float, height: float) -> Housing:
    """Two arms with a gap between them, on a base: outer sizes across the arms, along them, and
    above the surface (m). The beam is a quarter of the height below the open end."""
    arm, x = (across - gap) / 2, along / 2
    tip, base = -height / 4, height * 3 / 4
    inner = base - height / 4
    housing = Housing()
    housing.box((-x, tip, 0.0), (x, inner, arm)).box((-x, tip, -gap - arm), (x, inner, -gap))
    housing.box((-x, inner, -gap - arm), (x, base, arm))
    return housing.lines([(0, 0, 0), (0, 0, -gap)], [(0, 1)])


def _tcst() -> Housing:
    return fork(0.0031, 0.0119, 0.0063, 0.0108)


HOUSINGS = {
    "": lambda: fork(0.05, 0.09, 0.024, 0.06),
    "TCST1103": _tcst,
    "TCST1202": _tcst,
    "TCST1300": _tcst,
    "GP1A51HR": lambda: fork(0.003, 0.0122, 0.0063, 0.01),
    "GP1A53HR": lambda: fork(0.005, 0.0137, 0.0063, 0.01),
    "EE_SX670": lambda: fork(0.005, 0.0138, 0.0063, 0.0108),
}
