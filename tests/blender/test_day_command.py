# SPDX-License-Identifier: GPL-3.0-or-later
"""`angen day` as a user calls it: the folder, going on with it, Ctrl-C, and what can be wrong."""

from __future__ import annotations

import errno
import json
import math
import os
import signal
import subprocess
import sys
import tomllib
from collections.abc import Callable
from datetime import datetime
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest
from lived_home import FIRST_DAY, LIVED, ROUTINE, content, rows, words_of, write
from tiers import mostly_slow

ROOT = Path(__file__).resolve().parents[2]
# What stays of a run in a folder.
TABLES = ["activities.csv", "casas.txt", "casas.txt.sensors.csv", "events.csv", "home.toml",
          "people.csv"]  # fmt: skip


def say(*words: object) -> list[str]:
    return [str(word) for word in words]


@pytest.fixture
def home(lived_home: Path) -> Path:
    return lived_home


@pytest.fixture
def day(angen_day: Callable[..., tuple[int, str]]) -> Callable[..., tuple[int, str]]:
    return angen_day


def test_a_folder_of_days_tells_what_was_sensed_and_what_was_true(
    lived: Callable[..., Path], home: Path
) -> None:
    def state() -> Any:
        rig = bpy.data.objects["Adult"]
        parts = [bpy.data.objects["Door"], rig, *rig.pose.bones]
        placed = [np.array(part.matrix_basis).ravel() for part in parts]
        return np.concatenate([[bpy.data.lights["Lamp"].energy], *placed])

    before = state()
    LIVED.pop(2, None)
    out = lived(2)
    assert sorted(p.name for p in out.iterdir() if p.is_file()) == TABLES
    events, done = rows(out / "events.csv"), rows(out / "activities.csv")
    times = [datetime.fromisoformat(row["time"]) for row in events]
    assert times == sorted(times) and len(events[0]["time"]) == len("2026-03-02T00:00:00.000")
    begin = {(r["sensor"], r["field"]) for r in events if r["time"] == "2026-03-02T00:00:00.000"}
    assert begin == {("PIR left", "moved"), ("PIR right", "moved"), ("Contact", "open")}
    # Nobody is invisible, and nothing moves by itself.
    moved = [r for r in events if r["field"] == "moved" and r["value"] == "1"]
    opened = [r for r in events if r["sensor"] == "Contact" and r["because"]]
    assert moved and {r["person"] for r in moved} == {"anna"}
    body = bpy.data.objects["Adult"].children[0].name
    assert {r["because"] for r in moved} <= {body, "Door"}
    assert {(r["because"], r["person"]) for r in opened} == {("Magnet", "anna")}
    assert {r["value"] for r in opened} == {"0", "1"}
    where = [(datetime.fromisoformat(r["time"]), r) for r in rows(out / "people.csv")]
    for row in moved:
        now = datetime.fromisoformat(row["time"])
        last = [told for time, told in where if time <= now][-1]
        assert last["posture"] != "away" and last["room"] in {"left", "right"}
    assert [r["activity"] for r in done[:3]] == ["Sleep", "Sit", "Sleep"]
    # What goes on over midnight is told once.
    assert [r["start"][11:] for r in done].count("00:00:00.000") == 1
    told = tomllib.loads((out / "home.toml").read_text(encoding="utf-8"))
    assert (told["home"], told["seed"], told["days"]) == ("home.blend", 1, 2)
    assert told["start"] == datetime(2026, 3, 2)
    pir = next(s for s in told["sensors"] if s["name"] == "PIR left")
    assert (pir["kind"], pir["room"], pir["place"]) == ("PIR", "left", [0.06, 3.2, 2.0])
    assert b"Sleeping" in (out / "casas.txt").read_bytes()
    # The home is as it was.
    # To the bit: what is run next in this process reads the same.
    assert np.array_equal(state(), before)
    assert not any(a.name.startswith("Day ") for a in bpy.data.actions)


@pytest.mark.parametrize("reader", ["", "driver", "node", "constraint"])
def test_a_day_has_a_camera_only_where_something_asks_for_it(
    home: Path, addon_part: Callable[[str], Any], reader: str
) -> None:
    scene = bpy.context.scene
    scene.camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(scene.camera)
    box = bpy.data.objects["Door"]
    if reader == "driver":
        target = box.driver_add("pass_index").driver.variables.new().targets[0]
        target.id_type, target.id, target.data_path = "SCENE", scene, "camera.location.x"
    elif reader == "node":
        bpy.data.node_groups.new("Looks", "GeometryNodeTree").nodes.new(
            "GeometryNodeInputActiveCamera"
        )
    elif reader == "constraint":
        box.constraints.new("FOLLOW_TRACK")
    with addon_part("angen_addon.days.aside").put_aside(scene):
        assert (scene.camera is not None) == bool(reader)
    assert scene.camera.name == "Camera"


