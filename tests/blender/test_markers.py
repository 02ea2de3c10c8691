# SPDX-License-Identifier: GPL-3.0-or-later
"""Timeline markers for events: one for each, replaced not doubled, and only these are removed."""

import bpy
import pytest


@pytest.fixture
def home(world):
    """A switch and a detector that see a door move at frames 10, 20 and 30; simulated."""
    leaf = world.box((0.1, 0.1, 0.01), at=(0, 0, -0.02), name="door")
    places = {1: (0, 0, -0.02), 10: (1, 0, -0.02), 20: (0, 0, -0.02), 30: (1, 0, -0.02)}
    world.key(leaf, "location", places, "CONSTANT")
    world.switch("switch")
    world.pir("pir", rays=1, range_min=0.001)
    world.update()
    assert bpy.ops.angen.simulate() == {"FINISHED"}
    return world


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
    with pytest.raises(RuntimeError, match="no markers"):
        bpy.ops.angen.markers_clear()


def test_they_are_known_again_in_a_saved_file_and_leave_the_recording(home, tmp_path, addon_part):
    select("switch")
    bpy.ops.angen.markers_add()
    home.update()
    assert addon_part("angen_addon.runtime.state").CACHE.recording(home.scene) is not None
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "a.blend"))
    assert len(markers(home)) == 3
    assert bpy.ops.angen.markers_clear() == {"FINISHED"}
    assert markers(home) == []


def test_long_names_and_too_many(home, monkeypatch, addon_part):
    module = addon_part("operators.markers")
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
