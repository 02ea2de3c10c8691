# SPDX-License-Identifier: GPL-3.0-or-later
"""`python -m benchmarks`: its messages and exit status, with the measurements replaced."""

import copy
import json
import sys

import pytest

from benchmarks import page
from benchmarks.bounds import PARTS

DATA = page.known(page.DOCS / "data")


@pytest.fixture
def bench(monkeypatch, tmp_path, capsys):
    """Run the command in an empty place on the data given for its parts; raise given errors."""
    from benchmarks import __main__ as command

    light_holds = command._light_holds

    def run(*arguments, **parts):
        def measured(name, quick, docs):
            data = parts.get(name, DATA[name])
            if isinstance(data, Exception):
                raise data
            (docs / "data" / f"{name}.json").write_text(json.dumps(data))
            return data

        monkeypatch.setattr(command, "ROOT", tmp_path)
        monkeypatch.setattr(page, "draw", lambda folder, parts: None)
        monkeypatch.setattr(command, "_measure", measured)
        if command._light_holds is light_holds:
            monkeypatch.setattr(command, "_light_holds", lambda options: True)
        monkeypatch.setattr(sys, "argv", ["benchmarks", "--quick", *arguments])
        said = ""
        try:
            command.main()
        except SystemExit as end:
            said = str(end.code)
        return said, capsys.readouterr()

    return run


def doctored(name, *place, value):
    data = copy.deepcopy(DATA[name])
    part = data
    for key in place[:-1]:
        part = part[key]
    part[place[-1]] = value
    return data


def test_a_run_within_its_bounds_ends_well(bench):
    said, printed = bench()
    assert said == ""
    assert printed.out.startswith("# Benchmarks") and "LEFT OUT" not in printed.err


def test_a_run_out_of_its_bounds_fails_and_says_by_what(bench, tmp_path):
    worse = doctored("rays", "ray_accuracy", "fast_rms_m", value=1e-5)
    said, printed = bench(rays=worse)
    assert said.splitlines() == [
        "Figures break their bounds:",
        "rays: ray_accuracy, fast_rms_m: 1e-05, must be at most 8e-07 (single precision at 10 m is "
        "good for 1e-6)",
    ]
    assert printed.out.startswith("# Benchmarks"), "the page is written all the same"
    for name in PARTS:
        assert (tmp_path / "build" / "bench" / "data" / f"{name}.json").exists(), name


def test_a_part_that_cannot_be_measured_fails_and_the_others_go_on(bench, tmp_path):
    said, printed = bench(rays=RuntimeError("no such scene"))
    assert "rays: could not be measured: RuntimeError('no such scene')" in said
    assert "Traceback" in printed.err
    assert (tmp_path / "build" / "bench" / "data" / "coverage.json").exists()


def test_data_of_another_version_hide_no_regression(bench):
    old = {key: value for key, value in DATA["peers"].items() if key != "boxes"}
    worse = doctored("rays", "ray_accuracy", "fast_rms_m", value=1e-5)
    said, _ = bench(rays=worse, peers=old)
    assert "rays: ray_accuracy, fast_rms_m: 1e-05" in said
    assert "the pages could not be written: UndefinedError" in said


def test_what_is_not_installed_is_said_and_is_no_failure(bench):
    without = {**DATA["peers"], "missing": ["Embree (embreex)"]}
    said, printed = bench("--only", "peers", peers=without)
    assert said == ""
    assert "peers: LEFT OUT: Embree (embreex), which is not installed" in printed.err


def test_one_part_alone_is_judged_alone(bench):
    worse = doctored("rays", "ray_accuracy", "fast_rms_m", value=1e-5)
    assert bench("--only", "peers", rays=worse)[0] == ""
    assert bench("--only", "rays", rays=worse)[0] != ""


def test_spreads():
    runs = {"median": 2.0, "low": 1.0, "high": 4.0, "runs": 3}
    assert page.spread(runs) == "2.00 (1.00–4.00)"
    assert page.spread({**runs, "runs": 1}) == page.spread(2.0) == "2.00"


def test_tables_of_a_page_are_filled_between_their_markers():
    text = "before\n<!-- cost: python -m benchmarks -->\n\nold\n\n<!-- end of cost -->\nafter\n"
    made = page.with_tables("pir.md", text, DATA["pir_pyroelectric"])
    assert made == text.replace("old", page.text_of("pir_cost", DATA["pir_pyroelectric"]))


def test_light_that_is_out_of_its_bounds_fails_a_run(bench, monkeypatch):
    said, _ = bench("--only", "light")
    assert said == ""
    monkeypatch.setattr("benchmarks.__main__._light_holds", lambda options: False)
    said, _ = bench("--only", "light")
    assert "light: out of bounds" in said
