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
import numpy as np

AT = (0.0, 0.0, -0.5)
SIZE = 0.4
ODD: dict[str, Callable[[Any], Any]] = {}


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


# What modifiers make: of which object, which modifier, and its settings. Not smoke: its solver ends
# Blender's module as the next file opens.
MODIFIED = {
    "cloth": (grid, "CLOTH", {}),
    "soft_body": (box, "SOFT_BODY", {}),
    "ocean": (grid, "OCEAN", {"spatial_size": 1, "resolution": 4}),
    "dynamic_paint": (grid, "DYNAMIC_PAINT", {}),
    "displaced": (grid, "DISPLACE", {"strength": 0.2}),
    "subdivided": (box, "SUBSURF", {"levels": 2}),
    "solidified": (grid, "SOLIDIFY", {"thickness": 0.1}),
    "decimated_to_nothing": (box, "DECIMATE", {"ratio": 0.0}),
    "remeshed": (ball, "REMESH", {"voxel_size": 0.05}),
    "wireframe": (lambda world: grid(world, 6), "WIREFRAME", {"thickness": 0.02}),
    "triangulated": (grid, "TRIANGULATE", {}),
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

# Meshes that are hardly any: their points, edges and faces.
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

# Where, how large, how turned and how shown a thing is.
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

# Curves, text, and what else has a surface or looks as if.
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
