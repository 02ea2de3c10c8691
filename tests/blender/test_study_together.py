# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs that differ only in their sensors evaluate the home once, with the same bytes as alone."""

from __future__ import annotations

import shutil
from collections import defaultdict
from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy
import pytest
from lived_home import LIVED
from tiers import mostly_slow

PLAIN = """
home = "home.blend"
seeds = [1, 2]
measure = ["events", "active", "coverage"]
keep = ["events"]
[set]
"PIR*.noise_sigma" = 0.02
[vary]
"PIR hall.hold_time" = [0.0, 0.5]
"Swept.update_rate" = [6.0, 24.0]
"PIR warm.move_z" = [0.0, 0.25]
sensors = ["*", ["PIR hall", "Swept"], ["PIR hall"]]
"""
DAYS = """
home = "home.blend"
routine = "week.toml"
start = 2026-03-02
days = 1
measure = ["events", "active", "truth"]
keep = "events"
[set]
"PIR left.move_z" = -0.3
[vary]
"PIR*.hold_time" = [0.0, 20.0]
sensors = ["*", ["PIR right"]]
"""


@pytest.fixture
def plain_home(world: Any, tmp_path: Path) -> Path:
    """Add detectors, a swept switch and light; a wall moves before them, and a lamp goes on.

    The housing of one detector is in the other's view.
    """
    world.pir("PIR hall", sweep="ALL", range_max=1.8)
    warm = world.pir("PIR warm", model="PYROELECTRIC", warm_up_time=0.0)
    warm.location = (0.2, 0, -0.6)
    housing = world.box((0.1, 0.1, 0.1), (0.0, 0, 0), "housing")
    housing.parent = warm
    world.switch("Swept", swept=True).location = (0.5, 0, 0)
    light = world.sensor("LIGHT", "Light", samples=16, update_rate=24.0)
    light.location = (0, 0, 0.2)
    lamp = world.link("Lamp", bpy.data.lights.new("Lamp", "POINT"), (0.5, 0, 0))
    world.key(lamp.data, "energy", {1: 10.0, 24: 40.0})
    wall = world.wall(1.0)
    world.key(wall, "location", {1: (0, 0, -1.0), 8: (0, 0, -1.0), 9: (0, 0, -1.5), 24: (0, 0, -3)})
    bpy.context.scene.frame_end = 24
    path = tmp_path / "home.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


def lives_of(
    home: Path, text: str, addon_part: Callable[[str], Any], days_in: str = ""
) -> list[list[Any]]:
    """Return the runs of a study beside a home, with those that are simulated together."""
    study, tasks, runs, engine = (
        addon_part(f"studies.{name}") for name in ("study", "tasks", "runs", "engine")
    )
    path = home.parent / "study.toml"
    path.write_text(text, encoding="utf-8")
    found = study.read(path)
    files = {
        str(path): tasks.File(str(path), tasks.digest_of_bytes(path.read_bytes()))
        for path in (*found.homes, *found.routines)
    }
    homes = {str(home): runs.examine(files[str(home)])}
    planned = engine.Tasks(found, files, homes, tasks.versions(), days_in)
    lives = defaultdict(list)
    for run in study.runs_of(found):
        lives[planned.group_key(run)].append(planned.task_of(run))
    return list(lives.values())


def outcome(done: Any) -> tuple[Any, ...]:
    """Return all of a result except the seconds, which vary."""
    return done.digest, done.values, done.error, done.files


@pytest.mark.parametrize("text", mostly_slow([PLAIN, DAYS], PLAIN), ids=["plain", "days"])
def test_together_each_run_gives_what_it_gives_alone(
    text: str, request: pytest.FixtureRequest, addon_part: Callable[[str], Any]
) -> None:
    home = request.getfixturevalue("plain_home" if text is PLAIN else "lived_home")
    worker = addon_part("studies.runs")
    lives = lives_of(home, text, addon_part)
    # A sensor's pose belongs to the home, as do the seed, and whether light is measured.
    sizes = sorted(len(life) for life in lives)
    assert sizes == ([4] * 4 + [8] * 4 if text is PLAIN else [4])
    objects = set(bpy.data.objects.keys())
    different = set()
    for life in lives:
        together = {done.digest: outcome(done) for done in worker.run(life)}
        for task in life[::3]:
            (alone,) = map(outcome, worker.run([task]))
            assert not alone[2] and together[task.digest] == alone
        different |= {str(one[1:]) for one in together.values()}
    assert len(different) == sum(sizes)
    assert set(bpy.data.objects.keys()) == objects


@pytest.mark.slow
def test_a_day_in_a_study_is_that_of_angen_day(
    lived_home: Path,
    lived: Callable[..., Path],
    addon_part: Callable[[str], Any],
) -> None:
    """Its events and its truth, to the byte."""
    lived(1)
    text = DAYS.split("[set]")[0].replace("days = 1", "days = 1\nseeds = [1]")
    text += '[vary]\nsensors = ["*"]\n'
    (life,) = lives_of(lived_home, text, addon_part)
    (done,) = addon_part("studies.runs").run(life)
    assert not done.error and done.values["events"]
    found = {Path(name).name: text.encode() for name, text in done.files.items()}
    for name in ("events.csv", "activities.csv", "people.csv"):
        assert found[name] == LIVED[1][name], name


def test_days_that_cannot_be_lived_are_told_with_the_reason(
    lived_home: Path, addon_part: Callable[[str], Any]
) -> None:
    routine = lived_home.parent / "week.toml"
    routine.write_text(routine.read_text().replace('resident = "Adult"', 'resident = "Ada"'))
    text = DAYS.split("measure")[0].replace("days = 1", "days = 1\nseeds = [1]")
    (life,) = lives_of(lived_home, text, addon_part)
    (done,) = addon_part("studies.runs").run(life)
    assert "the home has no resident 'Ada'; its residents are Adult" in done.error


def test_one_that_fails_is_told_and_the_others_go_on(
    plain_home: Path, addon_part: Callable[[str], Any]
) -> None:
    worker = addon_part("studies.runs")
    (life,) = lives_of(
        plain_home,
        'home = "home.blend"\n[vary]\n"PIR hall.range_max" = [1.8, 0.01, 1.2]\n'
        'sensors = [["PIR hall"]]\n',
        addon_part,
    )
    found = {done.digest: done for done in worker.run(life)}
    first, bad, last = (found[task.digest] for task in life)
    assert "range_m" in bad.error and not bad.values
    assert first.values["events"] and last.values["events"]
    assert not first.error and not last.error


@pytest.mark.slow
def test_days_that_a_killed_worker_lived_are_not_lived_again(
    lived_home: Path,
    addon_part: Callable[[str], Any],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    text = DAYS.replace('keep = "events"\n', "").replace("days = 1", "days = 2")
    runs = addon_part("studies.runs")
    kept = lived_home.parent / "days"
    kept.mkdir()
    (life,) = lives_of(lived_home, text, addon_part, str(kept))
    lived, really = [], runs.run_days

    def run_days(household: Any, numbers: list[int]) -> Any:
        lived.append(list(numbers))
        for one in really(household, numbers):
            yield one
            if len(lived) == 1:
                raise KeyboardInterrupt

    monkeypatch.setattr(runs, "run_days", run_days)
    with pytest.raises(KeyboardInterrupt):
        runs.run(life)
    again = [outcome(done) for done in runs.run(life)]
    assert lived == [[0, 1], [1]]
    shutil.rmtree(kept)
    assert [outcome(done) for done in runs.run(life)] == again and lived[2:] == [[0, 1]]
