# SPDX-License-Identifier: GPL-3.0-or-later
"""The objects that light depends on or not, and the state of the file after a measurement."""

import math
import tempfile

import bpy
import pytest
from light_stage import UP, ball, facing, lamp, lux, material, measure, part, plate, request
from tiers import mostly_slow

SUN = 1.0


@pytest.fixture
def shade(world):
    """Add a sun, and a plate that shades the sensor."""
    lamp(world, "SUN")
    return plate(world, 4.0, (0, 0, 1), (0, 0, -1), material(0.001))


def is_shaded():
    found = lux(request(samples=16))
    assert found == pytest.approx(0.0, abs=0.01) or found == pytest.approx(SUN, rel=0.01)
    return found < 0.5


def layer_of(collection):
    return bpy.context.view_layer.layer_collection.children[collection.name]


def put_in_collection(obj):
    collection = bpy.data.collections.new("set")
    bpy.context.scene.collection.children.link(collection)
    bpy.context.scene.collection.objects.unlink(obj)
    collection.objects.link(obj)
    return collection


HIDING = {
    "eye": lambda o, c: o.hide_set(True),
    "monitor": lambda o, c: setattr(o, "hide_viewport", True),
    "excluded": lambda o, c: setattr(layer_of(c), "exclude", True),
    "eye of the collection": lambda o, c: setattr(layer_of(c), "hide_viewport", True),
    "monitor of the collection": lambda o, c: setattr(c, "hide_viewport", True),
    "ignored": lambda o, c: setattr(o, "angen_ignored", True),
    "lines in the viewport, nothing in renders": lambda o, c: (
        setattr(o, "hide_render", True),
        setattr(o, "display_type", "WIRE"),
    ),
}
NOT_HIDING = {
    "camera in the outliner": lambda o, c: setattr(o, "hide_render", True),
    "camera of the collection": lambda o, c: setattr(c, "hide_render", True),
    "not selectable": lambda o, c: setattr(o, "hide_select", True),
}


@pytest.mark.parametrize("way", [*HIDING, *NOT_HIDING])
def test_what_the_viewport_shows_is_there(shade, way):
    collection = put_in_collection(shade)
    assert is_shaded()
    {**HIDING, **NOT_HIDING}[way](shade, collection)
    assert is_shaded() == (way in NOT_HIDING)


@pytest.mark.parametrize("way", [*HIDING, *NOT_HIDING])
def test_so_are_lamps(world, way):
    if way.startswith("lines"):
        pytest.skip("lamps are always lines")
    sun = lamp(world, "SUN")
    collection = put_in_collection(sun)
    HIDING.get(way, NOT_HIDING.get(way))(sun, collection)
    expected = SUN * (way in NOT_HIDING)
    assert lux(request(samples=4)) == pytest.approx(expected, rel=1e-3)


def test_a_shown_object_stands_where_its_parent_and_constraints_put_it(world, shade):
    shade.hide_render = True
    shade.location.x = 50
    parent = world.link("parent", None, (-25, 0, 0))
    shade.parent = parent
    constraint = shade.constraints.new("COPY_LOCATION")
    constraint.target = world.link("target", None, (-25, 0, 0))
    constraint.use_offset = True
    constraint.use_z = False
    world.update()
    assert is_shaded() == (abs(shade.matrix_world.translation.x) < 2)
    constraint.influence = 0.0
    world.update()
    assert not is_shaded()


# Whole frames and fractions, before the first, and late in a day; frames in between are shaded.
MOMENTS = (-1199.0, -721.5, -1.0, 0.0, 7.0, 7.25, 1000.1, 487705.0, 864001.0)


@pytest.mark.parametrize("mapped", mostly_slow([(100, 100), (100, 50)], (100, 50), tuples=False))
@pytest.mark.parametrize("moment", MOMENTS)
def test_light_is_that_of_the_very_frame(world, shade, moment, mapped):
    whole = math.floor(moment)
    world.scene.render.frame_map_old, world.scene.render.frame_map_new = mapped
    world.scene.frame_set(whole, subframe=moment - whole)
    now = world.scene.frame_current_final
    # The plate is there at that frame only.
    for at, x in ((now - 0.125, -5e4), (now, 0.0), (now + 0.125, 5e4)):
        shade.location.x = x
        shade.keyframe_insert("location", index=0, frame=at)
    world.scene.frame_set(whole, subframe=moment - whole)
    assert is_shaded()
    world.scene.frame_set(whole + 1, subframe=moment - whole)
    assert not is_shaded()


