# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the reading that is shown of a sensor comes from, how old it is, and why.

Decided here alone: panels, the table, the overlay and handlers ask `at_playhead`. What was
recorded of the scene as it is comes first, then what was sensed live, then baked keys. Nothing is
estimated: what was not measured is told as such, or the last reading that was is told as old.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from ..sensor_logic.model import Reading
from ..sensor_logic.recording import Recording
from . import outputs, state
from .sensors import Sensor

RECORDED, LIVE, BAKED, NOTHING = "RECORDED", "LIVE", "BAKED", "NOTHING"
NOT_YET = "Nothing was sensed at this frame yet: scrub, play or simulate"
LIVE_IS_OFF = "Nothing is recorded of this frame, and Live is off: simulate, or switch Live on"
NOT_RECORDED = "Nothing is recorded of it: switch it on and simulate"


@dataclass(frozen=True)
class Told:
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
        outputs.show_recorded(recording, view_layer, frame)
    return recording is not None


def at_playhead(sensor: Sensor, scene: Any) -> Told:
    """What is known of a sensor that is switched on, while no run is on."""
    recording = recorded_here(scene)
    told = _live(sensor, scene) if recording is None else _recorded(sensor, scene, recording)
    if sensor.holders or not outputs.output_curves(sensor.object):
        return told
    keys = Reading(sensor.settings.active, sensor.settings.value, {})
    if told.reading is None and not told.problem:
        frame = scene.frame_current + scene.frame_subframe
        return Told(BAKED, keys, frame, old=told.old, keys=keys)
    return replace(told, keys=keys)


def _recorded(sensor: Sensor, scene: Any, recording: Recording) -> Told:
    frame = scene.frame_current + scene.frame_subframe
    track = recording.track_of(sensor.uid)
    index = track.at(frame) if track else None
    if track is None or index is None:
        return Told(NOTHING, old=NOT_RECORDED)
    fields = {name: column[index] for name, column in track.columns.items()}
    reading = Reading(bool(track.active[index]), track.value[index], fields)
    read_at = track.frames[index]
    age = _seconds(scene, frame - read_at)
    return Told(RECORDED, reading, read_at, age, fields.get("problem", ""))


def _live(sensor: Sensor, scene: Any) -> Told:
    live = state.CACHE.live
    if not scene.angen_live:
        return Told(NOTHING, old=LIVE_IS_OFF)
    if live is None or live.scene_uid != scene.session_uid:
        return Told(NOTHING, old=NOT_YET)
    problem = live.problems.get(sensor.name, "").removeprefix(f"'{sensor.name}': ")
    old = live.why_old(sensor, scene)
    published = live.readings.get(sensor.name)
    if published is None or published.reading.fields.get(sensor.reading.name) is None:
        # What was read as another kind, or by another method, is in another unit.
        return Told(NOTHING, problem=problem, old=old or NOT_YET)
    frame = scene.frame_current + scene.frame_subframe
    age = _seconds(scene, frame - published.frame)
    return Told(LIVE, published.reading, published.frame, age, problem, old)


def _seconds(scene: Any, frames: float) -> float:
    return float(frames * scene.render.fps_base / scene.render.fps)
