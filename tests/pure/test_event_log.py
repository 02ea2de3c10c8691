# SPDX-License-Identifier: GPL-3.0-or-later
"""The event log's text, reading it back, and what `check` calls a difference."""

import csv
import io

import pytest
from angen_sensors.sensor_logic.error import InputError
from angen_sensors.sensor_logic.log import (
    Event,
    differences,
    events_csv,
    for_spreadsheets,
    format_value,
    read_events,
    samples_csv,
    to_csv,
)
from angen_sensors.sensor_logic.model import Reading
from angen_sensors.sensor_logic.recording.tracks import Recording, Track

HEADER = "time_s,frame,sensor,kind,field,value\r\n"


def switch(name, states, fps=24.0, frames=None):
    track = Track(name, "OPTICAL_SWITCH")
    for index, state in enumerate(states):
        frame = frames[index] if frames else index + 1
        fields = {"open": bool(state), "range_m": 0.1 + 0.2}
        track.append(frame, (frame - 1) / fps, Reading(bool(state), 0.3, fields))
    return track


def recording(*tracks):
    return Recording({track.sensor: track for track in tracks}, 1, 100)


def test_a_row_for_the_first_update_and_for_each_change():
    assert events_csv(recording(switch("Door", [0, 0, 1, 1, 0]))) == HEADER + (
        "0.000000,1,Door,OPTICAL_SWITCH,open,0\r\n"
        "0.083333,3,Door,OPTICAL_SWITCH,open,1\r\n"
        "0.166667,5,Door,OPTICAL_SWITCH,open,0\r\n"
    )


def test_no_updates_no_rows():
    assert events_csv(recording(switch("Door", []))) == HEADER


def test_frames_between_frames_have_decimals():
    log = events_csv(recording(switch("Door", [0, 1, 0], frames=[1, 1.25, 2 + 1 / 3])))
    assert [row.split(",")[1] for row in log.splitlines()[1:]] == ["1", "1.25", "2.333333"]


def test_sorted_by_time_then_sensor_then_field():
    pad = Track("Able", "PRESSURE")
    fields = {f.name: 0 for f in pad.kind.samples} | {"partners": "a;b", "force_n": 2.0}
    pad.append(1, 0.0, Reading(False, 2.0, fields))
    found = recording(switch("Zoe", [0]), switch("Door", [0, 1]), pad, switch("Äng", [0, 1]))
    rows = list(csv.reader(io.StringIO(events_csv(found))))[1:]
    assert [(row[0], row[2], row[4]) for row in rows] == [
        ("0.000000", "Able", "force_n"),
        ("0.000000", "Able", "partners"),
        ("0.000000", "Able", "pressed"),
        ("0.000000", "Able", "valid"),
        ("0.000000", "Door", "open"),
        ("0.000000", "Zoe", "open"),
        ("0.000000", "Äng", "open"),
        ("0.041667", "Door", "open"),
        ("0.041667", "Äng", "open"),
    ]


@pytest.mark.parametrize(
    ("name", "written"),
    [
        ("Door", "Door"),
        ("Kök, dörr", '"Kök, dörr"'),
        ('the "big" door', '"the ""big"" door"'),
        ("two\nlines", '"two\nlines"'),
        ("two\r\nlines", '"two\r\nlines"'),
        ("semi;colon", "semi;colon"),
    ],
)
def test_names_are_quoted_as_rfc_4180_asks_and_read_back(tmp_path, name, written):
    log = events_csv(recording(switch(name, [1])))
    assert log == HEADER + f"0.000000,1,{written},OPTICAL_SWITCH,open,1\r\n"
    path = tmp_path / "log.csv"
    path.write_bytes(log.encode("utf-8"))
    assert read_events(path) == [Event(0.0, name, "open", 1.0, "OPTICAL_SWITCH", "1")]


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (True, "1"),
        (False, "0"),
        (float("nan"), ""),
        (12, "12"),
        (0.1 + 0.2, "0.3"),
        (1 / 3, "0.333333333"),
        (123456789.123, "123456789"),
        (2.5e-12, "2.5e-12"),
        (4.0, "4"),
        ("a;b", "a;b"),
    ],
)
def test_values_are_written(value, text):
    assert format_value(value) == text


def test_samples_have_every_update():
    assert "".join(samples_csv(switch("Door", [0, 1, 1]))) == (
        "time_s,frame,open,range_m\r\n0.000000,1,0,0.3\r\n0.041667,2,1,0.3\r\n0.083333,3,1,0.3\r\n"
    )


