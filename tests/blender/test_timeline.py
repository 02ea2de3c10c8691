# SPDX-License-Identifier: GPL-3.0-or-later
"""The sensors' timeline: spans, events, how they are drawn, and markers."""

import random
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.recording.results import RESULTS
from bl_ext.user_default.angen_sensors.angen_addon.view.timeline import draw, layout
from bl_ext.user_default.angen_sensors.angen_addon.view.timeline.layout import TimelineRegion
from bl_ext.user_default.angen_sensors.operators import markers as module
from bl_ext.user_default.angen_sensors.sensor_logic import model
from bl_ext.user_default.angen_sensors.sensor_logic.recording import events
from bl_ext.user_default.angen_sensors.sensor_logic.recording import tracks as recording

ADDON = "bl_ext.user_default.angen_sensors"


@pytest.fixture
def made():
    """Make a track of random readings with updates at these frames."""

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
def test_events_are_those_of_the_event_log(made, seed):
    numbers = random.Random(seed)
    count = numbers.choice([1, 2, 40, 200])
    frames = range(1, count + 1)
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
    told = {event.frame for event in events.track_events(track)}
    found = events.log_indices(track)
    assert [track.frames[i] for i in found.tolist()] == sorted(told)
    states = {"moved", "pressed", "partners", "valid"}
    changes = {e.frame for e in events.track_events(track) if e.field in states} - {1.0}
    switches = np.unique(events.event_rows(track, values=False))
    assert [track.frames[i] for i in switches.tolist()] == sorted(changes)
    rows = [event.frame for event in events.track_events(track) if event.frame > 1.0]
    assert [track.frames[i] for i in events.event_rows(track).tolist()] == sorted(rows)


def test_spans_tell_active_invalid_and_off(made):
    frames = [1, 3, 5, 7, 9, 21, 23]
    valid = [True, True, False, False, True, True, True]
    track = made("PRESSURE", frames, [0, 1, 1, 1, 1, 1, 0], valid=valid)
    spans = layout.spans_of(track, 1.0, 31.0)
    found = list(zip(spans.starts, spans.ends, spans.states, strict=True))
    assert found == [
        (1, 3, layout.IDLE),
        (3, 5, layout.ACTIVE),
        (5, 9, layout.INVALID),
        (9, 11, layout.ACTIVE),
        (11, 21, layout.OFF),
        (21, 23, layout.ACTIVE),
        (23, 25, layout.IDLE),
        (25, 31, layout.OFF),
    ]


def view(**changed):
    made = TimelineRegion(400, 10.0, 300.0, 1.0, 1.0, 101.0)
    return made._replace(**changed)


@pytest.fixture
def drawn():
    """Make a timeline of one PIR or pad, with these spans."""

    def make(spans, kind="PIR", room="hall", name="sensor", uid=1, frames=(), values=()):
        starts, ends, states = (np.array(column, float) for column in zip(*spans, strict=True))
        row = layout.HistoryRow(
            name, room, uid, kind, layout.Spans(starts, ends, states.astype(np.int8)),
            np.array(frames, float), np.array(values, float),
            max(values, default=1.0),
        )  # fmt: skip
        return layout.History((row,), 1.0, 101.0)

    return make


def test_an_active_span_is_where_its_frames_are(drawn):
    some = drawn([(1, 26, layout.IDLE), (26, 51, layout.ACTIVE), (51, 101, layout.IDLE)])
    picture = layout.strips(some, view(), frozenset())
    solid = [q for q in picture.quads if q[4] == layout.COLOURS[0]]
    assert [(q[0], q[2]) for q in solid] == [(100.0, 200.0)]
    # Zoomed in twice: the same span is twice as long.
    picture = layout.strips(some, view(left=26.0, right=76.0), frozenset())
    solid = [q for q in picture.quads if q[4] == layout.COLOURS[0]]
    assert [(q[0], q[2]) for q in solid] == [(0.0, 200.0)]


