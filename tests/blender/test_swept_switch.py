# SPDX-License-Identifier: GPL-3.0-or-later
"""Swept switches in Blender scenes: no rigid flag slips through between two frames."""

import math

import numpy as np
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.explain.explain import explain
from tiers import mostly_slow

FRAME = 1 / 24


def closed_at(world, recording, name="switch"):
    """Return the frames of the updates that read closed."""
    track = recording.tracks[name]
    opened = world.series(recording, name, "open")
    return [f for f, o in zip(track.frames, opened, strict=True) if not o]


def pass_beam(world, obj, at=10.5, speed=1.0, depth=-0.1, origin=(0, 0, 0)):
    """Set keys: the object's origin is in the beam at frame `at`, with `speed` (m/s) along x."""
    x, y, z = origin
    place = (at - 1) * FRAME * speed
    ends = {1: x - place, 24: x + 23 * FRAME * speed - place}
    world.key(obj, "location", {frame: (at_x, y, z + depth) for frame, at_x in ends.items()})
    world.scene.frame_end = 24
    return obj


def card_past(world, width=0.01, name="card", **way):
    return pass_beam(world, world.box((width, 0.1, 0.001), name=name), **way)


# Flags that are detected


def test_a_card_between_two_frames_is_caught(world, swept, each_caster):
    card_past(world)
    swept()
    swept("unswept", swept=False)
    recording = world.run()
    assert closed_at(world, recording) == [11]
    assert closed_at(world, recording, "unswept") == []
    ranges = world.series(recording, "switch", "range_m")
    assert ranges[10] == pytest.approx(0.0995, abs=1e-7)
    assert set(ranges[:10] + ranges[11:]) == {0.5}
    assert [row[5] for row in world.log(recording) if row[2] == "switch"] == ["1", "0", "1"]


@pytest.mark.parametrize(
    "width, speed", [(0.1, 1.0), (0.01, 0.05), (1e-3, 1.0), (1e-4, 20.0), (1e-5, 1.0)]
)
def test_flags_of_any_width_and_speed_are_caught_at_any_moment(world, swept, width, speed):
    """Exactly at the updates at which, or in whose interval, the flag is in the beam."""
    card_past(world, width=width, speed=speed, at=12.3)
    switches = 20
    for i in range(switches):
        obj = swept(f"switch {i}")
        obj.location.x = speed * FRAME * i / switches
    recording = world.run()
    for i in range(switches):
        edges = 12.3 + i / switches + np.array([-0.5, 0.5]) * width / speed / FRAME
        expected = [f for f in range(1, 25) if edges[0] < f < edges[1]]
        expected = expected or [math.ceil(edges[1])]
        if min(abs(edges - np.round(edges))) > 1e-4:
            assert closed_at(world, recording, f"switch {i}") == expected


def test_a_slow_switch_watches_between_its_updates(world, swept, each_caster):
    card_past(world, at=7.5)
    world.scene.frame_end = 48
    swept(update_rate=1.0)
    assert closed_at(world, world.run()) == [25]


def test_one_that_reaches_in_and_draws_back_is_caught(world, swept):
    """At both updates it is at the same place."""
    hand = world.box((0.1, 0.1, 0.01), name="hand")
    places = {1: (0.2, 0, -0.1), 6: (0.2, 0, -0.1), 8: (0.04, 0, -0.1), 10: (0.2, 0, -0.1)}
    world.key(hand, "location", places)
    swept(update_rate=1.0)
    assert closed_at(world, world.run()) == [25]


@pytest.mark.parametrize("scale", [(1, 1, 1), (-1, 1, 1), (-2, -0.5, -3), (0.01, 20, 1)])
@pytest.mark.parametrize("far", [0.0, 1e4])
def test_mirrored_and_scaled_and_far_away(world, swept, scale, far):
    """Coordinates of single precision are a millimetre apart 10 km from the origin."""
    card = world.box([size / abs(s) for size, s in zip((0.01, 0.1, 0.01), scale, strict=True)])
    card.scale = scale
    pass_beam(world, card, origin=(far, -far, far), speed=2.0)
    swept().location = (far, -far, far)
    recording = world.run()
    assert closed_at(world, recording) == [11]
    assert world.series(recording, "switch", "range_m")[10] == pytest.approx(
        0.095, abs=1e-6 + 1e-3 * (far > 0)
    )


