# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes docs/benchmarks.md and its plots from the data in docs/data; it needs no Blender.

`python -m benchmarks.page` writes them again from the last measurements.
"""

from __future__ import annotations

import json
import os
import re
import sys
from collections.abc import Mapping
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import Any

from .regressions import PARTS, checked
from .tables import table

DOCS = Path(__file__).resolve().parent.parent / "docs"
REPORTS: Mapping[str, ModuleType] = {
    part: import_module(f"{__package__}.{part}_report") for part in PARTS
}
HEAD = """\
# Benchmarks

Written by `make bench` from the data in [data/](data/); do not edit. `make bench ARGS=--quick` is a
quick measurement of a few minutes, written to `build/bench`; `ARGS="--only PART"` measures one
part.

**How to read this.** Numbers are medians, with the least and the greatest of repeated runs in
brackets; a number without brackets was measured once. Ratios compare figures that were measured
alternately in one run, so that a busy machine slows both. Every part names its command and the
reference of its errors: a closed form, another engine, or a dense computation. Errors, shares and
counts are the same in every run; the worst of them have bounds (`benchmarks/*_bounds.py`), and a
run that breaks a bound names it and fails, in CI too. Times have no bounds because they depend on
the machine: compare ratios.

**Compared with others**, in the same run:

{ratios}
| part | machine | took | bounds held |
| --- | --- | --- | --- |
{parts}
The light sensor has its own page: [light_benchmarks.md](light_benchmarks.md). Hard cases and their
tests: [hard_cases.md](hard_cases.md).
"""


def known(folder: Path) -> dict[str, dict[str, Any]]:
    """The data of the measured parts."""
    return {
        name: json.loads((folder / f"{name}.json").read_text(encoding="utf-8"))
        for name in REPORTS
        if (folder / f"{name}.json").exists()
    }


def markdown(parts: Mapping[str, dict[str, Any]]) -> str:
    ratios = [
        row
        for name, data in parts.items()
        if hasattr(REPORTS[name], "ratios")
        for row in REPORTS[name].ratios(data)
    ]
    lines = [
        f"| {name} | {data['machine']} | {_took(data.get('took_s'))} | {_held(name, data)} |\n"
        for name, data in parts.items()
    ]
    text = HEAD.format(ratios=table(("what", "beside", "ratio"), ratios), parts="".join(lines))
    for name, data in parts.items():
        title, _, rest = REPORTS[name].section(data).partition("\n\n")
        text += f"\n{title}\n\n{_origin(name, data)}\n\n{rest.strip()}\n"
    return text


def _origin(name: str, data: dict[str, Any]) -> str:
    """The command that measured a part."""
    if data["quick"]:
        return (
            f"`python -m benchmarks --only {name} --quick`: *a quick measurement, one run, not the "
            "full one.*"
        )
    return f"`python -m benchmarks --only {name}`"


def _held(name: str, data: dict[str, Any]) -> str:
    figures = checked(name, data)
    count = sum(figure.holds for figure in figures)
    return (
        f"{count} of {len(figures)}" if count == len(figures) else f"**{count} of {len(figures)}**"
    )


def _took(seconds: float | None) -> str:
    return "" if seconds is None else f"{seconds:.0f} s"


def figures(parts: Mapping[str, dict[str, Any]]) -> dict[str, str]:
    """SVGs by file name."""
    found: dict[str, str] = {}
    for name, data in parts.items():
        if hasattr(REPORTS[name], "figures"):
            found.update(REPORTS[name].figures(data))
    return found


def _linked(text: str, folder: Path) -> str:
    """The page with links that lead from `folder` to the other pages in docs."""
    if folder == DOCS:
        return text
    way = Path(os.path.relpath(DOCS, folder)).as_posix()
    return re.sub(r"\]\((?=[\w-]+\.md\))", f"]({way}/", text)


def write(docs: Path) -> str:
    """Writes the page and the plots beside the data in `docs`; returns the page."""
    parts = known(docs / "data")
    text = _linked(markdown(parts), docs)
    (docs / "benchmarks.md").write_text(text, encoding="utf-8")
    pictures = docs / "pictures"
    pictures.mkdir(exist_ok=True)
    if find_spec("matplotlib") is None:
        print("no plots were drawn: matplotlib is not installed", file=sys.stderr)
        return text
    for name, drawn in figures(parts).items():
        (pictures / name).write_text(drawn, encoding="utf-8")
    return text


if __name__ == "__main__":
    print(write(DOCS))
