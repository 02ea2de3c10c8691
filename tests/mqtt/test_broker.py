# SPDX-License-Identifier: GPL-3.0-or-later
"""`angen replay` and `angen simulate --mqtt` against a real mosquitto and mosquitto_sub."""

from __future__ import annotations

import csv
import json
import signal
import socket
import threading
from importlib.util import find_spec

import pytest

HEADER = "time_s,frame,sensor,kind,field,value"
ROWS = '''\
0.000000,1,Lux,LIGHT,illuminance_lux,0.1
0.000000,1,PIR hall,PIR,moved,0
0.000000,1,Pad,PRESSURE,partners,
0.000000,1,Pad,PRESSURE,pressed,1
0.000000,1,Switch,OPTICAL_SWITCH,open,0
0.000000,1,"Küche, ""links""; = 2",PIR,moved,0
0.000000,1,pir-hall,PIR,moved,1
0.100000,3,PIR hall,PIR,moved,1
0.200000,5,Switch,OPTICAL_SWITCH,open,1
0.200000,5,pir-hall,PIR,moved,0
0.300000,7,Pad,PRESSURE,force_n,700.5
0.300000,7,Pad,PRESSURE,partners,"Anna;Box ""1"""
0.400000,9,Pad,PRESSURE,partners,
0.400000,9,PIR hall,PIR,moved,0
0.500000,11,Lux,LIGHT,illuminance_lux,1445.25
'''
TOPICS = {
    "PIR hall": "pir_hall",
    "pir-hall": "pir_hall_2",
    'Küche, "links"; = 2': "kuche_links_2",
    "Switch": "switch",
    "Pad": "pad",
    "Lux": "lux",
}
WORDS = {(f, str(n)): w for f in ("moved", "open", "pressed") for n, w in enumerate(("OFF", "ON"))}
WORDS["partners", ""] = "–"
# A time limit that no test reaches.
FAR = (
    f"{HEADER}\n0,1,PIR hall,PIR,moved,0\n0.1,1,PIR hall,PIR,moved,1\n9999,1,PIR hall,PIR,moved,0\n"
)


def messages_of(text: str, begin: str = "angen") -> list[tuple[str, str]]:
    """Return the messages of an event log, in its order."""
    found = []
    for row in csv.DictReader(text.splitlines()):
        value = WORDS.get((row["field"], row["value"]), row["value"])
        found.append((f"{begin}/{TOPICS[row['sensor']]}/{row['field']}", value))
    return found


@pytest.fixture
def events(tmp_path):
    path = tmp_path / "events.csv"
    path.write_text(f"{HEADER}\n{ROWS}", encoding="utf-8")
    return path


@pytest.fixture
def endless(tmp_path):
    path = tmp_path / "endless.csv"
    path.write_text(FAR)
    return path


def the_line(err: str) -> str:
    assert err.count("\n") == 1, err
    assert err.startswith("angen: ")
    return err


def test_every_event_arrives_once_in_its_order(broker, angen, events) -> None:
    with broker.listen() as listener:
        status, out, err = angen("replay", events, "--mqtt", broker.address, "--speed", 2)
        received = listener.all()
    assert (status, out) == (0, "")
    assert "sent 8 readings of 6 sensors" in the_line(err)
    status = [(i, text) for i, (topic, text) in enumerate(received) if topic == "angen/status"]
    (begin, _), (online, _), (end, _) = status
    assert [text for _, text in status] == ["offline", "online", "offline"]
    assert (begin, end) == (0, len(received) - 1)
    states = messages_of(f"{HEADER}\n{ROWS}")
    first, changes = states[:7], states[7:]
    # A field is not known before its first event.
    assert sorted(received[7:online]) == sorted([*first, ("angen/pad/force_n", "None")])
    assert received[online + 1 : end] == changes
    configs = {topic: json.loads(payload) for topic, payload in received[1:7]}
    assert set(configs) == {f"homeassistant/device/angen_{t}/config" for t in TOPICS.values()}
    pad = configs["homeassistant/device/angen_pad/config"]
    assert pad["dev"]["name"] == "Pad"
    assert pad["cmps"]["force_n"]["unit_of_measurement"] == "N"
    assert pad["cmps"]["force_n"]["state_topic"] == "angen/pad/force_n"


