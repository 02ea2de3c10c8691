# SPDX-License-Identifier: GPL-3.0-or-later
"""Every format is read back: the log that was written, as far as the format can hold it."""

from __future__ import annotations

import subprocess
import sys
from datetime import datetime, timedelta
from importlib.util import find_spec
from pathlib import Path
from zoneinfo import ZoneInfo

import pytest
from angen_sensors.sensor_logic.compare import measures
from angen_sensors.sensor_logic.compare import read as read_home
from angen_sensors.sensor_logic.error import InputError
from angen_sensors.sensor_logic.files import write_files
from angen_sensors.sensor_logic.formats import FORMATS, outputs
from angen_sensors.sensor_logic.formats.log import SensorFacts
from angen_sensors.sensor_logic.formats.reading import read_log
from angen_sensors.sensor_logic.formats.source import make_log
from angen_sensors.sensor_logic.log import Event, rows_csv
from log_of_a_year import AWKWARD, ROWS, SENSORS, START, year

ROOT = Path(__file__).resolve().parent.parent.parent
# What a format has no place for.
LOST = {"casas": {"force_n", "partners", "valid", "distance_m"}, "casas-csv": {"partners"}}
LOST["pyadlml"] = {"partners"}
READ = [name for name in FORMATS if name != "parquet" or find_spec("pyarrow")]


@pytest.fixture
def written(tmp_path):
    def write(log, name: str) -> Path:
        target, out = FORMATS[name], tmp_path / f"log of {name}"
        if target.is_folder:
            out.mkdir()
        write_files(outputs.output_files(target, out, target.write(log)))
        return out

    return write


@pytest.mark.parametrize("name", READ)
def test_what_was_written_is_read_back(written, name) -> None:
    # No name ends with a backslash there.
    held = (lambda text: text.rstrip("\\")) if name == "influx" else str
    expected = [(t, held(s), *row) for t, s, *row in ROWS if row[0] not in LOST.get(name, set())]
    source = read_log(written(year(), name))
    found = sorted((e.time, e.sensor, e.field, e.row[-1]) for e in source.events)
    if name in {"casas", "casas-csv"}:
        # Their first line is a change: the states at the start have no time of their own.
        first = 2.833333
        expected = [(max(t - first, 0.0), *rest) for t, *rest in expected]
        assert source.start == START + timedelta(seconds=first)
    else:
        assert source.start == START
    assert [row[1:] for row in found] == [row[1:] for row in sorted(expected)]
    assert [row[0] for row in found] == pytest.approx(
        [row[0] for row in sorted(expected)], abs=1e-7
    )
    assert source.has_activities == (name not in {"events", "home-assistant", "parquet"})
    if name != "events":
        assert source.sensors[held(AWKWARD)].room == "kitchen, small"
        assert {(s.name, s.kind) for s in source.sensors.values()} == {
            (held(sensor.name), sensor.kind) for sensor in SENSORS.values()
        }


@pytest.mark.parametrize("name", READ)
def test_a_log_is_at_no_distance_from_itself_in_another_format(written, tmp_path, name) -> None:
    rows = [(0.0, s, "moved", "0") for s in ("PIR hall", "pir-hall")]
    rows += [
        (5 + 0.7 * i + 0.1 * (i % 3), "PIR hall", "moved", str((i + 1) % 2)) for i in range(99)
    ]
    rows += [
        (0.0, "Switch", "open", "1"),
        (6.0, "Switch", "open", "0"),
        (7.0, "Switch", "open", "1"),
    ]
    log = year(sorted(rows))
    (tmp_path / "events.csv").write_text(rows_csv(c.event for c in log.changes))
    one, two = read_home(tmp_path / "events.csv"), read_home(written(log, name))
    assert {n: s.quantity for n, s in one.sensors.items()} == {
        n: s.quantity for n, s in two.sensors.items()
    }
    found = {(m.group, m.name): m for m in measures(one, two)}
    assert found["motion", "on for"].distance == 0
    assert len(found["motion", "on for"].values[1]) == 49


@pytest.mark.parametrize("name", ["xes", "ocel", "influx", "mcap"])
def test_no_hour_is_lost_where_daylight_saving_begins(written, name) -> None:
    for zone, shift in (("Europe/London", 0), ("Europe/Stockholm", 1)):
        start = datetime(2026, 3, 29, shift, tzinfo=ZoneInfo(zone))
        rows = [(0.0, "PIR hall", "moved", "0"), (7200.0, "PIR hall", "moved", "1")]
        path = written(year(rows, start=start), name)
        assert [event.time for event in read_log(path).events] == [0.0, 7200.0]


