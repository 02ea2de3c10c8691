# SPDX-License-Identifier: GPL-3.0-or-later
"""Light through window panes against Fresnel's equations, and the four one-pixel views.

The views give 8-bit luminance in percent, within clip distances and a field of view.
"""

import math

import bpy
import light_stage as stage
import numpy as np
import pytest
from light_stage import facing, lamp, material, measure, part, percent, plate, request, sky

# The reflectance of a plane-parallel pane with a refractive index of 1.5, from the front.
REFLECTED = ((1.5 - 1.0) / (1.5 + 1.0)) ** 2
PANE = (1 - REFLECTED) / (1 + REFLECTED)


def reflectance(angle, index=1.5):
    """Return Fresnel's reflectance for unpolarised light."""
    inside = math.asin(math.sin(angle) / index)
    if angle == 0.0:
        return REFLECTED
    senkrecht = math.sin(angle - inside) / math.sin(angle + inside)
    parallel = math.tan(angle - inside) / math.tan(angle + inside)
    return (senkrecht**2 + parallel**2) / 2


def shader(kind, **inputs):
    material = bpy.data.materials.new("glass")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    node, output = tree.nodes.new(kind), tree.nodes.new("ShaderNodeOutputMaterial")
    for name, value in inputs.items():
        node.inputs[name.replace("_", " ")].default_value = value
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    return material


def glass(**inputs):
    return shader("ShaderNodeBsdfGlass", **{"Roughness": 0.0, "IOR": 1.5, **inputs})


def principled(**inputs):
    plain = {"Roughness": 0.0, "IOR": 1.5, "Base_Color": (1.0, 1.0, 1.0, 1.0)}
    return shader("ShaderNodeBsdfPrincipled", Transmission_Weight=1.0, **{**plain, **inputs})


def sun(world, angle=0.0):
    data = bpy.data.lights.new("sun", "SUN")
    data.energy, data.angle = 100.0, 0.0
    world.link("sun", data, (0, 0, 5)).rotation_euler.x = angle


def pane(world, material, size=(3, 3, 0.006), at=(0, 0, 1)):
    obj = world.box(size, at, "pane")
    obj.data.materials.append(material)
    return obj


@pytest.mark.parametrize("make", [glass, principled])
@pytest.mark.parametrize("degrees", [0, 50])
def test_the_sun_shines_through_a_pane(world, make, degrees):
    angle = math.radians(degrees)
    sun(world, angle)
    pane(world, make(), size=(30, 30, 0.006))
    share = (1 - reflectance(angle)) / (1 + reflectance(angle))
    assert stage.lux() == pytest.approx(100 * math.cos(angle) * share, rel=0.01)


@pytest.mark.parametrize("kind", ["POINT", "AREA"])
def test_a_lamp_shines_through_once(world, kind):
    """Its light counts once, though shadow rays and light paths both may reach the lamp."""
    data = bpy.data.lights.new("lamp", kind)
    data.energy = 100.0
    if kind == "AREA":
        data.size = 2.0
    world.link("lamp", data, (0, 0, 4))
    bare = stage.lux()
    pane(world, glass())
    assert stage.lux() == pytest.approx(PANE * bare, rel=0.02)


def test_a_sky_shines_through_once(world):
    world.scene.world = bpy.data.worlds.new("sky")
    world.scene.world.use_nodes = True
    world.scene.world.node_tree.nodes["Background"].inputs[0].default_value = (1, 1, 1, 1)
    pane(world, glass(), size=(300, 300, 0.006))
    # The pane reflects of the lower half as much light as it keeps of the upper half.
    assert stage.lux() == pytest.approx(math.pi, rel=0.005)


def test_colours_are_of_each_face(world):
    sun(world)
    pane(world, glass(Color=(0.5, 0.5, 0.5, 1)))
    assert stage.lux() == pytest.approx(100 * 0.25 * (1 - REFLECTED) ** 2, rel=0.01)


def sheet(world):
    made = world.wall(-1.0, "pane")
    made.data.materials.append(glass())
    return made


def solidified(world):
    modifier = sheet(world).modifiers.new("thick", "SOLIDIFY")
    modifier.thickness = 0.004


def faces_apart(world):
    made = pane(world, glass())
    split = made.modifiers.new("split", "EDGE_SPLIT")
    split.split_angle = 0.0


