# SPDX-License-Identifier: GPL-3.0-or-later
"""Sensors that come from another file: appended, linked, overridden."""

import bpy
import pytest


@pytest.fixture
def library(world, tmp_path):
    """A file with a switch called "Door", 0.2 m from a wall, in a collection."""
    collection = bpy.data.collections.new("devices")
    world.scene.collection.children.link(collection)
    for obj in (world.switch("Door"), world.wall(0.2, "panel")):
        world.scene.collection.objects.unlink(obj)
        collection.objects.link(obj)
    path = tmp_path / "library.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    world.scene.frame_end = 4
    return path


def bring(library, link):
    with bpy.data.libraries.load(str(library), link=link) as (source, target):
        target.collections = list(source.collections)
    (collection,) = target.collections
    bpy.context.scene.collection.children.link(collection)
    bpy.context.view_layer.update()
    return collection


@pytest.mark.parametrize("link", [False, True])
def test_appended_and_linked_sensors_sense(world, library, link):
    bring(library, link)
    recording = world.run()
    assert world.series(recording, "Door", "range_m") == pytest.approx([0.2] * 4, abs=2e-5)


def test_linked_sensors_follow_the_playhead(world, library):
    bring(library, link=True)
    world.scene.frame_set(2)
    assert bpy.data.objects["Door"].angen_sensor.active


def test_two_sensors_of_the_same_name_are_refused_with_their_files(world, library, addon_part):
    bring(library, link=True)
    world.switch("Door")
    with pytest.raises(addon_part("angen_addon.scene.sensors").AngenError) as error:
        world.run()
    for words in ("2 sensors", "'Door'", "library.blend", "this file", "rename"):
        assert words in str(error.value)
    with pytest.raises(RuntimeError, match="'Door'"):
        bpy.ops.angen.simulate()


def test_bake_passes_over_linked_sensors(world, library, fcurves):
    bring(library, link=True)
    world.switch("Local")
    world.update()
    bpy.ops.angen.simulate()
    assert bpy.ops.angen.bake_keyframes() == {"FINISHED"}
    assert len(fcurves(bpy.data.objects["Local"])) == 2


def test_assign_and_clear_refuse_linked_objects(world, library):
    bring(library, link=True)
    bpy.context.view_layer.objects.active = bpy.data.objects["Door"]
    for operator in (bpy.ops.angen.sensor_clear, bpy.ops.angen.sensor_assign):
        with pytest.raises(RuntimeError, match="linked"):
            operator()


def test_an_overridden_sensor_has_parameters_of_its_own(world, library):
    collection = bring(library, link=True)
    override = collection.override_hierarchy_create(
        world.scene, bpy.context.view_layer, do_fully_editable=True
    )
    assert override is not None
    if collection.name in world.scene.collection.children:
        world.scene.collection.children.unlink(collection)
    world.update()
    sensor = next(o for o in override.all_objects if o.angen_sensor.kind != "NONE")
    sensor.angen_sensor.optical_switch.threshold = 0.3
    world.update()
    assert world.series(world.run(), sensor.name, "open") == [0] * 4
    assert sensor.override_library.reference.angen_sensor.optical_switch.threshold < 0.1


def test_a_collection_instance_of_a_library_has_sensors_and_solids(world, library):
    with bpy.data.libraries.load(str(library), link=True) as (source, target):
        target.collections = list(source.collections)
    instance = world.link("instance", None)
    instance.instance_type, instance.instance_collection = "COLLECTION", target.collections[0]
    sensor = world.switch("Own")
    assert world.range(sensor) == pytest.approx(0.2, abs=2e-5)
    assert list(world.run().tracks) == ["Own", "instance/Door"]
