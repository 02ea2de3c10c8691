# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether an object is in use: a property that residents write in days, and anybody can key.

`UseHistory` is what sensors of used things, such as water meters and smart plugs, have observed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .kind import USES, OwnerProperties
from .model import Array, Updates
from .parameters import Parameters, parameter


@dataclass(frozen=True)
class InUse(Parameters):
    """Whether somebody uses an object."""

    in_use: bool = parameter(
        False,
        "In Use",
        "Somebody uses this object now: sits on it, works at it, or has switched it on. Residents "
        "set it in days; otherwise key it",
    )


IN_USE = OwnerProperties(
    "angen_use",
    ("Object",),
    "Use",
    "Whether this object is in use, which decides what it does: draw power, let water flow",
    InUse,
)


# Said of a sensor that has nothing to watch.
NOTHING_WATCHED = "It watches no object. Choose the object, or make it the sensor's parent"


# Begin and end of a time in s.
Span = tuple[float, float]


class UseHistory:
    """The times at which the object that a sensor watches was in use, as observed so far.

    Attributes
    ----------
    name
        The name of the object; empty without one.
    uses
        The begin and the end of each use in s, in order. A use before the first observation begins
        at −inf. One that has not ended ends at inf.
    """

    def __init__(self) -> None:
        self.name = ""
        self.uses: list[Span] = []
        self._is_used: bool | None = None

    def observe(self, updates: Updates) -> None:
        """Add what the sensor observes at all updates and at the steps between them."""
        answers = updates.ask(USES)
        known = [one is not None and one.in_use for one in answers.table]
        used = np.array(known, bool)[answers.rows]
        first = answers[0]
        self.name = first.name if first is not None else ""
        before = np.concatenate([[bool(self._is_used)], used[:-1]])
        for i in np.flatnonzero(used != before).tolist():
            time = float(updates.times[i])
            if used[i]:
                begins = -math.inf if self._is_used is None and i == 0 else time
                self.uses.append((begins, math.inf))
            else:
                self.uses[-1] = self.uses[-1][0], time
        self._is_used = bool(used[-1])

    def forget_before(self, time: float) -> None:
        """Forget the uses that ended before a time in s, except the last use."""
        while len(self.uses) > 1 and self.uses[0][1] < time:
            del self.uses[0]


def is_within(spans: list[Span], times: Array) -> NDArray[np.bool_]:
    """Return whether each of the times (n,) is in a span: from its begin to before its end."""
    found = np.zeros(len(times), bool)
    for begin, end in spans:
        found |= (times >= begin) & (times < end)
    return found


def device_error(accuracy: float, updates: Updates) -> float:
    """Return the factor by which a device measures wrongly: from 1 − `accuracy` to 1 + `accuracy`.

    Each device has its own factor, which it keeps.
    """
    if accuracy == 0.0:
        return 1.0
    return 1.0 + accuracy * float(updates.device_noise().uniform(-1.0, 1.0))
