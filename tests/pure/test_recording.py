# SPDX-License-Identifier: GPL-3.0-or-later
"""A recording as bytes is restored exactly, is small, and is refused if it is damaged.

Columns restore their values to the bit, and store repeated values once.
"""

import copy
import json
import math
import pickle
import struct
import tracemalloc
import zlib

import numpy as np
import pytest
from angen_sensors.sensor_logic.clock import Clock, Schedule
from angen_sensors.sensor_logic.kinds import KINDS
from angen_sensors.sensor_logic.logs.error import AngenError
from angen_sensors.sensor_logic.model import Reading, Readings, joined_readings
from angen_sensors.sensor_logic.recording.columns import CHUNK, Column
from angen_sensors.sensor_logic.recording.file import TITLE, VERSION, from_bytes, to_bytes
from angen_sensors.sensor_logic.recording.rows import Rows
from angen_sensors.sensor_logic.recording.tracks import Recording, Track
from hypothesis import given, settings
from hypothesis import strategies as st
from tiers import mostly_slow

VALUES = {
    bool: st.booleans(),
    int: st.integers(-(2**63), 2**63 - 1),
    float: st.floats(width=64),
    str: st.text(max_size=5),
}


def bits(column):
    """Return columns as bytes, so that a NaN equals itself and 0.0 is not −0.0."""
    return list(column) if column.type is str else (column.type, np.asarray(column).tobytes())


def contents(recording):
    return [
        recording.clock,
        recording.frame_start,
        recording.frame_end,
        [
            (name, t.sensor, t.kind_name, t.steps)
            + tuple(bits(c) for c in (t.frames, t.times, t.active, t.value))
            + tuple((key, bits(column)) for key, column in t.columns.items())
            + (t.has_evidence, t.evidence, t.parameters)
            for name, t in recording.tracks.items()
        ],
    ]


def track(name, kind, moments, draw):
    """Return readings at (frame, time) pairs; `draw` gives a value of a type."""
    made, of = Track(name, kind, steps={"force_n": 0.5}), KINDS[kind]
    evidence = {}
    for frame, time in moments:
        fields = {f.name: draw(f.type) for f in of.samples}
        if not evidence or draw(bool):
            evidence = {f.name: draw(f.type) for f in of.evidence}
        reading = Reading(draw(bool), draw(float), fields, evidence)
        made.extend([frame], [time], Readings.of([reading]), of.parameters())
    return made


def moments_of(clock, rate, last):
    schedule = Schedule(clock, rate)
    return [(clock.step_frame(s), clock.step_time(s)) for _, s in schedule.updates(0, last)]


@st.composite
def recordings(draw):
    clock = draw(
        st.none()
        | st.builds(
            Clock,
            st.integers(-10, 250),
            st.sampled_from([24, 25, 30, 60]),
            st.sampled_from([1.0, 1.001]),
            st.integers(1, 8),
        )
    )
    made = Recording({}, clock, draw(st.integers(-5, 5)), draw(st.integers(6, 900)))
    for name in draw(st.lists(st.text(max_size=8), max_size=3, unique=True)):
        on_the_clock = clock is not None and draw(st.booleans())
        if on_the_clock:
            moments = moments_of(clock, draw(st.sampled_from([0.9, 1.0, 10.0])), 100)
        else:
            moments = draw(st.lists(st.tuples(st.floats(-9, 9e5), st.floats(0, 9e4)), max_size=9))
        kind = draw(st.sampled_from(sorted(KINDS)))
        made.tracks[name] = track(name, kind, moments, lambda of: draw(VALUES[of]))
    return made


@settings(max_examples=20, deadline=None)
@given(recordings(), st.dictionaries(st.text(max_size=4), st.text(max_size=4)))
def test_comes_back_to_the_bit(recording, facts):
    again, told = from_bytes(to_bytes(recording, facts))
    assert contents(again) == contents(recording)
    assert told == facts


@pytest.mark.parametrize(
    "different",
    mostly_slow([1, 200, 255, 256, 3000, 65535, 65536, 70000], 1, 255, 256, 3000, 65536),
)
def test_values_come_back_however_many_different_ones_there_are(different):
    values = np.tile(np.arange(different) * 0.1, 5 if different < 70000 else 2)
    n, light = len(values), Track("lamp", "LIGHT")
    light.frames.extend(np.arange(n))
    light.times.extend(np.arange(n) / 24)
    light.active.extend(np.ones(n))
    light.value.extend(values)
    for name, column in light.columns.items():
        column.extend(np.full(n, 0.0 if name == "lit" else math.nan))
    recording = Recording({"lamp": light}, Clock(0, 24), 0, n)
    assert contents(from_bytes(to_bytes(recording, {}))[0]) == contents(recording)


