# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of what can change with time without keys: modifiers, constraints, nodes.

The table lists what cannot. Whatever is not listed may follow the frame, also types that a later
Blender adds.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

# Modifiers whose result depends on nothing but what their object, other objects and textures are.
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
# In names of kinds of nodes: those whose result may depend on the frame. A marker can choose
# another camera.
TIMED_NODES = ("Time", "Simula", "Bake", "ActiveCamera", "Sequence", "Movie", "Sound", "Solver")


def timed_modifiers(obj: Any) -> Iterator[Any]:
    """Modifiers of an object that may follow the frame, apart from geometry nodes."""
    return (one for one in obj.modifiers if one.type not in TIMELESS_MODIFIERS)


def timed_constraints(obj: Any) -> Iterator[Any]:
    """Constraints of an object and of its bones that may follow the frame."""
    bones = obj.pose.bones if obj.pose else ()
    every = (*obj.constraints, *(one for bone in bones for one in bone.constraints))
    return (one for one in every if one.type not in TIMELESS_CONSTRAINTS)


def is_timed_node(node: Any) -> bool:
    named = any(word in node.bl_idname for word in TIMED_NODES)
    return named or "frame" in getattr(node, "attribute_name", "")


def has_node(tree: Any, wanted: Callable[[Any], bool], seen: frozenset[str] = frozenset()) -> bool:
    """Whether a node tree, or a group within it, has a node that is wanted."""
    if tree is None or tree.name_full in seen:
        return False
    inside = seen | {tree.name_full}
    return any(
        wanted(node) or has_node(getattr(node, "node_tree", None), wanted, inside)
        for node in tree.nodes
    )


def may_follow_frame(obj: Any) -> bool:
    """Whether modifiers or constraints that are switched on may change an object with time."""
    return (
        any(one.show_viewport for one in timed_modifiers(obj))
        or any(not one.mute for one in timed_constraints(obj))
        or any(
            one.type == "NODES" and one.show_viewport and has_node(one.node_group, is_timed_node)
            for one in obj.modifiers
        )
    )
