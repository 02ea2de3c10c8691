# SPDX-License-Identifier: GPL-3.0-or-later
"""Sensors on surfaces: their place and direction by hit point and normal, and their housing."""

import functools
import itertools
import math
import types

import bpy
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.appearance.appearance import appearance_of
from bl_ext.user_default.angen_sensors.operators import place
from bl_ext.user_default.angen_sensors.operators.place import first_surface
from bl_ext.user_default.angen_sensors.operators.place import visible_surface as seen
from bl_ext.user_default.angen_sensors.sensor_logic.kinds import KINDS as kinds
from mathutils import Matrix, Vector

ops = bpy.ops.angen
KINDS = ("PIR", "OPTICAL_SWITCH", "PRESSURE", "LIGHT")
UP = Vector((0, 0, 1))


@pytest.fixture
def placing(addon_part):
    return addon_part("angen_addon.authoring.of_kind")


@pytest.fixture
def parent_keeping(addon_part):
    return addon_part("angen_addon.appearance.housing").parent_keeping


@pytest.fixture
def housing_of(addon_part):
    return addon_part("angen_addon.authoring.of_kind").housing_of


def unit(azimuth, elevation):
    a, e = math.radians(azimuth), math.radians(elevation)
    return Vector((math.cos(e) * math.cos(a), math.cos(e) * math.sin(a), math.sin(e)))


def close(a, b, tolerance=1e-5):
    return (Vector(a) - Vector(b)).length < tolerance


NORMALS = [
    unit(a, e) for a in (0, 37, 90, 145, 180, 270, 311) for e in (-90, -60, -20, 0, 15, 45, 90)
]


@pytest.mark.parametrize("azimuth", [0, 23, 90, 180, 250, 359])
@pytest.mark.parametrize("lean", [-25, -3, 0, 3, 25])
def test_a_motion_detector_looks_level_out_of_a_wall(placing, azimuth, lean):
    axes = placing.axes_on("PIR", unit(azimuth, lean))
    assert close(-axes.col[2], unit(azimuth, 0))
    assert close(axes.col[1], UP)


def test_what_looks_faces_out_of_slopes_ceilings_and_floors(placing):
    for normal in (unit(70, 45), unit(70, -45), -UP, UP):
        assert close(-placing.axes_on("PIR", normal).col[2], normal)
    for normal in NORMALS:
        axes = placing.axes_on("LIGHT", normal)
        assert close(-axes.col[2], normal)
        if abs(normal.z) < 0.9:
            assert axes.col[1].z > 0, "as upright as can be"


def test_a_pad_lies_with_its_upper_side_out(placing):
    for normal in NORMALS:
        assert close(placing.axes_on("PRESSURE", normal).col[2], normal)


def test_a_switch_stands_on_the_surface_with_its_beam_along_it(placing):
    for normal in NORMALS:
        axes = placing.axes_on("OPTICAL_SWITCH", normal)
        assert close(axes.col[1], -normal), "open away from the surface"
        if abs(normal.z) < 0.9:
            assert abs(axes.col[2].z) < 1e-5, "level on a wall"


def test_on_what_is_level_it_lines_up_with_the_object(placing):
    along = [Vector((3, 4, 0)), Vector((-4, 3, 0))]
    for kind in ("PIR", "PRESSURE", "LIGHT"):
        for normal in (UP, -UP):
            assert close(placing.axes_on(kind, normal, 0.0, along).col[1], (0.6, 0.8, 0))
    upright_first = [Vector((0, 0, 2)), Vector((0, 0, 0)), Vector((-4, 3, 0))]
    assert close(placing.axes_on("PIR", UP, 0.0, upright_first).col[1], (-0.8, 0.6, 0))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("scale", [1.0, 0.01])
def test_the_housing_touches_the_surface_from_outside(placing, housing_of, kind, scale):
    housing, point = housing_of(kind), Vector((3, -2, 1)) / scale
    solid = {i for face in housing.faces for i in face}
    for normal in NORMALS:
        matrix = placing.place_on(kind, housing, point, normal * 3, 0.3, [], scale)
        away = [
            (matrix @ (Vector(housing.points[i]) / scale) - point).dot(normal) * scale
            for i in solid
        ]
        assert min(away) == pytest.approx(0.0, abs=2e-6)
        assert max(away) > 1e-4


