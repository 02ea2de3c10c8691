# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets name parameters that exist, with values that a sensor can be simulated with."""

import math

import pytest

from sensor_logic.force_resistor import ForceResistor
from sensor_logic.kinds import KINDS
from sensor_logic.parameters import defaults, specs, used
from sensor_logic.presets import PRESETS, presets_of

IDS = [f"{preset.kind}-{preset.identifier}" for preset in PRESETS]


def parameters_of(preset):
    return KINDS[preset.kind].parameters(**preset.values)


@pytest.mark.parametrize("preset", PRESETS, ids=IDS)
def test_a_preset_gives_parameters_without_problems(preset):
    parameters = parameters_of(preset)
    assert parameters.problems() == []
    known = specs(type(parameters))
    for name, value in preset.values.items():
        assert used(parameters, name, known[name]), f"{name} is not used with this preset"
        default = defaults(type(parameters))[name]
        assert type(value) is type(default), f"{name} is stored as {type(default).__name__}"


@pytest.mark.parametrize("preset", PRESETS, ids=IDS)
def test_a_preset_says_what_it_is_and_where_from(preset):
    assert preset.label and preset.source and preset.values
    assert preset.identifier == preset.identifier.upper()


def test_identifiers_are_unique_within_a_kind():
    assert len({(preset.kind, preset.identifier) for preset in PRESETS}) == len(PRESETS)


def test_presets_of_a_kind():
    assert [preset.identifier for preset in presets_of("PIR")] == ["THESIS"]
    assert [preset.identifier for preset in presets_of("OPTICAL_SWITCH")] == ["THESIS"]
    assert len(presets_of("PRESSURE")) == 7
    assert presets_of("NONE") == ()


@pytest.mark.parametrize(
    ("kind", "identifier"),
    [("PIR", "THESIS"), ("OPTICAL_SWITCH", "THESIS"), ("PRESSURE", "FSR_402_IDEAL")],
)
def test_the_defaults_are_a_preset(kind, identifier):
    (preset,) = [p for p in presets_of(kind) if p.identifier == identifier]
    assert parameters_of(preset) == KINDS[kind].parameters()


@pytest.mark.parametrize("kind", ["PIR", "OPTICAL_SWITCH"])
def test_a_thesis_preset_sets_all_that_the_thesis_gives(kind):
    (preset,) = presets_of(kind)
    of_thesis = {n for n, spec in specs(KINDS[kind].parameters).items() if "thesis" in spec.source}
    assert of_thesis <= set(preset.values)


def test_areas_are_those_of_the_sizes_in_the_data_sheet():
    areas = {preset.identifier: preset.values["area"] for preset in presets_of("PRESSURE")}
    assert areas["FSR_400"] == pytest.approx(math.pi / 4 * 0.0051**2, rel=1e-3)
    assert areas["FSR_402"] == pytest.approx(math.pi / 4 * 0.0127**2, rel=1e-3)
    assert areas["FSR_406"] == pytest.approx(0.0381**2, rel=1e-3)


def test_part_presets_set_the_same_parameters_so_that_one_replaces_another():
    names = {preset.identifier: set(preset.values) for preset in presets_of("PRESSURE")}
    assert all(found == names["FSR_402"] for found in names.values())


def test_a_larger_load_resistor_reads_higher():
    loads = ["FSR_402_3K3", "FSR_402", "FSR_402_47K", "FSR_402_100K"]
    known = {preset.identifier: parameters_of(preset) for preset in presets_of("PRESSURE")}
    volts = [ForceResistor().update(known[name], 1.0, 0.0, 0.0).voltage_v for name in loads]
    assert volts == sorted(set(volts))