def small(is_told=False):
    made = Track("door", "OPTICAL_SWITCH")
    if is_told:
        why = {"object": ["", "Flag", "Cat"], "light": np.ones(3), "steps_ago": None}
        ranges = {"open": [True] * 3, "range_m": np.ones(3)}
        readings = Readings(np.ones(3, bool), np.ones(3), ranges, None, why)
        made.extend(range(30), range(30), joined_readings([readings] * 10), made.kind.parameters())
        return Recording({"door": made}, Clock(1, 24), 1, 30)
    for i in range(30):
        made.append(1.0 + i, i / 24, Reading(i > 9, 0.1 * i, {"open": i > 9, "range_m": 0.1 * i}))
    return Recording({"door": made}, Clock(1, 24), 1, 30)


def test_a_flipped_bit_anywhere_and_a_cut_end_are_noticed():
    data = to_bytes(small(), {"a": 1})
    for at in range(len(data)):
        damaged = bytearray(data)
        damaged[at] ^= 4
        for bad in (bytes(damaged), data[:at]):
            with pytest.raises(AngenError):
                from_bytes(bad)


def test_other_versions_and_a_track_under_another_name_are_refused():
    data = to_bytes(small(), {}).replace(b"%s %d " % (TITLE, VERSION), b"%s 9 " % TITLE, 1)
    with pytest.raises(AngenError, match=r"newer.*update the extension"):
        from_bytes(data)
    header, columns = taken_apart(to_bytes(small(), {}))
    header["tracks"][0]["fields"] = ["smell"]
    with pytest.raises(AngenError, match="another version"):
        from_bytes(put_together(header, columns))
    recording = small()
    recording.tracks["window"] = recording.tracks.pop("door")
    with pytest.raises(ValueError, match=r"'door'.*'window'"):
        to_bytes(recording, {})


def test_a_recording_of_an_earlier_version_has_no_evidence():
    assert not from_bytes(to_bytes(small(), {}))[0].tracks["door"].has_evidence


def test_evidence_is_stored_where_it_changes_and_comes_back_however_it_was_appended():
    seen = ["", "", "Door", "Door", "", "Cat", "Cat", "Cat"]
    reach = [1.0, 1.0, 1.0, math.nan, math.nan, 0.0, -0.0, -0.0]
    once, twice = (Rows({"object": str, "reach": float}) for _ in range(2))
    once.extend({"object": seen, "reach": np.array(reach)}, len(seen))
    for i in range(len(seen)):
        twice.extend({"object": seen[i : i + 1], "reach": reach[i : i + 1]}, 1)
    assert once == twice
    assert list(once.starts) == [0, 2, 3, 4, 5, 6]
    assert [once.value("object", i) for i in range(len(seen))] == seen
    assert repr([once.value("reach", i) for i in range(len(seen))]) == repr(reach)
    twice.extend({"object": None, "reach": None}, 2)
    assert once != twice and twice.value("object", 9) == ""
    assert math.isnan(twice.value("reach", 9)) and len(twice.starts) == 7


# Files of strangers: a correct checksum, with arbitrary content


def taken_apart(data):
    """Return (header, the packed columns)."""
    body = data.partition(b"\n")[2]
    size = struct.unpack("<I", body[:4])[0]
    return json.loads(zlib.decompress(body[4 : 4 + size])), body[4 + size :]


def with_checksum(body):
    return b"%s %d %d\n" % (TITLE, VERSION, zlib.crc32(body)) + body


def put_together(header, columns=b""):
    text = header if isinstance(header, bytes) else json.dumps(header).encode()
    packed = zlib.compress(text)
    return with_checksum(struct.pack("<I", len(packed)) + packed + columns)


@settings(max_examples=100, deadline=None)
@given(st.binary(max_size=200))
def test_nonsense_with_a_right_checksum_is_refused(body):
    with pytest.raises(AngenError, match="damaged"):
        from_bytes(with_checksum(body))


HOSTILE = [
    None, True, False, 0, -1, 1, 2**40, 10**30, 1e308, float("inf"), float("nan"), "", "as",
    "=open", "=no", "d", "texts", [], [None], [[]], {}, {"as": "d"}, [1, 2, 3, 4], [0, 0, 0, 0],
    [1, float("inf"), 1.0, 1], [1, 0, 1.0, 1], [1, 24, 0.0, 1], [1, 24, 1.0, 0],
    [1, 24, 1.0, 2**40],
]  # fmt: skip


