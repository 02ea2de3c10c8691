# SPDX-License-Identifier: GPL-3.0-or-later
"""Local times in a home's time zone, where clocks go forward in spring and back in autumn."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from datetime import UTC, datetime, timedelta, tzinfo

MICROSECOND = timedelta(microseconds=1)


def is_left_out(time: datetime, zone: tzinfo) -> bool:
    """Whether clocks went forward past this local time."""
    return time.tzinfo is None and _utc(time, zone).astimezone(zone).replace(tzinfo=None) != time


def localised(time: datetime, zone: tzinfo) -> datetime:
    """A local time in its zone. One that clocks left out becomes the moment at which they went
    forward, so that times stay in order."""
    if time.tzinfo is not None or not is_left_out(time, zone):
        return time if time.tzinfo else time.replace(tzinfo=zone)
    # With the offset of after, the time lies before that moment; with that of before, after it.
    early, late = (_utc(time.replace(fold=fold), zone) for fold in (1, 0))
    offset = early.astimezone(zone).utcoffset()
    while late - early > MICROSECOND:
        middle = early + (late - early) // 2
        if middle.astimezone(zone).utcoffset() == offset:
            early = middle
        else:
            late = middle
    return late.astimezone(zone)


def in_zone(times: Iterable[datetime], zone: tzinfo, in_utc: bool) -> list[datetime]:
    """The same moments in a zone; those without a zone are UTC if `in_utc`, or else local. In the
    hour that local clocks repeat, times that would go back are of the second time."""
    found: list[datetime] = []
    for time in times:
        if time.tzinfo is not None or in_utc:
            time = (time if time.tzinfo else time.replace(tzinfo=UTC)).astimezone(zone)
        else:
            time = localised(time, zone)
            if found and time.astimezone(UTC) < found[-1].astimezone(UTC):
                time = time.replace(fold=1)
        found.append(time)
    return found


def count_left_out(times: Sequence[datetime], zone: tzinfo | None) -> int:
    """How many of these local times clocks went past."""
    return 0 if zone is None else sum(is_left_out(time, zone) for time in times)


def since(start: datetime, time: datetime) -> int:
    """Microseconds from the start; a time without a zone is a local one in the start's zone.
    Raises TypeError for a time with a zone where the start has none."""
    zone = start.tzinfo
    if zone is not None:
        # Python subtracts times of one zone as if daylight saving did not exist.
        start, time = start.astimezone(UTC), localised(time, zone).astimezone(UTC)
    return (time - start) // MICROSECOND


def _utc(time: datetime, zone: tzinfo) -> datetime:
    return time.replace(tzinfo=zone).astimezone(UTC)
