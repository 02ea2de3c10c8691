# SPDX-License-Identifier: GPL-3.0-or-later
"""The docs agree with the code; a class name has one meaning, and each cache names its gain."""

import ast
import json
import os
import re
import subprocess
import sys
import tomllib
from collections import defaultdict
from itertools import pairwise
from pathlib import Path

import pytest
from angen_sensors.residents.acting import activity_steps
from angen_sensors.residents.routine import file, timetable
from angen_sensors.sensor_logic.kinds.pir.lenses import LENSES
from angen_sensors.studies import study

import hard_cases
import house_picture
import parameter_tables
from benchmarks import page
from benchmarks.bounds import PARTS


def test_the_parameter_page_is_up_to_date():
    written = parameter_tables.PAGE.read_text(encoding="utf-8")
    assert written == parameter_tables.page(), "run: python scripts/parameter_tables.py"


def test_the_benchmark_page_is_that_of_the_data_and_all_that_it_names_is_there():
    parts = page.known(page.DOCS / "data")
    assert set(parts) == set(PARTS), "run: python -m benchmarks"
    written = (page.DOCS / "benchmarks.md").read_text(encoding="utf-8")
    assert written == page.markdown(parts), "run: python -m benchmarks --page"


@pytest.mark.parametrize("file", page.TABLES)
def test_the_tables_of_other_pages_are_those_of_the_data(file):
    written = (page.DOCS / file).read_text(encoding="utf-8")
    assert page.with_tables(file, written, page.results(page.TABLES[file])) == written


def test_the_page_of_light_is_that_of_the_data():
    written = (page.DOCS / "light_benchmarks.md").read_text(encoding="utf-8")
    assert page.text_of("light", page.results("light")) + "\n" == written


def test_every_lens_is_told():
    written = (page.DOCS / "pir.md").read_text(encoding="utf-8")
    assert all(f"| `{name}` |" in written for name in LENSES)


def test_every_picture_and_page_that_the_benchmarks_name_is_there():
    text = (page.DOCS / "benchmarks.md").read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^)#]+)\)", text):
        assert (page.DOCS / target).exists(), target


def test_the_page_of_hard_cases_is_that_of_the_data_and_of_the_tests():
    data = json.loads(hard_cases.DATA.read_text(encoding="utf-8"))
    written = hard_cases.PAGE.read_text(encoding="utf-8")
    assert written == hard_cases.page(data), "run: python scripts/hard_cases.py --page"
    data = json.loads(hard_cases.DATA.read_text(encoding="utf-8"))
    tests = {row[4] for row in data["rows"]} | {row[3] for row in hard_cases.OTHERS}
    for path, _, name in (test.partition("::") for test in tests):
        source = (hard_cases.ROOT / path).read_text(encoding="utf-8")
        assert f"def {name}(" in source, f"{path}::{name}: run: python scripts/hard_cases.py"
    source = (hard_cases.ROOT / hard_cases.OWN).read_text(encoding="utf-8")
    written = hard_cases.PAGE.read_text(encoding="utf-8")
    for name in re.findall(r"^def (test_\w+)", source, re.MULTILINE):
        assert f"[{name}]" in written, "run: python scripts/hard_cases.py"


def test_the_way_of_a_reading_names_files_and_functions_that_are_there():
    written = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    way = written[written.index("The way of a reading") :]
    named = re.findall(r"^\d+\. `([\w/]+\.py)`, `([\w.]+)`", way, re.MULTILINE)
    assert len(named) > 15
    for found, name in named:
        (path,) = [p for p in (ROOT / found, ROOT / "angen_addon" / found) if p.exists()]
        source = path.read_text(encoding="utf-8")
        for part in name.split("."):
            assert re.search(rf"^\s*(def|class) {part}\b", source, re.MULTILINE), (found, name)