def test_a_sensor_looks_through_its_own_housing_and_every_light_sensors(world):
    lamp(world, "SUN")
    for name in ("sensor", "other"):
        sensor = world.sensor("LIGHT", name)
        housing = world.box((0.1, 0.1, 0.1), name=f"{name} housing")
        housing.parent = sensor
    assert lux(request(samples=4)) == pytest.approx(SUN, rel=1e-3)


@pytest.mark.parametrize("place", [(0, 0, -1), (0, 0, 1), (1, 0, 0), (-1, 0, 0), (0, 1, 0)])
def test_a_sensor_exactly_on_a_wall_reads_its_room(world, place):
    """It gets only the light inside: 100 W in the middle; outside it is dark."""
    box = world.box((2, 2, 2))
    box.data.materials.append(material(0.001))
    lamp(world, "POINT", at=(0, 0, 0), energy=100.0)
    inwards = tuple(-c for c in place)
    found = lux(request(matrix=facing(inwards, place), samples=64))
    assert found == pytest.approx(100 / (4 * 3.14159265), rel=0.005)


def test_other_sensors_do_not_matter_to_the_bit(world):
    box = world.box((4, 4, 4))
    box.data.materials.append(material(0.5))
    lamp(world, "POINT", at=(0.5, 0, 1), shadow_soft_size=0.2, energy=10.0)
    me = request("me", facing((1, 0, 0), (-1.5, 0, 0)), samples=16)
    walls = request("walls", facing((1, 0, 0)), method="FOUR_WALL", samples=64)
    alone = measure(me, walls)
    others = [
        request(f"{kind} {i}", facing(UP, (i / 10, 0, 0)), method=kind, samples=16 + i)
        for i in range(3)
        for kind in ("FOUR_WALL", "ILLUMINANCE")
    ]
    others += [request(f"same {i}", facing(UP, (i / 10, 1, 0)), samples=16) for i in range(5)]
    for asked in ([*others, me, walls], [walls, me, *others[::-1]], [me, *others[:3], walls]):
        found = measure(*asked)
        assert (found["me"], found["walls"]) == (alone["me"], alone["walls"])


def test_the_same_light_whatever_the_number_of_threads(world):
    ball(world, 2.0, material(0.5), rings=16)
    lamp(world, "POINT", at=(0, 0, 0))
    asked = [request(f"s{i}", facing((1, 0, 0), (-1, i / 10, 0)), samples=16) for i in range(5)]
    assert measure(*asked) == measure(*asked)


@pytest.fixture
def busy(world, shade, monkeypatch, tmp_path):
    """Set up a user at work: Edit Mode, a selection, hidden objects, a sub-frame, handlers."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    edited = world.box((1, 1, 1), at=(5, 0, 0))
    world.box((1, 1, 1), at=(9, 0, 0), name="hidden").hide_render = True
    world.key(shade, "location", {1: (0, 0, 1), 48: (9, 0, 1)})
    world.scene.frame_set(7, subframe=0.25)
    shade.select_set(True)
    bpy.context.view_layer.objects.active = edited
    bpy.ops.object.mode_set(mode="EDIT")
    heard = []
    lists = [
        getattr(bpy.app.handlers, n)
        for n in ("render_pre", "render_write", "frame_change_post", "object_bake_pre")
    ]

    def hear(*_):
        heard.append(True)

    for handlers in lists:
        handlers.append(hear)
    yield world, heard
    for handlers in lists:
        handlers.remove(hear)


ALL_WAYS = [request("lux", samples=4), request("walls", method="FOUR_WALL", samples=4)]


def test_a_measurement_leaves_everything_as_it_was(busy):
    world, heard = busy
    before = world.state()
    measure(*ALL_WAYS)
    assert world.state() == before
    assert not heard


def test_so_does_one_that_fails(busy, monkeypatch):
    world, _ = busy
    before = world.state()

    def fail(path):
        raise OSError(f"no space left for {path}")

    monkeypatch.setattr(part("light.engine"), "read_layers", fail)
    with pytest.raises(OSError, match="no space"):
        measure(*ALL_WAYS)
    assert world.state() == before
