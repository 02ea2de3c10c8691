# SPDX-License-Identifier: GPL-3.0-or-later
"""Places of residents: marks of doors and seats, unreachable places, and rooms."""

import json

import bpy
import numpy as np
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.commands.command_line import run_command as run
from bl_ext.user_default.angen_sensors.angen_addon.doctor import CHECKS as checks
from bl_ext.user_default.angen_sensors.angen_addon.doctor import Examined
from bl_ext.user_default.angen_sensors.angen_addon.layout.describe import describe
from bl_ext.user_default.angen_sensors.angen_addon.scene.sensors import known_rooms as known
from bl_ext.user_default.angen_sensors.residents.acting.unreached_places import unreached
from bl_ext.user_default.angen_sensors.residents.blender.places import read_places
from bl_ext.user_default.angen_sensors.residents.blender.standing import AngenError as error
from bl_ext.user_default.angen_sensors.residents.operators import places as button
from mathutils import Matrix, Vector
from panel_layout import drawn

WALLS = [
    # Centre and size in m: a flat of two rooms, with a doorway from 1.5 to 2.4 m between them.
    ((3.0, 2.0, -0.05), (6.2, 4.2, 0.1)),
    ((3.0, -0.05, 1.25), (6.2, 0.1, 2.5)),
    ((3.0, 4.05, 1.25), (6.2, 0.1, 2.5)),
    ((-0.05, 2.0, 1.25), (0.1, 4.0, 2.5)),
    ((6.05, 2.0, 1.25), (0.1, 4.0, 2.5)),
    ((3.0, 0.75, 1.25), (0.1, 1.5, 2.5)),
    ((3.0, 3.2, 1.25), (0.1, 1.6, 2.5)),
    ((3.0, 1.95, 2.3), (0.1, 0.9, 0.4)),
]


class Flat:
    """A flat with a chair, its back to the wall, in the left room and a bed in the right one."""

    def __init__(self, world, metres=1.0, origin=(0, 0, 0)):
        self.world, self.metres, self.origin = world, metres, Vector(origin)
        world.scene.unit_settings.scale_length = metres
        for number, (at, size) in enumerate(WALLS):
            self.box(f"wall {number}", size, at)
        self.box("Seat", (0.45, 0.45, 0.45), (0.5, 0.5, 0.225))
        back = self.box("Back", (0.05, 0.45, 0.5), (0.3, 0.5, 0.7))
        self.chair = bpy.data.objects["Seat"]
        world.update()
        back.parent = self.chair
        back.matrix_parent_inverse = self.chair.matrix_world.inverted()
        self.bed = self.box("Bed", (2.0, 0.9, 0.5), (4.9, 3.5, 0.25))
        self.head = self.box("Head", (0.05, 0.9, 0.9), (5.95, 3.5, 0.45))
        world.update()
        self.head.parent = self.bed
        self.head.matrix_parent_inverse = self.bed.matrix_world.inverted()

    def at(self, point):
        return (self.origin + Vector(point)) / self.metres

    def box(self, name, size, at):
        return self.world.box([s / self.metres for s in size], self.at(at), name)

    def door(self, scale=(1, 1, 1)):
        """Add a door whose origin is its hinge, at y = 1.5, on the face to which it opens: left."""
        x, y, z = (1 / s for s in scale)
        leaf = self.world.box((0.04 * x / self.metres, 0.88 * y / self.metres,
                               2.0 * z / self.metres), name="Door")  # fmt: skip
        shift = Vector((0.02 * x, 0.44 * y, 1.0 * z)) / self.metres
        leaf.data.transform(Matrix.Translation(shift))
        leaf.location, leaf.scale = self.at((2.95, 1.51, 0.01)), scale
        return leaf

    def read(self, part):
        depsgraph = self.world.update()
        return part("residents.blender.places").read_places(self.world.scene, depsgraph)

    def shown(self, point):
        return np.asarray(point) - np.array(self.origin)


