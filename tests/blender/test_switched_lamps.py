# SPDX-License-Identifier: GPL-3.0-or-later
"""A lamp that residents switch is all that belongs to it, and nothing else."""

from __future__ import annotations

from datetime import date
from types import SimpleNamespace
from typing import Any

import bpy
import numpy as np
import pytest
from day_home import part
from light_stage import nodes_instance
from mathutils import Vector

ROUTINE = """
schema = 1
[person.anna]
resident = "Anna"
begins = "Sleep"
[activity.Sleep]
do = ["lie Bed"]
while = []
[activity.Off]
do = ["switch Lamp off", "lie Bed"]
while = []
[activity.On]
do = ["switch Lamp on", "lie Bed"]
while = []
[[plan]]
person = "anna"
entries = [
  { at = "00:00:20", activity = "Off", until = "00:01" },
  { at = "00:01", activity = "On", until = "12:00" },
]
"""


@pytest.fixture
def home(world):
    """Add a room with a sleeper, a lamp's shade without lights, and a light sensor."""
    world.hall(4.0, 3.0, 2.8)
    bed = world.box((2.0, 0.9, 0.5), (1.2, 2.4, 0.25), "Bed")
    sort = part("residents.body.skeleton").Sort.ADULT
    rig = part("residents.blender.settings").add_resident(
        bpy.context, sort, Vector((2.5, 0.5, 0.0)), 0.0
    )
    rig.name = "Anna"
    world.box((0.1, 0.1, 0.1), (2.0, 1.0, 2.7), "Lamp")
    world.update()
    bed.angen_place.use, bed.angen_place.facing = "LIE", np.pi / 2
    lux = world.sensor("LIGHT", "lux", update_rate=0.1, method="ILLUMINANCE", samples=1024)
    lux.location, lux.rotation_euler = (2.0, 1.0, 1.0), (np.pi, 0, 0)
    world.scene.world = None
    world.update()
    return world


def bulb(world, name: str, at, parent: Any, data: Any = None) -> Any:
    made = data or bpy.data.lights.new(name, "POINT")
    if data is None:
        made.energy, made.shadow_soft_size = 20.0, 0.02
    obj = world.link(name, made, at)
    obj.parent = parent
    return obj


def bulbs(world, lamp) -> None:
    for x in (-0.3, 0.0, 0.3):
        bulb(world, f"bulb {x}", (x, 0, -0.2), lamp)


def arm(world, lamp) -> None:
    holder = world.link("arm", None)
    holder.parent = lamp
    for x in (-0.3, 0.3):
        bulb(world, f"bulb {x}", (x, 0, -0.2), holder)


def driven(world, lamp) -> None:
    made = bulb(world, "bulb", (0, 0, -0.2), lamp).data
    made.driver_add("energy").driver.expression = "25 + 0"


def shared(world, lamp) -> None:
    first = bulb(world, "bulb", (0, 0, -0.2), lamp)
    bulb(world, "other", (0.9, 0.2, 2.4), None, first.data)


def glowing(world, lamp, group: bool = False, linked: bool = False) -> None:
    tube = world.box((0.5, 0.05, 0.05), (0, 0, -0.2), "tube")
    tube.parent = lamp
    material = bpy.data.materials.new("glow")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    out = tree.nodes.new("ShaderNodeOutputMaterial")
    inside = tree
    if group:
        inside = bpy.data.node_groups.new("Glow", "ShaderNodeTree")
        inside.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
        node = tree.nodes.new("ShaderNodeGroup")
        node.node_tree = inside
        tree.links.new(node.outputs[0], out.inputs["Surface"])
        out = inside.nodes.new("NodeGroupOutput")
    emission = inside.nodes.new("ShaderNodeEmission")
    emission.inputs["Strength"].default_value = 30.0
    inside.links.new(emission.outputs[0], out.inputs[0])
    if linked:
        value = inside.nodes.new("ShaderNodeValue")
        value.outputs[0].default_value = 30.0
        inside.links.new(value.outputs[0], emission.inputs["Strength"])
    tube.data.materials.append(material)
    # Another object has the same material, far away behind the wall.
    world.box((0.1, 0.1, 0.1), (9, 9, 9), "far").data.materials.append(material)


