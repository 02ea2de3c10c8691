# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene for presence radars, without Blender: bodies as cylinders and balls, and thin walls."""

import math
from dataclasses import dataclass, field, replace

import numpy as np
from angen_sensors.sensor_logic.kinds.presence_radar.parameters import RadarParameters
from angen_sensors.sensor_logic.kinds.presence_radar.radar import PresenceRadar
from angen_sensors.sensor_logic.model import FIRST, Answers, Pose, Updates
from angen_sensors.sensor_logic.noise import generator
from angen_sensors.sensor_logic.radio.echoes import ECHOES, Echoes
from angen_sensors.sensor_logic.radio.substances import attenuation, reflectance

# A radar at the origin that looks along +Y; +X is to its right, +Z up.
POSE = Pose(np.zeros(3), np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]))


@dataclass(frozen=True)
class Ball:
    """A ball around a moving point: the nearest surface is at the distance minus its radius."""

    centre: tuple[float, float, float]
    radius: float = 0.2
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    breathing: float = 0.0
    substance: str = "BODY"

    def at(self, time):
        return np.array(self.centre) + np.array(self.velocity) * time

    def ranges(self, time, ways):
        centre = self.at(time)
        along = ways @ centre
        inside = along**2 - centre @ centre + self.radius**2
        near = along - np.sqrt(np.maximum(inside, 0.0))
        return np.where((inside > 0.0) & (near > 0.0), near, np.inf)


@dataclass(frozen=True)
class Person(Ball):
    """A standing person as an upright cylinder of 1.7 m, from 0.85 m below the radar upwards."""

    half: float = 0.85

    def ranges(self, time, ways):
        centre = self.at(time)
        flat = (ways[:, :2] ** 2).sum(axis=1)
        along = ways[:, :2] @ centre[:2]
        inside = along**2 - flat * (centre[:2] @ centre[:2] - self.radius**2)
        near = (along - np.sqrt(np.maximum(inside, 0.0))) / np.maximum(flat, 1e-12)
        height = near * ways[:, 2] - centre[2]
        seen = (inside > 0.0) & (near > 0.0) & (np.abs(height) <= self.half)
        return np.where(seen, near, np.inf)


@dataclass(frozen=True)
class Wall:
    """An endless wall across +Y at `distance`, which waves pass or not."""

    distance: float
    substance: str = "PLASTERBOARD"
    thickness: float = 0.025
    stops: bool = False


@dataclass
class Scene:
    """Bodies and walls, and the answers to a radar's queries."""

    bodies: list = field(default_factory=list)
    walls: list = field(default_factory=list)
    time: float = 0.0
    asked: float | None = None

    def answer(self, bundle, origins, ways, length, frequency, integration_time):
        moves = self.asked is not None and self.time > self.asked
        self.asked = self.time
        n = len(ways)
        ranges, solid = length.copy(), np.zeros(n, np.intp)
        share, speed, breathing, loss = (np.zeros(n) for _ in range(4))
        for number, body in enumerate(self.bodies, 1):
            at = body.ranges(self.time, ways)
            hit = at < ranges
            ranges[hit], solid[hit] = at[hit], number
            share[hit] = reflectance(body.substance, frequency)
            speed[hit] = (ways[hit] @ np.array(body.velocity)) * moves
            breathing[hit] = body.breathing
        for wall in self.walls:
            with np.errstate(divide="ignore"):
                at = np.where(ways[:, 1] > 0.0, wall.distance / ways[:, 1], np.inf)
            beyond = at < ranges
            if wall.stops:
                ranges[beyond], solid[beyond] = at[beyond], len(self.bodies) + 1
                share[beyond] = reflectance(wall.substance, frequency)
                speed[beyond] = breathing[beyond] = 0.0
            else:
                loss[beyond] += attenuation(wall.substance, wall.thickness, frequency)
        return Echoes(ranges, speed[None], breathing, breathing * 50.0, loss, share, solid)

    def at(self, time):
        self.time = time
        return self


def run(scene, parameters=None, updates=2, rate=10.0, model=None, first=0, pose=POSE, name="radar"):
    """Return the readings of a radar at successive updates."""
    parameters = parameters or RadarParameters()
    model = model or PresenceRadar()
    found = []
    for number in range(first, first + updates):
        scene.at(number / rate)
        update = Updates(
            np.array([number]),
            np.array([number / rate]),
            np.ones(1, bool),
            pose,
            {ECHOES: lambda *question, indices=None: Answers([scene.answer(*question)], FIRST)},
            lambda block: generator(0, name, block),
            lambda: generator(0, name, 0),
        )
        found.append(model.sense(parameters, update)[0])
    return found


def last(scene, parameters=None, **more):
    """Return the fields of the last of some readings."""
    return run(scene, parameters, **more)[-1].fields


def numbers(text):
    """Return the numbers in a field that joins them by semicolons."""
    return [float(word) for word in text.split(";")] if text else []


def polar(distance, degrees, height=0.0):
    """Return a point at a level distance, `degrees` to the right."""
    angle = math.radians(degrees)
    return distance * math.sin(angle), distance * math.cos(angle), height


def tracker(**values):
    """Return the parameters of a radar with three targets and fine rays."""
    return replace(
        RadarParameters(
            max_targets=3,
            gate_length=0.32,
            moving_thresholds="15",
            still_thresholds="20",
            hold_time=0.0,
            vertical_fov=math.radians(70),
            rays_across=120,
            rays_up=40,
        ),
        **values,
    )