def test_who_comes_later_finds_all_and_forget_removes_it(broker, angen, events) -> None:
    assert angen("replay", events, "--mqtt", broker.address, "--speed", "max")[0] == 0
    retained = broker.retained()
    assert retained["angen/status"] == "offline"
    last = dict(messages_of(f"{HEADER}\n{ROWS}"))
    assert {t: p for t, p in retained.items() if t in last} == last
    assert sum(topic.startswith("homeassistant/device/") for topic in retained) == 6
    broker.publish("homeassistant/device/lamp/config", '{"o": {"name": "other"}}', "-r")
    status, _, err = angen("replay", "--forget", "--mqtt", broker.address)
    assert status == 0
    assert "removed 6 sensors below 'angen'" in the_line(err)
    assert list(broker.retained()) == ["homeassistant/device/lamp/config"]


def test_a_part_is_replayed_from_the_states_at_its_begin(broker, angen, events) -> None:
    with broker.listen() as listener:
        options = ["--from", "0.15", "--until", "0.35", "--speed", "max"]
        assert angen("replay", events, "--mqtt", broker.address, *options)[0] == 0
        received = listener.all()
    online = received.index(("angen/status", "online"))
    assert ("angen/pir_hall/moved", "ON") in received[:online]
    part = "".join(line for line in ROWS.splitlines(True) if line.startswith(("0.2", "0.3")))
    assert received[online + 1 : -1] == messages_of(f"{HEADER}\n{part}")


def test_a_killed_replay_leaves_its_sensors_unavailable(broker, start, endless) -> None:
    with broker.listen() as listener:
        replay = start("replay", endless, "--mqtt", broker.address)
        listener.until("angen/pir_hall/moved", "ON")
        states = [text for topic, text in listener.received() if topic == "angen/status"]
        assert states == ["offline", "online"]
        replay.kill()
        listener.until_last("angen/status", "offline")
    assert broker.retained()["angen/status"] == "offline"


@pytest.mark.parametrize(
    ("number", "options", "status"),
    [(signal.SIGINT, ["--loop"], 0), (signal.SIGINT, [], 1), (signal.SIGTERM, [], 1)],
)
def test_ctrl_c_ends_it_cleanly(broker, start, endless, number, options, status) -> None:
    replay = start("replay", endless, "--mqtt", broker.address, *options)
    with broker.listen() as listener:
        listener.until("angen/pir_hall/moved", "ON")
        replay.send_signal(number)
        _, err = replay.communicate()
        assert listener.all()[-1] == ("angen/status", "offline")
    assert replay.returncode == status
    assert "interrupted: the broker now shows the sensors as unavailable" in the_line(err)


def test_a_loop_begins_again_with_the_states_of_its_begin(broker, start, events) -> None:
    with broker.listen() as listener:
        replay = start("replay", events, "--mqtt", broker.address, "--loop", "--speed", 5)
        listener.until("angen/status", "online")
        number = len(listener.received())
        states = messages_of(f"{HEADER}\n{ROWS}")
        round_ = [*states[7:], *states[:7]]
        while len(listener.received()) < number + 2 * len(round_):
            assert replay.poll() is None
        received = listener.received()
    online = received.index(("angen/status", "online"))
    later = received[online + 1 : online + 1 + 2 * len(round_)]
    for part in (later[: len(round_)], later[len(round_) :]):
        assert part[:8] == round_[:8]
        assert sorted(part[8:]) == sorted(round_[8:])


