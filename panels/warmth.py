# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels of surface temperatures for pyroelectric detectors (Physics, Material, Collection)."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.types import Context, Menu, Panel

from ..angen_addon.advice import warmth
from ..angen_addon.appearance.panel_parts import (
    Helped,
    PhysicsTab,
    draw_property,
    draw_row,
    has_name_column,
)
from ..angen_addon.scene.rays.geometry import SURFACE_TYPES, evaluated_materials
from ..angen_addon.scene.surfaces.warmth import (
    OwnWarmth,
    collection_parents,
    inherited_warmth,
    kelvin,
    own_warmth,
)
from ..operators.warmth import ANGEN_OT_warmth_set
from ..sensor_logic.logs.wording import ZERO_CELSIUS


class ANGEN_MT_warmth(Menu):
    bl_idname = "ANGEN_MT_warmth"
    bl_label = "Set Usual"
    bl_description = "Give the selected objects a usual temperature"

    def draw(self, context: Context) -> None:
        for usual in warmth.USUAL.values():
            item = self.layout.operator(ANGEN_OT_warmth_set.bl_idname, text=usual.label)
            item.sort = usual.identifier


class _Warmth(Helped):
    bl_label = "Temperature"
    help_page = "pir"
    bl_options = {"DEFAULT_CLOSED"}
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"

    layout: Any

    @staticmethod
    def owner(context: Context) -> Any:
        raise NotImplementedError

    @classmethod
    def poll(cls, context: Context) -> bool:
        return cls.owner(context) is not None

    def draw_header(self, context: Context) -> None:
        owner = self.owner(context)
        self.layout.prop(owner.angen_warmth, "use_temperature", text="")

    def draw(self, context: Context) -> None:
        draw_warmth(self.layout, self.owner(context))


class ANGEN_PT_physics_warmth(PhysicsTab, _Warmth, Panel):
    @staticmethod
    def owner(context: Context) -> Any:
        obj = context.object
        return obj if obj is not None and obj.type in SURFACE_TYPES | {"ARMATURE"} else None

    def draw(self, context: Context) -> None:
        obj, layout = context.object, self.layout
        if obj.type in SURFACE_TYPES:
            draw_warmth(layout, obj)
        layout.menu(ANGEN_MT_warmth.bl_idname)
        if obj.type in SURFACE_TYPES:
            _draw_inherited(layout, obj)
        column = layout.column()
        column.use_property_split = has_name_column()
        scene = context.scene
        draw_property(column, scene, scene, "angen_ambient_temperature", "Ambient", "°C")
        column.prop(scene, "angen_warmth_left")


class ANGEN_PT_material_warmth(_Warmth, Panel):
    bl_context = "material"

    @staticmethod
    def owner(context: Context) -> Any:
        return context.material


class ANGEN_PT_collection_warmth(_Warmth, Panel):
    bl_context = "collection"

    @staticmethod
    def owner(context: Context) -> Any:
        collection = context.collection
        return None if collection == context.scene.collection else collection


def draw_warmth(layout: Any, owner: Any) -> None:
    """Draw temperature, insulation and emissivity of an object, material or collection."""
    column = layout.column()
    column.use_property_split = has_name_column()
    column.active = owner.angen_warmth.use_temperature
    warmth, scene = owner.angen_warmth, bpy.context.scene
    covered = warmth.insulation > 0.0
    draw_property(column, scene, warmth, "temperature", "Skin" if covered else "Surface", "°C")
    column.prop(warmth, "insulation")
    found = own_warmth(owner)
    if covered and found is not None:
        draw_row(column, "Surface", _surface_text(found, scene))
    column.prop(warmth, "emissivity")


def _surface_text(found: OwnWarmth, scene: Any) -> str:
    """Return the temperature of a surface in the scene's ambient temperature, with its unit."""
    celsius = found.surface(kelvin(scene.angen_ambient_temperature)) - ZERO_CELSIUS
    return f"{celsius:.1f} °C"


def _draw_inherited(layout: Any, obj: Any) -> None:
    """Draw which materials, or which collection, set the object's temperature."""
    scene = bpy.context.scene
    for material in evaluated_materials(obj):
        found = None if material is None else own_warmth(material)
        if found is not None:
            text = f"Material '{material.name}': {_surface_text(found, scene)}"
            layout.label(text=text, icon="MATERIAL")
    if not obj.angen_warmth.use_temperature:
        inherited = inherited_warmth(obj, collection_parents())
        if inherited is not None:
            text = f"As its collection: {_surface_text(inherited, scene)}"
            layout.label(text=text, icon="OUTLINER_COLLECTION")


register, unregister = bpy.utils.register_classes_factory(
    (
        ANGEN_MT_warmth,
        ANGEN_PT_physics_warmth,
        ANGEN_PT_material_warmth,
        ANGEN_PT_collection_warmth,
    )
)
