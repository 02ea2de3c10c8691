# SPDX-License-Identifier: GPL-3.0-or-later
"""`angen day --samples`: every update of a day, with the frames of arrays, read back."""

from __future__ import annotations

import csv
import gzip
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest
from lived_home import content, rows, words_of

DAY_S = 86_400


@pytest.fixture
def home(lived_home: Path, world: Any) -> Path:
    """Save the home of two rooms with an array above the bed."""
    array = world.sensor("THERMAL_ARRAY", "Bed: array", update_rate=0.5, rays=10, hold_time=0.0)
    array.location = (4.9, 3.5, 2.4)
    bpy.ops.wm.save_as_mainfile(filepath=str(lived_home))
    return lived_home


def table(path: Path) -> dict[str, Any]:
    """Return the columns of a file of samples; frames as an array (updates, rows, columns)."""
    with gzip.open(path, "rt", encoding="utf-8", newline="") as file:
        header, *lines = csv.reader(file)
    found: dict[str, Any] = dict(zip(header, zip(*lines, strict=True), strict=True))
    frames = [np.array(text.split(";"), float).reshape(8, 8) for text in found["frame_c"]]
    return found | {"frame_c": np.array(frames), "time": np.array(found["time"], "datetime64[ms]")}


@pytest.mark.slow
def test_the_frames_of_a_day_are_kept_and_a_bed_stays_warm_for_minutes(
    home: Path, angen_day: Callable[..., tuple[int, str]]
) -> None:
    status, told = angen_day("--samples", "--sensor", "Bed*", days=1)
    assert status == 0, told
    out = home.parent / "out"
    (path,) = (out / "samples").rglob("*.*")
    assert path.relative_to(out) == Path("samples/Bed_ array/2026-03-02.csv.gz")
    read = table(path)
    seconds = (read["time"] - np.datetime64("2026-03-02")) / np.timedelta64(1, "s")
    assert np.array_equal(seconds, np.arange(0, DAY_S, 2))
    occupied = np.array(read["occupied"]) == "1"
    excess = read["frame_c"].max(axis=(1, 2)) - 20.0
    asleep = seconds < 8 * 3600
    assert occupied[asleep].all() and excess[asleep].min() > 3.0
    # She gets up; the bed is warm for minutes, and cold at noon.
    up = next(r["start"] for r in rows(out / "activities.csv") if r["activity"] == "Sit")
    after = seconds - (np.datetime64(up) - np.datetime64("2026-03-02")) / np.timedelta64(1, "s")
    gone = (after > 30.0) & (after < 5 * 3600.0)
    held = after[gone & occupied].max()
    print(held, excess[(after > 60.0) & (after < 90.0)].min(), excess[gone][-1])
    assert 120.0 < held < 3600.0
    assert excess[(after > 60.0) & (after < 90.0)].min() > excess[(after > 600.0) & gone].max()


@pytest.mark.slow
def test_pandas_reads_a_file_of_samples(
    home: Path, angen_day: Callable[..., tuple[int, str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also: processes write the same bytes, and days without samples are simulated again."""
    pandas = pytest.importorskip("pandas")
    chosen = ("--sensor", "Contact", "--sensor", "Bed*")
    assert angen_day(*chosen)[0] == 0
    bare = content(home.parent / "out")
    assert angen_day("--samples", *chosen)[0] == 0
    kept = content(home.parent / "out")
    assert {n: kept[n] for n in bare} == bare and len(kept) == len(bare) + 4
    more = ("--samples", *chosen, "--jobs", 2)
    words = words_of(home, *more, out="both")
    monkeypatch.setattr(sys, "argv", ["angen", "day", str(home), *words])
    assert angen_day(*more, out="both")[0] == 0
    assert content(home.parent / "both") == kept
    found = pandas.read_csv(
        home.parent / "both" / "samples" / "Contact" / "2026-03-03.csv.gz", parse_dates=["time"]
    )
    assert len(found) == DAY_S / 2 and found["time"].dt.date.nunique() == 1
    assert set(found["open"]) == {0, 1}


@pytest.mark.slow
def test_names_that_make_one_file_name_and_a_sensor_slower_than_days(
    lived_home: Path, world: Any, angen_day: Callable[..., tuple[int, str]]
) -> None:
    rates = {"a/b": 0.01, "a_b": 0.01, "A:b": 0.01, "..": 0.01, "rare": 1e-7}
    for name, rate in rates.items():
        array = world.sensor("THERMAL_ARRAY", name, update_rate=rate, rays=3)
        array.location = (4.9, 3.5, 2.4)
    bpy.ops.wm.save_as_mainfile(filepath=str(lived_home))
    chosen = [word for name in rates for word in ("--sensor", name)]
    for _ in range(2):
        status, told = angen_day("--samples", *chosen, days=1)
        assert status == 0, told
    assert "simulated" not in told, "the day is complete"
    folders = {path.name: path for path in (lived_home.parent / "out" / "samples").iterdir()}
    assert sorted(folders) == ["A_b-2", "_", "a_b", "a_b-3", "rare"]
    counts = {}
    for name, path in folders.items():
        with gzip.open(next(path.iterdir()), "rt", encoding="utf-8") as file:
            counts[name] = len(file.readlines()) - 1
    assert counts.pop("rare") == 0 and set(counts.values()) == {864}
