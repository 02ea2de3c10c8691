# SPDX-License-Identifier: GPL-3.0-or-later
"""`angen compare`: figures by hand, distances by scipy, logs of other homes in their own format.

Also the event log's text, reading it back, the differences of `check`, and `partners`.
"""

from __future__ import annotations

import csv
import io
import json
import os
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from angen_sensors.sensor_logic.logs.comparison.compare import (
    counts,
    gaps,
    ks_distance,
    on_times,
    read,
    shares,
)
from angen_sensors.sensor_logic.logs.error import InputError
from angen_sensors.sensor_logic.logs.log import (
    Event,
    differences,
    for_spreadsheets,
    format_value,
    read_events,
    to_csv,
)
from angen_sensors.sensor_logic.logs.wording import joined, split
from angen_sensors.sensor_logic.model import Reading
from angen_sensors.sensor_logic.recording.events import events_csv, samples_csv
from angen_sensors.sensor_logic.recording.tracks import Recording, Track
from hypothesis import example, given, settings
from hypothesis import strategies as st
from tiers import mostly_slow
from tutorials import shell

ROOT = Path(__file__).resolve().parent.parent.parent
HEADER = "time_s,frame,sensor,kind,field,value\n"
DAY = 86400


def log(tmp_path: Path, rows: list[tuple[float, str, int]], name: str = "events.csv") -> Path:
    """Write an event log of motion detectors: (seconds, sensor, moved)."""
    path = tmp_path / name
    lines = [f"{time:.6f},1,{sensor},PIR,moved,{moved}\n" for time, sensor, moved in rows]
    path.write_text(HEADER + "".join(lines))
    return path


@pytest.fixture
def compare(angen) -> Callable[..., tuple[int, str, str]]:
    """Run `angen compare` with arguments; return its status, standard output and error."""
    return partial(angen, "compare")


def test_figures_of_a_small_home_are_those_by_hand(tmp_path) -> None:
    rows = [(0, "A", 0), (0, "B", 1), (10, "A", 1), (12, "A", 0), (11, "B", 0)]
    rows += [(40, "B", 1), (46, "B", 0), (43, "A", 1), (44.5, "A", 0), (DAY, "A", 1)]
    home = read(log(tmp_path, sorted(rows)))
    # An output that is on at the start or end is no whole interval.
    assert sorted(on_times(home, "motion")) == [1.5, 2.0, 6.0]
    assert list(gaps(home, "motion")) == [30.0, 3.0, DAY - 43.0]
    # A went on twice in the first 24 hours and once as they ended, B once.
    assert sorted(counts(home, "motion")) == [1.0, 3.0]
    (share,) = shares(home, "motion")
    assert share == pytest.approx(100 * (2.0 + 6.0) / DAY)
    # An unfinished day does not count beside whole ones.
    rows = [(0, "A", 0), (10, "A", 1), (20, "A", 0), (DAY + 10, "A", 1), (DAY + 20, "A", 0)]
    assert list(counts(read(log(tmp_path, rows)), "motion")) == [1.0]
    # The rate of a log of minutes is scaled to a day.
    home = read(log(tmp_path, [(0, "A", 0), (10, "A", 1), (20, "A", 0), (864, "A", 1)]))
    assert list(counts(home, "motion")) == pytest.approx([200.0])
    assert list(shares(home, "motion")) == pytest.approx([100 * 10 / 864])


DAYS = "time,sensor,kind,field,value,person,because\n"


def folder_of_days(tmp_path: Path, days: int) -> Path:
    """Write a folder as `angen day` does: motion at 8 and at 9 o'clock each day."""
    (tmp_path / "home.toml").write_text(
        f"start = 2026-03-02T00:00:00\ndays = {days}\nsensors = []\n"
    )
    rows = ["2026-03-02T00:00:00.000,A,PIR,moved,0,,\n"]
    for day in range(2, 2 + days):
        for hour in (8, 9):
            rows.append(f"2026-03-{day:02}T{hour:02}:00:00.000,A,PIR,moved,1,anna,Body\n")
            rows.append(f"2026-03-{day:02}T{hour:02}:00:05.000,A,PIR,moved,0,anna,\n")
    (tmp_path / "events.csv").write_text(DAYS + "".join(rows))
    return tmp_path


