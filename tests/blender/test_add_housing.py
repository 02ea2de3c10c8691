# SPDX-License-Identifier: GPL-3.0-or-later
"""Housings are closed bodies of the sizes in the data sheets; their lines are no surface."""

import itertools
from types import SimpleNamespace

import bpy
import pytest
from mathutils import Vector

ops = bpy.ops.angen


@pytest.fixture
def housing(addon_part):
    return addon_part("angen_addon.authoring.housing")


@pytest.fixture
def housing_of(addon_part):
    return addon_part("angen_addon.authoring.of_kind").housing_of


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


def test_bodies_are_closed_and_face_outwards(housing, addon_part):
    kinds, appearance_of = (
        addon_part("sensor_logic.kinds").KINDS,
        addon_part("angen_addon.kinds").appearance_of,
    )
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


def test_every_preset_with_a_housing_of_its_own_exists(addon_part):
    appearance_of = addon_part("angen_addon.kinds").appearance_of
    for kind in addon_part("sensor_logic.kinds").KINDS.values():
        known = {"", *(preset.identifier for preset in kind.presets)}
        assert set(appearance_of(kind).housings) <= known


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


def test_a_preset_brings_its_housing(world):
    ops.sensor_add(kind="PRESSURE", preset="FSR_402")
    assert max(c[0] for c in bpy.context.object.bound_box) == pytest.approx(0.00914, rel=1e-3)


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


def test_menus_offer_all_kinds_the_door_and_residents(world):
    for name, count, menus in (
        ("ANGEN_MT_sensor_add", 13, ["ANGEN_MT_resident_add"]),
        ("ANGEN_MT_object_sensor", 9, []),
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
        cls.draw(SimpleNamespace(layout=Layout()), bpy.context)
        assert len(drawn) == count and drawn_menus == menus
        for idname, how in drawn:
            assert (how == "INVOKE_REGION_WIN") == (idname == "angen.sensor_place") or (
                idname == "angen.door_fit"
            )


@pytest.mark.parametrize("preset", ["FSR_402", "FSR_406"])
def test_what_stands_on_a_small_resistor_presses_on_it(world, preset):
    """A cube of 1 kg on a disk half a millimetre thin: the contact solver finds it."""
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