def test_states_differ_without_colour(drawn):
    """Solid, hatched and dotted shapes differ, whatever their colours."""

    def shapes(state):
        picture = layout.strips(drawn([(1, 101, state)]), view(), frozenset())
        rows = [q for q in picture.quads if q[4] != layout.GROUND]
        slanted = [line for line in picture.lines if line[0] != line[2] and line[1] != line[3]]
        covered = sum((q[2] - q[0]) * (q[3] - q[1]) for q in rows)
        return round(covered / (400 * 15), 2), len(slanted) > 20

    assert shapes(layout.ACTIVE) == (1.0, False)
    assert shapes(layout.INVALID) == (0.0, True)
    assert shapes(layout.IDLE) == (0.0, False)
    dots, slanted = shapes(layout.OFF)
    assert 0.0 < dots < 0.1
    assert not slanted


def test_a_curve_keeps_its_peaks(addon_part, drawn):
    layout = addon_part("angen_addon.view.timeline.layout")
    history = addon_part("angen_addon.view.timeline.layout")
    frames = np.linspace(1.0, 100.9, 50_000)
    values = np.ones(len(frames))
    values[20_000] = 4.0
    some = drawn([(1, 101, history.ACTIVE)], kind="PRESSURE", frames=frames, values=values)
    picture = layout.strips(some, view(), frozenset())
    tops = {q[3] - q[1] for q in picture.quads if q[4] == layout.COLOURS[2]}
    assert max(tops) == 15.0
    assert min(tops) == pytest.approx(15 / 4, abs=0.5)


def test_names_that_differ_at_the_end_only_differ_in_a_narrow_list(drawn):
    rows = []
    for number, end in enumerate(("window", "door", "sofa")):
        rows += drawn([(1, 101, layout.ACTIVE)], name=f"PIR living room, {end}", uid=number).rows
    some = layout.History(tuple(rows), 1.0, 101.0)
    narrow = view(top=200.0)._replace(width=110)
    words = layout.labels(some, narrow, frozenset(), ground=True).words
    assert len({word.text for word in words}) == 3
    assert all(word.text.startswith("PIR") and len(word.text) * 6 <= 110 for word in words)
    wide = layout.labels(some, view(top=200.0), frozenset(), ground=True).words
    assert [word.text for word in wide] == [row.name for row in rows]


@pytest.mark.parametrize("count", [1, 22, 500])
def test_rows_keep_within_the_region_and_what_does_not_fit_is_told(drawn, count):
    rows = []
    for i in range(count):
        rows += drawn([(1, 101, layout.ACTIVE)], room=f"room {i % 5}", name=f"s{i}", uid=i).rows
    rows.sort(key=lambda row: row.room)
    some = layout.History(tuple(rows), 1.0, 101.0)
    for top in (12.0, 60.0, 300.0, 2000.0):
        picture = layout.strips(some, view(top=top), frozenset({1}))
        names = layout.labels(some, view(top=top), frozenset(), ground=True)
        strips = [q for q in picture.quads if q[4] == layout.COLOURS[0]]
        assert all(10.0 <= q[1] < q[3] <= top for q in strips)
        lows = sorted(q[1] for q in strips)
        highs = sorted(q[3] for q in strips)
        assert all(low >= high for low, high in zip(lows[1:], highs[:-1], strict=True))
        told = [word.text for word in picture.words if "editor" in word.text]
        left_out = count - len(strips)
        what = "more" if strips else "sensors"
        has_room = strips or top - 10.0 >= 2 * layout.LETTER
        text = f"{left_out} {what} not shown: make this editor higher"
        assert told == ([text] if left_out and has_room else [])
        assert len(names.words) in (0, len(strips))


