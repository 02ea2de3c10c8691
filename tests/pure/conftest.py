# SPDX-License-Identifier: GPL-3.0-or-later
"""A stage for the sensor models, without Blender: a test gives what the sensors sense."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest
from angen_sensors.sensor_logic.kind import RAYS
from angen_sensors.sensor_logic.model import Array, Pose, Reading, Update
from angen_sensors.sensor_logic.noise import generator

AHEAD = Pose(np.zeros(3), np.eye(3))


def flat_world(distance: float) -> Callable[..., Array]:
    """Return a caster with a surface `distance` metres from the sensor along every ray."""

    def cast(bundle: int, origins: Array, directions: Array, length: Array) -> Array:
        travelled = np.linalg.norm(origins, axis=1)
        return np.clip(distance - travelled, 0.0, length)

    return cast


class Stage:
    """Runs a model through updates; each world is a caster, or a distance in metres."""

    def __init__(self) -> None:
        self.rate = 10.0
        self.seed = 0
        self.sensor = "sensor"

    def run(self, model: Any, parameters: Any, worlds: Sequence[Any]) -> list[Reading]:
        readings = []
        for number, world in enumerate(worlds):
            cast = world if callable(world) else flat_world(float(world))
            readings.append(model.update(parameters, self.update(number, cast)))
        return readings

    def update(self, number: int, cast: Any) -> Update:
        time = number / self.rate
        return Update(number, time, AHEAD, {RAYS: cast}, self.noise(number), self.noise(0))

    def noise(self, number: int) -> Callable[[], np.random.Generator]:
        return lambda: generator(self.seed, self.sensor, number)


@pytest.fixture
def angen(capfd: pytest.CaptureFixture[str]) -> Callable[..., tuple[int, str, str]]:
    """Run `python -m angen_addon ARGUMENTS` for a verb without Blender, in this process.

    Returns its status, standard output and error.
    """

    def run(*arguments: object) -> tuple[int, str, str]:
        from angen_sensors.angen_addon.__main__ import main

        capfd.readouterr()
        try:
            status = main([str(argument) for argument in arguments])
        except SystemExit as stop:
            status = int(stop.code or 0)
        return status, *capfd.readouterr()

    return run


@pytest.fixture
def stage() -> Stage:
    return Stage()
