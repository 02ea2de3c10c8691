# SPDX-License-Identifier: GPL-3.0-or-later
"""A day in several stretches that different processes live: where one ends and the next begins the
sensors must be in the same state in both."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np

from ...sensor_logic.log.event_log import NewEvents
from ..runtime import handlers, outputs
from ..runtime.sensor_runner import SensorRunner
from ..scene.animation import all_animated, may_set
from ..scene.timed import frames_to_step_from

# By sensor, a digest of all that its readings to come depend on beside the scene; empty where that
# cannot be told. Under the empty name, that of what drivers made of the sensors' outputs.
State = dict[str, str]
# By sensor whose events are told by a step, the values of its last ones by field: from those the
# next are told.
Last = dict[str, dict[str, Any]]


@dataclass
class DayStretch:
    """Stretch `number` (from 0) of a day that is cut at the times `cuts` (s since midnight). `tell`
    is called with the state at its beginning, `meets` with the number of a later stretch and the
    state in which its beginning is come to: whether it was begun in that very state. Afterwards it
    has gone `until` before that stretch, or the day's end. In the end `last_before` is asked for
    the last events before it, and waits for them; `hand_on` is called with the later stretch and
    its own."""

    number: int
    cuts: tuple[float, ...]
    tell: Callable[[State], object]
    meets: Callable[[int, State], bool]
    last_before: Callable[[], Last]
    hand_on: Callable[[int, Last], object]
    until: int = 0


def why_whole(scene: Any) -> str:
    """Why a day in this scene cannot be begun amid it, in words; empty where it can."""
    if frames_to_step_from(scene):
        return "physics go from frame to frame"
    return "other code follows the frames" if handlers.others_follow_frames() else ""


def differing(one: State, other: State) -> list[str]:
    """The sensors that are not known to be in the same state in both."""
    return sorted(n for n in one.keys() | other.keys() if one.get(n, "") != (other.get(n) or None))


def state_of(runners: Sequence[SensorRunner], new: NewEvents) -> State:
    """The state of sensors, of which all events until now were taken from `new`, but of those whose
    events are told by a step."""
    driven = outputs.are_driven()
    found = {runner.sensor.name: _state(runner, new, driven) for runner in runners}
    return found | {"": _digest(list(_driven()))} if driven else found


def _state(runner: SensorRunner, new: NewEvents, driven: bool) -> str:
    sensor, state = runner.sensor, runner.state
    # What does not matter with these parameters may matter with others.
    changes = any(may_set(obj, "angen_sensor.") for obj in (sensor.object, *sensor.holders))
    if state is None or changes:
        return ""
    shown = (sensor.settings.active, sensor.settings.value) if driven else ()
    last = {} if new.has_steps(sensor.name) else new.last_of(sensor.name)
    return _digest([state, sorted(last.items()), shown])


def _driven() -> Any:
    """What drivers have made of properties: one may go on from what it made before."""
    for owner in all_animated():
        for curve in owner.animation_data.drivers:
            try:
                value = owner.path_resolve(curve.data_path)
            except ValueError:
                # It leads nowhere, and so makes nothing.
                continue
            many = isinstance(value, bpy.types.bpy_prop_array) or hasattr(value, "__len__")
            yield owner.name, curve.data_path, list(value) if many else value


def _digest(value: Any) -> str:
    found = hashlib.sha256()
    for part in _parts(value):
        found.update(part)
    return found.hexdigest()


def _parts(value: Any) -> Any:
    """Bytes that tell a value of plain values, arrays, and sequences of them, from any other."""
    if isinstance(value, np.ndarray):
        yield f"{value.dtype.str}{value.shape}".encode()
        yield np.ascontiguousarray(value).tobytes()
    elif isinstance(value, (list, tuple)):
        yield f"({len(value)} ".encode()
        for one in value:
            yield from _parts(one)
    else:
        # Floats too are told to the bit.
        text = repr(value)
        yield f"{len(text)} {text}".encode()