SHEAR = Matrix(((1, 0.4, 0.2, 0), (0, 1, 0.3, 0), (0, 0, 1, 0), (0, 0, 0, 1)))
PARENTS = {
    "mirrored": Matrix.Diagonal((-1, 1, 1, 1)),
    "uneven": Matrix.Diagonal((0.1, 30, 2, 1)),
    "turned": Matrix.Rotation(1.0, 4, (1, 2, 3)),
    "sheared": SHEAR,
    "all": Matrix.Translation((5, 6, 7)) @ SHEAR @ Matrix.Diagonal((-2, 0.3, 1, 1)),
}


@pytest.mark.parametrize("kind", PARENTS)
def test_a_sensor_keeps_its_place_under_any_parent_and_follows(world, parent_keeping, kind):
    top, parent = world.link("top", None), world.link("parent", None)
    parent.parent, parent.matrix_parent_inverse = top, PARENTS[kind]
    world.update()
    sensor = world.link("sensor", None)
    wanted = Matrix.Translation((1, 2, 3)) @ Matrix.Rotation(0.7, 4, (3, 2, 1))
    assert parent_keeping(sensor, parent, wanted)
    world.update()
    assert all(
        close(a.xyz, b.xyz, 1e-4) for a, b in zip(sensor.matrix_world.col, wanted.col, strict=True)
    )
    top.location.x += 2
    world.update()
    assert close(sensor.matrix_world.translation, (3, 2, 3), 1e-4)


def test_a_parent_without_a_size_is_not_followed(world, parent_keeping):
    flat, sensor = world.link("flat", None), world.link("sensor", None)
    flat.scale = (0, 1, 1)
    world.update()
    assert not parent_keeping(sensor, flat, Matrix.Translation((1, 2, 3)))
    assert sensor.parent is None
    world.update()
    assert close(sensor.matrix_world.translation, (1, 2, 3))


# The surface under a ray


@pytest.fixture
def meets(world):

    def look(origin, direction, **more):
        depsgraph = world.update()
        return first_surface(world.scene, depsgraph, Vector(origin), Vector(direction), **more)

    return look


@pytest.mark.parametrize("scale", [(1, 1, 1), (-1, 1, 1), (0.3, -2, 4), (-1, -1, -1)])
def test_the_normal_faces_the_user_however_the_object_is_scaled(world, meets, scale):
    box = world.box((1, 1, 1), name="box")
    box.scale, box.rotation_euler = scale, (0, 0, 0.6)
    for direction in (unit(10, -20), unit(130, 40), unit(250, 80)):
        met = meets(-direction * 20, direction)
        assert met.object == box and met.whole
        assert met.normal.dot(direction) < 0
        local = box.matrix_world.inverted() @ (met.point + met.normal * 0.01)
        assert max(abs(c) for c in local) > 0.5, "outwards"
        inside = meets((0, 0, 0), direction)
        assert inside.normal.dot(direction) < 0, "towards who looks"


@pytest.mark.parametrize("way", ["itself", "instanced", "linked", "same name"])
def test_a_wall_of_a_linked_home_is_placed_on_but_is_no_parent(world, meets, tmp_path, way):
    wall = world.box((4, 0.2, 3), (0, 2, 0), "Outer walls")
    if way != "itself":
        flat = world.aside("flat", wall)
        if way == "linked":
            path = world.save_library(tmp_path / "home.blend", flat)
            with bpy.data.libraries.load(str(path), link=True) as (_, target):
                target.collections = ["flat"]
            flat = target.collections[0]
        world.instance("Home", flat)
    if way == "same name":
        world.link(wall.name, None)
    world.update()
    hit = meets((0, 0, 0), (0, 1, 0))
    assert hit.object.name.startswith("Outer walls") and hit.whole == (way == "itself")
    made = types.SimpleNamespace(
        kind="PIR", preset="", turn=0.0, follow=False, _typed=place.TypedLength(),
    )  # fmt: skip
    made._matrix = functools.partial(place.ANGEN_OT_sensor_place._matrix, made)
    place.ANGEN_OT_sensor_place._place_at(made, bpy.context, hit)
    values = {"location": made.location, "normal": made.normal, "surface": made.surface}
    assert bpy.ops.angen.sensor_place(kind="PIR", **values) == {"FINISHED"}
    assert bpy.context.object.location.y == pytest.approx(1.9, abs=0.05)
    assert bpy.context.object.parent is None


