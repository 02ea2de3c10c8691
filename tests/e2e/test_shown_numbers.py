# SPDX-License-Identifier: GPL-3.0-or-later
"""What a user reads in panels, table, labels and Explain is what the exported files say."""

import csv
import subprocess
from collections.abc import Callable
from pathlib import Path

import build_zip

Run = Callable[[list[str]], subprocess.CompletedProcess[str]]
HOME = build_zip.ROOT / "sample_blends" / "angen.blend"
SCRIPT = build_zip.ROOT / "scripts" / "shown_numbers.py"
COMPARE = ["-b", str(HOME), "--python-exit-code", "3", "--python", str(SCRIPT), "--"]
NAMED = {"table", "label", "full label", "panel", "events", "event", "Pressed By", "Explain"}


def test_every_number_on_the_screen_is_that_of_the_csv(run_blender: Run, tmp_path: Path) -> None:
    events, samples, report = tmp_path / "home.csv", tmp_path / "samples", tmp_path / "report.csv"
    arguments = [*COMPARE, str(events), str(samples), str(report)]
    done = run_blender(arguments)
    assert done.returncode == 0, done.stdout + done.stderr
    with report.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) > 10_000
    assert len({row["sensor"] for row in rows}) == 22
    assert {row["place"] for row in rows} >= NAMED

    # It would notice a file that says something else.
    wrong = samples / "Switch entrance.csv"
    wrong.write_text(wrong.read_text(encoding="utf-8").replace("0.0", "0.1"), encoding="utf-8")
    done = run_blender(arguments)
    assert done.returncode == 1
    assert "Switch entrance" in done.stdout
