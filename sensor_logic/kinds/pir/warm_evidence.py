# SPDX-License-Identifier: GPL-3.0-or-later
"""Why a pyroelectric detector has a signal: the objects that changed the power on its elements."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ...arrays import Array
from ...evidence import rows_text
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


class _Seen(NamedTuple):
    """What a detector's n rays meet at one update.

    `power` (n,) is the radiant power on the elements, minus that of surroundings of one
    temperature, in W per m² of lenslet. `temperature` (n,) is in K. `hits` has the numbers `met`
    (n,) of the solids and the `ranges` (n,).
    """

    power: Array
    temperature: Array
    hits: Any


class WarmEvidence:
    """The evidence of successive updates. Its state is what the rays met at the last one."""

    def __init__(self) -> None:
        self._last: _Seen | None = None

    def forget(self) -> None:
        """Forget the last update, which the next is not to be compared with."""
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
    met = np.where(was_nearer, old.hits.met[which], new.hits.met[which])
    temperature = np.where(was_nearer, old.temperature[which], new.temperature[which])
    numbers, of = np.unique(met, return_inverse=True)
    change = np.bincount(of, delta[which])
    warmth, count = np.bincount(of, temperature), np.bincount(of)
    found: dict[str, list[float]] = defaultdict(lambda: [0.0, 0.0, 0, 0])
    for i, number in enumerate(numbers.tolist()):
        if name := name_of(number):
            row = found[name]
            row[0] += float(change[i])
            row[1] += float(warmth[i])
            row[2] += int(count[i])
    for number, rays in zip(*np.unique(new.hits.met, return_counts=True), strict=True):
        if (name := name_of(int(number))) in found:
            found[name][3] += int(rays)
    return [(name, *row) for name, row in found.items()]
