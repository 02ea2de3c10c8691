# SPDX-License-Identifier: GPL-3.0-or-later
"""The fur of a cat as shapes, at rest, and which bones move it."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from ...model import Array
from . import surface as sf
from .cat_skeleton import CAT, HIP, HOCK, SHOULDER, WRIST
from .skin import Part
from .surface import Shape

_AHEAD = ((0, 0, 1), (0, 1, 0), (1, 0, 0))  # rings along the trunk: height, width, length


def _trunk() -> Shape:
    return sf.loft(
        (
            (-0.175, 0.205, 0.030, 0.028),
            (-0.150, 0.203, 0.050, 0.046),
            (-0.100, 0.196, 0.056, 0.053),
            (-0.040, 0.192, 0.054, 0.052),
            (0.030, 0.188, 0.054, 0.050),
            (0.090, 0.190, 0.052, 0.047),
            (0.130, 0.208, 0.044, 0.040),
            (0.160, 0.232, 0.036, 0.034),
        ),
        (0, 0, 0),
        _AHEAD,
        cap=0.02,
    )


def _head() -> Shape:
    skull = sf.ball((0.195, 0.0, 0.268), (0.044, 0.042, 0.038))
    muzzle = sf.ball((0.232, 0.0, 0.254), (0.018, 0.020, 0.015))
    ear = sf.capsule((0.185, 0.026, 0.290), (0.182, 0.036, 0.322), 0.014, 0.004)
    return sf.union(0.012, skull, muzzle, ear, sf.mirrored(ear))


def _leg(above: Array, joint: Array, ankle: Array, ball: Array, thick: float) -> Shape:
    paw = sf.ball(ball + np.array([0.014, 0.0, -0.004]), (0.026, 0.016, 0.013))
    return sf.union(
        0.015,
        sf.capsule(above, joint, thick, 0.021),
        sf.capsule(joint, ankle, 0.020, 0.013),
        sf.capsule(ankle, ball, 0.012, 0.012),
        paw,
    )


def fur() -> Shape:
    at = CAT.head
    hind = _leg(HIP - np.array([0.0, 0.0, 0.01]), at["shin.L"], HOCK, at["toes.L"], 0.046)
    fore = _leg(SHOULDER, at["forearm.L"], WRIST, at["fingers.L"], 0.032)
    tail = [at[f"tail.{k}"] for k in (1, 2, 3)] + [np.array([-0.39, 0.0, 0.165])]
    parts = [sf.capsule(a, b, 0.016, 0.014) for a, b in pairwise(tail)]
    legs = [sf.union(0.004, leg, sf.mirrored(leg)) for leg in (hind, fore)]
    return sf.union(0.022, sf.union(0.03, _trunk(), _head()), *legs, *parts)


def cat_parts() -> list[Part]:
    low, high = (-0.42, -0.085, -0.005), (0.26, 0.085, 0.34)
    parts = [Part("fur", "fur", fur(), low, high, 0.008, 2200, "cat")]
    for sign, side in ((1.0, "L"), (-1.0, "R")):
        eye = sf.ball((0.229, sign * 0.020, 0.276), (0.007, 0.007, 0.007))
        low, high = (0.21, sign * 0.02 - 0.015, 0.26), (0.245, sign * 0.02 + 0.015, 0.292)
        parts.append(Part(f"eye.{side}", "eye", eye, low, high, 0.003, 60, "cat"))
    return parts


def cat_weights(points: Array, _region: str) -> dict[str, Array]:
    """The weights of bones at points, by their distance: (n,) a bone, with the sum 1."""
    near = {}
    for bone in CAT.bones:
        if bone.name == "pelvis":
            continue
        start, axis = np.array(bone.head), np.array(bone.tail) - np.array(bone.head)
        along = np.clip((points - start) @ axis / (axis @ axis), 0.0, 1.0)
        away = np.linalg.norm(points - start - along[:, None] * axis, axis=1)
        # A leg moves nothing of the other side.
        other = {"L": points[:, 1] < -0.002, "R": points[:, 1] > 0.002}.get(bone.name[-1:])
        weight = 1.0 / (away + 0.004) ** 4
        near[bone.name] = weight if other is None else np.where(other, 0.0, weight)
    start, end = CAT.head["pelvis"] - np.array([0.04, 0, 0]), CAT.head["spine"]
    along = np.clip((points - start) @ (end - start) / ((end - start) @ (end - start)), 0.0, 1.0)
    away = np.linalg.norm(points - start - along[:, None] * (end - start), axis=1)
    near["pelvis"] = 1.0 / (away + 0.004) ** 4
    whole = np.sum(list(near.values()), axis=0)
    return {name: weight / whole for name, weight in near.items()}
