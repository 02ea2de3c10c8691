# SPDX-License-Identifier: GPL-3.0-or-later
"""Light sensor: four views, or a face."""

from __future__ import annotations

from ...view.appearance import Appearance
from .explain import explain_light, lacking
from .figure import figure, plan_rays, rays
from .housing import HOUSINGS
from .panel import draw

APPEARANCE = Appearance(
    HOUSINGS,
    rays=rays,
    plan_rays=plan_rays,
    figure=figure,
    explain=explain_light,
    lacking=lacking,
    details=draw,
)
