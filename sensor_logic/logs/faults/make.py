# SPDX-License-Identifier: GPL-3.0-or-later
"""Add faults to a log, and list them in a truth file, from which the log can be restored.

The faults of a sensor depend on the plan and its seed, and on the sensor's name and rows. They do
not depend on other sensors.

All rows of a sensor at one time are a message: they are lost, late or doubled together. The first
row of each field is its initial state. It is never lost, late or doubled.
"""

from __future__ import annotations

import csv
import heapq
import math
import zlib
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import groupby
from pathlib import Path

import numpy as np

from ..error import InputError, decoded, explained, replaced
from ..formats.log import Change, Channel, Log, SensorFacts
from ..log import HEADER, Event, Value, format_time, to_csv
from .plan import Fault, FaultPlan, Range

DAY_S = 86400.0
Span = tuple[int, int]


@dataclass(frozen=True)
class DrawnFault:
    """A fault that was chosen at random for a sensor.

    `fault` is its name, `time` its begin in microseconds, and `text` a description.
    """

    fault: str
    time: int
    sensor: SensorFacts
    text: str


@dataclass
class FaultyLog:
    """A log with faults, and the data to restore the log without faults.

    Attributes
    ----------
    log
        The log with faults.
    clean
        The log without faults.
    missing
        The rows of `clean` that `log` lacks.
    drawn
        The faults that were drawn for each sensor.
    """

    log: Log
    clean: Log
    missing: list[Change]
    drawn: list[DrawnFault]


@dataclass
class _Sensor:
    """The rows of a sensor, to which faults are added one after the other.

    `span` is the first and the last time of the log in µs. `table` is the index of the fault in the
    plan. `missing` has the rows that faults have removed.
    """

    facts: SensorFacts
    rows: list[Change]
    seed: int
    span: Span
    frame_at: Callable[[int], float]
    table: int = 0
    missing: list[Change] = field(default_factory=list)
    drawn: list[DrawnFault] = field(default_factory=list)

    def generator(self, fault: str) -> np.random.Generator:
        """Return the random generator for a fault of this sensor and table."""
        names = [zlib.crc32(text.encode()) for text in (self.facts.name, fault)]
        return np.random.default_rng([self.seed, self.table, *names])

    def note(self, fault: str, time: int, text: str) -> None:
        """Add a fault to the list of drawn faults."""
        self.drawn.append(DrawnFault(fault, time, self.facts, text))

    def messages(self) -> Iterator[list[Change]]:
        """Yield the messages, each as a list of the rows of one time, without initial states."""
        later = [row for row in self.rows if not row.is_first]
        return (list(rows) for _, rows in groupby(later, key=lambda row: row.time))

    def replace_messages(self, rows: Iterable[Change]) -> None:
        """Replace all rows, except initial states, with `rows`."""
        first = [row for row in self.rows if row.is_first]
        self.rows = sorted([*first, *rows], key=_order)


def make_faults(log: Log, plan: FaultPlan) -> FaultyLog:
    """Return the log with the faults that the plan describes."""
    first = {id(change) for change in log.initial().values()}
    of: dict[SensorFacts, list[Change]] = defaultdict(list)
    for index, change in enumerate(log.changes):
        row = replace(change, origin=index, is_first=id(change) in first)
        of[change.channel.sensor].append(row)
    span = (log.changes[0].time, log.changes[-1].time) if log.changes else (0, 0)
    same: list[Change] = []
    other: list[Change] = []
    missing: list[Change] = []
    drawn: list[DrawnFault] = []
    frame_at = _frames(log)
    for sensor, rows in of.items():
        done = _faults_of(sensor, rows, plan, span, frame_at)
        same += [row for row in done.rows if not row.faults]
        other += [row for row in done.rows if row.faults]
        missing += done.missing
        drawn += done.drawn
    # Rows without faults keep their order, also where their times are equal.
    same.sort(key=lambda row: row.origin or 0)
    merged = tuple(heapq.merge(same, sorted(other, key=_order), key=_order))
    faulty = replace(log, changes=merged, samples=None)
    return FaultyLog(faulty, log, [row for row in missing if row.origin is not None], drawn)


