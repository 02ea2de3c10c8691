# SPDX-License-Identifier: GPL-3.0-or-later
"""Write docs/benchmarks.md, the tables of other pages and all plots from the stored results.

This needs no Blender. `python -m benchmarks --page` writes all of them from the last results. The
texts and the columns of the tables are in page.md.j2 and light.md.j2.
"""

from __future__ import annotations

import json
import math
import os
import re
import sys
from collections.abc import Callable, Iterable, Mapping
from importlib.util import find_spec
from itertools import chain, pairwise
from pathlib import Path
from typing import Any

from jinja2 import FileSystemLoader

from .bounds import CYCLES, ENVIRONMENT, LEAST_W_M2, PARTS, RADIANCE, expression, held

DOCS = Path(__file__).resolve().parent.parent / "docs"
# Pages with tables between markers, and the part of the results that each page shows.
TABLES = {"pressure.md": "pressure", "pir.md": "pir_pyroelectric", "light.md": "light",
          "measured.md": "measured"}  # fmt: skip
# An exponent above FASTER is bold. Times shorter than LEAST_MS (ms) are noise.
FASTER, LEAST_MS = 1.2, 0.05


def known(folder: Path) -> dict[str, dict[str, Any]]:
    """Return the results of the measured parts, in the order of the page."""
    files = {name: folder / f"{name}.json" for name in PARTS}
    return {
        name: json.loads(file.read_text(encoding="utf-8"))
        for name, file in files.items()
        if file.exists()
    }


def results(part: str) -> dict[str, Any]:
    """Return the stored results of a part, or of light."""
    file = DOCS / ("light_benchmarks.json" if part == "light" else f"data/{part}.json")
    return dict(json.loads(file.read_text(encoding="utf-8")))


