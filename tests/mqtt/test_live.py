# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel *Live to MQTT* of an open home against a real mosquitto."""

from __future__ import annotations

import json
import signal
import threading
from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from tests.mqtt.conftest import ROOT, Broker, until

bpy = pytest.importorskip("bpy", reason="needs Blender's Python module (bpy)")


@pytest.fixture
def panel(addon: Any, monkeypatch: pytest.MonkeyPatch) -> Iterator[SimpleNamespace]:
    """Open a home; return its settings of the broker, and the operators' module as `live`."""
    bpy.ops.wm.open_mainfile(filepath=str(ROOT / "sample_blends" / "light_control.blend"))
    live = import_module(f"{addon.__name__}.operators.live_mqtt")
    monkeypatch.setattr(live, "may_go_online", lambda: True)
    link = import_module(f"{addon.__name__}.angen_addon.output.mqtt.link")
    monkeypatch.setattr(link, "check_online", lambda: None)
    settings = live.settings_of(bpy.context)
    for name in ("user", "password", "tls", "authority"):
        settings.property_unset(name)
    bpy.context.scene.frame_set(1)
    yield SimpleNamespace(live=live, settings=settings)
    live.stop()
    live.outcome = "", ""
    if bpy.app.timers.is_registered(live._tick):
        bpy.app.timers.unregister(live._tick)


def wait(panel: SimpleNamespace, what: Callable[[], Any]) -> None:
    """Wait until a condition is true, with the timer that Blender's window would call."""
    until(lambda: (panel.live._tick(), what())[1])


def start(panel: SimpleNamespace, broker: Broker) -> None:
    panel.settings.broker = broker.address
    assert bpy.ops.angen.mqtt_start() == {"FINISHED"}
    wait(panel, lambda: panel.live.sender.state.startswith("Connected"))


def sensors_at(broker: Broker) -> set[str]:
    """Return the names of the sensors that Home Assistant would have."""
    retained = broker.retained()
    configs = [json.loads(text) for topic, text in retained.items() if topic.endswith("/config")]
    names = {config["dev"]["name"] for config in configs}
    topics = {topic.split("/")[1] for topic in retained if topic.count("/") == 2}
    assert len(topics) == len(names), retained
    return names


def test_what_changes_in_the_scene_changes_at_the_broker(panel, broker) -> None:
    objects = bpy.data.objects
    with broker.listen() as listener:
        start(panel, broker)
        assert sensors_at(broker) >= {"PIR room"}
        before = sensors_at(broker)
        moved = "angen/pir_room/moved"
        listener.until(moved, "OFF")
        for frame in range(1, bpy.context.scene.frame_end):
            bpy.context.scene.frame_set(frame)
            panel.live._tick()
        listener.until(moved, "ON")
        sent = listener.all()
        online = sent.index(("angen/status", "online"))
        assert panel.live.sender.state.endswith(f"sent {len(sent) - online - 1} changes")
    # A sensor is renamed, one is removed, one comes.
    objects["PIR room"].name = "PIR flat"
    wait(panel, lambda: sensors_at(broker) == before - {"PIR room"} | {"PIR flat"})
    bpy.data.objects.remove(objects["PIR flat"])
    wait(panel, lambda: sensors_at(broker) == before - {"PIR room"})
    bpy.ops.angen.sensor_add(kind="CONTACT")
    name = bpy.context.object.name
    wait(panel, lambda: sensors_at(broker) == before - {"PIR room"} | {name})
    assert bpy.ops.angen.mqtt_stop() == {"FINISHED"}
    assert broker.retained()["angen/status"] == "offline"
    assert bpy.ops.angen.mqtt_remove() == {"FINISHED"}
    wait(panel, lambda: panel.live.sender is None)
    text, icon = panel.live.outcome
    assert (text, icon) == (f"Removed {len(before)} sensors from {broker.address}", "CHECKMARK")
    assert broker.retained() == {}


