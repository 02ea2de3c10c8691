# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes lines and surfaces of what all sensors of a scene see: from the hits of their own rays when
they sensed last, and only anew where those changed."""

from __future__ import annotations

from contextlib import suppress
from typing import Any, NamedTuple

from ....panels.readings import ReadingText
from ....sensor_logic.error import AngenError
from ....sensor_logic.model import Array, Pose
from ...kinds import appearance_of
from ...runtime.live import live_of
from ...runtime.sensor_runner import SensorRunner
from ...runtime.trace import RaysMet, Trace
from ...scene.sensors import Sensor, all_sensors, unit_scale
from .figures import Figure, surface_outline

NEVER = -(2**31)


class DrawnSensor:
    """One sensor with what is drawn of it.

    `matrix`: its place in the world; `parameters` and `pose`: what it senses with, None where it
    does not; `rays`: what its rays met; `outline` (n, 3): of a pad; `figures`: what it sees; `now`:
    what it scanned at its last update, and `lit`: where it saw movement then; `of_reading`: what a
    reading adds, with that; `revision` grows where `figures` change.
    """

    def __init__(self, sensor: Sensor) -> None:
        self.sensor = sensor
        self.uid = sensor.uid
        self.appearance = appearance_of(sensor.kind)
        self.matrix: Any = None
        self.parameters: Any = None
        self.pose: Pose | None = None
        self.rays: Trace | None = None
        self.outline: Array | None = None
        self.figures: list[Figure] = []
        self.now: list[Figure] = []
        self.lit: list[Figure] = []
        self.of_reading: tuple[Any, Figure | None] | None = None
        # The texts of its reading, kept while all that they depend on is equal: 20 µs a frame.
        self.texts: tuple[Any, ReadingText] | None = None
        self.revision = 0
        # What the figures were made of: of the sensor itself, of its rays, of its last update.
        self._read_at: tuple[Any, ...] = ()
        self._own: list[Figure] = []
        self._rays: tuple[Any, ...] = ()
        self._scan: tuple[Any, ...] = ()
        # By what draws them and the bundle's number, what was drawn of which rays.
        self._drawn: dict[tuple[str, int], tuple[RaysMet, Figure | None]] = {}

    @property
    def selected(self) -> bool:
        return self.sensor.selected

    def place(self, depsgraph: Any) -> None:
        matrix = self.sensor.world_matrix(depsgraph)
        if matrix != self.matrix:
            self.matrix = matrix.copy()

    def follow(
        self, runner: SensorRunner | None, depsgraph: Any, edits: int, metres: float
    ) -> None:
        """Makes those figures anew whose sensor, rays or readings have changed."""
        if not self._follow_sensor(runner, depsgraph, edits, metres) or runner is None:
            self.rays = None
            return
        rays = self.rays = runner.trace
        if self._rays != (rays, rays.revision):
            self._rays = rays, rays.revision
            self.figures = [*self._own, *self._of_bundles("rays_figure", rays.bundles, metres)]
            self.revision += 1
        scan = rays, rays.step, rays.revision
        if self._scan != scan:
            self._scan = scan
            now = {n: rays.bundles[n] for n in rays.scan if n in rays.bundles}
            self.now = [*self._of_bundles("scan_figure", now, metres)]
            self.lit = []
            for number, before in rays.scan.items():
                if before is not None and number in now:
                    found = self.appearance.lit_figure(self, number, now[number], before, metres)
                    self.lit += [found] if found is not None else []

    def _follow_sensor(
        self, runner: SensorRunner | None, depsgraph: Any, edits: int, metres: float
    ) -> bool:
        """Draws what stands apart from rays; whether it senses."""
        if runner is not None and runner.steady and self._read_at == (runner, edits, metres):
            return self.pose is not None
        self._read_at = runner, edits, metres
        read = None
        if runner is not None:
            with suppress(AngenError):
                read = runner.read(depsgraph, edits)
        if read is None:
            self._begin(None, None)
        elif self.parameters is not read.parameters or self.pose is not read.pose:
            self._begin(read.parameters, read.pose)
            evaluated = self.sensor.object.evaluated_get(depsgraph)
            outlined = self.appearance.outlined
            self.outline = surface_outline(evaluated, self.matrix) if outlined else None
            self._own = self.figures = [self.appearance.figure(self, metres)]
        return read is not None

    def _begin(self, parameters: Any, pose: Pose | None) -> None:
        """Forgets the figures of a sensor that has changed."""
        self.parameters, self.pose = parameters, pose
        self._rays, self._scan, self._drawn = (), (), {}
        self.of_reading, self._own, self.figures, self.now, self.lit = None, [], [], [], []
        self.revision += 1

    def _of_bundles(self, draws: str, bundles: dict[int, RaysMet], metres: float) -> list[Figure]:
        """The figures of some bundles, each made anew only where its rays met something else."""
        found = []
        for number, met in bundles.items():
            known = self._drawn.get((draws, number))
            if known is None or known[0] is not met:
                drawn = getattr(self.appearance, draws)(self, number, met, metres)
                known = self._drawn[draws, number] = met, drawn
            if known[1] is not None:
                found.append(known[1])
        return found


class SensorRow(NamedTuple):
    """A sensor that a view shows, what it reads, and whether it is selected."""

    seen: DrawnSensor
    shown: ReadingText
    selected: bool


class DrawnSensors:
    """The sensors of one scene. `frame` is that at which they were looked at; `outdated` after an
    edit since then; `unseen`: not all of their rays were cast at it."""

    def __init__(self, scene: Any) -> None:
        self.scene_uid = scene.session_uid
        self.unseen = True
        # By the clock of time.monotonic.
        self.followed_at = 0.0
        self.frame = NEVER
        self.outdated = True
        self.metres = 1.0
        self.seen: list[DrawnSensor] = []
        # What was drawn last of them, and in which region.
        self.rows: tuple[int, list[SensorRow]] = (0, [])
        # What labels.py and draw.py show in each region, by the region's address; and the uid of
        # the sensor whose sign the mouse is over.
        self.boards: dict[int, Any] = {}
        self.joined: dict[int, Any] = {}
        self.hovered: int | None = None
        # Whether what the sensors see was looked for, not their places alone.
        self.has_fields = False

    def fail(self, scene: Any) -> None:
        """Keeps still until the next edit."""
        self.seen, self.boards, self.joined = [], {}, {}
        self.frame, self.outdated, self.unseen = scene.frame_current, False, False
        self.has_fields = True

    def follow(self, scene: Any, view_layer: Any, depsgraph: Any) -> None:
        """Brings all figures up to date with the evaluated scene, after its sensors have sensed."""
        live = live_of(scene)
        edited = self.outdated
        self.frame, self.outdated = scene.frame_current, False
        self.metres = unit_scale(scene)
        if edited:
            self._list(view_layer)
        fields = self.has_fields = bool(scene.angen_overlay.fields)
        # The live sensors know of what was changed before the playhead moved.
        kept = live.places_are_kept(scene) and not edited
        for seen in self.seen:
            runner = live.runner(seen.uid)
            if not kept or runner is None or seen.matrix is None or not runner.steady:
                seen.place(depsgraph)
            if fields:
                seen.follow(runner, depsgraph, live.edits, self.metres)

    def _list(self, view_layer: Any) -> None:
        """Lists the sensors again; those that were listed before keep their figures."""
        known = {seen.uid: seen for seen in self.seen}
        self.seen = []
        for sensor in all_sensors(view_layer):
            before = known.get(sensor.uid)
            seen = DrawnSensor(sensor)
            if before is not None and before.sensor.kind is sensor.kind:
                seen = before
                seen.sensor = sensor
            self.seen.append(seen)
