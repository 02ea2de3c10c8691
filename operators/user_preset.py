# SPDX-License-Identifier: GPL-3.0-or-later
"""The user's presets, which Blender's preset system stores in presets/angen_sensors/KIND.

A preset is a Python file with a line for each parameter. This module parses the file and does not
run it. A file of an earlier version can set parameters that no longer exist.
"""

from __future__ import annotations

import ast
from pathlib import Path
from typing import Any

import bpy
from bl_operators.presets import AddPresetBase
from bpy.props import StringProperty
from bpy.types import Context, Operator

from ..angen_addon.authoring.presets import SAME_KIND_OF_VALUE
from ..angen_addon.scene.instances import stands_for
from ..angen_addon.translations.interface import translated
from ..sensor_logic.kind import Kind
from ..sensor_logic.kinds import KINDS
from ..sensor_logic.parameters import former_choice, former_text, specs
from .polls import can_change_sensor, cancelled, has_sensor

OWNER = "settings"


def folder_of(kind: Kind) -> str:
    """Return the folder of the presets for a kind, relative to Blender's preset folders."""
    return f"angen_sensors/{kind.attribute}"


def user_presets(kind: Kind) -> list[Path]:
    """Return the files of the user's presets for a kind of sensor, sorted by name."""
    folders = (Path(folder) for folder in bpy.utils.preset_paths(folder_of(kind)))
    return sorted(
        (file for folder in folders for file in folder.glob("*.py")), key=lambda f: f.name
    )


def label_of(file: Path) -> str:
    return bpy.path.display_name(file.name, title_case=False)


def values_in(file: Path) -> dict[str, Any]:
    """Return the parameter values in a preset's file, by parameter name.

    Raise `OSError` if the file cannot be read, and `ValueError` if it is no preset.
    """
    values: dict[str, Any] = {}
    try:
        statements = ast.parse(file.read_text(encoding="utf-8")).body
    except SyntaxError as error:
        raise ValueError(
            f"line {error.lineno} is not valid Python, in which Blender writes presets"
        ) from error
    for statement in statements:
        match statement:
            case ast.Assign(targets=[ast.Attribute(value=ast.Name(id=owner), attr=name)]):
                if owner == OWNER:
                    values[name] = ast.literal_eval(statement.value)
    return values


class ANGEN_OT_user_preset_save(AddPresetBase, Operator):
    bl_idname = "angen.user_preset_save"
    bl_label = "Save Preset"
    bl_description = "Save the active sensor's parameters as a preset of its kind, or remove one"
    preset_menu = "ANGEN_MT_presets"

    @classmethod
    def description(cls, context: Context, properties: Any) -> str:
        if properties.remove_name:
            return translated(f"Remove the preset '{properties.name}'")
        return translated(
            "Save the active sensor's parameters as a preset of its kind, for every file"
        )

    poll = classmethod(has_sensor)

    @property
    def _kind(self) -> Kind:
        return KINDS[stands_for(bpy.context.object).angen_sensor.kind]

    # For Blender's preset system

    @property
    def preset_subdir(self) -> str:
        return folder_of(self._kind)

    @property
    def preset_defines(self) -> list[str]:
        return [f"{OWNER} = bpy.context.object.angen_sensor.{self._kind.attribute}"]

    @property
    def preset_values(self) -> list[str]:
        """The names of the parameters to save: all except pointers to objects of the open file."""
        known = specs(self._kind.parameters)
        return [f"{OWNER}.{name}" for name, spec in known.items() if not spec.pointer]

    def execute(self, context: Context) -> set[str]:
        removed, name = self.remove_name, self.name.strip()
        if not self.as_filename(name):
            return cancelled(self, "Give the preset a name")
        # Blender's preset system reads the values of the context's object.
        with context.temp_override(object=stands_for(context.object)):
            result = super().execute(bpy.context)
        # Blender shows the last saved preset as the menu's name.
        getattr(bpy.types, self.preset_menu).bl_label = "Presets"
        if result == {"FINISHED"}:
            text = f"Removed the preset '{name}'" if removed else f"Saved the preset '{name}'"
            self.report({"INFO"}, translated(text))
        elif removed:
            self.report({"ERROR"}, translated(f"You have no preset '{name}'"))
        return result


class ANGEN_OT_user_preset_apply(Operator):
    bl_idname = "angen.user_preset_apply"
    bl_label = "Apply Own Preset"
    bl_description = "Set the active sensor's parameters to those of one of your presets"
    bl_options = {"REGISTER", "UNDO"}

    name: StringProperty(name="Name", description="Name of a preset of the sensor's kind")

    poll = classmethod(can_change_sensor)

    def execute(self, context: Context) -> set[str]:
        obj = stands_for(context.object)
        kind = KINDS[obj.angen_sensor.kind]
        files = {label_of(file): file for file in user_presets(kind)}
        if self.name not in files:
            hint = f"there are {', '.join(files)}" if files else "none is saved"
            return cancelled(self, f"No preset of '{kind.label}' is called '{self.name}': {hint}")
        try:
            values = values_in(files[self.name])
        except (OSError, ValueError) as error:
            return cancelled(self, f"The preset '{self.name}' cannot be read: {error}")
        former = _replace_former(obj, kind, values)
        unknown = _set_known(getattr(obj.angen_sensor, kind.attribute), kind, values)
        obj.angen_sensor.preset = ""
        if unknown:
            self.report(
                {"WARNING"},
                translated(
                    "These parameters do not exist in this version and were left "
                    f"out: {', '.join(unknown)}"
                ),
            )
        else:
            done = f"'{obj.name}' is set to: {self.name}"
            self.report({"INFO"}, translated("; ".join(filter(None, (done, former)))))
        return {"FINISHED"}


def _replace_former(obj: Any, kind: Kind, values: dict[str, Any]) -> str:
    """Replace choices in `values` that only earlier versions knew by their present equivalents.

    Return a text that lists the replacements; empty if there are none.
    """
    known = specs(kind.parameters)
    pairs = [(name, former_choice(known[name], values[name])) for name in values if name in known]
    found = [(obj.name, name, former) for name, former in pairs if former is not None]
    values |= {name: former.now for _, name, former in found}
    return former_text(found)


def _set_known(group: Any, kind: Kind, values: dict[str, Any]) -> list[str]:
    """Set the values that this version knows, and return the names of the other values."""
    known, unknown = specs(kind.parameters), []
    for name, value in values.items():
        spec = known.get(name)
        of_type = SAME_KIND_OF_VALUE.get(type(getattr(group, name, None)), ())
        choices = [choice.identifier for choice in spec.choices] if spec else []
        if not isinstance(value, of_type) or (choices and value not in choices):
            unknown.append(name)
        else:
            setattr(group, name, value)
    return unknown


register, unregister = bpy.utils.register_classes_factory(
    (ANGEN_OT_user_preset_save, ANGEN_OT_user_preset_apply)
)