def test_backs_of_faces_are_passed_where_the_view_culls_them(world, meets):
    """A room whose faces point inwards, seen from outside."""
    ceiling = [(-2, -2, 2), (2, -2, 2), (2, 2, 2), (-2, 2, 2)]
    world.link("room", world.mesh(ceiling, [(3, 2, 1, 0)]))
    world.box((1, 1, 1), name="table")
    assert meets((0, 0, 10), (0, 0, -1), culled=False).object.name == "room"
    assert meets((0, 0, 10), (0, 0, -1), culled=True).object.name == "table"
    from_within = meets((0, 0, 1), (0, 0, 1), culled=True)
    assert from_within.object.name == "room"
    assert from_within.normal.z == pytest.approx(-1)


def test_what_sensors_ignore_and_what_is_passed_is_no_surface(world, meets):
    world.box((4, 4, 4), name="volume").angen_ignored = True
    world.box((1, 1, 1), name="passed")
    world.box((9, 9, 1), at=(0, 0, -5), name="floor")
    met = meets((0, 0, 10), (0, 0, -1), passes=lambda obj: obj.name == "passed")
    assert met.object.name == "floor"
    assert met.point.z == pytest.approx(-4.5, abs=1e-5)
    assert meets((0, 0, 10), (0, 0, 1)) is None
    assert meets((0, 0, 10), (0, 0, -1), length=5.0) is None


@pytest.mark.parametrize("outline", ["WIRE", "BOUNDS"])
def test_one_places_through_a_ceiling_shown_as_an_outline_but_also_on_it(world, outline):
    ceiling = world.box((4, 4, 0.1), (0, 0, 2.5), name="ceiling")
    world.box((4, 4, 0.1), (0, 0, 0), name="floor")

    def looked(z, way):
        world.update()
        depsgraph = bpy.context.evaluated_depsgraph_get()
        met = seen(world.scene, depsgraph, Vector((0, 0, z)), Vector((0, 0, way)), False)
        return met.object.name

    assert looked(9, -1) == "ceiling"
    ceiling.display_type = outline
    assert looked(9, -1) == "floor"
    assert looked(1, 1) == "ceiling", "there is nothing behind it"


# Its height, shown and typed


@pytest.fixture
def heights(addon_part):
    return addon_part("operators.place")


@pytest.fixture
def told(world, heights):
    """Return the header's text on a place under a ray, and the height there (m)."""

    def look(kind, origin, direction, typed=""):
        depsgraph, scale = world.update(), world.scene.unit_settings.scale_length
        start = Vector(origin) / scale
        met = place.first_surface(world.scene, depsgraph, start, Vector(direction))
        stub = types.SimpleNamespace(kind=kind, preset="", turn=0.0, _typed=heights.TypedLength())
        operator = place.ANGEN_OT_sensor_place
        stub._matrix = lambda *arguments: operator._matrix(stub, *arguments)
        stub._typed.text = typed
        matrix, facts = operator._place_at(stub, bpy.context, met)
        return place.APART.join(facts), matrix.translation.z * scale

    return look


@pytest.mark.parametrize("kind", ["PRESSURE", "PIR"])
@pytest.mark.parametrize("at", [0.0, 2.7])
def test_on_a_floor_its_own_underside_is_nothing_below(world, told, kind, at):
    world.box((9, 9, 0.1), at=(0, 0, at - 0.05), name="Floor")
    text, height = told(kind, (1, 1, at + 1), (0, 0, -1))
    assert text == f"On 'Floor'    Z {height:.3f} m"
    assert "Z -" not in text and height == pytest.approx(at, abs=0.05)


def test_on_a_table_and_on_a_wall_the_height_is_that_above_the_floor(world, told):
    world.box((9, 9, 0.1), at=(0, 0, 0.95), name="Floor")
    world.box((1, 1, 0.04), at=(0, 0, 1.73), name="Table")
    world.box((0.2, 9, 3), at=(3, 0, 2.5), name="Wall")
    text, _ = told("PRESSURE", (0.2, 0, 3), (0, 0, -1))
    assert text == "On 'Table'    Z 1.750 m, 0.750 m above 'Floor'"
    text, _ = told("PIR", (2, 0, 3.2), (1, 0, 0))
    assert text == "On 'Wall'    Z 3.200 m, 2.200 m above 'Floor'"


