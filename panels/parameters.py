# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw the reading and parameters of a sensor of any kind in a panel."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from bpy.types import Context

from ..angen_addon.advice.sensing import unreachable
from ..angen_addon.appearance.appearance import appearance_of
from ..angen_addon.appearance.panel_parts import (
    draw_lines,
    draw_progress,
    draw_property,
    has_name_column,
)
from ..angen_addon.appearance.reading_text import ReadingText
from ..angen_addon.scene.instances import is_sensor
from ..angen_addon.scene.lengths import lengths_of
from ..angen_addon.scene.sensors import Sensor, check
from ..angen_addon.view.readings import reading_text
from ..sensor_logic.kinds import KINDS
from ..sensor_logic.logs.error import AngenError
from ..sensor_logic.parameters import Spec, is_chosen, label_of, specs


def sensor_of(obj: Any) -> Sensor | None:
    """Return the sensor that an object is, or None if the object is no sensor."""
    if not is_sensor(obj):
        return None
    return Sensor(obj.name, KINDS[obj.angen_sensor.kind], obj)


def draw_sensor(layout: Any, context: Context, sensor: Sensor) -> None:
    """Draw a sensor's reading, its warnings, and the parameters that its chosen model uses.

    `layout` must be as wide as the region, because Blender requires that for subpanels.
    """
    seen = reading_text(sensor, context.scene)
    # Operators drawn here act on the sensor, even if its housing is the active object.
    layout.context_pointer_set("object", sensor.object)
    layout.label(text=seen.text, icon=seen.icon, translate=False)
    enabled = sensor.settings.enabled
    if enabled:
        _draw_origin(layout, seen)
        if sensor.kind.requires_light and not seen.recorded:
            _draw_measure(layout)
        _draw_problem(layout, context.scene, sensor)
    appearance = appearance_of(sensor.kind)
    if enabled:
        appearance.details(layout, context, sensor, seen)
    sections = appearance.sections
    in_sections = {name for _, names in sections for name in names}
    others = [name for name in specs(sensor.kind.parameters) if name not in in_sections]
    column = _column(layout, enabled)
    column.prop(sensor.settings, "room", placeholder=sensor.room)
    scene = context.scene
    draw_property(column, scene, sensor.settings, "update_rate", "Rate", "Hz")
    _draw_sensor_parameters(column, scene, sensor, others)
    for number, (title, names) in enumerate(sections):
        header, body = layout.panel(
            f"ANGEN_{sensor.kind.identifier}_{number}", default_closed=number > 0
        )
        header.label(text=title)
        if body is not None:
            _draw_sensor_parameters(_column(body, enabled), scene, sensor, names)


def _draw_origin(layout: Any, texts: ReadingText) -> None:
    """Draw where the reading comes from, such as a recording, and the value of baked keyframes."""
    if texts.origin:
        row = layout.row()
        row.active = False
        row.label(text=texts.origin, icon="BLANK1", translate=False)
    if texts.old:
        draw_lines(layout, texts.old, "TIME")
    if texts.keys:
        text = (
            f"The baked keyframes have '{texts.keys}', which drivers read. Unbake removes the "
            "keyframes"
        )
        box = draw_lines(layout, text, "KEYFRAME_HLT")
        box.operator("angen.unbake_keyframes", icon="KEYFRAME").selected = True


def _draw_measure(layout: Any) -> None:
    column = layout.column()
    column.operator_context = "INVOKE_DEFAULT"
    if not draw_progress(column, "angen.measure_light"):
        column.operator("angen.measure_light", icon="LIGHT_SUN")


def _column(layout: Any, enabled: bool) -> Any:
    column = layout.column()
    column.use_property_split = has_name_column()
    column.use_property_decorate = True
    column.active = enabled
    return column


def _draw_sensor_parameters(column: Any, scene: Any, sensor: Sensor, names: Iterable[str]) -> None:
    known = specs(sensor.kind.parameters)
    group = sensor.parameters
    units = {name: sensor.kind.unit_of(known[name], group) for name in names}
    draw_parameters(column, scene, group, known, units)


def draw_parameters(
    column: Any, scene: Any, group: Any, known: Mapping[str, Spec], units: Mapping[str, str]
) -> None:
    """Draw the fields of a property group that its choices use.

    `known` describes all fields of the group. `units` has the unit of each field to draw, by name.
    """
    for name, unit in units.items():
        spec = known[name]
        # A parameter with only one choice needs no field.
        if is_chosen(group, spec.used_when) and len(spec.choices) != 1:
            label = label_of(spec, group, short=True)
            draw_property(column, scene, group, name, label, unit)


def _draw_problem(layout: Any, scene: Any, sensor: Sensor) -> None:
    lengths = lengths_of(scene)
    try:
        check(sensor, lengths)
    except AngenError as error:
        problem = str(error).removeprefix(f"'{sensor.name}': ")
        for name, spec in specs(sensor.kind.parameters).items():
            problem = problem.replace(name, label_of(spec, sensor.parameters, short=True))
        draw_lines(layout, problem, "ERROR")
        return
    for found in unreachable(sensor, lengths):
        draw_lines(layout, found.text, "ERROR")
