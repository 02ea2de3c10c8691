# SPDX-License-Identifier: GPL-3.0-or-later
"""Why a pyroelectric detector fired: which warm thing changed the power on its elements most."""

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

# s: what the elements felt earlier than this the amplifier has mostly forgotten.
WINDOW = 0.5
# s: that long after what moved has come to rest the signal may swing over the threshold once more.
SWING_BACK = 2.0
MOST_UPDATES = 12
ZERO_CELSIUS = 273.15
NAMES_SHOWN = 4


@dataclass(frozen=True)
class WarmThing:
    """A thing that came, went or moved before the elements' zones, or changed its temperature:
    `change`, the signed power on the elements that it changed, in W per m² of lenslet, added up
    over the window without sign; its mean temperature in K; rays on it at the update."""

    name: str
    change: float
    temperature: float
    rays: int


@dataclass(frozen=True)
class WarmCause:
    """`things`, the one that changed most first; the recorded signal against the threshold of 1;
    that threshold in W per m² of lenslet; the ambient in K."""

    things: tuple[WarmThing, ...]
    signal: float
    threshold: float
    ambient: float

    @property
    def because(self) -> str:
        return self.things[0].name if self.things and abs(self.signal) > 1.0 else ""


@dataclass(frozen=True)
class _Look:
    """One update, ray by ray (n,): power on the elements above that of the room, in W per m² of
    lenslet; temperature in K; range in Blender units and the name of what is met; the ambient."""

    power: Array
    temperature: Array
    ranges: Array
    names: list[str]
    ambient: float


def explain_pyroelectric(replay: Replay, index: int) -> Explanation:
    """Update `index` of a pyroelectric detector. Raises SensorError."""
    track = replay.track
    signal = float(track.columns["signal"][index])
    looks = _looks(replay, index, WINDOW)
    if abs(signal) > 1.0 and looks and not _things([look for _, look in looks]):
        # The amplifier swings back after what moved stands still.
        looks = _looks(replay, index, SWING_BACK)
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
    return replay.told(index, headline, tuple(facts), "", cause)


def _looks(replay: Replay, index: int, window: float) -> list[tuple[PirParameters, _Look]]:
    """Updates of so many seconds until this one, since the detector was off last."""
    times = replay.track.times
    first = index
    while first > 0 and times[index] - times[first - 1] <= window + 1e-9:
        first -= 1
    stride = max(1, math.ceil((index - first) / MOST_UPDATES))
    looks: list[tuple[PirParameters, _Look]] = []
    for at in sorted({*range(index, first - 1, -stride)}):
        look = _look(replay, at)
        if look is None:
            looks.clear()
        else:
            looks.append(look)
    return looks


def _look(replay: Replay, index: int) -> tuple[PirParameters, _Look] | None:
    taken = replay.take(index)
    if taken is None:
        return None
    parameters: PirParameters = taken.parameters
    update = taken.update
    told: list[Emission] = []

    def warmth(*asked: Any) -> Emission:
        told.append(update.ask(WARMTH, *asked))
        return told[-1]

    replay.runner.model.update(parameters, replace(update, scene={WARMTH: warmth}))
    emission, seen = told[-1], replay.seen
    weights = zone_rays(zones_of(parameters), parameters.zone_rays).weights
    surroundings = STEFAN_BOLTZMANN * emission.ambient**4
    power = weights * (radiosity(emission) - surroundings) / math.pi
    look = _Look(power, emission.temperature, seen.ranges, seen.names, emission.ambient)
    return parameters, look


def _things(looks: list[_Look]) -> tuple[WarmThing, ...]:
    """What changed the power, the greatest change first."""
    changes: dict[str, float] = {}
    temperatures: dict[str, list[float]] = {}
    for old, new in pairwise(looks):
        step: dict[str, float] = {}
        if len(old.power) != len(new.power):
            continue
        delta = new.power - old.power
        for ray in np.flatnonzero(np.abs(delta) > 0.0).tolist():
            # The nearer of the two things met was there once and once not.
            nearer = old if old.ranges[ray] < new.ranges[ray] else new
            name = nearer.names[ray]
            step[name] = step.get(name, 0.0) + float(delta[ray])
            temperatures.setdefault(name, []).append(float(nearer.temperature[ray]))
        for name, change in step.items():
            changes[name] = changes.get(name, 0.0) + abs(change)
    found = [
        WarmThing(name, change, float(np.mean(temperatures[name])), looks[-1].names.count(name))
        for name, change in sorted(changes.items())
        if name and change > 0.0
    ]
    return tuple(sorted(found, key=lambda thing: -thing.change))


def _thing_text(thing: WarmThing) -> str:
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
