# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws a sensor while it is being placed: its outline under the mouse, its place and the keys.

It adds nothing to the scene, so that no recording becomes stale.
"""

from __future__ import annotations

from typing import Any

import bpy
import gpu
from bpy.types import Context
from gpu_extras.batch import batch_for_shader
from mathutils import Matrix

from ..angen_addon.authoring.housing import Housing
from ..angen_addon.scene.sensors import unit_scale

COLOR = (1.0, 0.6, 0.1, 1.0)
LINE_WIDTH = 1.5
# Draw handlers in use. Blender ends operators without a call where the extension is switched off.
_handles: set[Any] = set()


class Preview:
    """Draws the outline of a housing at `matrix`, if that is not None."""

    def __init__(self, context: Context, housing: Housing) -> None:
        self.matrix: Matrix | None = None
        self._scale = unit_scale(context.scene)
        self._area = context.area
        self._lines = [housing.points[i] for edge in housing.outline() for i in edge]
        self._handle: Any = bpy.types.SpaceView3D.draw_handler_add(
            self._draw, (context.region,), "WINDOW", "POST_VIEW"
        )
        _handles.add(self._handle)

    def show(self, context: Context, matrix: Matrix | None, told: str, keys: str) -> None:
        self.matrix = matrix
        self._area.header_text_set(told)
        context.workspace.status_text_set(keys)
        self._area.tag_redraw()

    def remove(self, context: Context) -> None:
        _remove(self._handle)
        _clear_texts(self._area, context.workspace)

    def _draw(self, region: Any) -> None:
        if self.matrix is None or bpy.context.region != region:
            return
        shader = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
        to_world = self.matrix @ Matrix.Scale(1 / self._scale, 4)
        # Single precision is enough near the origin of the housing's axes.
        with gpu.matrix.push_pop():
            gpu.matrix.multiply_matrix(to_world)
            shader.bind()
            shader.uniform_float("color", COLOR)
            shader.uniform_float("lineWidth", LINE_WIDTH)
            shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
            batch_for_shader(shader, "LINES", {"pos": self._lines}).draw(shader)


def _clear_texts(area: Any, workspace: Any) -> None:
    area.header_text_set(None)
    workspace.status_text_set(None)
    area.tag_redraw()


def _remove(handle: Any) -> None:
    if handle in _handles:
        _handles.remove(handle)
        bpy.types.SpaceView3D.draw_handler_remove(handle, "WINDOW")


def remove_all() -> None:
    """Removes the draw handlers of operators that Blender ended without a call."""
    if _handles and bpy.context.window_manager is not None:
        for window in bpy.context.window_manager.windows:
            for area in window.screen.areas:
                if area.type == "VIEW_3D":
                    _clear_texts(area, window.workspace)
    for handle in list(_handles):
        _remove(handle)
