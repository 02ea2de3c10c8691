# SPDX-License-Identifier: GPL-3.0-or-later
"""The report from the command line and from Blender: what it says, and what it refuses."""

import re
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import bpy
import pytest

BAD_INPUT, FAILED = 2, 1


@pytest.fixture
def home(world: Any, tmp_path: Path) -> Path:
    """A door in the hall that opens at frame 13 and closes at 37, and a PIR that sees nothing."""
    world.door(13, 37)
    world.switch("Dörr <1>", range_max=0.4)["room"] = "Hall"
    world.pir("PIR").location.x = 100
    folder = tmp_path / "secret"
    folder.mkdir()
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "home & garden.blend"))
    return folder


@pytest.fixture
def command(addon_part: Any, capsys: Any) -> Any:
    """The command on the open file, in this process: (status, standard output and error)."""

    def run(*arguments: Any) -> tuple[int, str, str]:
        capsys.readouterr()
        status = addon_part("angen_addon.commands.command_line").run_command(
            [str(a) for a in arguments]
        )
        return status, *capsys.readouterr()

    return run


def texts(path: Path) -> list[str]:
    root = ET.fromstring(path.read_text(encoding="utf-8").removeprefix("<!DOCTYPE html>"))
    return [text.strip() for text in root.itertext() if text.strip()]


def rows(path: Path) -> list[list[str]]:
    root = ET.fromstring(path.read_text(encoding="utf-8").removeprefix("<!DOCTYPE html>"))
    return [["".join(cell.itertext()) for cell in row] for row in root.iter("tr")]


def test_the_page_tells_the_run(home: Path, command: Any) -> None:
    page = home / "report.html"
    status, out, _ = command("simulate", "--report", page, "--quiet")
    assert status == 0 and out.startswith("time_s,frame,sensor")
    shown = texts(page)
    for text in ("home & garden.blend", "1 to 48", "24 fps", "Timeline", "Hall", "Dörr <1>"):
        assert text in shown, text
    # The switch is numbered first: it has a room. At 24 Hz it opens at 0.5 s, closes at 1.5 s.
    assert rows(page)[1][:4] == ["1", "Dörr <1>", "Optical switch", "Hall"]
    assert rows(page)[1][5:9] == ["2", "0.5", "1.5", "50.0%"]
    assert rows(page)[-2][2] == "update_rate 24 Hz, range_max 0.4 m"
    assert "secret" not in page.read_text(encoding="utf-8")  # where the file lies is nobody's


def test_the_picture_has_timeline_and_plan(home: Path, command: Any) -> None:
    picture = home / "report.SVG"
    assert command("simulate", "--report", picture, "--quiet")[0] == 0
    shown = texts(picture)
    assert "Dörr <1>" in shown and "time in s" in shown
    assert any(text.startswith("Floor plan") for text in shown)


def test_the_same_run_gives_the_same_bytes(home: Path, command: Any) -> None:
    pages = [home / "one.html", home / "two.html"]
    for page, frame in zip(pages, (1, 20), strict=True):
        bpy.context.scene.frame_set(frame)
        assert command("simulate", "--report", page, "--quiet")[0] == 0
    assert pages[0].read_bytes() == pages[1].read_bytes()


def test_of_what_is_animated_no_single_value_is_told(home: Path, command: Any) -> None:
    obj, pages = bpy.data.objects["PIR"], [home / "one.html", home / "two.html"]
    for frame, angle in ((1, 0.5), (24, 1.0)):
        obj.angen_sensor.pir.threshold = angle
        obj.keyframe_insert("angen_sensor.pir.threshold", frame=frame)
    for page, frame in zip(pages, (1, 20), strict=True):
        bpy.context.scene.frame_set(frame)
        assert command("simulate", "--report", page, "--quiet")[0] == 0
    assert pages[0].read_bytes() == pages[1].read_bytes()
    assert rows(pages[0])[-1][2].endswith("vertical_fov 0°, threshold animated")


def test_the_report_keeps_to_the_chosen_sensors_and_frames(home: Path, command: Any) -> None:
    page = home / "r.html"
    arguments = ("--sensor", "PIR", "--frames", "5:28", "--report", page, "--quiet")
    assert command("simulate", *arguments)[0] == 0
    assert "5 to 28" in texts(page) and "Dörr <1>" not in texts(page)
    assert "What one sensor reported in 1 s." in texts(page)


def test_a_sensor_that_is_off_is_told_as_not_simulated(
    world: Any, home: Path, command: Any
) -> None:
    bpy.data.objects["PIR"].angen_sensor.enabled = False
    assert command("simulate", "--report", home / "r.html", "--quiet")[0] == 0
    assert "not simulated" in rows(home / "r.html")[2]


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("report.pdf", "report.pdf must end in .html (the whole report) or .svg"),
        ("report", "must end in .html"),
        ("none/r.html", "does not exist; make it first"),
        (".", "is a folder"),
    ],
)
def test_a_wrong_name_is_refused_before_the_run(
    home: Path, command: Any, name: str, said: str
) -> None:
    status, out, error = command("simulate", "--report", home / name)
    assert (status, out) == (BAD_INPUT, "")
    assert "--report" in error and said in error


def test_two_outputs_cannot_share_a_file(home: Path, command: Any) -> None:
    path = home / "x.html"
    status, _, error = command("simulate", "--report", path, "--events", path)
    assert status == BAD_INPUT and "--events and --report both name" in error
    assert not path.exists()


def test_where_one_file_fails_none_is_written(home: Path, command: Any) -> None:
    """The samples of 'PIR' cannot be written where a folder has their name."""
    (home / "samples" / "PIR.csv").mkdir(parents=True)
    report = home / "r.html"
    status, _, error = command("simulate", "--report", report, "--samples", home / "samples")
    assert status == FAILED and "it is a folder" in error
    assert not report.exists()


def test_the_operator_needs_a_recording_and_writes_the_same(home: Path, command: Any) -> None:
    path = home / "by_hand.html"
    assert not bpy.ops.angen.export_report.poll()
    bpy.ops.angen.simulate()
    assert bpy.ops.angen.export_report(filepath=str(path)) == {"FINISHED"}
    assert command("simulate", "--report", home / "headless.html", "--quiet")[0] == 0
    assert path.read_bytes() == (home / "headless.html").read_bytes()
    assert bpy.ops.angen.export_report.poll()  # the recording is still that of the scene
    with pytest.raises(RuntimeError, match=re.escape("must end in .html")):
        bpy.ops.angen.export_report(filepath=str(home / "r.txt"))


def test_the_export_menu_comes_and_goes(addon: Any, world: Any) -> None:
    def ours() -> list[Any]:
        drawn = bpy.types.TOPBAR_MT_file_export._dyn_ui_initialize()
        return [draw for draw in drawn if draw.__module__.endswith("operators.report")]

    assert len(ours()) == 1
    addon.unregister()
    try:
        assert ours() == [] and not hasattr(bpy.types, "ANGEN_MT_export")
    finally:
        addon.register()
    assert len(ours()) == 1
