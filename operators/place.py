# SPDX-License-Identifier: GPL-3.0-or-later
"""Places a new sensor on the surface under the mouse."""

from __future__ import annotations

import math
from typing import Any

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, FloatVectorProperty, StringProperty
from bpy.types import Context, Event, Operator
from bpy_extras.view3d_utils import region_2d_to_origin_3d, region_2d_to_vector_3d
from mathutils import Matrix, Vector

from ..angen_addon.authoring.of_kind import housing_of, place_on
from ..angen_addon.authoring.placing import parent_keeping
from ..angen_addon.authoring.presets import new_sensor
from ..angen_addon.scene.sensors import unit_scale
from ..sensor_logic.kinds import KINDS
from .add import KIND_ITEMS, preset_of, preset_property
from .height import ENDS, TypedLength, below, height_text, raised
from .place_preview import Preview, remove_all
from .polls import can_add, cancelled
from .surface import SurfacePoint, first_surface

WHEEL_STEP, KEY_STEP = math.radians(15), math.radians(90)
NAVIGATION = {"MIDDLEMOUSE", "TRACKPADPAN", "TRACKPADZOOM", "MOUSEROTATE", "NDOF_MOTION"}
KEYS = (
    "Click: place    R / Shift R: turn by 90°    Wheel: turn by 15°    "
    "Digits: height above the floor    P: {} the surface    Esc: cancel"
)


