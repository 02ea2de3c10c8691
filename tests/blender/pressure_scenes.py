# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes of rigid bodies and of animated people on pads, and the readings of the pads."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

G = 9.81
Vector = Sequence[float]
# A part of a mesh: half its size, and its centre, both (x, y, z).
Part = tuple[Vector, Vector]
FACES = np.array(
    [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
)
CORNERS = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
NOT_YET = "three frames in a row are not known"
LEGS = [(-0.5, -0.3), (0.5, -0.3), (-0.5, 0.3), (0.5, 0.3)]


class Readings:
    """The readings of one pad in a run by frame, each field an array."""

    def __init__(self, track: Any) -> None:
        self.frames = np.array(track.frames)
        self.times = np.array(track.times)
        self.force = np.array(track.columns["force_n"])
        self.valid = np.array(track.columns["valid"], bool)
        self.residual = np.array(track.columns["residual"])
        self.partners = list(track.columns["partners"])
        self.problem = list(track.columns["problem"])
        self.cop = np.column_stack([track.columns["cop_x_m"], track.columns["cop_y_m"]])
        self.adc = np.array(track.columns["adc"])

    @property
    def problems(self) -> set[str]:
        """Return the reasons why readings were not valid, without that of the first."""
        return set(self.problem) - {"", NOT_YET}

    def known(self, after: int = 1) -> np.ndarray:
        """Return the forces after a frame, and assert that all of them are valid."""
        late = self.frames > after
        assert late.any()
        assert self.valid[late].all(), (self.problems, self.frames[~self.valid].tolist())
        assert not any(np.array(self.problem)[late])
        return self.force[late]

    def never_valid(self, *words: str, after: int = 1) -> None:
        """Assert that every reading after a frame is invalid, for a reason with these words."""
        late = self.frames > after
        assert not self.valid[late].any(), self.frames[late & self.valid].tolist()
        for reason in np.array(self.problem)[late].tolist():
            assert reason
            for word in words:
                assert word in reason


class Physics:
    """A scene with a rigid-body world. Boxes are given by half their size, in units."""

    def __init__(self, world: Any) -> None:
        self.world = world
        self.bpy = world.bpy
        self.frames(30)

    @property
    def scene(self) -> Any:
        return self.bpy.context.scene

    @property
    def rigid(self) -> Any:
        """Return the rigid-body world, made at its first use."""
        if self.scene.rigidbody_world is None:
            self.bpy.ops.rigidbody.world_add()
            self.scene.rigidbody_world.point_cache.frame_end = 1000
        return self.scene.rigidbody_world

    def frames(self, last: int, fps: int = 24) -> None:
        self.scene.frame_start, self.scene.frame_end = 1, last
        self.scene.render.fps = fps

    def on_floor(self, last: int, fps: int = 24) -> None:
        """Set the number of frames, and add a floor at height 0."""
        self.frames(last, fps)
        self.floor()

    # Meshes

    def mesh(self, parts: Iterable[Part], name: str = "mesh") -> Any:
        points, faces = [], []
        for half, middle in parts:
            faces += (FACES + len(points)).tolist()
            points += (CORNERS * half + middle).tolist()
        mesh = self.bpy.data.meshes.new(name)
        mesh.from_pydata(points, [], faces)
        mesh.update()
        return mesh

    def solid(
        self,
        name: str,
        half: Vector,
        at: Vector = (0, 0, 0),
        parts: Iterable[Part] | None = None,
        parent: Any = None,
        **place: Any,
    ) -> Any:
        """Add a box, or boxes, without physics; `place`: scale, rotation_euler."""
        mesh = self.mesh(parts if parts is not None else [(half, (0, 0, 0))], name)
        obj = self.world.link(name, mesh, at)
        obj.parent = parent
        for key, value in place.items():
            setattr(obj, key, value)
        return obj

    # Rigid bodies

    def rigid_body(self, obj: Any, kind: str = "ACTIVE", **settings: Any) -> Any:
        """Make an object a rigid body; `shape` is its collision shape."""
        assert self.rigid
        with self.bpy.context.temp_override(object=obj, active_object=obj, selected_objects=[obj]):
            self.bpy.ops.rigidbody.object_add(type=kind)
        names = {"shape": "collision_shape", "bounce": "restitution"}
        given = {"shape": "BOX", "friction": 0.5, "bounce": 0.0, **settings}
        for key, value in given.items():
            setattr(obj.rigid_body, names.get(key, key), value)
        return obj

    def body(
        self, name: str, half: Vector, at: Vector, mass: float, place: Any = None, **settings: Any
    ) -> Any:
        """Add a simulated box."""
        obj = self.solid(name, half, at, **(place or {}))
        return self.rigid_body(obj, mass=mass, **settings)

    def round(self, kind: str, at: Vector, radius: float = 0.1, half_height: float = 0.1) -> Any:
        """Return the mesh of a round shape, along z."""
        ops = self.bpy.ops.mesh
        if kind == "SPHERE":
            ops.primitive_uv_sphere_add(radius=radius, location=at)
        elif kind == "CONE":
            ops.primitive_cone_add(radius1=radius, depth=2 * half_height, location=at)
        else:
            ops.primitive_cylinder_add(radius=radius, depth=2 * half_height, location=at)
        obj = self.bpy.context.object
        obj.name = kind.lower()
        return obj

    def compound(
        self, name: str, parts: Sequence[Part], at: Vector, mass: float, **settings: Any
    ) -> Any:
        """Add a simulated compound of boxes; its children are separate objects."""
        obj = self.solid(name, (), at, parts=parts)
        self.rigid_body(obj, mass=mass, shape="COMPOUND", **settings)
        for number, (half, middle) in enumerate(parts):
            child = self.solid(f"{name} {number}", half, middle, parent=obj)
            self.rigid_body(child, shape="BOX", **settings)
        return obj

    def floor(self, height: float = 0.0, **settings: Any) -> Any:
        floor = self.solid("floor", (5, 5, 0.5), (0, 0, height - 0.5))
        return self.rigid_body(floor, "PASSIVE", **settings)

    def pad(
        self,
        name: str = "pad",
        half: Vector = (0.15, 0.15, 0.005),
        at: Vector | None = None,
        kind: str | None = None,
        place: Any = None,
        body: Any = None,
        **settings: Any,
    ) -> Any:
        """Add a pad that senses at every frame, virtual unless `kind` makes it a rigid body."""
        obj = self.solid(name, half, (0, 0, half[2]) if at is None else at, **(place or {}))
        if kind is not None:
            self.rigid_body(obj, kind, **(body or {}))
        return self.sense(obj, **settings)

    def sense(self, obj: Any, **settings: Any) -> Any:
        rate = float(self.scene.render.fps)
        return self.world.sensor("PRESSURE", obj.name, obj, **{"update_rate": rate, **settings})

    def table(self, load: tuple[float, float] | None, mass: float = 20.0, heavy: float = 10.0):
        """Add a table on four pads, and a box on it at (x, y); return the names of the pads."""
        leg, top = 0.35, 0.025
        feet = [((0.025, 0.025, leg), (x, y, -top - leg)) for x, y in LEGS]
        self.floor()
        names = [f"leg {number}" for number in range(4)]
        for name, (x, y) in zip(names, LEGS, strict=True):
            self.pad(name, (0.05, 0.05, 0.005), (x, y, 0.005), "PASSIVE")
        height = 0.01 + 2 * leg + top
        self.compound("table", [((0.6, 0.4, top), (0, 0, 0)), *feet], (0, 0, height), mass)
        if load is not None:
            self.body("load", (0.05, 0.05, 0.05), (*load, height + top + 0.05), heavy)
        return names

    def carried(
        self, name: str, half: Vector, at: Vector, mass: float, tolerance: float = 0.03, **more: Any
    ) -> Any:
        """Add an animated, not simulated, body with a mass."""
        obj = self.solid(name, half, at, **more)
        obj.angen_load.mass, obj.angen_load.tolerance = mass, tolerance
        return obj

    def place_of(self, obj: Any) -> np.ndarray:
        """Return the location of an object, simulated or not, at the present frame."""
        evaluated = obj.evaluated_get(self.bpy.context.evaluated_depsgraph_get())
        return np.array(evaluated.matrix_world.translation)

    # Sensing

    def run(self, first: int | None = None, last: int | None = None) -> dict[str, Readings]:
        recording = self.world.run(first, last)
        return {name: Readings(track) for name, track in recording.tracks.items()}

    def read(self, name: str = "pad") -> Readings:
        """Run the scene, and return the readings of one pad."""
        return self.run()[name]

    def live(self, name: str, frames: Iterable[int]) -> list[tuple[int, float, str]]:
        """Return frame, force and problem of the live readings at these frames."""
        shown = []
        for frame in frames:
            self.scene.frame_set(frame)
            settings = self.bpy.data.objects[name].angen_sensor
            shown.append((frame, settings.value, live_problem(name)))
        return shown


def live_problem(name: str) -> str:
    """Return why the live reading of a sensor is not valid; "" if it is."""
    from bl_ext.user_default.angen_sensors.angen_addon.runtime.live import known_live

    live = known_live()
    return str(live.problems.get(name, "")) if live else "no live sensing"


def shares(
    load: tuple[float, float], weight: float, legs: Sequence[tuple[float, float]] = LEGS
) -> np.ndarray:
    """Return the forces p + q·x + r·y of equal legs on an elastic foundation under a weight."""
    legs = np.array(legs)
    count, (x, y) = len(legs), np.array(load)
    return weight * (
        1.0 / count
        + x * legs[:, 0] / (legs[:, 0] ** 2).sum()
        + y * legs[:, 1] / (legs[:, 1] ** 2).sum()
    )
