# SPDX-License-Identifier: GPL-3.0-or-later
"""The marks on objects: what residents do there, and how doors open."""

from __future__ import annotations

import math
from typing import Any

import bpy
from bpy.props import (
    BoolProperty,
    EnumProperty,
    FloatProperty,
    PointerProperty,
    StringProperty,
)
from bpy.types import Context, Object

from ....sensor_logic.residents import places as known
from ...scene.door_motion import MOTIONS
from ...scene.lengths import OVERRIDABLE, property_group
from ...scene.rooms import known_rooms
from .guess import guess

NONE = "NONE"
USES = [
    (NONE, "None", "Residents do nothing with it", "NONE", 0),
    (known.STAND, "Stand", "One stands there", "USER", 1),
    (known.SIT, "Sit", "One sits on it", "ASSET_MANAGER", 2),
    (known.LIE, "Lie", "One lies on it", "MOD_CLOTH", 3),
    (known.USE, "Use", "One stands before it and does something with the hands", "VIEW_PAN", 4),
    (known.DOOR, "Door", "A leaf, which is opened on the way and closed behind", "MOD_ARRAY", 5),
    (known.LAMP, "Lamp", "It is switched on and off", "LIGHT", 6),
    (known.TAP, "Tap", "Water is taken there", "MOD_FLUIDSIM", 7),
    (known.APPLIANCE, "Appliance", "It is used standing before it", "PREFERENCES", 8),
    (known.DRAWER, "Drawer", "It is pulled out and pushed in", "REMOVE", 9),
    (known.CURTAIN, "Curtain", "It is drawn aside along its width", "MOD_OPACITY", 10),
]
LABELS = {identifier: label for identifier, label, *_ in USES}
# What has a distance from which it is used.
BEFORE = (known.USE, known.TAP, known.APPLIANCE, known.DRAWER)


def _use_changed(self: Any, context: Context) -> None:
    obj = self.id_data
    if self.use != NONE and not obj.library and obj.name in context.view_layer.objects:
        guess(obj, context.evaluated_depsgraph_get())


MARK = property_group(
    "AngenPlace",
    {
        "use": EnumProperty(
            name="Use", description="What residents do there", items=USES, update=_use_changed
        ),
        "room": StringProperty(
            name="Room",
            description="The room that it is in; empty: guessed from the sensors around it",
            search=known_rooms,
            search_options={"SUGGESTION"},
        ),
        "facing": FloatProperty(
            name="Facing",
            description="Where one looks who sits, stands or works there, or where the head lies: "
            "about the object's own Z, from its front (-Y) on",
            subtype="ANGLE",
        ),
        "away": FloatProperty(
            name="Distance",
            description="From its front to whoever uses it; 0: as near as there is room",
            subtype="DISTANCE",
            min=0.0,
            soft_max=2.0,
        ),
        "motion": EnumProperty(name="Motion", description="How the leaf moves", items=MOTIONS),
        "other_side": BoolProperty(
            name="Other Side",
            description="It opens to the other side, or slides to the other end",
        ),
        "angle": FloatProperty(
            name="Opens by",
            description="How far the leaf turns from shut to open",
            subtype="ANGLE",
            default=math.radians(90),
            min=0.0,
            max=math.pi,
        ),
        "slide": FloatProperty(
            name="Slides by",
            description="How far it slides; 0: nearly its own width, or its depth",
            subtype="DISTANCE",
            min=0.0,
            soft_max=3.0,
        ),
        "entrance": BoolProperty(name="Entrance", description="Residents come and go by this door"),
        "switch": PointerProperty(
            name="Switch",
            description="The object, such as an empty on a wall, where a hand switches the lamp; "
            "without one at the lamp itself, or, above 2.2 m, from anywhere",
            type=Object,
            options={"ANIMATABLE"},
        ),
    },
    options=set(),
    override=OVERRIDABLE,
)


def marked(view_layer: Any) -> list[Any]:
    """The objects with a mark, by name."""
    found = [obj for obj in view_layer.objects if obj.angen_place.use != NONE]
    return sorted(found, key=lambda obj: obj.name)


_register, _unregister = bpy.utils.register_classes_factory((MARK,))


def register() -> None:
    _register()
    Object.angen_place = PointerProperty(type=MARK, override=OVERRIDABLE)


def unregister() -> None:
    del Object.angen_place
    _unregister()
