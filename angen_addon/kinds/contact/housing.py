# SPDX-License-Identifier: GPL-3.0-or-later
"""The housing of a door contact; its magnet is another object."""

from __future__ import annotations

from ...authoring.housing import Housing


def _contact() -> Housing:
    """27.5 × 13.6 × 9 mm, as sold with adhesive backs (midlandelectronics.com)."""
    return Housing().box((-0.01375, -0.0068, 0.0), (0.01375, 0.0068, 0.009))


HOUSINGS = {"": _contact}
