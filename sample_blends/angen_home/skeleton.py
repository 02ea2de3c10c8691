# SPDX-License-Identifier: GPL-3.0-or-later
"""The bones of the person: rest positions in metres, looking along +X, left is +Y, z = 0 the sole.

Rest is a stance with the arms a little away from the body, so that the skin has room.
"""

from dataclasses import dataclass
from math import cos, radians, sin

import numpy as np

ARM_REST = radians(30)  # from the vertical

SHOULDER = np.array([-0.010, 0.172, 1.392])
UPPER_ARM, FOREARM = 0.285, 0.245
_ARM = np.array([0.0, sin(ARM_REST), -cos(ARM_REST)])
ELBOW = SHOULDER + UPPER_ARM * _ARM
WRIST = ELBOW + FOREARM * _ARM
KNUCKLES = WRIST + 0.09 * _ARM

HIP = np.array([0.0, 0.090, 0.905])
KNEE = np.array([0.012, 0.105, 0.490])
ANKLE = np.array([-0.010, 0.115, 0.085])
BALL = np.array([0.120, 0.120, 0.020])  # where the foot rolls off
TOE = np.array([0.195, 0.122, 0.020])
HEEL_X = -0.065  # the back of the sole


@dataclass(frozen=True)
class Bone:
    name: str
    parent: str
    head: tuple[float, float, float]
    tail: tuple[float, float, float]


def _bone(name: str, parent: str, head: np.ndarray, tail: np.ndarray) -> Bone:
    return Bone(name, parent, tuple(map(float, head)), tuple(map(float, tail)))


def _bones() -> tuple[Bone, ...]:
    pelvis, spine = np.array([0.0, 0.0, 0.94]), np.array([-0.005, 0.0, 1.05])
    chest, neck = np.array([-0.01, 0.0, 1.19]), np.array([-0.022, 0.0, 1.435])
    head, crown = np.array([-0.005, 0.0, 1.535]), np.array([-0.005, 0.0, 1.72])
    bones = [
        _bone("pelvis", "", pelvis, spine),
        _bone("spine", "pelvis", spine, chest),
        _bone("chest", "spine", chest, neck),
        _bone("neck", "chest", neck, head),
        _bone("head", "neck", head, crown),
    ]
    limbs = (
        ("upper_arm", "chest", SHOULDER, ELBOW),
        ("forearm", "upper_arm", ELBOW, WRIST),
        ("hand", "forearm", WRIST, KNUCKLES),
        ("thigh", "pelvis", HIP, KNEE),
        ("shin", "thigh", KNEE, ANKLE),
        ("foot", "shin", ANKLE, BALL),
        ("toes", "foot", BALL, TOE),
    )
    for side, sign in (("L", 1.0), ("R", -1.0)):
        mirror = np.array([1.0, sign, 1.0])
        for name, parent, a, b in limbs:
            above = parent if parent in ("chest", "pelvis") else f"{parent}.{side}"
            bones.append(_bone(f"{name}.{side}", above, a * mirror, b * mirror))
    return tuple(bones)


BONES = _bones()
HEAD = {bone.name: np.array(bone.head) for bone in BONES}
PARENT = {bone.name: bone.parent for bone in BONES}
