# SPDX-License-Identifier: GPL-3.0-or-later
"""The coverage map of the detectors of a scene at the present frame.

The operator, the command line and the tests all use the generator `cover`. A view (`DetectorView`)
tells how strongly a detector notices a motion.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator, Mapping, Sequence
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
from ...sensor_logic.coverage.grid import Cells, CoverageMap
from ...sensor_logic.coverage.motions import DIRECTIONS, Motion
from ...sensor_logic.error import AngenError
from ...sensor_logic.model import Pose
from ..progress import Doing
from ..scene.home import EvaluatedHome
from ..scene.instances import Uid
from ..scene.sensors import (
    Sensor,
    check,
    check_evaluated,
    check_names,
    decimal,
    read_parameters,
    read_pose,
)
from ..scene.surfaces import Warmth, kelvin
from .floor import cells_of

BUNDLE = -10
# The moving body is as warm as a person with clothes; a cat is about as warm.
BODY = Walker()


def detectors(sensors: Sequence[Sensor]) -> list[Sensor]:
    """Return the motion detectors that are switched on. Raise `AngenError` without any."""
    found = [s for s in sensors if s.kind is DETECTOR and s.settings.enabled]
    if not found:
        raise AngenError(
            "there is no motion detector (PIR) that is switched on: add one with Shift+A, Sensor"
        )
    return found


def view_of(home: EvaluatedHome, sensor: Sensor) -> DetectorView:
    """Return the view of a sensor in the scene. Raise `AngenError` if the sensor cannot be read."""
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
    """Return the view of a detector; its rays are cast through the scene here.

    Parameters
    ----------
    home, warmth
        The evaluated scene, and its temperatures.
    parameters
        The parameters of the detector.
    pose
        Its pose, in m.
    rate
        Its update rate in Hz.
    uid
        Session uid of the detector's object. Its rays go through this object.
    """
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
    rays = origins / home.metres, directions, reach / home.metres
    seen = warmth.see(home.depsgraph, uid, BUNDLE, rays)[0]
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


SMALLEST_CELL, LARGEST_CELL = 0.05, 2.0
# The number of motions that are computed between two reports of progress.
AT_ONCE = 4000
# The part of the work that finding the floor takes, from 0 to 1.
FLOOR_SHARE = 0.3


def cover(
    depsgraph: Any,
    sensors: Sequence[Sensor],
    chosen: Sequence[Sensor],
    motion: Motion,
    size: float,
    rooms: Sequence[str] = (),
) -> Generator[Doing | CoverageMap, None, None]:
    """Make the map of the `chosen` detectors.

    Parameters
    ----------
    depsgraph
        The evaluated depsgraph.
    sensors
        All sensors of the home. Their rooms tell which cells belong to which room.
    chosen
        The sensors to map. Those that are no motion detectors are left out.
    motion
        The motion that is tested in each cell.
    size
        Side of a cell in m.
    rooms
        Names of the rooms to map; empty: all.

    Yields
    ------
    Doing or CoverageMap
        The progress, and last the map.

    Raises
    ------
    AngenError
        If a cell size, a detector or a room is wrong.
    """
    check_cell(size)
    chosen = detectors(chosen)
    check_names(list(chosen))
    home = EvaluatedHome(depsgraph)
    cells = yield from cells_of(home, sensors, motion, size, rooms)
    views = {}
    for sensor in chosen:
        views[sensor.name] = view_of(home, sensor)
        yield Doing(FLOOR_SHARE, sensor.name)
    yield from strengths(views, cells, motion)


def strengths(
    views: Mapping[str, DetectorView], cells: Cells, motion: Motion
) -> Iterator[Doing | CoverageMap]:
    """Compute how strongly each detector notices the motion in each cell and direction.

    `views` are by the name of the detector. Yield the progress, and last the map.
    """
    start, cell, direction = cells.starts()
    found = np.zeros((len(views), len(cells), DIRECTIONS), np.float32)
    for row, (name, view) in enumerate(views.items()):
        for first in range(0, len(start), AT_ONCE):
            rows = slice(first, first + AT_ONCE)
            found[row, cell[rows], direction[rows]] = view.strengths(motion, start.part(rows))
            share = (row + min(1.0, (first + AT_ONCE) / len(start))) / len(views)
            yield Doing(FLOOR_SHARE + (1.0 - FLOOR_SHARE) * share, name)
    yield CoverageMap(motion, cells, tuple(views), found)


def whole_map(views: Mapping[str, DetectorView], cells: Cells, motion: Motion) -> CoverageMap:
    """Return the exact map, as `strengths` yields it last."""
    *_, last = strengths(views, cells, motion)
    assert isinstance(last, CoverageMap)
    return last


def upper_bound_map(views: Mapping[str, DetectorView], cells: Cells, motion: Motion) -> CoverageMap:
    """Return a map that covers at least the cells of the exact map, and perhaps more.

    Making it is far quicker than making the exact map.
    """
    start, cell, direction = cells.starts()
    found = np.zeros((len(views), len(cells), DIRECTIONS), np.float32)
    for row, view in enumerate(views.values()):
        found[row, cell, direction] = np.where(view.may_notice(motion, start), np.inf, 0.0)
    return CoverageMap(motion, cells, tuple(views), found)


def check_cell(size: float) -> None:
    """Raise `AngenError` if cells with sides of `size` (m) are too small or too large."""
    if not SMALLEST_CELL <= size <= LARGEST_CELL:
        raise AngenError(
            f"the cell is {size:g} m: it must be from {SMALLEST_CELL:g} m to {LARGEST_CELL:g} m"
        )
