# SPDX-License-Identifier: GPL-3.0-or-later
"""Explain why a presence radar reported somebody, or why it did not."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from typing import Any

import numpy as np

from ....sensor_logic.kinds.presence_radar.parameters import NEVER, RadarParameters
from ....sensor_logic.kinds.presence_radar.radar import (
    Measurement,
    calibration,
    gate_energies,
    measure,
    radar_beams,
    sweep,
)
from ....sensor_logic.model import Array, Update
from ....sensor_logic.radio.echoes import ECHOES, Echoes
from ....sensor_logic.wording import named
from ...explain.facts import Explanation, Facts, at_frame
from ...explain.replay import Replay
from .figure import gate_span

# m. The scene has changed if the recorded distance differs by more than this.
TOLERANCE = 1e-6
# So it has if an energy differs by more than this: energies are recorded as whole numbers.
ENERGY_TOLERANCE = 1.0
NAMES_SHOWN = 3


@dataclass(frozen=True)
class RadarCause:
    """The gate of a presence radar that decides its reading.

    Attributes
    ----------
    gate
        The number of the nearest gate that detects anything, from 1. Without one, that of the gate
        with the power nearest to the one it needs.
    detects
        Whether the gate detects anything.
    moving
        Whether the gate is chosen for movement, not for breathing.
    energy, threshold
        The energy of the gate, and its threshold.
    distance, speed
        The distance in m of what the gate detects, noise included, and its radial speed in m/s,
        weighted by power.
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
    """Explain update `index` of a presence radar by its nearest gate that detects anything.

    Raise `AngenError` if the sensor cannot be read.
    """
    track = replay.track
    replay.sense_before(index)
    pending = replay.take_update(index)
    if pending is None:
        return replay.explain_off(index)
    parameters, update = pending.parameters, pending.update
    cause, measured = _cause(replay, parameters, update)
    facts = _facts(replay, parameters, cause, measured)
    if index > 0:
        word = _word(replay, index - 1).lower()
        facts.append(
            ("Before", f"{word}, at {at_frame(track.frames[index - 1], track.times[index - 1])}")
        )
    differing = _differing(replay, parameters, measured, index)
    doubt = ""
    if differing:
        doubt = f"{differing}: something has changed since the run. Simulate again"
    headline = f"{_word(replay, index)}: {_headline(replay, parameters, cause, index)}"
    return replay.explanation(index, headline, facts, doubt, cause)


def _differing(
    replay: Replay, parameters: RadarParameters, measured: Measurement, index: int
) -> str:
    """Return how the recording differs from what the scene now gives; empty if it does not."""
    track, text = replay.track, replay.lengths.text
    columns = track.columns
    detects = measured.distance is not None
    # Without a hold time, or after an update without presence, presence needs a detection.
    may_be_held = index > 0 and bool(track.active[index - 1]) and parameters.hold_time > 0.0
    pairs = (
        (
            ("no detection", "a detection"),
            bool(track.active[index]) and (detects or not may_be_held),
            detects,
        ),
        (("no movement", "movement"), bool(columns["moving"][index]), bool(measured.moving.any())),
    )
    for words, then, now in pairs:
        if then != now:
            return f"the recording has {words[then]}, but the scene now gives {words[now]}"
    recorded = float(columns["distance_m"][index])
    if measured.distance is not None and abs(recorded - measured.distance) > TOLERANCE:
        return (
            f"the recording has {text(recorded)}, but the scene now gives {text(measured.distance)}"
        )
    energies = np.array(gate_energies(columns["gates"][index]))
    again = np.stack([measured.moving_energy, measured.still_energy], axis=1)
    if energies.shape != again.shape or np.abs(energies - again).max() > ENERGY_TOLERANCE:
        return "the recording has other energies than the scene now gives"
    return ""


def _word(replay: Replay, index: int) -> str:
    kind = replay.sensor.kind
    return kind.active_label if replay.track.active[index] else kind.idle_label


