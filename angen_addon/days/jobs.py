# SPDX-License-Identifier: GPL-3.0-or-later
"""Processes that make days of the same command, each its share of them, or of the sensors."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

import bpy

from ...sensor_logic.kind import FORCES, LIGHT, RAYS
from ..scene.sensors import Sensor

# s
LOOK_EVERY = 0.2
# How long a day of a sensor that needs this takes, beside one that needs none of it.
WORK = {LIGHT: 100, FORCES: 15, RAYS: 3}
# Runs the command line of this very package in another Python.
_START = (
    "import runpy, sys; sys.path.insert(0, sys.argv.pop(1)); "
    "runpy.run_module('angen_addon', run_name='__main__', alter_sys=True)"
)


def share_of(sensors: Sequence[Sensor], part: int, parts: int) -> list[Sensor]:
    """The sensors of one of several processes, which are to take as long as each other."""
    each = [max((WORK.get(need, 1) for need in s.kind.needs), default=1) for s in sensors]
    work, of = [0] * parts, [0] * len(each)
    for i in sorted(range(len(each)), key=lambda i: -each[i]):
        of[i] = work.index(min(work))
        work[of[i]] += each[i]
    return [sensor for sensor, one in zip(sensors, of, strict=True) if one == part]


def command_of(part: int, parts: int, of: str) -> list[str]:
    """This process's own command, for a share `of` its days or of its sensors."""
    share = [f"--{of}", f"{part}/{parts}", "--quiet"]
    if bpy.app.binary_path:
        # Threads that wait for each other at each frame cost more than they give.
        return [bpy.app.binary_path, "--threads", "1", *sys.argv[1:], *share]
    root = Path(__file__).resolve().parents[2]
    return [sys.executable, "-c", _START, str(root), *sys.argv[1:], *share]


class Workers:
    """As a context: all processes but this one, each with a share `of` the days or the sensors,
    ended with it. `good`: whether those that are over did what they should."""

    def __init__(self, parts: int, of: str) -> None:
        self._parts, self._of = parts, of
        self._running: list[subprocess.Popen[bytes]] = []
        self.good = True

    def __enter__(self) -> Workers:
        for part in range(1, self._parts):
            command = command_of(part, self._parts, self._of)
            self._running.append(
                subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
            )
        return self

    def __exit__(self, *_: object) -> None:
        for process in self._running:
            process.terminate()
        for process in self._running:
            process.wait()

    def wait(self) -> Iterator[None]:
        """Until all are over, with a look now and then."""
        while self._running:
            for process in list(self._running):
                if process.poll() is not None:
                    self.good &= process.returncode == 0
                    self._running.remove(process)
            yield
            time.sleep(LOOK_EVERY if self._running else 0.0)
