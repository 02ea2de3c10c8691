# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the beam of a switch, and where it is broken."""

from __future__ import annotations

from typing import Any

from ...runtime.trace import RaysMet
from ...view.overlay.figures import Figure, beams, dashes, ends_of

# m: sizes of the marks on a beam.
LARGEST_MARK, LEAST_MARK = 0.04, 0.004


def beam_figure(seen: Any, number: int, met: RaysMet, metres: float) -> Figure:
    """The beam up to where it is broken, a cross there and a dashed line behind; a bar at the range
    that it must reach for the switch to be open."""
    drawn = beams(seen, number, met, metres)
    _, (ends,), (hit,) = ends_of(met, metres)
    parameters, pose = seen.parameters, seen.pose
    size = min(max(parameters.range_max / 10, LEAST_MARK), LARGEST_MARK) / metres
    across, up = pose.axes[:, 0] * size, pose.axes[:, 1] * size
    for place in ends[hit]:
        drawn.add("break", (place - across - up, place + across + up))
        drawn.add("break", (place - across + up, place + across - up))
    far = (met.origins + met.directions * met.reach[:, None]) / metres
    for place, end in zip(ends[hit], far[hit], strict=True):
        drawn.add("dark", dashes(place, end))
    gate = (pose.origin - pose.axes[:, 2] * parameters.threshold) / metres
    drawn.add("gate", (gate - across / 2, gate + across / 2), (gate - up / 2, gate + up / 2))
    return drawn
