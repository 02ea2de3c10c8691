# SPDX-License-Identifier: GPL-3.0-or-later
"""Find modifiers, nodes, physics and films whose result may change with time without keyframes.

The tables list the types that cannot change. All other types count as changing, including types
that later versions of Blender add.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from typing import Any

import bpy

# Modifiers whose result depends only on the state of objects and textures.
TIMELESS_MODIFIERS = {
    "ARMATURE", "ARRAY", "BEVEL", "BOOLEAN", "CAST", "CORRECTIVE_SMOOTH", "CURVE",
    "DATA_TRANSFER", "DECIMATE", "DISPLACE", "EDGE_SPLIT", "HOOK", "LAPLACIANDEFORM",
    "LAPLACIANSMOOTH", "LATTICE", "MASK", "MESH_DEFORM", "MESH_TO_VOLUME", "MIRROR", "MULTIRES",
    "NODES", "NORMAL_EDIT", "REMESH", "SCREW", "SHRINKWRAP", "SIMPLE_DEFORM", "SKIN", "SMOOTH",
    "SOLIDIFY", "SUBSURF", "SURFACE_DEFORM", "TRIANGULATE", "UV_PROJECT", "UV_WARP",
    "VERTEX_WEIGHT_EDIT", "VERTEX_WEIGHT_MIX", "VERTEX_WEIGHT_PROXIMITY", "VOLUME_DISPLACE",
    "VOLUME_TO_MESH", "WARP", "WEIGHTED_NORMAL", "WELD", "WIREFRAME",
}  # fmt: skip
TIMELESS_CONSTRAINTS = {
    "ACTION", "ARMATURE", "CHILD_OF", "CLAMP_TO", "COPY_LOCATION", "COPY_ROTATION",
    "COPY_SCALE", "COPY_TRANSFORMS", "DAMPED_TRACK", "FLOOR", "FOLLOW_PATH",
    "GEOMETRY_ATTRIBUTE", "IK", "LIMIT_DISTANCE", "LIMIT_LOCATION", "LIMIT_ROTATION",
    "LIMIT_SCALE", "LOCKED_TRACK", "MAINTAIN_VOLUME", "PIVOT", "SHRINKWRAP", "SPLINE_IK",
    "STRETCH_TO", "TRACK_TO", "TRANSFORM",
}  # fmt: skip
# Parts of the names of node types whose result may depend on the frame. Markers can change the
# active camera.
TIMED_NODES = ("Time", "Simula", "Bake", "ActiveCamera", "Sequence", "Movie", "Sound", "Solver")
# Modifiers that move vertices, and leave faces, materials and attributes as they are.
DEFORMING_MODIFIERS = {
    "ARMATURE", "CAST", "CORRECTIVE_SMOOTH", "CURVE", "HOOK", "LATTICE", "MESH_DEFORM",
    "SHRINKWRAP", "SIMPLE_DEFORM", "SMOOTH", "SURFACE_DEFORM", "WARP",
}  # fmt: skip
# Modifiers whose result at a frame depends on the frames before it.
SIMULATED_MODIFIERS = {"CLOTH", "DYNAMIC_PAINT", "FLUID", "PARTICLE_SYSTEM", "SOFT_BODY"}
# Modifiers that can make instances.
INSTANCING_MODIFIERS = {"NODES", "PARTICLE_SYSTEM"}
# Sources of images that differ from frame to frame.
FILM_SOURCES = {"MOVIE", "SEQUENCE"}
# Syntax of driver expressions that depend on nothing but their variables.
PURE = (
    ast.Expression, ast.BoolOp, ast.BinOp, ast.UnaryOp, ast.IfExp, ast.Compare, ast.Constant,
    ast.Load, ast.boolop, ast.operator, ast.unaryop, ast.cmpop,
)  # fmt: skip
PURE_NAMES = {
    "abs", "acos", "asin", "atan", "atan2", "bool", "ceil", "clamp", "cos", "cosh", "degrees",
    "e", "exp", "fabs", "float", "floor", "fmod", "hypot", "int", "lerp", "log", "log10", "max",
    "min", "pi", "pow", "radians", "round", "sin", "sinh", "smoothstep", "sqrt", "tan", "tanh",
    "trunc",
}  # fmt: skip


def timed_modifiers(obj: Any) -> Iterator[Any]:
    """Yield the modifiers of an object whose result may depend on the frame.

    Modifiers with geometry nodes are left out: `is_timed_node` says whether their nodes depend on
    it.
    """
    return (one for one in obj.modifiers if one.type not in TIMELESS_MODIFIERS)


def timed_constraints(obj: Any) -> Iterator[Any]:
    """Yield the constraints of an object and its bones whose result may depend on the frame."""
    bones = obj.pose.bones if obj.pose else ()
    every = (*obj.constraints, *(one for bone in bones for one in bone.constraints))
    return (one for one in every if one.type not in TIMELESS_CONSTRAINTS)


def is_timed_node(node: Any) -> bool:
    """Return whether the result of a node may depend on the frame."""
    named = any(word in node.bl_idname for word in TIMED_NODES)
    return named or "frame" in getattr(node, "attribute_name", "")


def has_node(tree: Any, wanted: Callable[[Any], bool], seen: frozenset[str] = frozenset()) -> bool:
    """Return whether a node tree, or a group in it, has a node that the function `wanted` accepts.

    `seen` has the names of the trees around this one, which are not searched again.
    """
    if tree is None or tree.name_full in seen:
        return False
    inside = seen | {tree.name_full}
    return any(
        wanted(node) or has_node(getattr(node, "node_tree", None), wanted, inside)
        for node in tree.nodes
    )


def may_follow_frame(obj: Any) -> bool:
    """Return whether enabled modifiers or constraints may change an object from frame to frame."""
    return (
        any(one.show_viewport for one in timed_modifiers(obj))
        or any(not one.mute for one in timed_constraints(obj))
        or any(
            one.type == "NODES" and one.show_viewport and has_node(one.node_group, is_timed_node)
            for one in obj.modifiers
        )
    )


def is_simulated(modifier: Any) -> bool:
    """Return whether the result of a modifier depends on earlier frames.

    That is so for physics, and for simulation zones in geometry nodes or their groups.
    """
    return modifier.type in SIMULATED_MODIFIERS or has_node(
        getattr(modifier, "node_group", None),
        lambda node: node.bl_idname == "GeometryNodeSimulationOutput",
    )


def frames_to_step_from(scene: Any) -> list[int]:
    """Return the first frame of each simulation in the scene.

    The state of a simulation at a frame depends on all frames since its first.
    """
    starts = []
    world = scene.rigidbody_world
    if world is not None and world.enabled and not world.point_cache.is_baked:
        starts.append(world.point_cache.frame_start)
    for obj in scene.objects:
        for modifier in obj.modifiers:
            if is_simulated(modifier):
                holder = getattr(modifier, "particle_system", modifier)
                cache = getattr(holder, "point_cache", None)
                starts.append(cache.frame_start if cache else scene.frame_start)
    return starts


def films(tree: Any) -> list[Any]:
    """Return the nodes of a tree that show movies or image sequences."""
    return [
        node
        for node in tree.nodes
        if hasattr(node, "image_user") and node.image and node.image.source in FILM_SOURCES
    ]


def has_stiff_films() -> bool:
    """Return whether any node shows a film without Auto Refresh, which Cycles does not advance."""
    data = bpy.data
    owners = [*data.materials, *data.lights, *data.worlds]
    trees = [*data.node_groups, *(o.node_tree for o in owners if o.node_tree)]
    return any(not node.image_user.use_auto_refresh for tree in trees for node in films(tree))


def reasons(scene: Any, shading: bool) -> Iterator[str]:
    """Yield a text about each thing that may differ between frames although it has no animation.

    If `shading` is True, lamps, materials and worlds count too.
    """
    yield from _timed_objects()
    yield from _simulated_bodies(scene)
    yield from _timed_nodes(shading)
    yield from _changing_images(shading)


def is_timeless_driver(driver: Any) -> bool:
    """Return whether the result of a driver depends on nothing but the values of its variables."""
    known = PURE_NAMES | {variable.name for variable in driver.variables}
    try:
        tree = ast.parse(driver.expression.strip(), mode="eval")
    except (SyntaxError, ValueError):
        return False
    return all(
        (node.id in known and node.id not in {"frame", "self", "depsgraph"})
        if isinstance(node, ast.Name)
        else isinstance(node, PURE)
        or (isinstance(node, ast.Call) and isinstance(node.func, ast.Name))
        for node in ast.walk(tree)
    )


def _timed_objects() -> Iterator[str]:
    """Yield a text for each object that modifiers, constraints, bones or drawings may change."""
    for obj in bpy.data.objects:
        for modifier in timed_modifiers(obj):
            yield f"'{obj.name}' has a modifier that may follow the frame ({modifier.name})"
        for constraint in timed_constraints(obj):
            yield f"'{obj.name}' has a constraint that may follow the frame ({constraint.name})"
        if obj.pose and obj.pose.ik_solver != "LEGACY":
            yield f"the bones of '{obj.name}' are solved from frame to frame (iTaSC)"
        layers = getattr(obj.data, "layers", ()) if obj.type in {"GPENCIL", "GREASEPENCIL"} else ()
        if any(len(layer.frames) > 1 for layer in layers) or len(
            getattr(obj, "grease_pencil_modifiers", ())
        ):
            yield f"'{obj.name}' has Grease Pencil drawings that change"


def _simulated_bodies(scene: Any) -> Iterator[str]:
    world = scene.rigidbody_world
    for obj in world.collection.objects if world and world.enabled and world.collection else ():
        if obj.rigid_body is not None and obj.rigid_body.type == "ACTIVE":
            yield f"'{obj.name}' is moved by the physics of rigid bodies"


def _timed_nodes(shading: bool) -> Iterator[str]:
    owners = [
        *bpy.data.textures,
        *((*bpy.data.materials, *bpy.data.worlds, *bpy.data.lights) if shading else ()),
    ]
    trees = [tree for owner in owners if (tree := getattr(owner, "node_tree", None)) is not None]
    for tree in (*bpy.data.node_groups, *trees):
        if isinstance(tree, bpy.types.CompositorNodeTree):
            continue
        if isinstance(tree, bpy.types.ShaderNodeTree) and not shading:
            continue
        for node in tree.nodes:
            if is_timed_node(node):
                yield f"nodes of '{tree.name}' may follow the frame ({node.name})"


def _changing_images(shading: bool) -> Iterator[str]:
    """Yield a text for each image, volume and texture that changes without animation."""
    if (
        shading
        or bpy.data.textures
        or any(
            "Image" in node.bl_idname
            for tree in bpy.data.node_groups
            if isinstance(tree, bpy.types.GeometryNodeTree)
            for node in tree.nodes
        )
    ):
        for image in bpy.data.images:
            if image.source in FILM_SOURCES:
                yield f"'{image.name}' is a film"
    for texture in bpy.data.textures:
        if texture.type == "NOISE":
            yield f"the texture '{texture.name}' differs at every frame"
    for volume in bpy.data.volumes:
        if volume.is_sequence:
            yield f"'{volume.name}' is a sequence of files"
