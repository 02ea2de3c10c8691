# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels of an animated object's weight on pressure sensors (Physics tab and sidebar)."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import bpy
from bpy.types import Context, Panel

from ..angen_addon.advice import sensing
from ..angen_addon.advice.sensing import may_be_simulated
from ..angen_addon.appearance.help import draw_help
from ..angen_addon.appearance.panel_parts import (
    PhysicsTab,
    Sidebar,
    draw_lines,
    draw_property,
    has_name_column,
)
from ..angen_addon.scene.bearers import bearer, candidates, has_mass
from ..angen_addon.scene.instances import is_sensor
from ..angen_addon.scene.sensors import unit_scale
from ..angen_addon.scene.units import kilograms
from ..sensor_logic.logs.wording import named

NAMES_SHOWN = 3


class _Weight:
    bl_label = "Weight on Sensors"
    help_page = "pressure"
    bl_options = {"DEFAULT_CLOSED"}
    layout: Any

    @classmethod
    def poll(cls, context: Context) -> bool:
        return context.object is not None and context.object.type in sensing.BEARER_TYPES

    def draw_header_preset(self, context: Context) -> None:
        # In a narrow region the mass would cover the panel's name.
        if context.object.angen_load.mass > 0.0 and has_name_column():
            self.layout.label(text=f"{context.object.angen_load.mass:g} kg")
        draw_help(self.layout, self.help_page)

    def draw(self, context: Context) -> None:
        """Draw mass and tolerance of the active object, an explanation of both, and warnings."""
        layout, obj = self.layout, context.object
        column = layout.column()
        column.use_property_split = has_name_column()
        scene = context.scene
        draw_property(column, scene, obj.angen_load, "mass", "Mass", "kg")
        held = column.column()
        held.active = has_mass(obj)
        draw_property(held, scene, obj.angen_load, "tolerance", "Tolerance", "m")
        if may_be_simulated(obj):
            _draw_simulated(layout, scene, obj)
        elif has_mass(obj):
            _draw_weighed(layout, obj, context.view_layer)
        else:
            _draw_without(layout, obj, context.view_layer)


def _draw_simulated(layout: Any, scene: Any, obj: Any) -> None:
    mass = f"{kilograms(obj.rigid_body, unit_scale(scene)):g} kg"
    if has_mass(obj):
        text = (
            "It is an active rigid body, but with this mass it counts as animated, not simulated. "
            f"Set the mass to 0: its rigid body weighs {mass} already"
        )
        draw_lines(layout, text, "ERROR")
    else:
        text = (
            f"It is an active rigid body and weighs {mass} already (Rigid Body, Mass). A mass here "
            "would make it count as animated"
        )
        draw_lines(layout, text, "INFO")


def _draw_weighed(layout: Any, obj: Any, view_layer: Any) -> None:
    weighed = sensing.weighed_with(obj, view_layer)
    if weighed.surfaces:
        names = _names(weighed.surfaces)
        draw_lines(
            layout,
            f"The weight presses where these surfaces touch something below: {names}",
            "INFO",
        )
    else:
        text = (
            "This mass weighs on nothing: the object and its children have no visible surface, or "
            "each surface has its own mass or is ignored by sensors"
        )
        draw_lines(layout, text, "ERROR")
    bearers = [other for _, other in weighed.apart] if weighed.surfaces else []
    if obj in weighed.surfaces:
        # Parents with a mass count too: it is the mass of their other surfaces.
        bearers += [
            other
            for other in list(candidates(obj))[1:]
            if has_mass(other) and sensing.weighed_with(other, view_layer).surfaces
        ]
    if bearers:
        text = f"Counted twice? {_names(bearers)} has a mass too, and both masses are added"
        draw_lines(layout, text, "ERROR")


def _draw_without(layout: Any, obj: Any, view_layer: Any) -> None:
    above = bearer(obj)
    if above is not None:
        mass = f"{above.angen_load.mass:g} kg"
        draw_lines(layout, f"Its weight is part of '{above.name}' ({mass})", "INFO")
        return
    weighed = sensing.weighed_with(obj, view_layer)
    texts = [
        "No weight. A mass here is meant for animated objects, such as a person or moved "
        "furniture, not for simulated ones"
    ]
    if weighed.surfaces:
        texts.append(f"The mass would be that of {_names(weighed.surfaces)}")
    if weighed.apart:
        bearers = _names(b for _, b in weighed.apart)
        texts.append(f"{bearers} on it has a mass already")
    draw_lines(layout, ". ".join(texts), "INFO")


def _names(objects: Iterable[Any]) -> str:
    return named(sorted(obj.name for obj in objects), NAMES_SHOWN)


class ANGEN_PT_physics_weight(_Weight, PhysicsTab, Panel):
    pass


class ANGEN_PT_sidebar_weight(_Weight, Sidebar, Panel):
    @classmethod
    def poll(cls, context: Context) -> bool:
        # A sensor seldom has a weight: the Physics tab is enough for it.
        return super().poll(context) and not is_sensor(context.object)


register, unregister = bpy.utils.register_classes_factory(
    (ANGEN_PT_physics_weight, ANGEN_PT_sidebar_weight)
)
