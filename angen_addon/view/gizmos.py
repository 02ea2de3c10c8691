# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw the handles of the active sensor in 3D views: gizmos to drag, as for cameras and lamps.

Each handle moves along a path in the world. Each point of the path represents a value of a
parameter. Dragging sets the value whose point is nearest to the mouse. Ctrl snaps, Shift makes
small steps, Esc and the right button restore the value.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import lru_cache
from typing import Any

import bpy
import numpy as np
from bpy.types import Context, Event, Gizmo, GizmoGroup
from bpy_extras.view3d_utils import location_3d_to_region_2d
from mathutils import Matrix, Vector

from ...sensor_logic.logs.error import AngenError, explained
from ...sensor_logic.model import Array, Pose, pose_from_matrix
from ..appearance.appearance import appearance_of
from ..appearance.handles import Handle, SizeHandle
from ..runtime.running import is_running
from ..scene.lengths import lengths_of
from ..scene.sensors import Sensor, unit_scale
from ..translations.interface import translated
from .active import active_sensor

# The greatest number of handles of a kind.
MOST = 6
# Size of a handle relative to Blender's gizmos.
SIZE = 0.11
COLOUR, HIGHLIGHT = (1.0, 1.0, 1.0), (1.0, 0.85, 0.3)
ROUND = 20
# Font, and sizes in pixels at an interface scale of 1.
TEXT_FONT, TEXT_SIZE, TEXT_OFF = 0, 12.0, 12.0
# Newton's method along a path: the greatest number of steps, a small change relative to the value,
# and the least value (m, rad) that changes are relative to. If doubling the value moves the handle
# by fewer than LEAST_PIXELS, the mouse cannot set it.
STEPS, SMALL, LARGE, LEAST_PIXELS = 12, 1e-3, 0.1, 2.0
PRECISE = 0.1

Pixel = Sequence[float]


def _shape() -> list[tuple[float, float, float]]:
    """Return the corners of triangles about the origin: a disc between two arrowheads along X."""
    turns = np.linspace(0.0, 2.0 * np.pi, ROUND + 1)
    rim = np.stack([np.cos(turns), np.sin(turns)], axis=1) * 0.55
    corners = []
    for one, two in zip(rim[:-1].tolist(), rim[1:].tolist(), strict=True):
        corners += [(0.0, 0.0), one, two]
    for side in (-1.0, 1.0):
        corners += [(side * 1.5, 0.0), (side * 0.75, 0.55), (side * 0.75, -0.55)]
    return [(x, y, 0.0) for x, y in corners]


def sensor_with_handles(context: Any) -> Sensor | None:
    """Return the active sensor if its handles are shown, or None.

    The sensor must be selected and editable, and not in a collection instance. Handles are shown
    only in Object Mode and not during a run.
    """
    settings, obj = context.scene.angen_overlay, context.view_layer.objects.active
    if not (settings.show and settings.handles) or context.mode != "OBJECT" or obj is None:
        return None
    if is_running() or not obj.select_get():
        return None
    sensor = active_sensor(context)
    is_free = sensor is not None and not sensor.holders and sensor.object.is_editable
    return sensor if is_free else None


def handles_of(sensor: Sensor) -> list[Handle | SizeHandle]:
    """Return the handles whose parameters have an effect with the sensor's present settings."""
    return [handle for handle in appearance_of(sensor.kind).handles if handle.is_used(sensor)]


# Each redraw takes 0.2 ms longer for each handle without the cache.
@lru_cache(maxsize=4)
def _pose(matrix: Matrix, metres: float) -> Pose:
    return pose_from_matrix(matrix.copy(), metres)


def in_world(
    sensor: Sensor, handle: Handle | SizeHandle, metres: float
) -> Callable[[float], Array]:
    """Return a function from a handle's value to its position (3,) in the world, in Blender units.

    The position does not depend on the sensor's scale. `metres` is the length of a Blender unit in
    m. Raise `AngenError` if the sensor has no valid pose.
    """
    with explained(f"'{sensor.name}'", ValueError, raised=AngenError):
        pose = _pose(sensor.object.matrix_world.copy().freeze(), metres)

    def place(value: float) -> Array:
        found: Array = (pose.origin + pose.axes @ handle.point(sensor, value)) / metres
        return found

    return place


