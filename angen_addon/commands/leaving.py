# SPDX-License-Identifier: GPL-3.0-or-later
"""Ends the process at once."""

from __future__ import annotations

import contextlib
import os
import shutil
import sys
from pathlib import Path
from typing import NoReturn


def leave_hard(status: int) -> NoReturn:
    """Flushes the output, removes Blender's temporary folder and ends the process without cleaning
    up: Blender's module crashes or hangs in its clean-up where drivers have run Python."""
    bpy = sys.modules.get("bpy")
    folder = Path(bpy.app.tempdir) if bpy is not None else None
    # The folder of this session, not the one shared with other programs.
    if folder is not None and folder.name.startswith("blender_"):
        shutil.rmtree(folder, ignore_errors=True)
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(OSError, ValueError, AttributeError):
            stream.flush()
    os._exit(status)
