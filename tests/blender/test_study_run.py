# SPDX-License-Identifier: GPL-3.0-or-later
"""`angen study run`, as a user types it, with workers that are killed, missing or different."""

from __future__ import annotations

import contextlib
import csv
import os
import pickle
import platform
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import bpy
import psutil
import pytest

from dev import link_folder

ROOT = Path(__file__).resolve().parent.parent.parent
STUDY = """
home = "home.blend"
seeds = 2
measure = ["events", "active", "score.py:score"]
keep = ["events"]
[vary]
"PIR hall.range_max" = [0.5, 1.8]
"PIR hall.move_z" = [0.0, -0.5]
[set]
"PIR hall.noise_sigma" = 0.02
"""
SCORE = """
import time
def score(recording, truth):
    time.sleep(PAUSE)
    return {"moves": sum(row.value == "1" for row in recording.events)}
"""
RUNS = 8


@pytest.fixture
def folder(world, tmp_path) -> Path:
    """Return a folder with a home, in which a wall moves before a detector, and a study of it."""
    world.sensor("PIR", "PIR hall", update_rate=24.0, sweep="ALL", rays=9)
    wall = world.wall(1.0)
    for frame, z in ((1, -1.0), (11, -1.0), (12, -1.5), (48, -3.0)):
        wall.location.z = z
        wall.keyframe_insert("location", frame=frame)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "home.blend"))
    (tmp_path / "study.toml").write_text(STUDY)
    (tmp_path / "score.py").write_text(SCORE.replace("PAUSE", "0.0"))
    return tmp_path


def start(folder: Path, *options: str, **how: object) -> subprocess.Popen:
    command = [sys.executable, "-m", "angen_addon", "study", "run", str(folder / "study.toml")]
    command += ["--out", str(folder / "out"), *options]
    how.setdefault("cwd", ROOT)
    return subprocess.Popen(command, stderr=subprocess.PIPE, text=True, **how)


def run(folder: Path, *options: str, status: int = 0, **how: object) -> str:
    driver = start(folder, *options, **how)
    told = driver.communicate(timeout=300)[1]
    assert driver.returncode == status, told
    assert "Traceback" not in told, told
    return told


