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
SHOWN = "Meal preparation"


def steps() -> Iterator[None]:
    main = bpy.context.window_manager.windows[0]
    view = window.areas()["VIEW_3D"]
    space: Any = view.spaces[0]
    window.without_ceilings()
    window.view_from(space, (4.6, 4.3, 0.0), 13.0, 18.0)
    window.only_panels("day")
    window.plain(space)
    bpy.context.scene.angen_show_places = False
    settings = bpy.context.scene.angen_day
    settings.routine = str(ROUTINE)
    settings.date = "2026-03-02"
    inside = window.region_of(view)
    with bpy.context.temp_override(window=main, area=view, region=inside):
        bpy.ops.angen.day_read()
        index = next(i for i, done in enumerate(settings.done) if done.name == SHOWN)
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
