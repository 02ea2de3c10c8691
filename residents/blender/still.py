# SPDX-License-Identifier: GPL-3.0-or-later
"""Playback of a shown stretch jumps over the frames in which nothing moves."""

from __future__ import annotations

import json
from typing import Any

import bpy
from bpy.app.handlers import persistent

from ...angen_addon.runtime import state
from ..acting.timeline import Acted
from ..days.rows import frame_at

# s: so much of a rest is played before and after; a shorter one is played whole.
AROUND_S = 1.0
LEAST_S = 4.0
# The frame before the present one, by which playback's direction shows.
_last = 0


def rests(acted: Acted, first: float, last: float) -> str:
    """The frames from `first` to `last` (s of the day) in which nothing moves: from and to, as the
    scene keeps them."""
    found, since = [], first
    for start, end in [*acted.spans(first, last).tolist(), (last, last)]:
        if start - since >= LEAST_S:
            found.append((frame_at(since + AROUND_S), frame_at(start - AROUND_S)))
        since = max(since, end)
    return json.dumps(found)


def beyond(scene: Any, frame: int, back: bool) -> int:
    """The frame at which playback goes on from a frame."""
    settings = scene.angen_day
    if not settings.before or not settings.skip or not settings.rests:
        return frame
    for begin, end in json.loads(settings.rests):
        if begin < frame < end:
            return max(begin, scene.frame_start) if back else min(end, scene.frame_end)
    return frame


def _jump(scene: Any, _depsgraph: Any = None) -> None:
    """Before Blender evaluates the frame: it then evaluates the one that is jumped to."""
    global _last
    frame, before = scene.frame_current, _last
    _last = frame
    if scene.angen_day.before and not state.CACHE.running:
        there = beyond(scene, frame, back=frame == before - 1)
        if there != frame:
            scene.frame_current = _last = there


# A handler of frames makes every run slow (runtime/handlers.py): it is there only while Blender
# plays.
@persistent  # type: ignore[untyped-decorator]
def play(*_: Any) -> None:
    stop()
    bpy.app.handlers.frame_change_pre.append(_jump)


@persistent  # type: ignore[untyped-decorator]
def stop(*_: Any) -> None:
    if _jump in bpy.app.handlers.frame_change_pre:
        bpy.app.handlers.frame_change_pre.remove(_jump)


def register() -> None:
    bpy.app.handlers.animation_playback_pre.append(play)
    bpy.app.handlers.animation_playback_post.append(stop)


def unregister() -> None:
    bpy.app.handlers.animation_playback_pre.remove(play)
    bpy.app.handlers.animation_playback_post.remove(stop)
    stop()