def results(folder: Path) -> list[dict[str, str]]:
    """Return the table without the columns of times."""
    with open(folder / "out" / "results.csv", encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        assert float(row.pop("seconds")) >= 0
    return rows


def everything(folder: Path) -> tuple[list[dict[str, str]], dict[str, bytes]]:
    logs = (folder / "out" / "logs").iterdir()
    return results(folder), {path.name: path.read_bytes() for path in logs}


def anew(folder: Path) -> None:
    shutil.rmtree(folder / "out")


def lines_at(folder: Path) -> int:
    path = folder / "out" / "runs.jsonl"
    return path.read_bytes().count(b"\n") if path.exists() else 0


def wait_until(reached: Callable[[], bool], driver: subprocess.Popen | None = None) -> None:
    end = time.monotonic() + 120
    while not reached():
        assert time.monotonic() < end and (driver is None or driver.poll() is None)
        time.sleep(0.05)


@pytest.fixture
def daemon() -> Iterator[Callable[..., subprocess.Popen]]:
    """Start a scheduler or a worker by Dask's own command; it ends with the test."""
    started: list[subprocess.Popen] = []

    def begin(*words: str, path: Path | None = None) -> subprocess.Popen:
        env = os.environ | ({"PYTHONPATH": str(path)} if path else {})
        command = [sys.executable, "-m", "distributed.cli.dask_" + words[0], *words[1:]]
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        started.append(subprocess.Popen(command, env=env, **quiet))
        return started[-1]

    yield begin
    for process in started:
        process.kill()
        process.wait()


@pytest.fixture
def package(tmp_path) -> Path:
    """Return a folder from which the package can be imported."""
    found = tmp_path / "package"
    found.mkdir()
    link_folder(found / "angen_sensors", ROOT)
    return found


@pytest.fixture
def scheduler(daemon, tmp_path) -> tuple[subprocess.Popen, str]:
    """Return a scheduler, and its address."""
    file = tmp_path / "scheduler.json"
    process = daemon(
        "scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard",
        "--scheduler-file", str(file),
    )  # fmt: skip
    wait_until(lambda: file.exists() and file.stat().st_size > 100)
    import json

    return process, json.loads(file.read_text())["address"]


@pytest.mark.slow
def test_the_results_are_the_same_for_any_number_of_workers_order_and_engine(
    folder, daemon, scheduler, package
) -> None:
    run(folder, "--jobs", "1")
    alone = everything(folder)
    rows, logs = alone
    assert len(rows) == RUNS and not any(row["error"] for row in rows)
    assert [row["run"] for row in rows] == [str(n + 1) for n in range(RUNS)]
    # With a long range it sees the wall move; noise makes seeds differ.
    assert len({row["moves"] for row in rows}) > 2 and len(set(logs.values())) > 4
    anew(folder)
    # Backwards: the last values first.
    text = STUDY.replace("[0.5, 1.8]", "[1.8, 0.5]").replace("[0.0, -0.5]", "[-0.5, 0.0]")
    (folder / "study.toml").write_text(text)
    run(folder, "--jobs", "2")
    by_digest = {row["digest"]: row | {"run": ""} for row in results(folder)}
    assert by_digest == {row["digest"]: row | {"run": ""} for row in rows}
    assert everything(folder)[1] == logs
    anew(folder)
    (folder / "study.toml").write_text(STUDY)
    _, address = scheduler
    daemon("worker", address, "--nthreads", "1", "--no-dashboard", path=package)
    run(folder, "--scheduler", address)
    assert everything(folder) == alone


@pytest.mark.slow
def test_a_log_that_is_kept_is_that_of_the_command_line(folder, command) -> None:
    """The same command again runs nothing."""
    (folder / "study.toml").write_text(
        'home = "home.blend"\nseeds = [0]\nkeep = "events"\n[vary]\n"PIR hall.enabled" = [true]\n'
    )
    driver = start(folder, "--jobs", "1")
    workers = set()
    while driver.poll() is None:
        with contextlib.suppress(psutil.Error):
            for child in psutil.Process(driver.pid).children(recursive=True):
                workers |= {child.pid} if "spawn_main" in " ".join(child.cmdline()) else set()
        time.sleep(0.3)
    assert driver.returncode == 0, driver.communicate()[1]
    # No worker crashed and was silently restarted.
    assert len(workers) == 1
    (log,) = (folder / "out" / "logs").iterdir()
    assert log.read_bytes().decode() == command("simulate", "--quiet")[1]
    assert "1 of 1 run is already done" in run(folder, "--jobs", "1")


@pytest.mark.slow
def test_runs_that_fail_are_rows_and_what_is_there_is_not_run_again(folder) -> None:
    text = STUDY.replace("[0.5, 1.8]", "[0.01, 1.8]")
    (folder / "study.toml").write_text(text)
    (folder / "score.py").write_text(
        "def score(recording, truth):\n"
        "    if len(recording.events) > 4:\n"
        "        raise RuntimeError('too many')\n"
        "    return 1.0\n"
    )
    told = run(folder, "--jobs", "1", status=1)
    rows = results(folder)
    errors = {row["error"] for row in rows}
    # A range that ends before it begins; a function of the user's that raises.
    assert any("range_m" in error for error in errors), errors
    assert "score.py:score: raised RuntimeError: too many (line 3)" in errors
    failed = sum(bool(row["error"]) for row in rows)
    assert f"{failed} of {RUNS} runs failed" in told
    # More values: only missing runs are made, and failed ones are tried again.
    before = (folder / "out" / "runs.jsonl").read_bytes()
    (folder / "study.toml").write_text(text.replace("0.01, 1.8", "0.01, 1.8, 0.7"))
    told = run(folder, "--jobs", "1", status=1)
    after = (folder / "out" / "runs.jsonl").read_bytes()
    assert after.startswith(before)
    new = after.count(b"\n") - before.count(b"\n")
    assert new == 4 + failed
    assert len(results(folder)) == 12


@pytest.mark.slow
def test_a_measure_that_fails_leaves_the_other_measures_of_its_row(folder) -> None:
    (folder / "study.toml").write_text(
        'home = "home.blend"\nmeasure = ["light_error", "score.py:broken", "events", '
        '"score.py:score"]\n'
    )
    (folder / "score.py").write_text(
        SCORE.replace("PAUSE", "0.0") + "def broken(recording, truth):\n    return 1 / 0\n"
    )
    assert "no sensor matches 'Pri*'" in run(folder, "--jobs", "1", "--sensor", "Pri*", status=2)
    told = run(folder, "--jobs", "1", "--no-light", status=1)
    assert "1 of 1 run failed" in told
    (row,) = results(folder)
    assert row["sensors_on"] == "1"
    assert int(row["events"]) == int(row["events PIR hall"]) > 0 and float(row["moves"]) > 0
    assert row["error"] == (
        "light_error: no light sensor is switched on; "
        "score.py:broken: raised ZeroDivisionError: division by zero (line 7)"
    )


@pytest.mark.parametrize(
    ("body", "error"),
    [
        ('return {"own": 1, "events": 7}', "returns 'events', which is the name of another column"),
        pytest.param(
            'return {"seed": 7}',
            "returns 'seed', which is the name of another column",
            marks=pytest.mark.slow,
        ),
        # A change of it would go unnoticed.
        pytest.param(
            "import neighbour; return 1",
            "No module named 'neighbour'",
            marks=pytest.mark.slow,
        ),
    ],
)
def test_a_function_is_its_own_text_and_fills_its_own_columns(folder, body, error) -> None:
    (folder / "neighbour.py").write_text("")
    (folder / "score.py").write_text(f"def score(recording, truth):\n    {body}\n")
    told = run(
        folder, "--jobs", "1", status=1, cwd=folder, env=os.environ | {"PYTHONPATH": str(ROOT)}
    )
    assert f"{RUNS} of {RUNS} runs failed" in told
    assert all(error in row["error"] and row["events"] for row in results(folder))


@pytest.mark.slow
def test_killed_workers_and_a_killed_driver_lose_nothing(folder) -> None:
    (folder / "score.py").write_text(SCORE.replace("PAUSE", "0.4"))
    run(folder, "--jobs", "1")
    whole = everything(folder)
    anew(folder)
    driver = start(folder, "--jobs", "2")
    wait_until(lambda: lines_at(folder) >= 2, driver)
    workers = [
        child
        for child in psutil.Process(driver.pid).children(recursive=True)
        if child.memory_info().rss > 150e6
    ]
    assert workers
    workers[0].send_signal(signal.SIGKILL)
    reached = lines_at(folder)
    wait_until(lambda: lines_at(folder) > reached, driver)
    # The driver too, with the rows that it was about to write.
    below = psutil.Process(driver.pid).children(recursive=True)
    driver.kill()
    driver.communicate()
    for child in below:
        if child.is_running():
            child.kill()
    kept = lines_at(folder)
    assert kept < RUNS
    with open(folder / "out" / "runs.jsonl", "ab") as file:
        file.write(b'{"digest": "ha')
    told = run(folder, "--jobs", "2")
    assert f"{kept} of {RUNS} runs are already done" in told
    assert everything(folder) == whole


@pytest.mark.slow
def test_ctrl_c_ends_it_with_a_line_and_keeps_what_is_done(folder) -> None:
    (folder / "score.py").write_text(SCORE.replace("PAUSE", "0.6"))
    driver = start(folder, "--jobs", "2", start_new_session=True)
    wait_until(lambda: lines_at(folder) >= 2, driver)
    # As a terminal sends it: to the workers too.
    os.killpg(driver.pid, signal.SIGINT)
    told = driver.communicate(timeout=120)[1]
    assert driver.returncode == 1 and "Traceback" not in told, told
    kept = lines_at(folder)
    assert f"interrupted: {kept} of {RUNS} runs are done and kept" in told
    assert 2 <= kept < RUNS and len(results(folder)) == kept


@pytest.mark.slow
def test_what_is_done_stays_where_the_scheduler_is_lost(folder, daemon, scheduler, package) -> None:
    (folder / "score.py").write_text(SCORE.replace("PAUSE", "0.6"))
    process, address = scheduler
    daemon("worker", address, "--nthreads", "1", "--no-dashboard", path=package)
    driver = start(folder, "--scheduler", address)
    wait_until(lambda: lines_at(folder) >= 2, driver)
    process.kill()
    told = driver.communicate(timeout=120)[1]
    assert driver.returncode == 1, told
    kept = lines_at(folder)
    assert 2 <= kept < RUNS and len(results(folder)) == kept
    assert f"{kept} of {RUNS} runs are done: the connection to the scheduler is lost;" in told
    assert "Traceback" not in told, told
    assert f"{kept} of {RUNS} runs are already done" in run(folder, "--jobs", "1")
    assert len(results(folder)) == RUNS


@pytest.mark.slow
def test_workers_that_are_not_alike_are_refused(folder, daemon, scheduler, package) -> None:
    _, address = scheduler
    other = folder / "other"
    for part in ("angen_addon", "sensor_logic", "operators", "panels", "studies"):
        shutil.copytree(ROOT / part, other / "angen_sensors" / part)
    shutil.copy(ROOT / "__init__.py", other / "angen_sensors")
    manifest = (ROOT / "blender_manifest.toml").read_text(encoding="utf-8")
    changed = manifest.replace('\nversion = "', '\nversion = "9.')
    (other / "angen_sensors" / "blender_manifest.toml").write_text(changed, encoding="utf-8")
    options = ("--nthreads", "1", "--no-dashboard")
    daemon("worker", address, *options, path=package)
    daemon("worker", address, *options, path=other)
    import distributed

    with distributed.Client(address) as client:
        client.wait_for_workers(2, timeout=60)
    told = run(folder, "--scheduler", address, status=2)
    assert (
        "have different versions: angen_sensors" in told
        and " 9." in told
        and told.count("tcp://") == 2
    )
    assert told.count("\n") == 1


def test_a_worker_of_another_python_is_one_clear_line(addon_part) -> None:
    """Functions sent to it would crash it, again and again."""

    class Client:
        def nthreads(self) -> dict[str, int]:
            return {"tcp://one:1": 1}

        def get_versions(self) -> dict[str, Any]:
            ours = {"host": {"python": platform.python_version() + ".final.0"}}
            return {
                "scheduler": ours,
                "workers": {"tcp://one:1": {"host": {"python": "3.2.1.final.0"}}},
            }

    with pytest.raises(addon_part("sensor_logic.logs.error").InputError) as told:
        addon_part("studies.engine").check_workers(Client())
    assert str(told.value).startswith(
        "the worker tcp://one:1 has Python 3.2.1, and this program has Python"
    )


@pytest.mark.slow
@pytest.mark.parametrize("where", ["here", "elsewhere"])
def test_a_worker_without_blenders_module_is_one_clear_line(
    folder, daemon, scheduler, package, tmp_path, where
) -> None:
    """Another `bpy`, found first, raises the error that Python would raise."""
    (package / "bpy.py").write_text("raise ModuleNotFoundError(\"No module named 'bpy'\")\n")
    if where == "here":
        env = os.environ | {"PYTHONPATH": str(package)}
        told = run(folder, "--jobs", "1", status=2, env=env)
    else:
        address = scheduler[1]
        daemon("worker", address, "--nthreads", "1", "--no-dashboard", path=package)
        told = run(folder, "--scheduler", address, status=2)
    (line,) = set(told.splitlines()) - {"angen: waiting for workers; Ctrl-C ends this"}
    assert "lacks Blender's Python module" in line and line.count("pip install") == 1
    assert line.endswith("install it there with pip install bpy")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        pytest.param(
            ("--scheduler", "tcp://127.0.0.1:9"),
            ["no scheduler answers at tcp://127.0.0.1:9"],
            marks=pytest.mark.slow,
        ),
        (("--scheduler", "nonsense"), ["no scheduler answers at nonsense"]),
        (("--jobs", "0"), ["'0' is not a whole number from 1"]),
    ],
)
def test_no_cluster_is_one_clear_line(folder, options, words) -> None:
    told = run(folder, *options, status=2)
    assert all(word in told for word in words) and told.count("\n") == 1, told