def test_the_studies_of_the_docs_can_be_read_and_stand_on_their_page():
    written = (page.DOCS / "studies.md").read_text(encoding="utf-8")
    files = sorted(Path(page.DOCS / "studies").glob("*.toml"))
    assert files
    for path in files:
        assert study.count_of(study.read(path)) > 1
        assert path.read_text(encoding="utf-8").strip() in written, path.name


def test_the_page_of_residents_has_a_routine_and_a_diary_that_can_be_read_and_all_words():
    written = (page.DOCS / "residents.md").read_text(encoding="utf-8")
    text = re.search(r"```toml\n(schema.*?)```", written, re.DOTALL).group(1)
    assert set(file.read(text, "week.toml").activities) == {"Sleeping", "Toilet", "Relaxing"}
    table = written[written.index("### Words") : written.index("### How it is acted")]
    steps = re.findall(r"`([^`]+)`", "".join(re.findall(r"^\| (`.*?) \|", table, re.MULTILINE)))
    told = {word for step in steps for word in activity_steps._WORDS if step.startswith(word)}
    assert told == set(activity_steps._WORDS)
    rows = re.search(r"    start,end.*?(?=\n\n)", written, re.DOTALL).group().replace("    ", "")
    assert [s.activity for s in timetable.read(rows, "d.csv")[1]][1::2] == ["Toilet", "Relaxing"]


def test_the_picture_of_the_house_is_that_of_the_imports():
    written = house_picture.PAGE.read_text(encoding="utf-8")
    assert written == house_picture.page(), "run: python scripts/house_picture.py"
    assert "--> " in written


def test_each_page_begins_with_what_its_reader_can_do_after_it_and_is_in_the_site():
    nav = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    pages = [path for path in page.DOCS.rglob("*.md") if path.name != "index.md"]
    assert len(pages) > 25
    for path in pages:
        paragraph = path.read_text(encoding="utf-8").split("\n\n")[1]
        assert re.match(r"After this page (you|an|each|a change)\b", paragraph), path.name
        assert f": {path.relative_to(page.DOCS).as_posix()}\n" in nav, path.name


def test_each_picture_is_on_a_page():
    pages = [*page.DOCS.rglob("*.md"), ROOT / "README.md"]
    text = "".join(path.read_text(encoding="utf-8") for path in pages)
    pictures = sorted(path.name for path in (page.DOCS / "pictures").iterdir())
    assert len(pictures) > 20
    assert [name for name in pictures if f"pictures/{name}" not in text] == []


COMMANDS = "angen|awk|blender|cat|cp|curl|dask|diff|grep|head|helm|kubectl|make|pip|python3?|touch"