@pytest.mark.parametrize("name", ["", "events.csv"])
def test_a_folder_of_days_lasts_until_its_last_midnight(tmp_path, name) -> None:
    home = read(folder_of_days(tmp_path, 3) / name)
    assert list(counts(home, "motion")) == [2.0, 2.0, 2.0]
    assert list(shares(home, "motion")) == pytest.approx([100 * 10 / DAY] * 3)
    assert home.length == 3 * DAY


def test_a_log_of_minutes_tells_that_its_rates_are_scaled_up(tmp_path, compare) -> None:
    short = log(tmp_path, [(0, "A", 0), (10, "A", 1), (20, "A", 0), (864, "A", 1)], "short.csv")
    folder = tmp_path / "days"
    folder.mkdir()
    folder_of_days(folder, 1)
    status, out, _ = compare(short, folder)
    assert status == 0
    assert "short.csv lasts 14 min: its times and % of a day are scaled up" in out
    assert "days lasts" not in out
    days = json.loads(compare(short, folder, "--json")[1])["days"]
    assert days == pytest.approx([0.01, 1.0])


def test_a_log_of_one_moment_is_refused(tmp_path, compare) -> None:
    """Its daily rates would be thousands of millions."""
    moment = log(tmp_path, [(5, "A", 1)], "moment.csv")
    status, out, told = compare(moment, moment)
    assert (status, out) == (2, "")
    assert "moment.csv are at the same time" in told


@pytest.mark.parametrize(
    ("one", "two", "enough"), [(1, 1000, False), (3, 3, False), (4, 4, True), (2, 8, True)]
)
def test_a_distance_of_few_values_is_not_told(tmp_path, compare, one, two, enough) -> None:
    """The distance of two like homes with 3 values each is 1.000 in a tenth of all cases."""
    paths = []
    for name, count, lasts in (("one", one, 1.0), ("two", two, 3.0)):
        rows = [(0.0, "A", 0)]
        for number in range(count):
            rows += [(10.0 * number + 1, "A", 1), (10.0 * number + 1 + lasts, "A", 0)]
        paths.append(log(tmp_path, rows, name))
    told = "distance 1.000" if enough else "too few values for a distance"
    assert f"motion: on for (s): {told}\n" in compare(*paths, "--picture", tmp_path / "it.svg")[1]
    found = json.loads(compare(*paths, "--json")[1])["measures"][0]
    assert found["ks_distance"] == (1.0 if enough else None)
    assert ("on for (s), distance" in (tmp_path / "it.svg").read_text()) == enough
    assert ElementTree.parse(tmp_path / "it.svg").getroot().find(".//{*}polyline") is not None


some = st.lists(st.floats(0, 1e6) | st.integers(0, 5).map(float), min_size=1, max_size=60)


@settings(deadline=None)
@given(some, some)
def test_the_distance_is_that_of_scipy(a, b) -> None:
    stats = pytest.importorskip("scipy.stats")
    expected = stats.ks_2samp(a, b, method="asymp").statistic
    assert ks_distance(np.array(a), np.array(b)) == pytest.approx(expected, abs=1e-12)
    assert np.isnan(ks_distance(np.empty(0), np.array(b)))


@pytest.mark.parametrize("separator", [" ", "\t", ","])
def test_files_of_casas_are_read_with_their_labels(tmp_path, separator) -> None:
    lines = [
        ("2010-11-04", "23:59:59.5", "M003", "ON", 'Sleeping="begin"'),
        ("2010-11-05", "00:00:01.25", "M003", "OFF"),
        ("2010-11-05", "00:00:02", "T001", "21.5"),
        ("2010-11-05", "00:00:03", "D002", "OPEN"),
        ("2010-11-05", "00:00:09", "D002", "CLOSE"),
    ]
    (tmp_path / "data").write_text("".join(separator.join(line) + "\n" for line in lines))
    home = read(tmp_path / "data")
    found = {name: sensor.quantity for name, sensor in home.sensors.items()}
    assert found == {"M003": "motion", "D002": "opening"}
    assert list(on_times(home, "opening")) == [6.0]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("hello\n", ["bad", "line 1"]),
        (HEADER, ["bad", "no sensor with the states on and off"]),
        ("2010-11-04 00:03:50.2 M003 ON\nrubbish\n", ["bad", "line 2", "CASAS"]),
        (None, ["cannot read", "bad"]),
    ],
)
def test_what_is_no_log_is_told_in_a_line(tmp_path, text, words, compare) -> None:
    bad = tmp_path / "bad"
    if text is not None:
        bad.write_text(text)
    status, out, err = compare(bad, bad)
    assert (status, out) == (2, "")
    assert err.count("\n") == 1
    assert all(word in err for word in words), err


