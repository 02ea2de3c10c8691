# SPDX-License-Identifier: GPL-3.0-or-later
"""A motion detector as the coverage map needs it: its rays cast once through the empty room."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...sensor_logic.coverage.detect import DetectorView, RangeView, WarmView
from ...sensor_logic.coverage.detectors import (
    DETECTOR,
    SIGHT,
    STEFAN_BOLTZMANN,
    PirParameters,
    Walker,
    fan_directions,
    radiosity,
    response_of,
    threshold_of,
    zone_rays,
    zones_of,
)
from ...sensor_logic.error import AngenError
from ...sensor_logic.model import Pose
from ..scene.home import EvaluatedHome
from ..scene.instances import Uid
from ..scene.sensors import Sensor, check, check_evaluated, decimal, read_parameters, read_pose
from ..scene.warmth import Warmth, kelvin

BUNDLE = -10
# What moves is as warm as a person, skin and clothing together; a cat's coat about as much.
BODY = Walker()


def detectors(sensors: Sequence[Sensor]) -> list[Sensor]:
    """The motion detectors among the sensors that are switched on. Raises AngenError."""
    found = [s for s in sensors if s.kind is DETECTOR and s.settings.enabled]
    if not found:
        raise AngenError(
            "there is no motion detector (PIR) that is switched on: add one with Shift+A, Sensor"
        )
    return found


def view_of(home: EvaluatedHome, sensor: Sensor) -> DetectorView:
    """The view of a sensor of the scene. Raises AngenError."""
    check(sensor)
    evaluated = sensor.object.evaluated_get(home.depsgraph)
    check_evaluated(sensor, home.depsgraph)
    settings = sensor.settings_in(evaluated)
    parameters = read_parameters(sensor, settings)
    pose = read_pose(sensor, sensor.world_matrix(home.depsgraph), home.metres)
    rate = decimal(settings.update_rate)
    return view_from(home, Warmth(home.caster), parameters, pose, rate, sensor.uid)


def view_from(
    home: EvaluatedHome,
    warmth: Warmth,
    parameters: PirParameters,
    pose: Pose,
    rate: float,
    uid: Uid,
) -> DetectorView:
    """The view of a detector with these parameters at a pose, `rate` updates a second; its rays
    pass through the object of this session uid."""
    if parameters.model == "PYROELECTRIC":
        return _warm_view(home, warmth, parameters, pose, rate, uid)
    fan = fan_directions(parameters)
    directions = fan.reshape(-1, 3) @ pose.axes.T
    reach = np.full(len(directions), parameters.range_max - parameters.range_min)
    origins = pose.origin + directions * parameters.range_min
    ranges = _cast(home, uid, origins, directions, reach)
    free = np.where(ranges >= reach, parameters.range_max, ranges + parameters.range_min)
    tilts = len(fan)
    period, offsets = 1.0 / rate, np.zeros(tilts)
    if parameters.sweep != "ALL":
        period, offsets = tilts / rate, np.arange(tilts) / rate
    return RangeView(
        pose.origin,
        directions.reshape(fan.shape),
        np.clip(free, parameters.range_min, parameters.range_max).reshape(fan.shape[:2]),
        parameters.range_min,
        parameters.range_max,
        parameters.threshold,
        period,
        offsets,
    )


def _warm_view(
    home: EvaluatedHome,
    warmth: Warmth,
    parameters: PirParameters,
    pose: Pose,
    rate: float,
    uid: Uid,
) -> WarmView:
    local = zone_rays(zones_of(parameters), parameters.zone_rays)
    directions = local.directions @ pose.axes.T
    origins = pose.origin + directions * parameters.range_min
    reach = np.full(len(directions), SIGHT)
    ranges = _cast(home, uid, origins, directions, reach)
    seen = warmth.see(
        home.depsgraph, uid, BUNDLE, origins / home.metres, directions, reach / home.metres
    )[0]
    ambient = STEFAN_BOLTZMANN * seen.ambient**4
    warm = STEFAN_BOLTZMANN * BODY.emissivity * (kelvin(BODY.celsius) ** 4 - seen.ambient**4)
    return WarmView(
        pose.origin,
        directions,
        local.weights,
        ranges + parameters.range_min,
        radiosity(seen) - ambient,
        warm,
        parameters.range_min,
        response_of(parameters),
        threshold_of(parameters),
        1.0 / rate,
    )


def _cast(home: EvaluatedHome, uid: Uid, origins: Any, directions: Any, reach: Any) -> Any:
    rows = np.flatnonzero(~home.caster.solids.owned_by(uid))
    metres = home.metres
    found = home.caster.first_met(
        home.depsgraph, rows, origins / metres, directions, reach / metres
    )
    return np.minimum(found[0] * metres, reach)
