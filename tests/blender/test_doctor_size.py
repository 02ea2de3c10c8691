# SPDX-License-Identifier: GPL-3.0-or-later
"""The doctor tells homes of another unit, and what looks solid but has no faces."""

import bpy
import numpy as np
import pytest
from bl_ext.user_default.angen_sensors.angen_addon import doctor


@pytest.fixture
def told(world):
    """Return a function that returns the doctor's findings of some checks."""

    def found(*checks):
        depsgraph = world.update()
        every = doctor.examine(bpy.context.scene, bpy.context.view_layer, depsgraph)
        return [one for one in every if one.check in checks]

    return found


def furnish(world, size=1.0, ceiling=True, door=False):
    """Add a flat of two rooms, drawn `size` times too large, with furniture."""
    before = set(bpy.data.objects)
    world.hall(6.0, 4.0, 2.5)
    world.box((0.1, 4.0, 2.5), (3.5, 2.0, 1.25), "partition")
    for number in range(6):
        world.box((0.5, 0.5, 0.45), (0.8 + 0.9 * number, 0.6, 0.225), f"chair {number}")
        world.box((1.6, 0.8, 0.03), (1.5 + 0.5 * number, 3.0, 0.74), f"table {number}")
    if not ceiling:
        bpy.data.objects.remove(bpy.data.objects["ceiling"])
    if door:
        world.box((0.9, 0.04, 2.05), (1.5, 0.1, 1.03), "Door")
    for obj in set(bpy.data.objects) - before:
        obj.location *= size
        obj.scale *= size


# Times too large, as a unit, and the Unit Scale that mends it.
SIZES = [
    (1 / 0.3048, "feet", "0.3048", "8.2 m"),
    (10.0, "tenths of a metre", "0.1", "25 m"),
    (1 / 0.0254, "inches", "0.0254", "98.4 m"),
    (100.0, "centimetres", "0.01", "250 m"),
]


@pytest.mark.parametrize("kind", ["rooms", "walls", "doors"])
@pytest.mark.parametrize("size", SIZES, ids=lambda s: s[1])
def test_a_home_that_is_too_large_is_told_with_its_unit_scale(world, told, size, kind):
    times, unit, scale, height = size
    furnish(world, times, ceiling=kind == "rooms", door=kind == "doors")
    (found,) = told("scale")
    assert found.text.startswith("The home is too large")
    if times < 20:
        high = height if kind != "doors" else f"{2.05 * times:.3g} m"
        assert f"its {kind} are {high} high" in found.text
    assert f"drawn in {unit}, set Unit Scale to {scale} " in found.mend
    world.scene.unit_settings.scale_length = float(scale)
    assert told("scale") == []


def test_a_room_of_one_mesh_in_feet_is_told(world, told):
    world.box((18.0, 13.0, 8.2), (0, 0, 4.1), "Room")
    (found,) = told("scale")
    assert "rooms are 8.2 m high" in found.text and "set Unit Scale to 0.3048 " in found.mend


def test_a_scale_that_is_set_already_is_part_of_the_advice(world, told):
    world.scene.unit_settings.scale_length = 0.1
    furnish(world, 100.0)
    (found,) = told("scale")
    assert "set Unit Scale to 0.01 " in found.mend


def three_storeys(world):
    for storey in range(3):
        world.box((10, 8, 0.3), (0, 0, 2.8 * storey - 0.15), "slab")
    for x in (-5, 5):
        world.box((0.3, 8, 8.4), (x, 0, 4.2), "outer wall")
    for y in (-4, 4):
        world.box((10, 0.3, 8.4), (0, y, 4.2), "outer wall")


def hall_with_a_door(world):
    world.hall(20.0, 12.0, 7.0)
    world.box((0.9, 0.04, 2.05), (1.5, 0.1, 1.03), "Door")


def under_a_sky(world):
    furnish(world)
    world.box((400, 400, 200), (0, 0, 90), "sky")
    world.box((60, 60, 0.1), (0, 0, -0.3), "terrain")


@pytest.mark.parametrize("build", [furnish, three_storeys, hall_with_a_door, under_a_sky])
def test_homes_of_a_usual_height_are_not_too_large(world, told, build):
    build(world)
    assert told("scale") == []


# What has no faces.


def points(number=500, size=(6.0, 0.1, 2.5)):
    return (np.random.default_rng(1).uniform(0, 1, (number, 3)) * size).tolist()


def scan(world):
    world.link("Wall", world.mesh(points(), []))


