# SPDX-License-Identifier: GPL-3.0-or-later
"""The sensors' history in the timeline: spans, events and what is drawn of them."""

import random

import bpy
import numpy as np
import pytest

ADDON = "bl_ext.user_default.angen_sensors"


@pytest.fixture
def made(addon_part):
    """A track of random readings: (kind, active, extra columns) with updates at these frames."""
    recording = addon_part("sensor_logic.recording.tracks")
    model = addon_part("sensor_logic.model")

    def make(kind, frames, active, **columns):
        track = recording.Track("sensor", kind)
        for i, (frame, on) in enumerate(zip(frames, active, strict=True)):
            fields = {
                f.name: {bool: bool(on), float: 0.0, int: 0, str: ""}[f.type]
                for f in track.kind.samples
            }
            fields.update({name: values[i] for name, values in columns.items()})
            if "valid" in fields and "valid" not in columns:
                fields["valid"] = True
            value = columns["force_n"][i] if "force_n" in columns else 0.0
            track.append(float(frame), frame / 24, model.Reading(bool(on), value, fields))
        return track

    return make


@pytest.mark.parametrize("seed", range(8))
def test_events_are_those_of_the_event_log(addon_part, made, seed):
    numbers = random.Random(seed)
    count = numbers.choice([1, 2, 40, 200])
    frames = range(1, count + 1)
    events = addon_part("sensor_logic.log")
    log = addon_part("sensor_logic.log")
    kind = ("PIR", "PRESSURE")[seed % 2]
    columns = {}
    if kind == "PRESSURE":
        columns = {
            "force_n": [numbers.choice([0.0, 0.4, 1.0, 2.5, float("nan")]) for _ in frames],
            "partners": [numbers.choice(["", "A", "A;B"]) for _ in frames],
            "valid": [numbers.random() > 0.2 for _ in frames],
        }
    track = made(kind, frames, [numbers.random() > 0.5 for _ in frames], **columns)
    track.steps = {"force_n": numbers.choice([0.0, 1.0])}
    told = {event.frame for event in log.track_events(track)}
    found = events.log_indices(track)
    assert [track.frames[i] for i in found.tolist()] == sorted(told)
    states = {"moved", "pressed", "partners", "valid"}
    changes = {e.frame for e in log.track_events(track) if e.field in states} - {1.0}
    switches = events.switch_indices(track)
    assert [track.frames[i] for i in switches.tolist()] == sorted(changes)


def test_spans_tell_active_invalid_and_off(addon_part, made):
    history = addon_part("angen_addon.view.timeline.layout")
    frames = [1, 3, 5, 7, 9, 21, 23]
    valid = [True, True, False, False, True, True, True]
    track = made("PRESSURE", frames, [0, 1, 1, 1, 1, 1, 0], valid=valid)
    spans = history.spans_of(track, 1.0, 31.0)
    found = list(zip(spans.starts, spans.ends, spans.states, strict=True))
    assert found == [
        (1, 3, history.IDLE),
        (3, 5, history.ACTIVE),
        (5, 9, history.INVALID),
        (9, 11, history.ACTIVE),
        (11, 21, history.OFF),
        (21, 23, history.ACTIVE),
        (23, 25, history.IDLE),
        (25, 31, history.OFF),
    ]


