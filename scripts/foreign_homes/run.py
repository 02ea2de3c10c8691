# SPDX-License-Identifier: GPL-3.0-or-later
"""Run every verb on homes that other people made.

python scripts/foreign_homes/run.py SOURCE…

A SOURCE is a home (.blend, .glb, .gltf, .obj, .ifc), a folder of homes, or the address of a git
repository of homes. For IFC, ifcopenshell is installed in its own virtual environment. Each home
gets a walking person and a sensor of every kind and model. The readings of the motion detectors and
switches are compared with those by Blender's own `scene.ray_cast`. All files stay in
build/foreign_homes/, with a table; the exit status is 1 if a verb failed on a home.
"""

from __future__ import annotations

import re
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
HERE = Path(__file__).resolve().parent
OUT = ROOT / "build" / "foreign_homes"
HOMES = {".blend", ".glb", ".gltf", ".obj", ".ifc"}
LIMIT = 600.0
BLIND = [
    f"--sensor=Angen {name}"
    for name in (
        "PIR range_scan",
        "PIR pyroelectric",
        "switch ray",
        "switch swept",
        "switch aperture",
        "pad",
    )
]
LIGHT = [f"--sensor=Angen light {name}" for name in ("walls", "lux", "Cycles")]
EXPLAINED = ("PIR range_scan", "PIR pyroelectric", "switch ray", "pad", "light lux")


def main(sources: list[str]) -> int:
    """Try all homes and write the table; return the exit status."""
    OUT.mkdir(parents=True, exist_ok=True)
    rows, failed = [], False
    for home in [home for source in sources for home in homes_of(source)]:
        print(f"== {home.name}", flush=True)
        row = try_home(home)
        rows.append(row)
        failed |= any(mark.startswith("FAILED") for mark in row.values())
    columns = list(dict.fromkeys(column for row in rows for column in row))
    lines = [columns, ["---"] * len(columns)]
    lines += [[row.get(column, "") for column in columns] for row in rows]
    table = "".join(f"| {' | '.join(line)} |\n" for line in lines)
    (OUT / "table.md").write_text(table, encoding="utf-8")
    print(table)
    return int(failed)


def homes_of(source: str) -> list[Path]:
    """Return the homes of a source: a file, a folder or a git repository."""
    path = Path(source)
    if path.is_file():
        return [path]
    if not path.is_dir() or path.suffix == ".git":
        path = OUT / re.sub(r"\W+", "_", source)
        if not path.exists():
            subprocess.run(["git", "clone", "-q", "--depth", "1", source, str(path)], check=True)
    return sorted(p for p in path.rglob("*") if p.suffix.lower() in HOMES)


def try_home(home: Path) -> dict[str, str]:
    """Return the result of each verb on a home."""
    folder = OUT / f"{home.stem}_{home.suffix[1:]}"
    folder.mkdir(exist_ok=True)
    row = {"home": f"{home.stem} ({home.suffix[1:]})"}
    blend, reference = folder / "home.blend", folder / "reference.blend"
    model = home
    if home.suffix.lower() == ".ifc":
        model = folder / "home.obj"
        row["import"] = run(folder, "ifc", [ifc_python(), HERE / "ifc_to_obj.py", home, model])[0]
    mark, said = run(folder, "furnish", [HERE / "furnish.py", model, blend, reference])
    size = [line for line in said.splitlines() if line.startswith("size: ")]
    row["import"] = size[0].removeprefix("size: ") if size else mark
    if not mark.startswith("ok"):
        return row
    for name, arguments in verbs_on(folder).items():
        row[name] = run(folder, name, ["-m", "angen_addon", *arguments])[0]
    return row


def verbs_on(folder: Path) -> dict[str, list[object]]:
    """Return the arguments after `angen` of each verb for a furnished home."""
    blend, reference, events = (folder / n for n in ("home.blend", "reference.blend", "events.csv"))
    verbs: dict[str, list[object]] = {
        "list": ["list", blend, "--json"],
        "doctor": ["doctor", blend],
        "simulate": ["simulate", blend, *BLIND, "--events", events, "--samples", folder / "rows"],
        "light": ["simulate", blend, *LIGHT, "--events", folder / "light.csv"],
        "as ray_cast": ["check", reference, events, *BLIND, "--tolerance", "1e-3"],
        "report": ["simulate", blend, *BLIND, "--report", folder / "report.html"],
        "coverage": ["coverage", blend, "--picture", folder / "coverage.svg", "--cell", "0.5"],
        "place": ["place", blend, "--count", "1", "--cell", "0.5", "--csv", folder / "place.csv"],
    }
    verbs["report"] += ["--save", folder / "recorded.blend", "--events", folder / "again.csv"]
    for name in EXPLAINED:
        verbs[f"explain {name}"] = ["explain", blend, "--sensor", f"Angen {name}", "--time", "2"]
    return verbs


def run(folder: Path, name: str, command: list[object]) -> tuple[str, str]:
    """Run a command, and keep its output beside the home; return how it ended and its last line."""
    program = [] if str(command[0]).endswith("python") else [sys.executable]
    began = time.monotonic()
    try:
        done = subprocess.run(
            [*program, *map(str, command)],
            cwd=ROOT,
            capture_output=True,
            encoding="utf-8",
            errors="replace",
            timeout=LIMIT,
        )
        status, said = done.returncode, done.stdout + done.stderr
        out = done.stdout
    except subprocess.TimeoutExpired:
        status, said, out = -1, f"not done after {LIMIT:.0f} s", ""
    took = time.monotonic() - began
    (folder / f"{name.replace(' ', '_')}.txt").write_text(said, encoding="utf-8")
    last = next((line for line in reversed(said.splitlines()) if line.strip()), "")
    mark = f"ok, {took:.0f} s"
    if status:
        # One line that names the fault of the home is a refusal; anything else is a failure.
        is_refused = status in (1, 2) and last.startswith("angen: ") and "Traceback" not in said
        mark = f"{'told' if is_refused else 'FAILED'} ({status}): {last[:120]}"
    print(f"   {name}: {mark}", flush=True)
    return mark.replace("|", "/"), out


def ifc_python() -> Path:
    """Return a Python that has ifcopenshell, installed if it is missing."""
    folder = OUT / "ifc-venv"
    python = folder / "bin" / "python"
    if not python.exists():
        subprocess.run([sys.executable, "-m", "venv", str(folder)], check=True)
        subprocess.run([str(python), "-m", "pip", "install", "-q", "ifcopenshell"], check=True)
    return python


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    sys.exit(main(sys.argv[1:]))