def test_names_wider_than_the_list_of_channels_keep_their_ends(drawn):
    names = [f"Motion detector in the corridor upstairs {n}" for n in (1, 2)]
    rows = tuple(drawn([(1, 101, layout.IDLE)], name=name, uid=name).rows[0] for name in names)
    some = layout.History(rows, 1.0, 101.0)
    narrow = layout.labels(some, view(width=120), frozenset(), ground=True)
    assert len({word.text for word in narrow.words}) == 2
    assert all("…" in word.text for word in narrow.words)
    wide = layout.labels(some, view(width=600), frozenset(), ground=True)
    assert [word.text for word in wide.words] == names


def test_rows_stand_by_room_and_kind_and_sensors_without_a_track_are_told_as_off(world):
    world.pir("B")["room"] = "hall"
    world.switch("A")["room"] = "hall"
    world.switch("C")
    world.pir("D", enabled=False)["room"] = "attic"
    recording = world.run()
    found = layout.history_of(recording, world.sensors())
    assert [(row.room, row.name) for row in found.rows] == [
        ("attic", "D"), ("hall", "B"), ("hall", "A"), ("", "C"),
    ]  # fmt: skip
    off, pir = found.rows[:2]
    assert off.spans.states.tolist() == [layout.OFF]
    assert (pir.spans.starts[0], pir.spans.ends[-1]) == (1.0, 49.0)
    assert layout.OFF not in pir.spans.states
    assert found.row_of(pir.uid) is pir


# Jumps


@pytest.fixture
def jumper(world):
    """Add a switch that opens and closes at frames 10, 20 and 30."""
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


def test_keys_are_there_once_and_gone_when_switched_off(world):
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


# Timeline markers for events


@pytest.fixture
def home(world):
    """Add a switch and a detector before a door that moves at frames 10, 20 and 30; simulate."""
    leaf = world.box((0.1, 0.1, 0.01), at=(0, 0, -0.02), name="door")
    places = {1: (0, 0, -0.02), 10: (1, 0, -0.02), 20: (0, 0, -0.02), 30: (1, 0, -0.02)}
    world.key(leaf, "location", places, "CONSTANT")
    world.switch("switch")
    world.pir("pir", rays=1, range_min=0.001)
    world.update()
    assert bpy.ops.angen.simulate() == {"FINISHED"}
    return world


def test_the_header_tells_why_there_are_no_rows(home, monkeypatch):
    # Without a window the scale of the interface is 0.
    limits = draw.SCROLL_BAR, draw.SCRUB
    monkeypatch.setattr(draw, "_row_limits", lambda _, r: (limits[0], r.height - limits[1], 1.0))

    def told(height):
        area = SimpleNamespace(regions=[SimpleNamespace(type="WINDOW", height=height, width=400)])
        space = SimpleNamespace(mode=draw.MODE)
        layer = bpy.context.view_layer
        context = SimpleNamespace(scene=home.scene, view_layer=layer, area=area, space_data=space)
        return draw.why_no_rows(context)

    assert told(200) == "" and told(24) == "Too low for rows"
    # Rows by setting, without one that the setting selects.
    select()
    for rows, text in (("SELECTED", "Select sensors"), ("ROOM", "Select a sensor")):
        home.scene.angen_timeline.rows = rows
        assert told(200) == text
    select("pir")
    assert told(200) == ""
    home.scene.angen_timeline.rows = "ALL"
    world = home
    # Gaps between rooms leave no height for rows, although the region is higher than a row.
    for number, name in enumerate(("switch", "pir")):
        bpy.data.objects[name]["room"] = f"room {number}"
    world.update()
    assert bpy.ops.angen.simulate() == {"FINISHED"}
    most = next(height for height in range(24, 200) if not told(height))
    assert all(told(height) == "Too low for rows" for height in range(24, most))
    history = layout.history_of(RESULTS.recording(home.scene), home.sensors())
    for height in range(most, 200):
        region = TimelineRegion(400, limits[0], height - limits[1], 1.0, 0.0, 1.0)
        assert layout.place(history.rows, region)
    world.sensor("PIR", "another")
    world.update()
    assert told(200) == told(24) == "Stale: simulate"
    assert bpy.ops.angen.clear_recording() == {"FINISHED"}
    assert told(200) == told(24) == "Not recorded"
    home.scene.angen_timeline.show = False
    assert told(24) == ""
    home.scene.angen_timeline.show = True
    for sensor in world.sensors():
        bpy.data.objects.remove(sensor.object)
    world.update()
    assert told(24) == "", "files without sensors have no hint"