def glowing_group(world, lamp) -> None:
    glowing(world, lamp, group=True, linked=True)


def bulb_in_shade(world, lamp) -> None:
    bulb(world, "bulb", (0, 0, -0.4), lamp)
    glowing(world, lamp, linked=True)


def keyed_glow(world, lamp) -> None:
    """The glow is keyed: off at first, at its full strength later."""
    glowing(world, lamp)
    tree = bpy.data.materials["glow"].node_tree
    node = next(n for n in tree.nodes if n.type == "EMISSION")
    for frame, value in ((40, 30.0), (1, 0.0)):
        node.inputs["Strength"].default_value = value
        node.inputs["Strength"].keyframe_insert("default_value", frame=frame)


def strip(world, lamp) -> None:
    """An NLA strip says with what power the bulb shines; it is off at the first frame."""
    light = bulb(world, "bulb", (0, 0, -0.2), lamp).data
    world.key(light, "energy", {1: 0.0, 40: 20.0})
    data = light.animation_data
    data.nla_tracks.new().strips.new("on", 1, data.action)
    data.action = None
    world.scene.frame_set(1)


def asset(world, lamp) -> None:
    """The lamp is an instance of a collection, as of an asset."""
    made = bulb(world, "bulb", (0, 0, -0.2), None)
    world.instance("inside", world.aside("asset", made)).parent = lamp


def state() -> dict[str, Any]:
    """Return what a day must leave as it is.

    Users of node groups are not counted: Blender 4.2 counts two where a material is copied.
    """
    return {
        "lights": {o.name: (o.data.name, o.data.energy)
                   for o in bpy.data.objects if o.type == "LIGHT"},
        "slots": {o.name: [(s.link, s.material and s.material.name) for s in o.material_slots]
                  for o in bpy.data.objects},
        "count": [len(c) for c in (bpy.data.lights, bpy.data.materials, bpy.data.node_groups,
                                   bpy.data.actions)],
        "users": {i.name: (i.users, i.use_fake_user)
                  for c in (bpy.data.lights, bpy.data.materials) for i in c
                  if i.name.lower().startswith(("glow", "bulb"))},
    }  # fmt: skip


def named_data() -> list[Any]:
    return [*bpy.data.objects, *bpy.data.lights, *bpy.data.materials]


def lux_of_a_minute() -> list[float]:
    """Return the illuminance of a day's first 100 s at 10, 50 and 90 s."""
    run, sensors = part("residents.blender.run"), part("angen_addon.scene.sensors")
    plan = run.Plan.from_text(ROUTINE, "routine")
    found = sensors.all_sensors(bpy.context.view_layer)
    household = run.HouseholdDays(bpy.context.scene, found, plan, date(2026, 3, 2), 0)
    [day] = run.run_days(household, [0], between=(0.0, 100.0))
    rows = [(e.time / 1e6, float(e.value)) for e in day.events if e.field == "illuminance_lux"]
    assert household.take_notes() == []
    return [[value for time, value in rows if time <= at][-1] for at in (10.0, 50.0, 90.0)]


@pytest.mark.parametrize(
    "kind",
    [bulbs, arm, driven, shared, glowing, glowing_group, bulb_in_shade, keyed_glow, strip, asset],
)
def test_switching_a_lamp_off_takes_all_its_light_and_no_other(home, kind) -> None:
    lamp = bpy.data.objects["Lamp"]
    kind(home, lamp)
    home.update()
    lamp.angen_place.use = "LAMP"
    home.update()
    before = state()
    on, off, again = lux_of_a_minute()
    assert on > 30.0 and again == pytest.approx(on, rel=0.05)
    if kind is shared:
        # The other lamp alone.
        assert 0.1 * on < off < 0.6 * on
        bpy.data.objects["bulb"].hide_render = bpy.data.objects["bulb"].hide_viewport = True
        home.update()
        alone = lux_of_a_minute()[0]
        assert off == pytest.approx(alone, rel=0.05)
        bpy.data.objects["bulb"].hide_render = bpy.data.objects["bulb"].hide_viewport = False
    else:
        assert off == pytest.approx(0.0, abs=0.01)
    home.update()
    assert state() == before


