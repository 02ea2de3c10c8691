# SPDX-License-Identifier: GPL-3.0-or-later
"""Our files read by other programs.

CASAS and pyadlml by pyadlml, MCAP by its own library and by rosbags, XES and OCEL by pm4py, line
protocol, Parquet, the schema of layouts.
"""

from __future__ import annotations

import csv
import json
import math
import re
from datetime import UTC, datetime, timedelta
from pathlib import Path
from zoneinfo import ZoneInfo

import pytest
from angen_sensors.sensor_logic.logs.formats.log import SensorFacts, slug
from angen_sensors.sensor_logic.logs.formats.source import make_log
from angen_sensors.sensor_logic.logs.log import Event
from log_of_a_year import ABOUT, ACTIVITIES, AWKWARD, ROWS, START, YEAR, year


def at(seconds: float) -> datetime:
    return START + timedelta(seconds=seconds)


def ids(path) -> dict[tuple[str, str], str]:
    """Return (sensor, field) → its name in a CASAS file."""
    with open(path.with_name(f"{path.name}.sensors.csv"), newline="", encoding="utf-8") as file:
        return {(row["sensor"], row["field"]): row["id"] for row in csv.DictReader(file)}


@pytest.fixture
def aruba(reader, written, tmp_path):
    reader("pyadlml")
    houses = reader("pyadlml.dataset._datasets.casas_houses")
    path = written(year(), "casas", "data")
    return ids(path), houses.CasasArubaFetcher().load_data(tmp_path)


def test_aruba_loader_finds_every_change_at_its_microsecond_and_the_activities(aruba) -> None:
    names, data = aruba
    devices = data["devices"]
    hall = devices[devices["device"] == names["PIR hall", "moved"]]
    assert list(hall["time"]) == [at(2.833333), at(3.625), at(YEAR - 0.000001), at(YEAR)]
    for sensor, field, values in (
        ("PIR hall", "moved", [True, False, True, False]),
        ("Switch", "open", ["OPEN", "CLOSE"]),
        ("Lux", "illuminance_lux", [1445.25]),
    ):
        assert list(devices[devices["device"] == names[sensor, field]]["value"]) == values
    found = data["activities"].sort_values("start_time")
    assert list(found["activity"]) == ["Anna_Enter_home", "Bo_Cook_eat"]
    # CASAS marks activities on changes: on the first and the last within.
    assert list(found["start_time"]) == [at(2.833333), at(5)]
    assert list(found["end_time"]) == [at(3.8), at(8)]


def test_ids_tell_the_kinds_apart_and_the_second_file_keeps_names_and_states(written) -> None:
    path = written(year(), "casas", "log.txt")
    found = ids(path)
    assert len(set(found.values())) == len(found)
    prefixes = {key: name.rstrip("0123456789") for key, name in found.items()}
    expected = {("PIR hall", "moved"): "M", ("Switch", "open"): "D", ("Pad", "pressed"): "I"}
    expected |= {("Lux", "lit"): "L", ("Lux", "illuminance_lux"): "LS"}
    assert expected.items() <= prefixes.items()
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


EPOCH_NS = int(START.replace(tzinfo=UTC).timestamp()) * 10**9


def messages(reader, path) -> list[tuple[str, int, object]]:
    """Return (topic, nanoseconds since the start, message), with every CRC checked."""
    make_reader = reader("mcap.reader").make_reader
    factory = reader("mcap_ros2.decoder").DecoderFactory()
    with open(path, "rb") as file:
        found = make_reader(file, validate_crcs=True, decoder_factories=[factory])
        return [
            (channel.topic, message.log_time - EPOCH_NS, decoded)
            for _, channel, message, decoded in found.iter_decoded_messages()
        ]


def test_every_change_is_a_message_at_its_microsecond(reader, written) -> None:
    found = messages(reader, written(year(), "mcap"))
    moved = [(time, m.data) for topic, time, m in found if topic == "/angen/pir_hall/moved"]
    last = int(YEAR) * 10**9
    assert moved == [
        (0, False),
        (2_833_333_000, True),
        (3_625_000_000, False),
        (last - 1000, True),
        (last, False),
    ]
    of_fields = [topic for topic, _, _ in found if not topic.endswith(("/range", "/activity"))]
    assert len(of_fields) == len(ROWS)
    assert f"/angen/{slug(AWKWARD)}/moved" in of_fields
    assert "/angen/pir_hall_2/moved" in of_fields


def test_messages_have_the_units_of_ros(reader, written) -> None:
    found = messages(reader, written(year(), "mcap"))
    (lux,) = [m for topic, time, m in found if topic == "/angen/lux/illuminance_lux" and time]
    assert lux.illuminance == 1445.25
    assert (lux.header.stamp.sec * 10**9 + lux.header.stamp.nanosec) - EPOCH_NS == 8 * 10**9
    forces = [m.wrench.force.z for topic, _, m in found if topic == "/angen/pad/force_n"]
    assert forces == [-34.671246, -700.5]
    beam = [m for topic, _, m in found if topic == "/angen/switch/range"]
    assert [m.range for m in beam] == [-math.inf, math.inf, -math.inf]
    assert all(
        m.min_range == m.max_range and math.isclose(m.max_range, 0.4, rel_tol=1e-6) for m in beam
    )
    tof = [m for topic, _, m in found if topic == "/angen/tof/distance_m"]
    assert [round(m.range, 6) for m in tof] == [math.inf, 0.8125]
    assert {(round(m.field_of_view, 6), round(m.min_range, 6)) for m in tof} == {(0.5, 0.04)}
    doors = {topic for topic, _, _ in found if topic.startswith("/angen/front_door")}
    assert doors == {"/angen/front_door/open"}, "a contact has no beam"
    people = [m.data for topic, _, m in found if topic == "/angen/people/anna/activity"]
    assert people == ["Enter home", ""]


