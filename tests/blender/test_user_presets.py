# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets set only the parameters that they name; user presets are saved, listed and removed."""

import math
from pathlib import Path
from types import SimpleNamespace

import bpy
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.authoring.presets import (
    is_applied,
    preset_of,
    preset_text,
)
from bl_ext.user_default.angen_sensors.operators import user_preset as module
from bl_ext.user_default.angen_sensors.sensor_logic.kinds import KINDS
from bl_ext.user_default.angen_sensors.sensor_logic.kinds import KINDS as kinds
from bl_ext.user_default.angen_sensors.sensor_logic.parameters import specs
from panel_layout import Layout, drawn

ops = bpy.ops.angen


@pytest.fixture
def user_preset():
    """Return the module; remove the presets that a test saved."""

    def saved():
        return [file for kind in kinds.values() for file in module.user_presets(kind)]

    assert saved() == []
    yield module
    for file in saved():
        file.unlink()


def make(world, kind, name="sensor", **settings):
    sensor = world.sensor(kind, name, **settings)
    world.update()
    bpy.context.view_layer.objects.active = sensor
    return sensor


def values(sensor):
    kind = kinds[sensor.angen_sensor.kind]
    group = getattr(sensor.angen_sensor, kind.attribute)
    return {n: getattr(group, n) for n in specs(kind.parameters)}


@pytest.mark.parametrize(
    ("kind", "settings"),
    [
        ("PIR", {"range_max": 6.5, "rays": 33, "sweep": "ALL"}),
        ("OPTICAL_SWITCH", {"threshold": 0.031, "aperture_rays": 7}),
        ("PRESSURE", {"load_resistor": 4700.0, "subtract_own_weight": False}),
        ("LIGHT", {"method": "ILLUMINANCE", "gamma": 0.66}),
    ],
)
def test_saved_and_applied_to_another_sensor(world, user_preset, kind, settings):
    first = make(world, kind, "first", **settings)
    assert ops.user_preset_save(name="My Part 2") == {"FINISHED"}
    second = make(world, kind, "second")
    assert values(second) != values(first)
    assert ops.user_preset_apply(name="My Part 2") == {"FINISHED"}
    assert values(second) == values(first)
    assert bpy.types.ANGEN_MT_presets.bl_label == "Presets"


def test_files_are_in_blenders_folder_and_of_its_form(world, user_preset):
    sensor = make(world, "PIR", rays=77)
    ops.user_preset_save(name="Hall way")
    kind = kinds["PIR"]
    (file,) = user_preset.user_presets(kind)
    folder = bpy.utils.user_resource("SCRIPTS", path="presets/angen_sensors/pir")
    assert file.parent.resolve() == Path(folder).resolve()
    assert user_preset.label_of(file) == "Hall way"
    sensor.angen_sensor.pir.rays = 5
    bpy.ops.script.execute_preset(filepath=str(file), menu_idname="ANGEN_MT_presets")
    assert sensor.angen_sensor.pir.rays == 77, "Blender's own operator runs it too"
    bpy.types.ANGEN_MT_presets.bl_label = "Presets"


def test_removed_in_the_same_menu(world, user_preset):
    make(world, "PIR")
    ops.user_preset_save(name="one")
    ops.user_preset_save(name="two")
    assert ops.user_preset_save(name="one", remove_name=True) == {"FINISHED"}
    kind = kinds["PIR"]
    assert [user_preset.label_of(f) for f in user_preset.user_presets(kind)] == ["two"]
    with pytest.raises(RuntimeError, match="no preset 'one'"):
        ops.user_preset_save(name="one", remove_name=True)


def test_the_menu_lists_both_kinds_of_presets(world, user_preset):
    make(world, "PIR")
    ops.user_preset_save(name="mine")
    drawn = []

    class Layout:
        operator_context = ""

        def operator(self, idname, **facts):
            item = type("Item", (), {"facts": facts, "idname": idname})()
            drawn.append(item)
            return item

        def row(self, **_):
            return self

        def separator(self): ...

    cls = bpy.types.ANGEN_MT_presets
    cls.draw(SimpleNamespace(layout=Layout()), bpy.context)
    texts = [item.facts["text"] for item in drawn]
    assert texts[0] == "Thesis (Gazebo range scan)" and {"HC-SR501", "HC-SR501, range scan"} <= set(
        texts
    )
    assert texts[-3:] == ["mine", "", "Save as Preset …"]
    assert (drawn[-2].name, drawn[-2].remove_name) == ("mine", True)


def test_what_is_not_a_preset_changes_nothing(world, user_preset, capfd):
    sensor = make(world, "PIR", rays=12)
    with pytest.raises(RuntimeError, match="Give the preset a name"):
        ops.user_preset_save(name="  ")
    ops.user_preset_save(name="odd")
    (file,) = user_preset.user_presets(kinds["PIR"])
    before = values(sensor)
    for text in ("settings.rays = (", "settings.rays = print('run')"):
        file.write_text(text)
        with pytest.raises(RuntimeError, match="'odd' cannot be read"):
            ops.user_preset_apply(name="odd")
    assert values(sensor) == before
    capfd.readouterr()
    file.write_text(
        "settings.gone = 3\nsettings.rays = 'many'\nsettings.sweep = 'NO'\nsettings.range_max = 9\n"
    )
    assert ops.user_preset_apply(name="odd") == {"FINISHED"}
    assert "left out: gone, rays, sweep" in capfd.readouterr().out
    assert sensor.angen_sensor.pir.range_max == 9.0
    assert (sensor.angen_sensor.pir.rays, sensor.angen_sensor.pir.sweep) == (12, "SAWTOOTH")


