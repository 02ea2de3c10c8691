# SPDX-License-Identifier: GPL-3.0-or-later
"""What the rays of radars hit: through thin walls, with the motion of surfaces, and breathing."""

import math

import bpy
import numpy as np
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.runtime.probes import Probes
from bl_ext.user_default.angen_sensors.sensor_logic.radio.echoes import ECHOES
from bl_ext.user_default.angen_sensors.sensor_logic.radio.substances import (
    attenuation,
    reflectance,
)
from mathutils import Vector

AHEAD = np.array([[0.0, 0.0, -1.0]])
GHZ = 24.125


class Radar:
    """Casts rays from the origin with one set of probes, as a run does frame by frame."""

    def __init__(self, scene):
        self.scene, self.probes, self.past = scene, Probes(scene), []

    def look(self, directions=AHEAD, length=20.0, frequency=GHZ, frame=None, steps=1):
        if frame is not None:
            self.scene.frame_set(frame)
        depsgraph = bpy.context.evaluated_depsgraph_get()
        self.probes.look(depsgraph)
        directions = np.asarray(directions, np.float64)
        units = 1.0 / self.scene.unit_settings.scale_length
        rays = np.zeros_like(directions), directions, np.full(len(directions), length * units)
        time = (self.scene.frame_current - 1) / self.scene.render.fps
        self.past = [one for one in self.past if one[0] < time][-steps:]
        self.past.append((time, self.probes.places.at(0)))
        probe = self.probes.surfaces[ECHOES]
        return probe.see(-1, 0, rays, None, frequency, 0.1, [self.past])[0]


@pytest.fixture
def radar(world):
    world.update()
    return Radar(world.scene)


def wall(world, distance, substance=None, thickness=0.0, name="Wall"):
    made = world.box((6, 6, 0.1), at=(0, 0, -distance - 0.05), name=name)
    if substance:
        made.angen_radar.substance, made.angen_radar.thickness = substance, thickness
    return made


def test_a_wall_of_nothing_known_stops_the_waves(world, radar):
    world.box((1, 1, 1), at=(0, 0, -5), name="Behind")
    wall(world, 2.0)
    seen = radar.look()
    assert seen.ranges == pytest.approx([2.0]) and seen.loss == pytest.approx([0.0])
    assert seen.reflectance == pytest.approx([reflectance("CONCRETE", GHZ)])
    assert not seen.through


@pytest.mark.parametrize("frequency", [24.125, 60.0])
def test_thin_walls_let_the_waves_through_at_a_loss(world, radar, frequency):
    world.box((1, 1, 1), at=(0, 0, -5.5), name="Behind")
    wall(world, 2.0, "PLASTERBOARD", 0.025)
    wall(world, 3.0, "GLASS", name="Pane")
    seen = radar.look(frequency=frequency)
    assert seen.ranges == pytest.approx([5.0])
    lost = attenuation("PLASTERBOARD", 0.025, frequency) + attenuation("GLASS", 0.008, frequency)
    assert seen.loss == pytest.approx([lost], rel=1e-6)
    assert seen.through == {0: ("Wall", "Pane")}


def test_a_pane_within_a_wall_and_many_panes_count_once_each(world, radar):
    world.box((1, 1, 1), at=(0, 0, -9.5), name="Behind")
    wall(world, 2.0, "PLASTERBOARD", 0.025)
    pane = world.box((2, 2, 0.02), at=(0, 0, -2.05), name="Pane")
    pane.angen_radar.substance = "GLASS"
    once = attenuation("PLASTERBOARD", 0.025, GHZ) + attenuation("GLASS", 0.008, GHZ)
    assert radar.look().loss == pytest.approx([once], rel=1e-6)
    for number in range(9):
        wall(world, 3.0 + number * 0.5, "GLASS", name=f"Pane {number}")
    world.update()
    seen = radar.look()
    assert seen.loss == pytest.approx([once + 9 * attenuation("GLASS", 0.008, GHZ)], rel=1e-6)
    assert seen.through[0][:2] == ("Wall", "Pane")


