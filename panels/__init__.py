# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels: one file for each place in the interface."""

from ..angen_addon.registering import of_modules

# In the order of the sidebar's panels.
register, unregister = of_modules(
    __name__, "presets", "physics_tab", "table", "sidebar", "events", "active_sensor", "overlay",
    "load", "warmth", "coverage", "residents", "places", "day", "study", "doctor",
)  # fmt: skip
