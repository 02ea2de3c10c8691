# SPDX-License-Identifier: GPL-3.0-or-later
"""`python -m benchmarks [--quick]`: measures, and writes docs/benchmarks.md from the data."""

from __future__ import annotations

import argparse
import json
import platform
from pathlib import Path

import bpy

from angen_addon.standalone import load_extension

DOCS = Path(__file__).resolve().parent.parent / "docs"


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="fewer frames; writes no file")
    quick = parser.parse_args().quick
    extension = load_extension()
    extension.register()
    try:
        from . import ray_accuracy, ray_layer, report

        data = {
            "machine": f"{platform.processor() or platform.machine()}, Blender "
            f"{bpy.app.version_string}, Python {platform.python_version()}",
            "ray_accuracy": ray_accuracy.measure(frames=12 if quick else 72),
            "ray_layer": ray_layer.measure(frames=24 if quick else 72, rounds=1 if quick else 3),
        }
    finally:
        extension.unregister()
    text = report.markdown(data)
    print(text)
    if not quick:
        (DOCS / "benchmarks.json").write_text(json.dumps(data, indent=1) + "\n")
        (DOCS / "benchmarks.md").write_text(text)


if __name__ == "__main__":
    main()
