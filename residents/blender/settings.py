# SPDX-License-Identifier: GPL-3.0-or-later
"""The settings of residents (`obj.angen_resident`), and the adding of residents."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import bpy
import numpy as np
from bpy.props import EnumProperty, FloatProperty, PointerProperty
from bpy.types import Object, PropertyGroup
from mathutils import Euler, Matrix, Vector

from ...angen_addon.advice.warmth import USUAL, warm
from ...angen_addon.authoring.presets import select_only
from ...angen_addon.scene.lengths import length_in_units
from ...angen_addon.scene.sensors import unit_scale
from ..acting.timeline import SITTING, STANDING
from ..body import gait as walker
from ..body.gait import Stance
from ..body.moves import lying, sitting, standing
from ..body.pose import BodyPose
from ..body.poses import seat_distance
from ..body.skeleton import BUILDS, SKELETON_STATURE, Build, Sort
from ..body.solve import channels
from .person import LABELS, add_person, body_of

NO_RESIDENT = "NONE"
_TIPS = {
    Sort.OLDER_ADULT: "Walks slowly, with short steps and a bent back",
    Sort.ADULT: "A grown-up person",
    Sort.CHILD: "A child of about seven",
    Sort.CAT: "Walks on four legs; sits and lies",
}
SORT_ITEMS = [
    (sort.value, LABELS[sort], _TIPS[sort], number)
    for number, sort in enumerate((Sort.OLDER_ADULT, Sort.ADULT, Sort.CHILD, Sort.CAT), 1)
]


def _sort_of(group: Any) -> Sort:
    return Sort(group.sort) if group.sort != NO_RESIDENT else Sort.ADULT


def is_placed_by_others(obj: Any) -> bool:
    """Return whether more than an object's own location, rotation and scale places it."""
    return bool(
        obj.parent is not None
        or any(obj.delta_location)
        or any(obj.delta_rotation_euler)
        or obj.delta_rotation_quaternion.angle
        or any(one != 1.0 for one in obj.delta_scale)
    )


def above(obj: Any) -> Matrix:
    """Return the matrix that an object's parent adds to its own location, rotation and scale."""
    if obj.parent is None:
        return Matrix()
    if obj.parent_type == "OBJECT":
        return obj.parent.matrix_world @ obj.matrix_parent_inverse
    return obj.matrix_world @ obj.matrix_basis.inverted_safe()


def _get_stature(group: Any) -> float:
    """Return the stature that was set, or the height of an armature that was scaled since, m.

    What scales the armature from above, such as an empty for the whole home, does not change it.
    """
    rig = group.id_data
    own = float(rig.scale[2]) * _stature_of_one(group)
    if not group.kept_scale or math.isclose(rig.scale[2], group.kept_scale, rel_tol=1e-4):
        return own * float(group.kept_above)
    return drawn_stature(rig) if is_placed_by_others(rig) else own


def _set_stature(group: Any, stature: float) -> None:
    rig = group.id_data
    one, own = _stature_of_one(group), float(rig.scale[2])
    # So that the body is also drawn with this stature.
    is_scaled = is_placed_by_others(rig) and own > 0.0 and drawn_stature(rig) > 0.0
    group.kept_above = drawn_stature(rig) / (own * one) if is_scaled else 1.0
    size = stature / one / group.kept_above
    rig.scale = (size, size, size)
    group.kept_scale = size


def _stature_of_one(group: Any) -> float:
    """Return the stature of a resident whose armature has the scale 1, m."""
    return float(SKELETON_STATURE[_sort_of(group)]) * unit_scale(bpy.context.scene)


def drawn_stature(rig: Any) -> float:
    """Return the height that a resident's body has in the scene, m."""
    return float(rig.matrix_world.to_scale()[2]) * _stature_of_one(rig.angen_resident)


def _get_mass(group: Any) -> float:
    body = body_of(group.id_data)
    return float(body.angen_load.mass) if body is not None else 0.0


def _set_mass(group: Any, mass: float) -> None:
    body = body_of(group.id_data)
    if body is not None:
        body.angen_load.mass = mass


SPEED_TIP = "Usual walking speed, which also sets the length of steps"
STATURE_TIP = "Height of the body, or of a cat's back; sets the scale of the armature"


