# SPDX-License-Identifier: GPL-3.0-or-later
"""Illuminance by Cycles against closed forms, also in the sample light.blend.

The efficacy is 1, so illuminances are in W/m².
"""

import math
import subprocess
import sys
from pathlib import Path

import bpy
import numpy as np
import pytest
from light_stage import ball, facing, lamp, lux, material, measure, part, plate, request, sky
from mathutils import Matrix, Vector

DIRECT_TOLERANCE, AREA_TOLERANCE = 1e-3, 2e-3
SOFT = 0.3


def form_factor(size_x, size_y, distance):
    """Return the form factor of a parallel rectangle centred over a small face (Hottel)."""
    a, b = size_x / 2 / distance, size_y / 2 / distance
    p, q = math.hypot(1, a), math.hypot(1, b)
    return 4 / (2 * math.pi) * (a / p * math.atan(b / p) + b / q * math.atan(a / q))


@pytest.mark.parametrize("tilt", [0.0, 0.5, 1.2])
def test_a_point_lamp_is_its_power_over_the_sphere(world, tilt):
    lamp(world, "POINT", energy=10.0)
    normal = (math.sin(tilt), 0, math.cos(tilt))
    # The measured face is 1 mm ahead of the sensor.
    way = Vector((0, 0, 2)) - 0.001 * Vector(normal)
    expected = 10 / (4 * math.pi) * way.dot(normal) / way.length**3
    found = lux(request(matrix=facing(normal), samples=16))
    assert found == pytest.approx(expected, rel=DIRECT_TOLERANCE / 2)


@pytest.mark.parametrize("soft", [True, False])
def test_a_ball_of_a_lamp(world, soft):
    lamp(world, "POINT", at=(0, 0, 1.001), shadow_soft_size=SOFT, use_soft_falloff=soft)
    expected = 1 / (4 * math.pi * (1 + SOFT**2 * soft))
    found = lux(request(samples=1024))
    assert found == pytest.approx(expected, rel=AREA_TOLERANCE)


@pytest.mark.parametrize(("off", "share"), [(0.0, 1.0), (0.35, 1.0), (0.85, 0.5), (1.3, 0.0)])
def test_a_spot_lamp_has_the_intensity_of_a_point_lamp_inside_its_smooth_edge(world, off, share):
    """The smoothstep is one half where the cosine is in the middle of the edge."""
    blend, cone = 0.5, 1.8
    edge = math.cos(cone / 2)
    if share == 0.5:
        off = math.acos(edge + blend * (1 - edge) / 2)
    place = 2 * np.array([math.sin(off), 0, -math.cos(off)])
    lamp(world, "SPOT", at=(0, 0, 0), spot_size=cone, spot_blend=blend)
    expected = share / (4 * math.pi * 2**2) * 1.001
    matrix = facing(-place, place)
    found = lux(request(matrix=matrix, samples=16))
    assert found == pytest.approx(expected, rel=DIRECT_TOLERANCE, abs=1e-9)


@pytest.mark.parametrize("angle", [0.0, 0.2])
def test_a_sun_is_its_strength_times_the_cosine(world, angle):
    lamp(world, "SUN", aim=(0, 1, -1), energy=3.0, angle=angle)
    found = lux(request(samples=1024 if angle else 16))
    assert found == pytest.approx(3 * math.cos(math.pi / 4), rel=DIRECT_TOLERANCE)


@pytest.mark.parametrize("distance", [0.05, 0.5, 4.0])
@pytest.mark.parametrize("shape", ["SQUARE", "RECTANGLE"])
def test_an_area_lamp_is_its_radiance_times_the_form_factor(world, distance, shape):
    at = (0, 0, distance + 0.001)
    lamp(world, "AREA", at=at, shape=shape, size=1.0, size_y=0.5)
    y = 1.0 if shape == "SQUARE" else 0.5
    expected = math.pi * (1 / (math.pi * y)) * form_factor(1.0, y, distance)
    found = lux(request(samples=1024))
    assert found == pytest.approx(expected, rel=AREA_TOLERANCE)


