# SPDX-License-Identifier: GPL-3.0-or-later
"""`obj.angen_resident`: who an armature is in the routines of days."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.props import EnumProperty, FloatProperty, PointerProperty
from bpy.types import Object, PropertyGroup

from ...sensor_logic.residents.body.build import SKELETON_STATURE, USUAL, Build, Sort
from .person import LABELS, body_of

NO_RESIDENT = "NONE"
_TIPS = {
    Sort.OLDER_ADULT: "Walks slowly, with short steps and a bent back",
    Sort.ADULT: "A grown-up person",
    Sort.CHILD: "A child of about seven",
    Sort.CAT: "Walks on four legs; sits and lies",
}
SORT_ITEMS = [
    (sort.value, LABELS[sort], _TIPS[sort], number)
    for number, sort in enumerate((Sort.OLDER_ADULT, Sort.ADULT, Sort.CHILD, Sort.CAT), 1)
]


def _metres() -> float:
    return float(bpy.context.scene.unit_settings.scale_length)


def _sort_of(group: Any) -> Sort:
    return Sort(group.sort) if group.sort != NO_RESIDENT else Sort.ADULT


def _get_stature(group: Any) -> float:
    return float(group.id_data.scale[2]) * _metres() * SKELETON_STATURE[_sort_of(group)]


def _set_stature(group: Any, stature: float) -> None:
    size = stature / SKELETON_STATURE[_sort_of(group)] / _metres()
    group.id_data.scale = (size, size, size)


def _get_mass(group: Any) -> float:
    body = body_of(group.id_data)
    return float(body.angen_load.mass) if body is not None else 0.0


def _set_mass(group: Any, mass: float) -> None:
    body = body_of(group.id_data)
    if body is not None:
        body.angen_load.mass = mass


class ANGEN_PG_resident(PropertyGroup):
    sort: EnumProperty(
        name="Sort",
        description="What the resident is: how it is built and moves",
        items=[
            (NO_RESIDENT, "No Resident", "Moved by its own animation only", 0),
            *SORT_ITEMS,
        ],
    )
    speed: FloatProperty(
        name="Speed",
        description="How fast it usually walks; with it go the lengths of its steps",
        default=1.1, min=0.05, soft_min=0.3, soft_max=1.6, unit="VELOCITY",
    )  # fmt: skip
    stature: FloatProperty(
        name="Stature",
        description="Height of the body (of a cat: of its back): the scale of the armature",
        get=_get_stature, set=_set_stature, min=0.05, soft_max=2.2, precision=3, unit="LENGTH",
    )  # fmt: skip
    mass: FloatProperty(
        name="Mass",
        description="What the body weighs on pressure pads: the mass of its mesh",
        get=_get_mass, set=_set_mass, min=0.0, soft_max=150.0, unit="MASS",
    )  # fmt: skip
    walking_frame: PointerProperty(
        name="Walking Frame",
        description="What the resident pushes before it as it walks, both hands on it",
        type=Object,
    )


def is_resident(obj: Any) -> bool:
    return obj is not None and obj.type == "ARMATURE" and obj.angen_resident.sort != NO_RESIDENT


def residents_in(scene: Any) -> list[Any]:
    """The armatures of all residents of a scene, by name."""
    return sorted(filter(is_resident, scene.objects), key=lambda obj: obj.name)


def build_of(obj: Any) -> Build:
    """The body of a resident's armature. Raises ValueError where it is none."""
    if not is_resident(obj):
        raise ValueError(f"'{obj.name}' is no resident: add one with Shift+A, Sensor, Resident")
    settings = obj.angen_resident
    return Build(
        Sort(settings.sort), settings.stature, settings.mass, settings.speed,
        settings.walking_frame is not None,
    )  # fmt: skip


def make_resident(obj: Any, sort: Sort) -> None:
    """The usual settings of a sort for an armature with a body."""
    usual, settings = USUAL[sort], obj.angen_resident
    settings.sort = sort.value
    settings.stature, settings.mass, settings.speed = usual.stature, usual.mass, usual.speed


_register, _unregister = bpy.utils.register_classes_factory((ANGEN_PG_resident,))


def register() -> None:
    _register()
    Object.angen_resident = PointerProperty(type=ANGEN_PG_resident)


def unregister() -> None:
    del Object.angen_resident
    _unregister()
