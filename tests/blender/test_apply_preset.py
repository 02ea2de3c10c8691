# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets set what they name and nothing else, and each can be told from the others."""

import math

import bpy
import pytest

ops = bpy.ops.angen


@pytest.fixture
def presets(addon_part):
    """Each with its kind."""
    kinds = addon_part("sensor_logic.kinds").KINDS.values()
    return [(kind, preset) for kind in kinds for preset in kind.presets]


def activate(world, obj):
    world.update()
    bpy.context.view_layer.objects.active = obj
    return obj


def values(world, addon_part, obj):
    """Every parameter of a sensor's kind, by name."""
    kind = addon_part("sensor_logic.kinds").KINDS[obj.angen_sensor.kind]
    group = getattr(obj.angen_sensor, kind.attribute)
    names = addon_part("sensor_logic.parameters").specs(kind.parameters)
    return {name: getattr(group, name) for name in names}


def test_every_preset_sets_what_it_names_and_nothing_else(world, addon_part, presets):
    is_applied = addon_part("angen_addon.authoring.presets").is_applied
    for kind, preset in presets:
        obj = activate(world, world.sensor(kind.identifier, preset.identifier))
        group = getattr(obj.angen_sensor, kind.attribute)
        for name, value in preset.values.items():
            if isinstance(value, float):
                setattr(group, name, value + 0.25)
        before = values(world, addon_part, obj)
        assert not is_applied(obj, preset)
        assert ops.preset_apply(preset=preset.identifier) == {"FINISHED"}
        assert is_applied(obj, preset)
        after = values(world, addon_part, obj)
        for name, value in after.items():
            expected = preset.values.get(name, before[name])
            if isinstance(expected, float):
                assert math.isclose(value, expected, rel_tol=1e-6, abs_tol=1e-12), name
            else:
                assert value == expected, name


def test_one_preset_at_most_is_ticked_for_each_part(world, addon_part, presets):
    """No two presets of a kind are the same; the ideal part is what a new pad has."""
    is_applied = addon_part("angen_addon.authoring.presets").is_applied
    pad = activate(world, world.sensor("PRESSURE", "pad"))
    of_kind = [preset for kind, preset in presets if kind.identifier == "PRESSURE"]
    assert [p.identifier for p in of_kind if is_applied(pad, p)] == ["FSR_402_IDEAL"]
    for preset in of_kind:
        ops.preset_apply(preset=preset.identifier)
        assert [p for p in of_kind if is_applied(pad, p)] == [preset]
    pad.angen_sensor.pressure.load_resistor = 4700.0
    assert not any(is_applied(pad, p) for p in of_kind)


def test_an_unknown_preset_changes_nothing(world, addon_part):
    pad = activate(world, world.sensor("PRESSURE", "pad", load_resistor=4700.0))
    before = values(world, addon_part, pad)
    with pytest.raises(RuntimeError, match=r"'THESIS'.*there are FSR_402_IDEAL, FSR_402,"):
        ops.preset_apply(preset="THESIS")
    assert values(world, addon_part, pad) == before


def test_a_preset_voids_the_recording(world):
    sensor = activate(world, world.switch(range_max=0.4))
    ops.simulate()
    assert ops.export_events.poll()
    ops.preset_apply(preset="THESIS")
    assert sensor.angen_sensor.optical_switch.range_max == pytest.approx(0.5)
    assert not ops.export_events.poll()