def select(*names):
    for obj in bpy.context.view_layer.objects:
        obj.select_set(obj.name in names)
    bpy.context.view_layer.objects.active = bpy.data.objects[names[0]] if names else None


def markers(world):
    return sorted((m.frame, m.name) for m in world.scene.timeline_markers)


SWITCH = [(10, "switch: Open"), (20, "switch: Closed"), (30, "switch: Open")]
PIR = [(f, f"pir: {w}") for f, w in [(10, "Motion"), (11, "Still"), (20, "Motion"),
                                     (21, "Still"), (30, "Motion"), (31, "Still")]]  # fmt: skip


def test_a_marker_for_each_event_of_the_selected_sensors(home):
    home.scene.timeline_markers.new("mine", frame=5)
    select("switch")
    assert bpy.ops.angen.markers_add() == {"FINISHED"}
    assert markers(home) == [(5, "mine"), *SWITCH]
    select("switch", "pir")
    assert bpy.ops.angen.markers_add() == {"FINISHED"}
    assert markers(home) == sorted([(5, "mine"), *SWITCH, *PIR])


def test_they_are_replaced_and_only_they_are_cleared(home):
    select("switch")
    bpy.ops.angen.markers_add()
    home.scene.timeline_markers[0].frame = 12
    renamed = home.scene.timeline_markers[1]
    renamed.name = "kept by the user"
    at = renamed.frame
    home.scene.timeline_markers.new("mine", frame=5)
    bpy.ops.angen.markers_add()
    assert markers(home) == sorted([(5, "mine"), (at, "kept by the user"), *SWITCH])
    select("pir")
    bpy.ops.angen.markers_add()
    assert len(markers(home)) == 11
    assert bpy.ops.angen.markers_clear() == {"FINISHED"}
    assert markers(home) == sorted([(5, "mine"), (at, "kept by the user")])
    with pytest.raises(RuntimeError, match="no event markers"):
        bpy.ops.angen.markers_clear()


def test_they_are_known_again_in_a_saved_file_and_leave_the_recording(home, tmp_path):
    select("switch")
    bpy.ops.angen.markers_add()
    home.update()
    assert RESULTS.recording(home.scene) is not None
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "a.blend"))
    assert len(markers(home)) == 3
    assert bpy.ops.angen.markers_clear() == {"FINISHED"}
    assert markers(home) == []


def test_long_names_and_too_many(home, monkeypatch):
    sensor = bpy.data.objects["switch"]
    name = "Schalter an der Tür zum Wirtschaftsraum im Süden, unten, é"
    sensor.name = name
    home.update()
    bpy.ops.angen.simulate()
    select(sensor.name)
    bpy.ops.angen.markers_add()
    bpy.ops.angen.markers_add()
    assert len(markers(home)) == 3
    monkeypatch.setattr(module, "MOST_MARKERS", 2)
    with pytest.raises(RuntimeError, match="select fewer sensors"):
        bpy.ops.angen.markers_add()
    assert len(markers(home)) == 3
    bpy.ops.angen.markers_clear()
    assert markers(home) == []


def test_what_they_need(world):
    def why(operator):
        with pytest.raises(RuntimeError) as error:
            operator()
        return str(error.value)

    world.switch()
    select()
    assert "Simulate first" in why(bpy.ops.angen.markers_add)
    world.update()
    bpy.ops.angen.simulate()
    assert "Select sensors" in why(bpy.ops.angen.markers_add)
