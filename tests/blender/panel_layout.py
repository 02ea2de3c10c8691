# SPDX-License-Identifier: GPL-3.0-or-later
"""A layout that records the items of panels, and checks every name against this Blender."""

from types import SimpleNamespace

import bpy

ICONS = bpy.types.UILayout.bl_rna.functions["label"].parameters["icon"].enum_items.keys()

PANELS = (
    "ANGEN_PT_physics",
    "ANGEN_PT_physics_weight",
    "ANGEN_PT_simulation",
    "ANGEN_PT_simulation_settings",
    "ANGEN_PT_table",
    "ANGEN_PT_overlay",
    "ANGEN_PT_active_sensor",
    "ANGEN_PT_sidebar_weight",
)


class Layout:
    """Replaces a UILayout; all parts of one drawing share their lists."""

    def __init__(self, whole=None, opened=True):
        self.whole = whole or self
        if whole is None:
            self.labels, self.props, self.operators, self.menus, self.icons = [], [], [], [], []
            self.sections, self.fields, self.menu_texts = [], {}, []
            self.pictures = 0
            self.opened = opened

    def _part(self, function, **arguments):
        self._check(function, **arguments)
        return Layout(self.whole)

    def _check(self, function, icon="NONE", **arguments):
        known = bpy.types.UILayout.bl_rna.functions[function].parameters
        assert set(arguments) <= set(known.keys())
        assert icon in ICONS

    def column(self, **arguments):
        return self._part("column", **arguments)

    def row(self, **arguments):
        return self._part("row", **arguments)

    def grid_flow(self, **arguments):
        return self._part("grid_flow", **arguments)

    def box(self):
        return self._part("box")

    def split(self, **arguments):
        return self._part("split", **arguments)

    def panel(self, idname, default_closed=False):
        assert self is self.whole, "Blender draws sections only where there is the full width"
        self.sections.append((idname, default_closed))
        header, body = (self._part("panel", default_closed=default_closed) for _ in range(2))
        return header, body if self.opened else None

    def context_pointer_set(self, name, data):
        assert name == "object" and data.angen_sensor.kind != "NONE"

    def label(self, text="", icon="NONE", **arguments):
        self._check("label", icon, **arguments)
        self.whole.labels.append(text)
        self.whole.icons.append(icon)

    def prop(self, data, name, **arguments):
        self._check("prop", **arguments)
        assert name in data.bl_rna.properties
        self.whole.props.append(name)
        self.whole.fields[arguments.get("text", data.bl_rna.properties[name].name)] = (data, name)

    def operator(self, idname, text=None, icon="NONE", **arguments):
        self._check("operator", icon, **arguments)
        module, _, name = idname.partition(".")
        assert name in dir(getattr(bpy.ops, module))
        item = SimpleNamespace()
        self.whole.operators.append((text, icon, item))
        return item

    def operator_menu_enum(self, idname, name, text=None, icon="NONE", **arguments):
        self._check("operator_menu_enum", icon, **arguments)
        self.whole.menus.append(idname)

    def progress(self, **arguments):
        self._check("progress", **arguments)
        assert 0.0 <= arguments["factor"] <= 1.0
        self.whole.labels.append(arguments["text"])

    def template_icon(self, **arguments):
        self._check("template_icon", **arguments)
        self.whole.pictures += 1

    def separator(self):
        self._check("separator")

    def template_list(self, listtype, list_id, data, name, active, index, **arguments):
        self._check("template_list", **arguments)
        table, shown = getattr(bpy.types, listtype), SimpleNamespace(bitflag_filter_item=1)
        assert index in active.bl_rna.properties
        objects = list(getattr(data, name))
        flags, places = [1] * len(objects), list(range(len(objects)))
        if "filter_items" in vars(table):
            flags, places = table.filter_items(shown, bpy.context, data, name)
        for number in sorted(range(len(objects)), key=places.__getitem__):
            if flags[number]:
                table.draw_item(
                    shown, bpy.context, self, data, objects[number], 0, active, index, number
                )

    def menu(self, idname, icon="NONE", **arguments):
        self._check("menu", icon, **arguments)
        assert hasattr(bpy.types, idname)
        self.whole.menus.append(idname)
        self.whole.menu_texts.append(arguments.get("text"))

    @property
    def text(self):
        return " ".join(self.whole.labels)


def panel_of(name):
    return getattr(bpy.types, name)


def drawn(name, opened=True):
    """Return the items that a panel draws in the present context, with its header.

    The button that opens the panel's page of the docs is left out.
    """
    cls = panel_of(name)
    assert not hasattr(cls, "poll") or cls.poll(bpy.context)
    layout = Layout(opened=opened)
    panel = SimpleNamespace(layout=layout, help_page=getattr(cls, "help_page", ""))
    for part in ("draw_header", "draw_header_preset", "draw"):
        if hasattr(cls, part):
            getattr(cls, part)(panel, bpy.context)
    layout.operators = [item for item in layout.operators if item[1] != "HELP"]
    return layout


def pad_under_a_box(world):
    """Add a floor, a box of 5 kg on it, and a pad below the box that senses at every frame."""
    bpy.ops.rigidbody.world_add()
    body(world, (4, 4, 4), (0, 0, -2), "floor", "PASSIVE")
    body(world, (0.2, 0.2, 0.2), (0.02, 0, 0.1), "box", "ACTIVE", 5.0)
    bpy.ops.angen.sensor_add(kind="PRESSURE")
    bpy.context.object.name = "pad"
    bpy.context.object.angen_sensor.update_rate = 24.0
    world.update()
    return world


def body(world, size, at, name, kind, mass=1.0):
    obj = activate(world, world.box(size, at, name))
    bpy.ops.rigidbody.object_add(type=kind)
    obj.rigid_body.collision_shape, obj.rigid_body.mass = "BOX", mass
    return obj


def activate(world, obj):
    world.update()
    bpy.context.view_layer.objects.active = obj
    return obj


def pad():
    return bpy.data.objects["pad"]
