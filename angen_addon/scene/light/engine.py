# SPDX-License-Identifier: GPL-3.0-or-later
"""Render settings of the sensors' own, whatever the user's are; and whether EEVEE can run."""

from __future__ import annotations

import functools
import subprocess
import sys
from typing import Any

import bpy

# Unbiased for what homes hold: after so many bounces between white walls 1e-3 of the light is left.
BOUNCES = 128
SEED = 0
# Light paths of any number and order have the same random numbers where they are told to be part
# of so many. Before Blender knew parts, they have where no more than 256 are traced at once.
SEQUENCE = 1 << 20
AT_ONCE, AT_ONCE_BEFORE = 2048, 256
EEVEE = "BLENDER_EEVEE" if bpy.app.version >= (5, 0) else "BLENDER_EEVEE_NEXT"
# Its compilation of shaders alone can take this long with a software renderer.
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


def set_up(scene: Any, engine: str) -> None:
    """Settings of a new scene that the sensors need; the others are Blender's own."""
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
    """So many light paths a pixel are traced at once. The sums of parts are rounded: it must not
    change from run to run."""
    return AT_ONCE if hasattr(scene.cycles, "use_sample_subset") else AT_ONCE_BEFORE


def trace(scene: Any, start: int, count: int) -> None:
    """So many light paths a pixel are traced next, from that number on."""
    cycles = scene.cycles
    cycles.sample_offset = start
    if hasattr(cycles, "use_sample_subset"):
        cycles.samples, cycles.use_sample_subset = SEQUENCE, True
        cycles.sample_subset_length = count
    else:
        cycles.samples = count


def why_no_eevee() -> str:
    """Why EEVEE cannot run here, in words; empty where it can.

    Without a GPU or a display Blender does not report, it ends: so another process tries.
    """
    return "" if not bpy.app.background else _why_no_eevee_in_background()


# Once, until Blender ends; without it a process that starts Blender each time: seconds to a minute.
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
            command, capture_output=True, text=True, timeout=PATIENCE_S, check=False
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        return f"{sorry} ({type(error).__name__})"
    return "" if tried.returncode == 0 and "EEVEE RUNS" in tried.stdout else sorry
