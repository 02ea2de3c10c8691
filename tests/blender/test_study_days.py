# SPDX-License-Identifier: GPL-3.0-or-later
"""A study of days: simulated in the workers, and judged by the truth."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from test_study_run import ROOT, results, run

STUDY = """
home = "home.blend"
routine = "week.toml"
start = 2026-03-02
days = 2
seeds = [1]
measure = ["events", "active", "truth", "score.py:score"]
keep = "events"
best = "most noticed"
[vary]
sensors = [["PIR left", "PIR right", "Contact"], ["PIR left"]]
"""
SCORE = """
def score(recording, truth):
    names = {row.person for row in recording.events if row.person}
    return {"people": len(names), "activities": len(truth.activities)}
"""


@pytest.fixture
def home(lived_home: Path) -> Path:
    return lived_home


@pytest.mark.slow
def test_days_are_those_of_angen_day_and_fewer_sensors_notice_less(home: Path) -> None:
    folder = home.parent
    (folder / "study.toml").write_text(STUDY, encoding="utf-8")
    (folder / "score.py").write_text(SCORE, encoding="utf-8")
    # Together: the days are acted once for both.
    run(folder, "--jobs", "1")
    assert not (folder / "out" / "days").exists()
    whole, alone = results(folder)
    assert not whole["error"] and not alone["error"], (whole, alone)
    command: list[Any] = [sys.executable, "-m", "angen_addon", "day", home, "--quiet"]
    command += ["--routine", folder / "week.toml", "--start", "2026-03-02", "--days", "2"]
    subprocess.run([*command, "--seed", "1", "--out", folder / "days"], cwd=ROOT, check=True)
    for name in ("events.csv", "activities.csv", "people.csv"):
        kept = folder / "out" / "logs" / whole["digest"] / name
        assert kept.read_bytes() == (folder / "days" / name).read_bytes(), name
    assert (whole["people"], alone["people"]) == ("1.0", "1.0")
    assert whole["activities"] == alone["activities"]
    # The truth does not depend on the sensors. She sleeps in the right room, which the left
    # detector does not see.
    folders = [folder / "out" / "logs" / row["digest"] for row in (whole, alone)]
    for name in ("activities.csv", "people.csv"):
        assert len({(one / name).read_bytes() for one in folders}) == 1
    assert float(alone["noticed"]) < float(whole["noticed"]) <= 1.0
    assert float(whole["missed_per_day"]) < float(alone["missed_per_day"])
    assert whole["sensors_on"] == "3" and alone["sensors_on"] == "1"
    assert 0 < float(alone["active PIR left"]) == float(whole["active PIR left"]) < 0.1


@pytest.mark.slow
def test_a_routine_that_this_home_cannot_live_is_a_row_with_its_error(home: Path) -> None:
    folder = home.parent
    routine = folder / "week.toml"
    routine.write_text(routine.read_text().replace('resident = "Adult"', 'resident = "Ada"'))
    (folder / "study.toml").write_text(
        'home = "home.blend"\nroutine = "week.toml"\nstart = 2026-03-02\ndays = 1\n'
    )
    run(folder, "--jobs", "1", status=1)
    (row,) = results(folder)
    assert "the home has no resident 'Ada'; its residents are Adult" in row["error"]
