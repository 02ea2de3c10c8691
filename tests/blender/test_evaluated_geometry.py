# SPDX-License-Identifier: GPL-3.0-or-later
"""Sensors meet evaluated geometry: what modifiers, bones, curves and instances make.

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


def test_array(world, beam):
    plate = world.box((0.1, 0.1, 0.01), at=(-0.3, 0, -0.2))
    assert beam() == near(BEHIND)
    array = plate.modifiers.new("array", "ARRAY")
    array.use_relative_offset, array.use_constant_offset = False, True
    array.constant_offset_displace, array.count = (0.15, 0, 0), 3
    assert beam() == near(0.195)


def test_mirror(world, beam):
    plate = world.box((0.1, 0.1, 0.01), at=(0.2, 0, -0.2))
    mirror = plate.modifiers.new("mirror", "MIRROR")
    assert beam() == near(BEHIND)
    mirror.mirror_object = world.link("middle", None, at=(0.1, 0, 0))
    assert beam() == near(0.195)


def test_a_modifier_that_the_viewport_does_not_show(world, beam):
    plate = world.box((0.1, 0.1, 0.01), at=(0, 0, -0.2))
    array = plate.modifiers.new("array", "ARRAY")
    array.use_relative_offset, array.use_constant_offset = False, True
    array.constant_offset_displace = (0, 0, 0.1)
    assert beam() == near(0.095)
    array.show_viewport = False
    assert beam() == near(0.195)


def test_shape_keys(world, beam):
    plate = world.box((0.1, 0.1, 0.01), at=(0, 0, -0.2))
    plate.shape_key_add(name="basis")
    moved = plate.shape_key_add(name="nearer")
    moved.value = 0.0
    for point in moved.data:
        point.co.z += 0.1
    assert beam() == near(0.195)
    moved.value = 0.5
    assert beam() == near(0.145)


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


def test_bevelled_curve(world, beam):
    data = world.bpy.data.curves.new("rail", "CURVE")
    data.dimensions, data.bevel_depth, data.bevel_resolution = "3D", 0.02, 0
    spline = data.splines.new("POLY")
    spline.points.add(1)
    spline.points[0].co, spline.points[1].co = (-1, 0, 0, 1), (1, 0, 0, 1)
    world.link("rail", data, at=(0, 0, -0.2))
    # A pipe of four corners (resolution 0): between 0.02·cos 45° and 0.02 thick on each side.
    assert 0.18 - 1e-5 <= beam() <= 0.2 - 0.02 * math.cos(math.pi / 4) + 1e-5


def test_text(world, beam):
    data = world.bpy.data.curves.new("text", "FONT")
    data.body, data.size, data.extrude = "I", 2.0, 0.05
    data.align_x, data.align_y = "CENTER", "CENTER"
    world.link("text", data, at=(0, 0, -0.2))
    assert beam() == near(0.15)


def test_metaball(world, beam):
    data = world.bpy.data.metaballs.new("ball")
    data.resolution = 0.02
    data.elements.new().radius = 0.2
    world.link("ball", data, at=(0, 0, -0.25))
    assert 0.05 < beam() < 0.25


def test_surface_patch(world, beam):
    """A flat NURBS patch."""
    data = world.bpy.data.curves.new("patch", "SURFACE")
    data.dimensions = "3D"
    spline = data.splines.new("NURBS")
    spline.points.add(3)
    world.link("patch", data, at=(0, 0, -0.2))
    # A row of points alone has no surface.
    assert beam() == near(BEHIND)


def test_collection_instance(world, beam):
    source = world.bpy.data.collections.new("source")
    plate = world.bpy.data.objects.new("plate", world.box((0.1, 0.1, 0.01), at=(9, 9, 9)).data)
    source.objects.link(plate)
    for distance in (0.3, 0.2):
        instance = world.link("instance", None, at=(0, 0, -distance))
        instance.instance_type, instance.instance_collection = "COLLECTION", source
    assert beam() == near(0.195)
    instance.scale.z = 2
    assert beam() == near(0.19)


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


def test_face_instances(world, beam):
    grid = world.wall(0.2, "instancer", size=0.1)
    grid.instance_type = "FACES"
    grid.show_instancer_for_viewport = False
    plate = world.box((0.1, 0.1, 0.01))
    plate.parent = grid
    assert beam() == near(0.195)


def nodes(world, build):
    """A modifier's node group whose output `build(tree)` makes."""
    tree = world.bpy.data.node_groups.new("nodes", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    out = tree.nodes.new("NodeGroupOutput")
    tree.links.new(build(tree), out.inputs[0])
    return tree


def test_geometry_nodes_mesh(world, beam):
    def move(tree):
        start = tree.nodes.new("NodeGroupInput")
        step = tree.nodes.new("GeometryNodeTransform")
        step.inputs["Translation"].default_value = (0, 0, 0.1)
        tree.links.new(start.outputs[0], step.inputs["Geometry"])
        return step.outputs[0]

    plate = world.box((0.1, 0.1, 0.01), at=(0, 0, -0.3))
    plate.modifiers.new("nodes", "NODES").node_group = nodes(world, move)
    assert beam() == near(0.195)


def test_geometry_nodes_instances(world, beam):
    """Cubes that exist nowhere but in the nodes' result."""

    def scatter(tree):
        line = tree.nodes.new("GeometryNodeMeshLine")
        line.inputs["Count"].default_value = 3
        line.inputs["Start Location"].default_value = (0, 0, -0.35)
        line.inputs["Offset"].default_value = (0, 0, 0.1)
        cube = tree.nodes.new("GeometryNodeMeshCube")
        cube.inputs["Size"].default_value = (0.1, 0.1, 0.02)
        put = tree.nodes.new("GeometryNodeInstanceOnPoints")
        tree.links.new(line.outputs[0], put.inputs["Points"])
        tree.links.new(cube.outputs[0], put.inputs["Instance"])
        return put.outputs[0]

    host = world.box((0.1, 0.1, 0.1), at=(0, 0, 0), name="host")
    host.modifiers.new("nodes", "NODES").node_group = nodes(world, scatter)
    assert beam() == near(0.15 - 0.01)


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


def test_a_mesh_in_edit_mode_is_seen(world, beam):
    plate = world.box((0.1, 0.1, 0.01), at=(0, 0, -0.2))
    world.update()
    world.bpy.context.view_layer.objects.active = plate
    world.bpy.ops.object.mode_set(mode="EDIT")
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
