# SPDX-License-Identifier: GPL-3.0-or-later
"""The interface in other languages: every panel is translated, and its texts fit.

Blender as a Python module has one language, so that the language is set for the extension alone.
"""

import bpy
from bl_ext.user_default.angen_sensors.angen_addon.translations import interface

CONTEXT = interface.CONTEXT


def ours():
    """Return the extension's registered classes of the interface."""
    bases = bpy.types.Panel, bpy.types.Menu, bpy.types.Operator, bpy.types.PropertyGroup
    found = [cls for base in bases for cls in interface._below(base)]
    return [cls for cls in found if getattr(cls, "is_registered", False)]


def test_all_texts_have_the_context_of_the_extension():
    groups = [cls for cls in ours() if issubclass(cls, bpy.types.PropertyGroup)]
    assert len(groups) > 15 and len(ours()) > 100
    for cls in ours():
        if cls not in groups:
            assert cls.bl_rna.translation_context == CONTEXT or (
                cls.bl_translation_context == CONTEXT
            ), cls
        inherited = {p.identifier for base in cls.__mro__[1:] if hasattr(base, "bl_rna")
                     for p in base.bl_rna.properties}  # fmt: skip
        for prop in cls.bl_rna.properties:
            if prop.identifier not in inherited and prop.name:
                assert prop.translation_context == CONTEXT, (cls, prop.identifier)
    for owner in (bpy.types.Scene, bpy.types.Object, bpy.types.WindowManager):
        for prop in owner.bl_rna.properties:
            if prop.identifier.startswith("angen_") and prop.type != "POINTER":
                assert prop.translation_context == CONTEXT, prop.identifier
