# SPDX-License-Identifier: GPL-3.0-or-later
"""Housings of pads: the default is one for under furniture and on seats, the others have the sizes
of the data sheets FSR 400 series, FSR 402 and 406."""

from __future__ import annotations

from ...authoring.housing import Housing, Point, pad


def _force_resistor(diameter: float, length: float, side: float = 0.0) -> Housing:
    """A disk (or square) with its tail along −Y, 0.45 mm thin. The tail senses nothing, so it
    is lines without a surface; its width is chosen."""
    thin, half = 0.00045, (diameter or side) / 2
    housing = pad(side, thin) if side else Housing().lathe([(half, 0.0), (half, thin)])
    end, w = half - length, min(half, 0.0032)
    tail: list[Point] = [(-w, -half, 0.0), (-w, end, 0.0), (w, end, 0.0), (w, -half, 0.0)]
    return housing.lines(tail, [(0, 1), (1, 2), (2, 3)])


def _fsr_402() -> Housing:
    return _force_resistor(0.01828, 0.056)


HOUSINGS = {
    "": lambda: pad(0.3, 0.01),
    **dict.fromkeys(("FSR_402_IDEAL", "FSR_402", "FSR_402_3K3"), _fsr_402),
    **dict.fromkeys(("FSR_402_47K", "FSR_402_100K"), _fsr_402),
    "FSR_400": lambda: _force_resistor(0.0051, 0.038),
    "FSR_406": lambda: _force_resistor(0.0, 0.083, side=0.04369),
}
