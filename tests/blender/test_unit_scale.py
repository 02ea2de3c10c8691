# SPDX-License-Identifier: GPL-3.0-or-later
"""Readings with units, such as newtons and lux, do not depend on the scene's unit scale."""

import math

import bpy
import pytest
from bl_ext.user_default.angen_sensors.angen_addon import doctor
from light_stage import facing, lamp, lux, material, plate, request, sky
from panel_layout import drawn
from pressure_scenes import G

WATTS = 10.0
# lx under a point lamp of 10 W at 2 m.
LUX = 135.9


@pytest.fixture
def scaled(world):
    """Return a function that sets a scene's unit scale, and returns how many units are a metre."""

    def set_scale(scale, system="METRIC"):
        world.scene.unit_settings.system = system
        world.scene.unit_settings.scale_length = scale
        return 1.0 if system == "NONE" else 1.0 / scale

    return set_scale


# Forces on pads.


@pytest.mark.parametrize(
    ("scale", "is_typed"),
    [(s, False) for s in (0.01, 0.001, 0.0254, 0.3048, 10.0)]
    + [(s, True) for s in (0.01, 0.001, 0.0254)],
)
def test_a_person_and_a_crate_weigh_the_same_at_any_scale(physics, scaled, scale, is_typed):
    """Typed numbers are what Blender's fields show; stored ones are those of a new scene."""
    metre = scaled(scale)
    if is_typed:
        physics.scene.gravity = (0, 0, -9.81 * metre)
    physics.frames(8)
    half = 5 * metre
    physics.rigid_body(physics.solid("floor", (half, half, half), (0, 0, -half)), "PASSIVE")
    thick = 0.01 * metre
    physics.pad(half=(40 * thick, 40 * thick, thick), at=(0, 0, thick), kind="PASSIVE")
    at = (-0.2 * metre, 0, 2 * thick + 0.5 * metre)
    physics.carried("Person", (0.02 * metre, 0.02 * metre, 0.5 * metre), at, 70.0)
    assert physics.read().known(after=3) == pytest.approx(686.7, rel=1e-3)
    side = 0.05 * metre
    # The crate's mass is typed too: the field shows cubic units.
    mass = 5.0 * metre**3 if is_typed else 5.0
    physics.body("Crate", (side, side, side), (0.1 * metre, 0, 2 * thick + side), mass)
    assert physics.read().known(after=3) == pytest.approx(75 * G, rel=1e-3)


def test_a_fall_in_slow_time_gives_its_impulse(physics, scaled):
    """By gravity of 9.81 units, a crate of 2 kg falls ten times as slowly in centimetres."""
    metre = scaled(0.01)
    physics.frames(60)
    half = 5 * metre
    physics.rigid_body(physics.solid("floor", (half, half, half), (0, 0, -half)), "PASSIVE")
    thick = 0.01 * metre
    physics.pad(half=(40 * thick, 40 * thick, thick), at=(0, 0, thick), kind="PASSIVE")
    side = 0.05 * metre
    at = (0, 0, 2 * thick + side + 0.1 * metre)
    physics.body("Crate", (side, side, side), at, 2.0, linear_damping=0.0)
    pad = physics.read()
    # 10 cm take 1.43 s in the engine's time.
    assert pad.valid[1:32].all() and pad.force[1:32] == pytest.approx(0.0, abs=0.02)
    assert pad.force.max() > 3 * 2 * G
    assert pad.valid[-3:].all() and pad.force[-3:] == pytest.approx(2 * G, rel=1e-3)


@pytest.mark.parametrize(
    ("scale", "stored", "true"),
    [(0.01, 1.62, 1.62), (0.01, 162.0, 1.62), (0.3048, 9.81 / 0.3048, 9.81), (1.0, 24.8, 24.8)],
)
def test_other_gravity_is_read_as_stored_or_as_typed(physics, scaled, scale, stored, true):
    metre = scaled(scale)
    physics.scene.gravity = (0, 0, -stored)
    physics.frames(6)
    size = 0.5 * metre
    physics.pad(half=(size, size, 0.01 * metre), at=(0, 0, -0.01 * metre))
    physics.carried("Person", (0.1 * metre, 0.1 * metre, size), (0, 0, size), 70.0)
    assert physics.read().known(after=2) == pytest.approx(70 * true, rel=1e-3)


# Light.


def lit(world, metre, kind, watts=WATTS, at=2.0, **settings):
    return lamp(world, kind, at=(0, 0, at * metre), energy=watts, **settings)


def measured(**asked):
    return lux(request(samples=64, **asked)) * 683.0


