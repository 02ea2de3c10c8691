# SPDX-License-Identifier: GPL-3.0-or-later
"""`angen day` as a user calls it: its folder, a run continued, Ctrl-C, and wrong inputs."""

from __future__ import annotations

import contextlib
import errno
import json
import os
import re
import signal
import subprocess
import sys
import time
import tomllib
from collections.abc import Callable
from datetime import date, datetime
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.commands.convert import main as convert
from bl_ext.user_default.angen_sensors.residents.blender import shared_days as jobs
from bl_ext.user_default.angen_sensors.residents.blender.api import Home
from bl_ext.user_default.angen_sensors.residents.days import rows as rows_of
from bl_ext.user_default.angen_sensors.sensor_logic.logs.error import AngenError as error
from lived_home import FIRST_DAY, LIVED, ROUTINE, content, rows, words_of, write
from tiers import mostly_slow

ROOT = Path(__file__).resolve().parents[2]
# The files of a run in its folder.
TABLES = ["activities.csv", "casas.txt", "casas.txt.sensors.csv", "events.csv", "home.toml",
          "people.csv"]  # fmt: skip


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
    # No resident is invisible, and nothing moves without one.
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
    # An activity over midnight has one row.
    assert [r["start"][11:] for r in done].count("00:00:00.000") == 1
    told = tomllib.loads((out / "home.toml").read_text(encoding="utf-8"))
    assert (told["home"], told["seed"], told["days"]) == ("home.blend", 1, 2)
    assert told["start"] == datetime(2026, 3, 2)
    pir = next(s for s in told["sensors"] if s["name"] == "PIR left")
    assert (pir["kind"], pir["room"], pir["place"]) == ("PIR", "left", [0.06, 3.2, 2.0])
    assert b"Sleeping" in (out / "casas.txt").read_bytes()
    # The home is as before.
    # To the bit: the next run in this process reads the same.
    assert np.array_equal(state(), before)
    assert not any(a.name.startswith("Day ") for a in bpy.data.actions)


@pytest.mark.parametrize("name", ["casas", "casas-csv"])
def test_convert_of_the_folder_keeps_the_truth_as_the_routine_labels_it(
    lived: Callable[..., Path], tmp_path: Path, name: str
) -> None:
    out, target = lived(2), tmp_path / "converted.txt"
    assert convert([str(out), "--format", name, "--out", str(target)], "angen") == 0
    # The events of the folder are rounded to milliseconds.
    if name == "casas":
        times = re.compile(r"\.\d{6} ")
        written = times.sub(" ", (out / "casas.txt").read_text())
        assert times.sub(" ", target.read_text()) == written
    text = target.read_text()
    assert "Sleeping" in text and "Sit" in text and not re.search(r"\bSleep\b", text)
    sensors = target.with_name(f"{target.name}.sensors.csv").read_text()
    assert ",left" in sensors and ",right" in sensors


def test_what_was_kept_is_gone_on_with(
    day: Any, home: Path, lived: Callable[..., Path], addon_part: Any, monkeypatch: Any
) -> None:
    """Ctrl-C during the second day keeps the first; the same command then makes the rest."""
    lived(2)
    whole = LIVED[2]
    write(home.parent / "parts", FIRST_DAY, whole)
    run, steps, grown = addon_part("residents.blender.run"), [], []
    household_run = run.HouseholdDays.run

    def interrupted(self: Any, number: int, keys: Any, **more: Any) -> Any:
        made = household_run(self, number, keys, **more)
        for step in made:
            steps.append(step)
            if len(steps) == 3:
                grown.append((home.parent / "parts" / "events.csv").read_bytes())
                signal.raise_signal(signal.SIGINT)
            yield step
        raise AssertionError("Ctrl-C was not heard")

    monkeypatch.setattr(run.HouseholdDays, "run", interrupted)
    status, told = day(out="parts")
    assert status == 1 and "1 of 2 days are in" in told and "nothing was written" not in told
    assert len(rows(home.parent / "parts" / "activities.csv")) == 3
    monkeypatch.undo()
    # The first day was there before the second was whole.
    assert grown == [(home.parent / "parts" / "events.csv").read_bytes()]
    assert day(out="parts")[0] == 0
    assert content(home.parent / "parts") == whole
    assert whole["events.csv"].startswith(grown[0])
    # The command again has nothing to do: no day is rewritten.
    days = home.parent / "parts" / "days"
    written = {path.name: path.stat().st_mtime_ns for path in days.glob("*.json")}
    assert day(out="parts")[0] == 0
    assert content(home.parent / "parts") == whole
    assert written == {path.name: path.stat().st_mtime_ns for path in days.glob("*.json")}


