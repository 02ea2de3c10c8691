# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the reading that is shown of a sensor comes from, how old it is, and why.

Decided here alone: panels, the table, the overlay and handlers ask `Playhead`. What was
recorded of the scene as it is comes first, then what was sensed live, then baked keys. Nothing is
estimated: what was not measured is told as such, or the last reading that was is told as old.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from ...sensor_logic.kind import LIGHT, Field
from ...sensor_logic.model import Reading
from ...sensor_logic.recording.tracks import Recording
from ..scene.sensors import Sensor
from . import state

RECORDED, LIVE, BAKED, NOTHING = "RECORDED", "LIVE", "BAKED", "NOTHING"
NOT_YET = "Nothing was sensed at this frame yet: scrub, play or simulate"
LIVE_IS_OFF = "Nothing is recorded of this frame, and Live is off: simulate, or switch Live on"


class PlayheadReading(NamedTuple):
    """What is known of a sensor at the playhead.

    `origin`: RECORDED, LIVE, BAKED or NOTHING; `reading`: None where nothing is known; it was read
    at `frame`, `age` seconds of the scene before the playhead (below 0: after it). `problem`: why
    it is not valid, or there is none; `old`: why it is not what the sensor would read now, or what
    brings a reading where there is none. `keys`: what baked keys say at the playhead, which is what
    drivers read.
    """

    origin: str
    reading: Reading | None = None
    frame: float = 0.0
    age: float = 0.0
    problem: str = ""
    old: str = ""
    keys: Reading | None = None


def why_not_recorded(sensor: Sensor) -> str:
    """Why a sensor has no readings in the recording, and what to do."""
    if not sensor.settings.enabled:
        return "This sensor is not recorded: switch it on and simulate"
    if sensor.kind.requires(LIGHT):
        return "Light is not in this recording: simulate with light"
    return "This sensor is not in the recording: simulate again"


def recorded_here(scene: Any) -> Recording | None:
    """The recording, if it is of the scene as it is and has the playhead's frame."""
    recording = state.CACHE.recording(scene)
    frame = scene.frame_current + scene.frame_subframe
    return recording if recording is not None and recording.covers(frame) else None


def show_recorded(scene: Any, view_layer: Any) -> bool:
    """Gives drivers what is recorded at the playhead; whether it is."""
    recording = recorded_here(scene)
    if recording is not None:
        frame = scene.frame_current + scene.frame_subframe
        state.show_recorded(recording, state.CACHE.sensors(view_layer), frame)
    return recording is not None


class Playhead:
    """What is known at a scene's playhead of sensors that are switched on, while no run is on. Not
    to be kept."""

    def __init__(self, scene: Any) -> None:
        self.frame = scene.frame_current + scene.frame_subframe
        self._base, self._rate = scene.render.fps_base, scene.render.fps
        recording = recorded_here(scene)
        self._is_recorded = recording is not None
        self._tracks = {t.uid: t for t in recording.tracks.values()} if recording else {}
        live = state.CACHE.live
        known = live is not None and live.scene_uid == scene.session_uid
        self._live = live if known and scene.angen_live else None
        self._nothing = NOT_YET if scene.angen_live else LIVE_IS_OFF
        self._old = self._live.why_old(scene) if self._live is not None else ""

    def of(self, sensor: Sensor, quantity: Field) -> PlayheadReading:
        """`quantity`: what the sensor's reading is."""
        told = self._recorded(sensor) if self._is_recorded else self._lively(sensor, quantity)
        if sensor.holders or not state.output_curves(sensor.object):
            return told
        keys = Reading(sensor.settings.active, sensor.settings.value, {})
        if told.reading is None and not told.problem:
            return PlayheadReading(BAKED, keys, self.frame, old=told.old, keys=keys)
        return told._replace(keys=keys)

    def source(self, sensor: Sensor, least_age: float) -> Any:
        """All that the reading of a sensor depends on, to be compared, but for an age below
        `least_age` (s), during which it is equal."""
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
        keyed = not sensor.holders and state.output_curves(sensor.object)
        fresh = 0.0 <= self.seconds(self.frame - read_at) < least_age and not keyed
        return self._is_recorded, self._nothing, self._old, found, None if fresh else self.frame

    def seconds(self, frames: float) -> float:
        return float(frames * self._base / self._rate)

    def _recorded(self, sensor: Sensor) -> PlayheadReading:
        track = self._tracks.get(sensor.uid)
        index = track.at(self.frame) if track else None
        if track is None or index is None:
            return PlayheadReading(NOTHING, old=why_not_recorded(sensor))
        fields = {name: column[index] for name, column in track.columns.items()}
        reading = Reading(bool(track.active[index]), track.value[index], fields)
        read_at = track.frames[index]
        age = self.seconds(self.frame - read_at)
        return PlayheadReading(RECORDED, reading, read_at, age, fields.get("problem", ""))

    def _lively(self, sensor: Sensor, quantity: Field) -> PlayheadReading:
        live = self._live
        if live is None:
            return PlayheadReading(NOTHING, old=self._nothing)
        problem = live.problems.get(sensor.name, "").removeprefix(f"'{sensor.name}': ")
        old = self._old or live.why_unlit(sensor)
        published = live.readings.get(sensor.name)
        if published is None or published.reading.fields.get(quantity.name) is None:
            # What was read as another kind, or by another method, is in another unit.
            return PlayheadReading(NOTHING, problem=problem, old=old or NOT_YET)
        age = self.seconds(self.frame - published.frame)
        return PlayheadReading(LIVE, published.reading, published.frame, age, problem, old)
