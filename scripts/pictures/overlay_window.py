# SPDX-License-Identifier: GPL-3.0-or-later
"""Sets up Blender's window for the pictures of what the viewport draws of the sensors.

    VIEW=motion blender --factory-startup --addons bl_ext.user_default.angen_sensors \\
        sample_blends/angen.blend --python scripts/pictures/overlay_window.py

VIEW is one of those listed below. READY is printed when the window shows it.
"""

import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import bpy

sys.path.append(str(Path(__file__).parent))
import window

# Frame, middle of the view (m), its distance (m), its tilt from above and its turn (degrees), the
# sensor that is active.
VIEWS: dict[str, tuple[int, tuple[float, float, float], float, float, float, str]] = {
    "motion": (1000, (7.9, 4.6, 0.8), 9.0, 52.0, -35.0, "PIR living room"),
    "home": (700, (5.0, 4.0, 0.0), 19.0, 30.0, 0.0, "PIR hall"),
    "door": (84, (5.0, 8.2, 2.15), 1.3, 80.0, 15.0, "Switch entrance"),
    "sofa": (1876, (8.7, 6.2, 0.75), 3.0, 62.0, -30.0, "Pressure sofa"),
    "light": (1500, (7.9, 4.6, 1.0), 9.0, 45.0, 25.0, "Light sensor living room"),
}


def steps() -> Iterator[None]:
    frame, middle, distance, tilt, turn, name = VIEWS[os.environ.get("VIEW", "motion")]
    view = window.areas()["VIEW_3D"]
    space: Any = view.spaces[0]
    window.select(name)
    window.plain(space)
    space.overlay.show_extras = False
    window.view_from(space, middle, distance, tilt, turn)
    bpy.context.scene.angen_overlay.which = os.environ.get("WHICH", "ALL")
    yield
    window.play_up_to(frame)
    yield
    window.open_sidebar(view)
    yield
    yield
    yield


window.show(steps())
