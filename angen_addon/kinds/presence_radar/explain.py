# SPDX-License-Identifier: GPL-3.0-or-later
"""Explain why a presence radar reported somebody, or why it did not."""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....sensor_logic.kinds.presence_radar.parameters import (
    NEVER,
    OFF,
    THRESHOLDS,
    RadarParameters,
)
from ....sensor_logic.kinds.presence_radar.radar import (
    Noise,
    Sweep,
    amplitude,
    amplitudes,
    calibration,
    energies,
    find_targets,
    gate_energies,
    hann,
    radar_beams,
    sweep,
    with_floors,
)
from ....sensor_logic.model import Array, Updates
from ....sensor_logic.radio.echoes import ECHOES, Echoes
from ....sensor_logic.wording import named
from ...explain.facts import Explanation, Facts, at_frame
from ...explain.replay import Replay
from .figure import gate_span

# The scene has changed if an energy differs by more than this: recorded ones are whole numbers.
ENERGY_TOLERANCE = 1.0
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

    @property
    def cause_name(self) -> str:
        """The name of the object that the radar detects; empty if it detects nothing."""
        return self.names[0] if self.detects and self.names else ""


def explain_radar(replay: Replay, index: int) -> Explanation:
    """Explain update `index` of a presence radar by its strongest gate that detects anything.

    Raise `AngenError` if the sensor cannot be read.
    """
    track = replay.track
    replay.sense_before(index)
    pending = replay.take_update(index)
    if pending is None:
        return replay.explain_off(index)
    parameters = pending.parameters
    again = _repeat(replay, parameters, pending.updates, index)
    cause = _cause(replay, parameters, again, index)
    facts = _facts(replay, parameters, cause, again)
    if index > 0:
        word = _word(replay, index - 1).lower()
        facts.append(
            ("Before", f"{word}, at {at_frame(track.frames[index - 1], track.times[index - 1])}")
        )
    differing = _differing(replay, again, index)
    doubt = ""
    if differing:
        doubt = f"{differing}: something has changed since the run. Simulate again"
    headline = f"{_word(replay, index)}: {_headline(replay, parameters, cause, index)}"
    return replay.explanation(index, headline, facts, doubt, cause)


@dataclass(frozen=True)
class Repeated:
    """What the scene gives now at a recorded update.

    Attributes
    ----------
    echoes, seen
        What the rays hit, and what the radar receives.
    weight
        The weights (n,) of the rays, as in `Beams`.
    energies
        The energies (2, gates), clipped. The still ones are a mean over the time before, so they
        are computed from those of the update before, as recorded.
    is_known
        Whether each of the energies is known (2, gates): a still one is not where the energy before
        was clipped, or is not in the recording.
    thresholds
        The thresholds (2, gates), as in the parameters.
    detects
        Whether each gate detects, by the energy of movement now and the recorded still one.
    targets
        The number of targets.
    """

    echoes: Echoes
    seen: Sweep
    weight: Array
    energies: Array
    is_known: NDArray[np.bool_]
    thresholds: Array
    detects: NDArray[np.bool_]
    targets: int


def _repeat(replay: Replay, parameters: RadarParameters, updates: Updates, index: int) -> Repeated:
    """Return what the scene gives now at update `index`, with the same noise as in the run."""
    track = replay.track
    beams, known = radar_beams(parameters, updates.pose), calibration(parameters)
    rays = beams.origins, beams.directions, beams.length
    how = parameters.frequency, parameters.integration_time
    echoes: Echoes = updates.ask(ECHOES, 0, *rays, *how)[0]
    seen = sweep(parameters, known, beams, echoes)
    drawn = Noise().draw(parameters, updates.numbers[:1], updates.noise)
    echo = amplitudes(parameters, seen.profile.cells[None], seen.profile.gates[None], drawn)
    found = with_floors(parameters, known, echo, drawn)
    recorded = np.array(gate_energies(track.columns["gates"][index])).T
    is_known = np.ones(found.shape[1:], bool)
    before = replay.index_of(replay.update_number(index) - 1, index)
    if before == index or before is None:
        is_known[1] = index == 0 and replay.update_number(index) == 0
    else:
        past = np.array(gate_energies(track.columns["gates"][before]))[:, 1]
        new = -math.expm1((track.times[before] - track.times[index]) / parameters.still_time)
        found[0, 1] = (1.0 - new) * amplitude(parameters, past) + new * found[0, 1]
        is_known[1] = past < 100.0
    energy = energies(parameters, found, drawn)
    detects = np.stack([energy[0, 0] > known.thresholds[0], np.zeros(len(is_known[0]), bool)])
    if recorded.shape == is_known.shape:
        detects[1] = recorded[1] > known.thresholds[1]
    shown = np.where(known.is_on, np.clip(energy[0], 0.0, 100.0), 0.0)
    count = len(find_targets(parameters, known, seen, drawn)[0])
    needed = np.stack([parameters.by_gate(name) for name in THRESHOLDS])
    return Repeated(echoes, seen, beams.weight, shown, is_known, needed, detects, count)


def _differing(replay: Replay, again: Repeated, index: int) -> str:
    """Return how the recording differs from what the scene now gives; empty if it does not."""
    columns = replay.track.columns
    words = "no movement", "movement"
    then, now = bool(columns["moving"][index]), bool(again.detects[0].any())
    if then != now:
        return f"the recording has {words[then]}, but the scene now gives {words[now]}"
    recorded = np.array(gate_energies(columns["gates"][index])).T
    if recorded.shape != again.energies.shape:
        return "the recording has another number of gates"
    far = np.abs(recorded - again.energies) > ENERGY_TOLERANCE
    if (far & again.is_known).any():
        return "the recording has other energies than the scene now gives"
    return ""


