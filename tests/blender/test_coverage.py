# SPDX-License-Identifier: GPL-3.0-or-later
"""The coverage map of a motion agrees with the simulation of that motion."""

import math
from importlib import import_module
from typing import Any

import bpy
import numpy as np
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.coverage.maps import cover
from bl_ext.user_default.angen_sensors.sensor_logic.coverage.motions import MOTIONS
from bl_ext.user_default.angen_sensors.sensor_logic.progress import finished
from panel_layout import drawn
from tiers import mostly_slow

ROOM = (4.0, 3.0, 2.5)
FPS, RATE = 20, 10.0
TILTS = 9
# The greatest difference of radius between a cylinder and its mesh of so many sides.
SIDES = 256


@pytest.fixture
def home(world: Any) -> Any:
    """Add a room of 4 m by 3 m with a table, a cupboard, and a detector on the west wall."""
    world.hall(*ROOM)
    world.box((0.8, 0.8, 0.9), (2.0, 2.0, 0.45), "table")
    world.box((0.5, 0.6, 2.2), (3.0, 0.3, 1.1), "cupboard")
    world.scene.render.fps = FPS
    pir = world.sensor("PIR", "pir", update_rate=RATE, range_max=5.0)
    pir.location = (0.05, 1.5, 2.2)
    pir.rotation_euler = (math.pi / 2, 0.0, -math.pi / 2)
    return world


@pytest.fixture
def mapped(home: Any) -> Any:
    """Return the map of a motion in cells of 0.25 m."""

    def make(name: str, size: float = 0.25, **options: Any) -> Any:
        motion = MOTIONS[name]
        sensors = home.sensors()
        return finished(cover(home.update(), sensors, sensors, motion, size, **options))

    return make


def body_of(world: Any, motion: Any) -> Any:
    """Add the body of the motion as a mesh, with its origin on the floor below it."""
    low, high = motion.bottom, motion.top
    if motion.radius:
        ring = [
            (motion.radius * math.cos(a), motion.radius * math.sin(a))
            for a in (2 * math.pi * i / SIDES for i in range(SIDES))
        ]
        points = [(x, y, z) for z in (low, high) for x, y in ring]
        sides = [(i, (i + 1) % SIDES, SIDES + (i + 1) % SIDES, SIDES + i) for i in range(SIDES)]
        faces = [*sides, tuple(range(SIDES))[::-1], tuple(range(SIDES, 2 * SIDES))]
        return world.link("body", world.mesh(points, faces))
    near, far = (-motion.length / 2, motion.length / 2) if motion.walks else (0.0, motion.length)
    body = world.box((far - near, motion.width, high - low), name="body")
    for vertex in body.data.vertices:
        vertex.co.x += (near + far) / 2
        vertex.co.z += (low + high) / 2
    return body


def moves(world: Any, body: Any, motion: Any, at: Any, heading: float, length: float) -> int:
    """Animate the body after a sweep at rest; return the frame by which all tilts saw the end."""
    body.animation_data_clear()
    body.location = at
    body.rotation_euler = (0.0, 0.0, heading)
    begin = 1 + TILTS * FPS / RATE
    end = begin + length / motion.speed * FPS
    if motion.walks:
        there = (at[0] + length * math.cos(heading), at[1] + length * math.sin(heading), at[2])
        world.key(body, "location", {begin: tuple(at), end: there})
    else:
        world.key(body, "rotation_euler", {begin: (0, 0, heading), end: (0, 0, heading + length)})
    return math.ceil(end + 2 * TILTS * FPS / RATE)


