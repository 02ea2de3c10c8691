# SPDX-License-Identifier: GPL-3.0-or-later
"""Explains the reading of a pad: which objects press on it, and with how much force."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ....sensor_logic.kind import FORCES
from ....sensor_logic.kinds.pressure import FORCE
from ....sensor_logic.kinds.pressure.model import pad_reading
from ....sensor_logic.kinds.pressure.parameters import PressureParameters
from ....sensor_logic.log.partner_names import split
from ....sensor_logic.quantities import Lengths, typed
from ....sensor_logic.wording import capital, quoted
from ...explain.facts import Explanation, at_frame, more_needed
from ...explain.replay import Replay
from .words import centre_text

# Tolerance relative to the recorded force, or to 1 N where that is more.
FORCE_TOLERANCE = 5e-3
# N: objects that press with less are left out.
LEAST_FORCE = 5e-3
newtons = FORCE.text


@dataclass(frozen=True)
class PadCause:
    """`partners`: the objects that press and their forces in N, the greatest first; `force`,
    `own_weight` along the pad's −Z and `threshold` in N; `centre` of pressure in m along the pad's
    axes; `problem`: why the forces are uncertain; `before`: the partners at the update before."""

    partners: tuple[tuple[str, float], ...]
    force: float
    own_weight: float
    threshold: float
    centre: tuple[float, float]
    problem: str
    before: tuple[str, ...]

    @property
    def because(self) -> str:
        """The object that presses most, or did at the update before."""
        return next(iter([name for name, _ in self.partners] or self.before), "")


def lacking(replay: Replay, index: int, found: Explanation) -> Explanation:
    """Adds why the pad is not pressed, before the other facts."""
    cause = found.cause
    if cause is None:
        return found
    facts = [("To be pressed", more_needed(cause.threshold, cause.force, "N"))]
    if not cause.partners:
        facts.append(("Nearest above", _nearest_above(replay, index) or "nothing stands above it"))
    return found.after(facts)


def _nearest_above(replay: Replay, index: int) -> str:
    """The nearest object above a pad, and its distance; empty without any."""
    found = replay.bounds(index, own=True)
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


def explain_pad(replay: Replay, index: int) -> Explanation:
    """Update `index` of a pad. Raises AngenError."""
    track, sensor = replay.track, replay.sensor
    pending = replay.take_moved(index)
    if pending is None:
        return replay.off(index)
    contact = pending.update.ask(FORCES)
    reading = replay.runner.model.update(
        pending.parameters, replace(pending.update, scene={FORCES: lambda: contact})
    )
    parameters: PressureParameters = pending.parameters
    pose = pending.update.pose
    weightless = replace(contact, weight=np.zeros(3))
    shares: dict[str, float] = {}
    for partner in contact.forces.partners:
        alone = replace(weightless, forces=replace(contact.forces, partners=(partner,)))
        force = pad_reading(parameters, pose, alone).force
        if abs(force) > LEAST_FORCE:
            shares[partner.name] = shares.get(partner.name, 0.0) + force
    own = 0.0
    if not parameters.subtract_own_weight:
        own = float(contact.weight @ -pose.axes[:, 2])
    cause = PadCause(
        tuple(sorted(shares.items(), key=lambda item: (-item[1], item[0]))),
        float(reading.value),
        own,
        parameters.threshold,
        (reading.fields["cop_x_m"], reading.fields["cop_y_m"]),
        reading.fields["problem"],
        tuple(split(track.columns["partners"][index - 1])) if index else (),
    )
    recorded = float(track.value[index])
    doubt = ""
    if abs(recorded - cause.force) > FORCE_TOLERANCE * max(1.0, abs(recorded)):
        doubt = (
            f"{newtons(recorded)} was recorded, {newtons(cause.force)} is found now: something has "
            "changed since, or the reading depends on frames long before. Simulate again"
        )
    elif cause.problem:
        doubt = cause.problem
    facts = _facts(cause, replay.lengths)
    if index > 0:
        names = ", ".join(cause.before)
        by = f", {names}" if names else ""
        when = at_frame(track.frames[index - 1], track.times[index - 1])
        facts.append(("Before", f"{newtons(track.value[index - 1])}{by}, at {when}"))
    headline = _headline(cause, sensor.kind.active_label, sensor.kind.idle_label)
    return replay.explanation(index, headline, tuple(facts), doubt, cause)


def _facts(cause: PadCause, lengths: Lengths) -> list[tuple[str, str]]:
    facts = [(name, newtons(force)) for name, force in cause.partners]
    if cause.own_weight:
        facts.append(("Own weight", newtons(cause.own_weight)))
    facts.append(("Force", f"{newtons(cause.force)}, threshold {typed(cause.threshold, 'N')}"))
    if np.isfinite(cause.centre).all():
        facts.append(("Centre", f"{centre_text(*cause.centre, lengths)} from the pad's origin"))
    return facts


def _headline(cause: PadCause, pressed: str, free: str) -> str:
    by = " and ".join(f"{quoted(name)} with {force:.1f} N" for name, force in cause.partners[:3])
    more = len(cause.partners) - 3
    by += f" and {more} more" if more > 0 else ""
    if cause.force > cause.threshold:
        return f"{pressed} by {by}" if by else f"{pressed}: {newtons(cause.force)}"
    if by:
        return f"{free}: {by} is not more than the threshold of {typed(cause.threshold, 'N')}"
    return capital(f"{free}: nothing presses on it")
