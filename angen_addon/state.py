# SPDX-License-Identifier: GPL-3.0-or-later
"""What the add-on keeps in memory between calls: one object, emptied by undo and file load."""

from __future__ import annotations

import weakref
from typing import Any, Protocol

from ..sensor_logic.recording import Recording


class Watching(Protocol):
    """What is told of each evaluation; `edited`: not by a change of frame."""

    def note(self, depsgraph: Any, edited: bool) -> None: ...


class Cache:
    """`recording`: the last run, by the scene's session uid; `running` while a run drives the
    frames, so that handlers keep still; `live` is what follows the playhead without a recording;
    `visible`: session uids of what the viewport showed when last looked, while a recording is kept;
    `shown_at` when a frame was last shown, by the clock of `time.monotonic`.
    """

    def __init__(self) -> None:
        self.running = False
        self.live: Any = None
        self.visible: list[int] = []
        self.shown_at = 0.0
        self._recordings: dict[int, Recording] = {}
        self._watching: weakref.WeakSet[Watching] = weakref.WeakSet()

    def watch(self, probe: Watching) -> None:
        """From now on `probe` is told what changes, for as long as it lives."""
        self._watching.add(probe)

    def note(self, depsgraph: Any, edited: bool) -> None:
        for probe in self._watching:
            probe.note(depsgraph, edited)

    def recording(self, scene: Any) -> Recording | None:
        return self._recordings.get(scene.session_uid)

    def keep_recording(self, scene: Any, recording: Recording) -> None:
        self._recordings[scene.session_uid] = recording

    def drop_recording(self, scene: Any) -> None:
        self._recordings.pop(scene.session_uid, None)

    def settings_changed(self) -> None:
        """A recording made with other settings would be a lie."""
        if not self.running:
            self._recordings.clear()
            self._outdate_live()

    def scene_edited(self, scene: Any) -> None:
        """The same for a scene in which something was moved, reshaped, added, hidden or keyed."""
        if not self.running:
            self.drop_recording(scene)
            self._outdate_live()

    def _outdate_live(self) -> None:
        if self.live is not None:
            self.live.outdated = True

    def clear(self) -> None:
        """Forgets all that refers to the file's data, which undo and load make anew."""
        self.running = False
        self.live = None
        self._recordings.clear()
        self._watching = weakref.WeakSet()


CACHE = Cache()
