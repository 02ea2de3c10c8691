# SPDX-License-Identifier: GPL-3.0-or-later
"""Scene settings that must not change the light sensors' readings, and settings that must.

Each is tested with and without a reference.
"""

import bpy
import pytest
from light_stage import facing, lit_room, material, objects, part, request
from tiers import mostly_slow

FEW, MANY = 16, 64


@pytest.fixture
def room(world):
    lit_room(world)
    world.scene.frame_set(9)
    return world


def read(reference=MANY, layer=None):
    """Return the readings of both methods in a run."""
    scene, layer = bpy.context.scene, layer or bpy.context.view_layer
    layer.update()
    kept = part("light.cycles").CyclesLight(reference)
    asked = [
        request("lux", facing((0, 1, 0), (0.3, -1, 0.2)), samples=FEW),
        request("walls", facing((1, 0, 0), (-0.7, 1, 0)), method="FOUR_WALL", samples=FEW),
    ]
    try:
        return dict(part("light.probe").measure(scene, layer, asked, 1.0, kept))
    finally:
        kept.close()


def simplify(scene, layer):
    scene.render.use_simplify = True
    scene.render.simplify_subdivision = scene.render.simplify_subdivision_render = 0
    scene.render.simplify_child_particles = scene.render.simplify_child_particles_render = 0.0
    scene.cycles.use_camera_cull = scene.cycles.use_distance_cull = True
    scene.cycles.texture_limit = scene.cycles.texture_limit_render = "128"


def border(scene, layer):
    scene.render.use_border = scene.render.use_crop_to_border = True
    scene.render.border_max_x = scene.render.border_max_y = 0.1
    scene.render.resolution_percentage = 1
    scene.render.pixel_aspect_x, scene.render.pixel_aspect_y = 3.0, 1.0


def compositor(scene, layer):
    """Set a compositor that makes everything black."""
    if hasattr(scene, "compositing_node_group"):
        tree = bpy.data.node_groups.new("comp", "CompositorNodeTree")
        tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
        tree.nodes.new("NodeGroupOutput")
        scene.compositing_node_group = tree
    else:
        scene.use_nodes = True
        scene.node_tree.nodes.clear()
        scene.node_tree.nodes.new("CompositorNodeComposite")
    scene.render.use_compositing = True
    strip_editor = scene.sequence_editor_create()
    strips = strip_editor.strips if hasattr(strip_editor, "strips") else strip_editor.sequences
    if bpy.app.version >= (5, 0):
        strips.new_effect("black", "COLOR", channel=1, frame_start=1, length=40)
    else:
        strips.new_effect("black", "COLOR", channel=1, frame_start=1, frame_end=41)
    scene.render.use_sequencer = True


def sampling(scene, layer):
    cycles = scene.cycles
    cycles.use_adaptive_sampling, cycles.adaptive_threshold = True, 0.9
    cycles.use_denoising, cycles.use_fast_gi = True, True
    cycles.use_light_tree, cycles.use_guiding = False, True
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 1e-3
    cycles.light_sampling_threshold, cycles.blur_glossy = 0.9, 5.0
    cycles.samples, cycles.seed, cycles.use_animated_seed = 1, 42, True
    cycles.sample_offset, cycles.time_limit = 5, 1e-3
    cycles.sampling_pattern = "TABULATED_SOBOL"
    cycles.caustics_reflective = cycles.caustics_refractive = False
    cycles.use_auto_tile, cycles.tile_size = True, 8
    cycles.film_exposure, cycles.pixel_filter_type = 3.0, "GAUSSIAN"
    cycles.max_bounces = cycles.diffuse_bounces = cycles.transparent_max_bounces = 0
    cycles.fast_gi_method = "REPLACE"
    cycles.ao_bounces = cycles.ao_bounces_render = 1


def persistent(scene, layer):
    scene.render.use_persistent_data = True
    scene.render.threads_mode, scene.render.threads = "FIXED", 1


def motion_blur(scene, layer):
    scene.render.use_motion_blur = True
    scene.render.motion_blur_shutter = 8.0
    scene.render.film_transparent = True
    scene.cycles.film_transparent_glass = True
    scene.cycles.rolling_shutter_type = "TOP"


def multiview(scene, layer):
    scene.render.use_multiview = True
    scene.render.views_format = "STEREO_3D"


def layer_settings(scene, layer):
    layer.material_override = material(glows=7.0)
    if hasattr(layer, "world_override"):
        layer.world_override = bpy.data.worlds.new("other")
    layer.samples = 1
    layer.use = False
    for name in dir(layer):
        if name.startswith("use_pass_"):
            setattr(layer, name, True)
    layer.use_pass_combined = layer.use_sky = layer.use_solid = False
    layer.cycles.denoising_store_passes = True
    layer.lightgroups.add(name="lamps")
    objects("point").lightgroup = "lamps"
    scene.world.lightgroup = "lamps"


def colour(scene, layer):
    scene.view_settings.exposure, scene.view_settings.gamma = 3.0, 2.0
    scene.view_settings.use_curve_mapping = True
    scene.display_settings.display_device = "sRGB"
    scene.render.dither_intensity = 2.0
    scene.render.use_stamp = True
    scene.render.image_settings.file_format = "PNG"


def freestyle(scene, layer):
    scene.render.use_freestyle = layer.use_freestyle = True
    scene.render.use_single_layer = True


def odd_aspects(scene, layer):
    scene.render.use_overwrite, scene.render.use_placeholder = False, True
    scene.render.use_file_extension = False
    scene.render.filepath = "/nowhere/at/all"
    scene.frame_step = 7


def hair(scene, layer):
    scene.render.hair_type, scene.render.hair_subdiv = "STRIP", 2
    scene.cycles_curves.shape = "THICK"


