# SPDX-License-Identifier: GPL-3.0-or-later
"""Why a pyroelectric detector has a signal: the objects that changed the power on its elements."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from ...arrays import Array
from ...evidence import Cause, rows_of, rows_text
from ...kind import Field
from ...model import Emission, Updates
from ...physics import STEFAN_BOLTZMANN, radiosity

PYRO = (("model", "PYROELECTRIC"),)
FIELDS = (
    Field("ambient", float, "K", tip="Temperature of the surroundings", used_when=PYRO),
    Field(
        "warm",
        str,
        tip="Objects that changed the power on the elements since the update before: by how much "
        "in W per m² of lenslet, the sum of their temperatures over the changed rays in K, the "
        "number of these, and of the rays that hit them now",
        used_when=PYRO,
    ),
)


# s. Changes that are longer ago have mostly decayed in the amplifier.
WINDOW = 0.5
# s. This long after a movement the signal may swing over the threshold once more.
SWING_BACK = 2.0


@dataclass(frozen=True)
class WarmObject:
    """An object that changed the radiant power on the detector's elements.

    Attributes
    ----------
    name
        The name of the object.
    change
        The sum of the absolute changes of power from update to update, in W per m² of lenslet.
    temperature
        The mean temperature of its surface in K.
    rays
        The number of rays that hit the object after its last change.
    """

    name: str
    change: float
    temperature: float
    rays: int


def cause_of_warmth(track: Any, index: int) -> Cause:
    """Return the cause of update `index` of a `Track`: what changed the power on the elements."""
    signals = track.columns["signal"]
    before, after = signals[index - 1] if index else math.nan, signals[index]
    things = warm_objects(track, index) if abs(after) > 1.0 else ()
    return Cause(tuple(thing.name for thing in things), "", "signal", before, after)


def warm_objects(track: Any, index: int) -> tuple[WarmObject, ...]:
    """Return the objects that explain the signal at update `index` of a `Track`.

    The object with the greatest change is first.
    """
    things = _changed(track, index, WINDOW)
    if abs(track.columns["signal"][index]) > 1.0 and not things:
        # After a movement the amplifier swings back, so the cause may be further in the past.
        things = _changed(track, index, SWING_BACK)
    return things


def _changed(track: Any, index: int, window: float) -> tuple[WarmObject, ...]:
    """Return the objects that changed the power in the `window` (s) up to an update."""
    times, at = track.times, index
    found: dict[str, WarmObject] = {}
    warmth: dict[str, tuple[float, int]] = {}
    while at > 0 and times[index] - times[at - 1] <= window + 1e-9:
        for name, change, temperatures, count, rays in rows_of(track.evidence.value("warm", at)):
            total, of = warmth.get(name, (0.0, 0))
            warmth[name] = total, of = total + temperatures, of + count
            known = found.get(name, WarmObject(name, 0.0, 0.0, rays))
            found[name] = replace(known, change=known.change + abs(change), temperature=total / of)
        at -= 1
    things = (thing for _, thing in sorted(found.items()) if thing.change > 0.0)
    return tuple(sorted(things, key=lambda thing: -thing.change))


class _Seen(NamedTuple):
    """What a detector's n rays meet at one update.

    `power` (n,) is the radiant power on the elements, minus that of surroundings of one
    temperature, in W per m² of lenslet. `temperature` (n,) is in K. `hits` has the numbers `solids`
    (n,) of the solids and the `ranges` (n,).
    """

    power: Array
    temperature: Array
    hits: Any


class WarmEvidence:
    """The evidence of successive updates. Its state is what the rays hit at the last one."""

    def __init__(self) -> None:
        self._last: _Seen | None = None

    def forget(self) -> None:
        """Forget the last update, so that the next update has no change as evidence."""
        self._last = None

    def columns(self, updates: Updates, answers: Any, weights: Array) -> dict[str, Any]:
        """Return the evidence of n updates by field.

        `answers` has the `Emission` at the hits of the rays, and `weights` (n,) their solid angles.
        """
        hits, rows, count = answers.hits, answers.rows, len(updates)
        ambient = np.array([emission.ambient for emission in answers.table])[rows]
        texts = np.full(count, "", object)
        if hits is None:
            return {"ambient": ambient, "warm": texts}
        changed = (rows[1:] != rows[:-1]) | (hits.rows[1:] != hits.rows[:-1])
        for i in [0, *(np.flatnonzero(changed) + 1).tolist()]:
            now = _seen(answers[i], weights, hits[i])
            if self._last is not None and len(self._last.power) == len(now.power):
                texts[i] = rows_text(_changes(self._last, now, updates.name_of))
            self._last = now
        return {"ambient": ambient, "warm": texts}


def _seen(emission: Emission, weights: Array, hits: Any) -> _Seen:
    excess = radiosity(emission) - STEFAN_BOLTZMANN * emission.ambient**4
    return _Seen(weights * excess / math.pi, emission.temperature, hits)


def _changes(old: _Seen, new: _Seen, name_of: Callable[[int], str]) -> list[tuple[Any, ...]]:
    """Return a row for each object that changed the power, as described in `FIELDS`."""
    delta = new.power - old.power
    which = np.flatnonzero(delta)
    if not len(which):
        return []
    # The nearer of the two objects is the one that came or left.
    was_nearer = old.hits.ranges[which] < new.hits.ranges[which]
    hit = np.where(was_nearer, old.hits.solids[which], new.hits.solids[which])
    temperature = np.where(was_nearer, old.temperature[which], new.temperature[which])
    numbers, of = np.unique(hit, return_inverse=True)
    change = np.bincount(of, delta[which])
    warmth, count = np.bincount(of, temperature), np.bincount(of)
    found: dict[str, list[float]] = defaultdict(lambda: [0.0, 0.0, 0, 0])
    for i, number in enumerate(numbers.tolist()):
        if name := name_of(number):
            row = found[name]
            row[0] += float(change[i])
            row[1] += float(warmth[i])
            row[2] += int(count[i])
    for number, rays in zip(*np.unique(new.hits.solids, return_counts=True), strict=True):
        if (name := name_of(int(number))) in found:
            found[name][3] += int(rays)
    return [(name, *row) for name, row in found.items()]
