# SPDX-License-Identifier: GPL-3.0-or-later
"""A day reads the same whatever is above a resident: an empty, a delta transform, another scale."""

from __future__ import annotations

from datetime import date
from typing import Any

import bpy
import numpy as np
import pytest
from day_home import part
from mathutils import Euler, Vector

ROUTINE = """
schema = 1
[person.anna]
resident = "Anna"
begins = "Sleep"
[activity.Sleep]
do = ["lie Bed"]
while = []
[activity.Sit]
do = ["sit Chair"]
while = []
[[plan]]
person = "anna"
entries = [
  { at = "00:01", activity = "Sit", until = "12:00" },
  { at = "12:00", activity = "Sleep", until = "23:00" },
]
"""


@pytest.fixture
def home(world):
    """Add a room with a bed and a chair, a resident with a walking frame, and range finders."""
    world.hall(5.0, 4.0, 2.6)
    bed = world.box((2.0, 0.9, 0.5), (1.2, 3.4, 0.25), "Bed")
    chair = world.box((0.45, 0.45, 0.45), (4.3, 0.5, 0.225), "Chair")
    settings = part("residents.blender.settings")
    sort = part("residents.body.skeleton").Sort.ADULT
    rig = settings.add_resident(bpy.context, sort, Vector((2.5, 1.5, 0.0)), 0.0, with_frame=True)
    rig.name = "Anna"
    world.update()
    bed.angen_place.use, bed.angen_place.facing = "LIE", np.pi / 2
    chair.angen_place.use, chair.angen_place.facing = "SIT", -np.pi / 2
    for name, at in (("over bed", (1.2, 3.4, 2.5)), ("over way", (2.5, 1.5, 2.5))):
        tof = world.sensor("DISTANCE", name, update_rate=2.0, noise=0.0)
        tof.location = at
    world.update()
    return world


def events() -> list[tuple[Any, ...]]:
    """Return the events of the first two and a half minutes of a day."""
    run, sensors = part("residents.blender.run"), part("angen_addon.scene.sensors")
    found = sensors.all_sensors(bpy.context.view_layer)
    plan = run.Plan.from_text(ROUTINE, "routine")
    household = run.HouseholdDays(bpy.context.scene, found, plan, date(2026, 3, 2), 0)
    [day] = run.run_days(household, [0], between=(0.0, 150.0))
    notes.extend(household.take_notes())
    return [(e.time, e.sensor, e.field, e.value) for e in day.events]


notes: list[str] = []


def below(*objects: Any, at=(0, 0, 0), turn=(0, 0, 0), scale=(1, 1, 1)) -> Any:
    """Parent objects to an empty without keeping their transforms."""
    empty = bpy.data.objects.new("Above", None)
    bpy.context.scene.collection.objects.link(empty)
    empty.location, empty.rotation_euler, empty.scale = at, turn, scale
    for obj in objects:
        obj.parent = empty
    bpy.context.view_layer.update()
    return empty


def resident() -> Any:
    return bpy.data.objects["Anna"]


def frame() -> Any:
    return resident().angen_resident.walking_frame


def moved() -> None:
    below(resident(), at=(0.7, -0.4, 0.3))


def turned() -> None:
    below(resident(), turn=(0, 0, 0.8))


def tilted() -> None:
    below(resident(), frame(), turn=(np.pi / 2, 0.2, 0.1), at=(1, 0, 0))


def scaled() -> None:
    below(resident(), scale=(2, 2, 2))


def shrunk() -> None:
    below(resident(), frame(), scale=(0.01, 0.01, 0.01))


def kept() -> None:
    empty = below(at=(1, 2, 0), turn=(0, 0, 0.5), scale=(3, 3, 3))
    for obj in (resident(), frame()):
        obj.parent, obj.matrix_parent_inverse = empty, empty.matrix_world.inverted()
    bpy.context.view_layer.update()


def delta() -> None:
    rig = resident()
    rig.delta_location, rig.delta_rotation_euler = (0.5, 0.3, 0.1), Euler((0.1, 0.0, 0.4))
    rig.delta_scale = (1.5, 1.5, 1.5)
    frame().delta_location = (0.2, 0.0, 0.0)


def delta_quaternion() -> None:
    rig = resident()
    rig.rotation_mode = "QUATERNION"
    rig.delta_rotation_quaternion = Euler((0.2, 0.1, 0.4)).to_quaternion()


