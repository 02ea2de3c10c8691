# SPDX-License-Identifier: GPL-3.0-or-later
"""The plan of small homes of known measure: walls, storeys, and the view of each sensor."""

import math
from typing import Any

import numpy as np
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.scene.sensors import read_parameters
from bl_ext.user_default.angen_sensors.sensor_logic.kinds.pir.pyroelectric import zones_of

ROOM = (4.0, 3.0)


@pytest.fixture
def plan(addon_part: Any) -> Any:
    return addon_part("angen_addon.plan.storeys")


@pytest.fixture
def drawn(world: Any, plan: Any) -> Any:
    """Return the storeys of the scene at its first frame."""
    return lambda frame=1: plan.storeys(world.scene, world.sensors(), frame)


def room(world: Any, at: Any = (0.0, 0.0, 0.0), unit: float = 1.0, parent: Any = None) -> None:
    """Add a room of 4 m by 3 m inside, with walls 0.2 m thick and 2.6 m high, on a floor.

    The top of the floor is at `at`, the inner south-west corner of the room. `unit`: Blender units
    in a metre.
    """
    w, d, t, h = *ROOM, 0.2, 2.6
    parts = {
        "floor": ((w + 2 * t, d + 2 * t, 0.2), (w / 2, d / 2, -0.1)),
        "south": ((w + 2 * t, t, h), (w / 2, -t / 2, h / 2)),
        "north": ((w + 2 * t, t, h), (w / 2, d + t / 2, h / 2)),
        "west": ((t, d, h), (-t / 2, d / 2, h / 2)),
        "east": ((t, d, h), (w + t / 2, d / 2, h / 2)),
    }
    for name, (size, centre) in parts.items():
        place = [(a + b) * unit for a, b in zip(at, centre, strict=True)]
        made = world.box([s * unit for s in size], place, name)
        made.parent = parent


def detector(world: Any, place: Any, turn: float = 0.0, **settings: Any) -> Any:
    """Add a PIR that faces +Y with +Z up, turned about Z."""
    few = {"rays": 25, "horizontal_fov": math.radians(120), "range_max": 10.0, **settings}
    made = world.pir("pir", **few)
    made.location = place
    made.rotation_euler = (math.pi / 2, 0.0, turn)
    return made


def at(sensor: Any, storeys: Any) -> Any:
    return next(p for s in storeys for p in s.sensors if p.name == sensor.name)


def test_a_fan_ends_at_the_walls(world: Any, drawn: Any) -> None:
    room(world)
    pir = detector(world, (1.0, 0.5, 2.0))
    (storey,) = drawn()
    assert storey.floor == pytest.approx(0.0, abs=1e-6)
    assert storey.cut == pytest.approx(1.1, abs=1e-6)
    placed = at(pir, [storey])
    assert placed.height == pytest.approx(2.0, abs=1e-6)
    np.testing.assert_allclose(placed.at, (1.0, 0.5), atol=1e-6)
    np.testing.assert_allclose(placed.looks, (0.0, 1.0), atol=1e-6)
    (fan,) = placed.fans
    for i, end in enumerate(fan):
        # Counter-clockwise seen from above: the first ray is 60° to the right of +Y.
        azimuth = -math.pi / 3 + i * math.radians(120) / 24
        way = np.array([-math.sin(azimuth), math.cos(azimuth)])
        sides = [(4.0 - 1.0) / way[0]] if way[0] > 0 else [-1.0 / way[0]] if way[0] < 0 else []
        free = min([2.5 / way[1], *sides])
        np.testing.assert_allclose(end, (1.0, 0.5) + free * way, atol=1e-4)


