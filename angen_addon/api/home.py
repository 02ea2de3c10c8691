# SPDX-License-Identifier: GPL-3.0-or-later
"""A blend file with sensors, opened by a script."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, Self

import bpy
import numpy as np
import numpy.typing as npt
from mathutils import Matrix, Vector

from ...sensor_logic.choice import SensorChoice
from ...sensor_logic.kinds import KINDS, NO_KIND
from ...sensor_logic.logs.error import AngenError, InputError, explained
from ...sensor_logic.parameters import former_choice, former_text, specs
from ...sensor_logic.recording.tracks import Recording as Run
from ..authoring.presets import find_preset, new_sensor
from ..layout.apply import Applied, apply_layout
from ..layout.describe import parameters_of
from ..output.output_files import Outputs, check_outputs
from ..output.run_log import about, sensor_facts
from ..process.system import standard_output_silenced
from ..recording.results import RESULTS
from ..recording.stored_recording import stored_run
from ..runtime.simulation import simulate
from ..runtime.time_base import evaluated_depsgraph, outside_scene
from ..scene.home.rooms import fill_room
from ..scene.sensors import (
    Sensor,
    all_sensors,
    check,
    chosen,
    named_block,
    simulated,
    unit_scale,
)
from .recording import Recording

# The open home: Blender holds one file at a time.
_open: Home | None = None
# The attributes of every sensor, besides the parameters of its kind.
COMMON = ("enabled", "update_rate", "room")


class HomeSensor:
    """A sensor of an open home.

    Its parameters are attributes, in SI units and radians, with the limits of the panel:
    `sensor.range_max = 3.0`. Where one is an object, its name can be set.
    """

    _home: Home
    _name: str

    def __init__(self, home: Home, name: str) -> None:
        object.__setattr__(self, "_home", home)
        object.__setattr__(self, "_name", name)

    @property
    def name(self) -> str:
        """The name of the sensor."""
        return self._name

    @property
    def kind(self) -> str:
        """The identifier of the sensor's kind, such as PIR."""
        return self._sensor().kind.identifier

    @property
    def pose(self) -> npt.NDArray[np.float64]:
        """The matrix (4, 4) from the sensor's space to world space.

        It is in metres, at the current frame.
        """
        depsgraph = evaluated_depsgraph()
        matrix = np.array(self._sensor().world_matrix(depsgraph))
        matrix[:3, 3] *= unit_scale(depsgraph.scene)
        return matrix

    @property
    def parameters(self) -> dict[str, Any]:
        """All parameters of the sensor's kind by name."""
        return parameters_of(self._sensor())

    def _sensor(self) -> Sensor:
        (found,) = chosen(self._home.all_sensors(), SensorChoice((self._name,)))
        return found

    def __getattr__(self, name: str) -> Any:
        sensor = self._sensor()
        if name == "room":
            return sensor.room
        if name in COMMON:
            return getattr(sensor.settings, name)
        if name in specs(sensor.kind.parameters):
            return getattr(sensor.parameters, name)
        raise AttributeError(_unknown(sensor, name))

    def __setattr__(self, name: str, value: Any) -> None:
        sensor = self._sensor()
        group = sensor.settings if name in COMMON else sensor.parameters
        if name not in COMMON and name not in specs(sensor.kind.parameters):
            raise AngenError(_unknown(sensor, name))
        before = getattr(group, name)
        spec = specs(sensor.kind.parameters).get(name)
        former = former_choice(spec, value) if spec is not None else None
        if former is not None:
            value = former.now
            warnings.warn(former_text([(sensor.name, name, former)]), stacklevel=2)
        where = f"'{sensor.name}': {name}"
        if spec is not None and spec.pointer and isinstance(value, str):
            with explained(where, InputError, raised=AngenError):
                value = named_block(spec.pointer, value)
        with explained(where, TypeError, ValueError, raised=AngenError):
            try:
                if spec is not None:
                    _check_value(sensor, name, value)
                setattr(group, name, value)
                check(sensor)
            except AngenError:
                setattr(group, name, before)
                raise

    def __repr__(self) -> str:
        return f"<{self.kind} '{self._name}'>"


def _check_value(sensor: Sensor, name: str, value: Any) -> None:
    """Raise AngenError if a value is outside the range of a parameter.

    Without this check, Blender would clamp the value and report nothing.
    """
    if isinstance(value, (bool, int, float)):
        problems = sensor.kind.parameters(**{name: value}).problems()
        problem = next((text for text in problems if text.startswith(f"{name} ")), "")
        if problem:
            raise AngenError(f"'{sensor.name}': {problem}")


def _unknown(sensor: Sensor, name: str) -> str:
    known = (*COMMON, *specs(sensor.kind.parameters))
    return f"'{sensor.name}' has no parameter '{name}'; its parameters are {', '.join(known)}"