def pixels_of_handles(context: Any) -> list[Pixel]:
    """Return the pixels at which the present 3D view shows handles."""
    sensor = sensor_with_handles(context) if context.space_data.show_gizmo else None
    if sensor is None:
        return []
    region, view, found = context.region, context.region_data, []
    for handle in handles_of(sensor):
        with suppress(AngenError):
            place = in_world(sensor, handle, unit_scale(context.scene))
            found.append(
                location_3d_to_region_2d(region, view, Vector(place(handle.value(sensor))))
            )
    return [at for at in found if at is not None]


def drag_value(
    project: Callable[[float], Pixel | None], value: float, target: Pixel, low: float, high: float
) -> float:
    """Return the value from `low` to `high` whose pixel is nearest to a target pixel.

    The search uses Newton's method. It ends where a change of the value hardly moves the pixel.

    Parameters
    ----------
    project
        Function from a value to its pixel. It returns None behind the viewer.
    value
        The value to start from.
    target
        The pixel (2,) to reach.
    low, high
        The limits of the value.
    """
    for _ in range(STEPS):
        step = max(abs(value), low, SMALL) * SMALL
        step = step if value + step <= high else -step
        pixel, next_pixel = project(value), project(value + step)
        if pixel is None or next_pixel is None:
            break
        way = np.subtract(next_pixel, pixel) / step
        square, size = float(way @ way), max(abs(value), LARGE)
        if square * size * size < LEAST_PIXELS**2:
            break
        change = float(np.subtract(target, pixel) @ way) / square
        new = value + min(max(change, -size / 2.0), size)
        new = min(max(new, low), high)
        if abs(new - value) < size * 1e-6:
            break
        value = new
    return value


class ANGEN_GT_handle(Gizmo):
    """A handle of the active sensor: a ring with an arrowhead on either side along its path."""

    bl_idname = "ANGEN_GT_handle"

    __slots__ = ("begin", "handle", "mouse", "shape", "target", "value")

    def setup(self) -> None:
        self.shape = self.new_custom_shape("TRIS", _shape())
        self.handle: Any = None

    def draw(self, context: Context) -> None:
        self.draw_custom_shape(self.shape)
        sensor = sensor_with_handles(context) if self.is_highlight or self.is_modal else None
        if sensor is not None:
            text = self.handle.text(sensor, lengths_of(context.scene))
            _write(context, self.matrix_basis, f"{translated(self.handle.label(sensor))}: {text}")

    def draw_select(self, context: Context, select_id: int) -> None:
        self.draw_custom_shape(self.shape, select_id=select_id)

    def _project(self, context: Context, sensor: Sensor) -> Callable[[float], Pixel | None]:
        place = in_world(sensor, self.handle, unit_scale(context.scene))
        region, view = context.region, context.region_data
        return lambda value: location_3d_to_region_2d(region, view, Vector(place(value)))

    def invoke(self, context: Context, event: Event) -> set[str]:
        sensor = sensor_with_handles(context)
        if sensor is None:
            return {"CANCELLED"}
        self.begin = self.value = self.handle.value(sensor)
        self.mouse = event.mouse_region_x, event.mouse_region_y
        # The pixel where the handle would be without limits and snapping.
        self.target: Any = self._project(context, sensor)(self.value)
        return {"RUNNING_MODAL"} if self.target is not None else {"CANCELLED"}

    def modal(self, context: Context, event: Event, tweak: set[str]) -> set[str]:
        sensor = sensor_with_handles(context)
        if sensor is None:
            return {"CANCELLED"}
        mouse = event.mouse_region_x, event.mouse_region_y
        share = PRECISE if "PRECISE" in tweak else 1.0
        self.target = tuple(
            at + share * (new - old)
            for at, new, old in zip(self.target, mouse, self.mouse, strict=True)
        )
        self.mouse = mouse
        limits = self.handle.limits(sensor)
        project = self._project(context, sensor)
        self.value = drag_value(project, self.value, self.target, *limits)
        self.handle.set(sensor, self.value, snap="SNAP" in tweak)
        return {"RUNNING_MODAL"}

    def exit(self, context: Context, cancel: bool) -> None:
        sensor = sensor_with_handles(context)
        if sensor is None or self.handle.value(sensor) == self.begin:
            return
        if cancel:
            self.handle.put(sensor, self.begin)
        else:
            bpy.ops.ed.undo_push(message=translated(f"Drag {self.handle.label(sensor)}"))


