# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of the active sensor go to the selected ones of its kind, and to no other."""

import bpy
import pytest

ops = bpy.ops.angen


@pytest.fixture
def sensors(world):
    """Three switches and a motion detector, all selected, the first switch active."""
    made = [world.switch(name) for name in ("one", "two", "three")] + [world.pir("pir")]
    world.update()
    for obj in made:
        obj.select_set(True)
    bpy.context.view_layer.objects.active = made[0]
    group = made[0].angen_sensor
    group.update_rate, group.optical_switch.threshold = 7.0, 0.2
    group.optical_switch.aperture_rays = 5
    return made


def test_all_settings(sensors, capfd):
    _one, two, three, pir = sensors
    assert ops.copy_to_selected() == {"FINISHED"}
    for obj in (two, three):
        assert obj.angen_sensor.update_rate == 7.0
        assert obj.angen_sensor.optical_switch.threshold == pytest.approx(0.2)
        assert obj.angen_sensor.optical_switch.aperture_rays == 5
    assert pir.angen_sensor.update_rate == 24.0
    told = capfd.readouterr().out
    assert "9 settings of 'one' to 2 sensors" in told
    assert "left out: 'pir' (another kind: Motion detector (PIR))" in told


def test_one_parameter(sensors, capfd):
    _one, two, three, _ = sensors
    three.select_set(False)
    ops.copy_to_selected(parameter="threshold")
    assert two.angen_sensor.optical_switch.threshold == pytest.approx(0.2)
    assert two.angen_sensor.optical_switch.aperture_rays == 1
    assert three.angen_sensor.optical_switch.threshold == pytest.approx(0.05)
    assert "threshold of 'one' to 1 sensor;" in capfd.readouterr().out
    with pytest.raises(RuntimeError, match="no parameter 'hue': it has update_rate, range_min"):
        ops.copy_to_selected(parameter="hue")


def test_pointers_are_copied(world):
    pads = [world.sensor("PRESSURE", name, world.box((1, 1, 1))) for name in ("a", "b")]
    world.update()
    for pad in pads:
        pad.select_set(True)
    bpy.context.view_layer.objects.active = pads[0]
    pads[0].angen_sensor.pressure.partner_object = pads[1]
    ops.copy_to_selected()
    assert pads[1].angen_sensor.pressure.partner_object == pads[1]


def test_nothing_to_copy_to_is_told(world, sensors):
    _one, two, three, pir = sensors
    two.select_set(False)
    three.select_set(False)
    with pytest.raises(RuntimeError, match="to 0 sensors; left out: 'pir'"):
        ops.copy_to_selected()
    pir.select_set(False)
    with pytest.raises(RuntimeError, match="the active one last"):
        ops.copy_to_selected()
    bpy.context.view_layer.objects.active = world.box((1, 1, 1))
    with pytest.raises(RuntimeError, match="from the active object"):
        ops.copy_to_selected()


def test_a_copy_voids_the_recording(world, sensors):
    ops.simulate()
    assert ops.clear_recording.poll()
    ops.copy_to_selected()
    assert not ops.export_events.poll()
