# SPDX-License-Identifier: GPL-3.0-or-later
"""Explains why a motion detector fired, or what would have to change for it to fire."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ....sensor_logic.physics.output_timing import waiting
from ....sensor_logic.wording import capital, quoted
from ...explain.facts import Explanation, Facts
from ...explain.replay import Replay
from .explain_scan import SAME as CHANGED
from .explain_scan import explain_range_scan
from .explain_warmth import WarmCause, explain_pyroelectric

# m: smaller movements count as none.
SAME = 1e-6


def explain_motion(replay: Replay, index: int) -> Explanation:
    """Explains update `index` of a motion detector of either model. Raises AngenError."""
    pyroelectric = replay.sensor.parameters.model == "PYROELECTRIC"
    return (explain_pyroelectric if pyroelectric else explain_range_scan)(replay, index)


def lacking(replay: Replay, index: int, found: Explanation) -> Explanation:
    """Adds what would have to change for the detector to fire, before the other facts."""
    headline, facts = found.headline, _missing(replay, index, found) if found.cause else []
    held = _why_waiting(replay, index)
    if held:
        headline = f"{capital(held)}. {headline}"
        facts.insert(0, ("Output", held))
    return replace(found, headline=headline, facts=(*facts, *found.facts))


def _why_waiting(replay: Replay, index: int) -> str:
    """Why a motion detector would not report movement now, or empty: warm-up or blocking time."""
    track, pir = replay.track, replay.sensor.parameters
    now = track.times[index]
    on = np.flatnonzero(np.asarray(track.active)[:index])
    fell = track.times[int(on[-1]) + 1] if len(on) else -math.inf
    blocking = pir.blocking_time
    if pir.model == "PYROELECTRIC":
        blocking = max(blocking, pir.blanking_time)
    return waiting(pir.warm_up_time, blocking, now, fell)


def _missing(replay: Replay, index: int, found: Explanation) -> Facts:
    """What would have to change for the detector to fire."""
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
    """The object nearest to the detector that has moved since its update before, and why the
    detector does not report it."""
    if index == 0:
        return "unknown at the first update"
    before, now = replay.bounds(index - 1), replay.bounds(index)
    pose = replay.pose
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
    text = f"{quoted(name)}, {replay.lengths.text(away[name])} away"
    pir = replay.sensor.parameters
    if name in _noticed(found):
        return f"{text}: seen, but it changes too little, or too slowly"
    if away[name] > pir.range_max:
        return f"{text}: beyond the range max of {replay.lengths.typed(pir.range_max)}"
    if pir.model == "RANGE_SCAN":
        middle = (moving[name].mean(axis=0) - pose.origin) @ pose.axes
        beside = abs(math.atan2(-middle[0], -middle[2]))
        half = pir.horizontal_fov / 2
        if beside > half:
            return (
                f"{text}: {math.degrees(beside):.0f}° beside its axis, its field of view ends at "
                f"{math.degrees(half):.0f}°"
            )
        return f"{text}: hidden, between its rays, or not at the tilt that it looks at"
    return f"{text}: hidden, outside its zones, as warm as what is behind, or too slow"


def _noticed(found: Explanation) -> set[str]:
    """The names of objects that changed something that the detector measures."""
    cause = found.cause
    if isinstance(cause, WarmCause):
        return {thing.name for thing in cause.things}
    return {cause.culprit} if cause.change > CHANGED else set()
