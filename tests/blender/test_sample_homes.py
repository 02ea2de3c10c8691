# SPDX-License-Identifier: GPL-3.0-or-later
"""Both sample homes as their scripts build them: each place that is marked can be reached."""

import sys
from datetime import date
from pathlib import Path

import bpy
import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def builders(empty_scene, addon_part, monkeypatch):
    """The scripts' modules, which need the extension under its plain name too."""
    monkeypatch.syspath_prepend(str(ROOT / "sample_blends"))
    addon_part("angen_addon.process.standalone").load_extension()
    import build_angen
    import build_atelier

    def angen():
        build_angen.build()
        from angen_home import marks

        marks.add_marks()

    yield {"angen": angen, "atelier": build_atelier.build}
    for name in [name for name in sys.modules if name.startswith(("build_a", "angen_home"))]:
        del sys.modules[name]


# Its rooms, what slides, where one rests, and its week.
ANGEN = (
    "angen", 7, {"Curtain north", "Curtain south"}, {"Bed", "Sofa east", "Sofa west"}, "week.toml",
)  # fmt: skip
ATELIER = (
    "atelier", 5,
    {"Bath door", "Terrace door", "Chest drawer", "Curtain east", "Curtain west"},
    {"Bed of Karin", "Bed of Olle", "Sofa north", "Sofa south"}, "atelier_week.toml",
)  # fmt: skip


def reached(addon_part, rooms, sliding, rests):
    """The places of the open home, each of which can be reached."""
    bpy.context.view_layer.update()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    found = addon_part("residents.blender.places").read_places(bpy.context.scene, depsgraph)
    assert found.problems == ()
    lost = addon_part("residents.acting.reach").unreached(found)
    assert [one.place.name for one in lost] == []
    assert len(found.entrances) == len(found.storeys) == 1
    assert len(set(found.storeys[0].rooms)) == rooms + 1
    assert {door.name for door in found.doors.values() if door.slides} == sliding
    assert rests <= {p.name for p in found.places.values() if p.use in ("SIT", "LIE")}
    # The toilet and its like are where the seat is, wherever the home stands.
    seat = found.places["Toilet"]
    assert seat.height == pytest.approx(0.42, abs=0.02)
    assert np.linalg.norm(seat.target[:2] - seat.at[:2]) == pytest.approx(0.57, abs=0.1)
    return found


@pytest.mark.slow
def test_every_place_of_the_sample_home_is_reached_as_it_ships(addon_part, empty_scene):
    home, *expected, _ = ANGEN
    bpy.ops.wm.open_mainfile(filepath=str(ROOT / "sample_blends" / f"{home}.blend"), load_ui=False)
    bpy.context.scene.angen_live = False
    reached(addon_part, *expected)


def test_the_sample_home_ships_with_a_recording_that_is_fresh(tmp_path, empty_scene):
    bpy.ops.wm.open_mainfile(filepath=str(ROOT / "sample_blends" / "angen.blend"), load_ui=False)
    events = tmp_path / "events.csv"
    assert bpy.ops.angen.export_events(filepath=str(events)) == {"FINISHED"}
    assert events.read_text(encoding="utf-8").count("\n") > 400


@pytest.mark.slow
@pytest.mark.parametrize(("home", "rooms", "sliding", "rests", "week"), [ANGEN, ATELIER])
def test_every_place_is_reached_and_a_day_lived(
    builders, addon_part, home, rooms, sliding, rests, week
):
    builders[home]()
    found = reached(addon_part, rooms, sliding, rests)
    _live(addon_part, found, (ROOT / "sample_blends" / week).read_text(encoding="utf-8"))


def _live(addon_part, found, text):
    """The second day of the home's own week: as busy as real homes are, and all of it acted."""
    build = addon_part("residents.body.skeleton")
    routine = addon_part("residents.routine.file").read(text, "week.toml")
    segments = addon_part("residents.routine.timetable").timetable(routine, date(2026, 3, 2), 2, 1)
    bodies = {
        name: build.CAT if name == "missan" else build.OLDER_ADULT for name in routine.persons
    }
    draws = addon_part("residents.routine.timetable").Draws(1, date(2026, 3, 2))
    act = addon_part("residents.acting").act
    acted = act(segments, routine, found, bodies, draws, 1)
    for name, body in acted.bodies.items():
        done = [one for one in acted.activities if one.person == name]
        moving = np.clip(body.moving(), 0.0, 86_400.0)
        share = float((moving[:, 1] - moving[:, 0]).sum()) / 86_400.0
        low, high = (0.005, 0.04) if bodies[name].is_cat else (0.03, 0.13)
        assert low < share < high, name
        assert (15 if bodies[name].is_cat else 29) <= len(done) <= 91, name
        assert {one.place for one in done} <= {"", *found.places}
    # What a hand opens it shuts again.
    for name, swings in acted.swings.items():
        assert swings[-1].after == found.doors[name].closed, name
