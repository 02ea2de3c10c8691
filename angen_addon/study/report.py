# SPDX-License-Identifier: GPL-3.0-or-later
"""The report of a study: one page that needs nothing else, to read, sort and print."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator, Sequence
from html import unescape
from itertools import combinations
from pathlib import Path
from typing import Any

from ...sensor_logic.error import InputError
from ...sensor_logic.files import write_files
from ...sensor_logic.report.page import PAGE_STYLE
from ...sensor_logic.report.svg import INKS, safe
from ...sensor_logic.study import summary
from ...sensor_logic.study.summary import Mean, Results, Setting, mean_over_seeds, pick
from ...sensor_logic.wording import plural
from . import plots
from .results import CSV, FACTS

REPORT, PICTURES = "report.html", "pictures"
FIGURE = r'<figure class="plot" role="img" aria-label="([^"]*)">(<svg.*?</svg>)'
BEST, MOST_ROWS, MOST_MAPS = 10, 2000, 6
STYLE = """
figure.plot{background:#fff;color:#000;padding:6px;overflow-x:auto}
figure.plot svg{width:auto;max-width:100%}
th[data-n]{cursor:pointer}th[data-n]:hover{text-decoration:underline}
@media print{figure.plot{padding:0}}
"""
# A click on a heading sorts by its column, another one the other way round.
SORT = """
for (const table of document.querySelectorAll("table.sort"))
  table.tHead.addEventListener("click", e => {
    const head = e.target.closest("th"); if (!head) return;
    const column = head.cellIndex, way = head.dataset.way = -(head.dataset.way || -1);
    const key = row => { const c = row.cells[column], v = c.dataset.v ?? c.textContent;
      return v !== "" && isFinite(v) ? +v : v; };
    const rows = [...table.tBodies[0].rows].sort((a, b) => {
      const x = key(a), y = key(b);
      return way * (typeof x === typeof y ? (x < y ? -1 : x > y ? 1 : 0)
                                          : typeof x === "number" ? -1 : 1); });
    table.tBodies[0].append(...rows);
  });
"""


def write(folder: Path) -> Path:
    """Writes report.html into the folder of a study, and its pictures into one within; returns the
    path of the page. Raises InputError."""
    facts = _facts(folder)
    try:
        results = summary.read(folder / CSV, facts["varied"])
    except OSError as error:
        raise InputError(f"cannot read {folder / CSV}: {error.strerror}") from None
    except ValueError as error:
        raise InputError(f"{folder / CSV} is not of this study: {error}") from None
    page = html(facts, results)
    try:
        pictures = folder / PICTURES
        pictures.mkdir(exist_ok=True)
        drawings = re.findall(FIGURE, page, re.DOTALL)
        texts = {
            pictures / f"{number:02d} {_file_name(unescape(about))}.svg": svg + "\n"
            for number, (about, svg) in enumerate(drawings, 1)
        }
        write_files({folder / REPORT: page, **texts})
    except OSError as error:
        raise InputError(f"cannot write in {folder}: {error.strerror}") from None
    return folder / REPORT


def _facts(folder: Path) -> dict[str, Any]:
    try:
        found: dict[str, Any] = json.loads((folder / FACTS).read_text(encoding="utf-8"))
        return found
    except OSError as error:
        raise InputError(
            f"{folder} has no results of a study ({error.strerror}): `angen study run` makes them"
        ) from None
    except ValueError:
        raise InputError(f"{folder / FACTS} is damaged: start the study again") from None


def html(facts: dict[str, Any], results: Results) -> str:
    """The page."""
    light = "".join(f"--{name}:{colours[0]};" for name, colours in INKS.items())
    dark = "".join(f"--{name}:{colours[1]};" for name, colours in INKS.items())
    css = PAGE_STYLE.replace("$light", light).replace("$dark", dark) + STYLE
    title = safe(Path(facts["name"]).stem)
    best, way = facts["best"] or ("", "")
    parts = [
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"/>',
        '<meta name="viewport" content="width=device-width, initial-scale=1"/>',
        f"<title>{title}: study</title>\n<style>{css}</style></head>\n<body>",
        f"<h1>{title}</h1><p>{safe(_summary(facts, results))}</p>",
        "<dl>" + "".join(_fact(*fact) for fact in _told(facts, results)) + "</dl>",
    ]
    if len(results):
        measures = summary.main_measures(results, best)
        found = summary.settings(results)
        ranked = _ranked(results, found, best, way)
        parts += _best(results, ranked, measures, best, way)
        shown = summary.pictured(results, ranked)
        if len(shown) < len(results):
            parts.append("<p>Pictures are of the best sensors of each number.</p>")
        parts += _curves(shown, measures)
        parts += _maps(shown, measures[0])
        parts += _all(results, found, measures)
    parts += _errors(results)
    parts.append(f"<script>{SORT}</script></body></html>")
    return "\n".join(parts) + "\n"


def _summary(facts: dict[str, Any], results: Results) -> str:
    failed = sum(results.errors.values())
    well = len(results) - results.partly
    missing = facts["runs"] - well - failed
    told = f"{well} of {plural(facts['runs'], 'run')} went well"
    told += f", {failed} failed" if failed else ""
    were = "was" if missing == 1 else "were"
    return told + (f", {missing} {were} not run yet." if missing else ".")


def _told(facts: dict[str, Any], results: Results) -> Iterator[tuple[str, str]]:
    yield "home", ", ".join(facts["homes"])
    yield "what varied", ", ".join(facts["varied"]) or "nothing"
    yield "seeds for each setting", str(facts["seeds"])
    seconds = results.measured.get("seconds")
    if seconds is not None and len(seconds):
        yield "simulated for", f"{seconds.sum():.0f} s of computing, {seconds.mean():.2f} s a run"
    for name, found in results.versions.items():
        yield name, ", ".join(found)


def _fact(name: str, value: str) -> str:
    return f"<div><dt>{safe(name)}</dt><dd>{safe(value)}</dd></div>"


def _ranked(results: Results, found: Sequence[Setting], best: str, way: str) -> Sequence[Setting]:
    """The settings that have the best measure, by it; all of them where there is none."""
    if best not in results.measured:
        return found
    sign = -1.0 if way == "most" else 1.0
    return sorted(
        (s for s in found if math.isfinite(_of(results, best, s).value)),
        key=lambda setting: sign * _of(results, best, setting).value,
    )


def _best(
    results: Results, ranked: Sequence[Setting], measures: Sequence[str], best: str, way: str
) -> Iterator[str]:
    yield "<h2>Best settings</h2>"
    if best not in results.measured:
        what = f"No run has the measure {best!r}" if best else "The study names no best measure"
        line = f'best = "most {measures[0]}"'
        yield f"<p>{safe(what)}: its file may say, for one, <code>{safe(line)}</code>.</p>"
        return
    yield (
        f"<p>The {way} {safe(best)}, and what that costs: the sensors that are on, and seconds of "
        "computing a run. Means over seeds, ± half of the 95 % confidence interval.</p>"
    )
    costs = [n for n in ("sensors_on", "seconds") if n in results.measured and n != best]
    yield _table(results, ranked[:BEST], [best, *costs])
    if "sensors_on" in results.measured:
        yield from _best_by_number(results, ranked, [n for n in measures if n != "seconds"])


def _best_by_number(
    results: Results, ranked: Sequence[Setting], measures: Sequence[str]
) -> Iterator[str]:
    """The first of the ranked settings of each number of sensors that are on."""
    first: dict[float, Setting] = {}
    for setting in ranked:
        first.setdefault(_of(results, "sensors_on", setting).value, setting)
    if len(first) > 1:
        yield "<h2>By number of sensors</h2><p>The best setting with so many sensors on.</p>"
        yield _table(results, [first[n] for n in sorted(first)], ["sensors_on", *measures])


def _curves(results: Results, measures: Sequence[str]) -> Iterator[str]:
    if not results.varied:
        return
    yield "<h2>Responses</h2><p>Means over all runs of a value; bars are 95 % confidence intervals "
    yield "over seeds. Continuous draws are shown in parts of equal numbers of runs.</p>"
    for measure in measures:
        yield _figure(plots.curves(results, [measure], measure), f"{measure} against what varied")
    for measure in ("events", "active"):
        columns = summary.of_sensors(results, measure)
        if 1 < len(columns) <= plots.MOST_LINES:
            drawing = plots.curves(results, columns, measure)
            yield _figure(drawing, f"{measure} of each sensor against what varied")


def _maps(results: Results, measure: str) -> Iterator[str]:
    pairs = list(combinations(results.varied, 2))[:MOST_MAPS]
    if pairs:
        yield f"<h2>Pairs</h2><p>{safe(measure)} over two of what varied, ± half of the 95 % "
        yield "confidence interval over seeds.</p>"
    for pair in pairs:
        drawing = plots.heat_map(results, measure, pair)
        yield _figure(drawing, f"{measure} over {pair[0]} and {pair[1]}")


def _all(results: Results, found: Sequence[Setting], measures: Sequence[str]) -> Iterator[str]:
    yield "<h2>All settings</h2>"
    left = f" The first {MOST_ROWS} of {len(found)} settings." if len(found) > MOST_ROWS else ""
    yield f"<p>A click on a heading sorts. Single runs are in {CSV}.{left}</p>"
    yield _table(results, found[:MOST_ROWS], measures)


def _errors(results: Results) -> Iterator[str]:
    if results.errors:
        yield "<h2>Runs that failed</h2><table><thead><tr><th>runs</th><th>why</th></tr></thead>"
        for text, count in sorted(results.errors.items(), key=lambda item: -item[1]):
            yield f'<tr><td class="n">{count}</td><td>{safe(text)}</td></tr>'
        yield "</table>"


def _of(results: Results, measure: str, setting: Setting) -> Mean:
    seeds = [results.seeds[i] for i in setting.rows]
    return mean_over_seeds(pick(results.measured[measure], setting.rows), seeds)


def _table(results: Results, rows: Sequence[Setting], measures: Sequence[str]) -> str:
    heads = "".join(f"<th data-n>{safe(name)}</th>" for name in results.varied)
    heads += "".join(f'<th data-n class="n">{safe(name)}</th>' for name in measures)
    lines = []
    for setting in rows:
        cells = [f"<td>{safe(_short(value))}</td>" for value in setting.values]
        for measure in measures:
            mean = _of(results, measure, setting)
            value = "" if math.isnan(mean.value) else repr(mean.value)
            cells.append(f'<td class="n" data-v="{value}">{_shown(mean)}</td>')
        lines.append(f"<tr>{''.join(cells)}</tr>")
    return (
        f'<div class="scroll"><table class="sort"><thead><tr>{heads}</tr></thead>'
        f"<tbody>{''.join(lines)}</tbody></table></div>"
    )


def _short(value: str) -> str:
    return f"{float(value):.6g}" if summary.numeric([value]) else value


def _shown(mean: Mean) -> str:
    if math.isnan(mean.value):
        return ""
    half = "" if math.isnan(mean.half) else f" ± {mean.half:.2g}"
    return f"{mean.value:.4g}{half}"


def _file_name(about: str) -> str:
    return re.sub(r"[^\w ,.-]+", "_", about)[:80]


def _figure(drawing: str, about: str) -> str:
    return f'<figure class="plot" role="img" aria-label="{safe(about)}">{drawing}</figure>'