def test_a_lookup_between_updates_finds_the_last_one():
    track = switch("Door", [0, 1, 0], frames=[1, 5, 9])
    assert [track.at(frame) for frame in (0, 0.9, 1, 4.99, 5, 100)] == [None, None, 0, 0, 1, 2]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "line 1"),
        ("time,frame\r\n", "line 1"),
        (HEADER + "0.0,1,Door,OPTICAL_SWITCH,open\r\n", "line 2"),
        (HEADER + "0.0,1,Door,OPTICAL_SWITCH,open,1\r\nnonsense\r\n", "line 3"),
        (HEADER + "zero,1,Door,OPTICAL_SWITCH,open,1\r\n", "line 2"),
        (HEADER + "nan,1,Door,OPTICAL_SWITCH,open,1\r\n", "line 2"),
        (HEADER + "inf,1,Door,OPTICAL_SWITCH,open,1\r\n", "line 2"),
        (HEADER + '0.0,1,"' + "x" * 200_000, "line 2"),
    ],
)
def test_a_file_that_is_no_event_log_is_refused_with_the_line(tmp_path, text, words):
    path = tmp_path / "log.csv"
    path.write_text(text, encoding="utf-8", newline="")
    with pytest.raises(InputError, match=words) as error:
        read_events(path)
    assert str(path) in str(error.value)


def test_a_binary_file_is_refused_by_name(tmp_path):
    path = tmp_path / "home.blend"
    path.write_bytes(b"BLENDER-v405\xff\xfe\x00\x80")
    with pytest.raises(InputError, match=r"home\.blend"):
        read_events(path)


def test_a_log_saved_by_a_spreadsheet_is_read(tmp_path):
    """With a byte order mark, and lines that end as on Unix."""
    path = tmp_path / "log.csv"
    text = HEADER + "0.5,13,Dörr,OPTICAL_SWITCH,open,1\r\n"
    path.write_bytes(b"\xef\xbb\xbf" + text.replace("\r\n", "\n").encode("utf-8"))
    assert read_events(path) == [Event(0.5, "Dörr", "open", 13.0, "OPTICAL_SWITCH", "1")]


def event(time, value="1", sensor="Door", field="open"):
    return Event(time, sensor, field, time * 24 + 1, "OPTICAL_SWITCH", value)


def verdicts(expected, actual, value=0.0, time=0.0):
    return [line.split(":")[0] for line in differences(expected, actual, value, time)]


def test_equal_logs_have_no_differences():
    events = [event(0.0, "0"), event(1.0), event(1.0, sensor="Other")]
    assert verdicts(events, list(reversed(events))) == []
    assert verdicts([], []) == []


def test_missing_unexpected_and_different_events_are_told_in_order_of_time():
    expected = [event(0.0, "0"), event(1.0, "1"), event(2.0, "0")]
    assert verdicts(expected, expected[:1] + expected[2:]) == ["missing"]
    assert verdicts(expected[:2], expected) == ["unexpected"]
    assert verdicts(expected, [event(0.0, "0"), event(1.0, "0"), event(2.0, "0")]) == ["different"]
    later = [event(0.0, "0"), event(1.5, "1"), event(2.0, "0")]
    assert verdicts(expected, later) == ["missing", "unexpected"]
    assert verdicts([event(3.0, sensor="A")], [event(1.0, sensor="B")]) == ["unexpected", "missing"]


def test_a_difference_names_time_sensor_field_and_both_values():
    (line,) = differences([event(1.0, "1")], [event(1.0, "0")], 0.0, 0.0)
    for word in ("1.000000", "25", "Door", "open", "0", "expected 1"):
        assert word in line


def test_time_tolerance():
    assert verdicts([event(1.0)], [event(1.04)], time=0.05) == []
    assert verdicts([event(1.0)], [event(1.06)], time=0.05) == ["missing", "unexpected"]
    assert verdicts([event(1.0)], [event(1.0 + 4e-7)]) == [], "times have six decimals"
    assert verdicts([event(1.0)], [event(1.0 + 1 / 240)]) == ["missing", "unexpected"]


def test_value_tolerance_is_for_numbers_alone():
    def force(value):
        return event(1.0, value, field="force_n")

    assert verdicts([force("10.0")], [force("10.4")], value=0.5) == []
    assert verdicts([force("10.0")], [force("10.6")], value=0.5) == ["different"]
    assert verdicts([force("a;b")], [force("a;c")], value=0.5) == ["different"]
    assert verdicts([force("")], [force("1")], value=5.0) == ["different"]


def test_names_that_are_formulas_are_none_for_spreadsheets():
    text = to_csv(("sensor", "value"), [("=cmd()|' /C calc'!A0", "-1.5"), ("@SUM(A1)", "+1e3")])
    assert for_spreadsheets(text) == to_csv(
        ("sensor", "value"), [("'=cmd()|' /C calc'!A0", "-1.5"), ("'@SUM(A1)", "+1e3")]
    )
    plain = to_csv(("sensor",), [('Hall, "PIR"',), ("two\nlines",), ("3-D",)])
    assert for_spreadsheets(plain) == plain
