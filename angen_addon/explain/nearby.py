# SPDX-License-Identifier: GPL-3.0-or-later
"""What is near a sensor at some of its updates: only the scene knows, not the recording."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np

from ...sensor_logic.model import Array, Pose
from ..appearance.recorded import RecordedSensor
from ..runtime import handlers
from ..runtime.probes import make_caster
from ..runtime.running import running
from ..runtime.time_base import evaluated_depsgraph
from ..scene.outputs import are_driven, show
from ..scene.sensors import Sensor, all_sensors, read_pose


@dataclass(frozen=True)
class Nearby:
    """The surroundings of a sensor at one update.

    Attributes
    ----------
    pose
        The pose of the sensor.
    bounds
        The bounds (2, 3) in m of the solids that rays can hit, by their names.
    """

    pose: Pose
    bounds: dict[str, Array]


def surroundings(
    recorded: RecordedSensor, indices: Sequence[int], include_sensor: bool = False
) -> list[Nearby]:
    """Return the surroundings of a sensor at some updates of its track, as the scene is now.

    If `include_sensor` is True, the bounds include those of the sensor's own solids. The frame is
    restored. Do not call this function in a frame handler, nor during a run.
    """
    scene, sensor, clock = recorded.scene, recorded.sensor, recorded.clock
    found = []
    with _restored(scene) as driven:
        caster = make_caster(scene)
        for index in indices:
            step = recorded.step_of(index)
            _show_outputs_before(recorded, driven, clock.step_frame(step))
            frame, subframe = clock.frame_and_subframe(step)
            scene.frame_set(frame, subframe=subframe)
            depsgraph = evaluated_depsgraph()
            caster.update(depsgraph)
            pose = read_pose(sensor, sensor.world_matrix(depsgraph), recorded.metres)
            found.append(Nearby(pose, _bounds(recorded, caster.solids, include_sensor)))
    return found


def _bounds(recorded: RecordedSensor, solids: Any, include_sensor: bool) -> dict[str, Array]:
    found: dict[str, Array] = {}
    for solid in solids.solids:
        box = np.stack([solids.lo[solid.row], solids.hi[solid.row]]) * recorded.metres
        is_own = solid.is_passed_by(recorded.sensor.uid)
        if not np.isfinite(box).all() or (is_own and not include_sensor):
            continue
        known = found.get(solid.name, box)
        found[solid.name] = np.stack([np.minimum(known[0], box[0]), np.maximum(known[1], box[1])])
    return found


def _show_outputs_before(recorded: RecordedSensor, driven: Sequence[Sensor], frame: float) -> None:
    """Set the outputs of all sensors to their values just before this frame, for drivers."""
    for sensor in driven:
        track = recorded.recording.track_of(sensor.uid)
        if track is None:
            continue
        # A force depends on the motion through a frame, so the run knew it one frame later.
        until = frame - 1.0 if sensor.kind.requires_forces else frame
        last = bisect_left(track.frames, until) - 1
        on, value = (bool(track.active[last]), track.value[last]) if last >= 0 else (False, 0.0)
        show(sensor, on, value)


@contextmanager
def _restored(scene: Any) -> Iterator[list[Sensor]]:
    """Give the sensors whose outputs drivers may read; on exit, restore frame and outputs."""
    frame, subframe = scene.frame_current, scene.frame_subframe
    view_layer = bpy.context.view_layer
    sensors = all_sensors(view_layer)
    before = [(s, s.settings.active, s.settings.value) for s in sensors]
    handlers.restore_handlers()
    with running():
        try:
            yield sensors if are_driven() else []
        finally:
            with suppress(ReferenceError):
                for sensor, active, value in before:
                    show(sensor, active, value)
                scene.frame_set(frame, subframe=subframe)
                # Evaluate now: later, the restored frame and outputs would count as an edit.
                view_layer.update()
