# SPDX-License-Identifier: GPL-3.0-or-later
"""The appearance of presence radars, which look level from a wall."""

from __future__ import annotations

from ...appearance.appearance import Appearance
from ...appearance.handles import ahead, edge
from ...appearance.housing import looking_level
from .explain import explain_radar, lacking
from .figure import DRAWN, HOUSINGS, SECTIONS, draw, plan_rays, rays_figure, targets_figure

APPEARANCE = Appearance(
    HOUSINGS,
    looking_level,
    plan_rays,
    rays_figure=rays_figure,
    reading_figure=targets_figure,
    drawn_fields=DRAWN,
    handles=(
        ahead("range_max"),
        edge("horizontal_fov", (1.0, 0.0), 0.5),
        edge("vertical_fov", (0.0, 1.0), 0.5),
    ),
    explain=explain_radar,
    lacking=lacking,
    sections=SECTIONS,
    details=draw,
)