@pytest.mark.parametrize("distance", [0.05, 1.0])
def test_a_disk_lamp(world, distance):
    lamp(world, "AREA", at=(0, 0, distance + 0.001), shape="DISK", size=1.0)
    radiance = 1 / (math.pi * math.pi / 4)
    expected = math.pi * radiance * 0.25 / (0.25 + distance**2)
    found = lux(request(samples=4096))
    assert found == pytest.approx(expected, rel=AREA_TOLERANCE)


def test_an_ellipse_lamp_far_away_is_its_power_over_pi(world):
    lamp(world, "AREA", at=(0, 0, 20), shape="ELLIPSE", size=0.2, size_y=0.1)
    found = lux(request(samples=256))
    assert found == pytest.approx(1 / (math.pi * 20**2), rel=AREA_TOLERANCE)


def test_a_world_is_pi_times_its_radiance(world):
    sky(world, 0.7)
    found = lux(request(samples=256))
    assert found == pytest.approx(0.7 * math.pi, rel=DIRECT_TOLERANCE)


def test_a_glowing_mesh_is_its_radiance_times_the_form_factor(world):
    plate(world, 1.0, (0, 0, 0.501), (0, 0, -1), material(glows=2.0))
    expected = 2 * math.pi * form_factor(1, 1, 0.5)
    assert lux(request(samples=1024)) == pytest.approx(expected, rel=AREA_TOLERANCE)


@pytest.mark.parametrize("reflects", [0.5, 0.8])
def test_inside_a_white_sphere_light_goes_round(world, figure, reflects):
    """Φ ρ / (A (1 − ρ)) everywhere indirectly, and the direct light of the central lamp."""
    ball(world, 2.0, material(reflects))
    lamp(world, "POINT", at=(0, 0, 0), energy=100.0)
    direct = 100 / (4 * math.pi * 2**2)
    expected = direct * (1 + reflects / (1 - reflects))
    # A face on the wall that looks to the centre.
    matrix = facing((1, 0, 0), (-1.99, 0, 0))
    found = lux(request(matrix=matrix))
    figure(abs(found / expected - 1), "of the light")
    assert found == pytest.approx(expected, rel=0.02)


def test_colours_count_by_their_luminance(world):
    lamp(world, "POINT", color=(1, 0, 0.5))
    expected = (0.2126 + 0.5 * 0.0722) / (4 * math.pi * 4)
    found = lux(request(samples=16))
    assert found == pytest.approx(expected, rel=2 * DIRECT_TOLERANCE)


@pytest.mark.parametrize(
    ("kind", "settings", "expected"),
    [
        ("POINT", {"exposure": 2.0}, 4 / (4 * math.pi * 4)),
        ("AREA", {"normalize": False, "size": 0.1}, 0.01 / (math.pi * 4)),
        ("POINT", {"normalize": False, "shadow_soft_size": 0.1}, 0.1**2 / 4),
        ("SUN", {"normalize": False, "angle": 0.2}, math.pi * math.sin(0.1) ** 2),
        ("POINT", {"use_temperature": True, "temperature": 6500.0}, 1 / (4 * math.pi * 4)),
    ],
)
def test_newer_settings_of_lamps(world, kind, settings, expected):
    if next(iter(settings)) not in bpy.types.PointLight.bl_rna.properties:
        pytest.skip("this Blender's lamps do not have it")
    lamp(world, kind, **settings)
    loose = 0.02 if "use_temperature" in settings or "normalize" in settings else 2e-3
    assert lux(request(samples=512)) == pytest.approx(expected, rel=loose)


def test_a_lamp_with_a_strength_in_its_nodes(world):
    light = lamp(world, "POINT")
    light.data.use_nodes = True
    node = next(n for n in light.data.node_tree.nodes if n.type == "EMISSION")
    node.inputs["Strength"].default_value = 3.0
    found = lux(request(samples=16))
    assert found == pytest.approx(3 / (4 * math.pi * 4), rel=2e-3)


