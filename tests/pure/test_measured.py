# SPDX-License-Identifier: GPL-3.0-or-later
"""The tables of measured situations can be read, and their page says what the data say."""

import csv
import re

import pytest

from benchmarks import page
from benchmarks.bounds import MISSED

FILES = sorted((page.DOCS.parent / "benchmarks").glob("measured_*.csv"))
WRITTEN = (page.DOCS / "measured.md").read_text(encoding="utf-8")
# id, situation, measured, simulated, tolerance.
ROW = re.compile(r"^\| (\w+) \| (.+?) \| (\S+) \| (\S+) \| (\S+)(?: to (\S+))? \|", re.MULTILINE)


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_each_measured_row_has_a_tolerance_around_it_or_says_why_not(file):
    rows = list(csv.DictReader(file.open(encoding="utf-8", newline="")))
    assert rows
    for row in rows:
        assert all(row[key] for key in ("id", "group", "situation", "quantity", "why", "source"))
        if row["low"]:
            assert float(row["low"]) <= float(row["measured"]) <= float(row["high"]), row
        else:
            assert not row["high"] and row["why"].startswith("not rebuilt: "), row


def test_no_two_rows_have_the_same_id():
    ids = [row["id"] for f in FILES for row in csv.DictReader(f.open(encoding="utf-8"))]
    assert len(ids) == len(set(ids)) > 80


def test_the_counts_of_the_page_and_of_the_readme_are_those_of_its_table():
    table = WRITTEN[WRITTEN.index("<!-- rows:") :]
    rows = [row for row in ROW.findall(table) if row[0] != "id"]
    rebuilt = [row for row in rows if row[4] != "–"]
    within = [row for row in rebuilt if "**" not in row[3]]
    said = f"{len(within)} of {len(rebuilt)}"
    assert f"**{said}** simulated figures" in WRITTEN
    assert said in (page.DOCS.parent / "README.md").read_text(encoding="utf-8")
    for name, _, _, simulated, low, high in rebuilt:
        if "**" not in simulated:
            assert float(low) <= float(simulated) <= float(high), name


def test_each_row_out_of_tolerance_says_what_is_missing():
    rows = page.results("measured")["rows"]
    out = {row["id"] for row in rows if row["low"] is not None and not row["within"]}
    assert out <= set(MISSED), f"bounds.MISSING has no law for {sorted(out - set(MISSED))}"
    missing = WRITTEN[WRITTEN.index("<!-- misses:") : WRITTEN.index("<!-- end of misses")]
    assert all(re.search(rf"\b{name}\b", missing) for name in out)
