# SPDX-License-Identifier: GPL-3.0-or-later
"""`python -m benchmarks [--quick] [--only PART]`: measures, and writes data, plots and pages.

The data go to docs/data; the page docs/benchmarks.md and the tables of docs/pressure.md and
docs/pir.md are made from them. With --quick all output goes to build/bench instead, and of light,
which has its own program, only the error of a run is measured. Exit status 1: a figure breaks its
bound, or a part could not be measured; the data of all other parts are written nevertheless.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import time
import traceback
from importlib import import_module
from pathlib import Path
from typing import Any

from angen_addon.process.standalone import load_extension

from . import page, pressure_report
from .regressions import broken, checked

ROOT = Path(__file__).resolve().parent.parent
LIGHT = "light"
# The module that measures a part, where its name differs from the part's.
MODULES = {"rays": "ray_benchmark"}


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--quick", action="store_true", help="measure less, into build/bench")
    parser.add_argument(
        "--only",
        choices=(*page.REPORTS, LIGHT),
        help="measure only this part; keep the last data of the others",
    )
    arguments = parser.parse_args()
    docs = ROOT / "build" / "bench" if arguments.quick else ROOT / "docs"
    (docs / "data").mkdir(parents=True, exist_ok=True)
    problems: list[str] = []
    for name in page.REPORTS:
        if arguments.only in (None, name):
            problems += _tried(name, arguments.quick, docs)
    try:
        _write_pages(docs, arguments.quick)
    except Exception as error:
        traceback.print_exc()
        problems.append(
            f"the pages could not be written: {error!r}, see above; a part that was measured by "
            "another version of the benchmarks must be measured again"
        )
    if arguments.only in (None, LIGHT) and not _light_holds(arguments.quick):
        problems.append("light: out of bounds or could not be measured, see above")
    if problems:
        raise SystemExit("\n".join(["Figures break their bounds:", *problems]))


def _light_holds(quick: bool) -> bool:
    """Measures light in its own program; returns whether its figures hold their bounds."""
    options = ["--quick", "--only", "run"] if quick else []
    return not subprocess.run([sys.executable, "-m", "benchmarks.light", *options]).returncode


def _write_pages(docs: Path, quick: bool) -> None:
    print(page.write(docs))
    print(f"written to {docs.relative_to(ROOT)}/benchmarks.md", file=sys.stderr, flush=True)
    for name, data in page.known(docs / "data").items():
        if not quick and hasattr(page.REPORTS[name], "write"):
            page.REPORTS[name].write(data)


def _tried(name: str, quick: bool, docs: Path) -> list[str]:
    """Measures a part; returns the bounds that it breaks, or why it could not be measured."""
    try:
        data = _measure(name, quick, docs)
    except Exception as error:
        traceback.print_exc()
        return [f"{name}: could not be measured: {error!r}, see above"]
    if hasattr(page.REPORTS[name], "left_out"):
        for what in page.REPORTS[name].left_out(data):
            print(f"{name}: LEFT OUT: {what}", file=sys.stderr, flush=True)
    figures = checked(name, data)
    within = sum(figure.holds for figure in figures)
    print(f"{name}: {within} of {len(figures)} bounds held", file=sys.stderr, flush=True)
    return broken(name, data)


def _measure(name: str, quick: bool, docs: Path) -> dict[str, Any]:
    """Measures a part and writes its data at once, in case a later part fails."""
    extension = load_extension()
    extension.register()
    begin = time.perf_counter()
    try:
        common = import_module("benchmarks.common")
        found = import_module(f"benchmarks.{MODULES.get(name, name)}").measure(quick)
        machine = common.machine()
    finally:
        extension.unregister()
    took = time.perf_counter() - begin
    data = {"machine": machine, "quick": quick, "took_s": took, **found}
    (docs / "data" / f"{name}.json").write_text(pressure_report.dumped(data), encoding="utf-8")
    print(f"{name}: {took:.0f} s", file=sys.stderr, flush=True)
    return data


if __name__ == "__main__":
    main()
