# SPDX-License-Identifier: GPL-3.0-or-later
"""Explains a pyroelectric detector by the object that changed the power on its elements most."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from ....sensor_logic.kind import WARMTH
from ....sensor_logic.kinds.pir.pyroelectric.detector import threshold_of, zones_of
from ....sensor_logic.kinds.pir.pyroelectric.radiance import STEFAN_BOLTZMANN, radiosity
from ....sensor_logic.kinds.pir.pyroelectric.zones import zone_rays
from ....sensor_logic.kinds.pir.range_scan import PirParameters
from ....sensor_logic.model import Array, Emission
from ....sensor_logic.wording import quoted
from ...explain.facts import Explanation
from ...explain.replay import Replay

# s: changes longer ago than this have mostly decayed in the amplifier.
WINDOW = 0.5
# s: the signal may swing over the threshold once more this long after a movement.
SWING_BACK = 2.0
MOST_UPDATES = 12
ZERO_CELSIUS = 273.15
NAMES_SHOWN = 4


@dataclass(frozen=True)
class WarmObject:
    """An object that changed the power on the elements. `change`: that power in W per m² of
    lenslet, summed over the window without sign; its mean temperature in K; the number of rays that
    hit it at the update."""

    name: str
    change: float
    temperature: float
    rays: int


@dataclass(frozen=True)
class WarmCause:
    """`things`: the objects that changed the power, the greatest change first; `signal`: as
    recorded, in multiples of the threshold; `threshold` in W per m² of lenslet; `ambient` in K."""

    things: tuple[WarmObject, ...]
    signal: float
    threshold: float
    ambient: float

    @property
    def because(self) -> str:
        return self.things[0].name if self.things and abs(self.signal) > 1.0 else ""


@dataclass(frozen=True)
class _Update:
    """One update, for each ray (n,): power on the elements above that of the room, in W per m² of
    lenslet; temperature in K; range in Blender units; name of the object hit. And the ambient in
    K."""

    power: Array
    temperature: Array
    ranges: Array
    names: list[str]
    ambient: float


def explain_pyroelectric(replay: Replay, index: int) -> Explanation:
    """Explains update `index` of a pyroelectric detector. Raises AngenError."""
    track = replay.track
    signal = float(track.columns["signal"][index])
    looks = _replay_window(replay, index, WINDOW)
    if abs(signal) > 1.0 and looks and not _things([look for _, look in looks]):
        # After a movement the amplifier swings back: look further into the past.
        looks = _replay_window(replay, index, SWING_BACK)
    if not looks:
        return replay.off(index)
    parameters, now = looks[-1]
    things = _things([look for _, look in looks])
    cause = WarmCause(things, signal, threshold_of(parameters), now.ambient)
    facts = [
        ("Signal", f"{signal:+.2f} of the threshold"),
        ("Around", f"{now.ambient - ZERO_CELSIUS:.1f} °C"),
    ]
    facts += [(thing.name, _thing_text(thing)) for thing in things[:NAMES_SHOWN]]
    headline = _headline(cause, bool(track.active[index]))
    return replay.explanation(index, headline, tuple(facts), "", cause)


def _replay_window(
    replay: Replay, index: int, window: float
) -> list[tuple[PirParameters, _Update]]:
    """The updates of the last `window` seconds, without those before the detector was last off."""
    times = replay.track.times
    first = index
    while first > 0 and times[index] - times[first - 1] <= window + 1e-9:
        first -= 1
    stride = max(1, math.ceil((index - first) / MOST_UPDATES))
    looks: list[tuple[PirParameters, _Update]] = []
    for at in sorted({*range(index, first - 1, -stride)}):
        look = _replay_update(replay, at)
        if look is None:
            looks.clear()
        else:
            looks.append(look)
    return looks


def _replay_update(replay: Replay, index: int) -> tuple[PirParameters, _Update] | None:
    pending = replay.take(index)
    if pending is None:
        return None
    parameters: PirParameters = pending.parameters
    update = pending.update
    emissions: list[Emission] = []

    def warmth(*asked: Any) -> Emission:
        emissions.append(update.ask(WARMTH, *asked))
        return emissions[-1]

    replay.runner.model.update(parameters, replace(update, scene={WARMTH: warmth}))
    emission, seen = emissions[-1], replay.seen
    weights = zone_rays(zones_of(parameters), parameters.zone_rays).weights
    surroundings = STEFAN_BOLTZMANN * emission.ambient**4
    power = weights * (radiosity(emission) - surroundings) / math.pi
    look = _Update(power, emission.temperature, seen.ranges, seen.names, emission.ambient)
    return parameters, look


def _things(looks: list[_Update]) -> tuple[WarmObject, ...]:
    """The objects that changed the power, the greatest change first."""
    changes: dict[str, float] = {}
    temperatures: dict[str, list[float]] = {}
    for old, new in pairwise(looks):
        step: dict[str, float] = {}
        if len(old.power) != len(new.power):
            continue
        delta = new.power - old.power
        for ray in np.flatnonzero(np.abs(delta) > 0.0).tolist():
            # The nearer of the two objects hit was there only once.
            nearer = old if old.ranges[ray] < new.ranges[ray] else new
            name = nearer.names[ray]
            step[name] = step.get(name, 0.0) + float(delta[ray])
            temperatures.setdefault(name, []).append(float(nearer.temperature[ray]))
        for name, change in step.items():
            changes[name] = changes.get(name, 0.0) + abs(change)
    found = [
        WarmObject(name, change, float(np.mean(temperatures[name])), looks[-1].names.count(name))
        for name, change in sorted(changes.items())
        if name and change > 0.0
    ]
    return tuple(sorted(found, key=lambda thing: -thing.change))


def _thing_text(thing: WarmObject) -> str:
    celsius = thing.temperature - ZERO_CELSIUS
    return f"changed {thing.change:.3g} W/m², {celsius:.1f} °C, {thing.rays} rays on it now"


def _headline(cause: WarmCause, active: bool) -> str:
    over = abs(cause.signal) > 1.0
    moving = cause.things[0] if cause.things else None
    who = (
        f"{quoted(moving.name)} changed the power on the elements most"
        if moving
        else "nothing warmer or colder than the room moved through its zones"
    )
    if over:
        ignored = "" if active else " (ignored: warm-up or blocking time)"
        return f"Motion{ignored}: {who}; the signal is {abs(cause.signal):.2f} of the threshold"
    held = "Held on" if active else "Still"
    return f"{held}: the signal is {abs(cause.signal):.2f} of the threshold; {who}"
