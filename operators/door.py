# SPDX-License-Identifier: GPL-3.0-or-later
"""Fit a door with an optical switch on its frame, and with a flag (a thin blade) on its leaf.

While the door is closed, the flag breaks the beam of the switch.
"""

from __future__ import annotations

import math
from typing import Any

import bpy
from bpy.props import BoolProperty, EnumProperty
from bpy.types import Context, Operator
from mathutils import Matrix, Vector

from ..angen_addon.appearance.housing import Housing, mesh_of, parent_keeping
from ..angen_addon.authoring.of_kind import place_on
from ..angen_addon.authoring.presets import new_sensor
from ..angen_addon.kinds.optical_switch import fork
from ..angen_addon.scene.door_motion import MOTIONS, Leaf, leaves_of
from ..angen_addon.scene.home.first_surface import SurfacePoint, belongs_to, first_surface
from ..angen_addon.scene.home.rooms import fill_room
from ..angen_addon.scene.sensors import unit_scale
from ..angen_addon.translations.interface import translated
from ..sensor_logic.logs.error import AngenError
from .polls import can_add, cancelled, needs

KIND = "OPTICAL_SWITCH"
# m: the gap and the fork of a switch's default housing. The flag is in the middle of the gap.
GAP, FORK = 0.05, fork(0.05, 0.09, 0.024, 0.06)
INSET = 0.06  # from the leaf's free edge to the flag
FLAG_HALF, FLAG_THIN, FLAG_OVER, FOOT = 0.008, 0.002, 0.012, 0.025
POST_AT, POST_THIN = 0.02, 0.004  # the post of a sliding leaf's flag, in front of the beam
# m: heights above the leaf at which to search for a frame. A sliding leaf needs at least ARM_BELOW,
# because its fork has an arm below the beam.
HEIGHTS = (0.025, 0.04, 0.06, 0.09, 0.12, 0.16)
ARM_BELOW = 0.05
# m: the search starts this far in front of the leaf, and ends this far behind its face.
BEFORE, BEHIND = 0.3, 0.3

# Hz. At 1 Hz, the default, a door reads shut for up to a second after it has opened.
RATE = 10.0
GUESS = (
    "Nothing shows where its hinge is: it is assumed at the {}, seen from the switch. To change "
    "that, choose another Motion in Adjust Last Operation (F9)"
)


class ANGEN_OT_door_fit(Operator):
    bl_idname = "angen.door_fit"
    bl_label = "Fit Door with Switch"
    bl_description = (
        "Give a door an optical switch on its frame, at the leaf's free upper corner, and a flag "
        "on the leaf that breaks the beam while the door is closed. With the playhead where the "
        "door is closed, select the door frame or wall, then the leaf"
    )
    bl_options = {"REGISTER", "UNDO"}

    motion: EnumProperty(name="Motion", description="How the leaf moves", items=MOTIONS)
    flip: BoolProperty(name="Other Side", description="The door opens to the other side")

    @classmethod
    def poll(cls, context: Context) -> bool:
        return can_add(cls, context) and needs(
            cls,
            context.object is not None and context.object.type == "MESH",
            "Select the frame or wall, then the leaf of the door",
        )

    def execute(self, context: Context) -> set[str]:
        leaf_object = context.object
        frames = [o for o in context.selected_objects if o != leaf_object]
        try:
            _refuse_fitted(context, leaf_object)
            leaves = leaves_of(leaf_object, self.motion)
            leaf, frame = _frame_of(context, leaf_object, frames, leaves, self.flip)
        except AngenError as error:
            return cancelled(self, f"'{leaf_object.name}': {error}")
        scale = unit_scale(context.scene)
        matrix = _switch_matrix(leaf, frame.point, scale)
        flag = _new_flag(context, leaf_object, leaf, matrix, scale)
        sensor = new_sensor(context, KIND, None, f"Switch {_short_name(leaf_object)}")
        sensor["door"] = leaf_object.name
        sensor.angen_sensor.update_rate = RATE
        if not (frame.whole and parent_keeping(sensor, frame.object, matrix)):
            sensor.matrix_world = matrix
        context.view_layer.update()
        # The room on this side of the door, not below its frame.
        before = matrix.translation + leaf.out * (BEFORE / scale)
        fill_room(context.evaluated_depsgraph_get(), sensor, before)
        problem = _why_not_working(context, sensor, flag, leaf_object, scale)
        if problem:
            self.report({"WARNING"}, translated(f"'{sensor.name}': {problem}"))
        else:
            kind = "sliding" if leaf.slides else "hinged"
            text = (
                f"Fitted the {kind} door '{leaf_object.name}': '{sensor.name}' on "
                f"'{frame.object.name}', '{flag.name}' on the leaf"
            )
            if leaf.guessed:
                side = "left" if leaf.hand == "LEFT" else "right"
                text += f". {GUESS.format(side)}"
            self.report({"INFO"}, translated(text))
        return {"FINISHED"}


