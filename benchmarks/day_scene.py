# SPDX-License-Identifier: GPL-3.0-or-later
"""A day in the home: its story again and again, with pauses in which nothing moves."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from angen_sensors.angen_addon.scene.animation import action_curves, all_animated

from .common import open_home

# So that a day fits into the frames that a scene can have (1,048,574).
FPS = 12
DAY_S = 86_400
# From one beginning of the story, of 172 s, to the next.
EVERY_S = 1728
FREE = 0


def open_day(seconds: int, strips: bool = True) -> Any:
    """The scene of the home, opened anew, whose story is told every `EVERY_S` for so long: by
    strips of the NLA, or by keys again and again, of which a day has 3.7 millions."""
    scene = open_home()
    slower = FPS * scene.render.fps_base / scene.render.fps
    times = -(-seconds // EVERY_S)
    for owner in list(all_animated()):
        if strips and owner.animation_data.action is not None:
            _as_strips(owner.animation_data, times, slower, scene)
    for curve in () if strips else _curves():
        _repeat(curve, times, slower, scene.frame_start)
    scene.render.fps, scene.render.fps_base = FPS, 1.0
    scene.frame_end = scene.frame_start + FPS * seconds
    scene.frame_set(scene.frame_start)
    return scene


def _as_strips(animation: Any, times: int, slower: float, scene: Any) -> None:
    action, slot = animation.action, getattr(animation, "action_slot", None)
    animation.action = None
    track = animation.nla_tracks.new()
    for number in range(times):
        start = scene.frame_start + number * EVERY_S * FPS
        strip = track.strips.new(action.name, start, action)
        if slot is not None:
            strip.action_slot = slot
        strip.action_frame_start, strip.action_frame_end = scene.frame_start, scene.frame_end
        strip.scale, strip.frame_start = slower, start


def _curves() -> Iterator[Any]:
    """Those of all actions that play, each once."""
    seen = set()
    for owner in all_animated():
        animation = owner.animation_data
        for curve in action_curves(animation.action, getattr(animation, "action_slot", None)):
            if curve.as_pointer() not in seen and len(curve.keyframe_points):
                seen.add(curve.as_pointer())
                yield curve


def _repeat(curve: Any, times: int, slower: float, start: int) -> None:
    """The keys again and again, with what they begin with held until the next time."""
    points = curve.keyframe_points
    count = len(points)
    moved = np.arange(times) * EVERY_S * FPS
    kinds = np.empty(count, np.int32)
    points.foreach_get("interpolation", kinds)
    kinds[-1] = 0
    placed = {}
    for name in ("co", "handle_left", "handle_right"):
        values = np.empty((count, 2), np.float32)
        points.foreach_get(name, values.ravel())
        values[:, 0] = start + (values[:, 0] - start) * slower
        placed[name] = np.tile(values, (times, 1))
        placed[name][:, 0] += np.repeat(moved, count)
    points.add(count * (times - 1))
    for name, values in placed.items():
        points.foreach_set(name, values.ravel())
    points.foreach_set("interpolation", np.tile(kinds, times))
    # Else Blender would place their handles anew.
    for name in ("handle_left_type", "handle_right_type"):
        points.foreach_set(name, np.full(count * times, FREE, np.int32))
