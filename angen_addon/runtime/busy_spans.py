# SPDX-License-Identifier: GPL-3.0-or-later
"""Where F-curves and strips can change a value: spans of the time that they are evaluated at.

A span (a, b) says: of two times with nothing of any span between them, both have the same values.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

Array = np.typing.NDArray[np.float64]

NEVER = np.empty((0, 2))
ALWAYS = np.array([[-np.inf, np.inf]])
CONSTANT, LINEAR, BEZIER = 0, 1, 2
# Blender takes a time that is nearer than 0.0001 to a key for the key's own.
NEAR_A_KEY = 1e-3


def of_curve(curve: Any) -> Array:
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
    return _of_keys(
        points["co"], points["handle_left"][1:, 1], points["handle_right"][:-1, 1], kinds[:-1]
    )


def _of_keys(keys: Any, into: Any, out_of: Any, kinds: Any) -> Array:
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


def of_strips(strips: Any) -> Array:
    """Spans of strips of the NLA, which hold what they end with, or nothing."""
    playing = [strip for strip in strips if not strip.mute]
    if any(s.use_animated_influence or s.use_animated_time or s.modifiers for s in playing):
        return ALWAYS
    ends = [[strip.frame_start - 1.0, strip.frame_end + 1.0] for strip in playing]
    return np.array(ends) if ends else NEVER


def reach_of(curve: Any) -> Array:
    """A span around all keys of an F-curve: where an action that is one of several strips acts."""
    points = curve.keyframe_points
    if not len(points):
        return NEVER
    return np.array([[points[0].co[0] - 1.0, points[-1].co[0] + 1.0]])


def joined(parts: Sequence[Array]) -> Array:
    """The same spans in order, without overlaps."""
    spans = np.concatenate([NEVER, *parts])
    if not len(spans):
        return NEVER
    spans = spans[np.argsort(spans[:, 0], kind="stable")]
    reached = np.maximum.accumulate(spans[:, 1])
    first = np.flatnonzero(np.concatenate([[True], spans[1:, 0] > reached[:-1]]))
    return np.stack([spans[first, 0], reached[np.append(first[1:], len(spans)) - 1]], axis=1)