@pytest.fixture(params=[(1.0, (0, 0, 0)), (0.01, (0, 0, 0)), (1.0, (4000, -9000, 30))])
def flat(request, world):
    return Flat(world, *request.param)


def test_a_seat_a_bed_and_the_door_between_them(flat, addon_part):
    for obj, use in ((flat.chair, "SIT"), (flat.bed, "LIE"), (flat.door(), "DOOR")):
        obj.angen_place.use = use
    found = flat.read(addon_part)
    seat, bed, door = found.places["Seat"], found.places["Bed"], found.doors["Door"]
    # The guesses: the back is to the wall, the head at the board.
    assert np.allclose(flat.shown(seat.target), (0.5, 0.5, 0.45), atol=0.08)
    assert seat.yaw == pytest.approx(0.0, abs=1e-3)
    assert seat.height == pytest.approx(0.45, abs=0.02)
    assert np.allclose(flat.shown(seat.at)[:2], seat.target[:2] + (0.57, 0) - flat.origin[:2],
                       atol=0.05)  # fmt: skip
    assert bed.yaw == pytest.approx(0.0, abs=1e-3)
    # With its board.
    assert bed.size == pytest.approx(2.075, abs=1e-3)
    assert flat.shown(bed.edge)[1] == pytest.approx(3.05 + 0.22, abs=0.02)
    assert np.allclose(flat.shown(door.handle_at(door.closed))[1:], (2.28, 1.05), atol=0.03)
    assert flat.shown(door.handle_at(door.open))[0] == pytest.approx(2.95 - 0.77, abs=0.03)
    assert door.side(door.handle_at(door.open)) == door.side(seat.at) == 1.0
    assert unreached(found) == []


def test_marks_that_a_day_cannot_use_are_told_with_the_way_out(world, addon_part):
    """A door in an instance has no leaf to turn; marks inside an instance are not of this scene."""
    flat = Flat(world)
    flat.chair.angen_place.use = "SIT"
    leaf = world.aside("leaf", flat.door())
    door = world.instance("Door of an asset", leaf)
    door.angen_place.use = "DOOR"
    (problem,) = flat.read(addon_part).problems
    assert problem.startswith("'Door of an asset': it is an instance") and "Make Insta" in problem
    bpy.data.objects.remove(door)
    world.instance("Home", world.aside("home", *bpy.context.scene.objects))
    with pytest.raises(error, match="the marks of 'Seat' are in instances"):
        flat.read(addon_part)


@pytest.mark.parametrize("scale", [(1, 1, 1), (0.5, 2, 3), (-1, 1, 1), (1, 1, -1)])
def test_a_leaf_that_is_scaled_or_mirrored_is_the_same_door(world, addon_part, scale):
    flat = Flat(world)
    leaf = flat.door(scale)
    leaf.angen_place.use = "DOOR"
    flat.chair.angen_place.use = "SIT"
    door = flat.read(addon_part).doors["Door"]
    assert np.allclose(door.handle_at(0.0)[1:], (2.28, 1.05), atol=0.03)
    # The leaf as Blender would show it, turned by hand.
    there = Matrix(door.moved(door.open).tolist()) @ leaf.matrix_world
    points = np.array([there @ v.co for v in leaf.data.vertices])
    assert np.ptp(points, axis=0) == pytest.approx((0.88, 0.04, 2.0), abs=1e-4)


def test_a_door_that_slides(world, addon_part):
    flat = Flat(world)
    mark = flat.door().angen_place
    mark.use, mark.motion, mark.slide = "DOOR", "SLIDING", 0.8
    flat.chair.angen_place.use = "SIT"
    door = flat.read(addon_part).doors["Door"]
    ends = [door.line(opening, 2)[:, 1] for opening in (door.closed, door.open)]
    assert sorted(ends[0]) == pytest.approx([1.51, 2.39], abs=0.01)
    assert abs(ends[1] - ends[0]) == pytest.approx([0.8, 0.8])
    mark.other_side = True
    other = flat.read(addon_part).doors["Door"]
    assert other.line(other.open, 2)[0, 1] != pytest.approx(ends[1][0], abs=0.5)


