# SPDX-License-Identifier: GPL-3.0-or-later
"""Illuminance by Cycles against closed forms: efficacy 1, so W/m²."""

import math

import bpy
import numpy as np
import pytest
from light_stage import (
    ball,
    facing,
    lamp,
    lux,
    material,
    measure,
    part,
    plate,
    request,
    sky,
)
from mathutils import Vector

DIRECT_TOLERANCE, AREA_TOLERANCE = 1e-3, 2e-3
SOFT = 0.3


def form_factor(size_x, size_y, distance):
    """Of a parallel rectangle centred over a small face (Hottel; four corners)."""
    a, b = size_x / 2 / distance, size_y / 2 / distance
    p, q = math.hypot(1, a), math.hypot(1, b)
    return 4 / (2 * math.pi) * (a / p * math.atan(b / p) + b / q * math.atan(a / q))


@pytest.mark.parametrize("tilt", [0.0, 0.5, 1.2])
def test_a_point_lamp_is_its_power_over_the_sphere(world, tilt):
    lamp(world, "POINT", energy=10.0)
    normal = (math.sin(tilt), 0, math.cos(tilt))
    # The face stands 1 mm ahead of the sensor.
    way = Vector((0, 0, 2)) - 0.001 * Vector(normal)
    expected = 10 / (4 * math.pi) * way.dot(normal) / way.length**3
    found = lux(request(matrix=facing(normal), samples=16))
    assert found == pytest.approx(expected, rel=DIRECT_TOLERANCE / 2)


@pytest.mark.parametrize("soft", [True, False])
def test_a_ball_of_a_lamp(world, soft):
    lamp(world, "POINT", at=(0, 0, 1.001), shadow_soft_size=SOFT, use_soft_falloff=soft)
    expected = 1 / (4 * math.pi * (1 + SOFT**2 * soft))
    found = lux(request(samples=1024))
    assert found == pytest.approx(expected, rel=AREA_TOLERANCE)


@pytest.mark.parametrize(("off", "share"), [(0.0, 1.0), (0.35, 1.0), (0.85, 0.5), (1.3, 0.0)])
def test_a_spot_lamp_has_the_intensity_of_a_point_lamp_inside_its_smooth_edge(world, off, share):
    """Half the smoothstep is where the cosine is in the middle of its edge."""
    blend, cone = 0.5, 1.8
    edge = math.cos(cone / 2)
    if share == 0.5:
        off = math.acos(edge + blend * (1 - edge) / 2)
    place = 2 * np.array([math.sin(off), 0, -math.cos(off)])
    lamp(world, "SPOT", at=(0, 0, 0), spot_size=cone, spot_blend=blend)
    expected = share / (4 * math.pi * 2**2) * 1.001
    matrix = facing(-place, place)
    found = lux(request(matrix=matrix, samples=16))
    assert found == pytest.approx(expected, rel=DIRECT_TOLERANCE, abs=1e-9)


@pytest.mark.parametrize("angle", [0.0, 0.2])
def test_a_sun_is_its_strength_times_the_cosine(world, angle):
    lamp(world, "SUN", aim=(0, 1, -1), energy=3.0, angle=angle)
    found = lux(request(samples=1024 if angle else 16))
    assert found == pytest.approx(3 * math.cos(math.pi / 4), rel=DIRECT_TOLERANCE)


@pytest.mark.parametrize("distance", [0.05, 0.5, 4.0])
@pytest.mark.parametrize("shape", ["SQUARE", "RECTANGLE"])
def test_an_area_lamp_is_its_radiance_times_the_form_factor(world, distance, shape):
    at = (0, 0, distance + 0.001)
    lamp(world, "AREA", at=at, shape=shape, size=1.0, size_y=0.5)
    y = 1.0 if shape == "SQUARE" else 0.5
    expected = math.pi * (1 / (math.pi * y)) * form_factor(1.0, y, distance)
    found = lux(request(samples=1024))
    assert found == pytest.approx(expected, rel=AREA_TOLERANCE)


@pytest.mark.parametrize("distance", [0.05, 1.0])
def test_a_disk_lamp(world, distance):
    lamp(world, "AREA", at=(0, 0, distance + 0.001), shape="DISK", size=1.0)
    radiance = 1 / (math.pi * math.pi / 4)
    expected = math.pi * radiance * 0.25 / (0.25 + distance**2)
    found = lux(request(samples=4096))
    assert found == pytest.approx(expected, rel=AREA_TOLERANCE)


def test_an_ellipse_lamp_far_away_is_its_power_over_pi(world):
    lamp(world, "AREA", at=(0, 0, 20), shape="ELLIPSE", size=0.2, size_y=0.1)
    found = lux(request(samples=256))
    assert found == pytest.approx(1 / (math.pi * 20**2), rel=AREA_TOLERANCE)


def test_a_world_is_pi_times_its_radiance(world):
    sky(world, 0.7)
    found = lux(request(samples=256))
    assert found == pytest.approx(0.7 * math.pi, rel=DIRECT_TOLERANCE)


def test_a_glowing_mesh_is_its_radiance_times_the_form_factor(world):
    plate(world, 1.0, (0, 0, 0.501), (0, 0, -1), material(glows=2.0))
    expected = 2 * math.pi * form_factor(1, 1, 0.5)
    assert lux(request(samples=1024)) == pytest.approx(expected, rel=AREA_TOLERANCE)


