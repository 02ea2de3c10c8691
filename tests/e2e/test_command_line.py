# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line of the installed extension, in a real Blender."""

import csv
import importlib.util
import json
import subprocess
import sys
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import build_zip
from compare_events import compare

Angen = Callable[..., subprocess.CompletedProcess[str]]
HOME = build_zip.ROOT / "sample_blends" / "angen.blend"


@pytest.fixture(scope="module")
def sensors(angen: Angen) -> list[dict[str, Any]]:
    """The sample home's sensors, as the command lists them."""
    done = angen(HOME, "list", "--json")
    assert done.returncode == 0, done.stderr
    found: list[dict[str, Any]] = json.loads(done.stdout)
    return found


@pytest.fixture(scope="module")
def quick(sensors: list[dict[str, Any]]) -> list[str]:
    """Options that leave out the light sensors: their pictures take most of the time, and are not
    the same in every version of Blender."""
    return [f"--sensor={sensor['name']}" for sensor in sensors if sensor["kind"] != "LIGHT"]


@pytest.fixture(scope="module")
def event_log(angen: Angen, quick: list[str], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The events of the whole story, with the extension installed from its zip."""
    path = tmp_path_factory.mktemp("events") / "events.csv"
    done = angen(HOME, "simulate", *quick, "--events", str(path))
    assert done.returncode == 0, done.stderr
    return path


def test_list_names_every_sensor_of_the_sample_home(sensors: list[dict[str, Any]]) -> None:
    assert len(sensors) == 22
    assert len({sensor["name"] for sensor in sensors}) == 22


def test_simulate_writes_the_events(event_log: Path) -> None:
    with event_log.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == ["time_s", "frame", "sensor", "kind", "field", "value"]
    assert {row["value"] for row in rows if row["field"] == "moved"} == {"0", "1"}
    assert Counter(row["time_s"] for row in rows)["0.000000"] >= 2


def test_light_is_rendered(angen: Angen) -> None:
    """The kitchen's lamp goes on when the person comes in, at 24 s."""
    done = angen(HOME, "simulate", "--sensor=Light sensor kitchen", "--frames=553:577")
    assert done.returncode == 0, done.stderr
    rows = list(csv.DictReader(done.stdout.splitlines()))
    dark, bright = (float(row["value"]) for row in rows if row["field"] == "luminance_percent")
    assert 0.0 < 3 * dark < bright


def test_events_go_to_standard_output_without_a_file(
    angen: Angen, quick: list[str], event_log: Path
) -> None:
    done = angen(HOME, "simulate", *quick)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines() == event_log.read_text(encoding="utf-8").splitlines()


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


def test_check_finds_no_difference_to_its_own_log(
    angen: Angen, quick: list[str], event_log: Path
) -> None:
    assert angen(HOME, "check", str(event_log), *quick).returncode == 0


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
