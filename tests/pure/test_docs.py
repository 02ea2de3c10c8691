# SPDX-License-Identifier: GPL-3.0-or-later
"""The docs say what the code says."""

import json
import re
from pathlib import Path

import hard_cases
import parameter_tables
from benchmarks import page
from sensor_logic.study import draws, study


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
