# SPDX-License-Identifier: GPL-3.0-or-later
"""Add sensors, and apply presets, which have the parameters of commercial parts."""

from __future__ import annotations

import math
from typing import Any

import bpy
from bpy.types import Context

from ...sensor_logic.kind import Kind, Preset
from ...sensor_logic.kinds import KINDS
from ...sensor_logic.logs.error import AngenError
from ..appearance.housing import housing_mesh
from ..scene.sensors import unit_scale
from .of_kind import housing_of

# Relative tolerance of values, since Blender stores single precision.
SAME = 1e-6
# By the type of a parameter: the types of values that it accepts.
SAME_KIND_OF_VALUE: dict[type, tuple[type, ...]] = {
    bool: (bool,), int: (int,), float: (int, float), str: (str,)
}  # fmt: skip


def find_preset(kind: Kind, identifier: str) -> Preset:
    """Return the preset of a kind with this identifier. Raise `AngenError` if there is none."""
    known = {preset.identifier: preset for preset in kind.presets}
    if identifier not in known:
        hint = f"choose one of {', '.join(known)}" if known else "this kind has no presets"
        raise AngenError(f"No preset of '{kind.label}' is called '{identifier}': {hint}")
    return known[identifier]


def apply(obj: Any, preset: Preset) -> None:
    """Set the parameters, and the rate, for which the preset has values; leave the others."""
    group = getattr(obj.angen_sensor, KINDS[obj.angen_sensor.kind].attribute)
    for name, value in preset.values.items():
        setattr(group, name, value)
    if preset.rate:
        obj.angen_sensor.update_rate = preset.rate
    obj.angen_sensor.preset = preset.identifier


def is_applied(obj: Any, preset: Preset) -> bool:
    """Return whether the parameters and the rate of a sensor have the values of the preset."""
    group = getattr(obj.angen_sensor, KINDS[obj.angen_sensor.kind].attribute)
    if preset.rate and not _same(obj.angen_sensor.update_rate, preset.rate):
        return False
    return all(_same(getattr(group, name), value) for name, value in preset.values.items())


def preset_of(obj: Any) -> tuple[Preset | None, bool]:
    """Return the preset of a sensor or None, and whether its values were edited since.

    If the edited values match other presets, return the one that sets the most parameters, and
    False.
    """
    settings = obj.angen_sensor
    presets = KINDS[settings.kind].presets
    named = next((p for p in presets if p.identifier == settings.preset), None)
    if named is not None and is_applied(obj, named):
        return named, False
    matching = [preset for preset in presets if is_applied(obj, preset)]
    best = max(matching, key=lambda preset: len(preset.values), default=None)
    return (best, False) if best is not None else (named, named is not None)


def preset_text(obj: Any) -> str:
    """Return the name of a sensor's preset, followed by "(edited)" if a value was edited.

    The text is empty if the sensor has no preset.
    """
    found, is_edited = preset_of(obj)
    if found is None:
        return ""
    # Fields in panels are narrow, so the part of the name in brackets is left out.
    return f"{found.label.partition(' (')[0]} (edited)" if is_edited else found.label


def _same(stored: Any, value: Any) -> bool:
    if isinstance(value, float):
        return math.isclose(stored, value, rel_tol=SAME, abs_tol=1e-12)
    return bool(stored == value)


def select_only(context: Context, *objects: Any) -> None:
    """Select these objects and no others; the first becomes the active object."""
    # `context.selected_objects` needs a window, and a file that a script saved can have none.
    for other in list(context.view_layer.objects.selected):
        other.select_set(False)
    for obj in objects:
        obj.select_set(True)
    context.view_layer.objects.active = objects[0]


def new_sensor(context: Context, kind: str, preset: Preset | None, name: str = "") -> Any:
    """Add a sensor at the origin, in the active collection, select it and return its object.

    `kind` is the identifier of the kind. The sensor becomes the active object.
    """
    label = KINDS[kind].label.partition(" (")[0]
    housing = housing_of(kind, preset.identifier if preset else "")
    mesh = housing_mesh(housing, label, unit_scale(context.scene))
    sensor = bpy.data.objects.new(name or label, mesh)
    sensor.angen_sensor.kind = kind
    if preset is not None:
        apply(sensor, preset)
    context.collection.objects.link(sensor)
    select_only(context, sensor)
    return sensor
