# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of kinds against the public interface, written out here."""

import math

import pytest
from angen_sensors.sensor_logic.kinds import KINDS
from angen_sensors.sensor_logic.parameters import Parameters, specs

# Numbers are in saved files: they never change and are never reused.
NUMBERS = {
    "PIR": 1,
    "OPTICAL_SWITCH": 2,
    "PRESSURE": 3,
    "LIGHT": 4,
    "DISTANCE": 5,
    "CONTACT": 6,
}
UPDATE_RATES = {**dict.fromkeys(NUMBERS, 1.0), "PIR": 10.0, "DISTANCE": 10.0, "CONTACT": 10.0}
DEGREE = math.pi / 180
DEFAULTS = {
    "PIR": {
        "model": "RANGE_SCAN",
        "horizontal_fov": 120 * DEGREE,
        "rays": 120,
        "range_min": 0.05,
        "range_max": 4.0,
        "vertical_fov": 90 * DEGREE,
        "vertical_step": 10 * DEGREE,
        "sweep": "SAWTOOTH",
        "threshold": 0.05,
        "noise_sigma": 0.0,
        "hold_time": 0.0,
        "blocking_time": 0.0,
        "warm_up_time": 0.0,
    },
    "OPTICAL_SWITCH": {
        "range_min": 0.001,
        "range_max": 0.5,
        "threshold": 0.05,
        "aperture_rays": 1,
        "aperture": 0.0,
        "noise_sigma": 0.0,
    },
    "PRESSURE": {
        "partner_object": None,
        "partner_collection": None,
        "subtract_own_weight": True,
        "force_min": 0.2,
        "force_max": 20.0,
        "load_resistor": 10_000.0,
        "supply_voltage": 5.0,
        "adc_bits": 10,
        "noise_sigma": 0.0,
    },
    "DISTANCE": {"target": "MATERIAL", "zones_across": 1, "range_max": 3.6, "noise_sigma": 0.0},
    "CONTACT": {"magnet": None, "close_distance": 0.015, "open_distance": 0.02},
    "LIGHT": {
        "method": "FOUR_WALL",
        "engine": "CYCLES",
        "clip_start": 0.5,
        "clip_end": 5.0,
        "field_of_view": 0.02,
        "exposure": 1.0,
        "gamma": 0.7,
        "noise_sigma": 0.0,
    },
}
# Parameters of the interface whose default it leaves open.
ALSO = {
    "OPTICAL_SWITCH": {"hysteresis"},
    "PRESSURE": {"threshold", "area", "report_step"},
    "LIGHT": {
        "samples",
        "threshold",
        "resistance_10lux",
        "dark_resistance",
        "load_resistor",
        "report_step",
    },
}
CHOICES = {
    ("PIR", "sweep"): {"SAWTOOTH": 0, "ALL": 1},
    ("LIGHT", "method"): {"FOUR_WALL": 0, "ILLUMINANCE": 1},
    ("LIGHT", "engine"): {"CYCLES": 0, "EEVEE": 1},
}
EVENTS = {
    "PIR": ["moved"],
    "OPTICAL_SWITCH": ["open"],
    "PRESSURE": ["pressed", "force_n", "partners", "valid"],
    "LIGHT": ["luminance_percent", "illuminance_lux", "lit"],
    "DISTANCE": ["near", "distance_m"],
    "CONTACT": ["open"],
}
SAMPLES = {
    "PIR": "angle_rad,moved,signal",
    "OPTICAL_SWITCH": "open,range_m",
    "PRESSURE": "force_n,pressed,valid,residual,resistance_ohm,voltage_v,adc,partners,"
    "cop_x_m,cop_y_m,problem",
    "LIGHT": "luminance_percent,illuminance_lux,resistance_ohm,voltage_v,lit",
    "DISTANCE": "distance_m,near,zones_m",
    "CONTACT": "open,distance_m",
}


def test_the_kinds_and_their_numbers():
    assert {name: kind.number for name, kind in KINDS.items()} == NUMBERS


@pytest.mark.parametrize("name", NUMBERS)
def test_a_kind_has_what_everything_else_is_built_from(name):
    kind = KINDS[name]
    assert kind.identifier == name
    assert kind.attribute == name.lower()
    assert issubclass(kind.parameters, Parameters)
    assert kind.update_rate == UPDATE_RATES[name]
    assert kind.label and kind.tip and kind.icon


@pytest.mark.parametrize("name", NUMBERS)
def test_defaults_of_the_interface(name):
    parameters = KINDS[name].parameters()
    found = {field: getattr(parameters, field) for field in DEFAULTS[name]}
    assert found == pytest.approx(DEFAULTS[name]) or found == DEFAULTS[name]
    assert set(specs(KINDS[name].parameters)) >= ALSO.get(name, set())


@pytest.mark.parametrize("name", NUMBERS)
def test_published_fields(name):
    assert [field.name for field in KINDS[name].events] == EVENTS[name]
    assert ",".join(field.name for field in KINDS[name].samples) == SAMPLES[name]


@pytest.mark.parametrize(("kind", "name"), CHOICES)
def test_choices_keep_their_numbers(kind, name):
    choices = specs(KINDS[kind].parameters)[name].choices
    assert {choice.identifier: choice.number for choice in choices} == CHOICES[kind, name]


def test_range_scan_is_number_0():
    choices = {c.identifier: c.number for c in specs(KINDS["PIR"].parameters)["model"].choices}
    assert choices["RANGE_SCAN"] == 0
    assert choices.get("PYROELECTRIC", 1) == 1
