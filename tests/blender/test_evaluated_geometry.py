# SPDX-License-Identifier: GPL-3.0-or-later
"""Sensors meet evaluated geometry at known distances: what modifiers, bones and instances make.
What else there is, is held against Blender's own rays in test_odd_geometries.py.

Each scene has a wall 0.4 m ahead, and something nearer that exists only when evaluated.
"""

import math

import pytest
from mathutils import Matrix

BEHIND = 0.4


@pytest.fixture
def beam(world, each_caster):
    """Ranges of a switch at the origin that looks along −Z; the wall behind is 0.4 m off."""
    world.wall(BEHIND, "behind")
    sensor = world.switch()
    return lambda: world.range(sensor)


def near(distance):
    return pytest.approx(distance, abs=2e-5)


def test_subdivision(world, beam):
    """Catmull-Clark's first level of a cube of half size h: the face's middle stays at h, the
    edges' middles go to ¾h. Half-way between the two the surface is at ⅞h."""
    half = 0.1
    cube = world.box((2 * half,) * 3, at=(0, -0.375 * half, -0.3))
    assert beam() == near(0.3 - half)
    modifier = cube.modifiers.new("subdivision", "SUBSURF")
    modifier.levels, modifier.render_levels, modifier.use_limit_surface = 1, 5, False
    assert beam() == near(0.3 - 0.875 * half)


def test_a_modifier_that_the_viewport_does_not_show(world, beam):
    plate = world.box((0.1, 0.1, 0.01), at=(0, 0, -0.2))
    array = plate.modifiers.new("array", "ARRAY")
    array.use_relative_offset, array.use_constant_offset = False, True
    array.constant_offset_displace = (0, 0, 0.1)
    assert beam() == near(0.095)
    array.show_viewport = False
    assert beam() == near(0.195)


def test_armature(world, beam, figure):
    """A plate on a bone that turns by 90° about the bone's head, into the beam."""
    data = world.bpy.data.armatures.new("armature")
    rig = world.link("rig", data, at=(0, 0, -0.3))
    world.bpy.context.view_layer.objects.active = rig
    world.bpy.ops.object.mode_set(mode="EDIT")
    bone = data.edit_bones.new("bone")
    bone.head, bone.tail = (0, 0, 0), (0.1, 0, 0)
    world.bpy.ops.object.mode_set(mode="OBJECT")
    plate = world.box((0.01, 0.05, 0.05), name="plate", at=(0.1, 0, -0.3))
    group = plate.vertex_groups.new(name="bone")
    group.add(range(8), 1.0, "REPLACE")
    plate.modifiers.new("armature", "ARMATURE").object = rig
    assert beam() == near(BEHIND)
    pose = rig.pose.bones["bone"]
    pose.rotation_mode = "QUATERNION"
    # About world +Y by −90°, +X goes to +Z: the plate's outer face at 0.105 m comes to the beam.
    turn = Matrix.Rotation(math.radians(-90), 4, "Y")
    pose.matrix = turn @ data.bones["bone"].matrix_local
    found = beam()
    figure(abs(found - (0.3 - 0.105)), "m")
    assert found == near(0.3 - 0.105)


def test_collection_instance_within_another(world, beam):
    inner = world.bpy.data.collections.new("inner")
    outer = world.bpy.data.collections.new("outer")
    plate = world.bpy.data.objects.new("plate", world.box((0.1, 0.1, 0.01), at=(9, 9, 9)).data)
    inner.objects.link(plate)
    between = world.bpy.data.objects.new("between", None)
    between.instance_type, between.instance_collection = "COLLECTION", inner
    between.location.z = 0.05
    outer.objects.link(between)
    instance = world.link("instance", None, at=(0, 0, -0.25))
    instance.instance_type, instance.instance_collection = "COLLECTION", outer
    assert beam() == near(0.195)


@pytest.mark.parametrize("instancer_shown", [True, False])
def test_vertex_instances(world, beam, instancer_shown):
    """The plate itself stays at the instancer's origin, aside of the beam."""
    points = [(-0.5, 0, -0.3), (-0.5, 0, -0.2), (0, 0, -0.1)]
    instancer = world.link("instancer", world.mesh(points, [(0, 1, 2)]), at=(0.5, 0, 0))
    instancer.instance_type = "VERTS"
    instancer.show_instancer_for_viewport = instancer_shown
    plate = world.box((0.1, 0.1, 0.01))
    plate.parent = instancer
    assert beam() == near(0.195)


def nodes(world, build):
    """A modifier's node group whose output `build(tree)` makes."""
    tree = world.bpy.data.node_groups.new("nodes", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    out = tree.nodes.new("NodeGroupOutput")
    tree.links.new(build(tree), out.inputs[0])
    return tree


def test_geometry_nodes_objects(world, beam):
    """Instances of an object of the file, which itself stands aside."""
    plate = world.box((0.1, 0.1, 0.01), at=(9, 9, 9), name="plate")

    def scatter(tree):
        line = tree.nodes.new("GeometryNodeMeshLine")
        line.inputs["Count"].default_value = 1
        line.inputs["Start Location"].default_value = (0, 0, -0.2)
        info = tree.nodes.new("GeometryNodeObjectInfo")
        info.inputs["Object"].default_value = plate
        info.inputs["As Instance"].default_value = True
        put = tree.nodes.new("GeometryNodeInstanceOnPoints")
        tree.links.new(line.outputs[0], put.inputs["Points"])
        tree.links.new(info.outputs["Geometry"], put.inputs["Instance"])
        return put.outputs[0]

    host = world.box((0.1, 0.1, 0.1), name="host")
    host.modifiers.new("nodes", "NODES").node_group = nodes(world, scatter)
    assert beam() == near(0.195)


def test_moving_evaluated_geometry(world, each_caster):
    """Shape key, bone and curve animation reach the sensors at each frame."""
    plate = world.box((0.1, 0.1, 0.01), at=(0, 0, -0.3))
    plate.shape_key_add(name="basis")
    moved = plate.shape_key_add(name="nearer")
    for point in moved.data:
        point.co.z += 0.2
    keys = plate.data.shape_keys
    for frame, value in ((1, 0.0), (5, 1.0)):
        moved.value = value
        moved.keyframe_insert("value", frame=frame)
    action = keys.animation_data.action
    curve = (
        action.fcurves[0]
        if hasattr(action, "fcurves")
        else action.layers[0].strips[0].channelbag(keys.animation_data.action_slot).fcurves[0]
    )
    for point in curve.keyframe_points:
        point.interpolation = "LINEAR"
    world.switch()
    world.scene.frame_end = 5
    ranges = world.series(world.run(), "switch", "range_m")
    assert ranges == pytest.approx([0.295, 0.245, 0.195, 0.145, 0.095], abs=2e-5)