def test_a_cupboard_is_opened_from_its_front_and_is_no_doorway(flat, addon_part):
    """Its leaf is on the wall side of the left room; the floor is the same with and without it."""
    flat.chair.angen_place.use = "SIT"
    flat.box("Carcass", (0.6, 0.3, 1.8), (1.2, 3.84, 0.9))
    leaf = flat.box("Leaf", (0.58, 0.02, 1.7), (1.2, 3.68, 0.9))
    leaf.angen_place.use = "USE"
    before = flat.read(addon_part).storeys[0].floor.free
    leaf.angen_place.use = "CUPBOARD"
    leaf.angen_place.motion = "LEFT"
    found = flat.read(addon_part)
    assert found.problems == () and unreached(found) == []
    place, door = found.places["Leaf"], found.doors["Leaf"]
    assert place.yaw == pytest.approx(np.pi / 2, abs=0.1)
    assert 2.9 < flat.shown(place.at)[1] < 3.6
    shut, opened = (flat.shown(door.handle_at(w))[1] for w in (door.closed, door.open))
    assert opened < shut - 0.4
    assert (found.storeys[0].floor.free == before).all()


@pytest.mark.parametrize(
    ("obstacle", "lost"),
    [
        ("no mark on the door", ["Bed"]),
        ("a cupboard in the doorway", ["Bed"]),
        ("a chair inside a block", ["Seat"]),
        ("nothing", []),
    ],
)
def test_places_that_nobody_gets_to(world, addon_part, obstacle, lost):
    flat = Flat(world)
    leaf = flat.door()
    if obstacle != "no mark on the door":
        leaf.angen_place.use = "DOOR"
    if obstacle == "a cupboard in the doorway":
        flat.box("Cupboard", (0.5, 1.4, 2.0), (3.5, 2.0, 1.0))
    if obstacle == "a chair inside a block":
        flat.box("Block", (1.8, 3.9, 2.2), (0.9, 1.95, 1.1))
    for name, at in (("Left", (2.6, 3.0, 0)), ("Left too", (2.6, 2.5, 0)), ("Third", (2.6, 1, 0))):
        obj = world.link(name, None, at)
        obj.angen_place.use = "STAND"
    flat.chair.angen_place.use, flat.bed.angen_place.use = "SIT", "LIE"
    found = unreached(flat.read(addon_part))
    assert [missing.place.name for missing in found] == lost
    for missing in found:
        # As far as the wall, or the block.
        assert missing.nearest[0] < 3.0
        assert missing.short > 0.5


def test_two_floors_and_none(world, addon_part):
    flat = Flat(world)
    flat.chair.angen_place.use = "SIT"
    up = world.box((3.0, 3.0, 0.1), (1.5, 1.5, 2.75), "Upper floor")
    world.link("Upstairs", None, (1.0, 1.0, 2.8)).angen_place.use = "STAND"
    found = flat.read(addon_part)
    assert [round(storey.height, 2) for storey in found.storeys] == [0.0, 2.8]
    assert found.places["Upstairs"].storey == 1
    for obj in [*bpy.data.objects]:
        if obj.name.startswith("wall") or obj == up:
            bpy.data.objects.remove(obj)
    flat.chair.location.z += 50
    with pytest.raises(error, match="no floor"):
        flat.read(addon_part)
    flat.chair.angen_place.use = bpy.data.objects["Upstairs"].angen_place.use = "NONE"
    with pytest.raises(error, match="nothing is marked"):
        flat.read(addon_part)


def locked_in(world):
    """Add a bed behind an unmarked door, and a path to it that ends there."""
    flat = Flat(world)
    flat.door()
    flat.chair.angen_place.use, flat.bed.angen_place.use = "SIT", "LIE"
    for number, y in enumerate((1.0, 2.5, 3.0)):
        world.link(f"Point {number}", None, (2.6, y, 0)).angen_place.use = "STAND"
    return flat