def test_shadows(world):
    lamp(world, "POINT", at=(0, 0, 2))
    lamp(world, "POINT", at=(1, 0, 2))
    plate(world, 0.2, (0, 0, 1), (0, 0, -1), material(0.001))
    expected = 1 / (4 * math.pi * 5) * 2 / math.sqrt(5)
    # Cycles chooses one lamp per path: half of its paths choose the shaded one.
    assert lux(request(samples=1024)) == pytest.approx(expected, rel=0.1)


def test_lux_are_watts_times_the_efficacy(world):
    lamp(world, "SUN")
    for efficacy in (683.0, 179.0):
        (sample,) = measure(request(samples=4), efficacy=efficacy).values()
        assert sample.illuminance_lux == pytest.approx(efficacy, rel=1e-3)


def test_no_lamps_no_world_and_nothing_at_all_are_dark(world):
    world.scene.world = None
    assert lux(request()) == 0.0


def test_negative_lamps_take_light_away_but_not_below_dark(world, figure):
    lamp(world, "SUN", energy=3.0)
    negative = lamp(world, "SUN", energy=-1.0)
    found = lux(request(samples=64))
    figure(abs(found / 2.0 - 1), "of the light")
    assert found == pytest.approx(2.0, rel=0.1)
    negative.data.energy = -5.0
    assert lux(request(samples=64)) == 0.0


def test_colours_that_are_no_numbers_are_left_out(world):
    lamp(world, "SUN")
    broken = lamp(world, "SUN")
    broken.data.color = (math.nan, 1, 1)
    assert math.isfinite(lux(request(samples=16)))


@pytest.mark.parametrize("far", [1e3, 1e4])
def test_far_from_the_origin_it_is_right(world, figure, far):
    """10 km away coordinates have steps of a millimetre."""
    lamp(world, "POINT", at=(far, 0, 2))
    box = world.box((8, 8, 8), at=(far, 0, 0))
    box.data.materials.append(material(0.001))
    poses = [facing((0, 0, 1), (far + 0.02 * n, 0, 0)) for n in range(3)]
    found = lux(*[request(f"{n}", p, samples=64) for n, p in enumerate(poses)])
    expected = 1 / (4 * math.pi * 4)
    figure(max(abs(value / expected - 1) for value in found), "of the light")
    assert found == pytest.approx([expected] * 3, rel=0.03 if far > 5e3 else 0.005)


def test_too_far_from_the_origin_is_refused(world):
    with pytest.raises(part("light.probe").AngenError, match="nearer to the origin"):
        lux(request(matrix=facing((0, 0, 1), (2e5, 0, 0))))


# All types of light


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
    """The strength depends on a ray's normal: the lamp shines to one side of the world only."""
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
    """Light reflected by the wall arrives; the sensor's own face is no receiver."""
    light = lamp(world, "POINT", at=(0, 0, 1), energy=10.0)
    wall = plate(world, 8.0, (0, 0, 2), (0, 0, -1), material(0.5))
    plain = lux(request(samples=4096))
    only = bpy.data.collections.new("receivers")
    light.light_linking.receiver_collection = only
    only.objects.link(wall)
    found = lux(request(samples=4096))
    # A large plate over the lamp gives an image of the lamp at twice the distance, Lambertian.
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
    """White above, black below: π looking up, 0 looking down, half of it sideways."""
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
    """Only shadow rays see it: it shades the lamp, and reflects nothing."""
    lamp(world, "POINT", at=(0, 0, 2))
    shade = plate(world, 1.0, (0, 0, 1), (0, 0, -1), material(0.8))
    for rays in ("camera", "diffuse", "glossy", "transmission", "volume_scatter"):
        setattr(shade, f"visible_{rays}", False)
    assert lux(request(samples=64)) == pytest.approx(0.0, abs=1e-6)
    shade.visible_shadow = False
    assert lux(request(samples=64)) == pytest.approx(1 / (4 * math.pi * 4), rel=2e-3)


def instanced(world, thing):
    """Instance, 5 m aside, a collection that is in no scene."""
    source = world.aside("source", thing)
    empty = world.instance("instance", source)
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
    """Blender's module hangs at its end if a Python handler is left after a render."""
    script = RUN.format(root=str(Path(__file__).resolve().parents[2]))
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=60, check=False
    )
    assert "MEASURED" in done.stdout and done.returncode == 0, done.stderr


