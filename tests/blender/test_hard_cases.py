# SPDX-License-Identifier: GPL-3.0-or-later
"""Hard cases, each with its measured figure: docs/hard_cases.md lists them.

`measured` notes a figure and compares it with its tolerance; scripts/hard_cases.py collects them.
"""

import math

import numpy as np
import pytest

RANGE_M = 5e-6
SIZE = np.array((5.0, 4.0, 2.6))


@pytest.fixture
def measured(record_property):
    """Note the figure of a case, and assert that it is within the tolerance."""

    def note(family, case, worst, tolerance, unit="m"):
        record_property("hard_case", f"{family}\t{case}\t{worst:.2g} {unit}\t{tolerance:g} {unit}")
        assert worst <= tolerance, f"{case}: {worst:g} {unit}"

    return note


def exits(obj, origins, directions, size):
    """Return the distance (n,) at which rays from inside a box object leave it.

    It is computed in float64 and in the object's own space, for any matrix.
    """
    matrix = np.array(obj.matrix_world, np.float64)
    inverse = np.linalg.inv(matrix[:3, :3])
    starts = (origins - matrix[:3, 3]) @ inverse.T
    ways = directions @ inverse.T
    with np.errstate(divide="ignore"):
        far = np.maximum((size / 2 - starts) / ways, (-size / 2 - starts) / ways)
    return far.min(axis=1)


def fan_in(world, place, **settings):
    """Add a detector whose rays go in nearly all directions; return it and its rays."""
    given = {"rays": 60, "range_max": 50.0, "vertical_fov": math.pi, "sweep": "ALL", **settings}
    sensor = world.pir(**given)
    sensor.location, sensor.rotation_euler = place, (0.3, -1.1, 2.2)
    return world.rays(sensor)


def worst(found, expected):
    return float(np.abs(found - expected).max())


@pytest.mark.parametrize("far", [1e3, 1e4, 1e5, 1e6])
def test_far_from_the_origin(world, measured, far):
    room = world.box(SIZE, at=(far, -far, 0), name="room")
    origins, directions, ranges = fan_in(world, (far + 0.5, -far - 0.5, 0.5))
    error = worst(ranges, exits(room, origins, directions, SIZE))
    measured("Place and size", f"a room {far:g} m from the origin: a range", error, RANGE_M)


@pytest.mark.parametrize("scale", [1e-4, 1e-2, 1e2, 1e4])
def test_scale_of_an_object(world, measured, scale):
    room = world.box(SIZE / scale, name="room")
    room.scale = (scale,) * 3
    origins, directions, ranges = fan_in(world, (0.5, -0.4, 0.3))
    error = worst(ranges, exits(room, origins, directions, SIZE / scale))
    measured(
        "Place and size", f"a room whose object is scaled by {scale:g}: a range", error, RANGE_M
    )


@pytest.mark.parametrize("size", [0.01, 1.0, 1e3, 1e5])
def test_size_of_a_room(world, measured, size):
    room = world.box(SIZE * size, name="room")
    place = np.array((0.5, -0.4, 0.3)) * size
    origins, directions, ranges = fan_in(world, place, range_min=0.0, range_max=50.0 * size)
    expected = exits(room, origins, directions, SIZE * size)
    error = float((np.abs(ranges - expected) / expected).max())
    case = f"a room of {5 * size:g} m: a range, relative"
    measured("Place and size", case, error, 2e-6, "")


SHAPES = {
    "mirrored": (-1, 1, 1),
    "mirrored on all axes": (-1, -1, -1),
    "scaled by (100, 1, 0.01)": (100, 1, 0.01),
}
# Single precision in a space that is squeezed ten thousand times as much along one axis.
SHAPE_M = {"scaled by (100, 1, 0.01)": 3e-4}


