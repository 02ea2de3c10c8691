# SPDX-License-Identifier: GPL-3.0-or-later
"""Live to MQTT: the readings at the playhead go to a broker, if Blender allows online access."""

import json
import time
from pathlib import Path

import bpy
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.output.mqtt import link, live, online
from bl_ext.user_default.angen_sensors.operators import live_mqtt
from bl_ext.user_default.angen_sensors.sensor_logic.logs.error import AngenError
from panel_layout import drawn

PATIENCE_S = 10.0


class Broker:
    """Takes the place of the connection: keeps what it gets."""

    def __init__(self, address, will):
        self.words = address.words
        self.address, self.got, self.is_lost, self.closed = address, [], False, False
        brokers.append(self)

    def connect(self):
        if "refuses" in self.address.host:
            raise AngenError("no broker listens there")

    def send(self, message, idle=None):
        self.got.append(message)
        return True

    def flush(self, seconds=0.0):
        return True

    def take_unacknowledged(self):
        return 0

    def retained(self, topics):
        return []

    def close(self):
        self.closed = True

    def states(self, topic):
        return [message.payload for message in self.got if message.topic == topic]


brokers: list[Broker] = []


@pytest.fixture
def broker(world, monkeypatch):
    """A home with a switch whose beam is free from frame 5 on, and settings of a broker."""
    brokers.clear()
    monkeypatch.setattr(live, "Link", Broker)
    monkeypatch.setattr("time.sleep", lambda seconds: None)
    monkeypatch.setattr(live_mqtt, "may_go_online", lambda: True)
    monkeypatch.setattr(live_mqtt, "outcome", ("", ""))
    settings = live_mqtt.settings_of(bpy.context)
    settings.broker, settings.user, settings.authority = "broker.home:1884", "anna", ""
    world.scene.angen_topic = "flat"
    world.door(5)
    world.switch("Door", range_max=0.5)
    world.scene.angen_live = True
    world.scene.frame_set(1)
    yield settings
    live_mqtt.stop()
    if bpy.app.timers.is_registered(live_mqtt._tick):
        bpy.app.timers.unregister(live_mqtt._tick)


def until(what):
    end = time.monotonic() + PATIENCE_S
    while not what():
        assert time.monotonic() < end
        live_mqtt._tick()


def test_readings_at_the_playhead_are_announced_and_sent_when_they_change(world, broker):
    broker.password = "secret"
    assert bpy.ops.angen.mqtt_start() == {"FINISHED"}
    (made,) = brokers
    address = made.address
    assert (address.host, address.port, address.user) == ("broker.home", 1884, "anna")
    assert address.password == "secret"
    until(lambda: made.states("flat/status")[-1:] == ["online"])
    configs = [json.loads(m.payload) for m in made.got if m.topic.startswith("homeassistant/")]
    assert [config["dev"]["name"] for config in configs] == ["Door"]
    assert made.states("flat/door/open") == ["OFF"]
    world.scene.frame_set(6)
    until(lambda: made.states("flat/door/open") == ["OFF", "ON"])
    until(lambda: live_mqtt.sender.state == "Connected to broker.home:1884: sent 1 change")
    assert not bpy.ops.angen.mqtt_start.poll()
    texts = drawn("ANGEN_PT_live_mqtt").labels
    assert "Connected to broker.home:1884: sent 1 change" in " ".join(texts)
    assert bpy.ops.angen.mqtt_stop() == {"FINISHED"}
    assert made.states("flat/status")[-1] == "offline" and made.closed


@pytest.mark.filterwarnings("ignore:.*blend relative")
def test_the_broker_stays_when_another_file_is_opened_and_the_password_is_in_no_file(
    world, broker, tmp_path
):
    broker.password = "a-secret-of-mine"
    path = tmp_path / "home.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=False)
    broker.authority = "//ca.pem"
    bpy.ops.wm.save_userpref()
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    now = live_mqtt.settings_of(bpy.context)
    assert (now.broker, now.user, now.password) == ("broker.home:1884", "anna", "a-secret-of-mine")
    assert now.authority == str(tmp_path / "ca.pem")
    assert bpy.context.scene.angen_topic == "angen"
    bpy.ops.wm.open_mainfile(filepath=str(path))
    assert bpy.context.scene.angen_topic == "flat"
    preferences = Path(bpy.utils.user_resource("CONFIG"), "userpref.blend")
    files = [path.read_bytes(), preferences.read_bytes()]
    assert [b"a-secret-of-mine" in text for text in files] == [False, False]
    assert [b"broker.home" in text for text in files] == [False, True]


def test_sensors_that_change_are_announced_and_a_file_that_is_opened_ends_it(world, broker):
    assert bpy.ops.angen.mqtt_start() == {"FINISHED"}
    (made,) = brokers
    until(lambda: made.states("flat/status")[-1:] == ["online"])
    bpy.data.objects["Door"].name = "Gate"
    config = "homeassistant/device/flat_{}/config"
    until(lambda: any(made.states(config.format("gate"))))
    assert made.states(config.format("door"))[-1] == ""
    assert made.states("flat/door/open")[-1] == ""
    world.scene.frame_set(2)
    until(lambda: made.states("flat/gate/open")[-1] == "OFF")
    count = len(made.got)
    for _ in range(3):
        live_mqtt._tick()
    world.pir("Hall")
    until(lambda: made.states("flat/hall/moved"))
    configs = [message.topic for message in made.got[count:] if message.topic.endswith("/config")]
    assert configs == [config.format("hall")]
    # What has not changed is not sent again.
    assert made.states("flat/status") == ["offline", "online"]
    assert made.states("flat/gate/open") == ["None", "OFF"]
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    assert live_mqtt.sender is None


def test_why_it_ended_stays_in_the_panel(broker):
    broker.broker = "refuses.home"
    bpy.ops.angen.mqtt_start()
    until(lambda: live_mqtt.sender is None)
    assert live_mqtt.outcome[0] == "no broker listens there"


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("broker", "anna@home", "contains a user name: give it as User"),
        ("broker", "home:port", "'home:port' is not HOST or HOST:PORT"),
        ("angen_topic", "flat/#", "'flat/#' is not a topic"),
    ],
)
def test_wrong_settings_are_one_line(world, broker, name, value, words):
    setattr(world.scene if name == "angen_topic" else broker, name, value)
    with pytest.raises(RuntimeError, match=words):
        bpy.ops.angen.mqtt_start()
    assert not brokers


def test_without_online_access_nothing_connects_and_the_way_out_is_told(
    broker, monkeypatch, command
):
    system = bpy.context.preferences.system
    monkeypatch.setattr(live_mqtt, "may_go_online", online.may_go_online)
    before = system.use_online_access
    try:
        system.use_online_access = True
        assert online.may_go_online() == bpy.app.online_access
        system.use_online_access = False
        assert not online.may_go_online()
        assert not bpy.ops.angen.mqtt_start.poll()
        texts = " ".join(drawn("ANGEN_PT_live_mqtt").labels)
        assert "Allow Online Access" in texts
        with pytest.raises(AngenError, match="Allow Online Access"):
            link.Link.connect(object())
    finally:
        system.use_online_access = before
