# SPDX-License-Identifier: GPL-3.0-or-later
"""An invented log of activities, with habits that are known, in the forms of several data sets."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime, timedelta
from pathlib import Path
from typing import NamedTuple

import numpy as np

MONDAY = datetime(2026, 1, 5)


class Done(NamedTuple):
    start: datetime
    end: datetime
    activity: str


def invented(days: int = 28, seed: int = 3) -> list[Done]:
    """Return days of a person, who breakfasts once a day, two hours later at the weekend.

    The toilet follows each sleep and interrupts the night now and then; who has been to the toilet
    then mostly washes.
    """
    random = np.random.default_rng(seed)
    found: list[Done] = []
    night = MONDAY - timedelta(hours=1)

    def add(start: datetime, minutes: float, activity: str) -> datetime:
        end = start + timedelta(minutes=max(round(minutes), 1))
        found.append(Done(start, end, activity))
        return end

    for number in range(days):
        day = MONDAY + timedelta(days=number)
        late = 120.0 if day.weekday() > 4 else 0.0
        now = day + timedelta(minutes=round(420 + late + random.normal(0, 15)))
        if random.random() < 0.4:
            woken = day + timedelta(minutes=int(random.integers(360)))
            add(night, (woken - night).total_seconds() / 60, "Sleep")
            night = add(woken, 3, "Use_Toilet")
        add(night, (now - night).total_seconds() / 60, "Sleep")
        now = add(now, 2, "Use_Toilet")
        now = add(now, random.lognormal(1.2, 0.3), "Wash")
        now = add(now + timedelta(minutes=3), random.lognormal(2.7, 0.25), "Breakfast")
        bed = day + timedelta(minutes=round(1380 + random.normal(0, 20)))
        while now < bed:
            now = add(now + timedelta(minutes=2), random.lognormal(4.0, 0.6), "Watch TV")
            if random.random() < 0.5:
                now = add(now, random.lognormal(0.8, 0.3), "Use_Toilet")
                if random.random() < 0.8:
                    now = add(now, random.lognormal(1.2, 0.3), "Wash")
        night = now
    end = MONDAY + timedelta(days=days - 1, hours=22)
    return [one for one in sorted(found) if one.end < end]


def punctual(days: int = 12, seed: int = 5) -> list[Done]:
    """Return days of a person who is in bed from 23:05 ± 4 min to 07:00 ± 6 min, and lunches at 12.

    Breakfast follows the toilet, by 5 to 9 min. What is under way ends for lunch and bed.
    """
    random = np.random.default_rng(seed)
    found: list[Done] = []
    now = MONDAY - timedelta(minutes=55)

    def add(minute: float, activity: str) -> None:
        """Let an activity last until a minute of the day."""
        nonlocal now
        end = day + timedelta(minutes=round(minute))
        if end > now:
            found.append(Done(now, end, activity))
            now = end

    def minute() -> float:
        return (now - day) / timedelta(minutes=1)

    for number in range(days):
        day = MONDAY + timedelta(days=number)
        add(420 + random.normal(0, 6), "Sleep")
        add(minute() + random.integers(5, 10), "Use_Toilet")
        add(minute() + 15, "Breakfast")
        for until, activity, lasts in (
            (round(720 + random.normal(0, 4)), "Lunch", 30.0),
            (round(1385 + random.normal(0, 4)), "", 0.0),
        ):
            while minute() < until:
                add(min(minute() + random.lognormal(4.0, 0.5), until), "Watch TV")
                add(min(minute() + 5, until), "Use_Toilet")
            if activity:
                add(minute() + lasts, activity)
    add(1385 + 480, "Sleep")
    return found


def table(rows: Sequence[Done]) -> str:
    return "start,end,activity\n" + "".join(f"{a},{b},{name}\n" for a, b, name in rows)


def ordonez(rows: Sequence[Done]) -> str:
    head = "Start time          \tEnd time            \tActivity\t\n"
    head += "--------------------\t--------------------\t--------\t\n"
    return head + "".join(f"{a}\t\t{b}\t\t{name}\t\n" for a, b, name in rows)


def lengths(rows: Sequence[Done]) -> str:
    zero = datetime(1970, 1, 1)
    return "".join(
        f"{int((a - zero).total_seconds())}\t{int((b - a).total_seconds())}\t{name}\n"
        for a, b, name in rows
    )


def casas(rows: Sequence[Done]) -> str:
    lines = [(a, f"{a}.000000 M001 ON {_word(name)} begin") for a, _, name in rows]
    # On an end that is another's begin, the end comes first, as in a list sorted by time.
    lines += [(b, f"{b}.000000 M001 OFF {_word(name)} end") for _, b, name in rows]
    lines += [(MONDAY, f"{MONDAY}.500000 M002 ON")]
    return "\n".join(text for _, text in sorted(lines, key=lambda line: line[0])) + "\n"


def casas_csv(rows: Sequence[Done]) -> str:
    lines = [(a, f'{a:%Y-%m-%d,%H:%M:%S}.000000,Door,ON,{_word(n)}="begin"') for a, _, n in rows]
    lines += [(b, f'{b:%Y-%m-%d,%H:%M:%S}.000000,Door,OFF,{_word(n)}="end"') for _, b, n in rows]
    return "\n".join(text for _, text in sorted(lines, key=lambda line: line[0])) + "\n"


def pyadlml(rows: Sequence[Done], folder: Path) -> None:
    folder.mkdir()
    names = sorted({name for *_, name in rows})
    ids = {name: number for number, name in enumerate(names)}
    texts = [f"{i},{name}\n" for name, i in ids.items()]
    folder.joinpath("activity_map.csv").write_text("id,activity\n" + "".join(texts))
    form = "%d.%m.%Y %H:%M:%S.%f"
    folder.joinpath("activities_subject_anna.csv").write_text(
        "start_time,end_time,activity\n"
        + "".join(f"{a:{form}},{b:{form}},{ids[name]}\n" for a, b, name in rows)
    )


def _word(name: str) -> str:
    return name.replace(" ", "_")