def test_what_was_kept_is_gone_on_with(
    day: Any, home: Path, lived: Callable[..., Path], addon_part: Any, monkeypatch: Any
) -> None:
    """Ctrl-C amid the second day keeps the first; the same command then makes the rest."""
    lived(2)
    whole = LIVED[2]
    write(home.parent / "parts", FIRST_DAY, whole)
    run, steps = addon_part("angen_addon.days.run"), []
    household_run = run.Household.run

    def interrupted(self: Any, number: int, keys: Any, **more: Any) -> Any:
        made = household_run(self, number, keys, **more)
        for step in made:
            steps.append(step)
            if len(steps) == 3:
                os.kill(os.getpid(), signal.SIGINT)
            yield step
        raise AssertionError("Ctrl-C was not heard")

    monkeypatch.setattr(run.Household, "run", interrupted)
    status, told = day(out="parts")
    assert status == 1 and "1 of 2 days are in" in told and "nothing was written" not in told
    assert len(rows(home.parent / "parts" / "activities.csv")) == 3
    monkeypatch.undo()
    assert day(out="parts")[0] == 0
    assert content(home.parent / "parts") == whole
    # Once more there is nothing to do: no day is written anew.
    days = home.parent / "parts" / "days"
    written = {path.name: path.stat().st_mtime_ns for path in days.glob("*.json")}
    assert day(out="parts")[0] == 0
    assert content(home.parent / "parts") == whole
    assert written == {path.name: path.stat().st_mtime_ns for path in days.glob("*.json")}


def test_days_depend_on_themselves_alone(day: Any, home: Path, lived: Callable[..., Path]) -> None:
    """A run that begins with the second date draws it the same; the first one is another day."""
    lived(2)
    assert day("--start", "2026-03-03", out="second", days=1)[0] == 0
    for name in ("events.csv", "activities.csv"):
        both, alone = (rows(home.parent / folder / name) for folder in ("out", "second"))
        key = "start" if name == "activities.csv" else "time"
        later = [row for row in both if row[key] > "2026-03-03T00:00:01"]
        assert later == [row for row in alone if row[key] > "2026-03-03T00:00:01"]
        first = [row[key][11:] for row in both if row[key] < "2026-03-03"]
        assert first != [row[key][11:] for row in alone]


@pytest.mark.slow
def test_days_one_after_the_other_are_those_of_one_run(
    day: Any, home: Path, lived: Callable[..., Path]
) -> None:
    lived(2)
    for days in (1, 2):
        assert day(out="parts", days=days)[0] == 0
    assert content(home.parent / "parts") == LIVED[2]


