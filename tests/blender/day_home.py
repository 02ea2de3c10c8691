# SPDX-License-Identifier: GPL-3.0-or-later
"""A home for days: a room, a box as the person, a door, lamps, and a day acted by hand.

Its keys are one per frame.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from importlib import import_module
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np

ADDON = "bl_ext.user_default.angen_sensors"
FPS = 10


def part(name: str) -> Any:
    return import_module(f"{ADDON}.{name}")


@dataclass
class Pelvis:
    """The part of a pose that the truth reads; the feet are where the hips are."""

    pelvis: Any

    @property
    def feet(self) -> Any:
        return SimpleNamespace(ankle=self.pelvis[:, None])


@dataclass
class Walks:
    """A body that goes from place to place, each walk from a time on and of so many seconds."""

    starts: Any
    lasts: Any
    points: Any

    def moving(self) -> Any:
        return np.column_stack([self.starts, self.starts + self.lasts])

    def away(self) -> Any:
        return np.zeros((0, 2))

    def poses(self, times: Any) -> Pelvis:
        knots = self.moving().ravel()
        last = len(self.starts) - 1
        rows = np.repeat(self.points, [1, *[2] * last, 1], axis=0)
        return Pelvis(np.column_stack([np.interp(times, knots, rows[:, k]) for k in range(3)]))


@dataclass
class BoxKeys:
    """Writes the keys of a stretch, in place of the extension's keys for bodies with bones."""

    shown: list[tuple[float, float]] = field(default_factory=list)

    def show(self, acted: Any, first: float, last: float) -> None:
        import bpy

        self.shown.append((first, last))
        spans = acted.spans(first, last)
        ends = [first, last, *(spans.ravel() if len(spans) else ())]
        frames = {1 + round(FPS * end) + d for end in ends for d in (-1, 0, 1)}
        for start, end in spans.tolist():
            frames.update(range(1 + round(FPS * start) - 1, 1 + round(FPS * end) + 2))
        every = np.array(sorted(frames))
        times = (every - 1) / FPS
        for person, body in acted.bodies.items():
            at = body.poses(times).pelvis
            self._key(bpy.data.objects[person], "location", every, at)
        for name, swings in acted.swings.items():
            knots = np.array([(s.start, s.end) for s in swings]).ravel()
            yaws = np.array([(s.before, s.after) for s in swings]).ravel()
            yaw = np.interp(times, knots, yaws)[:, None]
            self._key(bpy.data.objects[name], "rotation_euler", every, yaw, 2)
        lit: dict[str, list[Any]] = {}
        for switch in acted.switches:
            lit.setdefault(switch.object, []).append(switch)
        for name, switches in lit.items():
            on = np.zeros(len(times))
            for switch in switches:
                on[times >= switch.time - 1e-6] = 40.0 * switch.on
            self._key(bpy.data.objects[name].data, "energy", every, on[:, None], -1)

    @staticmethod
    def _key(owner: Any, path: str, frames: Any, values: Any, index: int = 0) -> None:
        """Replace all keys of a path by linear ones, values (n, k)."""
        import bpy

        owner.animation_data_clear()
        action = bpy.data.actions.new("day")
        data = owner.animation_data_create()
        data.action = action
        curves = getattr(action, "fcurves", None)
        if hasattr(action, "slots"):
            slot = action.slots.new(owner.id_type, owner.name)
            strip = action.layers.new("day").strips.new(type="KEYFRAME")
            curves = strip.channelbag(slot, ensure=True).fcurves
            data.action_slot = slot
        for column in range(values.shape[1]):
            where = {"index": index + column} if index >= 0 else {}
            points = curves.new(path, **where).keyframe_points
            points.add(len(frames))
            both = np.column_stack([frames, values[:, column]])
            points.foreach_set("co", both.astype(np.float32).ravel())
            points.foreach_set("interpolation", np.ones(len(frames), np.int32))


