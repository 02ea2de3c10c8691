# SPDX-License-Identifier: GPL-3.0-or-later
"""Ranges in a closed room against closed forms, own objects, and hidden objects.

A sensor's own objects never stop its beam. Sensors see the objects that the viewport shows.
"""

import math

import numpy as np
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.scene.sensors import AngenError
from mathutils import Matrix

SIZE = np.array((5.0, 4.0, 2.6))
TOLERANCE_M = 5e-6
TURNS = [(0, 0, 0), (math.radians(90), 0, 0), (0.3, -1.1, 2.2), (-2.0, 0.7, 0.1)]


def exits(origins, directions, lo, hi):
    """Return the distance (n,) at which rays from inside a box leave it."""
    with np.errstate(divide="ignore"):
        far = np.maximum((lo - origins) / directions, (hi - origins) / directions)
    return far.min(axis=1)


def turned(x, y, z):
    """Return the rotation matrix of Blender's XYZ Euler angles."""

    def about(axis, angle):
        i, j = [n for n in range(3) if n != axis]
        matrix, sign = np.eye(3), -1 if axis == 1 else 1
        matrix[i, i] = matrix[j, j] = math.cos(angle)
        matrix[i, j], matrix[j, i] = -sign * math.sin(angle), sign * math.sin(angle)
        return matrix

    return about(2, z) @ about(1, y) @ about(0, x)


def fan(rays, fov, tilts, step):
    """Return directions (tilts · rays, 3) in the sensor's axes, from its parameters."""
    found = []
    for k in range(tilts):
        for i in range(rays):
            azimuth = -fov / 2 + i * fov / (rays - 1)
            found.append(turned(-k * step, 0, 0) @ turned(0, azimuth, 0) @ (0, 0, -1))
    return np.array(found)


@pytest.mark.parametrize("turn", TURNS)
def test_every_range_in_a_room(world, each_caster, turn):
    centre, place = np.array((1.0, -2.0, 1.3)), np.array((2.2, -1.0, 2.0))
    world.box(SIZE, at=centre, name="room")
    sensor = world.pir(rays=40, range_max=50.0, vertical_fov=math.pi, sweep="ALL")
    sensor.location, sensor.rotation_euler = place, turn
    origins, directions, ranges = world.rays(sensor)
    expected = fan(40, math.radians(120), 18, math.radians(10)) @ turned(*turn).T
    np.testing.assert_allclose(directions, expected, atol=5e-7)
    np.testing.assert_allclose(origins, place + 0.05 * expected, atol=5e-7)
    free = exits(np.broadcast_to(place, expected.shape), expected, *corners(centre))
    assert np.abs(ranges + 0.05 - free).max() <= TOLERANCE_M


def corners(centre):
    return centre - SIZE / 2, centre + SIZE / 2


@pytest.mark.parametrize("system", ["METRIC", "NONE"])
def test_every_range_in_a_room_in_centimetres(world, each_caster, figure, system):
    world.scene.unit_settings.system = system
    world.scene.unit_settings.scale_length = 0.01
    metres = 0.01 if system == "METRIC" else 1.0
    world.box(SIZE / metres, name="room")
    sensor = world.pir(rays=120, range_max=50.0, vertical_fov=math.pi, sweep="ALL")
    sensor.location = np.array((0.3, 0.2, -0.1)) / metres
    sensor.rotation_euler = (0.3, -1.1, 2.2)
    origins, directions, ranges = world.rays(sensor)
    expected = exits(origins, directions, -SIZE / 2, SIZE / 2)
    figure(np.abs(ranges - expected).max(), "m")
    assert np.abs(ranges - expected).max() <= TOLERANCE_M
    np.testing.assert_allclose(np.linalg.norm(origins - (0.3, 0.2, -0.1), axis=1), 0.05, atol=1e-6)


