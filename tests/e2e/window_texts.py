# SPDX-License-Identifier: GPL-3.0-or-later
"""Run in Blender's window: note the texts that it draws in other languages, and end Blender.

    blender HOME.blend --python tests/e2e/window_texts.py -- REPORT.json de_DE sv_SE

The report has, for each language, the texts of panels and of the 3D view with their translations
and widths in pixels, the width of the sidebar, and what Blender itself looks up: names of
properties, panels and operators.
"""

import json
import os
import sys
import traceback
from collections.abc import Iterator
from itertools import cycle
from pathlib import Path
from typing import Any

import blf
import bpy

PACKAGE = "bl_ext.user_default.angen_sensors"
REPORT, *LANGUAGES = sys.argv[sys.argv.index("--") + 1 :]
# Redraws of each state: Blender opens regions and panels smoothly.
REDRAWS = 4
LAST_FRAME = 24
FONT, POINTS = 0, 11.0
interface: Any = sys.modules[f"{PACKAGE}.angen_addon.translations.interface"]
translate = interface.translated
drawn: dict[str, str] = {}
in_view: set[str] = set()


def translated(text: str) -> str:
    """Translate as the extension does, and note the text."""
    drawn[text] = translate(text)
    return drawn[text]


def is_known(text: str) -> bool:
    """Return whether the dictionary has the text, whose translation may be the same words."""
    code = interface.language()
    return text in interface._texts(code) or bool(interface._composed(code, text))


def draw(font: int, text: str, draw_text: Any = blf.draw) -> None:
    """Draw a text in the view or the Timeline as Blender does, and note it."""
    in_view.add(text)
    draw_text(font, text)


def watch() -> None:
    for name, module in list(sys.modules.items()):
        if name.startswith(PACKAGE) and hasattr(module, "translated"):
            module.translated = translated
    blf.draw = draw


def ours(base: Any) -> Iterator[Any]:
    return (c for c in interface._below(base) if getattr(c, "is_registered", False))


def open_panels() -> None:
    """Register the panels anew so that they are open: Blender draws no closed ones."""
    panels = sorted(ours(bpy.types.Panel), key=lambda cls: bool(getattr(cls, "bl_parent_id", "")))
    for cls in reversed(panels):
        bpy.utils.unregister_class(cls)
    for cls in panels:
        cls.bl_options = set(getattr(cls, "bl_options", ())) - {"DEFAULT_CLOSED"}
        bpy.utils.register_class(cls)


def width(text: str) -> float:
    blf.size(FONT, POINTS * bpy.context.preferences.system.ui_scale)
    return float(blf.dimensions(FONT, text)[0])


def looked_up() -> dict[str, str]:
    """Return the texts that Blender translates itself, with what it shows."""
    texts = bpy.app.translations
    found = {}
    for base in (*interface.HOLDERS, bpy.types.Operator):
        for cls in ours(base):
            inherited = {p.identifier for p in base.bl_rna.properties}
            for prop in cls.bl_rna.properties:
                if (
                    prop.identifier not in inherited
                    and prop.translation_context == interface.CONTEXT
                ):
                    if prop.name != prop.identifier:
                        found[prop.name] = texts.pgettext_iface(prop.name, interface.CONTEXT)
                    found[prop.description] = texts.pgettext_tip(prop.description)
    for base in (bpy.types.Panel, bpy.types.Menu, bpy.types.Operator):
        for cls in ours(base):
            found[cls.bl_label] = texts.pgettext_iface(cls.bl_label, interface.CONTEXT)
    return found


def area(kind: str) -> Any:
    return next(a for a in bpy.context.window_manager.windows[0].screen.areas if a.type == kind)


def region(kind: str) -> Any:
    return next(r for r in area("VIEW_3D").regions if r.type == kind)


def run(operator: Any, **options: Any) -> None:
    """Call an operator in the 3D view."""
    window = bpy.context.window_manager.windows[0]
    with bpy.context.temp_override(
        window=window, area=area("VIEW_3D"), region=region("WINDOW"), screen=window.screen
    ):
        operator(**options)


def show_sensor(obj: Any) -> None:
    for other in bpy.context.view_layer.objects:
        other.select_set(other == obj)
    bpy.context.view_layer.objects.active = obj


def states() -> Iterator[None]:
    """Bring the window into one state after another."""
    view = bpy.context.preferences.view
    view.show_splash = False
    view.use_translate_interface = view.use_translate_tooltips = True
    area("VIEW_3D").spaces.active.show_region_ui = True
    area("PROPERTIES").spaces.active.context = "PHYSICS"
    open_panels()
    yield
    region("UI").active_panel_category = "Sensors"
    bpy.ops.angen.clear_recording()
    sensors = {
        obj.angen_sensor.kind: obj
        for obj in bpy.context.view_layer.objects
        if obj.angen_sensor.kind != "NONE"
    }
    report = {}
    watch()
    for language in LANGUAGES:
        view.language = language
        drawn.clear()
        in_view.clear()
        bpy.context.scene.frame_set(1)
        for obj in sensors.values():
            show_sensor(obj)
            yield
        run(bpy.ops.angen.simulate, frame_start=1, frame_end=LAST_FRAME, without_light=True)
        run(bpy.ops.angen.doctor)
        bpy.context.scene.angen_coverage.cell = 1.0
        run(bpy.ops.angen.coverage)
        for kind, obj in sensors.items():
            show_sensor(obj)
            if kind != "LIGHT":
                run(bpy.ops.angen.explain, now=True)
            yield
        bpy.ops.angen.clear_recording()
        bpy.ops.angen.coverage_clear()
        names = {obj.name for obj in bpy.data.objects}
        looked = looked_up()
        report[language] = {
            "panels": {t: [s, width(t), width(s)] for t, s in drawn.items() if t not in names},
            "view": sorted(in_view - names),
            "sidebar": region("UI").width,
            "looked up": looked,
            "known": [t for t in drawn | looked if is_known(t)],
        }
    Path(REPORT).write_text(json.dumps(report, ensure_ascii=False), encoding="utf-8")


WORK = states()
STEPS = cycle(range(REDRAWS))


def step() -> float:
    """Redraw the window; after some redraws go to the next state, or end Blender."""
    try:
        if next(STEPS) == REDRAWS - 1:
            next(WORK)
        for one in bpy.context.window_manager.windows[0].screen.areas:
            one.tag_redraw()
    except StopIteration:
        os._exit(0)
    except BaseException:
        traceback.print_exc()
        os._exit(1)
    return 0.05


bpy.app.timers.register(step, first_interval=0.5)
