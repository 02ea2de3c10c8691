# SPDX-License-Identifier: GPL-3.0-or-later
"""Formats that are read bring back as much of a log as they can hold.

In logs of real homes and of other programs, damage is mended or reported, and nothing is lost.
"""

from __future__ import annotations

import math
import re
import struct
from datetime import datetime, timedelta
from pathlib import Path
from zoneinfo import ZoneInfo

import pytest
from angen_sensors.sensor_logic.logs.error import InputError
from angen_sensors.sensor_logic.logs.formats import FORMATS, mcap
from angen_sensors.sensor_logic.logs.formats.log import LoggedActivity, SensorFacts
from angen_sensors.sensor_logic.logs.formats.reading import read_log
from angen_sensors.sensor_logic.logs.formats.source import make_log, mended_word
from angen_sensors.sensor_logic.logs.formats.units import Units
from angen_sensors.sensor_logic.logs.log import HEADER, Event
from log_of_a_year import AWKWARD, ROWS, SENSORS, START, write, year

from angen_addon.process.standalone import load_extension

load_extension()
from angen_sensors.angen_addon.commands import convert, replay  # noqa: E402

ROOT = Path(__file__).resolve().parent.parent.parent
# The facts that a format has no field for.
LOST = {"casas": {"force_n", "partners", "valid", "distance_m"}, "casas-csv": {"partners"}}
LOST["pyadlml"] = {"partners"}
READ = ["events", "casas", "casas-csv", "pyadlml", "home-assistant"]


@pytest.fixture
def written(tmp_path):
    return lambda log, name: write(log, name, tmp_path / f"log of {name}")


@pytest.mark.parametrize("name", READ)
def test_what_was_written_is_read_back(written, name) -> None:
    expected = [row for row in ROWS if row[2] not in LOST.get(name, set())]
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
    assert source.has_activities == (name not in {"events", "home-assistant"})
    if name != "events":
        assert source.sensors[AWKWARD].room == "kitchen, small"
        assert {(s.name, s.kind) for s in source.sensors.values()} == {
            (sensor.name, sensor.kind) for sensor in SENSORS.values()
        }


@pytest.mark.parametrize("name", ["xes", "ocel"])
def test_no_hour_is_lost_where_daylight_saving_begins(written, name) -> None:
    for zone, shift in (("Europe/London", 0), ("Europe/Stockholm", 1)):
        start = datetime(2026, 3, 29, shift, tzinfo=ZoneInfo(zone))
        rows = [(0.0, "PIR hall", "moved", "0"), (7200.0, "PIR hall", "moved", "1")]
        text = written(year(rows, start=start, activities=()), name).read_text(encoding="utf-8")
        times = {datetime.fromisoformat(t) for t in re.findall(r"2026-03-29T[^\"]*", text)}
        assert max(times) - min(times) == timedelta(hours=2)


@pytest.mark.parametrize("begins", ["2026-03-29T01:30", "2026-10-25T02:30"])
@pytest.mark.parametrize("name", [name for name in READ if name != "events"])
def test_with_the_time_zone_clocks_may_be_put_forward_and_back(written, name, begins) -> None:
    zone = ZoneInfo("Europe/Stockholm")
    start = datetime.fromisoformat(begins).replace(tzinfo=zone)
    values = {0.0: "0", 2.0: "1", 3500.0: "0", 3700.0: "1"}
    rows = [(time, "PIR hall", "moved", value) for time, value in values.items()]
    path = written(year(rows, start=start), name)
    # CASAS has only changes.
    first = 2.0 if name in {"casas", "casas-csv"} else 0.0
    expected = [max(time, first) for time in values]
    assert [e.time for e in read_log(path, start, zone).events] == expected
    source = read_log(path, None, zone)
    assert [e.time for e in source.events] == [time - first for time in expected]
    assert source.start is not None and source.start.utcoffset() == start.utcoffset()


def test_line_separators_within_names_end_no_line(written) -> None:
    hall = "PIR\u2028hall\x85"
    events = [Event(float(time), hall, "moved", 1.0, "PIR", str(time)) for time in (0, 1)]
    log = make_log(events, {hall: SensorFacts(hall, "PIR")}, START, [], {})
    found = read_log(written(log, "home-assistant")).events
    assert [(e.time, e.row[-1]) for e in found] == [(0.0, "0"), (1.0, "1")]


