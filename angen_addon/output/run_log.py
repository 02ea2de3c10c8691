# SPDX-License-Identifier: GPL-3.0-or-later
"""The log of a run, from which formats of other tools are written.

In addition to the events, it has the rooms of the sensors, the seed, and versions.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from datetime import datetime
from pathlib import Path
from typing import Any

import bpy

from ...sensor_logic.logs.formats.log import DEFAULT_START, Log, SensorFacts
from ...sensor_logic.logs.formats.source import make_log
from ...sensor_logic.recording.events import events, samples_of
from ...sensor_logic.recording.tracks import Recording
from ..layout.describe import parameters_of
from ..process.version import extension_version
from ..scene.sensors import Sensor


def log_of_run(
    recording: Recording, scene: Any, sensors: Iterable[Sensor], start: datetime | None = None
) -> Log:
    """Return the log of a recording that was made of the open file.

    `sensors` are the recorded sensors. `start` is the date and time of t = 0.
    """
    facts = {s.name: sensor_facts(s) for s in sensors}
    begin, texts, samples = start or DEFAULT_START, about(scene), samples_of(recording)
    return make_log(events(recording), facts, begin, about=texts, samples=samples)


def sensor_facts(sensor: Sensor) -> SensorFacts:
    """Return the name, kind, room and parameters of a sensor, for a log."""
    return SensorFacts(sensor.name, sensor.kind.identifier, sensor.room, parameters_of(sensor))


def about(scene: Any) -> dict[str, str]:
    """Return the data on a run that its log contains, as texts by name.

    These are the name and the digest of the home's file, the seed, and the versions of the
    extension and of Blender.
    """
    found = {"seed": str(scene.angen_seed)}
    path = Path(bpy.data.filepath)
    if bpy.data.filepath and path.is_file():
        found["home"] = path.name
        found["digest"] = f"sha256:{hashlib.sha256(path.read_bytes()).hexdigest()}"
    found["versions.angen_sensors"] = extension_version()
    found["versions.blender"] = bpy.app.version_string
    return found
