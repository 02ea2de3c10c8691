# SPDX-License-Identifier: GPL-3.0-or-later
"""The output stage of a motion detector module: warm-up, hold time and blocking time.

Terms as in the HC-SR501's datasheet: after a trigger the output stays high for the delay (hold)
time, each new trigger in it starting it anew where the module is set to retrigger; after it fell,
triggers are ignored for the blocking time. During warm-up the output stays low.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

# Times are multiples of a frame; this only absorbs the rounding of their difference.
TIME_TOLERANCE_S = 1e-9


def waiting(warm_up: float, blocking: float, time: float, fell: float = -math.inf) -> str:
    """Why the detector ignores movement at `time` (s), and for how much longer; "" where it reports
    movement. `fell`: when the output last went off (s)."""
    left = warm_up - time
    if left > TIME_TOLERANCE_S:
        return f"warming up, {_seconds(left)} left"
    left = blocking - (time - fell)
    if left > TIME_TOLERANCE_S:
        return f"blocked after it went off, {_seconds(left)} left"
    return ""


def _seconds(time: float) -> str:
    return f"{time:.{0 if time >= 9.95 else 1}f} s"


class OutputTiming:
    """Turns triggers into the output, update by update. Times in seconds."""

    def __init__(self) -> None:
        self.active = False
        self._last_trigger = -math.inf
        self._fell = -math.inf
        self._seen = False

    def update(
        self,
        time: float,
        triggered: bool,
        hold: float,
        blocking: float,
        warm_up: float,
        retrigger: bool = True,
    ) -> bool:
        """The output at `time`, given whether motion was seen at this update."""
        blocked = not self.active and time - self._fell < blocking - TIME_TOLERANCE_S
        listening = not blocked and (retrigger or not self.active)
        if triggered and listening and time >= warm_up - TIME_TOLERANCE_S:
            self._last_trigger = time
            self.active = True
        elif self.active and time - self._last_trigger >= hold - TIME_TOLERANCE_S:
            self.active = False
            self._fell = time
        return self.active

    def run(
        self,
        times: NDArray[np.float64],
        triggered: NDArray[np.bool_],
        hold: float,
        blocking: float,
        warm_up: float,
        retrigger: bool = True,
        onsets: bool = False,
    ) -> NDArray[np.bool_]:
        """The output (n,) at `times` (n,), given where motion was seen; it steps only through
        times with motion or with the output on. `onsets`: only the beginning of motion triggers."""
        if onsets and len(triggered):
            before = np.concatenate([[self._seen], triggered[:-1]])
            self._seen = bool(triggered[-1])
            triggered = triggered & ~before
        active, triggers = np.zeros(len(times), bool), np.flatnonzero(triggered)
        i = 0
        while i < len(times):
            if not self.active:
                following = int(np.searchsorted(triggers, i))
                if following == len(triggers):
                    break
                i = int(triggers[following])
            seen = bool(triggered[i])
            active[i] = self.update(float(times[i]), seen, hold, blocking, warm_up, retrigger)
            i += 1
        return active
