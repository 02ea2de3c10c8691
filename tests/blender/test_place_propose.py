# SPDX-License-Identifier: GPL-3.0-or-later
"""Coverage maps and proposals in the scene, by operators and on the command line."""

import csv
import math
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.commands.command_line import run_command as run
from bl_ext.user_default.angen_sensors.angen_addon.coverage import proposal as module
from bl_ext.user_default.angen_sensors.angen_addon.coverage import shown
from bl_ext.user_default.angen_sensors.angen_addon.scene.sensors import all_sensors
from bl_ext.user_default.angen_sensors.sensor_logic.coverage.motions import MOTIONS
from bl_ext.user_default.angen_sensors.sensor_logic.progress import Enough as enough
from bl_ext.user_default.angen_sensors.sensor_logic.progress import finished
from panel_layout import drawn
from recorded_home import named, save_and_load

ops = bpy.ops.angen
CELL = 0.5


@pytest.fixture
def flat(world: Any) -> Any:
    """Add a room of 5 m by 4 m with a ceiling, a tall shelf in the middle, and a detector."""
    world.hall(5.0, 4.0, 2.5)
    world.box((0.3, 2.4, 2.2), (2.5, 2.0, 1.1), "shelf")
    pir = world.sensor("PIR", "pir", update_rate=10.0, rays=24, vertical_step=0.4, range_max=6.0)
    pir.location = (0.05, 0.3, 2.2)
    pir.rotation_euler = (math.pi / 2, 0.0, -math.pi / 2)
    pir["room"] = "den"
    world.bpy.context.view_layer.objects.active = pir
    world.scene.angen_coverage.cell = CELL
    return world


@pytest.fixture
def search(flat: Any) -> Any:
    """Return the generator of a proposal."""
    motion = MOTIONS["STEP"]

    def make(count: int, cell: float = CELL, **wish: Any) -> Any:
        pattern = shown.pattern(flat.sensors()[0], "")
        asked = module.Wish(count, *pattern, **{"spacing": 1.0, **wish})
        return module.propose(flat.update(), flat.sensors(), asked, motion, cell)

    return make


@pytest.fixture
def proposal(search: Any) -> Any:
    return lambda *asked, **wish: finished(search(*asked, **wish))


def test_a_map_takes_the_place_of_the_one_before(flat: Any) -> None:
    assert ops.coverage() == {"FINISHED"}
    (first,) = [o for o in flat.scene.objects if o.type == "MESH" and "angen_coverage" in o]
    assert first.angen_ignored and first.hide_render
    assert first.users_collection[0].name == "Coverage"
    assert ops.coverage() == {"FINISHED"}
    (second,) = [o for o in flat.scene.objects if o.type == "MESH" and "angen_coverage" in o]
    assert second.name == "Coverage step" and len(flat.scene.collection.children) == 1
    mesh = second.data
    colours = mesh.color_attributes["Coverage"]
    assert len(colours.data) == 4 * len(mesh.polygons) == len(mesh.vertices)
    assert mesh.attributes["sensors"].domain == mesh.attributes["noticed"].domain == "FACE"
    assert len(mesh.materials) == 5
    assert ops.coverage_clear() == {"FINISHED"}
    assert not len(flat.scene.collection.children)
    assert not [mesh for mesh in bpy.data.meshes if mesh.name.startswith("Coverage")]


def test_a_proposal_is_the_best_of_all_pairs_or_says_how_far(proposal: Any) -> None:
    found = proposal(1)
    assert found.choice.assured == 1.0, "of one detector the best is known"
    two = proposal(2)
    assert two.choice.covered >= found.choice.covered
    assert two.choice.covered <= two.choice.bound <= len(two.map.cells)
    assert two.map.count.astype(bool).sum() == two.choice.covered
    assert two.map.total().share > 0.95, "one on each side of the shelf"


