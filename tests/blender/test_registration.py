# SPDX-License-Identifier: GPL-3.0-or-later
"""Enabling and disabling the extension, and loading files, leaves Blender as it was."""

import subprocess
import sys

import addon_utils
import bpy
import pytest
from bl_ext.user_default.angen_sensors.sensor_logic import parameters
from bl_ext.user_default.angen_sensors.sensor_logic.kinds import KINDS as kinds

ADDON = "bl_ext.user_default.angen_sensors"
# One more where Blender tells of what is appended.
HANDLERS = 14 + hasattr(bpy.app.handlers, "blend_import_post")


def functions(owner):
    """Return the names of the functions appended to a menu."""
    return [f.__name__ for f in getattr(owner.draw, "_draw_funcs", [])]


def properties(owner):
    names = (p.identifier for p in owner.bl_rna.properties)
    return sorted(name for name in names if "angen" in name)


def what_is_registered():
    return {
        "handlers": {
            name: [f"{f.__module__}.{f.__name__}" for f in getattr(bpy.app.handlers, name)]
            for name in dir(bpy.app.handlers)
            if isinstance(getattr(bpy.app.handlers, name), list)
        },
        "types": sorted(name for name in dir(bpy.types) if name.lower().startswith("angen")),
        "operators": sorted(dir(bpy.ops.angen)),
        "object": properties(bpy.types.Object),
        "scene": properties(bpy.types.Scene),
        "menu": functions(bpy.types.VIEW3D_MT_add) + functions(bpy.types.VIEW3D_MT_object),
    }


def ours(handlers):
    return [f for group in handlers.values() for f in group if ADDON in f]


def test_on_and_off_three_times(empty_scene):
    on = what_is_registered()
    assert len(ours(on["handlers"])) == HANDLERS
    assert on["object"] == [
        "angen_breathing",
        "angen_heat",
        "angen_ignored",
        "angen_load",
        "angen_place",
        "angen_radar",
        "angen_resident",
        "angen_sensor",
        "angen_use",
        "angen_warmth",
    ]
    assert {"angen_seed", "angen_substeps", "angen_luminous_efficacy"} <= set(on["scene"])
    assert on["menu"].count("draw_in_add_menu") == 1
    assert {
        "bake_keyframes",
        "clear_recording",
        "export_events",
        "export_samples",
        "preset_apply",
        "sensor_add",
        "sensor_assign",
        "sensor_clear",
        "simulate",
    } <= set(on["operators"])
    for _ in range(3):
        addon_utils.disable(ADDON)
        try:
            off = what_is_registered()
        finally:
            assert addon_utils.enable(ADDON, default_set=True) is not None
        assert ours(off["handlers"]) == []
        assert off["types"] == off["object"] == off["scene"] == off["operators"] == []
        assert "draw_in_add_menu" not in off["menu"]
        assert "draw_in_object_menu" not in off["menu"]
        assert what_is_registered() == on


def test_nothing_is_printed_in_it(tmp_path):
    """Blender prints errors of the registration, and goes on."""
    program = (
        "import bpy\n"
        "print('bpy is here', flush=True)\n"
        "from angen_addon.process.standalone import load_extension\n"
        "for _ in range(3):\n"
        "    load_extension().register(); load_extension().unregister()\n"
        "load_extension().register()\n"
        "print('registered', hasattr(bpy.types.Object, 'angen_sensor'))\n"
        "load_extension().unregister()\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=False
    )
    said = done.stdout.partition("bpy is here")[2].strip()
    assert (done.returncode, said, done.stderr) == (0, "registered True", "")


UPGRADE = """
import bpy
from angen_addon.process.standalone import PACKAGE, load_extension
class Former(bpy.types.Operator):
    bl_idname, bl_label = "angen.former", "Former"
    __module__ = PACKAGE + ".operators.former"
    __annotations__ = {"name": "StringProperty()"}
extension = load_extension()
extension.register()
print("registered", hasattr(bpy.types.Object, "angen_sensor"), Former.__annotations__)
"""


def test_it_registers_where_blender_replaces_another_version_of_it():
    """Blender drops the modules of the former version, whose classes stay."""
    done = subprocess.run(
        [sys.executable, "-c", UPGRADE], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert "registered True {'name': 'StringProperty()'}" in done.stdout


FAILING = """
import bpy
from angen_addon.process.standalone import load_extension
extension = load_extension()
from angen_sensors import parts
parts.MODULES, modules = (*parts.MODULES, "sensor_logic.kind"), parts.MODULES
def attempt():
    try:
        extension.register()
    except Exception as error:
        return str(error)
print(attempt(), hasattr(bpy.types.Object, "angen_sensor"), dir(bpy.ops.angen))
parts.MODULES = modules
for _ in range(2):
    print(attempt(), hasattr(bpy.types.Object, "angen_sensor"))
"""


def test_an_error_leaves_nothing_registered_and_a_second_copy_is_refused():
    done = subprocess.run(
        [sys.executable, "-X", "utf8", "-c", FAILING],
        capture_output=True,
        encoding="utf-8",
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    failed, ended, again = done.stdout.splitlines()[-3:]
    assert "no attribute 'register'" in failed and failed.endswith(" False []")
    assert ended == "None True"
    assert again.startswith("Ängen Sensors is on already, from another repository or file: ")


def live_works(world):
    wall = world.wall(0.02)
    sensor = world.switch()
    world.scene.frame_set(1)
    world.scene.frame_set(2)
    assert not sensor.angen_sensor.active
    wall.location.z = -0.3
    world.update()
    world.scene.frame_set(3)
    return sensor.angen_sensor.active


def test_handlers_survive_new_files_and_file_loads(world, tmp_path):
    assert live_works(world)
    world.bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a.blend"))
    world.bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    assert live_works(world)
    world.bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "a.blend"))
    assert live_works(world)
    assert len(ours(what_is_registered()["handlers"])) == HANDLERS