def test_a_connection_lost_amid_comes_back_and_tells_what_was_missed(
    broker, start, tmp_path
) -> None:
    path = tmp_path / "long.csv"
    rows = [f"{second},1,PIR hall,PIR,moved,{second % 2}" for second in range(2000)]
    path.write_text("\n".join([HEADER, *rows, "2000,1,Switch,OPTICAL_SWITCH,open,1"]) + "\n")
    replay = start("replay", path, "--mqtt", broker.address, "--speed", 200)
    with broker.listen() as listener:
        listener.until("angen/pir_hall/moved", "ON")
    broker.stop()
    lost = replay.stderr.readline()
    assert "the connection to the broker is lost" in lost
    broker.start()
    with broker.listen() as listener:
        listener.until("angen/status", "online")
        listener.until("angen/switch/open", "ON")
        listener.until("angen/status", "offline")
        assert listener.all()[0][0].startswith("homeassistant/device/")
    _, err = replay.communicate()
    back, summary = err.splitlines()
    missed = int(back.split(" readings were missed")[0].rpartition(" ")[2])
    assert missed > 0
    assert f"sent {2000 - missed} readings" in summary
    assert f"{missed} were missed" in summary
    assert replay.returncode == 1


def test_two_replays_do_not_mix(broker, start, angen, endless, events) -> None:
    start("replay", endless, "--mqtt", broker.address)
    with broker.listen() as listener:
        listener.until("angen/pir_hall/moved", "ON")
    status, _, err = angen("replay", events, "--mqtt", broker.address)
    assert status == 1
    assert "another replay is running" in the_line(err)
    assert "--topic" in err
    options = ["--topic", "flat-2/west", "--speed", "max"]
    assert angen("replay", events, "--mqtt", broker.address, *options)[0] == 0
    retained = broker.retained()
    assert (retained["angen/status"], retained["flat-2/west/status"]) == ("online", "offline")
    assert retained["angen/pir_hall/moved"] == "ON"
    assert retained["flat-2/west/pir_hall/moved"] == "OFF"
    assert angen("replay", "--forget", "--mqtt", broker.address, "--topic", "flat-2/west")[0] == 0
    assert {topic.partition("/")[0] for topic in broker.retained()} == {"angen", "homeassistant"}


def test_sensors_that_a_home_has_no_more_go(broker, angen, events, endless) -> None:
    angen("replay", events, "--mqtt", broker.address, "--speed", "max")
    options = ["--speed", "max", "--until", "1"]
    status, _, err = angen("replay", endless, "--mqtt", broker.address, *options)
    assert status == 0
    told = err.splitlines()[0]
    assert all(name in told for name in ("Küche", "Lux", "Pad", "Switch", "pir-hall")), err
    assert set(broker.retained()) == {
        "homeassistant/device/angen_pir_hall/config",
        "angen/status",
        "angen/pir_hall/moved",
    }


def test_password_and_tls(guarded, angen, events, secrets) -> None:
    options = ["replay", events, "--mqtt", guarded.address, "--speed", "max"]
    options += ["--ca", secrets / "ca.pem", "--user", "angen"]
    with guarded.listen() as listener:
        assert angen(*options, ANGEN_MQTT_PASSWORD="geheim-ü")[0] == 0
        first = listener.all()
    assert ("angen/lux/illuminance_lux", "1445.25") in first
    # The file counts if both are given.
    status, _, err = angen(
        *options, "--password-file", secrets / "password", ANGEN_MQTT_PASSWORD="wrong"
    )
    assert status == 0, err
    assert "geheim" not in err


ANGEN = ["--ca", "ca.pem", "--user", "angen"]


@pytest.mark.parametrize(
    ("options", "status", "words"),
    [
        (["--ca", "ca.pem"], 1, ["refuses the connection", "--user"]),
        ([*ANGEN], 1, ["ANGEN_MQTT_PASSWORD"]),
        ([*ANGEN, "--password-file", "wrong"], 1, ["--password-file"]),
        ([*ANGEN, "--password-file", "none"], 2, ["none", "No such"]),
        ([*ANGEN, "--password-file", "empty"], 2, ["empty"]),
        (["--ca", "ca.pem", "--password-file", "password"], 2, ["--user"]),
        (
            [*ANGEN, "--password-file", "password", "--topic", "forbidden"],
            1,
            ["refuses messages from user 'angen'", "forbidden/"],
        ),
        (["--tls"], 1, ["certificate", "--ca"]),
        (["--ca", "other.pem"], 1, ["certificate", "--ca"]),
        (["--ca", "none.pem"], 2, ["none.pem", "No such file"]),
        (["--ca", "password"], 2, ["password", "PEM"]),
        ([], 1, ["closed the connection", "--tls"]),
    ],
)
def test_who_is_not_let_in_reads_why_in_a_line(
    guarded, angen, events, secrets, options, status, words
) -> None:
    files = {p.name for p in secrets.iterdir()} | {"none", "none.pem"}
    paths = [secrets / o if o in files else o for o in options]
    found, _, err = angen("replay", events, "--mqtt", guarded.address, *paths)
    assert found == status, err
    assert all(word in the_line(err) for word in words), err
    assert guarded.retained() == {}


