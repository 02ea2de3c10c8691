# SPDX-License-Identifier: GPL-3.0-or-later
"""Columns give back what was put in, to the bit, and keep what repeats once."""

import pickle
from bisect import bisect_right
from fractions import Fraction

import numpy as np
import pytest
from angen_sensors.sensor_logic.clock import Clock, Schedule
from angen_sensors.sensor_logic.log import samples_csv
from angen_sensors.sensor_logic.model import Reading
from angen_sensors.sensor_logic.recording.columns import CHUNK, Column, EvenSpacing
from angen_sensors.sensor_logic.recording.file import from_bytes, to_bytes
from angen_sensors.sensor_logic.recording.tracks import Recording, Track
from tiers import mostly_slow

MANY = 3 * CHUNK + 17
RNG = np.random.default_rng(3)
DAY = 864_000


def of_pattern(period):
    return np.resize(RNG.normal(size=period), MANY)


VALUES = {
    "nothing": (float, np.empty(0)),
    "one": (float, np.array([2.5])),
    "always the same": (float, np.full(MANY, np.nan)),
    "zeros of both signs": (float, np.where(np.arange(MANY) % 3, 0.0, -0.0)),
    "a pattern": (float, of_pattern(10)),
    "a pattern that breaks": (float, np.append(of_pattern(10)[:-40], np.arange(40.0))),
    "a long pattern": (float, of_pattern(255)),
    "a pattern too long to be looked for": (float, of_pattern(300)),
    "runs": (float, np.repeat(RNG.normal(size=99), 400)[:MANY]),
    "runs across chunks": (bool, np.arange(MANY) // (CHUNK - 3) % 2),
    "noise": (float, RNG.normal(size=MANY)),
    "every other one": (bool, np.arange(MANY) % 2),
    "large integers": (int, RNG.integers(-(2**63), 2**63 - 1, MANY)),
    "texts": (str, [f"name {i // 700 % 5}" for i in range(MANY)]),
}
VALUES["exactly a chunk"] = (float, VALUES["noise"][1][:CHUNK])


@pytest.mark.parametrize("name", VALUES)
@pytest.mark.parametrize("at_once", mostly_slow([1, 1000, MANY], 1000))
def test_values_come_back(name, at_once):
    of, values = VALUES[name]
    column = Column(of)
    for start in range(0, len(values), at_once):
        part = values[start : start + at_once]
        column.append(part[0]) if at_once == 1 else column.extend(part)
    expected = [of(v) for v in values]
    assert len(column) == len(values) and column == Column(of, values)
    assert repr(list(column)) == repr([int(v) if of is bool else v for v in expected])
    again = pickle.loads(pickle.dumps(column))
    for i in (0, 1, CHUNK - 1, CHUNK, MANY - 1, -1):
        if -len(values) <= i < len(values):
            assert repr(again[i]) == repr(list(column)[i])
    with pytest.raises(IndexError):
        column[len(values)]
    told = np.array(values, object if of is str else None)
    new = (
        [i for i in range(len(values)) if i == 0 or told[i].tobytes() != told[i - 1].tobytes()]
        if of is not str
        else [i for i in range(len(values)) if i == 0 or values[i] != values[i - 1]]
    )
    assert column.changes().tolist() == new
    assert np.array_equal(
        np.concatenate([np.empty(0, told.dtype), *(p for _, p in column.parts())]),
        told,
        equal_nan=of is float,
    )


@pytest.mark.parametrize(
    ("clock", "rate"),
    [(Clock(1, 24), 10), (Clock(-7, 30, 1.001, 3), 0.9), (Clock(1, 12), 10), (Clock(5, 25), 25)],
)
def test_times_of_a_clock_take_next_to_nothing_and_are_found(clock, rate):
    steps = [
        step
        for _, step in Schedule(clock, rate).updates(0, int(MANY * clock.steps_per_second / rate))
    ]
    frames = [clock.step_frame(step) for step in steps]
    times = [clock.step_time(step) for step in steps]
    track = Track("a", "PIR", clock=clock)
    track.frames.extend(frames)
    track.times.extend(times)
    assert list(track.frames) == frames and list(track.times) == times
    assert track.frames.nbytes + track.times.nbytes < 2 * 8 * CHUNK + 10_000
    for frame in [frames[0] - 1, *frames[:: CHUNK // 3], *(f - 0.01 for f in frames[::CHUNK]), 1e9]:
        assert track.frames.until(frame) == bisect_right(frames, frame)


def test_what_a_grid_does_not_hold_is_kept_as_it_is():
    values = RNG.normal(size=MANY) * 1e200
    assert np.array_equal(np.asarray(Column(float, values, EvenSpacing(1, Fraction(1, 3)))), values)


@pytest.fixture(scope="module")
def day():
    """A sweeping detector over a day at 12 frames a second, which sees somebody now and then."""
    clock = Clock(1, 12)
    track = Track("pir", "PIR", clock=clock)
    steps = np.arange(DAY, dtype=np.int64) * 6
    steps = -(-steps // 5)
    moved, angle = np.arange(DAY) // 500 % 37 == 0, np.arange(DAY) % 9 * 0.17
    readings = type("Readings", (), {})()
    readings.active, readings.value = moved, angle
    readings.fields = {"angle_rad": angle, "moved": moved, "signal": None}
    track.extend(1 + steps / 1, steps / 12, readings)
    return Recording({"pir": track}, clock, 1, 1 + 12 * 86_400)


def test_a_day_is_small_in_memory_and_comes_back_from_a_file(day):
    track = day.tracks["pir"]
    columns = [track.frames, track.times, track.active, track.value, *track.columns.values()]
    assert len(track) == DAY and sum(c.nbytes for c in columns) < 500_000
    again, _ = from_bytes(to_bytes(day, {}))
    assert again.tracks["pir"] == track
    assert sum(c.nbytes for c in again.tracks["pir"].columns.values()) < 500_000


@pytest.mark.slow
def test_samples_are_written_piece_by_piece(day):
    pieces = [len(piece) for piece in samples_csv(day.tracks["pir"])]
    assert sum(pieces) > 15_000_000 and max(pieces) < 500_000


def test_one_by_one_and_at_once_are_the_same_track():
    one, many = Track("a", "PIR"), Track("a", "PIR")
    moments = [(float(i), i / 12) for i in range(20)]
    for i, (frame, time) in enumerate(moments):
        fields = {"angle_rad": None, "moved": i > 5, "signal": 0.1 * i}
        one.append(frame, time, Reading(i > 5, 0.1 * i, fields))
    readings = type("Readings", (), {})()
    readings.active, readings.value = np.arange(20) > 5, [0.1 * i for i in range(20)]
    readings.fields = {"angle_rad": None, "moved": readings.active, "signal": readings.value}
    many.extend(*zip(*moments, strict=True), readings)
    assert one == many