def _short_name(leaf: Any) -> str:
    """Return the leaf's name for use in other names, such as "hall" for "Door hall"."""
    return leaf.name.removeprefix("Door ")


def _refuse_fitted(context: Context, leaf: Any) -> None:
    for obj in context.view_layer.objects:
        if obj.get("door") == leaf.name and obj.angen_sensor.kind == KIND:
            raise AngenError(f"it has the switch '{obj.name}' already: delete that first")


def _frame_of(
    context: Context, leaf_object: Any, frames: list[Any], side_groups: list[list[Leaf]], flip: bool
) -> tuple[Leaf, SurfacePoint]:
    """Return the side of the door leaf for the switch, and the surface to mount the switch on.

    `side_groups` are groups of possible sides. The first group with a suitable surface is used. If
    `flip` is True, use the opposite side. Raise `AngenError` if no surface is near the leaf's free
    upper corner.
    """
    for sides in side_groups:
        found = [
            (s, hit) for s in sides if (hit := _surface_above(context, leaf_object, frames, s))
        ]
        # A frame is nearly flush with the leaf's face: prefer the surface nearest to the face.
        found.sort(key=lambda pair: abs((pair[1].point - pair[0].corner).dot(pair[0].out)))
        if flip:
            turned = (found[0][0] if found else sides[0]).turned_round()
            hit = _surface_above(context, leaf_object, frames, turned)
            found = [(turned, hit)] if hit else []
        if found:
            return found[0]
    names = ", ".join(f"'{o.name}'" for o in frames)
    what = f"no part of {names}" if frames else "no frame or wall"
    raise AngenError(
        f"{what} is behind its free upper corner, up to 16 cm above its top: select the frame or "
        "wall there, then the leaf"
    )


def _surface_above(
    context: Context, leaf_object: Any, frames: list[Any], leaf: Leaf
) -> SurfacePoint | None:
    """Return a point above the leaf, in front of all parts of the frame, to mount the switch."""
    scale = unit_scale(context.scene)

    def passes(obj: Any) -> bool:
        if frames:
            return not any(belongs_to(obj, frame) for frame in frames)
        return belongs_to(obj, leaf_object) or obj.angen_sensor.kind != "NONE"

    for height in HEIGHTS:
        if leaf.slides and height < ARM_BELOW:
            continue
        hits = []
        for aside in (-INSET / 2, 0.0, INSET / 2):
            start = leaf.corner + leaf.up * (height / scale) + leaf.edge * ((aside - INSET) / scale)
            hits.append(
                first_surface(
                    context.scene, context.evaluated_depsgraph_get(),
                    start + leaf.out * (BEFORE / scale), -leaf.out,
                    (BEFORE + BEHIND) / scale + leaf.thickness, passes,
                )
            )  # fmt: skip
        if all(hit is not None for hit in hits):
            middle, foremost = hits[1], max(hit.point.dot(leaf.out) for hit in hits if hit)
            assert middle is not None
            point = middle.point + leaf.out * (foremost - middle.point.dot(leaf.out))
            return middle._replace(point=point)
    return None


