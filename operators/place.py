# SPDX-License-Identifier: GPL-3.0-or-later
"""Place a new sensor on the surface under the mouse.

The operator finds the surface, draws the sensor's outline there, and takes typed heights.
"""

from __future__ import annotations

import math
import re
from typing import Any

import bpy
import gpu
from bpy.props import BoolProperty, EnumProperty, FloatProperty, FloatVectorProperty, StringProperty
from bpy.types import Context, Event, Operator
from bpy_extras.view3d_utils import region_2d_to_origin_3d, region_2d_to_vector_3d
from gpu_extras.batch import batch_for_shader
from mathutils import Matrix, Vector

from ..angen_addon.appearance.housing import Housing, parent_keeping
from ..angen_addon.authoring.of_kind import housing_of, place_on
from ..angen_addon.authoring.presets import new_sensor
from ..angen_addon.scene.home.first_surface import UP, SurfacePoint, first_surface, floor_below
from ..angen_addon.scene.home.rooms import fill_room
from ..angen_addon.scene.lengths import lengths_of
from ..angen_addon.scene.sensors import unit_scale
from ..angen_addon.translations.interface import translated
from ..sensor_logic.kinds import KINDS
from ..sensor_logic.logs.error import AngenError
from .add import KIND_ITEMS, preset_of, preset_property
from .polls import can_add, cancelled

# The preview adds nothing to the scene, because that would make the recording stale.

COLOR = (1.0, 0.6, 0.1, 1.0)
LINE_WIDTH = 1.5
# Draw handlers in use. When the extension is switched off, Blender ends operators without `cancel`.
_handles: set[Any] = set()


class Preview:
    """Draws the outline of a housing at the world matrix `matrix`, unless `matrix` is None."""

    def __init__(self, context: Context, housing: Housing) -> None:
        self.matrix: Matrix | None = None
        self._scale = unit_scale(context.scene)
        self._area = context.area
        self._lines = [housing.points[i] for edge in housing.outline() for i in edge]
        self._handle: Any = bpy.types.SpaceView3D.draw_handler_add(
            self._draw, (context.region,), "WINDOW", "POST_VIEW"
        )
        _handles.add(self._handle)

    def show(self, context: Context, matrix: Matrix | None, header: str, keys: str) -> None:
        self.matrix = matrix
        self._area.header_text_set(header)
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
        # Points are relative to the housing's origin, where single precision is enough.
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
    """Remove the draw handlers of operators that Blender ended without a call of `cancel`."""
    if _handles and bpy.context.window_manager is not None:
        for window in bpy.context.window_manager.windows:
            for area in window.screen.areas:
                if area.type == "VIEW_3D":
                    _clear_texts(area, window.workspace)
    for handle in list(_handles):
        _remove(handle)


# A surface counts as level if the sine of its slope is smaller.
MIN_RISE = 0.5
# A typed length: numbers, each with or without a unit.
LENGTH = re.compile(r"-?((\d+\.?\d*|\.\d+)(mm|cm|m|ft|in|'|\")?)+")
NUMBER = re.compile(r"-?(\d+\.?\d*|\.\d+)")
TYPED = set("0123456789.-mcftin'\"")
ENDS = {"RET", "NUMPAD_ENTER"}


def height_text(scene: Any, place: Vector, floor: SurfacePoint | None) -> str:
    """Return a text with the height of the point `place`.

    If a floor is given, the text also has the height above the floor.
    """
    scale, lengths = unit_scale(scene), lengths_of(scene)
    height = f"Z {lengths.text(place.z * scale)}"
    if floor is None:
        return height
    above = lengths.text((place.z - floor.point.z) * scale)
    return f"{height}, {above} above '{floor.object.name}'"


def moved_up(point: Vector, normal: Vector, height: float) -> Vector | None:
    """Move a point along a surface until it is `height` higher, and return it.

    Return None if the surface is level.
    """
    along = UP - normal * normal.z
    if along.length < MIN_RISE:
        return None
    return point + along * (height / along.length_squared)


class TypedLength:
    """The text of a length, such as "1.2 m", while the user types it."""

    def __init__(self) -> None:
        self.text = ""

    def take(self, event: Event) -> bool:
        """Add a pressed key to the text. Return False if the key cannot be part of a length.

        A letter, as in "m", can only follow a number.
        """
        if event.type == "BACK_SPACE" and self.text:
            self.text = self.text[:-1]
            return True
        letter = "" if event.ctrl or event.alt else event.unicode.replace(",", ".")
        if event.type.startswith("NUMPAD_") and event.type[7:].isdigit():
            letter = event.type[7:]
        if len(letter) != 1 or letter not in TYPED or (letter.isalpha() and not self.text):
            return False
        self.text += letter
        return True

    def metres(self, scene: Any) -> float | None:
        """Return the length in metres, or None if the text is no length.

        A number without a unit is in the scene's unit.
        """
        if not LENGTH.fullmatch(self.text):
            return None
        number = NUMBER.fullmatch(self.text)
        if number is not None:
            return float(number.group()) * lengths_of(scene).metres
        system = "IMPERIAL" if scene.unit_settings.system == "IMPERIAL" else "METRIC"
        return float(bpy.utils.units.to_value(system, "LENGTH", self.text))


