# SPDX-License-Identifier: GPL-3.0-or-later
"""`python -m benchmarks [--quick] [--only PART]`: measures, and writes data, plots and pages.

The data go to docs/data, the page docs/benchmarks.md and docs/pressure.md's tables are made from
them. With --quick all goes to build/bench instead, and light, which has a program of its own, is
left out.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import time
from importlib import import_module
from pathlib import Path

from angen_addon.standalone import load_extension

from . import page, pressure_report

ROOT = Path(__file__).resolve().parent.parent
LIGHT = "light"
# The module that measures a part, where it is not called as the part is.
MODULES = {"rays": "ray_benchmark"}


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--quick", action="store_true", help="less of it, into build/bench")
    parser.add_argument(
        "--only",
        choices=(*page.REPORTS, LIGHT),
        help="this part alone; the others as last measured",
    )
    arguments = parser.parse_args()
    docs = ROOT / "build" / "bench" if arguments.quick else ROOT / "docs"
    (docs / "data").mkdir(parents=True, exist_ok=True)
    for name in page.REPORTS:
        if arguments.only in (None, name):
            _measure(name, arguments.quick, docs)
    print(page.write(docs))
    if not arguments.quick:
        pressure_report.write(page.known(docs / "data")["pressure"])
        if arguments.only in (None, LIGHT):
            subprocess.run([sys.executable, "-m", "benchmarks.light"], cwd=ROOT, check=True)


def _measure(name: str, quick: bool, docs: Path) -> None:
    """Measures a part and keeps its data at once, whatever becomes of the next part."""
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


if __name__ == "__main__":
    main()