def test_check_places_draws_how_far_one_gets(world):
    flat = locked_in(world)
    for _ in range(2):
        assert bpy.ops.angen.places_check() == {"FINISHED"}
        ways = [obj for obj in bpy.data.objects if obj.name.startswith("Way to")]
        assert [obj.name for obj in ways] == ["Way to Bed"]
    assert ways[0].angen_ignored and ways[0].hide_render
    end = ways[0].data.splines[0].points[-1].co
    assert 2.5 < end.x < 3.0 and end.z == pytest.approx(0.05, abs=0.01)
    count, (mend, told) = button.checked
    assert count == "5 marked: 1 place cannot be reached"
    assert told.startswith("'Bed' cannot be reached from 'Point 0': residents get as far as (2.")
    # In front of the door, not where a wall is nearest to the bed.
    assert 1.6 < end.y < 2.3
    assert told.endswith("; 'Door' is between")
    assert mend == "No resident opens 'Door': mark each that is a door with Use: Door"
    bpy.data.objects["Door"].angen_place.use = "DOOR"
    bpy.ops.angen.places_check()
    assert not [obj for obj in bpy.data.objects if obj.name.startswith("Way to")]
    assert button.checked == ("6 marked (5 places, 1 door): all places can be reached", ())
    flat.chair.angen_place.use = "NONE"


def test_what_is_marked_is_counted_alike_before_and_after_a_check(world):
    locked_in(world)
    bpy.data.objects["Door"].angen_place.use = "DOOR"
    button.checked = None
    assert "6 marked, not checked" in drawn("ANGEN_PT_places").labels
    bpy.ops.angen.places_check()
    labels = " ".join(drawn("ANGEN_PT_places").labels)
    assert "6 marked (5 places, 1 door): all places can be reached" in labels


def test_esc_amid_a_check_leaves_what_was_found_before(world, addon_part):
    locked_in(world)
    bpy.ops.angen.places_check()
    before = button.checked
    check = addon_part("residents.operators.places").ANGEN_OT_places_check
    work, enough = check._begin(None, bpy.context), addon_part("sensor_logic.progress").Enough
    shares = [next(work).share for _ in range(8)]
    assert shares == sorted(shares) and 0.0 <= shares[0] < shares[-1] < 1.0
    with pytest.raises(enough):
        work.throw(enough)
    assert button.checked == before and "Way to Bed" in bpy.data.objects


def test_places_behind_one_thing_are_told_together(world):
    locked_in(world)
    for name in ("Desk", "Shelf"):
        world.link(name, None, (5.0, 1.0 + len(name) / 5.0, 0)).angen_place.use = "STAND"
    bpy.ops.angen.places_check()
    count, (mend, told) = button.checked
    assert count == "7 marked: 3 places cannot be reached" and mend.startswith(
        "No resident opens 'Door'"
    )
    assert told.startswith("'Bed', 'Desk', 'Shelf' cannot be reached from 'Point 0': residents get")
    assert " short of 'Desk'; " in told or " short of 'Bed'; " in told
    assert told.endswith("; 'Door' is between")


def test_the_command_tells_the_same(world, tmp_path, capsys):
    locked_in(world)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "flat.blend"))
    capsys.readouterr()
    assert run(["places"]) == 1
    table = capsys.readouterr().out.splitlines()
    assert table[0].split() == ["Bed", "Lie"]
    assert table[-1].startswith("'Bed' cannot be reached from 'Point 0'")
    assert run(["places", "--json"]) == 1
    told = json.loads(capsys.readouterr().out)
    assert {p["name"]: p["reached"] for p in told["places"]} == {
        "Bed": False, "Point 0": True, "Point 1": True, "Point 2": True, "Seat": True,
    }  # fmt: skip
    assert told["places"][0]["between"] == "Door"


