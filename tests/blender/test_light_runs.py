# SPDX-License-Identifier: GPL-3.0-or-later
"""Light sensors in runs and during scrubbing; and the sample of the light control."""

import math
from importlib import import_module
from pathlib import Path

import bpy
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.runtime import handlers, probes
from bl_ext.user_default.angen_sensors.angen_addon.runtime.live import known_live
from bl_ext.user_default.angen_sensors.angen_addon.runtime.running import is_running
from bl_ext.user_default.angen_sensors.angen_addon.scene import memory
from bl_ext.user_default.angen_sensors.angen_addon.scene.light import probe
from bl_ext.user_default.angen_sensors.angen_addon.view import readings
from bl_ext.user_default.angen_sensors.angen_addon.view.overlay import labels
from bl_ext.user_default.angen_sensors.sensor_logic.logs.error import AngenError
from bl_ext.user_default.angen_sensors.sensor_logic.progress import Enough
from light_stage import material, plate
from tiers import mostly_slow


@pytest.fixture
def lamp(world):
    """Add a face that looks up, 2 m below a point lamp of 100 W that goes off at frame 13."""
    data = bpy.data.lights.new("lamp", "POINT")
    data.energy = 100.0
    data.shadow_soft_size = 0.0
    data.keyframe_insert("energy", frame=12)
    data.energy = 0.0
    data.keyframe_insert("energy", frame=13)
    world.link("lamp", data, (0, 0, 2))
    world.scene.frame_end = 24
    face = world.sensor("LIGHT", "lux", update_rate=24.0)
    face.rotation_euler = (math.pi, 0, 0)
    face.angen_sensor.light.method = "ILLUMINANCE"
    face.angen_sensor.light.samples = 16
    face.angen_sensor.light.output = "DIGITAL"
    face.angen_sensor.light.integration_time = 0.0
    face.angen_sensor.light.lux_step = 0.0
    face.angen_sensor.light.threshold = 100.0
    return face


def counted(monkeypatch):
    calls = []
    measure = probe.measuring

    def spy(*arguments):
        calls.append(arguments)
        return measure(*arguments)

    monkeypatch.setattr(probes, "measuring", spy)
    return calls


def test_a_lamp_is_followed_and_a_still_scene_rendered_once(world, lamp, monkeypatch):
    calls = counted(monkeypatch)
    recording = world.run()
    lux = world.series(recording, "lux", "illuminance_lux")
    lit = world.series(recording, "lux", "lit")
    assert lit == [1] * 12 + [0] * 12
    # The measured face is 1 mm ahead of the sensor, off the wall that the sensor may be on.
    assert lux[0] == pytest.approx(683.0 * 100.0 / (4 * math.pi * 1.999**2), rel=1e-3)
    assert lux[:12] == [lux[0]] * 12 and lux[12:] == [0.0] * 12
    assert len(calls) == 2, "once with the lamp on, once with it off"


def film(folder, name, brightness):
    """Write a sequence of images, each of one brightness."""
    for frame, value in enumerate(brightness, 1):
        image = bpy.data.images.new("one", 2, 2, float_buffer=True)
        image.colorspace_settings.name = "Non-Color"
        image.pixels = [value, value, value, 1.0] * 4
        image.filepath_raw = str(folder / f"{name}{frame:04}.exr")
        image.file_format = "OPEN_EXR"
        image.save()
        bpy.data.images.remove(image)
    found = bpy.data.images.load(str(folder / f"{name}0001.exr"))
    found.source, found.colorspace_settings.name = "SEQUENCE", "Non-Color"
    return found


@pytest.mark.parametrize("reference", mostly_slow([0, 64], 64))
@pytest.mark.parametrize(
    ("grouped", "refreshed"),
    mostly_slow([(False, False), (False, True), (True, False)], (False, False), (True, False)),
)
def test_a_film_on_a_screen_is_followed(world, lamp, tmp_path, grouped, refreshed, reference):
    """Blender's list of updates lacks it. `grouped`: its node is in a node group."""
    bpy.data.objects.remove(bpy.data.objects["lamp"])
    world.scene.angen_light_reference = reference
    glow = material(glows=1.0)
    tree = glow.node_tree
    of = tree
    if grouped:
        of = bpy.data.node_groups.new("television", "ShaderNodeTree")
        of.interface.new_socket("colour", in_out="OUTPUT", socket_type="NodeSocketColor")
        shown = tree.nodes.new("ShaderNodeGroup")
        shown.node_tree = of
    picture = of.nodes.new("ShaderNodeTexImage")
    picture.image, picture.image_user.frame_duration = film(tmp_path, "film", (0.1, 0.5, 0.2)), 3
    picture.image_user.use_auto_refresh = refreshed
    # The compositor's image node has its own frame settings.
    compositing = bpy.data.node_groups.new("compositing", "CompositorNodeTree")
    compositing.nodes.new("CompositorNodeImage").image = picture.image
    if grouped:
        of.links.new(picture.outputs[0], of.nodes.new("NodeGroupOutput").inputs[0])
        picture = shown
    emission = next(n for n in tree.nodes if n.type == "EMISSION")
    tree.links.new(picture.outputs[0], emission.inputs[0])
    plate(world, 1.0, (0, 0, 1), (0, 0, -1), glow, "screen")
    lux = world.series(world.run(), "lux", "illuminance_lux")
    assert lux[:3] == pytest.approx([lux[0], 5 * lux[0], 2 * lux[0]], rel=1e-3)
    assert lux[0] > 10.0


