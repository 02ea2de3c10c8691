# SPDX-License-Identifier: GPL-3.0-or-later
"""The bounds of the benchmarks: the published results are within them, and each can break."""

import copy
import math

import pytest

from benchmarks import bounds, page
from benchmarks.bounds import PARTS, broken, checked, left_out

DATA = page.known(page.DOCS / "data")


def wrongs(data, place=()):
    """Return places in the data with wrong values.

    Numbers far off (of lists of numbers only the first), lists without rows, and rows without a
    field.
    """
    for key, value in data.items() if isinstance(data, dict) else enumerate(data):
        here = (*place, key)
        if isinstance(value, dict | list):
            yield here, type(value)()
            if value and isinstance(value, list):
                # Rows of the same thing belong together.
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


def first_of_each(places):
    """Return places with wrong values in another order: of those in a list, first one each."""
    kinds, rest = {}, []
    for place, wrong in places:
        kind = tuple("" if isinstance(key, int) else key for key in place), str(wrong)[:1]
        if kind in kinds:
            rest.append((place, wrong))
        else:
            kinds[kind] = place, wrong
    return [*kinds.values(), *rest]


def at(data, place):
    for key in place:
        data = data[key]
    return data


def changed(data, place, value):
    """Return the data with one figure replaced, by shallow copies along its path."""
    if not place:
        return value
    part = copy.copy(data)
    part[place[0]] = changed(part[place[0]], place[1:], value)
    return part


@pytest.mark.parametrize("name", PARTS)
def test_what_was_published_holds_its_bounds(name):
    assert broken(name, DATA[name]) == []
    assert len(checked(name, DATA[name])) >= 15


# Not of those whose thousands of figures take a minute; of pads they take half of one.
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.slow) if name == "pressure" else name
        for name in PARTS
        if name not in ("pir", "measured")
    ],
)
def test_every_bound_can_break(name):
    """Each is broken by some wrong figure of the data, so none is empty."""
    unbroken = {figure.what for figure in checked(name, DATA[name])}
    for place, wrong in first_of_each(wrongs(DATA[name])):
        figures = checked(name, changed(DATA[name], place, wrong))
        unbroken -= {figure.what for figure in figures if not figure.holds}
        if not unbroken:
            break
    assert not unbroken


@pytest.mark.parametrize("name", PARTS)
@pytest.mark.parametrize("wrong", [math.nan, math.inf])
def test_no_figure_may_be_no_number(name, wrong):
    figures = {k: v for k, v in DATA[name].items() if isinstance(v, dict | list)}
    place = next(place for place, value in wrongs(figures) if isinstance(value, float))
    text = broken(name, changed(DATA[name], place, wrong))
    assert any("a number at" in line for line in text)


@pytest.mark.parametrize("name", PARTS)
def test_a_part_that_measured_nothing_is_broken(name):
    assert broken(name, {"machine": "", "quick": True, "took_s": 0.0})
    for key, value in DATA[name].items():
        # Fields that describe the part are no figures.
        if isinstance(value, dict | list) and key not in ("base", "missing"):
            without = {k: v for k, v in DATA[name].items() if k != key}
            assert broken(name, without), key
            assert broken(name, {**without, key: type(value)()}), key


def test_a_figure_that_was_not_measured_breaks_every_kind_of_bound(monkeypatch):
    lines = [("", "a", limit, "") for limit in ("<= 1", ">= 0", "== 0", "0 … 1")]
    monkeypatch.setattr(bounds, "BOUNDS", {"rays": lines})
    for figure in (None, math.nan, "0"):
        figures = [f for f in checked("rays", {"a": figure}) if f.what == "a"]
        assert len(figures) == len(lines) and not any(f.holds for f in figures)
    assert all(f.holds for f in checked("rays", {"a": 0}))
    assert str(checked("rays", {"a": 3})[0]) == "a: 3, must be at most 1"


def test_times_are_never_broken():
    slow = changed(DATA["home"], ("cases", 0, "speed", "median"), 1e-9)
    assert broken("home", slow) == []


def test_what_is_left_out_is_told():
    data = {**DATA["peers"], "missing": ["Embree (embreex)"], "touch": None, "light": None}
    assert left_out("peers", DATA["peers"]) == left_out("rays", DATA["rays"]) == []
    assert left_out("peers", data) == [
        "Embree (embreex), which is not installed",
        "MuJoCo's touch sensor, which is not installed",
        "Radiance (pyradiance), which is not installed",
    ]
    assert left_out("pressure", {**DATA["pressure"], "mujoco": False})
