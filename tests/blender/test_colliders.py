# SPDX-License-Identifier: GPL-3.0-or-later
"""Our shapes are where the engine's are: bodies at rest on a floor have no gap but the margin."""

import math

import numpy as np
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.scene.contact.colliders import (
    rigid_body_collider,
)
from bl_ext.user_default.angen_sensors.angen_addon.scene.contact.frame_state import _rigid

SHAPES = ["BOX", "SPHERE", "CAPSULE", "CYLINDER", "CONE", "CONVEX_HULL", "MESH"]
MARGIN = {"CONE": 0.04, "MESH": 0.04}
GAP = 0.001
EVEN, TALL, FLAT = (1.6, 1.6, 1.6), (0.6, 0.6, 2.0), (1.4, 0.8, 0.5)
TILTED = (0.0, math.pi / 2, 0.0)


def shaped(physics, shape, at):
    """A body of a shape with a mesh that is not symmetric where the engine takes it as it is."""
    if shape in ("CONVEX_HULL", "MESH"):
        obj = physics.solid("body", (), at, parts=[((0.15, 0.1, 0.1), (0, 0, 0))])
        for vertex in obj.data.vertices:
            if vertex.co.z > 0:
                vertex.co.x *= 0.7
    elif shape == "BOX":
        obj = physics.solid("body", (0.15, 0.1, 0.08), at)
    else:
        radius = 0.06 if shape == "CAPSULE" else 0.1
        obj = physics.round(shape, at, radius, 0.14)
    return obj


def lowest(physics, obj):
    """How high the lowest point of the collider is above the floor, where the body is now."""
    depsgraph = physics.bpy.context.evaluated_depsgraph_get()
    evaluated = obj.evaluated_get(depsgraph)
    matrix = np.array(evaluated.matrix_world)[None]
    poses, scales = _rigid(matrix, 1.0)
    collider = rigid_body_collider(depsgraph, evaluated, scales[0], 1.0)
    everywhere = np.full(3, 1e9)
    placed = collider.placed(poses[0], -everywhere, everywhere)
    assert placed
    return min(float(shape.lo[2]) for shape in placed), collider.margin


def settle(physics, obj, frames=50):
    physics.frames(frames)
    obj.rigid_body.angular_damping = 0.9
    obj.rigid_body.linear_damping = 0.3
    physics.scene.angen_live = False
    for frame in range(1, frames + 1):
        physics.scene.frame_set(frame)


@pytest.mark.parametrize("mirrored", [False, True], ids=["", "mirrored"])
@pytest.mark.parametrize("scale", [(1, 1, 1), EVEN, TALL, FLAT], ids=["1", "even", "tall", "flat"])
@pytest.mark.parametrize("shape", SHAPES)
def test_no_gap_at_rest(physics, shape, scale, mirrored):
    """Standing on its foot; of a body that falls over, wherever it comes to rest."""
    scale = (-scale[0], *scale[1:]) if mirrored else scale
    physics.floor()
    obj = shaped(physics, shape, (0, 0, 0.5))
    obj.scale = scale
    physics.rigid_body(obj, shape=shape, mass=2.0, friction=0.8)
    physics.world.update()
    height, margin = lowest(physics, obj)
    obj.location.z -= height - margin
    settle(physics, obj, 30)
    height, margin = lowest(physics, obj)
    assert margin == pytest.approx(MARGIN.get(shape, 0.0))
    # An active mesh trembles in the engine's soft margin.
    assert height == pytest.approx(margin, abs=0.006 if shape == "MESH" else GAP)


