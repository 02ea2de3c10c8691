# SPDX-License-Identifier: GPL-3.0-or-later
"""Each sensor of light.blend reads its closed form, computed here from the file's own objects."""

import math
from pathlib import Path

import bpy
import numpy as np
import pytest
from light_stage import measure, part

SAMPLE = Path(__file__).resolve().parents[2] / "sample_blends" / "light.blend"
# The face stands this far ahead of its sensor.
AHEAD = 1e-3
NAMES = ("point", "spot", "area", "glowing plate", "ball", "sun and sky")


@pytest.fixture
def sample(addon):
    bpy.ops.wm.open_mainfile(filepath=str(SAMPLE), load_ui=False)
    bpy.context.scene.angen_live = False
    bpy.context.scene.frame_set(49)
    yield bpy.context.scene
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)


def height(name, sensor):
    at = [bpy.data.objects[n].matrix_world.translation for n in (name, f"Light sensor {sensor}")]
    return (at[0] - at[1]).length - AHEAD


def square(side, distance):
    """Form factor of a square of this side over the middle of which a small face lies."""
    a = side / 2 / distance
    return 4 / math.pi * a / math.hypot(1, a) * math.atan(a / math.hypot(1, a))


def point():
    power = bpy.data.objects["Lamp point"].data.energy
    return power / (4 * math.pi * height("Lamp point", "point") ** 2)


def spot():
    power = bpy.data.objects["Lamp spot"].data.energy
    return power / (4 * math.pi * height("Lamp spot", "spot") ** 2)


def area():
    lamp = bpy.data.objects["Lamp area"].data
    return lamp.energy / lamp.size**2 * square(lamp.size, height("Lamp area", "area"))


def plate():
    plate = bpy.data.objects["Glowing plate"]
    shader = next(n for n in plate.active_material.node_tree.nodes if n.type == "EMISSION")
    shining = math.pi * shader.inputs["Strength"].default_value
    return shining * square(plate.dimensions.x, height("Glowing plate", "glowing plate"))


def ball():
    """Light of the lamp, straight, and what went round: Φ ρ / (A (1 − ρ)) everywhere."""
    power, reflects = bpy.data.objects["Lamp ball"].data.energy, 0.8
    radius = bpy.data.objects["Ball"].dimensions.z / 2
    straight = power / (4 * math.pi * height("Lamp ball", "ball") ** 2)
    return straight + power * reflects / (4 * math.pi * radius**2 * (1 - reflects))


def sky():
    sun = bpy.data.objects["Lamp sun"]
    nodes = bpy.context.scene.world.node_tree.nodes
    strength = next(n for n in nodes if n.type == "BACKGROUND").inputs["Strength"].default_value
    return sun.data.energy * sun.matrix_world.col[2].z + math.pi * strength


EXPECTED = dict(zip(NAMES, (point, spot, area, plate, ball, sky), strict=True))
# Each path looks at one of all the file's lamps, which makes noise also in direct light.
TOLERANCE = {"ball": 0.02}


def asked():
    request = part("light.probe").LightRequest
    return [
        request(
            o.name,
            np.array(o.matrix_world, np.float64),
            "ILLUMINANCE",
            "CYCLES",
            o.angen_sensor.light.samples,
        )
        for o in bpy.context.scene.objects
        if o.angen_sensor.kind == "LIGHT"
    ]


def test_all_six_sensors_read_their_closed_forms(sample):
    found = measure(*asked(), efficacy=683.0)
    assert len(found) == len(NAMES)
    for name, form in EXPECTED.items():
        lux = found[f"Light sensor {name}"].illuminance_lux
        assert lux == pytest.approx(683.0 * form(), rel=TOLERANCE.get(name, 0.01)), name


def test_the_point_lamp_dims_over_time(sample):
    readings = []
    for frame in (1, 25, 49, 73, 97):
        sample.frame_set(frame)
        readings.append(measure(*asked(), efficacy=683.0)["Light sensor point"].illuminance_lux)
    full = readings[2]
    assert readings == pytest.approx([0, full / 2, full, full / 2, 0], rel=1e-4, abs=1e-9)
