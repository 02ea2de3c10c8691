# SPDX-License-Identifier: GPL-3.0-or-later
"""The kinds of sensors: numbers in saved files, parameters and errors in them, presets, units.

Shared code names no kind. Defaults, limits, choices and fields are in docs/parameters.md, which
test_docs checks, and the columns of logs and samples in the golden files.
"""

import math
import re
from pathlib import Path

import numpy as np
import pytest
from angen_sensors.sensor_logic.kind import RAYS
from angen_sensors.sensor_logic.kinds import KINDS
from angen_sensors.sensor_logic.kinds.optical_switch import SlottedSwitch
from angen_sensors.sensor_logic.kinds.pir.lenses import LENS_PRESETS, LENSES
from angen_sensors.sensor_logic.logs.wording import Lengths, measured, percent, short, typed
from angen_sensors.sensor_logic.model import Pose, Update
from angen_sensors.sensor_logic.parameters import (
    Parameters,
    defaults,
    format_quantity,
    is_chosen,
    specs,
)

ROOT = Path(__file__).resolve().parents[2]
# Numbers are in saved files: they never change and are never reused.
NUMBERS = [
    *("PIR", "OPTICAL_SWITCH", "PRESSURE", "LIGHT", "DISTANCE", "CONTACT"),
    *("THERMAL_ARRAY", "PRESENCE_RADAR", "APPLIANCE", "FLOW"),
]
CHOICES = {
    ("PIR", "model"): ["RANGE_SCAN", "PYROELECTRIC"],
    ("PIR", "sweep"): ["SAWTOOTH", "ALL"],
    ("LIGHT", "method"): ["FOUR_WALL", "ILLUMINANCE"],
    ("LIGHT", "engine"): ["CYCLES", "EEVEE"],
    ("PRESSURE", "resistor"): ["FSR_402", "POWER_LAW"],
    ("FLOW", "flows"): ["WHILE_USED", "AFTER_USE"],
    ("APPLIANCE", "works"): ["WHILE_USED", "SWITCHED", "LINGERS", "PROGRAMME"],
    ("APPLIANCE", "load"): [
        *("CUSTOM", "MICROWAVE", "TOASTER", "KETTLE", "COFFEE_MAKER", "TELEVISION", "STOVE"),
        *("WASHING_MACHINE", "DISHWASHER", "COMPUTER", "LAMP"),
    ],
}


@pytest.mark.parametrize("name", NUMBERS)
def test_a_kind_has_what_everything_else_is_built_from(name):
    kind = KINDS[name]
    assert (kind.identifier, kind.attribute) == (name, name.lower())
    assert kind.number == 1 + NUMBERS.index(name) and len(KINDS) == len(NUMBERS)
    assert issubclass(kind.parameters, Parameters)
    assert kind.label and kind.tip and kind.icon


@pytest.mark.parametrize(("kind", "name"), CHOICES)
def test_choices_keep_their_numbers(kind, name):
    found = {c.number: c.identifier for c in specs(KINDS[kind].parameters)[name].choices}
    assert found == dict(enumerate(CHOICES[kind, name]))


IDENTIFIERS, ATTRIBUTES = "|".join(KINDS), "|".join(kind.attribute for kind in KINDS.values())
WORDS = re.compile(
    rf'"(?:{IDENTIFIERS})"'
    rf"|\b(?:settings|angen_sensor|source|target)\.(?:{ATTRIBUTES})\b"
    rf"|kinds\.(?:{ATTRIBUTES})\b"
)
# Blender has these words too: as types of objects and datablocks, and of properties.
BLENDERS = re.compile(
    r'type (?:==|!=|in|not in) [^"\n]*"LIGHT"|"LIGHT", "MATERIAL"|LIGHTLESS \| \{"LIGHT"\}'
    r'|"m": "DISTANCE"|subtype="DISTANCE"|"LIGHT", \d'
)
# Why a file may name a kind.
ALLOWED = {
    "operators/door.py": "fits a door with a switch, in a fork made for its flag",
    "operators/warmth.py": "writes the lens of a pyroelectric detector into a text",
}


def test_shared_code_names_no_kind():
    found = {}
    for folder in ("angen_addon", "operators", "panels", "sensor_logic"):
        for path in sorted((ROOT / folder).rglob("*.py")):
            name = path.relative_to(ROOT)
            text = BLENDERS.sub("", path.read_text(encoding="utf-8"))
            lines = [line.strip() for line in text.splitlines() if WORDS.search(line)]
            if lines and "kinds" not in name.parts:
                found[name.as_posix()] = lines
    assert {name: lines for name, lines in found.items() if name not in ALLOWED} == {}
    assert ALLOWED.keys() <= found.keys(), "these files name no kind any more"