def test_a_file_keeps_the_sensors(world, tmp_path):
    sensor = world.pir("Hall PIR", rays=33, hold_time=2.5)
    sensor.angen_load.mass = 70.0
    world.box((1, 1, 1), name="marker").angen_ignored = True
    world.scene.angen_seed = 12
    world.bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a.blend"))
    world.bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    assert not bpy.data.objects
    world.bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "a.blend"))
    sensor = bpy.data.objects["Hall PIR"]
    assert sensor.angen_sensor.kind == "PIR"
    assert (sensor.angen_sensor.pir.rays, sensor.angen_sensor.pir.hold_time) == (33, 2.5)
    assert sensor.angen_load.mass == 70.0
    assert bpy.data.objects["marker"].angen_ignored
    assert world.scene.angen_seed == 12


def test_undo_and_redo(world):
    """Undo replaces all data: sensors come back, and handlers still work on them."""
    world.update()
    bpy.ops.ed.undo_push(message="start")
    assert bpy.ops.angen.sensor_add(kind="OPTICAL_SWITCH") == {"FINISHED"}
    bpy.ops.ed.undo_push(message="add")
    bpy.ops.angen.simulate()
    bpy.ops.ed.undo()
    if "Optical switch" in bpy.data.objects:
        pytest.skip("this build of Blender does not undo without a window")
    assert not bpy.ops.angen.export_events.poll()
    bpy.ops.ed.redo()
    assert bpy.data.objects["Optical switch"].angen_sensor.kind == "OPTICAL_SWITCH"
    world.wall(0.02)
    world.scene.frame_set(5)
    world.scene.frame_set(6)
    assert not bpy.data.objects["Optical switch"].angen_sensor.active
    assert bpy.ops.angen.simulate() == {"FINISHED"}


def test_handlers_that_other_code_threw_out_are_put_back_by_a_run(world):
    wall = world.wall(0.3)
    world.key(wall, "location", {1: (0, 0, -0.3), 48: (0, 0, -0.4)})
    world.switch()
    expected = world.run()
    bpy.app.handlers.frame_change_post.clear()
    bpy.app.handlers.depsgraph_update_post.clear()
    assert world.run() == expected
    assert len(ours(what_is_registered()["handlers"])) == HANDLERS


def test_enum_numbers_in_files(world):
    items = bpy.types.Object.bl_rna.properties["angen_sensor"].fixed_type.properties["kind"]
    assert {item.identifier: item.value for item in items.enum_items} == {
        "NONE": 0,
        "PIR": 1,
        "OPTICAL_SWITCH": 2,
        "PRESSURE": 3,
        "LIGHT": 4,
        "DISTANCE": 5,
        "CONTACT": 6,
        "PRESENCE_RADAR": 8,
        "THERMAL_ARRAY": 7,
        "APPLIANCE": 9,
        "FLOW": 10,
    }


def test_every_parameter_is_a_property_that_overrides_can_change():
    group = bpy.types.Object.bl_rna.properties["angen_sensor"].fixed_type.properties
    for kind in kinds.values():
        properties = group[kind.attribute].fixed_type.properties
        for name, spec in parameters.specs(kind.parameters).items():
            found = properties[name]
            assert found.name.startswith(spec.label)
            assert found.description.startswith(spec.tip)
            assert found.is_overridable, name
            if not spec.pointer and not spec.choices:
                default = parameters.defaults(kind.parameters)[name]
                assert found.default == pytest.approx(default)
    for name in ("kind", "enabled", "update_rate", "active", "value"):
        assert group[name].is_overridable


def path_fields():
    """Return the fields for paths of all types and operators of the extension, by name."""
    operators = [getattr(bpy.ops.angen, name).get_rna_type() for name in dir(bpy.ops.angen)]
    groups = [
        cls.bl_rna
        for cls in bpy.types.PropertyGroup.__subclasses__()
        if cls.__module__.startswith(ADDON) and hasattr(cls, "bl_rna")
    ]
    return {
        f"{owner.identifier}.{prop.identifier}": prop
        for owner in operators + groups
        for prop in owner.properties
        if prop.type == "STRING" and prop.subtype in {"FILE_PATH", "DIR_PATH"}
    }


@pytest.mark.skipif(bpy.app.version < (4, 5, 0), reason="fields show no relative path in red")
def test_a_path_relative_to_the_file_is_not_shown_in_red():
    found = path_fields()
    assert {"AngenDay.routine", "AngenDay.out", "AngenStudy.file"} <= found.keys()
    assert len([name for name in found if name.startswith("ANGEN_OT")]) >= 8
    assert [name for name, prop in found.items() if not prop.is_path_supports_blend_relative] == []