def edges(world):
    mesh = bpy.data.meshes.new("edges")
    corners = [(0, 0, 0), (3, 0, 0), (3, 0, 2), (0, 0, 2)]
    mesh.from_pydata(corners, [(0, 1), (1, 2), (2, 3), (3, 0)], [])
    world.link("Wall", mesh)


def curve(world, name="Wall"):
    data = bpy.data.curves.new("line", "CURVE")
    spline = data.splines.new("POLY")
    spline.points.add(3)
    for number, point in enumerate(spline.points):
        point.co = (number, number % 2, 0, 1)
    return world.link(name, data)


def by_nodes(*nodes):
    """Return a function that adds a box, of which geometry nodes make something else."""

    def build(world):
        tree = bpy.data.node_groups.new("nodes", "GeometryNodeTree")
        for in_out in ("INPUT", "OUTPUT"):
            tree.interface.new_socket("Geometry", in_out=in_out, socket_type="NodeSocketGeometry")
        last = tree.nodes.new("NodeGroupInput")
        for kind in (*nodes, "NodeGroupOutput"):
            node = tree.nodes.new(kind)
            tree.links.new(last.outputs[0], node.inputs[0])
            last = node
        box = world.box((3, 0.1, 2), name="Wall")
        box.modifiers.new("nodes", "NODES").node_group = tree

    return build


def flat_curve(world):
    """Blender makes a mesh without faces of it."""
    made = curve(world)
    made.data.dimensions, made.data.fill_mode = "2D", "BOTH"


def surface_line(world):
    data = bpy.data.curves.new("line", "SURFACE")
    data.splines.new("NURBS").points.add(4)
    for number, point in enumerate(data.splines[0].points):
        point.co = (number, number % 2, 0, 1)
    world.link("Wall", data)


def hair(world):
    data = bpy.data.hair_curves.new("hair")
    data.add_curves([2, 2])
    for number, point in enumerate(data.points):
        point.position = (number, 0, number % 2)
    world.link("Wall", data)


def hedge(world):
    obj = world.box((3, 0.1, 0.1), name="Wall")
    obj.modifiers.new("hair", "PARTICLE_SYSTEM")
    settings = obj.particle_systems[0].settings
    settings.type, settings.hair_length, settings.count = "HAIR", 1.5, 10


def volume(world):
    world.link("Wall", bpy.data.volumes.new("smoke"))


BARE = {
    "scanned vertices": (scan, "Point clouds", "Make a mesh of the scan"),
    "points by nodes": (by_nodes("GeometryNodeMeshToPoints"), "Point clouds", "Make a mesh"),
    "edges": (edges, "Meshes without faces", "Fill the edges"),
    "curve": (curve, "Curves without a surface", "Bevel"),
    "flat curve": (flat_curve, "Curves without a surface", "Bevel"),
    "line of a surface": (surface_line, "Curves without a surface", "Bevel"),
    "curve by nodes": (by_nodes("GeometryNodeMeshToCurve"), "Curves without", "Bevel"),
    "hair": (hair, "Hair", "Put a mesh where"),
    "particles": (hedge, "Hair", "Put a mesh where"),
    "volume": (volume, "Volumes", "Volume to Mesh"),
    "volume by nodes": (by_nodes("GeometryNodeMeshToVolume"), "Volumes", "Volume to Mesh"),
}


@pytest.mark.parametrize("what", BARE)
@pytest.mark.parametrize("is_instanced", [False, True], ids=["", "instanced"])
def test_what_looks_solid_without_faces_is_named(world, told, what, is_instanced):
    if what == "hair" and bpy.app.version < (4, 3):
        pytest.skip("this Blender's Python cannot make hair")
    build, text, mend = BARE[what]
    furnish(world)
    build(world)
    if is_instanced:
        world.instance("Home", world.aside("home", bpy.data.objects["Wall"]))
    (found,) = told("no_faces", "scale")
    assert found.text == f"{found.text.partition(',')[0]}, through which every ray passes: 'Wall'"
    assert found.text.startswith(text) and mend in found.mend
    assert found.objects == ("Wall",)
    bpy.data.objects["Wall"].angen_ignored = True
    assert told("no_faces") == []


@pytest.mark.parametrize("size", [8.0, 800.0], ids=["metres", "centimetres"])
def test_a_home_that_is_only_a_scan_is_never_to_be_scaled_up(world, told, size):
    cloud = points(2000, (size, size, size / 3))
    world.link("Scan", world.mesh(cloud, []))
    world.box((0.05, 0.05, 0.02), (1, 1, 2), "Housing")
    (sized, bare) = told("scale", "no_faces") if size > 8.0 else (None, *told("scale", "no_faces"))
    assert bare.text.endswith("'Scan'")
    assert sized is None or "set Unit Scale to 0.01 " in sized.mend


