# SPDX-License-Identifier: GPL-3.0-or-later
"""The bounds of the benchmarks: what was published holds them, and every one of them can break."""

import copy
import math

import pytest

from benchmarks import page, peers_report, pressure_report
from benchmarks.bounds import Bounds
from benchmarks.regressions import CHECKS, broken, held
from benchmarks.tables import short

DATA = page.known(page.DOCS / "data")


def wrongs(data, place=()):
    """Places in the data and what is wrong there: numbers far off (of lists of numbers the first
    alone), lists without rows, rows without a field."""
    for key, value in data.items() if isinstance(data, dict) else enumerate(data):
        here = (*place, key)
        if isinstance(value, dict | list):
            yield here, type(value)()
            if value and isinstance(value, list):
                # Rows that name the same thing go together.
                groups = {row.get("group") for row in value if isinstance(row, dict)}
                for group in groups:
                    yield here, [row for row in value if row.get("group") != group]
            if isinstance(value, dict):
                yield from ((here, {k: v for k, v in value.items() if k != out}) for out in value)
            yield from wrongs(value, here)
        elif isinstance(value, int | float) and not isinstance(value, bool):
            yield from ((here, value + 1e9), (here, value - 1e9))
            if isinstance(data, list):
                return


def at(data, place):
    for key in place:
        data = data[key]
    return data


def changed(data, place, value):
    """The data with one figure replaced, by shallow copies along its way."""
    if not place:
        return value
    part = copy.copy(data)
    part[place[0]] = changed(part[place[0]], place[1:], value)
    return part


def doctored(name, *places_and_values):
    """A part's data with figures replaced; a place is where `row` says, then a path."""
    data = DATA[name]
    for place, value in places_and_values:
        data = changed(data, tuple(place), value)
    return data


def rows(part, /, *way, **known):
    """The number of the first row in a list of the data whose fields are as told."""
    found = at(DATA[part], way)
    index = next(
        i for i, row in enumerate(found) if all(row[key] == value for key, value in known.items())
    )
    return (*way, index)


def test_every_part_has_bounds():
    assert set(CHECKS) == set(page.REPORTS)


@pytest.mark.parametrize("name", CHECKS)
def test_what_was_published_holds_its_bounds(name):
    assert broken(name, DATA[name]) == []
    assert len(held(name, DATA[name])) >= 15


@pytest.mark.parametrize("name", CHECKS)
def test_every_bound_can_break(name):
    """Each is broken by some figure of the data that is far off, so none is held to nothing."""
    unbroken = {figure.what for figure in held(name, DATA[name])}
    for place, wrong in wrongs(DATA[name]):
        unbroken -= {f.what for f in held(name, changed(DATA[name], place, wrong)) if not f.holds}
        if not unbroken:
            break
    assert not unbroken


@pytest.mark.parametrize("name", CHECKS)
@pytest.mark.parametrize("wrong", [math.nan, math.inf])
def test_no_figure_may_be_no_number(name, wrong):
    figures = {k: v for k, v in DATA[name].items() if isinstance(v, dict | list)}
    place = next(place for place, value in wrongs(figures) if isinstance(value, float))
    text = broken(name, changed(DATA[name], place, wrong))
    assert any("a number at" in line for line in text)


@pytest.mark.parametrize("name", CHECKS)
def test_a_part_that_measured_nothing_is_broken(name):
    assert broken(name, {"machine": "", "quick": True, "took_s": 0.0})
    for key, value in DATA[name].items():
        # What describes the part holds no figures.
        if isinstance(value, dict | list) and key not in ("base", "missing"):
            without = {k: v for k, v in DATA[name].items() if k != key}
            assert broken(name, without), key
            assert broken(name, {**without, key: type(value)()}), key


def test_a_figure_that_was_not_measured_breaks_every_kind_of_bound():
    bounds = Bounds()
    for figure in (None, math.nan, "0"):
        bounds.at_most("a", figure, 1)
        bounds.at_least("b", figure, 0)
        bounds.within("c", figure, 0, 1)
        bounds.equal("d", figure, 0)
    assert not any(figure.holds for figure in bounds.held)
    assert str(bounds.held[0]) == "a: not measured, must be at most 1"