def test_places_are_on_walls_and_look_into_the_room(proposal: Any) -> None:
    for candidate in proposal(2).chosen:
        x, y, z = candidate.pose.origin
        assert z == pytest.approx(2.3, abs=1e-4)
        off = min(x, 5.0 - x, y, 4.0 - y)
        assert off == pytest.approx(0.03, abs=1e-4), "off a wall, not off the shelf"
        look = -candidate.pose.axes[:, 2]
        ahead = candidate.pose.origin + 0.3 * look
        assert 0 < ahead[0] < 5 and 0 < ahead[1] < 4
        assert np.linalg.det(candidate.pose.axes) == pytest.approx(1.0)
        assert candidate.pose.axes[:, 1] == pytest.approx([0, 0, 1])


def test_ceiling_places_look_down(proposal: Any) -> None:
    for candidate in proposal(2, mounting="CEILING").chosen:
        assert candidate.on == "ceiling"
        assert candidate.pose.origin[2] == pytest.approx(2.47, abs=1e-4)
        assert -candidate.pose.axes[:, 2] == pytest.approx([0, 0, -1])


def test_the_same_seed_proposes_the_same(proposal: Any) -> None:
    one, two = proposal(2, seed=3), proposal(2, seed=3)
    assert one.choice == two.choice
    for a, b in zip(one.chosen, two.chosen, strict=True):
        assert (a.pose.origin == b.pose.origin).all()


def test_beside_those_there_only_the_rest_counts(proposal: Any, flat: Any) -> None:
    alone, beside = proposal(1), proposal(1, beside=True)
    assert beside.before > 0
    assert beside.choice.covered < alone.choice.covered


def test_accepting_makes_sensors_of_the_proposal(flat: Any) -> None:
    settings = flat.scene.angen_coverage
    settings.count, settings.cell = 2, CELL
    assert ops.place_propose() == {"FINISHED"}
    ghosts = [o for o in flat.scene.objects if o.get("angen_coverage") == "PROPOSAL"]
    assert len(ghosts) == 2 and all(g.type == "EMPTY" for g in ghosts)
    assert all(g.select_get() and g.show_in_front for g in ghosts), "they stand out"
    assert len(flat.sensors()) == 1, "not before they are accepted"
    places = sorted(tuple(round(v, 4) for v in g.matrix_world.translation) for g in ghosts)
    assert ops.place_propose() == {"FINISHED"}, "again: replaced, not doubled"
    assert ops.place_accept() == {"FINISHED"}
    made = [s for s in flat.sensors() if s.name != "pir"]
    assert len(made) == 2 and {s.room for s in made} == {"den"}
    found = sorted(tuple(round(v, 4) for v in s.object.matrix_world.translation) for s in made)
    assert found == places
    assert all(s.settings.pir.rays == 24 and s.settings.pir.range_max == 6.0 for s in made)
    assert not [o for o in flat.scene.objects if o.get("angen_coverage") == "PROPOSAL"]
    assert not ops.place_accept.poll()


def test_polls_say_what_to_do(world: Any) -> None:
    assert not ops.coverage.poll()
    with pytest.raises(RuntimeError, match="Add a motion detector first"):
        ops.coverage()
    with pytest.raises(RuntimeError, match="no room is known"):
        ops.place_propose()


# Fresh and stale maps


def _map(world: Any) -> Any:
    """Return the shown map."""
    world.update()
    (found,) = [
        o
        for o in world.scene.objects
        if shown.is_map(o) and o.visible_get() and not o.hide_viewport
    ]
    return found


def _panel() -> str:
    return drawn("ANGEN_PT_coverage").text


CHANGES = {
    "detector moved": (lambda w: setattr(named("pir"), "location", (2, 0.3, 2.2)), "'pir'"),
    "parameter": (lambda w: setattr(named("pir").angen_sensor.pir, "range_max", 2.0), "'pir'"),
    "off": (lambda w: setattr(named("pir").angen_sensor, "enabled", False), "'pir'"),
    "furniture": (lambda w: setattr(named("shelf"), "location", (1, 1, 1.1)), "'shelf'"),
    "new box": (lambda w: w.box((1, 1, 1), (1, 1, 0.5), "chest"), "'chest' (new)"),
    "hidden": (lambda w: named("shelf").hide_set(True), "which objects are shown"),
    "setting": (lambda w: setattr(w.scene.angen_coverage, "motion", "CAT"), "Motion"),
}


