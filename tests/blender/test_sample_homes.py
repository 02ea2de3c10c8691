# SPDX-License-Identifier: GPL-3.0-or-later
"""The sample homes as their scripts build them: every marked place can be reached.

Also the script that furnishes homes of other people.
"""

import subprocess
import sys
from datetime import date
from pathlib import Path

import bpy
import numpy as np
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.process.standalone import load_extension
from bl_ext.user_default.angen_sensors.residents.acting import act
from bl_ext.user_default.angen_sensors.residents.acting.unreached_places import unreached
from bl_ext.user_default.angen_sensors.residents.blender.places import read_places
from bl_ext.user_default.angen_sensors.residents.body import skeleton
from bl_ext.user_default.angen_sensors.residents.routine.file import read
from bl_ext.user_default.angen_sensors.residents.routine.timetable import Draws, timetable

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def builders(empty_scene, monkeypatch):
    """Return the scripts' modules, which import the extension under its plain name too."""
    monkeypatch.syspath_prepend(str(ROOT / "sample_blends"))
    load_extension()
    import build_angen
    import build_atelier

    def angen():
        build_angen.build()
        from angen_home import marks

        marks.add_marks()

    yield {"angen": angen, "atelier": build_atelier.build}
    for name in [name for name in sys.modules if name.startswith(("build_a", "angen_home"))]:
        del sys.modules[name]


# Its rooms, sliding doors, resting places, and week.
ANGEN = (
    "angen", 7,
    {
        "Curtain north", "Curtain south", *(f"Kitchen drawer {n}" for n in range(1, 4)),
        "TV bench drawer left", "TV bench drawer right",
    },
    {
        "Fridge door", *(f"Cupboard shutter {n}" for n in range(1, 6)), "Hall cabinet door left",
        *(f"Base cupboard door {n}" for n in range(1, 4)), "Washbasin cupboard door right",
    },
    {"Bed", "Sofa east", "Sofa west"}, "week.toml",
)  # fmt: skip
ATELIER = (
    "atelier", 5,
    {"Bath door", "Terrace door", "Chest drawer", "Curtain east", "Curtain west"},
    {"Fridge door", "Wardrobe door left", *(f"Cupboard door {n}" for n in range(1, 5))},
    {"Bed of Karin", "Bed of Olle", "Sofa north", "Sofa south"}, "atelier_week.toml",
)  # fmt: skip


def _from_free_floor(places, point):
    """Return the distance from a point to the nearest free floor, m."""
    floor = places.storeys[0].floor
    free = floor.low + (np.argwhere(floor.free) + 0.5) * floor.size
    return float(np.linalg.norm(free - point[:2], axis=1).min())


def reached(rooms, sliding, cupboards, rests):
    """Return the places of the open home, and assert that each can be reached."""
    bpy.context.view_layer.update()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    found = read_places(bpy.context.scene, depsgraph)
    assert found.problems == ()
    lost = unreached(found)
    assert [one.place.name for one in lost] == []
    assert len(found.entrances) == len(found.storeys) == 1
    assert len(set(found.storeys[0].rooms)) == rooms + 1
    assert {door.name for door in found.doors.values() if door.slides} == sliding
    # Cupboards open into the room.
    for name in cupboards:
        door = found.doors[name]
        shut, opened = (
            _from_free_floor(found, door.handle_at(w)) for w in (door.closed, door.open)
        )
        assert opened < shut + 0.1, name
    assert rests <= {p.name for p in found.places.values() if p.use in ("SIT", "LIE")}
    # The toilet and other seats are where the seat is, wherever the home stands.
    seat = found.places["Toilet"]
    assert seat.height == pytest.approx(0.42, abs=0.02)
    assert np.linalg.norm(seat.target[:2] - seat.at[:2]) == pytest.approx(0.57, abs=0.1)
    return found


@pytest.mark.slow
def test_every_place_of_the_sample_home_is_reached_as_it_ships(empty_scene):
    home, *expected, _ = ANGEN
    bpy.ops.wm.open_mainfile(filepath=str(ROOT / "sample_blends" / f"{home}.blend"), load_ui=False)
    bpy.context.scene.angen_live = False
    reached(*expected)


def test_the_sample_home_ships_with_a_recording_that_is_fresh(tmp_path, empty_scene):
    bpy.ops.wm.open_mainfile(filepath=str(ROOT / "sample_blends" / "angen.blend"), load_ui=False)
    events = tmp_path / "events.csv"
    assert bpy.ops.angen.export_events(filepath=str(events)) == {"FINISHED"}
    assert events.read_text(encoding="utf-8").count("\n") > 400


@pytest.mark.slow
@pytest.mark.parametrize(
    ("home", "rooms", "sliding", "cupboards", "rests", "week"), [ANGEN, ATELIER]
)
def test_every_place_is_reached_and_a_day_lived(
    builders, home, rooms, sliding, cupboards, rests, week
):
    builders[home]()
    found = reached(rooms, sliding, cupboards, rests)
    _live(found, (ROOT / "sample_blends" / week).read_text(encoding="utf-8"))


def _live(found, text):
    """Act the second day of the home's own week: as busy as real homes, and complete."""
    routine = read(text, "week.toml")
    segments = timetable(routine, date(2026, 3, 2), 2, 1)
    bodies = {
        name: skeleton.CAT if name == "missan" else skeleton.OLDER_ADULT for name in routine.persons
    }
    draws = Draws(1, date(2026, 3, 2))
    acted = act(segments, routine, found, bodies, draws, 1)
    for name, body in acted.bodies.items():
        done = [one for one in acted.activities if one.person == name]
        moving = np.clip(body.moving(), 0.0, 86_400.0)
        share = float((moving[:, 1] - moving[:, 0]).sum()) / 86_400.0
        low, high = (0.005, 0.04) if bodies[name].is_cat else (0.03, 0.13)
        assert low < share < high, name
        assert (15 if bodies[name].is_cat else 29) <= len(done) <= 91, name
        assert {one.place for one in done} <= {"", *found.places}
    # Residents shut again what they open.
    for name, swings in acted.swings.items():
        assert swings[-1].after == found.doors[name].closed, name


# The script that adds a person and sensors to homes of other people, on a simple home


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
