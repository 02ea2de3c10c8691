# SPDX-License-Identifier: GPL-3.0-or-later
"""`angen compare`: figures by hand, distances by scipy, logs of other homes in their own format."""

from __future__ import annotations

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
from angen_sensors.sensor_logic.compare import counts, gaps, ks_distance, on_times, read, shares
from hypothesis import given, settings
from hypothesis import strategies as st
from tiers import mostly_slow

ROOT = Path(__file__).resolve().parent.parent.parent
HEADER = "time_s,frame,sensor,kind,field,value\n"
DAY = 86400


def log(tmp_path: Path, rows: list[tuple[float, str, int]], name: str = "events.csv") -> Path:
    """An event log of motion detectors: (seconds, sensor, moved)."""
    path = tmp_path / name
    lines = [f"{time:.6f},1,{sensor},PIR,moved,{moved}\n" for time, sensor, moved in rows]
    path.write_text(HEADER + "".join(lines))
    return path


@pytest.fixture
def compare(angen) -> Callable[..., tuple[int, str, str]]:
    """Runs `angen compare` with arguments; returns its status, standard output and error."""
    return partial(angen, "compare")


def test_figures_of_a_small_home_are_those_by_hand(tmp_path) -> None:
    rows = [(0, "A", 0), (0, "B", 1), (10, "A", 1), (12, "A", 0), (11, "B", 0)]
    rows += [(40, "B", 1), (46, "B", 0), (43, "A", 1), (44.5, "A", 0), (DAY, "A", 1)]
    home = read(log(tmp_path, sorted(rows)))
    assert sorted(on_times(home, "motion")) == [1.5, 2.0, 6.0]
    assert list(gaps(home, "motion")) == [30.0, 3.0, DAY - 43.0]
    # A went on twice in the first 24 hours and once as they ended, B once.
    assert sorted(counts(home, "motion")) == [1.0, 3.0]
    (share,) = shares(home, "motion")
    assert share == pytest.approx(100 * (2.0 + 6.0) / DAY)


def test_what_was_on_at_the_start_or_is_on_at_the_end_is_no_whole_interval(tmp_path) -> None:
    home = read(log(tmp_path, [(0, "A", 1), (5, "A", 0), (8, "A", 1)]))
    assert len(on_times(home, "motion")) == 0
    assert home.sensors["A"].starts == [8.0]


def test_an_unfinished_day_does_not_count_beside_whole_ones(tmp_path) -> None:
    rows = [(0, "A", 0), (10, "A", 1), (20, "A", 0), (DAY + 10, "A", 1), (DAY + 20, "A", 0)]
    home = read(log(tmp_path, rows))
    assert list(counts(home, "motion")) == [1.0]


def test_a_log_of_minutes_tells_its_rate_a_day(tmp_path) -> None:
    home = read(log(tmp_path, [(0, "A", 0), (10, "A", 1), (20, "A", 0), (864, "A", 1)]))
    assert list(counts(home, "motion")) == pytest.approx([200.0])
    assert list(shares(home, "motion")) == pytest.approx([100 * 10 / 864])


DAYS = "time,sensor,kind,field,value,person,because\n"


def folder_of_days(tmp_path: Path, days: int) -> Path:
    """As `angen day` writes it: somebody comes by at 8 and at 9 o'clock each day."""
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
    """Its rates a day would be thousands of millions."""
    moment = log(tmp_path, [(5, "A", 1)], "moment.csv")
    status, out, told = compare(moment, moment)
    assert (status, out) == (2, "")
    assert "moment.csv has changes at one time only" in told


@pytest.mark.parametrize(
    ("one", "two", "enough"), [(1, 1000, False), (3, 3, False), (4, 4, True), (2, 8, True)]
)
def test_a_distance_of_few_values_is_not_told(tmp_path, compare, one, two, enough) -> None:
    """Two like homes of 3 values each are at 1.000 in a tenth of all cases."""
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


some = st.lists(st.floats(0, 1e6) | st.integers(0, 5).map(float), min_size=1, max_size=60)


@settings(deadline=None)
@given(some, some)
def test_the_distance_is_that_of_scipy(a, b) -> None:
    stats = pytest.importorskip("scipy.stats")
    expected = stats.ks_2samp(a, b, method="asymp").statistic
    assert ks_distance(np.array(a), np.array(b)) == pytest.approx(expected, abs=1e-12)


def test_no_values_are_no_distance() -> None:
    assert np.isnan(ks_distance(np.empty(0), np.ones(3)))


@pytest.mark.parametrize("separator", [" ", "\t", ","])
def test_files_of_casas_are_read_with_their_labels(tmp_path, separator) -> None:
    lines = [
        ("2010-11-04", "23:59:59.5", "M003", "ON", 'Sleeping="begin"'),
        ("2010-11-05", "00:00:01.25", "M003", "OFF"),
        ("2010-11-05", "00:00:02", "T001", "21.5"),
        ("2010-11-05", "00:00:03", "D002", "OPEN"),
        ("2010-11-05", "00:00:09", "D002", "CLOSE"),
    ]
    path = tmp_path / "data"
    path.write_text("".join(separator.join(line) + "\n" for line in lines))
    home = read(path)
    assert {name: s.quantity for name, s in home.sensors.items()} == {
        "M003": "motion",
        "D002": "opening",
    }
    assert list(on_times(home, "opening")) == [6.0]


