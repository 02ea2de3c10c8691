# SPDX-License-Identifier: GPL-3.0-or-later
"""Unusual geometries of people's homes: each function adds one below a sensor at the origin.

It lies about (0, 0, -0.5) and is about 0.4 across, unless the docstring says otherwise.
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
ODD: dict[str, Callable[[Any], Any]] = {}


def grid(world: Any, cells: int = 8, size: float = SIZE, name: str = "grid") -> Any:
    """Add a flat square of many faces."""
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
    having(obj.modifiers.new(kind.lower(), kind), **settings)
    return obj


def having(obj: Any, **settings: Any) -> Any:
    for name, value in settings.items():
        setattr(obj, name, value)
    return obj


def box(world: Any, name: str = "box", size: float = SIZE) -> Any:
    return world.box((size, size, size), AT, name)


def curve(world: Any, name: str, kind: str = "CURVE", **settings: Any) -> Any:
    data = bpy.data.curves.new(name, kind)
    return world.link(name, having(data, **{"dimensions": "3D", **settings}), AT)


def line(obj: Any, points: Any, cyclic: bool = False) -> Any:
    spline = obj.data.splines.new("POLY")
    spline.points.add(len(points) - 1)
    for point, place in zip(spline.points, points, strict=True):
        point.co = (*place, 1.0)
    spline.use_cyclic_u = cyclic
    return obj


ROUND = [(0.2 * math.cos(a), 0.2 * math.sin(a), 0.0) for a in np.linspace(0, 6.0, 12)]


# Modifiers: the object, the modifier and its settings. Smoke is missing, because its solver crashes
# Blender's module when the next file opens.
MODIFIED = {
    "cloth": (grid, "CLOTH", {}),
    "displaced": (grid, "DISPLACE", {"strength": 0.2}),
    "subdivided": (box, "SUBSURF", {"levels": 2}),
    "solidified": (grid, "SOLIDIFY", {"thickness": 0.1}),
    "wireframe": (lambda world: grid(world, 6), "WIREFRAME", {"thickness": 0.02}),
    "array": (
        lambda world: world.box((0.05, 0.4, 0.05), (-0.2, 0, -0.5), "lamella"),
        "ARRAY",
        {"count": 6},
    ),
    "curve_with_a_mesh_modifier": (
        lambda world: line(curve(world, "pipe", bevel_depth=0.05), ROUND, cyclic=True),
        "SOLIDIFY",
        {"thickness": 0.01},
    ),
}
ODD |= {
    name: lambda world, build=build, kind=kind, settings=settings: modified(
        build(world), kind, **settings
    )
    for name, (build, kind, settings) in MODIFIED.items()
}

# Degenerate meshes: their points, edges and faces.
TRIANGLE = [(-0.2, -0.2, 0), (0.2, -0.2, 0), (0.2, 0.2, 0)]
HORSESHOE = [(-0.2, -0.2), (0.2, -0.2), (0.2, 0.2), (0.1, 0.2), (0.1, -0.1), (-0.1, -0.1)]
HORSESHOE += [(-0.1, 0.2), (-0.2, 0.2)]
BARE = {
    "mesh_without_anything": ([], [], []),
    "vertices_alone": ([(0, 0, 0), (0.1, 0, 0)], [], []),
    "edges_alone": ([(-0.1, 0, 0), (0.1, 0, 0), (0, 0.1, 0)], [(0, 1), (1, 2)], []),
    "faces_without_area": (
        [(-0.2, 0, 0), (0, 0, 0), (0.2, 0, 0), (0, 0, 0)],
        [],
        [(0, 1, 2), (0, 1, 3)],
    ),
    "faces_with_and_without_area": (
        [*TRIANGLE, (0, 0, 0), (0, 0, 0)],
        [],
        [(3, 4, 0), (0, 1, 2), (2, 2, 1)],
    ),
    # The sensor is above its opening.
    "a_concave_face": ([(x, y, 0.0) for x, y in HORSESHOE], [], [tuple(range(8))]),
    "a_face_that_is_not_flat": (
        [(-0.2, -0.2, 0), (0.2, -0.2, 0.1), (0.2, 0.2, 0), (-0.2, 0.2, 0.1)],
        [],
        [(0, 1, 2, 3)],
    ),
    "a_face_that_crosses_itself": (
        [(-0.2, -0.2, 0), (0.2, 0.2, 0), (0.2, -0.2, 0), (-0.2, 0.2, 0)],
        [],
        [(0, 1, 2, 3)],
    ),
    "three_faces_at_an_edge": (
        [(0, -0.2, 0), (0, 0.2, 0), (0.2, 0, 0), (-0.2, 0, 0), (0, 0, 0.2)],
        [],
        [(0, 1, 2), (0, 1, 3), (0, 1, 4)],
    ),
    "the_same_face_twice": (TRIANGLE * 2, [], [(0, 1, 2), (5, 4, 3)]),
}


def bare(world: Any, name: str) -> Any:
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(*BARE[name])
    return world.link(name, mesh, AT)


ODD |= {name: lambda world, name=name: bare(world, name) for name in BARE}

# Places, sizes, rotations and display of an object.
ODD |= {
    "tiny": lambda world: having(world.box((1e-3, 1e-3, 1e-3), AT, "tiny"), scale=(400, 400, 400)),
    "huge": lambda world: world.box((2e5, 2e5, 2e5), (0, 0, -1e5 - 0.5), "huge"),
    "scaled_down": lambda world: having(
        world.box((4e3, 4e3, 4e3), AT, "large"), scale=(1e-4, 1e-4, 1e-4)
    ),
    "mirrored": lambda world: having(ball(world), scale=(-1, 1, 1)),
    "mirrored_on_all_axes": lambda world: having(box(world), scale=(-1, -0.5, -2)),
    "flattened": lambda world: having(box(world), scale=(1, 1, 0)),
    "shown_as_wire": lambda world: having(box(world), display_type="WIRE"),
    "shown_as_bounds": lambda world: having(ball(world), display_type="BOUNDS"),
    "not_selectable": lambda world: having(box(world), hide_select=True),
    "hidden_in_renders_alone": lambda world: having(box(world), hide_render=True),
    "disabled_in_viewports": lambda world: having(box(world), hide_viewport=True),
}

# Curves, text, and other types of objects with a surface or without.
ODD |= {
    "curve_without_bevel": lambda world: line(curve(world, "bare"), ROUND),
    "curve_with_bevel": lambda world: line(
        curve(world, "pipe", bevel_depth=0.05), ROUND, cyclic=True
    ),
    "curve_extruded": lambda world: line(curve(world, "ribbon", extrude=0.1), ROUND),
    "curve_filled": lambda world: line(
        curve(world, "lid", dimensions="2D", fill_mode="BOTH"), ROUND, cyclic=True
    ),
    "volume": lambda world: world.link("volume", bpy.data.volumes.new("volume"), AT),
    "empty_with_a_picture": lambda world: having(
        world.link("picture", None, AT),
        empty_display_type="IMAGE",
        data=bpy.data.images.new("picture", 8, 8),
    ),
}


def _edited(world: Any, obj: Any, mode: str = "EDIT") -> Any:
    world.update()
    bpy.context.view_layer.objects.active = obj
    bpy.ops.object.mode_set(mode=mode)
    return obj


ODD |= {
    "being_edited": lambda world: _edited(world, box(world)),
    "being_edited_with_a_modifier": lambda world: _edited(
        world, modified(box(world), "SUBSURF", levels=2)
    ),
    "being_sculpted": lambda world: _edited(world, ball(world), "SCULPT"),
}

# Geometries that take more than a line to build


Builder = Callable[[Any], Any]


def odd(builder: Builder) -> Builder:
    ODD[builder.__name__] = builder
    return builder


def on_versions_with(operator: str) -> Callable[[Builder], Builder]:
    """Register a builder if `bpy.ops.object` has an operator."""
    return odd if operator in dir(bpy.ops.object) else lambda builder: builder


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
    """Add two objects of one family, whose common surface belongs to the first."""
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
    """Add a mesh made of a volume that is made of a mesh."""
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
def nowhere(world: Any) -> Any:
    """Add a mesh with vertices that are NaN."""
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
def by_an_armature(world: Any) -> Any:
    rig = world.rig("bone", (0, 0, 0.2), AT)
    made = box(world)
    made.vertex_groups.new(name="bone").add(range(8), 1.0, "REPLACE")
    modified(made, "ARMATURE", object=rig)
    rig.pose.bones["bone"].location = (0, 0.1, 0)
    return made


@odd
def boolean_that_leaves_nothing(world: Any) -> Any:
    other = world.box((1, 1, 1), AT, "other")
    other.hide_viewport = True
    return modified(box(world), "BOOLEAN", object=other, operation="DIFFERENCE")


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
    """Instance the output of one node, with its inputs set."""

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
    """Add a curve whose nodes turn it into a mesh."""

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
    made = world.instance("instance", source, AT)
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
    made = world.instance("instance", source, AT)
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
