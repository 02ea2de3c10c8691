# SPDX-License-Identifier: GPL-3.0-or-later
"""What all sensors of a scene see at its present frame, kept from frame to frame.

A sensor's rays are asked for again only where its pose or parameters changed, and cast again only
where something moved near them.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ....sensor_logic.clock import Clock
from ....sensor_logic.model import Array, Pose
from ....sensor_logic.parameters import specs
from ...kinds import appearance_of
from ...runtime import state
from ...runtime.live import live_of
from ...runtime.sensor_runner import SensorRunner
from ...scene.animation import is_animated
from ...scene.rays.solids import Solids
from ...scene.sensors import Sensor, SensorError, all_sensors, unit_scale
from ..sight import Rays, sight_of
from .figures import Figure, surface_outline
from .movers import Movers
from .sweep import NO_TILTS, Sweep

NEVER = -(2**31)
# Bundles of rays that are only drawn are numbered downwards from here.
DRAWN = -100


class Seen:
    """One sensor with what is drawn of it.

    `matrix`: its place in the world; `rays` and their `ranges`, in Blender units, both None where
    it does not look, and whether it `casts` these itself; `outline` (n, 3): of a pad; `figure`, to
    be made anew where None; `scan`: what it scans now, one of `scans` by their tilts, and `lit`:
    where movement was seen at its last update; `of_reading`: what a reading adds, with that;
    `problem`: why it cannot sense.
    """

    def __init__(self, sensor: Sensor, clock: Clock) -> None:
        self.sensor = sensor
        self.uid = sensor.uid
        self.appearance = appearance_of(sensor.kind)
        self.runner = SensorRunner(sensor, clock)
        self.matrix: Any = None
        self.parameters: Any = None
        self.pose: Pose | None = None
        self.rays: Rays | None = None
        self.ranges: Array | None = None
        self.casts = False
        self.outline: Array | None = None
        # Bundles whose ranges may not be those of the present frame.
        self.stale: set[int] = set()
        self.number: int | None = None
        self.figure: Figure | None = None
        self.scan: Figure | None = None
        self.scans: dict[range, Figure] = {}
        self.lit: Figure | None = None
        self.of_reading: tuple[Any, Figure | None] | None = None
        self._parts: dict[int, tuple[Array, Array, Array]] = {}
        self.problem = ""
        self.sweep = Sweep()
        self.animated = _is_animated(sensor)

    def keep(self, before: Seen) -> None:
        """Takes over what is known of the same sensor."""
        self.matrix, self.parameters, self.pose = before.matrix, before.parameters, before.pose
        self.rays, self.ranges, self.casts = before.rays, before.ranges, before.casts
        self.outline = before.outline
        self.figure, self.scan, self.problem = before.figure, before.scan, before.problem
        self.scans, self.lit, self.of_reading = before.scans, before.lit, before.of_reading
        self.sweep, self.stale, self._parts = before.sweep, before.stale, before._parts

    def aim(self, rays: Rays | None) -> None:
        """New rays: nothing is known of what they meet."""
        self.rays, self.ranges, self.figure, self.of_reading = rays, None, None, None
        self.scan = self.lit = None
        self._parts, self.scans = {}, {}
        self.stale = set(range(rays.bundles if rays else 0))

    def parts(self, part: slice, row: int) -> tuple[Array, Array, Array]:
        """Origins, directions and reach of a row, the same arrays each time: the caster knows them
        again by that."""
        if row not in self._parts:
            assert self.rays is not None
            rays = self.rays
            self._parts[row] = rays.origins[part], rays.directions[part], rays.reach[part]
        return self._parts[row]

    @property
    def selected(self) -> bool:
        return self.sensor.selected


def _is_animated(sensor: Sensor) -> bool:
    """Whether its parameters must be read anew at each frame."""
    if sensor.object.animation_data is None:
        return False
    names = [f"{sensor.kind.attribute}.{name}" for name in specs(sensor.kind.parameters)]
    return any(is_animated(sensor.object, f"angen_sensor.{n}") for n in ["enabled", *names])


class Field:
    """The sensors of one scene. `frame` is that at which they were looked at; `outdated` after an
    edit since then; `unseen`: something is as sensors saw it at earlier updates."""

    def __init__(self, scene: Any) -> None:
        self.scene_uid = scene.session_uid
        self.unseen = False
        # By the clock of time.monotonic.
        self.followed_at = 0.0
        self.frame = NEVER
        self.outdated = True
        self.metres = 1.0
        self.seen: list[Seen] = []
        self.states: tuple[int, list[Any]] = (0, [])
        # What labels.py shows in each region, by the region's address; and the uid of the sensor
        # whose sign the mouse is over.
        self.boards: dict[int, Any] = {}
        self.hovered: int | None = None
        self._clock: Clock | None = None
        self._boxes: tuple[Array, Array] = (np.empty((0, 3)), np.empty((0, 3)))
        self._movers = Movers(Solids())
        self._outputs: list[bool] = []

    def fail(self, scene: Any) -> None:
        """Keeps still until the next edit."""
        self.seen, self.boards = [], {}
        self.frame, self.outdated = scene.frame_current, False

    def follow(self, scene: Any, view_layer: Any, depsgraph: Any, in_handler: bool = False) -> None:
        """Brings everything to the scene as it is evaluated; `in_handler`: of a frame change, where
        the live sensors came first."""
        clock = Clock(scene.frame_start, scene.render.fps, scene.render.fps_base)
        edited = self.outdated or clock != self._clock
        self.frame, self.outdated, self._clock = scene.frame_current, False, clock
        self.metres = unit_scale(scene)
        if edited:
            self._list(view_layer, clock)
        live = live_of(scene)
        # The live sensors know of what was changed before the playhead moved.
        alike = in_handler and live.looked_at == scene.frame_current and not live.told
        asked = [s for s in self.seen if edited or not (alike and s.matrix and s.runner.steady)]
        aimed = [seen for seen in asked if self._aim(seen, depsgraph, edited)]
        if edited or aimed:
            self._bound()
        caster = self._look(scene, depsgraph, in_handler)
        self._movers.follow()
        near = self._movers.near(*self._boxes).tolist()
        step = scene.frame_current - scene.frame_start
        self.unseen = False
        for number, seen in enumerate(self.seen):
            if seen.rays is not None:
                if _is_drawn(scene, seen):
                    self._see(seen, caster, near[number], step, not in_handler)
                elif near[number]:
                    seen.stale = set(range(seen.rays.bundles))
                self.unseen |= bool(seen.stale)
        if not in_handler or state.CACHE.live.looked_at is None:
            self._forget_driven(scene, caster)
        state.CACHE.live.looked_at = None

    def _list(self, view_layer: Any, clock: Clock) -> None:
        """Finds the sensors anew; what is known of those that stay is kept."""
        known = {seen.uid: seen for seen in self.seen}
        listed = [Seen(sensor, clock) for sensor in all_sensors(view_layer)]
        for seen in listed:
            before = known.get(seen.uid)
            if before is not None and before.sensor.kind is seen.sensor.kind:
                seen.keep(before)
        self.seen = listed

    def _bound(self) -> None:
        boxes = [s.rays.box() if s.rays is not None else (np.inf, -np.inf) for s in self.seen]
        lo = np.array([np.broadcast_to(box[0], 3) for box in boxes]).reshape(-1, 3)
        hi = np.array([np.broadcast_to(box[1], 3) for box in boxes]).reshape(-1, 3)
        self._boxes = lo, hi

    def _aim(self, seen: Seen, depsgraph: Any, edited: bool) -> bool:
        """Asks a sensor for its rays where they can have changed; whether they did."""
        evaluated = seen.sensor.object.evaluated_get(depsgraph)
        matrix = seen.sensor.world_matrix(depsgraph)
        if not edited and not seen.animated and matrix == seen.matrix:
            return False
        seen.matrix = matrix.copy()
        problem, sight, rays = "", None, None
        try:
            sight = sight_of(seen.runner, depsgraph)
        except SensorError as error:
            problem = str(error)
        if sight is not None:
            rays = seen.appearance.rays(sight, self.metres)
            seen.parameters, seen.pose = sight.parameters, sight.pose
            seen.casts = rays is sight.rays
        outline = surface_outline(evaluated, matrix) if seen.appearance.outlined and rays else None
        if problem == seen.problem and _same(rays, seen.rays) and _equal(outline, seen.outline):
            # Parameters that bear on no ray can show too, as a threshold does.
            if edited or seen.animated:
                seen.figure = None
            return False
        seen.problem, seen.outline = problem, outline
        seen.aim(rays)
        return True

    def _look(self, scene: Any, depsgraph: Any, in_handler: bool) -> Any:
        """The caster of the live sensors: it need not cast again what they did."""
        live = live_of(scene)
        if self._movers.solids is not live.caster.solids:
            self._movers = Movers(live.caster.solids)
        # Where the live sensors looked at this very frame, looking again could hide from them what
        # Blender evaluates only after the handlers.
        looked = in_handler and live.looked_at == scene.frame_current
        if not looked:
            live.looked_at = None
            live.caster.update(depsgraph)
        return live.caster

    def _see(self, seen: Seen, caster: Any, near: bool, step: int, all_now: bool) -> None:
        """Casts what a sensor casts at this frame, where something moved near it since; and all
        that it sees where `all_now`, or where it does not follow from the frame before."""
        rays = seen.rays
        assert rays is not None
        if seen.ranges is None:
            seen.ranges = rays.reach.copy()
        if near:
            seen.stale = set(range(rays.bundles))
        scans = seen.appearance.scans(seen.parameters)
        due, follows = NO_TILTS, False
        if scans:
            due, follows = seen.sweep.due(seen.runner.schedule, step, seen.parameters, rays.rows)
        elif rays.rows > 1:
            # Views and zones: wide; once an update is enough while the playhead moves.
            number = seen.runner.schedule.last_update(max(step, 0))
            follows, seen.number = number == seen.number, number
        asked = due if follows and not all_now else range(rays.bundles)
        rows = [row for row in asked if row in seen.stale]
        changed = self._cast(seen, caster, rows) if rows else []
        if changed or seen.figure is None:
            seen.figure = seen.appearance.figure(seen, self.metres)
            seen.scans = {t: f for t, f in seen.scans.items() if not any(r in t for r in changed)}
        if scans:
            self._scan(seen, due)

    def _scan(self, seen: Seen, due: range) -> None:
        """What a detector scans, and what it saw move where tilts are due."""
        sweep, rays = seen.sweep, seen.rays
        assert rays is not None and seen.ranges is not None
        if due:
            ranges = seen.ranges.reshape(rays.rows, -1) * self.metres
            sweep.compare(ranges, seen.parameters.threshold)
        if sweep.lit is None:
            seen.lit = None
        elif due:
            seen.lit = seen.appearance.lit_figure(seen, self.metres)
        if sweep.tilts not in seen.scans:
            seen.scans[sweep.tilts] = seen.appearance.scan_figure(seen, self.metres)
        seen.scan = seen.scans[sweep.tilts]

    def _cast(self, seen: Seen, caster: Any, rows: list[int]) -> list[int]:
        """Casts some rows of a sensor's rays; those of which a range changed."""
        rays, ranges = seen.rays, seen.ranges
        assert rays is not None and ranges is not None
        changed = []
        for row in rows:
            part = rays.bundle(row)
            seen.stale.discard(row)
            if part.stop > part.start:
                bundle = row if seen.casts else DRAWN - row
                found = caster.cast(seen.uid, bundle, *seen.parts(part, row))
                if not np.array_equal(found, ranges[part]):
                    changed.append(row)
                    ranges[part] = found
        return changed

    def _forget_driven(self, scene: Any, caster: Any) -> None:
        """What drivers make of recorded readings, Blender tells nobody."""
        values = [bool(seen.sensor.settings.active) for seen in self.seen]
        if values != self._outputs:
            self._outputs = values
            if state.CACHE.outputs_are_driven():
                caster.solids.forget()


def _is_drawn(scene: Any, seen: Seen) -> bool:
    settings = scene.angen_overlay
    return settings.fields and (settings.which == "ALL" or seen.selected)


def _same(one: Rays | None, two: Rays | None) -> bool:
    return one is two or (one is not None and one.same(two))


def _equal(one: Array | None, two: Array | None) -> bool:
    if one is None or two is None:
        return one is two
    return np.array_equal(one, two)
