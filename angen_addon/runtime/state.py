# SPDX-License-Identifier: GPL-3.0-or-later
"""What the add-on keeps in memory between calls: one object, emptied by file load. Recordings
outlive undo, as long as the scene is, or is again, the one that they were made of. And the outputs
`active` and `value`, which panels show and drivers read.
"""

from __future__ import annotations

import weakref
from collections.abc import Iterable, Iterator
from typing import Any, Protocol

import bpy

from ...sensor_logic.recording.tracks import Recording
from ..recording.followed_map import FollowedMap
from ..recording.references import LightReferences
from ..recording.stored_recording import StoredRecording
from ..scene.animation import all_animated, curves
from ..scene.sensors import Sensor, all_sensors

# The outputs `active` and `value` of a sensor, which panels show and drivers read.

ACTIVE_PATH = "angen_sensor.active"
VALUE_PATH = "angen_sensor.value"


def show(sensor: Sensor, active: bool, value: float) -> bool:
    """Writes the outputs where they differ, so that drivers see them; True if `active` changed.

    Keyed outputs are left alone: their keys say what they are; so are those of sensors in
    collection instances, which have one object between them. In a frame change Blender
    evaluates what is tagged here before it goes on, and tells nobody. A rigid body is never tagged,
    so that its drivers do not follow: Blender would take it for moved and drop the simulation.
    """
    settings = sensor.settings
    changed = settings.active != active
    if not changed and abs(settings.value - value) <= 1e-6 * max(1.0, abs(value)):
        return False
    if sensor.holders or output_curves(sensor.object):
        return False
    settings.active = active
    settings.value = value
    if sensor.object.rigid_body is None:
        sensor.object.update_tag(refresh={"OBJECT"})
    return changed


def show_recorded(recording: Recording, sensors: Iterable[Sensor], frame: float) -> None:
    """Shows what was recorded at or before `frame`."""
    tracks = {track.uid: track for track in recording.tracks.values()}
    for sensor in sensors:
        track = tracks.get(sensor.uid)
        index = track.at(frame) if track else None
        if track is not None and index is not None:
            show(sensor, bool(track.active[index]), track.value[index])


def output_curves(obj: Any) -> list[Any]:
    """The F-curves that set the outputs."""
    return curves(obj, {ACTIVE_PATH, VALUE_PATH})


def are_driven(*paths: str) -> bool:
    """Whether any driver of the file reads outputs, or what else of sensors begins with these data
    paths."""
    starts = paths or (ACTIVE_PATH, VALUE_PATH)
    return any(target.data_path.startswith(starts) for target in _driver_targets())


def read_by_drivers(sensors: Iterable[Sensor]) -> list[Sensor]:
    """Those of the sensors whose outputs a driver of the file reads: the scene depends on them."""
    read = {
        target.id.session_uid
        for target in _driver_targets()
        if target.id is not None and target.data_path.startswith((ACTIVE_PATH, VALUE_PATH))
    }
    return [s for s in sensors if not s.holders and s.object.session_uid in read]


def _driver_targets() -> Iterator[Any]:
    for animated in all_animated():
        for curve in animated.animation_data.drivers:
            for variable in curve.driver.variables:
                yield from variable.targets


# So many recordings of a scene are kept for undo and redo, or fewer of more bytes, but two.
UNDONE, UNDONE_BYTES = 4, 1 << 28
# In place of a recording's mark.
CLEARED = -1


class Watching(Protocol):
    """What is told of each evaluation; `edited`: not by a change of frame."""

    def note(self, depsgraph: Any, edited: bool, by_frame: bool) -> None: ...


