# SPDX-License-Identifier: GPL-3.0-or-later
"""Send the readings at the playhead to an MQTT broker, such as Home Assistant's."""

from __future__ import annotations

import argparse
from dataclasses import replace
from typing import Any

import bpy
from bpy.app.handlers import persistent
from bpy.props import BoolProperty, StringProperty
from bpy.types import AddonPreferences, Context, Operator

from ..angen_addon.output.mqtt import address
from ..angen_addon.output.mqtt.live import (
    WORDS,
    BrokerThread,
    LiveSender,
    Remover,
    present_readings,
)
from ..angen_addon.output.mqtt.online import REFUSAL, may_go_online
from ..angen_addon.relative_path import absolute
from ..angen_addon.runtime.running import is_running
from ..angen_addon.scene.sensors import all_sensors, check_names, simulated
from ..angen_addon.translations.dictionary import CONTEXT
from ..sensor_logic.logs.error import AngenError
from ..sensor_logic.logs.formats.home_assistant import TOPIC
from .polls import cancelled, needs

# s: pause between two looks at the readings.
TICK_S = 0.2

# The password stays in memory: Blender would write a property into the file.
_password = ""
sender: BrokerThread | None = None
# The scene whose readings are sent, by its `session_uid`.
_scene = 0
# How the last work has ended, and its icon; empty if the user stopped it.
outcome = "", "ERROR"
# The state that the panel shows.
_drawn = ""


def _get_password(_settings: Any) -> str:
    return _password


def _set_password(_settings: Any, text: str) -> None:
    global _password
    _password = text


def _changed(settings: Any, context: Context) -> None:
    # Blender saves its preferences at its end if they have changed.
    context.preferences.is_dirty = True
    # A path that is relative to this file would mean another one in the next file.
    if settings.authority.startswith("//"):
        settings.authority = str(absolute(settings.authority))


class AngenPreferences(AddonPreferences):
    """The broker of *Live to MQTT*, which stays the same when another file is opened."""

    bl_idname = __package__.rpartition(".")[0]

    broker: StringProperty(
        name="Broker",
        description="The broker's host, or HOST:PORT, such as homeassistant.local. Without a port "
        "1883, or 8883 with TLS",
        update=_changed,
    )
    user: StringProperty(
        name="User", description="User name at the broker; empty: none", update=_changed
    )
    password: StringProperty(
        name="Password",
        description="Password of the user. It is in no file: Blender forgets it at its end",
        subtype="PASSWORD",
        get=_get_password,
        set=_set_password,
    )
    tls: BoolProperty(name="TLS", description="Encrypt the connection", update=_changed)
    authority: StringProperty(
        name="Authority",
        description="Certificate (PEM) of the authority that signed the broker's; empty: those "
        "that the system trusts",
        subtype="FILE_PATH",
        update=_changed,
    )


def settings_of(context: Context) -> Any:
    """Return the settings of the broker; None in the Python package, which has no preferences."""
    addon = context.preferences.addons.get(AngenPreferences.bl_idname)
    return addon and addon.preferences


def address_of(context: Context) -> tuple[address.Address, str]:
    """Return the broker's address and the topic of the home; raise AngenError if one is wrong."""
    settings = settings_of(context)
    authority = absolute(settings.authority) if settings.authority else None
    if "@" in settings.broker:
        raise AngenError("the broker contains a user name: give it as User, and its Password")
    try:
        host = address.host_and_port(settings.broker.strip())
        topic = address.topic(context.scene.angen_topic.strip() or TOPIC)
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
    return replace(found, password=_password or None, words=WORDS), topic


def is_busy() -> bool:
    """Return whether the thread connects, sends readings or removes sensors."""
    return sender is not None and sender.is_alive


def sent_scene() -> Any:
    """Return the scene whose readings are sent; None without one."""
    if not (is_busy() and isinstance(sender, LiveSender)):
        return None
    return next((scene for scene in bpy.data.scenes if scene.session_uid == _scene), None)


def _can_start(operator: type[Operator], context: Context) -> bool:
    return (
        needs(operator, may_go_online(), REFUSAL)
        and needs(operator, not is_busy(), "Stop first, or wait for the end")
        and needs(operator, getattr(settings_of(context), "broker", ""), "Name the broker first")
    )


def _start(new: BrokerThread) -> None:
    global sender, outcome
    sender, outcome = new, ("", "ERROR")
    new.start()
    if not bpy.app.timers.is_registered(_tick):
        bpy.app.timers.register(_tick, first_interval=TICK_S, persistent=True)


