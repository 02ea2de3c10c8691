# SPDX-License-Identifier: GPL-3.0-or-later
"""A door is fitted in one step: closed it reads closed, open by 5° or 5 cm it reads open."""

import math
from pathlib import Path

import bpy
import pytest
from mathutils import Matrix, Vector
from tiers import mostly_slow

ops = bpy.ops.angen
WIDTH, HEIGHT, THICK = 0.9, 2.0, 0.04
# The leaf's box in its own axes: the hinge is its origin, on the face that it opens to (−Y).
HINGED = ((0, 0, 0), (WIDTH, THICK, HEIGHT))
YAWS = [0, 37, 90, 180, 251]


def box_mesh(world, low, high):
    corners = [
        (x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])
    ]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return world.mesh(corners, faces)


class Door:
    """A leaf in a wall with an opening, all turned by `yaw` (degrees) about the hinge."""

    def __init__(self, world, yaw=0.0, leaf_box=HINGED, wall_y=(0.0, 0.2), at=(2, 3, 0), scale=1.0):
        self.world = world
        world.scene.unit_settings.scale_length = scale
        self.place = Matrix.Translation(Vector(at) / scale) @ Matrix.Rotation(
            math.radians(yaw), 4, "Z"
        )

        def part(name, low, high):
            mesh = box_mesh(world, [c / scale for c in low], [c / scale for c in high])
            obj = world.link(name, mesh)
            obj.matrix_world = self.place
            return obj

        self.leaf = part("leaf", *leaf_box)
        y0, y1 = wall_y
        # Over the leaf and beside it, as one mesh: three boxes.
        self.wall = part("wall over", (-1.0, y0, HEIGHT + 0.005), (2.0, y1, 2.6))
        for name, x0, x1 in (("wall left", -1.0, -0.005), ("wall right", WIDTH + 0.005, 2.0)):
            part(name, (x0, y0, 0), (x1, y1, 2.6))
        world.update()

    def fit(self, select=(), **settings):
        for obj in bpy.context.selected_objects:
            obj.select_set(False)
        for obj in (*select, self.leaf):
            obj.select_set(True)
        bpy.context.view_layer.objects.active = self.leaf
        assert ops.door_fit(**settings) == {"FINISHED"}
        self.world.update()
        return bpy.context.object

    def open(self, degrees):
        self.leaf.matrix_world = self.place @ Matrix.Rotation(math.radians(degrees), 4, "Z")

    def slide(self, metres):
        self.leaf.matrix_world = self.place @ Matrix.Translation((metres, 0, 0))


def is_open(world, switch):
    """Return the reading of the switch, by its own model."""
    return world.series(world.run(1, 1), switch.name, "open") == [1]


@pytest.mark.parametrize("yaw", YAWS)
def test_a_hinged_door_reads_closed_and_from_five_degrees_open(world, yaw, capfd):
    door = Door(world, yaw)
    switch = door.fit([door.wall])
    told = capfd.readouterr().out
    assert bpy.context.object.angen_sensor.update_rate == 10.0
    assert "Fitted the hinged door 'leaf'" in told and "Warning" not in told
    assert not is_open(world, switch)
    for degrees in (5, 7, 10, 20, 45, 60, 75, 90):
        door.open(-degrees)  # towards −Y, where the hinge is
        assert is_open(world, switch), degrees
    door.open(0)
    assert not is_open(world, switch)


@pytest.mark.parametrize(
    ("leaf_y", "wall_y"),
    [
        ((0.0, THICK), (0.0, 0.2)),  # flush with the wall
        ((0.0, THICK), (-0.03, 0.2)),  # set back in the wall
        ((0.0, THICK), (0.05, 0.2)),  # before the wall
        ((0.0, THICK), (0.02, 0.2)),  # half before it
        ((0.0, 0.06), (0.03, 0.2)),  # as in the sample home
    ],
)
def test_frames_before_and_behind_the_leaf(world, leaf_y, wall_y, capfd):
    door = Door(world, 37, ((0, leaf_y[0], 0), (WIDTH, leaf_y[1], HEIGHT)), wall_y)
    switch = door.fit()
    assert "Warning" not in capfd.readouterr().out
    assert not is_open(world, switch)
    for degrees in (5, 15, 45, 90):
        door.open(-degrees)
        assert is_open(world, switch), degrees


