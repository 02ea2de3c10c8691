# SPDX-License-Identifier: GPL-3.0-or-later
"""Rebuild what was measured with real infrared arrays: noise, and people below a ceiling.

`measured_thermal.csv` has the measured values. `simulate` gives the same figures of the presets, in
rooms with the project's own resident. Who walks is posed as standing. Set-ups as far as they are
known: docs/measured.md.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import bpy
import numpy as np
from angen_sensors.angen_addon.authoring.presets import find_preset, new_sensor
from angen_sensors.residents.blender.settings import add_resident, build_of, posed, show_pose
from angen_sensors.residents.body.skeleton import Sort
from angen_sensors.sensor_logic.kinds import KINDS
from mathutils import Vector

from .common import box_mesh, link, new_scene, run, sensors_of

KIND = KINDS["THERMAL_ARRAY"]
# m. Heights of a seat and of a mattress on the floor.
SEAT, MATTRESS = 0.45, 0.10
# s. So long rests who leaves warmth: the recording says seconds, and its files last 10 to 30 s.
RESTED = 15
# K. A pixel belongs to a body if the mean of 3 × 3 pixels exceeds the room by this.
BLOB = 0.7


def simulate(quick: bool) -> dict[str, float]:
    """Return the simulated value of each row of measured_thermal.csv by its id."""
    left = {
        "TA15": _warmth_left("sitting", SEAT, _chair, 10, 43),
        "TA16": _warmth_left("lying", MATTRESS, _mattress, 5, 28),
    }
    return {**_noise(quick), **_melexis_people(quick), **_omron_people(quick), **left}


# Noise


def _noise(quick: bool) -> dict[str, float]:
    updates = 200 if quick else 800
    melexis = _still("MLX90640_BAA", updates, 8.0, netd=0.196 * math.sqrt(2.0))
    eye = _still("AMG8833", updates * 2)
    omron = _still("D6T_1616L", updates)
    heimann = _still("HTPA32", updates)
    of_melexis, of_eye = _by_differences(melexis), _by_differences(eye)
    return {
        "TA1": _middle(of_melexis),
        "TA2": float(np.median(of_melexis)),
        "TA3": _edge(of_melexis),
        "TA4": _pixel_means(melexis, 40),
        "TA7": _middle(of_eye),
        "TA8": _edge(of_eye),
        "TA9": _corners(of_eye),
        "TA10": float(_means(eye, 50).mean(axis=(1, 2)).std()),
        "TA11": _pixel_means(eye, 50),
        "TA14": _corners(_by_differences(omron)) / _middle(_by_differences(omron)),
        "TA17": _corners(_by_differences(heimann)) / _middle(_by_differences(heimann)),
    }


def _still(preset: str, updates: int, rate: float = 0.0, **values: Any) -> Any:
    """Return frames (updates, rows, columns) of an array in a room where nothing moves."""
    sensor = _room(preset, 2.5, 21.0, updates, rate)
    for name, value in {"rays": 1, **values}.items():
        setattr(sensor.angen_sensor.thermal_array, name, value)
    return _frames(updates)


def _by_differences(frames: Any) -> Any:
    return np.diff(frames, axis=0).std(axis=0) / math.sqrt(2.0)


def _middle(noise: Any) -> float:
    rows, columns = noise.shape
    inner = noise[rows // 2 - 1 : rows // 2 + 1, columns // 2 - 1 : columns // 2 + 1]
    return float(inner.mean())


def _corners(noise: Any) -> float:
    return float(noise[:: len(noise) - 1, :: len(noise[0]) - 1].mean())


def _edge(noise: Any) -> float:
    is_edge = np.ones(noise.shape, bool)
    is_edge[1:-1, 1:-1] = False
    return float(np.median(noise[is_edge]))


def _means(frames: Any, count: int) -> Any:
    """Return the means (k, rows, columns) of `count` frames in a row."""
    whole = frames[: len(frames) // count * count]
    return whole.reshape(-1, count, *frames.shape[1:]).mean(axis=1)


def _pixel_means(frames: Any, count: int) -> float:
    means = _means(frames, count)
    against = means - means.mean(axis=(1, 2), keepdims=True)
    return float(np.median(against.std(axis=0)))


# People


def _melexis_people(quick: bool) -> dict[str, float]:
    frames = _people("MLX90640_BAA", 2.355, 27.0, 1.2, 0.6, 4 if quick else 16)
    blobs = {posture: [_blob(frame) for frame in frames[posture]] for posture in frames}
    return {"TA5": float(np.mean(blobs["lying"])), "TA6": float(np.mean(blobs["standing"]))}


def _omron_people(quick: bool) -> dict[str, float]:
    frames = _people("D6T_1616L", 2.2, 19.5, 0.8, 0.8, 6 if quick else 24)
    tops = {p: np.median([_top(frame) for frame in frames[p]]) for p in frames}
    halves = [_above_half(frame) for frame in frames["sitting"]]
    return {"TA12": float(tops["lying"] / tops["standing"]), "TA13": float(np.median(halves))}


def _people(
    preset: str, ceiling: float, ambient: float, x: float, y: float, count: int
) -> dict[str, list[Any]]:
    """Return frames above the room, by posture, of an adult at `count` random places.

    The places are within ±x and ±y (m) of the point below the array. The frames have no noise.
    """
    _without_noise(_room(preset, ceiling, ambient, 1))
    mattress = link("mattress", _mattress())
    chair = link("chair", _chair())
    rig = add_resident(bpy.context, Sort.ADULT, Vector((0, 0, 0)), 0.0)
    places = np.random.default_rng(1).uniform(-1.0, 1.0, (count, 3)) * (x, y, math.pi)
    found: dict[str, list[Any]] = {}
    for posture, height in (("standing", 0.0), ("sitting", SEAT), ("lying", MATTRESS)):
        found[posture] = []
        for k, (at_x, at_y, yaw) in enumerate(places.tolist()):
            pose = posed(build_of(rig), posture, (at_x, at_y, height), yaw, side=(0, 1, -1)[k % 3])
            show_pose(rig, pose)
            mattress.location = (at_x, at_y, 0.0 if posture == "lying" else -5.0)
            chair.location = (at_x, at_y, 0.0 if posture == "sitting" else -5.0)
            mattress.rotation_euler.z = chair.rotation_euler.z = yaw
            bpy.context.view_layer.update()
            found[posture].append(_frames(1)[0] - ambient)
    return found


def _without_noise(sensor: Any) -> None:
    noise = "netd", "fixed_pattern", "offset_sigma", "frame_drift", "pixel_drift", "resolution"
    for name in noise:
        setattr(sensor.angen_sensor.thermal_array, name, 0.0)


def _warmth_left(
    posture: str, height: float, bearer: Callable[[], Any], first: int, last: int
) -> float:
    """Return the excess that a person leaves on a chair or mattress, by the person's own.

    The person rests for `RESTED` s and is gone at once. The excess is that of the three warmest
    pixels, in the mean from `first` to `last` s afterwards.
    """
    ambient = 19.5
    sensor = _room("D6T_1616L", 2.2, ambient, RESTED + last + 1, 1.0)
    _without_noise(sensor)
    sensor.angen_sensor.thermal_array.mean_of = 1
    link("bearer", bearer(), (0.3, 0.2, 0.0))
    rig = add_resident(bpy.context, Sort.ADULT, Vector((0, 0, 0)), 0.0)
    show_pose(rig, posed(build_of(rig), posture, (0.3, 0.2, height), 0.0))
    for frame, aside in ((RESTED, 0.0), (RESTED + 1, 50.0)):
        rig.delta_location.x = aside
        rig.keyframe_insert("delta_location", index=0, frame=frame)
    tops = [_top(frame - ambient) for frame in _frames(RESTED + last + 1)]
    return float(np.mean(tops[RESTED + first : RESTED + last + 1]) / tops[RESTED - 1])


def _mattress() -> Any:
    return box_mesh([((1.0, 0.45, MATTRESS / 2), (0, 0, MATTRESS / 2))])


def _chair() -> Any:
    """Return a chair that looks along +x, with its seat below the origin of the hips."""
    return box_mesh([
        ((0.21, 0.21, 0.02), (0.05, 0, SEAT - 0.02)),
        ((0.02, 0.21, 0.25), (-0.20, 0, SEAT + 0.2)),
    ])  # fmt: skip


def _blob(excess: Any) -> int:
    """Return the number of pixels of the largest blob whose means of 3 × 3 pixels are warm."""
    padded = np.pad(excess, 1, mode="edge")
    rows, columns = excess.shape
    mean = sum(padded[i : i + rows, j : j + columns] for i in range(3) for j in range(3)) / 9.0
    left, largest = set(zip(*np.nonzero(mean > BLOB), strict=True)), 0
    while left:
        reached = {left.pop()}
        size = 0
        while reached:
            row, column = reached.pop()
            size += 1
            near = {(row + i, column + j) for i in (-1, 0, 1) for j in (-1, 0, 1)} & left
            left -= near
            reached |= near
        largest = max(largest, size)
    return largest


def _top(excess: Any) -> float:
    """Return the mean of the three warmest pixels."""
    return float(np.sort(excess, axis=None)[-3:].mean())


def _above_half(excess: Any) -> int:
    return int(np.count_nonzero(excess > _top(excess) / 2.0))


# Scenes


def _room(
    preset: str, ceiling: float, ambient: float, updates: int, rate: float = 0.0
) -> Any:  # fmt: skip
    """Make a room with an array on its ceiling, which looks down; return the array."""
    scene = new_scene(10, updates)
    scene.angen_ambient_temperature = ambient
    link("floor", box_mesh([((4.0, 4.0, 0.05), (0, 0, -0.05))]))
    sensor = new_sensor(bpy.context, KIND.identifier, find_preset(KIND, preset), "array")
    sensor.location = (0.0, 0.0, ceiling)
    if rate:
        sensor.angen_sensor.update_rate = rate
    scene.render.fps = round(sensor.angen_sensor.update_rate)
    bpy.context.view_layer.update()
    return sensor


def _frames(last: int) -> Any:
    """Return the frames (last, rows, columns) in °C of the scene's array."""
    sensors = sensors_of(KIND.identifier)
    _, recording = run(bpy.context.scene, sensors, 1, last)
    texts = recording.tracks["array"].columns["frame_c"]
    shape = sensors[0].parameters.rows, sensors[0].parameters.columns
    return np.array([np.array(text.split(";"), float).reshape(shape) for text in texts])