def test_a_picture_and_a_skirting_board_on_the_wall_are_no_floor(world, told):
    world.box((9, 9, 0.1), at=(0, 0, 0.95), name="Floor")
    world.box((0.2, 9, 9), at=(3, 0, 1), name="Wall")
    world.box((0.03, 0.6, 0.4), at=(2.885, 0, 2.6), name="Picture")
    world.box((0.02, 9, 0.1), at=(2.89, 0, 1.05), name="Skirting")
    text, height = told("PIR", (2, 0, 3.1), (1, 0, 0), "2.2")
    assert height == pytest.approx(3.2) and "2.200 m above 'Floor'" in text
    world.box((0.4, 2, 0.04), at=(2.7, 0, 2.98), name="Shelf")
    assert "0.200 m above 'Shelf'" in told("PIR", (2, 0, 3.2), (1, 0, 0))[0]


@pytest.mark.parametrize("scale", [1.0, 0.01])
@pytest.mark.parametrize("lean", [0.0, 10.0, -10.0])
def test_a_typed_height_is_that_above_the_floor_and_on_the_wall(world, told, scale, lean):
    world.scene.unit_settings.scale_length = scale
    world.box((9 / scale, 9 / scale, 0.1 / scale), at=(0, 0, 0.95 / scale), name="Floor")
    wall = world.box((0.2 / scale, 9 / scale, 9 / scale), at=(3 / scale, 0, 1 / scale), name="Wall")
    wall.rotation_euler.y = math.radians(lean)
    for typed, wanted in (("2.2", 2.2), ("180cm", 1.8), ("7ft", 2.1336), (".5", 0.5)):
        text, height = told("LIGHT", (2, 0, 2.5), (1, 0, 0), typed)
        assert height == pytest.approx(1 + wanted, abs=1e-4)
        assert f"{wanted:.3f} m above 'Floor'    Height: {typed}" in text
    text, height = told("LIGHT", (2, 0, 2.5), (1, 0, 0), "2.")
    assert height == pytest.approx(3.0, abs=1e-4), "while it is being typed"


def test_keys_that_are_a_height_and_keys_that_are_not(world, heights):
    def press(typed, name, unicode="", ctrl=False):
        event = types.SimpleNamespace(type=name, unicode=unicode, ctrl=ctrl, alt=False)
        return typed.take(event)

    typed = heights.TypedLength()
    assert not press(typed, "M", "m"), "a letter alone is a command"
    assert not press(typed, "BACK_SPACE") and typed.metres(world.scene) is None
    for name, unicode in (("ONE", "1"), ("COMMA", ","), ("NUMPAD_4", "")):
        assert press(typed, name, unicode)
    assert (typed.text, typed.metres(world.scene)) == ("1.4", pytest.approx(1.4))
    assert not press(typed, "R", "r") and not press(typed, "TWO", "2", ctrl=True)
    assert not press(typed, "MOUSEMOVE") and not press(typed, "NUMPAD_ENTER", "\r")
    assert press(typed, "M", "m") and press(typed, "M", "m")
    assert typed.metres(world.scene) == pytest.approx(0.0014)
    world.scene.unit_settings.system = "IMPERIAL"
    for _ in range(2):
        press(typed, "BACK_SPACE")
    assert typed.metres(world.scene) == pytest.approx(1.4 * 0.3048)
    world.scene.unit_settings.system = "METRIC"
    world.scene.unit_settings.length_unit = "CENTIMETERS"
    assert typed.metres(world.scene) == pytest.approx(0.014), "as the scene shows lengths"
    press(typed, "MINUS", "-")
    assert typed.metres(world.scene) is None


# The operator called by a script, and repeated from the panel of the last operation