def test_rosbags_reads_the_same_and_the_metadata_tells_seed_and_versions(reader, written) -> None:
    highlevel = reader("rosbags.highlevel")
    path = written(year(), "mcap", "bag.mcap")
    with highlevel.AnyReader([path]) as bag:
        found = [
            (connection.topic, time - EPOCH_NS, bag.deserialize(data, connection.msgtype))
            for connection, time, data in bag.messages()
        ]
    moved = [(time, m.data) for topic, time, m in found if topic == "/angen/pir_hall/moved"]
    assert moved[1] == (2_833_333_000, True)
    assert len(found) == len(messages(reader, path))
    with open(path, "rb") as file:
        (about,) = reader("mcap.reader").make_reader(file).iter_metadata()
    assert (about.name, about.metadata) == ("angen", {"start": START.isoformat(), **ABOUT})
    assert messages(reader, written(make_log([], start=START), "mcap", "empty")) == []


def test_many_messages_lie_in_many_chunks_and_all_are_found(reader, written) -> None:
    facts = {"Lux": SensorFacts("Lux", "LIGHT", "hall")}
    events = [Event(i * 0.1, "Lux", "illuminance_lux", 0.0, "LIGHT", str(i)) for i in range(60_000)]
    path = written(make_log(events, facts, START), "mcap")
    found = messages(reader, path)
    assert [m.illuminance for _, _, m in found] == [float(i) for i in range(60_000)]
    with open(path, "rb") as file:
        summary = reader("mcap.reader").make_reader(file).get_summary()
    assert len(summary.chunk_indexes) > 1
    assert summary.statistics.message_count == 60_000


UTC_START = START.replace(tzinfo=UTC)


def at_utc(seconds: float):
    return UTC_START + timedelta(seconds=seconds)


def test_pm4py_reads_changes_and_activities_from_xes(reader, written) -> None:
    frame = reader("pm4py").read_xes(str(written(year(), "xes", "log.xes")))
    sensors = frame[frame["case:angen:case"] == "sensors"]
    assert len(sensors) == len(ROWS)
    hall = sensors[sensors["org:resource"] == "PIR hall"].sort_values("time:timestamp")
    words = [name.removeprefix("PIR hall moved ") for name in hall["concept:name"]]
    assert words == ["off", "on", "off", "on", "off"]
    assert list(hall["time:timestamp"])[-2:] == [at_utc(YEAR - 0.000001), at_utc(YEAR)]
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
    pandas, _ = reader("pandas"), reader("pyarrow")
    start = START.replace(tzinfo=ZoneInfo(zone)) if zone else START
    frame = pandas.read_parquet(written(year(start=start), "parquet", "log.parquet"))
    assert len(frame) == len(ROWS)
    hall = frame[frame["sensor"] == "PIR hall"]
    assert list(hall["number"]) == [0, 1, 0, 1, 0]
    assert hall["time"].iloc[-1] == pandas.Timestamp(start) + pandas.Timedelta(seconds=YEAR)
    assert set(frame[frame["sensor"] == AWKWARD]["room"]) == {"kitchen, small"}


def test_pandas_reads_every_sample_of_a_recording(reader, written) -> None:
    from angen_sensors.sensor_logic.model import Reading
    from angen_sensors.sensor_logic.recording.events import samples_of
    from angen_sensors.sensor_logic.recording.tracks import Recording, Track

    pandas, _ = reader("pandas"), reader("pyarrow")
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
    frame = pandas.read_parquet(written(year(samples=samples_of(recording)), "parquet"))
    assert len(frame) == 6
    assert list(frame[frame["sensor"] == "Lux"]["illuminance_lux"]) == [0, 1, 2]
    assert frame[frame["sensor"] == "Lux"]["luminance_percent"].isna().all()
    assert list(frame[frame["sensor"] == "Switch"]["open"]) == [False, True, False]
    assert frame[frame["sensor"] == "Switch"]["illuminance_lux"].isna().all()


DOCS = Path(__file__).resolve().parents[2] / "docs" / "layouts.md"
FILE = DOCS.parents[1] / "sensor_logic" / "layout" / "layout.schema.json"
SCHEMA = json.loads(FILE.read_text(encoding="utf-8"))


def sensor(**values):
    return [{"name": "A", "kind": "PIR", "location": [0, 0, 0], **values}]


@pytest.mark.parametrize(
    "wrong",
    [
        {"sensor": []},
        [{"kind": "PIR"}],
        sensor(kind="PIRR"),
        sensor(rooom="hall"),
        sensor(preset="FSR_402"),
        sensor(update_rate=0),
        sensor(location=[1, 2]),
        sensor(look=[1, 0, 0], rotation=[0, 0, 0]),
        sensor(parameters={"range_mx": 1}),
        sensor(parameters={"range_max": -1}),
        sensor(parameters={"rays": 1.5}),
        sensor(parameters={"sweep": "AL"}),
    ],
)
def test_what_is_wrong_is_found(reader, wrong) -> None:
    validator = reader("jsonschema").Draft7Validator
    validator.check_schema(SCHEMA)
    assert not validator(SCHEMA).is_valid(wrong)


def test_the_example_of_the_docs_is_valid(reader) -> None:
    examples = re.findall(r"```json\n(.*?)```", DOCS.read_text(encoding="utf-8"), re.DOTALL)
    assert examples
    for example in examples:
        reader("jsonschema").Draft7Validator(SCHEMA).validate(json.loads(example))
