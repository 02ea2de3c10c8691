# SPDX-License-Identifier: GPL-3.0-or-later
"""Housings of motion detectors."""

from __future__ import annotations

import math

from ...authoring.housing import Housing, looking


def _hc_sr501() -> Housing:
    """32 × 24 × 25 mm with a lens of 23 mm, as sold: innovatorsguru.com, purplebearsshopnearn.com.
    The share of the lens in the depth is chosen."""
    lens = [(0.0115 * math.sin(a), 0.0115 * (1 - math.cos(a)))
            for a in (math.pi / 2 * i / 4 for i in range(5))]  # fmt: skip
    housing = Housing().lathe([*lens, (0.0115, 0.0165)])
    return looking(housing.box((-0.016, -0.012, 0.0165), (0.016, 0.012, 0.025)))


def _pmod_pir() -> Housing:
    """Board of 1.2 × 0.8 inches, 0.55 inches high: Digilent Pmod PIR reference manual."""
    housing = Housing().lathe([(0.0, 0.0), (0.0035, 0.001), (0.0047, 0.004), (0.0047, 0.0124)])
    return looking(housing.box((-0.01524, -0.01016, 0.0124), (0.01524, 0.01016, 0.01397)))


def _wall_detector() -> Housing:
    """A detector for walls, as in the sample home: a flat body of 68 × 110 mm with a bulging lens,
    40 mm deep."""
    lens = [(0.026 * math.sin(a), 0.014 * (1 - math.cos(a)))
            for a in (math.pi / 2 * i / 4 for i in range(5))]  # fmt: skip
    return looking(Housing().lathe(lens).box((-0.034, -0.055, 0.014), (0.034, 0.055, 0.04)))


HOUSINGS = {
    "": _hc_sr501,
    "EKMC1601111": _pmod_pir,
    "EKMC1601111_SCAN": _pmod_pir,
    "HAA53_SCAN": _wall_detector,
    "EKMC1604111": _wall_detector,
    "EKMC1604111_SCAN": _wall_detector,
    "PET_IMMUNE": _wall_detector,
    "CURTAIN": _wall_detector,
    "SPACETI_WALL": _wall_detector,
}