@pytest.mark.parametrize("is_typed", [False, True], ids=["stored", "typed"])
@pytest.mark.parametrize("scale", [0.01, 0.001, 0.0254, 0.3048])
def test_ten_watts_at_two_metres_are_135_9_lux(world, scaled, scale, is_typed):
    metre = scaled(scale)
    # Blender's field shows the power in square units.
    watts = WATTS * metre**2 if is_typed else WATTS
    lit(world, metre, "POINT", watts)
    assert measured() == pytest.approx(LUX, rel=1e-3)


KINDS = {
    "POINT": lambda metre: {},
    "POINT of a size": lambda metre: {"shadow_soft_size": 0.1 * metre},
    "SPOT": lambda metre: {"spot_size": math.radians(60), "spot_blend": 0.0},
    "AREA": lambda metre: {"size": 0.5 * metre},
    "AREA, disk": lambda metre: {"shape": "DISK", "size": 0.5 * metre},
    "SUN": lambda metre: {},
}


@pytest.mark.parametrize("kind", KINDS)
def test_a_lamp_of_any_kind_gives_the_same_light(world, scaled, kind):
    found = []
    for scale in (1.0, 0.01, 0.0254):
        metre = scaled(scale)
        made = lit(world, metre, kind.partition(" ")[0].rstrip(","), **KINDS[kind](metre))
        found.append(measured())
        bpy.data.objects.remove(made)
    assert found[0] > 1.0
    assert found[1:] == pytest.approx([found[0]] * 2, rel=2e-3)


@pytest.mark.skipif(
    "normalize" not in bpy.types.AreaLight.bl_rna.properties, reason="from Blender 4.5 on"
)
def test_a_lamp_by_radiance_is_independent_of_scale(world, scaled):
    found = []
    for scale in (1.0, 0.01):
        metre = scaled(scale)
        made = lit(world, metre, "AREA", size=0.5 * metre, normalize=False)
        found.append(measured())
        bpy.data.objects.remove(made)
    assert found[1] == pytest.approx(found[0], rel=2e-3)


def test_sky_and_glowing_surfaces_stay_as_they_are(world, scaled):
    found = []
    for scale in (1.0, 0.01):
        metre = scaled(scale)
        made = plate(world, metre, (0, 0, metre), (0, 0, -1), material(glows=2.0))
        sky(world, 0.5)
        found.append(measured())
        bpy.data.objects.remove(made)
    assert found[1] == pytest.approx(found[0], rel=0.02)


def test_lamps_in_instances_follow_the_scale_too(world, scaled):
    metre = scaled(0.01)
    made = lit(world, metre, "POINT")
    world.instance("Lamps", world.aside("lamps", made))
    assert measured() == pytest.approx(LUX, rel=1e-3)


