# SPDX-License-Identifier: GPL-3.0-or-later
"""Appearance of distance sensors: a module that looks level from a wall, and its zones."""

from __future__ import annotations

from ...authoring.placing import looking_level
from ...view.appearance import Appearance
from .explain import explain_distance
from .figure import plan_rays, zones_figure
from .housing import HOUSINGS

APPEARANCE = Appearance(
    HOUSINGS, looking_level, plan_rays, rays_figure=zones_figure, explain=explain_distance
)