@pytest.mark.parametrize(
    ("use", "count"), [("SIT", 3), ("LIE", 3), ("DOOR", 13), ("CURTAIN", 3), ("LAMP", 0)]
)
def test_arrows_of_a_leaf(world, addon_part, use, count):
    """A seat has an arrow along its direction, a door its swing from the free edge on."""
    leaf = Flat(world).door()
    world.update()
    leaf.angen_place.use = use
    lines = addon_part("residents.blender.places_drawn").lines(leaf, 1.0)
    assert lines.shape == (count, 2, 3)
    if use == "DOOR":
        assert lines[0, 0] == pytest.approx((2.95, 2.39, 0.05), abs=0.02)
        assert lines[-1, 1] == pytest.approx((2.07, 1.51, 0.05), abs=0.02)


def test_arrows_are_those_of_the_selected_places_until_the_places_are_checked(world, addon_part):
    flat = Flat(world)
    leaf, bed = flat.door(), world.box((2, 1, 0.4), (1, 3, 0.2), "Bed")
    leaf.angen_place.use, bed.angen_place.use = "DOOR", "LIE"
    drawn = addon_part("residents.blender.places_drawn")
    for obj in bpy.context.selected_objects:
        obj.select_set(False)
    assert drawn.shown(bpy.context) == []
    bed.select_set(True)
    assert drawn.shown(bpy.context) == [bed]
    assert bpy.ops.angen.places_check() == {"FINISHED"}
    assert set(drawn.shown(bpy.context)) == {
        obj for obj in bpy.data.objects if obj.angen_place.use != "NONE"
    }


def test_no_arrow_has_the_colour_of_a_sensors_state(addon_part):
    drawn = addon_part("residents.blender.places_drawn")
    looks = addon_part("angen_addon.view.overlay.picture").LOOKS
    for arrow in (drawn.REST, drawn.USED, drawn.LEAF, drawn.LIT):
        for look in looks.values():
            assert np.linalg.norm(np.subtract(arrow, look.colour)) > 0.25


# Rooms of places


@pytest.fixture
def studio(world):
    """Add one open room of 6 x 4 m with a detector at each end, a table and two chairs between."""
    world.box((6, 4, 0.1), (3, 2, -0.05), "Floor")
    for name, x, room in (("PIR a", 0.3, "sleeping"), ("PIR b", 5.7, "kitchen")):
        sensor = world.sensor("PIR", name)
        sensor.location, sensor.angen_sensor.room = (x, 2, 2.2), room
    for name, x in (("Chair 1", 2.3), ("Chair 2", 3.7)):
        world.box((0.4, 0.4, 0.45), (x, 2, 0.225), name).angen_place.use = "SIT"

    def rooms():
        depsgraph = world.update()
        found = read_places(world.scene, depsgraph)
        return {name: (p.room, p.room_guessed) for name, p in found.places.items()}

    return rooms


def test_rooms_between_which_is_no_wall_are_guessed(studio):
    assert all(guessed for _, guessed in studio().values())
    home = Examined(
        bpy.context.scene, bpy.context.view_layer, bpy.context.evaluated_depsgraph_get()
    )
    ((text, _, objects),) = checks["rooms"](home)
    assert "'Chair 1', 'Chair 2'" in text and objects == ("Chair 1", "Chair 2")


def test_a_room_that_is_set_or_named_by_a_collection_is_not_guessed(studio):
    bpy.data.objects["Chair 1"].angen_place.room = "dining"
    kitchen = bpy.data.collections.new("Kitchen")
    bpy.context.scene.collection.children.link(kitchen)
    kitchen.objects.link(bpy.data.objects["Chair 2"])
    assert studio() == {"Chair 1": ("dining", False), "Chair 2": ("kitchen", False)}