@pytest.mark.parametrize("kind", KINDS)
def test_placed_sensors_stand_on_a_wall_and_sense(world, kind):
    wall = world.box((0.2, 4, 3), at=(-0.1, 0, 1.5), name="wall")
    world.update()
    assert ops.sensor_place(
        kind=kind, location=(0, 1, 2), normal=(1, 0, 0), surface="wall", follow=True
    ) == {"FINISHED"}
    sensor = bpy.context.object
    assert (sensor.angen_sensor.kind, sensor.parent) == (kind, wall)
    world.update()
    axes = sensor.matrix_world.to_3x3()
    ahead = axes.col[2] if kind == "PRESSURE" else -axes.col[2]
    assert ahead.x == pytest.approx(0 if kind == "OPTICAL_SWITCH" else 1, abs=1e-6)
    corners = [sensor.matrix_world @ v.co for v in sensor.data.vertices]
    assert min(c.x for c in corners) > -1e-5, "not in the wall"
    assert sensor.matrix_world.translation.x < 0.05
    wall.location.y += 1
    world.update()
    assert sensor.matrix_world.translation.y == pytest.approx(2)


def test_placing_tells_what_it_cannot_do(world):
    for arguments, words in (
        ({"kind": "PIR", "normal": (0, 0, 0)}, "normal is zero"),
        ({"kind": "PIR", "surface": "gone"}, "no object 'gone'"),
        ({"kind": "PIR", "preset": "FSR_402"}, "choose one of THESIS"),
    ):
        with pytest.raises(RuntimeError, match=words):
            ops.sensor_place(**arguments)
    assert not bpy.data.objects


def test_a_placed_motion_detector_sees_past_its_own_housing(world):
    world.box((0.2, 4, 3), at=(-0.1, 0, 1.5), name="wall")
    world.box((0.2, 4, 3), at=(3.1, 0, 1.5), name="other wall")
    ops.sensor_place(kind="PIR", location=(0, 0, 2), normal=(1, 0, 0), surface="wall")
    sensor = bpy.context.object
    sensor.angen_sensor.pir.rays, sensor.angen_sensor.pir.vertical_fov = 9, 0.0
    _, directions, ranges = world.rays(sensor)
    middle = max(range(9), key=lambda i: directions[i][0])
    lens = sensor.matrix_world.translation.x
    assert ranges[middle] + 0.05 == pytest.approx(3 - lens, abs=1e-4)


# Housings are closed bodies of the sizes in the data sheets; their lines are not hit by rays


@pytest.fixture
def housing(addon_part):
    return addon_part("angen_addon.appearance.housing")


def size(housing, axes="xyz"):
    solid = [housing.points[i] for i in {i for face in housing.faces for i in face}]
    return [
        1000 * (max(p["xyz".index(a)] for p in solid) - min(p["xyz".index(a)] for p in solid))
        for a in axes
    ]


@pytest.mark.parametrize(
    ("kind", "preset", "millimetres"),
    [
        ("PIR", "HC_SR501", (32, 24, 25)),
        ("PIR", "EKMC1601111", (30.48, 20.32, 13.97)),
        ("OPTICAL_SWITCH", "TCST1103", (6.3, 10.8, 11.9)),
        ("PRESSURE", "FSR_402", (18.28, 18.28, 0.45)),
        ("PRESSURE", "FSR_406", (43.69, 43.69, 0.45)),
        ("PRESSURE", "", (300, 300, 10)),
        ("LIGHT", "GL5528", (5, 5, 2)),
    ],
)
def test_sizes_are_those_of_the_parts(housing_of, kind, preset, millimetres):
    assert size(housing_of(kind, preset)) == pytest.approx(millimetres, rel=1e-3)


def test_bodies_are_closed_and_face_outwards(housing):
    makers = [make for kind in kinds.values() for make in appearance_of(kind).housings.values()]
    for make in [housing.marker, *makers]:
        found = make()
        directed = [e for f in found.faces for e in zip(f, f[1:] + f[:1], strict=True)]
        assert len(set(directed)) == len(directed)
        assert all((b, a) in directed for a, b in directed), "closed, and turned one way"
        volume = 0.0
        for face in found.faces:
            points = [Vector(found.points[i]) for i in face]
            for b, c in itertools.pairwise(points):
                volume += points[0].dot(b.cross(c)) / 6
        assert volume > 0, "outwards"


def test_an_object_is_selected_in_a_file_without_a_window(world, addon_part):
    """`context.selected_objects` is missing there, as in files that a script saved."""
    first, second = world.box((1, 1, 1)), world.box((1, 1, 1))
    first.select_set(True)
    context = types.SimpleNamespace(view_layer=bpy.context.view_layer)
    addon_part("angen_addon.authoring.presets").select_only(context, second)
    assert (first.select_get(), second.select_get()) == (False, True)
    assert bpy.context.view_layer.objects.active == second


