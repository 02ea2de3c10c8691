# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a log faulty. What is done to a sensor depends on the plan, its seed, and that sensor's
name and rows alone.

A message is what a sensor tells at one time: its rows go together. The first row of each field
says how the log begins and is neither lost, late nor doubled.
"""

from __future__ import annotations

import heapq
import math
import zlib
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from itertools import groupby

import numpy as np

from ..formats.log import Change, Channel, Log, SensorFacts, Value
from .plan import Fault, Plan, Range

DAY_S = 86400.0
Span = tuple[int, int]


@dataclass(frozen=True)
class Row:
    """A row of the faulty log, or one that is missing there: `change` is how it stands in it,
    `origin` its index in the log without faults (None: it is not there), `faults` why."""

    change: Change
    origin: int | None
    faults: tuple[str, ...] = ()
    is_first: bool = False

    @property
    def key(self) -> tuple[int, str, str]:
        channel = self.change.channel
        return self.change.time, channel.sensor.name, channel.field

    def by(self, fault: str, time: int | None = None) -> Row:
        """The same with a fault more, perhaps at another time (microseconds)."""
        change = self.change
        if time is not None:
            change = Change(time, change.channel, change.value, change.frame)
        return Row(change, self.origin, (*self.faults, fault), self.is_first)


@dataclass(frozen=True)
class Fact:
    """What was drawn for a sensor: a fault, when it begins (microseconds), and how it is."""

    fault: str
    time: int
    sensor: SensorFacts
    text: str


@dataclass
class Faulty:
    """`rows` of the faulty log in order, those `missing` in it, and what was drawn."""

    log: Log
    clean: Log
    rows: list[Row]
    missing: list[Row]
    facts: list[Fact]


@dataclass
class _Sensor:
    """One sensor on its way through the faults."""

    facts: SensorFacts
    rows: list[Row]
    seed: int
    span: Span
    frame_at: Callable[[int], float]
    table: int = 0
    missing: list[Row] = field(default_factory=list)
    told: list[Fact] = field(default_factory=list)

    def draw(self, fault: str) -> np.random.Generator:
        """Random numbers of its own for each sensor, table and fault: none changes another's."""
        names = [zlib.crc32(text.encode()) for text in (self.facts.name, fault)]
        return np.random.default_rng([self.seed, self.table, *names])

    def tell(self, fault: str, time: int, text: str) -> None:
        self.told.append(Fact(fault, time, self.facts, text))

    def messages(self) -> Iterator[list[Row]]:
        """Rows of one time together, without those at which the log begins."""
        later = [row for row in self.rows if not row.is_first]
        return (list(rows) for _, rows in groupby(later, key=lambda row: row.change.time))

    def put(self, rows: Iterable[Row]) -> None:
        """Takes these rows for those of the messages."""
        first = [row for row in self.rows if row.is_first]
        self.rows = sorted([*first, *rows], key=lambda row: row.key)


def make_faults(log: Log, plan: Plan) -> Faulty:
    """The log with the plan's faults, and what tells them."""
    first = {id(change) for change in log.initial().values()}
    of: dict[SensorFacts, list[Row]] = defaultdict(list)
    for index, change in enumerate(log.changes):
        of[change.channel.sensor].append(Row(change, index, (), id(change) in first))
    span = (log.changes[0].time, log.changes[-1].time) if log.changes else (0, 0)
    same: list[Row] = []
    other: list[Row] = []
    missing: list[Row] = []
    facts: list[Fact] = []
    frame_at = _frames(log)
    for sensor, rows in of.items():
        done = _faults_of(sensor, rows, plan, span, frame_at)
        same += [row for row in done.rows if not row.faults]
        other += [row for row in done.rows if row.faults]
        missing += done.missing
        facts += done.told
    # What no fault touched keeps its order, whatever that is where times are equal.
    same.sort(key=lambda row: row.origin or 0)
    merged = list(heapq.merge(same, sorted(other, key=lambda r: r.key), key=lambda r: r.key))
    faulty = replace(log, changes=tuple(row.change for row in merged), samples=None)
    missing = [row for row in missing if row.origin is not None]
    return Faulty(faulty, log, merged, missing, facts)


def _frames(log: Log) -> Callable[[int], float]:
    """Time → the nearest frame, by the times and frames in the log."""
    times = np.array([change.time for change in log.changes], float)
    frames = np.array([change.frame for change in log.changes])
    return lambda time: float(round(float(np.interp(time, times, frames))))