def _order(row: Change) -> tuple[int, str, str]:
    return row.time, row.channel.sensor.name, row.channel.field


def _with_fault(row: Change, fault: str, time: int | None = None) -> Change:
    """Return the row marked with a fault and, if `time` (µs) is given, moved to that time."""
    return replace(row, faults=(*row.faults, fault), time=row.time if time is None else time)


def _frames(log: Log) -> Callable[[int], float]:
    """Return a function that interpolates the frame at a time between the rows of the log."""
    times = np.array([change.time for change in log.changes], float)
    frames = np.array([change.frame for change in log.changes])
    return lambda time: float(round(float(np.interp(time, times, frames))))


def _faults_of(
    sensor: SensorFacts,
    rows: list[Change],
    plan: FaultPlan,
    span: Span,
    frame_at: Callable[[int], float],
) -> _Sensor:
    done = _Sensor(sensor, rows, plan.seed, span, frame_at)
    for done.table, fault in enumerate(plan.faults):
        if fault.concerns(sensor.name, sensor.kind):
            for step in (_false_alarms, _stuck, _battery, _clock, _lost, _late, _doubled):
                step(done, fault)
    return done


def _drawn(rng: np.random.Generator, within: Range) -> float:
    return float(rng.uniform(*within)) if within[0] < within[1] else within[0]


def _us(seconds: float) -> int:
    return round(seconds * 1e6)


def _false_alarms(sensor: _Sensor, fault: Fault) -> None:
    """Switch the sensor's first output on at random times, for random durations."""
    if not fault.false_alarms_per_day:
        return
    rng = sensor.generator("false_alarm")
    begin, end = sensor.span
    mean = DAY_S / fault.false_alarms_per_day
    spans: list[Span] = []
    # Drawn in order of time, so that a longer log begins with the false alarms of a shorter one.
    while (begin := begin + _us(rng.exponential(mean)) + 1) <= end:
        lasts = rng.uniform(*fault.false_alarm_lasts)
        sensor.note("false_alarm", begin, f"for {lasts:.6f} s")
        last = begin + max(_us(lasts), 1)
        if spans and begin <= spans[-1][1]:
            spans[-1] = (spans[-1][0], max(spans[-1][1], last))
        else:
            spans.append((begin, last))
    outputs = [c for c in _channels(sensor) if _is_output(c)]
    for channel in outputs[:1]:
        _force(sensor, channel, spans, True, "false_alarm")


def _stuck(sensor: _Sensor, fault: Fault) -> None:
    """Hold the sensor's outputs on or off for a time, or hold the values of all its fields."""
    if not fault.stuck:
        return
    rng = sensor.generator("stuck")
    begin, lasts = _drawn(rng, fault.stuck_from), _drawn(rng, fault.stuck_for)
    end = sensor.span[1] + 1 if math.isinf(lasts) else _us(begin) + max(_us(lasts), 1)
    until = "the end" if math.isinf(lasts) else f"{end / 1e6:.6f} s"
    sensor.note("stuck", _us(begin), f"{fault.stuck} until {until}")
    for channel in _channels(sensor):
        forced = fault.stuck != "held" and _is_output(channel)
        value = fault.stuck == "on" if forced else None
        _force(sensor, channel, [(_us(begin), end)], value, "stuck")


def _channels(sensor: _Sensor) -> list[Channel]:
    return list(dict.fromkeys(row.channel for row in sensor.rows))


def _is_output(channel: Channel) -> bool:
    return channel.type is bool and channel.quantity != "validity"