def test_days_depend_on_themselves_alone(day: Any, home: Path, lived: Callable[..., Path]) -> None:
    """A run that begins with the second date draws that day the same; the first one differs."""
    lived(2)
    assert day("--start", "2026-03-03", out="second", days=1)[0] == 0
    for name in ("events.csv", "activities.csv"):
        both, alone = (rows(home.parent / folder / name) for folder in ("out", "second"))
        key = "start" if name == "activities.csv" else "time"
        later = [row for row in both if row[key] > "2026-03-03T00:00:01"]
        assert later == [row for row in alone if row[key] > "2026-03-03T00:00:01"]
        first = [row[key][11:] for row in both if row[key] < "2026-03-03"]
        assert first != [row[key][11:] for row in alone]


def test_a_log_that_excel_has_open_on_windows_while_days_are_made(
    day: Any, home: Path, lived: Callable[..., Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    """It grows again once it is closed, and the days go on meanwhile."""
    lived(2)
    out, rename, opened = home.parent / "parts", os.rename, [True]
    write(out, FIRST_DAY, LIVED[2])
    (out / "events.csv").write_bytes(b"a former run")

    def guarded(old: Any, new: Any, **options: Any) -> None:
        if opened and str(out / "events.csv") in (str(old), str(new)):
            raise PermissionError(13, "Permission denied", str(old), 32, str(new))
        rename(old, new, **options)

    monkeypatch.setattr(os, "rename", guarded)
    status, told = day(out="parts")
    assert status == 1 and "another program has" in told and "events.csv open" in told
    assert (out / "days" / "2026-03-03.json").is_file()
    assert (out / "events.csv").read_bytes() == b"a former run"
    opened.clear()
    assert day(out="parts")[0] == 0
    assert content(out) == LIVED[2]


def test_a_full_disk_is_one_line_and_keeps_whole_days(
    day: Any, home: Path, lived: Callable[..., Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same command continues in that folder once there is room."""
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


def test_a_script_gets_the_same_days(lived: Callable[..., Path], home: Path) -> None:
    lived(1)
    opened = Home.open(home)
    told: list[float] = []
    routine = home.parent / "week.toml"
    made = list(opened.days(routine, "2026-03-02", seed=1, progress=told.append))
    assert told == sorted(told) and told[-1] == 1.0
    files = rows_of.DayRows.joined(made).files()
    for name, text in files.items():
        assert (home.parent / "out" / name).read_bytes() == text.encode()
    with pytest.raises(error, match="is not a date"):
        list(opened.days(routine, "March"))


@pytest.mark.parametrize("jobs", mostly_slow([2, 3], 2))
def test_processes_write_the_same_bytes(
    day: Any, home: Path, lived: Callable[..., Path], monkeypatch: Any, jobs: int
) -> None:
    """The processes share the days; this process is the first."""
    lived(2)
    more = ("--jobs", jobs)
    monkeypatch.setattr(sys, "argv", ["angen", "day", str(home), *words_of(
        home, *more, out="both")])  # fmt: skip
    status, told = day(*more, out="both")
    assert status == 0, told
    assert "2 of 2 days are in" in told
    assert content(home.parent / "both") == LIVED[2]


@pytest.fixture
def workers_do(monkeypatch: Any) -> Callable[[str], None]:
    """Make the processes of `--jobs` run this Python code instead."""

    def do(code: str) -> None:
        command = [sys.executable, "-c", f"import os, signal, sys\n{code}"]
        monkeypatch.setattr(jobs, "worker_command", lambda: command)

    return do


@pytest.mark.skipif(sys.platform == "win32", reason="has no SIGKILL")
def test_the_day_of_a_process_that_is_killed_is_made_by_another(
    day: Any, home: Path, lived: Callable[..., Path], workers_do: Any
) -> None:
    lived(2)
    workers_do("os.kill(os.getpid(), signal.SIGKILL)")
    status, told = day("--jobs", 2, out="both")
    first, *_, last = told.splitlines()
    assert first == (
        "angen: a process of --jobs was ended by the signal SIGKILL; another process "
        "simulates 2026-03-03 again"
    )
    assert status == 0 and "2 of 2 days are in" in last and "2 simulated in" in last
    assert content(home.parent / "both") == LIVED[2]


def test_a_process_that_crashes_with_the_status_of_windows_is_told(
    day: Any, home: Path, lived: Callable[..., Path], workers_do: Any
) -> None:
    """There a crash has a positive status: 0xC0000005 is an access violation."""
    lived(2)
    workers_do("os._exit(0xC5)")
    status, told = day("--jobs", 2, out="both")
    assert told.splitlines()[0] == (
        "angen: a process of --jobs was ended with status 0xc5; another process simulates "
        "2026-03-03 again"
    )
    assert status == 0
    assert content(home.parent / "both") == LIVED[2]


def test_ctrl_c_in_a_terminal_of_windows_reaches_no_worker(monkeypatch: Any) -> None:
    """There it reaches all processes of a group."""
    given: dict[str, Any] = {}

    def start(command: list[str], **options: Any) -> Any:
        given.update(options)
        raise OSError

    monkeypatch.setattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0x200, raising=False)
    monkeypatch.setattr(subprocess, "Popen", start)
    shared = jobs.SharedDays(None, [1, 2], 1)  # type: ignore[arg-type]
    with pytest.raises(OSError), shared:
        pass
    assert given["creationflags"] == 0x200 and given["start_new_session"]


def started(home: Path, days: int) -> subprocess.Popen[str]:
    """Start `angen day --jobs 2`, and wait until the second process has a day."""
    words = words_of(home, "--jobs", 2, out="both", days=days)
    command = [sys.executable, "-m", "angen_addon", "day", str(home), *words]
    run = subprocess.Popen(command, cwd=ROOT, stderr=subprocess.PIPE, text=True)
    while run.poll() is None and not workers_of(run.pid):
        time.sleep(0.05)
    time.sleep(0.5)
    return run


def workers_of(process: int) -> list[int]:
    found = Path(f"/proc/{process}/task/{process}/children").read_text(encoding="utf-8").split()
    workers = []
    for child in found:
        # Blender starts other processes too, which end at once.
        with contextlib.suppress(OSError):
            if b"--worker" in Path(f"/proc/{child}/cmdline").read_bytes():
                workers.append(int(child))
    return workers


@pytest.mark.slow
def test_workers_end_with_the_process_that_is_killed(
    day: Any, home: Path, lived: Callable[..., Path]
) -> None:
    """The same command then makes the rest, to the same bytes."""
    assert day(days=4)[0] == 0
    with started(home, 4) as run:
        (worker,) = workers_of(run.pid)
        while not [*(home.parent / "both" / "days").glob("*.json")]:
            time.sleep(0.05)
        run.kill()
        until = time.monotonic() + 10.0
        while Path(f"/proc/{worker}").exists() and time.monotonic() < until:
            time.sleep(0.05)
        assert not Path(f"/proc/{worker}").exists()
    assert len([*(home.parent / "both" / "days").glob("*.json")]) < 4
    assert day(out="both", days=4)[0] == 0
    assert content(home.parent / "both") == content(home.parent / "out")


@pytest.mark.slow
def test_ctrl_c_in_the_first_day_ends_all_processes_with_a_line(home: Path) -> None:
    with started(home, 4) as run:
        workers = workers_of(run.pid)
        run.send_signal(signal.SIGINT)
        told = run.communicate()[1]
    assert run.returncode == 1
    kept = f"0 of 4 days are in {home.parent / 'both'}"
    assert told == f"angen: {kept}; give the same command again to continue with the first\n"
    assert not any(Path(f"/proc/{worker}").exists() for worker in workers)


@pytest.mark.parametrize(
    ("more", "text", "changed"),
    [
        (["--seed", 2], "holds another run: its seed (1, not 2) differs", ""),
        (["--start", "2026-03-03"], "its start (2026-03-02, not 2026-03-03) differs", ""),
        (["--routine", "none.toml"], "cannot read none.toml", ""),
        (["--start", "2026-02-30"], "is not a date", ""),
        ([], "holds another run: its routine differs", ROUTINE.replace("90 min", "80 min")),
        (
            [],
            "week.toml, line 4: the home has no resident 'Adul'",
            ROUTINE.replace('"Adult"', '"Adul"'),
        ),
        ([], "no place is marked 'Sofa'", ROUTINE.replace("sit Seat", "sit Sofa")),
        ([], "two things at once", ROUTINE.replace('"09:00"', '"07:00"')),
    ],
)
def test_what_is_wrong_is_one_line_and_loses_nothing(
    day: Any, home: Path, lived: Callable[..., Path], more: list[object], text: str, changed: str
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
    assert status != 0 and "holds another run: its sensors differs" in told


def test_a_folder_with_other_things_in_it_is_left_alone(day: Any, home: Path) -> None:
    (home.parent / "out").mkdir()
    (home.parent / "out" / "thesis.txt").write_text("mine")
    status, told = day()
    assert status == 1 and "is not empty and holds no days" in told
    assert content(home.parent / "out") == {"thesis.txt": b"mine"}


def test_what_a_diary_begins_with_at_midnight_was_begun_before(
    home: Path, addon_part: Callable[[str], Any]
) -> None:
    run, routine = addon_part("residents.blender.run"), home.parent / "week.toml"
    diary = home.parent / "diary.csv"
    diary.write_text(
        "start,end,person,activity\n"
        "2026-03-02 00:00,2026-03-02 07:00,anna,Sleep\n2026-03-02 07:00,2026-03-02 09:00,anna,Sit\n"
    )
    household = run.HouseholdDays(
        bpy.context.scene, [], run.Plan.read(routine, diary), date(2026, 3, 2), 1
    )
    acted = household.acted(0)
    assert len(acted.spans(0.0, 6.9 * 3600)) == 0
    assert (acted.where[0].posture, acted.where[0].place) == ("lying", "Bed")
    sleep = acted.activities[0]
    assert (sleep.activity, sleep.start) == ("Sleep", 0.0) and sleep.end == pytest.approx(7 * 3600)


def test_days_that_a_diary_lacks_are_told(day: Any, home: Path) -> None:
    diary = home.parent / "diary.csv"
    head = "start,end,person,activity\n"
    diary.write_text(f"{head}2026-04-02 00:00,2026-04-03 00:00,anna,Sleep\n")
    status, told = day("--diary", diary, days=1)
    assert status != 0 and not (home.parent / "out").exists()
    assert told == (
        f"angen: {diary} says nothing of 2026-03-02: begin on one of its days, 2026-04-02\n"
    )
    diary.write_text(f"{head}2026-03-01 00:00,2026-03-02 19:00,anna,Sleep\n")
    with pytest.warns(UserWarning, match="'anna' from 2026-03-02 19:00 to 2026-03-03 00:00: 'Oth"):
        next(
            Home.open(home).days(
                home.parent / "week.toml", "2026-03-02", sensors=["Contact"], diary=diary
            )
        )


def test_a_contact_that_never_closes_is_told_after_the_days(day: Any, home: Path) -> None:
    bpy.data.objects["Contact"].angen_sensor.contact.close_distance = 0.005
    status, told = day("--sensor", "Contact", days=1)
    assert status == 0
    assert "'Contact': its magnet 'Magnet' comes no nearer than 0.0071 m, and it closes" in told


def test_a_folder_of_diaries_is_one_diary(
    home: Path, addon_part: Callable[[str], Any], tmp_path: Path
) -> None:
    run, routine = addon_part("residents.blender.run"), home.parent / "week.toml"
    one, folder = tmp_path / "one.csv", tmp_path / "days"
    night = "2026-03-02 22:00,{},anna,Sleep\n", "{},2026-03-03 07:00,anna,Sleep\n"
    head, midnight = "start,end,person,activity\n", "2026-03-03 00:00"
    one.write_text(head + night[0].format("2026-03-03 07:00"))
    folder.mkdir()
    error = addon_part("sensor_logic.logs.error").InputError
    with pytest.raises(error, match="days has no diary: name a folder with CSV files"):
        run.Plan.read(routine, folder)
    for name, row in zip(("2026-03-02.csv", "2026-03-03.csv"), night, strict=True):
        folder.joinpath(name).write_text(head + row.format(midnight))
    assert run.Plan.read(routine, folder).diary == run.Plan.read(routine, one).diary


def test_a_process_that_fails_ends_the_run_with_the_days_that_are_made(
    day: Any, home: Path, workers_do: Any
) -> None:
    workers_do("sys.exit(1)")
    status, told = day("--jobs", 2, out="both", days=3)
    assert status == 1
    kept = f"1 of 3 days are in {home.parent / 'both'}"
    assert told.endswith(f"angen: {kept}; give the same command again to continue with the next\n")
