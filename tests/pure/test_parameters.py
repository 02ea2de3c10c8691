# SPDX-License-Identifier: GPL-3.0-or-later
"""Parameters out of range or in contradiction are told by name; what is valid is let pass."""

import dataclasses
import math

import pytest
from angen_sensors.sensor_logic.kinds import KINDS
from angen_sensors.sensor_logic.parameters import format_quantity, specs

NUMBERS = [
    (kind.identifier, name)
    for kind in KINDS.values()
    for name, spec in specs(kind.parameters).items()
    if not spec.choices and not spec.pointer
    if not isinstance(getattr(kind.parameters(), name), (bool, str))
]


@pytest.mark.parametrize("kind", KINDS)
def test_defaults_and_presets_are_valid(kind):
    for values in ({}, *(preset.values for preset in KINDS[kind].presets)):
        parameters = KINDS[kind].parameters(**values)
        assert parameters.problems() == []
        assert parameters.unreachable() == []


@pytest.mark.parametrize(
    ("kind", "changes", "words"),
    [
        ("DISTANCE", {"threshold": 0.04}, "near never goes on"),
        ("DISTANCE", {"threshold": 3.4, "hysteresis": 0.3}, "plus the hysteresis (0.3 m)"),
        ("DISTANCE", {"threshold": 3.3, "hysteresis": 0.3}, ""),
        ("LIGHT", {"threshold": 100.0}, "at most 100 %: once off"),
        ("LIGHT", {"threshold": 90.0, "hysteresis": 20.0}, "above 100 %"),
        ("LIGHT", {"threshold": 5.0, "hysteresis": 12.0}, "stays on in the dark"),
        ("LIGHT", {"threshold": 5.0, "hysteresis": 10.0}, ""),
        ("LIGHT", {"threshold": 2000.0, "method": "ILLUMINANCE"}, ""),
        (
            "LIGHT",
            {"threshold": 90.0, "method": "ILLUMINANCE", "output": "DIGITAL", "lux_max": 88.0},
            "at most 88 lx",
        ),
        ("OPTICAL_SWITCH", {"threshold": 0.001}, "the switch never closes"),
        ("CONTACT", {}, ""),
        ("PRESSURE", {"hysteresis": 0.9}, ""),
    ],
)
def test_an_output_that_is_stuck_is_advised_on(kind, changes, words):
    found = KINDS[kind].parameters(**changes).unreachable()
    assert bool(found) == bool(words)
    assert all(words in advice.problem and advice.mend for advice in found)


@pytest.mark.parametrize(
    ("kind", "changes", "named"),
    [
        ("PIR", {"range_min": 4.0}, ["range_min", "range_max", "4 m"]),
        ("PIR", {"range_min": 5.0}, ["range_min", "range_max", "5 m"]),
        ("PIR", {"range_max": 0.0}, ["range_max", "above 0 m"]),
        ("PIR", {"range_min": -0.1}, ["range_min", "at least 0 m"]),
        ("PIR", {"vertical_step": 0.0}, ["vertical_step", "0°"]),
        ("PIR", {"vertical_step": -1.0}, ["vertical_step"]),
        ("PIR", {"rays": 0}, ["rays", "at least 1"]),
        ("PIR", {"rays": 200_000}, ["rays", "at most 100000"]),
        ("PIR", {"rays": 50_000}, ["50000 rays", "9 tilts"]),
        ("PIR", {"horizontal_fov": math.radians(361)}, ["horizontal_fov", "361°", "360°"]),
        ("PIR", {"vertical_fov": math.radians(181)}, ["vertical_fov", "180°"]),
        ("PIR", {"threshold": -0.01}, ["threshold"]),
        ("PIR", {"noise_sigma": -0.01}, ["noise_sigma"]),
        ("PIR", {"hold_time": -1.0}, ["hold_time", "-1 s"]),
        ("PIR", {"blocking_time": -1.0}, ["blocking_time"]),
        ("PIR", {"warm_up_time": -1.0}, ["warm_up_time"]),
        ("PIR", {"model": "MAGIC"}, ["model", "MAGIC", "RANGE_SCAN"]),
        ("PIR", {"sweep": ""}, ["sweep", "SAWTOOTH, ALL"]),
        ("OPTICAL_SWITCH", {"range_min": 0.5}, ["range_min", "range_max", "0.5 m"]),
        ("OPTICAL_SWITCH", {"threshold": 0.6}, ["threshold", "range_max"]),
        ("OPTICAL_SWITCH", {"aperture_rays": 0}, ["aperture_rays"]),
        ("OPTICAL_SWITCH", {"aperture": -0.001}, ["aperture"]),
        ("OPTICAL_SWITCH", {"hysteresis": 1.0}, ["hysteresis"]),
        ("OPTICAL_SWITCH", {"hysteresis": -0.1}, ["hysteresis"]),
        ("PRESSURE", {"force_min": 20.0}, ["force_min", "force_max"]),
        ("PRESSURE", {"adc_bits": 0}, ["adc_bits"]),
        ("PRESSURE", {"area": 0.0}, ["area"]),
        ("LIGHT", {"clip_start": 5.0}, ["clip_start", "clip_end"]),
        ("LIGHT", {"samples": 0}, ["samples"]),
        ("LIGHT", {"field_of_view": 0.0}, ["field_of_view"]),
    ],
)
def test_what_is_wrong_is_named(kind, changes, named):
    problems = KINDS[kind].parameters(**changes).problems()
    assert len(problems) == 1
    for words in named:
        assert words in problems[0]


