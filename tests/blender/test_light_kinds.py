# SPDX-License-Identifier: GPL-3.0-or-later
"""Light of all kinds: lamps with nodes and IES files, light linking, an image as the world, objects
that only shadow, instances of collections."""

import math
import subprocess
import sys
from pathlib import Path

import bpy
import numpy as np
import pytest
from light_stage import facing, lamp, lux, material, plate, request
from mathutils import Matrix

CANDELA = (100.0, 75.0, 50.0, 25.0, 0.0)
IES = f"""IESNA:LM-63-1995
TILT=NONE
1 -1 1 5 1 1 2 0 0 0
1 1 0
0 30 60 75 90
0
{" ".join(f"{c:g}" for c in CANDELA)}
"""


def emission(light):
    light.data.use_nodes = True
    tree = light.data.node_tree
    return tree, next(n for n in tree.nodes if n.type == "EMISSION")


@pytest.mark.parametrize(("tilt", "share"), [(0, 1.0), (30, 0.75), (60, 0.5), (75, 0.25)])
def test_an_ies_lamp_shines_as_its_table_says(world, tilt, share):
    """Vertical angles count from straight down."""
    angle = math.radians(tilt)
    light = lamp(world, "POINT", at=(0, 0, 0))
    tree, shader = emission(light)
    text = bpy.data.texts.new("lamp.ies")
    text.write(IES)
    table = tree.nodes.new("ShaderNodeTexIES")
    table.mode, table.ies = "INTERNAL", text
    tree.links.new(table.outputs[0], shader.inputs["Strength"])
    place = 2 * np.array([math.sin(angle), 0, -math.cos(angle)])
    matrix = facing(-place, place)
    found = lux(request(matrix=matrix, samples=64))
    straight = lux(request(matrix=facing((0, 0, 1), (0, 0, -2)), samples=64))
    assert straight > 0.0
    assert found / straight == pytest.approx(share, rel=0.02)


def test_a_lamp_whose_nodes_look_at_its_direction(world):
    """Strength by a ray's normal: a lamp that shines to one side of the world alone."""
    light = lamp(world, "POINT", at=(0, 0, 0))
    tree, shader = emission(light)
    geometry, split = (
        tree.nodes.new("ShaderNodeNewGeometry"),
        tree.nodes.new("ShaderNodeSeparateXYZ"),
    )
    side = tree.nodes.new("ShaderNodeMath")
    side.operation = "GREATER_THAN"
    side.inputs[1].default_value = 0.0
    tree.links.new(geometry.outputs["Normal"], split.inputs[0])
    tree.links.new(split.outputs["X"], side.inputs[0])
    tree.links.new(side.outputs[0], shader.inputs["Strength"])
    found = sorted(
        lux(request(matrix=facing((-x, 0, 0), (2 * x, 0, 0)), samples=64)) for x in (-1, 1)
    )
    assert found == pytest.approx([0.0, 1 / (4 * math.pi * 4)], rel=2e-3, abs=1e-9)


def test_light_linking_a_lamp_shines_on_its_receivers_alone(world):
    """What is bounced off the wall comes; the sensor's own face is no receiver."""
    light = lamp(world, "POINT", at=(0, 0, 1), energy=10.0)
    wall = plate(world, 8.0, (0, 0, 2), (0, 0, -1), material(0.5))
    plain = lux(request(samples=4096))
    only = bpy.data.collections.new("receivers")
    light.light_linking.receiver_collection = only
    only.objects.link(wall)
    found = lux(request(samples=4096))
    # A large plate over the lamp: an image of the lamp at twice the distance, Lambertian.
    direct = 10 / (4 * math.pi)
    assert plain - found == pytest.approx(direct, rel=0.02)
    assert found > 0.05 * direct


def test_a_lamp_that_a_blocker_list_lets_through(world):
    light = lamp(world, "POINT", at=(0, 0, 2))
    shade = plate(world, 1.0, (0, 0, 1), (0, 0, -1), material(0.001))
    assert lux(request(samples=16)) == pytest.approx(0.0, abs=1e-3)
    blockers = bpy.data.collections.new("blockers")
    light.light_linking.blocker_collection = blockers
    blockers.objects.link(shade)
    blockers.collection_objects[0].light_linking.link_state = "EXCLUDE"
    assert lux(request(samples=16)) == pytest.approx(1 / (4 * math.pi * 4), rel=0.01)


