# SPDX-License-Identifier: GPL-3.0-or-later
"""Skip the frames in which nothing moves while a shown part of a day is played back."""

from __future__ import annotations

import json
from typing import Any

import bpy
from bpy.app.handlers import persistent

from ...angen_addon.runtime import handlers
from ...angen_addon.runtime.running import is_running
from ..acting.timeline import Acted
from ..days.rows import frame_at

# s: a rest is played for AROUND_S at its start and end; rests shorter than LEAST_S are not skipped.
AROUND_S = 1.0
LEAST_S = 4.0
# The previous frame, which shows the direction of playback.
_last = 0


def rests(acted: Acted, first: float, last: float) -> str:
    """Return the frame ranges in a part of a day during which nothing moves, as JSON.

    `acted` has all movements of the day. The part lasts from `first` to `last`, in s since
    midnight. The result is a list of pairs of a first and a last frame.
    """
    found, since = [], first
    for start, end in [*acted.spans(first, last).tolist(), (last, last)]:
        if start - since >= LEAST_S:
            found.append((frame_at(since + AROUND_S), frame_at(start - AROUND_S)))
        since = max(since, end)
    return json.dumps(found)


def playback_frame(scene: Any, frame: int, back: bool) -> int:
    """Return the frame at which playback goes on when it reaches `frame`.

    In a range of frames without movement, this is the end of the range. If `back` is True, playback
    runs backwards, and this is the start.
    """
    settings = scene.angen_day
    if not settings.before or not settings.skip or not settings.rests:
        return frame
    for begin, end in json.loads(settings.rests):
        if begin < frame < end:
            return max(begin, scene.frame_start) if back else min(end, scene.frame_end)
    return frame


def _jump(scene: Any, _depsgraph: Any = None) -> None:
    """Skip a range without movement, before Blender evaluates the frame."""
    global _last
    frame, before = scene.frame_current, _last
    _last = frame
    if scene.angen_day.before and not is_running():
        there = playback_frame(scene, frame, back=frame == before - 1)
        if there != frame:
            scene.frame_current = _last = there


# A run needs no such handler: it is registered only during playback.
@persistent  # type: ignore[untyped-decorator]
def play(*_: Any) -> None:
    stop()
    bpy.app.handlers.frame_change_pre.append(_jump)


@persistent  # type: ignore[untyped-decorator]
def stop(*_: Any) -> None:
    if _jump in bpy.app.handlers.frame_change_pre:
        bpy.app.handlers.frame_change_pre.remove(_jump)


def register() -> None:
    handlers.frame_handlers.add(_jump)
    bpy.app.handlers.animation_playback_pre.append(play)
    bpy.app.handlers.animation_playback_post.append(stop)


def unregister() -> None:
    handlers.frame_handlers.discard(_jump)
    bpy.app.handlers.animation_playback_pre.remove(play)
    bpy.app.handlers.animation_playback_post.remove(stop)
    stop()