@pytest.mark.parametrize("shape", SHAPES)
def test_mirrored_and_uneven(world, measured, shape):
    scale = np.array(SHAPES[shape], np.float64)
    room = world.box(SIZE / np.abs(scale), name="room")
    room.scale, room.rotation_euler = scale, (0.2, 0.5, -0.3)
    origins, directions, ranges = fan_in(world, (0.2, -0.1, 0.3))
    error = worst(ranges, exits(room, origins, directions, SIZE / np.abs(scale)))
    measured("Shape", f"a room {shape}: a range", error, SHAPE_M.get(shape, RANGE_M))


def test_sheared(world, measured):
    parent = world.link("parent", None)
    parent.scale = (3, 1, 0.5)
    room = world.box((2, 4, 5), name="room")
    room.parent, room.rotation_euler = parent, (0.4, 0.7, 0.2)
    origins, directions, ranges = fan_in(world, (0.1, -0.1, 0.1))
    error = worst(ranges, exits(room, origins, directions, np.array((2, 4, 5))))
    measured("Shape", "a room sheared by its parent: a range", error, RANGE_M)


def aimed(world, caster_at, targets):
    """Return the ranges of rays from a point exactly at targets (n, 3)."""
    from bl_ext.user_default.angen_sensors.angen_addon.runtime import probes

    ways = targets - caster_at
    far = np.linalg.norm(ways, axis=1)
    depsgraph = world.update()
    caster = probes.make_caster(world.scene)
    caster.update(depsgraph)
    starts = np.broadcast_to(caster_at, ways.shape).copy()
    return caster.cast(1, 0, starts, ways / far[:, None], far + 1.0), far


def test_edges_and_corners_of_a_closed_mesh(world, measured):
    world.bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=4, radius=1.0)
    ball = world.bpy.context.object.data
    points = np.array([v.co for v in ball.vertices], np.float64)
    ends = np.array([e.vertices for e in ball.edges])
    share = np.linspace(0.0, 1.0, 5)[:, None, None]
    targets = (points[ends[:, 0]] * (1 - share) + points[ends[:, 1]] * share).reshape(-1, 3)
    ranges, far = aimed(world, np.array((0.1, 0.05, -0.2)), targets)
    leaks = int((ranges > far + 1e-3).sum())
    case = f"{len(far)} rays aimed at edges and corners of a sphere from inside: leaks"
    measured("Edges", case, leaks, 0, "rays")
    error = worst(ranges, far)
    measured("Edges", "the same: a range", error, 1e-5)


def test_abutting_panels(world, measured):
    chance = np.random.default_rng(1)
    for i in range(8):
        h = 0.5
        panel = world.mesh([(-h, -h, 0), (h, -h, 0), (h, h, 0), (-h, h, 0)], [(0, 1, 2, 3)])
        world.link(f"panel {i}", panel, (i - 3.5, 0, -1.0))
    targets = np.stack(
        [chance.uniform(-3.9, 3.9, 20_000), chance.uniform(-0.4, 0.4, 20_000), np.full(20_000, -1)],
        axis=1,
    )
    ranges, far = aimed(world, np.array((0.1, 0.05, 1.0)), targets)
    measured(
        "Edges",
        "20000 rays at eight panels that abut: leaks",
        int((ranges > far + 1e-3).sum()),
        0,
        "rays",
    )


def test_coplanar_faces(world, measured):
    for i in range(3):
        world.wall(0.3, f"wall {i}")
    readings = [world.range(world.switch(f"switch {i}")) for i in range(2)]
    measured("Edges", "three walls in one plane: a range", worst(np.array(readings), 0.3), 1e-6)


@pytest.mark.parametrize("angle", [1e-1, 1e-2, 1e-3, 1e-4, 1e-5])
def test_grazing(world, measured, angle):
    start = np.array((0.0, 0.0, 1e-3))
    reach = start[2] / math.tan(angle)
    half = 1.5 * reach
    world.link("plane", world.mesh([(-half, -half, 0), (half, -half, 0), (half, half, 0),
                                    (-half, half, 0)], [(0, 1, 2, 3)]))  # fmt: skip
    azimuths = np.linspace(0, 2 * math.pi, 100, endpoint=False)
    targets = np.stack([reach * np.cos(azimuths), reach * np.sin(azimuths), 0 * azimuths], axis=1)
    ranges, far = aimed(world, start, targets)
    error = float((np.abs(ranges - far) / far).max())
    measured(
        "Edges", f"a ray that grazes a plane at {angle:g} rad: a range, relative", error, 1e-5, ""
    )