def test_breathing_and_substances_can_be_animated(world, radar):
    body = world.box((1, 1, 1), at=(0, 0, -5.5), name="Body")
    pane = wall(world, 2.0, "GLASS", name="Pane")
    body.angen_breathing.breathes = "YES"
    world.key(body, "angen_breathing.displacement", {1: 0.004, 11: 0.006}, "LINEAR")
    world.key(pane, "angen_radar.thickness", {1: 0.004, 2: 0.008}, "CONSTANT")
    first, later = radar.look(frame=1), radar.look(frame=6)
    assert first.breathing == pytest.approx([0.004]) and later.breathing == pytest.approx([0.005])
    assert first.loss == pytest.approx([attenuation("GLASS", 0.004, GHZ)], rel=1e-4)
    assert later.loss == pytest.approx([attenuation("GLASS", 0.008, GHZ)], rel=1e-4)


def test_a_material_counts_where_its_object_says_nothing_and_the_worst_of_several(world, radar):
    world.box((1, 1, 1), at=(0, 0, -5.5), name="Behind")
    made = wall(world, 2.0)
    board, steel = (bpy.data.materials.new(name) for name in ("Board", "Steel"))
    board.angen_radar.substance, steel.angen_radar.substance = "PLASTERBOARD", "METAL"
    made.data.materials.append(board)
    world.update()
    assert radar.look().ranges == pytest.approx([5.0])
    made.data.materials.append(steel)
    world.update()
    assert radar.look().ranges == pytest.approx([2.0])
    made.angen_radar.substance = "WOOD"
    world.update()
    assert radar.look().ranges == pytest.approx([5.0]), "the object's own substance comes first"


@pytest.mark.parametrize("scale", [1.0, 0.01])
def test_the_motion_of_what_a_ray_hits_along_the_ray(world, radar, scale):
    world.scene.unit_settings.scale_length = scale
    body = world.box((1 / scale, 1 / scale, 1 / scale), at=(0, 0, 0), name="Body")
    places = {1: (0, 0, -4.5 / scale), 11: (0.3 / scale, 0, -4.0 / scale)}
    world.key(body, "location", places, "LINEAR")
    first = radar.look(frame=1)
    assert not first.speed.any() and first.ranges == pytest.approx([4.0])
    fps = world.scene.render.fps
    assert radar.look(frame=2).speed[-1] / fps == pytest.approx([-0.05], rel=1e-4), "nearer"
    aside = np.array([[math.sin(0.1), 0.0, -math.cos(0.1)]])
    step = np.array([0.03, 0.0, 0.05]) * fps
    assert radar.look(aside, frame=3).speed[0] == pytest.approx(step @ aside.T, rel=1e-4)
    seen = radar.look(aside, frame=5, steps=3)
    assert seen.speed[:, 0] == pytest.approx([step @ aside[0]] * 2, rel=1e-4), "over both parts"


def test_a_turning_body_moves_as_its_points_do(world, radar):
    plate = world.box((2, 2, 0.02), at=(0, 0, -4.0), name="Plate")
    world.key(plate, "rotation_euler", {1: (0, 0, 0), 11: (0, 0.1, 0)}, "LINEAR")
    aside = np.array([[0.2, 0.0, -1.0]]) / math.hypot(0.2, 1.0)
    radar.look(aside, frame=1)
    seen = radar.look(aside, frame=2)
    point = aside[0] * seen.ranges[0] - (0, 0, -4.0)
    angle = 0.01
    before = np.array(
        [
            point[0] * math.cos(angle) - point[2] * math.sin(angle),
            point[1],
            point[0] * math.sin(angle) + point[2] * math.cos(angle),
        ]
    )
    moved = seen.speed / world.scene.render.fps
    assert moved == pytest.approx(np.array([(point - before) @ aside.T]), rel=0.01)