def places(value, way=()):
    """Yield every place in nested lists and dictionaries."""
    yield way
    items = value.items() if isinstance(value, dict) else enumerate(value)
    for key, part in items if isinstance(value, (dict, list)) else ():
        if isinstance(part, (dict, list)):
            yield from places(part, (*way, key))
        else:
            yield (*way, key)


@pytest.mark.parametrize("is_told", [False, True])
def test_whatever_stands_in_the_header_is_refused_in_a_line_or_is_a_recording(is_told):
    header, columns = taken_apart(to_bytes(small(is_told), {"a": 1}))
    refused = 0
    for way in places(header):
        if not way:
            continue
        for value in HOSTILE:
            made = copy.deepcopy(header)
            holder = made
            for key in way[:-1]:
                holder = holder[key]
            holder[way[-1]] = value
            try:
                found, _ = from_bytes(put_together(made, columns))
            except AngenError as error:
                refused += 1
                assert "\n" not in str(error)
            else:
                # An accepted file can be queried like any other.
                assert all(len(track) == 30 for track in found.tracks.values())
                assert found.covers(3) in (True, False)
                for track in found.tracks.values():
                    assert track.at(1e12) == 29 and track.columns["open"][29] in (0, 1)
                    if track.has_evidence:
                        assert isinstance(track.evidence.value("object", 29), str)
                        assert track.parameters_at(29) is not None
    assert refused > 400


@pytest.mark.parametrize("opening", [b"[", b'{"a":'])
def test_deep_json_is_refused(opening):
    with pytest.raises(AngenError, match="damaged"):
        from_bytes(put_together(opening * 200_000))


def peak_mib(refused):
    tracemalloc.start()
    try:
        with pytest.raises(AngenError):
            from_bytes(refused)
        return tracemalloc.get_traced_memory()[1] / 2**20
    finally:
        tracemalloc.stop()


def test_what_unpacks_to_gigabytes_is_refused_before_it_does():
    bomb = zlib.compress(bytes(2**28), 1)
    header, columns = taken_apart(to_bytes(small(), {}))
    # A column larger than the header says; a header that says so; a header that is.
    first = header["tracks"][0]["columns"][0]
    rest = columns[first["size"] :]
    first["size"] = len(bomb)
    assert peak_mib(put_together(header, bomb + rest)) < 50
    header["tracks"][0]["count"] = 2**27
    assert peak_mib(put_together(header, bomb + rest)) < 50
    assert peak_mib(put_together(b'{"clock": "' + bytes(2**27))) < 300


def test_many_tracks_are_counted_together_and_what_would_be_refused_is_not_written(monkeypatch):
    header, columns = taken_apart(to_bytes(small(), {}))
    assert len(from_bytes(put_together(header, columns), 30 * 6)[0].tracks) == 1
    with pytest.raises(AngenError, match="more readings"):
        from_bytes(put_together(header, columns), 30 * 6 - 1)
    monkeypatch.setattr("angen_sensors.sensor_logic.recording.file.VALUES", 30 * 6 - 1)
    with pytest.raises(AngenError, match="more readings"):
        to_bytes(small(), {})


# Columns

MANY = 3 * CHUNK + 17
RNG = np.random.default_rng(3)
DAY = 864_000


def of_pattern(period):
    return np.resize(RNG.normal(size=period), MANY)


COLUMNS = {
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
COLUMNS["exactly a chunk"] = (float, COLUMNS["noise"][1][:CHUNK])


@pytest.mark.parametrize("name", COLUMNS)
@pytest.mark.parametrize("at_once", mostly_slow([1, 1000, MANY], 1000))
def test_values_come_back(name, at_once):
    of, values = COLUMNS[name]
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
    bits = [v if of is str else v.tobytes() for v in values]
    new = [i for i in range(len(values)) if i == 0 or bits[i] != bits[i - 1]]
    assert column.changes().tolist() == new
    parts = [value for _, part in column.parts() for value in part.tolist()]
    assert repr([of(v) for v in parts]) == repr(expected)


@pytest.fixture(scope="module")
def day():
    """Return a sweeping detector over a day at 12 frames a second, with motion now and then."""
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
    # Less than a fifth of a byte per update, also in the file.
    data = to_bytes(day, {})
    assert len(data) < 0.2 * DAY
    again, _ = from_bytes(data)
    assert again.tracks["pir"] == track
    assert sum(c.nbytes for c in again.tracks["pir"].columns.values()) < 500_000
