# SPDX-License-Identifier: GPL-3.0-or-later
"""Every number that a user reads has the right value and unit, whatever the scene's units."""

import math

import blf
import bpy
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.layout.describe import describe
from bl_ext.user_default.angen_sensors.angen_addon.scene.lengths import with_unit
from bl_ext.user_default.angen_sensors.sensor_logic import kinds, parameters
from light_stage import facing, lamp
from panel_layout import drawn

ops = bpy.ops.angen


@pytest.fixture
def lit(world):
    """Add a lamp of 1445 lx above a light sensor by illuminance."""
    world.scene.angen_luminous_efficacy = 1.0
    lamp(world, "POINT", at=(0, 0, 10), energy=1445.0 * 4 * math.pi * 100)
    obj = world.sensor(
        "LIGHT", "light", method="ILLUMINANCE", samples=16, update_rate=24.0, threshold=300.0
    )
    obj.matrix_world = facing((0, 0, 1)).tolist()
    obj.rotation_euler = (math.pi, 0, 0)
    bpy.context.view_layer.objects.active = obj
    world.scene.frame_end = 4
    return obj


def test_light_by_illuminance_is_in_lux_wherever_it_is_shown(world, lit, tmp_path):
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
    told = describe(sensor)
    assert told["reading"] == {"field": "illuminance_lux", "unit": "lx"}
    assert told["units"]["luminance_percent"] == "%"
    for shown in (panel.text, page):
        assert "e+0" not in shown


# Unit systems, units, scales, and the texts of 4 m and of the beam of 0.31 m.
SCENES = [
    ("METRIC", "METERS", 1.0, "4 m", "0.310 m"),
    ("METRIC", "CENTIMETERS", 0.01, "4 m", "31.0 cm"),
    ("METRIC", "MILLIMETERS", 0.001, "4 m", "310 mm"),
    ("METRIC", "METERS", 100.0, "4 m", "0.310 m"),
    ("METRIC", "ADAPTIVE", 0.01, "4 m", "0.310 m"),
    ("IMPERIAL", "FEET", 1.0, "13' 1.5\"", "1.017 ft"),
    ("IMPERIAL", "INCHES", 0.0254, "13' 1.5\"", "12.20 in"),
]


@pytest.fixture(params=SCENES, ids=lambda p: f"{p[1]} {p[2]:g}")
def scaled(request, world):
    """Set the scene's units; return metres per unit and both texts."""
    system, unit, scale, *texts = request.param
    settings = world.scene.unit_settings
    settings.system, settings.length_unit, settings.scale_length = system, unit, scale
    return world.scene, scale, *texts


def read(scene, field):
    """Return the text of a field of lengths as Blender's interface shows it."""
    owner, name = field
    assert owner.bl_rna.properties[name].unit == "LENGTH"
    settings = scene.unit_settings
    metres = getattr(owner, name) * settings.scale_length
    return bpy.utils.units.to_string(
        settings.system, "LENGTH", metres, precision=4, split_unit=True
    )


def type_in(scene, field, text):
    """Type a text into a field of lengths, as in Blender's interface."""
    owner, name = field
    settings = scene.unit_settings
    metres = bpy.utils.units.to_value(settings.system, "LENGTH", text)
    setattr(owner, name, metres / settings.scale_length)


@pytest.mark.parametrize("panel", ["ANGEN_PT_active_sensor", "ANGEN_PT_physics"])
def test_lengths_are_read_and_typed_in_the_scenes_unit_and_stored_in_metres(
    scaled, world, panel, fcurves
):
    scene, _, four_metres, _ = scaled
    ops.sensor_add(kind="PIR", preset="THESIS")
    pir = bpy.context.object.angen_sensor.pir
    field = drawn(panel).fields["Range max"]
    assert read(scene, field) == four_metres
    for text, metres in (("3m", 3.0), ("10ft", 3.048), ("250cm", 2.5), ("0.75 m", 0.75)):
        type_in(scene, field, text)
        assert pir.range_max == pytest.approx(metres, rel=1e-6)
    assert bpy.context.object.keyframe_insert("angen_sensor.pir.range_max", frame=1)
    (curve,) = fcurves(bpy.context.object)
    assert curve.keyframe_points[0].co.y == pytest.approx(0.75)
    ops.preset_apply(preset="THESIS")
    assert pir.range_max == 4.0


def test_a_contradiction_is_told_in_the_scenes_unit(scaled, world):
    ops.sensor_add(kind="PIR")
    bpy.context.object.angen_sensor.pir.range_min = 6.096
    unit = {"METERS": "6.096 m", "ADAPTIVE": "6.096 m", "CENTIMETERS": "609.6 cm"}
    unit |= {"MILLIMETERS": "6096 mm", "FEET": "20 ft", "INCHES": "240 in"}
    told = drawn("ANGEN_PT_active_sensor").text
    assert f"Range min ({unit[scaled[0].unit_settings.length_unit]}) must be smaller" in told


def test_what_is_measured_is_told_in_the_scenes_unit(scaled, world):
    scene, scale, _, told = scaled
    wall = world.wall(0.31 / scale, size=1.0 / scale)
    switch = world.switch()
    bpy.context.view_layer.objects.active = switch
    ops.simulate()
    scene.frame_set(3)
    assert drawn("ANGEN_PT_active_sensor").labels[1] == f"Open, {told}"
    ops.explain()
    assert f"'{wall.name}' at {told}" in drawn("ANGEN_PT_events").text


def test_other_lengths_follow_the_scenes_unit_too(scaled, world):
    scene = scaled[0]
    obj = world.box((1, 1, 1))
    bpy.context.view_layer.objects.active = obj
    obj.angen_load.mass = 70.0
    weight, coverage = drawn("ANGEN_PT_sidebar_weight"), drawn("ANGEN_PT_coverage")
    for layout, label, owner, name in (
        (weight, "Tolerance", obj.angen_load, "tolerance"),
        (coverage, "Cell", scene.angen_coverage, "cell"),
        (drawn("ANGEN_PT_coverage_place"), "On Walls At", scene.angen_coverage, "mounting_height"),
    ):
        type_in(scene, layout.fields[label], "50cm")
        assert getattr(owner, name) == pytest.approx(0.5, rel=1e-6)


def test_without_units_the_label_has_those_that_blender_leaves_out(world):
    world.scene.unit_settings.system = "NONE"
    ops.sensor_add(kind="PIR")
    assert {"Range max (m)", "Hold time (s)", "Horizontal"} <= set(
        drawn("ANGEN_PT_active_sensor").fields
    )
    bpy.context.object.angen_sensor.pir.model = "PYROELECTRIC"
    fields = drawn("ANGEN_PT_active_sensor").fields
    assert fields["Detection (m)"][1] == "range_max" and "Range max (m)" not in fields


def test_no_label_is_wider_than_its_column():
    """40 % of the sidebar's default 235 pixels without margins, in Blender's own font."""
    blf.size(0, 11.0)
    for kind in kinds.KINDS.values():
        units = {field.unit for field in kind.samples if field.used_when} or {""}
        for name, spec in parameters.specs(kind.parameters).items():
            of_reading = spec.unit == parameters.READING
            for unit in units if of_reading else (spec.unit,):
                # Checkboxes have the wider column of values.
                room = 100 if isinstance(parameters.defaults(kind.parameters)[name], bool) else 78
                for label in (spec.short or spec.label, *(s for *_, s in spec.other_labels)):
                    assert blf.dimensions(0, with_unit(label, unit))[0] <= room, label
