# SPDX-License-Identifier: GPL-3.0-or-later
"""A recording as bytes comes back as it was, is small, and is refused where it is not whole."""

import copy
import json
import math
import struct
import tracemalloc
import zlib

import numpy as np
import pytest
from angen_sensors.sensor_logic.clock import Clock, Schedule
from angen_sensors.sensor_logic.error import AngenError
from angen_sensors.sensor_logic.kinds import KINDS
from angen_sensors.sensor_logic.model import Reading
from angen_sensors.sensor_logic.recording.file import TITLE, VERSION, from_bytes, to_bytes
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
    """Columns by their bytes: so that a NaN equals itself and 0.0 is not −0.0."""
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
            for name, t in recording.tracks.items()
        ],
    ]


def track(name, kind, moments, draw):
    """Readings at (frame, time) pairs; `draw` gives a value of a type."""
    made = Track(name, kind, steps={"force_n": 0.5})
    for frame, time in moments:
        fields = {f.name: draw(f.type) for f in KINDS[kind].samples}
        made.append(frame, time, Reading(draw(bool), draw(float), fields))
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
    values = iter(np.tile(np.arange(different) * 0.1, 5 if different < 70000 else 2))
    moments = [(float(i), i / 24) for i in range(different * (5 if different < 70000 else 2))]
    light = Track("lamp", "LIGHT")
    for frame, time in moments:
        light.frames.append(frame)
        light.times.append(time)
        light.active.append(1)
        light.value.append(next(values))
        for name, column in light.columns.items():
            column.append(0 if name == "lit" else math.nan)
    recording = Recording({"lamp": light}, Clock(0, 24), 0, len(moments))
    assert contents(from_bytes(to_bytes(recording, {}))[0]) == contents(recording)


def hour():
    """A detector at 10 Hz that sweeps and sees somebody at times, and a noisy light sensor."""
    clock = Clock(1, 24)
    rng = np.random.default_rng(1)
    pir, light = Track("pir", "PIR"), Track("light", "LIGHT")
    last = 3600 * 24
    for i, (frame, time) in enumerate(moments_of(clock, 10.0, last)):
        fields = {f.name: math.nan if f.type is float else False for f in KINDS["PIR"].samples}
        angle = i % 9 * math.radians(10)
        pir.append(frame, time, Reading(i % 700 < 40, angle, {**fields, "angle_rad": angle}))
    for frame, time in moments_of(clock, 1.0, last):
        names = {f.name: float(rng.normal()) for f in KINDS["LIGHT"].samples if f.type is float}
        light.append(frame, time, Reading(True, 0.5, {**names, "lit": True}))
    return Recording({"pir": pir, "light": light}, clock, 1, last)


def test_is_small():
    """A sweeping detector takes less than a byte an update; noise the eight bytes that it has."""
    recording = hour()
    pir = Recording({"pir": recording.tracks["pir"]}, recording.clock, 1, 2)
    assert len(to_bytes(pir, {})) < 0.2 * len(recording.tracks["pir"])
    light = Recording({"light": recording.tracks["light"]}, recording.clock, 1, 2)
    assert len(to_bytes(light, {})) < 4 * 8 * len(recording.tracks["light"])


def small():
    made = Track("door", "OPTICAL_SWITCH")
    for i in range(30):
        made.append(1.0 + i, i / 24, Reading(i > 9, 0.1 * i, {"open": i > 9, "range_m": 0.1 * i}))
    return Recording({"door": made}, Clock(1, 24), 1, 30)


def test_a_flipped_bit_anywhere_is_noticed():
    data = to_bytes(small(), {"a": 1})
    for at in range(len(data)):
        damaged = bytearray(data)
        damaged[at] ^= 4
        with pytest.raises(AngenError):
            from_bytes(bytes(damaged))


def test_a_cut_end_is_noticed():
    data = to_bytes(small(), {})
    for length in range(len(data)):
        with pytest.raises(AngenError):
            from_bytes(data[:length])


@settings(max_examples=100, deadline=None)
@given(st.binary(max_size=200))
def test_nonsense_with_a_right_checksum_is_refused(body):
    data = b"%s %d %d\n" % (TITLE, VERSION, zlib.crc32(body)) + body
    with pytest.raises(AngenError, match="damaged"):
        from_bytes(data)