@pytest.mark.parametrize("margin", [0.01, 0.1])
@pytest.mark.parametrize("scale", [1.0, 1.6])
@pytest.mark.parametrize("shape", ["BOX", "SPHERE", "CAPSULE", "CYLINDER", "CONVEX_HULL"])
def test_a_margin_of_its_own(physics, shape, scale, margin):
    """Of these only hulls stand off by it; where they do, the margin is told or in the shape."""
    physics.floor()
    obj = shaped(physics, shape, (0, 0, 0.5))
    obj.scale = (scale, scale, scale)
    physics.rigid_body(obj, shape=shape, mass=2.0, friction=0.8)
    obj.rigid_body.use_margin, obj.rigid_body.collision_margin = True, margin
    physics.world.update()
    obj.location.z -= lowest(physics, obj)[0] - margin
    settle(physics, obj, 30)
    height, told = lowest(physics, obj)
    assert height == pytest.approx(told, abs=GAP)


@pytest.mark.parametrize("shape", ["BOX", "CAPSULE", "CYLINDER", "CONVEX_HULL"])
def test_no_gap_lying_on_the_side(physics, shape):
    """Radius and length, not the height alone."""
    physics.floor()
    obj = shaped(physics, shape, (0, 0, 0.5))
    obj.rotation_euler = TILTED
    physics.rigid_body(obj, shape=shape, mass=2.0, friction=0.8)
    physics.world.update()
    obj.location.z -= lowest(physics, obj)[0] - 0.002
    settle(physics, obj, 40)
    assert lowest(physics, obj)[0] == pytest.approx(0.0, abs=GAP)


@pytest.mark.parametrize("mirrored", [False, True], ids=["", "mirrored"])
@pytest.mark.parametrize("scale", [1.0, 1.7])
@pytest.mark.parametrize("shape", ["BOX", "SPHERE", "CYLINDER", "CONVEX_HULL"])
def test_compounds(physics, shape, scale, mirrored):
    """Four feet of a shape, turned and scaled of their own, which the engine leaves out."""
    physics.floor()
    obj = physics.solid("top", (0.3, 0.3, 0.02), (0, 0, 1))
    obj.scale = (-scale if mirrored else scale, scale, scale)
    physics.rigid_body(obj, shape="COMPOUND", mass=2.0, friction=0.8)
    for x in (-0.25, 0.25):
        for y in (-0.25, 0.25):
            foot = shaped(physics, shape, (0, 0, 0))
            foot.parent, foot.location = obj, (x, y, -0.1)
            foot.rotation_euler, foot.scale = (0, 0, 0.4), (1.2, 0.9, 0.8)
            physics.rigid_body(foot, shape=shape)
    physics.world.update()
    obj.location.z -= lowest(physics, obj)[0]
    settle(physics, obj, 20)
    assert lowest(physics, obj)[0] == pytest.approx(0.0, abs=GAP)
    top = np.array(obj.evaluated_get(physics.world.update()).matrix_world)[2, 2] / scale
    assert abs(top) == pytest.approx(1.0, abs=0.01), "it stands"


@pytest.mark.parametrize("source", ["BASE", "FINAL"])
def test_the_mesh_that_the_engine_takes(physics, source):
    """Mesh bodies before or after modifiers: a passive floor that a modifier thickens."""
    floor = physics.solid("floor", (2, 2, 0.05), (0, 0, -0.05))
    modifier = floor.modifiers.new("displace", "DISPLACE")
    modifier.direction, modifier.mid_level, modifier.strength = "Z", 0.0, 0.1
    physics.rigid_body(floor, "PASSIVE", shape="MESH")
    floor.rigid_body.mesh_source = source
    height = 0.1 if source == "FINAL" else 0.0
    box = physics.body("box", (0.1, 0.1, 0.1), (0, 0, height + 0.15), 2.0)
    settle(physics, box, 20)
    depsgraph = physics.bpy.context.evaluated_depsgraph_get()
    collider = rigid_body_collider(depsgraph, floor.evaluated_get(depsgraph), np.ones(3), 1.0)
    top = collider.hi[2] + floor.location.z + collider.margin
    assert lowest(physics, box)[0] == pytest.approx(top, abs=GAP)
    assert top == pytest.approx(height + 0.04, abs=1e-4)