def test_who_is_not_there_is_told_in_a_line(broker, angen, events, tmp_path) -> None:
    gone = broker.address
    options = ["replay", events, "--mqtt"]
    _, _, err = angen(*options, gone, "--tls")
    assert "does not use TLS" in the_line(err)
    broker.stop()
    for address, words in (
        (gone, ["no broker listens", gone, "running"]),
        ("nowhere.invalid", ["host 'nowhere.invalid' is not found"]),
    ):
        status, _, err = angen(*options, address)
        assert status == 1
        assert all(word in the_line(err) for word in words), err


def test_a_web_server_is_no_broker(angen, events) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:

        def answer() -> None:
            client, _ = server.accept()
            client.recv(1024)
            client.sendall(b"HTTP/1.1 400 Bad Request\r\n\r\n" + 80 * b" ")

        threading.Thread(target=answer, daemon=True).start()
        address = f"localhost:{server.getsockname()[1]}"
        status, _, err = angen("replay", events, "--mqtt", address)
    assert status == 1
    assert f"{address} does not answer as a broker does: is this its port" in the_line(err)


BLENDS = "sample_blends"


def told(events: str) -> dict[str, list[str]]:
    """Return the values of each field in the log, as `sensor/field`, in order."""
    found: dict[str, list[str]] = {}
    for row in csv.DictReader(events.splitlines()):
        words = {"moved", "lit", "pressed", "valid"}
        value = ("OFF", "ON")[int(row["value"])] if row["field"] in words else row["value"] or "–"
        found.setdefault(f"{row['sensor']}/{row['field']}", []).append(value)
    return found


needs_bpy = pytest.mark.skipif(
    find_spec("bpy") is None, reason="needs Blender's Python module (bpy)"
)


@needs_bpy
@pytest.mark.parametrize(
    ("blend", "options"), [("light_control", ["--speed", 20]), ("pressure", ["--speed", "max"])]
)
def test_what_is_sent_is_what_is_logged(broker, angen, blend, options) -> None:
    with broker.listen() as listener:
        home = f"{BLENDS}/{blend}.blend"
        options = ["--quiet", "--mqtt", broker.address, *options]
        status, out, err = angen("simulate", home, *options)
        received = listener.all()
    assert (status, err) == (0, "")
    names = {}
    for topic, payload in received:
        if topic.endswith("/config"):
            config = json.loads(payload)
            for field, entity in config["cmps"].items():
                names[entity["state_topic"]] = f"{config['dev']['name']}/{field}"
    online = received.index(("angen/status", "online"))
    assert received[-1] == ("angen/status", "offline")
    found: dict[str, list[str]] = {}
    for topic, payload in received[online + 1 : -1]:
        found.setdefault(names[topic], []).append(payload)
    assert found == told(out)
    assert {payload for topic, payload in received[:online] if topic in names} == {"None"}


@needs_bpy
def test_ctrl_c_ends_run_and_sending(broker, start, tmp_path) -> None:
    events = tmp_path / "events.csv"
    with broker.listen() as listener:
        home = f"{BLENDS}/light_control.blend"
        run = start("simulate", home, "--quiet", "--mqtt", broker.address, "--events", events)
        listener.until("angen/pir_room/moved", "ON")
        run.send_signal(signal.SIGINT)
        _, err = run.communicate()
        assert listener.all()[-1] == ("angen/status", "offline")
    assert (run.returncode, err) == (1, "angen: interrupted; nothing was written\n")
    assert not events.exists()
