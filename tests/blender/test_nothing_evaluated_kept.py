# SPDX-License-Identifier: GPL-3.0-or-later
"""No reference to evaluated data is kept from one evaluation of the scene to the next.

Blender frees instances, and meshes that nodes make, at the next evaluation, and crashes on
references to them. Originals, the objects of the file, may be kept, and the Depsgraph.
"""

import gc
import os
import subprocess
import sys
import types
from pathlib import Path

import bpy
import nodes_scenes
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.explain.explain import explain
from bl_ext.user_default.angen_sensors.angen_addon.runtime.live import known_live, live_of
from bl_ext.user_default.angen_sensors.angen_addon.runtime.simulation import simulate
from bl_ext.user_default.angen_sensors.angen_addon.scene.home.evaluated_home import EvaluatedHome
from bl_ext.user_default.angen_sensors.angen_addon.view.overlay.picture import DrawnSensors
from bl_ext.user_default.angen_sensors.sensor_logic.recording.tracks import Recording
from tiers import mostly_slow

ROOT = Path(__file__).resolve().parents[2]
LEAVES = (types.ModuleType, type, str, bytes, int, float, bool, type(None))


def kept_by(*roots):
    """Return all Blender data that some Python objects reach, each with the types on the way."""
    found, seen = [], set()
    waiting = [(root, type(root).__name__) for root in roots]
    while waiting:
        thing, way = waiting.pop()
        if id(thing) in seen or isinstance(thing, LEAVES):
            continue
        seen.add(id(thing))
        if isinstance(thing, (bpy.types.bpy_struct, bpy.types.bpy_prop_collection)):
            found.append((thing, way))
            continue
        if isinstance(thing, types.FunctionType):
            # Not the globals of a function.
            parts = [thing.__closure__, thing.__defaults__, thing.__kwdefaults__]
        else:
            parts = gc.get_referents(thing)
        waiting += [(part, f"{way} > {type(part).__name__}") for part in parts]
    return found


def evaluated(*roots):
    """Return the data that must not be kept."""
    # Not every evaluated datablock has `is_evaluated`: those of the file are in bpy.data.
    of_the_file = {datablock.as_pointer() for datablock in bpy.data.user_map()}
    wrong = []
    for thing, way in kept_by(*roots):
        if not isinstance(thing, bpy.types.Depsgraph):
            owner = thing.id_data
            if owner is None or owner.as_pointer() not in of_the_file:
                wrong.append(f"{type(thing).__name__}: {way}")
    return wrong


@pytest.fixture
def home(world):
    nodes_scenes.home(world)
    world.update()
    return world


def test_the_search_finds_what_must_not_be_kept(world):
    box = world.box((1, 1, 1))
    box.modifiers.new("array", "ARRAY")
    depsgraph = world.update()

    class Keeper:
        __slots__ = ("it",)

    keeper = Keeper()
    for bad in (box.evaluated_get(depsgraph), box.evaluated_get(depsgraph).data):
        keeper.it = bad
        assert evaluated([{"a": (keeper,)}])
        assert evaluated(lambda: bad)  # noqa: B023
    for good in (box, box.data, depsgraph, box.angen_sensor, box.modifiers[0]):
        keeper.it = good
        assert evaluated(keeper) == []


@pytest.mark.parametrize("caster", ["FAST", "SCENE"])
def test_a_run_keeps_nothing_evaluated(home, caster):
    home.scene.angen_ray_caster = caster
    recording = Recording()
    steps = simulate(home.scene, home.sensors(), 1, 6, recording)
    looked = 0
    for _ in steps:
        stage = steps.gi_frame.f_locals["stage"]
        assert evaluated(stage) == []
        looked += len(kept_by(stage.probes))
    assert looked > 50


def test_live_values_keep_nothing_evaluated(home):
    for frame in (1, 2, 3, 9, 10):
        home.scene.frame_set(frame)
        live = known_live()
        assert live is not None and live.readings
        assert evaluated(live) == []


def test_what_is_drawn_keeps_nothing_evaluated(home):
    field = DrawnSensors(home.scene)
    for frame in (1, 2, 9):
        home.scene.frame_set(frame)
        layer = bpy.context.view_layer
        field.follow(home.scene, layer, layer.depsgraph)
        assert evaluated(field) == []


def test_a_plan_and_an_explanation_keep_nothing_evaluated(home):
    recording = home.run(1, 12)
    for sensor in home.sensors():
        assert evaluated(explain(home.scene, sensor, recording, 3)) == []
    plan = EvaluatedHome(home.update())
    assert len(list(plan.surfaces(plan.caster.solids.version > 0))) > 10
    assert evaluated(plan) == []


# The verbs that read evaluated data


@pytest.fixture
def file(home, tmp_path):
    path = tmp_path / "home.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


@pytest.mark.parametrize(
    "verb",
    mostly_slow(
        [
            ["simulate", "--report", "report.html", "--samples", "samples"],
            ["explain", "--sensor", "pad", "--time", "1"],
            ["explain", "--sensor", "ILLUMINANCE", "--time", "1"],
            ["coverage", "--csv", "coverage.csv", "--cell", "0.5"],
            ["place", "--count", "1", "--csv", "place.csv", "--cell", "0.5"],
        ],
        ["simulate", "--report", "report.html", "--samples", "samples"],
    ),
    ids=lambda verb: "-".join(verb[:3:2]),
)
def test_every_verb_ends_well(file, verb):
    """In a separate process, because a kept reference crashes Blender (status -11)."""
    done = subprocess.run(
        [sys.executable, "-m", "angen_addon", verb[0], str(file), *verb[1:]],
        cwd=file.parent,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-2000:]


def test_what_was_removed_a_moment_ago_is_not_looked_at(world):
    """Blender lists removed objects until its next evaluation, though their memory is free.

    A timer that read one crashed Blender.
    """
    world.wall(0.3, "wall")
    world.switch()
    world.scene.frame_set(2)
    live = live_of(world.scene)
    assert "wall" in {solid.name for solid in live._probes.caster.solids.solids}
    walls = [world.wall(0.5 + n, f"later {n}") for n in range(8)]
    world.update()
    for wall in [bpy.data.objects["wall"], *walls]:
        bpy.data.objects.remove(wall)
    live.catch_up(world.scene, bpy.context.view_layer)
    assert [solid.name for solid in live._probes.caster.solids.solids] == []
