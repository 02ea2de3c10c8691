# SPDX-License-Identifier: GPL-3.0-or-later
"""Render settings of light scenes, whether EEVEE can run, and a reader for rendered OpenEXR files.

The reader takes plain files: scan lines of 32-bit floats, not compressed, in one part. Blender
could read them too, but would leave their images in the user's file.
"""

from __future__ import annotations

import functools
import struct
import subprocess
import sys
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ....sensor_logic.model import Array

# After this many bounces between white walls 1e-3 of the light is left: without bias in homes.
BOUNCES = 128
SEED = 0
# Cycles draws the same random numbers for each part of a sequence of this length. Versions of
# Blender without parts draw the same numbers for at most 256 paths at once.
SEQUENCE = 1 << 20
AT_ONCE, AT_ONCE_BEFORE = 2048, 256
EEVEE = "BLENDER_EEVEE" if bpy.app.version >= (5, 0) else "BLENDER_EEVEE_NEXT"
# EEVEE may take this long to compile its shaders with a software renderer.
PATIENCE_S = 120
TRY_EEVEE = """
import bpy

bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.render.engine = {engine!r}
scene.render.resolution_x = scene.render.resolution_y = 4
scene.eevee.taa_render_samples = 1
camera = bpy.data.objects.new("c", bpy.data.cameras.new("c"))
scene.collection.objects.link(camera)
scene.camera = camera
bpy.ops.render.render()
print("EEVEE", "RUNS")
"""
# The first bytes of OpenEXR files.
MAGIC = 0x01312F76
# Flags of tiled, deep and multi-part files.
OTHER_KINDS = 0x1A00
FLOAT = 2
# From the chromaticities of the primaries (ITU-R BT.709, BT.2020; AMPAS S-2014-004, adapted to
# D65).
TO_REC709: dict[str, Any] = {
    "Linear Rec.2020": [
        [1.660491, -0.587641, -0.072850],
        [-0.124550, 1.132900, -0.008349],
        [-0.018151, -0.100579, 1.118730],
    ],
    "ACEScg": [
        [1.705052, -0.621792, -0.083258],
        [-0.130257, 1.140802, -0.010548],
        [-0.024003, -0.128969, 1.152972],
    ],
}


def set_up(scene: Any, engine: str) -> None:
    """Set the render settings that the sensors need in a new scene."""
    render, cycles = scene.render, scene.cycles
    render.engine = EEVEE if engine == "EEVEE" else "CYCLES"
    render.use_compositing = render.use_sequencer = False
    render.use_multiview = False
    render.resolution_percentage = 100
    cycles.device = "CPU"
    cycles.seed = SEED
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.light_sampling_threshold = 0.0
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.blur_glossy = 0.0
    cycles.pixel_filter_type = "BOX"
    cycles.sampling_pattern = "TABULATED_SOBOL"
    cycles.use_auto_tile = False
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = BOUNCES
    cycles.transmission_bounces = cycles.transparent_max_bounces = BOUNCES


def at_once(scene: Any) -> int:
    """Return the number of light paths that one render traces for each pixel.

    The sums of several renders are rounded, so this number must be the same in all runs.
    """
    return AT_ONCE if hasattr(scene.cycles, "use_sample_subset") else AT_ONCE_BEFORE


def trace(scene: Any, start: int, count: int) -> None:
    """Set how many light paths the next render traces for each pixel, and the number of the first.

    The number of a path decides its random numbers.
    """
    cycles = scene.cycles
    cycles.sample_offset = start
    if hasattr(cycles, "use_sample_subset"):
        cycles.samples, cycles.use_sample_subset = SEQUENCE, True
        cycles.sample_subset_length = count
    else:
        cycles.samples = count


def why_no_eevee() -> str:
    """Return a text that says why EEVEE cannot run here; empty if it can.

    Without a GPU or a display, a render by EEVEE ends Blender without an error. So another process
    tries it.
    """
    return "" if not bpy.app.background else _why_no_eevee_in_background()


# Once, until Blender ends; without this cache each call starts Blender: seconds to a minute.
@functools.cache
def _why_no_eevee_in_background() -> str:
    script = TRY_EEVEE.format(engine=EEVEE)
    if bpy.app.binary_path:
        command = [bpy.app.binary_path, "-b", "--factory-startup", "--python-expr", script]
    else:
        command = [sys.executable, "-c", script]
    sorry = "EEVEE cannot run here: it needs a GPU or OpenGL, and a display; choose Cycles"
    try:
        tried = subprocess.run(
            command,
            capture_output=True,
            encoding="utf-8",
            errors="replace",
            timeout=PATIENCE_S,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        return f"{sorry} ({type(error).__name__})"
    return "" if tried.returncode == 0 and "EEVEE RUNS" in tried.stdout else sorry


def read_layers(path: Path) -> dict[str, NDArray[np.float64]]:
    """Return the pixels (height, width, 3) of each layer and pass of a rendered OpenEXR file.

    Keys are such as "ViewLayer.Combined". A file without layers has the key "". Raise `ValueError`
    if the file is not of the kind that this module reads.
    """
    data = path.read_bytes()
    magic, version = struct.unpack_from("<II", data)
    if magic != MAGIC or version & OTHER_KINDS:
        raise ValueError(f"{path.name} is not a plain OpenEXR file")
    header, at = _header(data, 8)
    if header["compression"][0] != 0:
        raise ValueError(f"{path.name} is compressed")
    x0, y0, x1, y1 = struct.unpack("<4i", header["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    channels = _channels(header["channels"])
    if any(kind != FLOAT for _, kind in channels):
        raise ValueError(f"{path.name} has channels that are not 32-bit floats")
    # After a table of offsets, each row has its number, its size, and the channels one by one.
    row = 8 + 4 * width * len(channels)
    rows = np.frombuffer(data, np.uint8, height * row, at + 8 * height).reshape(height, row)[:, 8:]
    planes = np.ascontiguousarray(rows).view("<f4").reshape(height, len(channels), width)
    found: dict[str, NDArray[np.float64]] = {}
    for number, (name, _) in enumerate(channels):
        layer, _, channel = name.rpartition(".")
        if channel in "RGB":
            pixels = found.setdefault(layer, np.empty((height, width, 3)))
            pixels[..., "RGB".index(channel)] = planes[:, number]
    return found


def _header(data: bytes, at: int) -> tuple[dict[str, bytes], int]:
    """Return the attributes of a header by name, and the position behind them."""
    found = {}
    while data[at] != 0:
        name, at = _text(data, at)
        _, at = _text(data, at)
        (size,) = struct.unpack_from("<i", data, at)
        found[name] = data[at + 4 : at + 4 + size]
        at += 4 + size
    return found, at + 1


def _channels(data: bytes) -> list[tuple[str, int]]:
    found, at = [], 0
    while data[at] != 0:
        name, at = _text(data, at)
        (kind,) = struct.unpack_from("<i", data, at)
        found.append((name, kind))
        at += 16
    return found


def _text(data: bytes, at: int) -> tuple[str, int]:
    end = data.index(0, at)
    return data[at:end].decode(), end + 1


def to_rec709(rgb: Array) -> Array:
    """Convert the colours (…, 3) of a render to linear Rec. 709.

    Before Blender 5.0, renders are in Rec. 709 already.

    References
    ----------
    ITU-R BT.709 and BT.2020; AMPAS S-2014-004 for ACEScg.
    """
    space = getattr(getattr(bpy.data, "colorspace", None), "working_space", "")
    matrix = TO_REC709.get(space)
    return rgb if matrix is None else rgb @ np.array(matrix).T
