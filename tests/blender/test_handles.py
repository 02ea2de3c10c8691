# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles that a user drags in 3D views: where they are, and what a drag does.

There is no window here: real drags are seen with xdotool. The gizmo's methods run on stand-ins.
"""

import math
import types

import bpy
import numpy as np
import pytest
from mathutils import Euler, Matrix, Vector

PIXELS_A_METRE = 100.0


@pytest.fixture
def gizmos(world, addon_part):
    return addon_part("angen_addon.view.gizmos")


@pytest.fixture
def active(world, gizmos):
    """Makes an object the active one; its handles by the label, as a user has them then."""

    def make(obj):
        obj.select_set(True)
        bpy.context.view_layer.objects.active = obj
        world.update()
        sensor = gizmos.sensor_with_handles(bpy.context)
        found = gizmos.handles_of(sensor) if sensor is not None else []
        return sensor, {handle.label(sensor): handle for handle in found}

    return make


def place(gizmos, sensor, handle, metres=1.0):
    return gizmos.in_world(sensor, handle, metres)(handle.value(sensor))


@pytest.mark.parametrize("scale", [1.0, 0.01])
def test_handles_stand_where_the_sensor_sees_and_do_not_follow_its_scale(
    world, gizmos, active, scale
):
    world.scene.unit_settings.scale_length = scale
    obj = world.pir(range_max=4.0, horizontal_fov=math.radians(60), vertical_fov=math.radians(90))
    obj.location, obj.scale = (1 / scale, 2 / scale, 3 / scale), (5.0, 0.2, -3.0)
    obj.rotation_euler = turned = Euler((0.4, -0.3, 2.0))
    sensor, handles = active(obj)
    assert list(handles) == ["Range max", "Horizontal field of view", "Vertical field of view"]
    for label, expected in (
        ("Range max", (0, 0, -4)),
        ("Horizontal field of view", (1, 0, -math.sqrt(3))),
        ("Vertical field of view", (0, -2, 0)),
    ):
        at = Vector((1, 2, 3)) + turned.to_matrix() @ Vector(expected)
        found = place(gizmos, sensor, handles[label], scale) * scale
        if label == "Range max":
            # A mirrored object looks the same way as its axes are turned.
            assert np.linalg.norm(found - (1, 2, 3)) == pytest.approx(4.0, abs=1e-5)
        obj.scale = (1, 1, 1)
        world.update()
        found = place(gizmos, sensor, handles[label], scale) * scale
        assert found == pytest.approx(np.array(at), abs=1e-4)


def test_each_model_has_its_own_handles(world, gizmos, active):
    def labels(obj):
        return list(active(obj)[1])

    pir = world.pir()
    pir.angen_sensor.pir.model = "PYROELECTRIC"
    assert labels(pir) == ["Detection distance"]
    light = world.sensor("LIGHT", "light")
    assert labels(light) == ["Clip end", "Field of view"]
    light.angen_sensor.light.method = "ILLUMINANCE"
    assert labels(light) == []
    assert labels(world.switch()) == ["Range max", "Threshold"]
    ranger = world.sensor("DISTANCE", "ranger")
    assert {"Range max", "Threshold"} < set(labels(ranger)) and len(labels(ranger)) == 4
    assert labels(world.sensor("CONTACT", "contact")) == []
    ranger.select_set(False)
    bpy.context.view_layer.objects.active = ranger
    assert gizmos.sensor_with_handles(bpy.context) is None, "what is not selected has none"
    ranger.select_set(True)
    assert gizmos.sensor_with_handles(bpy.context) is not None
    world.scene.angen_overlay.handles = False
    assert gizmos.sensor_with_handles(bpy.context) is None


def test_a_value_stays_within_the_limits_of_its_property_and_has_few_digits(world, active):
    sensor, handles = active(world.pir())
    parameters = sensor.parameters
    for label, name, given, snapped, expected in (
        ("Range max", "range_max", 3.14159, False, 3.142),
        ("Range max", "range_max", 3.14159, True, 3.1),
        ("Range max", "range_max", -2.0, False, 0.001),
        ("Horizontal field of view", "horizontal_fov", 7.0, False, 2 * math.pi),
        ("Horizontal field of view", "horizontal_fov", -1.0, False, 0.0),
        ("Vertical field of view", "vertical_fov", math.radians(43.21), False, math.radians(43.2)),
        ("Vertical field of view", "vertical_fov", math.radians(43.21), True, math.radians(45)),
    ):
        handles[label].set(sensor, given, snap=snapped)
        assert getattr(parameters, name) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("scale", [1.0, 0.01])
def test_a_pad_is_sized_by_its_edges(world, gizmos, active, scale):
    world.scene.unit_settings.scale_length = scale
    body = world.box((0.3 / scale, 0.2 / scale, 0.01 / scale), (1 / scale, 0, 0), name="pad")
    parent = world.link("parent", None)
    parent.scale = (2.0, 2.0, 2.0)
    body.parent = parent
    pad, handles = active(world.sensor("PRESSURE", "pad", body))
    assert list(handles) == ["Size X", "Size Y"]
    assert place(gizmos, pad, handles["Size X"], scale) * scale == pytest.approx(
        (2.3, 0.0, 0.01), abs=1e-6
    )
    handles["Size X"].set(pad, 0.5)
    assert tuple(body.scale) == pytest.approx((0.5 / 0.3, 1.0, 1.0))
    assert body.dimensions.x * scale == pytest.approx(1.0, rel=1e-5)
    assert place(gizmos, pad, handles["Size X"], scale)[0] * scale == pytest.approx(2.5, abs=1e-5)
    body.lock_scale[1] = True
    assert list(active(body)[1]) == ["Size X"]


def test_a_handle_goes_to_where_its_path_is_nearest_to_the_mouse(gizmos):
    def straight(value):
        return 100.0 + 30.0 * value, 50.0 + 40.0 * value

    at = gizmos.drag_value(
        straight, 2.0, (100.0 + 300.0 - 40.0, 50.0 + 400.0 + 30.0), 0.0, math.inf
    )
    assert at == pytest.approx(10.0), "beside the path: the foot on it"
    assert gizmos.drag_value(straight, 2.0, (-500.0, -500.0), 0.001, 9.0) == 0.001
    assert gizmos.drag_value(straight, 2.0, (5000.0, 5000.0), 0.001, 9.0) == 9.0

    def round_(angle):
        return 300 + 200 * math.sin(angle / 2), 300 - 200 * math.cos(angle / 2)

    for angle in (0.2, 1.5, 3.0, 5.0):
        target = 300 + 250 * math.sin(angle / 2), 300 - 250 * math.cos(angle / 2)
        assert gizmos.drag_value(round_, 2.0, target, 0.0, 6.28) == pytest.approx(angle, rel=1e-3)

    def away(value):
        return 400 + 1000 / (value + 2), 300.0

    assert gizmos.drag_value(away, 1.0, away(30.0), 0.0, math.inf) == pytest.approx(30.0, rel=1e-2)
    assert gizmos.drag_value(lambda value: (400.0, 300.0), 2.0, (9.0, 9.0), 0.0, 9.0) == 2.0
    assert gizmos.drag_value(lambda value: None, 2.0, (9.0, 9.0), 0.0, 9.0) == 2.0, "behind the eye"


@pytest.fixture
def drag(world, gizmos, monkeypatch):
    """Drags a handle by pixels in steps, as Blender calls the gizmo, in a view along +Y of 100
    pixels a metre; ends as a release does, or as Esc. Returns the messages of undo steps."""
    part, messages = types.SimpleNamespace, []
    matrix = Matrix.Translation((0, 0, -5)) @ Matrix.Rotation(-math.pi / 2, 4, "X")
    lens = Matrix.Diagonal((PIXELS_A_METRE / 400, PIXELS_A_METRE / 300, -0.01, 1.0))
    ops = part(ops=part(ed=part(undo_push=lambda message: messages.append(message))))
    monkeypatch.setattr(gizmos, "bpy", ops)

    def context():
        return part(
            scene=world.scene,
            view_layer=bpy.context.view_layer,
            window_manager=bpy.context.window_manager,
            mode="OBJECT",
            region=part(width=800, height=600),
            region_data=part(perspective_matrix=lens @ matrix, view_matrix=matrix),
        )

    def run(handle, x, y, cancel=False, tweak=()):
        gizmo = part(handle=handle)
        own = gizmos.ANGEN_GT_handle
        gizmo._project = lambda *given: own._project(gizmo, *given)
        event = part(mouse_region_x=300, mouse_region_y=300)
        assert own.invoke(gizmo, context(), event) == {"RUNNING_MODAL"}
        for share in (0.25, 0.5, 1.0):
            event = part(mouse_region_x=300 + share * x, mouse_region_y=300 + share * y)
            assert own.modal(gizmo, context(), event, set(tweak)) == {"RUNNING_MODAL"}
            world.update()
        own.exit(gizmo, context(), cancel)
        done, messages[:] = messages[:], []
        return done

    run.context = context
    return run


def test_a_drag_is_one_step_of_undo_and_esc_brings_the_value_back(world, active, drag):
    """The detector looks along +X, to the right in the view."""
    obj = world.pir(range_max=2.0)
    obj.rotation_euler = (math.pi / 2, 0, -math.pi / 2)
    _, handles = active(obj)
    pir, handle = obj.angen_sensor.pir, handles["Range max"]
    assert drag(handle, 150, 7) == ["Drag Range max"]
    assert pir.range_max == pytest.approx(3.5, abs=1e-4)
    assert drag(handle, 100, 0, cancel=True) == [] and pir.range_max == pytest.approx(3.5, abs=1e-4)
    assert drag(handle, 0, 0) == []
    assert drag(handle, 100, 0, tweak=("PRECISE",)) and pir.range_max == pytest.approx(
        3.6, abs=1e-3
    )
    assert drag(handle, 123, 0, tweak=("SNAP",)) and pir.range_max == pytest.approx(4.8)
    drag(handle, -900, 0)
    assert pir.range_max == pytest.approx(0.001)


def test_a_handle_turns_its_arrows_along_its_path(world, gizmos, active):
    obj = world.pir(range_max=2.0)
    obj.rotation_euler = (math.pi / 2, 0, -math.pi / 2)
    sensor, handles = active(obj)
    view = Matrix.Translation((0, 0, -5)) @ Matrix.Rotation(-math.pi / 2, 4, "X")
    context = types.SimpleNamespace(
        scene=world.scene, region_data=types.SimpleNamespace(view_matrix=view)
    )
    found = gizmos.matrix_of(context, sensor, handles["Range max"])
    assert tuple(found.translation) == pytest.approx((2, 0, 0), abs=1e-5)
    assert np.abs(found.col[0][:3]) == pytest.approx((1, 0, 0), abs=1e-5)
    assert np.abs(found.col[2][:3]) == pytest.approx((0, 1, 0), abs=1e-5), "to the eye"


def test_labels_leave_room_for_handles(world, gizmos, active, drag):
    """In pixels of the view; none where Blender hides gizmos."""
    obj = world.pir(range_max=2.0, vertical_fov=0.0)
    obj.rotation_euler = (math.pi / 2, 0, -math.pi / 2)
    active(obj)
    context = drag.context()
    context.space_data = types.SimpleNamespace(show_gizmo=True)
    found = gizmos.pixels_of_handles(context)
    assert len(found) == 3
    assert tuple(found[0]) == pytest.approx((400 + 2 * PIXELS_A_METRE, 300), abs=1e-3)
    context.space_data.show_gizmo = False
    assert gizmos.pixels_of_handles(context) == []