EVENTS_HEAD = b"time_s,frame,sensor,kind,field,value\n"
ROW = EVENTS_HEAD + b"0,1,A,PIR,moved,1\n"


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"<?xml version='1.0'?><log></log>", ["not recognised", "home-assistant"]),
        (b'{"topic": "a"}\n', ["home-assistant", "line 1", "'payload'"]),
        (b'{"topic": "a", "payload": "ON"}\n{"a\n', ["home-assistant", "line 2", "JSON"]),
        (b"2010-11-04 00:00:01 M001 ON\n2010-13-04 00:00:02 M001 ON\n", ["casas", "line 2"]),
        (b"2010-11-04 00:00:02 M001 ON\n2010-11-04 00:00:01 M001 ON\n", ["casas", "sort"]),
        (b"2010-11-04 00:00:02 T001 21.5\n", ["no sensor"]),
        (b"a,b\n1,2\n", ["line 1", "time_s,frame", "pyadlml"]),
        (ROW + b"1,1,A,PIR,moved,1\n0,1,A,PIR,moved,0\n", ["line 4", "sort the events by time"]),
        (EVENTS_HEAD + b"0,1,A,PIR,moved,perhaps\n", ["line 2", "'moved'", "0 or 1"]),
        (EVENTS_HEAD + b"0,1,A,LIGHT,illuminance_lux,bright\n", ["line 2", "a finite number"]),
        (EVENTS_HEAD + b"0,1,A,SONAR,moved,1\n", ["line 2", "SONAR", "PIR"]),
        (EVENTS_HEAD + b"0,1,A,PIR,open,1\n", ["line 2", "'open'", "moved"]),
        (ROW + b"0,1,A,LIGHT,lit,1\n", ["line 3", "'A'", "PIR", "LIGHT"]),
        (b"BLENDER-v402\x8f\xff", ["not recognised", "pyadlml"]),
    ],
)
def test_a_file_that_is_none_is_told_in_a_line(tmp_path, content, words) -> None:
    path = tmp_path / "log"
    path.write_bytes(content)
    with pytest.raises(InputError) as raised:
        read_log(path).log()
    told = str(raised.value)
    assert all(word in told for word in [str(path), *words]), told
    assert "\n" not in told


# Logs of real homes and of other programs

HEAD = ",".join(HEADER) + "\n"


@pytest.fixture
def run(tmp_path, capsys):
    """Convert a text; return the exit status, the lines on standard error and the output."""

    def run(text: str, name: str = "casas", *options: str) -> tuple[int, list[str], str]:
        source, out = tmp_path / "source", tmp_path / "out"
        source.write_text(text)
        given = [source, "--format", name, "--out", out, *options]
        status = convert.main([str(option) for option in given], "angen")
        lines = capsys.readouterr().err.splitlines()
        told = [line.removeprefix(f"angen: {source}: ").removeprefix("angen: ") for line in lines]
        written = out.read_text(errors="replace") if status == 0 and out.is_file() else ""
        return status, told, written

    return run


def of_casas(*rows: str) -> str:
    return "".join(f"2010-11-04 00:00:{n:02} {row}\n" for n, row in enumerate(rows))


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("PRESENT", "PRESENT"), ("ABSENT", "ABSENT"), ("off", "OFF"), ("CLOSED", "CLOSED"),
        ("OFFc", "OFF"), ("OFF5", "OFF"), ("OFcF", "OFF"), ("OFFccc5", "OFF"), ("ON`", "ON"),
        ("ONM026", "ON"), ("OFFM009", "OFF"), ("OPENc", "OPEN"), ("OF", "OFF"), ("CLOS", "CLOSE"),
        ("O", None), ("C", None), ("21.5", None), ("0", None), ("ONLINE", None), ("", None),
    ],
)  # fmt: skip
def test_words_are_known_or_mended_where_it_is_obvious(text, word) -> None:
    assert mended_word(text) == word


def test_what_is_mended_or_left_out_is_one_line_with_the_first_of_each(run) -> None:
    rows = ["M001 ON", "M001 OFFc", "T002 21.5", "M001 ONM026", "M001 O", "M001 OF", "c ON"]
    status, told, out = run(of_casas(*rows))
    assert status == 0
    assert told == [
        "3 words mended, first line 2: 'OFFc' is OFF; 3 rows left out, first line 3: 'T002 21.5'"
    ]
    assert [line.split()[-1] for line in out.splitlines()] == ["ON", "OFF", "ON", "OFF"]


