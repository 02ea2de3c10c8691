# SPDX-License-Identifier: GPL-3.0-or-later
"""What would have to change for a sensor that reports nothing to report something."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from ...sensor_logic.model import Array, Pose
from ...sensor_logic.output_timing import waiting
from ...sensor_logic.quantities import typed
from ..sensors import read_pose
from ..station import evaluated_depsgraph
from ..wording import capital, quoted
from .facts import Explanation
from .motion import SAME as CHANGED
from .replay import Replay
from .warm import WarmCause

Facts = list[tuple[str, str]]
# Blender units: what moves by less does not move.
SAME = 1e-6


def with_what_is_missing(replay: Replay, index: int, found: Explanation) -> Explanation:
    """The explanation of an update at which the sensor is not active, with what keeps it from
    that. Raises SensorError."""
    if replay.track.active[index]:
        return found
    kind, headline = replay.sensor.kind.identifier, found.headline
    facts = MISSING[kind](replay, index, found) if found.cause is not None else []
    held = _waiting(replay, index) if kind == "PIR" else ""
    if held:
        headline = f"{capital(held)}. {headline}"
        facts.insert(0, ("Output", held))
    return replace(found, headline=headline, facts=(*facts, *found.facts))


def _waiting(replay: Replay, index: int) -> str:
    """Why a motion detector would not report what it notices; empty where it would."""
    track, pir = replay.track, replay.sensor.parameters
    now = track.times[index]
    on = np.flatnonzero(np.asarray(track.active)[:index])
    fell = track.times[int(on[-1]) + 1] if len(on) else -math.inf
    return waiting(pir.warm_up_time, pir.blocking_time, now, fell)


def _motion(replay: Replay, index: int, found: Explanation) -> Facts:
    if replay.sensor.parameters.model == "PYROELECTRIC":
        share = abs(found.cause.signal)
        if share > 1.0:
            return []
        facts = [("To fire", f"the signal must exceed its threshold: it is {share:.0%} of it")]
    else:
        cause, lengths = found.cause, replay.lengths
        if cause.triggered:
            return []
        share = cause.change / cause.threshold if cause.threshold else math.inf
        facts = [
            (
                "To fire",
                f"a range must change by more than {lengths.typed(cause.threshold)}: "
                f"the most is {share:.0%} of that",
            )
        ]
    return [*facts, ("Nearest movement", _nearest_movement(replay, index, found))]


def _nearest_movement(replay: Replay, index: int, found: Explanation) -> str:
    """What moves nearest to a motion detector since its update before, and why that is not seen,
    or not enough."""
    if index == 0:
        return "not known at the first update"
    before, now = _bounds(replay, index - 1), _bounds(replay, index)
    pose = _pose(replay)
    moving = {
        name: now[name]
        for name in now.keys() & before.keys()
        if np.abs(now[name] - before[name]).max() > SAME
    }
    if not moving:
        return "nothing moves"
    places = {n: np.clip(pose.origin, b[0], b[1]) for n, b in moving.items()}
    away = {n: float(np.linalg.norm(place - pose.origin)) for n, place in places.items()}
    name = min(sorted(away), key=lambda n: away[n])
    told = f"{quoted(name)}, {replay.lengths.text(away[name])} away"
    pir = replay.sensor.parameters
    if name in _noticed(found):
        return f"{told}: seen, but it changes too little, or too slowly"
    if away[name] > pir.range_max:
        return f"{told}: beyond the range max of {replay.lengths.typed(pir.range_max)}"
    if pir.model == "RANGE_SCAN":
        middle = (moving[name].mean(axis=0) - pose.origin) @ pose.axes
        beside = abs(math.atan2(-middle[0], -middle[2]))
        half = pir.horizontal_fov / 2
        if beside > half:
            return (
                f"{told}: {math.degrees(beside):.0f}° beside its axis, its field of view ends at "
                f"{math.degrees(half):.0f}°"
            )
        return f"{told}: hidden, between its rays, or not at the tilt that it looks at"
    return f"{told}: hidden, outside its zones, as warm as what is behind, or too slow"


def _noticed(found: Explanation) -> set[str]:
    """What changed anything that the detector measures."""
    cause = found.cause
    if isinstance(cause, WarmCause):
        return {thing.name for thing in cause.things}
    return {cause.culprit} if cause.change > CHANGED else set()


def _switch(replay: Replay, index: int, found: Explanation) -> Facts:
    now, lengths = found.cause.now, replay.lengths
    if now.rays > 1:
        return [("To open", f"more light must pass: now {now.light:.0%}")]
    short = found.cause.threshold - now.range
    what = quoted(now.name) if now.name else "something"
    if short <= 0.0:
        return [("To open", "nothing may go through the beam until the next update")]
    return [
        (
            "To open",
            f"the beam must be clear to {lengths.typed(found.cause.threshold)}: {what} ends it "
            f"{lengths.text(short)} before that",
        )
    ]


def _pad(replay: Replay, index: int, found: Explanation) -> Facts:
    cause = found.cause
    facts = [("To be pressed", _over(cause.threshold, cause.force, "N"))]
    if cause.partners:
        return facts
    near = _nearest_above(replay, index)
    return [*facts, ("Nearest above", near or "nothing stands above it")]


def _nearest_above(replay: Replay, index: int) -> str:
    """What is lowest above a pad, and by how much it is."""
    found = _bounds(replay, index, own=True)
    name = replay.sensor.object.name
    if name not in found:
        return ""
    low, high = found.pop(name)
    gaps = {
        n: float(b[0, 2] - high[2])
        for n, b in found.items()
        if (b[0, :2] < high[:2]).all() and (b[1, :2] > low[:2]).all() and b[0, 2] >= high[2]
    }
    if not gaps:
        return ""
    nearest = min(sorted(gaps), key=lambda n: gaps[n])
    return f"{quoted(nearest)}, by {replay.lengths.text(gaps[nearest])}"


def _light(replay: Replay, index: int, found: Explanation) -> Facts:
    light = replay.sensor.parameters
    level = light.threshold + light.hysteresis / 2
    return [("To be lit", _over(level, replay.track.value[index], replay.sensor.reading.unit))]


def _over(threshold: float, value: float, unit: str) -> str:
    share = f"{value / threshold:.0%} of that" if threshold else "nothing"
    return f"more than {typed(threshold, unit)} is needed: it is {share}"


def _bounds(replay: Replay, index: int, own: bool = False) -> dict[str, Array]:
    """Least and greatest corner (2, 3) in metres of what rays meet at an update, by name; `own`:
    the sensor's own too."""
    depsgraph = replay.go(replay.step(index))
    replay.probes.look(depsgraph, None)
    solids = replay.witness.solids
    found: dict[str, Array] = {}
    for solid in solids.solids:
        box = np.stack([solids.lo[solid.row], solids.hi[solid.row]]) * replay.metres
        if not np.isfinite(box).all() or (not own and replay.sensor.uid in solid.owners):
            continue
        known = found.get(solid.name, box)
        found[solid.name] = np.stack([np.minimum(known[0], box[0]), np.maximum(known[1], box[1])])
    return found


def _pose(replay: Replay) -> Pose:
    matrix = replay.sensor.world_matrix(evaluated_depsgraph())
    return read_pose(replay.sensor, matrix, replay.metres)


MISSING: dict[str, Callable[[Replay, int, Any], Facts]] = {
    "PIR": _motion,
    "OPTICAL_SWITCH": _switch,
    "PRESSURE": _pad,
    "LIGHT": _light,
}
