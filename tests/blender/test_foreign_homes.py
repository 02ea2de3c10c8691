# SPDX-License-Identifier: GPL-3.0-or-later
"""The script that puts a person and sensors into homes of others, on one that is quickly made."""

import subprocess
import sys
from pathlib import Path

import bpy
import pytest

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts" / "foreign_homes"


def furnish(home, folder):
    files = [folder / "home.blend", folder / "reference.blend"]
    command = [sys.executable, SCRIPTS / "furnish.py", home, *files]
    done = subprocess.run(
        [str(part) for part in command], capture_output=True, text=True, timeout=120, check=False
    )
    return done, *files


def write(path, points, faces):
    lines = [f"v {x} {y} {z}" for x, y, z in points]
    lines += ["f " + " ".join(str(corner + 1) for corner in face) for face in faces]
    path.write_text("o room\n" + "\n".join(lines) + "\n")
    return path


def test_a_room_gets_a_person_and_sensors_that_notice_it(world, tmp_path):
    room = world.box((5, 4, 2.5), (2.5, 2, 1.25))
    points = [tuple(v.co + room.location) for v in room.data.vertices]
    home = write(tmp_path / "room.obj", points, [f.vertices for f in room.data.polygons])
    done, furnished, reference = furnish(home, tmp_path)
    assert done.returncode == 0, done.stderr
    assert "size: 5.0 × 4.0 × 2.5 m" in done.stdout
    assert reference.exists()
    bpy.ops.wm.open_mainfile(filepath=str(furnished))
    recording = world.run()
    assert any(world.series(recording, "Angen PIR range_scan", "moved"))
    weighed = max(world.series(recording, "Angen pad", "force_n"))
    assert 680 < weighed < 690
    lux = world.series(recording, "Angen light lux", "illuminance_lux")
    assert min(lux) > 0.0


@pytest.mark.slow
def test_a_home_without_a_mesh_is_told(tmp_path):
    done, *_ = furnish(write(tmp_path / "none.obj", [(0, 0, 0)], []), tmp_path)
    assert done.returncode == 1
    assert "no mesh is shown" in done.stderr
