# SPDX-License-Identifier: GPL-3.0-or-later
"""The state of the add-on in memory (`CACHE`).

The cache is emptied when a file is loaded. Undo does not remove recordings, but can change whether
a recording is stale.
"""

from __future__ import annotations

import weakref
from collections.abc import Iterable
from typing import Any, Protocol

from ...sensor_logic.recording.tracks import Recording
from ..recording.followed_map import FollowedMap, FollowedResult
from ..recording.followed_scene import FollowedScene
from ..recording.stored_recording import StoredRecording
from ..scene import memory
from ..scene.outputs import are_driven
from ..scene.sensors import Sensor, all_sensors

# Recordings of a scene that are kept for undo and redo. At least two are kept, and further ones up
# to this number and this size.
UNDONE, UNDONE_BYTES = 4, 1 << 28
# The number that a scene stores in place of its recording's mark, once the recording was cleared.
CLEARED = -1
# The results other than recordings that edits can make stale. Residents add theirs.
FOLLOWED: list[type[FollowedResult]] = [FollowedMap]


class Listener(Protocol):
    """An object whose method `note` is called at each evaluation of the scene.

    `edited` is false if only the frame has changed. `by_frame` says whether a change of frame
    caused the evaluation.
    """

    def note(self, depsgraph: Any, edited: bool, by_frame: bool) -> None: ...


