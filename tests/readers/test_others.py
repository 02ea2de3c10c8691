# SPDX-License-Identifier: GPL-3.0-or-later
"""XES and OCEL read by pm4py, line protocol by line-protocol-parser, Parquet by pandas."""

from __future__ import annotations

from datetime import UTC, timedelta
from zoneinfo import ZoneInfo

import pytest
from angen_sensors.sensor_logic.formats.reading import read_log
from log_of_a_year import ACTIVITIES, AWKWARD, ROWS, START, YEAR, year

UTC_START = START.replace(tzinfo=UTC)


def at(seconds: float):
    return UTC_START + timedelta(seconds=seconds)


def test_pm4py_reads_changes_and_activities_from_xes(reader, written) -> None:
    frame = reader("pm4py").read_xes(str(written(year(), "xes", "log.xes")))
    sensors = frame[frame["case:angen:case"] == "sensors"]
    assert len(sensors) == len(ROWS)
    hall = sensors[sensors["org:resource"] == "PIR hall"].sort_values("time:timestamp")
    words = [name.removeprefix("PIR hall moved ") for name in hall["concept:name"]]
    assert words == ["off", "on", "off", "on", "off"]
    assert list(hall["time:timestamp"])[-2:] == [at(YEAR - 0.000001), at(YEAR)]
    assert AWKWARD in set(sensors["org:resource"])
    people = frame[frame["case:angen:case"] == "person"].sort_values("time:timestamp")
    assert list(people["concept:name"]) == ["Enter home"] * 2 + ["Cook, eat"] * 2
    assert list(people["lifecycle:transition"]) == ["start", "complete"] * 2


def test_pm4py_reads_objects_and_events_from_ocel(reader, written) -> None:
    ocel = reader("pm4py").read_ocel2_json(str(written(year(), "ocel", "log.json")))
    assert len(ocel.events) == len(ROWS) + 2 * len(ACTIVITIES)
    objects = dict(zip(ocel.objects["ocel:oid"], ocel.objects["ocel:type"], strict=True))
    assert objects["sensor:PIR hall"] == "sensor"
    assert objects["room:kitchen, small"] == "room"
    assert objects["person:Bo"] == "person"
    related = ocel.relations[ocel.relations["ocel:oid"] == f"sensor:{AWKWARD}"]
    assert list(related["ocel:activity"]) == ["moved", "moved"]


def test_line_protocol_parser_reads_every_line(reader, written) -> None:
    parse = reader("line_protocol_parser").parse_line
    lines = written(year(), "influx").read_text().splitlines()
    found = [parse(line) for line in lines]
    hall = [f for f in found if f["tags"].get("sensor") == "PIR hall"]
    begin = int(UTC_START.timestamp()) * 10**9
    assert [(f["time"] - begin, f["fields"]["moved"]) for f in hall] == [
        (0, False),
        (2_833_333_000, True),
        (3_625_000_000, False),
        (int(YEAR) * 10**9 - 1000, True),
        (int(YEAR) * 10**9, False),
    ]
    assert all(f["tags"]["room"] == "hall" for f in hall)
    pad = [f["fields"] for f in found if f["measurement"] == "pressure"]
    assert pad[0] == {"force_n": 34.671246, "partners": "", "pressed": True, "valid": True}
    assert pad[1]["partners"] == 'Anna;Box "1"'
    # The format cannot hold a backslash at the end of a name.
    assert {f["tags"].get("sensor") for f in found} >= {AWKWARD.rstrip("\\")}


@pytest.mark.parametrize("zone", [None, "Europe/Stockholm"])
def test_pandas_reads_a_typed_table(reader, written, zone) -> None:
    pandas = reader("pandas")
    start = START.replace(tzinfo=ZoneInfo(zone)) if zone else START
    frame = pandas.read_parquet(written(year(start=start), "parquet", "log.parquet"))
    assert len(frame) == len(ROWS)
    hall = frame[frame["sensor"] == "PIR hall"]
    assert list(hall["number"]) == [0, 1, 0, 1, 0]
    assert hall["time"].iloc[-1] == pandas.Timestamp(start) + pandas.Timedelta(seconds=YEAR)
    assert set(frame[frame["sensor"] == AWKWARD]["room"]) == {"kitchen, small"}


def test_pandas_reads_every_sample_of_a_recording(reader, written) -> None:
    from angen_sensors.sensor_logic.model import Reading
    from angen_sensors.sensor_logic.recording.tracks import Recording, Track

    pandas = reader("pandas")
    switch, lux = Track("Switch", "OPTICAL_SWITCH"), Track("Lux", "LIGHT")
    for i in range(3):
        switch.append(
            i, i / 24, Reading(bool(i % 2), 0.1 * i, {"open": bool(i % 2), "range_m": 0.1 * i})
        )
        fields = dict.fromkeys(("luminance_percent", "resistance_ohm", "voltage_v"))
        lux.append(
            i, i / 24, Reading(False, i, fields | {"illuminance_lux": float(i), "lit": False})
        )
    recording = Recording({"Switch": switch, "Lux": lux})
    frame = pandas.read_parquet(written(year(samples=recording), "parquet"))
    assert len(frame) == 6
    assert list(frame[frame["sensor"] == "Lux"]["illuminance_lux"]) == [0, 1, 2]
    assert frame[frame["sensor"] == "Lux"]["luminance_percent"].isna().all()
    assert list(frame[frame["sensor"] == "Switch"]["open"]) == [False, True, False]
    assert frame[frame["sensor"] == "Switch"]["illuminance_lux"].isna().all()
    # And by `angen compare` and `convert`.
    changes = read_log(written(year(samples=recording), "parquet", "again")).events
    opened = [(e.time, e.value) for e in changes if e.field == "open"]
    assert opened == [(0.0, False), (round(1 / 24, 6), True), (round(2 / 24, 6), False)]