class ANGEN_PG_resident(PropertyGroup):
    sort: EnumProperty(
        name="Type",
        description="Type of resident, which decides the body and how it moves",
        items=[
            (NO_RESIDENT, "No Resident", "Moved only by its own animation", 0),
            *SORT_ITEMS,
        ],
    )
    speed: FloatProperty(
        name="Speed",
        description=SPEED_TIP,
        default=1.1, min=0.05, soft_min=0.3, soft_max=1.6, unit="VELOCITY",
    )  # fmt: skip
    speed_in_units: length_in_units("speed", "Speed", SPEED_TIP, unit="VELOCITY")
    stature: FloatProperty(
        name="Stature",
        description=STATURE_TIP,
        get=_get_stature, set=_set_stature, min=0.05, soft_max=2.2, precision=3, unit="LENGTH",
    )  # fmt: skip
    stature_in_units: length_in_units("stature", "Stature", STATURE_TIP)
    # The armature's own scale when the stature was set, and what its parent then scaled it by.
    kept_scale: FloatProperty(options={"HIDDEN"})
    kept_above: FloatProperty(options={"HIDDEN"}, default=1.0)
    mass: FloatProperty(
        name="Mass",
        description="Mass with which the body weighs on pads",
        get=_get_mass, set=_set_mass, min=0.0, soft_max=150.0,
    )  # fmt: skip
    walking_frame: PointerProperty(
        name="Walking Frame",
        description="Object that the resident pushes with both hands as it walks",
        type=Object,
    )


def is_resident(obj: Any) -> bool:
    return obj is not None and obj.type == "ARMATURE" and obj.angen_resident.sort != NO_RESIDENT


def residents_in(scene: Any) -> list[Any]:
    """Return the armatures of all residents of a scene, sorted by name."""
    return sorted(filter(is_resident, scene.objects), key=lambda obj: obj.name)


def build_of(obj: Any) -> Build:
    """Return the build of a resident's armature; raise `ValueError` if it is no resident."""
    if not is_resident(obj):
        raise ValueError(f"'{obj.name}' is not a resident: add one with Shift+A, Sensor, Resident")
    settings = obj.angen_resident
    return Build(
        Sort(settings.sort), settings.stature, settings.mass, settings.speed,
        settings.walking_frame is not None,
    )  # fmt: skip


def make_resident(obj: Any, sort: Sort) -> None:
    """Make an armature a resident, with the usual size, mass and speed of a sort of body."""
    usual, settings = BUILDS[sort], obj.angen_resident
    settings.sort = sort.value
    settings.stature, settings.mass, settings.speed = usual.stature, usual.mass, usual.speed


_register, _unregister = bpy.utils.register_classes_factory((ANGEN_PG_resident,))


def register() -> None:
    _register()
    Object.angen_resident = PointerProperty(type=ANGEN_PG_resident)


def unregister() -> None:
    del Object.angen_resident
    _unregister()


# New residents, with a mass and a temperature.


def add_resident(context: Any, sort: Sort, at: Vector, yaw: float, with_frame: bool = False) -> Any:
    """Add a resident that stands at a point (Blender units) and looks along `yaw` (rad)."""
    collection = context.collection
    rig = add_person(collection, sort)
    make_resident(rig, sort)
    rig.location, rig.rotation_euler = at, (0.0, 0.0, yaw)
    # Objects removed while building the body stay in the view layer until this update.
    context.view_layer.update()
    warm(body_of(rig), USUAL["PET" if sort is Sort.CAT else "PERSON"], context.view_layer)
    if with_frame:
        add_walking_frame(rig)
    stand_up(rig)
    select_only(context, rig)
    return rig


def stand_up(rig: Any) -> None:
    """Pose a resident's bones as standing, with a walking frame in front if there is one."""
    place, yaw = rig.location, rig.rotation_euler.z
    if is_placed_by_others(rig):
        place, yaw = rig.matrix_world.translation, rig.matrix_world.to_euler().z
    place = place * unit_scale(bpy.context.scene)
    show_pose(rig, posed(build_of(rig), STANDING, place, yaw, place.z))


def posed(
    build: Build, posture: str, at: Sequence[float], yaw: float, floor: float = 0.0, side: int = 0
) -> BodyPose:
    """Return one pose (n = 1) of a posture at a point (m).

    Parameters
    ----------
    build
        The build of the resident.
    posture
        "standing" at the point, "sitting" on it, or "lying" with the hips over it.
    at
        The point (x, y, z): on the floor, on a seat, or on what bears a lying person.
    yaw
        Where the resident looks, or where the head of a lying one points, in rad; 0 is +x.
    floor
        The height of the floor, for the feet of a sitting person.
    side
        Whether a person lies on the back (0), the left (1) or the right side (−1).
    """
    x, y, z = at
    if posture == STANDING:
        return standing(Stance.at(x, y, yaw, build), z, build)
    ahead = seat_distance(build)
    before = Stance.at(x + ahead * math.cos(yaw), y + ahead * math.sin(yaw), yaw, build)
    stand = standing(before, floor, build)
    point = np.array(at, float)
    return sitting(stand, point) if posture == SITTING else lying(stand, point, yaw, side)