def test_ranges_end_at_range_max(world, each_caster):
    world.box(SIZE, name="room")
    sensor = world.pir(rays=120, range_max=1.6)
    origins, directions, ranges = world.rays(sensor)
    free = exits(origins, directions, -SIZE / 2, SIZE / 2)
    np.testing.assert_allclose(ranges, np.minimum(free, 1.6 - 0.05), atol=TOLERANCE_M)
    assert (ranges < 1.5).any() and (free > 1.6).any(), "both cases are in the fan"


def test_what_is_nearer_than_range_min_is_not_seen(world, each_caster):
    world.wall(0.04, "near")
    world.wall(0.3, "far")
    assert world.range(world.switch(range_min=0.05)) == pytest.approx(0.3, abs=TOLERANCE_M)
    assert world.range(world.switch("other", range_min=0.03)) == pytest.approx(0.04, abs=1e-6)


def test_glass_stops_the_beam(world, each_caster):
    glass = world.bpy.data.materials.new("glass")
    glass.use_nodes = True
    shader = next(n for n in glass.node_tree.nodes if n.type == "BSDF_PRINCIPLED")
    shader.inputs["Transmission Weight"].default_value = 1.0
    shader.inputs["Alpha"].default_value = 0.0
    pane, _ = world.box((1, 1, 0.004), at=(0, 0, -0.1), name="pane"), world.wall(0.3)
    pane.data.materials.append(glass)
    assert world.range(world.switch()) == pytest.approx(0.098, abs=TOLERANCE_M)


def test_backfaces_stop_the_beam(world, each_caster, figure):
    wall = world.wall(0.2)
    assert world.range(world.switch()) == pytest.approx(0.2, abs=TOLERANCE_M)
    wall.rotation_euler.x = math.pi
    behind = world.range(world.switch("again"))
    figure(abs(behind - 0.2), "m")
    assert behind == pytest.approx(0.2, abs=TOLERANCE_M)


def test_a_beam_into_the_joint_of_two_panels_does_not_leak(world, each_caster, figure):
    for side in (-0.25, 0.25):
        world.box((0.5, 1, 0.02), at=(side, 0, -0.2))
    found = world.range(world.switch())
    figure(abs(found - 0.19), "m")
    assert found == pytest.approx(0.19, abs=TOLERANCE_M)


# A sensor's own objects never stop its beam; a flag in a narrow gap always does


PLACES = {"origin": (0, 0, 0), "1 km": (1000, -300, 20), "10 km": (7000, 7000, -1000)}
# The error of a range (m) where coordinates of single precision are this coarse.
ROUNDING = {"origin": 5e-6, "1 km": 2e-4, "10 km": 2e-3}
PARENTS = {
    "none": None,
    "small": Matrix.Diagonal((1e-3, 1e-3, 1e-3, 1)),
    "large": Matrix.Diagonal((1e3, 1e3, 1e3, 1)),
    "mirrored": Matrix.Diagonal((-1, 1, 1, 1)),
    "uneven": Matrix.Diagonal((0.1, 30, 2, 1)),
    "sheared": Matrix(((1, 0.4, 0.2, 0), (0, 1, 0.3, 0), (0, 0, 1, 0), (0, 0, 0, 1))),
}


def put_under(world, parent_matrix, place):
    """Return a parent at `place` with this matrix, or None."""
    parent = world.link("parent", None)
    # A matrix with shear needs two objects: their rotation between two scales.
    if parent_matrix is not None:
        parent.matrix_parent_inverse = parent_matrix
        top = world.link("top", None, place)
        parent.parent = top
    else:
        parent.location = place
    return parent


def housing(world, sensor):
    """Add a box about the sensor, and a lid before it as the box's child, both across the beam."""
    box = world.box((0.02, 0.02, 0.02), name="box")
    lid = world.box((0.02, 0.02, 0.001), at=(0, 0, -0.05), name="lid")
    box.parent, lid.parent = sensor, box


