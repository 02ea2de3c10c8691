# SPDX-License-Identifier: GPL-3.0-or-later
"""A recording as bytes comes back as it was, is small, and is refused where it is not whole."""

import math
import struct
import zlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sensor_logic.clock import Clock, Schedule
from sensor_logic.kinds import KINDS
from sensor_logic.model import Reading
from sensor_logic.recording import Recording, Track
from sensor_logic.recording_file import TITLE, VERSION, RecordingFileError, from_bytes, to_bytes

VALUES = {
    bool: st.booleans(),
    int: st.integers(-(2**63), 2**63 - 1),
    float: st.floats(width=64),
    str: st.text(max_size=5),
}


def bits(column):
    """Columns by their bytes: so that a NaN equals itself and 0.0 is not −0.0."""
    return list(column) if isinstance(column, list) else (column.typecode, column.tobytes())


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


@settings(max_examples=60, deadline=None)
@given(recordings(), st.dictionaries(st.text(max_size=4), st.text(max_size=4)))
def test_comes_back_to_the_bit(recording, facts):
    again, told = from_bytes(to_bytes(recording, facts))
    assert contents(again) == contents(recording)
    assert told == facts


@pytest.mark.parametrize("different", [1, 200, 255, 256, 3000, 65535, 65536, 70000])
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
        with pytest.raises(RecordingFileError):
            from_bytes(bytes(damaged))


def test_a_cut_end_is_noticed():
    data = to_bytes(small(), {})
    for length in range(len(data)):
        with pytest.raises(RecordingFileError):
            from_bytes(data[:length])


@settings(max_examples=100, deadline=None)
@given(st.binary(max_size=200))
def test_nonsense_with_a_right_checksum_is_refused(body):
    data = b"%s %d %d\n" % (TITLE, VERSION, zlib.crc32(body)) + body
    with pytest.raises(RecordingFileError, match="damaged"):
        from_bytes(data)


def test_a_newer_version_says_what_to_do():
    data = to_bytes(small(), {}).replace(b"%s %d " % (TITLE, VERSION), b"%s 9 " % TITLE, 1)
    with pytest.raises(RecordingFileError, match=r"newer.*update the extension"):
        from_bytes(data)


def test_fields_of_another_version_are_refused():
    header = b'{"clock": null, "frames": [1, 2], "facts": {}, "tracks": [{"sensor": "a", '
    header += b'"kind": "PIR", "count": 0, "steps": {}, "fields": ["smell"], "columns": []}]}'
    packed = zlib.compress(header)
    body = struct.pack("<I", len(packed)) + packed
    with pytest.raises(RecordingFileError, match="another version"):
        from_bytes(b"%s %d %d\n" % (TITLE, VERSION, zlib.crc32(body)) + body)


def test_a_track_under_another_name_is_no_recording():
    recording = small()
    recording.tracks["window"] = recording.tracks.pop("door")
    with pytest.raises(ValueError, match=r"'door'.*'window'"):
        to_bytes(recording, {})
