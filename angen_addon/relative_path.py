# SPDX-License-Identifier: GPL-3.0-or-later
"""Options of properties that hold a path, which may begin with // for the blend file's folder."""

from __future__ import annotations

import bpy

# Blender 5 shows a field with such a path in red unless its property says that it is meant.
RELATIVE_PATH: set[str] = (
    {"PATH_SUPPORTS_BLEND_RELATIVE"} if bpy.app.version >= (4, 5, 0) else set()
)
