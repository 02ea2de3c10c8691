# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel *Study* writes a study of this home."""

from __future__ import annotations

import bpy
import pytest


@pytest.fixture
def home(world, tmp_path):
    """Add two detectors and a switch, all selected, the first detector active; save the file."""
    for name in ("PIR hall", "PIR bed"):
        world.pir(name)
    world.switch("Door")
    for obj in bpy.data.objects:
        obj.select_set(True)
    bpy.context.view_layer.objects.active = bpy.data.objects["PIR hall"]
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "home.blend"))
    return tmp_path / "home.blend"


@pytest.fixture
def wanted(addon):
    found = bpy.context.window_manager.angen_study
    yield found
    found.varied.clear()
    found.file, found.seeds = "", 1


def test_the_study_of_the_panel_is_that_of_the_selected_sensors(home, wanted, addon_part) -> None:
    for name in ("rays", "hold_time", "model", "enabled", "move_z", "rays"):
        assert bpy.ops.angen.study_vary(parameter=name) == {"FINISHED"}
    assert [row.parameter for row in wanted.varied] == [
        "rays", "hold_time", "model", "enabled", "move_z",
    ]  # fmt: skip
    wanted.varied[1].first, wanted.varied[1].last, wanted.varied[1].steps = 0.5, 2.0, 4
    bpy.ops.angen.study_leave(index=4)
    wanted.seeds = 3
    path = home.parent / "my study.toml"
    assert bpy.ops.angen.study_write(filepath=str(path)) == {"FINISHED"}
    studies, settings = addon_part("studies.study"), addon_part("studies.settings")
    study = studies.read(path)
    assert study.homes == (home.resolve(),) and study.seeds == (1, 2, 3)
    kinds = {"PIR hall": "PIR", "PIR bed": "PIR", "Door": "OPTICAL_SWITCH"}
    facts = settings.StudiedHome("home.blend", kinds, "")
    settings.check(study, [facts])
    runs = list(studies.runs_of(study))
    # 9 rays: half to twice as many; four hold times; both models; on and off; three seeds.
    assert len(runs) == 3 * 4 * 2 * 2 * 3
    first = settings.settings_of(facts, runs[0].setting)
    assert first.keys() == {"PIR hall", "PIR bed"}
    assert first["PIR hall"] == first["PIR bed"]
    assert first["PIR bed"] == {
        "rays": 4, "hold_time": 0.5, "model": "RANGE_SCAN", "enabled": True,
    }  # fmt: skip
    told = addon_part("studies.window.operators").command(wanted.file)
    assert told == f"angen study run '{path}' --out '{path.with_suffix('')}'"


def test_a_study_is_written_beside_the_home(home, wanted, addon_part) -> None:
    bpy.ops.angen.study_vary(parameter="hold_time")
    assert bpy.ops.angen.study_write(filepath="//angen_beside.toml") == {"FINISHED"}
    study = addon_part("studies.study").read(home.with_name("angen_beside.toml"))
    assert study.homes == (home.resolve(),)


def test_what_cannot_be_written_or_shown_is_told(home, wanted) -> None:
    with pytest.raises(RuntimeError, match="Add a parameter to vary"):
        bpy.ops.angen.study_write(filepath=str(home.parent / "s.toml"))
    with pytest.raises(RuntimeError, match="Write a study first"):
        bpy.ops.angen.study_report()
    with pytest.raises(RuntimeError, match="has no parameter 'reach'"):
        bpy.ops.angen.study_vary(parameter="reach")
    bpy.ops.angen.study_vary(parameter="hold_time")
    wanted.varied[0].first = 9.0
    with pytest.raises(RuntimeError, match=r"Hold time \(s\): To must be above From"):
        bpy.ops.angen.study_write(filepath=str(home.parent / "s.toml"))
    wanted.file = str(home.parent / "s.toml")
    with pytest.raises(RuntimeError, match="There is no report yet: run `angen study report"):
        bpy.ops.angen.study_report()


def test_angles_are_degrees_in_the_panel_and_radians_in_the_file(home, wanted, addon_part) -> None:
    for name in ("horizontal_fov", "turn_z", "model", "enabled"):
        bpy.ops.angen.study_vary(parameter=name)
    fov, turn, model, enabled = wanted.varied
    assert (fov.label, turn.label) == ("Horizontal field of view (°)", "Turn Z (°)")
    assert fov.last == pytest.approx(240.0) and turn.first == pytest.approx(-30.0)
    assert (model.shown, enabled.shown) == ("Range scan, Pyroelectric", "On, Off")
    fov.first, fov.last = 90.0, 180.0
    path = home.parent / "angles.toml"
    bpy.ops.angen.study_write(filepath=str(path))
    (line,) = (found for found in path.read_text().splitlines() if "horizontal_fov" in found)
    assert line.endswith("{ from = 1.5707963, to = 3.1415927, steps = 3 }  # 90° to 180°")
    assert addon_part("studies.study").read(path)


def test_the_panel_and_parquet_are_shown_only_where_their_packages_are(
    addon_part, monkeypatch
) -> None:
    parts, formats = addon_part("parts"), addon_part("sensor_logic.logs.formats")
    here = parts.find_spec
    assert parts.runs_here("studies.window.panel")
    monkeypatch.setattr(parts, "find_spec", lambda *a: None if a[0] == "jinja2" else here(*a))
    assert not parts.runs_here("studies.window.panel") and parts.runs_here("panels.sidebar")
    monkeypatch.setattr(formats, "find_spec", lambda name: None)
    assert not formats.FORMATS["parquet"].is_installed and formats.FORMATS["casas"].is_installed
