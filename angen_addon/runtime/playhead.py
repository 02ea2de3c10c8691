# SPDX-License-Identifier: GPL-3.0-or-later
"""The reading of a sensor at the playhead: its origin, its age and its problems.

Panels, the table, the overlay and the handlers all use `Playhead`. The reading comes from the first
of these that has one: a fresh recording of the frame, live sensing, baked keyframes. Nothing is
estimated. A reading from another frame is marked as old.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from ...sensor_logic.kind import LIGHT
from ...sensor_logic.logs.fields import Field
from ...sensor_logic.model import Reading
from ...sensor_logic.recording.tracks import Recording
from ..recording.results import RESULTS
from ..scene import outputs
from ..scene.sensors import Sensor
from .edits import EDITS
from .live import has_reading, known_live

RECORDED, LIVE, BAKED, NOTHING = "RECORDED", "LIVE", "BAKED", "NOTHING"
NOT_YET = "Nothing was sensed at this frame yet: scrub, play or simulate"
LIVE_IS_OFF = "This frame is not recorded, and Live is off: simulate, or switch Live on"


class PlayheadReading(NamedTuple):
    """The reading of a sensor at the playhead.

    Attributes
    ----------
    origin
        Where the reading comes from: RECORDED, LIVE, BAKED or NOTHING.
    reading
        The reading; None if there is none.
    frame
        The frame at which the sensor sensed.
    age
        Time from `frame` to the playhead in s; negative if `frame` comes after the playhead.
    problem
        A text on why the reading is missing or not valid; empty if it is valid.
    old
        A text on why the reading may be outdated, or on how to get one; empty if it is current.
    keys
        The values of the baked keyframes at the playhead, which drivers read; None without
        keyframes.
    """

    origin: str
    reading: Reading | None = None
    frame: float = 0.0
    age: float = 0.0
    problem: str = ""
    old: str = ""
    keys: Reading | None = None


def why_not_recorded(sensor: Sensor) -> str:
    """Return why a sensor has no readings in the recording, and what the user can do, as a text."""
    if not sensor.settings.enabled:
        return "This sensor is not recorded: switch it on and simulate"
    if sensor.kind.requires(LIGHT):
        return "Light is not in this recording: simulate with light"
    return "This sensor is not in the recording: simulate again"


def fresh_recording(scene: Any) -> Recording | None:
    """Return the scene's recording if it is fresh and covers the playhead's frame, else None."""
    recording = RESULTS.recording(scene)
    frame = scene.frame_current + scene.frame_subframe
    return recording if recording is not None and recording.covers(frame) else None


def show_recorded(scene: Any, view_layer: Any) -> bool:
    """Write the recorded outputs at the playhead's frame to the sensors.

    Return whether a fresh recording covers this frame.
    """
    recording = fresh_recording(scene)
    if recording is not None:
        frame = scene.frame_current + scene.frame_subframe
        outputs.show_recorded(recording, EDITS.sensors(view_layer), frame)
    return recording is not None


class Playhead:
    """The readings of a scene's enabled sensors at its playhead, outside of runs.

    Make a new object for each use, since an old one does not follow changes of the scene.
    """

    def __init__(self, scene: Any) -> None:
        self.frame = scene.frame_current + scene.frame_subframe
        self._base, self._rate = scene.render.fps_base, scene.render.fps
        recording = fresh_recording(scene)
        self._is_recorded = recording is not None
        self._tracks = {t.uid: t for t in recording.tracks.values()} if recording else {}
        live = known_live()
        is_same_scene = live is not None and live.scene_uid == scene.session_uid
        self._live = live if is_same_scene and scene.angen_live else None
        self._nothing = NOT_YET if scene.angen_live else LIVE_IS_OFF
        self._old = self._live.why_old(scene) if self._live is not None else ""

    def of(self, sensor: Sensor, quantity: Field) -> PlayheadReading:
        """Return the reading of a sensor at the playhead.

        `quantity` is the field that the sensor shows as its main value. A live reading without this
        field does not count.
        """
        found = (
            self._recorded_reading(sensor)
            if self._is_recorded
            else self._live_reading(sensor, quantity)
        )
        if sensor.holders or not outputs.output_curves(sensor.object):
            return found
        keys = Reading(sensor.settings.active, sensor.settings.value, {})
        if found.reading is None and not found.problem:
            return PlayheadReading(BAKED, keys, self.frame, old=found.old, keys=keys)
        return found._replace(keys=keys)

    def source(self, sensor: Sensor, least_age: float) -> Any:
        """Return a value that stays equal while the reading is displayed in the same way.

        It contains everything on which `of` depends. An age of less than `least_age` seconds is
        left out.
        """
        read_at: float = self.frame
        found: Any = None
        if self._is_recorded:
            track = self._tracks.get(sensor.uid)
            index = track.at(self.frame) if track else None
            if track is not None and index is not None:
                read_at, found = track.frames[index], (track, index)
        elif self._live is not None:
            name, published = sensor.name, self._live.readings.get(sensor.name)
            found = (published, self._live.problems.get(name), self._live.why_unlit(sensor))
            read_at = published.frame if published is not None else self.frame
        keyed = not sensor.holders and outputs.output_curves(sensor.object)
        fresh = 0.0 <= self.seconds(self.frame - read_at) < least_age and not keyed
        return self._is_recorded, self._nothing, self._old, found, None if fresh else self.frame

    def seconds(self, frames: float) -> float:
        """Return the duration of a number of frames in s."""
        return float(frames * self._base / self._rate)

    def _recorded_reading(self, sensor: Sensor) -> PlayheadReading:
        track = self._tracks.get(sensor.uid)
        index = track.at(self.frame) if track else None
        if track is None or index is None:
            return PlayheadReading(NOTHING, old=why_not_recorded(sensor))
        fields = {name: column[index] for name, column in track.columns.items()}
        reading = Reading(bool(track.active[index]), track.value[index], fields)
        read_at = track.frames[index]
        age = self.seconds(self.frame - read_at)
        return PlayheadReading(RECORDED, reading, read_at, age, fields.get("problem", ""))

    def _live_reading(self, sensor: Sensor, quantity: Field) -> PlayheadReading:
        live = self._live
        if live is None:
            return PlayheadReading(NOTHING, old=self._nothing)
        problem = live.problems.get(sensor.name, "").removeprefix(f"'{sensor.name}': ")
        old = self._old or live.why_unlit(sensor)
        published = live.readings.get(sensor.name)
        if published is None or not has_reading(published, quantity):
            return PlayheadReading(NOTHING, problem=problem, old=old or NOT_YET)
        age = self.seconds(self.frame - published.frame)
        return PlayheadReading(LIVE, published.reading, published.frame, age, problem, old)
