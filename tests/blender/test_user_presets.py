# SPDX-License-Identifier: GPL-3.0-or-later
"""What a user saves comes back, in Blender's own folder of presets, and goes when removed."""

from pathlib import Path
from types import SimpleNamespace

import bpy
import pytest

ops = bpy.ops.angen


@pytest.fixture
def user_preset(addon_part):
    """The module; the presets that a test saves are gone after it."""
    module = addon_part("operators.user_preset")
    kinds = addon_part("sensor_logic.kinds").KINDS

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


def values(addon_part, sensor):
    kind = addon_part("sensor_logic.kinds").KINDS[sensor.angen_sensor.kind]
    group = getattr(sensor.angen_sensor, kind.attribute)
    return {
        n: getattr(group, n) for n in addon_part("sensor_logic.parameters").specs(kind.parameters)
    }


@pytest.mark.parametrize(
    ("kind", "settings"),
    [
        ("PIR", {"range_max": 6.5, "rays": 33, "sweep": "ALL"}),
        ("OPTICAL_SWITCH", {"threshold": 0.031, "aperture_rays": 7}),
        ("PRESSURE", {"load_resistor": 4700.0, "subtract_own_weight": False}),
        ("LIGHT", {"method": "ILLUMINANCE", "gamma": 0.66}),
    ],
)
def test_saved_and_applied_to_another_sensor(world, user_preset, addon_part, kind, settings):
    first = make(world, kind, "first", **settings)
    assert ops.user_preset_save(name="My Part 2") == {"FINISHED"}
    second = make(world, kind, "second")
    assert values(addon_part, second) != values(addon_part, first)
    assert ops.user_preset_apply(name="My Part 2") == {"FINISHED"}
    assert values(addon_part, second) == values(addon_part, first)
    assert bpy.types.ANGEN_MT_presets.bl_label == "Presets"


def test_files_are_in_blenders_folder_and_of_its_form(world, user_preset, addon_part):
    sensor = make(world, "PIR", rays=77)
    ops.user_preset_save(name="Hall way")
    kind = addon_part("sensor_logic.kinds").KINDS["PIR"]
    (file,) = user_preset.user_presets(kind)
    folder = bpy.utils.user_resource("SCRIPTS", path="presets/angen_sensors/pir")
    assert file.parent.resolve() == Path(folder).resolve()
    assert user_preset.label_of(file) == "Hall way"
    sensor.angen_sensor.pir.rays = 5
    bpy.ops.script.execute_preset(filepath=str(file), menu_idname="ANGEN_MT_presets")
    assert sensor.angen_sensor.pir.rays == 77, "Blender's own operator runs it too"
    bpy.types.ANGEN_MT_presets.bl_label = "Presets"


def test_kinds_have_presets_of_their_own(world, user_preset, addon_part):
    make(world, "PIR")
    ops.user_preset_save(name="mine")
    make(world, "LIGHT")
    with pytest.raises(RuntimeError, match=r"'Light sensor' is called 'mine': none is saved"):
        ops.user_preset_apply(name="mine")
    ops.user_preset_save(name="mine")
    assert ops.user_preset_apply(name="mine") == {"FINISHED"}


def test_removed_in_the_same_menu(world, user_preset, addon_part):
    make(world, "PIR")
    ops.user_preset_save(name="one")
    ops.user_preset_save(name="two")
    assert ops.user_preset_save(name="one", remove_name=True) == {"FINISHED"}
    kind = addon_part("sensor_logic.kinds").KINDS["PIR"]
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


def test_what_is_not_a_preset_changes_nothing(world, user_preset, addon_part, capfd):
    sensor = make(world, "PIR", rays=12)
    with pytest.raises(RuntimeError, match="Give the preset a name"):
        ops.user_preset_save(name="  ")
    ops.user_preset_save(name="odd")
    (file,) = user_preset.user_presets(addon_part("sensor_logic.kinds").KINDS["PIR"])
    before = values(addon_part, sensor)
    for text in ("settings.rays = (", "settings.rays = print('run')"):
        file.write_text(text)
        with pytest.raises(RuntimeError, match="'odd' cannot be read"):
            ops.user_preset_apply(name="odd")
    assert values(addon_part, sensor) == before
    capfd.readouterr()
    file.write_text(
        "settings.gone = 3\nsettings.rays = 'many'\nsettings.sweep = 'NO'\nsettings.range_max = 9\n"
    )
    assert ops.user_preset_apply(name="odd") == {"FINISHED"}
    assert "left out: gone, rays, sweep" in capfd.readouterr().out
    assert sensor.angen_sensor.pir.range_max == 9.0
    assert (sensor.angen_sensor.pir.rays, sensor.angen_sensor.pir.sweep) == (12, "SAWTOOTH")


def test_what_is_of_one_file_is_not_saved(world, user_preset, addon_part):
    sensor = make(world, "PRESSURE")
    sensor.angen_sensor.pressure.partner_object = sensor
    ops.user_preset_save(name="pad")
    (file,) = user_preset.user_presets(addon_part("sensor_logic.kinds").KINDS["PRESSURE"])
    assert "partner" not in file.read_text()


def test_a_preset_of_an_earlier_version_with_the_engine_direct_sets_cycles(
    world, user_preset, addon_part, capfd
):
    sensor = make(world, "LIGHT", engine="EEVEE")
    ops.user_preset_save(name="old")
    (file,) = user_preset.user_presets(addon_part("sensor_logic.kinds").KINDS["LIGHT"])
    file.write_text(file.read_text().replace("'EEVEE'", "'DIRECT'"))
    capfd.readouterr()
    assert ops.user_preset_apply(name="old") == {"FINISHED"}
    assert sensor.angen_sensor.light.engine == "CYCLES"
    told = capfd.readouterr().out
    assert told.count("engine DIRECT no longer exists and was replaced by CYCLES") == 1