@pytest.mark.parametrize("what", ["Object", "Collection"])
def test_lamps_that_nodes_instance_follow_the_scale_too(world, scaled, what):
    metre = scaled(0.01)
    made = lit(world, metre, "POINT")
    made.location = (0, 0, 5000 * metre if what == "Object" else 0)
    tree = bpy.data.node_groups.new("nodes", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    node = tree.nodes.new(f"GeometryNode{what}Info")
    if what == "Object":
        node.inputs["As Instance"].default_value = True
    node.inputs[what].default_value = made if what == "Object" else world.aside("lamps", made)
    out = tree.nodes.new("NodeGroupOutput")
    found = next(s for s in node.outputs if s.type == "GEOMETRY")
    tree.links.new(found, out.inputs[0])
    holder = world.link("Chandelier", bpy.data.meshes.new("empty"), (0, 0, 2 * metre))
    holder.modifiers.new("nodes", "NODES").node_group = tree
    world.update()
    assert measured() == pytest.approx(LUX, rel=1e-3)


def test_without_units_a_number_is_in_metres(world, scaled):
    scaled(0.01, "NONE")
    lit(world, 1.0, "POINT")
    assert measured() == pytest.approx(LUX, rel=1e-3)


def test_a_lamp_that_is_dimmed_keeps_its_unit_at_each_frame(world, scaled):
    """A lamp that was typed as 10 W: keyed to 0.1 %, it has 10 mW, not 100 W."""
    metre = scaled(0.01)
    made = lit(world, metre, "POINT", WATTS * metre**2).data
    world.key(made, "energy", {1: made.energy, 2: made.energy / 1000})
    for frame, share in ((1, 1.0), (2, 0.001)):
        world.scene.frame_set(frame)
        assert measured() == pytest.approx(share * LUX, rel=1e-3)


def test_a_run_of_a_switched_lamp_in_an_instance_is_in_lux(world, scaled):
    metre = scaled(0.01)
    made = lit(world, metre, "POINT")
    world.key(made.data, "energy", {1: WATTS, 3: WATTS, 4: 0.0}, interpolation="CONSTANT")
    world.instance("Lamps", world.aside("lamps", made))
    sensor = world.sensor("LIGHT", "light", method="ILLUMINANCE", samples=64, update_rate=24.0)
    sensor.matrix_world = facing((0, 0, 1)).tolist()
    world.scene.angen_luminous_efficacy = 683.0
    world.scene.frame_end = 5
    found = world.series(world.run(), "light", "illuminance_lux")
    assert found == pytest.approx([LUX, LUX, LUX, 0.0, 0.0], rel=1e-3, abs=1e-3)


# What the doctor tells.


def told(world, check="units"):
    depsgraph = world.update()
    found = doctor.examine(bpy.context.scene, bpy.context.view_layer, depsgraph)
    return [one for one in found if one.check == check]


@pytest.fixture
def centimetres(physics, scaled):
    """A room in centimetres with a lamp, a crate, a pad and a light sensor, from a script."""
    world, metre = physics.world, scaled(0.01)
    lit(world, metre, "POINT")
    physics.pad(kind="PASSIVE")
    physics.body("Crate", (10, 10, 10), (0, 0, 11), 5.0)
    world.sensor("LIGHT", "light")
    return world


def test_the_doctor_tells_numbers_that_blender_shows_otherwise(centimetres):
    mass, power, gravity = told(centimetres)
    assert "mass of 5e-06 kg, and sensors take 5 kg: 'Crate'" in mass.text
    assert "power of 0.001 W, and sensors take 10 W: 'point'" in power.text
    assert "gravity is 0.0981 m/s², and pads take 9.81 m/s²" in gravity.text
    assert "fall too slowly" in gravity.text and "Type 9.81 m/s²" in gravity.mend


def test_the_doctor_is_content_once_they_are_typed(centimetres):
    centimetres.scene.gravity = (0, 0, -981)
    bpy.data.objects["Crate"].rigid_body.mass = 5e6
    bpy.data.lights["point"].energy = 1e5
    assert told(centimetres) == told(centimetres, "watts") == []


def test_electrical_watts_are_told_in_any_unit(centimetres):
    bpy.data.lights["point"].energy = 60.0
    (found,) = told(centimetres, "watts")
    assert "'point' shines with 60 W of light" in found.text


def test_in_metres_and_without_units_nothing_is_told(centimetres, scaled):
    scaled(1.0)
    assert told(centimetres) == []
    scaled(0.01, "NONE")
    assert told(centimetres) == []


# The fields of a resident.


def shown(field, scale):
    """Return what Blender's field shows of a property, in metres, kilograms and seconds."""
    owner, name = field
    powers = {"LENGTH": 1, "VELOCITY": 1, "MASS": 3, "NONE": 0}
    unit = owner.bl_rna.properties[name].unit
    return getattr(owner, name) * scale ** powers[unit]


@pytest.mark.parametrize("scale", [1.0, 0.01, 0.001, 0.0254, 100.0])
def test_the_fields_of_a_resident_show_its_true_size_speed_and_mass(world, scaled, scale):
    metre = scaled(scale)
    bpy.ops.angen.resident_add(sort="ADULT")
    rig = bpy.context.object
    fields = drawn("ANGEN_PT_sidebar_resident").fields
    mass = next(label for label in fields if label.startswith("Mass"))
    assert shown(fields["Stature"], scale) == pytest.approx(rig.angen_resident.stature, rel=1e-5)
    assert 1.5 < rig.angen_resident.stature < 2.0
    assert shown(fields["Speed"], scale) == pytest.approx(rig.angen_resident.speed, rel=1e-5)
    assert shown(fields[mass], scale) == pytest.approx(rig.angen_resident.mass, rel=1e-5)
    for label, wanted in (("Stature", 1.6), ("Speed", 0.8)):
        owner, name = fields[label]
        setattr(owner, name, wanted * metre if name.endswith("in_units") else wanted)
        assert shown(fields[label], scale) == pytest.approx(wanted, rel=1e-5)
    assert rig.angen_resident.stature == pytest.approx(1.6, rel=1e-5)
    assert rig.angen_resident.speed == pytest.approx(0.8, rel=1e-5)
    assert rig.dimensions.z * scale == pytest.approx(1.6, rel=0.1)
