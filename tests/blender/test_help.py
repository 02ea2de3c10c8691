# SPDX-License-Identifier: GPL-3.0-or-later
"""F1 over a setting or button, and the help of a panel, open a page that the docs have."""

from pathlib import Path
from types import SimpleNamespace

import bpy
from bl_ext.user_default.angen_sensors.angen_addon.appearance import help as pages
from panel_layout import Layout

DOCS = Path(__file__).resolve().parents[2] / "docs"


def opened(name: str) -> str:
    """Return the page that Blender opens for a name in its Python, without the site."""
    found = bpy.types.WM_OT_doc_view_manual._lookup_rna_url(name, verbose=False)
    assert found and found.startswith(pages.site()), (name, found)
    return found.removeprefix(pages.site()).removesuffix(".html")


def groups(owner):
    """Yield the names of all properties of the extension, with those of their groups."""
    for found in owner.bl_rna.properties:
        if found.identifier.startswith("angen"):
            yield f"bpy.types.{owner.bl_rna.identifier}.{found.identifier}"
            yield from _inner(found)


def _inner(pointer):
    group = getattr(pointer, "fixed_type", None)
    if group is None or "angen" not in group.identifier.lower():
        return
    for found in group.properties:
        if found.identifier not in ("rna_type", "name"):
            yield f"bpy.types.{group.identifier}.{found.identifier}"
            yield from _inner(found)


def test_each_setting_and_button_has_a_page_of_the_docs(world):
    names = {f"bpy.ops.angen.{name}" for name in dir(bpy.ops.angen)}
    for owner in (bpy.types.Object, bpy.types.Scene, bpy.types.Material, bpy.types.WindowManager):
        names |= set(groups(owner))
    assert len(names) > 200
    for name in names:
        assert (DOCS / f"{opened(name)}.md").is_file(), name


def test_a_setting_opens_the_page_of_its_kind(world):
    for kind, page in (("PIR", "pir"), ("OPTICAL_SWITCH", "switch"), ("LIGHT", "light")):
        settings = world.sensor(kind, kind).angen_sensor
        group = getattr(settings, kind.lower()).bl_rna
        name = next(p.identifier for p in group.properties if p.identifier not in ("rna_type",))
        assert opened(f"bpy.types.{group.identifier}.{name}") == page
    assert opened("bpy.ops.angen.mqtt_start") == "home_assistant"
    assert opened("bpy.types.Scene.angen_seed") == "window"
    assert bpy.types.WM_OT_doc_view_manual._lookup_rna_url("bpy.types.Object.location") != ""


def test_each_panel_opens_its_page(world):
    bpy.context.view_layer.objects.active = world.box((1, 1, 1))
    found = [getattr(bpy.types, name) for name in dir(bpy.types) if name.startswith("ANGEN_PT_")]
    # That of the Timeline is a popover, which has no header.
    found = [cls for cls in found if cls.bl_space_type in ("VIEW_3D", "PROPERTIES")]
    assert len(found) > 20
    for cls in found:
        assert (DOCS / f"{cls.help_page}.md").is_file(), cls
        layout = Layout()
        cls.draw_header_preset(SimpleNamespace(layout=layout, help_page=cls.help_page), bpy.context)
        ((_, icon, button),) = layout.operators
        assert (icon, button.url) == ("HELP", f"{pages.site()}{cls.help_page}.html")
