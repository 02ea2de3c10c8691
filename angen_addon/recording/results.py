# SPDX-License-Identifier: GPL-3.0-or-later
"""The recordings and other results of the scenes of the file, which edits can make stale.

Undo does not remove recordings, but can change whether a recording is stale.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from ...sensor_logic.recording.tracks import Recording
from ..scene import memory
from .followed_map import FollowedMap, FollowedResult
from .followed_scene import FollowedScene
from .stored_recording import StoredRecording

# Recordings of a scene that are kept for undo and redo. At least two are kept, and further ones up
# to this number and this size.
UNDONE, UNDONE_BYTES = 4, 1 << 28
# The number that a scene stores in place of its recording's mark, once the recording was cleared.
CLEARED = -1
# The results other than recordings that edits can make stale. Residents add theirs.
FOLLOWED: list[type[FollowedResult]] = [FollowedMap]


class SceneResults:
    """The recordings and other results of the scenes of the file.

    Attributes
    ----------
    notice
        A notice to the user about a recording in the file; empty if there is none.
    """

    def __init__(self) -> None:
        self.notice = ""
        # The recordings by the session uid of their scene, and by their mark.
        self._kept: dict[int, dict[int, StoredRecording]] = {}
        # Results other than recordings, by the session uid of their scene and by their class.
        self._results: dict[tuple[int, type[FollowedResult]], FollowedResult] = {}

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

    def check(self, owner: Any) -> None:
        """Compare one original datablock with the fingerprints of all recordings and results."""
        for _, kept in self._all_followed():
            kept.check(owner)

    def add_notice(self, text: str) -> None:
        """Add a sentence to the notice to the user."""
        self.notice = ". ".join(filter(None, (self.notice, text)))

    def doubt(self) -> None:
        """Mark all recordings and results as unsure, because undo or redo will change the scene."""
        for _, kept in self._all_followed():
            kept.unsure = True

    def clear(self) -> None:
        """Forget all recordings and results, because another file opens."""
        self._kept.clear()
        self._results.clear()
        self.notice = ""


def _bytes_of(recordings: Iterable[StoredRecording]) -> int:
    return sum(t.nbytes for kept in recordings for t in kept.recording.tracks.values())


RESULTS = SceneResults()
memory.forgets_at_undo(RESULTS.doubt)
memory.forgets_at_load(RESULTS.clear)
