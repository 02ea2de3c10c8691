# SPDX-License-Identifier: GPL-3.0-or-later
"""Playback with live readings: the section of the page, from data."""

from __future__ import annotations

from typing import Any

from .tables import columns

TEXT = """\
## Live readings

Playback of {frames} frames of the sample home in which somebody walks, without a window, with live
readings and without in turn: milliseconds of processor time a frame. *Cost*: what live readings
add. *Same*: of the readings from the first frame on, those that are what a run records, to the bit.
What a window costs besides is measured in one: `scripts/pictures/playback.py`.

{cases}
"""


def section(data: dict[str, Any]) -> str:
    return TEXT.format(
        frames=data["frames"],
        cases=columns(
            data["cases"],
            "sensors=name",
            "without ms=plain_ms:spread",
            "live ms=live_ms:spread",
            "cost ms=cost_ms:spread",
            "readings=read:,",
            "same=same:,",
        ),
    )