def commands():
    """Yield the page and the text of each command of the docs that a user types."""
    for path in [*page.DOCS.rglob("*.md"), ROOT / "README.md"]:
        text = path.read_text(encoding="utf-8")
        blocks = re.findall(r"^```sh\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
        indented = re.findall(rf"^ {{4,}}((?:{COMMANDS}) .*(?:\\\n.*)*)", text, re.MULTILINE)
        for line in [*"".join(blocks).splitlines(), *indented]:
            yield path.name, line


def test_commands_of_the_docs_run_in_each_shell_of_windows_and_macos():
    """Neither cmd nor PowerShell has the words and signs of a POSIX shell."""
    found = list(commands())
    assert len(found) > 60
    for name, line in found:
        assert not re.match(r"(awk|cat|cp|curl|diff|grep|head|python3|touch) ", line), (name, line)
        # Lines that go on, pipes and redirections, variables, comments, quotes that are none.
        assert not re.search(r"[\\|&<>$#'`~]", line), (name, line)


def test_the_glossary_is_short_and_in_order():
    text = (page.DOCS / "glossary.md").read_text(encoding="utf-8")
    terms = re.findall(r"^\| \*\*(.+?)\*\* \|", text, re.MULTILINE)
    assert 40 <= len(terms) <= 60
    assert terms == sorted(set(terms))


def test_text_after_a_table_is_not_read_as_a_row_of_it():
    pages = [*page.DOCS.rglob("*.md"), *page.DOCS.parent.glob("*.md")]
    assert len(pages) > 20
    for path in pages:
        text = path.read_text(encoding="utf-8")
        found = re.search(r"^\|.*\|\n(?!\||\n|\Z).*", text, re.MULTILINE)
        assert found is None, f"{path.name}: {found and found.group()}"


def test_the_page_of_accuracy_says_what_was_measured():
    parts = page.known(page.DOCS / "data")
    light = page.results("light")["run"]
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
    written = " ".join((page.DOCS / "accuracy.md").read_text(encoding="utf-8").split())
    for claim in claims:
        assert claim in written, claim
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert f"| {round(speed[14], -1):.0f} times real time, 1.8 times bare Blender |" in readme
    assert f"| {speed[22]:.0f} times real time on two cores |" in readme
    both = f"{100 * rms['ILLUMINANCE']:.1f} % (lux), {100 * rms['FOUR_WALL']:.1f} % (four walls)"
    assert f"| rms error {both} |" in readme
    assert len(readme.encode()) <= 10_000


def _power(value):
    """Return a number as on the page, such as 8e-6."""
    digit, _, power = f"{value:.0e}".partition("e")
    return f"{digit}e{int(power)}"


def system():
    """Return the variables without which no program starts on Windows."""
    return {name: os.environ[name] for name in ("SYSTEMROOT",) if name in os.environ}


@pytest.mark.parametrize("name", ["learnt_days", "like_real_homes", "recogniser", "sim_to_real"])
def test_an_example_without_its_packages_is_one_line(name):
    script = page.DOCS / "examples" / f"{name}.py"
    # -S: without any installed package.
    command = [sys.executable, "-S", str(script), "days"]
    done = subprocess.run(command, capture_output=True, text=True, env=system())
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.startswith(f"{name}: No module named") and "pip install" in done.stderr
    assert done.stderr.count("\n") == 1


def test_the_twin_of_a_real_home_names_sensors_and_activities_that_it_has():
    twin = page.DOCS / "examples" / "twin"
    read = {path.stem: tomllib.loads(path.read_text("utf-8")) for path in twin.glob("*.toml")}
    routine, rules = file.read((twin / "routine.toml").read_text("utf-8"), "routine"), read["rules"]
    layout = json.loads((twin / "sensors.json").read_text("utf-8"))
    sensors = {sensor["name"] for sensor in layout["sensors"]}
    assert set(rules["rules"].values()) <= sensors
    assert set(rules["rules"]) == set(routine.activities) - {"Away"}
    homes = [table for name, table in read.items() if name not in ("routine", "rules")]
    assert len(homes) == 4
    for home in homes:
        assert set(home["sensors"].values()) <= sensors
        assert set(home["labels"].values()) <= set(routine.activities)


ROOT = Path(__file__).resolve().parents[2]


# Rules of the code

FOLDERS = ("angen_addon", "operators", "panels", "residents", "sensor_logic", "studies")
TEXTS = {
    path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8")
    for folder in FOLDERS
    for path in (ROOT / folder).rglob("*.py")
}
CACHES = re.compile(r"@(functools\.)?(lru_cache|cache)\b")
# The class of the Python package that users hold, and the class of the core that it shows; a home,
# and a home with residents.
TWICE = {"Home", "Recording"}


def test_no_two_classes_are_called_the_same() -> None:
    found = defaultdict(list)
    for name, text in TEXTS.items():
        for node in ast.parse(text).body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                found[node.name].append(name)
    assert len(found) > 300
    assert {name: files for name, files in found.items() if len(files) > 1}.keys() == TWICE


def test_each_cache_says_what_it_costs_to_go_without() -> None:
    silent, count = [], 0
    for name, text in TEXTS.items():
        for above, line in pairwise(map(str.strip, text.splitlines())):
            if CACHES.match(line):
                count += 1
                if not re.match(r"#.*\b(without|costs?|saves?|[\d.]+ (ms|µs|s))\b", above):
                    silent.append(f"{name}: {line}")
    assert count > 15 and silent == []