def _switch_matrix(leaf: Leaf, point: Vector, scale: float) -> Matrix:
    """Return the world matrix of a switch whose beam has its middle at `point`."""
    # The flag of a hinged leaf swings out between two arms that are side by side. That of a sliding
    # leaf moves out between an upper and a lower arm.
    turn = math.pi / 2 if leaf.slides else 0.0
    matrix = place_on(KIND, FORK, point, leaf.out, turn, unit_scale=scale)
    return Matrix.Translation(matrix.col[2].xyz * (GAP / 2 / scale)) @ matrix


def _new_flag(context: Context, leaf_object: Any, leaf: Leaf, switch: Matrix, scale: float) -> Any:
    """Add a thin flag to the leaf, in the beam of the switch while the door is closed."""
    beam = switch @ Vector((0, 0, -GAP / 2 / scale)) - leaf.corner
    across, over = beam.dot(leaf.out) * scale, beam.dot(leaf.up) * scale
    shape = flag_shape(across, over, leaf.thickness * scale, leaf.slides)
    flag = bpy.data.objects.new(f"Flag {_short_name(leaf_object)}", mesh_of(shape, "Flag", scale))
    context.collection.objects.link(flag)
    side = Matrix((leaf.up.cross(leaf.out), leaf.out, leaf.up)).transposed()
    world = Matrix.Translation(leaf.corner - leaf.edge * (INSET / scale)) @ side.to_4x4()
    parent_keeping(flag, leaf_object, world)
    return flag


def flag_shape(across: float, over: float, thickness: float, slides: bool) -> Housing:
    """Return the mesh of a flag, in metres, with its origin at the leaf's top edge.

    Its x axis points along the leaf, y out of the leaf's face, and z up. The beam's middle is
    `across` metres in front of the face, and `over` metres above the top edge. `slides` says
    whether the leaf slides; otherwise it is hinged.
    """
    shape, half = Housing(), FLAG_THIN / 2
    if slides:
        # A level blade, carried by a post in front of the fork.
        post = across + POST_AT
        shape.box((-FLAG_HALF, across - FLAG_HALF, over - half),
                  (FLAG_HALF, post + POST_THIN, over + half))  # fmt: skip
        low, high, half, top = post, post + POST_THIN, FLAG_HALF, over
    else:
        low, high, top = across - FLAG_HALF, across + FLAG_HALF, over + FLAG_OVER
    if low <= 0.0 and high >= -thickness:  # above the leaf: the flag is mounted on its top
        return shape.box((-half, low, 0.0), (half, high, top))
    shape.box((-half, low, -FOOT), (half, high, top))
    if low > 0.0:
        return shape.box((-half, 0.0, -FOOT), (half, low, 0.0))
    return shape.box((-half, high, -FOOT), (half, -thickness, 0.0))


def _why_not_working(context: Context, sensor: Any, flag: Any, leaf: Any, scale: float) -> str:
    """Return a text on why the switch cannot sense the door; empty if it can.

    `flag` is the object on the leaf that blocks the beam while the door is shut. Something else may
    be hit before the flag, or may block the beam even without flag and leaf.
    """
    matrix = sensor.matrix_world
    start, beam = matrix.translation, -matrix.col[2].xyz.normalized()
    depsgraph, gap = context.evaluated_depsgraph_get(), GAP / scale

    def first_hit(passes: Any) -> SurfacePoint | None:
        return first_surface(context.scene, depsgraph, start, beam, gap, passes)

    first = first_hit(lambda obj: belongs_to(obj, sensor))
    if first is None or first.object != flag:
        what = f"'{first.object.name}'" if first else "nothing"
        return f"its beam hits {what} before the flag: tick Other Side, or move the switch"
    other = first_hit(lambda obj: belongs_to(obj, sensor) or belongs_to(obj, leaf))
    if other is not None:
        return f"'{other.object.name}' is in its gap, so it would never read open: move the object"
    return ""


register, unregister = bpy.utils.register_classes_factory((ANGEN_OT_door_fit,))
