# SPDX-License-Identifier: GPL-3.0-or-later
"""The installed extension in a real Blender: its command line, and days by two processes.

Also every number that a user reads in panels, table, labels and Explain equals that of the exported
files.
"""

from __future__ import annotations

import csv
import importlib.util
import json
import subprocess
import sys
from collections.abc import Callable
from datetime import datetime
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

import build_zip
from compare_events import compare

Angen = Callable[..., subprocess.CompletedProcess[str]]
HOME = build_zip.ROOT / "sample_blends" / "angen.blend"


@pytest.fixture(scope="module")
def sensors(angen: Angen) -> list[dict[str, Any]]:
    """Return the sample home's sensors, as the command lists them."""
    done = angen(HOME, "list", "--json")
    assert done.returncode == 0, done.stderr
    found: list[dict[str, Any]] = json.loads(done.stdout)
    return found


@pytest.fixture(scope="module")
def quick(sensors: list[dict[str, Any]]) -> list[str]:
    """Return options that leave out the light sensors.

    Their pictures take most of the time, and differ between versions of Blender.
    """
    return [f"--sensor={sensor['name']}" for sensor in sensors if sensor["kind"] != "LIGHT"]


@pytest.fixture(scope="module")
def event_log(angen: Angen, quick: list[str], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the events of the whole story, with the extension installed from its zip."""
    path = tmp_path_factory.mktemp("events") / "events.csv"
    done = angen(HOME, "simulate", *quick, "--events", str(path))
    assert done.returncode == 0, done.stderr
    return path


def test_simulate_writes_the_events_and_check_finds_no_difference(
    angen: Angen, sensors: list[dict[str, Any]], quick: list[str], event_log: Path
) -> None:
    assert len({sensor["name"] for sensor in sensors}) == 22
    with event_log.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == ["time_s", "frame", "sensor", "kind", "field", "value"]
    assert {row["value"] for row in rows if row["field"] == "moved"} == {"0", "1"}
    # Without a file they go to standard output.
    done = angen(HOME, "simulate", *quick)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines() == event_log.read_text(encoding="utf-8").splitlines()
    assert angen(HOME, "check", str(event_log), *quick).returncode == 0


def test_light_is_rendered(angen: Angen) -> None:
    """The kitchen's lamp goes on when the person has come in, at 31 s."""
    done = angen(HOME, "simulate", "--sensor=Light sensor kitchen", "--frames=721:745")
    assert done.returncode == 0, done.stderr
    rows = list(csv.DictReader(done.stdout.splitlines()))
    dark, bright = (float(row["value"]) for row in rows if row["field"] == "luminance_percent")
    assert 0.0 < 3 * dark < bright


@pytest.mark.skipif(
    importlib.util.find_spec("bpy") is None, reason="needs Blender's Python module (bpy)"
)
def test_the_python_module_gives_the_same_events(
    event_log: Path, quick: list[str], tmp_path: Path
) -> None:
    path = tmp_path / "events.csv"
    arguments = ["simulate", str(HOME), *quick, "--events", str(path)]
    subprocess.run(
        [sys.executable, "-m", "angen_addon", *arguments], cwd=build_zip.ROOT, check=True
    )
    assert compare(event_log, path) == []


def test_a_layout_gives_the_same_sensors_again(
    angen: Angen, sensors: list[dict[str, Any]], tmp_path: Path
) -> None:
    none, layout = tmp_path / "none.json", tmp_path / "layout.json"
    bare, again = tmp_path / "bare.blend", tmp_path / "again.blend"
    none.write_text("[]")
    layout.write_text(json.dumps(sensors))
    assert angen(HOME, "apply", str(none), "--remove", "--save", str(bare)).returncode == 0
    assert angen(bare, "apply", str(layout), "--save", str(again)).returncode == 0
    assert json.loads(angen(again, "list", "--json").stdout) == sensors


@pytest.mark.parametrize(
    ("file", "arguments", "named"),
    [
        ("missing.blend", ["simulate"], "no blend file is open"),
        (HOME, ["simulate", "--sensor", "no such sensor"], "no such sensor"),
        (HOME, ["simulate", "--frames", "nonsense"], "nonsense"),
        (HOME, ["check", "missing.csv"], "missing.csv"),
    ],
    ids=["missing file", "unknown sensor", "bad frames", "missing expectation"],
)
def test_what_cannot_be_done_exits_with_2(
    angen: Angen, file: str | Path, arguments: list[str], named: str
) -> None:
    done = angen(file, *arguments)
    assert done.returncode == 2
    assert named in done.stderr


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
    # The existing folder is complete: no day is made again.
    written = {path.name: path.read_bytes() for path in (tmp_path / "day").glob("*.csv")}
    assert angen(HOME, "day", *options).returncode == 0
    assert written == {path.name: path.read_bytes() for path in (tmp_path / "day").glob("*.csv")}


Run = Callable[[list[str]], subprocess.CompletedProcess[str]]
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

    # The comparison would notice a file with another value.
    wrong = samples / "Switch entrance.csv"
    wrong.write_text(wrong.read_text(encoding="utf-8").replace("0.0", "0.1"), encoding="utf-8")
    done = run_blender(arguments)
    assert done.returncode == 1
    assert "Switch entrance" in done.stdout


@pytest.mark.parametrize(
    ("mode", "told"),
    [
        ("--offline-mode", "Preferences ▸ System ▸ Allow Online Access"),
        ("--online-mode", "no broker listens at 127.0.0.1:1"),
    ],
)
def test_mqtt_works_from_the_zip_where_blender_allows_it(
    run_blender: Callable[[list[str]], subprocess.CompletedProcess[str]], mode: str, told: str
) -> None:
    options = ["--frames", "1:3", "--sensor", "PIR hall", "--mqtt", "127.0.0.1:1"]
    done = run_blender([mode, str(HOME), "--command", "angen", "simulate", *options])
    assert done.returncode == 1 and told in done.stderr
    assert not done.stdout
