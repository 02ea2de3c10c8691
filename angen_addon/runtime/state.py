# SPDX-License-Identifier: GPL-3.0-or-later
"""The state of the add-on in memory (`CACHE`), and the outputs `active` and `value` of sensors.

The cache is emptied when a file is loaded. Undo does not remove recordings, but it can make a
recording stale, or fresh again. Panels show the outputs, and drivers read them.
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
    """Write new outputs to a sensor if they differ; return whether `active` changed.

    Outputs with keyframes are not written. Nor are those of a sensor in a collection instance,
    because all instances share one object.

    The object is tagged, so that Blender evaluates drivers that read the outputs. During a frame
    change this happens before the change ends, and Blender reports no update. The object of a
    rigid body is not tagged: Blender would discard the cached simulation, as for an object that was
    moved. Drivers then do not see its new outputs.
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
    """Write the outputs that the sensors have at `frame` in the recording.

    These are the last ones recorded at or before the frame.
    """
    tracks = {track.uid: track for track in recording.tracks.values()}
    for sensor in sensors:
        track = tracks.get(sensor.uid)
        index = track.at(frame) if track else None
        if track is not None and index is not None:
            show(sensor, bool(track.active[index]), track.value[index])


def output_curves(obj: Any) -> list[Any]:
    """Return the F-curves of an object that animate its outputs."""
    return curves(obj, {ACTIVE_PATH, VALUE_PATH})


def are_driven(*paths: str) -> bool:
    """Whether any driver of the file reads an output of a sensor.

    With `paths`, look instead for drivers that read a data path beginning with one of these.
    """
    starts = paths or (ACTIVE_PATH, VALUE_PATH)
    return any(target.data_path.startswith(starts) for target in _driver_targets())


def read_by_drivers(sensors: Iterable[Sensor]) -> list[Sensor]:
    """Return those of the sensors whose outputs are read by a driver of the file."""
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


# Recordings of a scene that are kept for undo and redo. At least two are kept, and further ones up
# to this number and this size.
UNDONE, UNDONE_BYTES = 4, 1 << 28
# The number that a scene stores in place of its recording's mark, once the recording was cleared.
CLEARED = -1


class Listener(Protocol):
    """An object that is notified of each evaluation of the scene.

    `edited` is false if only the frame has changed. `by_frame` says that a change of frame caused
    the evaluation.
    """

    def note(self, depsgraph: Any, edited: bool, by_frame: bool) -> None: ...


