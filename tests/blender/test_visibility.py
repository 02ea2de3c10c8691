# SPDX-License-Identifier: GPL-3.0-or-later
"""Sensors see what a user sees as solid in the viewport, and nothing else."""

import pytest

NEAR, FAR = 0.1, 0.3


@pytest.fixture
def screen(world):
    """A wall before the far one, which a test hides in its way."""
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


def exclude(world, screen):
    in_collection(world, screen)[1].exclude = True


def hide_its_collection(world, screen):
    in_collection(world, screen)[0].hide_viewport = True


def close_its_collections_eye(world, screen):
    in_collection(world, screen)[1].hide_viewport = True


def hide_in_renders(world, screen):
    screen.hide_render = True
    in_collection(world, screen)[0].hide_render = True


WAYS = {
    "shown": (lambda world, screen: None, NEAR),
    "object": (lambda world, screen: setattr(screen, "hide_viewport", True), FAR),
    "eye": (lambda world, screen: screen.hide_set(True), FAR),
    "excluded": (exclude, FAR),
    "collection": (hide_its_collection, FAR),
    "eye of the collection": (close_its_collections_eye, FAR),
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
    """A room's volume marker may have the furniture under it."""
    marker = world.box((5, 5, 5), name="marker")
    marker.angen_ignored = True
    screen.parent = marker
    assert seen(world, world.switch()) == NEAR


def test_an_ignored_collection_instance(world, each_caster, screen):
    collection = world.bpy.data.collections.new("source")
    world.scene.collection.objects.unlink(screen)
    collection.objects.link(screen)
    instance = world.link("instance", None)
    instance.instance_type, instance.instance_collection = "COLLECTION", collection
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


def test_a_keyed_wall_goes_and_another_comes_at_the_same_frame(world, each_caster, screen):
    other = world.wall(0.2, "other")
    world.key(screen, "hide_viewport", {1: False, 5: True}, "CONSTANT")
    world.key(other, "hide_viewport", {1: True, 5: False}, "CONSTANT")
    world.switch(threshold=0.25)
    world.scene.frame_end = 8
    ranges = world.series(world.run(), "switch", "range_m")
    assert ranges == pytest.approx([NEAR] * 4 + [0.2] * 4, abs=2e-5)


def test_sensors_in_an_excluded_collection_report_nothing(world):
    sensor = world.switch()
    world.switch("other")
    _, layer = in_collection(world, sensor)
    layer.exclude = True
    assert list(world.run().tracks) == ["other"]


def test_a_sensor_that_is_hidden_with_the_eye_still_senses(world, each_caster, screen):
    """Users hide their sensors from view; `enabled` is what switches them off."""
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
def test_a_sensor_that_blender_does_not_place_is_refused(world, addon_part, of):
    """Disabled in viewports it is not evaluated: it would sense at the origin."""
    sensor = world.switch()
    sensor.location = (1, 2, 3)
    collection, _ = in_collection(world, sensor)
    (sensor if of == "object" else collection).hide_viewport = True
    with pytest.raises(
        addon_part("angen_addon.scene.sensors").AngenError, match=r"switch.*viewport"
    ):
        world.run()
    sensor.angen_sensor.enabled = False
    assert not world.run().tracks


def test_a_sensor_is_placed_where_a_hidden_parent_carries_it(world, screen):
    """A parent that is disabled in viewports is evaluated for its child's sake."""
    parent, sensor = world.link("parent", None), world.switch()
    sensor.parent = parent
    parent.hide_viewport = True
    world.key(parent, "location", {1: (0, 0, 0), 3: (0, 0, -0.04)})
    world.scene.frame_end = 3
    ranges = world.series(world.run(), "switch", "range_m")
    assert ranges == pytest.approx([0.1, 0.08, 0.06], abs=2e-5)


def test_a_child_of_a_hidden_parent_is_seen(world, each_caster, screen):
    """Hiding a parent hides it alone."""
    marker = world.box((5, 5, 0.01), at=(0, 0, -0.05), name="marker")
    marker.hide_viewport = True
    screen.parent = marker
    screen.location.z = -0.05
    assert seen(world, world.switch()) == NEAR