ACCURACY = ("ray_accuracy",)
PIR = ("rows",)
# What regressions look like: part, doctored figures, and what the message says.
REGRESSIONS = (
    # A fan that loses a fifth of its updates; says what is not there; updates that are not taken.
    ("home", [((*rows("home", "rays", rays=640), "kept"), 0.8)], "640 rays, share kept: 0.8"),
    ("home", [((*rows("home", "rays", rays=80), "extra"), 0.05)], "80 rays, share said alone"),
    ("home", [((*rows("home", "cases", sensors=15), "updates"), 360)], "updates of 'and a pad'"),
    ("home", [((*rows("home", "cases", sensors=22), "sensors"), 21)], "sensors of 'and 7 light"),
    ("home", [((*rows("home", "far", far_m=20.0), "percent"), 30.0)], "by a farther plane"),
    # Ranges in single precision, world coordinates; one update that says otherwise; none that see.
    ("rays", [((*ACCURACY, "fast_rms_m"), 1e-6)], "triangles, rms m"),
    ("rays", [((*ACCURACY, "fast_m"), 4.5e-5)], "triangles, worst m"),
    ("rays", [((*ACCURACY, "apart_fast_m"), 4.5e-5)], "where scene.ray_cast differs"),
    ("rays", [(("ray_layer", "rows", 3, "updates_that_differ"), 1)], "updates that differ: 1"),
    ("rays", [(("ray_layer", "rows", 3, "worst_range_error_m"), 1e-3)], "range difference m"),
    ("rays", [(("ray_layer", "rows", 3, "updates_with_motion"), 0)], "updates with movement: 0"),
    ("rays", [(("ray_layer", "rows", 3, "updates"), 100)], "updates: 100"),
    # A person who is missed once in forty passes; a sweep that comes late; flicker; a false alarm.
    (
        "pir",
        [((*rows("pir", *PIR, name="thesis"), "walkers", "walk", "detected"), 0.975)],
        "thesis, walk: passes detected: 0.975",
    ),
    (
        "pir",
        [((*rows("pir", *PIR, name="thesis"), "walkers", "child", "latency_s"), 1.0)],
        "thesis, child: median latency s: 1",
    ),
    (
        "pir",
        [((*rows("pir", *PIR, name="recommended"), "walkers", "cat", "said"), 0.2)],
        "recommended, cat: updates of the dense one's",
    ),
    (
        "pir",
        [((*rows("pir", *PIR, name="thesis"), "walkers", "walk", "early"), 1)],
        "thesis, walk: updates that said so before it set off: 1",
    ),
    # Half of the peak is lost; who is as warm as the room is felt; a person is not.
    (
        "pir_pyroelectric",
        [((*rows("pir_pyroelectric", "error", zone_rays=12, rate=24.0), "rms"), 0.1)],
        "12 rays a zone at 24 Hz",
    ),
    (
        "pir_pyroelectric",
        [
            (
                (
                    *rows(
                        "pir_pyroelectric",
                        "models",
                        situation="walk of something as warm as the room",
                    ),
                    "pyroelectric",
                    "detected",
                ),
                0.05,
            )
        ],
        "as warm as the room: passes felt: 0.05",
    ),
    (
        "pir_pyroelectric",
        [
            (
                (*rows("pir_pyroelectric", "models", situation="walk"), "pyroelectric", "detected"),
                0.5,
            )
        ],
        "walk: passes felt: 0.5",
    ),
    # One ray of the aperture is left out; no hysteresis; a flag that every second look misses.
    ("switch", [((*rows("switch", "aperture", rays=9), "worst_error"), 0.0625)], "of 9 rays"),
    ("switch", [((*rows("switch", "aperture", rays=9), "changes"), 172)], "changes of a shaking"),
    (
        "switch",
        [((*rows("switch", "flags", width_m=0.01, substeps=1), "seen"), 0.12)],
        "card, 1 cm at 1 m/s, 1 substeps: share seen: 0.12",
    ),
    (
        "switch",
        [((*rows("switch", "flags", width_m=0.1, substeps=1), "seen"), 0.995)],
        "flag of a door",
    ),
    ("switch", [(("swept", 3, "seen"), 0.99)], "0.5 mm at 1 m/s, swept: share seen: 0.99"),
    ("switch", [(("swept", 0, "wrong"), 1)], "swept: said at another update: 1"),
    # A millionth more than gravity's rounding; a leg that takes its neighbour's; pads that give up.
    ("pressure", [(("accuracy", 0, "error"), 1e-5)], "rest, box of 5 kg: error"),
    ("pressure", [(("accuracy", 0, "mujoco"), 1e-4)], "difference from MuJoCo"),
    ("pressure", [(("accuracy", 0, "valid"), 46)], "rest, box of 5 kg: valid updates"),
    (
        "pressure",
        [((*rows("pressure", "accuracy", group="four legs"), "error"), 0.01)],
        "four legs, table of 20 kg",
    ),
    ("pressure", [((*rows("pressure", "accuracy", group="drop"), "error"), 0.01)], "drop, 2 kg"),
    ("pressure", [(("table", "worst_newtons"), 0.05)], "legs of the sample's table"),
    ("pressure", [((*rows("pressure", "resistor", by_hand=642), "adc"), 641)], "ADC at 1 N: 641"),
    ("pressure", [(("speed", "island", 0, "error"), 1e-4)], "island of 1"),
    # Ranges as bad as Blender's own; a ray through the edge of a box; the closed form is wrong.
    ("peers", [(("rays", 0, "rms_m"), 1.2e-6)], "Ängen Sensors: range, rms m"),
    ("peers", [(("rays", 0, "worst_m"), 2.8e-5)], "Ängen Sensors: range, worst m"),
    ("peers", [(("rays", 0, "at_edges"), 1)], "Ängen Sensors: rays past an edge: 1"),
    (
        "peers",
        [((*rows("peers", "rays", engine="MuJoCo rangefinder"), "worst_m"), 1e-5)],
        "MuJoCo rangefinder: closed form",
    ),
    ("peers", [(("touch", "ours_error"), 1e-4)], "a box on a pad: error"),
    # The home through Radiance is another; Cycles's paths do not come together.
    ("peers", [(("light", "apart_rms"), 0.1)], "light: difference from Radiance"),
    ("peers", [(("light", "rows", 4, "rms"), 0.1)], "light: Ängen Sensors (Cycles), most rays"),
    # A recording that loses readings.
    ("growth", [(("recording", "rows"), 305_999)], "readings of the recording: 305999"),
    # Rays that pass walls; a map that depends on the moment; zones that are turned.
    (
        "coverage",
        [((*rows("coverage", "rows", motion="Arm"), "covered"), 0.9)],
        "Arm: share covered",
    ),
    (
        "coverage",
        [((*rows("coverage", "rows", motion="Step"), "phases_differ"), 0.1)],
        "Step: cells that another moment",
    ),
    (
        "coverage",
        [((*rows("coverage", "sizes", size=0.25), "error"), -0.05)],
        "cells of 0.25 m: error",
    ),
    (
        "coverage",
        [((*rows("coverage", "sizes", size=0.125), "disagree"), 0.1)],
        "cells of 0.125 m: share that differs",
    ),
    ("coverage", [(("office", "zones", 2, "share"), 0.9)], "office, zones, three detectors"),
    ("coverage", [(("office", "zones", 0, "share"), 0.4)], "office, zones, one detector"),
)


