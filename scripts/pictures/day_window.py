# SPDX-License-Identifier: GPL-3.0-or-later
"""Sets up Blender's window for the picture of a day of the sample home, one stretch of it shown.

    blender --factory-startup --addons bl_ext.user_default.angen_sensors \\
        sample_blends/angen.blend --python scripts/pictures/day_window.py

READY is printed when the window shows it.
"""

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import bpy

sys.path.append(str(Path(__file__).parent))
import window

ROUTINE = Path(__file__).resolve().parents[2] / "sample_blends" / "week.toml"
# Closed in the picture, so that the tab shows the day alone.
OTHERS = (
    "table", "events", "simulation_settings", "simulation", "overlay", "active_sensor",
    "sidebar_weight", "sidebar_warmth", "coverage_place", "coverage", "doctor", "study", "places",
    "sidebar_resident", "resident",
)  # fmt: skip
SHOWN = "Meal preparation"


def steps() -> Iterator[None]:
    main = bpy.context.window_manager.windows[0]
    view = window.areas()["VIEW_3D"]
    space: Any = view.spaces[0]
    window.from_above(space)
    window.one_panel("day", OTHERS)
    window.plain(space)
    space.overlay.show_relationship_lines = space.overlay.show_cursor = False
    space.show_region_ui = True
    space.show_gizmo = False
    bpy.context.scene.angen_show_places = False
    asked = bpy.context.scene.angen_day
    asked.routine = str(ROUTINE)
    asked.date = "2026-03-02"
    inside = window.region_of(view)
    with bpy.context.temp_override(window=main, area=view, region=inside):
        bpy.ops.angen.day_read()
        index = next(i for i, done in enumerate(asked.done) if done.name == SHOWN)
        bpy.ops.angen.day_show(index=index)
    yield
    window.open_sidebar(view)
    start = bpy.context.scene.frame_start
    for frame in range(start, start + 150):
        bpy.context.scene.frame_set(frame)
    yield
    yield
    yield


window.show(steps())