@pytest.mark.parametrize("seed", range(5))
def test_spans_agree_with_the_track_at_every_frame(addon_part, made, seed):
    """A rate that is no divisor of the frame rate: updates two and three frames apart."""
    history = addon_part("angen_addon.view.timeline.layout")
    numbers = random.Random(seed)
    frames = sorted({1 + -(-k * 24 // 10) for k in range(100)})
    track = made("PIR", frames, [numbers.random() > 0.7 for _ in frames])
    end = frames[-1] + 2.0
    spans = history.spans_of(track, 1.0, end)
    assert (spans.starts[0], spans.ends[-1]) == (1.0, end)
    assert (spans.starts[1:] == spans.ends[:-1]).all()
    assert (np.diff(spans.states) != 0).all()
    for frame in np.arange(1.0, end, 0.5):
        at = int(np.searchsorted(spans.starts, frame, side="right")) - 1
        assert spans.states[at] == track.active[track.at(frame)]


def view(addon_part, **changed):
    made = addon_part("angen_addon.view.timeline.layout").TimelineRegion(
        400, 10.0, 300.0, 1.0, 1.0, 101.0
    )
    return made._replace(**changed)


@pytest.fixture
def drawn(addon_part):
    """A history of one PIR or pad, with these spans."""
    history = addon_part("angen_addon.view.timeline.layout")

    def make(spans, kind="PIR", room="hall", name="sensor", uid=1, frames=(), values=()):
        starts, ends, states = (np.array(column, float) for column in zip(*spans, strict=True))
        row = history.HistoryRow(
            name, room, uid, kind, history.Spans(starts, ends, states.astype(np.int8)),
            np.array(frames, float), np.array(values, float),
            max(values, default=1.0),
        )  # fmt: skip
        return history.History((row,), 1.0, 101.0)

    return make


def test_an_active_span_is_where_its_frames_are(addon_part, drawn):
    layout = addon_part("angen_addon.view.timeline.layout")
    history = addon_part("angen_addon.view.timeline.layout")
    some = drawn([(1, 26, history.IDLE), (26, 51, history.ACTIVE), (51, 101, history.IDLE)])
    picture = layout.strips(some, view(addon_part), frozenset())
    solid = [q for q in picture.quads if q[4] == layout.COLOURS[0]]
    assert [(q[0], q[2]) for q in solid] == [(100.0, 200.0)]
    # Twice as near: the same span is twice as long.
    picture = layout.strips(some, view(addon_part, left=26.0, right=76.0), frozenset())
    solid = [q for q in picture.quads if q[4] == layout.COLOURS[0]]
    assert [(q[0], q[2]) for q in solid] == [(0.0, 200.0)]


def test_the_shortest_span_is_seen_and_the_number_of_shapes_is_bounded(addon_part, drawn):
    layout = addon_part("angen_addon.view.timeline.layout")
    history = addon_part("angen_addon.view.timeline.layout")
    count = 100_000
    frames = np.linspace(1.0, 101.0, count + 1)
    spans = [
        (frames[i], frames[i + 1], history.ACTIVE if i % 97 == 0 else history.IDLE)
        for i in range(count)
    ]
    picture = layout.strips(drawn(spans), view(addon_part), frozenset())
    assert len(picture.quads) <= 400
    alone = drawn([(1, 50, 0), (50, 50.001, history.ACTIVE), (50.001, 101, 0)])
    picture = layout.strips(alone, view(addon_part), frozenset())
    solid = [q for q in picture.quads if q[4] == layout.COLOURS[0]]
    assert [q[2] - q[0] for q in solid] == [1.0]


def test_states_differ_without_colour(addon_part, drawn):
    """Solid, hatched, dotted: by the shapes, whatever their colours are."""
    layout = addon_part("angen_addon.view.timeline.layout")
    history = addon_part("angen_addon.view.timeline.layout")

    def shapes(state):
        picture = layout.strips(drawn([(1, 101, state)]), view(addon_part), frozenset())
        rows = [q for q in picture.quads if q[4] != layout.GROUND]
        slanted = [line for line in picture.lines if line[0] != line[2] and line[1] != line[3]]
        covered = sum((q[2] - q[0]) * (q[3] - q[1]) for q in rows)
        return round(covered / (400 * 15), 2), len(slanted) > 20

    assert shapes(history.ACTIVE) == (1.0, False)
    assert shapes(history.INVALID) == (0.0, True)
    assert shapes(history.IDLE) == (0.0, False)
    dots, slanted = shapes(history.OFF)
    assert 0.0 < dots < 0.1
    assert not slanted


def test_a_curve_keeps_its_peaks(addon_part, drawn):
    layout = addon_part("angen_addon.view.timeline.layout")
    history = addon_part("angen_addon.view.timeline.layout")
    frames = np.linspace(1.0, 100.9, 50_000)
    values = np.ones(len(frames))
    values[20_000] = 4.0
    some = drawn([(1, 101, history.ACTIVE)], kind="PRESSURE", frames=frames, values=values)
    picture = layout.strips(some, view(addon_part), frozenset())
    tops = {q[3] - q[1] for q in picture.quads if q[4] == layout.COLOURS[2]}
    assert max(tops) == 15.0
    assert min(tops) == pytest.approx(15 / 4, abs=0.5)


@pytest.mark.parametrize("count", [1, 22, 500])
def test_rows_keep_within_the_region_and_what_does_not_fit_is_told(addon_part, drawn, count):
    layout = addon_part("angen_addon.view.timeline.layout")
    history = addon_part("angen_addon.view.timeline.layout")
    rows = []
    for i in range(count):
        rows += drawn([(1, 101, history.ACTIVE)], room=f"room {i % 5}", name=f"s{i}", uid=i).rows
    rows.sort(key=lambda row: row.room)
    some = history.History(tuple(rows), 1.0, 101.0)
    for top in (12.0, 60.0, 300.0, 2000.0):
        picture = layout.strips(some, view(addon_part, top=top), frozenset({1}))
        names = layout.labels(some, view(addon_part, top=top), frozenset(), ground=True)
        strips = [q for q in picture.quads if q[4] == layout.COLOURS[0]]
        assert all(10.0 <= q[1] < q[3] <= top for q in strips)
        lows = sorted(q[1] for q in strips)
        highs = sorted(q[3] for q in strips)
        assert all(low >= high for low, high in zip(lows[1:], highs[:-1], strict=True))
        told = [word.text for word in picture.words if "more" in word.text]
        left_out = count - len(strips)
        assert told == (
            [f"{left_out} more: make this editor higher"] if left_out and strips else []
        )
        assert len(names.words) in (0, len(strips))


def test_rows_stand_by_room_and_kind_and_sensors_without_a_track_are_told_as_off(world, addon_part):
    history = addon_part("angen_addon.view.timeline.layout")
    world.pir("B")["room"] = "hall"
    world.switch("A")["room"] = "hall"
    world.switch("C")
    world.pir("D", enabled=False)["room"] = "attic"
    recording = world.run()
    found = history.history_of(recording, world.sensors())
    assert [(row.room, row.name) for row in found.rows] == [
        ("attic", "D"), ("hall", "B"), ("hall", "A"), ("", "C"),
    ]  # fmt: skip
    off, pir = found.rows[:2]
    assert off.spans.states.tolist() == [history.OFF]
    assert (pir.spans.starts[0], pir.spans.ends[-1]) == (1.0, 49.0)
    assert history.OFF not in pir.spans.states
    assert found.row_of(pir.uid) is pir


def test_a_history_is_made_once_a_recording(world, addon_part):
    made = addon_part("angen_addon.view.timeline.layout").Histories()
    sensor = world.switch("A")
    recording = world.run()
    first = made.get(recording, world.sensors())
    assert made.get(recording, world.sensors()) is first
    sensor["room"] = "hall"
    second = made.get(recording, world.sensors())
    assert second.rows[0].room == "hall"
    assert made.get(world.run(), world.sensors()) is not second


def test_a_day_is_made_ready_quickly(addon_part, made):
    """86 400 s at 10 Hz: the events by numpy, not row by row."""
    recording = addon_part("sensor_logic.recording.tracks")
    events = addon_part("sensor_logic.log")
    history = addon_part("angen_addon.view.timeline.layout")
    count = 864_000
    track = recording.Track("day", "PIR")
    active = (np.arange(count) // 50 % 7 == 0).astype(np.int8)
    track.frames.extend(np.arange(count) * 2.4 + 1)
    track.active.extend(active)
    track.columns["moved"].extend(active)
    assert len(events.switch_indices(track)) == int(np.count_nonzero(np.diff(active)))
    spans = history.spans_of(track, 1.0, count * 2.4 + 1)
    assert len(spans.starts) == int(np.count_nonzero(np.diff(active))) + 1


def test_nothing_is_drawn_without_a_window_and_settings_are_the_scenes(world, addon_part):
    assert bpy.app.background
    assert not addon_part("angen_addon.view.timeline.draw")._handles
    settings = world.scene.angen_timeline
    assert (settings.show, settings.rows, settings.names) == (True, "ALL", True)
    menu = bpy.types.DOPESHEET_HT_header.draw._draw_funcs
    assert [f.__name__ for f in menu].count("draw_in_timeline_header") == 1


# Jumping


@pytest.fixture
def jumper(world):
    """A switch that opens and closes at frames 10, 20 and 30."""
    leaf = world.box((0.1, 0.1, 0.01), at=(0, 0, -0.02), name="door")
    places = {1: (0, 0, -0.02), 10: (1, 0, -0.02), 20: (0, 0, -0.02), 30: (1, 0, -0.02)}
    world.key(leaf, "location", places, "CONSTANT")
    obj = world.switch()
    bpy.context.view_layer.objects.active = obj
    world.update()
    return obj


def test_jumps_go_from_event_to_event(world, jumper):
    assert bpy.ops.angen.simulate() == {"FINISHED"}
    scene = world.scene
    visited = []
    scene.frame_set(1)
    while bpy.ops.angen.event_jump(direction="NEXT") == {"FINISHED"}:
        visited.append(scene.frame_current)
    assert visited == [10, 20, 30]
    assert jumper.angen_sensor.active
    scene.frame_set(25)
    while bpy.ops.angen.event_jump(direction="PREVIOUS") == {"FINISHED"}:
        visited.append(scene.frame_current)
    assert visited[3:] == [20, 10]


def test_jumps_reach_events_between_frames(world, jumper):
    world.scene.angen_substeps = 4
    jumper.angen_sensor.update_rate = 96.0
    action = jumper.id_data  # the door's keys, moved off whole frames
    door = bpy.data.objects["door"]
    assert action is jumper
    door.animation_data_clear()
    world.key(door, "location", {1: (0, 0, -0.02), 9.3: (1, 0, -0.02)}, "CONSTANT")
    assert bpy.ops.angen.simulate() == {"FINISHED"}
    world.scene.frame_set(1)
    assert bpy.ops.angen.event_jump(direction="NEXT") == {"FINISHED"}
    assert world.scene.frame_float == pytest.approx(9.5)
    assert bpy.ops.angen.event_jump(direction="NEXT") == {"CANCELLED"}


def test_a_jump_needs_a_recorded_sensor(world, jumper):
    with pytest.raises(RuntimeError, match="Simulate first"):
        bpy.ops.angen.event_jump()
    bpy.context.view_layer.objects.active = bpy.data.objects["door"]
    with pytest.raises(RuntimeError, match="active"):
        bpy.ops.angen.event_jump()


def test_keys_are_there_once_and_gone_when_switched_off(world, addon_part):
    import addon_utils

    def items():
        config = bpy.context.window_manager.keyconfigs.addon
        keymap = config.keymaps.get("Frames") if config else None
        found = keymap.keymap_items if keymap else ()
        return [
            (i.type, i.shift, i.alt, i.ctrl, i.properties.direction)
            for i in found
            if i.idname == "angen.event_jump"
        ]

    expected = [
        ("RIGHT_ARROW", True, True, False, "NEXT"), ("LEFT_ARROW", True, True, False, "PREVIOUS"),
    ]  # fmt: skip
    assert sorted(items()) == sorted(expected)
    addon_utils.disable(ADDON)
    try:
        assert items() == []
        assert not hasattr(bpy.types.Scene, "angen_timeline")
        header = bpy.types.DOPESHEET_HT_header.draw
        names = [f.__name__ for f in getattr(header, "_draw_funcs", [])]
        assert "draw_in_timeline_header" not in names
    finally:
        assert addon_utils.enable(ADDON, default_set=True) is not None
    assert sorted(items()) == sorted(expected)