@pytest.mark.parametrize("begins", ["2026-03-29T01:30", "2026-10-25T02:30"])
@pytest.mark.parametrize("name", [name for name in READ if name != "events"])
def test_with_the_time_zone_clocks_may_be_put_forward_and_back(written, name, begins) -> None:
    zone = ZoneInfo("Europe/Stockholm")
    start = datetime.fromisoformat(begins).replace(tzinfo=zone)
    values = {0.0: "0", 2.0: "1", 3500.0: "0", 3700.0: "1"}
    rows = [(time, "PIR hall", "moved", value) for time, value in values.items()]
    path = written(year(rows, start=start), name)
    # CASAS has changes alone.
    first = 2.0 if name in {"casas", "casas-csv"} else 0.0
    expected = [max(time, first) for time in values]
    assert [e.time for e in read_log(path, start, zone).events] == expected
    source = read_log(path, None, zone)
    assert [e.time for e in source.events] == [time - first for time in expected]
    assert source.start is not None and source.start.utcoffset() == start.utcoffset()


@pytest.mark.parametrize("name", ["home-assistant", "influx"])
def test_line_separators_within_names_end_no_line(written, name) -> None:
    hall = "PIR\u2028hall\x85"
    events = [Event(float(time), hall, "moved", 1.0, "PIR", str(time)) for time in (0, 1)]
    log = make_log(events, {hall: SensorFacts(hall, "PIR")}, START, [], {})
    found = read_log(written(log, name)).events
    assert [(e.time, e.row[-1]) for e in found] == [(0.0, "0"), (1.0, "1")]


def test_other_programs_folders_are_read_by_the_names_of_their_devices(tmp_path) -> None:
    (tmp_path / "device_map.csv").write_text("id,device\n0,Front door\n1,Hall\n2,Lamp\n")
    rows = [("00", 0, 1), ("01", 1, 1), ("02", 2, "0.5"), ("03", 0, 0), ("09", 1, 0)]
    lines = [f"05.11.2010 00:00:{s}.000000,{device},{value}\n" for s, device, value in rows]
    (tmp_path / "devices.csv").write_text("time,device,value\n" + "".join(lines))
    home = read_home(tmp_path)
    assert {name: sensor.quantity for name, sensor in home.sensors.items()} == {
        "Front door": "opening",
        "Hall": "motion",
    }
    assert home.sensors["Hall"].intervals == [(1.0, 9.0)]


def test_convert_takes_any_format(written, tmp_path) -> None:
    source, out = written(year(), "influx"), tmp_path / "out.xes"
    command = ["convert", source, "--format", "xes", "--out", out]
    done = subprocess.run(
        [sys.executable, "-m", "angen_addon", *map(str, command)],
        cwd=ROOT, capture_output=True, text=True,
    )  # fmt: skip
    assert (done.returncode, done.stdout) == (0, "")
    assert "activities" in done.stderr
    assert [e.row for e in read_log(out).events] == [e.row for e in read_log(source).events]


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"<?xml version='1.0'?><log><trace>", ["xes", "no element"]),
        (b"<?xml version='1.0'?><log></log>", ["no sensor"]),
        (b'{"objects": [', ["ocel"]),
        (b'{"objects": []}', ["ocel", "'events'"]),
        (b'{"topic": "a"}\n', ["home-assistant", "line 1", "'payload'"]),
        (b'{"topic": "a", "payload": "ON"}\n{"a\n', ["home-assistant", "line 2", "JSON"]),
        (b"\x89MCAP0\r\n\x06\xff\x00\x00\x00\x00\x00\x00\x00", ["mcap", "truncated"]),
        (b"cpu,host=a load=1 1\nno line\n", ["influx", "line 2", "no line"]),
        (b"cpu,host=a load=1 1\ncpu,host=a load=x 1\n", ["influx", "line 2", "load is 'x'"]),
        (b"cpu,host=a load=1 1\ncpu,host=a load=1 99999999999999999999999\n", ["influx"]),
        (b"2010-11-04 00:00:01 M001 ON\n2010-13-04 00:00:02 M001 ON\n", ["casas", "line 2"]),
        (b"2010-11-04 00:00:02 M001 ON\n2010-11-04 00:00:01 M001 ON\n", ["casas", "sort"]),
        (b"2010-11-04 00:00:02 T001 21.5\n", ["no sensor"]),
        (b"a,b\n1,2\n", ["line 1", "time_s,frame", "pyadlml"]),
        (b"# A page\n\nIts text: a=1.\n", ["not recognised", "influx"]),
        (b"# A recipe\nVENV ?= a=1\n", ["not recognised", "influx"]),
        (b"BLENDER-v402\x8f\xff", ["not recognised", "influx"]),
        (b"# by influx\ncpu,host=a load=1 1\nno line\n", ["read as influx", "no line"]),
    ],
)
def test_a_file_that_is_none_is_told_in_a_line(tmp_path, content, words) -> None:
    path = tmp_path / "log"
    path.write_bytes(content)
    with pytest.raises(InputError) as raised:
        read_log(path)
    told = str(raised.value)
    assert all(word in told for word in [str(path), *words]), told
    assert "\n" not in told
