# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of a study as pandas reads them, and its report, from artificial rows."""

from __future__ import annotations

import json
import math
import re
import xml.etree.ElementTree as ET
from importlib import import_module
from itertools import combinations, product
from pathlib import Path
from typing import Any

import pytest
from angen_sensors.angen_addon.process.standalone import load_extension

NEEDED = ("jinja2", "matplotlib", "pandas", "pyarrow", "scipy")

# Two seeds of three settings; a run of the last setting failed.
ROWS = [
    {
        "run": 2 * n + s,
        "PIR*.rays": rays,
        "PIR*.sweep": sweep,
        "seed": s,
        "events": 10 * rays + s if not (n == 2 and s == 2) else None,
        "share": 0.5 * n,
        "numpy": "2.0",
        "seconds": 1.25,
        "digest": f"{n}{s}",
        "error": "it is <too> much" if n == 2 and s == 2 else "",
    }
    for n, (rays, sweep) in enumerate([(5, "ALL"), (10, "ALL"), (10, "SAWTOOTH")])
    for s in (1, 2)
]


@pytest.fixture
def report(reader) -> Any:
    """Return the module of the report, if the packages that it needs are installed."""
    for needed in NEEDED:
        reader(needed)
    load_extension()
    return import_module("angen_sensors.studies.report")


@pytest.fixture
def write_tables(report) -> Any:
    return import_module("angen_sensors.studies.results").write_tables


@pytest.fixture
def folder(tmp_path: Path, write_tables) -> Path:
    assert write_tables(tmp_path, ROWS) == []
    facts = {
        "name": "try.toml", "varied": ["PIR*.rays", "PIR*.sweep"], "seeds": 2, "runs": 7,
        "best": ["most", "events"][::-1], "homes": ["home.blend"],
    }  # fmt: skip
    (tmp_path / "study.json").write_text(json.dumps(facts))
    return tmp_path


def test_both_tables_are_the_rows(folder, reader) -> None:
    pandas = reader("pandas")
    comma = pandas.read_csv(folder / "results.csv")
    parquet = pandas.read_parquet(folder / "results.parquet")
    assert list(comma) == list(parquet) == [
        "run", "PIR*.rays", "PIR*.sweep", "seed", "events", "share", "numpy",
        "seconds", "digest", "error",
    ]  # fmt: skip
    assert parquet["share"].tolist() == comma["share"].tolist() == [0, 0, 0.5, 0.5, 1, 1]
    assert parquet["events"].tolist()[:5] == [51, 52, 101, 102, 101]
    assert parquet["events"].isna().tolist() == comma["events"].isna().tolist()
    assert parquet["error"].tolist() == ["", "", "", "", "", "it is <too> much"]
    assert str(parquet["PIR*.rays"].dtype) == "int64"


def test_the_report_tells_what_is_in_the_rows(folder, report) -> None:
    page = report.write(folder).read_text(encoding="utf-8")
    assert "5 of 7 runs went well, 1 failed, 1 was not run yet." in page
    assert "it is &lt;too&gt; much" in page
    # Means over two seeds: ± t(1) × sd / √2 = 12.71 × 0.7071 / 1.4142; of one seed alone, none.
    cells = re.findall(r'<td class="n" data-v="[^"]*">([^<]*)</td>', page)
    assert "101.5 ± 6.4" in cells and "51.5 ± 6.4" in cells and "101" in cells
    best = page[page.index("Best settings") : page.index("Responses")]
    assert best.index("101.5") < best.index("101<") < best.index("51.5")
    pictures = sorted((folder / "pictures").iterdir())
    assert [p.name for p in pictures] == [
        "01 events against what varied.svg",
        "02 share against what varied.svg",
        "03 seconds against what varied.svg",
        "04 events over PIR_.rays and PIR_.sweep.svg",
    ]
    for picture in pictures:
        texts = [e.text for e in ET.parse(picture).iter("{http://www.w3.org/2000/svg}text")]
        assert "PIR*.rays" in texts
    # The page loads nothing, and the same rows give the same page.
    assert "src=" not in page and 'href="http' not in page.replace("xlink:href", "")
    assert report.write(folder).read_text(encoding="utf-8") == page


def test_many_sets_of_sensors_are_shown_by_their_number(tmp_path, report, write_tables) -> None:
    sets = [s for count in (1, 2, 3) for s in combinations("abcdef", count)]
    rows = [
        {
            "run": number, "sensors": "; ".join(chosen), "seed": seed, "sensors_on": len(chosen),
            "noticed": 0.2 * len(chosen) + 0.1 * ("c" in chosen), "digest": str(number),
            "error": "",
        }
        for number, (chosen, seed) in enumerate(product(sets, (1, 2)))
    ]  # fmt: skip
    write_tables(tmp_path, rows)
    facts = {
        "name": "s.toml", "varied": ["sensors"], "seeds": 2, "runs": len(rows),
        "best": ["noticed", "most"], "homes": ["home.blend"],
    }  # fmt: skip
    (tmp_path / "study.json").write_text(json.dumps(facts))
    page = report.write(tmp_path).read_text(encoding="utf-8")
    table = page[page.index("By number of sensors") : page.index("Responses")]
    assert re.findall(r"<tr><td>([^<]*)</td>", table) == ["c", "a; c", "a; b; c"]
    drawn = (tmp_path / "pictures" / "01 noticed against what varied.svg").read_text()
    assert "sensors on" in drawn and "a; b" not in drawn
    found = report.read(tmp_path / "results.csv", ["sensors"])
    best = report.rank_settings(found, found.settings["noticed"], "most")
    shown = report.results_to_plot(found, best)
    assert shown.varied == ["sensors on"]
    assert shown.rows["sensors on"].tolist() == ["1", "1", "2", "2", "3", "3"]
    assert shown.rows["noticed"].tolist() == pytest.approx([0.3, 0.3, 0.5, 0.5, 0.7, 0.7])


def test_a_mean_counts_each_seed_once_and_its_interval_is_students(report, reader) -> None:
    # Three seeds with means 1, 2 and 6: sd 2.6458, t(2) = 4.3027; the other setting has one seed.
    rows = reader("pandas").DataFrame(
        {
            "setting": [0, 0, 0, 0, 0, 1, 1],
            "seed": ["1", "1", "2", "3", "3", "1", "1"],
            "events": [0.0, 2.0, 2.0, 6.0, math.nan, 0.0, 2.0],
        }
    )
    found = report.means(rows, [rows["setting"]], ["events"])
    assert found.value["events"].tolist() == pytest.approx([3.0, 1.0])
    half = 4.30265 * 2.645751 / math.sqrt(3)
    assert found.half["events"].tolist() == pytest.approx([half, math.nan], rel=1e-5, nan_ok=True)


def test_levels_are_values_bins_or_names(report, reader) -> None:
    def levels(values: list[str]) -> Any:
        return report.levels(reader("pandas").Series(values))

    assert levels(["b", "a", "b"]).labels == ["b", "a"]
    assert levels(["2", "1", "2"]).number.tolist() == [1, 0, 1]
    bins = levels([str(x / 100) for x in range(400)])
    assert bins.number.value_counts().tolist() == [50] * report.BINS
    assert bins.at[0] == pytest.approx(0.245)


def test_a_folder_without_results_is_one_clear_line(folder, report) -> None:
    with pytest.raises(Exception, match=r"has no results of a study \(No such file"):
        report.write(folder / "none")
    (folder / "study.json").write_text("{")
    with pytest.raises(Exception, match=r"study\.json is damaged"):
        report.write(folder)
