# SPDX-License-Identifier: GPL-3.0-or-later
"""Small worlds of known geometry, and fixtures that sense in them."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from importlib import import_module
from typing import Any

import numpy as np
import pytest
from lived_home import angen_day, lived, lived_home  # noqa: F401  (fixtures)
from pressure_scenes import Physics

ADDON = "bl_ext.user_default.angen_sensors"
CUBE = [(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]
CUBE_FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def part(name: str) -> Any:
    """Return a module of the extension, which is importable once the extension is enabled."""
    return import_module(f"{ADDON}.{name}")


def curves_of(obj: Any) -> list[Any]:
    """Return the F-curves of an object, in every version of Blender."""
    data = obj.animation_data
    if data is None or data.action is None:
        return []
    if not hasattr(data, "action_slot"):
        return list(data.action.fcurves)
    bags = [s.channelbag(data.action_slot) for la in data.action.layers for s in la.strips]
    return [curve for bag in bags if bag for curve in bag.fcurves]


def plain_values(group: Any) -> dict[str, str]:
    """Return all plain values of a property group, as texts."""
    return {
        p.identifier: str(getattr(group, p.identifier))
        for p in group.bl_rna.properties
        if p.type in {"BOOLEAN", "INT", "FLOAT", "ENUM", "STRING"}
        and not getattr(p, "is_array", False)
    }


class World:
    """The present scene (24 fps, frames 1 to 48), with methods that add objects and sensors."""

    def __init__(self) -> None:
        import bpy

        self.bpy = bpy
        self.scene.frame_start, self.scene.frame_end = 1, 48
        self.scene.render.fps, self.scene.render.fps_base = 24, 1.0

    @property
    def scene(self) -> Any:
        return self.bpy.context.scene

    # Objects

    def link(self, name: str, data: Any, at: Sequence[float] = (0, 0, 0)) -> Any:
        obj = self.bpy.data.objects.new(name, data)
        obj.location = at
        self.scene.collection.objects.link(obj)
        return obj

    def instance(self, name: str, collection: Any, at: Sequence[float] = (0, 0, 0)) -> Any:
        """Add an empty that instances a collection."""
        obj = self.link(name, None, at)
        obj.instance_type, obj.instance_collection = "COLLECTION", collection
        return obj

    def aside(self, name: str, *objects: Any) -> Any:
        """Move objects of the scene to a collection outside the scene; return the collection."""
        made = self.bpy.data.collections.new(name)
        for obj in objects:
            self.scene.collection.objects.unlink(obj)
            made.objects.link(obj)
        return made

    def rig(self, bone: str, tail: Sequence[float], at: Sequence[float] = (0, 0, 0)) -> Any:
        """Add an armature with one bone, from its origin to `tail`."""
        rig = self.link("rig", self.bpy.data.armatures.new("rig"), at)
        self.bpy.context.view_layer.objects.active = rig
        self.bpy.ops.object.mode_set(mode="EDIT")
        made = rig.data.edit_bones.new(bone)
        made.head, made.tail = (0, 0, 0), tail
        self.bpy.ops.object.mode_set(mode="OBJECT")
        return rig

    def mesh(self, points: Iterable[Any], faces: Iterable[Any], name: str = "mesh") -> Any:
        mesh = self.bpy.data.meshes.new(name)
        mesh.from_pydata(list(points), [], list(faces))
        return mesh

    def box(self, size: Sequence[float], at: Sequence[float] = (0, 0, 0), name: str = "box") -> Any:
        """Add a box whose mesh has the size, in units; its object is not scaled."""
        points = [tuple(c * s for c, s in zip(corner, size, strict=True)) for corner in CUBE]
        return self.link(name, self.mesh(points, CUBE_FACES), at)

    def hall(self, w: float, d: float, h: float, thick: float = 0.2) -> None:
        """Add a room of `w` by `d` by `h` m, its inner corner at the origin, of six boxes."""
        for name, size, at in (
            ("floor", (w + 2 * thick, d + 2 * thick, thick), (w / 2, d / 2, -thick / 2)),
            ("ceiling", (w + 2 * thick, d + 2 * thick, thick), (w / 2, d / 2, h + thick / 2)),
            ("south", (w + 2 * thick, thick, h), (w / 2, -thick / 2, h / 2)),
            ("north", (w + 2 * thick, thick, h), (w / 2, d + thick / 2, h / 2)),
            ("west", (thick, d, h), (-thick / 2, d / 2, h / 2)),
            ("east", (thick, d, h), (w + thick / 2, d / 2, h / 2)),
        ):
            self.box(size, at, name)

    def door(self, *frames: int, open_at: float = 1.0) -> Any:
        """Add a leaf before a switch at the origin: closed at frame 1, open and closed in turn."""
        leaf = self.box((0.1, 0.1, 0.01), at=(0, 0, -0.02), name="door")
        places = {f: (open_at * (i % 2), 0, -0.02) for i, f in enumerate((1, *frames))}
        self.key(leaf, "location", places, "CONSTANT")
        return leaf

    def wall(self, distance: float, name: str = "wall", size: float = 1.0) -> Any:
        """Add a square across the beam of a sensor at the origin, `distance` ahead of it."""
        h = size / 2
        mesh = self.mesh([(-h, -h, 0), (h, -h, 0), (h, h, 0), (-h, h, 0)], [(0, 1, 2, 3)])
        return self.link(name, mesh, (0, 0, -distance))

    def sensor(self, kind: str, name: str, obj: Any = None, **settings: Any) -> Any:
        """Make an empty (or `obj`) a sensor, with settings of the sensor or of its kind."""
        obj = obj or self.link(name, None)
        obj.angen_sensor.kind = kind
        for key, value in settings.items():
            group = obj.angen_sensor
            if not hasattr(group, key):
                group = getattr(group, kind.lower())
            setattr(group, key, value)
        return obj

    def switch(self, name: str = "switch", **settings: Any) -> Any:
        return self.sensor("OPTICAL_SWITCH", name, **{"update_rate": 24.0, **settings})

    def pir(self, name: str = "pir", **settings: Any) -> Any:
        """Add a detector with one tilt that senses at every frame."""
        few = {"update_rate": 24.0, "rays": 9, "vertical_fov": 0.0}
        return self.sensor("PIR", name, **{**few, **settings})

    def key(
        self, obj: Any, path: str, frames: dict[float, Any], interpolation: str = "LINEAR"
    ) -> None:
        """Set keyframes {frame: value} of a property of `obj`."""
        owner_path, _, name = path.rpartition(".")
        owner = obj.path_resolve(owner_path) if owner_path else obj
        for frame, value in frames.items():
            setattr(owner, name, value)
            obj.keyframe_insert(path, frame=frame)
        for curve in curves_of(obj):
            if curve.data_path == path:
                for point in curve.keyframe_points:
                    point.interpolation = interpolation

    @staticmethod
    def warm(owner: Any, celsius: float, emissivity: float = 0.95) -> None:
        """Give an object, a collection or a material a temperature."""
        warmth = owner.angen_warmth
        warmth.use_temperature, warmth.temperature, warmth.emissivity = True, celsius, emissivity

    def update(self) -> Any:
        self.bpy.context.view_layer.update()
        return self.bpy.context.evaluated_depsgraph_get()

    # Files

    def save_library(self, path: Any, collection: Any) -> Any:
        """Save a file whose scene has the collection, and open an empty one."""
        self.scene.collection.children.link(collection)
        self.bpy.ops.wm.save_as_mainfile(filepath=str(path))
        self.bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        return path

    def bring(self, path: Any, link: bool = True) -> Any:
        """Link or append the only collection of a file into the scene."""
        with self.bpy.data.libraries.load(str(path), link=link) as (source, target):
            target.collections = list(source.collections)
        (collection,) = target.collections
        self.scene.collection.children.link(collection)
        self.update()
        return collection

    def override(self, collection: Any) -> Any:
        """Replace a linked collection by a library override."""
        layer = self.bpy.context.view_layer
        made = collection.override_hierarchy_create(self.scene, layer, do_fully_editable=True)
        if collection.name in self.scene.collection.children:
            self.scene.collection.children.unlink(collection)
        self.update()
        return made

    def state(self) -> dict[str, Any]:
        """Return all data of the file and session that a run or a measurement must not change."""
        scene, layer, bpy = self.scene, self.bpy.context.view_layer, self.bpy
        groups = (
            scene, scene.render, scene.unit_settings, scene.cycles, scene.render.bake,
            scene.render.image_settings, scene.view_settings, layer,
        )  # fmt: skip
        active, handlers = layer.objects.active, bpy.app.handlers
        lists = {name: getattr(handlers, name) for name in dir(handlers)}
        data = {name: getattr(bpy.data, name) for name in dir(bpy.data)}
        counted = bpy.types.bpy_prop_collection
        return {
            "frame": (scene.frame_current, scene.frame_subframe),
            "settings": [plain_values(group) for group in groups],
            "world": scene.world and plain_values(scene.world.cycles),
            "selection": sorted(o.name for o in layer.objects if o.select_get()),
            "active": active and active.name,
            "mode": bpy.context.mode,
            "hidden": [
                (o.name, o.hide_get(), o.hide_viewport, o.hide_render) for o in layer.objects
            ],
            "places": {o.name: [list(row) for row in o.matrix_world] for o in layer.objects},
            "data": {
                name: len(found) for name, found in data.items() if isinstance(found, counted)
            },
            "handlers": {n: [str(f) for f in one] for n, one in lists.items() if type(one) is list},
            "files": sorted(os.listdir(tempfile.gettempdir())),
        }

    # Sensing

    def sensors(self) -> list[Any]:
        self.bpy.context.view_layer.update()
        return part("angen_addon.scene.sensors").all_sensors(self.bpy.context.view_layer)

    def run(self, first: int | None = None, last: int | None = None) -> Any:
        """Return the recording of a run over the scene's frames."""
        recording = part("sensor_logic.recording.tracks").Recording()
        scene = self.scene
        first = scene.frame_start if first is None else first
        last = scene.frame_end if last is None else last
        simulate = part("angen_addon.runtime.simulation").simulate
        run = simulate(scene, self.sensors(), first, last, recording)
        for _ in run:
            pass
        return recording

    def series(self, recording: Any, name: str, column: str) -> list[Any]:
        return list(recording.tracks[name].columns[column])

    def log(self, recording: Any) -> list[list[str]]:
        """Return the rows of the event log, without the header."""
        text = part("sensor_logic.recording.events").events_csv(recording)
        return [line.split(",") for line in text.splitlines()[1:]]

    def rays(self, obj: Any, number: int = 0) -> tuple[Any, Any, Any]:
        """Return the rays of one update by the sensor's own runner.

        They are origins (n, 3) and directions (n, 3) in world space, and the free distance ahead of
        each (n,), in metres.
        """
        depsgraph = self.update()
        probes = part("angen_addon.runtime.probes").Probes(self.scene)
        probes.look(depsgraph)
        probes.caster = spy = Spy(probes.caster)
        sensor = next(s for s in self.sensors() if s.object == obj)
        clock = part("angen_addon.runtime.time_base").clock_of(self.scene)
        runner = part("angen_addon.runtime.sensor_runner").SensorRunner(sensor, clock)
        part("angen_addon.runtime.sensor_runner").single_update(runner, number, 0, probes).reading()
        metres = part("angen_addon.scene.sensors").unit_scale(self.scene)
        return spy.origins * metres, spy.directions, spy.ranges * metres

    def range(self, obj: Any) -> float:
        """Return the range that a switch's single ray reads."""
        _, _, ranges = self.rays(obj)
        return float(ranges[0]) + obj.angen_sensor.optical_switch.range_min


