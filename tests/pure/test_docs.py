# SPDX-License-Identifier: GPL-3.0-or-later
"""The docs say what the code says."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
from angen_sensors.sensor_logic.study import draws, study

import hard_cases
import parameter_tables
from benchmarks import page


def test_the_parameter_page_is_up_to_date():
    written = parameter_tables.PAGE.read_text(encoding="utf-8")
    assert written == parameter_tables.page(), "run: python scripts/parameter_tables.py"


def test_the_benchmark_page_is_that_of_the_data():
    parts = page.known(page.DOCS / "data")
    assert set(parts) == set(page.REPORTS), "run: python -m benchmarks"
    written = (page.DOCS / "benchmarks.md").read_text(encoding="utf-8")
    assert written == page.markdown(parts), "run: python -m benchmarks.page"


def test_every_picture_and_page_that_the_benchmarks_name_is_there():
    text = (page.DOCS / "benchmarks.md").read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^)#]+)\)", text):
        assert (page.DOCS / target).exists(), target


def test_the_page_of_hard_cases_is_that_of_the_data():
    data = json.loads(hard_cases.DATA.read_text(encoding="utf-8"))
    written = hard_cases.PAGE.read_text(encoding="utf-8")
    assert written == hard_cases.page(data), "run: python scripts/hard_cases.py --page"


def test_every_hard_case_has_its_test():
    data = json.loads(hard_cases.DATA.read_text(encoding="utf-8"))
    tests = {row[4] for row in data["rows"]} | {row[3] for row in hard_cases.OTHERS}
    for path, _, name in (test.partition("::") for test in tests):
        source = (hard_cases.ROOT / path).read_text(encoding="utf-8")
        assert f"def {name}(" in source, f"{path}::{name}: run: python scripts/hard_cases.py"


def test_every_test_of_hard_cases_is_in_the_page():
    source = (hard_cases.ROOT / hard_cases.OWN).read_text(encoding="utf-8")
    written = hard_cases.PAGE.read_text(encoding="utf-8")
    for name in re.findall(r"^def (test_\w+)", source, re.MULTILINE):
        assert f"[{name}]" in written, "run: python scripts/hard_cases.py"


def test_the_studies_of_the_docs_can_be_read_and_stand_on_their_page():
    written = (page.DOCS / "studies.md").read_text(encoding="utf-8")
    files = sorted(Path(page.DOCS / "studies").glob("*.toml"))
    assert files
    for file in files:
        assert draws.count(study.read(file)) > 1
        assert file.read_text(encoding="utf-8").strip() in written, file.name


def test_text_after_a_table_is_not_read_as_a_row_of_it():
    pages = [*page.DOCS.rglob("*.md"), *page.DOCS.parent.glob("*.md")]
    assert len(pages) > 20
    for file in pages:
        text = file.read_text(encoding="utf-8")
        found = re.search(r"^\|.*\|\n(?!\||\n|\Z).*", text, re.MULTILINE)
        assert found is None, f"{file.name}: {found and found.group()}"


def test_the_readme_says_what_was_measured():
    parts = page.known(page.DOCS / "data")
    light = json.loads((page.DOCS / "light_benchmarks.json").read_text(encoding="utf-8"))["run"]
    accuracy, layer = parts["rays"]["ray_accuracy"], parts["rays"]["ray_layer"]["rows"]
    ratio = {
        (row["objects"] > 1000, row["sweep"]): row["ratio"]["median"]
        for row in layer
        if (row["pirs"], row["rays"]) == (7, 120)
    }
    rms = {
        row["method"]: row["rms"]
        for row in light["rows"]
        if (row["code"], row["samples"]) == ("this", 256)
    }
    speed = {row["sensors"]: row["speed"]["median"] for row in parts["home"]["cases"]}
    claims = (
        f"Over {accuracy['rays']:,} rays of the home the worst error against float64 intersections "
        f"is {_power(accuracy['fast_m'])} m; that of Blender's own `scene.ray_cast` is "
        f"{_power(accuracy['reference_m'])} m",
        f"it is {ratio[False, 'SAWTOOTH']:.0f} times as fast",
        f"({ratio[False, 'ALL']:.0f} times when they scan all tilts at every update)",
        f"{ratio[True, 'SAWTOOTH']:.0f} times with 1000 more objects (over 1000)",
        f"an rms error of {100 * rms['ILLUMINANCE']:.1f} % (lux) and "
        f"{100 * rms['FOUR_WALL']:.1f} % (four walls)",
        f"at about {round(speed[14], -1):.0f} times real time with its detectors and switches",
        f"it runs at {speed[22]:.0f} times real time on two cores",
    )
    assert ratio[True, "ALL"] > 1000
    written = " ".join((page.DOCS.parent / "README.md").read_text(encoding="utf-8").split())
    for claim in claims:
        assert claim in written, claim


def _power(value):
    """Such as 8e-6."""
    digit, _, power = f"{value:.0e}".partition("e")
    return f"{digit}e{int(power)}"


@pytest.mark.parametrize("name", ["like_real_homes", "recogniser"])
def test_an_example_without_its_packages_is_one_line(name):
    script = page.DOCS / "examples" / f"{name}.py"
    # -S: without any package that is installed.
    command = [sys.executable, "-S", str(script), "days"]
    done = subprocess.run(command, capture_output=True, text=True, env={})
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.startswith(f"{name}: No module named") and "pip install" in done.stderr
    assert done.stderr.count("\n") == 1