class Home:
    """An open blend file; opening another one closes it, because Blender holds one at a time."""

    def __init__(self, path: Path) -> None:
        self.path = path

    @classmethod
    def open(cls, path: Path) -> Self:
        """Return the home in the file at `path`, which Blender has already opened.

        The home that was open before is closed.
        """
        global _open
        _open = found = cls(path)
        return found

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the file without saving it."""
        global _open
        if _open is self:
            bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
            _open = None

    @property
    def sensors(self) -> list[HomeSensor]:
        """All sensors, in the order of their names."""
        return [HomeSensor(self, sensor.name) for sensor in self.all_sensors()]

    def sensor(self, name: str) -> HomeSensor:
        """Return the sensor with this name. Raise AngenError if there is none."""
        found = HomeSensor(self, name)
        found._sensor()
        return found

    def add(
        self,
        kind: str,
        name: str = "",
        at: Sequence[float] = (0.0, 0.0, 0.0),
        look: Sequence[float] | None = None,
        preset: str = "",
    ) -> HomeSensor:
        """Add a sensor, and return it.

        Its room is the room of the home at its position, or empty if there is none there. The room
        can be changed later.

        Parameters
        ----------
        kind, preset
            Identifiers of the kind and of its preset.
        name
            The name of the object; Blender adds a number if another object has the name.
        at
            The position (x, y, z) in metres.
        look
            The direction in which the sensor looks; its +Y points up as far as possible. Without a
            direction the sensor looks down, or a pressure sensor lies flat, face up.

        Raises
        ------
        AngenError
            If an argument is invalid.
        """
        self.all_sensors()
        if kind not in KINDS or kind == NO_KIND:
            raise AngenError(f"kind '{kind}' is unknown: choose one of {', '.join(KINDS)}")
        chosen_preset = find_preset(KINDS[kind], preset) if preset else None
        matrix = _world_matrix(at, look, unit_scale(bpy.context.scene))
        obj = new_sensor(bpy.context, kind, chosen_preset, name)
        obj.matrix_world = matrix
        bpy.context.view_layer.update()
        fill_room(bpy.context.evaluated_depsgraph_get(), obj)
        return HomeSensor(self, obj.name)

    def apply(self, layout: str | Path, remove: bool = False) -> Applied:
        """Add and change sensors to match a layout file.

        If `remove` is True, delete the sensors that are not in the layout. Return the names of the
        sensors added, changed, unchanged and removed. If the layout is wrong, raise AngenError and
        change nothing.
        """
        self.all_sensors()
        return apply_layout(Path(layout), remove)

    def simulate(
        self,
        frames: tuple[int, int] | None = None,
        sensors: Iterable[str] | None = None,
        progress: Callable[[float], object] | None = None,
    ) -> Recording:
        """Simulate a range of frames.

        Parameters
        ----------
        frames
            The first and the last frame; by default the scene's. Frames before the start of the
            scene are left out. Frames after its end are simulated. A warning says so.
        sensors
            Names or patterns such as "PIR*"; by default all sensors. An empty list is an error.
        progress
            A function that is called with the fraction of the work done, 0 to 1. If it raises an
            exception, the run ends.

        Raises
        ------
        AngenError
            If there is nothing to simulate.
        """
        scene = bpy.context.scene
        found = self._chosen(sensors)
        first, last = frames or (scene.frame_start, scene.frame_end)
        if not scene.frame_start <= last or first > last:
            raise AngenError(
                f"the scene has no frames {first} to {last}: it begins at frame {scene.frame_start}"
            )
        if not simulated(found):
            raise AngenError(f"{self.path.name} has no sensors to simulate: add one, or enable one")
        if text := outside_scene(scene, first, last):
            warnings.warn(text, stacklevel=2)
        run = Run()
        for step in simulate(scene, found, max(first, scene.frame_start), last, run):
            if progress is not None:
                progress(min(step.share, 1.0))
        RESULTS.keep_alone(scene, stored_run(run, scene, evaluated_depsgraph()))
        return Recording(run, {s.name: sensor_facts(s) for s in found}, about(scene))

    def save(self, path: str | Path) -> None:
        """Save a copy of the home, with its last recording. Raise AngenError if that fails."""
        self.all_sensors()
        check_outputs({"path": Path(path)})
        # Blender would report the temporary name.
        with standard_output_silenced(), Outputs() as outputs:
            outputs.save_blend(Path(path))
            outputs.commit()

    def _chosen(self, names: Iterable[str] | None) -> list[Sensor]:
        """Return the sensors that match these names or patterns; None for all sensors.

        Raise AngenError if a name matches none, or if there are no names.
        """
        every = self.all_sensors()
        if names is None:
            return every
        patterns = (names,) if isinstance(names, str) else tuple(names)
        if not patterns:
            raise AngenError("sensors is empty: give names or patterns, or None for all sensors")
        return chosen(every, SensorChoice(patterns))

    def _simulated(self, names: Iterable[str] | None) -> list[Sensor]:
        """Return the enabled sensors that match these names or patterns; by default all of them.

        Raise AngenError if there are none.
        """
        found = simulated(self._chosen(names))
        if not found:
            raise AngenError(f"{self.path.name} has no sensors to simulate: add one, or enable one")
        return found

    def all_sensors(self) -> list[Sensor]:
        """Return the sensors of the open file, as the add-on's objects.

        Raise AngenError if this home has been closed.
        """
        if _open is not self:
            raise AngenError(
                f"{self.path.name} is closed: Blender holds one home at a time; open it again"
            )
        return all_sensors(bpy.context.view_layer)


def _world_matrix(at: Sequence[float], look: Sequence[float] | None, metres: float) -> Matrix:
    """Return the world matrix of a new sensor, in Blender units.

    `at` is its position in metres, and `look` the direction in which it looks. `metres` is the
    length of a Blender unit in m. Raise AngenError if `at` or `look` is invalid.
    """
    point = np.asarray(at, float)
    direction = np.array([0.0, 0.0, -1.0]) if look is None else np.asarray(look, float)
    if point.shape != (3,) or not np.isfinite(point).all():
        raise AngenError(f"at={at!r} is not a point: give x, y and z in metres")
    if direction.shape != (3,) or not np.isfinite(direction).all() or not direction.any():
        raise AngenError(f"look={look!r} is not a direction: give x, y and z")
    turned = Vector(direction).to_track_quat("-Z", "Y").to_matrix().to_4x4()
    if look is None:
        turned = Matrix.Identity(4)
    return Matrix.Translation(Vector(point / metres)) @ turned
