# SPDX-License-Identifier: GPL-3.0-or-later
"""Nothing of a file stays in memory when another one opens, and no references after undo."""

from __future__ import annotations

import gc
from collections import Counter
from collections.abc import Callable
from typing import Any

import bpy
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.advice import lacking
from bl_ext.user_default.angen_sensors.angen_addon.recording.references import REFERENCES
from bl_ext.user_default.angen_sensors.angen_addon.recording.results import FOLLOWED, RESULTS
from bl_ext.user_default.angen_sensors.angen_addon.runtime import handlers
from bl_ext.user_default.angen_sensors.angen_addon.view.overlay import refresh
from bl_ext.user_default.angen_sensors.angen_addon.view.readings import ReadingTexts
from bl_ext.user_default.angen_sensors.angen_addon.view.timeline.layout import HISTORIES
from bl_ext.user_default.angen_sensors.operators import doctor
from bl_ext.user_default.angen_sensors.panels import table
from bl_ext.user_default.angen_sensors.residents.operators import day, places
from recorded_home import ADDON, recorded

# Objects of these classes hold references to Blender's data.
REFERRING = {
    "Sensor",
    "Live",
    "SensorRunner",
    "Probes",
    "DrawnSensors",
    "RayCaster",
    "ReadingTexts",
}
# Objects of these are about the file.
ABOUT_FILE = {
    "Recording",
    "StoredRecording",
    "FollowedMap",
    "FollowedDay",
    "Finding",
    "History",
    "ComputedDay",
}

Left = Callable[[], Counter[str]]


@pytest.fixture
def left() -> Left:
    """Return a function that counts the objects made since, by the name of their class."""

    def alive() -> list[Any]:
        gc.collect()
        return [o for o in gc.get_objects() if str(type(o).__module__).startswith(ADDON)]

    earlier = alive()
    known = {id(one) for one in earlier}
    return lambda: Counter(type(one).__name__ for one in alive() if id(one) not in known)


@pytest.fixture
def home(world: Any) -> Any:
    """A home of which all is kept that can be: a recording, live sensors, findings, a notice."""
    recorded(world)
    bpy.data.objects["Front door"].hide_render = True
    world.scene.angen_live = True
    world.scene.frame_set(60)
    layer = bpy.context.view_layer
    refresh._drawn_sensors(world.scene).follow(world.scene, layer, layer.depsgraph)
    bpy.ops.angen.doctor()
    for kind in FOLLOWED:
        RESULTS.note_result(world.scene, world.update(), kind)
    RESULTS.add_notice("a notice")
    lacking.found.append("a missing file")
    HISTORIES.get(RESULTS.kept(world.scene).recording, world.sensors())
    table._texts = ReadingTexts(world.scene)
    day._computed = day.ComputedDay((0, 0), None, None, None, None)
    places.checked = "1 marked", ()
    REFERENCES._found["lux"] = 1
    return world


def test_another_file_finds_nothing_of_the_former(left, home):
    made = left()
    wanted = REFERRING | ABOUT_FILE
    assert not {name for name in wanted if not made[name]}
    del home
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    assert doctor.found is None and places.checked is None
    assert not RESULTS.notice and not lacking.found and not REFERENCES._found
    now = left()
    assert not {name: now[name] for name in wanted if now[name]}


def test_undo_leaves_what_was_recorded_but_nothing_that_refers_to_objects(left, home):
    handlers.before_undo()
    now = left()
    assert not {name: now[name] for name in REFERRING if now[name]}
    kept = RESULTS.kept(home.scene)
    assert kept is not None and kept.unsure and doctor.found