def boxes(obj, place):
    """Return the spans of a mesh's boxes, each of eight points, in the door's own axes."""
    points = [place.inverted() @ obj.matrix_world @ v.co for v in obj.data.vertices]
    whole = [points[i : i + 8] for i in range(0, len(points) - 7, 8)]
    return [[(min(p[i] for p in b), max(p[i] for p in b)) for i in range(3)] for b in whole]


def touching(one, other, place):
    """Return whether two objects made of boxes overlap by more than 0.1 mm."""
    return any(
        all(min(a[1], b[1]) - max(a[0], b[0]) > 1e-4 for a, b in zip(mine, its, strict=True))
        for mine in boxes(one, place)
        for its in boxes(other, place)
    )


@pytest.mark.parametrize("wall_y", [(0.0, 0.2), (-0.03, 0.2), (0.05, 0.2)])
def test_the_flag_goes_through_no_wall_and_no_fork(world, wall_y):
    door = Door(world, 0, wall_y=wall_y)
    switch = door.fit()
    flag = bpy.data.objects["Flag leaf"]
    for degrees in (0, 1, 2, 3, 5, 20, 90):
        door.open(-degrees)
        world.update()
        walls = [o for o in bpy.data.objects if o.name.startswith("wall")]
        assert not any(touching(flag, wall, door.place) for wall in walls), degrees
        assert not touching(flag, switch, door.place), degrees
        assert not touching(switch, door.leaf, door.place), degrees


@pytest.mark.parametrize("scale", [1.0, 0.01, 0.0254])
def test_a_door_in_any_unit(world, scale, capfd):
    door = Door(world, 37, scale=scale)
    switch = door.fit([door.wall])
    assert "Warning" not in capfd.readouterr().out
    assert not is_open(world, switch)
    door.open(-5)
    assert is_open(world, switch)


def test_keys_tell_the_side_that_it_opens_to(world):
    """A hinge in the middle of the thickness leaves the side open; the keys give it."""
    for sign in (1, -1):
        door = Door(world, 37, ((0, -THICK / 2, 0), (WIDTH, THICK / 2, HEIGHT)), (-0.1, 0.1))
        yaw = math.radians(37)
        world.key(
            door.leaf, "rotation_euler", {1: (0, 0, yaw), 20: (0, 0, yaw + sign * math.radians(80))}
        )
        world.scene.frame_set(1)
        switch = door.fit()
        local = door.place.inverted() @ switch.matrix_world.translation
        assert local.y * sign > 0.1
        opened = world.run(1, 20)
        assert opened.tracks[switch.name].columns["open"][0] == 0
        switch.angen_sensor.update_rate = 24.0
        series = world.series(world.run(1, 20), switch.name, "open")
        assert series[:1] == [0] and series[-15:] == [1] * 15
        assert series == sorted(series), "it opens once"
        for obj in list(bpy.data.objects):
            bpy.data.objects.remove(obj)


def test_a_leaf_on_a_turning_empty(world):
    """The leaf's own origin is its centre; its parent turns."""
    door = Door(world, 90)
    hinge = world.link("hinge", None)
    hinge.matrix_world = door.place
    middle = Vector((WIDTH / 2, THICK / 2, HEIGHT / 2))
    for vertex in door.leaf.data.vertices:
        vertex.co -= middle
    door.leaf.parent = hinge
    door.leaf.matrix_world = door.place @ Matrix.Translation(middle)
    world.update()
    switch = door.fit()
    assert not is_open(world, switch)
    hinge.rotation_euler.z -= math.radians(6)
    assert is_open(world, switch)


@pytest.mark.parametrize("yaw", YAWS)
@pytest.mark.parametrize("sign", [1, -1])
def test_a_sliding_door_in_front_of_the_wall(world, yaw, sign, capfd):
    """Its leaf slides in front of the wall, keyed to either side."""
    door = Door(world, yaw, ((0, -0.06, 0), (WIDTH, -0.02, HEIGHT)), (0.0, 0.2))
    closed = door.place.translation.copy()
    way = door.place.to_3x3().col[0] * sign * 0.85
    world.key(door.leaf, "location", {1: closed, 20: closed + way})
    world.scene.frame_set(1)
    switch = door.fit()
    told = capfd.readouterr().out
    assert "Fitted the sliding door" in told and "Warning" not in told
    assert not is_open(world, switch)
    local = door.place.inverted() @ switch.matrix_world.translation
    assert (local.x > WIDTH / 2) == (sign < 0), "at the edge that closes"
    door.leaf.animation_data_clear()
    for metres in (0.05, 0.1, 0.4, 0.85):
        door.slide(sign * metres)
        assert is_open(world, switch), metres
    door.slide(0)
    assert not is_open(world, switch)


