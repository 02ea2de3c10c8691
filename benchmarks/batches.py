# SPDX-License-Identifier: GPL-3.0-or-later
"""What a run costs beside Blender's bare evaluation of its frames, in the home, in turns:

    python -m benchmarks.batches [--beside CHECKOUT]… [--rounds N] [--frames N]

Each round runs every program in a process of its own; both times of a ratio are of one process.
With OPENBLAS_NUM_THREADS=1 numpy's threads do not wait for each other on few cores.
"""

from __future__ import annotations

import argparse
import importlib
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent.parent
ADDON = "bl_ext.user_default.angen_sensors"
# Kinds that are on, and whether the detectors are pyroelectric, which needs every frame.
CASES = {
    "7 PIRs and 7 switches": (("PIR", "OPTICAL_SWITCH"), False),
    "and a pad": (("PIR", "OPTICAL_SWITCH", "PRESSURE"), False),
    "7 pyroelectric PIRs, 24 Hz": (("PIR",), True),
}


def _part(*names: str) -> Any:
    """The first of these modules that the program has: older ones have other places."""
    for name in names:
        try:
            return importlib.import_module(f"{ADDON}.{name}")
        except ModuleNotFoundError:
            continue
    raise SystemExit(f"none of {', '.join(names)} is there")


def work(case: str, frames: int) -> dict[str, float]:
    """Seconds of a run and of its frames alone, in the program that is linked as an extension."""
    # Blender's own modules are found once it is there.
    import bpy  # isort: skip
    import addon_utils

    addon_utils.enable(ADDON, default_set=True)
    bpy.ops.wm.open_mainfile(filepath=str(HERE / "sample_blends/angen.blend"), load_ui=False)
    scene, (kinds, pyroelectric) = bpy.context.scene, CASES[case]
    for obj in bpy.data.objects:
        settings = obj.angen_sensor
        settings.enabled = settings.kind in kinds
        if pyroelectric and settings.kind == "PIR":
            settings.pir.model, settings.update_rate = "PYROELECTRIC", 24.0
    # Without warmth nothing is felt.
    warmth = bpy.data.objects["Person"].angen_warmth
    warmth.use_temperature, warmth.temperature = True, 33.0
    simulate = _part("angen_addon.runtime.simulation", "angen_addon.simulation").simulate
    tracks = _part("sensor_logic.recording.tracks", "sensor_logic.recording")
    recording = tracks.Recording()
    last = min(scene.frame_end, scene.frame_start + frames - 1)
    sensors = _part("angen_addon.scene.sensors", "angen_addon.sensors")
    every = sensors.all_sensors(bpy.context.view_layer)
    begin = time.perf_counter()
    for _ in simulate(scene, every, scene.frame_start, last, recording):
        pass
    run = time.perf_counter() - begin
    rate = 24.0 if pyroelectric else 10.0
    per_update = scene.render.fps / rate
    steps = range(int((last - scene.frame_start) / per_update) + 1)
    bpy.app.handlers.frame_change_post.clear()
    begin = time.perf_counter()
    for k in steps:
        scene.frame_set(scene.frame_start + math.ceil(k * per_update - 1e-9))
    bare = time.perf_counter() - begin
    seconds = (last - scene.frame_start + 1) / scene.render.fps
    return {"run": run, "bare": bare, "ratio": run / bare, "real_time": seconds / run}


def _elsewhere(program: Path, case: str, frames: int) -> dict[str, float]:
    """The same in a process of its own."""
    with tempfile.TemporaryDirectory() as folder:
        extensions = Path(folder) / "extensions/user_default"
        extensions.mkdir(parents=True)
        (extensions / "angen_sensors").symlink_to(program)
        command = [sys.executable, __file__, "--case", case, "--frames", str(frames)]
        found = subprocess.run(
            command,
            env={**os.environ, "BLENDER_USER_RESOURCES": folder},
            capture_output=True,
            text=True,
        )
    if found.returncode:
        raise SystemExit(f"{program}: {found.stderr.strip()[-2000:]}")
    result: dict[str, float] = json.loads(found.stdout.strip().splitlines()[-1])
    return result


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--beside", type=Path, action="append", default=[], metavar="CHECKOUT")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--frames", type=int, default=10**9, help="of the story, at most")
    parser.add_argument("--case", choices=CASES, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.case:
        print(json.dumps(work(options.case, options.frames)), flush=True)
        # Blender's module is slow to go.
        os._exit(0)
    programs = [HERE, *(path.resolve() for path in options.beside)]
    for case in CASES:
        found: dict[Path, list[dict[str, float]]] = {program: [] for program in programs}
        for _ in range(options.rounds):
            for program in programs:
                found[program].append(_elsewhere(program, case, options.frames))
        for program, runs in found.items():
            ratio, speed = (statistics.median(r[of] for r in runs) for of in ("ratio", "real_time"))
            name = "this" if program == HERE else program.name
            print(f"{case:28} {name:12} {ratio:6.2f} × bare frames, {speed:6.1f} × real time")


if __name__ == "__main__":
    main()
