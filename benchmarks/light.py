# SPDX-License-Identifier: GPL-3.0-or-later
"""`python -m benchmarks.light [--quick] [--only PART] [--beside CHECKOUT]`: the light sensor's
speed against its error, and Cycles against Radiance; writes docs/light_benchmarks.md, .json, .svg.

A run's error and processor time are told beside those of another checkout, such as of former code
(`git worktree add ../former COMMIT`). Ends with status 1 where a run's error is out of bounds.
"""

from __future__ import annotations

import argparse
import json
import platform
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import bpy

from angen_addon.process.standalone import load_extension

DOCS = Path(__file__).resolve().parent.parent / "docs"
DATA = DOCS / "light_benchmarks.json"
# Between these docs/light.md has a table.
BEGIN, END = "<!-- table: python -m benchmarks.light -->\n", "<!-- end of table -->"
BEGIN_RUN, END_RUN = "<!-- run: python -m benchmarks.light -->\n", "<!-- end of run -->"
# Some minutes each.
PARTS = ("ILLUMINANCE", "FOUR_WALL", "plane", "run", "radiance")
REFERENCE, RADIANCE, TRUE_RUN = 65_536, 131_072, 32_768


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.light", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="fewer light paths; writes no file")
    parser.add_argument("--only", choices=PARTS, help="this part; the others as last measured")
    parser.add_argument("--beside", type=Path, help="another checkout, measured in turns")
    arguments = parser.parse_args()
    quick, parts = arguments.quick, (arguments.only,) if arguments.only else PARTS
    data: dict[str, Any] = json.loads(DATA.read_text()) if DATA.exists() and not quick else {}
    if "moments" not in data.get("run", {}):
        # As another version of this measured it.
        data.pop("run", None)
    machine = f"{platform.processor() or platform.machine()}, Blender {bpy.app.version_string}"
    extension = load_extension()
    extension.register()
    try:
        from . import light_plane, light_radiance, light_report, light_run, light_speed

        for part in parts:
            if part == "run":
                paths = TRUE_RUN // 16 if quick else TRUE_RUN
                found = light_run.measure(paths, quick, arguments.beside)
            elif part == "plane":
                found = light_plane.measure(quick)
            elif part != "radiance":
                found = light_speed.measure(part, 4096 if quick else REFERENCE, 1 if quick else 3)
            elif find_spec("pyradiance"):
                found = light_radiance.measure(1024 if quick else RADIANCE)
            else:
                continue
            data[part] = {"machine": machine, **found}
    finally:
        extension.unregister()
    text = light_report.markdown(data)
    print(text)
    if not quick:
        DATA.write_text(json.dumps(data, indent=1) + "\n")
        (DOCS / "light_benchmarks.md").write_text(text)
        _fill(BEGIN, END, light_report.table(data))
        _fill(BEGIN_RUN, END_RUN, light_report.run_table(data))
        if find_spec("matplotlib"):
            (DOCS / "light_benchmarks.svg").write_text(light_report.plot(light_report.rows(data)))
            if "run" in data:
                (DOCS / "light_run.svg").write_text(light_report.run_plot(data["run"]["rows"]))
    problems = light_run.problems(data["run"]) if "run" in parts else []
    if problems:
        sys.exit("\n".join(problems))


def _fill(begin: str, end: str, table: str) -> None:
    """Puts a table into docs/light.md."""
    page = DOCS / "light.md"
    before, _, rest = page.read_text().partition(begin)
    after = rest.partition(end)[2]
    page.write_text(f"{before}{begin}\n{table}\n{end}{after}")


if __name__ == "__main__":
    main()
