# SPDX-License-Identifier: GPL-3.0-or-later
"""Write a routine as TOML, as `file.read` reads it, and days of it as a diary."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterator, Mapping, Sequence
from datetime import date, datetime, time, timedelta

from ...sensor_logic.logs.log import to_csv
from .file import VARIES
from .routine import (
    DAY,
    SHARES,
    WEEKDAYS,
    Calendar,
    Filler,
    FixedPoint,
    FixedPoints,
    Interruption,
    Pastime,
    Person,
    Routine,
    RoutineActivity,
    Segment,
    Spread,
    StepGroup,
    UsualUse,
)
from .timetable import COLUMNS

# The names of several days of the week together.
_TOGETHER = {frozenset(range(5)): "weekdays", frozenset((5, 6)): "weekend"}
# Weights after an activity that differ from the weight by less than this share are left out.
_LIKE = 0.5


def routine_text(routine: Routine, about: Sequence[str], said: Mapping[str, str]) -> str:
    """Return a routine of persons, activities, plans, fillers and interruptions as TOML.

    Parameters
    ----------
    routine : Routine
        The routine. It has no absences, and its plans no alternatives and no dates.
    about : sequence of str
        The first lines, which become comments.
    said : mapping
        The comment above an activity, by its name.
    """
    lines = [f"# {line}" for line in about]
    lines += ["schema = 1"]
    for person in routine.persons.values():
        lines += ["", *_person(person)]
    if routine.uses:
        lines += ["", "[uses]", *(_use(name, use) for name, use in routine.uses.items())]
    for activity in routine.activities.values():
        if activity.name in said:
            lines += ["", *(f"# {line}" for line in said[activity.name].split("\n"))]
        lines += [*([] if activity.name in said else [""]), *_activity(activity)]
    for plan in routine.plans:
        lines += ["", *_plan(plan)]
    for filler in routine.fillers:
        lines += ["", *_filler(filler)]
    for rule in routine.interruptions:
        lines += ["", *_interruption(rule)]
    return "\n".join(lines) + "\n"


def diary_texts(segments: Sequence[Segment], first: date, days: int, gaps: str) -> dict[str, str]:
    """Return the days from the date `first` on, each as a diary that `angen day --diary` reads.

    The names of the files are dates. Activities are cut at midnight, and `gaps` are not written.
    """
    found = {}
    for day in range(days):
        zero = datetime.combine(first, time()) + timedelta(days=day)
        rows = []
        for one in segments:
            begin, end = (round(min(max(at - day * DAY, 0.0), DAY)) for at in (one.start, one.end))
            if one.activity != gaps and begin < end:
                times = ((zero + timedelta(seconds=at)).isoformat() for at in (begin, end))
                rows.append((*times, one.person, one.activity))
        found[f"{zero:%Y-%m-%d}.csv"] = to_csv(COLUMNS, sorted(rows))
    return found


def _person(person: Person) -> Iterator[str]:
    yield f"[person.{_key(person.name)}]"
    if person.resident != person.name:
        yield f"resident = {_text(person.resident)}"
    if person.visitor:
        yield "visitor = true"
    yield f"begins = {_text(person.begins)}"


def _use(name: str, use: UsualUse) -> str:
    """Return the line of a table [uses] for a place or leaf."""
    keys = [f'lasts = "{duration(use.lasts)}"'] if use.lasts is not None else []
    keys += [f"varies = {_spread(use.varies)}"] if use.varies is not None else []
    return f"{_key(name)} = {{ {', '.join(keys)} }}"


def _spread(varies: Spread) -> str:
    below, above = varies
    return f"{below:g}" if below == above else f"[{below:g}, {above:g}]"


def _activity(activity: RoutineActivity) -> Iterator[str]:
    yield f"[activity.{_key(activity.name)}]"
    yield f"do = {_steps(activity.do)}"
    if activity.meanwhile:
        yield "while = ["
        for row in activity.meanwhile:
            burst = f", burst = {row.burst:g}" if row.burst is not None else ""
            yield (
                f'  {{ do = {_texts(row.do)}, every = "{duration(row.every)}", '
                f"varies = {row.varies:g}{burst} }},"
            )
        yield "]"
    elif not activity.usual_rest:
        yield "while = []"
    if activity.labels:
        labels = (f"{_key(key)} = {_text(label)}" for key, label in activity.labels.items())
        yield f"labels = {{ {', '.join(labels)} }}"


def _steps(do: tuple[str | StepGroup, ...], weights: Sequence[float] = ()) -> str:
    """Return steps, or alternatives with their weights, as a TOML array."""
    parts = []
    for number, one in enumerate(do):
        weight = weights[number] if weights else 1.0
        parts.append(_text(one) if isinstance(one, str) else _group(one, weight))
    return f"[{', '.join(parts)}]"


def _group(group: StepGroup, weight: float) -> str:
    """Return a group of steps as an inline table, with its weight as an alternative."""
    key = "either" if group.weights else "do"
    keys = [f"{key} = {_steps(group.do, group.weights)}"]
    if weight != 1.0:
        keys.append(f"weight = {weight:g}")
    if not group.daily:
        keys.append('drawn = "each time"')
    if group.chance != 1.0:
        keys.append(f"chance = {group.chance:g}")
    if group.times != (1, 1):
        least, largest = group.times
        keys.append(f"times = {least if least == largest else [least, largest]}")
    if group.any_order:
        keys.append("any_order = true")
    if group.varies is not None:
        keys.append(f"varies = {_spread(group.varies)}")
    if group.share is not None:
        names = [name for name, share in SHARES.items() if share == group.share]
        low, high = group.share
        keys.append(f"during = {_text(names[0]) if names else f'[{low:g}, {high:g}]'}")
    return f"{{ {', '.join(keys)} }}"


def _plan(plan: FixedPoints) -> Iterator[str]:
    yield "[[plan]]"
    yield f"person = {_text(plan.person)}"
    yield from _days(plan.days)
    yield "entries = ["
    for entry in plan.entries:
        yield f"  {{ {', '.join(_entry(entry))} }},"
    yield "]"


def _entry(entry: FixedPoint) -> Iterator[str]:
    yield f'at = "{clock(entry.at)}"'
    start, end = map(duration, entry.spread)
    both = entry.until is None or start == end
    yield f'spread = "{start}"' if both else f'spread = ["{start}", "{end}"]'
    yield f"activity = {_text(entry.activity)}"
    if entry.until is not None:
        yield f'until = "{clock(entry.until % DAY)}"'
    else:
        yield from _lasting(entry.lasts, entry.varies, None, 0.0)
    if entry.chance < 1.0:
        yield f"chance = {entry.chance:.2g}"


def _days(days: Calendar) -> Iterator[str]:
    weekdays = days.weekdays
    if weekdays != frozenset(range(7)):
        names = [WEEKDAYS[day] for day in sorted(weekdays)]
        together = _TOGETHER.get(weekdays)
        yield f"on = {_text(together) if together else _texts(names)}"


def _filler(filler: Filler) -> Iterator[str]:
    yield "[[filler]]"
    yield f"person = {_text(filler.person)}"
    yield from _days(filler.days)
    yield f'between = ["{clock(filler.begins)}", "{clock(filler.ends)}"]'
    yield "[filler.choose]"
    total = sum(choice.weight for choice in filler.choices)
    for choice in filler.choices:
        yield f"{_key(choice.activity)} = {{ {', '.join(_choice(choice, 100.0 / total))} }}"


def _choice(choice: Pastime, scale: float) -> Iterator[str]:
    """Yield the keys of a choice, with its weights multiplied by `scale`."""
    yield f"weight = {_number(choice.weight * scale)}"
    yield from _lasting(choice.lasts, choice.varies, choice.until, choice.spread)
    if choice.regular:
        before, later = choice.usual
        yield f"usual = [{round(before, 2):g}, {round(max(later, before), 2):g}]"
        yield f"regular = {choice.regular:.2g}"
    after = {
        name: weight
        for name, weight in choice.after.items()
        if not weight or abs(weight - choice.weight) > _LIKE * choice.weight
    }
    if after:
        rows = (f"{_key(name)} = {_number(weight * scale)}" for name, weight in after.items())
        yield f"after = {{ {', '.join(rows)} }}"


def _interruption(rule: Interruption) -> Iterator[str]:
    yield "[[interruption]]"
    yield f"person = {_text(rule.person)}"
    yield f"during = {_text(rule.during)}"
    yield f"activity = {_text(rule.activity)}"
    yield f"times = {rule.times:.2g}"
    yield from _lasting(rule.lasts, rule.varies, None, 0.0)


def _lasting(
    lasts: float | None, varies: Spread, until: float | None, spread: float
) -> Iterator[str]:
    if until is not None:
        yield f'until = "{clock(until)}"'
        yield f'spread = "{duration(spread)}"'
        return
    yield f'lasts = "{duration(max(lasts or 0.0, 1.0))}"'
    below, above = (min(round(part, 2), 3.0) for part in varies)
    if below == above != VARIES:
        yield f"varies = {below:g}"
    elif below != above:
        yield f"varies = [{below:g}, {above:g}]"


def duration(seconds: float) -> str:
    """Return a duration as a routine has it: to the second below 10 minutes, else to the minute.

    Those below half a second have two digits.
    """
    if 0 < seconds < 0.5:
        # A duration of 0 s is refused in many places.
        return f"{max(seconds, 0.01):.2g} s"
    if seconds < 600:
        minutes, rest = divmod(round(seconds), 60)
        parts = [(minutes, "min"), (rest, "s")]
    else:
        hours, minutes = divmod(round(seconds / 60), 60)
        parts = [(hours, "h"), (minutes, "min")]
    return " ".join(f"{number} {unit}" for number, unit in parts if number) or "0 s"


def clock(seconds: float) -> str:
    """Return a time of day as text, such as 07:05; the end of the day is 24:00."""
    minutes = round(seconds / 60)
    if minutes > DAY / 60:
        minutes -= round(DAY / 60)
    return f"{minutes // 60:02d}:{minutes % 60:02d}"


def _number(value: float) -> str:
    """Return a weight with two digits, without an exponent."""
    text = f"{value:.2g}" if value < 100 else f"{value:.0f}"
    return text if "e" not in text else f"{value:.6f}".rstrip("0").rstrip(".") or "0"


def _key(name: str) -> str:
    bare = name.isascii() and name.replace("_", "a").replace("-", "a").isalnum()
    return name if bare else _text(name)


def _text(text: str) -> str:
    # TOML, unlike JSON, does not allow the character DEL.
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _texts(texts: Collection[str]) -> str:
    return f"[{', '.join(map(_text, texts))}]"
