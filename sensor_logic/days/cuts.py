# SPDX-License-Identifier: GPL-3.0-or-later
"""Cuts a day into stretches: whose keys are set in the home one after the other, or which different
processes live."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..model import Array

# s: a shorter rest is not cut in.
REST = 2.0
# s of movement that take as long as the references of light for another stand of the sun.
REFERENCES = 17.0


def stretches(spans: Array, first: float, last: float, most: float) -> list[float]:
    """Times (s) at which to cut from `first` to `last`, so that there is movement for `most` s at
    most between two of them; if possible while nothing moves, in the middle of that. `spans`
    (k, 2): when anything moves."""
    cuts: list[float] = []
    moved = 0.0
    # The last rest, and how much movement came before it.
    rest: tuple[float, float] | None = None
    for number, (start, end) in enumerate(spans.tolist()):
        while moved + end - start > most:
            if rest is not None:
                cuts.append(rest[0])
                moved, rest = moved - rest[1], None
                continue
            # No rest in sight: amid the movement.
            start += most - moved
            cuts.append(start)
            moved = 0.0
        moved += end - start
        until = spans[number + 1, 0] if number + 1 < len(spans) else last
        if until - end > REST:
            rest = (end + until) / 2, moved
    return [cut for cut in cuts if first < cut < last]


def shares(
    spans: Array, last: float, parts: int, lead: float, changes: Sequence[float] = ()
) -> tuple[float, ...]:
    """Times (s) at which to cut a day that ends at `last`, for so many processes at most: each a
    little before a rest ends that is as long as the `lead` by which a process begins before its
    cut, or the longest there is; with about as much to do between each two. `spans` (k, 2): when
    anything moves; `changes`: when the sun comes to stand elsewhere, from the first to the last."""
    ends = np.append(spans[1:, 0], last)
    rests = ends - spans[:, 1]
    stand = np.searchsorted(changes, spans[:, 0], side="right")
    is_first = np.diff(stand, prepend=0) > 0
    done = np.cumsum(spans[:, 1] - spans[:, 0] + REFERENCES * is_first)
    # Of the last rest nothing is left to be done.
    long = np.flatnonzero(rests[:-1] >= max(min(lead, rests[:-1].max(initial=0.0)), REST))
    if not len(long):
        return ()
    wanted = [done[-1] * k / parts for k in range(1, parts)]
    found = {int(long[np.abs(done[long] - much).argmin()]) for much in wanted}
    return tuple(float(ends[i]) - REST / 2 for i in sorted(found))
