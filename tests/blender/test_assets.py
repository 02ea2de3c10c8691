# SPDX-License-Identifier: GPL-3.0-or-later
"""The library of ready sensors: every part is in it, with its housing and a picture, and senses."""

import re
import subprocess
import sys
from pathlib import Path, PurePosixPath

import bpy
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.authoring.presets import is_applied
from bl_ext.user_default.angen_sensors.sensor_logic.kinds import KINDS as kinds

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(
    scope="module",
    params=[("DISTANCE",), pytest.param((), marks=pytest.mark.slow)],
    ids=["one kind", "all"],
)
def library(request, tmp_path_factory):
    """Build a library of one kind of sensor, or of all."""
    folder = tmp_path_factory.mktemp("assets")
    done = subprocess.run(
        [sys.executable, ROOT / "scripts" / "build_assets.py", folder, *request.param],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    # Blender 5.2 prints a greeting first.
    assert re.fullmatch(r"\d+ assets in .*angen_sensors.blend", done.stdout.splitlines()[-1])
    assert sorted(path.name for path in folder.iterdir()) == [
        "angen_sensors.blend",
        "blender_assets.cats.txt",
    ]
    return folder, request.param


def test_every_part_is_there_as_its_preset_says(world, library):
    library, only = library
    catalogs = dict(
        re.findall(r"^([0-9a-f-]{36}):(Sensors[^:]*):", (library / "blender_assets.cats.txt")
        .read_text(encoding="utf-8"), re.MULTILINE)
    )  # fmt: skip
    # Each catalog's parents are there: Blender would add them, and show the library as not saved.
    paths = set(catalogs.values())
    assert {str(parent) for path in paths for parent in PurePosixPath(path).parents} - {
        "."
    } <= paths
    path = str(library / "angen_sensors.blend")
    with bpy.data.libraries.load(path, link=False, assets_only=True) as (there, target):
        target.objects = list(there.objects)
    found = {(obj.angen_sensor.kind, obj.name): obj for obj in target.objects}
    chosen = [kind for kind in kinds.values() if not only or kind.identifier in only]
    presets = {(k.identifier, p.label): p for k in chosen for p in k.presets}
    assert set(found) == set(presets)
    for (kind, _), preset in presets.items():
        sensor = found[kind, preset.label]
        assert is_applied(sensor, preset)
        facts = sensor.asset_data
        assert catalogs[facts.catalog_id] == f"Sensors/{kinds[kind].label}"
        assert preset.source[:100] in facts.description
        pixels = list(sensor.preview.image_pixels_float)[3::4]
        assert 0.05 < sum(pixels) / len(pixels) < 0.95, "a picture in which the part can be seen"
        assert len(sensor.data.polygons) > 4


def test_every_part_is_in_renders_and_has_the_picture_of_its_own_housing(world, library):
    library, _ = library
    path = str(library / "angen_sensors.blend")
    with bpy.data.libraries.load(path, link=False, assets_only=True) as (there, target):
        target.objects = list(there.objects)
    assert [obj.name for obj in target.objects if obj.hide_render] == []
    pictures = {}
    for obj in target.objects:
        corners = [round(x, 5) for vertex in obj.data.vertices for x in vertex.co]
        housing = obj.angen_sensor.kind, *corners
        pictures.setdefault(tuple(obj.preview.image_pixels), []).append((obj.name, housing))
    for shared in pictures.values():
        assert len({housing for _, housing in shared}) == 1, [name for name, _ in shared]


@pytest.mark.slow
@pytest.mark.parametrize("library", [()], ids=["all"], indirect=True)
def test_one_that_is_dragged_in_senses(world, library):
    library, _ = library
    path = str(library / "angen_sensors.blend")
    with bpy.data.libraries.load(path, link=False, assets_only=True) as (there, target):
        target.objects = [name for name in there.objects if "TCST" in name][:1]
    (sensor,) = target.objects
    world.scene.collection.objects.link(sensor)
    world.wall(0.0005)
    assert bpy.ops.angen.simulate() == {"FINISHED"}
