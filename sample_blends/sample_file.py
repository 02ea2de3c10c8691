# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line of the scripts that build the small sample files."""

import argparse
import sys
from collections.abc import Callable
from pathlib import Path

import bpy

from angen_addon.process.standalone import load_extension

Scene = bpy.types.Scene


def make(
    blend: Path, build: Callable[[], Scene], set_up: Callable[[Scene], None] | None = None
) -> int:
    """Build a file and save it; return the exit status.

    With `set_up`, which prepares the scene for a render, the file's 3D views look through the
    camera, and `--picture` renders it.
    """
    argv = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:]
    parser = argparse.ArgumentParser(prog=f"build_{blend.stem}.py")
    parser.add_argument("--out", type=Path, default=blend)
    if set_up is not None:
        parser.add_argument("--picture", type=Path, help="render the scene to this file too")
    arguments = parser.parse_args(argv)
    out = arguments.out.resolve()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    extension = load_extension()
    extension.register()
    try:
        scene = build()
        if set_up is not None:
            arrange_views()
        bpy.ops.wm.save_as_mainfile(filepath=str(out), compress=True, relative_remap=True)
        if set_up is not None and arguments.picture:
            set_up(scene)
            scene.view_settings.view_transform = "AgX"
            scene.render.filepath = str(arguments.picture.resolve())
            bpy.ops.render.render(write_still=True)
    finally:
        # Blender 4.2 as a Python module crashes at exit with the extension still registered.
        extension.unregister()
    print(f"{out.name}: {len(scene.objects)} objects, {out.stat().st_size / 1e3:.0f} kB")
    return 0


def arrange_views() -> None:
    """Set every 3D view of the file to the camera and the materials' colours."""
    for screen in bpy.data.screens:
        for area in screen.areas:
            if area.type == "VIEW_3D":
                space = area.spaces.active
                space.region_3d.view_perspective = "CAMERA"
                space.shading.color_type = "MATERIAL"
                space.show_region_ui = True
