# SPDX-License-Identifier: GPL-3.0-or-later
"""Appearance of optical switches: a fork that stands on a surface, its beam along it."""

from __future__ import annotations

from ...authoring.placing import beside_it
from ...view.appearance import Appearance
from .explain import explain_switch, lacking
from .figure import beam_figure
from .housing import HOUSINGS

APPEARANCE = Appearance(
    HOUSINGS, beside_it, rays_figure=beam_figure, explain=explain_switch, lacking=lacking
)
