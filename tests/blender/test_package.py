# SPDX-License-Identifier: GPL-3.0-or-later
"""`import angen_sensors` as an installed package, in separate processes."""

from __future__ import annotations

import csv
import os
import re
import subprocess
import sys
from pathlib import Path

import bpy
import numpy as np
import pytest

from dev import link_folder

ROOT = Path(__file__).resolve().parent.parent.parent


@pytest.fixture
def home(world, tmp_path) -> Path:
    """Add a wall a metre ahead of a detector, which moves from frame 12 on, and a lit lamp."""
    world.sensor("PIR", "PIR hall", update_rate=24.0, sweep="ALL")
    wall = world.wall(1.0)
    for frame, z in ((1, -1.0), (11, -1.0), (12, -1.5), (48, -3.0)):
        wall.location.z = z
        wall.keyframe_insert("location", frame=frame)
    path = tmp_path / "home.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


@pytest.fixture
def run(tmp_path):
    """Run a script beside the home with the package importable; return its output."""
    packages = tmp_path / "packages"
    packages.mkdir()
    link_folder(packages / "angen_sensors", ROOT)

    def run_script(script: str, status: int = 0) -> str:
        path = tmp_path / "script.py"
        path.write_text(script)
        done = subprocess.run(
            [sys.executable, path],
            cwd=tmp_path,
            env=os.environ | {"PYTHONPATH": str(packages)},
            capture_output=True,
            text=True,
        )
        assert done.returncode == status, done.stderr
        return done.stdout if status == 0 else done.stderr

    return run_script


def test_the_examples_of_the_docs_run_as_they_stand(home, run, tmp_path) -> None:
    text = (ROOT / "docs" / "package.md").read_text(encoding="utf-8")
    out = run("\n".join(re.findall(r"```python\n(.*?)```", text, re.DOTALL)))
    assert "PIR hall PIR  [0. 0. 0.]" in out
    assert "0.000000 PIR door moved 0" in out and "['PIR door']" in out
    assert (tmp_path / "events.csv").read_text().startswith("time_s,frame,sensor")
    assert (tmp_path / "events.mcap").read_bytes().startswith(b"\x89MCAP0\r\n")
    assert (tmp_path / "with_sensor.blend").exists()


def test_events_are_those_of_the_command_line(home, run, command, tmp_path) -> None:
    told = command("simulate", "--quiet")[1]
    out = run(
        "import angen_sensors\n"
        "found = angen_sensors.open('home.blend').simulate()\n"
        "found.write('same.csv')\n"
        "for row in found.events: print(','.join(row))\n"
    )
    assert out.splitlines() == told.splitlines()[1:]
    assert any(row.endswith("PIR hall,PIR,moved,1") for row in out.splitlines())
    assert (tmp_path / "same.csv").read_bytes().decode().splitlines() == told.splitlines()


@pytest.mark.slow
def test_many_homes_and_runs_in_one_process_give_the_same(home, run) -> None:
    out = run(
        "import angen_sensors\n"
        "found = set()\n"
        "for _ in range(3):\n"
        "    with angen_sensors.open('home.blend') as home:\n"
        "        for _ in range(2):\n"
        "            found.add(tuple(home.simulate().events))\n"
        "print(len(found), len(found.pop()) > 2)\n"
    )
    assert out.split() == ["1", "True"]


@pytest.mark.slow
def test_it_works_in_a_thread_and_in_spawned_workers(home, run) -> None:
    out = run(
        "import multiprocessing, os, threading\n"
        "import angen_sensors\n"
        "def work(_=None):\n"
        "    return angen_sensors.open('home.blend').simulate()\n"
        "if __name__ == '__main__':\n"
        "    with multiprocessing.get_context('spawn').Pool(2) as pool:\n"
        "        found = [r.events for r in pool.map(work, range(3))]\n"
        "    thread = threading.Thread(target=lambda: found.append(work().events))\n"
        "    thread.start(); thread.join()\n"
        "    print(len(found), all(f == found[0] for f in found), len(found[0]) > 2, flush=True)\n"
        # Blender's module crashes if another thread than its own ends it.
        "    os._exit(0)\n"
    )
    assert out.split() == ["4", "True", "True"]


