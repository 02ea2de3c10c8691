# SPDX-License-Identifier: GPL-3.0-or-later
"""Explain why a motion detector reported motion, or why it did not.

A detector has one of two models, range scan or pyroelectric. Each has its own explanation.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ....sensor_logic.evidence import rows_of
from ....sensor_logic.kinds.pir.pyroelectric import threshold_of
from ....sensor_logic.kinds.pir.range_scan import PirParameters
from ....sensor_logic.kinds.pir.scan_evidence import SAME
from ....sensor_logic.kinds.pir.warm_evidence import WarmObject, warm_objects
from ....sensor_logic.logs.wording import Lengths, capital, listed, percent, quoted
from ....sensor_logic.parameters import label_of, specs
from ....sensor_logic.physics import waiting
from ...appearance.facts import Explanation, Facts
from ...appearance.recorded import RecordedSensor
from ...explain.nearby import surroundings

# Range scan: an update is explained by the ray whose range changed most.

NAMES_SHOWN = 4
NOISE = "noise"


@dataclass(frozen=True)
class RayChange:
    """The ray whose range changed most between two scans, with the object that changed it.

    Attributes
    ----------
    tilt, ray
        The number of the tilt, and of the ray within this tilt; −1 if only noise changed ranges,
        and by less than the threshold.
    azimuth, elevation
        The direction of the ray, in radians.
    before, after
        The range of the ray in the first and in the second scan, in m; 0 without a ray.
    names
        The objects that the ray hit in the two scans; empty for none.
    culprit
        The object that changed the range, or "noise".
    threshold
        The change of a range that counts as movement, in m.
    over
        For each object, or "noise", the number of rays that it changed by more than the threshold.
    triggered
        Whether the second scan triggers the detector.
    """

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
        """The change of the range in m."""
        return abs(self.after - self.before)


def explain_range_scan(recorded: RecordedSensor, index: int) -> Explanation:
    """Explain update `index` of a range scan by the ray whose range changed most."""
    parameters: PirParameters = recorded.parameters_at(index)
    ago = recorded.evidence("ago", index)
    if ago < 0:
        text = (
            "No motion yet: this is the first scan at its tilt, so there is no scan to compare with"
        )
        return recorded.explanation(index, text, ())
    cause, lengths = _change(recorded, parameters, index), recorded.lengths
    earlier = recorded.index_of(recorded.update_number(index) - ago, index)
    compared = [] if earlier is None else [("Compared with", recorded.when(earlier))]
    facts = [
        *_ray_facts(cause, parameters, lengths),
        *compared,
        *_facts(cause, parameters, lengths),
    ]
    moved = _sensor_movement(recorded, index)
    if moved:
        facts.append(("Sensor", moved))
    headline = _headline(cause, parameters, bool(recorded.track.active[index]), lengths)
    return recorded.explanation(index, headline, tuple(facts), "", cause)


def _change(recorded: RecordedSensor, parameters: PirParameters, index: int) -> RayChange:
    """Return the ray that changed most at update `index`."""
    tilt, ray, before, after, *names, culprit, over = (
        recorded.evidence(name, index)
        for name in (
            "tilt", "ray", "before", "after", "hit_before", "hit_after", "culprit", "over",
        )
    )  # fmt: skip
    if ray < 0:
        tilt = round(recorded.track.columns["angle_rad"][index] / parameters.vertical_step)
    rays = parameters.rays
    spacing = parameters.horizontal_fov / (rays - 1) if rays > 1 else 0.0
    return RayChange(
        tilt,
        ray,
        -parameters.horizontal_fov / 2 + ray * spacing if rays > 1 else 0.0,
        -tilt * parameters.vertical_step,
        before,
        after,
        tuple(names),
        culprit or NOISE,
        parameters.threshold,
        tuple((name or NOISE, int(count)) for name, count in rows_of(over)),
        abs(after - before) > parameters.threshold,
    )


def _ray_text(cause: RayChange, parameters: PirParameters) -> str:
    tilt = f"tilt {cause.tilt} ({abs(math.degrees(cause.elevation)):.0f}° below the horizon)"
    azimuth = math.degrees(cause.azimuth) + 0.0
    return f"{cause.ray} of 0 to {parameters.rays - 1}, at {azimuth:+.1f}°, {tilt}"


def _hit_text(name: str, parameters: PirParameters, lengths: Lengths) -> str:
    return quoted(name) if name else f"nothing within {lengths.typed(parameters.range_max)}"


def _ray_facts(cause: RayChange, parameters: PirParameters, lengths: Lengths) -> Facts:
    if cause.ray < 0:
        return []
    facts = [("Ray", _ray_text(cause, parameters))]
    for word, length, name in zip(
        ("Before", "After"), (cause.before, cause.after), cause.names, strict=True
    ):
        facts.append((word, f"{lengths.text(length)}, {_hit_text(name, parameters, lengths)}"))
    return facts


def _facts(cause: RayChange, parameters: PirParameters, lengths: Lengths) -> Facts:
    limit = f"threshold {lengths.typed(parameters.threshold)}"
    change = NOISE if _is_noise_alone(cause, parameters) else lengths.text(cause.change)
    facts = [("Change", f"{change}, {limit}")]
    if parameters.noise_sigma > 0.0:
        sigma = lengths.typed(parameters.noise_sigma)
        facts.append(("Noise", f"{sigma} (standard deviation) on each range"))
    if cause.over:
        shown = [f"{count} by {_culprit_text(name)}" for name, count in cause.over]
        facts.append(("Rays changed", listed(shown, NAMES_SHOWN)))
    return facts


def _is_noise_alone(cause: RayChange, parameters: PirParameters) -> bool:
    return cause.ray < 0 and parameters.noise_sigma > 0.0


def _culprit_text(name: str) -> str:
    return name if name == NOISE else quoted(name)


def _headline(cause: RayChange, parameters: PirParameters, active: bool, lengths: Lengths) -> str:
    if not cause.triggered:
        limit, hold_time = lengths.typed(cause.threshold), parameters.hold_time
        most = f"the largest change was {lengths.text(cause.change)}"
        if _is_noise_alone(cause, parameters):
            most = "only noise changed the ranges"
        if parameters.sweep == "ALL":
            text = f"no ray changed by more than {limit}; {most}"
        else:
            text = f"no ray of this update's tilt {cause.tilt} changed by more than {limit}; {most}"
        if active:
            return f"Held on: {text}"
        if hold_time:
            return f"Still, no movement in the hold time of {hold_time:g} s: {text}"
        return f"Still, no movement: {text}"
    name = quoted(cause.culprit)
    old, new = cause.names
    if cause.culprit == NOISE:
        what = "nothing moved, the noise alone exceeded the threshold"
    elif old == new:
        away = cause.after > cause.before
        what = f"{name} moved away" if away else f"{name} moved nearer"
    elif cause.after < cause.before:
        what = (
            f"{name} came in front of {_hit_text(old, parameters, lengths)}"
            if old
            else f"{name} came in"
        )
    else:
        what = f"{name} left, {quoted(new)} is behind" if new else f"{name} left"
    text = f"{what}; ray {cause.ray} changed by {lengths.text(cause.change)}"
    return f"Motion: {text}" if active else f"Motion (ignored: warm-up or blocking time): {text}"


def _sensor_movement(recorded: RecordedSensor, index: int) -> str:
    """Return a text on how the sensor itself moved between two scans; empty if it did not move."""
    way = recorded.evidence("sensor_moved", index)
    turn = math.degrees(recorded.evidence("sensor_turned", index))
    if way <= SAME and turn <= 1e-3:
        return ""
    return f"the sensor itself moved by {recorded.lengths.text(way)} and turned by {turn:.2f}°"


# Pyroelectric detector: an update is explained by the object that changed the power most.

ZERO_CELSIUS = 273.15
THINGS_SHOWN = 4


@dataclass(frozen=True)
class WarmCause:
    """The objects and the signal that explain the reading of a pyroelectric detector.

    Attributes
    ----------
    things
        The objects that changed the power on the elements, in descending order of the change.
    signal
        The recorded signal in multiples of the threshold.
    threshold
        The threshold in W per m² of lenslet.
    ambient
        The temperature of the surroundings in K.
    """

    things: tuple[WarmObject, ...]
    signal: float
    threshold: float
    ambient: float


def explain_pyroelectric(recorded: RecordedSensor, index: int) -> Explanation:
    """Explain update `index` by the object that changed the radiation on the elements most."""
    parameters: PirParameters = recorded.parameters_at(index)
    signal = recorded.track.columns["signal"][index]
    things = warm_objects(recorded.track, index)
    ambient = recorded.evidence("ambient", index)
    cause = WarmCause(things, signal, threshold_of(parameters), ambient)
    facts = [
        ("Signal", f"{percent(signal)} of the threshold"),
        ("Ambient", f"{ambient - ZERO_CELSIUS:.1f} °C"),
    ]
    facts += [(thing.name, _warm_object_text(thing)) for thing in things[:THINGS_SHOWN]]
    headline = _warm_headline(cause, bool(recorded.track.active[index]))
    return recorded.explanation(index, headline, tuple(facts), "", cause)


def _warm_object_text(thing: WarmObject) -> str:
    celsius = thing.temperature - ZERO_CELSIUS
    return f"changed by {thing.change:.3g} W/m², {celsius:.1f} °C, hit by {thing.rays} rays now"


def _warm_headline(cause: WarmCause, active: bool) -> str:
    over = abs(cause.signal) > 1.0
    moving = cause.things[0] if cause.things else None
    who = (
        f"{quoted(moving.name)} changed the radiation on the elements most"
        if moving
        else "nothing warmer or colder than the room moved through the zones"
    )
    signal = f"the signal is {percent(cause.signal)} of the threshold"
    if over:
        text = f"{who}; {signal}"
        ignored = f"Motion (ignored: warm-up or blocking time): {text}"
        return f"Motion: {text}" if active else ignored
    return f"Held on: {signal}; {who}" if active else f"Still: {signal}; {who}"


# m. A smaller movement counts as none.
UNCHANGED = 1e-6


def explain_motion(recorded: RecordedSensor, index: int) -> Explanation:
    """Explain update `index` of a motion detector of either model."""
    pyroelectric = recorded.parameters_at(index).model == "PYROELECTRIC"
    return (explain_pyroelectric if pyroelectric else explain_range_scan)(recorded, index)


def lacking(recorded: RecordedSensor, index: int, found: Explanation) -> Explanation:
    """Add facts to an explanation: what must change until the detector reports motion.

    `found` is the explanation of update `index`. Return it with the new facts before its other
    facts.
    """
    headline, facts = (
        found.headline,
        _missing_to_fire(recorded, index, found) if found.cause else [],
    )
    held = _why_waiting(recorded, index)
    if held:
        headline = f"{capital(held)}. {headline}"
        facts.insert(0, ("Output", held))
    return replace(found, headline=headline, facts=(*facts, *found.facts))


def _why_waiting(recorded: RecordedSensor, index: int) -> str:
    """Return why the detector cannot report movement yet, such as its warm-up; empty if it can."""
    track, pir = recorded.track, recorded.sensor.parameters
    now = track.times[index]
    on = np.flatnonzero(np.asarray(track.active)[:index])
    fell = track.times[int(on[-1]) + 1] if len(on) else -math.inf
    blocking = pir.blocking_time
    if pir.model == "PYROELECTRIC":
        blocking = max(blocking, pir.blanking_time)
    return waiting(pir.warm_up_time, blocking, now, fell)


def _missing_to_fire(recorded: RecordedSensor, index: int, found: Explanation) -> Facts:
    if recorded.sensor.parameters.model == "PYROELECTRIC":
        share = abs(found.cause.signal)
        if share > 1.0:
            return []
        text = f"the signal must exceed the threshold: it is {percent(share)} of it"
        facts = [("To fire", text)]
    else:
        cause, lengths = found.cause, recorded.lengths
        if cause.triggered:
            return []
        share = percent(cause.change / cause.threshold if cause.threshold else math.inf)
        much = f"the largest change is {share} of that"
        if _is_noise_alone(cause, recorded.sensor.parameters):
            much = "only noise changes the ranges"
        limit = lengths.typed(cause.threshold)
        facts = [("To fire", f"a range must change by more than {limit}: {much}")]
    return [*facts, ("Nearest movement", _nearest_movement(recorded, index, found))]


def _nearest_movement(recorded: RecordedSensor, index: int, found: Explanation) -> str:
    """Return a text on the nearest object that moved, and on why it was not reported."""
    if index == 0:
        return "unknown at the first update"
    earlier, at_update = surroundings(recorded, [index - 1, index])
    before, now, pose = earlier.bounds, at_update.bounds, at_update.pose
    moving = {
        name: now[name]
        for name in now.keys() & before.keys()
        if np.abs(now[name] - before[name]).max() > UNCHANGED
    }
    if not moving:
        return "nothing moves"
    places = {n: np.clip(pose.origin, b[0], b[1]) for n, b in moving.items()}
    away = {n: float(np.linalg.norm(place - pose.origin)) for n, place in places.items()}
    name = min(sorted(away), key=lambda n: away[n])
    text = f"{quoted(name)}, {recorded.lengths.text(away[name])} away"
    pir = recorded.sensor.parameters
    if name in _noticed_names(found):
        return f"{text}: seen, but the readings change too little or too slowly"
    if away[name] > pir.range_max:
        label = label_of(specs(recorded.sensor.kind.parameters)["range_max"], pir).lower()
        return f"{text}: beyond the {label} of {recorded.lengths.typed(pir.range_max)}"
    if pir.model == "RANGE_SCAN":
        middle = (moving[name].mean(axis=0) - pose.origin) @ pose.axes
        beside = abs(math.atan2(-middle[0], -middle[2]))
        half = pir.horizontal_fov / 2
        if beside > half:
            return (
                f"{text}: {math.degrees(beside):.0f}° beside the detector's axis, while the field "
                f"of view ends at {math.degrees(half):.0f}°"
            )
        return f"{text}: hidden, between the rays, or not at the tilt of this update"
    return f"{text}: hidden, outside the zones, as warm as its background, or too slow"


def _noticed_names(found: Explanation) -> set[str]:
    """Return the names of the objects that, by the explanation, changed the measured quantity."""
    cause = found.cause
    if isinstance(cause, WarmCause):
        return {thing.name for thing in cause.things}
    return {cause.culprit} if cause.change > SAME else set()
