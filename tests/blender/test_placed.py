# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects that sensors, places and residents name have a place, also where viewports hide them.

An object without a place is an error that names it.
"""

import bpy
import pytest
from bl_ext.user_default.angen_sensors.angen_addon import doctor
from bl_ext.user_default.angen_sensors.angen_addon.advice.sensing import hidden_partner
from bl_ext.user_default.angen_sensors.angen_addon.scene.sensors import AngenError
from test_places import Flat


def left_out(world, obj):
    """Put an object into a separate collection that the view layer excludes."""
    made = bpy.data.collections.new("left out")
    world.scene.collection.children.link(made)
    world.scene.collection.objects.unlink(obj)
    made.objects.link(obj)
    bpy.context.view_layer.layer_collection.children["left out"].exclude = True


def collection_disabled(world, obj):
    left_out(world, obj)
    bpy.context.view_layer.layer_collection.children["left out"].exclude = False
    bpy.data.collections["left out"].hide_viewport = True


def disabled(world, obj):
    obj.hide_viewport = True


def closed_eye(world, obj):
    obj.hide_set(True)


@pytest.fixture
def door(world):
    """Add a contact at (2, 0, 0), whose magnet on the leaf goes 1 m away at frame 5."""
    leaf = world.box((0.1, 0.1, 0.1), (0, 0, 5), "leaf")
    world.key(leaf, "location", {1: (0, 0, 5), 5: (0, 1, 5)}, "CONSTANT")
    magnet = world.link("magnet", None, (2.0, 0.01, -5))
    magnet.parent = leaf
    made = world.sensor("CONTACT", "contact", update_rate=24.0, magnet=magnet)
    made.location = (2, 0, 0)
    world.scene.frame_end = 8
    return magnet


@pytest.mark.parametrize("hide", [disabled, collection_disabled, closed_eye])
def test_a_magnet_that_viewports_hide_moves_with_its_leaf(world, door, hide):
    hide(world, door)
    found = world.run()
    assert world.series(found, "contact", "open") == [False] * 4 + [True] * 4
    far = world.series(found, "contact", "distance_m")
    assert far == pytest.approx([0.01] * 4 + [1.01] * 4, abs=1e-5)


def keyed(world, obj):
    world.key(obj, "location", {1: (2, 0.01, -5), 5: (2, 0.5, -5)})
    obj.hide_viewport = True


def keyed_away(world, obj):
    world.key(obj, "location", {1: (2, 0.01, -5), 5: (2, 0.5, -5)})
    world.key(obj, "hide_viewport", {1: False, 4: True}, "CONSTANT")


@pytest.mark.parametrize(
    ("hide", "words"),
    [
        (left_out, r"'contact': 'magnet' is in no collection.*tick its collection"),
        (keyed, r"'contact': 'magnet' moves and is disabled in viewports.*monitor icon"),
        (keyed_away, r"'contact': 'magnet' moves and is disabled in viewports"),
    ],
)
def test_a_magnet_without_a_place_is_an_error(world, door, hide, words):
    hide(world, door)
    with pytest.raises(AngenError, match=words):
        world.run()


def test_a_sensor_that_keys_hide_is_refused(world):
    switch = world.switch()
    world.key(switch, "location", {1: (0, 0, 0), 9: (0, 0, 1)})
    world.key(switch, "hide_viewport", {1: False, 4: True}, "CONSTANT")
    with pytest.raises(AngenError, match="monitor icon"):
        world.run(1, 6)


@pytest.mark.parametrize("hide", [None, disabled, collection_disabled, closed_eye])
def test_a_place_that_viewports_hide_is_where_it_stands(world, addon_part, hide):
    """It holds for an object that was never evaluated, as in a file that was just opened."""
    flat = Flat(world)
    flat.chair.angen_place.use = "SIT"
    west = world.link("West", None, (1.5, 3.0, 0.0))
    west.angen_place.use = "STAND"
    lamp = world.link("Lamp", bpy.data.lights.new("Lamp", "POINT"), (4, 1, 2.4))
    lamp.angen_place.use = "LAMP"
    switch = lamp.angen_place.switch = world.link("Lamp switch", None, (2.9, 1.0, 1.1))
    switch.parent = west
    switch.location = (1.4, -2.0, 1.1)
    if hide is not None:
        hide(world, switch)
        west.hide_viewport = True
    found = flat.read(addon_part)
    assert found.places["West"].at[:2] == pytest.approx((1.5, 3.0))
    assert found.lamps["Lamp"].at == pytest.approx((2.9, 1.0, 1.1))
    assert not found.problems


def test_a_place_without_a_place_is_a_problem_by_name(world, addon_part):
    flat = Flat(world)
    flat.chair.angen_place.use = "SIT"
    point = world.link("Sofa west", None, (1.5, 3.0, 0.0))
    point.angen_place.use = "STAND"
    world.key(point, "location", {1: (1.5, 3, 0), 9: (1, 3, 0)})
    point.hide_viewport = True
    found = flat.read(addon_part)
    assert list(found.places) == ["Seat"]
    assert found.problems[0].startswith("'Sofa west': moves and is disabled in viewports")


def test_the_doctor_names_what_has_no_place(world, door):
    left_out(world, door)
    hidden = world.switch("hidden")
    hidden.hide_viewport = True
    rig = world.link("Anna", bpy.data.armatures.new("Anna"))
    frame = rig.angen_resident.walking_frame = world.box((0.5, 0.5, 0.9), name="walker")
    world.scene.collection.objects.unlink(frame)
    depsgraph = world.update()
    found = doctor.examine(world.scene, bpy.context.view_layer, depsgraph)
    texts = [one.text for one in found if one.check == "unplaced"]
    assert "'hidden' is disabled in viewports" in texts[0]
    assert texts[1].startswith("'contact' needs 'magnet': 'magnet' is in no collection")
    assert texts[2].startswith("'Anna' needs 'walker'")
    assert all(one.mend for one in found)


def test_a_pad_that_measures_only_what_is_hidden_is_advised_on(physics):
    person = physics.carried("person", (0.2, 0.2, 0.8), (0, 0, 0.82), 70.0)
    physics.pad(partner_object=person)
    (pad,) = physics.world.sensors()
    layer = bpy.context.view_layer
    assert hidden_partner(pad, layer) is None
    person.hide_set(True)
    assert "measures only 'person'" in hidden_partner(pad, layer).problem
    physics.rigid_body(person)
    assert hidden_partner(pad, layer) is None, "physics goes on for what is hidden"