def straighten_bones(rig: Any) -> None:
    """Set all bones of a resident to rest, so that poses and keyframes need no other channels."""
    for bone in rig.pose.bones:
        bone.rotation_mode = "QUATERNION"
        bone.location, bone.rotation_quaternion, bone.scale = (0, 0, 0), (1, 0, 0, 0), (1, 1, 1)


def show_pose(rig: Any, pose: BodyPose) -> None:
    """Move a resident's armature and walking frame to one pose (n = 1), without keyframes."""
    metres = unit_scale(bpy.context.scene)
    rest = {bone.name: np.array(bone.matrix_local.to_quaternion()) for bone in rig.data.bones}
    found = list(channels(pose, rest))
    if is_placed_by_others(rig):
        place = [float(values[0]) / metres for path, _, values in found if path == "location"]
        turn, size = Euler((0.0, 0.0, float(pose.heading[0]))), [pose.build.scale / metres] * 3
        rig.matrix_world = Matrix.LocRotScale(Vector(place), turn, Vector(size))
        found = [one for one in found if one[0].startswith("pose.bones")]
    straighten_bones(rig)
    for path, index, values in found:
        owner, _, name = path.rpartition(".")
        value = float(values[0]) / (metres if path == "location" else 1.0)
        getattr(rig.path_resolve(owner) if owner else rig, name)[index] = value
    frame = rig.angen_resident.walking_frame
    if frame is not None:
        frame.location = Vector(pose.walker[0, :3].tolist()) / metres
        frame.rotation_euler = (0.0, 0.0, float(pose.walker[0, 3]))


def add_walking_frame(rig: Any) -> Any:
    """Add a walking frame with four wheels, in the resident's size, and return its object."""
    mesh = bpy.data.meshes.new(f"{rig.name} walking frame")
    points: list[Vector] = []
    faces: list[list[int]] = []
    for start, end, radius in _tubes():
        _add_tube(points, faces, Vector(start), Vector(end), radius)
    mesh.from_pydata(points, [], faces)
    mesh.update()
    mesh.materials.append(_metal())
    frame = bpy.data.objects.new(mesh.name, mesh)
    rig.users_collection[0].objects.link(frame)
    frame.scale = rig.scale
    rig.angen_resident.walking_frame = frame
    return frame


def _tubes() -> list[tuple[tuple[float, ...], tuple[float, ...], float]]:
    """Return both ends and the radius of each tube of a walking frame."""
    back, side, high = walker.HANDLE_BACK, walker.HANDLE_SIDE, walker.HANDLE_HEIGHT
    tubes: list[tuple[tuple[float, ...], tuple[float, ...], float]] = []
    for y in (side, -side):
        out = y + (0.02 if y > 0 else -0.02)
        tubes += [
            ((back - 0.08, y, high), (back + 0.06, y, high), 0.017),
            ((back + 0.05, y, high), (-0.20, out, 0.09), 0.012),
            ((back + 0.05, y, high - 0.25), (0.24, out, 0.09), 0.012),
            ((-0.20, out - 0.015, 0.09), (-0.20, out + 0.015, 0.09), 0.09),
            ((0.24, out - 0.015, 0.09), (0.24, out + 0.015, 0.09), 0.09),
        ]
    tubes += [((x, -side, z), (x, side, z), 0.010) for x, z in ((0.02, 0.52), (0.16, 0.30))]
    tubes.append(((-0.02, -side + 0.03, 0.55), (-0.02, side - 0.03, 0.55), 0.05))
    return tubes


def _add_tube(
    points: list[Vector], faces: list[list[int]], start: Vector, end: Vector, radius: float
) -> None:  # fmt: skip
    along = (end - start).to_track_quat("Z", "X").to_matrix()
    first, sides = len(points), 12
    for middle in (start, end):
        for k in range(sides):
            rim = Matrix.Rotation(6.283185307 * k / sides, 3, "Z") @ Vector((radius, 0.0, 0.0))
            points.append(middle + along @ rim)
    for k in range(sides):
        after = (k + 1) % sides
        faces.append([first + k, first + after, first + sides + after, first + sides + k])
    faces.append([first + k for k in reversed(range(sides))])
    faces.append([first + sides + k for k in range(sides)])


def _metal() -> bpy.types.Material:
    name = "Walking frame metal"
    material = bpy.data.materials.get(name)
    if material is None:
        material = bpy.data.materials.new(name)
        material.diffuse_color = (0.35, 0.36, 0.38, 1.0)
        material.metallic, material.roughness = 0.6, 0.4
    return material