@pytest.mark.parametrize(
    ("kind", "changes"),
    [
        ("PIR", {"range_min": 0.0}),
        ("PIR", {"range_min": 3.999}),
        ("PIR", {"horizontal_fov": 2 * math.pi, "vertical_fov": math.pi}),
        ("PIR", {"horizontal_fov": 6.2831854820251465, "vertical_fov": 3.1415927410125732}),
        ("PIR", {"vertical_fov": 0.0, "horizontal_fov": 0.0, "rays": 1}),
        ("PIR", {"threshold": 0.0}),
        ("PIR", {"rays": 100_000, "vertical_fov": 0.0}),
        ("OPTICAL_SWITCH", {"threshold": 0.5}),
        ("OPTICAL_SWITCH", {"threshold": 0.0}),
        ("OPTICAL_SWITCH", {"hysteresis": 0.0}),
        ("OPTICAL_SWITCH", {"hysteresis": 0.95}),
    ],
)
def test_limits_themselves_are_valid(kind, changes):
    assert KINDS[kind].parameters(**changes).problems() == []


@pytest.mark.parametrize(("kind", "name"), NUMBERS)
def test_no_number_may_be_beyond_its_limits_nan_or_infinite(kind, name):
    cls = KINDS[kind].parameters
    for bad in (math.nan, math.inf, -math.inf):
        problems = cls(**{name: bad}).problems()
        assert problems and name in problems[0]
    spec = specs(cls)[name]
    for limit, way in ((spec.minimum, -1), (spec.maximum, 1)):
        if math.isfinite(limit):
            beyond = limit + way * max(1, abs(limit)) / 2
            whole = isinstance(getattr(cls(), name), int)
            problems = cls(**{name: math.floor(beyond) if whole and way < 0 else beyond}).problems()
            assert problems and name in problems[0]
    if spec.positive:
        assert cls(**{name: 0}).problems()


def test_several_problems_are_all_told():
    problems = KINDS["PIR"].parameters(rays=0, vertical_step=0.0, threshold=-1.0).problems()
    assert [problem.split()[0] for problem in problems] == ["rays", "vertical_step", "threshold"]


@pytest.mark.parametrize("kind", KINDS)
def test_every_parameter_explains_itself(kind):
    for name, spec in specs(KINDS[kind].parameters).items():
        assert spec.label and spec.tip, name
        assert not spec.tip.endswith("."), "Blender adds the full stop"
        assert spec.minimum <= spec.maximum


@pytest.mark.parametrize("kind", KINDS)
def test_parameters_are_frozen(kind):
    parameters = KINDS[kind].parameters()
    name = next(iter(specs(KINDS[kind].parameters)))
    with pytest.raises(dataclasses.FrozenInstanceError):
        setattr(parameters, name, 1)


def test_quantities_are_written_as_people_do():
    assert format_quantity(math.radians(120), "rad") == "120°"
    assert format_quantity(0.05, "m") == "0.05 m"
    assert format_quantity(120, "") == "120"
