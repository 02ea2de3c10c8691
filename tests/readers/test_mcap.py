# SPDX-License-Identifier: GPL-3.0-or-later
"""MCAP, read by its own library and by rosbags."""

from __future__ import annotations

import math
from datetime import UTC

from angen_sensors.sensor_logic.formats.log import SensorFacts, slug
from angen_sensors.sensor_logic.formats.source import make_log
from angen_sensors.sensor_logic.log import Event
from log_of_a_year import ABOUT, AWKWARD, ROWS, START, YEAR, year

EPOCH_NS = int(START.replace(tzinfo=UTC).timestamp()) * 10**9


def messages(reader, path) -> list[tuple[str, int, object]]:
    """(topic, nanoseconds since the start, message), every CRC checked."""
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


def test_the_metadata_tells_seed_and_versions(reader, written) -> None:
    with open(written(year(), "mcap"), "rb") as file:
        (found,) = reader("mcap.reader").make_reader(file).iter_metadata()
    assert found.name == "angen"
    assert found.metadata == {"start": START.isoformat(), **ABOUT}


def test_rosbags_reads_the_same(reader, written) -> None:
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


def test_an_empty_log_is_a_valid_file(reader, written) -> None:
    assert messages(reader, written(make_log([], start=START), "mcap")) == []
