# SPDX-License-Identifier: GPL-3.0-or-later
"""Sending to a broker without a broker: pace, classes and options. The rest is in tests/mqtt."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest
from angen_sensors.angen_addon.output.mqtt.player import SLICE_S, Pace
from angen_sensors.sensor_logic.kinds import KINDS
from angen_sensors.sensor_logic.logs.formats.home_assistant import HomeMessages, payload
from angen_sensors.sensor_logic.logs.formats.log import Channel, SensorFacts
from angen_sensors.sensor_logic.logs.formats.source import make_log
from angen_sensors.sensor_logic.logs.log import Event
from angen_sensors.sensor_logic.model import Reading
from angen_sensors.sensor_logic.recording.events import NewEvents, events
from angen_sensors.sensor_logic.recording.tracks import Recording, Track

ROOT = Path(__file__).resolve().parents[2]
EVENTS = "time_s,frame,sensor,kind,field,value\n0,1,P,PIR,moved,0\n2.5,1,P,PIR,moved,1\n"


class Clock:
    """A clock that a test moves; a sleep lasts 30 ms longer than requested."""

    def __init__(self) -> None:
        self.now = 1e6
        self.idle = 0

    def __call__(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        assert 0.0 < seconds <= SLICE_S
        self.now += seconds + 0.03

    def note_idle(self) -> None:
        self.idle += 1


@pytest.mark.parametrize("speed", [0.5, 1.0, 60.0])
def test_no_wait_moves_the_moments_after_it(speed) -> None:
    clock = Clock()
    pace = Pace(speed, clock.note_idle, clock, clock.sleep)
    begin = clock()
    pace.start(5_000_000)
    for number in range(1000):
        until = 5_000_000 + number * 7_000_000
        late = pace.wait(until)
        due = begin + number * 7.0 / speed
        assert clock() - due == pytest.approx(late, abs=1e-6)
        assert -1e-9 <= late <= 0.03 + 1e-6
        clock.now += 0.05  # work between two moments
    assert clock.idle > 1000


def test_who_is_behind_does_not_wait_and_says_how_late_it_is() -> None:
    clock = Clock()
    pace = Pace(2.0, clock.note_idle, clock, clock.sleep)
    pace.start(0)
    clock.now += 10.0
    assert pace.wait(8_000_000) == pytest.approx(6.0)
    at_once = Pace(0.0, clock.note_idle, clock, clock.sleep)
    at_once.start(0)
    before = clock()
    assert at_once.wait(10**15) == 0.0
    assert clock() == before


# The platform, class and unit of each field for Home Assistant.
CLASSES = {
    ("PIR", "moved"): ("binary_sensor", "motion", None),
    ("OPTICAL_SWITCH", "open"): ("binary_sensor", "door", None),
    ("PRESSURE", "pressed"): ("binary_sensor", "occupancy", None),
    ("PRESSURE", "force_n"): ("sensor", None, "N"),
    ("PRESSURE", "partners"): ("sensor", None, None),
    ("PRESSURE", "valid"): ("binary_sensor", None, None),
    ("LIGHT", "luminance_percent"): ("sensor", None, "%"),
    ("LIGHT", "illuminance_lux"): ("sensor", "illuminance", "lx"),
    ("LIGHT", "lit"): ("binary_sensor", "light", None),
    ("DISTANCE", "near"): ("binary_sensor", "occupancy", None),
    ("DISTANCE", "distance_m"): ("sensor", "distance", "m"),
    ("CONTACT", "open"): ("binary_sensor", "door", None),
    ("THERMAL_ARRAY", "occupied"): ("binary_sensor", "occupancy", None),
    ("THERMAL_ARRAY", "warm_pixels"): ("sensor", None, None),
    ("THERMAL_ARRAY", "max_c"): ("sensor", "temperature", "°C"),
    ("APPLIANCE", "on"): ("binary_sensor", "running", None),
    ("APPLIANCE", "power_w"): ("sensor", "power", "W"),
    ("FLOW", "flowing"): ("binary_sensor", "running", None),
}


def test_every_field_has_its_class_and_unit() -> None:
    rows = [Event(0.0, kind, field, 1.0, kind, "0") for kind, field in CLASSES]
    home = HomeMessages(make_log(sorted(rows)).channels, "flat")
    found = {}
    for topic, text in home.discovery():
        config = json.loads(text)
        assert topic == f"homeassistant/device/{config['dev']['ids'][0]}/config"
        kind = config["dev"]["name"]
        for field, entity in config["cmps"].items():
            facts = (entity["p"], entity.get("device_class"), entity.get("unit_of_measurement"))
            found[kind, field] = facts
            assert entity["state_topic"] == f"flat/{kind.lower()}/{field}"
            is_number = KINDS[kind].fields[field].type in (int, float)
            assert entity.get("state_class") == ("measurement" if is_number else None)
    assert found == CLASSES


@pytest.mark.parametrize(
    ("type_", "value", "text"),
    [
        (bool, True, "ON"),
        (bool, False, "OFF"),
        (float, 697.123456789, "697.123457"),
        (float, float("nan"), "None"),
        (float, float("inf"), "None"),
        # An empty payload would remove the retained state.
        (str, "", "–"),
        (str, "Anna;Bo", "Anna;Bo"),
        (str, "x" * 300, "x" * 254 + "…"),
    ],
)
def test_payloads_are_what_an_entity_takes(type_, value, text) -> None:
    assert payload(Channel(SensorFacts("S", "K"), "f", type_, "", ""), value) == text


def test_events_taken_as_they_come_are_those_of_the_log() -> None:
    pad, pir = Track("Pad", "PRESSURE"), Track("PIR", "PIR")
    pad.steps = {"force_n": 5.0}
    recording = Recording({"Pad": pad, "PIR": pir})
    names = [field.name for field in KINDS["PRESSURE"].samples]
    stream, taken = NewEvents(recording), []
    for step in range(40):
        fields = dict.fromkeys(names, 0.0) | {"force_n": 1.3 * step, "partners": "A" * (step // 9)}
        fields |= {"pressed": step % 7 > 3, "valid": step != 11, "adc": 0, "problem": ""}
        pad.append(step, step / 24, Reading(False, 0.0, fields))
        pir.append(step, step / 24, Reading(False, 0.0, {"moved": step % 3 > 1, "angle_rad": 0.0,
                   "signal": None}))  # fmt: skip
        if step % 5 == 2:
            taken += stream.take()
    taken += stream.take()
    assert stream.take() == []
    assert taken == events(recording)
    assert len(taken) > 40


@pytest.fixture
def replay(tmp_path, angen, monkeypatch):
    """Run `angen replay` on a log of 2.5 s, without paho-mqtt; return (status, its one line)."""
    for name in ("paho", "paho.mqtt", "paho.mqtt.client"):
        monkeypatch.setitem(sys.modules, name, None)
    path = tmp_path / "events.csv"
    path.write_text(EVENTS)

    def run(*options: object) -> tuple[int, str]:
        arguments = [str(path) if option == "EVENTS" else str(option) for option in options]
        status, out, err = angen("replay", *arguments)
        assert out == ""
        assert err.count("\n") == 1, err
        return status, err

    return run


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["EVENTS"], ["--mqtt"]),
        (["--mqtt", "localhost"], ["EVENTS.csv", "--forget"]),
        (["EVENTS", "--mqtt", "localhost", "--forget"], ["leave out EVENTS.csv"]),
        (["none.csv", "--mqtt", "localhost"], ["none.csv"]),
        (["EVENTS", "--mqtt", "anna:secret@localhost"], ["ANGEN_MQTT_PASSWORD"]),
        (["EVENTS", "--mqtt", "localhost:0"], ["HOST:PORT"]),
        (["EVENTS", "--mqtt", "localhost:99999"], ["HOST:PORT"]),
        (["EVENTS", "--mqtt", "mqtt://localhost"], ["HOST:PORT"]),
        (["EVENTS", "--mqtt", "localhost", "--speed", "-1"], ["-1", "max"]),
        (["EVENTS", "--mqtt", "localhost", "--topic", "a/#"], ["a/#", "topic"]),
        (["EVENTS", "--mqtt", "localhost", "--from", "3"], ["--from 3 s", "ends at 2.5 s"]),
        (["EVENTS", "--mqtt", "localhost", "--from", "noon"], ["noon", "no dates"]),
        (["EVENTS", "--mqtt", "localhost", "--loop", "--speed", "max"], ["--loop", "--speed"]),
        (["EVENTS", "--mqtt", "localhost", "--loop", "--from", "2.5"], ["--loop", "--from"]),
    ],
)
def test_what_cannot_be_done_is_one_clear_line(replay, options, words) -> None:
    status, err = replay(*options)
    assert status == 2, err
    assert all(word in err for word in words), err
    assert "secret" not in err


def test_moments_are_seconds_or_dates(replay, tmp_path) -> None:
    options = ["EVENTS", "--mqtt", "localhost"]
    status, err = replay(*options)
    assert status == 1 and 'pip install ".[mqtt]"' in err
    (tmp_path / "events.csv").write_text(
        "time_s,frame,sensor,kind,field,value,time\n"
        "0,1,P,PIR,moved,0,2026-03-02T07:00:00.000\n9,1,P,PIR,moved,1,2026-03-02T07:00:09.000\n"
    )
    for time, told in (
        ("2026-03-02T07:00:05", "paho"),
        ("2026-03-02T07:00:10", "--from 10 s"),
        ("2026-03-02T07:00:05+01:00", "time zone"),
    ):
        assert told in replay(*options, "--from", time)[1]
