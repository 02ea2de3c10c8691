# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of all sensors: its order, its search, and what a click does."""

import math
from types import SimpleNamespace

import bpy
import pytest
from mathutils import Quaternion, Vector

ops = bpy.ops.angen
SHOW = 1 << 30


@pytest.fixture
def home(world):
    """Five sensors in two rooms, and things that are none."""
    world.wall(0.02)
    world.box((1, 1, 1), (9, 9, 9), name="a box")
    made = [
        (world.switch("Door b", update_rate=24.0), "hall"),
        (world.switch("Door c", update_rate=24.0, threshold=0.01), "kitchen"),
        (world.pir("Motion a", update_rate=24.0), "Hall 2"),
        (world.sensor("LIGHT", "lamp", enabled=False), "hall"),
        (world.switch("odd", update_rate=24.0, threshold=0.9), ""),
    ]
    for obj, room in made:
        if room:
            obj["room"] = room
    world.scene.frame_set(1)
    world.scene.frame_set(2)
    return world


def table(addon_part, **settings):
    """Names in the table, from top to bottom."""
    chosen = SimpleNamespace(**{"sort": "NAME", "search": "", "reverse": False, **settings})
    objects = list(bpy.context.view_layer.objects)
    arranged = addon_part("panels.table").arranged
    flags, places = arranged(objects, bpy.context.scene, chosen, SHOW)
    assert sorted(places) == list(range(len(objects)))
    rows = sorted(zip(places, flags, objects, strict=True), key=lambda row: row[0])
    return [obj.name for _, flag, obj in rows if flag == SHOW]


def test_only_sensors_by_name(home, addon_part):
    assert table(addon_part) == ["Door b", "Door c", "lamp", "Motion a", "odd"]
    assert table(addon_part, reverse=True) == ["odd", "Motion a", "lamp", "Door c", "Door b"]


def test_by_room(home, addon_part):
    expected = ["Door b", "lamp", "Motion a", "Door c", "odd"]
    assert table(addon_part, sort="ROOM") == expected


def test_by_kind(home, addon_part):
    expected = ["Motion a", "Door b", "Door c", "odd", "lamp"]
    assert table(addon_part, sort="KIND") == expected


def test_by_state_what_is_wrong_comes_first(home, addon_part):
    """'odd' can never open, 'Door c' is open, 'lamp' is off."""
    expected = ["odd", "Door c", "Door b", "Motion a", "lamp"]
    assert table(addon_part, sort="STATE") == expected


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("door", ["Door b", "Door c"]),
        ("HALL", ["Door b", "lamp", "Motion a"]),
        ("hall switch", ["Door b"]),
        ("invalid", ["odd"]),
        ("still", ["Motion a"]),
        ("off", ["lamp"]),
        ("attic", []),
    ],
)
def test_search_looks_at_name_room_kind_and_state(home, addon_part, words, expected):
    assert table(addon_part, search=words) == expected


def test_without_live_values_nothing_is_claimed(home, addon_part):
    home.scene.angen_live = False
    shown = addon_part("panels.readings").shown
    found = {sensor.name: shown(sensor, home.scene) for sensor in home.sensors()}
    assert found["Door c"].text == "No reading" and found["lamp"].text == "Off"
    assert found["Door c"].icon not in {found["lamp"].icon, "RADIOBUT_ON", "RADIOBUT_OFF"}
    home.scene.angen_live = True
    assert shown(home.sensors()[1], home.scene).text.startswith("Open")


def test_show_selects_one(home):
    bpy.data.objects["a box"].select_set(True)
    assert ops.sensor_show(name="Motion a") == {"FINISHED"}
    assert [obj.name for obj in bpy.context.selected_objects] == ["Motion a"]
    assert bpy.context.object.name == "Motion a"
    assert ops.sensor_show(name="odd", extend=True) == {"FINISHED"}
    assert {obj.name for obj in bpy.context.selected_objects} == {"Motion a", "odd"}
    assert bpy.context.object.name == "odd"


def test_show_says_why_not(home):
    with pytest.raises(RuntimeError, match="No sensor of this view layer is called 'a box'"):
        ops.sensor_show(name="a box")
    bpy.data.objects["odd"].hide_set(True)
    before = bpy.context.object
    assert ops.sensor_show(name="odd") == {"CANCELLED"}
    assert bpy.context.object == before
    bpy.data.objects["Door b"].hide_select = True
    assert ops.sensor_show(name="Door b") == {"CANCELLED"}
    home.update()
    bpy.context.view_layer.objects.active = bpy.data.objects["a box"]
    bpy.ops.object.mode_set(mode="EDIT")
    assert not ops.sensor_show.poll()
    bpy.ops.object.mode_set(mode="OBJECT")


def test_a_click_on_a_row_shows_its_sensor(home):
    settings = bpy.context.window_manager.angen_table
    names = [obj.name for obj in bpy.context.view_layer.objects]
    settings.index = names.index("Door c")
    assert bpy.context.object.name == "Door c" and settings.index == names.index("Door c")
    settings.index = names.index("a box")
    assert bpy.context.object.name == "Door c", "that is no row"


def test_the_view_holds_all_that_a_sensor_sees(home, addon_part):
    show = addon_part("operators.show")
    sensor = next(s for s in home.sensors() if s.name == "Motion a")
    sensor.object.location = (5, 6, 7)
    home.update()
    middle, radius = show.surroundings(sensor, bpy.context)
    assert tuple(middle) == pytest.approx((5, 6, 5)) and radius == pytest.approx(2.0)
    view = framed(show, middle, radius, region("WINDOW", 0, 1000, 1000))
    # A lens of 36 mm on Blender's 72 mm wide window sees 45° to each side.
    assert view.view_distance == pytest.approx(1.25 * 2.0 * 2**0.5)
    assert view.view_perspective == "PERSP" and view.view_location == middle


def region(kind, x, width, height=1000):
    return SimpleNamespace(type=kind, x=x, width=width, height=height)


def framed(show, middle, radius, *regions):
    """The view of an area with these regions, moved to a place."""
    view = SimpleNamespace(
        view_perspective="CAMERA",
        view_location=None,
        view_distance=0.0,
        view_rotation=Quaternion(),
    )
    area = SimpleNamespace(regions=regions)
    space = SimpleNamespace(lens=36.0)
    show.frame(SimpleNamespace(space_data=space, region_data=view, area=area), middle, radius)
    return view


def test_what_is_shown_is_beside_the_sidebar(addon_part):
    """A quarter of the window is covered: the middle of the rest is an eighth left of its middle,
    and the place is seen there; the whole sphere fits."""
    show, middle = addon_part("operators.show"), Vector((5, 6, 5))
    regions = region("WINDOW", 100, 1000, 800), region("UI", 850, 250, 800)
    view = framed(show, middle, 2.0, *regions)
    to_the_left = (middle - view.view_location).x / view.view_distance
    assert to_the_left == pytest.approx(-0.25), "of tan 45° to the window's edge"
    assert view.view_location.yz == middle.yz
    half = math.atan(0.75)
    assert view.view_distance * math.sin(half) == pytest.approx(1.25 * 2.0)
    # A sidebar that lies beside the window, not over it, takes nothing.
    view = framed(show, middle, 2.0, regions[0], region("UI", 1100, 250, 800))
    assert view.view_location == middle