def within_an_instance(world):
    made = pane(world, glass())
    held = bpy.data.collections.new("window")
    held.objects.link(made)
    world.scene.collection.objects.unlink(made)
    world.instance("holder", held)


def moved_by_physics(world):
    made = pane(world, glass())
    world.bpy.context.view_layer.objects.active = made
    bpy.ops.rigidbody.object_add(type="PASSIVE")


@pytest.mark.parametrize(
    "build", [sheet, solidified, faces_apart, within_an_instance, moved_by_physics]
)
def test_panes_of_any_making(world, build):
    sun(world)
    build(world)
    assert stage.lux() == pytest.approx(100 * PANE, rel=0.01)


def test_the_users_material_is_as_before(world):
    sun(world)
    made = pane(world, glass())
    stage.lux()
    assert made.material_slots[0].link == "DATA"
    assert [n.type for n in made.data.materials[0].node_tree.nodes] == [
        "BSDF_GLASS",
        "OUTPUT_MATERIAL",
    ]
    assert len(bpy.data.materials) == 1 and len(bpy.data.objects) == 2


def ball(world):
    """Add a solid ball, which focuses light."""
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.4, location=(0, 0, 1))
    bpy.context.object.name = "pane"
    bpy.context.object.data.materials.append(glass())


def thick(world):
    pane(world, glass(), size=(1, 1, 0.5))


def keyed(world):
    material = pane(world, glass()).data.materials[0]
    material.node_tree.nodes[0].inputs["Color"].keyframe_insert("default_value", frame=1)


@pytest.mark.parametrize("build", [ball, thick, keyed])
def test_what_is_no_pane_is_named(world, command, tmp_path, build):
    sun(world)
    build(world)
    world.sensor("LIGHT", "light")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "home.blend"))
    status, found, _ = command("doctor")
    assert status == 1 and "the glass 'glass' of 'pane'" in found
    _, _, advice = command("simulate", "--frames", "1:1")
    assert "no lamp and no sun through the glass 'glass' of 'pane'" in advice


def test_panes_and_bottles_are_not_named(world, command, tmp_path):
    sun(world)
    pane(world, glass())
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.05, location=(0.4, 0, 1))
    bpy.context.object.data.materials.append(glass())
    world.sensor("LIGHT", "light")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "home.blend"))
    assert "glass" not in command("doctor")[1]


# The four one-pixel views


UPRIGHT = facing((0, 1, 0))
COUNT = 100 / 255


def walls(world, *radiances, distance=2.0, size=1.0):
    """Add glowing walls ahead of a sensor's −Z, −X, +Z, +X."""
    x, z = UPRIGHT[:3, 0], UPRIGHT[:3, 2]
    for way, radiance in zip((-z, -x, z, x), radiances, strict=False):
        glow = material(glows=radiance)
        plate(world, size, tuple(way * distance), tuple(-way), glow)


def look(**asked):
    return percent(matrix=UPRIGHT, **{"samples": 64, **asked})


def test_all_white_is_100_percent(world):
    sky(world, 1.0)
    assert look() == pytest.approx(100.0)


def test_all_black_is_0_percent(world):
    assert look() == 0.0


def test_one_count_is_0_39_percent(world):
    sky(world, 1.0 / 255)
    assert look() == pytest.approx(COUNT)
    sky(world, 0.49 / 255)
    assert look() == 0.0


def test_the_four_views_are_averaged(world):
    walls(world, 0.2, 0.4, 0.6, 1.0)
    counts = [round(255 * v) for v in (0.2, 0.4, 0.6, 1.0)]
    assert look() == pytest.approx(np.mean(counts) * COUNT, abs=1e-9)


@pytest.mark.parametrize("wall", range(4))
def test_each_view_looks_where_it_should(world, wall):
    radiances = [0.0] * 4
    radiances[wall] = 1.0
    walls(world, *radiances)
    world.update()
    asked = request(matrix=UPRIGHT, method="FOUR_WALL", samples=64)
    light = part("light.cycles").CyclesLight()
    light.look(world.scene, bpy.context.view_layer)
    found, _ = part("light.probe").finished(light.light([asked]))
    light.close()
    found = found[asked.name]
    assert found.colours == pytest.approx(np.outer(radiances, [1, 1, 1]))


def test_colours_count_by_luminance_of_their_counts(world):
    walls(world, *[(1.0, 0.5, 0.25)] * 4)
    expected = (0.2126 * 255 + 0.7152 * 128 + 0.0722 * 64) * COUNT
    assert look() == pytest.approx(expected, abs=1e-9)


