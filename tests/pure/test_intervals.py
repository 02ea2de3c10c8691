# SPDX-License-Identifier: GPL-3.0-or-later
"""Logs of intervals and of activities, as `convert` and `compare` read them."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable
from pathlib import Path

import pytest
from angen_sensors.sensor_logic.logs.error import InputError
from angen_sensors.sensor_logic.logs.formats.reading import read_log
from invented_log import casas, invented, ordonez, table

ORDONEZ = """\
Start time          \tEnd time            \tLocation\tType\t\tPlace
--------------------\t--------------------\t--------\t--------\t-----
2026-01-05 07:00:21\t\t2026-01-05 07:21:49\t\tSeat\t\tPressure\tLiving
2026-01-05 07:22:57\t\t2026-01-05 07:22:59\t\tDoor\t\tPIR\t\tLiving
2026-01-05 07:23:14\t\t2026-01-05 07:23:17\t\tDoor\t\tPIR\t\tKitchen
2026-01-05 07:23:30\t\t2026-01-05 07:24:00\t\tFridge\t\tMagnetic\tKitchen
2026-01-05 07:23:50\t\t2026-01-05 07:24:10\t\tFridge\t\tMagnetic\tKitchen
2026-01-05 07:30:00\t\t2026-01-05 07:29:00\t\tToilet\t\tFlush\t\tBathroom
2026-01-05 07:31:00\t\t2026-01-05 07:31:05\t\tToilet\t\tFlush\t\tBathroom
"""
KASTEREN = """\
25-Feb-2026 00:20:14\t25-Feb-2026 00:22:57\t24\t1
25-Feb-2026 09:33:41\t25-Feb-2026 09:33:42\tbedroom door\t1
"""
SECONDS = "1203898814\t163\t24\n1203932021\t1\t6\n"
TABLE = "start,end,sensor,type,room\n2026-01-05 07:00,2026-01-05 07:05,Mat,Pressure,hall\n"


def rows(tmp_path: Path, text: str) -> list[tuple[str, str, str, float, str]]:
    path = tmp_path / "log.txt"
    path.write_text(text)
    log = read_log(path)
    return [
        (log.start.isoformat() if log.start else "", e.sensor, e.field, e.time, str(e.value))
        for e in log.events
    ]


def test_ordonez_is_read_with_types_places_and_overlaps(tmp_path: Path) -> None:
    found = rows(tmp_path, ORDONEZ)
    assert {row[0] for row in found} == {"2026-01-05T07:00:21"}
    assert [row[1:] for row in found] == [
        ("Seat", "pressed", 0.0, "True"),
        ("Seat", "pressed", 1288.0, "False"),
        ("Door Living", "moved", 1356.0, "True"),
        ("Door Living", "moved", 1358.0, "False"),
        ("Door Kitchen", "moved", 1373.0, "True"),
        ("Door Kitchen", "moved", 1376.0, "False"),
        ("Fridge", "open", 1389.0, "True"),
        ("Fridge", "open", 1429.0, "False"),
        ("Toilet", "flowing", 1839.0, "True"),
        ("Toilet", "flowing", 1844.0, "False"),
    ]
    log = read_log(tmp_path / "log.txt")
    assert log.sensors["Door Kitchen"].room == "Kitchen"
    assert not log.has_states
    assert [note.partition(": ")[2] for note in log.notes] == [
        "1 row left out, first line 8: it ends before it begins"
    ]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (KASTEREN, [("24", "moved", 0.0), ("24", "moved", 163.0),
                    ("bedroom door", "open", 33207.0), ("bedroom door", "open", 33208.0)]),
        (SECONDS, [("24", "moved", 0.0), ("24", "moved", 163.0),
                   ("6", "moved", 33207.0), ("6", "moved", 33208.0)]),
        (TABLE, [("Mat", "pressed", 0.0), ("Mat", "pressed", 300.0)]),
    ],
)  # fmt: skip
def test_other_forms_of_intervals(
    text: str, told: list[tuple[str, str, float]], tmp_path: Path
) -> None:
    assert [row[1:4] for row in rows(tmp_path, text)] == told


def test_what_is_no_interval_is_told_with_its_line(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="intervals: line 3 is not start, end and sensor"):
        rows(tmp_path, KASTEREN + "later 5\n")


def test_a_log_of_intervals_becomes_casas_with_its_activities(angen, tmp_path: Path) -> None:
    sensors, done, out = (tmp_path / name for name in ("sensors.txt", "done.txt", "out.txt"))
    sensors.write_text(ORDONEZ)
    done.write_text("2026-01-05 07:00:00\t2026-01-05 07:22:58\tSpare_Time/TV\n")
    words = ["--format", "casas", "--activities", done, "--out", out]
    status, _, _ = angen("convert", sensors, *words)
    assert status == 0
    lines = out.read_text().splitlines()
    assert lines[0].endswith("I001 ON Spare_Time_TV begin")
    assert sum("Spare_Time_TV end" in line for line in lines) == 1


def test_activities_alone_are_no_log_of_sensors(angen, tmp_path: Path) -> None:
    path = tmp_path / "done.txt"
    path.write_text(ordonez(invented(3)))
    status, _, told = angen("convert", path, "--format", "xes", "--out", tmp_path / "x.xes")
    assert status == 2 and told.count("\n") == 1
    assert "has activities and no sensors: give the log of the sensors" in told


def test_activities_are_compared(
    angen: Callable[..., tuple[int, str, str]], tmp_path: Path
) -> None:
    one, two, labels = (tmp_path / name for name in ("one.csv", "two.txt", "map.toml"))
    one.write_text(table(invented(14)))
    two.write_text(casas(invented(14)))
    labels.write_text('[labels]\n"Watch TV" = "Watch_TV"\n')
    status, text, told = angen("compare", one, two, "--labels", labels, "--json")
    assert (status, told) == (0, "")
    found = json.loads(text)
    names = {(m["group"], m["measure"]): m for m in found["measures"]}
    assert {group for group, _ in names} == {
        "Breakfast", "Sleep", "Use_Toilet", "Wash", "Watch_TV"
    }  # fmt: skip
    assert {m["ks_distance"] for m in found["measures"]} == {0.0}
    breakfast = names["Breakfast", "times a day"]["logs"][0]
    assert breakfast["n"] == 14 and breakfast["quantiles"]["0.5"] == 1.0
    assert names["Breakfast", "begins at"]["logs"][0]["quantiles"]["0.5"] == pytest.approx(
        7.2, abs=0.5
    )
    # An evening that goes on over midnight is late, not early.
    assert names["Sleep", "begins at"]["logs"][0]["quantiles"]["0.5"] > 22
    status, text, _ = angen("compare", one, two)
    assert "Watch TV: begins at (h): one log has no values" in text


def test_days_are_compared_with_activities(angen, tmp_path: Path) -> None:
    one, days = tmp_path / "one.csv", tmp_path / "days"
    one.write_text(table(invented(14)))
    days.mkdir()
    with open(days / "activities.csv", "w", encoding="utf-8", newline="") as file:
        rows = [(a.isoformat(), b.isoformat(), "anna", name, "") for a, b, name in invented(14)]
        csv.writer(file).writerows([("start", "end", "person", "activity", "room"), *rows])
    status, text, _ = angen("compare", one, days)
    assert status == 0 and "Sleep: lasts (s): distance 0.000" in text


def test_a_map_without_a_table_is_told(angen, tmp_path: Path) -> None:
    path, labels = tmp_path / "one.csv", tmp_path / "map.toml"
    path.write_text(table(invented(3)))
    for text, why in (("", "give a table"), ("[words]\na = 'b'\n", "the key 'words' is unknown")):
        labels.write_text(text)
        status, _, told = angen("compare", path, path, "--labels", labels)
        assert status == 2 and why in told and told.count("\n") == 1