def build(world: Any) -> None:
    """Add the room, the residents, and sensors of all kinds."""
    world.scene.render.fps = 24
    walls = [
        ((6, 4, 0.1), (0, 0, -0.05)),
        ((6, 0.1, 2.5), (0, 2, 1.25)),
        ((6, 0.1, 2.5), (0, -2, 1.25)),
        ((0.1, 4, 2.5), (-3, 0, 1.25)),
        ((0.1, 4, 2.5), (3, 0, 1.25)),
    ]
    for number, (size, at) in enumerate(walls):
        world.box(size, at, f"wall {number}")
    body = world.box((0.4, 0.3, 1.7), (0, 0, 0.85), "anna")
    body.angen_load.mass = 70.0
    body.angen_warmth.use_temperature, body.angen_warmth.temperature = True, 34.0
    world.box((0.04, 0.8, 2.0), (2.0, 1.0, 1.0), "door")
    for name, x in (("lamp", 0.5), ("lamp 2", -1.5)):
        world.link(name, world.bpy.data.lights.new(name, "POINT"), (x, 0.0, 2.4))
    scan = world.pir("scan", update_rate=10.0, rays=31)
    scan.location, scan.rotation_euler = (-2.9, 0, 1), (1.5708, 0, -1.5708)
    sweep = world.pir("sweep", update_rate=10.0, rays=31, vertical_fov=1.0, noise_sigma=0.004)
    sweep.location, sweep.rotation_euler = (2.9, 0, 1.4), (1.5708, 0, 1.5708)
    warm = world.pir("warm", update_rate=10.0, model="PYROELECTRIC", warm_up_time=30.0)
    warm.location, warm.rotation_euler = (-2.9, 0.5, 1), (1.5708, 0, -1.5708)
    world.switch("switch", update_rate=1.0, range_max=1.0, threshold=0.6).location = (2, 1.3, 2.3)
    pad = world.box((1.2, 1.2, 0.1), (0.4, 0, -0.05), "pad")
    world.sensor("PRESSURE", "pad", pad, update_rate=1.0)
    lux = world.sensor("LIGHT", "lux", update_rate=1.0, method="ILLUMINANCE", samples=16)
    lux.location, lux.rotation_euler = (0.4, 1.2, 0.5), (3.14159, 0, 0)
    for obj in (scan, sweep, warm, lux):
        obj.angen_sensor.room = "room"
    for number in range(24):
        world.box((0.1, 0.1, 0.1), (number % 6 - 2.5, -1.8, number // 6 * 0.2 + 0.1), "thing")


def acted(seed: int, ways: int = 12, day: float = 86_400.0) -> Any:
    """Return what anna does on a day: walks between random points, the door, the lamps."""
    module = part("residents.acting.timeline")
    random = np.random.default_rng(seed)
    starts = np.sort(random.choice(np.arange(40, int(day) - 40, 20), ways, replace=False)) * 1.0
    points = np.column_stack([random.uniform(low, high, ways + 1) for low, high in
                              ((-1.2, 1.4), (-1.0, 0.8), (0.85, 0.85))])  # fmt: skip
    lasts = np.round(random.uniform(1.0, 4.0, ways), 1)
    body = Walks(starts, lasts, points)
    yaw, swings = 0.0, []
    for start in starts[::3].tolist():
        after = float(random.choice([0.0, -0.6, 0.5]))
        swings.append(module.LeafSwing(start, start + 1.5, yaw, after, "anna"))
        yaw = after
    names = [("lamp", "lamp 2")[n % 2] for n in range(len(starts[1::2]))]
    switches = [module.Switch(-200.0, name, False, "") for name in ("lamp", "lamp 2")]
    switches += [module.Switch(start + 0.5, name, bool(random.integers(2)), "anna")
                 for start, name in zip(starts[1::2].tolist(), names, strict=True)]  # fmt: skip
    ends = [*starts.tolist(), day]
    done = [module.ActedActivity(0.0, starts[0], "anna", "Rest", "chair")]
    done += [module.ActedActivity(a, b, "anna", f"Go {n % 3}", "chair")
             for n, (a, b) in enumerate(pairwise(ends))]  # fmt: skip
    stays, now = [], -200.0
    for start, last in zip(starts.tolist(), lasts.tolist(), strict=True):
        stays.append(module.Stay(now, start, "anna", "chair", module.STANDING))
        stays.append(module.Stay(start, start + last, "anna", "", module.WALKING))
        now = start + last
    stays.append(module.Stay(now, day + 200.0, "anna", "chair", module.STANDING))
    return module.Acted({"anna": body}, {"door": swings}, switches, {}, done, stays)