def told(world):
    (sensor,) = world.sensors()
    return readings.reading_text(sensor, world.scene)


def test_scrubbing_shows_what_was_measured_and_how_old_it_is(world, lamp, monkeypatch):
    """The frame handler renders and estimates nothing.

    Panels and drivers read the last measurement, which was made with the playhead at rest, as in a
    run.
    """
    recorded = world.series(world.run(), "lux", "illuminance_lux")
    memory.forget_file()
    calls = counted(monkeypatch)
    world.scene.angen_live = True
    world.update()
    world.scene.frame_set(5)
    waiting = told(world)
    assert (waiting.text, waiting.short) == ("Measured at rest", "at rest")
    assert "when the playhead stops" in waiting.old
    label = labels._texts(bpy.context, "lux", waiting, False)
    assert label == ("lux", "at rest"), "it says why it has no value"
    assert not lamp.angen_sensor.active and not calls
    following = known_live()
    assert following.has_waiting_light
    following.measure_waiting(world.scene, bpy.context.view_layer)
    assert len(calls) == 1 and not following.has_waiting_light
    assert lamp.angen_sensor.value == pytest.approx(recorded[4], rel=1e-6)
    assert lamp.angen_sensor.active
    assert not following.outdated, "showing a value is no edit"
    measured = told(world)
    assert (measured.icon, measured.old) == (readings.ACTIVE, "")
    world.scene.frame_set(24)
    old = told(world)
    assert old.text == f"{measured.text}, 0.8 s ago" and old.icon == readings.OLD
    assert "when the playhead stops" in old.old
    assert lamp.angen_sensor.active, "what was measured last"
    world.scene.frame_set(2)
    assert told(world).text == f"{measured.text}, at frame 5"
    world.scene.frame_set(20)
    following.measure_waiting(world.scene, bpy.context.view_layer)
    assert lamp.angen_sensor.value == 0.0 and not lamp.angen_sensor.active
    assert told(world).icon == readings.IDLE


def test_at_rest_as_many_paths_are_traced_as_a_reference_has(world, lamp):
    """Few paths without a reference would read light where a run reads dark."""
    room = world.box((6, 6, 5), name="room")
    room.data.materials.append(bpy.data.materials.new("paint"))
    world.box((1, 1, 0.05), at=(0, 0, 1.5), name="shade")
    light = lamp.angen_sensor.light
    light.samples = 1024
    exact = world.series(world.run(1, 1), "lux", "illuminance_lux")[0]
    light.samples = 4
    few = world.series(world.run(1, 1), "lux", "illuminance_lux")[0]
    assert few != pytest.approx(exact, rel=0.01)
    world.scene.angen_light_reference = 1024
    memory.forget_file()
    world.scene.angen_live = True
    world.scene.frame_set(1)
    known_live().measure_waiting(world.scene, bpy.context.view_layer)
    assert lamp.angen_sensor.value == pytest.approx(exact, rel=1e-6)


def test_at_rest_the_selected_sensor_comes_first(world, lamp):
    world.sensor("LIGHT", "a", engine="CYCLES", samples=16)
    bpy.ops.object.select_all(action="DESELECT")
    lamp.select_set(True)
    world.scene.angen_live = True
    world.update()
    world.scene.frame_set(5)
    known_live().measure_waiting(world.scene, bpy.context.view_layer, at_most=1)
    texts = {s.name: readings.reading_text(s, world.scene).text for s in world.sensors()}
    assert texts["lux"].startswith("Lit") and texts["a"] == "Measured at rest"
    known_live().measure_waiting(world.scene, bpy.context.view_layer, at_most=1)
    assert not known_live().has_waiting_light
    assert all(readings.reading_text(s, world.scene).old == "" for s in world.sensors())


