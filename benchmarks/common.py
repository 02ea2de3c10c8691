# SPDX-License-Identifier: GPL-3.0-or-later
"""Helpers of all benchmarks.

They name the machine, repeat runs, open the sample home, make small scenes, and call a function in
its own process.
"""

from __future__ import annotations

import importlib.util
import json
import os
import platform
import statistics
import subprocess
import sys
import time
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial, wraps
from inspect import isgeneratorfunction
from pathlib import Path
from typing import Any

import bpy
import numpy as np

ROOT = Path(__file__).resolve().parent.parent
SAMPLES = ROOT / "sample_blends"
HOME = SAMPLES / "angen.blend"
CPU_INFO = Path("/proc/cpuinfo")
MIB = 2**20
# The faces of a box whose corners are ordered by x, y and z.
FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def machine() -> str:
    """Return the processor, the cores of this process, and the versions of Blender and numpy."""
    name = platform.processor() or platform.machine()
    if CPU_INFO.exists():
        lines = CPU_INFO.read_text(encoding="utf-8").splitlines()
        names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
        name = names[0] if names else name
    can_tell = hasattr(os, "sched_getaffinity")
    cores = len(os.sched_getaffinity(0)) if can_tell else os.cpu_count() or 1
    return (
        f"{name}, {cores} cores, {platform.system()}, Blender {bpy.app.version_string}, "
        f"Python {platform.python_version()}, numpy {np.__version__}"
    )


def progress(part: str, done: int, total: int, now: str) -> None:
    """Print on standard error how far a long part is."""
    print(f"  {part}: {done} of {total} done, now {now}", file=sys.stderr, flush=True)


def spread(values: Sequence[float]) -> dict[str, float]:
    """Return median, least and greatest of repeated runs."""
    middle = statistics.median(values)
    return {"median": middle, "low": min(values), "high": max(values), "runs": len(values)}


def rms(values: Any) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def has(module: str) -> bool:
    """Return whether a Python module is installed; True for ""."""
    return not module or importlib.util.find_spec(module) is not None


def apart(function: str, *arguments: Any) -> Any:
    """Call a function of the benchmarks ("module.name") in its own process; return its result.

    Arguments and result are JSON values. The extension is registered in the process.
    """
    command = [sys.executable, "-m", "benchmarks", "--apart", function, json.dumps(arguments)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"{function}{arguments} failed:\n{done.stderr.strip()[-2000:]}")
    return json.loads(done.stdout.splitlines()[-1])


def memory_mib(most: bool = False) -> float:
    """Return the MiB of memory of this process, or their peak; 0 where the system has no figure."""
    status = Path("/proc/self/status")
    if not status.exists():
        return 0.0
    name = "VmHWM:" if most else "VmRSS:"
    line = next(
        line for line in status.read_text(encoding="utf-8").splitlines() if line.startswith(name)
    )
    return int(line.split()[1]) / 1024


def open_home(path: Path = HOME) -> Any:
    """Return the scene of the Ängen home as saved, with live readings off."""
    bpy.ops.wm.open_mainfile(filepath=str(path), load_ui=False)
    scene = bpy.context.scene
    scene.angen_live = False
    return scene


def new_scene(fps: int, last: int) -> Any:
    """Return an empty scene of frames 1 … `last`, with live readings off."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end, scene.render.fps = 1, last, fps
    scene.angen_live = False
    return scene


def link(name: str, data: Any, at: Sequence[float] = (0, 0, 0), parent: Any = None) -> Any:
    """Add an object to the scene, and return it."""
    obj = bpy.data.objects.new(name, data)
    obj.location, obj.parent = at, parent
    bpy.context.scene.collection.objects.link(obj)
    return obj


def box_mesh(parts: Sequence[tuple[Sequence[float], Sequence[float]]]) -> Any:
    """Return a mesh of boxes, each given as (half size, centre)."""
    points: list[Any] = []
    faces: list[Any] = []
    signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    for half, middle in parts:
        faces += [tuple(len(points) + corner for corner in face) for face in FACES]
        points += (np.array(middle) + signs * np.array(half)).tolist()
    mesh = bpy.data.meshes.new("boxes")
    mesh.from_pydata(points, [], faces)
    return mesh


def sensors_of(*kinds: str) -> list[Any]:
    """Return the scene's sensors of these kinds, or all sensors if no kind is given."""
    from angen_sensors.angen_addon.scene.sensors import all_sensors

    every = all_sensors(bpy.context.view_layer)
    return [sensor for sensor in every if not kinds or sensor.kind.identifier in kinds]