@pytest.mark.parametrize("options", mostly_slow(["", "--json"], ""))
@pytest.mark.parametrize(
    ("stream", "status", "says"),
    [
        (">&-", 1, "angen: standard output is closed: redirect it to a file\n"),
        (">/dev/full", 1, "angen: cannot write to standard output: No space left on device\n"),
        ("| head -c 1 >/dev/null", 0, ""),
        ("2>&- >/dev/full", 1, ""),
    ],
)
@pytest.mark.skipif(sys.platform == "win32", reason="has other streams")
def test_standard_output_that_takes_nothing(tmp_path, options, stream, status, says):
    if "full" in stream and not Path("/dev/full").exists():
        pytest.skip("has no /dev/full")
    path = log(tmp_path, [(0, "PIR hall", 0), (5, "PIR hall", 1), (9, "PIR hall", 0)])
    command = f"{sys.executable} -m angen_addon compare {path} {path} {options} {stream}"
    done = subprocess.run([shell(), "-c", command], cwd=ROOT, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (status, says)


def test_names_are_utf_8_whatever_the_terminal_speaks(tmp_path):
    rows = [(0, "PIR hall", 0), (5, "PIR hall", 1), (9, "PIR hall", 0)]
    path = str(log(tmp_path, rows, "Küche.csv"))
    for options in ([], ["--json"]):
        command = [sys.executable, "-m", "angen_addon", "compare", path, path, *options]
        environment = {**os.environ, "PYTHONIOENCODING": "ascii"}
        done = subprocess.run(command, cwd=ROOT, capture_output=True, env=environment)
        assert done.returncode == 0, done.stderr
        assert "Küche" in done.stdout.decode()


def test_usage_is_told_where_a_file_or_a_verb_is_missing(angen) -> None:
    for arguments in ([], ["simulate", "--frames", "1:2"]):
        status, _, err = angen(*arguments)
        assert status == 2 and "usage" in err


# The event log's text

HEAD = "time_s,frame,sensor,kind,field,value\r\n"


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
    assert events_csv(recording(switch("Door", [0, 0, 1, 1, 0]))) == HEAD + (
        "0.000000,1,Door,OPTICAL_SWITCH,open,0\r\n"
        "0.083333,3,Door,OPTICAL_SWITCH,open,1\r\n"
        "0.166667,5,Door,OPTICAL_SWITCH,open,0\r\n"
    )
    assert events_csv(recording(switch("Door", []))) == HEAD
    between = events_csv(recording(switch("Door", [0, 1, 0], frames=[1, 1.25, 2 + 1 / 3])))
    assert [row.split(",")[1] for row in between.splitlines()[1:]] == ["1", "1.25", "2.333333"]


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
    assert log == HEAD + f"0.000000,1,{written},OPTICAL_SWITCH,open,1\r\n"
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


def test_samples_have_every_update_and_a_lookup_finds_the_last_one():
    assert "".join(samples_csv(switch("Door", [0, 1, 1]))) == (
        "time_s,frame,open,range_m\r\n0.000000,1,0,0.3\r\n0.041667,2,1,0.3\r\n0.083333,3,1,0.3\r\n"
    )
    track = switch("Door", [0, 1, 0], frames=[1, 5, 9])
    assert [track.at(frame) for frame in (0, 0.9, 1, 4.99, 5, 100)] == [None, None, 0, 0, 1, 2]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (b"BLENDER-v405\xff\xfe\x00\x80", r"log\.csv"),
        ("", "line 1"),
        ("time,frame\r\n", "line 1"),
        (HEAD + "0.0,1,Door,OPTICAL_SWITCH,open\r\n", "line 2"),
        (HEAD + "0.0,1,Door,OPTICAL_SWITCH,open,1\r\nnonsense\r\n", "line 3"),
        (HEAD + "zero,1,Door,OPTICAL_SWITCH,open,1\r\n", "line 2"),
        (HEAD + "nan,1,Door,OPTICAL_SWITCH,open,1\r\n", "line 2"),
        (HEAD + "inf,1,Door,OPTICAL_SWITCH,open,1\r\n", "line 2"),
        (HEAD + '0.0,1,"' + "x" * 200_000, "line 2"),
    ],
)
def test_a_file_that_is_no_event_log_is_refused_with_the_line(tmp_path, text, words):
    path = tmp_path / "log.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(InputError, match=words) as error:
        read_events(path)
    assert str(path) in str(error.value)


