# SPDX-License-Identifier: GPL-3.0-or-later
"""The appearance of motion detectors, which look level from a wall."""

from __future__ import annotations

from ...appearance.appearance import Appearance
from ...appearance.handles import ahead, edge
from ...appearance.housing import looking_level
from .explain import explain_motion, lacking
from .figure import HOUSINGS, draw, lit_figure, plan_rays, rays_figure, scan_figure

APPEARANCE = Appearance(
    HOUSINGS,
    looking_level,
    plan_rays,
    rays_figure=rays_figure,
    scan_figure=scan_figure,
    lit_figure=lit_figure,
    handles=(
        ahead("range_max"),
        edge("horizontal_fov", (1.0, 0.0), 0.5),
        edge("vertical_fov", (0.0, -1.0), 1.0),
    ),
    explain=explain_motion,
    lacking=lacking,
    details=draw,
)