def test_a_volume_that_marks_a_room_counts(studio, world):
    volume = world.box((6, 4, 2.5), (3, 2, 1.25), "dining")
    volume.angen_ignored, volume.display_type = True, "WIRE"
    assert set(studio().values()) == {("dining", False)}


# The room of a sensor


ops = bpy.ops.angen


@pytest.fixture
def listed(world):
    """Return the rooms by sensor in `list` and in the report."""

    def rooms():
        return {s.name: describe(s)["room"] for s in world.sensors()}

    return rooms


def test_the_room_is_a_field_and_the_property_of_older_files_still_counts(world, listed):
    world.switch("new").angen_sensor.room = "Hall"
    world.switch("old")["room"] = "Kitchen"
    both = world.switch("both")
    both["room"], both.angen_sensor.room = "Attic", "Cellar"
    world.switch("none")
    assert listed() == {"new": "Hall", "old": "Kitchen", "both": "Cellar", "none": ""}


def test_the_field_offers_the_rooms_of_the_file(world):
    world.switch("a").angen_sensor.room = "Hall"
    world.switch("b")["room"] = "kitchen"
    world.switch("c").angen_sensor.room = "Hall"
    mark = world.box((1, 1, 1))
    mark.angen_ignored, mark.angen_sensor.room = True, "Alcove"
    assert known(None, None, "") == ["Alcove", "Hall", "kitchen"]
    assert known(None, None, "L") == ["Alcove", "Hall"]


def test_noting_the_room_keeps_the_recording(world):
    sensor = world.switch("door")
    world.update()
    ops.simulate()
    sensor.angen_sensor.room = "Hall"
    world.update()
    assert ops.export_events.poll()


def test_a_sensor_keeps_its_room_in_a_file(world, tmp_path, listed):
    world.switch("door").angen_sensor.room = "Hall"
    path = str(tmp_path / "home.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.wm.open_mainfile(filepath=path)
    assert listed() == {"door": "Hall"}


@pytest.mark.parametrize(
    ("width", "y", "own_sides"),
    [
        # Free on both sides; with a side at the wall; for one.
        (1.6, 2.3, True), (1.4, 3.28, False), (1.0, 2.0, None),
    ],
)  # fmt: skip
def test_a_bed_that_is_wide_enough_has_a_side_for_each_of_two(
    world, addon_part, width, y, own_sides
):
    flat = Flat(world)
    for obj in (flat.bed, flat.head):
        bpy.data.objects.remove(obj)
    bed = flat.box("Double", (2.0, width, 0.5), (4.9, y, 0.25))
    bed.angen_place.use, bed.angen_place.facing = "LIE", np.pi / 2
    place = flat.read(addon_part).places["Double"]
    if own_sides is None:
        assert place.sides == ()
        return
    one, other = place.sides
    assert {one.side, other.side} == {1, 2} and one.name == other.name == "Double"
    assert abs(one.target[1] - other.target[1]) == pytest.approx(width / 2, abs=0.02)
    assert (one.target[1] + other.target[1]) / 2 == pytest.approx(y, abs=0.02)
    apart = abs(one.at[1] - other.at[1])
    assert apart > width if own_sides else apart < 0.05
    assert one.target[2] == other.target[2] == pytest.approx(0.5, abs=0.01)


@pytest.mark.parametrize(("width", "count"), [(1.8, 2), (0.9, 0)])
def test_a_sofa_that_is_wide_enough_has_seats_for_two(world, addon_part, width, count):
    flat = Flat(world)
    sofa = flat.box("Sofa", (0.8, width, 0.45), (0.6, 2.5, 0.225))
    sofa.angen_place.use, sofa.angen_place.facing = "SIT", np.pi / 2
    sides = flat.read(addon_part).places["Sofa"].sides
    assert len(sides) == count
    if count:
        assert abs(sides[0].target[1] - sides[1].target[1]) == pytest.approx(0.9, abs=0.02)
        assert abs(sides[0].at[1] - sides[1].at[1]) == pytest.approx(0.9, abs=0.1)