def test_a_mesh_that_changes_shape_moves_by_its_faces(world, radar):
    body = world.box((1, 1, 1), at=(0, 0, -4.5), name="Body")
    body.shape_key_add(name="Basis")
    key = body.shape_key_add(name="Nearer", from_mix=False)
    for point, base in zip(key.data, body.data.vertices, strict=True):
        point.co = base.co + Vector((0, 0, 0.4))
    keys = body.data.shape_keys
    for frame, value in ((1, 0.0), (11, 1.0)):
        key.value = value
        keys.keyframe_insert('key_blocks["Nearer"].value', frame=frame)
    radar.look(frame=1)
    before, seen = radar.look(frame=2), radar.look(frame=3)
    nearer = before.ranges[0] - seen.ranges[0]
    assert nearer > 0.01
    assert seen.speed[-1] / world.scene.render.fps == pytest.approx([-nearer], rel=1e-4)


def test_cloth_is_what_bends_as_cloth_or_is_thin_and_named_so(world, radar):
    def made_of(name, size=(2, 2, 0.1), materials=(), cloth=False):
        sheet = world.box(size, (0, 0, -2), name)
        for material in materials:
            sheet.data.materials.append(bpy.data.materials.new(material))
        if cloth:
            sheet.modifiers.new("Cloth", "CLOTH")
        world.update()
        passed = bool(radar.look().through)
        bpy.data.objects.remove(sheet)
        return passed

    world.box((1, 1, 1), at=(0, 0, -5.5), name="Behind")
    world.update()
    assert made_of("Curtain left") and made_of("Duvet", materials=["Red"])
    assert made_of("Thing", materials=["Linen white", "fabric.001"])
    assert made_of("Sheet", cloth=True)
    assert not made_of("Sheet") and not made_of("Thing", materials=["linen", "oak"])
    assert not made_of("Sofa", (2, 2, 0.7), materials=["fabric grey"]), "not thin"
    assert not made_of("Curtain rail")
    body = world.box((2, 2, 0.1), (0, 0, -2), "Cloth body")
    body.angen_load.mass = 60.0
    body.modifiers.new("Rig", "ARMATURE").object = world.link("Rig", bpy.data.armatures.new("Rig"))
    world.update()
    assert radar.look().ranges == pytest.approx([1.95]), "a body first"


def test_bodies_breathe_if_they_are_rigged_and_have_a_mass_or_say_so(world, radar):
    body = world.box((1, 1, 1), at=(0, 0, -4.5), name="Body")
    body.angen_load.mass = 70.0
    world.update()
    assert radar.look().breathing == pytest.approx([0.0]), "a cushion can have a mass too"
    body.modifiers.new("Rig", "ARMATURE").object = world.link("Rig", bpy.data.armatures.new("Rig"))
    world.update()
    seen = radar.look()
    assert seen.breathing == pytest.approx([0.005]) and seen.rate == pytest.approx([0.25])
    assert seen.reflectance == pytest.approx([reflectance("BODY", GHZ)])
    body.angen_breathing.breathes = "NO"
    world.update()
    assert radar.look().breathing == pytest.approx([0.0])
    body.angen_load.mass = 0.0
    body.angen_breathing.breathes, body.angen_breathing.displacement = "YES", 0.008
    world.update()
    assert radar.look().breathing == pytest.approx([0.008])


def test_a_body_bent_by_an_armature_with_a_mass_breathes(world, radar):
    body = world.box((1, 1, 1), at=(0, 0, -4.5), name="Body")
    rig = world.link("Rig", bpy.data.armatures.new("Rig"))
    rig.angen_load.mass = 60.0
    body.modifiers.new("Rig", "ARMATURE").object = rig
    world.update()
    assert radar.look().breathing == pytest.approx([0.005])


def test_a_door_that_opens_lets_more_through(world, radar):
    """A moving pane is followed at each frame, and hides nothing once it is aside."""
    world.box((1, 1, 1), at=(0, 0, -5.5), name="Behind")
    door = wall(world, 2.0, "WOOD", name="Door")
    door.scale = (0.3, 0.3, 1.0)
    world.key(door, "location", {1: (0, 0, -2.05), 2: (5, 0, -2.05)}, "CONSTANT")
    closed, opened = radar.look(frame=1), radar.look(frame=2)
    assert closed.through == {0: ("Door",)} and not opened.through
    assert closed.loss[0] > 0.0 and opened.loss == pytest.approx([0.0])
