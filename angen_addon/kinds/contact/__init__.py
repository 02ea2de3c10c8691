# SPDX-License-Identifier: GPL-3.0-or-later
"""Appearance of door contacts: a flat body, with rings where its magnet closes and opens it."""

from __future__ import annotations

from ...view.appearance import Appearance
from .explain import explain_contact
from .figure import figure
from .housing import HOUSINGS
from .panel import draw

APPEARANCE = Appearance(HOUSINGS, figure=figure, explain=explain_contact, details=draw)
