# SPDX-License-Identifier: GPL-3.0-or-later
"""The fast ray caster against Blender's own `scene.ray_cast`, on random scenes that change."""

from fractions import Fraction

import bpy
import numpy as np
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.runtime import state
from bl_ext.user_default.angen_sensors.angen_addon.scene.rays import solids
from bl_ext.user_default.angen_sensors.angen_addon.scene.rays.caster import RayCaster
from bl_ext.user_default.angen_sensors.angen_addon.scene.rays.reference import SceneRayCaster
from random_scene import LAST_FRAME, RandomScene
from tiers import mostly_slow

TOLERANCE_M = 2e-5
RAYS = 80
STEPS = 16
REACH = 6.0


def casters():
    pair = RayCaster(), SceneRayCaster(bpy.context.scene)
    for caster in pair:
        state.CACHE.watch(caster.solids)
    return pair


def ranges(caster, sensor, origins, ways):
    caster.update(bpy.context.evaluated_depsgraph_get())
    o = np.array([tuple(v) for v in origins])
    d = np.array([tuple(v) for v in ways], np.float64)
    d /= np.linalg.norm(d, axis=1)[:, None]
    return caster.cast(sensor, 0, o, d, np.full(len(o), REACH))


def grazing(reference, sensor, origin, way):
    """Whether the reference itself is undecided: a hair's breadth aside it says something else."""
    aside = way.orthogonal().normalized()
    across = way.cross(aside)
    nearby = [origin + offset * 2e-6 for offset in (aside, -aside, across, -across)]
    seen = ranges(reference, sensor, nearby, [way] * 4)
    return seen.max() - seen.min() > TOLERANCE_M


@pytest.mark.parametrize("instances", [False, True])
@pytest.mark.parametrize("seed", mostly_slow(range(8), 1))
def test_same_ranges_as_scene_ray_cast(empty_scene, figure, seed, instances):
    world = RandomScene(seed, instances)
    scene = world.scene
    fast, reference = casters()
    origins, ways = world.rays(RAYS)
    compared = hits = 0
    worst = 0.0
    frame = 1
    for _ in range(STEPS):
        frame = world.random.choice((frame + 1, frame + 1, frame, world.random.randrange(1, 24)))
        # An edit tells the casters that anything may have changed: most steps are frames alone.
        done = world.change() if world.random.random() < 0.4 else "frame"
        if done != "frame":
            bpy.context.view_layer.update()
        scene.frame_set(min(frame, LAST_FRAME))
        uids = [o.session_uid for o in scene.objects]
        sensor = world.random.choice(sorted(uids))
        got = ranges(fast, sensor, origins, ways)
        expected = ranges(reference, sensor, origins, ways)
        off = np.abs(got - expected)
        worst = max(worst, off[off <= TOLERANCE_M].max())
        wrong = [
            row
            for row in np.flatnonzero(off > TOLERANCE_M).tolist()
            if not grazing(reference, sensor, origins[row], ways[row])
        ]
        assert not wrong, (seed, frame, done, [(r, got[r], expected[r]) for r in wrong[:5]])
        compared += len(got)
        hits += int((expected < REACH).sum())
    figure(worst, "m")
    assert instances or fast.solids.listing < STEPS, "every step made the list anew"
    assert hits > compared / 8, "the scene is too empty to show anything"


def test_inverses_of_scaled_and_mirrored_matrices_are_exact():
    """Against rational arithmetic; numpy's own would wait for threads (4 ms on a busy machine)."""
    rng = np.random.default_rng(7)
    for scale in ((1, 1, 1), (-1, 1, 1), (1e-3, 1, 1e3), (2, 0, 1)):
        turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        matrix = np.eye(4)
        matrix[:3, :3], matrix[:3, 3] = turn * np.array(scale, float), (1e5, -3.0, 0.1)
        assert solids.invertible(matrix) == (0 not in scale)
        if 0 in scale:
            continue
        found = solids.inverted(matrix[None])[0]
        product = np.vectorize(Fraction)(found) @ np.vectorize(Fraction)(matrix)
        # What rounding leaves of terms that cancel, as large as these are.
        size = np.abs(found) @ np.abs(matrix)
        off = np.abs(product.astype(float) - np.eye(4))
        assert (off <= 1e-15 * np.maximum(size, 1.0)).all()
