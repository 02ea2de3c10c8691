# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels of the properties that kinds of sensor need of objects (Physics) and of materials."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.types import Context, Panel

from ..angen_addon.appearance.help import GROUP_PAGES
from ..angen_addon.appearance.panel_parts import Helped, PhysicsTab, has_name_column
from ..angen_addon.scene.rays.geometry import SURFACE_TYPES
from ..angen_addon.scene.surfaces.echoes import BREATHING
from ..sensor_logic.kind import OwnerProperties
from ..sensor_logic.kinds import owner_properties
from ..sensor_logic.parameters import specs
from ..sensor_logic.use import IN_USE
from .parameters import draw_parameters

CONTEXTS = {"Object": "physics", "Material": "material"}


class _OwnerPanel(Helped):
    """Draws the properties `made` of the owner of type `owner_type`."""

    bl_options = {"DEFAULT_CLOSED"}
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"

    layout: Any
    made: OwnerProperties
    owner_type: str

    @classmethod
    def poll(cls, context: Context) -> bool:
        if cls.owner_type == "Material":
            return context.material is not None
        if context.object is None or cls.made is IN_USE:
            # A lamp, or an empty that marks a place, can be in use too.
            return context.object is not None
        # Of a body with an armature, the armature can have the breathing, but no substance.
        types = SURFACE_TYPES | ({"ARMATURE"} if cls.made.attribute == BREATHING else set())
        return context.object.type in types

    def draw(self, context: Context) -> None:
        owner = context.material if self.owner_type == "Material" else context.object
        column = self.layout.column()
        column.use_property_split = has_name_column()
        known = specs(self.made.parameters)
        units = {name: spec.unit for name, spec in known.items()}
        group = getattr(owner, self.made.attribute)
        if not has_name_column():
            # Its name would be cut; the panel's title says it.
            first = next(iter(units))
            del units[first]
            column.prop(group, first, text="")
        draw_parameters(column, context.scene, group, known, units)


def _panel(made: OwnerProperties, owner_type: str) -> type:
    """Return the class of the panel of some properties for a type of owner."""
    return type(
        f"ANGEN_PT_{owner_type.lower()}_{made.attribute.removeprefix('angen_')}",
        (PhysicsTab, _OwnerPanel, Panel) if owner_type == "Object" else (_OwnerPanel, Panel),
        {
            "bl_label": made.label,
            "bl_description": made.tip,
            "bl_context": CONTEXTS[owner_type],
            "help_page": GROUP_PAGES[made.attribute],
            "made": made,
            "owner_type": owner_type,
        },
    )


register, unregister = bpy.utils.register_classes_factory(
    [_panel(made, name) for name in CONTEXTS for made in owner_properties(name)]
)
