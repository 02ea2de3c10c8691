# SPDX-License-Identifier: GPL-3.0-or-later
"""Table of all sensors with their readings, which can be sorted and searched.

A click on a row selects the sensor.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import bpy
from bpy.props import BoolProperty, EnumProperty, IntProperty, PointerProperty, StringProperty
from bpy.types import Context, Panel, PropertyGroup, UIList, WindowManager

from ..angen_addon.appearance.panel_parts import USUAL_WIDTH, Sidebar
from ..angen_addon.appearance.reading_text import (
    ACTIVE,
    BAKED,
    DOUBTFUL,
    IDLE,
    NOT_SURE,
    OFF,
    OLD,
    UNKNOWN,
    WRONG,
    ReadingText,
)
from ..angen_addon.runtime.edits import EDITS
from ..angen_addon.scene.instances import stands_for
from ..angen_addon.scene.memory import forgets_at_undo
from ..angen_addon.scene.sensors import Sensor
from ..angen_addon.translations.interface import translated
from ..angen_addon.view.readings import ReadingTexts
from ..operators.show import show, why_hidden
from ..sensor_logic.report.svg import shortened
from .instanced import draw_rows
from .parameters import sensor_of

# The order of states in the table. States that need attention come first.
ORDER_OF_STATES = (WRONG, DOUBTFUL, OLD, ACTIVE, IDLE, NOT_SURE, BAKED, UNKNOWN, OFF)
ROWS, MOST_ROWS = 4, 8
# Regions wider than this (pixels at scale 1) have a column for rooms.
WIDE = 330
# Pixels at scale 1 of a row's margins with the scroll bar, and of the icon before a name.
MARGINS, ICON = 86, 42
# Pixels at scale 1: the size of the interface's letters.
LETTER = 11.0
NAME_SHARE, NAME_SHARE_WIDE, NAME_SHARE_ACTIVE, ROOM_SHARE = 0.78, 0.5, 0.66, 0.6


def sort_key(sensor: Sensor, seen: ReadingText | None, by: str) -> tuple[Any, ...]:
    """Return the key that sorts a sensor by NAME, ROOM, KIND or STATE, and then by name.

    `seen` has the texts of the sensor's reading; only STATE needs them.
    """
    if by == "ROOM":
        # Sensors without a room come last.
        return (not sensor.room, sensor.room.lower(), sensor.name.lower())
    if by == "KIND":
        return (sensor.kind.number, sensor.name.lower())
    if by == "STATE" and seen is not None:
        return (ORDER_OF_STATES.index(seen.icon), sensor.name.lower())
    return (sensor.name.lower(),)


def matches(sensor: Sensor, seen: ReadingText | None, words: str) -> bool:
    """Return whether each of the words occurs in the sensor's name, room, kind or state.

    `seen` has the texts of the sensor's reading.
    """
    state = seen.text if seen else ""
    text = f"{sensor.name} {sensor.room} {translated(sensor.kind.label)} {state}".lower()
    return all(word in text for word in words.lower().split())


# The texts for the rows of the table that is being drawn. Blender filters the rows and then draws
# them, with a new object of the list at each step, which cannot keep the texts itself.
_texts: ReadingTexts | None = None


@forgets_at_undo
def _forget() -> None:
    global _texts
    _texts = None


class ANGEN_UL_sensors(UIList):
    """A list of the sensors in a view layer."""

    def draw_item(
        self,
        context: Context,
        layout: Any,
        data: Any,
        item: Any,
        icon: int,
        active_data: Any,
        active_property: str,
        index: int = 0,
        flt_flag: int = 0,
    ) -> None:
        sensor = sensor_of(item)
        if sensor is None:
            return
        seen = (_texts or ReadingTexts(context.scene)).of(sensor)
        row = layout.row(align=True)
        row.active = sensor.settings.enabled
        wide = _is_wide(context)
        # The row of the active sensor also has a button.
        active = item == stands_for(context.view_layer.objects.active)
        narrow = NAME_SHARE_ACTIVE if active else NAME_SHARE
        split = row.split(factor=NAME_SHARE_WIDE if wide else narrow, align=True)
        room = _room_for_name(context, NAME_SHARE_WIDE if wide else narrow)
        split.label(text=shortened(sensor.name, room, LETTER), icon=seen.icon, translate=False)
        if wide:
            split = split.split(factor=ROOM_SHARE, align=True)
            split.label(text=sensor.room, translate=False)
        value = split.row()
        value.alignment = "RIGHT"
        value.label(text=seen.short if wide else seen.brief or seen.text, translate=False)
        if active:
            again = row.operator("angen.sensor_show", text="", icon="ZOOM_SELECTED", emboss=False)
            again.name, again.library = sensor.name, sensor.library

    def filter_items(self, context: Context, data: Any, name: str) -> tuple[list[int], list[int]]:
        global _texts
        _texts = ReadingTexts(context.scene)
        settings = context.window_manager.angen_table
        return sorted_and_filtered(
            list(getattr(data, name)), context.scene, settings, self.bitflag_filter_item
        )

    def draw_filter(self, context: Context, layout: Any) -> None:
        """Draw nothing, because the panel has its own search and sort fields above the table."""


def sorted_and_filtered(
    objects: list[Any], scene: Any, settings: Any, show: int
) -> tuple[list[int], list[int]]:
    """Return the filter flags and the new order of objects, as `UIList.filter_items` does.

    The flag of an object is `show` if the object matches the search, else 0.
    """
    found = _matching(map(sensor_of, objects), scene, settings)
    kept = set(found)
    flags = [show if number in kept else 0 for number in range(len(objects))]
    others = [number for number in range(len(objects)) if number not in kept]
    places = [0] * len(objects)
    for place, number in enumerate([*found, *others]):
        places[number] = place
    return flags, places


def _matching(sensors: Iterable[Sensor | None], scene: Any, settings: Any) -> list[int]:
    """Return the indices of the sensors that match the search, in the table's sort order."""
    by, words = settings.sort, settings.search
    texts = ReadingTexts(scene) if words or by == "STATE" else None
    keys = []
    for number, sensor in enumerate(sensors):
        if sensor is None:
            continue
        seen = texts.of(sensor) if texts is not None else None
        if matches(sensor, seen, words):
            keys.append((sort_key(sensor, seen, by), number))
    return [number for _, number in sorted(keys, reverse=settings.reverse)]