def test_a_log_saved_by_a_spreadsheet_is_read(tmp_path):
    """With a byte order mark, and line ends as on Unix."""
    path = tmp_path / "log.csv"
    text = HEAD + "0.5,13,Dörr,OPTICAL_SWITCH,open,1\r\n"
    path.write_bytes(b"\xef\xbb\xbf" + text.replace("\r\n", "\n").encode("utf-8"))
    assert read_events(path) == [Event(0.5, "Dörr", "open", 13.0, "OPTICAL_SWITCH", "1")]


def event(time, value="1", sensor="Door", field="open"):
    return Event(time, sensor, field, time * 24 + 1, "OPTICAL_SWITCH", value)


def verdicts(expected, actual, value=0.0, time=0.0):
    return [line.split(":")[0] for line in differences(expected, actual, value, time)]


def force(value):
    return [event(1.0, value, field="force_n")]


THREE = [event(0.0, "0"), event(1.0, "1"), event(2.0, "0")]
OTHER = event(1.0, sensor="Other")


@pytest.mark.parametrize(
    ("expected", "actual", "tolerances", "told"),
    [
        ([*THREE[:2], OTHER], [OTHER, *THREE[1::-1]], (), []),
        ([], [], (), []),
        (THREE, THREE[:1] + THREE[2:], (), ["missing"]),
        (THREE[:2], THREE, (), ["unexpected"]),
        (THREE, [THREE[0], event(1.0, "0"), THREE[2]], (), ["different"]),
        (THREE, [THREE[0], event(1.5, "1"), THREE[2]], (), ["missing", "unexpected"]),
        ([event(3.0, sensor="A")], [event(1.0, sensor="B")], (), ["unexpected", "missing"]),
        ([event(1.0)], [event(1.04)], (0.0, 0.05), []),
        ([event(1.0)], [event(1.06)], (0.0, 0.05), ["missing", "unexpected"]),
        ([event(1.0)], [event(1.0 + 4e-7)], (), []),  # times have six decimals
        ([event(1.0)], [event(1.0 + 1 / 240)], (), ["missing", "unexpected"]),
        (force("10.0"), force("10.4"), (0.5,), []),
        (force("10.0"), force("10.6"), (0.5,), ["different"]),
        (force("a;b"), force("a;c"), (0.5,), ["different"]),
        (force(""), force("1"), (5.0,), ["different"]),
    ],
)
def test_differences_of_logs_in_order_of_time(expected, actual, tolerances, told):
    assert verdicts(expected, actual, *tolerances) == told


def test_a_difference_names_time_sensor_field_and_both_values():
    (line,) = differences([event(1.0, "1")], [event(1.0, "0")], 0.0, 0.0)
    for word in ("1.000000", "25", "Door", "open", "0", "expected 1"):
        assert word in line


def test_names_that_are_formulas_are_none_for_spreadsheets():
    text = to_csv(("sensor", "value"), [("=cmd()|' /C calc'!A0", "-1.5"), ("@SUM(A1)", "+1e3")])
    assert "".join(for_spreadsheets([text])) == "\ufeff" + to_csv(
        ("sensor", "value"), [("'=cmd()|' /C calc'!A0", "-1.5"), ("'@SUM(A1)", "+1e3")]
    )
    plain = to_csv(("sensor",), [('Hall, "PIR"',), ("two\nlines",), ("3-D",)])
    assert "".join(for_spreadsheets([plain])) == f"\ufeff{plain}"


# Partners


@given(st.lists(st.text("a;\\ü\n", min_size=1, max_size=4), max_size=4))
@example(["a\\", "b"])
@example(["\\;", ";\\", ";;", "\\\\"])
def test_there_and_back(names):
    assert split(joined(names)) == sorted(names)


def test_ordinary_names_stay_as_they_are():
    assert joined(["right", "left", "Küche: Stuhl (2)"]) == "Küche: Stuhl (2);left;right"
