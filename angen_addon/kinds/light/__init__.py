# SPDX-License-Identifier: GPL-3.0-or-later
"""Appearance of light sensors: a photoresistor, with its four views or the lobe of its face."""

from __future__ import annotations

from ...view.appearance import Appearance
from .explain import explain_light, lacking
from .figure import figure, plan_rays, view_figure
from .housing import HOUSINGS
from .panel import draw

APPEARANCE = Appearance(
    HOUSINGS,
    plan_rays=plan_rays,
    figure=figure,
    rays_figure=view_figure,
    explain=explain_light,
    lacking=lacking,
    details=draw,
)