@pytest.mark.parametrize("kind", PARENTS)
@pytest.mark.parametrize("place", PLACES)
def test_the_housing_of_a_parented_sensor(world, figure, place, kind):
    parent = put_under(world, PARENTS[kind], PLACES[place])
    sensor = world.switch()
    sensor.parent = parent
    housing(world, sensor)
    world.update()
    wall = world.wall(0.3)
    pose = sensor.matrix_world
    ahead = -(pose.to_3x3() @ Matrix.Identity(3).col[2]).normalized()
    wall.matrix_world = (
        Matrix.Translation(pose.translation + ahead * 0.3)
        @ ahead.to_track_quat("Z", "Y").to_matrix().to_4x4()
    )
    world.update()
    found = world.range(sensor)
    figure(abs(found - 0.3), "m")
    assert found == pytest.approx(0.3, abs=ROUNDING[place])


@pytest.mark.parametrize("scale", [1.0, 1e-3, 1e3])
@pytest.mark.parametrize("place", PLACES)
def test_a_sensor_that_is_a_mesh_itself(world, place, scale):
    """Lengths of the sensor are metres at any scale of its object."""
    box = world.box((0.1, 0.1, 0.1), at=PLACES[place], name="housing")
    box.scale = (scale, scale, scale)
    sensor = world.switch(obj=box)
    wall = world.wall(0.3)
    wall.location = [a + b for a, b in zip(PLACES[place], (0, 0, -0.3), strict=True)]
    assert world.range(sensor) == pytest.approx(0.3, abs=ROUNDING[place])


def test_another_sensors_housing_stops_the_beam_only_if_it_is_solid(world, each_caster):
    sensor, other = world.switch(), world.switch("other")
    housing(world, sensor)
    other.location.z = -0.2
    housing(world, other)
    assert world.range(sensor) == pytest.approx(0.5, abs=2e-5)
    other.angen_sensor.housing_solid = True
    assert world.range(sensor) == pytest.approx(0.19, abs=2e-5)


def test_the_sensors_parent_stops_the_beam(world, each_caster):
    """A switch on a door frame: the frame is not the sensor's own."""
    frame = world.box((0.2, 0.2, 0.02), at=(0, 0, -0.1), name="frame")
    sensor = world.switch()
    sensor.parent = frame
    sensor.matrix_parent_inverse = Matrix.Translation((0, 0, 0.1))
    assert world.range(sensor) == pytest.approx(0.09, abs=2e-5)


GAP = {"threshold": 0.005, "range_max": 0.02, "range_min": 0.0005}


@pytest.mark.parametrize("scale", [1.0, 1e-3, 1e3])
@pytest.mark.parametrize("place", PLACES)
def test_a_flag_of_half_a_millimetre_in_a_gap_of_five(world, place, scale):
    """Two housings 5 mm apart, the flag in between, on a door that is parented and scaled."""
    door = world.link("door", None, PLACES[place])
    door.scale = (scale, scale, scale)
    sensor = world.switch(**GAP)
    receiver = world.box((0.01, 0.01, 0.01), at=(0, 0, -0.010), name="receiver")
    flag = world.box((0.02, 0.02, 0.0005), at=(0, 0, -0.0025), name="flag")
    for obj in (sensor, receiver, flag):
        obj.parent = door
        obj.matrix_parent_inverse = Matrix.Scale(1 / scale, 4)
    housing(world, sensor)
    reads = world.range(sensor)
    assert reads < 0.005, "the flag is in the gap"
    if place == "origin":
        assert reads == pytest.approx(0.00225, abs=5e-6)
    flag.hide_viewport = True
    reads = world.range(sensor)
    # The receiver is 5 mm away, as exactly as single precision can place it there.
    assert reads == pytest.approx(0.005, abs=ROUNDING[place])