def test_a_newer_version_says_what_to_do():
    data = to_bytes(small(), {}).replace(b"%s %d " % (TITLE, VERSION), b"%s 9 " % TITLE, 1)
    with pytest.raises(AngenError, match=r"newer.*update the extension"):
        from_bytes(data)


def test_fields_of_another_version_are_refused():
    header = b'{"clock": null, "frames": [1, 2], "facts": {}, "tracks": [{"sensor": "a", '
    header += b'"kind": "PIR", "count": 0, "steps": {}, "fields": ["smell"], "columns": []}]}'
    packed = zlib.compress(header)
    body = struct.pack("<I", len(packed)) + packed
    with pytest.raises(AngenError, match="another version"):
        from_bytes(b"%s %d %d\n" % (TITLE, VERSION, zlib.crc32(body)) + body)


def test_a_track_under_another_name_is_no_recording():
    recording = small()
    recording.tracks["window"] = recording.tracks.pop("door")
    with pytest.raises(ValueError, match=r"'door'.*'window'"):
        to_bytes(recording, {})


# Files of strangers: a right checksum, and all else as they please


def taken_apart(data):
    """(header, the packed columns)."""
    body = data.partition(b"\n")[2]
    size = struct.unpack("<I", body[:4])[0]
    return json.loads(zlib.decompress(body[4 : 4 + size])), body[4 + size :]


def put_together(header, columns=b""):
    text = header if isinstance(header, bytes) else json.dumps(header).encode()
    packed = zlib.compress(text)
    body = struct.pack("<I", len(packed)) + packed + columns
    return b"%s %d %d\n" % (TITLE, VERSION, zlib.crc32(body)) + body


HOSTILE = [
    None, True, False, 0, -1, 1, 2**40, 10**30, 1e308, float("inf"), float("nan"), "", "as",
    "=open", "=no", "d", "texts", [], [None], [[]], {}, {"as": "d"}, [1, 2, 3, 4], [0, 0, 0, 0],
    [1, float("inf"), 1.0, 1], [1, 0, 1.0, 1], [1, 24, 0.0, 1], [1, 24, 1.0, 0],
    [1, 24, 1.0, 2**40],
]  # fmt: skip


def places(value, way=()):
    """Every place in nested lists and dictionaries."""
    yield way
    items = value.items() if isinstance(value, dict) else enumerate(value)
    for key, part in items if isinstance(value, (dict, list)) else ():
        if isinstance(part, (dict, list)):
            yield from places(part, (*way, key))
        else:
            yield (*way, key)


def test_whatever_stands_in_the_header_is_refused_in_a_line_or_is_a_recording():
    header, columns = taken_apart(to_bytes(small(), {"a": 1}))
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
                # What comes through can be asked like any other.
                assert all(len(track) == 30 for track in found.tracks.values())
                assert found.covers(3) in (True, False)
                for track in found.tracks.values():
                    assert track.at(1e12) == 29 and track.columns["open"][29] in (0, 1)
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
    # A column that is larger than the header says; a header that says so; a header that is.
    first = header["tracks"][0]["columns"][0]
    rest = columns[first["size"] :]
    first["size"] = len(bomb)
    assert peak_mib(put_together(header, bomb + rest)) < 50
    header["tracks"][0]["count"] = 2**27
    assert peak_mib(put_together(header, bomb + rest)) < 50
    assert peak_mib(put_together(b'{"clock": "' + bytes(2**27))) < 300


def test_many_tracks_are_counted_together():
    header, columns = taken_apart(to_bytes(small(), {}))
    with pytest.raises(AngenError, match="more readings"):
        from_bytes(put_together(header, columns), 30 * 6 - 1)
    assert len(from_bytes(put_together(header, columns), 30 * 6)[0].tracks) == 1


def test_what_a_file_would_refuse_is_not_written(monkeypatch):
    monkeypatch.setattr("angen_sensors.sensor_logic.recording.file.VALUES", 30 * 6 - 1)
    with pytest.raises(AngenError, match="more readings"):
        to_bytes(small(), {})