@pytest.mark.parametrize("reflects", [0.5, 0.8])
def test_inside_a_white_sphere_light_goes_round(world, figure, reflects):
    """Indirect Φ ρ / (A (1 − ρ)) everywhere, and the direct light of the lamp in the middle."""
    ball(world, 2.0, material(reflects))
    lamp(world, "POINT", at=(0, 0, 0), energy=100.0)
    direct = 100 / (4 * math.pi * 2**2)
    expected = direct * (1 + reflects / (1 - reflects))
    # A face on the wall, which looks to the middle.
    matrix = facing((1, 0, 0), (-1.99, 0, 0))
    found = lux(request(matrix=matrix))
    figure(abs(found / expected - 1), "of the light")
    assert found == pytest.approx(expected, rel=0.02)


def test_colours_count_by_their_luminance(world):
    lamp(world, "POINT", color=(1, 0, 0.5))
    expected = (0.2126 + 0.5 * 0.0722) / (4 * math.pi * 4)
    found = lux(request(samples=16))
    assert found == pytest.approx(expected, rel=2 * DIRECT_TOLERANCE)


@pytest.mark.parametrize(
    ("kind", "settings", "expected"),
    [
        ("POINT", {"exposure": 2.0}, 4 / (4 * math.pi * 4)),
        ("AREA", {"normalize": False, "size": 0.1}, 0.01 / (math.pi * 4)),
        ("POINT", {"normalize": False, "shadow_soft_size": 0.1}, 0.1**2 / 4),
        ("SUN", {"normalize": False, "angle": 0.2}, math.pi * math.sin(0.1) ** 2),
        ("POINT", {"use_temperature": True, "temperature": 6500.0}, 1 / (4 * math.pi * 4)),
    ],
)
def test_newer_settings_of_lamps(world, kind, settings, expected):
    if next(iter(settings)) not in bpy.types.PointLight.bl_rna.properties:
        pytest.skip("this Blender's lamps do not have it")
    lamp(world, kind, **settings)
    loose = 0.02 if "use_temperature" in settings or "normalize" in settings else 2e-3
    assert lux(request(samples=512)) == pytest.approx(expected, rel=loose)


def test_a_lamp_with_a_strength_in_its_nodes(world):
    light = lamp(world, "POINT")
    light.data.use_nodes = True
    node = next(n for n in light.data.node_tree.nodes if n.type == "EMISSION")
    node.inputs["Strength"].default_value = 3.0
    found = lux(request(samples=16))
    assert found == pytest.approx(3 / (4 * math.pi * 4), rel=2e-3)


def test_shadows(world):
    lamp(world, "POINT", at=(0, 0, 2))
    lamp(world, "POINT", at=(1, 0, 2))
    plate(world, 0.2, (0, 0, 1), (0, 0, -1), material(0.001))
    expected = 1 / (4 * math.pi * 5) * 2 / math.sqrt(5)
    # Cycles chooses one lamp a path: half of its paths find the shaded one.
    assert lux(request(samples=1024)) == pytest.approx(expected, rel=0.1)


def test_lux_are_watts_times_the_efficacy(world):
    lamp(world, "SUN")
    for efficacy in (683.0, 179.0):
        (sample,) = measure(request(samples=4), efficacy=efficacy).values()
        assert sample.illuminance_lux == pytest.approx(efficacy, rel=1e-3)


def test_no_lamps_no_world_and_nothing_at_all_are_dark(world):
    world.scene.world = None
    assert lux(request()) == 0.0


def test_negative_lamps_take_light_away_but_not_below_dark(world, figure):
    lamp(world, "SUN", energy=3.0)
    negative = lamp(world, "SUN", energy=-1.0)
    found = lux(request(samples=64))
    figure(abs(found / 2.0 - 1), "of the light")
    assert found == pytest.approx(2.0, rel=0.1)
    negative.data.energy = -5.0
    assert lux(request(samples=64)) == 0.0


def test_colours_that_are_no_numbers_are_left_out(world):
    lamp(world, "SUN")
    broken = lamp(world, "SUN")
    broken.data.color = (math.nan, 1, 1)
    assert math.isfinite(lux(request(samples=16)))


@pytest.mark.parametrize("far", [1e3, 1e4])
def test_far_from_the_origin_it_is_right(world, figure, far):
    """10 km away coordinates have steps of a millimetre."""
    lamp(world, "POINT", at=(far, 0, 2))
    box = world.box((8, 8, 8), at=(far, 0, 0))
    box.data.materials.append(material(0.001))
    poses = [facing((0, 0, 1), (far + 0.02 * n, 0, 0)) for n in range(3)]
    found = lux(*[request(f"{n}", p, samples=64) for n, p in enumerate(poses)])
    expected = 1 / (4 * math.pi * 4)
    figure(max(abs(value / expected - 1) for value in found), "of the light")
    assert found == pytest.approx([expected] * 3, rel=0.03 if far > 5e3 else 0.005)


def test_too_far_from_the_origin_is_refused(world):
    with pytest.raises(part("light.probe").AngenError, match="nearer to the origin"):
        lux(request(matrix=facing((0, 0, 1), (2e5, 0, 0))))
