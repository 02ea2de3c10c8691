# SPDX-License-Identifier: GPL-3.0-or-later
"""Where on Earth a home stands, and the day that the window looks at."""

from __future__ import annotations

import math

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)
from bpy.types import PropertyGroup, Text

from ...sensor_logic.formats import FORMATS

# Files keep the bit of a format.
BITS = {
    name: 1 << k
    for k, name in enumerate(
        ("casas", "casas-csv", "pyadlml", "mcap", "xes", "ocel", "influx", "home-assistant",
         "parquet")
    )
}  # fmt: skip
FORMAT_ITEMS = [(name, name, FORMATS[name].tip, "NONE", bit) for name, bit in BITS.items()]


class AngenSite(PropertyGroup):
    """Set both latitude and longitude, and the sun of a day follows its date and hour."""

    latitude: FloatProperty(
        name="Latitude", description="North is positive", subtype="ANGLE",
        min=-math.pi / 2, max=math.pi / 2, precision=3, options=set(),
    )  # fmt: skip
    longitude: FloatProperty(
        name="Longitude", description="East is positive", subtype="ANGLE",
        min=-math.pi, max=math.pi, precision=3, options=set(),
    )  # fmt: skip
    utc_offset: FloatProperty(
        name="Hours Ahead of UTC", description="Of the clocks in the home, all the year",
        min=-14.0, max=14.0, precision=2, options=set(),
    )  # fmt: skip
    north: FloatProperty(
        name="North", description="By how much north is turned from the home's +Y, "
        "counter-clockwise from above", subtype="ANGLE", options=set(),
    )  # fmt: skip


class AngenDone(PropertyGroup):
    """An activity of the day that the panel lists; s since midnight."""

    person: StringProperty()
    room: StringProperty()
    start: FloatProperty()
    end: FloatProperty()


class AngenDay(PropertyGroup):
    """What the panel Day shows; `before` notes how the home was while a stretch is shown."""

    routine: StringProperty(
        name="Routine", description="File of a routine", subtype="FILE_PATH", options=set()
    )
    text: PointerProperty(
        name="Text", description="A routine in this file, in place of one on disk", type=Text
    )
    date: StringProperty(
        name="First Day", description="Its date, as 2026-03-02", default="2026-03-02",
        options=set(),
    )  # fmt: skip
    number: IntProperty(
        name="Day", description="Which day since the first is looked at", default=1, min=1,
        soft_max=31, options=set(),
    )  # fmt: skip
    seed: IntProperty(name="Seed", description="Of all chance in the routine", min=0, options=set())
    out: StringProperty(
        name="Folder", description="A new folder for the days, or one of earlier days of the same "
        "run to go on with", subtype="DIR_PATH", options=set(),
    )  # fmt: skip
    days: IntProperty(
        name="Days", description="How many days are run, from the first day on", default=1, min=1,
        soft_max=31, options=set(),
    )  # fmt: skip
    formats: EnumProperty(
        name="Also for Other Tools", description="Formats that are written beside the tables",
        items=FORMAT_ITEMS, options={"ENUM_FLAG"},
    )  # fmt: skip
    done: CollectionProperty(type=AngenDone)
    active: IntProperty(options=set())
    # The activity that is shown: `active` is the chosen row of the list.
    shown: IntProperty(options={"HIDDEN"})
    time: StringProperty(
        name="Time", description="A time of the day to go to, as 07:00", default="07:00",
        options=set(),
    )  # fmt: skip
    skip: BoolProperty(
        name="Skip Rest", description="Playback jumps over the time in which nothing moves",
        default=True, options=set(),
    )  # fmt: skip
    # The frames of the shown stretch in which nothing moves (still.py).
    rests: StringProperty(options={"HIDDEN"})
    told: StringProperty(options={"HIDDEN"})
    before: StringProperty(options={"HIDDEN"})


_register, _unregister = bpy.utils.register_classes_factory((AngenSite, AngenDone, AngenDay))


def register() -> None:
    _register()
    bpy.types.Scene.angen_site = PointerProperty(type=AngenSite)
    bpy.types.Scene.angen_day = PointerProperty(type=AngenDay)


def unregister() -> None:
    del bpy.types.Scene.angen_day, bpy.types.Scene.angen_site
    _unregister()