# Presets set only the parameters that they name, and all differ from each other


@pytest.fixture
def presets():
    """Return each preset with its kind."""
    kinds = KINDS.values()
    return [(kind, preset) for kind in kinds for preset in kind.presets]


def activate(world, obj):
    world.update()
    bpy.context.view_layer.objects.active = obj
    return obj


def all_values(world, obj):
    """Return every parameter of a sensor's kind, by name."""
    kind = KINDS[obj.angen_sensor.kind]
    group = getattr(obj.angen_sensor, kind.attribute)
    names = specs(kind.parameters)
    return {name: getattr(group, name) for name in names}


def test_every_preset_sets_what_it_names_and_nothing_else(world, presets):
    for kind, preset in presets:
        obj = activate(world, world.sensor(kind.identifier, preset.identifier))
        group = getattr(obj.angen_sensor, kind.attribute)
        for name, value in preset.values.items():
            if isinstance(value, float):
                setattr(group, name, value + 0.25)
        before = all_values(world, obj)
        assert not is_applied(obj, preset)
        assert ops.preset_apply(preset=preset.identifier) == {"FINISHED"}
        assert is_applied(obj, preset)
        after = all_values(world, obj)
        for name, value in after.items():
            expected = preset.values.get(name, before[name])
            if isinstance(expected, float):
                assert math.isclose(value, expected, rel_tol=1e-6, abs_tol=1e-12), name
            else:
                assert value == expected, name


def test_a_preset_sets_the_rate_that_its_noise_holds_for(world):
    obj = activate(world, world.sensor("THERMAL_ARRAY", "array"))
    for preset, rate in (("AMG8833_1HZ", 1.0), ("AMG8833", 10.0), ("HTPA32", 5.0)):
        ops.preset_apply(preset=preset)
        assert obj.angen_sensor.update_rate == rate
    assert "(edited)" not in preset_text(obj)
    obj.angen_sensor.update_rate = 2.0
    assert preset_text(obj) == "Heimann HTPA 32 × 32 L2.1 (edited)"


def test_one_preset_at_most_is_ticked_for_each_part(world, presets):
    """No two presets of a kind are the same; a new pad is no part."""
    pad = activate(world, world.sensor("PRESSURE", "pad"))
    of_kind = [preset for kind, preset in presets if kind.identifier == "PRESSURE"]
    assert preset_text(pad) == "Any pad (no part)"
    for preset in of_kind:
        ops.preset_apply(preset=preset.identifier)
        assert preset_of(pad) == (preset, False)
    pad.angen_sensor.pressure.load_resistor = 4700.0
    assert preset_of(pad) == (of_kind[-1], True)


def test_an_edited_preset_keeps_its_name_and_says_so(world, presets):
    pir = activate(world, world.sensor("PIR", "pir"))
    ops.preset_apply(preset="EKMC1601111")
    label = "Panasonic EKMC1601111 (5 m)"
    assert drawn("ANGEN_PT_active_sensor").menu_texts == [label]
    before = pir.angen_sensor.pir.hold_time
    pir.angen_sensor.pir.hold_time = 7.0
    assert drawn("ANGEN_PT_active_sensor").menu_texts == ["Panasonic EKMC1601111 (edited)"]
    pir.angen_sensor.pir.hold_time = before
    assert preset_text(pir) == label
    other = world.sensor("PIR", "other")
    other.select_set(True)
    pir.angen_sensor.pir.hold_time = 7.0
    ops.copy_to_selected()
    assert preset_text(other) == "Panasonic EKMC1601111 (edited)"
    ops.preset_apply(preset="THESIS")
    assert preset_text(pir) == "Thesis (Gazebo range scan)"


def test_a_preset_is_no_change_that_makes_a_recording_stale(world):
    pir = activate(world, world.sensor("PIR", "pir"))
    world.scene.frame_end = 4
    ops.simulate()
    ops.preset_apply(preset="THESIS")
    world.update()
    assert pir.angen_sensor.preset == "THESIS"
    assert not drawn("ANGEN_PT_simulation").text.count("stale")


@pytest.mark.parametrize("kind", KINDS)
def test_the_menus_add_a_real_part_by_its_name(world, kind):
    part = next(p for p in KINDS[kind].presets if p.identifier == KINDS[kind].part)
    layout = Layout()
    addon_menu = bpy.types.ANGEN_MT_sensor_add
    addon_menu.draw(SimpleNamespace(layout=layout), bpy.context)
    items = [item for *_, item in layout.operators if getattr(item, "kind", "") == kind]
    assert [item.preset for item in items] == [part.identifier] * 2
    assert "no part" not in part.source and "thesis" not in part.source.lower()
    ops.sensor_add(kind=kind, preset=part.identifier)
    assert preset_text(bpy.context.object) == part.label


def test_a_script_without_a_preset_gets_the_defaults(world):
    ops.sensor_add(kind="PRESSURE")
    assert bpy.context.object.angen_sensor.pressure.threshold == 1.0
    assert preset_text(bpy.context.object) == "Any pad (no part)"


def test_a_pad_is_as_large_as_its_part(world):
    ops.sensor_add(kind="PRESSURE", preset="SMART_CAREGIVER_CHAIR")
    pad = bpy.context.object
    assert pad.dimensions[:2] == pytest.approx((0.254, 0.381))
    assert pad.angen_sensor.pressure.area == pytest.approx(0.254 * 0.381)