def test_items_are_present_or_absent_and_a_sensor_keeps_its_kind(tmp_path) -> None:
    rows = of_casas("I03 PRESENT", "Bowl ABSENT", "Fridge OPEN", "Fridge OFF")
    (tmp_path / "data").write_text(rows)
    events = read_log(tmp_path / "data").events
    found = [(e.field, e.row[-1]) for e in events]
    assert found == [("pressed", "1"), ("pressed", "0"), ("open", "1"), ("open", "0")]


@pytest.mark.parametrize("name", ["casas", "casas-csv"])
def test_casas_to_casas_keeps_all_rows_and_names(run, tmp_path, name) -> None:
    rows = ["D007 OPEN", "M014 ON", "M014 OFF", "M003 OFF", "E001 ON"]
    status, told, out = run(of_casas(*rows), name)
    assert (status, told) == (0, [])
    assert [" ".join(line.replace(",", " ").split()[2:4]) for line in out.splitlines()] == rows
    again = read_log(tmp_path / "out")
    assert len(again.events) == len(rows) and not again.has_states


def test_what_casas_cannot_have_is_told(run) -> None:
    status, told, out = run(of_casas("FrontDoor OPEN", "D001 CLOSE"))
    assert status == 0
    assert told == [
        "sensors whose names do not fit CASAS were renamed, as the file OUT.sensors.csv "
        "lists: FrontDoor is D002"
    ]
    assert [line.split()[2] for line in out.splitlines()] == ["D002", "D001"]
    status, told, out = run(HEAD + "0,1,A,PIR,moved,0\n", "casas", "--start", "2026-03-02")
    assert (status, out) == (0, "")
    assert told == ["the file is empty, since CASAS lists only changes, and no sensor changed"]
    status, told, _ = run("", "casas")
    assert status == 2 and told[0].endswith("is empty: no sensor changed, or it was not written")


DOUBLE = of_casas("M001 ON", "M001 OFF") * 2 + of_casas(*[""] * 2, "M001 ON").splitlines()[2]


@pytest.mark.parametrize(
    "text",
    [
        DOUBLE,
        HEAD + "0,1,M001,PIR,moved,1\n1,1,M001,PIR,moved,0\n" * 2 + "2,1,M001,PIR,moved,1\n",
        "time,sensor,kind,field,value,person,because\n"
        + "2010-11-04T00:00:01,M001,PIR,moved,0,,\n2010-11-04T00:00:00,M001,PIR,moved,1,,\n" * 2
        + "2010-11-04T00:00:02,M001,PIR,moved,1,,\n",
    ],
    ids=["casas", "events", "days"],
)
def test_what_is_out_of_order_is_told_by_line_and_time_and_sorted(run, text) -> None:
    status, told, _ = run(text, "events", "--start", "2010-11-04")
    assert status == 2 and len(told) == 1
    assert any(f"line {n}: " in told[0] for n in (3, 4)) and "--sort" in told[0]
    status, told, out = run(text, "events", "--sort", "--start", "2010-11-04")
    assert status == 0 and told == [
        f"sorted by time; rows out of order: {'2' if 'because' in text else '1'}; "
        "repeated rows, left out: 2"
    ]
    assert [(row[:8], row.split(",")[5]) for row in out.splitlines()[1:]] == [
        ("0.000000", "1"), ("1.000000", "0"), ("2.000000", "1")
    ]  # fmt: skip


def test_states_at_the_start_are_at_the_earliest_time_of_what_is_sorted(run, tmp_path) -> None:
    table = "id,sensor,field,kind,room,unit,initial\nM001,Hall,moved,PIR,,,OFF\n"
    (tmp_path / "source.sensors.csv").write_text(table)
    rows = of_casas("M001 ON", "M001 OFF").splitlines()
    status, _, out = run("\n".join(rows[::-1]), "events", "--sort")
    assert status == 0
    assert [row.split(",")[5] for row in out.splitlines()[1:]] == ["0", "1", "0"]


@pytest.mark.parametrize("value", ["nan", "inf", "-inf"])
@pytest.mark.parametrize("name", [name for name in FORMATS if name != "parquet"])
def test_a_number_that_is_not_finite_is_told_alike_in_all_formats(run, name, value) -> None:
    text = HEAD + f"0,1,T,DISTANCE,distance_m,1\n1,1,T,DISTANCE,distance_m,{value}\n"
    status, told, _ = run(text, name)
    assert status == 2
    assert told[-1] == f"line 3: 'distance_m' is '{value}', not a finite number"