def test_samples_are_columns_of_one_length(home, run) -> None:
    out = run(
        "import angen_sensors\n"
        "found = angen_sensors.open('home.blend').simulate().samples('PIR hall')\n"
        "print({len(c) for c in found.values()}, found['moved'].dtype, found['moved'].any())\n"
        "print(found['time_s'][1] * 24, found['frame'][0])\n"
    )
    assert out.splitlines() == ["{48} bool True", "1.0 1.0"]


def test_a_new_sensor_stands_and_looks_as_asked_for_and_is_saved(home, run, tmp_path) -> None:
    run(
        "import angen_sensors\n"
        "home = angen_sensors.open('home.blend')\n"
        "home.add('PIR', name='New', at=(1, 2, 3), look=(0, 1, 0)).range_max = 2.5\n"
        "home.simulate(sensors=['New'])\n"
        "home.save('saved.blend')\n"
    )
    out = run(
        "import angen_sensors\n"
        "new = angen_sensors.open('saved.blend').sensor('New')\n"
        "print(new.pose.round(6).tolist(), new.range_max, new.kind)\n"
    )
    # It faces along its −Z, the home's +Y; its own +Y is up.
    pose = [[1.0, 0.0, 0.0, 1.0], [0.0, 0.0, -1.0, 2.0], [0.0, 1.0, 0.0, 3.0], [0.0, 0.0, 0.0, 1.0]]
    assert out.strip().replace("-0.0,", "0.0,") == f"{pose} 2.5 PIR"


def test_objects_are_set_by_their_names_and_one_sensor_by_its_name_alone(home, run) -> None:
    out = run(
        "import angen_sensors\n"
        "home = angen_sensors.open('home.blend')\n"
        "contact = home.add('CONTACT', 'New')\n"
        "contact.magnet = 'PIR hall'\n"
        "print(contact.magnet.name, contact.parameters['magnet'])\n"
        "contact.magnet = None\n"
        "print(contact.magnet)\n"
        "print({row.sensor for row in home.simulate(sensors='New').events})\n"
    )
    assert out.splitlines() == ["PIR hall PIR hall", "None", "{'New'}"]


def test_lengths_are_metres_whatever_the_unit_scale(world, run, tmp_path) -> None:
    world.scene.unit_settings.scale_length = 0.01
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "home.blend"))
    out = run(
        "import angen_sensors\n"
        "home = angen_sensors.open('home.blend')\n"
        "pir = home.add('PIR', at=(1, 2, 3))\n"
        "pir.range_max = 3.0\n"
        "print(pir.pose[:3, 3].round(4).tolist(), pir.range_max)\n"
    )
    assert out.strip() == "[1.0, 2.0, 3.0] 3.0"


WRONG = [
    ("angen_sensors.open('none.blend')", ["none.blend", "No such file"]),
    ("angen_sensors.open('script.py')", ["script.py is not a blend file"]),
    ("home.sensor('PIR hal')", ["'PIR hal'", "PIR hall"]),
    ("home.add('SONAR')", ["SONAR", "PIR"]),
    ("home.add('PIR', preset='HC')", ["HC", "HC_SR501"]),
    ("home.add('PIR', at=(1, 2))", ["(1, 2)", "metres"]),
    ("home.add('PIR', look=(0, 0, 0))", ["look=(0, 0, 0)"]),
    ("setattr(home.sensor('PIR hall'), 'range_max', -1.0)", ["range_max", "PIR hall"]),
    ("setattr(home.sensor('PIR hall'), 'reach', 1.0)", ["reach", "range_max"]),
    ("setattr(home.sensor('PIR hall'), 'model', 'SONAR')", ["model", "SONAR"]),
    ("setattr(home.sensor('PIR hall'), 'update_rate', 'fast')", ["update_rate"]),
    ("home.apply('script.py')", ["script.py, line 1: not valid JSON at column 1"]),
    ("home.simulate(frames=(5, 1))", ["frames 5 to 1"]),
    ("home.simulate(sensors=['no'])", ["'no'"]),
    ("home.simulate(sensors=[])", ["sensors is empty", "None for all"]),
    ("home.live('plan.toml', sensors=())", ["sensors is empty"]),
    (
        "setattr(home.add('CONTACT', 'New'), 'magnet', 'PIR hal')",
        ["'New': magnet: no object is called 'PIR hal'; did you mean PIR hall?"],
    ),
    (
        "home.mark('PIR hall', 'LAMP', switch='PIR hal')",
        ["'PIR hall': switch: no object is called 'PIR hal'; did you mean PIR hall?"],
    ),
    ("home.simulate().samples('no')", ["'no'", "PIR hall"]),
    ("home.simulate().write('x', format='word')", ["word", "casas"]),
    ("home.simulate().write('none/x')", ["path: the folder none does not exist"]),
    ("home.simulate().write('x', truth='y')", ["give faults too"]),
    ("home.simulate().write('x', faults='no.toml', truth='y')", ["no.toml"]),
    ("(home.close(), home.sensors)", ["home.blend is closed"]),
    ("(angen_sensors.open('home.blend'), home.sensors)", ["one home at a time"]),
]


