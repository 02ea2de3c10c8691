# SPDX-License-Identifier: GPL-3.0-or-later
"""`angen convert`: without Blender, exact in time, one clear line per error."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
from angen_sensors.sensor_logic.logs.formats import FORMATS
from angen_sensors.sensor_logic.logs.formats.log import camel, slug, unique
from angen_sensors.sensor_logic.logs.formats.reading import read_log
from angen_sensors.sensor_logic.logs.formats.source import make_log
from log_of_a_year import write, year

ROOT = Path(__file__).resolve().parent.parent.parent
HEADER = "time_s,frame,sensor,kind,field,value\r\n"
EVENTS = (
    HEADER
    + "0.000000,1,PIR hall,PIR,moved,0\r\n0.000000,1,Switch,OPTICAL_SWITCH,open,0\r\n"
    + "2.833333,69,PIR hall,PIR,moved,1\r\n"
    + "31536000.000001,756864001,Switch,OPTICAL_SWITCH,open,1\r\n"
)
# Runs the command where no part of Blender can be imported.
WITHOUT_BLENDER = """
import sys
for name in ("bpy", "mathutils", "bmesh"):
    sys.modules[name] = None
from angen_addon.__main__ import main
sys.exit(main(sys.argv[1:]))
"""


@pytest.fixture
def convert(tmp_path, angen):
    """Run `angen convert` on the events above, or on others; return (status, standard error)."""

    def run(*options: object, events: str = EVENTS) -> tuple[int, str]:
        source = tmp_path / "events.csv"
        source.write_text(events, newline="")
        status, out, err = angen("convert", source, *options)
        assert out == ""
        return status, err

    return run


def test_it_needs_no_blender_and_takes_any_format(tmp_path) -> None:
    source, target = tmp_path / "home", tmp_path / "log.jsonl"
    write(year(), "pyadlml", source)
    options = ["--format", "home-assistant", "--out", target]
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT_BLENDER, "convert", source, *map(str, options)],
        cwd=ROOT,
        capture_output=True,
        text=True,
    )
    assert (done.returncode, done.stdout) == (0, ""), done.stderr
    assert "activities" in done.stderr
    assert [e.row for e in read_log(target).events] == [e.row for e in read_log(source).events]


@pytest.mark.parametrize("verb", ["compare", "replay", "learn"])
def test_the_other_verbs_need_no_blender_either(verb) -> None:
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT_BLENDER, verb, "--help"],
        cwd=ROOT,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0 and f"usage: python -m angen_addon {verb}" in done.stdout


def one_line(err: str) -> str:
    """Return the only line of standard error, without its prefix."""
    assert err.count("\n") == 1, err
    assert err.startswith("angen: ")
    return err.removeprefix("angen: ").rstrip("\n")


def test_the_event_log_comes_back_byte_for_byte(convert, tmp_path) -> None:
    out = tmp_path / "same.csv"
    status, err = convert("--format", "events", "--out", out)
    assert status == 0 and "taken as 1970" in one_line(err)
    assert out.read_bytes() == EVENTS.encode()


def test_an_event_log_gets_dates_where_its_start_is_given_and_keeps_them(convert, tmp_path) -> None:
    rows = HEADER + "0,1,P,PIR,moved,0\r\n7200.5,1,P,PIR,moved,1\r\n"
    dated, again, out = (tmp_path / name for name in ("dated.csv", "again.csv", "out.txt"))
    start = ["--start", "2026-03-29T01:00", "--timezone", "Europe/Stockholm"]
    assert convert("--format", "events", "--out", dated, *start, events=rows) == (0, "")
    # At 02:00 of this night clocks in Sweden went to 03:00.
    assert dated.read_bytes().decode() == (
        "time_s,frame,sensor,kind,field,value,time\r\n"
        "0.000000,1,P,PIR,moved,0,2026-03-29T01:00:00.000+01:00\r\n"
        "7200.500000,1,P,PIR,moved,1,2026-03-29T04:00:00.500+02:00\r\n"
    )
    rows = dated.read_bytes().decode()
    assert convert("--format", "casas", "--out", out, events=rows) == (0, "")
    assert out.read_text().startswith("2026-03-29 03:00:00.500000")
    assert convert("--format", "events", "--out", again, events=rows) == (0, "")
    assert [line.split(",")[:6] for line in again.read_text().splitlines()] == [
        line.split(",")[:6] for line in rows.splitlines()
    ]
    midnight = ["--format", "events", "--out", again, "--start", "1970-01-01"]
    assert convert(*midnight) == (0, "")
    assert again.read_text().splitlines()[1].endswith(",1970-01-01T00:00:00.000")


DAY_HEAD = "time,sensor,kind,field,value,person,because\r\n"


def of_day(*times: str) -> str:
    rows = [f"{at},P,PIR,moved,{number % 2},," for number, at in enumerate(times)]
    return DAY_HEAD + "".join(f"{row}\r\n" for row in rows)


@pytest.mark.parametrize("home", [False, True], ids=["alone", "with home.toml"])
@pytest.mark.parametrize("date", ["2026-03-29", "2026-10-25"])
def test_days_keep_their_local_times_where_clocks_change(convert, tmp_path, home, date) -> None:
    told = [f"{date}T00:30:00.000", f"{date}T09:00:00.500", f"{date}T23:58:20.400"]
    options = ["--timezone", "Europe/Stockholm"]
    if home:
        (tmp_path / "home.toml").write_text(
            f'start = {date}T00:00:00\n[[sensors]]\nname = "P"\nkind = "PIR"\nroom = "hall"\n'
        )
        options += ["--home", tmp_path / "home.toml"]
    out = tmp_path / "out.csv"
    assert convert("--format", "events", "--out", out, *options, events=of_day(*told)) == (0, "")
    found = [row.split(",")[-1] for row in out.read_text().split()[1:]]
    assert [time[:-6] for time in found] == told
    # The clock differs from the seconds by the whole hours of the change.
    seconds = [float(row.split(",")[0]) for row in out.read_text().split()[1:]]
    changed = -3600.0 if date < "2026-06" else 3600.0
    assert seconds[2] - seconds[0] == pytest.approx(84_500.4 + changed)
    # Activities are included, and mark the event that they begin with.
    (tmp_path / "acts.csv").write_text(
        f"start,end,person,activity,room\r\n{told[1]},{date}T23:59:30.000,anna,Sit,hall\r\n",
        newline="",
    )
    options += ["--activities", tmp_path / "acts.csv"]
    out = tmp_path / "casas.txt"
    rows = of_day(*told, f"{date}T23:59:00.000", f"{date}T23:59:10.000")
    status, _ = convert("--format", "casas", "--out", out, *options, events=rows)
    marked = [line for line in out.read_text().splitlines() if "begin" in line]
    assert status == 0 and len(marked) == 1 and " 09:00:00.500" in marked[0]


def test_local_times_that_clocks_leave_out_stay_in_order_and_are_counted(convert, tmp_path) -> None:
    hours = ("01:59:59.000", "02:00:00.000", "02:45:00.000", "03:00:00.000", "03:10:00.000")
    rows = of_day(*(f"2026-03-29T{hour}" for hour in hours))
    out = tmp_path / "out.csv"
    zone = "--timezone", "Europe/Stockholm"
    status, err = convert("--format", "events", "--out", out, *zone, events=rows)
    assert status == 0 and "2 changes in" in one_line(err)
    found = [row.split(",")[-1][11:] for row in out.read_text().split()[1:]]
    begin, three = "01:59:59.000+01:00", "03:00:00.000+02:00"
    assert found == [begin, three, three, three, "03:10:00.000+02:00"]


def test_rooms_come_from_list_json_and_from_home_toml(convert, tmp_path) -> None:
    facts = [{"name": "PIR hall", "kind": "PIR", "room": "hall"}]
    (tmp_path / "home.json").write_text(json.dumps(facts))
    (tmp_path / "home.toml").write_text(
        'seed = 7\nstart = 2026-03-02T07:00:00\n[[sensors]]\nname = "PIR hall"\nkind = "PIR"\n'
        'room = "hall"\n'
    )
    for name in ("home.json", "home.toml"):
        out = tmp_path / "log.lp"
        status, err = convert("--format", "influx", "--out", out, "--home", tmp_path / name)
        assert status == 0
        assert "pir,sensor=PIR\\ hall,room=hall moved=false" in out.read_text()
        assert ("start is taken as" in err) == (name == "home.json")
    assert f" {1772434800 * 10**9}\n" in out.read_text()  # its start, in UTC


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["OUT/x", "--format", "word"], ["word", "casas"]),
        (["OUT/none/x", "--format", "xes"], ["OUT/none", "does not exist"]),
        (["OUT", "--format", "xes"], ["OUT", "is a folder"]),
        (["OUT/events.csv", "--format", "pyadlml"], ["events.csv", "--out"]),
        (["OUT/./events.csv", "--format", "events"], ["is also read"]),
        (["OUT/x", "--format", "xes", "--home", "OUT/no.toml"], ["no.toml"]),
        (["OUT/x", "--format", "xes", "--start", "noon"], ["noon", "ISO 8601"]),
        (["OUT/x", "--format", "xes", "--timezone", "Nowhere/Nope"], ["'Nowhere/Nope'", "known"]),
    ],
)
def test_what_cannot_be_done_is_one_clear_line(convert, tmp_path, options, words) -> None:
    status, err = convert("--out", *[text.replace("OUT", str(tmp_path)) for text in options])
    assert status == 2
    assert all(word.replace("OUT", str(tmp_path)) in one_line(err) for word in words), err
    assert sorted(p.name for p in tmp_path.iterdir()) == ["events.csv"]
    assert (tmp_path / "events.csv").read_bytes() == EVENTS.encode()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("not = [toml", ["home.toml"]),
        ("seed = 1\n", ["list of sensors"]),
        ('[[sensors]]\nname = "A"\n', ["no kind"]),
        ('[[sensors]]\nname="A"\nkind="PIR"\n' * 2, ["two sensors", "'A'"]),
    ],
)
def test_a_wrong_home_is_told(convert, tmp_path, text, words) -> None:
    (tmp_path / "home.toml").write_text(text)
    out = tmp_path / "x"
    status, err = convert("--format", "xes", "--out", out, "--home", tmp_path / "home.toml")
    assert status == 2
    assert all(word in one_line(err) for word in words), err


def test_every_format_writes_an_empty_log() -> None:
    for target in FORMATS.values():
        if target.name != "parquet":  # needs pyarrow: tests/readers
            assert target.write(make_log([])).files


def test_names_stay_apart() -> None:
    assert unique(["PIR hall", "pir-hall", "Ä", "A", "7"], slug) == {
        "7": "sensor_7",
        "A": "a",
        "PIR hall": "pir_hall",
        "pir-hall": "pir_hall_2",
        "Ä": "a_2",
    }
    assert [camel(name) for name in ("PIR hall", "light sensor 2", "日本")] == [
        "PIRHall",
        "LightSensor2",
        "Sensor",
    ]