class ANGEN_OT_sensor_place(Operator):
    bl_idname = "angen.sensor_place"
    bl_label = "Place Sensor"
    bl_description = (
        "Place a sensor on the surface under the mouse: a motion detector looks level from a wall, "
        "and down from a ceiling; a pad lies on a floor or a seat; a switch stands on a door's "
        "frame. Click to place, R or wheel to turn, digits for the height on a wall, P to parent "
        "it to the surface, Esc to cancel"
    )
    bl_options = {"REGISTER", "UNDO"}

    kind: EnumProperty(name="Kind", items=KIND_ITEMS)
    preset: preset_property()
    location: FloatVectorProperty(
        name="Location", description="Where on the surface", subtype="TRANSLATION"
    )
    normal: FloatVectorProperty(
        name="Normal",
        description="Where the surface faces",
        subtype="DIRECTION",
        default=(0.0, 0.0, 1.0),
    )
    turn: FloatProperty(name="Turn", description="About the normal", subtype="ANGLE")
    surface: StringProperty(name="Surface", description="Name of the object that has the surface")
    follow: BoolProperty(name="Follow", description="The sensor becomes a child of the surface")

    _preview: Preview | None = None
    _typed: TypedLength

    poll = classmethod(can_add)

    # From a script, and again from the panel of the last operation

    def execute(self, context: Context) -> set[str]:
        normal = Vector(self.normal)
        surface = context.view_layer.objects.get(self.surface) if self.surface else None
        try:
            preset = preset_of(self)
            if normal.length == 0.0:
                raise KeyError("The normal is zero: give the direction that the surface faces")
            if self.surface and surface is None:
                raise KeyError(f"There is no object '{self.surface}' to place the sensor on")
        except KeyError as error:
            return cancelled(self, error.args[0])
        met = SurfacePoint(Vector(self.location), normal, surface, True) if surface else None
        matrix = self._matrix(context, Vector(self.location), normal, met.along if met else [])
        sensor = new_sensor(context, self.kind, preset)
        followed = bool(self.follow and surface) and parent_keeping(sensor, surface, matrix)
        if not followed:
            sensor.matrix_world = matrix
        if self.follow and not followed:
            self.report({"WARNING"}, f"'{sensor.name}' cannot follow here: it stands free")
        else:
            self.report({"INFO"}, f"Placed '{sensor.name}'{_on(surface)}")
        return {"FINISHED"}

    def _matrix(
        self, context: Context, point: Vector, normal: Vector, along: list[Vector]
    ) -> Matrix:
        housing, scale = housing_of(self.kind, self.preset), unit_scale(context.scene)
        return place_on(self.kind, housing, point, normal, self.turn, along, scale)

    # With the mouse

    def invoke(self, context: Context, event: Event) -> set[str]:
        if context.area is None or context.area.type != "VIEW_3D" or context.region_data is None:
            return cancelled(self, "Place sensors with the mouse over a 3D view")
        try:
            preset_of(self)
        except KeyError as error:
            return cancelled(self, error.args[0])
        self._preview = Preview(context, housing_of(self.kind, self.preset))
        self._typed = TypedLength()
        context.window_manager.modal_handler_add(self)
        self._look(context, event)
        return {"RUNNING_MODAL"}

    def modal(self, context: Context, event: Event) -> set[str]:
        pressed = event.value == "PRESS"
        if pressed and self._typed.take(event):
            self._look(context, event)
            return {"RUNNING_MODAL"}
        pad = event.type.startswith("NUMPAD_") and event.type not in ENDS
        if pad or event.type in NAVIGATION:
            return {"PASS_THROUGH"}
        if event.type in {"ESC", "RIGHTMOUSE"} and pressed:
            self.cancel(context)
            return {"CANCELLED"}
        if event.type in {"LEFTMOUSE", *ENDS} and pressed:
            self._look(context, event)
            if self._preview is not None and self._preview.matrix is not None:
                self.cancel(context)
                return self.execute(context)
            self.report(
                {"WARNING"}, "No surface under the mouse: click on a wall, ceiling, floor …"
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
        self._look(context, event)
        return {"RUNNING_MODAL"}

    def cancel(self, context: Context) -> None:
        """Blender also calls this where it ends the operator itself."""
        if self._preview is not None:
            self._preview.remove(context)
            self._preview = None

    def _look(self, context: Context, event: Event) -> None:
        """Finds the surface under the mouse, and shows the sensor there."""
        met = _surface_under(context, event)
        matrix, text = None, "No surface under the mouse"
        if met is not None:
            matrix, text = self._stand(context, met)
        keys = KEYS.format("leave" if self.follow else "follow")
        if self._preview is not None:
            self._preview.show(context, matrix, f"{KINDS[self.kind].label}    {text}", keys)

    def _stand(self, context: Context, met: SurfacePoint) -> tuple[Matrix, str]:
        """Sets the place on a surface, at the typed height if any; returns the matrix there and a
        text for the header."""
        scene, along = context.scene, met.along if met.whole else []
        matrix = self._matrix(context, met.point, met.normal, along)
        floor = below(scene, context.evaluated_depsgraph_get(), matrix.translation, met)
        text = f"On '{met.object.name}'    "
        height = self._typed.metres(scene)
        if height is not None:
            level = (floor.point.z if floor else 0.0) + height / unit_scale(scene)
            higher = raised(met.point, met.normal, level - matrix.translation.z)
            if higher is None:
                text += "Heights work on walls, not on level surfaces    "
            else:
                met = met._replace(point=higher)
                matrix = self._matrix(context, met.point, met.normal, along)
        self.location, self.normal = met.point, met.normal
        self.surface = met.object.name if met.whole else ""
        text += height_text(scene, matrix.translation, floor)
        return matrix, text + (f"    Height: {self._typed.text}" if self._typed.text else "")


def _on(surface: Any) -> str:
    return f" on '{surface.name}'" if surface is not None else ""


def _surface_under(context: Context, event: Event) -> SurfacePoint | None:
    region = context.region
    # Where the mouse is in the region, which its window's overlapping regions cover in part.
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
    """The surface that the user sees first along a ray: an object shown as an outline, such as a
    ceiling from above, only counts where nothing is behind it."""
    met = first_surface(scene, depsgraph, origin, direction, passes=_is_outline, culled=culled)
    return met or first_surface(scene, depsgraph, origin, direction, culled=culled)


def _is_outline(obj: Any) -> bool:
    return obj.display_type in {"WIRE", "BOUNDS"}


register, _unregister = bpy.utils.register_classes_factory((ANGEN_OT_sensor_place,))


def unregister() -> None:
    remove_all()
    _unregister()
