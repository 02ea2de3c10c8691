# SPDX-License-Identifier: GPL-3.0-or-later
"""Odd things that stand in people's homes: each builds one under a sensor at the origin.

What a builder makes lies about (0, 0, -0.5), some 0.4 across, unless it says otherwise.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import bmesh
import bpy
import nodes_scenes
import numpy as np
from mathutils import Matrix, Vector

AT = (0.0, 0.0, -0.5)
SIZE = 0.4
Builder = Callable[[Any], Any]
ODD: dict[str, Builder] = {}


def odd(builder: Builder) -> Builder:
    ODD[builder.__name__] = builder
    return builder


def on_versions_with(operator: str) -> Callable[[Builder], Builder]:
    """Registers a builder where `bpy.ops.object` has an operator."""
    return odd if operator in dir(bpy.ops.object) else lambda builder: builder


def grid(world: Any, cells: int = 8, size: float = SIZE, name: str = "grid") -> Any:
    """A flat square of many faces."""
    mesh = bpy.data.meshes.new(name)
    made = bmesh.new()
    bmesh.ops.create_grid(made, x_segments=cells, y_segments=cells, size=size / 2)
    made.to_mesh(mesh)
    made.free()
    return world.link(name, mesh, AT)


def ball(world: Any, radius: float = SIZE / 2, name: str = "ball") -> Any:
    mesh = bpy.data.meshes.new(name)
    made = bmesh.new()
    bmesh.ops.create_icosphere(made, subdivisions=3, radius=radius)
    made.to_mesh(mesh)
    made.free()
    return world.link(name, mesh, AT)


def modified(obj: Any, kind: str, **settings: Any) -> Any:
    modifier = obj.modifiers.new(kind.lower(), kind)
    for name, value in settings.items():
        setattr(modifier, name, value)
    return obj


def box(world: Any, name: str = "box", size: float = SIZE) -> Any:
    return world.box((size, size, size), AT, name)


def curve(world: Any, name: str, kind: str = "CURVE", **settings: Any) -> Any:
    data = bpy.data.curves.new(name, kind)
    data.dimensions = "3D"
    for key, value in settings.items():
        setattr(data, key, value)
    return world.link(name, data, AT)


def line(obj: Any, points: Any, cyclic: bool = False) -> Any:
    spline = obj.data.splines.new("POLY")
    spline.points.add(len(points) - 1)
    for point, place in zip(spline.points, points, strict=True):
        point.co = (*place, 1.0)
    spline.use_cyclic_u = cyclic
    return obj


ROUND = [(0.2 * math.cos(a), 0.2 * math.sin(a), 0.0) for a in np.linspace(0, 6.0, 12)]


# What physics shapes; not smoke: its solver ends Blender's module as the next file opens.


@odd
def cloth(world: Any) -> Any:
    return modified(grid(world), "CLOTH")


@odd
def cloth_that_has_fallen(world: Any) -> Any:
    made = modified(grid(world), "CLOTH")
    for frame in range(1, 5):
        world.scene.frame_set(frame)
    return made


@odd
def soft_body(world: Any) -> Any:
    return modified(box(world), "SOFT_BODY")


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
    settings.frame_start, settings.frame_end, settings.count = 1, 1, 200
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
def ocean(world: Any) -> Any:
    return modified(grid(world), "OCEAN", spatial_size=1, resolution=4)


@odd
def dynamic_paint(world: Any) -> Any:
    return modified(grid(world), "DYNAMIC_PAINT")


# Curves, text, and what else has a surface


@odd
def curve_without_bevel(world: Any) -> Any:
    return line(curve(world, "bare"), ROUND)


@odd
def curve_with_bevel(world: Any) -> Any:
    return line(curve(world, "pipe", bevel_depth=0.05), ROUND, cyclic=True)


@odd
def curve_extruded(world: Any) -> Any:
    return line(curve(world, "ribbon", extrude=0.1), ROUND)


@odd
def curve_filled(world: Any) -> Any:
    return line(curve(world, "lid", dimensions="2D", fill_mode="BOTH"), ROUND, cyclic=True)


@odd
def curve_with_bevel_object(world: Any) -> Any:
    profile = line(curve(world, "profile"), [(0.03, 0, 0), (0, 0.03, 0), (-0.03, 0, 0)], True)
    profile.location = (9, 9, 9)
    return line(curve(world, "rail", bevel_mode="OBJECT", bevel_object=profile), ROUND)


@odd
def curve_with_a_mesh_modifier(world: Any) -> Any:
    made = line(curve(world, "pipe", bevel_depth=0.05), ROUND, cyclic=True)
    return modified(made, "SOLIDIFY", thickness=0.01)


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
def volume(world: Any) -> Any:
    return world.link("volume", bpy.data.volumes.new("volume"), AT)


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
def empty_with_a_picture(world: Any) -> Any:
    made = world.link("picture", None, AT)
    made.empty_display_type = "IMAGE"
    made.data = bpy.data.images.new("picture", 8, 8)
    return made


# Meshes that are hardly any


@odd
def mesh_without_anything(world: Any) -> Any:
    return world.link("nothing", bpy.data.meshes.new("nothing"), AT)


@odd
def vertices_alone(world: Any) -> Any:
    return world.link("points", world.mesh([(0, 0, 0), (0.1, 0, 0)], []), AT)


@odd
def edges_alone(world: Any) -> Any:
    mesh = bpy.data.meshes.new("edges")
    mesh.from_pydata([(-0.1, 0, 0), (0.1, 0, 0), (0, 0.1, 0)], [(0, 1), (1, 2)], [])
    return world.link("edges", mesh, AT)


@odd
def faces_without_area(world: Any) -> Any:
    points = [(-0.2, 0, 0), (0, 0, 0), (0.2, 0, 0), (0, 0, 0)]
    return world.link("needle", world.mesh(points, [(0, 1, 2), (0, 1, 3)]), AT)


@odd
def faces_with_and_without_area(world: Any) -> Any:
    points = [(-0.2, -0.2, 0), (0.2, -0.2, 0), (0.2, 0.2, 0), (0, 0, 0), (0, 0, 0)]
    return world.link("mixed", world.mesh(points, [(3, 4, 0), (0, 1, 2), (2, 2, 1)]), AT)


@odd
def a_concave_face(world: Any) -> Any:
    """A horseshoe of one face, the sensor above its opening."""
    points = [(-0.2, -0.2), (0.2, -0.2), (0.2, 0.2), (0.1, 0.2), (0.1, -0.1), (-0.1, -0.1)]
    points += [(-0.1, 0.2), (-0.2, 0.2)]
    mesh = world.mesh([(x, y, 0.0) for x, y in points], [tuple(range(len(points)))])
    return world.link("horseshoe", mesh, AT)


@odd
def a_face_that_is_not_flat(world: Any) -> Any:
    points = [(-0.2, -0.2, 0), (0.2, -0.2, 0.1), (0.2, 0.2, 0), (-0.2, 0.2, 0.1)]
    return world.link("saddle", world.mesh(points, [(0, 1, 2, 3)]), AT)


@odd
def a_face_that_crosses_itself(world: Any) -> Any:
    points = [(-0.2, -0.2, 0), (0.2, 0.2, 0), (0.2, -0.2, 0), (-0.2, 0.2, 0)]
    return world.link("bow", world.mesh(points, [(0, 1, 2, 3)]), AT)


@odd
def three_faces_at_an_edge(world: Any) -> Any:
    points = [(0, -0.2, 0), (0, 0.2, 0), (0.2, 0, 0), (-0.2, 0, 0), (0, 0, 0.2)]
    return world.link("fin", world.mesh(points, [(0, 1, 2), (0, 1, 3), (0, 1, 4)]), AT)


@odd
def the_same_face_twice(world: Any) -> Any:
    points = [(-0.2, -0.2, 0), (0.2, -0.2, 0), (0.2, 0.2, 0)]
    return world.link("double", world.mesh(points * 2, [(0, 1, 2), (5, 4, 3)]), AT)


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


# Where, how large, and how turned


@odd
def a_kilometre_off_its_origin(world: Any) -> Any:
    made = box(world)
    made.data.transform(Matrix.Translation((1000.0, 2000.0, 0)))
    made.location = Vector(AT) - Vector((1000.0, 2000.0, 0))
    return made


@odd
def huge(world: Any) -> Any:
    """A box of 200 km whose top is under the sensor."""
    return world.box((2e5, 2e5, 2e5), (0, 0, -1e5 - 0.5), "huge")


@odd
def tiny(world: Any) -> Any:
    """A millimetre cube, scaled up."""
    made = world.box((1e-3, 1e-3, 1e-3), AT, "tiny")
    made.scale = (400, 400, 400)
    return made


@odd
def scaled_down(world: Any) -> Any:
    made = world.box((4e3, 4e3, 4e3), AT, "large")
    made.scale = (1e-4, 1e-4, 1e-4)
    return made


@odd
def mirrored(world: Any) -> Any:
    made = ball(world)
    made.scale = (-1, 1, 1)
    return made


@odd
def mirrored_on_all_axes(world: Any) -> Any:
    made = box(world)
    made.scale = (-1, -0.5, -2)
    return made


@odd
def flattened(world: Any) -> Any:
    """Scaled to nothing along the beam."""
    made = box(world)
    made.scale = (1, 1, 0)
    return made


@odd
def sheared(world: Any) -> Any:
    parent = world.link("parent", None, AT)
    parent.scale = (1, 3, 1)
    made = world.box((0.2, 0.1, 0.2), (0, 0, 0), "sheared")
    made.parent, made.rotation_euler = parent, (0.5, 0.4, 0.3)
    return made


# Deformed


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
def displaced(world: Any) -> Any:
    return modified(grid(world), "DISPLACE", strength=0.2)


@odd
def multires(world: Any) -> Any:
    made = modified(box(world), "MULTIRES")
    bpy.context.view_layer.objects.active = made
    for _ in range(2):
        bpy.ops.object.multires_subdivide(modifier="multires", mode="CATMULL_CLARK")
    made.modifiers[0].levels = 2
    return made


@odd
def subdivided(world: Any) -> Any:
    return modified(box(world), "SUBSURF", levels=2)


@odd
def shrunk_onto(world: Any) -> Any:
    return modified(grid(world), "SHRINKWRAP", target=ball(world))


# Made of others


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
def array(world: Any) -> Any:
    made = world.box((0.05, 0.4, 0.05), (-0.2, 0, -0.5), "lamella")
    return modified(made, "ARRAY", count=6)


@odd
def mirror(world: Any) -> Any:
    made = world.box((0.1, 0.4, 0.1), AT, "half")
    made.data.transform(Matrix.Translation((0.1, 0, 0)))
    return modified(made, "MIRROR")


@odd
def solidified(world: Any) -> Any:
    return modified(grid(world), "SOLIDIFY", thickness=0.1)


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
def decimated_to_nothing(world: Any) -> Any:
    return modified(box(world), "DECIMATE", ratio=0.0)


@odd
def remeshed(world: Any) -> Any:
    return modified(ball(world), "REMESH", voxel_size=0.05)


@odd
def masked_away(world: Any) -> Any:
    made = box(world)
    made.vertex_groups.new(name="none")
    return modified(made, "MASK", vertex_group="none")


@odd
def wireframe(world: Any) -> Any:
    return modified(grid(world, 6), "WIREFRAME", thickness=0.02)


@odd
def built_half(world: Any) -> Any:
    made = modified(grid(world), "BUILD", frame_start=1, frame_duration=20)
    world.scene.frame_set(10)
    return made


@odd
def triangulated(world: Any) -> Any:
    return modified(grid(world), "TRIANGULATE")


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
def shown_as_wire(world: Any) -> Any:
    made = box(world)
    made.display_type = "WIRE"
    return made


@odd
def shown_as_bounds(world: Any) -> Any:
    made = ball(world)
    made.display_type = "BOUNDS"
    return made


@odd
def not_selectable(world: Any) -> Any:
    made = box(world)
    made.hide_select = True
    return made


@odd
def hidden_in_renders_alone(world: Any) -> Any:
    made = box(world)
    made.hide_render = True
    return made


@odd
def hidden(world: Any) -> Any:
    made = box(world)
    made.hide_set(True)
    return made


@odd
def disabled_in_viewports(world: Any) -> Any:
    made = box(world)
    made.hide_viewport = True
    return made


@odd
def being_edited(world: Any) -> Any:
    made = box(world)
    world.update()
    bpy.context.view_layer.objects.active = made
    bpy.ops.object.mode_set(mode="EDIT")
    return made


@odd
def being_edited_with_a_modifier(world: Any) -> Any:
    made = modified(box(world), "SUBSURF", levels=2)
    world.update()
    bpy.context.view_layer.objects.active = made
    bpy.ops.object.mode_set(mode="EDIT")
    return made


@odd
def being_sculpted(world: Any) -> Any:
    made = ball(world)
    world.update()
    bpy.context.view_layer.objects.active = made
    bpy.ops.object.mode_set(mode="SCULPT")
    return made