def test_an_image_as_the_world(world):
    """White above, black below: π looking up, 0 looking down, half of it to the side."""
    image = bpy.data.images.new("half", 64, 32, float_buffer=True, is_data=True)
    pixels = np.zeros((32, 64, 4), np.float32)
    pixels[16:, :, :3] = 1.0
    pixels[..., 3] = 1.0
    image.pixels.foreach_set(pixels.ravel())
    sky = bpy.data.worlds.new("image")
    if not sky.node_tree:
        sky.use_nodes = True
    nodes = sky.node_tree.nodes
    background = next(n for n in nodes if n.type == "BACKGROUND")
    texture = nodes.new("ShaderNodeTexEnvironment")
    texture.image, texture.interpolation = image, "Closest"
    sky.node_tree.links.new(texture.outputs[0], background.inputs["Color"])
    world.scene.world = sky
    for normal, share in (((0, 0, 1), 1.0), ((1, 0, 0), 0.5), ((0, 0, -1), 0.0)):
        found = lux(request(matrix=facing(normal)))
        assert found == pytest.approx(share * math.pi, rel=0.02, abs=0.01), normal


def test_an_object_that_only_shadows(world):
    """Unseen by all rays but those to lamps: it takes the lamp away and sends nothing back."""
    lamp(world, "POINT", at=(0, 0, 2))
    shade = plate(world, 1.0, (0, 0, 1), (0, 0, -1), material(0.8))
    for rays in ("camera", "diffuse", "glossy", "transmission", "volume_scatter"):
        setattr(shade, f"visible_{rays}", False)
    assert lux(request(samples=64)) == pytest.approx(0.0, abs=1e-6)
    shade.visible_shadow = False
    assert lux(request(samples=64)) == pytest.approx(1 / (4 * math.pi * 4), rel=2e-3)


def instanced(world, thing):
    """An instance, 5 m aside of nothing else, of a collection that is in no scene."""
    source = bpy.data.collections.new("source")
    world.scene.collection.objects.unlink(thing)
    source.objects.link(thing)
    empty = world.link("instance", None)
    empty.instance_type, empty.instance_collection = "COLLECTION", source
    return empty


def test_an_instance_of_a_collection_shades_and_one_that_is_hidden_does_not(world):
    lamp(world, "POINT", at=(0, 0, 2))
    empty = instanced(world, plate(world, 1.0, (0, 0, 1), (0, 0, -1), material(0.001)))
    asked = request(samples=16)
    assert lux(asked) == pytest.approx(0.0, abs=1e-3)
    empty.matrix_world = Matrix.Translation((9, 0, 0))
    assert lux(asked) == pytest.approx(1 / (4 * math.pi * 4), rel=0.01)
    empty.matrix_world = Matrix()
    empty.hide_set(True)
    assert lux(asked) == pytest.approx(1 / (4 * math.pi * 4), rel=0.01)


def test_a_lamp_inside_an_instance_shines(world):
    instanced(world, lamp(world, "POINT", at=(0, 0, 2)))
    expected = 1 / (4 * math.pi * 4)
    assert lux(request(samples=16)) == pytest.approx(expected, rel=2e-3)


RUN = """
import sys
sys.path.insert(0, {root!r})
import bpy
from angen_addon.process.standalone import load_extension
extension = load_extension()
extension.register()
import numpy as np
from angen_sensors.angen_addon.scene.light import probe
asked = [probe.LightRequest(m, np.eye(4), m, samples=1) for m in ("ILLUMINANCE", "FOUR_WALL")]
probe.measure(bpy.context.scene, bpy.context.view_layer, asked)
extension.unregister()
print("MEASURED")
"""


def test_a_process_that_measured_ends():
    """The wheel hangs at its end where a handler of Python's is left after a render."""
    script = RUN.format(root=str(Path(__file__).resolve().parents[2]))
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=60, check=False
    )
    assert "MEASURED" in done.stdout and done.returncode == 0, done.stderr
