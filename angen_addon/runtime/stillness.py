# SPDX-License-Identifier: GPL-3.0-or-later
"""When nothing that sensors read can change, so that the scene need not be evaluated anew.

What keys and strips do is told from them. What else can change with time (drivers on the frame,
physics, simulation zones, films …), and what is not known here, keeps every frame from being
skipped, with the reason in words.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np

from ...sensor_logic.kind import CROSSINGS, FORCES, POSES, RAYS, WARMTH
from ...sensor_logic.model import Array
from ..scene.animation import action_curves, all_animated, time_stretch
from ..scene.timed import is_timeless_driver
from ..scene.timed import reasons as timed_reasons
from . import outputs

# What no sensor reads that needs these alone of the scene, unless a driver does.
SHADING = (bpy.types.Light, bpy.types.Material, bpy.types.ShaderNodeTree, bpy.types.World)
BLIND_TO_SHADING = {RAYS, WARMTH, CROSSINGS, FORCES, POSES}
# Spans (n, 2) of time.
NEVER = np.empty((0, 2))
ALWAYS = np.array([[-np.inf, np.inf]])
# Interpolations of keys, as Blender numbers them.
CONSTANT, LINEAR, BEZIER = 0, 1, 2
# Blender takes a time that is nearer than 0.0001 to a key for the key's own.
NEAR_A_KEY = 1e-3


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
        *timed_reasons(scene, shading),
    ]
    parts, timed = [], bool(reasons)
    for owner in owners:
        spans = _spans_of(owner, shading)
        if np.isinf(spans).any():
            reasons.append(f"keys of '{owner.name}' go on without end (modifiers, extrapolation)")
        parts.append(spans)
    every = tuple(dict.fromkeys(reasons))
    return Stillness(_joined(parts), every, time_stretch(scene), timed)


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
    parts = [_curve_spans(curve) for curve in curves]
    tracks = animation.nla_tracks
    if len(tracks):
        # The action is one of the strips then: it may have no effect before its keys and after.
        playing = [s for track in tracks if track.is_solo or not track.mute for s in track.strips]
        parts += [_strip_spans(playing), *(_reach(curve) for curve in found)]
    if animation.use_tweak_mode:
        parts.append(ALWAYS)
    return _joined(parts)


def _drivers(owner: Any, shading: bool) -> list[Any]:
    found = owner.animation_data.drivers
    return [c for c in found if not c.mute and _counts(owner, c, shading)]


def _targets(driver: Any) -> Iterator[Any]:
    return (target for variable in driver.variables for target in variable.targets)


def _of_drivers(owners: Iterable[Any], shading: bool) -> Iterator[str]:
    for owner in owners:
        for curve in _drivers(owner, shading):
            driver = curve.driver
            if driver.type == "SCRIPTED" and not is_timeless_driver(driver):
                yield f"a driver of '{owner.name}' may follow the frame: {driver.expression}"
            if any("frame" in target.data_path for target in _targets(driver)):
                yield f"a driver of '{owner.name}' reads a frame"


def _curve_spans(curve: Any) -> Array:
    """Spans (n, 2) in which an F-curve may change its value."""
    if curve.mute:
        return NEVER
    count = len(curve.keyframe_points)
    if any(not m.mute for m in curve.modifiers) or len(curve.sampled_points):
        return ALWAYS
    if count == 0:
        return NEVER
    if curve.extrapolation != "CONSTANT":
        return ALWAYS
    points = {
        name: np.empty((count, 2), np.float32) for name in ("co", "handle_left", "handle_right")
    }
    kinds = np.empty(count, np.int32)
    for name, values in points.items():
        curve.keyframe_points.foreach_get(name, values.ravel())
    curve.keyframe_points.foreach_get("interpolation", kinds)
    return _key_spans(
        points["co"], points["handle_left"][1:, 1], points["handle_right"][:-1, 1], kinds[:-1]
    )


def _key_spans(keys: Any, into: Any, out_of: Any, kinds: Any) -> Array:
    """Of keys (n, 2), with the heights (n − 1,) of the handles that end and begin each segment,
    and how it is interpolated."""
    times, values = keys[:, 0].astype(np.float64), keys[:, 1]
    lengths = np.diff(times)
    if not (np.isfinite(times).all() and (lengths >= 0.0).all()):
        return ALWAYS
    first, last = values[:-1], values[1:]
    level = (first == last) & (out_of == first) & (into == first)
    flat = (kinds == CONSTANT) | ((first == last) & (kinds == LINEAR)) | (level & (kinds == BEZIER))
    jumps = flat & (first != last)
    crowded = lengths < 2 * NEAR_A_KEY
    early = np.where(jumps | crowded, NEAR_A_KEY, 0.0)
    begins = np.where(flat & ~crowded, times[1:], times[:-1]) - early
    ends = times[1:] + np.where(crowded, NEAR_A_KEY, 0.0)
    return np.stack([begins, ends], axis=1)[~flat | jumps | crowded]


def _strip_spans(strips: Any) -> Array:
    """Spans of strips of the NLA, which hold what they end with, or nothing."""
    playing = [strip for strip in strips if not strip.mute]
    if any(s.use_animated_influence or s.use_animated_time or s.modifiers for s in playing):
        return ALWAYS
    ends = [[strip.frame_start - 1.0, strip.frame_end + 1.0] for strip in playing]
    return np.array(ends) if ends else NEVER


def _reach(curve: Any) -> Array:
    """A span around all keys of an F-curve: where an action that is one of several strips acts."""
    points = curve.keyframe_points
    if not len(points):
        return NEVER
    return np.array([[points[0].co[0] - 1.0, points[-1].co[0] + 1.0]])


def _joined(parts: Sequence[Array]) -> Array:
    """The same spans in order, without overlaps."""
    spans = np.concatenate([NEVER, *parts])
    if not len(spans):
        return NEVER
    spans = spans[np.argsort(spans[:, 0], kind="stable")]
    reached = np.maximum.accumulate(spans[:, 1])
    first = np.flatnonzero(np.concatenate([[True], spans[1:, 0] > reached[:-1]]))
    return np.stack([spans[first, 0], reached[np.append(first[1:], len(spans)) - 1]], axis=1)
