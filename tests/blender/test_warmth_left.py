# SPDX-License-Identifier: GPL-3.0-or-later
"""Warmth that bodies leave in seats and beds: what an infrared array sees after they went."""

import bpy
import numpy as np
import pytest

ROOM, SKIN = 21.0, 33.5
FPS = 2


@pytest.fixture
def room(world):
    """An array 2 m above the seat of a stool, in a room of 21 °C, at two frames a second."""
    world.scene.angen_ambient_temperature = ROOM
    world.scene.render.fps = FPS
    world.box((0.5, 0.5, 0.4), (0, 0, -2.2), "Stool")
    world.box((9, 9, 0.1), (0, 0, -2.5), "Floor")
    world.sensor(
        "THERMAL_ARRAY", "array", update_rate=FPS, hold_time=0.0, rays=20, min_pixels=1, threshold=2
    )
    return world


def sitter(world, name="Sitter", seconds=60.0, celsius=SKIN):
    """Add a body that sits on the stool for some seconds, and then stands far away."""
    body = world.box((0.4, 0.4, 0.3), (0, 0, -1.85), name)
    body.angen_load.mass = 70.0
    body.angen_warmth.use_temperature, body.angen_warmth.temperature = True, celsius
    leaves = 1 + round(seconds * FPS)
    world.key(body, "location", {1: (0, 0, -1.85), leaves: (30, 0, -1.85)}, "CONSTANT")
    return leaves


def highest(world, recording, name="array"):
    return np.array(world.series(recording, name, "max_c"), float)


def minutes_occupied(world, seconds):
    leaves = sitter(world, seconds=seconds)
    recording = world.run(1, leaves + 20 * 60 * FPS)
    occupied = np.array(world.series(recording, "array", "occupied"))[leaves - 1 :]
    return np.count_nonzero(occupied) / FPS / 60.0


def test_a_long_stay_leaves_minutes_of_warmth(room):
    found = minutes_occupied(room, 3600.0)
    assert 3.0 < found < 12.0


def test_a_short_stay_leaves_seconds(room):
    assert 0.0 < minutes_occupied(room, 20.0) < 0.5