def nested() -> None:
    below(below(resident(), turn=(0, 0, 1.0), scale=(0.5, 0.5, 0.5)), at=(1, 0, 0), scale=(3, 3, 3))


def everything() -> None:
    """All that is in the home was made at half its size, and is scaled under one empty."""
    tops = [obj for obj in bpy.data.objects if obj.parent is None]
    for obj in tops:
        obj.location, obj.scale = obj.location * 0.5, obj.scale * 0.5
    below(*tops, scale=(2, 2, 2))


def everything_but_the_frame() -> None:
    tops = [obj for obj in bpy.data.objects if obj.parent is None and obj != frame()]
    for obj in tops:
        obj.location -= Vector((3.0, 2.0, 0.0))
    below(*tops, at=(3, 2, 0))


def higher() -> None:
    """The rooms were too low, so the home is scaled upwards: what stands can still turn."""
    below(resident(), frame(), scale=(1, 1, 1.2))


def to_a_bone() -> None:
    rig = bpy.data.objects.new("rig", bpy.data.armatures.new("rig"))
    bpy.context.scene.collection.objects.link(rig)
    rig.location = (1, 1, 0)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    bone = rig.data.edit_bones.new("bone")
    bone.head, bone.tail = (0, 0, 0), (0, 0.5, 0.2)
    bpy.ops.object.mode_set(mode="OBJECT")
    obj = resident()
    obj.parent, obj.parent_type, obj.parent_bone = rig, "BONE", "bone"


def frame_below_resident() -> None:
    frame().parent = resident()
    frame().matrix_parent_inverse = resident().matrix_world.inverted()


def on_a_chair() -> None:
    """The resident is a child of a marked place, which must not count it as a part."""
    resident().parent = bpy.data.objects["Chair"]
    resident().matrix_parent_inverse = bpy.data.objects["Chair"].matrix_world.inverted()


def posed_otherwise() -> None:
    """The user has turned and scaled bones, by other rotation modes than the keyframes have."""
    resident().rotation_mode = "AXIS_ANGLE"
    for bone in resident().pose.bones:
        bone.rotation_mode = "XYZ"
        bone.location, bone.scale, bone.rotation_euler = (0.3, 0, 0), (1.5, 1, 1), (0.2, 0, 0)


WAYS = [moved, turned, tilted, scaled, shrunk, kept, delta, delta_quaternion, nested,
        everything, everything_but_the_frame, higher, to_a_bone, frame_below_resident, on_a_chair,
        posed_otherwise]  # fmt: skip


@pytest.fixture(scope="module")
def right() -> list[Any]:
    return []


@pytest.mark.parametrize("way", WAYS)
def test_the_log_is_the_same_as_without(home, right, way) -> None:
    if not right:
        right.extend(events())
        assert len(right) > 8
    rig = resident()
    way()
    bpy.context.view_layer.update()
    before = [obj.matrix_world.copy() for obj in (rig, frame())]
    stature = rig.angen_resident.stature
    assert stature == pytest.approx(1.75, abs=0.05)
    notes.clear()
    found = events()
    assert notes == []
    assert [row[:3] for row in found] == [row[:3] for row in right]
    assert [float(row[3]) for row in found] == pytest.approx([float(r[3]) for r in right], abs=2e-3)
    # All is as it was.
    bpy.context.view_layer.update()
    for obj, matrix in zip((rig, frame()), before, strict=True):
        assert np.allclose(obj.matrix_world, matrix, atol=1e-5)
    assert rig.angen_resident.stature == pytest.approx(stature)


def uneven() -> str:
    below(resident(), scale=(1, 2, 1))
    return "'Anna' cannot turn without distortion: what is above it, 'Above', is scaled differently"


def constrained() -> str:
    resident().constraints.new("LIMIT_LOCATION")
    return "'Anna' has constraints, which move it away from where a day puts it: 'Limit Location'"


def uneven_frame() -> str:
    below(frame(), scale=(1, 2, 1))
    return f"'{frame().name}' cannot turn without distortion"


def driven() -> str:
    resident().driver_add("location", 0).driver.expression = "1.0"
    return "'Anna' has drivers, which move it away from where a day puts it: 'location'"


def driven_above() -> str:
    below(resident()).driver_add("location", 0).driver.expression = "frame / 100"
    return "'Anna' moves with the drivers of 'Above' during a day"


