# SPDX-License-Identifier: GPL-3.0-or-later
"""Which runs of a study differ in their sensors alone, so that one living of the home is enough."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, TypeVar

from .targets import POSE, HomeFacts

# Runs that live a home together at most; fewer where their logs are kept, which a worker has in
# memory until the last of them is written.
MOST, MOST_WITH_LOGS = 1000, 64
# Runs that wait at the driver until others are found to live with.
WAITING = 20_000

Settings = dict[str, dict[str, Any]]
Run = TypeVar("Run")


def of_the_home(home: HomeFacts, settings: Mapping[str, Mapping[str, Any]]) -> Settings:
    """What of a run's settings changes the home for other sensors too: where one stands, for its
    housing is in the way of their rays, and all that is set of those that are not `home.free`."""
    found = {
        name: {
            parameter: value
            for parameter, value in values.items()
            if name not in home.free or (parameter in POSE and value)
        }
        for name, values in settings.items()
    }
    return {name: values for name, values in found.items() if values}


def size_of(lives: Counter[str], workers: int, logs: bool = False) -> Callable[[str], int]:
    """How many runs of each living go together, if there are to be tasks for all workers; `logs`:
    whether they are kept."""
    most = MOST_WITH_LOGS if logs else MOST
    parts = math.ceil(workers / max(len(lives), 1))

    def size(life: str) -> int:
        return min(math.ceil(lives[life] / parts), most)

    return size


def grouped(
    runs: Iterable[Run], life: Callable[[Run], str], size: Callable[[str], int]
) -> Iterator[list[Run]]:
    """The runs, together with those of the same living, as many as its size says."""
    waiting: dict[str, list[Run]] = {}
    count = 0
    for run in runs:
        key = life(run)
        waiting.setdefault(key, []).append(run)
        count += 1
        if len(waiting[key]) < size(key):
            if count < WAITING:
                continue
            key = max(waiting, key=lambda one: len(waiting[one]))
        group = waiting.pop(key)
        count -= len(group)
        yield group
    yield from waiting.values()