def _write(context: Any, matrix: Matrix, text: str) -> None:
    """Write a text on the screen, beside the handle with the world matrix `matrix`."""
    import blf
    import gpu

    region, scale = context.region, context.preferences.system.ui_scale
    at = location_3d_to_region_2d(region, context.region_data, matrix.translation)
    if at is None:
        return
    pixels = Matrix.Diagonal((2.0 / region.width, 2.0 / region.height, 1.0, 1.0))
    with gpu.matrix.push_pop(), gpu.matrix.push_pop_projection():
        gpu.matrix.load_identity()
        gpu.matrix.load_projection_matrix(Matrix.Translation((-1.0, -1.0, 0.0)) @ pixels)
        blf.size(TEXT_FONT, TEXT_SIZE * scale)
        blf.enable(TEXT_FONT, blf.SHADOW)
        blf.shadow(TEXT_FONT, 5, 0.0, 0.0, 0.0, 1.0)
        blf.color(TEXT_FONT, *HIGHLIGHT, 1.0)
        blf.position(TEXT_FONT, at.x + TEXT_OFF * scale, at.y + TEXT_OFF * scale, 0.0)
        blf.draw(TEXT_FONT, text)
        blf.disable(TEXT_FONT, blf.SHADOW)


class ANGEN_GGT_handles(GizmoGroup):
    """The handles of the active sensor."""

    bl_idname = "ANGEN_GGT_handles"
    bl_label = "Handles of the Active Sensor"
    bl_space_type = "VIEW_3D"
    bl_region_type = "WINDOW"
    bl_options = {"3D", "PERSISTENT", "SHOW_MODAL_ALL"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        sensor = sensor_with_handles(context)
        return sensor is not None and bool(appearance_of(sensor.kind).handles)

    def setup(self, context: Context) -> None:
        for _ in range(MOST):
            gizmo = self.gizmos.new(ANGEN_GT_handle.bl_idname)
            gizmo.scale_basis = SIZE
            gizmo.use_draw_modal = True
            gizmo.color, gizmo.alpha = COLOUR, 0.8
            gizmo.color_highlight, gizmo.alpha_highlight = HIGHLIGHT, 1.0
            gizmo.hide = True

    def draw_prepare(self, context: Context) -> None:
        sensor = sensor_with_handles(context)
        used = handles_of(sensor) if sensor is not None else []
        for number, gizmo in enumerate(self.gizmos):
            gizmo.hide = number >= len(used)
            if sensor is None or gizmo.hide:
                continue
            gizmo.handle = used[number]
            try:
                gizmo.matrix_basis = matrix_of(context, sensor, used[number])
            except AngenError:
                gizmo.hide = True


def matrix_of(context: Any, sensor: Sensor, handle: Handle | SizeHandle) -> Matrix:
    """Return the world matrix of a handle, which faces the viewer with its X axis along its path.

    Raise `AngenError` if the sensor has no valid pose.
    """
    place, value = in_world(sensor, handle, unit_scale(context.scene)), handle.value(sensor)
    at = Vector(place(value))
    eye = context.region_data.view_matrix.to_3x3()
    along = eye @ (Vector(place(value + max(value, SMALL) * SMALL)) - at)
    turn = Matrix.Rotation(np.arctan2(along.y, along.x), 3, "Z")
    return Matrix.Translation(at) @ (eye.inverted() @ turn).to_4x4()


register, unregister = bpy.utils.register_classes_factory((ANGEN_GT_handle, ANGEN_GGT_handles))
