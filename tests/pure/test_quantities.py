# SPDX-License-Identifier: GPL-3.0-or-later
"""What people read of numbers: value, unit and format."""

import math

import pytest
from angen_sensors.sensor_logic.kinds import KINDS
from angen_sensors.sensor_logic.kinds.light import LightParameters
from angen_sensors.sensor_logic.kinds.pir.range_scan import PirParameters
from angen_sensors.sensor_logic.parameters import format_quantity, specs
from angen_sensors.sensor_logic.wording import Lengths, measured, short, typed

CENTIMETRES, FEET = Lengths("cm", 0.01), Lengths("ft", 0.3048)


@pytest.mark.parametrize(
    ("kind", "field", "value", "text", "brief"),
    [
        ("LIGHT", "illuminance_lux", 1445.3, "1445 lx", "1445 lx"),
        ("LIGHT", "illuminance_lux", 235.4, "235 lx", "235 lx"),
        ("LIGHT", "illuminance_lux", 14.52, "14.5 lx", "14.5 lx"),
        ("LIGHT", "illuminance_lux", 0.324, "0.32 lx", "0.3 lx"),
        ("LIGHT", "illuminance_lux", 100_000.0, "100000 lx", "100000 lx"),
        ("LIGHT", "illuminance_lux", 0.0, "0 lx", "0.0 lx"),
        ("LIGHT", "luminance_percent", 45.55, "45.5 %", "45.5 %"),
        ("LIGHT", "resistance_ohm", 1e6, "1 MΩ", "1 MΩ"),
        ("LIGHT", "resistance_ohm", 999_999.9, "1 MΩ", "1 MΩ"),
        ("LIGHT", "resistance_ohm", 14_000.0, "14 kΩ", "14 kΩ"),
        ("LIGHT", "voltage_v", 4.657, "4.66 V", "4.7 V"),
        ("PRESSURE", "force_n", -0.001, "0.00 N", "0.0 N"),
        ("PRESSURE", "force_n", 533.955, "533.96 N", "534 N"),
        ("PRESSURE", "force_n", math.nan, "–", "–"),
        ("OPTICAL_SWITCH", "range_m", 0.31, "0.310 m", "0.31 m"),
        ("PIR", "angle_rad", math.radians(40), "40°", "40°"),
        ("PIR", "signal", -1.739, "174 % of threshold", "174 % of threshold"),
    ],
)
def test_a_field_is_shown_in_its_own_unit(kind, field, value, text, brief):
    published = KINDS[kind].fields[field]
    assert (published.text(value), published.short(value)) == (text, brief)


def test_a_light_sensor_reads_percent_or_lux_as_its_method_says():
    kind, threshold = KINDS["LIGHT"], specs(LightParameters)["threshold"]
    for method, field, unit in (
        ("FOUR_WALL", "luminance_percent", "%"),
        ("ILLUMINANCE", "illuminance_lux", "lx"),
    ):
        parameters = LightParameters(method=method)
        assert (kind.reading(parameters).name, kind.reading(parameters).unit) == (field, unit)
        assert kind.unit_of(threshold, parameters) == unit


def test_a_motion_detector_reads_a_tilt_or_a_signal_as_its_model_says():
    for model, unit in (("RANGE_SCAN", "rad"), ("PYROELECTRIC", "of threshold")):
        assert KINDS["PIR"].reading(PirParameters(model=model)).unit == unit


def test_lengths_are_shown_in_what_the_scene_shows_them_in():
    fine = KINDS["OPTICAL_SWITCH"].fields["range_m"]
    assert fine.text(0.3104, CENTIMETRES) == "31.0 cm"
    assert fine.text(0.3048, FEET) == "1.000 ft"
    assert short(4.0, "m", CENTIMETRES) == "400 cm"
    assert CENTIMETRES.typed(0.05) == "5 cm" and FEET.typed(3.048) == "10 ft"
    # Nothing else is a length.
    assert measured(3.0, "N", 2, FEET) == "3.00 N"


def test_what_was_typed_has_no_exponent():
    assert typed(10_000_000.0, "Ω") == "10 MΩ" and typed(6880.0, "Ω") == "6.88 kΩ"
    assert typed(54_612.5, "lx") == "54612.5 lx"
    assert typed(2_000_000.0, "lx") == "2000000 lx"
    assert format_quantity(50.0, "reading") == "50"


def test_the_numbers_that_a_kind_publishes_have_a_unit():
    plain = {"residual"}
    for kind in KINDS.values():
        for field in kind.fields.values():
            assert field.type is not float or field.unit or field.name in plain, field.name


def test_clips_that_illuminance_does_not_use_contradict_nothing():
    assert LightParameters(clip_start=9.0).problems()
    assert not LightParameters(method="ILLUMINANCE", clip_start=9.0).problems()