def test_a_sensor_removed_while_the_broker_is_gone_is_removed_once_it_is_back(
    panel, make_broker, tmp_path
) -> None:
    lines = ["allow_anonymous true", "persistence true", f"persistence_location {tmp_path}/"]
    broker = make_broker(*lines)
    start(panel, broker)
    before = sensors_at(broker)
    broker.process.send_signal(signal.SIGTERM)
    broker.process.wait()
    wait(panel, lambda: panel.live.sender.state == "Connection lost, trying again")
    bpy.data.objects["PIR room"].name = "PIR flat"
    panel.live._tick()
    broker.start()
    wait(panel, lambda: panel.live.sender.state.startswith("Connected"))
    wait(panel, lambda: sensors_at(broker) == before - {"PIR room"} | {"PIR flat"})
    assert broker.retained()["angen/status"] == "online"


def test_an_error_of_the_client_itself_is_shown_and_sending_goes_on(
    panel, broker, monkeypatch
) -> None:
    seen: list[Any] = []
    monkeypatch.setattr(threading, "excepthook", lambda args: seen.append(args.exc_type))
    start(panel, broker)
    client = panel.live.sender._player._link._client
    client.on_publish = lambda *_: 1 / 0
    bpy.data.objects[next(iter(sensors_at(broker)))].name = "Renamed"
    wait(panel, lambda: seen)
    assert seen == [ZeroDivisionError]
    wait(panel, lambda: "Renamed" in sensors_at(broker))
    assert panel.live.sender.state.startswith("Connected")


def test_stopped_while_it_connects_it_announces_nothing(panel, broker) -> None:
    panel.settings.broker = broker.address
    broker.process.send_signal(signal.SIGSTOP)
    bpy.ops.angen.mqtt_start()
    sender = panel.live.sender
    wait(panel, lambda: sender.state.startswith("Connecting"))
    bpy.ops.angen.mqtt_stop()
    # Two senders would disturb each other.
    assert not bpy.ops.angen.mqtt_start.poll() and not bpy.ops.angen.mqtt_stop.poll()
    assert sender.state == f"Stopping, waiting for {broker.address}"
    broker.process.send_signal(signal.SIGCONT)
    wait(panel, lambda: panel.live.sender is None)
    assert broker.retained() == {}
    assert bpy.ops.angen.mqtt_start.poll()


def test_the_scene_that_sends_is_the_one_it_was_started_in(panel, broker) -> None:
    first = bpy.context.scene
    start(panel, broker)
    before = sensors_at(broker)
    window = bpy.context.window_manager.windows[0]
    window.scene = bpy.data.scenes.new("Other")
    assert panel.live.sent_scene() == first
    panel.live._tick()
    assert sensors_at(broker) == before
    assert panel.live.is_busy()
    bpy.data.scenes.remove(first)
    panel.live._tick()
    assert not panel.live.is_busy()
    assert "is gone" in panel.live.outcome[0]
    assert broker.retained()["angen/status"] == "offline"


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({}, "closed the connection: is this its port, and does it need TLS?"),
        ({"tls": True}, "give Authority, the certificate of the authority that signed it"),
        ({"tls": True, "authority": "other.pem"}, "give Authority, the certificate"),
        ({"tls": True, "authority": "ca.pem"}, "Not authorized): give User and Password"),
        ({"tls": True, "authority": "ca.pem", "user": "angen"}, "give User and Password"),
        (
            {"tls": True, "authority": "ca.pem", "user": "angen", "password": "geheim-ü",
             "angen_topic": "forbidden"},
            "allow it to publish below homeassistant/device/ and forbidden/",
        ),
    ],
)  # fmt: skip
def test_why_it_ends_is_told_in_the_words_of_the_panel(
    panel, guarded, secrets: Path, settings, words
) -> None:
    for name, value in {"broker": guarded.address, "password": "wrong", **settings}.items():
        owner = bpy.context.scene if name == "angen_topic" else panel.settings
        setattr(owner, name, str(secrets / value) if name == "authority" else value)
    bpy.ops.angen.mqtt_start()
    wait(panel, lambda: panel.live.sender is None)
    text, icon = panel.live.outcome
    assert words in text and icon == "ERROR"
    assert "--" not in text and "wrong" not in text


def test_another_home_that_is_online_is_told_and_can_be_removed(panel, broker) -> None:
    broker.publish("angen/status", "online", "-r")
    panel.settings.broker = broker.address
    bpy.ops.angen.mqtt_start()
    wait(panel, lambda: panel.live.sender is None)
    assert panel.live.outcome[0].endswith("give another Topic; if there is none, press Remove")
    bpy.ops.angen.mqtt_remove()
    wait(panel, lambda: panel.live.sender is None)
    start(panel, broker)
