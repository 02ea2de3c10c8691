# SPDX-License-Identifier: GPL-3.0-or-later
"""`python -m benchmarks.light [--quick]`: the light sensor's speed against its error, and Cycles
against Radiance; writes docs/light_benchmarks.md, .json and .svg from the data."""

from __future__ import annotations

import argparse
import json
import platform
from importlib.util import find_spec
from pathlib import Path

import bpy

from angen_addon.standalone import load_extension

DOCS = Path(__file__).resolve().parent.parent / "docs"


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.light", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="fewer light paths; writes no file")
    quick = parser.parse_args().quick
    extension = load_extension()
    extension.register()
    try:
        from . import light_radiance, light_report, light_speed

        data = {
            "machine": f"{platform.processor() or platform.machine()}, Blender "
            f"{bpy.app.version_string}",
            "speed": light_speed.measure(4096 if quick else 65536, 1 if quick else 3),
        }
        if find_spec("pyradiance"):
            data["radiance"] = light_radiance.measure(1024 if quick else 65536)
    finally:
        extension.unregister()
    text = light_report.markdown(data)
    print(text)
    if not quick:
        (DOCS / "light_benchmarks.json").write_text(json.dumps(data, indent=1) + "\n")
        (DOCS / "light_benchmarks.md").write_text(text)
        (DOCS / "light_benchmarks.svg").write_text(light_report.plot(data["speed"]["rows"]))


if __name__ == "__main__":
    main()