def test_the_sensor_that_moves_past_a_flag(world, swept):
    """One moves past the flag, one turns past a pole by 20° a frame."""
    world.box((0.01, 0.1, 0.001), at=(0, 0, -0.1), name="card")
    pass_beam(world, swept(), depth=0.0)
    world.box((0.01, 0.1, 0.01), at=(5.2, 0, 0), name="pole")
    turning = swept("turning")
    turning.location = (5, 0, 0)
    turning.rotation_mode = "XYZ"
    turns = {1: (0, math.radians(-90 - 190), 0), 24: (0, math.radians(-90 + 270), 0)}
    world.key(turning, "rotation_euler", turns)
    recording = world.run()
    assert closed_at(world, recording) == [11]
    assert closed_at(world, recording, "turning") == [11]
    ranges = world.series(recording, "turning", "range_m")
    assert ranges[10] == pytest.approx(0.195, abs=1e-5)


def test_what_moves_with_the_sensor_never_crosses(world, swept):
    """A carriage with switch and flag turns and drives; a still post is detected."""
    carriage = world.link("carriage", None)
    carriage.rotation_mode = "XYZ"
    flag = world.box((0.01, 0.1, 0.001), at=(0.012, 0, -0.1), name="flag")
    switch = swept()
    flag.parent = switch.parent = carriage
    world.key(carriage, "location", {1: (0, 0, 0), 24: (9, 3, 1)})
    world.key(carriage, "rotation_euler", {1: (0, 0, 0), 24: (1, 2, 3)})
    world.scene.frame_end = 24
    assert closed_at(world, world.run()) == []


@pytest.mark.parametrize("radius", [0.3, 0.9])
@pytest.mark.parametrize("hinge_is_origin", [True, False])
def test_the_edge_of_a_door_that_is_flung(world, swept, radius, hinge_is_origin):
    """At 40° a frame, a beam 0.1 mm beyond the tip is open, one 0.1 mm nearer is broken.

    The tip passes midway between two frames.
    """
    door = world.box((0.001, 0.1, 0.001), name="door")
    pivot = world.link("hinge", None)
    pivot.rotation_mode = "XYZ"
    if hinge_is_origin:
        points = [(x + radius - 0.0005, y, z) for x, y, z in (v.co for v in door.data.vertices)]
        for vertex, point in zip(door.data.vertices, points, strict=True):
            vertex.co = point
    else:
        door.location.x = radius - 0.0005
    door.parent = pivot
    pivot.location = (0, 0, -0.1)
    slope = math.radians(40)
    # About z; at frame 6.5 it points along +x.
    world.key(pivot, "rotation_euler", {1: (0, 0, -5.5 * slope), 9: (0, 0, 2.5 * slope)})
    for name, x in (("in", radius - 1e-4), ("out", radius + 1e-3)):
        swept(name, threshold=0.3).location = (x, 0, 0)
    # The flag is 0.1 m wide: its corners reach farther.
    reach = math.hypot(radius, 0.05)
    swept("beyond").location = (reach + 1e-4, 0, 0)
    recording = world.run(1, 9)
    assert 7 in closed_at(world, recording, "in")
    assert closed_at(world, recording, "beyond") == []
    # Its corners pass at angles to both sides, still within the same frame for the longer one.
    assert 7 in closed_at(world, recording, "out")


def test_an_aperture_is_covered_by_a_wide_flag_and_not_by_a_thin_one(world, swept):
    for name, width, y in (("wide", 0.01, 0.0), ("thin", 0.0004, 1.0)):
        card_past(world, width=width, name=f"{name} card", origin=(0, y, 0))
        slit = swept(name, aperture_rays=9, aperture=0.001)
        slit.location.y = y
    recording = world.run()
    assert closed_at(world, recording, "wide") == [11]
    assert closed_at(world, recording, "thin") == []


def test_what_stands_in_part_of_the_slit_counts_too(world, swept):
    """A strip over 4 of 9 rays leaves it open; with a thin flag before the strip, it closes."""
    world.box((0.001, 0.1, 0.001), at=(-0.00055, 0, -0.2), name="strip")
    card_past(world, width=0.0003)
    swept(aperture_rays=9, aperture=0.001, hysteresis=0.0)
    assert closed_at(world, world.run()) == [11]