@pytest.mark.parametrize("scale", [1.0, 0.01])
@pytest.mark.parametrize("kind", ["PIR", "OPTICAL_SWITCH", "PRESSURE", "LIGHT"])
def test_a_new_sensor_has_its_real_size_in_every_unit(world, housing_of, kind, scale):
    world.scene.unit_settings.scale_length = scale
    ops.sensor_add(kind=kind)
    mesh = bpy.context.object.data
    corners = [mesh.vertices[i].co for face in mesh.polygons for i in face.vertices]
    found = [
        1000 * scale * (max(c[i] for c in corners) - min(c[i] for c in corners)) for i in range(3)
    ]
    assert found == pytest.approx(size(housing_of(kind)), rel=1e-4)


def test_the_fork_does_not_stop_its_own_beam_but_a_flag_in_it_does(world):
    for preset, gap in (("", 0.05), ("TCST1103", 0.0031), ("GP1A53HR", 0.005)):
        ops.sensor_add(kind="OPTICAL_SWITCH", preset=preset)
        switch = bpy.context.object
        switch.angen_sensor.update_rate = 24.0
        switch.name = f"switch {preset}"
        flag = world.box((0.02, 0.02, 0.0005), at=(0, 0, -gap / 2))
        world.key(flag, "location", {1: (0, 0, -gap / 2), 3: (1, 0, -gap / 2)}, "CONSTANT")
        opened = world.series(world.run(1, 4), switch.name, "open")
        assert opened == [0, 0, 1, 1], preset
        for obj in list(bpy.data.objects):
            bpy.data.objects.remove(obj)


@pytest.mark.parametrize("preset", ["FSR_402", "FSR_406"])
def test_what_stands_on_a_small_resistor_presses_on_it(world, preset):
    """A cube of 1 kg on a disk half a millimetre thick: the contact solver finds the contact."""
    bpy.ops.rigidbody.world_add()
    for name, size, z, kind in (("floor", 1.0, -0.5, "PASSIVE"), ("cube", 0.01, 0.00545, "ACTIVE")):
        obj = world.box((size,) * 3, (0, 0, z), name)
        bpy.context.view_layer.objects.active = obj
        bpy.ops.rigidbody.object_add(type=kind)
        obj.rigid_body.collision_shape, obj.rigid_body.mass = "BOX", 1.0
        obj.rigid_body.use_margin, obj.rigid_body.collision_margin = True, 0.0
    ops.sensor_place(kind="PRESSURE", preset=preset, surface="floor")
    pad = bpy.context.object
    pad.angen_sensor.update_rate = 24.0
    bpy.ops.rigidbody.object_add(type="PASSIVE")
    pad.rigid_body.collision_shape, pad.rigid_body.use_margin = "MESH", True
    pad.rigid_body.collision_margin = 0.0
    force = world.series(world.run(), pad.name, "force_n")
    assert force[-8:] == pytest.approx([9.81] * 8, rel=0.02)


def test_menus_offer_all_kinds_the_door_and_residents(world):
    for name, count, menus in (
        ("ANGEN_MT_sensor_add", 21, ["ANGEN_MT_resident_add"]),
        ("ANGEN_MT_object_sensor", 13, []),
    ):
        assert hasattr(bpy.types, name)
        drawn, drawn_menus = [], []

        class Layout:
            operator_context = ""

            def operator(self, idname, drawn=drawn, **_):
                assert idname.removeprefix("angen.") in dir(ops)
                drawn.append((idname, self.operator_context))
                return type("Item", (), {})()

            def menu(self, idname, drawn_menus=drawn_menus, **_):
                assert hasattr(bpy.types, idname)
                drawn_menus.append(idname)

            def separator(self): ...

        cls = getattr(bpy.types, name)
        cls.draw(types.SimpleNamespace(layout=Layout()), bpy.context)
        assert len(drawn) == count and drawn_menus == menus
        for idname, how in drawn:
            assert (how == "INVOKE_REGION_WIN") == (idname == "angen.sensor_place") or (
                idname == "angen.door_fit"
            )
