# SPDX-License-Identifier: GPL-3.0-or-later
"""Odd things that take more than a line to build; `odd_geometries` has the others."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import bpy
import nodes_scenes
from mathutils import Matrix, Vector
from odd_geometries import AT, ODD, ROUND, ball, box, curve, grid, line, modified

Builder = Callable[[Any], Any]


def odd(builder: Builder) -> Builder:
    ODD[builder.__name__] = builder
    return builder


def on_versions_with(operator: str) -> Callable[[Builder], Builder]:
    """Registers a builder where `bpy.ops.object` has an operator."""
    return odd if operator in dir(bpy.ops.object) else lambda builder: builder


@odd
def cloth_that_has_fallen(world: Any) -> Any:
    made = modified(grid(world), "CLOTH")
    for frame in range(1, 5):
        world.scene.frame_set(frame)
    return made


@odd
def rigid_body(world: Any) -> Any:
    made = box(world)
    bpy.context.view_layer.objects.active = made
    made.select_set(True)
    bpy.ops.rigidbody.world_add()
    bpy.ops.rigidbody.object_add(type="ACTIVE")
    return made


@odd
def particles_that_show_objects(world: Any) -> Any:
    host = grid(world)
    shown = world.box((0.1, 0.1, 0.1), (9, 9, 9), "shown")
    modified(host, "PARTICLE_SYSTEM")
    settings = host.particle_systems[0].settings
    settings.frame_start, settings.frame_end, settings.count = 1, 1, 50
    settings.physics_type, settings.render_type = "NO", "OBJECT"
    settings.instance_object, settings.particle_size = shown, 1.0
    world.scene.frame_set(2)
    return host


@odd
def hair_of_particles(world: Any) -> Any:
    """Strands have no surface; the skin under them has."""
    host = modified(grid(world), "PARTICLE_SYSTEM")
    host.particle_systems[0].settings.type = "HAIR"
    return host


@odd
def exploded(world: Any) -> Any:
    host = modified(box(world), "PARTICLE_SYSTEM")
    return modified(host, "EXPLODE")


@odd
def curve_with_bevel_object(world: Any) -> Any:
    profile = line(curve(world, "profile"), [(0.03, 0, 0), (0, 0.03, 0), (-0.03, 0, 0)], True)
    profile.location = (9, 9, 9)
    return line(curve(world, "rail", bevel_mode="OBJECT", bevel_object=profile), ROUND)


@odd
def text(world: Any) -> Any:
    made = world.link("text", bpy.data.curves.new("text", "FONT"), AT)
    made.data.body, made.data.align_x, made.data.align_y = "MW", "CENTER", "CENTER"
    return made


@odd
def surface(world: Any) -> Any:
    made = curve(world, "surface", "SURFACE")
    bpy.data.objects.remove(made)
    bpy.ops.surface.primitive_nurbs_surface_sphere_add(radius=0.2, location=AT)
    return bpy.context.object


@odd
def metaballs(world: Any) -> Any:
    """Two objects of one family are one surface, listed under the first."""
    for x in (0.0, 0.12):
        data = bpy.data.metaballs.new("meta")
        data.resolution = 0.05
        data.elements.new().radius = 0.15
        world.link("meta", data, (x, 0, -0.5))
    return bpy.data.objects["meta"]


@odd
def hair_curves(world: Any) -> Any:
    data = bpy.data.hair_curves.new("hair")
    data.add_curves([4, 4])
    return world.link("hair", data, AT)


@on_versions_with("pointcloud_random_add")
def point_cloud(world: Any) -> Any:
    bpy.ops.object.pointcloud_random_add(location=AT)
    return bpy.context.object


@odd
def volume_as_mesh(world: Any) -> Any:
    """A mesh made of a volume that is made of a mesh."""
    host = world.link("host", bpy.data.volumes.new("volume"), AT)
    modified(host, "MESH_TO_VOLUME", object=ball(world), resolution_mode="VOXEL_AMOUNT")
    made = world.link("mesh", bpy.data.meshes.new("mesh"), AT)
    return modified(made, "VOLUME_TO_MESH", object=host)


@odd
def grease_pencil(world: Any) -> Any:
    add = bpy.ops.object
    (add.grease_pencil_add if bpy.app.version >= (4, 3) else add.gpencil_add)(
        type="STROKE", location=AT
    )
    return bpy.context.object


@odd
def inside_out(world: Any) -> Any:
    made = box(world)
    made.data.flip_normals()
    return made


@odd
def nowhere(world: Any) -> Any:
    """Some of its vertices are no numbers."""
    made = grid(world)
    made.data.vertices[0].co = (math.nan, 0, 0)
    made.data.vertices[5].co = (math.inf, 0, 0)
    return made


@odd
def a_kilometre_off_its_origin(world: Any) -> Any:
    made = box(world)
    made.data.transform(Matrix.Translation((1000.0, 2000.0, 0)))
    made.location = Vector(AT) - Vector((1000.0, 2000.0, 0))
    return made


@odd
def sheared(world: Any) -> Any:
    parent = world.link("parent", None, AT)
    parent.scale = (1, 3, 1)
    made = world.box((0.2, 0.1, 0.2), (0, 0, 0), "sheared")
    made.parent, made.rotation_euler = parent, (0.5, 0.4, 0.3)
    return made


@odd
def by_a_lattice(world: Any) -> Any:
    lattice = world.link("lattice", bpy.data.lattices.new("lattice"), AT)
    lattice.data.points[0].co_deform.x -= 0.5
    lattice.data.points[7].co_deform.z += 0.5
    return modified(box(world), "LATTICE", object=lattice)


@odd
def by_an_armature(world: Any) -> Any:
    rig = world.link("rig", bpy.data.armatures.new("rig"), AT)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    bone = rig.data.edit_bones.new("bone")
    bone.head, bone.tail = (0, 0, 0), (0, 0, 0.2)
    bpy.ops.object.mode_set(mode="OBJECT")
    made = box(world)
    made.vertex_groups.new(name="bone").add(range(8), 1.0, "REPLACE")
    modified(made, "ARMATURE", object=rig)
    rig.pose.bones["bone"].location = (0, 0.1, 0)
    return made


@odd
def by_shape_keys(world: Any) -> Any:
    made = box(world)
    made.shape_key_add(name="basis")
    key = made.shape_key_add(name="up")
    for point in key.data:
        point.co.z += 0.2
    key.value = 0.5
    return made


@odd
def by_a_curve(world: Any) -> Any:
    way = line(curve(world, "way", use_path=True), [(0, 0, 0), (0.1, 0.1, 0), (1, 0, 0)])
    return modified(box(world), "CURVE", object=way)


@odd
def multires(world: Any) -> Any:
    made = modified(box(world), "MULTIRES")
    bpy.context.view_layer.objects.active = made
    for _ in range(2):
        bpy.ops.object.multires_subdivide(modifier="multires", mode="CATMULL_CLARK")
    made.modifiers[0].levels = 2
    return made


@odd
def shrunk_onto(world: Any) -> Any:
    return modified(grid(world), "SHRINKWRAP", target=ball(world))


@odd
def boolean(world: Any) -> Any:
    other = ball(world, 0.25)
    other.hide_viewport = True
    return modified(box(world), "BOOLEAN", object=other, operation="DIFFERENCE")


@odd
def boolean_that_leaves_nothing(world: Any) -> Any:
    other = world.box((1, 1, 1), AT, "other")
    other.hide_viewport = True
    return modified(box(world), "BOOLEAN", object=other, operation="DIFFERENCE")


@odd
def mirror(world: Any) -> Any:
    made = world.box((0.1, 0.4, 0.1), AT, "half")
    made.data.transform(Matrix.Translation((0.1, 0, 0)))
    return modified(made, "MIRROR")


@odd
def screwed(world: Any) -> Any:
    mesh = bpy.data.meshes.new("profile")
    mesh.from_pydata([(0.15, 0, -0.1), (0.15, 0, 0.1)], [(0, 1)], [])
    return modified(world.link("vase", mesh, AT), "SCREW")


@odd
def skinned(world: Any) -> Any:
    mesh = bpy.data.meshes.new("sticks")
    mesh.from_pydata([(-0.2, 0, 0), (0.2, 0, 0)], [(0, 1)], [])
    made = world.link("sticks", mesh, AT)
    bpy.context.view_layer.objects.active = made
    return modified(made, "SKIN")


@odd
def masked_away(world: Any) -> Any:
    made = box(world)
    made.vertex_groups.new(name="none")
    return modified(made, "MASK", vertex_group="none")


@odd
def built_half(world: Any) -> Any:
    made = modified(grid(world), "BUILD", frame_start=1, frame_duration=20)
    world.scene.frame_set(10)
    return made


@odd
def nodes_that_instance_cubes(world: Any) -> Any:
    host = world.link("host", world.mesh([(9, 9, 9)], []), AT)
    return nodes_scenes.add_nodes(
        host, nodes_scenes.cubes((0.1, 0.3, 0.1), 4, (0.12, 0, 0), (-0.2, 0, 0))
    )


@odd
def nodes_that_nest_instances(world: Any) -> Any:
    host = world.link("host", world.mesh([(9, 9, 9)], []), AT)
    inner = nodes_scenes.cubes((0.05, 0.05, 0.05), 4, (0.1, 0, 0), (-0.15, 0, 0))
    return nodes_scenes.add_nodes(host, nodes_scenes.nested(inner, 4, (0, 0.1, 0)))


def _instances_of(name: str, *values: Any) -> Builder:
    """Instances of what one node makes, with its inputs set."""

    def build(tree: Any) -> Any:
        node = tree.nodes.new(name)
        for key, value in values:
            node.inputs[key].default_value = value
        return nodes_scenes.on_line(tree, node.outputs[0], 3, (0.1, 0, 0), (-0.1, 0, 0))

    return lambda world: nodes_scenes.add_nodes(
        world.link("host", world.mesh([(9, 9, 9)], []), AT), build
    )


ODD["nodes_that_instance_letters"] = _instances_of(
    "GeometryNodeStringToCurves", ("String", "MW"), ("Size", 0.3)
)
ODD["nodes_that_instance_curves"] = _instances_of("GeometryNodeCurvePrimitiveCircle")
ODD["nodes_that_instance_points"] = _instances_of("GeometryNodePoints", ("Count", 5))
ODD["nodes_that_instance_volumes"] = _instances_of("GeometryNodeVolumeCube")


@odd
def nodes_on_a_curve(world: Any) -> Any:
    """A curve whose nodes make a mesh of it."""

    def build(tree: Any) -> Any:
        start, circle = (
            tree.nodes.new("NodeGroupInput"),
            tree.nodes.new("GeometryNodeCurvePrimitiveCircle"),
        )
        circle.inputs["Radius"].default_value = 0.05
        sweep = tree.nodes.new("GeometryNodeCurveToMesh")
        tree.links.new(start.outputs[0], sweep.inputs[0])
        tree.links.new(circle.outputs[0], sweep.inputs[1])
        return sweep.outputs[0]

    return nodes_scenes.add_nodes(line(curve(world, "way"), ROUND), build)


@odd
def collection_instance(world: Any) -> Any:
    source = bpy.data.collections.new("source")
    source.objects.link(bpy.data.objects.new("inner", ball(world).data))
    bpy.data.objects.remove(bpy.data.objects["ball"])
    made = world.link("instance", None, AT)
    made.instance_type, made.instance_collection = "COLLECTION", source
    made.scale = (1, 0.5, -1)
    return made


@odd
def collection_instance_of_nodes(world: Any) -> Any:
    source = bpy.data.collections.new("source")
    inner = bpy.data.objects.new("inner", world.mesh([(9, 9, 9)], []))
    source.objects.link(inner)
    nodes_scenes.add_nodes(
        inner, nodes_scenes.cubes((0.1, 0.3, 0.1), 3, (0.15, 0, 0), (-0.15, 0, 0))
    )
    made = world.link("instance", None, AT)
    made.instance_type, made.instance_collection = "COLLECTION", source
    return made


@odd
def instances_on_faces(world: Any) -> Any:
    host = grid(world, 3)
    host.instance_type = "FACES"
    host.show_instancer_for_viewport = False
    world.box((0.05, 0.05, 0.05), (0, 0, 0), "part").parent = host
    return host


@odd
def hidden(world: Any) -> Any:
    made = box(world)
    made.hide_set(True)
    return made