class Cube(Door):
    """A leaf as a beginner makes it: Blender's cube, scaled, with its origin in its centre."""

    def __init__(self, world, yaw=0.0, leaf_y=(-THICK / 2, THICK / 2), wall_y=(-0.1, 0.1)):
        super().__init__(world, yaw, wall_y=wall_y)
        self.middle = Vector((WIDTH / 2, sum(leaf_y) / 2, HEIGHT / 2))
        self.leaf.data = box_mesh(world, (-1, -1, -1), (1, 1, 1))
        self.size = Matrix.Diagonal((WIDTH / 2, (leaf_y[1] - leaf_y[0]) / 2, HEIGHT / 2, 1))
        self.stand(Matrix())
        world.update()

    def stand(self, moved):
        """Place the closed leaf, then move it in the door's own axes."""
        self.leaf.matrix_world = self.place @ moved @ Matrix.Translation(self.middle) @ self.size

    def swing(self, degrees, x, y):
        """Turn the leaf about an upright axis in the door's own axes."""
        axis = Matrix.Translation((x, y, 0))
        self.stand(axis @ Matrix.Rotation(math.radians(degrees), 4, "Z") @ axis.inverted())


@pytest.mark.parametrize("yaw", mostly_slow(YAWS, YAWS[0], YAWS[2]))
@pytest.mark.parametrize("motion", ["AUTO", "LEFT", "RIGHT"])
@pytest.mark.parametrize("flip", [False, True])
def test_a_cube_with_its_origin_in_the_middle_is_a_hinged_door(world, yaw, motion, flip, capfd):
    door = Cube(world, yaw)
    switch = door.fit([door.wall], motion=motion, flip=flip)
    told = capfd.readouterr().out
    assert "Fitted the hinged door 'leaf'" in told and "Warning" not in told
    assert ("assumed at the left" in told) == (motion == "AUTO")
    assert not is_open(world, switch)
    place = door.place.inverted() @ switch.matrix_world.translation
    out = math.copysign(1.0, place.y)
    # Seen from the switch on +Y, +X is at the left.
    hinge = WIDTH if (out > 0.0) == (motion != "RIGHT") else 0.0
    assert (place.x < WIDTH / 2) == (hinge > 0.0), "at the free edge"
    for degrees in (5, 20, 60, 90):
        door.swing(degrees * out * (1 if hinge == 0.0 else -1), hinge, out * THICK / 2)
        assert is_open(world, switch), degrees
    door.stand(Matrix())
    assert not is_open(world, switch)


def test_where_only_one_edge_has_a_frame_the_hinge_is_at_the_other(world, capfd):
    """The wall ends over the leaf's middle: only one upper corner has a wall behind it."""
    for side in (1, -1):
        door = Cube(world)
        ends = sorted((WIDTH / 2, WIDTH / 2 + side * 1.5))
        over = ((ends[0], -0.1, HEIGHT + 0.005), (ends[1], 0.1, 2.6))
        door.wall.data = box_mesh(world, *over)
        switch = door.fit([door.wall])
        local = door.place.inverted() @ switch.matrix_world.translation
        assert (local.x > WIDTH / 2) == (side > 0)
        assert "Nothing shows where its hinge is" in capfd.readouterr().out
        for obj in list(bpy.data.objects):
            bpy.data.objects.remove(obj)


def test_a_hinge_without_a_frame_on_its_own_side_is_fitted_from_the_other(world):
    """The origin gives the side, but the wall above the leaf is only on the other one."""
    door = Door(world, 0, ((0, -0.5, 0), (WIDTH, 0, HEIGHT)), (-0.02, 0.2))
    door.wall.data = box_mesh(world, (-1, -0.3, HEIGHT + 0.005), (2, -0.25, 2.6))
    switch = door.fit([door.wall])
    assert (door.place.inverted() @ switch.matrix_world.translation).y < -0.2
    assert not is_open(world, switch)


