# SPDX-License-Identifier: GPL-3.0-or-later
"""What all rays of a sensor meet at one frame, also those that it casts in turn: for views, once
the playhead rests. Its own readings go on as if nobody had looked."""

from __future__ import annotations

from typing import Any

from ..scene.light.four_walls import view_rays
from .answers import light_request
from .last_rays import LastRays, RaysMet
from .probes import Probes
from .sensor_runner import SensorRunner


def full_scan(runner: SensorRunner, depsgraph: Any, probes: Probes) -> LastRays:
    """All that the sensor of a runner casts, update after update, until its rays repeat; of a light
    sensor the axes and corners of its views. Nothing of what is switched off. Raises AngenError.
    """
    apart = SensorRunner(runner.sensor, runner.clock)
    if runner.sensor.kind.requires_light:
        _look_along_views(apart, depsgraph, probes)
    elif not runner.sensor.kind.requires_forces:
        number, known = 0, -1
        while len(apart.rays.bundles) > known:
            known = len(apart.rays.bundles)
            step = apart.schedule.step(number)
            pending = apart.take(number, step, depsgraph, probes)
            if pending is not None:
                pending.readings()
            number += 1
    return apart.rays


def _look_along_views(runner: SensorRunner, depsgraph: Any, probes: Probes) -> None:
    read = runner.read(depsgraph, probes.edits)
    if read is None:
        return
    metres = read.metres
    request = light_request(runner.sensor, read.parameters, read.pose, metres, False)
    runner.rays.aim(read.parameters, read.pose)
    if request.method == "FOUR_WALL":
        for wall, rays in enumerate(zip(*view_rays(request), strict=True)):
            ranges = probes.caster.cast(runner.uid, wall, *rays)
            origins, directions, reach = rays
            met = RaysMet(origins * metres, directions, reach * metres, ranges * metres)
            runner.rays.show(wall, met)