def enable_only(kinds: Sequence[str]) -> None:
    for sensor in sensors_of():
        sensor.settings.enabled = sensor.kind.identifier in kinds


def run(scene: Any, sensors: list[Any], first: int, last: int) -> tuple[float, Any]:
    """Simulate a range of frames; return the seconds that it took, and the recording."""
    from angen_sensors.angen_addon.runtime.simulation import simulate
    from angen_sensors.sensor_logic.recording.tracks import Recording

    recording = Recording()
    begin = time.perf_counter()
    for _ in simulate(scene, sensors, first, last, recording):
        pass
    return time.perf_counter() - begin, recording


def bare_frames(scene: Any, frames: Sequence[int]) -> float:
    """Return the seconds in which Blender evaluates these frames without any handlers."""
    handlers = bpy.app.handlers.frame_change_post, bpy.app.handlers.depsgraph_update_post
    before = [list(functions) for functions in handlers]
    for functions in handlers:
        functions.clear()
    try:
        begin = time.perf_counter()
        for frame in frames:
            scene.frame_set(frame)
        return time.perf_counter() - begin
    finally:
        for functions, known in zip(handlers, before, strict=True):
            functions.extend(known)


EVALUATION = "evaluation of the scene"


def _timed_functions() -> tuple[tuple[Any, str, str], ...]:
    """Return the functions that `Stopwatch` times: owner, name, and part of the run."""
    from angen_sensors.angen_addon.runtime.edits import Edits
    from angen_sensors.angen_addon.runtime.probes import Probes
    from angen_sensors.angen_addon.runtime.sensor_runner import PendingUpdates
    from angen_sensors.angen_addon.scene.capture import Capture
    from angen_sensors.angen_addon.scene.forces.tracker import ContactTracker
    from angen_sensors.angen_addon.scene.rays.caster import RayCaster
    from angen_sensors.angen_addon.scene.rays.reference import SceneRayCaster
    from angen_sensors.angen_addon.scene.sensor_reader import SensorReader
    from angen_sensors.sensor_logic.recording.tracks import Track

    return (
        (Edits, "note", "what moved"),
        (Capture, "add", "what moved"),
        (Capture, "add_first", "what moved"),
        (Capture, "finish", "what moved"),
        (RayCaster, "cast_at", "rays"),
        (SceneRayCaster, "cast_at", "rays"),
        (ContactTracker, "look", "contact forces"),
        (Probes, "forces", "contact forces"),
        (Probes, "measure", "light"),
        (SensorReader, "read", "sensor models"),
        (PendingUpdates, "readings", "sensor models"),
        (Track, "extend", "recording"),
    )


class Stopwatch:
    """Seconds by part of a run, without those of nested parts.

    The remaining time is Blender's evaluation of the frames, and the loop itself.
    """

    def __init__(self) -> None:
        self.seconds: dict[str, float] = defaultdict(float)
        self._inner: list[float] = []

    @contextmanager
    def running(self) -> Iterator[None]:
        wrapped = _timed_functions()
        self.seconds.update(dict.fromkeys((EVALUATION, *(part for *_, part in wrapped)), 0.0))
        before = [(owner, name, getattr(owner, name)) for owner, name, _ in wrapped]
        begin = time.perf_counter()
        for (owner, name, old), (*_, part) in zip(before, wrapped, strict=True):
            setattr(owner, name, self._measured(old, part))
        try:
            yield
        finally:
            for owner, name, old in before:
                setattr(owner, name, old)
        total = time.perf_counter() - begin
        self.seconds[EVALUATION] += total - sum(self.seconds.values())

    def _measured(self, work: Any, part: str) -> Any:
        @wraps(work)
        def measured(*arguments: Any, **named: Any) -> Any:
            return self._timed(part, partial(work, *arguments, **named))

        @wraps(work)
        def measured_steps(*arguments: Any, **named: Any) -> Iterator[Any]:
            steps = work(*arguments, **named)
            # The time between two steps of a generator is not the generator's.
            while True:
                try:
                    step = self._timed(part, partial(next, steps))
                except StopIteration as end:
                    return end.value
                yield step

        return measured_steps if isgeneratorfunction(work) else measured

    def _timed(self, part: str, work: Callable[[], Any]) -> Any:
        """Return the result of `work`; add its seconds, without nested parts, to `part`."""
        self._inner.append(0.0)
        start = time.perf_counter()
        try:
            return work()
        finally:
            seconds = time.perf_counter() - start
            self.seconds[part] += seconds - self._inner.pop()
            if self._inner:
                self._inner[-1] += seconds