def broken_by_a_corner(world, name, frame):
    """Return whether 2048 samples find the beam broken between the frame before and this one."""
    for obj in world.scene.objects:
        obj.angen_sensor.enabled = obj.name == name
        obj.angen_sensor.update_rate = 24 * 2048
    world.scene.angen_substeps = 2048
    recording = world.run(frame - 1, frame - 1)
    return 0 in world.series(recording, name, "open")


@pytest.mark.parametrize("seed", mostly_slow(range(4), 0))
def test_random_flags_against_64_substeps(world, swept, seed):
    """Boxes that fly, or swing about hinges, past 12 switches.

    The sweep finds exactly the flags that dense samples find.
    """
    chance = np.random.default_rng(seed)
    world.scene.frame_end = 5
    for i in range(12):
        box = world.box(chance.uniform(0.005, 0.05, 3), name=f"box {i}")
        box.scale = chance.choice([-1.0, 1.0, 2.0], 3)
        if i % 2:
            start, end = chance.uniform(-0.6, 0.6, (2, 3)) - (0, 0, 0.1)
            world.key(box, "location", {1: start, 5: end})
            continue
        box.parent = world.link(f"hinge {i}", None, chance.uniform(-0.2, 0.2, 3))
        box.location = chance.uniform(-0.3, 0.3, 3)
        box.parent.rotation_mode = "AXIS_ANGLE"
        axis, angle = chance.normal(size=3), chance.uniform(2, 6)
        turns = {1: (0.0, *axis), 5: (angle, *axis)}
        world.key(box.parent, "rotation_axis_angle", turns)
    for i in range(12):
        sensor = swept(f"switch {i:02d}", range_max=1.0, threshold=0.99, aperture_rays=3)
        sensor.angen_sensor.optical_switch.aperture = 0.002
        sensor.location = (*chance.uniform(-0.25, 0.25, 2), 0.4)
    found = world.run()
    for obj in world.scene.objects:
        obj.angen_sensor.optical_switch.swept = False
        obj.angen_sensor.update_rate = 24 * 64
    world.scene.angen_substeps = 64
    dense = world.run()
    broken = 0
    for name in found.tracks:
        looks = np.array(dense.tracks[name].active[: 4 * 64 + 1])
        closing = np.flatnonzero(np.diff(looks) < 0) + 1
        edges = {1 + math.ceil(step / 64) for step in closing.tolist()}
        at_frames = {f for f in range(1, 6) if not looks[(f - 1) * 64]}
        assert (edges | at_frames) <= set(closed_at(world, found, name)), name
        for frame in set(closed_at(world, found, name)) - edges - at_frames:
            assert broken_by_a_corner(world, name, int(frame)), (name, frame)
        broken += len(edges)
    assert broken >= 1, "the boxes met the beams"


# Flags that are not detected


def test_a_flag_that_stops_before_the_beam(world, swept):
    card = world.box((0.01, 0.1, 0.001), name="card")
    world.key(card, "location", {1: (-0.5, 0, -0.1), 10: (-0.0051, 0, -0.1), 20: (-0.5, 0, -0.1)})
    swept()
    nearer = swept("nearer")
    nearer.location.x = -0.0002
    recording = world.run()
    assert closed_at(world, recording) == []
    assert closed_at(world, recording, "nearer") == [10]


@pytest.mark.parametrize("beyond, closes", [(1e-4, False), (-1e-4, True)])
def test_a_flag_behind_the_threshold_and_before_it(world, swept, beyond, closes):
    card_past(world, depth=-(0.3005 + beyond))
    swept()
    assert bool(closed_at(world, world.run())) is closes


def test_nothing_is_late_where_a_flag_leaves(world, swept):
    """Opening is at the same update, swept or not."""
    card_past(world, width=0.3, at=12.3)
    swept()
    swept("unswept", swept=False)
    recording = world.run()
    assert closed_at(world, recording) == closed_at(world, recording, "unswept")
    assert recording.tracks["switch"].value == recording.tracks["unswept"].value


def test_its_own_housing_and_what_is_ignored(world, swept):
    card_past(world, name="ignored").angen_ignored = True
    switch = swept()
    card_past(world, name="own").parent = switch
    assert closed_at(world, world.run()) == []


