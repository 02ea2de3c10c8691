# SPDX-License-Identifier: GPL-3.0-or-later
"""Send the readings at the playhead to an MQTT broker, such as Home Assistant's."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
from bpy.app.handlers import persistent
from bpy.props import BoolProperty, PointerProperty, StringProperty
from bpy.types import Context, Operator, PropertyGroup

from ..angen_addon.output.mqtt import address
from ..angen_addon.output.mqtt.live import LiveSender, present_readings
from ..angen_addon.output.mqtt.online import REFUSAL, may_go_online
from ..angen_addon.relative_path import RELATIVE_PATH
from ..angen_addon.runtime.running import is_running
from ..angen_addon.scene.sensors import all_sensors, simulated
from ..sensor_logic.logs.error import AngenError
from ..sensor_logic.logs.formats.home_assistant import TOPIC
from .polls import cancelled, needs

# s: pause between two looks at the readings.
TICK_S = 0.2

# The password stays in memory: Blender would write a property into the file.
_password = ""
sender: LiveSender | None = None
# Why the last sending has ended; empty if the user stopped it.
problem = ""
# The state that the panel shows.
_drawn = ""


def _get_password(_settings: Any) -> str:
    return _password


def _set_password(_settings: Any, text: str) -> None:
    global _password
    _password = text


class AngenMqtt(PropertyGroup):
    """The broker of *Live to MQTT*."""

    broker: StringProperty(
        name="Broker",
        description="The broker's host, or HOST:PORT, such as homeassistant.local. Without a port "
        "1883, or 8883 with TLS",
    )
    user: StringProperty(name="User", description="User name at the broker; empty: none")
    password: StringProperty(
        name="Password",
        description="Password of the user. It is in no file: Blender forgets it at its end",
        subtype="PASSWORD",
        get=_get_password,
        set=_set_password,
    )
    tls: BoolProperty(name="TLS", description="Encrypt the connection")
    authority: StringProperty(
        name="Authority",
        description="Certificate (PEM) of the authority that signed the broker's; empty: those "
        "that the system trusts",
        subtype="FILE_PATH",
        options=RELATIVE_PATH,
    )
    topic: StringProperty(
        name="Topic",
        description="First part of all topics. A second home at the same broker needs another",
        default=TOPIC,
    )


def address_of(settings: Any) -> tuple[address.Address, str]:
    """Return the broker's address and the topic of the settings; raise AngenError if wrong."""
    authority = Path(bpy.path.abspath(settings.authority)) if settings.authority else None
    if "@" in settings.broker:
        raise AngenError("the broker contains a user name: give it as User, and its Password")
    try:
        host = address.host_and_port(settings.broker.strip())
        topic = address.topic(settings.topic.strip() or TOPIC)
    except argparse.ArgumentTypeError as error:
        raise AngenError(str(error)) from None
    options = argparse.Namespace(
        mqtt=host,
        user=settings.user or None,
        password_file=None,
        tls=settings.tls,
        ca=authority if settings.tls else None,
    )
    found = address.address_of(options)
    assert found is not None
    return replace(found, password=_password or None), topic


def is_sending() -> bool:
    """Return whether readings are being sent, or the connection is being made."""
    return sender is not None and sender.is_alive


class ANGEN_OT_mqtt_start(Operator):
    bl_idname = "angen.mqtt_start"
    bl_label = "Start Live to MQTT"
    bl_description = (
        "Announce the sensors to the broker, and send their readings at the playhead from now on, "
        "while scrubbing and playing too"
    )

    @classmethod
    def poll(cls, context: Context) -> bool:
        return (
            needs(cls, may_go_online(), REFUSAL)
            and needs(cls, not is_sending(), "Readings are being sent already")
            and needs(cls, context.window_manager.angen_mqtt.broker, "Name the broker first")
            and needs(cls, all_sensors(context.view_layer), "Add a sensor first: Shift+A, Sensor")
        )

    def execute(self, context: Context) -> set[str]:
        global sender, problem
        sensors = simulated(all_sensors(context.view_layer))
        if not sensors:
            return cancelled(self, "All sensors are switched off: switch one on with Enabled")
        try:
            found, topic = address_of(context.window_manager.angen_mqtt)
            new = LiveSender(found, sensors, topic)
        except AngenError as error:
            return cancelled(self, error)
        sender, problem = new, ""
        new.start(present_readings(context.scene, sensors))
        if not bpy.app.timers.is_registered(_tick):
            bpy.app.timers.register(_tick, first_interval=TICK_S, persistent=True)
        return {"FINISHED"}


class ANGEN_OT_mqtt_stop(Operator):
    bl_idname = "angen.mqtt_stop"
    bl_label = "Stop Live to MQTT"
    bl_description = "Send no more readings. The broker then shows the sensors as unavailable"

    @classmethod
    def poll(cls, _context: Context) -> bool:
        return needs(cls, is_sending(), "Nothing is being sent")

    def execute(self, _context: Context) -> set[str]:
        stop()
        return {"FINISHED"}


def stop() -> None:
    """Send no more readings."""
    global sender
    if sender is not None:
        sender.stop()
        sender = None


def _tick() -> float | None:
    """Send what has changed; return the time in s until the next call, None to end the timer."""
    global sender, problem, _drawn
    if sender is None:
        return None
    if not sender.is_alive:
        problem, sender = sender.error, None
        _redraw()
        return None
    if not may_go_online():
        stop()
        problem = REFUSAL
        _redraw()
        return None
    scene, view_layer = bpy.context.scene, bpy.context.view_layer
    if scene is not None and view_layer is not None and not is_running():
        sender.show(present_readings(scene, simulated(all_sensors(view_layer))))
    if sender.state != _drawn:
        _drawn = sender.state
        _redraw()
    return TICK_S


def _redraw() -> None:
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


@persistent
def _before_load(*_: Any) -> None:
    stop()


_register, _unregister = bpy.utils.register_classes_factory(
    (AngenMqtt, ANGEN_OT_mqtt_start, ANGEN_OT_mqtt_stop)
)


def register() -> None:
    _register()
    bpy.types.WindowManager.angen_mqtt = PointerProperty(type=AngenMqtt)
    bpy.app.handlers.load_pre.append(_before_load)


def unregister() -> None:
    stop()
    if bpy.app.timers.is_registered(_tick):
        bpy.app.timers.unregister(_tick)
    bpy.app.handlers.load_pre.remove(_before_load)
    del bpy.types.WindowManager.angen_mqtt
    _unregister()
