# SPDX-License-Identifier: GPL-3.0-or-later
"""Properties that hold a path, which may begin with // for the blend file's folder."""

from __future__ import annotations

from pathlib import Path

import bpy
from bpy.props import StringProperty

# Blender 5 shows a field with such a path in red unless its property says that it is meant.
RELATIVE_PATH: set[str] = (
    {"PATH_SUPPORTS_BLEND_RELATIVE"} if bpy.app.version >= (4, 5, 0) else set()
)


def absolute(path: str) -> Path:
    """Return the absolute path for a property's path, whatever system has saved the blend file."""
    # Blender converts separators of its own paths when it opens a file of Windows, not of these.
    is_relative = path.startswith("//")
    return Path(bpy.path.abspath(bpy.path.native_pathsep(path) if is_relative else path))


class ChosenFile:
    """Mix-in of operators that read or write a file. List it before Blender's `ExportHelper`."""

    filepath: StringProperty(name="File Path", subtype="FILE_PATH", options=RELATIVE_PATH)

    @property
    def path(self) -> Path:
        """The absolute path of the file."""
        return absolute(self.filepath)
