# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets name parameters that exist, with values that a sensor can be simulated with."""

import math

import numpy as np
import pytest
from angen_sensors.sensor_logic.kind import RAYS
from angen_sensors.sensor_logic.kinds import KINDS
from angen_sensors.sensor_logic.kinds.optical_switch import SlottedSwitch
from angen_sensors.sensor_logic.kinds.pressure import ForceResistor
from angen_sensors.sensor_logic.model import Pose, Update
from angen_sensors.sensor_logic.parameters import defaults, is_chosen, specs

PRESETS = [(kind, preset) for kind in KINDS.values() for preset in kind.presets]
IDS = [f"{kind.identifier}-{preset.identifier}" for kind, preset in PRESETS]


def presets_of(kind):
    return KINDS[kind].presets


def parameters_of(kind, preset):
    return KINDS[kind].parameters(**preset.values)


def named(kind):
    return {preset.identifier: preset for preset in presets_of(kind)}


@pytest.mark.parametrize(("kind", "preset"), PRESETS, ids=IDS)
def test_a_preset_gives_parameters_without_problems(kind, preset):
    parameters = kind.parameters(**preset.values)
    assert parameters.problems() == []
    known = specs(type(parameters))
    for name, value in preset.values.items():
        assert is_chosen(parameters, known[name].used_when), f"{name} is not used with this preset"
        default = defaults(type(parameters))[name]
        assert type(value) is type(default), f"{name} is stored as {type(default).__name__}"


@pytest.mark.parametrize(("kind", "preset"), PRESETS, ids=IDS)
def test_a_preset_says_what_it_is_and_where_from(kind, preset):
    assert preset.label and preset.source and preset.values
    assert preset.identifier == preset.identifier.upper()


def test_identifiers_are_unique_within_a_kind():
    assert len(set(IDS)) == len(IDS)


def test_presets_of_a_kind():
    assert {"THESIS", "HC_SR501", "EKMC1601111", "HAA53_SCAN"} <= set(named("PIR"))
    assert {"THESIS", "TCST1103", "GP1A53HR", "EE_SX670"} <= set(named("OPTICAL_SWITCH"))
    assert len(presets_of("PRESSURE")) == 7
    assert {"THESIS", "GL5516", "GL5528", "GL5539", "BH1750FVI", "VEML7700"} <= set(named("LIGHT"))


@pytest.mark.parametrize(
    ("kind", "identifier"),
    [
        ("PIR", "THESIS"),
        ("OPTICAL_SWITCH", "THESIS"),
        ("PRESSURE", "FSR_402_IDEAL"),
        ("LIGHT", "THESIS"),
    ],
)
def test_the_defaults_are_a_preset(kind, identifier):
    (preset,) = [p for p in presets_of(kind) if p.identifier == identifier]
    assert parameters_of(kind, preset) == KINDS[kind].parameters()


@pytest.mark.parametrize("kind", ["PIR", "OPTICAL_SWITCH", "LIGHT"])
def test_a_thesis_preset_sets_all_that_the_thesis_gives(kind):
    preset = named(kind)["THESIS"]
    of_thesis = {n for n, spec in specs(KINDS[kind].parameters).items() if "thesis" in spec.source}
    assert of_thesis <= set(preset.values)


def test_areas_are_those_of_the_sizes_in_the_data_sheet():
    areas = {preset.identifier: preset.values["area"] for preset in presets_of("PRESSURE")}
    assert areas["FSR_400"] == pytest.approx(math.pi / 4 * 0.0051**2, rel=1e-3)
    assert areas["FSR_402"] == pytest.approx(math.pi / 4 * 0.0127**2, rel=1e-3)
    assert areas["FSR_406"] == pytest.approx(0.0381**2, rel=1e-3)


@pytest.mark.parametrize(
    ("kind", "part"),
    [
        ("PRESSURE", "FSR_402"),
        ("PIR", "HC_SR501"),
        ("PIR", "HC_SR501_SCAN"),
        ("OPTICAL_SWITCH", "EE_SX670"),
    ],
)
def test_part_presets_set_the_same_parameters_so_that_one_replaces_another(kind, part):
    model = named(kind)[part].values.get("model")
    alike = [p for p in presets_of(kind) if p.values.get("model") == model]
    names = {p.identifier: set(p.values) for p in alike if p.identifier != "THESIS"}
    assert len(names) > 5
    assert all(found == names[part] for found in names.values())


def test_a_part_has_its_physics_and_a_range_scan_says_that_it_is_one():
    for name, preset in named("PIR").items():
        is_scan = name == "THESIS" or name.endswith("_SCAN")
        assert preset.values["model"] == ("RANGE_SCAN" if is_scan else "PYROELECTRIC"), name
        assert is_scan == ("range scan" in preset.label), name


def test_a_motion_detector_has_the_same_times_and_reach_in_both_models():
    parts = named("PIR")
    both = [name for name in parts if f"{name}_SCAN" in parts]
    assert {"HC_SR501", "EKMC1601111", "EKMC1603111", "EKMC1604111"} <= set(both)
    for name in both:
        for what in ("range_max", "hold_time", "blocking_time", "warm_up_time"):
            assert parts[name].values[what] == parts[f"{name}_SCAN"].values[what], (name, what)
    hc = parts["HC_SR501_SCAN"].values
    assert math.degrees(hc["horizontal_fov"]) == pytest.approx(120)
    assert math.degrees(hc["vertical_fov"]) == pytest.approx(60), "half of a cone is below"


class Beam:
    """A flag whose edge covers a share of the aperture, in the middle of the gap."""

    def __init__(self, gap, covered, aperture):
        self.gap, self.edge = gap, (covered - 0.5) * aperture

    def cast(self, bundle, origins, directions, reach):
        stopped = origins[:, 0] < self.edge
        return np.where(stopped, np.minimum(self.gap / 2, reach), reach)


@pytest.mark.parametrize("preset", presets_of("OPTICAL_SWITCH")[1:], ids=lambda p: p.identifier)
def test_a_slotted_switch_closes_by_what_is_in_its_gap(preset):
    """Clear light is open, a covered aperture closed; both as Blender stores the numbers."""
    stored = {k: float(np.float32(v)) if type(v) is float else v for k, v in preset.values.items()}
    parameters = KINDS["OPTICAL_SWITCH"].parameters(**stored)
    pose = Pose(np.zeros(3), np.eye(3))
    switch = SlottedSwitch()
    width = parameters.aperture or 1e-4
    seen = []
    for covered in (-0.2, 0.3, 0.7, 1.2, 0.5, 0.3):
        beam = Beam(parameters.range_max, covered, width)
        update = Update(0, 0.0, pose, {RAYS: beam.cast})
        seen.append(switch.update(parameters, update).active)
    expected = [True, True, False, False, False, True]
    assert seen == (expected if parameters.aperture else [True, True, False, False, True, True])


def test_a_larger_load_resistor_reads_higher():
    loads = ["FSR_402_3K3", "FSR_402", "FSR_402_47K", "FSR_402_100K"]
    known = {
        preset.identifier: parameters_of("PRESSURE", preset) for preset in presets_of("PRESSURE")
    }
    volts = [ForceResistor().update(known[name], 1.0, 0.0, 0.0).voltage_v for name in loads]
    assert volts == sorted(set(volts))
