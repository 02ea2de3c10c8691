# SPDX-License-Identifier: GPL-3.0-or-later
"""Explain why a presence radar reported somebody, or why it did not."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ....sensor_logic.evidence import rows_of
from ....sensor_logic.kinds.presence_radar.gate_evidence import gate_energies, is_off
from ....sensor_logic.kinds.presence_radar.parameters import THRESHOLDS, RadarParameters
from ....sensor_logic.logs.wording import named
from ...appearance.facts import Explanation, Facts
from ...appearance.recorded import RecordedSensor
from .figure import gate_span

NAMES_SHOWN = 3


@dataclass(frozen=True)
class RadarCause:
    """The gate of a presence radar that decides its reading.

    Attributes
    ----------
    gate
        The number of the strongest gate that detects anything, from 0. Without one, that of the
        gate with the energy nearest to its threshold.
    detects
        Whether the gate detects anything.
    moving
        Whether the gate is chosen for movement, not for breathing.
    energy, threshold
        The energy of the gate, and its threshold.
    distance, speed
        The recorded distance in m, and the radial speed in m/s of what moves in the gate, weighted
        by power.
    names
        The objects in the gate that return power, the strongest first.
    through
        The objects that the waves passed on the way to the first of these.
    loss
        The mean one-way loss in dB on the way.
    stops
        The objects that stop the waves, those with the greatest share of the waves first.
    """

    gate: int
    detects: bool
    moving: bool
    energy: float
    threshold: float
    distance: float
    speed: float
    names: tuple[str, ...]
    through: tuple[str, ...]
    loss: float
    stops: tuple[str, ...]


def explain_radar(recorded: RecordedSensor, index: int) -> Explanation:
    """Explain update `index` of a presence radar by its strongest gate that detects anything."""
    parameters: RadarParameters = recorded.parameters_at(index)
    cause = _cause(recorded, parameters, index)
    facts = _facts(recorded, parameters, cause, index)
    if index > 0:
        before = recorded.word(index - 1).lower()
        facts.append(("Before", f"{before}, at {recorded.when(index - 1)}"))
    headline = f"{recorded.word(index)}: {_headline(recorded, parameters, cause, index)}"
    return recorded.explanation(index, headline, facts, "", cause)


def _cause(recorded: RecordedSensor, parameters: RadarParameters, index: int) -> RadarCause:
    """Return the gate that decides the reading."""
    gate, detects, moving, speed, loss = (
        recorded.evidence(name, index)
        for name in ("gate", "detects", "by_movement", "speed", "loss")
    )
    objects, through, stops = (
        tuple(name for (name,) in rows_of(recorded.evidence(field, index)))
        for field in ("objects", "through", "stops")
    )
    columns, which = recorded.track.columns, 0 if moving else 1
    return RadarCause(
        gate,
        bool(detects),
        bool(moving),
        gate_energies(columns["gates"][index])[gate][which],
        float(parameters.by_gate(THRESHOLDS[which])[gate]),
        float(columns["distance_m"][index]),
        speed,
        objects,
        through,
        loss,
        stops,
    )


def _headline(
    recorded: RecordedSensor, parameters: RadarParameters, cause: RadarCause, index: int
) -> str:
    lengths = recorded.lengths
    if not cause.detects:
        if recorded.track.active[index]:
            held = f"presence stays on for {parameters.hold_time:g} s after that"
            return f"nothing is detected now; {held}"
        return "nothing exceeds the threshold of a gate"
    if not cause.names:
        return f"the still energy of who was here fades in gate {cause.gate}"
    what = named(cause.names, NAMES_SHOWN)
    away = lengths.text(cause.distance)
    text = f"{what} moves, {away} away" if cause.moving else f"{what} breathes, {away} away"
    return f"{text}, seen through {named(cause.through)}" if cause.through else text


def _facts(
    recorded: RecordedSensor, parameters: RadarParameters, cause: RadarCause, index: int
) -> Facts:
    stops: Facts = []
    if not cause.detects and cause.stops:
        stops = [("Waves stop at", named(cause.stops, NAMES_SHOWN))]
    if not cause.names:
        return stops
    lengths = recorded.lengths
    energy = f"{cause.energy:.0f} of 100, above {cause.threshold:g}"
    if not cause.detects:
        energy = f"{cause.energy:.0f} of 100, not above {cause.threshold:g}"
    # The panel of events has room for names of 14 letters and texts of 22.
    facts: Facts = [
        ("Gate", f"{cause.gate}, {gate_span(parameters, cause.gate, lengths)}"),
        ("Moving energy" if cause.moving else "Still energy", energy),
    ]
    if cause.detects and cause.moving:
        speed = f"{abs(cause.speed):.2f} m/s"
        way = f"{speed} away" if cause.speed > 0.0 else f"{speed} towards it"
        facts.append(("Speed", way))
    if cause.through:
        facts.append(("Passed", f"{named(cause.through)}: {2.0 * cause.loss:.1f} dB both ways"))
    if parameters.max_targets:
        facts.append(("Targets", str(recorded.track.columns["targets"][index])))
    return facts + stops


def lacking(recorded: RecordedSensor, index: int, found: Explanation) -> Explanation:
    """Add a fact to an explanation: how much more energy would make the radar detect somebody.

    `found` is the explanation of update `index`. Return it with the fact before its other facts.
    """
    cause: Any = found.cause
    if cause is None or cause.detects:
        return found
    kind = "movement" if cause.moving else "breathing"
    if not cause.names:
        return found.after([("To be present", "nothing that moves or breathes is in sight")])
    if is_off(cause.threshold):
        text = f"gate {cause.gate} is switched off for {kind}: its threshold is {cause.threshold:g}"
        return found.after([("To be present", text), ("Nearest to it", named(cause.names))])
    text = (
        f"more than {cause.threshold:g} of 100 is needed in gate {cause.gate}: the energy of "
        f"{kind} is {cause.energy:.0f}"
    )
    return found.after([("To be present", text), ("Nearest to it", named(cause.names))])
