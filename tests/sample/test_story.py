# SPDX-License-Identifier: GPL-3.0-or-later
"""The animation in the sample home: errors that a viewer would notice."""

from types import SimpleNamespace

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from sample_blends import build_angen  # noqa: E402
from sample_blends.angen_home import plan  # noqa: E402

EVERY = 3
BONES = ("pelvis", "head", "hand.L", "hand.R")
WALLS = [w for w in (*plan.OUTER_WALLS, *plan.INNER_WALLS, *plan.BALCONY_WALLS) if w.z0 < 2.0]
SOLIDS = [("a wall", wall) for wall in WALLS] + list(plan.FURNITURE.items())


@pytest.fixture(scope="module")
def film():
    """Return joints and free edges of doors at every third frame of the shipped file."""
    bpy.ops.wm.open_mainfile(filepath=str(build_angen.HERE / "angen.blend"), load_ui=False)
    scene = bpy.context.scene
    rig = bpy.data.objects["Person rig"]
    frames = range(scene.frame_start, scene.frame_end + 1, EVERY)
    at = {bone: [] for bone in BONES}
    leaves = {name: [] for name in plan.DOORS}
    for frame in frames:
        scene.frame_set(frame)
        for bone in BONES:
            at[bone].append(rig.matrix_world @ rig.pose.bones[bone].head)
        for name in leaves:
            leaves[name].append(bpy.data.objects[f"Door {name}"].matrix_world.copy())
    last = scene.frame_end
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    return SimpleNamespace(
        last=last,
        seconds=(np.array(frames) - 1) / plan.FPS,
        at={bone: np.array(points) for bone, points in at.items()},
        leaves={name: np.array(found) for name, found in leaves.items()},
    )


def off(box, points):
    """Return distances (n,) on the floor from points (n, 2 or more) to a box, m."""
    low, high = (box.x0, box.y0), (box.x1, box.y1)
    return np.hypot(*np.maximum(0, np.maximum(low - points[:, :2], points[:, :2] - high)).T)


def test_nothing_jumps(film):
    for bone, limit in (("pelvis", 1.5), ("head", 2.0), ("hand.L", 3.5), ("hand.R", 3.5)):
        way = np.linalg.norm(np.diff(film.at[bone], axis=0), axis=1)
        speed = way / np.diff(film.seconds)
        assert speed.max() < limit, f"{bone} at {film.seconds[speed.argmax()]:.2f} s"


def test_who_stands_or_walks_keeps_clear_of_walls_furniture_and_leaves(film):
    upright = film.at["pelvis"][:, 2] > 0.93
    here, seconds = film.at["pelvis"][upright], film.seconds[upright]
    for name, box in SOLIDS:
        near = off(box, here)
        # A person sits down from a place close to the seat.
        least = 0.05 if name in ("Sofa", "Bed", "Toilet") else 0.19
        assert near.min() > least, f"{name}: {near.min():.3f} m at {seconds[near.argmin()]:.2f} s"
    for name, matrices in film.leaves.items():
        along = np.linspace(0.0, plan.DOORS[name].leaf_width, 11)
        leaf = matrices[upright, :2, :1] * along + matrices[upright, :2, 3:]
        near = np.hypot(*(leaf - here[:, :2, None]).transpose(1, 0, 2)).min(axis=1)
        assert near.min() > 0.22, f"{name}: {near.min():.3f} m at {seconds[near.argmin()]:.2f} s"


@pytest.mark.parametrize(
    ("on", "height", "lasts"),
    [("Sofa", plan.SOFA_SEAT_Z, 10.0), ("Toilet", plan.TOILET_SEAT_Z, 2.0)],
)
def test_she_sits_on_seats(film, on, height, lasts):
    pelvis = film.at["pelvis"]
    above = pelvis[:, 2] - height
    sits = (off(plan.FURNITURE[on], pelvis) == 0.0) & (above > 0.05) & (above < 0.3)
    assert sits.sum() * EVERY / plan.FPS > lasts


def test_it_lasts_nearly_three_minutes_and_ends_in_bed_with_doors_shut(film):
    assert film.last == 4120
    shut = {name: matrices[[0, -1]] for name, matrices in film.leaves.items()}
    for name, (first, last) in shut.items():
        assert last == pytest.approx(first, abs=1e-5), name
    opened = {name for name, m in film.leaves.items() if np.ptp(m[:, :3, 0], axis=0).max() > 0.5}
    assert opened == {"entrance", "kitchen", "bathroom", "closet", "bedroom"}
    head, pelvis = film.at["head"][-1], film.at["pelvis"][-1]
    assert off(plan.FURNITURE["Bed"], pelvis[None]) == 0.0
    assert plan.BED_TOP_Z < pelvis[2] < plan.BED_TOP_Z + 0.2
    assert abs(head[2] - pelvis[2]) < 0.15


def test_a_wrong_story_is_one_line_and_status_1(monkeypatch, capsys, tmp_path):
    def wrong(_scene):
        raise build_angen.InputError("story.toml, line 12: nonsense")

    monkeypatch.setattr(build_angen, "build", lambda: bpy.context.scene)
    monkeypatch.setattr(build_angen, "add_story", wrong)
    out = tmp_path / "home.blend"
    assert build_angen.make(out, with_digest=False) == 1
    assert capsys.readouterr().err == "story.toml, line 12: nonsense\n"
    assert not out.exists()