@pytest.mark.parametrize("turn", [0.0, 0.7])
@pytest.mark.parametrize("place", PLACES)
def test_a_slanted_card_far_from_its_origin(world, figure, place, turn):
    """A triangle modelled far away is hit where the plane of its stored vertices is."""
    offset = PLACES[place]
    sensor = world.switch()
    sensor.location = offset
    corners = [(-0.2, -0.2, -0.3), (0.3, -0.2, -0.25), (0.0, 0.3, -0.2)]
    points = [tuple(a + b for a, b in zip(c, offset, strict=True)) for c in corners]
    card = world.link("card", world.mesh(points, [(0, 1, 2)]))
    world.update()
    a, b, c = (np.array(vertex.co, np.float64) for vertex in card.data.vertices)
    normal = np.cross(b - a, c - a)
    place_of = np.array(sensor.matrix_world.translation, np.float64)
    expected = (normal @ (place_of - a)) / normal[2]
    sensor.rotation_euler.z = turn
    found = world.range(sensor)
    figure(abs(found - expected), "m")
    assert found == pytest.approx(expected, abs=5e-6)


@pytest.mark.parametrize("angle", [0, 30, 45])
def test_the_beam_passes_a_slit_beside_the_flag(world, each_caster, angle):
    """Half a millimetre free beside the flag is enough for the beam."""
    sensor = world.switch(**GAP)
    sensor.rotation_euler.z = math.radians(angle)
    world.box((0.02, 0.02, 0.0005), at=(0.0105, 0, -0.0025), name="flag")
    assert world.range(sensor) == pytest.approx(0.02, abs=1e-6)


# Sensors see the objects that are solid in the viewport, and nothing else


NEAR, FAR = 0.1, 0.3


@pytest.fixture
def screen(world):
    """Add a wall before the far one; the test hides it in some way."""
    world.wall(FAR, "far")
    return world.wall(NEAR, "screen")


def seen(world, sensor):
    distance = world.range(sensor)
    for place in (NEAR, FAR):
        if distance == pytest.approx(place, abs=2e-5):
            return place
    raise AssertionError(f"the beam ended at {distance}, where nothing is")


def in_collection(world, obj):
    collection = world.bpy.data.collections.new("collection")
    world.scene.collection.children.link(collection)
    world.scene.collection.objects.unlink(obj)
    collection.objects.link(obj)
    return collection, world.bpy.context.view_layer.layer_collection.children["collection"]


def hide_in_renders(world, screen):
    screen.hide_render = True
    in_collection(world, screen)[0].hide_render = True


WAYS = {
    "shown": (lambda world, screen: None, NEAR),
    "object": (lambda world, screen: setattr(screen, "hide_viewport", True), FAR),
    "eye": (lambda world, screen: screen.hide_set(True), FAR),
    "excluded": (lambda *made: setattr(in_collection(*made)[1], "exclude", True), FAR),
    "collection": (lambda *made: setattr(in_collection(*made)[0], "hide_viewport", True), FAR),
    "its eye": (lambda *made: setattr(in_collection(*made)[1], "hide_viewport", True), FAR),
    "in renders alone": (hide_in_renders, NEAR),
    "wire": (lambda world, screen: setattr(screen, "display_type", "WIRE"), NEAR),
    "bounds": (lambda world, screen: setattr(screen, "display_type", "BOUNDS"), NEAR),
}


@pytest.mark.parametrize(("hide", "met"), WAYS.values(), ids=WAYS)
def test_what_the_viewport_shows_is_met(world, each_caster, screen, hide, met):
    hide(world, screen)
    assert seen(world, world.switch()) == met


def test_ignored_objects(world, each_caster, screen):
    screen.angen_ignored = True
    sensor = world.switch()
    assert seen(world, sensor) == FAR
    screen.angen_ignored = False
    assert seen(world, sensor) == NEAR


def test_an_ignored_objects_children_are_seen(world, each_caster, screen):
    """A room's volume marker may be the parent of furniture."""
    marker = world.box((5, 5, 5), name="marker")
    marker.angen_ignored = True
    screen.parent = marker
    assert seen(world, world.switch()) == NEAR


def test_an_ignored_collection_instance(world, each_caster, screen):
    collection = world.aside("source", screen)
    instance = world.instance("instance", collection)
    sensor = world.switch()
    assert seen(world, sensor) == NEAR
    instance.angen_ignored = True
    assert seen(world, sensor) == FAR