def test_what_appears_or_changes_shape_is_not_swept(world, swept):
    """A card that is hidden until it is past, and one that bends as it passes."""
    hidden = card_past(world, name="hidden")
    world.key(hidden, "hide_viewport", {1: True, 11: False}, "CONSTANT")
    bends = card_past(world, name="bends")
    bends.shape_key_add(name="Basis")
    key = bends.shape_key_add(name="bent")
    key.data[0].co.y += 0.01
    for frame, value in ((1, 0.0), (24, 1.0)):
        key.value = value
        key.keyframe_insert("value", frame=frame)
    swept()
    assert closed_at(world, world.run()) == []


def test_what_appears_on_the_way_of_a_sensor_was_not_met(world, swept):
    card = world.box((0.01, 0.1, 0.001), at=(0, 0, -0.1), name="card")
    world.key(card, "hide_viewport", {1: True, 11: False}, "CONSTANT")
    pass_beam(world, swept(), depth=0.0)
    assert closed_at(world, world.run()) == []


@pytest.mark.parametrize("scale", [0.0, math.nan])
def test_what_is_flattened_at_a_frame_is_not_swept_from_there(world, swept, scale):
    card = card_past(world)
    world.key(card, "scale", {1: (scale, 1, 1), 11: (1, 1, 1)}, "CONSTANT")
    swept()
    with np.errstate(all="raise"):
        assert closed_at(world, world.run()) == []


def test_switched_off_at_the_frame_before(world, swept):
    card_past(world)
    obj = swept()
    world.key(obj, "angen_sensor.enabled", {1: True, 10: False, 11: True}, "CONSTANT")
    recording = world.run()
    assert closed_at(world, recording) == []
    assert 10.0 not in list(recording.tracks["switch"].frames)


# Swept switches in playback, in parts of runs, and in explanations


@pytest.mark.parametrize("rate", [2.0, 10.0, 24.0, 60.0])
@pytest.mark.parametrize("substeps", [1, 3])
def test_from_its_second_update_on_a_part_tells_what_the_whole_run_does(
    world, swept, rate, substeps
):
    world.scene.angen_substeps = substeps
    for at in (4.5, 8.2, 11.5, 13.3, 17.9, 22.4):
        card_past(world, width=0.004, name=f"card {at}", at=at)
    swept(update_rate=rate, aperture_rays=5, aperture=0.002)
    world.scene.frame_end = 48
    whole = world.run().tracks["switch"]
    assert 0 in whole.active
    for first in (2, 5, 9, 14):
        part = world.run(first, 48).tracks["switch"]
        assert len(part.frames) > 1
        skipped = len(whole.frames) - len(part.frames)
        for name in ("frames", "active", "value"):
            told, expected = list(getattr(part, name)), list(getattr(whole, name))
            assert told[1:] == expected[skipped + 1 :], (first, name)


def test_swept_may_be_keyed(world, swept):
    for i, at in enumerate((6.5, 16.5)):
        card_past(world, name=f"card {i}", at=at)
    obj = swept()
    world.key(obj, "angen_sensor.optical_switch.swept", {1: False, 12: True}, "CONSTANT")
    assert closed_at(world, world.run()) == [17]


def test_what_went_through_is_named(world, swept, each_caster):
    card_past(world, name="Card")
    obj = swept(update_rate=12.0)
    recording = world.run()
    sensor = next(s for s in world.sensors() if s.object == obj)
    track = recording.tracks["switch"]
    index = list(track.frames).index(11)
    told = {i: explain(world.scene, sensor, recording, i) for i in (index - 1, index, index + 1)}
    assert not any(found.doubt for found in told.values())
    # It comes in 5 mm before frame 10.5.
    assert told[index].headline == (
        "Closed: 'Card' went through the beam 0.100 m from the sensor, 0.026 s before this update"
    )
    assert told[index].cause.now.ago == pytest.approx((0.5 + 0.005 * 24) * FRAME, abs=1e-5)
    assert "nothing within" in dict(told[index].facts)["Before"]
    assert told[index + 1].headline.startswith("Open: 'Card' no longer breaks the beam")
    assert "'Card' at" in dict(told[index + 1].facts)["Before"]
    assert told[index - 1].headline.startswith("Open: nothing")
