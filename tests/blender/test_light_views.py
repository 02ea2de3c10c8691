# SPDX-License-Identifier: GPL-3.0-or-later
"""The four one-pixel views: 8-bit luminance in percent, clip distances, field of view."""

import math

import bpy
import numpy as np
import pytest
from light_stage import facing, lamp, material, measure, part, percent, plate, request, sky

UPRIGHT = facing((0, 1, 0))
COUNT = 100 / 255


def walls(world, *radiances, distance=2.0, size=1.0):
    """Glowing walls ahead of a sensor's −Z, −X, +Z, +X."""
    x, z = UPRIGHT[:3, 0], UPRIGHT[:3, 2]
    for way, radiance in zip((-z, -x, z, x), radiances, strict=False):
        glow = material(glows=radiance)
        plate(world, size, tuple(way * distance), tuple(-way), glow)


def look(**asked):
    return percent(matrix=UPRIGHT, **{"samples": 64, **asked})


def test_all_white_is_100_percent(world):
    sky(world, 1.0)
    assert look() == pytest.approx(100.0)


def test_all_black_is_0_percent(world):
    assert look() == 0.0


def test_one_count_is_0_39_percent(world):
    sky(world, 1.0 / 255)
    assert look() == pytest.approx(COUNT)
    sky(world, 0.49 / 255)
    assert look() == 0.0


def test_the_four_views_are_averaged(world):
    walls(world, 0.2, 0.4, 0.6, 1.0)
    counts = [round(255 * v) for v in (0.2, 0.4, 0.6, 1.0)]
    assert look() == pytest.approx(np.mean(counts) * COUNT, abs=1e-9)


@pytest.mark.parametrize("wall", range(4))
def test_each_view_looks_where_it_should(world, wall):
    radiances = [0.0] * 4
    radiances[wall] = 1.0
    walls(world, *radiances)
    world.update()
    asked = request(matrix=UPRIGHT, method="FOUR_WALL", samples=64)
    light = part("light.cycles").CyclesLight()
    light.look(world.scene, bpy.context.view_layer)
    found, _ = part("light.cycles_scene").finished(light.light([asked]))
    light.close()
    found = found[asked.name]
    assert found.colours == pytest.approx(np.outer(radiances, [1, 1, 1]))


def test_colours_count_by_luminance_of_their_counts(world):
    walls(world, *[(1.0, 0.5, 0.25)] * 4)
    expected = (0.2126 * 255 + 0.7152 * 128 + 0.0722 * 64) * COUNT
    assert look() == pytest.approx(expected, abs=1e-9)


def test_too_bright_is_white_and_exposure_scales(world):
    walls(world, *[4.0] * 4)
    assert look() == pytest.approx(100.0)
    assert look(exposure=0.125) == pytest.approx(128 * COUNT)
    assert look(exposure=0.0) == 0.0


def test_nearer_than_the_clip_is_not_seen(world):
    walls(world, *[1.0] * 4, distance=0.45)
    assert look() == 0.0
    assert look(clip_start=0.4) == pytest.approx(100.0)


def test_farther_than_the_clip_is_not_seen(world):
    walls(world, *[1.0] * 4, distance=4.0)
    assert look() == pytest.approx(100.0)
    assert look(clip_end=3.9) == 0.0


@pytest.mark.parametrize("angle", [0.02, 0.4, 1.5])
def test_the_view_is_a_square_of_the_field_of_view(world, angle):
    """A wall that covers half the width and half the height is a quarter of the light."""
    size = 2 * 2 * math.tan(angle / 2) / 2
    walls(world, *[1.0] * 4, size=size)
    assert look(field_of_view=angle, samples=4096) == pytest.approx(25.0, abs=1.0)


def test_a_white_wall_under_a_lamp(world):
    """Radiance ρ E / π."""
    x, z = UPRIGHT[:3, 0], UPRIGHT[:3, 2]
    for way in (-z, -x, z, x):
        plate(world, 1.0, tuple(way * 2), tuple(-way), material(0.5))
    lamp(world, "POINT", at=(0, 0, 0), energy=100.0)
    radiance = 0.5 / math.pi * 100 / (4 * math.pi * 4)
    # A hundredth of it goes from wall to wall.
    assert look(samples=4096) == pytest.approx(100 * radiance, rel=0.03)


def test_eevee_is_refused_with_a_reason_where_it_cannot_run(world, monkeypatch):
    engine = part("light.engine")
    monkeypatch.setattr(engine, "_why_no_eevee_in_background", lambda: "no GPU; choose Cycles")
    with pytest.raises(part("light.probe").AngenError, match="choose Cycles"):
        look(engine="EEVEE")


@pytest.mark.slow
@pytest.mark.parametrize("method", ["FOUR_WALL", "ILLUMINANCE"])
def test_no_lamp_shines_through_a_wall_in_eevee(world, method):
    if reason := part("light.engine").why_no_eevee():
        pytest.skip(reason)
    box = world.box((2, 2, 2))
    box.data.materials.append(material(0.5))
    lamp(world, "POINT", at=(0, 5, 0), energy=500.0)
    world.update()
    asked = request(matrix=UPRIGHT, method=method, samples=16, engine="EEVEE")
    found = measure(asked)[asked.name]
    assert (found.luminance_percent or 0.0) == (found.illuminance_lux or 0.0) == 0.0


def test_many_sensors_are_one_render_each_with_its_own_light(world):
    walls(world, 0.2, 0.4, 0.6, 1.0)
    alone = look()
    more = [
        request(f"s{i}", facing((0, 1, 0), (50 + i, 0, 0)), method="FOUR_WALL", samples=64)
        for i in range(9)
    ]
    found = measure(request("sensor", UPRIGHT, method="FOUR_WALL", samples=64), *more)
    assert found["sensor"].luminance_percent == alone
    assert [found[r.name].luminance_percent for r in more] == [0.0] * 9


def test_what_a_sensor_sees_does_not_depend_on_the_others(world):
    """Views that cross each other's far ends among them: there a path meets one surface more."""
    box = world.box((9, 9, 4))
    box.data.materials.append(material(0.5))
    lamp(world, "POINT", at=(1, 1, 1), energy=3000.0)
    apart = {"a": (0, 0, 0), "b": (3, 0, 0), "c": (0, 3, 0), "d": (3, 0.02, 0), "e": (-3, -2, 0)}
    asked = [
        request(name, method="FOUR_WALL", matrix=facing((0, 1, 0), place), samples=16)
        for name, place in apart.items()
    ]
    together = measure(*asked)
    for alone in asked:
        assert measure(alone)[alone.name] == together[alone.name]
    assert len({sample.luminance_percent for sample in together.values()}) > 2


def test_fog_in_the_world_counts_from_where_it_sees(world):
    """To a glowing wall at 4 m, from the near end of its views."""
    fog = sky(world, 0.0).node_tree
    absorbs = fog.nodes.new("ShaderNodeVolumeAbsorption")
    absorbs.inputs["Density"].default_value = 0.2
    absorbs.inputs["Color"].default_value = (0, 0, 0, 1)
    output = next(node for node in fog.nodes if node.type == "OUTPUT_WORLD")
    fog.links.new(absorbs.outputs[0], output.inputs["Volume"])
    walls(world, *[1.0] * 4, distance=4.0)
    assert look() == pytest.approx(100 * math.exp(-0.2 * 3.5), abs=0.6)
