# SPDX-License-Identifier: GPL-3.0-or-later
"""Sensors whose readings were often not valid in a run, and why."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from typing import NamedTuple

from ..logs.wording import percent
from ..model import NOT_YET
from .tracks import Track

# A run names a sensor if a larger share of its updates was not valid.
MOST = 0.1


class NotValid(NamedTuple):
    """How often a sensor's readings were not valid in a run.

    Attributes
    ----------
    sensor
        The name of the sensor.
    updates
        The number of its updates.
    problems
        The number of updates for each reason why the reading was not valid.
    """

    sensor: str
    updates: int
    problems: dict[str, int]


def not_valid(tracks: Iterable[Track]) -> Iterator[NotValid]:
    """Yield how often each sensor was not valid, for the kinds that name a `problem`.

    Updates that only lack the frame before or after, such as a run's first one, do not count.
    """
    for track in tracks:
        if "problem" not in track.columns:
            continue
        problems = Counter(track.columns["problem"])
        left_out = problems.pop(NOT_YET, 0)
        problems.pop("", None)
        yield NotValid(track.sensor, len(track) - left_out, dict(problems))


def often_not_valid(found: Iterable[NotValid]) -> Iterator[str]:
    """Yield a sentence for each sensor that was not valid in more than a tenth of its updates.

    `found` can have several runs of a sensor. The sentence has the most frequent reason.
    """
    updates: Counter[str] = Counter()
    problems: dict[str, Counter[str]] = {}
    for one in found:
        updates[one.sensor] += one.updates
        problems.setdefault(one.sensor, Counter()).update(one.problems)
    for sensor, reasons in sorted(problems.items()):
        share = reasons.total() / max(updates[sensor], 1)
        if share > MOST:
            most = max(reasons, key=lambda reason: (reasons[reason], reason))
            yield f"'{sensor}' was not valid in {percent(share)} of its updates: {most}"