def physical() -> str:
    bpy.ops.rigidbody.world_add()
    bpy.context.view_layer.objects.active = frame()
    bpy.ops.rigidbody.object_add(type="ACTIVE")
    return f"'{frame().name}' is moved by physics, not by a day"


def bent() -> str:
    resident().pose.bones["pelvis"].constraints.new("LIMIT_LOCATION").name = "Stop"
    return (
        "Bones of 'Anna' have constraints or drivers, which bend the body away from its poses in "
        "a day: 'Stop'"
    )


def body_aside() -> str:
    body().delta_location = (1.0, 0.0, 0.0)
    return f"'{body().name}' is not where its armature 'Anna' is"


def body_loose() -> str:
    body().parent = None
    return "'Anna' has no body"


def body_stiff() -> str:
    body().modifiers[0].show_viewport = False
    return f"'{body().name}' is not bent by 'Anna': its Armature modifier is off"


def body() -> Any:
    return part("residents.blender.person").body_of(resident())


@pytest.mark.parametrize(
    "way",
    [
        uneven,
        constrained,
        uneven_frame,
        driven,
        driven_above,
        physical,
        bent,
        body_aside,
        body_loose,
        body_stiff,
    ],
)
def test_what_a_day_cannot_place_is_told(home, way, capsys) -> None:
    text = way()
    bpy.context.view_layer.update()
    reachable, doctor = part("residents.blender.reachable"), part("angen_addon.doctor")
    depsgraph = bpy.context.evaluated_depsgraph_get()
    checked = reachable.check_places(depsgraph)
    assert [one for one in checked.unable if one.startswith(text)] == list(checked.unable) != []
    examined = doctor.Examined(home.scene, bpy.context.view_layer, depsgraph)
    assert any(found[0].startswith(text) for found in doctor.CHECKS["residents"](examined))
    run = part("residents.blender.run")
    plan = run.Plan.from_text(ROUTINE, "routine")
    household = run.HouseholdDays(home.scene, [], plan, date(2026, 3, 2), 0)
    assert household.take_notes() == list(checked.unable) and household.take_notes() == []


def test_a_constraint_without_a_target_is_no_finding(home) -> None:
    resident().constraints.new("COPY_LOCATION")
    bpy.context.view_layer.update()
    assert (
        part("residents.blender.reachable")
        .check_places(bpy.context.evaluated_depsgraph_get())
        .unable
        == ()
    )


def test_a_door_that_cannot_turn_is_told_by_a_day_too(home) -> None:
    leaf = home.box((0.9, 0.04, 2.0), (2.5, 0.02, 1.0), "Front door")
    leaf.angen_place.use = "DOOR"
    leaf.driver_add("rotation_euler", 2).driver.expression = "0.0"
    bpy.context.view_layer.update()
    run = part("residents.blender.run")
    plan = run.Plan.from_text(ROUTINE, "routine")
    [text] = run.HouseholdDays(home.scene, [], plan, date(2026, 3, 2), 0).take_notes()
    assert text.startswith("'Front door' has drivers, which move it away")
    doctor, depsgraph = part("angen_addon.doctor"), bpy.context.evaluated_depsgraph_get()
    examined = doctor.Examined(home.scene, bpy.context.view_layer, depsgraph)
    [(problem, *_)] = doctor.CHECKS["residents"](examined)
    assert text.startswith(problem)


def test_the_doctor_tells_a_body_that_is_drawn_with_another_size(home) -> None:
    below(resident(), scale=(2, 2, 2))
    doctor = part("angen_addon.doctor")
    depsgraph = bpy.context.evaluated_depsgraph_get()
    examined = doctor.Examined(home.scene, bpy.context.view_layer, depsgraph)
    [found] = doctor.CHECKS["residents"](examined)
    assert found[0].startswith("'Anna' is 3.470 m tall in the scene") and found[1].startswith(
        "Type the Stature again"
    )
    resident().angen_resident.stature = 1.7
    bpy.context.view_layer.update()
    drawn = part("residents.blender.settings").drawn_stature(resident())
    assert drawn == pytest.approx(1.7)
    assert resident().angen_resident.stature == pytest.approx(1.7)
    assert [*doctor.CHECKS["residents"](examined)] == []


def test_a_resident_that_is_scaled_by_hand_has_that_stature(home) -> None:
    rig = resident()
    rig.scale = rig.scale * 0.8
    bpy.context.view_layer.update()
    assert rig.angen_resident.stature == pytest.approx(0.8 * 1.75, abs=0.05)
