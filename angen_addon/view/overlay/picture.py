# SPDX-License-Identifier: GPL-3.0-or-later
"""Make coloured lines and triangles for the GPU from the figures of sensors.

The colours show the states of the sensors.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....sensor_logic.logs.error import AngenError
from ....sensor_logic.model import Array, Pose
from ...appearance.appearance import appearance_of
from ...appearance.figures import Figure, surface_outline
from ...appearance.reading_text import ACTIVE, ReadingText
from ...runtime.live import live_of
from ...runtime.sensor_runner import SensorRunner
from ...runtime.trace import CastRays, Trace
from ...scene.sensors import Sensor, all_sensors, unit_scale
from ...view import readings

# The look of each state of a sensor: a colour that colour-blind people can tell from the others
# (after Okabe and Ito), a sign of a different shape, and whole or broken lines.

Colour = tuple[float, float, float]
Points = NDArray[np.float32]


def _ring(radius: float, parts: int = 16, gaps: int = 1) -> list[list[tuple[float, float]]]:
    """Return a circle as `parts` lines; if `gaps` is 2, return only every other line."""
    at = [2 * math.pi * n / parts for n in range(parts + 1)]
    points = [(radius * math.cos(a), radius * math.sin(a)) for a in at]
    return [[points[n], points[n + 1]] for n in range(0, parts, gaps)]


def _disc(radius: float, parts: int = 16) -> list[list[tuple[float, float]]]:
    return [[(0.0, 0.0), *edge] for edge in _ring(radius, parts)]


def disc() -> Points:
    """Return a filled circle of radius 1 as triangles (n, 3, 2)."""
    return _array(_disc(1.0), 3)


def _array(shape: list[list[tuple[float, float]]], corners: int) -> Points:
    return np.array(shape, np.float32).reshape(-1, corners, 2)


@dataclass(frozen=True)
class Look:
    """The sign, the colour and the opacity that show a state of a sensor.

    `lines` (n, 2, 2) and `faces` (m, 3, 2) are the lines and triangles of the sign. The sign is
    centred on the origin, with a radius of about 1. `strength` multiplies the opacity of the field
    of view.
    """

    colour: Colour
    strength: float
    lines: Points = field(default_factory=lambda: _array([], 2))
    faces: Points = field(default_factory=lambda: _array([], 3))


_CROSS = [[(-0.7, -0.7), (0.7, 0.7)], [(-0.7, 0.7), (0.7, -0.7)]]
_TRIANGLE = [(-1.0, -0.8), (1.0, -0.8), (0.0, 1.0)]
_SIDES = [[_TRIANGLE[n], _TRIANGLE[(n + 1) % 3]] for n in range(3)]
_HANDS = [[(0.0, 0.65), (0.0, 0.0)], [(0.0, 0.0), (0.5, 0.0)]]
_DOTS = [[(x - 0.12, 0.0), (x + 0.12, 0.0)] for x in (-0.5, 0.0, 0.5)]
_DIAMOND = [(0.0, -1.0), (1.0, 0.0), (0.0, 1.0), (-1.0, 0.0)]
_EXCLAMATION = [[(0.0, 0.45), (0.0, -0.2)], [(0.0, -0.45), (0.0, -0.6)]]

# The looks by the icons of panels, so that views and panels agree.
LOOKS = {
    readings.ACTIVE: Look((1.0, 0.62, 0.05), 1.0, _array(_ring(1.0), 2), _array(_disc(1.0), 3)),
    readings.IDLE: Look((0.34, 0.71, 0.96), 0.75, _array(_ring(1.0), 2)),
    readings.OFF: Look((0.62, 0.62, 0.62), 0.4, _array(_CROSS, 2)),
    readings.DOUBTFUL: Look((0.80, 0.80, 0.76), 0.5, _array(_SIDES + _EXCLAMATION, 2)),
    readings.WRONG: Look((0.93, 0.53, 0.80), 0.75, _array(_SIDES + _EXCLAMATION, 2)),
    readings.UNKNOWN: Look((0.80, 0.80, 0.76), 0.5, _array(_ring(1.0, 12, 2), 2)),
    readings.NOT_SURE: Look((0.80, 0.80, 0.76), 0.5, _array(_ring(1.0) + _DOTS, 2)),
    readings.OLD: Look((0.94, 0.89, 0.26), 0.5, _array(_ring(1.0) + _HANDS, 2)),
    readings.BAKED: Look(
        (0.80, 0.80, 0.76), 0.5, _array([[_DIAMOND[n], _DIAMOND[n - 1]] for n in range(4)], 2)
    ),
}
# States whose fields of view have broken lines, since they show no present reading.
BROKEN = {
    readings.NOT_SURE,
    readings.DOUBTFUL,
    readings.WRONG,
    readings.UNKNOWN,
    readings.OLD,
    readings.BAKED,
}


Array32 = NDArray[np.float32]
# The opacity of lines and fills by their meaning. Meanings in BOLD have thick lines, and those in
# ON_TOP show through walls and people.
LINES = {
    "edge": 0.14,
    "ray": 0.3,
    "outline": 0.5,
    "limit": 0.3,
    "now": 0.95,
    "lit": 0.9,
    "beam": 0.85,
    "axis": 0.45,
    "dark": 0.35,
    "break": 1.0,
    "gate": 0.7,
    "picture": 0.9,
    "pad": 0.8,
    "force": 1.0,
}
FILLS = {
    "sheet": 0.03,
    "now": 0.04,
    "lit": 0.30,
    "picture": 0.3,
    "pad": 0.12,
    "force": 1.0,
    "value": 0.9,
}
BOLD = {"now", "lit", "break", "force", "beam"}
ON_TOP = {"force"}
# Factors of the opacity of selected sensors and of all others.
SELECTED, OTHER = 1.0, 0.8


@dataclass(frozen=True)
class Primitives:
    """Lines or triangles, with `points` (n, 3) in the world and their `colours` (n, 4).

    `corners` is 2 for lines and 3 for triangles.
    """

    points: Array32
    colours: Array32
    corners: int


def picture(figure: Figure, icon: str, selected: bool) -> dict[str, Primitives]:
    """Return the lines and triangles of a figure, by the name of their GPU batch.

    The names are `fills`, `thin` and `bold`, and `top_fills` and `top` for shapes that show through
    walls. `icon` is the icon of the sensor's state, and `selected` says whether the sensor is
    selected. The figure keeps the last result for reuse.
    """
    look = icon, selected
    if figure.pictured is None or figure.pictured[0] != look:
        figure.pictured = look, _picture(figure, icon, selected)
    made: dict[str, Primitives] = figure.pictured[1]
    return made


def _picture(figure: Figure, icon: str, selected: bool) -> dict[str, Primitives]:
    found: dict[str, list[tuple[Array32, Any]]] = {}
    look = LOOKS[icon]
    emphasis = look.strength * (SELECTED if selected else OTHER)
    for meaning, lines in figure.lines.items():
        if icon in BROKEN:
            lines = lines[::2]
        name = "top" if meaning in ON_TOP else "bold" if meaning in BOLD else "thin"
        found.setdefault(name, []).append((lines, _rgba(look, LINES[meaning] * emphasis)))
    for meaning, faces in figure.fills.items():
        name = "top_fills" if meaning in ON_TOP else "fills"
        colours = _rgba(look, FILLS[meaning] * emphasis)
        if meaning in figure.colours:
            colours = figure.colours[meaning] * np.array([1.0, 1.0, 1.0, colours[3]], np.float32)
        found.setdefault(name, []).append((faces, colours))
    made = {name: _join(parts, 3 if "fills" in name else 2) for name, parts in found.items()}
    return {name: part for name, part in made.items() if len(part.points)}


def _rgba(look: Look, alpha: float) -> Array32:
    return np.array([*look.colour, min(alpha, 1.0)], np.float32)


def _join(parts: list[tuple[Array32, Array32]], corners: int) -> Primitives:
    points = np.concatenate([part.reshape(-1, 3) for part, _ in parts])
    each = [np.broadcast_to(colour, (len(part), 4)) for part, colour in parts]
    colours = np.repeat(np.concatenate(each), corners, axis=0)
    return Primitives(np.ascontiguousarray(points, np.float32), colours, corners)


def joined(pictures: Iterable[dict[str, Primitives]]) -> dict[str, Primitives]:
    """Return the pictures of several figures as one, by the name of their GPU batch."""
    found: dict[str, list[Primitives]] = {}
    for one in pictures:
        for name, part in one.items():
            found.setdefault(name, []).append(part)
    return {name: _one(parts) for name, parts in found.items()}


def _one(parts: list[Primitives]) -> Primitives:
    if len(parts) == 1:
        return parts[0]
    points = np.concatenate([part.points for part in parts])
    return Primitives(points, np.concatenate([part.colours for part in parts]), parts[0].corners)


def changing_figures(seen: Any, shown: ReadingText, metres: float) -> list[Figure]:
    """Return the figures of a sensor that change from update to update.

    These are the figures of the last scan, of the movement in it, and of the reading. `seen` is a
    `DrawnSensor`, and `shown` its reading. `metres` is the length of a Blender unit in m.
    """
    found = [*seen.now]
    # Movement is drawn only if the reading is active: the sensor may have ignored the movement.
    if shown.icon == ACTIVE:
        found += seen.lit
    of_reading = _reading_figure(seen, shown, metres)
    return found if of_reading is None else [*found, of_reading]


def _reading_figure(seen: Any, shown: ReadingText, metres: float) -> Figure | None:
    """Return the figure of the reading `shown`; None if it is not valid or the kind draws none.

    While the drawn fields are equal, the result is the same object.
    """
    look, fields = seen.appearance, shown.fields
    if fields is None or shown.problem or seen.pose is None or not look.drawn_fields:
        return None
    if not all(name in fields for name in look.drawn_fields):
        return None
    read = [str(fields[name]) for name in look.drawn_fields], seen.revision
    if seen.of_reading is None or seen.of_reading[0] != read:
        seen.of_reading = read, look.reading_figure(seen, fields, metres)
    found: Figure | None = seen.of_reading[1]
    return found


# A frame number that no scene can have.
NEVER = -(2**31)


class DrawnSensor:
    """A sensor with the figures that 3D views draw of it.

    Attributes
    ----------
    matrix
        World matrix.
    parameters, pose
        The parameters and the pose; None while the sensor is switched off or cannot be read.
    rays
        The `Trace` with the hits of its rays.
    outline
        Corners (n, 3) of the upper side of a pad.
    figures
        The figures of the sensor itself and of all its rays.
    now
        The figures of the rays that it cast at its last update.
    lit
        The figures of the movement that it detected at its last update.
    of_reading
        The drawn fields of its reading, as texts, and the revision, with the figure of the reading.
    revision
        A number that grows whenever `figures` change.
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
        # What the texts of its reading were made from, and the texts. Making them takes 20 µs.
        self.texts: tuple[Any, ReadingText] | None = None
        self.revision = 0
        # What the figures were made from: of the sensor itself, its rays and its last update.
        self._read_at: tuple[Any, ...] = ()
        self._sensor_figures: list[Figure] = []
        self._rays: tuple[Any, ...] = ()
        self._scan: tuple[Any, ...] = ()
        # By name of the drawing function and number of the bundle: the hits and their figure.
        self._drawn: dict[tuple[str, int], tuple[CastRays, Figure | None]] = {}

    @property
    def selected(self) -> bool:
        """Whether the sensor is selected."""
        return self.sensor.selected

    def place(self, depsgraph: Any) -> None:
        """Read the world matrix of the sensor."""
        matrix = self.sensor.world_matrix(depsgraph)
        if matrix != self.matrix:
            self.matrix = matrix.copy()

    def follow(
        self, runner: SensorRunner | None, depsgraph: Any, edits: int, metres: float
    ) -> None:
        """Make the figures anew whose sensor, rays or readings have changed.

        `edits` is the number of edits of the scene so far, and `metres` the length of a Blender
        unit in m.
        """
        if not self._update_sensor(runner, depsgraph, edits, metres) or runner is None:
            self.rays = None
            return
        rays = self.rays = runner.trace
        if self._rays != (rays, rays.revision):
            self._rays = rays, rays.revision
            self.figures = [
                *self._sensor_figures,
                *self._bundle_figures("rays_figure", rays.bundles, metres),
            ]
            self.revision += 1
        scan = rays, rays.step, rays.revision
        if self._scan != scan:
            self._scan = scan
            now = {n: rays.bundles[n] for n in rays.scan if n in rays.bundles}
            self.now = [*self._bundle_figures("scan_figure", now, metres)]
            self.lit = []
            for number, before in rays.scan.items():
                if before is not None and number in now:
                    found = self.appearance.lit_figure(self, number, now[number], before, metres)
                    self.lit += [found] if found is not None else []

    def _update_sensor(
        self, runner: SensorRunner | None, depsgraph: Any, edits: int, metres: float
    ) -> bool:
        """Make the figure of the sensor anew if its parameters or pose have changed.

        The parameters are as for `follow`; `runner` is None while the sensor is not read. Return
        whether the sensor is switched on and can be read.
        """
        if runner is not None and runner.reader.steady and self._read_at == (runner, edits, metres):
            return self.pose is not None
        self._read_at = runner, edits, metres
        read = None
        if runner is not None:
            with suppress(AngenError):
                read = runner.reader.read(depsgraph, edits)
        if read is None:
            self._reset(None, None)
        elif self.parameters is not read.parameters or self.pose is not read.pose:
            self._reset(read.parameters, read.pose)
            evaluated = self.sensor.object.evaluated_get(depsgraph)
            outlined = self.appearance.outlined
            self.outline = surface_outline(evaluated, self.matrix) if outlined else None
            self._sensor_figures = self.figures = [self.appearance.figure(self, metres)]
        return read is not None

    def _reset(self, parameters: Any, pose: Pose | None) -> None:
        self.parameters, self.pose = parameters, pose
        self._rays, self._scan, self._drawn = (), (), {}
        self.of_reading, self._sensor_figures, self.figures, self.now, self.lit = (
            None,
            [],
            [],
            [],
            [],
        )
        self.revision += 1

    def _bundle_figures(
        self, draws: str, bundles: dict[int, CastRays], metres: float
    ) -> list[Figure]:
        """Return the figures of ray bundles; make the figure of a bundle anew if its hits changed.

        A bundle is a set of rays that the sensor casts together.

        `draws` is the name of the attribute of `Appearance` that draws a bundle. `bundles` has the
        hits by number of the bundle.
        """
        found = []
        for number, cast in bundles.items():
            known = self._drawn.get((draws, number))
            if known is None or known[0] is not cast:
                drawn = getattr(self.appearance, draws)(self, number, cast, metres)
                known = self._drawn[draws, number] = cast, drawn
            if known[1] is not None:
                found.append(known[1])
        return found


