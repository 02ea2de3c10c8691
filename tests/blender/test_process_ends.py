# SPDX-License-Identifier: GPL-3.0-or-later
"""Processes that used the extension end, with the exit status that they should have, also where
the open file has drivers that are Python, whose remains Blender's module does not survive, and
where something else of Python's, such as a function of a property, could outlive the end."""

import subprocess
import sys
from pathlib import Path

import bpy
import pytest
from tiers import mostly_slow

ROOT = Path(__file__).resolve().parents[2]
EXPRESSIONS = ("round(frame, 1) / 12 - 1", "[0, frame / 12][1] - 1", "noise.random() * 0 - 1")
USE = """
import sys
sys.path.insert(0, {root!r})

def use(path):
    import bpy
    from angen_addon.process.standalone import load_extension
    load_extension().register()
    bpy.ops.wm.open_mainfile(filepath=path)
    bpy.context.scene.frame_set(5)
    assert bpy.data.objects["wall"].location.x != 9
"""
WORKER = """
if __name__ == "__main__":
    import multiprocessing
    worker = multiprocessing.get_context("spawn").Process(target=use, args=(sys.argv[1],))
    worker.start()
    worker.join()
    sys.exit(worker.exitcode)
"""

WITH_EXTENSION = """
import sys
sys.path.insert(0, {root!r})
import bpy
from angen_addon.process.standalone import load_extension
extension = load_extension()
extension.register()
scene = bpy.context.scene
thing = bpy.context.object
"""
SIMULATED = """
thing.angen_sensor.kind = {kind!r}
scene.frame_end = 3
assert bpy.ops.angen.simulate() == {{"FINISHED"}}
"""
WAYS = {
    "nothing": "",
    "switched off": "extension.unregister()",
    "off and on": "extension.unregister()\nextension.register()",
    "light": SIMULATED.format(kind="LIGHT"),
    "rigid bodies": "bpy.ops.rigidbody.object_add()" + SIMULATED.format(kind="PRESSURE"),
    "undo": SIMULATED.format(kind="PIR")
    + "bpy.ops.ed.undo_push()\nthing.location.x = 2\nbpy.ops.ed.undo_push()\nbpy.ops.ed.undo()",
    "held": "held = [bpy, thing, thing.angen_sensor, type(scene.angen_coverage)]",
}


@pytest.fixture
def driven(world, tmp_path):
    """A wall that drivers move, before a switch."""
    wall, other = world.wall(0.02), world.wall(90.0, "other")
    for index, expression in enumerate(EXPRESSIONS):
        curve = (other if index else wall).driver_add("location", index)
        curve.driver.type = "SCRIPTED"
        curve.driver.expression = expression
    world.scene.frame_end = 24
    world.switch()
    path = tmp_path / "driven.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


def run(*arguments, cwd=ROOT):
    done = subprocess.run(
        [sys.executable, *map(str, arguments)], cwd=cwd, capture_output=True, text=True, timeout=120
    )
    return done.returncode, done.stdout, done.stderr


def test_the_command_line_ends_and_leaves_no_folder_behind(driven, tmp_path, monkeypatch):
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setenv("TMPDIR", str(folder))
    status, out, err = run("-m", "angen_addon", "simulate", driven)
    assert status == 0, err
    assert [row.split(",")[1] for row in out.splitlines()[1:]] == ["1", "6", "19"]
    assert "memory" not in err
    assert list(folder.iterdir()) == []
    status, _, err = run("-m", "angen_addon", "simulate", driven, "--sensor", "nobody")
    assert status == 2, err


@pytest.mark.slow
@pytest.mark.parametrize(
    ("end", "status"),
    mostly_slow([("sys.exit(3)", 3), ("", 0), ("raise ValueError('mine')", 1)], ("sys.exit(3)", 3)),
)
def test_a_script_ends_with_its_own_status(driven, tmp_path, end, status):
    script = tmp_path / "script.py"
    script.write_text(f"{USE.format(root=str(ROOT))}\nuse(sys.argv[1])\n{end}\n")
    found, _, err = run(script, driven, cwd=tmp_path)
    assert found == status, err
    assert ("mine" in err) is (status == 1)


@pytest.mark.parametrize("way", mostly_slow(WAYS, "off and on"))
def test_a_script_ends_after(way, tmp_path):
    script = tmp_path / "script.py"
    script.write_text(f"{WITH_EXTENSION.format(root=str(ROOT))}\n{WAYS[way]}\nsys.exit(3)\n")
    status, out, err = run(script, cwd=tmp_path)
    assert status == 3, out + err
    assert "memory" not in out + err


@pytest.mark.slow
def test_a_worker_process_ends_as_it_should(driven, tmp_path):
    script = tmp_path / "worker.py"
    script.write_text(USE.format(root=str(ROOT)) + WORKER)
    status, _, err = run(script, driven, cwd=tmp_path)
    assert status == 0, err


@pytest.mark.slow
def test_a_test_session_ends_as_it_should(driven, tmp_path):
    (tmp_path / "test_it.py").write_text(
        f"{USE.format(root=str(ROOT))}\ndef test_it():\n    use({str(driven)!r})\n"
    )
    arguments = ("-m", "pytest", "-q", "-p", "no:cacheprovider", "test_it.py")
    status, out, err = run(*arguments, cwd=tmp_path)
    assert status == 0, out + err
    assert "1 passed" in out


@pytest.mark.skipif(bpy.app.version >= (5, 0), reason="sample blends are built with Blender 4.2")
@pytest.mark.parametrize("name", mostly_slow(["pressure", "light", "light_control"], "pressure"))
def test_sample_blends_are_built_with_status_zero(tmp_path, name):
    """`make sample` stops at the first script that ends in a crash."""
    script, out = ROOT / "sample_blends" / f"build_{name}.py", tmp_path / f"{name}.blend"
    done = subprocess.run([sys.executable, str(script), "--out", str(out)], check=False)
    assert done.returncode == 0
    assert out.exists()