class ANGEN_OT_mqtt_start(Operator):
    bl_idname = "angen.mqtt_start"
    bl_label = "Start Live to MQTT"
    bl_description = (
        "Announce the sensors to the broker, and send their readings at the playhead from now on, "
        "while scrubbing and playing too"
    )

    @classmethod
    def poll(cls, context: Context) -> bool:
        return _can_start(cls, context) and needs(
            cls, all_sensors(context.view_layer), "Add a sensor first: Shift+A, Sensor"
        )

    def execute(self, context: Context) -> set[str]:
        global _scene
        sensors = simulated(all_sensors(context.view_layer))
        if not sensors:
            return cancelled(self, "All sensors are switched off: switch one on with Enabled")
        try:
            check_names(sensors)
            found, topic = address_of(context)
            new = LiveSender(found, topic, sensors, present_readings(context.scene, sensors))
        except AngenError as error:
            return cancelled(self, error)
        _scene = context.scene.session_uid
        _start(new)
        return {"FINISHED"}


class ANGEN_OT_mqtt_remove(Operator):
    bl_idname = "angen.mqtt_remove"
    bl_label = "Remove Sensors from Broker"
    bl_description = (
        "Remove all sensors below the topic from the broker, and so from Home Assistant. Start "
        "announces them again"
    )

    @classmethod
    def poll(cls, context: Context) -> bool:
        return _can_start(cls, context)

    def execute(self, context: Context) -> set[str]:
        try:
            _start(Remover(*address_of(context)))
        except AngenError as error:
            return cancelled(self, error)
        return {"FINISHED"}


class ANGEN_OT_mqtt_stop(Operator):
    bl_idname = "angen.mqtt_stop"
    bl_label = "Stop Live to MQTT"
    bl_description = "Send no more readings. The broker then shows the sensors as unavailable"

    @classmethod
    def poll(cls, _context: Context) -> bool:
        return needs(cls, sender is not None and not sender.is_stopped, "Nothing is being sent")

    def execute(self, _context: Context) -> set[str]:
        stop()
        return {"FINISHED"}


def stop() -> None:
    """Send no more readings. The sender stays until it has ended: no second one may disturb it."""
    global sender
    if sender is not None:
        sender.stop()
        if not sender.is_alive:
            sender = None


def _tick() -> float | None:
    """Send what has changed; return the time in s until the next call, None to end the timer."""
    global sender, _drawn
    if sender is None:
        return None
    if sender.is_stopped:
        if sender.is_alive:
            return TICK_S
        sender = None
        _redraw()
        return None
    if not sender.is_alive:
        done = sender.state if isinstance(sender, Remover) else ""
        _end(sender.error or done, "ERROR" if sender.error else "CHECKMARK")
        return None
    if not may_go_online():
        _end(REFUSAL, "ERROR")
        return None
    if isinstance(sender, LiveSender):
        if sent_scene() is None:
            _end("The scene whose readings were sent is gone: start again", "ERROR")
            return None
        _show(sender)
    if sender.state != _drawn:
        _drawn = sender.state
        _redraw()
    return TICK_S


def _end(text: str, icon: str) -> None:
    global outcome
    stop()
    outcome = text, icon
    _redraw()


def _show(live: LiveSender) -> None:
    """Hand on the readings at the playhead, in a window that shows the scene."""
    if is_running():
        return
    for window in bpy.context.window_manager.windows:
        if window.scene.session_uid == _scene:
            sensors = simulated(all_sensors(window.view_layer))
            live.show(sensors, present_readings(window.scene, sensors))
            return


def _redraw() -> None:
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


@persistent
def _before_load(*_: Any) -> None:
    stop()


_register, _unregister = bpy.utils.register_classes_factory(
    (AngenPreferences, ANGEN_OT_mqtt_start, ANGEN_OT_mqtt_stop, ANGEN_OT_mqtt_remove)
)


def register() -> None:
    _register()
    bpy.types.Scene.angen_topic = StringProperty(
        name="Topic",
        description="First part of all topics. A second home at the same broker needs another",
        default=TOPIC,
        translation_context=CONTEXT,
    )
    bpy.app.handlers.load_pre.append(_before_load)


def unregister() -> None:
    stop()
    if bpy.app.timers.is_registered(_tick):
        bpy.app.timers.unregister(_tick)
    bpy.app.handlers.load_pre.remove(_before_load)
    del bpy.types.Scene.angen_topic
    _unregister()