def test_what_stands_in_the_way_leaves_a_dead_zone(world: Any, drawn: Any) -> None:
    room(world)
    pir = detector(world, (2.0, 0.5, 2.0), rays=121)
    free = at(pir, drawn()).fans[0]
    world.box((0.4, 0.4, 2.6), (2.0, 1.7, 1.3), "pillar")
    cut = at(pir, drawn()).fans[0]
    behind = np.abs(free[:, 0] - 2.0) < 0.2 / 1.0 * 2.5 - 1e-3
    assert (cut[behind, 1] < 1.71).all() and (free[behind, 1] > 2.9).all()
    np.testing.assert_allclose(cut[~behind], free[~behind], atol=1e-5)


def test_tilted_fans_end_on_the_floor(world: Any, drawn: Any) -> None:
    """2 m up, tilted by 45°: every ray of the second fan hits the floor 2 m ahead."""
    world.box((40, 40, 0.2), (0, 0, -0.1), "floor")
    pir = detector(world, (0, 0, 2.0), vertical_fov=math.pi / 2, vertical_step=math.pi / 4)
    level, tilted = at(pir, drawn()).fans
    np.testing.assert_allclose(np.linalg.norm(level, axis=1), 10.0, atol=1e-4)
    np.testing.assert_allclose(tilted[:, 1], 2.0, atol=1e-4)


def walls(storey: Any) -> list[Any]:
    return [line for shape in storey.shapes if shape.role == "wall" for line in shape.lines]


@pytest.mark.parametrize("unit_scale", [1.0, 0.01, 0.3048])
def test_walls_are_cut_in_metres_whatever_the_unit(
    world: Any, drawn: Any, unit_scale: float
) -> None:
    world.scene.unit_settings.scale_length = unit_scale
    unit = 1 / unit_scale
    room(world, unit=unit)
    detector(world, (1.0 * unit, 0.5 * unit, 2.0 * unit))
    (storey,) = drawn()
    assert sorted(line.area for line in walls(storey)) == pytest.approx(
        [0.6, 0.6, 0.88, 0.88], rel=1e-4
    )
    np.testing.assert_allclose(storey.view, [(-0.5, -0.5), (4.5, 3.5)], atol=1e-3)
    np.testing.assert_allclose(at(world.sensors()[0], [storey]).at, (1.0, 0.5), atol=1e-4)


def test_each_storey_has_its_own_plan(world: Any, drawn: Any) -> None:
    room(world)
    room(world, at=(0.0, 0.0, 2.8))
    world.box((4.4, 3.4, 0.1), (2.0, 1.5, 5.45), "roof")
    names = {"low": 2.4, "high": 5.35, "pad": 2.79}
    for i, (name, z) in enumerate(names.items()):
        world.switch(name).location = (1.0 + i, 1.5, z)
    ground, upper = drawn()
    assert [p.name for p in ground.sensors] == ["low"]
    assert [p.name for p in upper.sensors] == ["high", "pad"]
    assert (ground.floor, upper.floor) == pytest.approx((0.0, 2.8), abs=1e-5)
    assert at(world.sensors()[0], [upper]).height == pytest.approx(2.55, abs=1e-5)


def roles(storey: Any) -> dict[str, int]:
    found: dict[str, int] = {}
    for shape in storey.shapes:
        found[shape.role] = found.get(shape.role, 0) + 1
    return found


def test_walls_furniture_and_doors_are_told_apart(world: Any, drawn: Any) -> None:
    room(world)
    detector(world, (1.0, 0.5, 2.0))
    world.box((0.6, 0.6, 1.8), (3.5, 2.5, 0.9), "fridge")
    world.box((1.6, 0.8, 0.74), (2.0, 1.5, 0.37), "table")
    world.box((2.0, 1.0, 0.01), (2.0, 1.5, 0.005), "rug")
    world.box((0.2, 0.2, 0.2), (2.0, 1.5, 2.4), "lamp")
    door = world.box((0.9, 0.05, 2.1), (0.5, 2.0, 1.05), "door")
    world.key(door, "rotation_euler", {1: (0, 0, 0), 20: (0, 0, 1.5)})
    (storey,) = drawn()
    assert roles(storey) == {"wall": 4, "solid": 1, "low": 1, "floor": 2, "moving": 1}
    (closed,) = (s.lines[0].points for s in storey.shapes if s.role == "moving")
    (later,) = drawn(20)
    (opened,) = (s.lines[0].points for s in later.shapes if s.role == "moving")
    assert np.ptp(closed, axis=0)[0] == pytest.approx(0.9, abs=1e-4)
    assert np.ptp(opened, axis=0)[1] > 0.85