@pytest.mark.parametrize("name", CHANGES)
def test_a_map_says_what_has_changed_since(flat: Any, name: str) -> None:
    assert ops.coverage() == {"FINISHED"}
    flat.update()
    assert shown.why_stale(flat.scene) == "" and _map(flat).display_type == "TEXTURED"
    assert "stale" not in _panel()
    change, words = CHANGES[name]
    change(flat)
    flat.update()
    assert words in shown.why_stale(flat.scene)
    assert "stale" in _panel() and words.split("'")[0] in _panel()
    assert name == "setting" or _map(flat).display_type == "WIRE"
    assert ops.coverage.poll() is (name != "off")
    if name != "off":
        ops.coverage()
        assert shown.why_stale(flat.scene) == "" and "stale" not in _panel()


def test_what_no_map_depends_on_leaves_it_fresh(flat: Any) -> None:
    lamp = flat.sensor("LIGHT", "lux")
    ops.coverage()
    flat.scene.angen_seed += 1
    flat.scene.frame_set(7)
    lamp.location = (1.0, 1.0, 1.0)
    lamp.angen_sensor.light.threshold = 7.0
    flat.sensor("PRESSURE", "mat")
    flat.update()
    assert shown.why_stale(flat.scene) == ""
    assert "frame 1" in _panel(), "a map is of the frame at which it was made"


def test_a_saved_map_is_stale_or_fresh_as_it_was(flat: Any, tmp_path: Path) -> None:
    ops.coverage()
    save_and_load(tmp_path / "home.blend")
    assert shown.why_stale(bpy.context.scene) == ""
    named("pir").location.x += 2.0
    save_and_load(tmp_path / "home.blend")
    assert shown.why_stale(bpy.context.scene) == "changed since: 'pir'"


def test_undo_makes_a_map_fresh_again(flat: Any) -> None:
    bpy.ops.ed.undo_push(message="before")
    ops.coverage()
    bpy.ops.ed.undo_push(message="map")
    named("pir").location.x += 2.0
    bpy.ops.ed.undo_push(message="move")
    flat.update()
    assert shown.why_stale(bpy.context.scene)
    bpy.ops.ed.undo()
    assert shown.why_stale(bpy.context.scene) == ""
    bpy.ops.ed.redo()
    assert shown.why_stale(bpy.context.scene)


def test_discarding_a_proposal_brings_back_the_map_before(flat: Any) -> None:
    ops.coverage()
    before = _map(flat).name, len(_map(flat).data.polygons), shown.summary(flat.scene)
    for count in (2, 1):
        flat.scene.angen_coverage.count = count
        ops.place_propose()
    assert "Only proposed places count" in _panel()
    assert shown.summary(flat.scene)["rooms"] != before[2]["rooms"]
    ops.place_discard()
    assert (_map(flat).name, len(_map(flat).data.polygons), shown.summary(flat.scene)) == before
    assert "proposed" not in _panel() and shown.why_stale(flat.scene) == ""


def test_a_discarded_proposal_leaves_no_map_where_there_was_none(flat: Any) -> None:
    ops.place_propose()
    ops.place_discard()
    assert shown.summary(flat.scene) is None
    assert not [o for o in flat.scene.objects if shown.is_map(o)]


def test_an_accepted_map_is_stale_until_it_is_mapped_again(flat: Any) -> None:
    """The map lacks the other detectors, and places may have been moved or left out."""
    ops.coverage()
    ops.place_propose()
    ops.place_accept()
    flat.update()
    assert "new" in shown.why_stale(flat.scene) and "proposed" not in _panel()
    assert [o for o in flat.scene.objects if shown.is_map(o)] == [_map(flat)]
    ops.coverage()
    assert shown.why_stale(flat.scene) == ""


# The command line


