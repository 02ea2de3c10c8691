# SPDX-License-Identifier: GPL-3.0-or-later
"""CASAS and pyadlml, read by pyadlml."""

from __future__ import annotations

import csv
from datetime import datetime, timedelta

import pytest
from log_of_a_year import ACTIVITIES, AWKWARD, ROWS, START, YEAR, year


def at(seconds: float) -> datetime:
    return START + timedelta(seconds=seconds)


def ids(path) -> dict[tuple[str, str], str]:
    """(sensor, field) → its name in a CASAS file."""
    with open(path.with_name(f"{path.name}.sensors.csv"), newline="", encoding="utf-8") as file:
        return {(row["sensor"], row["field"]): row["id"] for row in csv.DictReader(file)}


@pytest.fixture
def aruba(reader, written, tmp_path):
    reader("pyadlml")
    houses = reader("pyadlml.dataset._datasets.casas_houses")
    path = written(year(), "casas", "data")
    return ids(path), houses.CasasArubaFetcher().load_data(tmp_path)


def test_aruba_loader_finds_every_change_at_its_microsecond(aruba) -> None:
    names, data = aruba
    devices = data["devices"]
    hall = devices[devices["device"] == names["PIR hall", "moved"]]
    assert list(hall["time"]) == [at(2.833333), at(3.625), at(YEAR - 0.000001), at(YEAR)]
    assert list(hall["value"]) == [True, False, True, False]
    switch = devices[devices["device"] == names["Switch", "open"]]
    assert list(switch["value"]) == ["OPEN", "CLOSE"]
    lux = devices[devices["device"] == names["Lux", "illuminance_lux"]]
    assert list(lux["value"]) == [1445.25]


def test_aruba_loader_finds_the_activities(aruba) -> None:
    _, data = aruba
    found = data["activities"].sort_values("start_time")
    assert list(found["activity"]) == ["Anna_Enter_home", "Bo_Cook_eat"]
    # CASAS marks activities on changes: on the first and the last within.
    assert list(found["start_time"]) == [at(2.833333), at(5)]
    assert list(found["end_time"]) == [at(3.8), at(8)]


def test_ids_tell_the_kinds_apart_and_the_second_file_keeps_names_and_states(written) -> None:
    path = written(year(), "casas", "log.txt")
    found = ids(path)
    prefixes = {key: name.rstrip("0123456789") for key, name in found.items()}
    assert prefixes["PIR hall", "moved"] == "M"
    assert prefixes["Switch", "open"] == "D"
    assert prefixes["Pad", "pressed"] == "I"
    assert prefixes["Lux", "lit"] == "L"
    assert prefixes["Lux", "illuminance_lux"] == "LS"
    assert len(set(found.values())) == len(found)
    with open(path.with_name("log.txt.sensors.csv"), newline="", encoding="utf-8") as file:
        rows = {(row["sensor"], row["field"]): row for row in csv.DictReader(file)}
    assert rows[AWKWARD, "moved"]["room"] == "kitchen, small"
    assert rows["pir-hall", "moved"]["initial"] == "ON"
    assert rows["Lux", "illuminance_lux"]["unit"] == "lx"


def test_pandas_reads_the_form_of_2025_by_the_columns_of_its_release(reader, written) -> None:
    pandas = reader("pandas")
    path = written(year(), "casas-csv", "log.csv")
    columns = ["date", "time", "sensor", "message", "activity"]
    frame = pandas.read_csv(path, names=columns, header=None)
    when = pandas.to_datetime(frame["date"] + " " + frame["time"])
    hall = frame["sensor"] == "PIRHall"
    assert list(when[hall]) == [at(2.833333), at(3.625), at(YEAR - 0.000001), at(YEAR)]
    assert list(frame["message"][hall]) == ["ON", "OFF", "ON", "OFF"]
    assert list(frame["message"][frame["sensor"] == "Switch"]) == ["OPEN", "CLOSE"]
    told = dict(zip(when, frame["activity"].fillna(""), strict=True))
    assert told[at(2.833333)] == 'Anna_Enter_home="begin"'
    assert told[at(3.000001)] == "Anna_Enter_home"
    assert told[at(4.0)] == 'Anna_Enter_home="end"'
    assert told[at(YEAR)] == ""


def test_act_assist_loader_finds_devices_rooms_and_people(reader, written) -> None:
    dataset = reader("pyadlml.dataset")
    path = written(year(), "pyadlml", "home")
    data = dataset.load_act_assist(str(path), subjects=["Anna", "Bo"])
    devices = data["devices"]
    hall = devices[devices["device"] == "PIR hall"]
    assert list(hall["time"]) == [at(s) for s in (0, 2.833333, 3.625, YEAR - 0.000001, YEAR)]
    assert list(hall["value"]) == [False, True, False, True, False]
    awkward = devices[devices["device"] == AWKWARD]
    assert list(awkward["value"]) == [False, True]
    rooms = dict(zip(data["dev2area"]["device"], data["dev2area"]["area"], strict=True))
    assert rooms["PIR hall"] == "hall"
    assert rooms[AWKWARD] == "kitchen, small"
    for person, activity in zip(("Anna", "Bo"), ACTIVITIES, strict=True):
        (row,) = data["activities"][person].itertuples()
        assert row.activity == activity.activity
        assert row.start_time == at(activity.start / 1e6)
        assert row.end_time == at(activity.end / 1e6)
    told = sum(1 for row in ROWS if row[2] != "partners")
    assert len(devices) == told


def test_a_home_in_which_nobody_does_anything_loads(reader, written) -> None:
    dataset = reader("pyadlml.dataset")
    data = dataset.load_act_assist(str(written(year(activities=()), "pyadlml")), subjects=["R1"])
    assert len(data["activities"]["R1"]) == 0