def test_no_surface_no_hit(world, each_caster):
    world.wall(FAR, "far")
    world.link("edges", world.mesh([(-1, 0, -NEAR), (1, 0, -NEAR)], []))
    line = world.bpy.data.curves.new("line", "CURVE")
    spline = line.splines.new("POLY")
    spline.points.add(1)
    spline.points[0].co, spline.points[1].co = (-1, 0, -NEAR, 1), (1, 0, -NEAR, 1)
    world.link("line", line)
    for data in (world.bpy.data.lights.new("lamp", "AREA"), world.bpy.data.cameras.new("camera")):
        world.link("other", data, at=(0, 0, -NEAR))
    world.link("flat", world.bpy.data.objects["far"].data, at=(0, 0, -NEAR)).scale = (0, 0, 0)
    assert seen(world, world.switch()) == FAR


def test_keyed_visibility_is_followed(world, each_caster, figure, screen):
    world.key(screen, "hide_viewport", {1: False, 5: True, 9: False}, "CONSTANT")
    world.switch(threshold=0.2)
    world.scene.frame_end = 12
    recording = world.run()
    found, expected = world.series(recording, "switch", "open"), [0] * 4 + [1] * 4 + [0] * 4
    figure(f"{sum(a != b for a, b in zip(found, expected, strict=True))} of 12 frames wrong")
    assert found == expected


def test_sensors_in_an_excluded_collection_report_nothing(world):
    sensor = world.switch()
    world.switch("other")
    _, layer = in_collection(world, sensor)
    layer.exclude = True
    assert list(world.run().tracks) == ["other"]


def test_a_sensor_that_is_hidden_with_the_eye_still_senses(world, each_caster, screen):
    """Users hide their sensors from view; `enabled` switches them off."""
    moves = {1: (0, 0, 0), 5: (0, 0, -0.04)}
    one = world.switch("one")
    two = world.switch("two")
    for sensor in (one, two):
        world.key(sensor, "location", moves)
    _, layer = in_collection(world, two)
    layer.hide_viewport = True
    one.hide_set(True)
    world.scene.frame_end = 5
    recording = world.run()
    expected = pytest.approx([0.1, 0.09, 0.08, 0.07, 0.06], abs=2e-5)
    assert world.series(recording, "one", "range_m") == expected
    assert world.series(recording, "two", "range_m") == expected


@pytest.mark.parametrize("of", ["object", "collection"])
def test_a_sensor_that_blender_does_not_place_is_refused(world, of):
    """Blender does not evaluate objects disabled in viewports: it would sense at the origin."""
    sensor = world.switch()
    sensor.location = (1, 2, 3)
    collection, _ = in_collection(world, sensor)
    (sensor if of == "object" else collection).hide_viewport = True
    with pytest.raises(AngenError, match=r"switch.*viewport"):
        world.run()
    sensor.angen_sensor.enabled = False
    assert not world.run().tracks


def test_a_sensor_is_placed_where_a_hidden_parent_carries_it(world, screen):
    """Blender evaluates a disabled parent for its child."""
    parent, sensor = world.link("parent", None), world.switch()
    sensor.parent = parent
    parent.hide_viewport = True
    world.key(parent, "location", {1: (0, 0, 0), 3: (0, 0, -0.04)})
    world.scene.frame_end = 3
    ranges = world.series(world.run(), "switch", "range_m")
    assert ranges == pytest.approx([0.1, 0.08, 0.06], abs=2e-5)


def test_a_child_of_a_hidden_parent_is_seen(world, each_caster, screen):
    """Hiding a parent hides only the parent."""
    marker = world.box((5, 5, 0.01), at=(0, 0, -0.05), name="marker")
    marker.hide_viewport = True
    screen.parent = marker
    screen.location.z = -0.05
    assert seen(world, world.switch()) == NEAR