def _word(replay: Replay, index: int) -> str:
    kind = replay.sensor.kind
    return kind.active_label if replay.track.active[index] else kind.idle_label


def _cause(replay: Replay, parameters: RadarParameters, again: Repeated, index: int) -> RadarCause:
    """Return the gate that decides the reading."""
    echoes, powers = again.echoes, again.seen.powers
    detects = again.detects
    if not replay.track.active[index]:
        # Without an earlier movement, the still energies do not count.
        detects = detects & np.array([[True], [False]])
    # The energies of echoes alone: floors are everywhere.
    echo = again.seen.profile.gates
    if detects.any():
        which = 0 if detects[0].any() else 1
        gate = int(
            np.where(detects[which], np.maximum(again.energies[which], echo[which]), -1).argmax()
        )
    else:
        # Where all gates that receive anything are switched off, take the strongest.
        shares = np.where(_is_off(again.thresholds), 0.0, echo / again.thresholds.clip(1e-9))
        best = int(np.argmax(shares if shares.any() else echo))
        which, gate = divmod(best, echo.shape[1])
    power = powers[which] * hann(echoes.ranges / parameters.bin_length - gate) ** 2
    total = float(power.sum())
    share = power / total if total else power
    met = _names(replay, echoes, share)
    speed = again.seen.speed
    return RadarCause(
        gate,
        bool(detects.any()),
        which == 0,
        float(again.energies[which, gate]),
        float(again.thresholds[which, gate]),
        float(replay.track.columns["distance_m"][index]),
        float(share @ speed),
        met,
        _passed(replay, echoes, share, met),
        float(share @ echoes.loss),
        _names(replay, echoes, np.where(echoes.reflectance > 0.0, again.weight, 0.0)),
    )


def _names(replay: Replay, echoes: Echoes, share: Array) -> tuple[str, ...]:
    """Return the names of the objects that rays hit, those with the greatest `share` (n,) first."""
    found: dict[str, float] = defaultdict(float)
    for ray in np.flatnonzero(share > 0.0).tolist():
        found[replay.name_of(int(echoes.solid[ray]))] += float(share[ray])
    return tuple(sorted(found, key=lambda name: -found[name]))


def _passed(replay: Replay, echoes: Echoes, share: Array, met: tuple[str, ...]) -> tuple[str, ...]:
    """Return the names of the objects that rays to the first of the objects `met` passed."""
    if not met:
        return ()
    rays = [
        ray
        for ray in np.flatnonzero(share > 0.0).tolist()
        if replay.name_of(int(echoes.solid[ray])) == met[0]
    ]
    names = (name for ray in rays for name in echoes.through.get(ray, ()))
    return tuple(dict.fromkeys(names))


def _headline(replay: Replay, parameters: RadarParameters, cause: RadarCause, index: int) -> str:
    lengths = replay.lengths
    if not cause.detects:
        if replay.track.active[index]:
            held = f"presence stays on for {parameters.hold_time:g} s after that"
            return f"nothing is detected now; {held}"
        return "nothing exceeds the threshold of a gate"
    if not cause.names:
        return f"the still energy of who was here fades in gate {cause.gate}"
    what = named(cause.names, NAMES_SHOWN)
    does = "moves" if cause.moving else "breathes"
    text = f"{what} {does}, {lengths.text(cause.distance)} away"
    return f"{text}, seen through {named(cause.through)}" if cause.through else text


def _facts(
    replay: Replay, parameters: RadarParameters, cause: RadarCause, again: Repeated
) -> Facts:
    stops: Facts = []
    if not cause.detects and cause.stops:
        stops = [("Waves stop at", named(cause.stops, NAMES_SHOWN))]
    if not cause.names:
        return stops
    lengths = replay.lengths
    energy = f"{cause.energy:.0f} of 100, {'' if cause.detects else 'not '}above"
    # The panel of events has room for names of 14 letters and texts of 22.
    facts: Facts = [
        ("Gate", f"{cause.gate}, {gate_span(parameters, cause.gate, lengths)}"),
        ("Moving energy" if cause.moving else "Still energy", f"{energy} {cause.threshold:g}"),
    ]
    if cause.detects and cause.moving:
        way = "away" if cause.speed > 0.0 else "towards it"
        facts.append(("Speed", f"{abs(cause.speed):.2f} m/s {way}"))
    if cause.through:
        facts.append(("Passed", f"{named(cause.through)}: {2.0 * cause.loss:.1f} dB both ways"))
    if parameters.max_targets:
        facts.append(("Targets", str(again.targets)))
    return facts + stops


def _is_off(thresholds: Any) -> Any:
    return (thresholds <= OFF) | (thresholds >= NEVER)


def lacking(replay: Replay, index: int, found: Explanation) -> Explanation:
    """Add a fact to an explanation: how much more energy would make the radar detect somebody.

    `found` is the explanation of update `index`. Return it with the fact before its other facts.
    """
    cause: Any = found.cause
    if cause is None or cause.detects:
        return found
    kind = "movement" if cause.moving else "breathing"
    if not cause.names:
        return found.after([("To be present", "nothing that moves or breathes is in sight")])
    if _is_off(cause.threshold):
        text = f"gate {cause.gate} is switched off for {kind}: its threshold is {cause.threshold:g}"
        return found.after([("To be present", text), ("Nearest to it", named(cause.names))])
    text = (
        f"more than {cause.threshold:g} of 100 is needed in gate {cause.gate}: the energy of "
        f"{kind} is {cause.energy:.0f}"
    )
    return found.after([("To be present", text), ("Nearest to it", named(cause.names))])
