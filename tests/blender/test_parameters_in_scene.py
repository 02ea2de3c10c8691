# SPDX-License-Identifier: GPL-3.0-or-later
"""Animated and driven parameters are read as they are at the frame; silent sensors stay silent."""

import pytest


def test_an_animated_threshold_is_read_at_each_frame(world, each_caster):
    world.wall(0.2)
    sensor = world.switch()
    world.key(
        sensor,
        "angen_sensor.optical_switch.threshold",
        {1: 0.1, 5: 0.3, 9: 0.1},
        "CONSTANT",
    )
    world.scene.frame_end = 12
    assert world.series(world.run(), "switch", "open") == [1] * 4 + [0] * 4 + [1] * 4


def test_an_animated_number_of_rays_is_no_movement(world):
    world.wall(2.0, size=20)
    sensor = world.pir()
    world.key(sensor, "angen_sensor.pir.rays", {1: 9, 5: 30}, "CONSTANT")
    world.scene.frame_end = 12
    assert world.series(world.run(), "pir", "moved") == [0] * 12


def test_a_driven_parameter_is_read_evaluated(world):
    world.wall(0.2)
    sensor = world.switch()
    driver = sensor.driver_add("angen_sensor.optical_switch.threshold").driver
    driver.expression = "frame / 20"
    world.scene.frame_end = 6
    # Frame 4 drives the threshold to 0.2 exactly, where the switch is still open.
    assert world.series(world.run(), "switch", "open")[:3] == [1, 1, 1]
    assert world.series(world.run(), "switch", "open")[4:] == [0, 0]


def test_an_animated_parameter_that_goes_wrong_stops_the_run_and_says_so(world, addon_part):
    world.wall(0.2)
    sensor = world.switch()
    world.key(sensor, "angen_sensor.optical_switch.range_min", {1: 0.001, 5: 0.6}, "CONSTANT")
    with pytest.raises(
        addon_part("angen_addon.scene.sensors").AngenError, match=r"'switch'.*range_min"
    ):
        world.run()


def test_a_sensor_on_a_moving_parent_with_a_constraint(world):
    """The evaluated place counts: the parent is keyed, the sensor copies another's location."""
    world.wall(0.3)
    target = world.link("target", None)
    world.key(target, "location", {1: (0, 0, 0), 5: (0, 0, -0.2)})
    sensor = world.switch()
    sensor.constraints.new("COPY_LOCATION").target = target
    world.scene.frame_end = 5
    ranges = world.series(world.run(), "switch", "range_m")
    assert ranges == pytest.approx([0.3, 0.25, 0.2, 0.15, 0.1], abs=2e-5)


@pytest.mark.parametrize("scale", [(0, 0, 0), (1, 1, 0), (float("nan"), 1, 1)])
def test_a_sensor_without_a_direction_is_refused_by_name(world, addon_part, scale):
    sensor = world.switch("Kitchen")
    sensor.scale = scale
    error = addon_part("angen_addon.scene.sensors").AngenError
    with pytest.raises(error, match="'Kitchen'"):
        world.run()


def test_a_sensor_at_nan_is_refused_by_name(world, addon_part):
    world.switch("Kitchen").location.x = float("nan")
    error = addon_part("angen_addon.scene.sensors").AngenError
    with pytest.raises(error, match="'Kitchen'"):
        world.run()


def test_a_rate_of_zero_is_refused(world, addon_part):
    world.switch("Kitchen").angen_sensor.update_rate = 0.0
    with pytest.raises(
        addon_part("angen_addon.scene.sensors").AngenError, match=r"'Kitchen'.*rate"
    ):
        world.run()


@pytest.mark.parametrize(
    ("kind", "name", "value"),
    [
        ("PIR", "range_min", 4.0),
        ("PIR", "vertical_step", 0.0),
        ("PIR", "rays", 0),
        ("OPTICAL_SWITCH", "range_max", 0.0),
        ("OPTICAL_SWITCH", "threshold", 0.7),
        ("OPTICAL_SWITCH", "aperture_rays", 0),
        ("OPTICAL_SWITCH", "hysteresis", 1.5),
    ],
)
def test_parameters_out_of_range_reach_the_user(world, addon_part, kind, name, value):
    """Blender's property lets them be typed, so that the run can say what is wrong."""
    world.sensor(kind, "Kitchen", **{name: value})
    with pytest.raises(
        addon_part("angen_addon.scene.sensors").AngenError, match=rf"'Kitchen'.*{name}"
    ):
        world.run()


def test_bad_parameters_of_a_sensor_that_is_off_do_not_matter(world):
    world.switch("off", enabled=False, range_max=0.0)
    world.switch()
    assert list(world.run().tracks) == ["switch"]


def test_nan_and_flattened_things_in_the_scene_are_passed_over(world, each_caster):
    world.wall(0.3)
    world.box((0.1, 0.1, 0.01), at=(0, 0, -0.1)).scale = (0, 1, 1)
    world.box((0.1, 0.1, 0.01), at=(0, 0, float("nan")))
    assert world.range(world.switch()) == pytest.approx(0.3, abs=2e-5)
