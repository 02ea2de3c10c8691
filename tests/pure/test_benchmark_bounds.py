# SPDX-License-Identifier: GPL-3.0-or-later
"""The bounds of the benchmarks: what was published holds them, and every one of them can break."""

import copy
import math

import pytest

from benchmarks import page, peers_report, pressure_report
from benchmarks.bounds import Bounds
from benchmarks.regressions import CHECKS, broken, checked
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
    assert len(checked(name, DATA[name])) >= 15


@pytest.mark.parametrize("name", CHECKS)
def test_every_bound_can_break(name):
    """Each is broken by some figure of the data that is far off, so none is held to nothing."""
    unbroken = {figure.what for figure in checked(name, DATA[name])}
    for place, wrong in wrongs(DATA[name]):
        figures = checked(name, changed(DATA[name], place, wrong))
        unbroken -= {figure.what for figure in figures if not figure.holds}
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
    assert not any(figure.holds for figure in bounds.checked)
    assert str(bounds.checked[0]) == "a: not measured, must be at most 1"


# What regressions look like, one a part: a doctored figure, and what the message says.
REGRESSIONS = (
    # A fan that loses a fifth of its updates; ranges in single precision.
    ("home", (*rows("home", "rays", rays=640), "kept"), 0.8, "640 rays, share kept: 0.8"),
    # A sensor that skipping makes read otherwise.
    ("day", ("checked", "same"), 13, "tracks as without skipping: 13"),
    ("days", ("checked", "same"), 13, "tracks as at every frame: 13"),
    ("rays", ("ray_accuracy", "fast_rms_m"), 1e-6, "triangles, rms m"),
    # A person who is missed once in forty passes; a person who is not felt.
    (
        "pir",
        (*rows("pir", "rows", name="thesis"), "walkers", "walk", "detected"),
        0.975,
        "thesis, walk: passes detected: 0.975",
    ),
    (
        "pir_pyroelectric",
        (*rows("pir_pyroelectric", "models", situation="walk"), "pyroelectric", "detected"),
        0.5,
        "walk: passes felt: 0.5",
    ),
    # One ray of the aperture is left out; a millionth more than gravity's rounding.
    ("switch", (*rows("switch", "aperture", rays=9), "worst_error"), 0.0625, "of 9 rays"),
    ("pressure", ("accuracy", 0, "error"), 1e-5, "rest, box of 5 kg: error"),
    # A ray through the edge of a box; another home by Radiance; Cycles's paths do not converge.
    ("peers", ("rays", 0, "at_edges"), 1, "Ängen Sensors: rays past an edge: 1"),
    ("peers", ("light", "apart_rms"), 0.1, "light: difference from Radiance"),
    ("peers", ("light", "rows", 4, "rms"), 0.1, "light: Ängen Sensors (Cycles), most rays"),
    # A recording that loses readings; rays that pass walls.
    ("growth", ("recording", "rows"), 305_999, "readings of the recording: 305999"),
    (
        "coverage",
        (*rows("coverage", "rows", motion="Arm"), "covered"),
        0.9,
        "Arm: share covered",
    ),
)


@pytest.mark.parametrize(("name", "place", "wrong", "says"), REGRESSIONS)
def test_a_regression_is_told_by_its_figure_and_its_bound(name, place, wrong, says):
    found = broken(name, changed(DATA[name], place, wrong))
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
    assert all(f"| {len(checked(name, data))} of " in text for name, data in DATA.items())
    off = changed(DATA["rays"], ("ray_accuracy", "fast_m"), 1.0)
    count = len(checked("rays", off))
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