# Parameters

FIGURES = [
    (kind.identifier, name)
    for kind in KINDS.values()
    for name, spec in specs(kind.parameters).items()
    if not spec.choices and not spec.pointer
    if not isinstance(getattr(kind.parameters(), name), (bool, str))
]


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
        ("FLOW", {"min_flow": 7.0}, "flowing never goes on"),
        ("FLOW", {"min_flow": 6.0}, ""),
        ("APPLIANCE", {"power": 4.0}, "on never goes on"),
        ("APPLIANCE", {"load": "LAMP", "threshold": 10.0}, "on never goes on"),
        ("APPLIANCE", {"standby_power": 5.0}, "on never goes off"),
        ("APPLIANCE", {"load": "WASHING_MACHINE", "threshold": 1900.0}, ""),
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
        ("PIR", {"range_max": 0.0}, ["range_max", "above 0 m"]),
        ("PIR", {"vertical_step": 0.0}, ["vertical_step", "0°"]),
        ("PIR", {"rays": 0}, ["rays", "at least 1"]),
        ("PIR", {"rays": 50_000}, ["50000 rays", "9 tilts"]),
        ("PIR", {"horizontal_fov": math.radians(361)}, ["horizontal_fov", "361°", "360°"]),
        ("PIR", {"hold_time": -1.0}, ["hold_time", "-1 s"]),
        ("PIR", {"model": "MAGIC"}, ["model", "MAGIC", "RANGE_SCAN"]),
        ("PIR", {"sweep": ""}, ["sweep", "SAWTOOTH, ALL"]),
        ("OPTICAL_SWITCH", {"range_min": 0.5}, ["range_min", "range_max", "0.5 m"]),
        ("OPTICAL_SWITCH", {"threshold": 0.6}, ["threshold", "range_max"]),
        ("PRESSURE", {"force_min": 20.0}, ["force_min", "force_max"]),
        ("LIGHT", {"clip_start": 5.0}, ["clip_start", "clip_end"]),
        ("CONTACT", {"close_distance": 0.03}, ["open_distance (0.02 m)", "close_distance (0.03"]),
        ("APPLIANCE", {"min_power": 3680.0}, ["min_power", "max_power"]),
        ("FLOW", {"accuracy": 1.5}, ["accuracy", "1.5"]),
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
        ("LIGHT", {"method": "ILLUMINANCE", "clip_start": 9.0}),
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


@pytest.mark.parametrize(("kind", "name"), FIGURES)
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


# Presets

PRESETS = [(kind, preset) for kind in KINDS.values() for preset in kind.presets]
IDS = [f"{kind.identifier}-{preset.identifier}" for kind, preset in PRESETS]
NAMED = {name: {p.identifier: p for p in kind.presets} for name, kind in KINDS.items()}


@pytest.mark.parametrize(("kind", "preset"), PRESETS, ids=IDS)
def test_a_preset_says_where_from_and_gives_parameters_without_problems(kind, preset):
    assert preset.label and preset.source and preset.values
    assert preset.identifier == preset.identifier.upper() and len(set(IDS)) == len(IDS)
    parameters = kind.parameters(**preset.values)
    assert parameters.problems() == [] == parameters.unreachable()
    known = specs(type(parameters))
    for name, value in preset.values.items():
        assert is_chosen(parameters, known[name].used_when), f"{name} is not used with this preset"
        default = defaults(type(parameters))[name]
        assert type(value) is type(default), f"{name} is stored as {type(default).__name__}"


@pytest.mark.parametrize(
    ("kind", "identifier"),
    [
        ("PIR", "THESIS"),
        ("OPTICAL_SWITCH", "THESIS"),
        ("PRESSURE", "FSR_402_IDEAL"),
        ("PRESSURE", "PAD"),
        ("LIGHT", "THESIS"),
    ],
)
def test_the_defaults_are_a_preset(kind, identifier):
    assert KINDS[kind].parameters(**NAMED[kind][identifier].values) == KINDS[kind].parameters()


@pytest.mark.parametrize("kind", ["PIR", "OPTICAL_SWITCH", "LIGHT"])
def test_a_thesis_preset_sets_all_that_the_thesis_gives(kind):
    preset = NAMED[kind]["THESIS"]
    of_thesis = {n for n, spec in specs(KINDS[kind].parameters).items() if "thesis" in spec.source}
    assert of_thesis <= set(preset.values)