def camera(scene, layer):
    data = bpy.data.cameras.new("camera")
    data.type, data.clip_start, data.dof.use_dof = "PANO", 3.0, True
    scene.camera = bpy.data.objects.new("camera", data)
    scene.collection.objects.link(scene.camera)
    marker = scene.timeline_markers.new("cut", frame=1)
    marker.camera = scene.camera


HARMLESS = (
    simplify, border, compositor, sampling, persistent, motion_blur, multiview, layer_settings,
    colour, freestyle, odd_aspects, hair, camera,
)  # fmt: skip


@pytest.mark.parametrize("trap", HARMLESS)
@pytest.mark.parametrize("reference", mostly_slow([0, MANY], MANY))
def test_no_render_setting_moves_a_bit(room, trap, reference):
    before = read(reference)
    trap(room.scene, bpy.context.view_layer)
    assert read(reference) == before


def test_time_that_is_stretched_is_the_users(room):
    """Frame 30 of a film stretched to three times its length is its frame 10."""
    data = objects("point").data
    for frame in (1, 48):
        data.energy = float(frame)
        data.keyframe_insert("energy", frame=frame)
    room.scene.frame_set(10)
    before = [read(0), read()]
    room.scene.frame_set(30)
    assert [read(0), read()] != before
    room.scene.render.frame_map_old, room.scene.render.frame_map_new = 100, 300
    room.scene.frame_set(30)
    assert [read(0), read()] == before


def attribute(tree, kind, name, into):
    node = tree.nodes.new("ShaderNodeAttribute")
    node.attribute_type, node.attribute_name = kind, name
    shader = next(n for n in tree.nodes if n.type == "EMISSION")
    out = "Color" if into == "Color" else "Fac"
    tree.links.new(node.outputs[out], shader.inputs[into])


def key(owner, name, values, path=None):
    for frame, value in zip((1, 20), values, strict=True):
        if path is None:
            setattr(owner, name, value)
        else:
            owner[name] = value
        owner.keyframe_insert(path or name, frame=frame)


def screen_tree():
    return bpy.data.materials["screen"].node_tree


def layer_property():
    layer, scene = bpy.context.view_layer, bpy.context.scene
    for frame, value in ((1, 0.0), (20, 9.0)):
        layer["glow"] = value
        scene.keyframe_insert(f'view_layers["{layer.name}"]["glow"]', frame=frame)
    attribute(screen_tree(), "VIEW_LAYER", "glow", "Strength")


def lamp_bounces():
    key(objects("point").data.cycles, "max_bounces", (0, 9))


def glow_of(owner, kind="OBJECT", tree=screen_tree, into="Strength"):
    """Make a glow that depends on a keyed property."""

    def change():
        key(owner(), "glow", (0.0, 9.0), '["glow"]')
        attribute(tree(), kind, "glow", into)

    return change


def lamp_tree():
    data = objects("point").data
    if not data.node_tree:
        data.use_nodes = True
    return data.node_tree


LOOKED_AT = {
    "scene": glow_of(lambda: bpy.context.scene, "VIEW_LAYER"),
    "world": glow_of(lambda: bpy.context.scene.world, "VIEW_LAYER"),
    "object": glow_of(lambda: objects("screen")),
    "mesh": glow_of(lambda: objects("screen").data),
    "view layer": layer_property,
    "a lamp's bounces": lamp_bounces,
}
if bpy.app.version >= (4, 5):
    # Blender 4.2 gives lamps no properties.
    LOOKED_AT["lamp"] = glow_of(lambda: objects("point").data, tree=lamp_tree)


@pytest.mark.parametrize("change", LOOKED_AT.values(), ids=LOOKED_AT)
@pytest.mark.parametrize("reference", mostly_slow([0, 128], 128))
def test_what_nodes_look_at_is_followed_in_runs(room, change, reference):
    """A run reads the same as a measurement without knowledge of the frames before."""
    objects("screen").animation_data_clear()
    change()
    room.scene.angen_light_reference = reference
    settings = {"method": "ILLUMINANCE", "engine": "CYCLES", "samples": 64, "update_rate": 24.0}
    room.sensor("LIGHT", "meter", **settings).location = (0.3, -1, 0.2)
    run = room.series(room.run(1, 9), "meter", "illuminance_lux")
    alone = room.series(room.run(9, 9), "meter", "illuminance_lux")
    assert len(set(run)) > 3
    assert run[-1] == alone[0]


@pytest.mark.parametrize("reference", [0, MANY])
def test_each_view_layer_has_its_own_light(room, reference):
    scene, first = room.scene, bpy.context.view_layer
    inside = bpy.data.collections.new("inside")
    scene.collection.children.link(inside)
    scene.collection.objects.unlink(objects("point"))
    inside.objects.link(objects("point"))
    lit = read(reference)
    second = scene.view_layers.new("second")
    second.layer_collection.children["inside"].exclude = True
    assert read(reference) == lit
    dark = read(reference, second)
    first.layer_collection.children["inside"].exclude = True
    assert read(reference) == dark != lit
    first.layer_collection.children["inside"].exclude = False
    # A run in a view layer that the window does not show; Blender 4.5 crashed.
    settings = {"method": "ILLUMINANCE", "engine": "CYCLES", "samples": 16, "update_rate": 24.0}
    room.sensor("LIGHT", "meter", **settings).location = (0.3, -1, 0.2)
    room.scene.angen_light_reference = reference
    runs = []
    for layer in (first, second):
        with bpy.context.temp_override(view_layer=layer):
            runs.append(room.series(room.run(1, 2), "meter", "illuminance_lux"))
    assert runs[0] != runs[1]
