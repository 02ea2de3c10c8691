# SPDX-License-Identifier: GPL-3.0-or-later
"""Light through window panes, against Fresnel's equations."""

import math

import bpy
import light_stage as stage
import pytest

# Of a plane-parallel pane with an index of refraction of 1.5, from the front.
REFLECTED = ((1.5 - 1.0) / (1.5 + 1.0)) ** 2
PANE = (1 - REFLECTED) / (1 + REFLECTED)


def reflectance(angle, index=1.5):
    """Fresnel's for unpolarised light."""
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
    """Neither twice, by shadow rays and by light paths that happen to meet the lamp."""
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
    # What it keeps of the upper half, it reflects of the lower one.
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
    holder = world.link("holder", None)
    holder.instance_type, holder.instance_collection = "COLLECTION", held


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


def test_a_colour_that_is_edited_counts(world):
    sun(world)
    made = pane(world, glass())
    switch = made.data.materials[0].node_tree.nodes[0].inputs["Color"]
    assert stage.lux() == pytest.approx(100 * PANE, rel=0.01)
    switch.default_value = (0.0, 0.0, 0.0, 1.0)
    assert stage.lux() < 1.0


def ball(world):
    """A solid ball, which gathers light."""
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