def test_what_no_sensor_has_is_told_before_anything_runs(folder) -> None:
    (folder / "study.toml").write_text(STUDY.replace("hall.range_max", "hall.reach"))
    told = run(folder, "--jobs", "1", status=2)
    assert "study.toml, line 7: 'PIR hall' has no parameter 'reach'" in told
    assert told.count("\n") == 1 and lines_at(folder) == 0


@pytest.mark.slow
def test_a_full_disk_is_one_clear_line_and_keeps_what_is_done(folder) -> None:
    resource = pytest.importorskip("resource", reason="has no limits of this kind")

    def little_room() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (1300, 1300))

    (folder / "study.toml").write_text(STUDY.replace('keep = ["events"]\n', ""))
    told = run(folder, "--jobs", "1", status=1, preexec_fn=little_room)
    assert "runs are done: cannot write in" in told, told
    kept = lines_at(folder)
    assert 0 < kept < RUNS
    assert f"{kept} of {RUNS} runs are already done" in run(folder, "--jobs", "1")
    assert len(results(folder)) == RUNS


def test_a_worker_that_does_not_see_the_drivers_files_gets_them(tmp_path, addon_part) -> None:
    tasks = addon_part("studies.tasks")
    home = tasks.File(str(tmp_path / "home.blend"), tasks.digest_of_bytes(b"BLENDER"))
    (tmp_path / "home.blend").write_bytes(b"another home of that name")
    with pytest.raises(Exception, match=r"file .*home\.blend is missing or is not the same"):
        tasks.local_path(home)
    plugin = tasks.FilesOfStudy("files", {home: b"BLENDER"})
    pickle.loads(pickle.dumps(plugin)).setup(None)
    assert tasks.local_path(home).read_bytes() == b"BLENDER"


@pytest.mark.slow
def test_coverage_and_the_error_of_light_are_measured(folder) -> None:
    home = ROOT / "sample_blends" / "light_control.blend"
    (folder / "study.toml").write_text(
        f'home = "{home.as_posix()}"\nframes = [1, 48]\nmeasure = ["coverage", "light_error"]\n'
        'draw = "list"\n[vary]\n"Light*.samples" = [4, 256]\n"PIR*.range_max" = [2.0, 7.0]\n'
    )
    run(folder, "--jobs", "1")
    few, many = results(folder)
    assert float(few["light_error"]) > 2 * float(many["light_error"]) > 0
    assert 0 < float(few["coverage"]) < float(many["coverage"]) <= 1
