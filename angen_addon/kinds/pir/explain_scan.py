# SPDX-License-Identifier: GPL-3.0-or-later
"""Explains a motion detector that compares ranges by the ray that changed most."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ....sensor_logic.kinds.pir.range_scan import PirParameters, fan_directions
from ....sensor_logic.model import Array, Pose
from ....sensor_logic.quantities import Lengths
from ....sensor_logic.wording import quoted
from ...explain.facts import Explanation, at_frame
from ...explain.replay import Replay

# m: a range whose change without noise is smaller did not change.
SAME = 1e-6
NAMES_SHOWN = 4
NOISE = "noise"


@dataclass(frozen=True)
class Scan:
    """One update: the numbers of its `tilts`; `ranges` (tilts, rays) in m; `clean`: the same
    without noise; `names` of the objects that the rays hit, in the same order."""

    tilts: range
    ranges: Array
    clean: Array
    names: list[str]
    pose: Pose


@dataclass(frozen=True)
class RayChange:
    """The ray that changed most between two scans. Lengths in m, angles in radians. `culprit`: the
    object that changed it, or "noise"; `names`: the objects that the ray hit before and after,
    empty for none; `over`: the number of rays that each culprit changed by more than the
    threshold."""

    tilt: int
    ray: int
    azimuth: float
    elevation: float
    before: float
    after: float
    names: tuple[str, str]
    culprit: str
    threshold: float
    over: tuple[tuple[str, int], ...]
    triggered: bool

    @property
    def change(self) -> float:
        return abs(self.after - self.before)

    @property
    def because(self) -> str:
        return self.culprit if self.triggered and self.culprit != NOISE else ""


def explain_range_scan(replay: Replay, index: int) -> Explanation:
    """Explains update `index` of a detector that compares ranges. Raises AngenError."""
    track, sensor = replay.track, replay.sensor
    set_up = sensor.settings.pir
    back = 1 if set_up.sweep == "ALL" else _tilts(replay)
    earlier = replay.index_of(replay.number(index) - back, index)
    old = None if earlier is None else scan(replay, earlier)
    new = scan(replay, index)
    if new is None:
        return replay.off(index)
    parameters, now, triggered, angle = new
    if old is None or old[1].ranges.shape != now.ranges.shape or earlier is None:
        text = (
            "No motion yet: this is the first scan at its tilt, there is nothing to compare it with"
        )
        return replay.explanation(index, text, ())
    cause = _change(parameters, old[1], now, triggered)
    lengths = replay.lengths
    facts = list(_facts(cause, parameters, lengths))
    facts.insert(3, ("Compared with", at_frame(track.frames[earlier], track.times[earlier])))
    moved = _own_movement(old[1].pose, now.pose, lengths)
    if moved:
        facts.append(("Sensor", moved))
    return replay.explanation(
        index,
        _headline(cause, parameters, bool(track.active[index]), lengths),
        tuple(facts),
        _doubt(replay, index, parameters, triggered, angle),
        cause,
    )


def _tilts(replay: Replay) -> int:
    pir = replay.sensor.settings.pir
    return PirParameters(vertical_fov=pir.vertical_fov, vertical_step=pir.vertical_step).tilt_count


def scan(replay: Replay, index: int) -> tuple[PirParameters, Scan, bool, float] | None:
    """Replays an update: the detector's parameters, its scan, whether its model finds movement in
    it, and the tilt (rad) that it publishes. None where the detector is off."""
    pending = replay.take(index)
    if pending is None:
        return None
    # Without hold, blocking and warm-up time the model reports this scan alone.
    bare = replace(pending.parameters, hold_time=0.0, blocking_time=0.0, warm_up_time=0.0)
    reading = replay.runner.model.update(bare, pending.update)
    parameters: PirParameters = pending.parameters
    fan = fan_directions(parameters)
    first = pending.update.number % len(fan)
    tilts = range(len(fan)) if parameters.sweep == "ALL" else range(first, first + 1)
    shape = len(tilts), parameters.rays
    seen = replay.seen
    reach = parameters.range_max - parameters.range_min
    ahead = seen.ranges * replay.metres
    clean = np.where(ahead >= reach, parameters.range_max, ahead + parameters.range_min)
    ranges = clean
    if parameters.noise_sigma > 0.0:
        noise = pending.update.noise().normal(0.0, parameters.noise_sigma, len(clean))
        ranges = clean + noise
    ranges = np.clip(ranges, parameters.range_min, parameters.range_max)
    found = Scan(
        tilts, ranges.reshape(shape), clean.reshape(shape), seen.names, pending.update.pose
    )
    return parameters, found, reading.active, reading.value


def _change(parameters: PirParameters, old: Scan, new: Scan, triggered: bool) -> RayChange:
    changes = np.abs(new.ranges - old.ranges)
    row, ray = (int(i) for i in np.unravel_index(int(np.argmax(changes)), changes.shape))
    rays = parameters.rays
    culprits = Counter(
        _culprit(old, new, int(r), int(i)) for r, i in np.argwhere(changes > parameters.threshold)
    )
    spacing = parameters.horizontal_fov / (rays - 1) if rays > 1 else 0.0
    tilt = new.tilts[row]
    return RayChange(
        tilt,
        ray,
        -parameters.horizontal_fov / 2 + ray * spacing if rays > 1 else 0.0,
        -tilt * parameters.vertical_step,
        float(old.ranges[row, ray]),
        float(new.ranges[row, ray]),
        (old.names[row * rays + ray], new.names[row * rays + ray]),
        _culprit(old, new, row, ray),
        parameters.threshold,
        tuple(sorted(culprits.items(), key=lambda item: (-item[1], item[0]))),
        triggered,
    )


def _culprit(old: Scan, new: Scan, row: int, ray: int) -> str:
    """The object that changed a ray: the nearer of the two that it hit was there only once."""
    before, after = float(old.clean[row, ray]), float(new.clean[row, ray])
    if abs(before - after) <= SAME:
        return NOISE
    nearer = old if before < after else new
    return nearer.names[row * new.ranges.shape[1] + ray]


def _ray_text(cause: RayChange, parameters: PirParameters) -> str:
    tilt = f"tilt {cause.tilt} ({abs(math.degrees(cause.elevation)):.0f}° below the horizon)"
    azimuth = math.degrees(cause.azimuth) + 0.0
    return f"{cause.ray} of 0 to {parameters.rays - 1}, at {azimuth:+.1f}°, {tilt}"


def _met(name: str, parameters: PirParameters, lengths: Lengths) -> str:
    return quoted(name) if name else f"nothing within {lengths.typed(parameters.range_max)}"


def _facts(cause: RayChange, parameters: PirParameters, lengths: Lengths) -> list[tuple[str, str]]:
    facts = [("Ray", _ray_text(cause, parameters))]
    for word, length, name in zip(
        ("Before", "After"), (cause.before, cause.after), cause.names, strict=True
    ):
        facts.append((word, f"{lengths.text(length)}, {_met(name, parameters, lengths)}"))
    limit = f"threshold {lengths.typed(parameters.threshold)}"
    facts.append(("Change", f"{lengths.text(cause.change)}, {limit}"))
    if parameters.noise_sigma > 0.0:
        sigma = lengths.typed(parameters.noise_sigma)
        facts.append(("Noise", f"{sigma} (standard deviation) on each range"))
    if cause.over:
        shown = [f"{count} by {_named(name)}" for name, count in cause.over[:NAMES_SHOWN]]
        more = len(cause.over) - NAMES_SHOWN
        facts.append(("Rays changed", ", ".join(shown) + (f" and {more} more" if more > 0 else "")))
    return facts


def _named(name: str) -> str:
    return name if name == NOISE else quoted(name)


def _headline(cause: RayChange, parameters: PirParameters, active: bool, lengths: Lengths) -> str:
    if not cause.triggered:
        held = f" in the hold time of {parameters.hold_time:g} s" if parameters.hold_time else ""
        where = "" if parameters.sweep == "ALL" else f" at tilt {cause.tilt}, the one looked at,"
        text = (
            f"no ray{where} changed by more than {lengths.typed(cause.threshold)}; "
            f"the largest change was {lengths.text(cause.change)}"
        )
        return f"{'Held on' if active else f'Still, no movement{held}'}: {text}"
    name = quoted(cause.culprit)
    ignored = "" if active else " (ignored: warm-up or blocking time)"
    old, new = cause.names
    if cause.culprit == NOISE:
        what = "nothing moved, the noise alone exceeded the threshold"
    elif old == new:
        what = f"{name} moved {'away' if cause.after > cause.before else 'nearer'}"
    elif cause.after < cause.before:
        what = (
            f"{name} came in front of {_met(old, parameters, lengths)}"
            if old
            else f"{name} came in"
        )
    else:
        what = f"{name} left" + (f", {quoted(new)} is behind" if new else "")
    return f"Motion{ignored}: {what}; ray {cause.ray} changed by {lengths.text(cause.change)}"


def _own_movement(old: Pose, new: Pose, lengths: Lengths) -> str:
    """How the sensor itself moved, or empty: then everything seems to move."""
    if old is new:
        return ""
    way = float(np.linalg.norm(new.origin - old.origin))
    cosine = (float(np.trace(old.axes.T @ new.axes)) - 1.0) / 2.0
    turn = math.degrees(math.acos(max(-1.0, min(1.0, cosine))))
    if way <= SAME and turn <= 1e-3:
        return ""
    return f"moved itself by {lengths.text(way)} and turned by {turn:.2f}°"


def _doubt(
    replay: Replay, index: int, parameters: PirParameters, triggered: bool, angle: float
) -> str:
    track: Any = replay.track
    recorded = bool(track.active[index])
    delayed = parameters.hold_time or parameters.blocking_time or parameters.warm_up_time
    recorded_angle = float(track.columns["angle_rad"][index])
    if abs(recorded_angle - angle) > 1e-6 or (triggered != recorded and not delayed):
        return (
            "the rays hit something else now than at the run: something has changed since. "
            "Simulate again"
        )
    return ""