@pytest.mark.parametrize("kind", KINDS)
def test_a_part_says_what_of_it_was_measured_and_what_is_assumed(kind):
    for identifier, preset in NAMED[kind].items():
        if identifier not in {"THESIS", "PAD"}:
            assert "Assumed:" in preset.source or "Measured:" in preset.source, identifier


def test_areas_are_those_of_the_sizes_in_the_data_sheet():
    areas = {preset.identifier: preset.values["area"] for preset in KINDS["PRESSURE"].presets}
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
    model = NAMED[kind][part].values.get("model")
    alike = [p for p in KINDS[kind].presets if p.values.get("model") == model]
    names = {p.identifier: set(p.values) for p in alike if p.identifier not in ("THESIS", "PAD")}
    assert len(names) > 5
    assert all(found == names[part] for found in names.values())


def test_a_part_has_its_physics_and_a_range_scan_says_that_it_is_one():
    for name, preset in NAMED["PIR"].items():
        is_scan = name == "THESIS" or name.endswith("_SCAN")
        assert preset.values["model"] == ("RANGE_SCAN" if is_scan else "PYROELECTRIC"), name
        assert is_scan == ("range scan" in preset.label), name
    for preset in LENS_PRESETS:
        assert "Assumed" in preset.source
        reach = LENSES[preset.values["lens"]].detection_distance
        # The trimmer's end is the other setting of one lens.
        assert preset.values["range_max"] == (7.0 if preset.identifier == "HC_SR501_MAX" else reach)


def test_a_motion_detector_has_the_same_times_and_reach_in_both_models():
    parts = NAMED["PIR"]
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


@pytest.mark.parametrize("preset", KINDS["OPTICAL_SWITCH"].presets[1:], ids=lambda p: p.identifier)
def test_a_slotted_switch_closes_by_what_is_in_its_gap(preset):
    """Free light is open, a covered aperture closed; both with numbers as Blender stores them."""
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


# Units

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


@pytest.mark.parametrize(
    ("kind", "values", "field", "unit"),
    [
        ("LIGHT", {"method": "FOUR_WALL"}, "luminance_percent", "%"),
        ("LIGHT", {"method": "ILLUMINANCE"}, "illuminance_lux", "lx"),
        ("PIR", {"model": "RANGE_SCAN"}, "angle_rad", "rad"),
        ("PIR", {"model": "PYROELECTRIC"}, "signal", "of threshold"),
    ],
)
def test_a_reading_has_the_unit_of_its_method_or_model(kind, values, field, unit):
    parameters = KINDS[kind].parameters(**values)
    found = KINDS[kind].reading(parameters)
    assert (found.name, found.unit) == (field, unit)
    if kind == "LIGHT":
        assert KINDS[kind].unit_of(specs(type(parameters))["threshold"], parameters) == unit


def test_lengths_are_shown_in_what_the_scene_shows_and_what_was_typed_has_no_exponent():
    fine = KINDS["OPTICAL_SWITCH"].fields["range_m"]
    assert fine.text(0.3104, CENTIMETRES) == "31.0 cm"
    assert fine.text(0.3048, FEET) == "1.000 ft"
    assert short(4.0, "m", CENTIMETRES) == "400 cm"
    assert CENTIMETRES.typed(0.05) == "5 cm" and FEET.typed(3.048) == "10 ft"
    # No other value is a length.
    assert measured(3.0, "N", 2, FEET) == "3.00 N"
    # Halves are rounded up.
    assert measured(27.25, "°C", 1) == short(27.25, "°C") == "27.3 °C"
    assert measured(-0.25, "°C", 1) == "-0.3 °C"
    assert typed(10_000_000.0, "Ω") == "10 MΩ" and typed(6880.0, "Ω") == "6.88 kΩ"
    assert typed(54_612.5, "lx") == "54612.5 lx"
    assert typed(2_000_000.0, "lx") == "2000000 lx"
    assert format_quantity(50.0, "reading") == "50" and format_quantity(120, "") == "120"
    assert format_quantity(math.radians(120), "rad") == "120°"


def test_the_numbers_that_a_kind_publishes_have_a_unit():
    plain = {"residual"}
    for kind in KINDS.values():
        for field in kind.fields.values():
            assert field.type is not float or field.unit or field.name in plain, field.name


@pytest.mark.parametrize(
    ("share", "text"),
    [(0.12, "12 %"), (-1.33, "133 %"), (0.0, "0 %"), (1.0, "100 %"), (0.996, "99.6 %"),
     (0.004, "0.4 %")],
)  # fmt: skip
def test_a_share_has_one_sign_and_unit(share, text):
    assert percent(share) == text