@pytest.mark.parametrize(
    ("name", "start", "holds"),
    [
        ("mcap", "1970-01-01", True),
        ("mcap", "1969-12-31T23:59:59", False),
        ("mcap", "2038-01-19T03:14:06", True),
        ("mcap", "2038-01-19T03:14:07", False),
        ("mcap", "2038-01-19T04:14:06+01:00", True),
        ("influx", "1677-09-22", True),
        ("influx", "1677-09-21", False),
        ("influx", "2262-04-11", True),
        ("influx", "2262-04-12", False),
        ("xes", "1000-01-01", True),
        ("casas", "0999-01-01", True),
        ("pyadlml", "0999-01-01", True),
    ],
)
def test_a_date_that_a_format_cannot_hold_is_one_line(run, tmp_path, name, start, holds) -> None:
    text = HEAD + "0,1,A,PIR,moved,0\n1,1,A,PIR,moved,1\n"
    status, told, _ = run(text, name, "--start", start)
    assert (status, len(told)) == ((0, 0) if holds else (2, 1))
    if holds:
        assert (tmp_path / "out").exists()
    else:
        assert f"{name} holds dates from " in told[0] and "give another start" in told[0]
        assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("start", ["0001-01-01", "9999-12-31", "9891-01-01T00:00+14:00"])
def test_a_start_too_near_the_ends_of_the_calendar_is_told(run, start) -> None:
    status, told, _ = run(HEAD, "casas", "--start", start, "--timezone", "Europe/Stockholm")
    assert (status, len(told)) == (2, 1)
    assert "a start must lie between 0001-01-03 and 9890-01-01" in told[0]


def test_dates_are_checked_before_a_run() -> None:
    with pytest.raises(InputError, match="2038-01-19 03:14:07"):
        FORMATS["mcap"].check_dates(datetime(2038, 1, 19), 0.0, 86400.0)
    with pytest.raises(InputError, match="1 and 9999"):
        FORMATS["casas"].check_dates(datetime(9999, 12, 31), 0.0, 2 * 86400.0)


def ranges(events: list[Event], facts: SensorFacts | None = None) -> list[tuple[float, ...]]:
    """Return (min_range, max_range, range) of each Range message of a log.

    Asserts that no topic claims to have activities.
    """
    log = make_log(events, {facts.name: facts} if facts else {})
    found = list(mcap._messages(log))
    assert all(m.about.get("holds") != mcap.ACTIVITIES for m in found)
    messages = [m.data for m in found if m.schema == mcap.RANGE]
    return [tuple(round(x, 6) for x in struct.unpack("<3f", data[-12:])) for data in messages]


def distances(*values: float) -> list[Event]:
    rows = enumerate(values)
    return [Event(float(t), "T", "distance_m", 0.0, "DISTANCE", str(v)) for t, v in rows]


def test_a_distance_without_a_target_is_infinite_and_a_beam_is_no_activity() -> None:
    assert ranges(distances(3.6, 1.5)) == [(0.04, 3.6, math.inf), (0.04, 3.6, 1.5)]
    # A preset's sensor has a longer range than one with the defaults.
    assert ranges(distances(4.0, 1.5)) == [(0.04, 4.0, math.inf), (0.04, 4.0, 1.5)]
    facts = SensorFacts("T", "DISTANCE", "", {"range_min": 0.1, "range_max": 2.0})
    assert ranges(distances(2.0, 1.5), facts) == [(0.1, 2.0, math.inf), (0.1, 2.0, 1.5)]
    events = [Event(float(t), "S", "open", 0.0, "OPTICAL_SWITCH", str(t)) for t in (0, 1)]
    assert ranges(events) == [(0.5, 0.5, -math.inf), (0.5, 0.5, math.inf)]