def test_measure_now_measures_at_this_frame_after_an_edit(world, lamp):
    """Otherwise light waits after an edit until the playhead has moved and rests."""
    world.scene.angen_live = True
    bpy.context.view_layer.objects.active = lamp
    world.scene.frame_set(5)
    assert bpy.ops.angen.measure_light() == {"FINISHED"}
    first = told(world).fields["illuminance_lux"]
    assert first > 0.0 and told(world).old == ""
    bpy.data.objects["lamp"].location.z = 1.0
    world.update()
    known_live().catch_up(world.scene, bpy.context.view_layer)
    assert "Measure Now" in told(world).old and not known_live().has_waiting_light
    assert bpy.ops.angen.measure_light() == {"FINISHED"}
    assert told(world).old == "" and told(world).fields["illuminance_lux"] > 1.5 * first
    assert bpy.ops.angen.measure_light() == {"FINISHED"}, "again, though nothing has changed"
    assert not is_running()


def test_measure_now_by_esc_leaves_the_reading_of_before(world, lamp):
    world.scene.angen_live = True
    bpy.context.view_layer.objects.active = lamp
    world.update()
    world.scene.frame_set(5)
    live = known_live()
    run = live.measure_now(world.scene, bpy.context.view_layer, world.sensors())
    doing = next(run)
    assert doing.text.startswith("lux, ") and doing.slow
    with pytest.raises(Enough):
        run.throw(Enough)
    assert live.why_old(world.scene) == ""
    assert told(world).text == "Measured at rest" and live.has_waiting_light and not is_running()
    assert len(bpy.data.scenes) == 1


def test_measure_now_says_why_it_cannot(world, lamp):
    bpy.context.view_layer.objects.active = None
    with pytest.raises(RuntimeError, match="Select a light sensor"):
        bpy.ops.angen.measure_light()
    bpy.context.view_layer.objects.active = lamp
    world.scene.angen_live = False
    with pytest.raises(RuntimeError, match="Live is off"):
        bpy.ops.angen.measure_light()
    world.scene.angen_live = True
    bpy.ops.angen.simulate()
    with pytest.raises(RuntimeError, match="is recorded"):
        bpy.ops.angen.measure_light()


def test_what_was_pending_does_not_overwrite_a_recording(world, lamp, monkeypatch):
    """Simulate starts before the light of the frame at the playhead was measured."""
    world.scene.angen_live = True
    world.update()
    world.scene.frame_set(5)
    assert known_live().has_waiting_light
    bpy.ops.angen.simulate()
    recorded = lamp.angen_sensor.value
    before = told(world)
    assert before.recorded and before.fields["illuminance_lux"] == pytest.approx(recorded)
    calls = counted(monkeypatch)
    handlers._shown_at = 0.0
    assert handlers._sense_at_rest() is None and not calls
    assert (told(world).text, told(world).recorded) == (before.text, True)
    assert lamp.angen_sensor.value == recorded


def test_what_cannot_be_measured_is_told(world, lamp):
    lamp.location = (2e5, 0, 0)
    world.update()
    with pytest.raises(AngenError, match="lux"):
        world.run()


# The sample of the light control


ADDON = "bl_ext.user_default.angen_sensors"
SAMPLE = Path(__file__).resolve().parents[2] / "sample_blends" / "light_control.blend"
LAST = 330
# The person of the story comes in, and stands still for longer than the hold time.
ON, OFF = 141, 285


@pytest.fixture
def room(addon):
    bpy.ops.wm.open_mainfile(filepath=str(SAMPLE))
    sensor = bpy.data.objects["Light sensor room"].angen_sensor
    sensor.light.engine, sensor.light.samples = "CYCLES", 16
    bpy.context.scene.frame_end = LAST
    return bpy.context.scene


def energy(frame):
    bpy.context.scene.frame_set(frame)
    lamp = bpy.data.lights["Lamp"]
    return lamp.evaluated_get(bpy.context.evaluated_depsgraph_get()).energy


def changes(name, field):
    results = import_module(f"{ADDON}.angen_addon.recording.results")
    track = results.RESULTS.recording(bpy.context.scene).tracks[name]
    column = list(track.columns[field])
    return [
        (int(track.frames[i]), bool(value))
        for i, value in enumerate(column)
        if i == 0 or value != column[i - 1]
    ]


def test_the_detector_switches_the_lamp_and_the_light_sensor_sees_it(room, tmp_path):
    assert bpy.ops.angen.simulate() == {"FINISHED"}
    assert changes("PIR room", "moved") == [(1, False), (ON, True), (OFF, False)]
    # The sensor measures twice a second; a driver shows a reading from the next frame on.
    assert changes("Light sensor room", "lit") == [(1, False), (145, True), (289, False)]
    lit = {ON + 20: 20.0, OFF + 20: 0.0, ON - 1: 0.0, OFF - 2: 20.0}
    assert {frame: energy(frame) for frame in lit} == pytest.approx(lit)
    path = str(tmp_path / "recorded.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    assert {frame: energy(frame) for frame in lit} == pytest.approx(lit)
    assert bpy.ops.angen.bake_keyframes() == {"FINISHED"}
    bpy.ops.angen.clear_recording()
    bpy.context.scene.angen_live = False
    assert {frame: energy(frame) for frame in lit} == pytest.approx(lit)