def test_the_same_home_in_another_format_is_at_no_distance(tmp_path, compare) -> None:
    rows = [(0.0, "A", 0)] + [(i * 0.7 + 0.1 * (i % 3), "A", i % 2) for i in range(1, 200)]
    events = log(tmp_path, rows)
    other = tmp_path / "casas.txt"
    command = ["convert", events, "--format", "casas", "--out", other, "--start", "2026-03-02"]
    subprocess.run([sys.executable, "-m", "angen_addon", *map(str, command)], cwd=ROOT, check=True)
    status, out, err = compare(events, other, "--json")
    assert (status, err) == (0, "")
    found = {m["measure"]: m for m in json.loads(out)["measures"]}
    assert found["on for"]["ks_distance"] == 0
    assert found["on for"]["logs"][0]["n"] == 99
    assert found["on for"]["logs"][0]["quantiles"]["0.5"] == pytest.approx(
        found["on for"]["logs"][1]["quantiles"]["0.5"], abs=1e-6
    )


def test_the_table_and_the_picture_tell_both(tmp_path, compare) -> None:
    one = log(tmp_path, [(0, "A", 0), (1, "A", 1), (3, "A", 0), (9, "A", 1)], "one.csv")
    two = log(tmp_path, [(0, "A", 0), (1, "A", 1), (9, "A", 0), (10, "A", 1)], "two.csv")
    status, out, _ = compare(one, two, "--picture", tmp_path / "both.svg")
    assert status == 0
    assert "motion: on for (s): too few values for a distance" in out
    rows = [line.split() for line in out.splitlines() if line.startswith(("one.csv", "two.csv"))]
    assert rows[0][:5] == ["one.csv", "1", "2", "2", "2"]
    assert rows[1][:5] == ["two.csv", "1", "8", "8", "8"]
    drawing = ElementTree.parse(tmp_path / "both.svg").getroot()
    assert len(drawing.findall(".//{*}polyline")) == 8


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("hello\n", ["bad", "line 1"]),
        (HEADER, ["bad", "no sensor that is on or off"]),
        ("2010-11-04 00:03:50.2 M003 ON\nrubbish\n", ["bad", "line 2", "CASAS"]),
        ("2010-11-04 00:03:50 M003 ON\n2010-11-04 00:03:40 M003 OFF\n", ["out of order"]),
        (HEADER + "0,1,A,PIR,moved,7\n", ["bad", "line 2"]),
    ],
)
def test_what_is_no_log_is_told_in_a_line(tmp_path, text, words, compare) -> None:
    bad = tmp_path / "bad"
    bad.write_text(text)
    status, out, err = compare(bad, bad)
    assert (status, out) == (2, "")
    assert err.count("\n") == 1
    assert all(word in err for word in words), err


def test_a_missing_log_is_told(tmp_path, compare) -> None:
    status, _, err = compare(tmp_path / "none", tmp_path / "none")
    assert status == 2
    assert "cannot read" in err and str(tmp_path / "none") in err


@pytest.mark.parametrize("options", mostly_slow(["", "--json"], ""))
@pytest.mark.parametrize(
    ("stream", "status", "says"),
    [
        (">&-", 1, "angen: standard output is closed\n"),
        (">/dev/full", 1, "angen: cannot write to standard output: No space left on device\n"),
        ("| head -c 1 >/dev/null", 0, ""),
        ("2>&- >/dev/full", 1, ""),
    ],
)
def test_standard_output_that_takes_nothing(tmp_path, options, stream, status, says):
    if "full" in stream and not Path("/dev/full").exists():
        pytest.skip("has no /dev/full")
    path = log(tmp_path, [(0, "PIR hall", 0), (5, "PIR hall", 1), (9, "PIR hall", 0)])
    command = f"{sys.executable} -m angen_addon compare {path} {path} {options} {stream}"
    done = subprocess.run(["sh", "-c", command], cwd=ROOT, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (status, says)


def test_names_are_utf_8_whatever_the_terminal_speaks(tmp_path):
    rows = [(0, "PIR hall", 0), (5, "PIR hall", 1), (9, "PIR hall", 0)]
    path = log(tmp_path, rows, "Küche.csv")
    for options in ([], ["--json"]):
        done = subprocess.run(
            [sys.executable, "-m", "angen_addon", "compare", str(path), str(path), *options],
            cwd=ROOT,
            capture_output=True,
            env={**os.environ, "PYTHONIOENCODING": "ascii"},
        )
        assert done.returncode == 0, done.stderr
        assert "Küche" in done.stdout.decode()