def _room_for_name(context: Context, share: float) -> float:
    """Return the width of the column of names in pixels at scale 1, without the icon.

    `share` is the column's part of a row's width.
    """
    region = context.region
    wide = region.width / (context.preferences.system.ui_scale or 1.0) if region else USUAL_WIDTH
    return share * (wide - MARGINS) - ICON


def _is_wide(context: Context) -> bool:
    region = context.region
    scale = context.preferences.system.ui_scale or 1.0
    return region is not None and region.width > WIDE * scale


class ANGEN_PT_table(Sidebar, Panel):
    bl_label = "Sensors"

    def draw(self, context: Context) -> None:
        layout, settings = self.layout, context.window_manager.angen_table
        sensors = EDITS.sensors(context.view_layer)
        if not sensors:
            layout.label(text="No sensors yet: Shift+A, Sensor", icon="INFO")
            return
        layout.prop(settings, "search", text="", icon="VIEWZOOM")
        row = layout.row(align=True)
        row.prop(settings, "sort", expand=True)
        row.prop(
            settings,
            "reverse",
            text="",
            icon="SORT_ASC" if settings.reverse else "SORT_DESC",
        )
        instanced = [s for s in sensors if s.holders]
        if instanced:
            found = _matching(instanced, context.scene, settings)
            draw_rows(layout, context, [instanced[number] for number in found])
        if len(instanced) == len(sensors):
            return
        rows = min(max(len(sensors) - len(instanced), ROWS), MOST_ROWS)
        layout.template_list(
            ANGEN_UL_sensors.__name__,
            "",
            context.view_layer,
            "objects",
            settings,
            "index",
            rows=rows,
            maxrows=rows,
            sort_lock=True,
        )


def _active_index(self: PropertyGroup) -> int:
    layer = bpy.context.view_layer
    active = stands_for(layer.objects.active) if layer else None
    return -1 if active is None else layer.objects.find(active.name)


def _show_index(self: PropertyGroup, index: int) -> None:
    """Select the sensor of the clicked row. Move the view to the sensor if it is out of view."""
    context = bpy.context
    objects = context.view_layer.objects
    sensor = sensor_of(objects[index]) if 0 <= index < len(objects) else None
    if sensor is not None and context.mode == "OBJECT" and not why_hidden(sensor.object, context):
        show(sensor, context, stay=True)
        bpy.ops.ed.undo_push(message=translated("Show Sensor"))


def _group() -> type:
    annotations = {
        "search": StringProperty(
            name="Search",
            description="Show only sensors with these words in name, room, kind or state",
            options={"TEXTEDIT_UPDATE"},
        ),
        "sort": EnumProperty(
            name="Sort By",
            description="Order of the table",
            items=[
                ("NAME", "Name", "By name", 0),
                ("ROOM", "Room", "By room, then name", 1),
                ("KIND", "Kind", "By kind, then name", 2),
                ("STATE", "State", "Not valid first, then active", 3),
            ],
        ),
        "reverse": BoolProperty(name="Reverse", description="Reverse the order"),
        "index": IntProperty(
            name="Active Sensor", get=_active_index, set=_show_index, options=set()
        ),
    }
    return type("AngenTable", (PropertyGroup,), {"__annotations__": annotations})


TABLE = _group()
_register, _unregister = bpy.utils.register_classes_factory(
    (TABLE, ANGEN_UL_sensors, ANGEN_PT_table)
)


def register() -> None:
    _register()
    WindowManager.angen_table = PointerProperty(type=TABLE)


def unregister() -> None:
    del WindowManager.angen_table
    _unregister()