class Cache:
    """The state of the add-on in memory.

    Attributes
    ----------
    notice
        A notice to the user about a recording in the file.
    """

    def __init__(self) -> None:
        self.notice = ""
        # See `revision`.
        self._revision = 0
        # The listed sensors, with the view layer and the revision of the list.
        self._sensors: tuple[Any, list[Sensor]] = (None, [])
        # The revision of the look-up, and whether drivers read outputs.
        self._driven = -1, False
        self._kept: dict[int, dict[int, StoredRecording]] = {}
        # Results other than recordings, by the session uid of their scene and by their class.
        self._results: dict[tuple[int, type[FollowedResult]], FollowedResult] = {}
        self._listeners: weakref.WeakSet[Listener] = weakref.WeakSet()

    @property
    def revision(self) -> int:
        """A number that grows with each edit of the scene; a change of frame is no edit."""
        return self._revision

    def watch(self, probe: Listener) -> None:
        """Call `probe.note` at each evaluation from now on, until `probe` is garbage-collected."""
        self._listeners.add(probe)

    def note(self, depsgraph: Any, edited: bool, by_frame: bool = False) -> None:
        """Notify all listeners; call this method at each evaluation.

        `edited` is false if only the frame has changed. `by_frame` says whether a change of frame
        caused the evaluation. A script may change the scene just before it moves the playhead:
        Blender reports this edit with the change of frame, and it counts as an edit.
        """
        if edited or depsgraph.id_type_updated("SCENE") or depsgraph.id_type_updated("COLLECTION"):
            self._revision += 1
        for probe in self._listeners:
            probe.note(depsgraph, edited, by_frame)

    def sensors(self, view_layer: Any) -> list[Sensor]:
        """Return all sensors of a view layer; list them anew only after an edit of the scene.

        Call this method only in handlers and while drawing, when Blender has reported all edits.
        Elsewhere call `all_sensors`.
        """
        return self.sensors_and_revision(view_layer)[0]

    def sensors_and_revision(self, view_layer: Any) -> tuple[list[Sensor], int]:
        """Return all sensors of a view layer as `sensors` does, and the revision of the scene."""
        layer = view_layer.id_data.session_uid, view_layer.name
        known, sensors = self._sensors
        if known == (self._revision, *layer) and not _have_their_names(sensors):
            # Blender does not report new names.
            self._revision += 1
        if known != (self._revision, *layer):
            sensors = all_sensors(view_layer)
            self._sensors = (self._revision, *layer), sensors
        return sensors, self._revision

    def outputs_are_driven(self) -> bool:
        """Return whether any driver reads an output; look anew only after an edit of the scene."""
        if self._driven[0] != self._revision:
            self._driven = self._revision, are_driven()
        return self._driven[1]

    def recording(self, scene: Any) -> Recording | None:
        """Return the last recording of a scene; None if it is stale or there is none."""
        kept = self.kept(scene)
        return kept.recording if kept is not None and not kept.stale else None

    def kept(self, scene: Any) -> StoredRecording | None:
        """Return the last recording of a scene, even if it is stale; None if there is none."""
        made, mark = self._kept.get(scene.session_uid, {}), scene.angen_recording
        if mark == CLEARED or mark in made:
            return made.get(mark)
        # A recording is kept if undo has removed its mark from the scene: return the oldest.
        aside = scene.angen_recording_aside
        return next((kept for mark, kept in made.items() if mark != aside), None)

    def kept_aside(self, scene: Any) -> StoredRecording | None:
        """Return the recording that `set_aside` has put away; None if there is none."""
        return self._kept.get(scene.session_uid, {}).get(scene.angen_recording_aside)

    def set_aside(self, scene: Any) -> None:
        """Put the scene's recording away until `take_back`, because the scene shows another time.

        Meanwhile the scene can have other recordings. They do not push this one out.
        """
        kept = self.kept(scene)
        if kept is not None:
            kept.stale_then = kept.stale
        scene.angen_recording_aside = CLEARED if kept is None else kept.mark
        scene.angen_recording = CLEARED

    def take_back(self, scene: Any) -> None:
        """Make the recording that was put away the scene's last recording again."""
        scene.angen_recording, scene.angen_recording_aside = scene.angen_recording_aside, 0
        kept = self.kept(scene)
        if kept is not None:
            kept.unsure = True

    def result(self, scene: Any, kind: type[FollowedResult]) -> FollowedResult | None:
        """Return the fingerprint of the scene that a result shows; None without such a result."""
        text = kind.stored_text(scene)
        if not text:
            return None
        found = self._results.get((scene.session_uid, kind))
        if found is None or found.stored != text:
            # Another result: undo, a new file, or a proposal that was discarded.
            found = self._results[scene.session_uid, kind] = kind.read(text)
        return found

    def note_result(self, scene: Any, depsgraph: Any, kind: type[FollowedResult]) -> None:
        """Remember that a result was computed from the scene as it is now.

        For this, store a fingerprint of the scene: later edits are compared with it.
        """
        self._results[scene.session_uid, kind] = kind.note(scene, depsgraph)

    def followed(self, scene: Any) -> list[FollowedScene]:
        """Return the last recording and the results of a scene, which edits can make stale."""
        results = (self.result(scene, kind) for kind in FOLLOWED)
        return [found for found in (self.kept(scene), *results) if found]

    def _all_followed(self) -> list[tuple[int, FollowedScene]]:
        """Return all recordings and other results, each with the session uid of its scene."""
        runs = ((uid, kept) for uid, made in self._kept.items() for kept in made.values())
        return [*runs, *((uid, found) for (uid, _), found in self._results.items())]

    def keep(self, scene: Any, kept: StoredRecording) -> None:
        """Make `kept` the last recording of a scene; undo restores the former one."""
        made = self._kept.setdefault(scene.session_uid, {})
        made[kept.mark] = kept
        while len(made) > UNDONE or (len(made) > 2 and _bytes_of(made.values()) > UNDONE_BYTES):
            aside = scene.angen_recording_aside
            made.pop(next(mark for mark in made if mark != aside))
        if scene.angen_recording != kept.mark:
            scene.angen_recording = kept.mark
        self.notice = ""

    def keep_from_file(self, scene: Any, kept: StoredRecording, is_aside: bool) -> None:
        """Keep a recording of the scene's file, put away if `is_aside`; the scene has its mark."""
        mark = scene.angen_recording_aside if is_aside else scene.angen_recording
        if mark > 0:
            kept.mark = mark
        if not is_aside:
            self.keep(scene, kept)
        elif mark > 0:
            self._kept.setdefault(scene.session_uid, {})[mark] = kept

    def keep_alone(self, scene: Any, kept: StoredRecording) -> None:
        """Make `kept` the only recording of a scene, apart from one that is put away.

        Call this method only where no undo can follow.
        """
        aside = self.kept_aside(scene)
        self._kept[scene.session_uid] = {aside.mark: aside} if aside is not None else {}
        self.keep(scene, kept)

    def clear_recording(self, scene: Any) -> None:
        """Clear the recording of a scene; undo restores it."""
        scene.angen_recording = CLEARED
        self.notice = ""

    def note_other_scene(self, scene: Any, depsgraph: Any) -> None:
        """Pass an update in `scene` to the recordings of other scenes, which may share its data.

        Blender reports such an update only once, even if another scene is shown later.
        """
        for uid, kept in self._all_followed():
            if uid != scene.session_uid:
                kept.note_other_scene(depsgraph)

    def count_edit(self) -> None:
        """Count an edit that Blender does not report."""
        self._revision += 1

    def check(self, owner: Any) -> None:
        """Compare one original datablock with the fingerprints of all recordings and results."""
        for _, kept in self._all_followed():
            kept.check(owner)

    def forget_references(self) -> None:
        """Remove all references to Blender's data, because undo or redo will replace that data."""
        self._revision += 1
        self._sensors = None, []
        self._listeners = weakref.WeakSet()
        for _, kept in self._all_followed():
            kept.unsure = True

    def clear(self) -> None:
        """Empty the cache, because another file opens."""
        self._kept.clear()
        self._results.clear()
        self.notice = ""


def _bytes_of(recordings: Iterable[StoredRecording]) -> int:
    return sum(t.nbytes for kept in recordings for t in kept.recording.tracks.values())


def _have_their_names(sensors: list[Sensor]) -> bool:
    """Return whether all sensors still exist and have the names under which they were listed."""
    try:
        return all(sensor.name_now == sensor.name for sensor in sensors)
    except ReferenceError:
        return False


CACHE = Cache()
memory.forgets_at_undo(CACHE.forget_references)
memory.forgets_at_load(CACHE.clear)