def test_errors_are_one_clear_line(home, run) -> None:
    """All errors in one process: each leaves the package as before."""
    out = run(
        "import angen_sensors\n"
        f"for line in {[line for line, _ in WRONG]!r}:\n"
        "    home = angen_sensors.open('home.blend')\n"
        "    try:\n        exec(line)\n"
        "    except angen_sensors.AngenError as error:\n        print(error)\n"
    )
    told = out.splitlines()
    assert len(told) == len(WRONG), out
    for text, (line, words) in zip(told, WRONG, strict=True):
        assert all(word in text for word in words), (line, text)


def test_the_home_by_script_of_the_docs_runs_as_it_stands(run, tmp_path) -> None:
    text = (ROOT / "docs" / "home_by_script.md").read_text(encoding="utf-8")
    out = run("\n".join(re.findall(r"```python\n(.*?)```", text, re.DOTALL)))
    assert "Chair SIT studio 0.45" in out and "Bed LIE studio 0.5" in out
    # Anna gets up and walks to the chair.
    assert re.search(r"field='moved'.* value=True.* person='anna'", out)
    assert "anna" in out and (tmp_path / "lived_in.blend").exists()


@pytest.mark.slow
def test_the_frames_for_a_recogniser_have_a_person_in_each_posture(run, tmp_path) -> None:
    script = ROOT / "docs" / "examples" / "array_frames.py"
    run(
        "import runpy, sys\n"
        "sys.argv = ['array_frames.py', 'frames.csv', '--people', '2', '--places', '1']\n"
        f"runpy.run_path({str(script)!r}, run_name='__main__')\n"
    )
    with (tmp_path / "frames.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["posture"] for row in rows] == ["standing", "sitting", "lying"] * 2
    assert [row["person"] for row in rows] == ["person 0"] * 3 + ["person 1"] * 3
    for row in rows:
        frame = np.array(row["frame_c"].split(";"), float)
        assert len(frame) == 256 and row["columns"] == "16"
        assert frame.max() - np.median(frame) > 2.0
    assert len({row["frame_c"] for row in rows}) == 6


@pytest.mark.parametrize(
    ("call", "error"),
    [
        ("home.mark('Sofa', 'SIT')", "the home has no object 'Sofa'"),
        ("home.mark('PIR hal', 'SIT')", "no object 'PIR hal'; did you mean PIR hall?"),
        ("home.mark('PIR hall', 'NAP')", "use 'NAP' is unknown"),
        ("home.mark('PIR hall', 'SIT', angel=1)", "the property 'angel' of a mark is unknown"),
        ("home.add_resident('DOG')", "sort 'DOG' is unknown"),
        ("home.pose('Anna', 'lying', (0, 0, 0))", "no resident is called 'Anna'"),
        ("home.places()", "nothing is marked"),
        ("home.live('none.toml')", "cannot read none.toml"),
        ("home.live('x = 1\\n', between=('9', '8'))", "routine"),
    ],
)
@pytest.mark.slow
def test_what_a_home_cannot_do_is_one_clear_line(home, run, call, error) -> None:
    out = run(
        "import angen_sensors\n"
        "home = angen_sensors.open('home.blend')\n"
        f"try:\n    {call}\n"
        "except angen_sensors.AngenError as error:\n    print(error)\n"
    )
    assert error in out and out.count("\n") == 1


MADE_BY_DATA = """
import warnings
import bpy
import angen_sensors

home = angen_sensors.open("home.blend")

def link(name, data, at):
    obj = bpy.data.objects.new(name, data)
    obj.location = at
    bpy.context.scene.collection.objects.link(obj)
    return obj

def box(name, size, at):
    mesh = bpy.data.meshes.new(name)
    corners = [(x * s[0], y * s[1], z * s[2]) for s in [[c / 2 for c in size]]
               for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    mesh.from_pydata(corners, [], faces)
    return link(name, mesh, at)
"""


def test_sensors_made_by_bpy_data_alone_are_simulated(home, run) -> None:
    out = run(
        MADE_BY_DATA
        + """
tof = link("ToF new", None, (20.0, 0.0, 2.0))
tof.angen_sensor.kind = "DISTANCE"
box("floor", (4, 4, 0.2), (20.0, 0.0, -0.1))
pad = box("Pad new", (0.4, 0.4, 0.01), (21.0, 0.0, 0.005))
pad.angen_sensor.kind = "PRESSURE"
print([s.name for s in home.sensors], home.sensor("ToF new").pose[:3, 3].round(3).tolist())
found = home.simulate(sensors=["*new"])
print(found.sensors, found.samples("ToF new")["distance_m"][0].round(1))
bpy.data.objects.remove(pad)
print(home.simulate(sensors=["*new"]).sensors)
"""
    )
    assert out.splitlines() == [
        "['PIR hall', 'Pad new', 'ToF new'] [20.0, 0.0, 2.0]",
        "['Pad new', 'ToF new'] 2.0",
        "['ToF new']",
    ]


def test_places_made_by_bpy_data_alone_are_read(home, run) -> None:
    out = run(
        MADE_BY_DATA
        + """
box("floor", (6, 6, 0.2), (20.0, 0.0, -0.1))
box("Bed", (2.0, 1.0, 0.5), (20.0, 0.0, 0.25))
home.mark("Bed", "LIE", room="bedroom")
chair = box("Chair", (0.4, 0.4, 0.45), (22.0, 1.0, 0.225))
chair.angen_place.use = "SIT"
print(sorted(home.places()))
"""
    )
    assert out.splitlines()[-1] == "['Bed', 'Chair']"


@pytest.mark.parametrize(
    ("frames", "words"),
    [
        ((-24, 24), "frames -24:24: those before the scene's start, frame 1, are left out"),
        ((24, 60), "frames 24:60: those after the scene's end, frame 48, are simulated too"),
        ((1, 48), ""),
    ],
)
def test_frames_outside_the_scene_are_told(home, run, frames, words) -> None:
    out = run(
        "import warnings, angen_sensors\n"
        "home = angen_sensors.open('home.blend')\n"
        "with warnings.catch_warnings(record=True) as told:\n"
        "    warnings.simplefilter('always')\n"
        f"    found = home.simulate(frames={frames})\n"
        "print(*[w.message for w in told], sep='; ')\n"
        "print(found.samples('PIR hall')['frame'][[0, -1]].tolist())\n"
    )
    first, last = max(frames[0], 1), frames[1]
    assert out.splitlines() == [words, str([float(first), float(last)])]


def test_the_twin_of_a_real_home_has_contacts_that_close(run) -> None:
    layout = ROOT / "docs" / "examples" / "twin" / "sensors.json"
    said = run(
        "import angen_sensors\n"
        f"home = angen_sensors.open({str(ROOT / 'sample_blends' / 'angen.blend')!r})\n"
        f"home.apply({str(layout)!r})\n"
        "names = ['Contact fridge', 'Contact cupboard']\n"
        "found = home.simulate(frames=(1, 1), sensors=names)\n"
        "print([bool(found.samples(name)['open'][0]) for name in names])\n"
    )
    assert said.splitlines()[-1] == "[False, False]"
