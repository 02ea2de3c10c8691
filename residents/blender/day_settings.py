# SPDX-License-Identifier: GPL-3.0-or-later
"""Properties of a scene: where on Earth the home is, and the day shown in the panel Day."""

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
from bpy.types import ID, Action, Material, Object, PropertyGroup, Text

from ...angen_addon.relative_path import RELATIVE_PATH
from ...sensor_logic.logs.formats import FORMATS

# Bits of the formats as stored in blend files: never renumber them.
BITS = {
    name: 1 << k
    for k, name in enumerate(
        ("casas", "casas-csv", "pyadlml", "mcap", "xes", "ocel", "influx", "home-assistant",
         "parquet")
    )
}  # fmt: skip
FORMAT_ITEMS = [
    (name, name, FORMATS[name].tip, "NONE", bit)
    for name, bit in BITS.items()
    if FORMATS[name].is_installed
]


class AngenSite(PropertyGroup):
    """The place on Earth; the sun follows date and hour if latitude and longitude are set."""

    latitude: FloatProperty(
        name="Latitude", description="North is positive", subtype="ANGLE",
        min=-math.pi / 2, max=math.pi / 2, precision=3, options=set(),
    )  # fmt: skip
    longitude: FloatProperty(
        name="Longitude", description="East is positive", subtype="ANGLE",
        min=-math.pi, max=math.pi, precision=3, options=set(),
    )  # fmt: skip
    utc_offset: FloatProperty(
        name="Ahead of UTC", description="Offset of the home's clocks in hours, the same all year",
        min=-14.0, max=14.0, precision=2, options=set(),
    )  # fmt: skip
    north: FloatProperty(
        name="North", description="Angle from the home's +Y to north, counter-clockwise "
        "seen from above", subtype="ANGLE", options=set(),
    )  # fmt: skip


class AngenDone(PropertyGroup):
    """An activity in the list of the panel Day; times in s since midnight."""

    person: StringProperty()
    room: StringProperty()
    start: FloatProperty()
    end: FloatProperty()
    # The activity's place in the routine, which decides its colour.
    place: IntProperty()


class AngenEarlier(PropertyGroup):
    """A datablock as it was before a day was shown: its action, and other values as JSON.

    `owner` is a datablock. If `of_data` is set, the values are of the object's light; if `of_tree`
    is set, of the node tree of that light, material or world. Pointers know datablocks by identity,
    also after saving.
    """

    owner: PointerProperty(type=ID)
    of_data: BoolProperty()
    of_tree: BoolProperty()
    action: PointerProperty(type=Action)
    values: StringProperty()


class AngenLent(PropertyGroup):
    """A copy of a light or material that a lamp has while a day is shown, as `lamps.Lent`."""

    object: PointerProperty(type=Object)
    original: PointerProperty(type=ID)
    copy: PointerProperty(type=ID)
    link: StringProperty()
    before: PointerProperty(type=Material)


class AngenDay(PropertyGroup):
    """Settings and state of the panel Day.

    While an activity is shown, `before` is the earlier state of the scene, as JSON, and `earlier`
    and `lent` are the earlier state of the home.
    """

    routine: StringProperty(
        name="Routine", description="Routine file", subtype="FILE_PATH", options=RELATIVE_PATH
    )
    text: PointerProperty(
        name="Text",
        description="Routine in a text of this blend file, instead of a file",
        type=Text,
    )
    date: StringProperty(
        name="First Day", description="Date of the first day, such as 2026-03-02",
        default="2026-03-02", options=set(),
    )  # fmt: skip
    number: IntProperty(
        name="Day", description="Number of the day to read, counted from the first",
        default=1, min=1, soft_max=31, options=set(),
    )  # fmt: skip
    seed: IntProperty(
        name="Seed", description="Seed of all random draws of the routine", min=0, options=set()
    )
    out: StringProperty(
        name="Folder", description="New folder for the days; or the folder of an earlier run with "
        "the same settings, to continue it", subtype="DIR_PATH", options=RELATIVE_PATH,
    )  # fmt: skip
    days: IntProperty(
        name="Days", description="Number of days to run, from the first day on", default=1, min=1,
        soft_max=31, options=set(),
    )  # fmt: skip
    formats: EnumProperty(
        name="Also for Other Tools", description="Formats of other tools to write in addition to "
        "the tables",
        items=FORMAT_ITEMS, options={"ENUM_FLAG"},
    )  # fmt: skip
    done: CollectionProperty(type=AngenDone)
    active: IntProperty(options=set())
    # `active` is the chosen row of the list, `shown` the activity that is animated.
    shown: IntProperty(options={"HIDDEN"})
    time: StringProperty(
        name="Time", description="Time of the day to go to, such as 07:00", default="07:00",
        options=set(),
    )  # fmt: skip
    skip: BoolProperty(
        name="Skip Rest", description="During playback, skip times in which nothing moves",
        default=True, options=set(),
    )  # fmt: skip
    # The frames of the shown stretch in which nothing moves (still.py).
    rests: StringProperty(options={"HIDDEN"})
    told: StringProperty(options={"HIDDEN"})
    # The list's own number, the settings with which it was read, and the home's fingerprint.
    mark: IntProperty(options={"HIDDEN"})
    read_with: StringProperty(options={"HIDDEN"})
    followed: StringProperty(options={"HIDDEN"})
    before: StringProperty(options={"HIDDEN"})
    earlier: CollectionProperty(type=AngenEarlier)
    lent: CollectionProperty(type=AngenLent)


_register, _unregister = bpy.utils.register_classes_factory(
    (AngenSite, AngenDone, AngenEarlier, AngenLent, AngenDay)
)


def register() -> None:
    _register()
    bpy.types.Scene.angen_site = PointerProperty(type=AngenSite)
    bpy.types.Scene.angen_day = PointerProperty(type=AngenDay)


def unregister() -> None:
    del bpy.types.Scene.angen_day, bpy.types.Scene.angen_site
    _unregister()