WHEEL_STEP, KEY_STEP = math.radians(15), math.radians(90)
NAVIGATION = {"MIDDLEMOUSE", "TRACKPADPAN", "TRACKPADZOOM", "MOUSEROTATE", "NDOF_MOTION"}
KEYS = (
    "Click: place", "R / Shift R: turn by 90°", "Wheel: turn by 15°",
    "Digits: height above the floor",
)  # fmt: skip
# Between the texts of the header and of the status bar.
APART = "    "


class ANGEN_OT_sensor_place(Operator):
    bl_idname = "angen.sensor_place"
    bl_label = "Place Sensor"
    bl_description = (
        "Place a sensor on the surface under the mouse: a motion detector looks level from a wall, "
        "and down from a ceiling; a pad lies on a floor or a seat; a switch is mounted on a door's "
        "frame. Click to place, R or wheel to turn, digits for the height on a wall, P to parent "
        "it to the surface, Esc to cancel"
    )
    bl_options = {"REGISTER", "UNDO"}

    kind: EnumProperty(name="Kind", items=KIND_ITEMS)
    preset: preset_property()
    location: FloatVectorProperty(
        name="Location", description="Point on the surface", subtype="TRANSLATION"
    )
    normal: FloatVectorProperty(
        name="Normal",
        description="Direction that the surface faces",
        subtype="DIRECTION",
        default=(0.0, 0.0, 1.0),
    )
    turn: FloatProperty(name="Turn", description="Rotation about the normal", subtype="ANGLE")
    surface: StringProperty(name="Surface", description="Name of the object that has the surface")
    follow: BoolProperty(name="Follow", description="Make the sensor a child of the surface")

    _preview: Preview | None = None
    _typed: TypedLength

    poll = classmethod(can_add)

    # Called by a script, and by the panel Adjust Last Operation

    def execute(self, context: Context) -> set[str]:
        normal = Vector(self.normal)
        surface = context.view_layer.objects.get(self.surface) if self.surface else None
        try:
            preset = preset_of(self)
            if normal.length == 0.0:
                raise AngenError("The normal is zero: give the direction that the surface faces")
            if self.surface and surface is None:
                raise AngenError(f"There is no object '{self.surface}' to place the sensor on")
        except AngenError as error:
            return cancelled(self, error)
        hit = SurfacePoint(Vector(self.location), normal, surface, True) if surface else None
        matrix = self._matrix(context, Vector(self.location), normal, hit.axes if hit else [])
        sensor = new_sensor(context, self.kind, preset)
        followed = bool(self.follow and surface) and parent_keeping(sensor, surface, matrix)
        if not followed:
            sensor.matrix_world = matrix
        fill_room(context.evaluated_depsgraph_get(), sensor, matrix.translation)
        if self.follow and not followed:
            self.report(
                {"WARNING"},
                translated(
                    f"'{sensor.name}' was placed without a parent: the surface is part of an "
                    "instance, or has a scale of 0"
                ),
            )
        else:
            text = f"Placed '{sensor.name}'"
            if surface is not None:
                text = f"Placed '{sensor.name}' on '{surface.name}'"
            self.report({"INFO"}, translated(text))
        return {"FINISHED"}

    def _matrix(
        self, context: Context, point: Vector, normal: Vector, along: list[Vector]
    ) -> Matrix:
        housing, scale = housing_of(self.kind, self.preset), unit_scale(context.scene)
        return place_on(self.kind, housing, point, normal, self.turn, along, scale)

    # Called by a click: the operator runs until the user places the sensor

    def invoke(self, context: Context, event: Event) -> set[str]:
        if context.area is None or context.area.type != "VIEW_3D" or context.region_data is None:
            return cancelled(self, "Place sensors with the mouse over a 3D view")
        try:
            preset_of(self)
        except AngenError as error:
            return cancelled(self, error)
        self._preview = Preview(context, housing_of(self.kind, self.preset))
        self._typed = TypedLength()
        context.window_manager.modal_handler_add(self)
        self._preview_at(context, event)
        return {"RUNNING_MODAL"}

    def modal(self, context: Context, event: Event) -> set[str]:
        pressed = event.value == "PRESS"
        if pressed and self._typed.take(event):
            self._preview_at(context, event)
            return {"RUNNING_MODAL"}
        pad = event.type.startswith("NUMPAD_") and event.type not in ENDS
        if pad or event.type in NAVIGATION:
            return {"PASS_THROUGH"}
        if event.type in {"ESC", "RIGHTMOUSE"} and pressed:
            self.cancel(context)
            return {"CANCELLED"}
        if event.type in {"LEFTMOUSE", *ENDS} and pressed:
            self._preview_at(context, event)
            if self._preview is not None and self._preview.matrix is not None:
                self.cancel(context)
                return self.execute(context)
            self.report(
                {"WARNING"},
                translated("No surface under the mouse: click on a wall, ceiling, floor …"),
            )
            return {"RUNNING_MODAL"}
        if event.type == "P" and pressed:
            self.follow = not self.follow
        elif event.type == "R" and pressed:
            self.turn += -KEY_STEP if event.shift else KEY_STEP
        elif event.type == "WHEELUPMOUSE":
            self.turn += WHEEL_STEP
        elif event.type == "WHEELDOWNMOUSE":
            self.turn -= WHEEL_STEP
        self._preview_at(context, event)
        return {"RUNNING_MODAL"}

    def cancel(self, context: Context) -> None:
        """Remove the preview. Blender also calls this when it ends the operator itself."""
        if self._preview is not None:
            self._preview.remove(context)
            self._preview = None

    def _preview_at(self, context: Context, event: Event) -> None:
        """Find the surface under the mouse, and draw the sensor there."""
        hit = _surface_under(context, event)
        matrix, facts = None, ["No surface under the mouse"]
        if hit is not None:
            matrix, facts = self._place_at(context, hit)
        header = APART.join(map(translated, [KINDS[self.kind].label, *facts]))
        parent = "P: leave the surface" if self.follow else "P: follow the surface"
        keys = APART.join(map(translated, [*KEYS, parent, "Esc: cancel"]))
        if self._preview is not None:
            self._preview.show(context, matrix, header, keys)

    def _place_at(self, context: Context, hit: SurfacePoint) -> tuple[Matrix, list[str]]:
        """Set `location` to the sensor's position on a surface, at the typed height if any.

        Return the matrix of the sensor, and the texts for the header.
        """
        scene, along = context.scene, hit.axes if hit.whole else []
        matrix = self._matrix(context, hit.point, hit.normal, along)
        floor = floor_below(scene, context.evaluated_depsgraph_get(), matrix.translation, hit)
        facts = [f"On '{hit.object.name}'"]
        height = self._typed.metres(scene)
        if height is not None:
            level = (floor.point.z if floor else 0.0) + height / unit_scale(scene)
            higher = moved_up(hit.point, hit.normal, level - matrix.translation.z)
            if higher is None:
                facts.append("A height can be typed only on walls, not on level surfaces")
            else:
                hit = hit._replace(point=higher)
                matrix = self._matrix(context, hit.point, hit.normal, along)
        self.location, self.normal = hit.point, hit.normal
        self.surface = hit.object.name if hit.whole else ""
        facts.append(height_text(scene, matrix.translation, floor))
        if self._typed.text:
            facts.append(f"Height: {self._typed.text}")
        return matrix, facts


