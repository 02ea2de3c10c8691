# SPDX-License-Identifier: GPL-3.0-or-later
"""Simulate the sample home and show its sensors' readings: `make demo`.

It runs in Blender's Python module. Without the module, or if BLENDER names a Blender program, it
runs in that program, or in the one on PATH.
"""

import contextlib
import importlib.util
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from demo_table import Report, active_share, change_times, greatest, last_time, row, table
from dev import link_folder

ROOT = Path(__file__).resolve().parent.parent
HOME = ROOT / "sample_blends" / "angen.blend"
OUTPUT = ROOT / "build" / "demo"
MIB = 1024**2


@contextlib.contextmanager
def angen_command() -> Iterator[list[str]]:
    """Yield the command line, up to its verb, of this checkout's extension on the sample home."""
    blender = os.environ.get("BLENDER")
    if not blender and importlib.util.find_spec("bpy"):
        yield [sys.executable, "-m", "angen_addon"]
        return
    blender = blender or shutil.which("blender")
    if not blender:
        sys.exit("demo: needs Blender's Python module, or a Blender program (BLENDER=PATH)")
    with tempfile.TemporaryDirectory(prefix="angen_demo_") as resources:
        link = Path(resources, "extensions", "user_default", "angen_sensors")
        link.parent.mkdir(parents=True)
        link_folder(link, ROOT)
        os.environ["BLENDER_USER_RESOURCES"] = resources
        addon = ["--addons", "bl_ext.user_default.angen_sensors"]
        yield [blender, "--factory-startup", *addon, str(HOME), "--command", "angen"]


def run(command: list[str], verb: str, *arguments: str) -> str:
    """Run a verb on the sample home with its progress on this terminal; return its output."""
    home = [] if "--command" in command else [str(HOME)]
    whole = [*command, verb, *home, *arguments]
    done = subprocess.run(
        whole, cwd=ROOT, stdout=subprocess.PIPE, encoding="utf-8", errors="replace", check=False
    )
    if done.returncode != 0:
        sys.exit(f"demo: {verb} failed with status {done.returncode}")
    return done.stdout


def lines(path: Path) -> list[str]:
    """Return the lines of a CSV file for csv.reader."""
    with path.open(encoding="utf-8", newline="") as file:
        return list(file)


def report(sensor: Mapping[str, Any], changes: list[float], samples: list[str]) -> Report:
    """Return the report of a sensor, as `list --json` has it, from its changes and samples."""
    return Report(
        changes, active_share(samples, sensor["kind"]), greatest(samples, sensor["units"])
    )


def memory_of_children() -> int:
    """Return the most memory of a process that this one started, in bytes; 0 on Windows."""
    try:
        import resource
    except ImportError:
        return 0
    # In KiB, but in bytes on macOS.
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss * unit


def main() -> None:
    events, samples, page = OUTPUT / "events.csv", OUTPUT / "samples", OUTPUT / "report.html"
    shutil.rmtree(OUTPUT, ignore_errors=True)
    samples.mkdir(parents=True)

    with angen_command() as command:
        print(f"Simulating {HOME.relative_to(ROOT)} ...", flush=True)
        started = time.perf_counter()
        outputs = ["--events", str(events), "--samples", str(samples), "--report", str(page)]
        run(command, "simulate", *outputs)
        wall = time.perf_counter() - started
        memory = memory_of_children()
        sensors = sorted(json.loads(run(command, "list", "--json")), key=lambda s: s["room"])

    changes = change_times(lines(events))
    sampled = {s["name"]: lines(samples / f"{s['name']}.csv") for s in sensors}
    rows = [row(s, report(s, changes[s["name"]], sampled[s["name"]])) for s in sensors]
    simulated = max(last_time(text) for text in sampled.values())
    print(f"\n{table(rows)}\n")
    print("Events are changes of what a sensor publishes; active is its share of the time;")
    print("max is the greatest force on a pressure pad, or the most luminance of a light sensor.")
    at_most = f"; {memory / MIB:.0f} MiB of memory at most" if memory else ""
    print(
        f"{simulated:.0f} s of the home in {wall:.1f} s: {simulated / wall:.1f} times real time, "
        f"Blender's start included{at_most}."
    )
    print(f"Event log: {events.relative_to(ROOT)}   samples: {samples.relative_to(ROOT)}/")
    print(f"Timeline, floor plan and figures to read and print: {page.relative_to(ROOT)}")


if __name__ == "__main__":
    main()