@pytest.mark.parametrize(("name", "wrong", "says"), REGRESSIONS)
def test_a_regression_is_told_by_its_figure_and_its_bound(name, wrong, says):
    found = broken(name, doctored(name, *wrong))
    assert any(says in line and ", must be " in line for line in found), found
    assert len(found) <= 3, "one figure is off, and it alone is told"


def test_noise_that_raises_an_alarm_is_a_regression():
    quiet = {"group": "noise and a threshold of 7 σ√2, all tilts", "name": "0.01 m, 0.099 m"}
    chosen = [row for row in DATA["pir"]["rows"] if row["group"] == "chosen"]
    still = {**chosen[2], **quiet, "false_alarms_an_hour": 0.0}
    assert broken("pir", {**DATA["pir"], "rows": [*chosen, still]}) == []
    loud = {**still, "false_alarms_an_hour": 6.0}
    (found,) = broken("pir", {**DATA["pir"], "rows": [*chosen, loud]})
    assert found == "pir: false alarms with noise of 0.01 m, 0.099 m: 6, must be 0.0"


def test_times_are_never_broken():
    slow = changed(DATA["home"], ("cases", 0, "speed", "median"), 1e-9)
    assert broken("home", slow) == []


def test_the_page_tells_how_many_bounds_are_held():
    text = page.markdown(DATA)
    assert all(f"| {len(held(name, data))} of " in text for name, data in DATA.items())
    off = doctored("rays", ((*ACCURACY, "fast_m"), 1.0))
    count = len(held("rays", off))
    assert f"| **{count - 1} of {count}** |" in page.markdown({**DATA, "rays": off})


def test_the_page_begins_with_ratios_to_others():
    head = page.markdown(DATA).partition("| part |")[0]
    light = DATA["peers"]["light"]["seconds"]
    times = light["Radiance `rtrace`"] / light["Ängen Sensors (Cycles)"]
    assert f"| Radiance `rtrace` | {short(times, 2)} times as fast |" in head
    for peer in ("bare evaluation", "Blender's `scene.ray_cast`", "MuJoCo", "Embree"):
        assert peer in head


def test_what_is_left_out_is_told():
    data = {**DATA["peers"], "missing": ["Embree (embreex)"], "touch": None, "light": None}
    assert peers_report.left_out(DATA["peers"]) == []
    assert peers_report.left_out(data) == [
        "Embree (embreex), which is not installed",
        "MuJoCo's touch sensor, which is not installed",
        "Radiance (pyradiance), which is not installed",
    ]
    assert pressure_report.left_out({**DATA["pressure"], "mujoco": False})
