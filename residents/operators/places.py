# SPDX-License-Identifier: GPL-3.0-or-later
"""Add places for residents, guess a place's settings, and check which places are reachable."""

from __future__ import annotations

import bpy
from bpy.props import EnumProperty
from bpy.types import Context, Operator

from ...angen_addon.authoring.presets import select_only
from ...angen_addon.scene import memory
from ...angen_addon.scene.lengths import lengths_of
from ...angen_addon.scene.sensors import unit_scale
from ...angen_addon.translations.interface import translated
from ...operators.long_work import LongWork
from ...operators.polls import can_add, is_idle
from ...sensor_logic.logs.error import AngenError
from ...sensor_logic.logs.wording import capital
from ...sensor_logic.progress import Work
from ..acting import places as known
from ..blender import reachable
from ..blender.marks import LABELS, NONE, USES, guess
from ..blender.reachable import Checked, check_places_in_steps, sentences

# Kinds of places that an empty can mark. Doors and lamps need an object.
POINTS = (known.STAND, known.SIT, known.LIE, known.USE, known.TAP, known.APPLIANCE)
# m: size of the empty.
SHOWN_M = 0.1
POINT_ITEMS = [item for item in USES if item[0] in POINTS]


# What the last Check Places found, as a summary and as lines; None before it.
checked: tuple[str, tuple[str, ...]] | None = None


@memory.forgets_at_load
def forget() -> None:
    """Forget the findings, which are about the open file."""
    global checked
    checked = None


class ANGEN_OT_place_point(Operator):
    bl_idname = "angen.place_point"
    bl_label = "Add Place"
    bl_description = (
        "Add an empty at the 3D cursor as a place for residents. Put it where they stand, or on "
        "the seat, bed or other object that they use. Its arrow shows where they look, or where "
        "the head lies"
    )
    bl_options = {"REGISTER", "UNDO"}

    use: EnumProperty(name="Use", items=POINT_ITEMS)

    poll = classmethod(can_add)

    def execute(self, context: Context) -> set[str]:
        obj = bpy.data.objects.new(LABELS[self.use], None)
        obj.empty_display_type = "CIRCLE"
        obj.empty_display_size = SHOWN_M / unit_scale(context.scene)
        obj.matrix_world = context.scene.cursor.matrix
        context.collection.objects.link(obj)
        select_only(context, obj)
        obj.angen_place.use = self.use
        return {"FINISHED"}


class ANGEN_OT_place_guess(Operator):
    bl_idname = "angen.place_guess"
    bl_label = "Guess Again"
    bl_description = (
        "Guess where the object faces, or how far the door opens, from the object's "
        "shape and keyframes"
    )
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        return context.object is not None and context.object.angen_place.use != NONE

    def execute(self, context: Context) -> set[str]:
        guess(context.object, context.evaluated_depsgraph_get())
        return {"FINISHED"}


class ANGEN_OT_places_check(LongWork, Operator):
    bl_idname = "angen.places_check"
    bl_label = "Check Places"
    bl_description = (
        "Find the marked places that residents cannot reach from the entrance. A curve on the "
        "floor shows how far they get. Esc cancels"
    )
    bl_options = {"REGISTER", "UNDO"}

    poll = classmethod(is_idle)

    def _begin(self, context: Context) -> Work[Checked]:
        context.view_layer.update()
        try:
            found = yield from check_places_in_steps(context.evaluated_depsgraph_get())
        except AngenError as error:
            raise AngenError(capital(str(error))) from None
        return found

    def _finish(self, context: Context, result: Checked) -> None:
        global checked
        reachable.show(context.scene, result.places, result.lost)
        found = sentences(result, lengths_of(context.scene))
        checked = result.count, tuple(found)
        self.report({"WARNING" if found else "INFO"}, translated(result.count))


register, unregister = bpy.utils.register_classes_factory(
    (ANGEN_OT_place_point, ANGEN_OT_place_guess, ANGEN_OT_places_check)
)