def _echoes(parameters: RadarParameters, update: Update) -> Echoes:
    beams = radar_beams(parameters, update.pose)
    rays = beams.origins, beams.directions, beams.length
    how = parameters.frequency, parameters.integration_time
    found: Echoes = update.ask(ECHOES, 0, *rays, *how)
    return found


def _cause(
    replay: Replay, parameters: RadarParameters, update: Update
) -> tuple[RadarCause, Measurement]:
    """Return the gate that decides the reading, and the measurement at this update."""
    beams, known = radar_beams(parameters, update.pose), calibration(parameters)
    echoes = _echoes(parameters, update)
    is_noisy = parameters.energy_noise or parameters.range_noise or parameters.angle_noise
    generator = update.noise() if is_noisy else None
    measured = measure(parameters, known, beams, echoes, generator)
    seen = sweep(parameters, beams.weight, echoes)
    energies = np.stack([measured.moving_energy, measured.still_energy])
    names = "moving_thresholds", "still_thresholds"
    thresholds = np.stack([parameters.thresholds(name) for name in names])
    detected = np.stack([measured.moving, measured.still])
    if detected.any():
        gate = int(np.argmax(detected.any(axis=0)))
        which = 0 if detected[0, gate] else 1
    else:
        # Energies end at 0: powers also compare what is weaker. Where all gates that receive
        # anything are switched off, take the strongest.
        powers = np.stack([seen.moving, seen.still])
        shares = powers / np.stack([known.moving_needed, known.still_needed])
        best = np.argmax(shares if shares.any() else powers)
        which, gate = (int(i) for i in np.unravel_index(best, powers.shape))
    power = (seen.moving_power, seen.still_power)[which]
    power = np.where(seen.gate == gate, power, 0.0)
    total = float(power.sum())
    share = power / total if total else power
    met = _names(replay, echoes, share)
    return (
        RadarCause(
            gate + 1,
            bool(detected.any()),
            which == 0,
            float(energies[which, gate]),
            float(thresholds[which, gate]),
            parameters.range_max if measured.distance is None else measured.distance,
            float(share @ seen.speed),
            met,
            _passed(replay, echoes, share, met),
            float(share @ echoes.loss),
            _names(replay, echoes, np.where(echoes.reflectance > 0.0, beams.weight, 0.0)),
        ),
        measured,
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
    what = named(cause.names, NAMES_SHOWN) or "something"
    does = "moves" if cause.moving else "breathes"
    text = f"{what} {does}, {lengths.text(cause.distance)} away"
    return f"{text}, seen through {named(cause.through)}" if cause.through else text


def _facts(
    replay: Replay, parameters: RadarParameters, cause: RadarCause, measured: Measurement
) -> Facts:
    stops: Facts = []
    if not cause.detects and cause.stops:
        stops = [("Waves stop at", named(cause.stops, NAMES_SHOWN))]
    if not cause.names:
        return stops
    lengths = replay.lengths
    energy = f"energy {cause.energy:.0f}, {'' if cause.detects else 'not '}above"
    # The panel of events has room for names of 14 letters and texts of 22.
    facts: Facts = [
        ("Gate", f"{cause.gate}, {gate_span(parameters, cause.gate - 1, lengths)}"),
        ("Movement" if cause.moving else "Breathing", f"{energy} {cause.threshold:g}"),
    ]
    if cause.detects and cause.moving:
        way = "away" if cause.speed > 0.0 else "towards it"
        facts.append(("Speed", f"{abs(cause.speed):.2f} m/s {way}"))
    if cause.through:
        facts.append(("Passed", f"{named(cause.through)}: {2.0 * cause.loss:.1f} dB both ways"))
    if parameters.max_targets:
        facts.append(("Targets", str(len(measured.targets))))
    return facts + stops


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
    if cause.threshold >= NEVER:
        text = f"gate {cause.gate} is switched off for {kind}: its threshold is {NEVER:g}"
        return found.after([("To be present", text), ("Nearest to it", named(cause.names))])
    text = (
        f"more than {cause.threshold:g} is needed in gate {cause.gate}: the energy of {kind} is "
        f"{cause.energy:.0f}"
    )
    return found.after([("To be present", text), ("Nearest to it", named(cause.names))])
