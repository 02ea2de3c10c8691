# SPDX-License-Identifier: GPL-3.0-or-later
"""How cost and memory grow: with the objects, triangles, sensors and frames of a scene, and with
the length of a recording. Each case runs in a process of its own, so that its memory is its own.

`python -m benchmarks.growth '{"objects": 100}'` measures one case and prints it.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from .common import spread
from .progress import progress

ROOT = Path(__file__).resolve().parent.parent
STATUS = Path("/proc/self/status")
BASE = {"objects": 300, "triangles": 12_000, "sensors": 7, "frames": 96}
SWEEPS: dict[str, tuple[int, ...]] = {
    "objects": (10, 30, 100, 300, 1000, 3000),
    "triangles": (10_000, 100_000, 500_000, 2_000_000),
    "sensors": (1, 10, 50, 100, 500),
    "frames": (100, 1000, 5000, 20_000),
}
GLANCE: dict[str, tuple[int, ...]] = {
    "objects": (10, 100, 1000),
    "triangles": (10_000, 100_000),
    "sensors": (1, 50),
    "frames": (100, 1000),
}
DAY = 86_400
RATES = {"PIR": (7, 10.0), "OPTICAL_SWITCH": (7, 1.0), "LIGHT": (7, 1.0), "PRESSURE": (1, 1.0)}


def measure(quick: bool) -> dict[str, Any]:
    rounds = 1 if quick else 3
    sweeps = GLANCE if quick else SWEEPS
    # Round by round, so that a busy moment of the machine meets all cases.
    found: dict[tuple[str, int], list[dict[str, float]]] = {}
    for turn in range(rounds):
        for name, sizes in sweeps.items():
            for size in sizes:
                progress("growth", turn, rounds, f"{size} {name}")
                found.setdefault((name, size), []).append(_case({**BASE, name: size}))
    return {
        "base": BASE,
        "sweeps": {
            name: [{"size": size, **_together(found[name, size])} for size in sizes]
            for name, sizes in sweeps.items()
        },
        "recording": _case({"recording": DAY // 24 if quick else DAY}),
    }


def _together(runs: list[dict[str, float]]) -> dict[str, Any]:
    return {key: spread([run[key] for run in runs]) for key in runs[0]}


def _case(case: dict[str, int]) -> dict[str, Any]:
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks.growth", json.dumps(case)],
        cwd=ROOT,
        capture_output=True,
        text=True,
    )
    if done.returncode:
        raise RuntimeError(f"growth of {case} failed:\n{done.stderr[-2000:]}")
    return dict(json.loads(done.stdout.splitlines()[-1]))


def _memory() -> float:
    """MiB of this process at most so far."""
    if STATUS.exists():
        # Not getrusage: it hands down what the parent had.
        line = next(t for t in STATUS.read_text().splitlines() if t.startswith("VmHWM:"))
        return int(line.split()[1]) / (1 << 10)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (1 << 20)


def _run_scene(objects: int, triangles: int, sensors: int, frames: int) -> dict[str, float]:
    """A hall of still objects with as many triangles in all, one thing that moves to and fro, and
    detectors of the thesis's kind, all 24 fps at 10 Hz."""
    import bpy
    from angen_sensors.angen_addon.runtime.simulation import simulate
    from angen_sensors.angen_addon.scene.sensors import all_sensors
    from angen_sensors.sensor_logic.recording.tracks import Recording

    from .growth_scene import hall

    empty = _memory()
    scene = hall(objects, triangles, sensors, frames)
    built = _memory()
    chosen = all_sensors(bpy.context.view_layer)
    # By the end of a second all tilts have been looked at once: what stands still is known.
    early, second = Recording(), scene.frame_start + scene.render.fps
    begin = time.perf_counter()
    for _ in simulate(scene, chosen, scene.frame_start, second, early):
        pass
    first, steps = time.perf_counter() - begin, len(next(iter(early.tracks.values())))
    recording = Recording()
    begin = time.perf_counter()
    for _ in simulate(scene, chosen, scene.frame_start, scene.frame_end, recording):
        pass
    wall = time.perf_counter() - begin
    looks = len(next(iter(recording.tracks.values())))
    frames_looked = sorted({int(f) for t in recording.tracks.values() for f in t.frames})[steps:]
    begin = time.perf_counter()
    for frame in frames_looked:
        scene.frame_set(frame)
    evaluation = (time.perf_counter() - begin) / len(frames_looked)
    ms = (wall - first) / (looks - steps) * 1e3
    return {
        "start_ms": first * 1e3,
        "ms": ms,
        "sensing_ms": ms - evaluation * 1e3,
        "evaluation_ms": evaluation * 1e3,
        "scene_mib": built - empty,
        "run_mib": _memory() - built,
    }


def _run_recording(seconds: int) -> dict[str, Any]:
    """A recording as long as that, of the home's 22 sensors at the thesis's rates."""
    from angen_sensors.sensor_logic.kinds import KINDS
    from angen_sensors.sensor_logic.model import Reading
    from angen_sensors.sensor_logic.recording.tracks import Recording, Track

    before = _memory()
    recording, rows = Recording(frame_start=1, frame_end=seconds * 24), 0
    begin = time.perf_counter()
    for kind_name, (count, rate) in RATES.items():
        kind = KINDS[kind_name]
        idle, busy = ({f.name: f.type(on) for f in kind.samples} for on in (0, 1))
        for index in range(count):
            track = Track(f"{kind_name} {index}", kind_name)
            recording.tracks[track.sensor] = track
            for number in range(int(seconds * rate)):
                # What stays as it was most of the time, as sensors' readings do.
                active = number // 97 % 5 == 0
                reading = Reading(active, float(active), busy if active else idle)
                track.append(1 + number * 24 / rate, number / rate, reading)
            rows += len(track)
    filled = time.perf_counter() - begin
    found: dict[str, Any] = {
        "seconds": seconds,
        "rows": rows,
        "fill_s": filled,
        "mib": _memory() - before,
    }
    found.update(_written(recording))
    return found


def _written(recording: Any) -> dict[str, Any]:
    from angen_sensors.sensor_logic.log import events_csv
    from angen_sensors.sensor_logic.recording.file import from_bytes, to_bytes

    begin = time.perf_counter()
    text = events_csv(recording)
    logged = time.perf_counter()
    data = to_bytes(recording, {})
    saved = time.perf_counter()
    again, _ = from_bytes(data)
    loaded = time.perf_counter()
    assert events_csv(again) == text, "a recording that was read again says the same"
    return {
        "events_s": logged - begin,
        "events_mib": len(text) / (1 << 20),
        "save_s": saved - logged,
        "load_s": loaded - saved,
        "file_mib": len(data) / (1 << 20),
    }


def _main() -> None:
    from angen_addon.process.standalone import load_extension

    extension = load_extension()
    extension.register()
    try:
        case = json.loads(sys.argv[1])
        done = _run_recording(case["recording"]) if "recording" in case else _run_scene(**case)
    finally:
        extension.unregister()
    print(json.dumps(done))


if __name__ == "__main__":
    _main()