# Each sensor of light.blend reads its closed form, computed from the file's own objects


SAMPLE = Path(__file__).resolve().parents[2] / "sample_blends" / "light.blend"
# The measured face is this far ahead of its sensor.
AHEAD = 1e-3
NAMES = ("point", "spot", "area", "glowing plate", "ball", "sun and sky")


@pytest.fixture
def sample(addon):
    bpy.ops.wm.open_mainfile(filepath=str(SAMPLE), load_ui=False)
    bpy.context.scene.angen_live = False
    bpy.context.scene.frame_set(49)
    yield bpy.context.scene
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)


def height(name, sensor):
    at = [bpy.data.objects[n].matrix_world.translation for n in (name, f"Light sensor {sensor}")]
    return (at[0] - at[1]).length - AHEAD


def square(side, distance):
    """Return the form factor of a square of this side centred over a small face."""
    a = side / 2 / distance
    return 4 / math.pi * a / math.hypot(1, a) * math.atan(a / math.hypot(1, a))


def point():
    power = bpy.data.objects["Lamp point"].data.energy
    return power / (4 * math.pi * height("Lamp point", "point") ** 2)


def spot():
    power = bpy.data.objects["Lamp spot"].data.energy
    return power / (4 * math.pi * height("Lamp spot", "spot") ** 2)


def area():
    lamp = bpy.data.objects["Lamp area"].data
    return lamp.energy / lamp.size**2 * square(lamp.size, height("Lamp area", "area"))


def glowing_plate():
    glowing_plate = bpy.data.objects["Glowing plate"]
    shader = next(n for n in glowing_plate.active_material.node_tree.nodes if n.type == "EMISSION")
    shining = math.pi * shader.inputs["Strength"].default_value
    return shining * square(glowing_plate.dimensions.x, height("Glowing plate", "glowing plate"))


def in_a_ball():
    """Return the direct light of the lamp and its interreflections, Φ ρ / (A (1 − ρ))."""
    power, reflects = bpy.data.objects["Lamp ball"].data.energy, 0.8
    radius = bpy.data.objects["Ball"].dimensions.z / 2
    straight = power / (4 * math.pi * height("Lamp ball", "ball") ** 2)
    return straight + power * reflects / (4 * math.pi * radius**2 * (1 - reflects))


def under_the_sky():
    sun = bpy.data.objects["Lamp sun"]
    nodes = bpy.context.scene.world.node_tree.nodes
    strength = next(n for n in nodes if n.type == "BACKGROUND").inputs["Strength"].default_value
    return sun.data.energy * sun.matrix_world.col[2].z + math.pi * strength


EXPECTED = dict(
    zip(NAMES, (point, spot, area, glowing_plate, in_a_ball, under_the_sky), strict=True)
)
# Each path samples one of all lamps in the file, so direct light has noise too.
TOLERANCE = {"ball": 0.02}


def asked():
    request = part("light.probe").LightRequest
    return [
        request(
            o.name,
            np.array(o.matrix_world, np.float64),
            "ILLUMINANCE",
            "CYCLES",
            o.angen_sensor.light.samples,
        )
        for o in bpy.context.scene.objects
        if o.angen_sensor.kind == "LIGHT"
    ]


def test_all_six_sensors_read_their_closed_forms(sample):
    found = measure(*asked(), efficacy=683.0)
    assert len(found) == len(NAMES)
    for name, form in EXPECTED.items():
        lux = found[f"Light sensor {name}"].illuminance_lux
        assert lux == pytest.approx(683.0 * form(), rel=TOLERANCE.get(name, 0.01)), name


def test_the_point_lamp_dims_over_time(sample):
    readings = []
    for frame in (1, 25, 49, 73, 97):
        sample.frame_set(frame)
        readings.append(measure(*asked(), efficacy=683.0)["Light sensor point"].illuminance_lux)
    full = readings[2]
    assert readings == pytest.approx([0, full / 2, full, full / 2, 0], rel=1e-4, abs=1e-9)
