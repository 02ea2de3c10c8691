# SPDX-License-Identifier: GPL-3.0-or-later
"""The interface in other languages: every panel is translated, and its texts fit.

Blender as a Python module has one language, so that the language is set for the extension alone.
"""

import re
import sys

import bpy
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.translations import interface
from bl_ext.user_default.angen_sensors.sensor_logic.kinds import KINDS
from panel_layout import Layout

CONTEXT = interface.CONTEXT


def ours():
    """Return the extension's registered classes of the interface."""
    return [cls for cls in interface._classes() if getattr(cls, "is_registered", False)]


def test_all_texts_have_the_context_of_the_extension():
    groups = [cls for cls in ours() if issubclass(cls, interface.HOLDERS)]
    assert bpy.types.AddonPreferences in {cls.__base__ for cls in groups}
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


def panels():
    return [c for c in ours() if issubclass(c, bpy.types.Panel)]


@pytest.fixture
def said(monkeypatch):
    """Return the texts that were translated while panels were drawn, with their translations."""
    found = {}

    def translated(text, of=interface.translated):
        found[text] = of(text)
        return found[text]

    for name, module in list(sys.modules.items()):
        if name.startswith(interface.PACKAGE) and hasattr(module, "translated"):
            monkeypatch.setattr(module, "translated", translated)
    return found


class Context:
    """The present context, with None for what it lacks, such as a material."""

    def __getattr__(self, name):
        return getattr(bpy.context, name, None)


QUOTED = re.compile(r"'[^']*'")
WORD = re.compile(r"(?<!/)\b[^\W\d_]{3,}")
# Letters: of the names beside fields, in a third of the panel's width, and of a whole line.
NAME, LINE = 16, 42


def draw_all(kinds, world):
    """Draw every panel that shows, with each kind of sensor and a resident active in turn."""
    for kind in kinds:
        bpy.ops.angen.sensor_add(kind=kind)
        world.update()
        draw_panels(("VIEW_3D", "PROPERTIES", "DOPESHEET_EDITOR"))


def draw_panels(editors=("VIEW_3D", "PROPERTIES")):
    for cls in panels():
        polled = not hasattr(cls, "poll") or cls.poll(Context())
        if cls.bl_space_type in editors and polled:
            _draw(cls)


def recorded_home(world):
    """Draw every panel with a recording and explanations, then with a stale one and findings."""
    box = world.box((1, 1, 1), (0, 0, -3), "box")
    world.key(box, "location", {1: (0, 0, -3), 12: (2, 0, -3)})
    world.scene.frame_end = 12
    bpy.ops.angen.simulate(without_light=True)
    for obj in bpy.context.view_layer.objects:
        if obj.angen_sensor.kind != "NONE":
            bpy.context.view_layer.objects.active = obj
            if obj.angen_sensor.kind != "LIGHT":
                bpy.ops.angen.explain(now=True)
            draw_panels()
    bpy.ops.angen.doctor()
    world.box((8, 8, 0.1), (0, 0, -4), "floor")
    bpy.ops.angen.place_point(use="SIT")
    world.update()
    bpy.ops.angen.places_check()
    bpy.ops.angen.coverage()
    box.angen_load.mass = 60.0
    bpy.context.view_layer.objects.active = box
    world.update()
    draw_panels()


def _draw(cls):
    bases = [base for base in reversed(cls.__mro__) if base.__module__.startswith("bl_ext")]
    own = {n: v for base in bases for n, v in vars(base).items() if not n.startswith("__")}
    panel = type("Shown", (), own)()
    panel.layout = Layout()
    for part in interface.DRAWING:
        if hasattr(cls, part):
            getattr(panel, part)(Context())
    interface.translated(cls.bl_label)


@pytest.mark.parametrize("language", ["de", "sv"])
def test_every_panel_is_translated_and_fits(world, said, monkeypatch, language):
    monkeypatch.setattr(interface, "language", lambda: language)
    draw_all(KINDS, world)
    assert len(said) > 150
    assert {
        "Rate (Hz)",
        "No reading",
        "Residents' Places",
        "Only baked keyframes",
        "Live to MQTT",
    } <= set(said)
    recorded_home(world)
    assert _untranslated(said, language) == []
    for text, shown in said.items():
        assert len(shown) <= 1.5 * max(len(text), LINE), shown
    labels = [e for e in interface._entries(language) if e.what == "label"]
    wide = [e for e in labels if len(e.translation) > 1.5 * max(len(e.text), NAME)]
    assert wide == []


def _untranslated(said, language):
    """Return the texts that stay English, without numbers, units and quoted names."""
    known = interface._texts(language)
    return [
        text
        for text, shown in said.items()
        if text == shown
        and WORD.search(QUOTED.sub("", text))
        # Some translations are the same word.
        and not (text in known or interface._composed(language, text))
    ]


def test_texts_with_values_are_translated_and_others_stay(monkeypatch):
    monkeypatch.setattr(interface, "language", lambda: "de")
    for text, shown in [
        ("Removed 3 markers", "3 Marken entfernt"),
        ("Saved the preset 'Mine'", "Voreinstellung 'Mine' gespeichert"),
        ("Threshold (N)", "Schwelle (N)"),
        ("Reverse", "Umkehren"),
        ("No problem was found", "Kein Problem gefunden"),
        ("3 problems found", "3 Probleme gefunden"),
        ("'A, B': it has no faces", "'A, B': it has no faces"),
        (
            "Pressed by 'A' with 3.0 N and 'B' with 1.0 N",
            "Gedrückt durch 'A' mit 3.0 N und 'B' mit 1.0 N",
        ),
        ("A text of a user, 12", "A text of a user, 12"),
        ("", ""),
    ]:
        assert interface.translated(text) == shown
    monkeypatch.setattr(interface, "language", lambda: "en")
    assert interface.translated("Reverse") == "Reverse"


def test_a_log_has_the_same_bytes_in_each_language(world, monkeypatch, tmp_path):
    box = world.box((1, 1, 1), (0, 0, -3), "box")
    world.key(box, "location", {1: (0, 0, -3), 24: (2, 0, -3)})
    world.pir("PIR")
    logs = set()
    for language in ("en", "de", "sv"):
        monkeypatch.setattr(interface, "language", lambda language=language: language)
        assert bpy.ops.angen.simulate() == {"FINISHED"}
        path = tmp_path / f"{language}.csv"
        assert bpy.ops.angen.export_events(filepath=str(path)) == {"FINISHED"}
        logs.add(path.read_bytes())
    assert len(logs) == 1 and len(logs.pop().splitlines()) > 2
