# SPDX-License-Identifier: GPL-3.0-or-later
"""The appearance of optical switches: housings, the beam in the viewport, and explanations.

The housing is a fork that stands on a surface. Its beam runs parallel to the surface.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from ...sensor_logic.kinds.optical_switch import SWITCHING_LEVEL, OpticalSwitchParameters
from ...sensor_logic.logs.wording import Lengths, percent, quoted
from ..appearance.appearance import Appearance
from ..appearance.facts import Explanation, Facts
from ..appearance.figures import Figure, beams, dashes, ends_of
from ..appearance.handles import ahead
from ..appearance.housing import Housing, beside_it
from ..appearance.recorded import RecordedSensor
from ..runtime.trace import CastRays


@dataclass(frozen=True)
class Beam:
    """What the beam of an optical switch hits at one update.

    Attributes
    ----------
    range
        The shortest range of the beam's rays, in m.
    name
        The object that the ray with this range hits; empty without a hit.
    light
        The fraction of the light that passes, from 0 to 1.
    rays
        The number of rays.
    ago
        Time in s from the crossing to this update. None if no object crossed the beam since the
        update before.
    """

    range: float
    name: str
    light: float
    rays: int
    ago: float | None = None


@dataclass(frozen=True)
class BeamCause:
    """The beams at two updates, which explain why an optical switch is open or closed.

    Attributes
    ----------
    before, now
        The beam at the previous update (None if it is unknown), and at this one.
    open
        Whether the switch is open at this update.
    threshold
        The range in m below which an object breaks the beam.
    """

    before: Beam | None
    now: Beam
    open: bool
    threshold: float


def lacking(recorded: RecordedSensor, index: int, found: Explanation) -> Explanation:
    """Add a fact to an explanation: what must change until the switch opens.

    `found` is the explanation of update `index`. Return it with the fact before its other facts.
    """
    return found.after(_missing(found.cause, recorded.lengths))


def _missing(cause: BeamCause, lengths: Lengths) -> Facts:
    now = cause.now
    if now.rays > 1:
        return [("To open", f"more light must pass: now {percent(now.light)}")]
    short = cause.threshold - now.range
    what = quoted(now.name) if now.name else "something"
    if short <= 0.0:
        return [("To open", "the beam must stay free until the next update")]
    return [
        (
            "To open",
            f"the beam must be free up to {lengths.typed(cause.threshold)}: {what} blocks it "
            f"{lengths.text(short)} before that",
        )
    ]


def explain_switch(recorded: RecordedSensor, index: int) -> Explanation:
    """Explain update `index` of an optical switch by the objects in its beam."""
    earlier = recorded.index_of(recorded.update_number(index) - 1, index)
    before = None if earlier is None or earlier == index else _beam(recorded, earlier)
    parameters: OpticalSwitchParameters = recorded.parameters_at(index)
    now, lengths = _beam(recorded, index), recorded.lengths
    cause = BeamCause(before, now, bool(recorded.track.active[index]), parameters.threshold)
    facts = [("Now", _beam_text(now, parameters, lengths))]
    if before is not None and earlier is not None:
        text = _beam_text(before, parameters, lengths)
        facts.append(("Before", f"{text}, at {recorded.when(earlier)}"))
    facts.append(("Opens from", lengths.typed(parameters.threshold)))
    if now.rays > 1:
        half = parameters.hysteresis / 2
        opens, closes = percent(SWITCHING_LEVEL + half), percent(SWITCHING_LEVEL - half)
        levels = f"opens from {opens}, closes below {closes}"
        facts.append(("Light", f"{percent(now.light)} of the full light; {levels}"))
    if parameters.noise_sigma > 0.0:
        sigma = lengths.typed(parameters.noise_sigma)
        facts.append(("Noise", f"{sigma} (standard deviation) on the range"))
    headline = _headline(cause, parameters, lengths)
    return recorded.explanation(index, headline, tuple(facts), "", cause)


def _beam(recorded: RecordedSensor, index: int) -> Beam:
    """Return the beam at update `index`."""
    steps = recorded.evidence("steps_ago", index)
    return Beam(
        recorded.track.columns["range_m"][index],
        recorded.evidence("object", index),
        recorded.evidence("light", index),
        recorded.parameters_at(index).aperture_rays,
        None if math.isnan(steps) else steps / float(recorded.clock.steps_per_second),
    )


def _beam_text(beam: Beam, parameters: OpticalSwitchParameters, lengths: Lengths) -> str:
    if beam.ago is not None:
        return f"{_crossing_object(beam)} at {lengths.text(beam.range)}, {beam.ago:.3f} s before"
    if not beam.name:
        return f"nothing within {lengths.typed(parameters.range_max)}"
    return f"{quoted(beam.name)} at {lengths.text(beam.range)}"


def _crossing_object(beam: Beam) -> str:
    return quoted(beam.name) if beam.name else "something"


def _headline(cause: BeamCause, parameters: OpticalSwitchParameters, lengths: Lengths) -> str:
    now, before = cause.now, cause.before
    if now.ago is not None:
        return (
            f"Closed: {_crossing_object(now)} went through the beam {lengths.text(now.range)} "
            f"from the sensor, {now.ago:.3f} s before this update"
        )
    broken = now.range < parameters.threshold
    if not cause.open:
        if not broken:
            return f"Still closed: only {percent(now.light)} of the light passes"
        return (
            f"Closed: {quoted(now.name) if now.name else 'noise'} breaks the beam "
            f"{lengths.text(now.range)} from the sensor"
        )
    if broken:
        covers = quoted(now.name) if now.name else "noise"
        return f"Still open: {covers} covers a part of the beam, {percent(now.light)} of it passes"
    text = "Open: nothing breaks the beam"
    if before is not None and before.range < parameters.threshold and before.name:
        text = f"Open: {quoted(before.name)} no longer breaks the beam"
    return f"{text}, which reaches {quoted(now.name)}" if now.name else text


# m. Sizes of the marks on a beam.
LARGEST_MARK, LEAST_MARK = 0.04, 0.004


def beam_figure(seen: Any, number: int, cast: CastRays, metres: float) -> Figure:
    """Draw the beam up to its hit, with a cross at the hit and a dashed line behind it.

    A bar marks the threshold, the range from which the switch is open. `seen` is the `DrawnSensor`,
    and `number` the number of the ray bundle. `cast` has the rays with their ranges. `metres` is
    the length of a Blender unit in m.
    """
    drawn = beams(seen, number, cast, metres)
    _, (ends,), (hit,) = ends_of(cast, metres)
    parameters, pose = seen.parameters, seen.pose
    size = min(max(parameters.range_max / 10, LEAST_MARK), LARGEST_MARK) / metres
    across, up = pose.axes[:, 0] * size, pose.axes[:, 1] * size
    for place in ends[hit]:
        drawn.add("break", (place - across - up, place + across + up))
        drawn.add("break", (place - across + up, place + across - up))
    far = (cast.origins + cast.directions * cast.reach[:, None]) / metres
    for place, end in zip(ends[hit], far[hit], strict=True):
        drawn.add("dark", dashes(place, end))
    gate = (pose.origin - pose.axes[:, 2] * parameters.threshold) / metres
    drawn.add("gate", (gate - across / 2, gate + across / 2), (gate - up / 2, gate + up / 2))
    return drawn


# Forks of slotted switches. The default fork fits around a flag on a door. A part whose outer sizes
# are unknown has its own gap, and the other sizes of Vishay's part (data sheet 83764).


def fork(gap: float, across: float, along: float, height: float) -> Housing:
    """Return the housing of a slotted switch: two arms with a gap between them, on a base.

    Parameters
    ----------
    gap
        Distance between the arms, in m.
    across, along
        Outer sizes across the arms and along them, in m.
    height
        Height above the surface, in m. The beam is a quarter of it below the tips of the arms.
    """
    arm, x = (across - gap) / 2, along / 2
    tip, base = -height / 4, height * 3 / 4
    inner = base - height / 4
    housing = Housing()
    housing.box((-x, tip, 0.0), (x, inner, arm)).box((-x, tip, -gap - arm), (x, inner, -gap))
    housing.box((-x, inner, -gap - arm), (x, base, arm))
    return housing.lines([(0, 0, 0), (0, 0, -gap)], [(0, 1)])


def _tcst() -> Housing:
    return fork(0.0031, 0.0119, 0.0063, 0.0108)


HOUSINGS = {
    "": lambda: fork(0.05, 0.09, 0.024, 0.06),
    "TCST1103": _tcst,
    "TCST1202": _tcst,
    "TCST1300": _tcst,
    "GP1A51HR": lambda: fork(0.003, 0.0122, 0.0063, 0.01),
    "GP1A53HR": lambda: fork(0.005, 0.0137, 0.0063, 0.01),
    "EE_SX670": lambda: fork(0.005, 0.0138, 0.0063, 0.0108),
}


APPEARANCE = Appearance(
    HOUSINGS,
    beside_it,
    rays_figure=beam_figure,
    handles=(ahead("range_max"), ahead("threshold")),
    explain=explain_switch,
    lacking=lacking,
)