class Spy:
    """A caster that records its queries and answers."""

    def __init__(self, caster: Any) -> None:
        self._caster = caster

    def cast_at(self, sensor: Any, bundle: int, rays: Any, frames: Any) -> Any:
        self.origins, self.directions = (np.array(part) for part in rays[:2])
        answers = self._caster.cast_at(sensor, bundle, rays, frames)
        self.ranges = answers[0]
        return answers


@pytest.fixture
def frame_by_frame(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make runs sense and report each frame at once."""
    monkeypatch.setattr(part("angen_addon.scene.capture"), "MOST_FRAMES", 1)


@pytest.fixture
def world(empty_scene: None) -> World:
    return World()


@pytest.fixture
def swept(world: World) -> Callable[..., Any]:
    """Add a switch at the origin, swept by default."""

    def make(name: str = "switch", **settings: Any) -> Any:
        settings = {"threshold": 0.3, "swept": True, **settings}
        return world.switch(name, **settings)

    return make


@pytest.fixture
def physics(world: World) -> Physics:
    """Return the empty scene, for pads and loads."""
    return Physics(world)


@pytest.fixture(params=["FAST", "SCENE"])
def each_caster(request: pytest.FixtureRequest, world: World) -> str:
    """Run the test with each of both ray casters."""
    world.scene.angen_ray_caster = request.param
    return str(request.param)


@pytest.fixture
def command(capsys: pytest.CaptureFixture[str]) -> Callable[..., tuple[int, str, str]]:
    """Run the command on the open file, in this process: its status, standard output and error."""

    def run(*arguments: Any) -> tuple[int, str, str]:
        capsys.readouterr()
        status = part("angen_addon.commands.command_line").run_command(list(map(str, arguments)))
        return status, *capsys.readouterr()

    return run


@pytest.fixture
def addon_part() -> Callable[[str], Any]:
    return part


@pytest.fixture
def fcurves() -> Callable[[Any], list[Any]]:
    return curves_of


@pytest.fixture
def echoes(world: World, monkeypatch: pytest.MonkeyPatch) -> dict[tuple[str, int], Any]:
    """Return the `Echoes` of radars from now on, by the name and the step of each update."""
    answers_of = part("angen_addon.runtime.sensor_runner").ANSWERS
    need = part("sensor_logic.radio.echoes").ECHOES
    found: dict[tuple[str, int], Any] = {}
    answer = answers_of[need]

    def spied(query: Any, *question: Any, indices: Any = None) -> Any:
        answers = answer(query, *question, indices=indices)
        for i, step in enumerate(query.steps):
            found[query.sensor.name, step] = answers[i]
        return answers

    monkeypatch.setitem(answers_of, need, spied)
    return found


@pytest.fixture
def field(world: World) -> Iterator[Callable[..., Any]]:
    """Follow the scene to a frame, and return the signs drawn of its sensors.

    With a frame it follows as in playback, without one as with the playhead at rest.
    """
    refresh = part("angen_addon.view.overlay.refresh")
    live_of = part("angen_addon.runtime.live").live_of
    sensors = part("angen_addon.view.overlay.picture")
    made = refresh.overlay = sensors.DrawnSensors(world.scene)

    def follow(frame: float | None = None, publish: bool = True) -> Any:
        scene, layer = world.scene, world.bpy.context.view_layer
        world.update()
        if frame is None:
            live_of(scene).look_around(scene, layer, layer.depsgraph)
        else:
            world.scene.frame_set(frame)
            if not publish:
                live_of(scene).follow(scene, layer, layer.depsgraph, publish)
        made.follow(scene, layer, layer.depsgraph)
        return made

    yield follow
    refresh.discard()
