# SPDX-License-Identifier: GPL-3.0-or-later
"""Appearance of pressure sensors: a pad that lies on a surface, and the force on it."""

from __future__ import annotations

from ...authoring.placing import lying
from ...view.appearance import Appearance
from .explain import explain_pad, lacking
from .figure import FIELDS, figure, force_of_reading
from .housing import HOUSINGS
from .panel import SECTIONS, draw

APPEARANCE = Appearance(
    HOUSINGS,
    lying,
    figure=figure,
    reading_figure=force_of_reading,
    drawn_fields=FIELDS,
    outlined=True,
    explain=explain_pad,
    lacking=lacking,
    sections=SECTIONS,
    details=draw,
)
