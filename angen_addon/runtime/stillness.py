# SPDX-License-Identifier: GPL-3.0-or-later
"""Find the steps at which nothing that sensors read can change, so that a run skips them.

The times of changes come from keyframes and NLA strips. If anything else can change the scene with
time, no frame is skipped, and a text gives the reason. Examples are drivers that read the frame,
physics, simulation zones and movie textures.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np

from ...sensor_logic.kind import CROSSINGS, FORCES, POSES, RAYS, USES, WARMTH
from ...sensor_logic.model import Array
from ..scene import outputs
from ..scene.animation import action_curves, all_animated, time_stretch
from ..scene.light.changes import SHADING
from ..scene.surfaces import SURFACES
from ..scene.surfaces.warmth import heat_changes
from ..scene.timed import is_timeless_driver
from ..scene.timed import reasons as timed_reasons

# Quantities that do not depend on datablocks of the types in SHADING, unless a driver reads one.
BLIND_TO_SHADING = {RAYS, CROSSINGS, FORCES, POSES, USES} | {
    need for need, probe in SURFACES.items() if not probe.reads_shading
}
# Spans (n, 2) of time.
NEVER = np.empty((0, 2))
ALWAYS = np.array([[-np.inf, np.inf]])
# Interpolations of keyframes, as Blender numbers them.
CONSTANT, LINEAR, BEZIER = 0, 1, 2
# At a time nearer than 0.0001 to a keyframe, Blender evaluates the keyframe itself.
NEAR_A_KEY = 1e-3


@dataclass(frozen=True)
class Stillness:
    """The times at which the scene can change; at all others it stays the same.

    Attributes
    ----------
    busy
        The spans of time (n, 2) in which the scene can change, in frames of the F-curves. They are
        in order and do not overlap.
    reasons
        Texts on why no frame can be skipped; empty if frames can be skipped.
    stretch
        The number of frames of the F-curves in one frame of the scene (time stretching).
    timed
        Whether anything other than keyframes can make the scene differ between frames.
    """

    busy: Array
    reasons: tuple[str, ...] = ()
    stretch: float = 1.0
    timed: bool = False

    @property
    def why(self) -> str:
        """A text with the first reason and the number of further ones; empty without a reason."""
        first, more = "".join(self.reasons[:1]), len(self.reasons) - 1
        return f"{first} (and {more} more)" if more > 0 else first

    def fresh(self, frames: Any, subframes: Any = 0.0) -> np.typing.NDArray[np.bool_]:
        """Return whether the scene at each frame can differ from the scene one frame before, (n,).

        The times are `frames` (n,), ascending, plus `subframes` (n,) from 0 to 1. The first value
        is always true.
        """
        # Blender computes the time in single precision.
        times = np.asarray(frames, np.float32) + np.asarray(subframes, np.float32)
        times = (times * np.float32(self.stretch)).astype(np.float64)
        if self.reasons:
            return np.ones(len(times), bool)
        begun = np.searchsorted(self.busy[:, 0], times[1:])
        ended = np.searchsorted(self.busy[:, 1], times[:-1], side="right")
        return np.concatenate([[True], begun > ended])


def find_stillness(scene: Any, needs: Iterable[str], other_handlers: bool = False) -> Stillness:
    """Return the times at which the scene can change in a way that sensors read.

    `needs` are the quantities that the sensors read, such as RAYS. `other_handlers` says whether
    other code has frame handlers, which could change anything at any frame.
    """
    needs = set(needs)
    owners = [owner for owner in all_animated() if _is_evaluated(owner, scene)]
    shading = not BLIND_TO_SHADING.issuperset(needs) or any(
        isinstance(target.id, SHADING)
        for owner in owners
        for curve in _drivers(owner, shading=False)
        for target in _targets(curve.driver)
    )
    reasons = ["a script has added a frame change handler"] if other_handlers else []
    if outputs.are_driven():
        reasons.append("drivers read the outputs of sensors")
    reasons += [
        *_driver_reasons(owners, shading),
        *timed_reasons(scene, shading),
    ]
    parts, timed = [], bool(reasons)
    for owner in owners:
        spans = _busy_spans(owner, shading)
        if WARMTH in needs:
            cooler = heat_changes(owner, scene)
            spans = _join_spans([spans, np.stack([cooler - NEAR_A_KEY, cooler], axis=1)])
        if np.isinf(spans).any():
            reasons.append(
                f"'{owner.name}' has animation without an end (cycles or other "
                "modifiers, extrapolation)"
            )
        parts.append(spans)
    different = tuple(dict.fromkeys(reasons))
    return Stillness(_join_spans(parts), different, time_stretch(scene), timed)


def _is_evaluated(owner: Any, scene: Any) -> bool:
    if isinstance(owner, bpy.types.Scene):
        shown = scene
        while shown is not None and shown != owner:
            shown = shown.background_set
        return shown is not None
    return not isinstance(owner, bpy.types.CompositorNodeTree)


def _affects_sensors(owner: Any, curve: Any, shading: bool) -> bool:
    """Return whether an F-curve or driver of `owner` animates data that sensors can read.

    If sensors read shading (`shading`), every curve counts. Otherwise, curves of materials and
    other shading data count only if they animate the extension's own properties. Outputs of sensors
    never count, since `find_stillness` checks the drivers that read them.
    """
    if shading:
        return True
    if isinstance(owner, SHADING):
        return str(curve.data_path).startswith("angen_")
    return curve.data_path not in {outputs.ACTIVE_PATH, outputs.VALUE_PATH}


def _busy_spans(owner: Any, shading: bool) -> Array:
    """Return the spans (n, 2) in which keyframes and NLA strips can change a datablock."""
    animation = owner.animation_data
    found = action_curves(animation.action, getattr(animation, "action_slot", None))
    curves = [curve for curve in found if _affects_sensors(owner, curve, shading)]
    parts = [_curve_spans(curve) for curve in curves]
    tracks = animation.nla_tracks
    if len(tracks):
        # The action then acts as a strip, which may have no effect before and after its keys.
        playing = [s for track in tracks if track.is_solo or not track.mute for s in track.strips]
        parts += [_strip_spans(playing), *(_key_range(curve) for curve in found)]
    if animation.use_tweak_mode:
        parts.append(ALWAYS)
    return _join_spans(parts)


def _drivers(owner: Any, shading: bool) -> list[Any]:
    found = owner.animation_data.drivers
    return [c for c in found if not c.mute and _affects_sensors(owner, c, shading)]


def _targets(driver: Any) -> Iterator[Any]:
    return (target for variable in driver.variables for target in variable.targets)


def _driver_reasons(owners: Iterable[Any], shading: bool) -> Iterator[str]:
    for owner in owners:
        for curve in _drivers(owner, shading):
            driver = curve.driver
            if driver.type == "SCRIPTED" and not is_timeless_driver(driver):
                yield f"a driver of '{owner.name}' may follow the frame: {driver.expression}"
            if any("frame" in target.data_path for target in _targets(driver)):
                yield f"a driver of '{owner.name}' reads the frame number"


def _curve_spans(curve: Any) -> Array:
    """Return the spans (n, 2) in which the value of an F-curve can change."""
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
    """Return the spans (m, 2) in which the value of an F-curve with n keyframes can change.

    Parameters
    ----------
    keys
        The time and the value of each keyframe (n, 2).
    into, out_of
        The values of the handles at the end and at the start of each segment (n − 1,). A segment
        lies between two keyframes.
    kinds
        The interpolation of each segment (n − 1,), as Blender's integer.
    """
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
    """Return the spans (n, 2) of NLA strips, longer by one frame at both ends.

    Outside of its span, a strip holds its value or has no effect.
    """
    playing = [strip for strip in strips if not strip.mute]
    if any(s.use_animated_influence or s.use_animated_time or s.modifiers for s in playing):
        return ALWAYS
    ends = [[strip.frame_start - 1.0, strip.frame_end + 1.0] for strip in playing]
    return np.array(ends) if ends else NEVER


def _key_range(curve: Any) -> Array:
    """Return one span (1, 2) around all keyframes of an F-curve; shape (0, 2) without keyframes."""
    points = curve.keyframe_points
    if not len(points):
        return NEVER
    return np.array([[points[0].co[0] - 1.0, points[-1].co[0] + 1.0]])


def _join_spans(parts: Sequence[Array]) -> Array:
    """Return all spans (n, 2) in order, with overlapping ones joined."""
    spans = np.concatenate([NEVER, *parts])
    if not len(spans):
        return NEVER
    spans = spans[np.argsort(spans[:, 0], kind="stable")]
    reached = np.maximum.accumulate(spans[:, 1])
    first = np.flatnonzero(np.concatenate([[True], spans[1:, 0] > reached[:-1]]))
    return np.stack([spans[first, 0], reached[np.append(first[1:], len(spans)) - 1]], axis=1)
