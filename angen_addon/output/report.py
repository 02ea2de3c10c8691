# SPDX-License-Identifier: GPL-3.0-or-later
"""The report on a run, as an HTML page or an SVG picture."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime
from pathlib import Path
from typing import Any

import bpy

from ...sensor_logic.kind import LIGHT
from ...sensor_logic.logs.error import InputError
from ...sensor_logic.parameters import defaults, format_quantity, is_chosen, specs, value_text
from ...sensor_logic.recording.tracks import Recording
from ...sensor_logic.report import page
from ...sensor_logic.report.facts import Report, ReportedSensor
from ...sensor_logic.report.svg import shown_number
from ..advice.lacking import lacking
from ..plan.storeys import storeys
from ..process.version import extension_version
from ..scene.animation import is_animated
from ..scene.sensors import Sensor, decimal, read_parameters, simulated

PAGES, DRAWINGS = {".html", ".htm"}, {".svg"}


def check_name(path: Path, what: str) -> None:
    """Raise InputError unless the file's name ends in .html, .htm or .svg.

    `what` names the output in the error, such as an option.
    """
    if path.suffix.lower() not in PAGES | DRAWINGS:
        raise InputError(
            f"{what}: {path.name} must end in .html (the whole report) or .svg "
            "(timeline and plan as a picture)"
        )


def report_text(
    path: Path,
    scene: Any,
    sensors: Sequence[Sensor],
    recording: Recording,
    start: datetime | None = None,
) -> str:
    """Return the text of the report on a run, as HTML or SVG by the ending of `path`.

    Parameters
    ----------
    path
        The file that the report will be written to.
    scene
        The scene of the run.
    sensors
        The sensors that the report lists.
    recording
        The readings of the run.
    start
        The date and time of t = 0; None if the run has none.

    Raises
    ------
    AngenError
        If the report cannot be made.
    """
    check_name(path, "report")
    report = gather(scene, sensors, recording, start)
    return page.html(report) if path.suffix.lower() in PAGES else page.svg(report)


def gather(
    scene: Any, sensors: Sequence[Sensor], recording: Recording, start: datetime | None = None
) -> Report:
    """Return the content of the report on a run.

    The report also lists the sensors in `sensors` that the run did not simulate, and marks them.
    `start` is the date and time of t = 0.
    """
    return Report(
        scene.name,
        tuple(_facts(scene, sensors, recording, start)),
        tuple(_sensor_facts(sensor) for sensor in sensors),
        recording,
        storeys(scene, sensors, recording.frame_start),
        recording.frame_start,
        _made_by(),
    )


def _facts(
    scene: Any, sensors: Sequence[Sensor], recording: Recording, start: datetime | None
) -> list[tuple[str, str]]:
    clock = recording.clock
    assert clock is not None
    rate = decimal(clock.fps / clock.fps_base)
    found = [
        ("File", Path(bpy.data.filepath).name or "not saved"),
        ("Scene", scene.name),
        ("Frames", f"{recording.frame_start} to {recording.frame_end}"),
        ("Frame rate", f"{shown_number(rate)} fps"),
        ("Substeps", str(clock.substeps)),
        ("Seed of the noise", str(scene.angen_seed)),
        ("Sensors", str(len(sensors))),
    ]
    if start is not None:
        found.append(("Time 0 is", start.isoformat(" ")))
    if any(sensor.kind.requires(LIGHT) for sensor in sensors):
        efficacy = shown_number(decimal(scene.angen_luminous_efficacy))
        found.append(("Luminous efficacy", f"{efficacy} lm/W"))
    light = any(sensor.kind.requires(LIGHT) for sensor in simulated(sensors))
    found += [("Lacking", text) for text in lacking(bpy.context.view_layer, light)]
    return found


def _sensor_facts(sensor: Sensor) -> ReportedSensor:
    rate = decimal(sensor.settings.update_rate)
    settings = []
    if rate != sensor.kind.update_rate:
        settings.append(("update_rate", format_quantity(rate, "Hz")))
    shapes = tuple(
        (f.name, (getattr(sensor.parameters, f.shape[0]), getattr(sensor.parameters, f.shape[1])))
        for f in sensor.kind.samples
        if f.shape is not None
    )
    settings += _changed(sensor)
    kind, room = sensor.kind.identifier, sensor.room
    return ReportedSensor(sensor.name, kind, room, 1.0 / rate, tuple(settings), shapes)


def _changed(sensor: Sensor) -> list[tuple[str, str]]:
    """Return the name and the value of each parameter that differs from the default of the kind.

    Leave out parameters that have no effect with the present settings. An animated parameter is
    always listed, with the value "animated".
    """
    parameters = read_parameters(sensor, sensor.settings)
    usual = defaults(sensor.kind.parameters)
    found = []
    for name, spec in specs(sensor.kind.parameters).items():
        value = getattr(parameters, name)
        if is_animated(sensor.object, f"angen_sensor.{sensor.kind.attribute}.{name}"):
            found.append((name, "animated"))
        elif is_chosen(parameters, spec.used_when) and not _same(value, usual[name]):
            found.append((name, value_text(value, spec, sensor.kind.unit_of(spec, parameters))))
    return found


def _same(value: Any, usual: Any) -> bool:
    if isinstance(value, float):
        # Blender stores angles in single precision.
        return abs(value - usual) <= 1e-6 * max(abs(usual), 1e-6)
    return bool(value == usual)


def _made_by() -> str:
    version = extension_version()
    blender = ".".join(map(str, bpy.app.version[:2]))
    return f"Made by Ängen Sensors {version} in Blender {blender}."
