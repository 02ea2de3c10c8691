# SPDX-License-Identifier: GPL-3.0-or-later
"""`python -m benchmarks [--quick] [--only PART]`: measures, and writes the pages from the data:
docs/benchmarks.md, and docs/pressure.md's tables and figure."""

from __future__ import annotations

import argparse
import json
import platform
from pathlib import Path
from typing import Any

import bpy

from angen_addon.standalone import load_extension

DOCS = Path(__file__).resolve().parent.parent / "docs"
PARTS = ("rays", "pressure")


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="less of it; writes no file")
    parser.add_argument("--only", choices=PARTS, help="this part alone; the other as last measured")
    arguments = parser.parse_args()
    quick, parts = arguments.quick, (arguments.only,) if arguments.only else PARTS
    machine = (
        f"{platform.processor() or platform.machine()}, Blender "
        f"{bpy.app.version_string}, Python {platform.python_version()}"
    )
    extension = load_extension()
    extension.register()
    try:
        from . import pressure, pressure_report, ray_accuracy, ray_layer, report

        rays = _known(DOCS / "benchmarks.json")
        pads = _known(pressure_report.DATA)
        if "rays" in parts:
            rays = {
                "machine": machine,
                "ray_accuracy": ray_accuracy.measure(frames=12 if quick else 72),
                "ray_layer": ray_layer.measure(
                    frames=24 if quick else 72, rounds=1 if quick else 3
                ),
            }
        if "pressure" in parts:
            pads = {"machine": machine, **pressure.measure(quick)}
    finally:
        extension.unregister()
    text = report.markdown(rays) + pressure_report.section(pads)
    print(text)
    if quick:
        print("\n".join(pressure_report.tables(pads).values()))
        return
    (DOCS / "benchmarks.json").write_text(json.dumps(rays, indent=1) + "\n")
    (DOCS / "benchmarks.md").write_text(text)
    pressure_report.write(pads)


def _known(path: Path) -> dict[str, Any]:
    """What was measured last."""
    return dict(json.loads(path.read_text(encoding="utf-8"))) if path.exists() else {}


if __name__ == "__main__":
    main()
