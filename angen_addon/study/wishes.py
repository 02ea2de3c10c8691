# SPDX-License-Identifier: GPL-3.0-or-later
"""What the panel *Study* collects, in Blender, until it is written into a file."""

from __future__ import annotations

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)
from bpy.types import PropertyGroup

from ...sensor_logic.study.targets import BETWEEN
from ...sensor_logic.study.writing import Vary


class AngenStudyVary(PropertyGroup):
    """A parameter of some sensors that is to vary; those with `choices` take all of them."""

    sensors: StringProperty()
    parameter: StringProperty()
    label: StringProperty()
    first: FloatProperty(name="From", description="Its first value", precision=3)
    last: FloatProperty(name="To", description="Its last value", precision=3)
    steps: IntProperty(name="Steps", description="How many values", default=3, min=2, soft_max=50)
    whole: BoolProperty()
    choices: StringProperty()


class AngenStudy(PropertyGroup):
    """`file`: the study that was written last, or is to be looked at."""

    varied: CollectionProperty(type=AngenStudyVary)
    seeds: IntProperty(
        name="Seeds", description="Runs of each setting, with other noise", default=1, min=1
    )
    file: StringProperty(
        name="Study", description="Its file; the report is in the folder of its name beside it",
        subtype="FILE_PATH",
    )  # fmt: skip


# Not methods: Blender 4.2 keeps classes of groups of properties, and what they lead to, for good.
def fill(row: AngenStudyVary, vary: Vary, label: str) -> None:
    row.name, row.label = vary.key, label
    row.sensors, row.parameter = BETWEEN.join(vary.sensors), vary.parameter
    row.first, row.last, row.whole = vary.first, vary.last, vary.whole
    row.choices = BETWEEN.join(map(str, vary.choices))


def vary_of(row: AngenStudyVary) -> Vary:
    choices = [
        {"True": True, "False": False}.get(choice, choice)
        for choice in row.choices.split(BETWEEN)
        if choice
    ]
    return Vary(
        row.sensors.split(BETWEEN),
        row.parameter,
        row.first,
        row.last,
        row.steps,
        row.whole,
        choices,
    )


_register, _unregister = bpy.utils.register_classes_factory((AngenStudyVary, AngenStudy))


def register() -> None:
    _register()
    bpy.types.WindowManager.angen_study = PointerProperty(type=AngenStudy)


def unregister() -> None:
    del bpy.types.WindowManager.angen_study
    _unregister()