def _force(
    sensor: _Sensor, channel: Channel, spans: list[Span], value: Value | None, fault: str
) -> None:
    """Hold a field at `value` during each of the spans; None is the value at the begin of the span.

    Spans are in order and do not overlap. After each span, the field has the value that the sensor
    senses.
    """
    rows = [row for row in sensor.rows if row.channel is channel]
    out: list[Change] = []
    at = 0

    def add(time: int, added: Value, is_first: bool = False) -> None:
        frame = sensor.frame_at(time)
        out.append(Change(time, channel, added, frame, None, (fault,), is_first))

    for begin, end in spans:
        while at < len(rows) and rows[at].time < begin:
            out.append(rows[at])
            at += 1
        sensed = rows[at - 1].value if at else None
        if value is not None and out and out[-1].value != value:
            add(begin, value)
        while at < len(rows) and rows[at].time < end:
            row, sensed = rows[at], rows[at].value
            if not out and (value is None or sensed == value):
                out.append(row)
            else:
                if not out and value is not None:
                    add(row.time, value, is_first=True)
                sensor.missing.append(_with_fault(row, fault))
            at += 1
        goes_on = at < len(rows) and rows[at].time == end
        is_over = end <= sensor.span[1] and not goes_on
        if is_over and sensed is not None and sensed != out[-1].value:
            add(end, sensed)
    out += rows[at:]
    others = [row for row in sensor.rows if row.channel is not channel]
    sensor.rows = sorted(others + out, key=_order)


def _battery(sensor: _Sensor, fault: Fault) -> None:
    """Remove all messages after the battery has died."""
    life = _drawn(sensor.generator("battery"), fault.battery_life)
    if math.isinf(life):
        return
    sensor.note("battery", _us(life), "dead from here on")
    _drop(sensor, "battery", lambda time: time > _us(life))


def _drop(sensor: _Sensor, fault: str, is_dropped: Callable[[int], bool]) -> None:
    left: list[Change] = []
    for rows in sensor.messages():
        if is_dropped(rows[0].time):
            sensor.missing += [_with_fault(row, fault) for row in rows]
        else:
            left += rows
    sensor.replace_messages(left)


def _clock(sensor: _Sensor, fault: Fault) -> None:
    """Move all messages to the times of a wrong clock, with an offset and a drift."""
    rng = sensor.generator("clock")
    offset = _drawn(rng, fault.clock_offset)
    ppm = _drawn(rng, fault.clock_drift_ppm)
    if not (offset or ppm):
        return
    sensor.note("clock", 0, f"{offset:+.6f} s, {ppm:+.6f} ppm")
    begin = sensor.span[0]
    _move(sensor, "clock", lambda t: max(begin + 1, t + _us(offset) + round(t * ppm * 1e-6)))


def _move(sensor: _Sensor, fault: str, to: Callable[[int], int]) -> None:
    moved = []
    for rows in sensor.messages():
        old = rows[0].time
        new = to(old)
        moved += rows if new == old else [_with_fault(row, fault, new) for row in rows]
    sensor.replace_messages(moved)


def _lost(sensor: _Sensor, fault: Fault) -> None:
    if fault.lost:
        rng = sensor.generator("lost")
        _drop(sensor, "lost", lambda _: rng.random() < fault.lost)


def _late(sensor: _Sensor, fault: Fault) -> None:
    if fault.late:
        rng = sensor.generator("late")

        def arrival(time: int) -> int:
            is_late, by = rng.random() < fault.late, rng.uniform(*fault.late_by)
            return time + _us(by) if is_late else time

        _move(sensor, "late", arrival)


def _doubled(sensor: _Sensor, fault: Fault) -> None:
    if fault.doubled:
        rng = sensor.generator("doubled")
        out: list[Change] = []
        for rows in sensor.messages():
            out += rows
            is_doubled, after = rng.random() < fault.doubled, rng.uniform(*fault.doubled_after)
            if is_doubled:
                copies = [_with_fault(row, "doubled", row.time + _us(after)) for row in rows]
                out += [replace(copy, origin=None) for copy in copies]
        sensor.replace_messages(out)