def _surface_under(context: Context, event: Event) -> SurfacePoint | None:
    region = context.region
    # `event.mouse_region_x` can belong to an overlapping region: compute it for this one.
    at = (event.mouse_x - region.x, event.mouse_y - region.y)
    if not (0 <= at[0] < region.width and 0 <= at[1] < region.height):
        return None
    return visible_surface(
        context.scene,
        context.evaluated_depsgraph_get(),
        region_2d_to_origin_3d(region, context.region_data, at),
        region_2d_to_vector_3d(region, context.region_data, at),
        context.space_data.shading.show_backface_culling,
    )


def visible_surface(
    scene: Any, depsgraph: Any, origin: Vector, direction: Vector, culled: bool
) -> SurfacePoint | None:
    """Return the first surface along a ray that the user can see, or None.

    Objects that the viewport draws as wire or bounds are passed if there is a surface behind them.
    An example is a ceiling, seen from above.
    """
    hit = first_surface(scene, depsgraph, origin, direction, passes=_is_outline, culled=culled)
    return hit or first_surface(scene, depsgraph, origin, direction, culled=culled)


def _is_outline(obj: Any) -> bool:
    return obj.display_type in {"WIRE", "BOUNDS"}


register, _unregister = bpy.utils.register_classes_factory((ANGEN_OT_sensor_place,))


def unregister() -> None:
    remove_all()
    _unregister()