class Cache:
    """The state of the add-on in memory.

    Attributes
    ----------
    running
        Whether a run changes the frame at the moment. Handlers do nothing meanwhile.
    publishing
        Whether the run evaluates the drivers that read outputs, at the moment.
    working
        The progress of a long operator: its identifier, the part done from 0 to 1, and a text of
        two lines. None while no such operator runs.
    live
        The live sensors, which sense at the playhead where there is no recording.
    shown_at
        When a frame was last shown, by `time.monotonic`.
    notice
        A notice to the user on a recording in the file.
    lacks
        Texts on what the file needs but this computer does not have, such as missing files.
    overlay
        The drawing of the sensors in the viewport.
    findings
        The findings of the doctor; None before its first run.
    places
        The findings on the places of residents, as a summary and as lines.
    arrows
        The drawing of the places of residents in the viewport.
    references
        The light references, for the next run.
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
        # See `revision`.
        self._revision = 0
        # The listed sensors, with the view layer and the revision of the list.
        self._sensors: tuple[Any, list[Sensor]] = (None, [])
        # The revision of the look-up, and whether drivers read outputs.
        self._driven = -1, False
        self._kept: dict[int, dict[int, StoredRecording]] = {}
        # Marks of recordings that later runs do not push out: of the home, while a day is shown.
        self.pinned: set[int] = set()
        # The coverage maps, by the session uid of their scenes.
        self._maps: dict[int, FollowedMap] = {}
        self._listeners: weakref.WeakSet[Listener] = weakref.WeakSet()
        self.references = LightReferences()

    @property
    def revision(self) -> int:
        """A number that grows with each edit of the scene; a change of frame is no edit."""
        return self._revision

    def watch(self, probe: Listener) -> None:
        """Notify `probe` of each evaluation from now on, until the probe is garbage-collected."""
        self._listeners.add(probe)

    def note(self, depsgraph: Any, edited: bool, by_frame: bool = False) -> None:
        """Notify all listeners; call this method at each evaluation.

        A script may change the scene just before it moves the playhead. Such an edit is reported
        with the change of frame, and counts too.
        """
        if edited or depsgraph.id_type_updated("SCENE") or depsgraph.id_type_updated("COLLECTION"):
            self._revision += 1
        for probe in self._listeners:
            probe.note(depsgraph, edited, by_frame)

    def sensors(self, view_layer: Any) -> list[Sensor]:
        """Return all sensors of a view layer, from a list made once for each revision of the scene.

        Call this method only in handlers and while drawing: Blender has reported all edits by then.
        Elsewhere call `all_sensors`.
        """
        return self.sensors_and_revision(view_layer)[0]

    def sensors_and_revision(self, view_layer: Any) -> tuple[list[Sensor], int]:
        """Return what `sensors` returns, and the revision of the scene."""
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
        """Whether any driver reads an output, looked up once for each revision of the scene."""
        if self._driven[0] != self._revision:
            self._driven = self._revision, are_driven()
        return self._driven[1]

    def recording(self, scene: Any) -> Recording | None:
        """Return the last recording of a scene if it is fresh, else None."""
        kept = self.kept(scene)
        return kept.recording if kept is not None and not kept.stale else None

    def kept(self, scene: Any) -> StoredRecording | None:
        """Return the last recording of a scene, stale or not; None if it was cleared."""
        return self._recording_of_mark(scene.session_uid, scene.angen_recording)

    def _recording_of_mark(self, uid: int, mark: int) -> StoredRecording | None:
        """Return the recording with this mark, of the scene with the session uid `uid`.

        If none has the mark, return the oldest one. Return None if the recording was cleared.
        """
        made = self._kept.get(uid, {})
        return None if mark == CLEARED else made.get(mark) or next(iter(made.values()), None)

    def coverage_map(self, scene: Any) -> FollowedMap | None:
        """Return the fingerprint of the scene that the coverage map shows; None without a map."""
        text = FollowedMap.stored_text(scene)
        if not text:
            return None
        found = self._maps.get(scene.session_uid)
        if found is None or found.stored != text:
            # Another map: undo, a new file, or a proposal that was discarded.
            found = self._maps[scene.session_uid] = FollowedMap.read(text)
        return found

    def note_map(self, scene: Any, depsgraph: Any) -> None:
        """Note that the coverage map of a scene was made from the present scene."""
        self._maps[scene.session_uid] = FollowedMap.note(scene, depsgraph)

    def followed(self, scene: Any) -> list[StoredRecording]:
        """Return what edits of a scene can make stale: its last recording and its coverage map."""
        return [found for found in (self.kept(scene), self.coverage_map(scene)) if found]

    def _all_followed(self) -> list[tuple[int, StoredRecording]]:
        """Return all recordings and coverage maps, each with the session uid of its scene."""
        runs = ((uid, kept) for uid, made in self._kept.items() for kept in made.values())
        return [*runs, *self._maps.items()]

    def keep(self, scene: Any, kept: StoredRecording) -> None:
        """Make `kept` the last recording of a scene; undo brings the former one back."""
        made = self._kept.setdefault(scene.session_uid, {})
        made[kept.mark] = kept
        while len(made) > UNDONE or (len(made) > 2 and _bytes_of(made.values()) > UNDONE_BYTES):
            made.pop(next(mark for mark in made if mark not in self.pinned))
        if scene.angen_recording != kept.mark:
            scene.angen_recording = kept.mark
        self.notice = ""

    def keep_alone(self, scene: Any, kept: StoredRecording) -> None:
        """Make `kept` the only recording of a scene; call this only where no undo can follow."""
        self._kept.pop(scene.session_uid, None)
        self.keep(scene, kept)

    def clear_recording(self, scene: Any) -> None:
        """Clear the recording of a scene; undo brings it back."""
        scene.angen_recording = CLEARED
        self.notice = ""

    def all_kept(self) -> dict[int, StoredRecording]:
        """Return the last recording of each scene, by the session uid of the scene."""
        found = {scene.session_uid: self.kept(scene) for scene in bpy.data.scenes}
        return {uid: kept for uid, kept in found.items() if kept is not None}

    def note_other_scene(self, scene: Any, depsgraph: Any) -> None:
        """Note an update in `scene`, which may share data with other scenes.

        Such an update can make the recordings of the other scenes stale. Blender reports it only
        now, and not again once another scene is shown.
        """
        for uid, kept in self._all_followed():
            if uid != scene.session_uid:
                kept.note_other_scene(depsgraph)

    def settings_changed(self, owner: Any) -> None:
        """Compare all recordings with `owner`, an object or scene whose settings have changed."""
        self._revision += 1
        if not self.running:
            for _, kept in self._all_followed():
                kept.check(owner)
            self.outdate_live()

    def outdate_live(self) -> None:
        """Mark the live readings as outdated."""
        if self.live is not None:
            self.live.outdated = True

    def forget_references(self) -> None:
        """Drop all references to Blender's data, because undo or redo will replace that data."""
        self.running = False
        self.live = None
        self.overlay = self.arrows = None
        self._revision += 1
        self._sensors = None, []
        self._listeners = weakref.WeakSet()
        for _, kept in self._all_followed():
            kept.unsure = True

    def clear(self) -> None:
        """Empty the cache, because another file opens."""
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
    """Whether all sensors still exist and have the names under which they were listed."""
    try:
        return all(sensor.name_now == sensor.name for sensor in sensors)
    except ReferenceError:
        return False


CACHE = Cache()