@pytest.mark.parametrize(
    "time", ["05.11.2010 00:00:09", "2010-11-05 00:00:09", "2010-11-05T00:00:09.0"]
)
@pytest.mark.parametrize("values", [("0", "1"), ("False", "True")])
@pytest.mark.parametrize("names", ["device_map.csv", "device_mapping.csv", None])
def test_folders_of_other_programs_are_read(tmp_path, time, values, names) -> None:
    door, hall, lamp = ("Front door", "Hall", "Lamp") if names is None else "012"
    if names:
        (tmp_path / names).write_text("id,devices\n0,Front door\n1,Hall\n2,Lamp\n")
    rows = "".join(f"{time},{door},{value}\n" for value in values)
    rows += f"{time},{hall},{values[1]}\n{time},{lamp},0.5\n"
    (tmp_path / "devices.csv").write_text("time,device,value\n" + rows)
    read = read_log(tmp_path)
    assert read.start == datetime(2010, 11, 5, 0, 0, 9)
    expected = [("Front door", "open", "0"), ("Front door", "open", "1"), ("Hall", "moved", "1")]
    assert [(e.sensor, e.field, e.row[-1]) for e in read.events] == expected


@pytest.mark.parametrize(
    ("devices", "names", "words"),
    [
        ("time,device,value\nnoon,0,1\n", "id,device\n0,A\n", ["devices.csv line 2", "'noon'"]),
        ("time,device\nnoon,0\n", "id,device\n0,A\n", ["devices.csv line 1", "no column value"]),
        ("time,device,value\n", "a,b\n0,A\n", ["device_map.csv line 1", "id,device"]),
    ],
)
def test_a_folder_that_cannot_be_read_is_told_by_its_line(tmp_path, devices, names, words) -> None:
    (tmp_path / "devices.csv").write_text(devices)
    (tmp_path / "device_map.csv").write_text(names)
    with pytest.raises(InputError) as raised:
        read_log(tmp_path)
    assert all(word in str(raised.value) for word in [str(tmp_path), *words]), raised.value


HISTORY = """entity_id,state,last_changed
binary_sensor.front_door,off,2024-03-01T10:00:00.000Z
binary_sensor.front_door,unavailable,2024-03-01T10:01:00.000Z
binary_sensor.front_door,on,2024-03-01T10:05:00.500Z
binary_sensor.pad_pressed,off,2024-03-01T10:00:00.000Z
sensor.pad_force_n,1.5,2024-03-01T10:00:01.000Z
binary_sensor.hall_motion,on,2024-03-01T10:00:02.000Z
light.kitchen,off,2024-03-01T10:00:03.000Z
sensor.temperature,21,2024-03-01T10:00:00.000Z
"""


def test_the_history_of_home_assistant_is_read(run, tmp_path) -> None:
    status, told, _ = run(HISTORY, "xes")
    assert status == 0
    assert told == [
        "1 state left out, first line 3: 'binary_sensor.front_door unavailable'",
        "left out, because their names do not say that they are a sensor of a known kind: "
        "sensor.temperature; rename them in the file, such as binary_sensor.hall_motion",
    ]
    status, told, _ = run(HISTORY.replace("2024-03-01T10:05:00.500Z", "noon"), "xes")
    assert status == 2 and "line 4: 'noon' is not a time" in told[0]
    (tmp_path / "source").write_text(HISTORY)
    read = read_log(tmp_path / "source")
    assert read.start == datetime(2024, 3, 1, 10)
    assert [(e.time, e.sensor, e.field, e.row[-1]) for e in read.events] == [
        (0.0, "front_door", "open", "0"),
        (0.0, "pad", "pressed", "0"),
        (1.0, "pad", "force_n", "1.5"),
        (2.0, "hall_motion", "moved", "1"),
        (3.0, "kitchen", "lit", "0"),
        (300.5, "front_door", "open", "1"),
    ]


def test_replay_reads_the_history_and_tells_what_it_leaves_out(tmp_path, capsys) -> None:
    path = tmp_path / "history.csv"
    path.write_text(HISTORY)
    log, start = replay._read(path, None)
    assert len(log.changes) == 6 and start == datetime(2024, 3, 1, 10)
    assert "1 state left out" in capsys.readouterr().err


def history(*rows: str) -> str:
    return "entity_id,state,last_changed\n" + "".join(
        f"{row},2024-03-01T10:00:{second:02}.000Z\n" for second, row in enumerate(rows)
    )


RADARS = history("sensor.ld2410_detection_distance,135", "sensor.ld2450_target_1_distance,1832")


def values(out: str) -> list[str]:
    return [row.split(",")[5] for row in out.splitlines()[1:]]


