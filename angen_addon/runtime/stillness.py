# SPDX-License-Identifier: GPL-3.0-or-later
"""When nothing that sensors read can change, so that the scene need not be evaluated anew.

What keys and strips do is told from them. What else can change with time (drivers on the frame,
physics, simulation zones, films …), and what is not known here, keeps every frame from being
skipped, with the reason in words.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np

from ...sensor_logic.kind import CROSSINGS, FORCES, POSES, RAYS, WARMTH
from ..scene.animation import action_curves, all_animated, time_stretch
from ..scene.timed import is_timed_node, timed_constraints, timed_modifiers
from . import busy_spans, outputs
from .busy_spans import Array

# What no sensor reads that needs these alone of the scene, unless a driver does.
SHADING = (bpy.types.Light, bpy.types.Material, bpy.types.ShaderNodeTree, bpy.types.World)
BLIND_TO_SHADING = {RAYS, WARMTH, CROSSINGS, FORCES, POSES}
# What the expression of a driver may consist of to depend on its variables alone.
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


@dataclass(frozen=True)
class Stillness:
    """`busy` (n, 2): spans of time in which something may change, in order and apart, as F-curves
    count time; `reasons`: why nothing can be skipped, in words; `stretch`: frames of theirs in one
    of the scene (Time Stretching); `timed`: whether anything but keys may follow the frame."""

    busy: Array
    reasons: tuple[str, ...] = ()
    stretch: float = 1.0
    timed: bool = False

    @property
    def why(self) -> str:
        """The first of the reasons, and how many more there are; empty where there is none."""
        more = len(self.reasons) - 1
        return "".join(self.reasons[:1]) + (f" (and {more} more)" if more > 0 else "")

    def fresh(self, frames: Any, subframes: Any = 0.0) -> np.typing.NDArray[np.bool_]:
        """Of moments (n,) in order, each a frame and a part of one: at which of them something may
        be otherwise than at the one before. The first is one of them."""
        # As Blender works the time out, in single precision.
        times = np.asarray(frames, np.float32) + np.asarray(subframes, np.float32)
        times = (times * np.float32(self.stretch)).astype(np.float64)
        if self.reasons:
            return np.ones(len(times), bool)
        begun = np.searchsorted(self.busy[:, 0], times[1:])
        ended = np.searchsorted(self.busy[:, 1], times[:-1], side="right")
        return np.concatenate([[True], begun > ended])


def find(scene: Any, needs: Iterable[str], others_act: bool = False) -> Stillness:
    """When nothing can change in a scene that is run, of what sensors read that have such `needs`;
    `others_act`: other code has handlers that may change anything at any frame."""
    owners = [owner for owner in all_animated() if _is_evaluated(owner, scene)]
    shading = not BLIND_TO_SHADING.issuperset(needs) or any(
        isinstance(target.id, SHADING)
        for owner in owners
        for curve in _drivers(owner, shading=False)
        for target in _targets(curve.driver)
    )
    reasons = ["other code acts at each frame (a frame handler)"] if others_act else []
    if outputs.are_driven():
        reasons.append("drivers read what sensors say")
    reasons += [
        *_of_drivers(owners, shading),
        *_of_objects(),
        *_of_bodies(scene),
        *_of_nodes(shading),
    ]
    reasons += _of_films(shading)
    parts, timed = [], bool(reasons)
    for owner in owners:
        spans = _spans_of(owner, shading)
        if np.isinf(spans).any():
            reasons.append(f"keys of '{owner.name}' go on without end (modifiers, extrapolation)")
        parts.append(spans)
    every = tuple(dict.fromkeys(reasons))
    return Stillness(busy_spans.joined(parts), every, time_stretch(scene), timed)


def _is_evaluated(owner: Any, scene: Any) -> bool:
    if isinstance(owner, bpy.types.Scene):
        shown = scene
        while shown is not None and shown != owner:
            shown = shown.background_set
        return shown is not None
    return not isinstance(owner, bpy.types.CompositorNodeTree)


def _counts(owner: Any, curve: Any, shading: bool) -> bool:
    """Whether sensors can read what a curve or driver sets. How warm a material is, is not of its
    shading; what sensors say, nobody reads (see `outputs.are_driven`)."""
    if shading:
        return True
    if isinstance(owner, SHADING):
        return str(curve.data_path).startswith("angen_")
    return curve.data_path not in {outputs.ACTIVE_PATH, outputs.VALUE_PATH}


def _spans_of(owner: Any, shading: bool) -> Array:
    """Where keys and strips of a datablock may change something."""
    animation = owner.animation_data
    found = action_curves(animation.action, getattr(animation, "action_slot", None))
    curves = [curve for curve in found if _counts(owner, curve, shading)]
    parts = [busy_spans.of_curve(curve) for curve in curves]
    tracks = animation.nla_tracks
    if len(tracks):
        # The action is one of the strips then: it may have no effect before its keys and after.
        playing = [s for track in tracks if track.is_solo or not track.mute for s in track.strips]
        parts += [busy_spans.of_strips(playing), *(busy_spans.reach_of(curve) for curve in found)]
    if animation.use_tweak_mode:
        parts.append(busy_spans.ALWAYS)
    return busy_spans.joined(parts)


def _drivers(owner: Any, shading: bool) -> list[Any]:
    found = owner.animation_data.drivers
    return [c for c in found if not c.mute and _counts(owner, c, shading)]


def _targets(driver: Any) -> Iterator[Any]:
    return (target for variable in driver.variables for target in variable.targets)


def _of_drivers(owners: Iterable[Any], shading: bool) -> Iterator[str]:
    for owner in owners:
        for curve in _drivers(owner, shading):
            driver = curve.driver
            if driver.type == "SCRIPTED" and not _is_pure(driver):
                yield f"a driver of '{owner.name}' may follow the frame: {driver.expression}"
            if any("frame" in target.data_path for target in _targets(driver)):
                yield f"a driver of '{owner.name}' reads a frame"


def _is_pure(driver: Any) -> bool:
    """Whether an expression depends on its variables alone."""
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


def _of_objects() -> Iterator[str]:
    """What objects have that may go by the frame. Physics of rigid bodies is told of elsewhere."""
    for obj in bpy.data.objects:
        for modifier in timed_modifiers(obj):
            yield f"'{obj.name}' has a modifier that may follow the frame ({modifier.name})"
        for constraint in timed_constraints(obj):
            yield f"'{obj.name}' has a constraint that may follow the frame ({constraint.name})"
        if obj.pose and obj.pose.ik_solver != "LEGACY":
            yield f"the bones of '{obj.name}' are solved over time (iTaSC)"
        layers = getattr(obj.data, "layers", ()) if obj.type in {"GPENCIL", "GREASEPENCIL"} else ()
        if any(len(layer.frames) > 1 for layer in layers) or len(
            getattr(obj, "grease_pencil_modifiers", ())
        ):
            yield f"'{obj.name}' has drawings that change"


def _of_bodies(scene: Any) -> Iterator[str]:
    """Rigid bodies that the simulation moves."""
    world = scene.rigidbody_world
    for obj in world.collection.objects if world and world.enabled and world.collection else ():
        if obj.rigid_body is not None and obj.rigid_body.type == "ACTIVE":
            yield f"'{obj.name}' is moved by the physics of rigid bodies"


def _of_nodes(shading: bool) -> Iterator[str]:
    """Node trees that look at the frame, and what they may look up by its name."""
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


def _of_films(shading: bool) -> Iterator[str]:
    """Pictures, clouds and patterns that change by themselves."""
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
            if image.source in {"MOVIE", "SEQUENCE"}:
                yield f"'{image.name}' is a film"
    for texture in bpy.data.textures:
        if texture.type == "NOISE":
            yield f"the texture '{texture.name}' differs at every frame"
    for volume in bpy.data.volumes:
        if volume.is_sequence:
            yield f"'{volume.name}' is a sequence of files"
