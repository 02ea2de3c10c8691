# SPDX-License-Identifier: GPL-3.0-or-later
"""Simulating part of the frames, and what exports let the user choose."""

import csv

import bpy
import pytest

ops = bpy.ops.angen


def read(path):
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.reader(file))


@pytest.fixture
def home(world):
    """Two switches that read 24 times a second for two seconds."""
    world.wall(0.2)
    world.switch("Front")
    world.switch("Back")
    world.update()
    return world


def test_simulate_heeds_the_preview_range(home, tmp_path):
    scene = home.scene
    scene.use_preview_range = True
    scene.frame_preview_start, scene.frame_preview_end = 13, 20
    ops.simulate()
    ops.export_samples(directory=str(tmp_path))
    rows = read(tmp_path / "Front.csv")[1:]
    assert [row[1] for row in rows] == [str(frame) for frame in range(13, 21)]
    assert rows[0][0] == "0.500000", "time begins where the scene does"
    scene.use_preview_range = False
    ops.simulate()
    ops.export_samples(directory=str(tmp_path))
    assert len(read(tmp_path / "Front.csv")) == 1 + 48


def test_frames_before_the_scene_are_refused(home):
    home.scene.frame_start = 20
    with pytest.raises(RuntimeError, match=r"frames 1:5 end before the scene's start, frame 20"):
        ops.simulate(frame_start=1, frame_end=5)


def test_samples_get_a_folder_of_their_own(home, tmp_path):
    ops.simulate()
    for name in ("home samples", "home samples 2"):
        assert ops.export_samples(directory=str(tmp_path), folder="home samples") == {"FINISHED"}
        assert sorted(p.name for p in (tmp_path / name).iterdir()) == ["Back.csv", "Front.csv"]
    assert len(list(tmp_path.iterdir())) == 2
    for bad in ("a/b", ".."):
        with pytest.raises(RuntimeError, match="not the name of a folder"):
            ops.export_samples(directory=str(tmp_path), folder=bad)


def test_only_selected_sensors(home, tmp_path):
    ops.simulate()
    path = tmp_path / "events.csv"
    with pytest.raises(RuntimeError, match="No recorded sensor is selected"):
        ops.export_events(filepath=str(path), selected_only=True)
    assert not path.exists()
    bpy.data.objects["Back"].select_set(True)
    ops.export_events(filepath=str(path), selected_only=True)
    assert {row[2] for row in read(path)[1:]} == {"Back"}
    page = tmp_path / "report.html"
    ops.export_report(filepath=str(page), selected_only=True)
    text = page.read_text(encoding="utf-8")
    assert "Back" in text and "Front" not in text
    ops.export_samples(directory=str(tmp_path), folder="one", selected_only=True)
    assert [p.name for p in (tmp_path / "one").iterdir()] == ["Back.csv"]


def test_the_time_of_day(home, tmp_path):
    ops.simulate()
    path, page = tmp_path / "events.csv", tmp_path / "report.html"
    ops.export_events(filepath=str(path), start="2026-03-01T23:59:59.5")
    rows = read(path)
    assert rows[0] == ["time_s", "frame", "sensor", "kind", "field", "value", "time"]
    assert rows[1][-1] == "2026-03-01T23:59:59.500"
    ops.export_samples(directory=str(tmp_path), folder="one", start="2026-03-01T23:59:59.5")
    samples = read(tmp_path / "one" / "Front.csv")
    assert (samples[0][-1], samples[13][-1]) == ("time", "2026-03-02T00:00:00.000")
    ops.export_report(filepath=str(page), start="2026-03-01T08:00")
    assert "2026-03-01 08:00:00" in page.read_text(encoding="utf-8")
    with pytest.raises(RuntimeError, match=r"Start: 'noon' is no date and time"):
        ops.export_events(filepath=str(path), start="noon")


def test_a_dated_log_can_be_checked(home, tmp_path, addon_part):
    recording = home.run()
    log = addon_part("sensor_logic.log")
    start = addon_part("sensor_logic.log").parse_start("2026-03-01T08:00+01:00")
    path = tmp_path / "events.csv"
    path.write_text(log.events_csv(recording, start), encoding="utf-8", newline="")
    assert read(path)[1][-1] == "2026-03-01T08:00:00.000+01:00"
    found = log.read_events(path)
    assert found and log.differences(found, log.events(recording), 0.0, 0.0) == []


def test_events_for_other_tools(home, tmp_path):
    ops.simulate()
    path = tmp_path / "home"
    start = "2026-03-01T08:00"
    ops.export_format(filepath=str(path), format="casas-csv", start=start)
    assert (tmp_path / "home.csv").read_text(encoding="utf-8") == ""  # nothing changes here
    names = [row[1] for row in read(tmp_path / "home.csv.sensors.csv")[1:]]
    assert names == ["Back", "Front"]
    bpy.data.objects["Back"].select_set(True)
    ops.export_format(
        filepath=str(tmp_path / "back.lp"), format="influx", start=start, selected_only=True
    )
    (line,) = (tmp_path / "back.lp").read_text(encoding="utf-8").splitlines()
    assert line == "optical_switch,sensor=Back open=true 1772352000000000000"
    ops.export_format(filepath=str(tmp_path / "folder"), format="pyadlml", start=start)
    assert (tmp_path / "folder" / "devices.csv").exists()
    with pytest.raises(RuntimeError, match="does not exist"):
        ops.export_format(filepath=str(tmp_path / "none" / "x"), format="xes")