def test_numbers_without_a_unit_are_asked_for_and_never_guessed(run) -> None:
    status, told, _ = run(RADARS, "events")
    assert status == 2
    assert "sensor.ld2410_detection_distance, sensor.ld2450_target_1_distance" in told[0]
    assert "--unit sensor.ld2410_detection_distance=UNIT" in told[0]
    # The other sensors are there.
    status, told, out = run(RADARS + "binary_sensor.hall_motion,on,2024-03-01T10:01Z\n", "events")
    assert (status, len(told), values(out)) == (0, 1, ["1"])


@pytest.mark.parametrize(
    "given",
    [
        ("sensor.ld2410_detection_distance=cm", "sensor.ld2450_target_1_distance=mm"),
        ("detection_distance=cm", "target_1_distance=mm"),
        ("distance_m=mm", "sensor.ld2410_detection_distance=cm"),
        ("distance=mm", "detection_distance=cm"),
    ],
)
def test_the_unit_of_an_entity_or_of_a_field_is_told(run, given) -> None:
    options = [text for unit in given for text in ("--unit", unit)]
    status, told, out = run(RADARS, "events", *options)
    assert (status, told, values(out)) == (0, [], ["1.35", "1.832"])


@pytest.mark.parametrize(
    ("name", "unit", "value", "right"),
    [
        ("a_distance", "m", "1.35", "1.35"), ("a_distance", "in", "100", "2.54"),
        ("a_distance", "ft", "10", "3.048"), ("a_illuminance", "lx", "120", "120"),
        ("a_illuminance", "klx", "1.2", "1200"), ("pad_force_n", "kg", "70", "686.4655"),
        ("a_max_c", "°F", "98.6", "37"), ("a_max_c", "K", "300", "26.85"),
        ("a_distance_m", "cm", "135", "1.35"),
    ],
)  # fmt: skip
def test_units_of_each_field_are_converted(run, name, unit, value, right) -> None:
    rows = history(f"sensor.{name},{value}")
    status, told, out = run(rows, "events", "--unit", f"{name}={unit}")
    assert (status, told, values(out)) == (0, [], [right])


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ("distance_m=parsec", ["distance_m", "'parsec'", "m, cm, mm"]),
        ("distance_m=lx", ["'lx' is no unit of distance_m"]),
        ("distance_m", ["'distance_m' is not FIELD=UNIT"]),
        ("=cm", ["is not FIELD=UNIT"]),
        ("detecton_distance=cm", ["detecton_distance", "did you mean"]),
    ],
)
def test_a_wrong_unit_is_one_line(run, given, words) -> None:
    status, told, _ = run(RADARS, "events", "--unit", given)
    assert (status, len(told)) == (2, 1)
    assert all(word in told[0] for word in words), told
    # Logs whose fields have their units take none.
    status, told, _ = run(HEAD + "0,1,A,DISTANCE,distance_m,135\n", "events", "--unit", given)
    assert (status, len(told)) == (2, 1) and "--unit" in told[0]


def test_a_column_of_units_is_read(run) -> None:
    head, *rows = RADARS.splitlines()
    lines = [f"{head},unit_of_measurement", f"{rows[0]},cm", f"{rows[1]},mm"]
    text = "\n".join(lines) + "\n"
    for options in ((), ("--unit", "distance_m=m")):
        status, told, out = run(text, "events", *options)
        assert (status, told, values(out)) == (0, [], ["1.35", "1.832"])
    status, told, out = run(text, "events", "--unit", "sensor.ld2410_detection_distance=m")
    assert (status, told, values(out)) == (0, [], ["135", "1.832"])


def test_a_row_without_a_reading_needs_no_unit(run) -> None:
    head, row = RADARS.splitlines()[:2]
    gone = ",".join([row.split(",")[0], "unavailable", row.split(",")[2]])
    text = "\n".join([f"{head},unit_of_measurement", f"{gone},", f"{row},cm"]) + "\n"
    status, told, out = run(text, "events")
    assert (status, len(told), values(out)) == (0, 1, ["1.35"]) and "unavailable" in told[0]


@pytest.mark.parametrize(
    ("units", "words"), [(("cm", "m"), "'cm' and 'm'"), (("", "m"), "none and")]
)
def test_a_unit_that_changes_is_one_line(run, units, words) -> None:
    head, row = RADARS.splitlines()[:2]
    text = "\n".join([f"{head},unit_of_measurement", *(f"{row},{unit}" for unit in units)]) + "\n"
    status, told, _ = run(text, "events")
    assert (status, len(told)) == (2, 1)
    assert f"line 3: sensor.ld2410_detection_distance has had two units, {words}" in told[0]