def test_a_sensor_on_a_face(world, measured):
    world.box(SIZE, name="room")
    chance, wrong = np.random.default_rng(1), 0
    for i in range(50):
        sensor = world.switch(f"switch {i}", range_max=10.0, range_min=0.001)
        y, z = chance.uniform(-1, 1, 2).tolist()
        # On the wall x = 2.5, facing the opposite wall.
        sensor.location, sensor.rotation_euler = (2.5, y, z), (math.pi / 2, 0, math.pi / 2)
        wrong += abs(world.range(sensor) - 5.0) > 1e-5
    measured("Edges", "50 sensors exactly on a wall: ones that see that wall", wrong, 0, "sensors")


@pytest.mark.parametrize("far", [0.0, 1e3, 1e4])
def test_a_thin_flag(world, measured, far):
    chance, missed = np.random.default_rng(1), 0
    half = 0.01
    # The nearest coordinates of single precision there.
    step = float(np.spacing(np.float32(max(far, 1.0))))
    for i in range(20):
        x = float(np.float32(far + chance.uniform(0, 0.5)))
        world.box((half, half, 0.0005), at=(x, i, -0.0025), name=f"flag {i}")
        sensor = world.switch(f"switch {i}", range_min=0.0005, range_max=0.005, threshold=0.004)
        sensor.location = (x, i, 0.0)
        missed += abs(world.range(sensor) - 0.00225) > step
    case = f"20 flags of 0.5 mm in a gap of 5 mm, {far:g} m from the origin: missed"
    measured("Thin and fast", case, missed, 0, "flags")


@pytest.mark.parametrize("fps, base", [(1, 1), (5, 1), (24, 1), (30, 1.001), (60, 1), (240, 1)])
def test_time_steps(world, measured, fps, base):
    """The event of a door is at the first update whose frame is at or after it.

    The door opens at 1.53 s, before a switch at 10 Hz.
    """
    scene = world.scene
    scene.render.fps, scene.render.fps_base = fps, base
    frames = 1 + math.ceil(3 * fps / base)
    scene.frame_end = frames
    flag = world.box((0.2, 0.2, 0.01), at=(0, 0, -0.02), name="flag")
    opens = 1 + math.ceil(1.53 * fps / base)
    world.key(flag, "location", {1: (0, 0, -0.02), opens: (1, 0, -0.02)}, "CONSTANT")
    world.switch(update_rate=10.0)
    rows = [row for row in world.log(world.run()) if row[4] == "open"]
    assert [row[5] for row in rows] == ["0", "1"]
    late = float(rows[1][0]) - (opens - 1) * base / fps
    assert late >= 0.0
    # An update is taken at the first frame at or after its time.
    allowed = 0.1 + base / fps
    measured("Time", f"a door seen at {fps / base:.4g} fps and 10 Hz: lateness", late, allowed, "s")