class Cache:
    """The last runs of each scene, by its session uid and their marks: the scene has the mark of
    the one that counts, so that undo and redo choose it; `running` while a run drives the frames,
    so that handlers keep still, `publishing` while what reads its outputs is evaluated; `working`
    what a long operator shows: its identifier, the share that is done, and in two lines of words;
    `references` of the light, for the next run; `live` is what follows the playhead without a
    recording; `shown_at` when a frame was last shown, by the clock of `time.monotonic`; `notice`
    what the user should know of a recording that a file had; `overlay` what the viewport draws of
    the sensors; `lacks` what the file needs and does not have here; `findings` what the doctor
    found, None before it was asked; `places` what was said of the places of residents, in short and
    line by line, and `arrows` what was last drawn of them.
    """

    def __init__(self) -> None:
        self.running = self.publishing = False
        self.working: tuple[str, float, str] | None = None
        self.live: Any = None
        self.shown_at = 0.0
        self.notice = ""
        self.lacks: list[str] = []
        self.overlay: Any = None
        self.findings: tuple[Any, ...] | None = None
        self.places: tuple[str, tuple[str, ...]] | None = None
        self.arrows: Any = None
        # How often the scene was changed by anything but the playhead.
        self._revision = 0
        # The sensors as they were found last: of which view layer, at which revision.
        self._sensors: tuple[Any, list[Sensor]] = (None, [])
        # Whether drivers read outputs, as of which revision.
        self._driven = -1, False
        self._kept: dict[int, dict[int, StoredRecording]] = {}
        # What is known of the coverage map of a scene, by its session uid.
        self._maps: dict[int, FollowedMap] = {}
        self._watching: weakref.WeakSet[Watching] = weakref.WeakSet()
        self.references = LightReferences()

    @property
    def revision(self) -> int:
        """Grows with each change of the scene by anything but the playhead."""
        return self._revision

    def watch(self, probe: Watching) -> None:
        """From now on `probe` is told what changes, for as long as it lives."""
        self._watching.add(probe)

    def note(self, depsgraph: Any, edited: bool, by_frame: bool = False) -> None:
        """To be called at each evaluation. A script may change the scene just before it moves the
        playhead: that tells of it too."""
        if edited or depsgraph.id_type_updated("SCENE") or depsgraph.id_type_updated("COLLECTION"):
            self._revision += 1
        for probe in self._watching:
            probe.note(depsgraph, edited, by_frame)

    def sensors(self, view_layer: Any) -> list[Sensor]:
        """All sensors, listed once for each revision of the scene. For handlers and drawing, before
        which Blender tells of edits; else there is `all_sensors`."""
        return self.sensors_now(view_layer)[0]

    def sensors_now(self, view_layer: Any) -> tuple[list[Sensor], int]:
        """The same, and the revision."""
        layer = view_layer.id_data.session_uid, view_layer.name
        known, sensors = self._sensors
        if known == (self._revision, *layer) and not _have_their_names(sensors):
            # Blender tells nobody of new names.
            self._revision += 1
        if known != (self._revision, *layer):
            sensors = all_sensors(view_layer)
            self._sensors = (self._revision, *layer), sensors
        return sensors, self._revision

    def outputs_are_driven(self) -> bool:
        """Whether drivers read what sensors put out: all animation of the file is gone through, so
        that is done once an edit."""
        if self._driven[0] != self._revision:
            self._driven = self._revision, are_driven()
        return self._driven[1]

    def recording(self, scene: Any) -> Recording | None:
        """The last run, if the scene is as it was then."""
        kept = self.kept(scene)
        return kept.recording if kept is not None and not kept.stale else None

    def kept(self, scene: Any) -> StoredRecording | None:
        """The last run, stale or not, unless it was cleared."""
        return self._of_mark(scene.session_uid, scene.angen_recording)

    def _of_mark(self, uid: int, mark: int) -> StoredRecording | None:
        """The recording of this mark, or the first one: undo of the first run loses nothing."""
        made = self._kept.get(uid, {})
        return None if mark == CLEARED else made.get(mark) or next(iter(made.values()), None)

    def coverage_map(self, scene: Any) -> FollowedMap | None:
        """What has changed since the scene's coverage map was made; None without a map."""
        text = FollowedMap.text_in(scene)
        if not text:
            return None
        found = self._maps.get(scene.session_uid)
        if found is None or found.stored != text:
            # Another map: undo, a new file, or a proposal that was discarded.
            found = self._maps[scene.session_uid] = FollowedMap.read(text)
        return found

    def note_map(self, scene: Any, depsgraph: Any) -> None:
        """From now on the scene's coverage map is one of the scene as it is now."""
        self._maps[scene.session_uid] = FollowedMap.note(scene, depsgraph)

    def followed(self, scene: Any) -> list[StoredRecording]:
        """What becomes stale where the scene changes: the last run, and the coverage map."""
        return [found for found in (self.kept(scene), self.coverage_map(scene)) if found]

    def _all_followed(self) -> list[tuple[int, StoredRecording]]:
        runs = ((uid, kept) for uid, made in self._kept.items() for kept in made.values())
        return [*runs, *self._maps.items()]

    def keep(self, scene: Any, kept: StoredRecording) -> None:
        """From now on this is the last run; undo brings the former one back."""
        made = self._kept.setdefault(scene.session_uid, {})
        made[kept.mark] = kept
        while len(made) > UNDONE or (len(made) > 2 and _bytes_of(made.values()) > UNDONE_BYTES):
            made.pop(next(iter(made)))
        if scene.angen_recording != kept.mark:
            scene.angen_recording = kept.mark
        self.notice = ""

    def keep_alone(self, scene: Any, kept: StoredRecording) -> None:
        """The same where nobody can undo."""
        self._kept.pop(scene.session_uid, None)
        self.keep(scene, kept)

    def clear_recording(self, scene: Any) -> None:
        """Forgets the last run, until undo takes back what is noted in the scene."""
        scene.angen_recording = CLEARED
        self.notice = ""

    def all_kept(self) -> dict[int, StoredRecording]:
        """Those that were not cleared, by the session uid of the scene."""
        found = {scene.session_uid: self.kept(scene) for scene in bpy.data.scenes}
        return {uid: kept for uid, kept in found.items() if kept is not None}

    def note_elsewhere(self, scene: Any, depsgraph: Any) -> None:
        """What other scenes share with this one: Blender does not tell of it once they are shown
        again."""
        for uid, kept in self._all_followed():
            if uid != scene.session_uid:
                kept.note_elsewhere(depsgraph)

    def settings_changed(self, owner: Any) -> None:
        """A recording made with other settings of `owner`, an object or scene, would be a lie."""
        self._revision += 1
        if not self.running:
            for _, kept in self._all_followed():
                kept.check(owner)
            self.outdate_live()

    def outdate_live(self) -> None:
        if self.live is not None:
            self.live.outdated = True

    def forget_references(self) -> None:
        """Undo and redo make the file's data anew: whatever refers to the old is void."""
        self.running = False
        self.live = None
        self.overlay = self.arrows = None
        self._revision += 1
        self._sensors = None, []
        self._watching = weakref.WeakSet()
        for _, kept in self._all_followed():
            kept.unsure = True

    def clear(self) -> None:
        """Another file takes the place of this one."""
        self.forget_references()
        self._kept.clear()
        self._maps.clear()
        self.references = LightReferences()
        self.lacks = []
        self.notice = ""
        self.findings = self.places = None


def _bytes_of(recordings: Iterable[StoredRecording]) -> int:
    return sum(t.nbytes for kept in recordings for t in kept.recording.tracks.values())


def _have_their_names(sensors: list[Sensor]) -> bool:
    """Whether all of them still exist, under their names."""
    try:
        return all(sensor.name_now == sensor.name for sensor in sensors)
    except ReferenceError:
        return False


CACHE = Cache()