def test_replay_takes_units(tmp_path) -> None:
    path = tmp_path / "history.csv"
    path.write_text(RADARS)
    log, _ = replay._read(path, None, Units.parse(["detection_distance=cm", "distance=mm"]))
    assert [change.value for change in log.changes] == [1.35, 1.832]


@pytest.mark.parametrize(
    "name",
    [
        "wan_status", "printer_online", "front_door_battery", "front_door_tamper", "bed_heater",
        "hall_motion_problem", "phone_charging", "kitchen_leak", "guest_mode", "hall",
    ],
)  # fmt: skip
def test_what_is_no_sensor_of_a_known_kind_is_left_out_and_named(run, name) -> None:
    rows = history(f"binary_sensor.{name},on", "binary_sensor.hall_2_motion,on")
    status, told, out = run(rows, "events")
    assert (status, [row.split(",")[2] for row in out.splitlines()[1:]]) == (0, ["hall_2_motion"])
    assert len(told) == 1 and f"binary_sensor.{name}; rename" in told[0]


@pytest.mark.parametrize(
    ("name", "field"),
    [
        ("front_door_motion", "moved"), ("hall_pir", "moved"), ("hall_occupancy", "moved"),
        ("motion_sensor_hall", "moved"), ("bed_lamp", "lit"), ("ld2410_has_target", "presence"),
        ("ld2410_presence", "presence"), ("wc_window_contact", "open"), ("office_chair", "pressed"),
    ],
)  # fmt: skip
def test_the_last_known_word_of_a_name_says_what_an_entity_measures(run, name, field) -> None:
    status, told, out = run(history(f"binary_sensor.{name},on"), "events")
    assert (status, told, out.splitlines()[1].split(",")[4]) == (0, [], field)


@pytest.mark.parametrize("name", [name for name in READ if name != "events"])
def test_two_changes_of_a_field_at_one_time_are_both_kept(written, name) -> None:
    rows = [(0.0, "PIR hall", "moved", "0")]
    rows += [(float(t), "PIR hall", "moved", value) for t in (1, 2) for value in "1010"]
    log = year(rows)
    path = written(log, name)
    expected = [(time, value) for time, _, _, value in rows]
    if name.startswith("casas"):
        # They list changes alone, and begin with the first.
        expected = [(time - 1.0, value) for time, value in expected[1:]]
    found = [(e.time, e.row[-1]) for e in read_log(path).events]
    assert found[-8:] == expected[-8:]


def points(text: str) -> list[tuple[str, str, str]]:
    """Return series, fields and time of each line for InfluxDB."""
    return [tuple(line.rsplit(" ", 2)) for line in text.splitlines()]


def test_influx_keeps_each_change_and_activity_as_a_point_of_its_own(run) -> None:
    # The hour that clocks skip in spring, in which a sensor changes often.
    times = [f"2026-03-29 02:{n // 60:02}:{n % 60:02}" for n in range(0, 3600, 2)]
    rows = "".join(f"{time} M001 {'OFF' if n % 2 else 'ON'}\n" for n, time in enumerate(times))
    rows += "2026-03-29 03:00:00 M001 ON\n"
    status, told, out = run(rows, "influx", "--timezone", "Europe/Stockholm")
    assert (status, len(told)) == (0, 1) and "1800 changes" in told[0]
    found = points(out)
    assert len({(series, time) for series, _, time in found}) == len(found) == 1801
    assert [fields for _, fields, _ in found[:3]] == ["moved=true", "moved=false", "moved=true"]
    assert [int(time) for *_, time in found] == sorted(int(time) for *_, time in found)


def test_influx_keeps_the_end_of_an_activity_and_the_begin_of_the_next() -> None:
    hours = [(0, 1, "Cooking"), (1, 2, "Eating"), (2, 2, "Washing up")]
    activities = [
        LoggedActivity(start * 10**6, end * 10**6, "Anna", name, "kitchen")
        for start, end, name in hours
    ]
    log = make_log([Event(0.0, "A", "moved", 0.0, "PIR", "0")], {}, START, activities)
    found = points(FORMATS["influx"].write(log).files[""])
    assert len({(series, time) for series, _, time in found}) == len(found) == 7
    last = [fields for series, fields, _ in sorted(found, key=lambda point: int(point[2]))][-4:]
    assert [fields.rpartition("=")[2] for fields in last] == ["true", "false", "true", "false"]