def test_flip_is_the_other_side(world):
    door = Door(world, 37, wall_y=(0.0, 0.04))
    switch = door.fit(flip=True)
    assert (door.place.inverted() @ switch.matrix_world.translation).y > THICK
    assert not is_open(world, switch)
    door.open(5)
    assert is_open(world, switch)


def test_what_cannot_be_fitted_changes_nothing_and_says_why(world):
    leaf = world.link("leaf", box_mesh(world, *HINGED))
    world.update()
    bpy.context.view_layer.objects.active = leaf
    leaf.select_set(True)
    with pytest.raises(RuntimeError, match=r"'leaf': no frame or wall is behind.*select the frame"):
        ops.door_fit()
    leaf.rotation_euler = (math.pi / 2, 0, 0)
    world.update()
    with pytest.raises(RuntimeError, match="does not stand upright"):
        ops.door_fit()
    leaf.rotation_euler, leaf.scale = (0, 0, 0), (1, 0, 1)
    world.update()
    with pytest.raises(RuntimeError, match="no thickness"):
        ops.door_fit()
    assert len(bpy.data.objects) == 1
    bpy.context.view_layer.objects.active = None
    with pytest.raises(RuntimeError, match="then the leaf of the door"):
        ops.door_fit()


def test_a_door_is_fitted_once(world):
    door = Door(world)
    door.fit()
    with pytest.raises(RuntimeError, match="has the switch 'Switch leaf' already"):
        door.fit()


def test_the_switch_is_in_the_room_before_the_door(world):
    """The leaf is flush with the wall's face at y = 3; the switch is before that."""
    door = Door(world)
    for room, y in (("kitchen", 1.0), ("hall", 5.2)):
        world.box((4, 4, 0.1), (2.5, y, -0.05), f"Floor {room}")
        world.sensor("LIGHT", f"Light {room}", room=room).location = (0, y, -3)
    world.update()
    assert door.fit().angen_sensor.room == "kitchen"


def test_what_stands_in_the_gap_is_told(world, capfd):
    door = Door(world)
    switch = door.fit()
    middle = switch.matrix_world @ Vector((0, 0, -0.045))
    for obj in (switch, bpy.data.objects["Flag leaf"]):
        bpy.data.objects.remove(obj)
    world.box((0.004, 0.004, 0.004), at=middle, name="cable")
    door.fit([door.wall])
    assert "'cable'" in capfd.readouterr().out


HOME = Path(__file__).resolve().parents[2] / "sample_blends" / "angen.blend"


@pytest.mark.slow
@pytest.mark.skipif(not HOME.exists(), reason="the sample home is not built: make sample")
def test_the_doors_of_the_home_can_be_fitted_without_telling_their_frames(world, capfd):
    """Its own switches and flags are removed first; each leaf is selected alone."""
    bpy.ops.wm.open_mainfile(filepath=str(HOME))
    bpy.context.scene.angen_live = False
    for obj in bpy.data.objects:
        obj.angen_sensor.enabled = obj.angen_sensor.kind == "OPTICAL_SWITCH"
    names = [o.name[5:] for o in bpy.data.objects if o.name.startswith("Flag ")]
    assert len(names) == 7
    for name in names:
        switch = bpy.data.objects[f"Switch {name}"]
        for obj in (bpy.data.objects[f"Flag {name}"], *switch.children, switch):
            bpy.data.objects.remove(obj)
    bpy.context.scene.frame_set(1)
    fitted = {}
    for name in names:
        for obj in bpy.context.selected_objects:
            obj.select_set(False)
        bpy.context.view_layer.objects.active = leaf = bpy.data.objects[f"Door {name}"]
        assert ops.door_fit() == {"FINISHED"}
        fitted[name] = leaf, bpy.context.object, leaf.rotation_euler.z, leaf["open_yaw"]
        assert bpy.context.object.parent.name == f"Door frame {name}"
        leaf.animation_data_clear()
        leaf.rotation_mode = "XYZ"
    assert "Warning" not in capfd.readouterr().out
    for degrees in (0, 5, 20, 60):
        for leaf, _, closed, opened in fitted.values():
            way = math.copysign(1.0, opened - closed)
            leaf.rotation_euler.z = closed + way * math.radians(degrees)
        recording = world.run(1, 1)
        for name, (_, switch, _, _) in fitted.items():
            seen = world.series(recording, switch.name, "open")
            assert seen == [degrees > 0], (name, degrees)
