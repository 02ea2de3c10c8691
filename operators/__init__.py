# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators: one file for each thing that a user does."""

from ..angen_addon.registering import of_modules

register, unregister = of_modules(
    __name__, "add", "place", "places", "assign", "copy", "door", "preset", "user_preset",
    "simulate", "bake", "recording", "export", "export_format", "import_layout", "lacking",
    "report", "event_jump", "markers", "explain", "show", "instance_override", "warmth",
    "resident_add", "day", "coverage", "propose", "doctor", "study",
)  # fmt: skip
