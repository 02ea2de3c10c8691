# SPDX-License-Identifier: GPL-3.0-or-later
"""Days by two processes, in a real Blender."""

from __future__ import annotations

import csv
import subprocess
from collections.abc import Callable
from datetime import datetime
from itertools import pairwise
from pathlib import Path

import build_zip

Angen = Callable[..., subprocess.CompletedProcess[str]]
HOME = build_zip.ROOT / "sample_blends" / "angen.blend"
ENTRANCE = "Switch entrance"


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_days_tell_who_opened_the_entrance_when_somebody_left(angen: Angen, tmp_path: Path) -> None:
    routine = HOME.with_name("week.toml")
    options = ["--routine", str(routine), "--start", "2026-03-02", "--seed", "1", "--quiet"]
    options += ["--days", "2"]
    options += ["--sensor", ENTRANCE, "--out", str(tmp_path / "day")]
    done = angen(HOME, "day", *options, "--jobs", "2")
    assert done.returncode == 0, done.stderr
    events = rows(tmp_path / "day" / "events.csv")
    assert {row["sensor"] for row in events} == {ENTRANCE}
    opened = [row for row in events if row["value"] == "1"]
    assert opened and all(row["person"] and row["because"] for row in opened)
    people = rows(tmp_path / "day" / "people.csv")
    left = [
        datetime.fromisoformat(row["time"])
        for before, row in pairwise(people)
        if row["posture"] == "away" and before["posture"] != "away"
    ]
    times = [datetime.fromisoformat(row["time"]) for row in opened]
    assert left
    for moment in left:
        assert any(abs((moment - time).total_seconds()) < 30.0 for time in times), moment
    # What is there is whole: nothing is lived again.
    written = {path.name: path.read_bytes() for path in (tmp_path / "day").glob("*.csv")}
    assert angen(HOME, "day", *options).returncode == 0
    assert written == {path.name: path.read_bytes() for path in (tmp_path / "day").glob("*.csv")}