def test_too_bright_is_white_and_exposure_scales(world):
    walls(world, *[4.0] * 4)
    assert look() == pytest.approx(100.0)
    assert look(exposure=0.125) == pytest.approx(128 * COUNT)
    assert look(exposure=0.0) == 0.0


def test_nearer_than_the_clip_is_not_seen(world):
    walls(world, *[1.0] * 4, distance=0.45)
    assert look() == 0.0
    assert look(clip_start=0.4) == pytest.approx(100.0)


def test_farther_than_the_clip_is_not_seen(world):
    walls(world, *[1.0] * 4, distance=4.0)
    assert look() == pytest.approx(100.0)
    assert look(clip_end=3.9) == 0.0


@pytest.mark.parametrize("angle", [0.02, 0.4, 1.5])
def test_the_view_is_a_square_of_the_field_of_view(world, angle):
    """A wall that covers half the width and half the height is a quarter of the light."""
    size = 2 * 2 * math.tan(angle / 2) / 2
    walls(world, *[1.0] * 4, size=size)
    assert look(field_of_view=angle, samples=4096) == pytest.approx(25.0, abs=1.0)


def test_a_white_wall_under_a_lamp(world):
    """Its radiance is ρ E / π."""
    x, z = UPRIGHT[:3, 0], UPRIGHT[:3, 2]
    for way in (-z, -x, z, x):
        plate(world, 1.0, tuple(way * 2), tuple(-way), material(0.5))
    lamp(world, "POINT", at=(0, 0, 0), energy=100.0)
    radiance = 0.5 / math.pi * 100 / (4 * math.pi * 4)
    # A hundredth of the light goes from wall to wall.
    assert look(samples=4096) == pytest.approx(100 * radiance, rel=0.03)


def test_eevee_is_refused_with_a_reason_where_it_cannot_run(world, monkeypatch):
    engine = part("light.engine")
    monkeypatch.setattr(engine, "_why_no_eevee_in_background", lambda: "no GPU; choose Cycles")
    with pytest.raises(part("light.probe").AngenError, match="choose Cycles"):
        look(engine="EEVEE")


@pytest.mark.slow
@pytest.mark.parametrize("method", ["FOUR_WALL", "ILLUMINANCE"])
def test_no_lamp_shines_through_a_wall_in_eevee(world, method):
    if reason := part("light.engine").why_no_eevee():
        pytest.skip(reason)
    box = world.box((2, 2, 2))
    box.data.materials.append(material(0.5))
    lamp(world, "POINT", at=(0, 5, 0), energy=500.0)
    world.update()
    asked = request(matrix=UPRIGHT, method=method, samples=16, engine="EEVEE")
    found = measure(asked)[asked.name]
    assert (found.luminance_percent or 0.0) == (found.illuminance_lux or 0.0) == 0.0


def test_what_a_sensor_sees_does_not_depend_on_the_others(world):
    """Some views cross each other's far ends, where a path hits one surface more."""
    box = world.box((9, 9, 4))
    box.data.materials.append(material(0.5))
    lamp(world, "POINT", at=(1, 1, 1), energy=3000.0)
    apart = {"a": (0, 0, 0), "b": (3, 0, 0), "c": (0, 3, 0), "d": (3, 0.02, 0), "e": (-3, -2, 0)}
    asked = [
        request(name, method="FOUR_WALL", matrix=facing((0, 1, 0), place), samples=16)
        for name, place in apart.items()
    ]
    together = measure(*asked)
    for alone in asked:
        assert measure(alone)[alone.name] == together[alone.name]
    assert len({sample.luminance_percent for sample in together.values()}) > 2


def test_fog_in_the_world_counts_from_where_it_sees(world):
    """The path goes to a glowing wall at 4 m, from the near end of the views."""
    fog = sky(world, 0.0).node_tree
    absorbs = fog.nodes.new("ShaderNodeVolumeAbsorption")
    absorbs.inputs["Density"].default_value = 0.2
    absorbs.inputs["Color"].default_value = (0, 0, 0, 1)
    output = next(node for node in fog.nodes if node.type == "OUTPUT_WORLD")
    fog.links.new(absorbs.outputs[0], output.inputs["Volume"])
    walls(world, *[1.0] * 4, distance=4.0)
    assert look() == pytest.approx(100 * math.exp(-0.2 * 3.5), abs=0.6)