def used(world):
    """Add curves and points that are no walls: a path, a bevel's profile, a marker, a rug."""
    path = curve(world, "Path")
    follower = world.box((0.1, 0.1, 0.1), name="Follower")
    follower.constraints.new("FOLLOW_PATH").target = path
    profile = curve(world, "Profile")
    pipe = curve(world, "Pipe")
    pipe.data.bevel_mode, pipe.data.bevel_object = "OBJECT", profile
    world.link("Marker", world.mesh([(0, 0, 0)], []))
    rug = world.box((2, 1, 0.01), name="Rug")
    rug.modifiers.new("hair", "PARTICLE_SYSTEM")
    rug.particle_systems[0].settings.type = "HAIR"
    rug.particle_systems[0].settings.hair_length = 0.02
    text = bpy.data.curves.new("text", "FONT")
    text.body = "Kitchen"
    world.link("Text", text)


def test_paths_profiles_and_rugs_are_no_walls(world, told):
    furnish(world)
    used(world)
    assert told("no_faces") == []


# Coordinates of maps.


def by_matrix(obj, offset):
    obj.location = [a + b for a, b in zip(obj.location, offset, strict=True)]


def by_mesh(obj, offset):
    obj.data = obj.data.copy()
    for vertex in obj.data.vertices:
        vertex.co = [v + o / s for v, o, s in zip(vertex.co, offset, obj.scale, strict=True)]


def by_mesh_and_back(obj, offset):
    """As after Set Origin: the object is near, but its points were rounded before."""
    by_mesh(obj, offset)
    by_matrix(obj, [-o for o in offset])


def by_a_parent(obj, offset):
    """As of a georeferenced file: a parent is far away, and its inverse takes that back."""
    far = bpy.data.objects.get("Map") or bpy.data.objects.new("Map", None)
    far.location = offset
    if not far.users_collection:
        bpy.context.scene.collection.objects.link(far)
    bpy.context.view_layer.update()
    obj.parent, obj.matrix_parent_inverse = far, far.matrix_world.inverted()


@pytest.mark.parametrize("move", [by_matrix, by_mesh, by_mesh_and_back, by_a_parent])
@pytest.mark.parametrize("unit", [1.0, 0.001], ids=["metres", "millimetres"])
def test_coordinates_of_a_map_are_told(world, told, move, unit):
    world.scene.unit_settings.scale_length = unit
    furnish(world, 1.0 / unit)
    for obj in list(bpy.context.scene.objects):
        move(obj, (450_000.0 / unit, 5_428_000.0 / unit, 0.0))
    (found,) = told("coarse")
    assert found.text.startswith("Objects that are so far from the origin")
    assert "rounds their points to 0.5 m" in found.text if unit == 1.0 else "rounds" in found.text
    assert len(found.objects) == 19 and "ifc_to_obj.py" in found.mend


@pytest.mark.parametrize(("far", "is_told"), [(16_000.0, False), (17_000.0, True)])
def test_steps_of_more_than_a_millimetre_are_told(world, told, far, is_told):
    world.box((1, 1, 1), (0, far, 0))
    assert bool(told("coarse")) == is_told


def test_an_instance_that_takes_an_offset_back_is_told(world, told):
    offset = (450_000.0, 5_428_000.0, 0.0)
    kept = world.aside("home", world.box((1, 1, 1), offset, "Shed"))
    kept.instance_offset = offset
    world.instance("Home", kept)
    (found,) = told("coarse")
    assert found.objects == ("Shed in Home",)


def test_without_a_unit_system_the_advice_is_to_choose_one(world, told):
    world.scene.unit_settings.system = "NONE"
    world.scene.unit_settings.scale_length = 0.3048
    furnish(world, 1 / 0.3048)
    (found,) = told("scale")
    assert "set Unit System to Metric and Unit Scale to 0.3048 " in found.mend


def test_an_instance_far_away_is_told_and_wide_terrain_is_not(world, told):
    made = world.box((1, 1, 1), name="Shed")
    world.instance("Far", world.aside("shed", made), (60_000.0, 0, 0))
    world.box((60_000, 60_000, 1), (0, 0, -1), "Terrain")
    (found,) = told("coarse")
    assert found.objects == ("Shed in Far",)