def table(rows: Iterable[Mapping[str, Any]], *columns: Any, of: Any = None) -> str:
    """Return a Markdown table with a row for each of `rows`.

    Each of `columns` is a text, or a list of texts, of the form "head", "head = expression" or
    "head = expression : format". The expression is a Jinja expression of the row's fields, of
    `this`, the row, and of `of`. The format is `spread`, `percent` or a format of Python. A text
    after the format follows the number, as in ".2f %".
    """
    heads, cells = [], []
    flat = [[column] if isinstance(column, str) else column for column in columns]
    for column in chain.from_iterable(flat):
        head, _, rest = column.partition(" = ")
        text, _, how = rest.rpartition(" : ")
        heads.append(head)
        cells.append((expression(text or how or head), how if text else ""))
    lines = [heads, ["---"] * len(heads)]
    lines += [[shown(work(**row, this=row, of=of), how) for work, how in cells] for row in rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def each(pattern: str, names: Iterable[str]) -> list[str]:
    """Return a column for each name, or for each item of a dict, from `pattern`."""
    pairs = names.items() if isinstance(names, Mapping) else zip(names, names, strict=True)
    return [pattern.format(name, title) for name, title in pairs]


def shown(value: Any, how: str) -> str:
    """Return a value as text by a format of `table`."""
    how, space, unit = how.partition(" ")
    if how in FORMATS:
        return FORMATS[how](value)
    return f"{value:{how}}{space}{unit}"


def spread(found: Mapping[str, Any] | float, digits: int = 3) -> str:
    """Return median (least–greatest) of repeated runs as text; of a single run only the number."""
    if not isinstance(found, Mapping):
        return short(found, digits)
    middle, low, high = (short(found[key], digits) for key in ("median", "low", "high"))
    return middle if found["runs"] == 1 else f"{middle} ({low}–{high})"


def short(value: float, digits: int = 3) -> str:
    """Return a number with significant digits; with an exponent below 0.001 and from 1e6 on."""
    if value and not 1e-3 <= abs(value) < 1e6:
        return f"{value:.{digits - 1}e}"
    if abs(value) < 1:
        return f"{value:.{digits}g}"
    return f"{value:.{max(digits - len(str(int(abs(value)))), 0)}f}"


def percent(share: float) -> str:
    return f"{share:.0%}" if share in (0.0, 1.0) else f"{share:.1%}"


def tiny(share: float) -> str:
    """Return a share in percent with two digits, or "< 0.001 %"."""
    if math.isnan(share):
        return "none"
    return "< 0.001 %" if share < 1e-5 else f"{100.0 * share:.2g} %"


def seen(found: Mapping[str, Any]) -> str:
    """Return share of passes detected, median latency and share of updates with motion as text."""
    late = found["latency_s"]
    latency = "–" if late is None else f"{late:.2f} s"
    return f"{percent(found['detected'])}, {latency}, {percent(found['said'])}"


def felt(found: Mapping[str, Any]) -> str:
    """Return share of passes detected and median latency as text."""
    late = found["latency_s"]
    return f"{found['detected']:.0%}" + (f", {late:.2f} s" if late else "")


def shares(some: Mapping[str, Any], best: Mapping[str, Any]) -> list[str]:
    """Return, by walker, the updates with motion relative to the best setting, in rising order."""
    found = [(s["said"] / best[w]["said"], w) for w, s in some.items() if best[w]["said"]]
    return [f"{percent(share)} ({walker})" for share, walker in sorted(found)]


def exponents(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the rows with the exponent of the time over the size, from each row to the next."""
    found = [{**rows[0], "exponent": ""}]
    for before, row in pairwise(rows):
        few, many = before["sensing_ms"]["median"], row["sensing_ms"]["median"]
        text = "–"
        if min(few, many) >= LEAST_MS:
            power = math.log(many / few) / math.log(row["size"] / before["size"])
            text = f"**{power:.2f}**" if power > FASTER else f"{power:.2f}"
        found.append({**row, "exponent": text})
    return found


def light_rows(data: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the rows of speed against error of both methods of a light sensor."""
    return [row for name in ("ILLUMINANCE", "FOUR_WALL") for row in data.get(name, EMPTY)["rows"]]


def light_compared(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return Cycles against Radiance, by light and part, over the faces with enough light."""
    groups: dict[tuple[str, str], list[tuple[float, float]]] = {}
    for row in rows:
        pair = row["cycles"], row["radiance"]
        if max(pair) >= LEAST_W_M2:
            groups.setdefault((row["time"], row["part"]), []).append(pair)
    found = []
    for (time, part), pairs in groups.items():
        errors = [abs(ours / theirs - 1.0) if theirs else 1.0 for ours, theirs in pairs]
        ours, theirs = (sum(side) for side in zip(*pairs, strict=True))
        rms = math.sqrt(sum(error**2 for error in errors) / len(errors))
        worst, faces = max(errors), len(pairs)
        ratios = {"faces": faces, "ratio": ours / theirs, "rms": rms, "worst": worst}
        found.append({"time": time, "part": part, **ratios})
    return found


EMPTY: Mapping[str, Any] = {"rows": []}
FORMATS: Mapping[str, Callable[..., str]] = {
    "f": lambda value, how: f"{value:{how}}",
    "small": lambda share: "< 0.001%" if share < 1e-5 else percent(share),
    "mean": lambda values: sum(values) / len(values),  # type: ignore[dict-item, return-value]
    **{work.__name__: work for work in (spread, short, percent, tiny, seen, felt)},
}
ENVIRONMENT.loader = FileSystemLoader(Path(__file__).parent)
ENVIRONMENT.filters.update(FORMATS)
ENVIRONMENT.globals.update(
    {work.__name__: work for work in (table, each, shares, exponents, light_rows, light_compared)},
    RADIANCE=RADIANCE,
    CYCLES=CYCLES,
    LEAST_W_M2=LEAST_W_M2,
)


def text_of(name: str, *arguments: Any) -> str:
    """Return the text of a macro of the templates, without blank lines around it."""
    template = "light.md.j2" if name.startswith("light") else "page.md.j2"
    macro = getattr(ENVIRONMENT.get_template(template).module, name)
    return str(macro(*arguments)).strip()


def markdown(parts: Mapping[str, dict[str, Any]]) -> str:
    """Return the text of docs/benchmarks.md."""
    found = {name: held(name, data) for name, data in parts.items()}
    texts = [text_of("head", dict.fromkeys(PARTS) | dict(parts), found)]
    for name, data in parts.items():
        origin = f"`python -m benchmarks --only {name}`"
        if data["quick"]:
            origin = f"{origin[:-1]} --quick`: *a quick measurement, one run, not the full one.*"
        texts.append(text_of(name, {**data, "origin": origin}))
    return "\n\n".join(texts) + "\n"


def with_tables(file: str, page: str, data: dict[str, Any]) -> str:
    """Return a page of the docs with its tables renewed.

    The first marker of a table has its name and the command that measures it.
    """

    def renewed(found: re.Match[str]) -> str:
        text = text_of(f"{file.partition('.')[0]}_{found['name']}", data)
        return f"{found['first']}\n\n{text}\n\n{found['last']}"

    marked = r"(?P<first><!-- (?P<name>\w+): python -m [^>]+ -->).*?(?P<last><!-- end of \2 -->)"
    return re.sub(marked, renewed, page, flags=re.DOTALL)


def write_tables(part: str, data: dict[str, Any]) -> None:
    """Renew the tables of a part's page, if it has one."""
    for file, shown_part in TABLES.items():
        if shown_part == part:
            page = (DOCS / file).read_text(encoding="utf-8")
            (DOCS / file).write_text(with_tables(file, page, data), encoding="utf-8")


def write(docs: Path) -> str:
    """Write the page and the plots beside the results in `docs`; return the page."""
    parts = known(docs / "data")
    text = markdown(parts)
    if docs != DOCS:
        # The page is not in docs/: its links to other pages lead there.
        way = Path(os.path.relpath(DOCS, docs)).as_posix()
        text = re.sub(r"\]\((?=[\w-]+\.md[)#])", f"]({way}/", text)
    (docs / "benchmarks.md").write_text(text, encoding="utf-8")
    draw(docs / "pictures", parts)
    return text


def write_light(data: dict[str, Any]) -> None:
    """Write docs/light_benchmarks.md, its plots, and the tables of docs/light.md."""
    text = text_of("light", data) + "\n"
    (DOCS / "light_benchmarks.md").write_text(text, encoding="utf-8")
    write_tables("light", data)
    draw(DOCS, {"light": data})


def draw(folder: Path, parts: Mapping[str, dict[str, Any]]) -> None:
    folder.mkdir(exist_ok=True)
    if find_spec("matplotlib") is None:
        print("no plots were drawn: matplotlib is not installed", file=sys.stderr)
        return
    from .plot import figures

    for name, drawn in figures(parts).items():
        (folder / name).write_text(drawn, encoding="utf-8")