def _faults_of(
    sensor: SensorFacts, rows: list[Row], plan: Plan, span: Span, frame_at: Callable[[int], float]
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
    """Its first output is on at random times, whatever it senses."""
    if not fault.false_alarms_per_day:
        return
    rng = sensor.draw("false_alarm")
    begin, end = sensor.span
    mean = DAY_S / fault.false_alarms_per_day
    spans: list[Span] = []
    # Drawn one after the other: those of a longer log begin with those of a shorter one.
    while (begin := begin + _us(rng.exponential(mean)) + 1) <= end:
        lasts = rng.uniform(*fault.false_alarm_lasts)
        sensor.tell("false_alarm", begin, f"for {lasts:.6f} s")
        last = begin + max(_us(lasts), 1)
        if spans and begin <= spans[-1][1]:
            spans[-1] = (spans[-1][0], max(spans[-1][1], last))
        else:
            spans.append((begin, last))
    outputs = [c for c in _channels(sensor) if _is_output(c)]
    for channel in outputs[:1]:
        _force(sensor, channel, spans, True, "false_alarm")


def _stuck(sensor: _Sensor, fault: Fault) -> None:
    """Its outputs are on, or off, or all its fields stay as they are."""
    if not fault.stuck:
        return
    rng = sensor.draw("stuck")
    begin, lasts = _drawn(rng, fault.stuck_from), _drawn(rng, fault.stuck_for)
    end = sensor.span[1] + 1 if math.isinf(lasts) else _us(begin) + max(_us(lasts), 1)
    until = "the end" if math.isinf(lasts) else f"{end / 1e6:.6f} s"
    sensor.tell("stuck", _us(begin), f"{fault.stuck} until {until}")
    for channel in _channels(sensor):
        forced = fault.stuck != "held" and _is_output(channel)
        value = fault.stuck == "on" if forced else None
        _force(sensor, channel, [(_us(begin), end)], value, "stuck")


def _channels(sensor: _Sensor) -> list[Channel]:
    return list(dict.fromkeys(row.change.channel for row in sensor.rows))


def _is_output(channel: Channel) -> bool:
    return channel.type is bool and channel.quantity != "validity"


def _force(
    sensor: _Sensor, channel: Channel, spans: list[Span], value: Value | None, fault: str
) -> None:
    """Holds a field at a value (None: at its last one) within spans, which are in order and
    apart; at the end of each it tells what is sensed then."""
    rows = [row for row in sensor.rows if row.change.channel is channel]
    out: list[Row] = []
    at = 0

    def invent(time: int, told: Value, is_first: bool = False) -> None:
        change = Change(time, channel, told, sensor.frame_at(time))
        out.append(Row(change, None, (fault,), is_first))

    for begin, end in spans:
        while at < len(rows) and rows[at].change.time < begin:
            out.append(rows[at])
            at += 1
        sensed = rows[at - 1].change.value if at else None
        if value is not None and out and out[-1].change.value != value:
            invent(begin, value)
        while at < len(rows) and rows[at].change.time < end:
            row, sensed = rows[at], rows[at].change.value
            if not out and (value is None or sensed == value):
                out.append(row)
            else:
                if not out and value is not None:
                    invent(row.change.time, value, is_first=True)
                sensor.missing.append(row.by(fault))
            at += 1
        goes_on = at < len(rows) and rows[at].change.time == end
        is_over = end <= sensor.span[1] and not goes_on
        if is_over and sensed is not None and sensed != out[-1].change.value:
            invent(end, sensed)
    out += rows[at:]
    others = [row for row in sensor.rows if row.change.channel is not channel]
    sensor.rows = sorted(others + out, key=lambda row: row.key)


def _battery(sensor: _Sensor, fault: Fault) -> None:
    """It falls silent."""
    life = _drawn(sensor.draw("battery"), fault.battery_life)
    if math.isinf(life):
        return
    sensor.tell("battery", _us(life), "dead from here on")
    _drop(sensor, "battery", lambda time: time > _us(life))


def _drop(sensor: _Sensor, fault: str, is_dropped: Callable[[int], bool]) -> None:
    left: list[Row] = []
    for rows in sensor.messages():
        if is_dropped(rows[0].change.time):
            sensor.missing += [row.by(fault) for row in rows]
        else:
            left += rows
    sensor.put(left)


def _clock(sensor: _Sensor, fault: Fault) -> None:
    """It stamps its messages by a clock that is off, and runs fast or slow."""
    rng = sensor.draw("clock")
    offset = _drawn(rng, fault.clock_offset)
    ppm = _drawn(rng, fault.clock_drift_ppm)
    if not (offset or ppm):
        return
    sensor.tell("clock", 0, f"{offset:+.6f} s, {ppm:+.6f} ppm")
    begin = sensor.span[0]
    _move(sensor, "clock", lambda t: max(begin + 1, t + _us(offset) + round(t * ppm * 1e-6)))


def _move(sensor: _Sensor, fault: str, to: Callable[[int], int]) -> None:
    moved = []
    for rows in sensor.messages():
        old = rows[0].change.time
        new = to(old)
        moved += rows if new == old else [row.by(fault, new) for row in rows]
    sensor.put(moved)


def _lost(sensor: _Sensor, fault: Fault) -> None:
    if fault.lost:
        rng = sensor.draw("lost")
        _drop(sensor, "lost", lambda _: rng.random() < fault.lost)


def _late(sensor: _Sensor, fault: Fault) -> None:
    if fault.late:
        rng = sensor.draw("late")

        def arrival(time: int) -> int:
            is_late, by = rng.random() < fault.late, rng.uniform(*fault.late_by)
            return time + _us(by) if is_late else time

        _move(sensor, "late", arrival)


def _doubled(sensor: _Sensor, fault: Fault) -> None:
    if fault.doubled:
        rng = sensor.draw("doubled")
        out: list[Row] = []
        for rows in sensor.messages():
            out += rows
            is_doubled, after = rng.random() < fault.doubled, rng.uniform(*fault.doubled_after)
            if is_doubled:
                copies = [row.by("doubled", row.change.time + _us(after)) for row in rows]
                out += [replace(copy, origin=None) for copy in copies]
        sensor.put(out)