@pytest.fixture
def command(flat: Any, tmp_path: Path, capsys: Any) -> Any:
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "flat.blend"))

    def call(*arguments: Any) -> tuple[int, str, str]:
        capsys.readouterr()
        status = run([str(a) for a in arguments])
        told = capsys.readouterr()
        return status, told.out, told.err

    return call


def test_coverage_writes_table_csv_and_picture(command: Any, tmp_path: Path) -> None:
    sheet, drawn = tmp_path / "map.csv", tmp_path / "map.svg"
    asked = ("coverage", "--cell", CELL, "--csv", sheet, "--picture", drawn, "--quiet")
    status, out, _ = command(*asked)
    assert status == 0 and "den" in out
    rows = list(csv.DictReader(sheet.open()))
    assert {row["room"] for row in rows} == {"den"} and "pir" in rows[0]
    assert drawn.read_text().startswith("<?xml") and "Coverage of flat" in drawn.read_text()
    first = sheet.read_text()
    command(*asked)
    assert sheet.read_text() == first, "the same bytes again"


def test_place_saves_a_file_with_the_sensors(command: Any, tmp_path: Path) -> None:
    saved, sheet = tmp_path / "placed.blend", tmp_path / "places.csv"
    status, out, _ = command(
        "place", "--room", "den", "--count", 2, "--cell", CELL, "--like", "pir",
        "--save", saved, "--csv", sheet,
    )  # fmt: skip
    assert status == 0 and "of the best" in out
    rows = list(csv.DictReader(sheet.open()))
    assert len(rows) == 2
    bpy.ops.wm.open_mainfile(filepath=str(saved))
    sensors = all_sensors(bpy.context.view_layer)
    placed = [s for s in sensors if s.name.startswith("PIR den")]
    assert len(placed) == 2
    assert all(s.settings.pir.rays == 24 for s in placed)


@pytest.mark.parametrize(
    "arguments, status, told",
    [
        (("coverage", "--cell", "0"), 2, "length above 0"),
        (("coverage", "--cell", "9"), 1, "from 0.05 m to 2 m"),
        (("coverage", "--sensor", "nobody"), 2, "no sensor is called 'nobody'"),
        (("coverage", "--room", "cellar"), 1, "the rooms are den"),
        (("coverage", "--picture", "map.png"), 2, "must end in .svg"),
        (("coverage", "--motion", "DOG"), 2, "invalid choice"),
        (("coverage", "--height", "4"), 1, "above 0 and below"),
        (("place", "--count", "0"), 2, "1 or more"),
        (("place", "--preset", "NONE"), 1, "no preset"),
        (("place", "--mounting-height", "9"), 1, "set another height"),
        (("coverage", "--csv", "/nowhere/x.csv"), 2, "does not exist"),
    ],
)
def test_bad_input_is_told(command: Any, arguments: Any, status: int, told: str) -> None:
    found, _, err = command(*arguments)
    assert found == status and told in err


def test_enough_keeps_the_best_so_far_and_its_bound(search: Any) -> None:
    stages: list[Any] = []

    def noted() -> Any:
        work = search(2)
        while True:
            try:
                stages.append(next(work))
            except StopIteration as end:
                return end.value

    whole = noted()
    shares = [stage.share for stage in stages]
    assert shares == sorted(shares) and shares[-1] <= 1.0
    first = next(n for n, s in enumerate(stages) if "computed exactly" in s.text)
    assert [s.found for s in stages] == [n >= first for n in range(len(stages))]
    for number in (1, first - 1):
        run = search(2)
        for _ in range(number):
            next(run)
        with pytest.raises(enough):
            run.throw(enough)
    run = search(2)
    for _ in range(first + 1):
        next(run)
    with pytest.raises(StopIteration) as ended:
        run.throw(enough)
    early = ended.value.value
    assert len(early.chosen) == len(early.names) == 1
    assert early.map.count.astype(bool).sum() == early.choice.covered <= whole.choice.covered
    assert whole.choice.covered <= early.choice.bound <= len(early.map.cells)
    assert "% of the best" in early.summary()
