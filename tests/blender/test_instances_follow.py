# SPDX-License-Identifier: GPL-3.0-or-later
"""Whatever in an instance changes during a run is seen, while what has no part in it moves at every
frame: instances are listed anew only where something that they hang on has changed."""

import bpy
import pytest

SWITCHED = 13


@pytest.fixture
def stage(world, each_caster):
    """A switch with a plate 0.2 m ahead that a collection instance shows, and a walker elsewhere
    that moves all the time. `plate` is in the collection `inner`, which the holder `near` shows."""
    world.switch(range_max=1.0, threshold=0.5)
    walker = world.box((0.1, 0.1, 0.1), at=(5, 0, 0), name="walker")
    world.key(walker, "location", {1: (5, 0, 0), 48: (6, 0, 0)})
    world.inner = bpy.data.collections.new("inner")
    world.plate = world.wall(0.2, "plate", 0.1)
    world.scene.collection.objects.unlink(world.plate)
    world.inner.objects.link(world.plate)
    world.near = holder(world, "near", world.inner)
    return world


def holder(world, name, collection):
    made = world.link(name, None)
    made.instance_type, made.instance_collection = "COLLECTION", collection
    return made


def at_switch(world, obj, path, before, after):
    world.key(obj, path, {1: before, SWITCHED: after}, "CONSTANT")


def part_moves(world):
    at_switch(world, world.plate, "location", (0, 0, -0.2), (3, 0, -0.2))


def part_is_hidden(world):
    at_switch(world, world.plate, "hide_viewport", False, True)


def part_is_moved_by_its_parent(world):
    world.plate.parent = arm = bpy.data.objects.new("arm", None)
    world.inner.objects.link(arm)
    at_switch(world, arm, "location", (0, 0, 0), (3, 0, 0))


def part_changes_shape(world):
    world.plate.shape_key_add(name="flat")
    away = world.plate.shape_key_add(name="away")
    for point in away.data:
        point.co.x += 3
    at_switch(world, world.plate.data.shape_keys, 'key_blocks["away"].value', 0.0, 1.0)


def holder_moves(world):
    at_switch(world, world.near, "location", (0, 0, 0), (3, 0, 0))


def holder_is_moved_by_a_constraint(world):
    target = world.link("target", None)
    world.near.constraints.new("COPY_LOCATION").target = target
    at_switch(world, target, "location", (0, 0, 0), (3, 0, 0))


def holder_is_hidden(world):
    at_switch(world, world.near, "hide_viewport", False, True)


def holder_within_a_holder_moves(world):
    outer = bpy.data.collections.new("outer")
    world.scene.collection.objects.unlink(world.near)
    outer.objects.link(world.near)
    holder(world, "far", outer)
    at_switch(world, world.near, "location", (0, 0, 0), (3, 0, 0))


def instancer_by_vertices_moves(world):
    world.scene.collection.objects.unlink(world.near)
    points = world.link("points", world.mesh([(0, 0, 0)], []))
    points.instance_type = "VERTS"
    world.inner.objects.unlink(world.plate)
    world.scene.collection.objects.link(world.plate)
    world.plate.parent = points
    at_switch(world, points, "location", (0, 0, 0), (3, 0, 0))


CHANGES = [
    part_moves,
    part_is_hidden,
    part_is_moved_by_its_parent,
    part_changes_shape,
    holder_moves,
    holder_is_moved_by_a_constraint,
    holder_is_hidden,
    holder_within_a_holder_moves,
    instancer_by_vertices_moves,
]


@pytest.mark.parametrize("change", CHANGES)
def test_a_change_within_an_instance_is_seen(stage, change):
    change(stage)
    rows = stage.log(stage.run())
    assert [(row[1], row[5]) for row in rows] == [("1", "0"), (str(SWITCHED), "1")]