@pytest.mark.parametrize("renamed", [False, True], ids=["", "renamed"])
@pytest.mark.parametrize("kind", [shared, driven, glowing_group, strip, asset])
def test_a_shown_day_gives_lamps_back_after_saving(home, tmp_path, kind, renamed) -> None:
    shown = part("residents.blender.shown")
    timeline, places = part("residents.acting.timeline"), part("residents.acting.places")
    lamp = bpy.data.objects["Lamp"]
    kind(home, lamp)
    home.update()
    before = state()
    switches = [timeline.Switch(0.0, "Lamp", True, ""), timeline.Switch(5.0, "Lamp", False, "")]
    acted = timeline.Acted({}, switches=switches)
    light = SimpleNamespace(sun=None, skies=list, insert_keys=lambda: None)
    at = np.zeros(3)
    found = places.Places({}, {}, {"Lamp": places.LampPlace("Lamp", "Lamp", at)})
    shown.show(home.scene, acted, found, {}, light, date(2026, 3, 2), 0.0, 10.0)
    names = {one: one.name for one in named_data()} if renamed else {}
    for one, name in names.items():
        one.name = f"{name} of the hall"
    path = str(tmp_path / "shown.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    assert state() != before
    assert shown.leave(bpy.context.scene) == []
    bpy.context.view_layer.update()
    for one in named_data():
        one.name = one.name.removesuffix(" of the hall")
    assert state() == before


def nothing(world, lamp) -> str:
    return "'Lamp' is marked as a lamp, but nothing in it shines"


def powerless(world, lamp) -> str:
    bulb(world, "bulb", (0, 0, -0.2), lamp).data.energy = 0.0
    return "'bulb' is marked as a lamp, but its power is zero at the first frame"


def instanced(world, lamp) -> str:
    made = bulb(world, "bulb", (0, 0, -0.2), lamp)
    bpy.data.collections.new("lamps").objects.link(made)
    world.instance("copy", bpy.data.collections["lamps"], (1, 1, 0))
    return "'bulb' is switched together with its instance 'copy'"


def instanced_by_nodes(world, lamp) -> str:
    nodes_instance(world, bulb(world, "bulb", (0, 0, -0.2), lamp), (0.5, 0, 0))
    return "'bulb' is switched together with its instance 'by nodes'"


def instancing(world, lamp) -> str:
    nodes_instance(world, bulb(world, "bulb", (9, 9, 9), None), (0.5, 0, 0)).parent = lamp
    return "'Lamp' stays on: its modifiers or particles instance 'bulb'"


def glowing_pipe(world, lamp) -> str:
    """The nodes of a curve give it a surface that glows."""
    glowing(world, lamp)
    tube = bpy.data.objects["tube"]
    tube.material_slots[0].material = None
    data = bpy.data.curves.new("pipe", "CURVE")
    data.splines.new("POLY").points.add(1)
    pipe = world.link("pipe", data)
    pipe.parent = lamp
    tree = bpy.data.node_groups.new("nodes", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    cube = tree.nodes.new("GeometryNodeMeshCube")
    made = tree.nodes.new("GeometryNodeSetMaterial")
    made.inputs["Material"].default_value = bpy.data.materials["glow"]
    out = tree.nodes.new("NodeGroupOutput")
    tree.links.new(cube.outputs[0], made.inputs[0])
    tree.links.new(made.outputs[0], out.inputs[0])
    pipe.modifiers.new("nodes", "NODES").node_group = tree
    return "'Lamp' stays on: its modifiers make 'pipe' glow"


@pytest.mark.parametrize(
    "kind", [nothing, powerless, instanced, instanced_by_nodes, instancing, glowing_pipe]
)
def test_what_residents_cannot_switch_is_named(home, kind) -> None:
    lamp = bpy.data.objects["Lamp"]
    text = kind(home, lamp)
    home.update()
    lamp.angen_place.use = "LAMP"
    depsgraph = home.update()
    reachable, doctor = part("residents.blender.reachable"), part("angen_addon.doctor")
    [told] = reachable.check_places(depsgraph).unable
    assert told.startswith(text)
    examined = doctor.Examined(home.scene, bpy.context.view_layer, depsgraph)
    assert [found[0] for found in doctor.CHECKS["lamps"](examined)] == [text]
