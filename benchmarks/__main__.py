# SPDX-License-Identifier: GPL-3.0-or-later
"""Measure speed and errors, and write the results and the pages of the docs.

python -m benchmarks [--quick] [--only PART] [--page]

The results go to docs/data. From them come docs/benchmarks.md with its plots, and the tables of
docs/pressure.md and docs/pir.md. With --quick all output goes to build/bench instead, and of the
light sensor, which has its own program, only the error of a run is measured. The exit status is 1
if a figure breaks its bound or a part cannot be measured. The results of all other parts are
written nevertheless.
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
import time
import traceback
from importlib import import_module
from pathlib import Path
from typing import Any

from angen_addon.process.standalone import load_extension

from . import page
from .bounds import PARTS, broken, checked, left_out

ROOT = Path(__file__).resolve().parent.parent
LIGHT = "light"
# The functions that measure a part, where this is not the function `measure` of its module.
FUNCTIONS = {"live": "home.measure_live", "pir_pyroelectric": "pir.measure_pyroelectric"}


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--quick", action="store_true", help="measure less, into build/bench")
    parser.add_argument(
        "--only",
        choices=(*PARTS, LIGHT),
        help="measure only this part; keep the last data of the others",
    )
    parser.add_argument(
        "--page", action="store_true", help="measure nothing; write all pages from the last data"
    )
    parser.add_argument("--apart", nargs=2, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.apart:
        print(json.dumps(call(arguments.apart[0], *json.loads(arguments.apart[1]))), flush=True)
        return
    docs = ROOT / "build" / "bench" if arguments.quick else ROOT / "docs"
    (docs / "data").mkdir(parents=True, exist_ok=True)
    chosen = [*PARTS, LIGHT] if arguments.only is None else [arguments.only]
    problems: list[str] = []
    for name in PARTS:
        if name in chosen and not arguments.page:
            problems += _measure_safely(name, arguments.quick, docs)
    try:
        _write_pages(docs, arguments.quick)
    except Exception as error:
        traceback.print_exc()
        problems.append(
            f"the pages could not be written: {error!r}, see above; a part that was measured by "
            "another version of the benchmarks must be measured again"
        )
    options = ["--page"] if arguments.page else ["--quick", "--only", "run"]
    options = options if arguments.page or arguments.quick else []
    if LIGHT in chosen and not (arguments.page and arguments.quick) and not _light_holds(options):
        problems.append("light: out of bounds or could not be measured, see above")
    if problems:
        raise SystemExit("\n".join(["Figures break their bounds:", *problems]))


def call(function: str, *arguments: Any) -> Any:
    """Call a function of the benchmarks ("module.name") with the extension registered."""
    extension = load_extension()
    extension.register()
    try:
        module, _, name = function.partition(".")
        return getattr(import_module(f"benchmarks.{module}"), name)(*arguments)
    finally:
        extension.unregister()


def _light_holds(options: list[str]) -> bool:
    """Run the light sensor's own program; return whether its figures hold their bounds."""
    return not subprocess.run([sys.executable, "-m", "benchmarks.light", *options]).returncode


def _write_pages(docs: Path, quick: bool) -> None:
    print(page.write(docs))
    print(f"written to {docs.relative_to(ROOT)}/benchmarks.md", file=sys.stderr, flush=True)
    for name, data in page.known(docs / "data").items():
        if not quick:
            page.write_tables(name, data)


def _measure_safely(name: str, quick: bool, docs: Path) -> list[str]:
    """Measure a part; return the bounds that it breaks, or why it could not be measured."""
    try:
        data = _measure(name, quick, docs)
    except Exception as error:
        traceback.print_exc()
        return [f"{name}: could not be measured: {error!r}, see above"]
    for what in left_out(name, data):
        print(f"{name}: LEFT OUT: {what}", file=sys.stderr, flush=True)
    figures = checked(name, data)
    within = sum(figure.holds for figure in figures)
    print(f"{name}: {within} of {len(figures)} bounds held", file=sys.stderr, flush=True)
    return broken(name, data)


def _measure(name: str, quick: bool, docs: Path) -> dict[str, Any]:
    """Measure a part, and write its results at once, in case a later part fails."""
    begin = time.perf_counter()
    found = call(FUNCTIONS.get(name, f"{name}.measure"), quick)
    took = time.perf_counter() - begin
    data = {"machine": call("common.machine"), "quick": quick, "took_s": took, **found}
    (docs / "data" / f"{name}.json").write_text(dumped(data), encoding="utf-8")
    print(f"{name}: {took:.0f} s", file=sys.stderr, flush=True)
    return data


def dumped(data: dict[str, Any]) -> str:
    """Return `data` as JSON with one line for each innermost list, for readable diffs."""
    text = json.dumps(data, indent=1, ensure_ascii=False)
    return re.sub(r"\[[^][{}]*\]", lambda m: re.sub(r"\s*\n\s*", " ", m[0]), text) + "\n"


if __name__ == "__main__":
    main()