class SensorRow(NamedTuple):
    """A sensor that a view shows, its reading, and whether the sensor is selected."""

    seen: DrawnSensor
    shown: ReadingText
    selected: bool


class DrawnSensors:
    """The drawn sensors of a scene.

    Attributes
    ----------
    frame
        The frame of the figures.
    outdated
        Whether the scene was edited since the figures were made.
    unseen
        Whether some rays were not cast at that frame, so that their figures are missing or old.
    """

    def __init__(self, scene: Any) -> None:
        self.scene_uid = scene.session_uid
        self.unseen = True
        # The time of the last frame change, by time.monotonic.
        self.followed_at = 0.0
        self.frame = NEVER
        self.outdated = True
        self.metres = 1.0
        self.seen: list[DrawnSensor] = []
        # The region that was drawn last, and its rows.
        self.rows: tuple[int, list[SensorRow]] = (0, [])
        # What labels.py and draw.py keep for each region, by the region's address.
        self.boards: dict[int, Any] = {}
        self.joined: dict[int, Any] = {}
        # The uid of the sensor whose sign is below the mouse.
        self.hovered: int | None = None
        # Whether figures were made; without fields of view only the places of the signs are read.
        self.has_fields = False

    def fail(self, scene: Any) -> None:
        """Discard all figures after an error, and draw nothing until the next edit."""
        self.seen, self.boards, self.joined = [], {}, {}
        self.frame, self.outdated, self.unseen = scene.frame_current, False, False
        self.has_fields = True

    def follow(self, scene: Any, view_layer: Any, depsgraph: Any) -> None:
        """Update all figures to the evaluated scene; call it after the sensors have sensed."""
        live = live_of(scene)
        edited = self.outdated
        self.frame, self.outdated = scene.frame_current, False
        self.metres = unit_scale(scene)
        if edited:
            self._list_sensors(view_layer)
        fields = self.has_fields = bool(scene.angen_overlay.fields)
        # An edit may have moved sensors before the playhead moved. `places_are_kept` says if not.
        kept = live.places_are_kept(scene) and not edited
        for seen in self.seen:
            runner = live.runner(seen.uid)
            if not kept or runner is None or seen.matrix is None or not runner.reader.steady:
                seen.place(depsgraph)
            if fields:
                seen.follow(runner, depsgraph, live.edits, self.metres)

    def _list_sensors(self, view_layer: Any) -> None:
        """List the sensors anew; sensors that were listed before keep their figures."""
        known = {seen.uid: seen for seen in self.seen}
        self.seen = []
        for sensor in all_sensors(view_layer):
            before = known.get(sensor.uid)
            seen = DrawnSensor(sensor)
            if before is not None and before.sensor.kind is sensor.kind:
                seen = before
                seen.sensor = sensor
            self.seen.append(seen)