# The truth file lists every change that faults made to a log, so that `undo` can restore the log.
#
# A row with `true_row` only is an event that the faulty log lacks; a row with `row` only was added
# by a fault; a row with both numbers has another time. An added event is shown as in the faulty
# log, any other event as in the log without faults. Numbers count from 1, the first row after the
# header. A row with neither number is a fault that was drawn for a sensor, such as an empty
# battery.

TRUTH_HEADER = ("faults", "row", "true_row", *HEADER)


def truth_csv(faulty: FaultyLog) -> str:
    """Return the truth file of a log with faults: a row for each fault and each faulty row.

    The rows are sorted by time.
    """
    found = [(drawn.time, _drawn_row(drawn)) for drawn in faulty.drawn]
    numbered = [(str(number), row) for number, row in enumerate(faulty.log.changes, start=1)]
    for number, row in [*numbered, *(("", row) for row in faulty.missing)]:
        if row.faults:
            change = row if row.origin is None else faulty.clean.changes[row.origin]
            true_row = "" if row.origin is None else str(row.origin + 1)
            cells = (";".join(row.faults), number, true_row, *change.event.row)
            found.append((change.time, cells))
    return to_csv(TRUTH_HEADER, (cells for _, cells in sorted(found, key=lambda pair: pair[0])))


def _drawn_row(drawn: DrawnFault) -> tuple[str, ...]:
    time = format_time(drawn.time / 1e6)
    return (drawn.fault, "", "", time, "", drawn.sensor.name, drawn.sensor.kind, "", drawn.text)


def undo(faulty: Sequence[Event[float]], truth: Path) -> list[Event[float]]:
    """Return the events of the log without faults, in their original order.

    `faulty` are the events with faults, `truth` is their truth file. Raise InputError if it is not
    a truth file, or if it belongs to another log. Raise OSError if it cannot be opened.
    """
    left: dict[int, Event[float]] = dict(enumerate(faulty, start=1))
    put: dict[int, Event[float]] = {}
    for line, cells in _rows(truth):
        row, true_row, event = _read(truth, line, cells)
        logged = left.pop(row, None) if row else None
        if row and (logged is None or not _is_same(logged, event, with_time=not true_row)):
            raise InputError(
                f"{truth}: line {line} does not match the log: give the truth file "
                "that was written with this log"
            )
        if true_row:
            put[true_row] = event
    rest = iter(left.values())
    with replaced(
        f"{truth} does not match the log: it refers to rows that the log lacks", StopIteration
    ):
        return [put.get(number) or next(rest) for number in range(1, len(left) + len(put) + 1)]


def _is_same(logged: Event[float], event: Event[float], with_time: bool) -> bool:
    """Return whether two events are equal; times are compared only if `with_time`."""
    return logged.row[1 - with_time :] == event.row[1 - with_time :]


def _rows(truth: Path) -> list[tuple[int, list[str]]]:
    with open(truth, newline="", encoding="utf-8-sig") as file:
        not_text = decoded(truth)
        with not_text, explained(str(truth), csv.Error):
            rows = csv.reader(file)
            if tuple(next(rows, ())) != TRUTH_HEADER:
                raise InputError(f"{truth}: line 1 is not {','.join(TRUTH_HEADER)}")
            # Rows of drawn faults have neither number.
            return [
                (rows.line_num, row)
                for row in rows
                if len(row) != len(TRUTH_HEADER) or any(row[1:3])
            ]


def _read(truth: Path, line: int, cells: list[str]) -> tuple[int, int, Event[float]]:
    try:
        _faults, row, true_row, time, frame, sensor, kind, field, value = cells
        event = Event(float(time), sensor, field, float(frame), kind, value)
        return int(row or 0), int(true_row or 0), event
    except ValueError:
        raise InputError(f"{truth}: line {line} is not a row of a truth file") from None
