# SPDX-License-Identifier: GPL-3.0-or-later
"""Every number that a user reads has the right value and unit, whatever the scene's units."""

import math

import bpy
import pytest
from light_stage import facing, lamp
from test_panels import drawn

ops = bpy.ops.angen


@pytest.fixture
def lit(world):
    """A lamp of 1445 lx above a light sensor by illuminance."""
    world.scene.angen_luminous_efficacy = 1.0
    lamp(world, "POINT", at=(0, 0, 10), energy=1445.0 * 4 * math.pi * 100)
    obj = world.sensor(
        "LIGHT", "light", method="ILLUMINANCE", engine="DIRECT", update_rate=24.0, threshold=300.0
    )
    obj.matrix_world = facing((0, 0, 1)).tolist()
    obj.rotation_euler = (math.pi, 0, 0)
    bpy.context.view_layer.objects.active = obj
    world.scene.frame_end = 4
    return obj


def test_light_by_illuminance_is_in_lux_wherever_it_is_shown(world, lit, addon_part, tmp_path):
    ops.simulate()
    world.scene.frame_set(2)
    assert drawn("ANGEN_PT_active_sensor").labels[1] == "Lit, 1445 lx"
    assert "1445 lx" in drawn("ANGEN_PT_table").labels
    assert ops.explain() == {"FINISHED"}
    panel = drawn("ANGEN_PT_events")
    assert any(text.startswith("1445 lx") for text in panel.labels)
    ops.export_report(filepath=str(tmp_path / "report.html"))
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "1445 lx" in page and "300 lx" in page and "1445 %" not in page
    (sensor,) = world.sensors()
    told = addon_part("angen_addon.describe").describe(sensor)
    assert told["reading"] == {"field": "illuminance_lux", "unit": "lx"}
    assert told["units"]["luminance_percent"] == "%"
    for shown in (panel.text, page):
        assert "e+0" not in shown