def test_points_that_are_no_numbers(world, measured):
    """A mesh with NaN or infinite corners is ignored; rays hit the wall behind it."""
    for name, bad in (("nan", math.nan), ("inf", math.inf), ("-inf", -math.inf)):
        mesh = world.mesh([(-1, -1, bad), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [(0, 1, 2, 3)])
        world.link(name, mesh, (0, 0, -0.1))
    world.wall(0.3)
    error = abs(world.range(world.switch()) - 0.3)
    measured(
        "Not a number", "meshes with NaN and infinite corners before a wall: a range", error, 1e-6
    )


def test_places_that_are_no_numbers(world, measured):
    for i, bad in enumerate((math.nan, math.inf, 1e38)):
        box = world.box((1, 1, 0.01), at=(0, 0, -0.1), name=f"box {i}")
        box.location.x = bad
    flat = world.box((1, 1, 1), at=(0, 0, -0.1), name="flat")
    flat.scale = (0, 1, 1)
    world.wall(0.3)
    error = abs(world.range(world.switch()) - 0.3)
    measured("Not a number", "objects at NaN, ∞, 1e38 and of scale 0: a range", error, 1e-6)


def test_a_still_room_never_moves(world, measured):
    """The room is far away, scaled and turned: without noise no update may have motion."""
    room = world.box(SIZE, at=(5000, 300, 2), name="room")
    room.rotation_euler = (0.1, 0.2, 0.3)
    sensor = world.pir(rays=120, vertical_fov=math.pi / 2, sweep="ALL", threshold=0.0)
    sensor.location = (5000.3, 300.2, 2.5)
    moved = world.series(world.run(), "pir", "moved")
    measured("Time", "false alarms of a still room, threshold 0", sum(moved), 0, "updates")


@pytest.mark.parametrize("people", [1, 8])
def test_deforming_meshes(world, measured, people):
    """Sheets bend over time before both casters, at every frame."""
    for i in range(people):
        corners = [(x / 10 - 0.5, y / 10 - 0.5, 0) for y in range(11) for x in range(11)]
        faces = [(i, i + 1, i + 12, i + 11) for k in range(10) for i in range(11 * k, 11 * k + 10)]
        sheet = world.link(f"sheet {i}", world.mesh(corners, faces), (0.3 * i, 0, -1.0 - 0.1 * i))
        wave = sheet.modifiers.new("wave", "WAVE")
        wave.height, wave.width, wave.speed = 0.2, 0.4, 0.05
    seen = {}
    for caster in ("FAST", "SCENE"):
        world.scene.angen_ray_caster = caster
        sensors = [o for o in world.scene.objects if o.angen_sensor.kind == "OPTICAL_SWITCH"]
        for i in range(9 - len(sensors)):
            switch = world.switch(f"switch {i}", range_max=5.0)
            switch.location = (0.11 * i - 0.2, 0.07, 0.0)
        recording = world.run()
        seen[caster] = np.array([t.columns["range_m"] for t in recording.tracks.values()])
    assert np.ptp(seen["FAST"], axis=1).max() > 0.05, "the sheets move"
    case = f"{people} bending meshes over 48 frames: a range, against scene.ray_cast"
    measured("Shape", case, worst(seen["FAST"], seen["SCENE"]), 2e-5)


def test_light_exactly_on_a_wall(world, measured):
    """A light sensor in the plane of a wall, with a lamp across: the inverse-square law."""
    lamp = world.bpy.data.lights.new("lamp", "POINT")
    lamp.energy, lamp.shadow_soft_size = 10.0, 0.0
    world.link("lamp", lamp, (0, 0, -2.0))
    black = world.bpy.data.materials.new("black")
    black.use_nodes = True
    black.node_tree.nodes.clear()
    wall = world.wall(0.0, size=4.0)
    wall.data.materials.append(black)
    world.sensor("LIGHT", "light", update_rate=1.0, method="ILLUMINANCE", samples=64)
    world.scene.angen_luminous_efficacy = 683.0
    recording = world.run(1, 1)
    exact = 683.0 * 10.0 / (4 * math.pi * 2.0**2) / math.pi * math.pi
    error = abs(world.series(recording, "light", "illuminance_lux")[0] / exact - 1.0)
    measured("Light", "a light sensor exactly on a wall: illuminance, relative", error, 2e-3, "")


@pytest.mark.parametrize("fps", [1, 5, 24, 60, 240])
def test_weight_at_any_frame_rate(physics, measured, fps):
    """Blender steps the physics of a box at rest at the scene's rate."""
    physics.on_floor(20, fps)
    physics.pad(kind="PASSIVE")
    physics.body("box", (0.1, 0.1, 0.1), (0, 0, 0.11), 5.0)
    # The physics engine steps by at most 4 ms.
    physics.scene.rigidbody_world.substeps_per_frame = max(10, 240 // fps)
    error = float(np.abs(physics.read().known() / (5.0 * 9.81) - 1.0).max())
    measured("Pressure", f"a box of 5 kg at rest at {fps} fps: force, relative", error, 1e-3, "")