def test_a_full_disk_is_one_line_and_keeps_whole_days(
    day: Any, home: Path, lived: Callable[..., Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is left is a folder with which the same command goes on, once there is room."""
    lived(1, "first")
    out = home.parent / "out"
    write(out, FIRST_DAY, LIVED[1])

    def full(number: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    status, told = day()
    assert status == 1 and "No space left on device" in told and len(told.splitlines()) == 1, told
    assert content(out) == {name: LIVED[1][name] for name in FIRST_DAY}
    monkeypatch.undo()
    assert day(days=1)[0] == 0
    assert content(out) == LIVED[1]


def test_a_script_gets_the_same_days(
    lived: Callable[..., Path], home: Path, addon_part: Callable[..., Any]
) -> None:
    lived(1)
    rows_of = addon_part("sensor_logic.days.rows")
    opened = addon_part("angen_addon.api.home").open_home(home)
    told: list[float] = []
    routine = home.parent / "week.toml"
    made = list(opened.days(routine, "2026-03-02", seed=1, progress=told.append))
    assert told == sorted(told) and told[-1] == 1.0
    files = rows_of.DayRows.of(made).files()
    for name, text in files.items():
        assert (home.parent / "out" / name).read_bytes() == text.encode()
    error = addon_part("angen_addon.api.error").AngenError
    with pytest.raises(error, match="is not a date"):
        list(opened.days(routine, "March"))


@pytest.mark.parametrize(("days", "jobs"), mostly_slow([(2, 2), (1, 2), (2, 3)], (1, 2)))
def test_processes_write_the_same_bytes(
    day: Any, home: Path, lived: Callable[..., Path], monkeypatch: Any, days: int, jobs: int
) -> None:
    """They share the days and, of those left over, the hours; this process is the first."""
    lived(days)
    more = ("--jobs", jobs)
    monkeypatch.setattr(sys, "argv", ["angen", "day", str(home), *words_of(
        home, *more, out="both", days=days)])  # fmt: skip
    status, told = day(*more, out="both", days=days)
    assert status == 0, told
    assert f"{days} of {days} days are in" in told
    assert content(home.parent / "both") == LIVED[days]


@pytest.mark.slow
def test_what_is_told_by_a_step_goes_on_from_the_last_event_before_a_cut(
    day: Any, home: Path, world: Any
) -> None:
    sensor = world.sensor("DISTANCE", "Range", update_rate=1.0)
    sensor.location, sensor.rotation_euler = (0.06, 2.4, 1.2), (math.radians(90), 0, -math.pi / 2)
    # Noise that hardly ever reaches a step: which readings do depends on all of them before.
    sensor.angen_sensor.distance.noise_sigma = 0.01
    sensor.angen_sensor.distance.report_step = 0.03
    bpy.ops.wm.save_mainfile()
    assert day(days=1)[0] == 0
    words = words_of(home, "--jobs", 2, out="both", days=1)
    command = [sys.executable, "-m", "angen_addon", "day", str(home), *words]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert content(home.parent / "both") == content(home.parent / "out")
    told = [r for r in rows(home.parent / "out" / "events.csv") if r["field"] == "distance_m"]
    assert len(told) > 1000


SECOND = ("--day-share", "1/2", "--cut-days", "0")
FIRST = ("--day-share", "0/2", "--cut-days", "0")


@pytest.mark.slow
def test_stretches_of_a_day_are_joined_to_the_same_bytes(
    day: Any, home: Path, lived: Callable[..., Path], monkeypatch: Any, addon_part: Any
) -> None:
    lived(1)
    days = home.parent / "both" / "days"
    state, second = "2026-03-02.2-of-2.json", "2026-03-02.2-to-2-of-2.json"
    assert day(*SECOND, days=1, out="both")[0] == 0
    assert sorted(path.name for path in days.glob("*.json")) == [state, second]
    # It ends where the other began, and what is there is gone on with.
    assert day(*FIRST, days=1, out="both") == (0, "")
    names = ["2026-03-02.1-to-1-of-2.json", state, second]
    assert sorted(path.name for path in days.glob("*.json")) == names
    shared = [json.loads((days / name).read_text("utf-8"))["events"] for name in names[::2]]
    assert all(len(events) > 1 for events in shared)
    # Nothing is lived again.
    monkeypatch.setattr(addon_part("angen_addon.days.run").Household, "run", None)
    assert day(days=1, out="both")[0] == 0
    assert content(home.parent / "both") == LIVED[1]


@pytest.mark.slow
def test_where_a_sensor_had_not_settled_one_process_goes_on(day: Any, home: Path) -> None:
    # What moved in the morning is held until the night.
    bpy.data.objects["PIR left"].angen_sensor.pir.hold_time = 14 * 3600.0
    assert day(days=1)[0] == 0
    days = home.parent / "both" / "days"
    assert day(*SECOND, days=1, out="both")[0] == 0
    second = json.loads((days / "2026-03-02.2-to-2-of-2.json").read_text("utf-8"))["events"]
    whole = json.loads((home.parent / "out/days/2026-03-02.json").read_text("utf-8"))["events"]
    # By itself the second process tells what never was.
    assert {tuple(e[:5]) for e in second} - {tuple(e[:5]) for e in whole}
    status, told = day(*FIRST, days=1, out="both")
    assert status == 0 and "one process goes on, for PIR left had not settled there" in told
    assert (days / "2026-03-02.1-to-2-of-2.json").is_file()
    assert day(days=1, out="both")[0] == 0
    assert content(home.parent / "both") == content(home.parent / "out")


@pytest.fixture
def killed(monkeypatch: Any, addon_part: Any) -> None:
    """Processes of `--jobs` are killed as they begin."""
    command = [sys.executable, "-c", "import os, signal; os.kill(os.getpid(), signal.SIGKILL)"]
    monkeypatch.setattr(addon_part("angen_addon.days.jobs"), "command_of", lambda *_: command)


def test_where_the_other_process_is_killed_at_once_this_one_makes_the_day(
    day: Any, home: Path, lived: Callable[..., Path], killed: None
) -> None:
    lived(1)
    status, told = day("--jobs", 2, days=1, out="both")
    assert status == 1 and "1 of 1 days are in" in told
    assert day(days=1, out="both")[0] == 0
    for name in ("events.csv", "activities.csv", "people.csv"):
        assert content(home.parent / "both")[name] == LIVED[1][name]


@pytest.mark.slow
def test_a_process_that_is_killed_loses_its_own_stretch_alone(
    day: Any, home: Path, lived: Callable[..., Path], killed: None
) -> None:
    """The stretch of this process stays; the other one's is made by whoever goes on."""
    lived(1)
    days = home.parent / "both" / "days"
    assert day(*SECOND, days=1, out="both")[0] == 0
    (days / "2026-03-02.2-to-2-of-2.json").unlink()
    status, told = day("--jobs", 2, days=1, out="both")
    assert status == 1 and "0 of 1 days are in" in told
    first = days / "2026-03-02.1-to-1-of-2.json"
    kept = first.read_bytes()
    assert day(*SECOND, days=1, out="both")[0] == 0
    assert first.read_bytes() == kept
    assert day(days=1, out="both")[0] == 0
    assert content(home.parent / "both") == content(home.parent / "out")


def test_what_goes_from_frame_to_frame_stays_in_one_process(
    world: Any, addon_part: Callable[[str], Any]
) -> None:
    why = addon_part("angen_addon.days.stretch").why_whole
    assert why(world.scene) == ""
    world.box((1, 1, 1)).modifiers.new("Cloth", "CLOTH")
    assert why(world.scene) == "physics go from frame to frame"


@pytest.mark.parametrize(
    ("more", "text", "changed"),
    [
        (["--seed", 2], "holds another run", ""),
        (["--start", "2026-03-03"], "holds another run", ""),
        (["--routine", "none.toml"], "cannot read none.toml", ""),
        (["--start", "2026-02-30"], "is not a date", ""),
        ([], "holds another run", ROUTINE.replace("90 min", "80 min")),
        ([], "no resident 'Adul'", ROUTINE.replace('"Adult"', '"Adul"')),
        ([], "no place is marked 'Sofa'", ROUTINE.replace("sit Seat", "sit Sofa")),
        ([], "two things at once", ROUTINE.replace('"09:00"', '"07:00"')),
    ],
)
def test_what_is_wrong_is_one_line_and_loses_nothing(
    day: Any,
    home: Path,
    lived: Callable[..., Path],
    more: list[object],
    text: str,
    changed: str,
) -> None:
    out = lived(1)
    before = content(out)
    if changed:
        (home.parent / "week.toml").write_text(changed, encoding="utf-8")
    status, told = day(*more, days=1)
    assert status in (1, 2) and text in told and len(told.splitlines()) == 1, told
    assert content(out) == before


@pytest.mark.slow
def test_days_can_have_the_sensors_of_a_layout(day: Any, home: Path) -> None:
    layout, out = home.parent / "real.json", home.parent / "real"
    right = {"name": "PIR right", "preset": "CASAS_WALL", "update_rate": 10}
    layout.write_text(json.dumps({"others_enabled": False, "sensors": [right]}))
    before = home.read_bytes()
    status, told = day("--layout", layout, out=out.name, days=1)
    assert status == 0, told
    assert home.read_bytes() == before
    (sensor,) = tomllib.loads((out / "home.toml").read_text(encoding="utf-8"))["sensors"]
    assert (sensor["name"], sensor["preset"]) == ("PIR right", "CASAS_WALL")
    # Another layout is another run.
    layout.write_text(json.dumps([{"name": "PIR right", "parameters": {"hold_time": 3}}]))
    status, told = day("--layout", layout, out=out.name, days=1)
    assert status != 0 and "holds another run" in told


def test_a_folder_with_other_things_in_it_is_left_alone(day: Any, home: Path) -> None:
    (home.parent / "out").mkdir()
    (home.parent / "out" / "thesis.txt").write_text("mine")
    status, told = day()
    assert status == 1 and "is not empty and holds no days" in told
    assert content(home.parent / "out") == {"thesis.txt": b"mine"}
