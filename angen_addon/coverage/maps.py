# SPDX-License-Identifier: GPL-3.0-or-later
"""Compute the coverage map of a scene's motion detectors at the current frame.

The operator, the command line and the tests all use the generator `cover`. A `DetectorView`
computes how strongly one detector notices a motion.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from ...sensor_logic.coverage.detect import DetectorView
from ...sensor_logic.coverage.grid import Cells, CoverageMap
from ...sensor_logic.coverage.motions import DIRECTIONS, Motion
from ...sensor_logic.kind import RAYS, Kind
from ...sensor_logic.kinds import KINDS
from ...sensor_logic.logs.error import AngenError
from ...sensor_logic.model import Array, Pose, Update
from ...sensor_logic.progress import Doing, Work, finished
from ..scene.home.evaluated_home import EvaluatedHome
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
from ..scene.surfaces import SURFACES
from .floor_cells import cells_of

# Coverage casts its bundles under numbers below this, which no sensor's model uses.
BUNDLE = -10
# The uid of a detector that no object is yet: its rays pass through no object.
NOBODY = -1
# The kinds of sensor that have coverage maps. The first is that of new detectors.
MAPPED = [kind for kind in KINDS.values() if kind.view is not None]


# These kinds in the middle of a sentence, such as "motion detector (PIR)".
MAPPED_LABELS = " or ".join(kind.label[0].lower() + kind.label[1:] for kind in MAPPED)


def check_mapped(sensor: Sensor) -> None:
    """Raise `AngenError` if the kind of a sensor has no coverage maps."""
    if sensor.kind not in MAPPED:
        raise AngenError(f"'{sensor.name}' is not a {MAPPED_LABELS}: choose one")


def detectors(sensors: Sequence[Sensor]) -> list[Sensor]:
    """Return the sensors with coverage maps that are switched on; `AngenError` without any."""
    found = [s for s in sensors if s.kind in MAPPED and s.settings.enabled]
    if not found:
        raise AngenError(
            f"there is no {MAPPED_LABELS} that is switched on: add one with Shift+A, Sensor"
        )
    return found


class Views:
    """Makes views of detectors in an evaluated scene."""

    def __init__(self, home: EvaluatedHome) -> None:
        self._home = home
        self._surfaces = {name: probe(home.caster) for name, probe in SURFACES.items()}

    def of(self, sensor: Sensor) -> DetectorView:
        """Return the view of a sensor. Raise `AngenError` if the sensor cannot be read."""
        check(sensor)
        home = self._home
        evaluated = sensor.object.evaluated_get(home.depsgraph)
        check_evaluated(sensor, home.depsgraph)
        settings = sensor.settings_in(evaluated)
        parameters = read_parameters(sensor, settings)
        pose = read_pose(sensor, sensor.world_matrix(home.depsgraph), home.metres)
        return self.at(sensor.kind, parameters, pose, decimal(settings.update_rate), sensor.uid)

    def at(
        self, kind: Kind, parameters: Any, pose: Pose, rate: float, uid: Uid = NOBODY
    ) -> DetectorView:
        """Return the view of a detector at a pose; its rays are cast through the scene here.

        Parameters
        ----------
        kind, parameters
            The kind of the detector, and its parameters.
        pose
            Its pose, in m.
        rate
            Its update rate in Hz.
        uid
            Session uid of the detector's object. Its rays go through this object.
        """
        assert kind.view is not None
        scene: dict[str, Any] = {RAYS: partial(self._cast, uid)}
        scene |= {name: partial(self._see, name, uid) for name in self._surfaces}
        view: DetectorView = kind.view(parameters, Update(0, 0.0, pose, scene), rate)
        return view

    def _cast(
        self, uid: Uid, bundle: int, origins: Array, directions: Array, reach: Array
    ) -> Array:
        home, metres = self._home, self._home.metres
        rows = np.flatnonzero(~home.caster.solids.passed_by(uid))
        rays = origins / metres, directions, reach / metres
        ranges = home.caster.first_hits(rows, *rays)[0]
        return np.minimum(ranges * metres, reach)

    def _see(
        self,
        name: str,
        uid: Uid,
        bundle: int,
        origins: Array,
        directions: Array,
        reach: Array,
        *details: Any,
    ) -> Any:
        metres = self._home.metres
        rays = origins / metres, directions, reach / metres
        return self._surfaces[name].see(uid, BUNDLE - bundle, rays, None, *details)[0]


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
) -> Work[CoverageMap]:
    """Compute the coverage map of the `chosen` detectors.

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
    Doing or None
        The progress.

    Raises
    ------
    AngenError
        If the cell size, a detector or a room is wrong.
    """
    check_cell(size)
    chosen = detectors(chosen)
    check_names(list(chosen))
    home = EvaluatedHome(depsgraph)
    cells = yield from cells_of(home, sensors, motion, size, rooms)
    views, made = {}, Views(home)
    for sensor in chosen:
        views[sensor.name] = made.of(sensor)
        yield Doing(FLOOR_SHARE, sensor.name)
    return (yield from strengths(views, cells, motion))


def strengths(views: Mapping[str, DetectorView], cells: Cells, motion: Motion) -> Work[CoverageMap]:
    """Compute how strongly each detector notices the motion in each cell and direction.

    `views` has a `DetectorView` by name of the detector. Yield the progress, and return the map.
    """
    start, cell, direction = cells.starts()
    found = np.zeros((len(views), len(cells), DIRECTIONS), np.float32)
    for row, (name, view) in enumerate(views.items()):
        for first in range(0, len(start), AT_ONCE):
            rows = slice(first, first + AT_ONCE)
            found[row, cell[rows], direction[rows]] = view.strengths(motion, start.part(rows))
            share = (row + min(1.0, (first + AT_ONCE) / len(start))) / len(views)
            yield Doing(FLOOR_SHARE + (1.0 - FLOOR_SHARE) * share, name)
    return CoverageMap(motion, cells, tuple(views), found)


def whole_map(views: Mapping[str, DetectorView], cells: Cells, motion: Motion) -> CoverageMap:
    """Return the exact map that `strengths` computes."""
    return finished(strengths(views, cells, motion))


def upper_bound_map(views: Mapping[str, DetectorView], cells: Cells, motion: Motion) -> CoverageMap:
    """Return a map that covers at least the cells of the exact map.

    It is far quicker to compute than the exact map.
    """
    start, cell, direction = cells.starts()
    found = np.zeros((len(views), len(cells), DIRECTIONS), np.float32)
    for row, view in enumerate(views.values()):
        found[row, cell, direction] = np.where(view.may_notice(motion, start), np.inf, 0.0)
    return CoverageMap(motion, cells, tuple(views), found)


def check_cell(size: float) -> None:
    """Raise `AngenError` if `size`, the side of a cell in m, is too small or too large."""
    if not SMALLEST_CELL <= size <= LARGEST_CELL:
        raise AngenError(
            f"the cell is {size:g} m: it must be from {SMALLEST_CELL:g} m to {LARGEST_CELL:g} m"
        )