def test_instances_and_mirrored_ones_are_walls_too(world: Any, drawn: Any) -> None:
    wall = world.box((2.0, 0.2, 2.5), (0.0, 1.0, 1.25), "wall")
    group = world.aside("wall", wall)
    for i, scale in enumerate((1, -1)):
        copy = world.instance(f"copy {i}", group, (0.0, 2.0 * i, 0.0))
        copy.scale.x = scale
    detector(world, (0.0, 0.0, 1.0))
    (storey,) = drawn()
    assert [line.area for line in walls(storey)] == pytest.approx([0.4, 0.4], rel=1e-5)


def test_beams_and_pads(world: Any, drawn: Any) -> None:
    room(world)
    switch = world.switch("switch", range_max=0.5)
    switch.location, switch.rotation_euler = (3.8, 1.5, 2.0), (math.pi / 2, 0.0, -math.pi / 2)
    pad = world.sensor("PRESSURE", "pad", world.box((0.4, 0.3, 0.02), (1.0, 2.0, 0.01)))
    pad.name = "pad"
    lamp = world.sensor("LIGHT", "light", clip_start=0.5, clip_end=5.0)
    lamp.location, lamp.rotation_euler = (1.0, 1.0, 2.0), (math.pi / 2, 0.0, 0.0)
    (storey,) = drawn()
    ((start, end),) = at(switch, [storey]).beams
    np.testing.assert_allclose([*start, *end], (3.801, 1.5, 4.0, 1.5), atol=1e-4)
    assert np.ptp(at(pad, [storey]).pad, axis=0) == pytest.approx((0.4, 0.3), abs=1e-5)
    ends = {tuple(np.round(beam[1], 3).tolist()) for beam in at(lamp, [storey]).beams}
    assert ends == {(1.0, 3.0), (0.0, 1.0), (1.0, 0.0), (4.0, 1.0)}
    for beam in at(lamp, [storey]).beams:
        assert np.linalg.norm(beam[0] - (1.0, 1.0)) == pytest.approx(0.5, abs=1e-5)


def test_the_zones_of_a_pyroelectric_detector_are_fans(world: Any, drawn: Any) -> None:
    """Each reaches as far as the detection distance, or to an obstacle."""
    world.box((30, 0.2, 30), (0, 3.1, 0), "wall")
    pir = detector(world, (0, 0, 2.0), model="PYROELECTRIC", range_max=6.0)
    parameters = read_parameters(world.sensors()[0], pir.angen_sensor)
    zones, fans = zones_of(parameters), at(pir, drawn()).fans
    assert len(fans) == len(zones) > 1
    for zone, fan in zip(zones, fans, strict=True):
        level = math.cos(zone.elevation)
        ahead = level * math.cos(zone.azimuth)
        free = min(6.0, 3.0 / ahead) if ahead > 0 else 6.0
        middle = (-math.sin(zone.azimuth) * level * free, ahead * free)
        np.testing.assert_allclose(fan[2], middle, atol=1e-4)


def test_a_sensor_without_a_home_has_a_plan(world: Any, drawn: Any) -> None:
    pir = detector(world, (7.0, -3.0, 1.5))
    (storey,) = drawn()
    assert storey.shapes == () and at(pir, [storey]).height == 0.0
    assert (storey.view[0] < (7, -3)).all() and (storey.view[1] > (7, -3)).all()
    pir.angen_sensor.enabled = False
    assert drawn() == ()
