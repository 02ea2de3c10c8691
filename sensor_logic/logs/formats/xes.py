# SPDX-License-Identifier: GPL-3.0-or-later
"""XES 1.0 (IEEE 1849): event logs for process mining.

A trace has the events of one day. There is a trace for the changes of all sensors, and one for the
activities of each person. Each activity has a `start` and a `complete` event. The attribute
`angen:case` of a trace is `sensors` or `person`.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterator
from xml.sax.saxutils import quoteattr

from ..log import format_value
from .log import Change, FormatFiles, Log, LoggedActivity

HEAD = """<?xml version="1.0" encoding="UTF-8"?>
<log xes.version="1.0" xes.features="nested-attributes" xmlns="http://www.xes-standard.org/">
\t<extension name="Concept" prefix="concept" uri="http://www.xes-standard.org/concept.xesext"/>
\t<extension name="Time" prefix="time" uri="http://www.xes-standard.org/time.xesext"/>
\t<extension name="Lifecycle" prefix="lifecycle" uri="http://www.xes-standard.org/lifecycle.xesext"/>
\t<extension name="Organizational" prefix="org" uri="http://www.xes-standard.org/org.xesext"/>
\t<global scope="trace">
\t\t<string key="concept:name" value="day"/>
\t</global>
\t<global scope="event">
\t\t<string key="concept:name" value="event"/>
\t\t<date key="time:timestamp" value="1970-01-01T00:00:00.000+00:00"/>
\t</global>
\t<classifier name="Event Name" keys="concept:name"/>
"""


def write(log: Log) -> FormatFiles:
    """Return the log as XES: all changes, including initial states, and all activities."""
    parts = [HEAD]
    parts += [_attribute(1, "string", f"angen:{key}", value) for key, value in log.about.items()]
    days: dict[str, list[Change]] = defaultdict(list)
    for change in log.changes:
        days[_day(log, change.time)].append(change)
    for day, changes in days.items():
        parts += _trace(f"sensors {day}", "sensors", [_change(log, c) for c in changes])
    lives: dict[tuple[str, str], list[LoggedActivity]] = defaultdict(list)
    for activity in log.activities:
        lives[activity.person, _day(log, activity.start)].append(activity)
    for (person, day), activities in sorted(lives.items()):
        parts += _trace(f"{person} {day}", "person", list(_activity_events(log, activities)))
    return FormatFiles({"": "".join([*parts, "</log>\n"])})


def _day(log: Log, time: int) -> str:
    return log.local(time).date().isoformat()


def _trace(name: str, case: str, events: list[str]) -> Iterator[str]:
    yield "\t<trace>\n"
    yield _attribute(2, "string", "concept:name", name)
    yield _attribute(2, "string", "angen:case", case)
    yield from events
    yield "\t</trace>\n"


def _change(log: Log, change: Change) -> str:
    channel = change.channel
    value = change.value
    word = ("off", "on")[value] if isinstance(value, bool) else format_value(value)
    kind = {bool: "boolean", str: "string"}.get(channel.type, "float")
    text = str(value).lower() if isinstance(value, bool) else format_value(value)
    name = channel.field if kind == "float" else f"{channel.field} {word}"
    return _event(
        _attribute(3, "string", "concept:name", f"{channel.sensor.name} {name}"),
        _attribute(3, "date", "time:timestamp", log.iso(change.time)),
        _attribute(3, "string", "lifecycle:transition", "complete"),
        _attribute(3, "string", "org:resource", channel.sensor.name),
        _attribute(3, "string", "angen:kind", channel.sensor.kind),
        _attribute(3, "string", "angen:room", channel.sensor.room),
        _attribute(3, "string", "angen:unit", channel.unit),
        _attribute(3, kind, f"angen:{channel.field}", text),
    )


def _activity_events(log: Log, activities: list[LoggedActivity]) -> Iterator[str]:
    marks = [(a.start, "start", a) for a in activities] + [
        (a.end, "complete", a) for a in activities
    ]
    for time, transition, activity in sorted(marks, key=lambda mark: mark[0]):
        yield _event(
            _attribute(3, "string", "concept:name", activity.activity),
            _attribute(3, "date", "time:timestamp", log.iso(time)),
            _attribute(3, "string", "lifecycle:transition", transition),
            _attribute(3, "string", "org:resource", activity.person),
            _attribute(3, "string", "angen:room", activity.room),
        )


def _event(*attributes: str) -> str:
    return "".join(["\t\t<event>\n", *attributes, "\t\t</event>\n"])


def _attribute(depth: int, kind: str, key: str, value: str) -> str:
    """Return an attribute as a line, indented by `depth` tabs; "" for an empty value."""
    if not value:
        return ""
    # XML cannot hold control characters: they are replaced.
    legal = re.sub(r"[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]", "\ufffd", value)
    escaped = {"\t": "&#9;", "\n": "&#10;", "\r": "&#13;"}
    return "\t" * depth + f"<{kind} key={quoteattr(key)} value={quoteattr(legal, escaped)}/>\n"
