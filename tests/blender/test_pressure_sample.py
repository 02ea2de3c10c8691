# SPDX-License-Identifier: GPL-3.0-or-later
"""The sample of the pressure sensor: its pads read what statics and the momentum theorem say."""

from importlib import import_module
from pathlib import Path

import bpy
import numpy as np
import pytest

SAMPLE = Path(__file__).resolve().parents[2] / "sample_blends" / "pressure.blend"
ADDON = "bl_ext.user_default.angen_sensors"
LEGS = ("front left", "front right", "back left", "back right")
G = 9.81
TABLE, WEIGHT, DROPPED = 12.0 * G, 8.0 * G, 2.0 * G
# Newtons: the legs are stiff, and rest on areas, not on points.
LEG_TOLERANCE = 0.1


@pytest.fixture(scope="module")
def readings():
    """Columns (frames,) of every pad, and where the weight was (frames, 3)."""
    bpy.ops.wm.open_mainfile(filepath=str(SAMPLE), load_ui=False)
    scene = bpy.context.scene
    recording = import_module(f"{ADDON}.sensor_logic.recording.tracks").Recording()
    simulation = import_module(f"{ADDON}.angen_addon.runtime.simulation")
    found = import_module(f"{ADDON}.angen_addon.scene.sensors").all_sensors(bpy.context.view_layer)
    for _ in simulation.simulate(scene, found, scene.frame_start, scene.frame_end, recording):
        pass
    # The places alone are wanted now.
    scene.angen_live = False
    weight = bpy.data.objects["Weight"]
    places = []
    for frame in range(scene.frame_start, scene.frame_end + 1):
        scene.frame_set(frame)
        places.append(tuple(weight.matrix_world.translation))
    pads = {
        name.removeprefix("Pad "): {key: np.array(column) for key, column in track.columns.items()}
        for name, track in recording.tracks.items()
    }
    return pads, np.array(places)


def test_every_update_is_valid_but_the_first(readings):
    pads, places = readings
    assert set(pads) == {*LEGS, "stack", "drop"}
    for columns in pads.values():
        assert len(columns["valid"]) == len(places) == 240
        assert not columns["valid"][0] and columns["valid"][1:].all()


def test_the_four_legs_follow_statics(readings):
    """Four equal springs under a stiff table: a leg has ¼ W (1 + x·X/X² + y·Y/Y²)."""
    pads, places = readings
    for leg in LEGS:
        at = bpy.data.objects[f"Pad {leg}"].location
        share = (1.0 + places[:, 0] / at.x + places[:, 1] / at.y) / 4.0
        exact = TABLE / 4.0 + WEIGHT * share
        assert np.ptp(exact) > 30.0
        assert np.abs(pads[leg]["force_n"] - exact).max() < LEG_TOLERANCE


def test_the_sum_of_the_legs_is_the_weight(readings):
    pads, _ = readings
    total = sum(pads[leg]["force_n"] for leg in LEGS)
    assert total == pytest.approx(TABLE + WEIGHT, rel=1e-4)


def test_the_force_rises_strictly_as_the_weight_nears_the_leg(readings):
    pads, places = readings
    near = np.linalg.norm(places[:, :2] - np.array(bpy.data.objects["Pad back right"].location)[:2],
                          axis=1)  # fmt: skip
    nearing = np.flatnonzero(np.diff(near[160:229]) < -1e-5) + 160
    assert len(nearing) > 60
    assert (np.diff(pads["back right"]["force_n"])[nearing] > 0.1).all()


def test_the_stack_weighs_its_boxes(readings):
    pads, _ = readings
    assert pads["stack"]["force_n"] == pytest.approx(7.0 * G, rel=1e-4)
    assert set(pads["stack"]["partners"]) == {"Box 4 kg"}


def test_the_drop_gives_the_impulse_of_its_fall(readings):
    """From the release at frame 25, between two readings, to rest at the end."""
    pads, _ = readings
    force, dt = pads["drop"]["force_n"], 1.0 / 24.0
    assert not force[:25].any()
    assert (force > 0.0).sum() > 100 and force.max() > 5.0 * DROPPED
    released = 24
    seconds = (len(force) - released) * dt
    assert force.sum() * dt == pytest.approx(DROPPED * seconds, rel=0.005)
    assert force[-1] == pytest.approx(DROPPED, rel=1e-4)


def test_no_path_of_the_builder_is_in_the_file():
    assert not [image.filepath for image in bpy.data.images if image.filepath]
    assert not bpy.data.libraries
    assert SAMPLE.stat().st_size < 300_000
