# SPDX-License-Identifier: GPL-3.0-or-later
"""What a worker of a study does. It runs in a process with one thread, which has Blender's module;
this module itself is read where there is none."""

from __future__ import annotations

import platform
import threading

from ...sensor_logic.error import AngenError
from ...sensor_logic.study.targets import HomeFacts
from .tasks import Done, File, Task, differences, found, versions

__all__ = ["examine", "run", "versions"]

# Blender has one scene: a process that has several threads all the same works in turns.
_one_at_a_time = threading.Lock()


def examine(home: File) -> HomeFacts:
    """What is known of a home without simulating it. Raises AngenError."""
    with _one_at_a_time:
        from . import home_run

        return home_run.facts(found(home), home, versions())


def run(group: list[Task]) -> list[Done]:
    """Simulates runs that differ in their sensors alone: the home is lived once for all of them.
    Raises AngenError; all else that goes wrong is told in what it returns."""
    differ = differences(group[0].versions, versions())
    if differ:
        raise AngenError(f"{platform.node()} is not as the other workers: {differ}")
    with _one_at_a_time:
        from . import home_run

        return home_run.done(group)