def cases(found: Any, count: int) -> list[tuple[int, int, float]]:
    """Return cells, directions and strengths: weakest, about the threshold, and others."""
    cell, direction = np.nonzero(found.cells.lengths > 0.0)
    strength = found.strength[0, cell, direction]
    about = np.argsort(np.abs(strength - 1.0), kind="stable")[:count]
    spread = np.linspace(0, len(cell) - 1, count).astype(int)
    chosen = sorted({*about.tolist(), *spread.tolist(), *np.argsort(strength)[: count // 2]})
    return [(int(cell[i]), int(direction[i]), float(strength[i])) for i in chosen]


@pytest.mark.parametrize(
    "name, sweep",
    mostly_slow(
        [("STEP", "SAWTOOTH"), ("CAT", "SAWTOOTH"), ("ARM", "SAWTOOTH"), ("ARM", "ALL")],
        ("STEP", "SAWTOOTH"),
        ("ARM", "ALL"),
    ),
)
def test_the_map_is_what_the_simulation_says(home: Any, mapped: Any, name: str, sweep: str) -> None:
    home.bpy.data.objects["pir"].angen_sensor.pir.sweep = sweep
    found = mapped(name)
    body = body_of(home, found.motion)
    said = []
    for cell, direction, strength in cases(found, 16):
        if found.motion.radius and abs(strength - 1.0) < 0.01:
            continue
        heading = direction * math.pi / 4
        at, length = found.cells.at[cell].tolist(), float(found.cells.lengths[cell, direction])
        last = moves(home, body, found.motion, at, heading, length)
        recording = home.run(1, last)
        moved = any(home.series(recording, "pir", "moved"))
        said.append(moved)
        assert moved == (strength > 1.0), (at, direction, strength)
    assert len(said) > 16
    if name != "STEP":
        assert any(said) and not all(said), "both are tried"


def test_the_pyroelectric_map_is_what_the_simulation_says(home: Any, mapped: Any) -> None:
    settings = home.bpy.data.objects["pir"].angen_sensor
    settings.pir.model = "PYROELECTRIC"
    settings.update_rate = 20.0
    found = mapped("STEP")
    body = body_of(home, found.motion)
    body.angen_warmth.use_temperature = True
    body.angen_warmth.temperature, body.angen_warmth.emissivity = 29.0, 0.95
    compared = []
    for cell, direction, strength in cases(found, 6):
        at, length = found.cells.at[cell].tolist(), float(found.cells.lengths[cell, direction])
        last = moves(home, body, found.motion, at, direction * math.pi / 4, length)
        recording = home.run(1, last)
        peak = max(abs(value) for value in home.series(recording, "pir", "signal"))
        compared.append((strength, peak))
    assert len(compared) > 8
    for strength, peak in compared:
        assert strength == pytest.approx(peak, rel=0.03, abs=0.02)


def test_cells_are_free_floor_alone(mapped: Any) -> None:
    found = mapped("STEP")
    x, y = found.cells.at[:, 0], found.cells.at[:, 1]
    assert found.cells.at[:, 2] == pytest.approx(0.0, abs=1e-6)
    for x0, y0, x1, y1 in ((1.6, 1.6, 2.4, 2.4), (2.75, 0.0, 3.25, 0.6)):
        apart = np.hypot(
            np.maximum(np.maximum(x0 - x, x - x1), 0), np.maximum(np.maximum(y0 - y, y - y1), 0)
        )
        assert apart.min() >= 0.2 - 1e-6, "a body of 0.2 m stands beside furniture, not recorded"
    assert x.min() >= 0.2 and x.max() <= 3.8 and y.min() >= 0.2 and y.max() <= 2.8
    # All free floor is mapped: the room without its margins and furniture, counted by hand.
    expected = {
        (i, j) for i in range(16) for j in range(12) if _stands(0.125 + 0.25 * i, 0.125 + 0.25 * j)
    }
    assert {
        (round((a - 0.125) / 0.25), round((b - 0.125) / 0.25)) for a, b in zip(x, y, strict=True)
    } == expected


def _stands(x: float, y: float) -> bool:
    """Return whether rays in eight directions are free for 0.2 m."""

    def solid(a: float, b: float) -> bool:
        table = 1.6 < a < 2.4 and 1.6 < b < 2.4
        return table or (2.75 < a < 3.25 and b < 0.6) or not (0 < a < 4 and 0 < b < 3)

    steps = np.linspace(0.0, 0.2, 41)
    return not any(
        solid(x + r * math.cos(k * math.pi / 4), y + r * math.sin(k * math.pi / 4))
        for k in range(8)
        for r in steps
    )


def test_a_box_that_marks_a_room_names_its_cells(home: Any, mapped: Any) -> None:
    mark = home.box((1.5, 3.0, 2.4), (3.25, 1.5, 1.3), "mark")
    mark.angen_ignored = True
    mark["room"] = "alcove"
    home.bpy.data.objects["pir"]["room"] = "den"
    found = mapped("STEP")
    rooms = np.array(found.cells.room)
    assert set(rooms[found.cells.at[:, 0] > 2.5]) == {"alcove"}
    assert set(rooms[found.cells.at[:, 0] < 2.5]) == {"den"}
    only = mapped("STEP", rooms=["alcove"])
    assert only.cells.rooms == ["alcove"] and len(only.cells) == (rooms == "alcove").sum()


def test_a_detector_without_a_room_splits_none(home: Any, mapped: Any) -> None:
    home.bpy.data.objects["pir"].angen_sensor.room = "den"
    other = home.sensor("PIR", "unnamed")
    other.location, other.rotation_euler = (3.9, 1.5, 2.2), (math.pi / 2, 0.0, math.pi / 2)
    assert mapped("STEP").cells.rooms == ["den"]
    home.box((0.1, 3.0, 2.5), (2.5, 1.5, 1.25), "partition")
    found = mapped("STEP").cells
    assert found.rooms == ["den", "no room"], "another room, behind a wall"
    assert found.at[np.array(found.room) == "den"][:, 0].max() < 2.5


def test_units_change_nothing(home: Any, mapped: Any) -> None:
    before = mapped("CAT")
    scene = home.scene
    scene.unit_settings.scale_length = 0.01
    for obj in scene.objects:
        obj.location = obj.location * 100.0
        if obj.type == "MESH":
            for vertex in obj.data.vertices:
                vertex.co = vertex.co * 100.0
    after = mapped("CAT")
    assert after.cells.at == pytest.approx(before.cells.at, abs=1e-5)
    assert (after.covered == before.covered).mean() > 0.995


def test_a_closed_door_hides_what_is_behind_and_an_open_one_shows_it(
    home: Any, mapped: Any
) -> None:
    west = home.bpy.data.objects["west"]
    west.hide_viewport = True
    # A second room to the east of a wall with a doorway.
    east = home.bpy.data.objects["east"]
    east.hide_viewport = True
    home.box((0.1, 0.9, 2.5), (2.9, 1.05, 1.25), "wall one")
    home.box((0.1, 0.6, 2.5), (2.9, 2.7, 1.25), "wall two")
    home.box((0.1, 0.9, 0.4), (2.9, 1.95, 2.3), "lintel")
    home.bpy.data.objects["table"].hide_viewport = True
    home.box((0.1, 3.0, 2.5), (-0.05, 1.5, 1.25), "west wall")
    home.box((0.1, 3.0, 2.5), (4.05, 1.5, 1.25), "east wall")
    door = home.box((0.05, 0.9, 2.1), (2.9, 1.95, 1.05), "door")
    home.box((0.1, 0.61, 2.5), (2.9, 0.3, 1.25), "wall three")
    light = home.sensor("LIGHT", "light")
    light.location = (3.5, 2.0, 2.3)
    light["room"], home.bpy.data.objects["pir"]["room"] = "east", "west"
    # Behind the closed door no motion is noticed, in front of it all are.
    closed = mapped("STEP")
    assert closed.cells.rooms == ["east", "west"]
    shares = {room.name: room.share for room in closed.rooms()}
    assert shares["east"] == 0.0 and shares["west"] > 0.9
    door.hide_viewport = True
    opened = {room.name: room.share for room in mapped("STEP").rooms()}
    assert opened["east"] > 0.2


# A coverage map beside a recording


def test_a_map_of_a_small_room_leaves_a_recording_fresh(world):
    results = import_module("bl_ext.user_default.angen_sensors.angen_addon.recording.results")
    scene = world.scene
    world.hall(3, 2, 2.5)
    world.pir(update_rate=10.0).location = (0.1, 1.0, 1.5)
    world.box((0.4, 0.4, 0.4), (2, 1, 0.2), "Sofa")
    assert bpy.ops.angen.simulate(frame_start=1, frame_end=12) == {"FINISHED"}
    scene.angen_coverage.motion, scene.angen_coverage.cell = "ARM", 0.5
    bpy.ops.angen.coverage()
    world.update()
    assert any(obj.name.startswith("Coverage") for obj in scene.objects)
    assert results.RESULTS.kept(scene).stale == ""
    bpy.ops.ed.undo_push(message="a map")
    scene.objects["Sofa"].location.x += 0.1
    world.update()
    assert "Sofa" in results.RESULTS.kept(scene).stale


# A map in the window


def test_a_fresh_map_has_its_colours_at_once(world):
    scene = world.scene
    world.hall(3, 2, 2.5)
    detector = world.pir(update_rate=10.0)
    detector.location = (0.1, 1.0, 1.5)
    sofa = world.box((0.4, 0.4, 0.4), (2, 1, 0.2), "Sofa")
    scene.angen_coverage.motion, scene.angen_coverage.cell = "ARM", 0.5
    shown = import_module("bl_ext.user_default.angen_sensors.angen_addon.coverage.shown")

    def looks():
        return {obj.display_type for obj in scene.objects if shown.is_map(obj)}

    bpy.ops.angen.coverage()
    assert looks() == {"TEXTURED"}
    sofa.location.x += 0.2
    world.update()
    assert looks() == {"WIRE"} and shown.why_stale(scene)
    bpy.ops.angen.coverage()
    assert looks() == {"TEXTURED"} and not shown.why_stale(scene)
    world.update()
    assert looks() == {"TEXTURED"}
    bpy.ops.angen.place_propose()
    assert looks() == {"TEXTURED"}
    bpy.ops.angen.place_discard()
    assert looks() == {"TEXTURED"}


def test_the_panel_names_the_detectors_and_the_colours(world):
    world.hall(3, 2, 2.5)
    for number in range(5):
        world.pir(f"PIR {number}").location = (0.1, 1.0, 1.5)
    world.scene.angen_coverage.motion, world.scene.angen_coverage.cell = "ARM", 0.5
    bpy.ops.angen.coverage()
    texts = drawn("ANGEN_PT_coverage").labels
    assert any("5 detectors" in text for text in texts)
    assert [text for text in texts if text.startswith("PIR")] == ["PIR 0", "PIR 1", "PIR 2"]
    assert "and 2 more" in texts
    picture = import_module("bl_ext.user_default.angen_sensors.sensor_logic.coverage.picture")
    assert set(picture.LEVELS) <= set(texts)
    # The field has 0 m, which stands for the usual height.
    assert "0: usual, 0.914 m" in texts
    world.scene.angen_coverage.height = 1.2
    assert not any("usual" in text for text in drawn("ANGEN_PT_coverage").labels)


def test_only_the_last_map_is_shown(world):
    scene = world.scene
    world.hall(3, 2, 2.5)
    world.pir(update_rate=10.0).location = (0.1, 1.0, 1.5)
    scene.angen_coverage.cell = 0.5

    def visible():
        return [o.name for o in scene.objects if o.name.startswith("Coverage") and o.visible_get()]

    for motion in ("ARM", "CAT"):
        scene.angen_coverage.motion = motion
        bpy.ops.angen.coverage()
        assert visible() == [f"Coverage {motion.lower()}"]
    for motion in ("CAT", "ARM"):
        # The map of the proposal takes the place of all others, until it is discarded.
        scene.angen_coverage.motion = motion
        bpy.ops.angen.place_propose()
        assert len(visible()) == 1 and visible() != ["Coverage cat"]
        bpy.ops.angen.place_discard()
        assert visible() == ["Coverage cat"]


def test_a_map_of_another_motion_does_not_make_an_outdated_one_look_fresh(world):
    scene = world.scene
    world.hall(3, 2, 2.5)
    world.pir(update_rate=10.0).location = (0.1, 1.0, 1.5)
    sofa = world.box((0.4, 0.4, 0.4), (2, 1, 0.2), "Sofa")
    scene.angen_coverage.motion, scene.angen_coverage.cell = "ARM", 0.5

    def looks():
        return {o.name: o.display_type for o in scene.objects if o.name.startswith("Coverage")}

    bpy.ops.angen.coverage()
    (arm,) = looks()
    sofa.location.x += 0.2
    world.update()
    scene.angen_coverage.motion = "CAT"
    bpy.ops.angen.coverage()
    world.update()
    assert looks().pop(arm) == "WIRE"
    assert set(looks().values()) - {"WIRE"} == {"TEXTURED"}
