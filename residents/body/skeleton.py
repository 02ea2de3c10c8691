# SPDX-License-Identifier: GPL-3.0-or-later
"""The bones of a person at rest, and the builds of residents.

Rest positions are in metres. The person looks along +x, left is +y, and the feet stand at z = 0. At
rest the arms are a little away from the body, so that they do not touch the trunk.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from math import cos, radians, sin

import numpy as np

from ...sensor_logic.model import Array

SIDES = ("L", "R")
SIGN = np.array([1.0, -1.0])
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
    """A bone from `head` to `tail`, m; the root bone's parent is ""."""

    name: str
    parent: str
    head: tuple[float, ...]
    tail: tuple[float, ...]


def bone(name: str, parent: str, head: Array, tail: Array) -> Bone:
    """Return a bone from the points (3,) at its head and tail."""
    return Bone(name, parent, tuple(map(float, head)), tuple(map(float, tail)))


def mirrored_limbs(
    limbs: tuple[tuple[str, str, Array, Array], ...], trunk: tuple[str, ...]
) -> list[Bone]:
    """Return the bones of the limbs on the left side and, mirrored, those on the right side.

    Parameters
    ----------
    limbs : tuples
        Name, parent, head and tail of each bone of the left side, without the suffix of the side.
    trunk : tuple of str
        The bones of the trunk, whose names have no suffix.
    """
    bones = []
    for side, sign in zip(SIDES, SIGN, strict=True):
        mirror = np.array([1.0, sign, 1.0])
        for name, parent, a, b in limbs:
            above = parent if parent in trunk else f"{parent}.{side}"
            bones.append(bone(f"{name}.{side}", above, a * mirror, b * mirror))
    return bones


def _bones() -> tuple[Bone, ...]:
    pelvis, spine = np.array([0.0, 0.0, 0.94]), np.array([-0.005, 0.0, 1.05])
    chest, neck = np.array([-0.01, 0.0, 1.19]), np.array([-0.022, 0.0, 1.435])
    head, crown = np.array([-0.005, 0.0, 1.535]), np.array([-0.005, 0.0, 1.72])
    trunk = [
        bone("pelvis", "", pelvis, spine),
        bone("spine", "pelvis", spine, chest),
        bone("chest", "spine", chest, neck),
        bone("neck", "chest", neck, head),
        bone("head", "neck", head, crown),
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
    return tuple(trunk + mirrored_limbs(limbs, ("chest", "pelvis")))


class Leg:
    """A pair of legs, or of a cat's forelegs, with the lengths and names of the bones.

    `names` are the upper bone, lower bone, foot and toes, without the suffix of the side. `hinge`
    is +1 if the knees point forward, and −1 if they point back.
    """

    def __init__(self, heads: dict[str, Array], names: tuple[str, ...], hinge: float) -> None:
        self.names = names
        self.hinge = np.array([0.0, hinge, 0.0])
        at = [heads[f"{name}.L"] for name in names]
        self.upper = float(np.linalg.norm(at[1] - at[0]))
        self.lower = float(np.linalg.norm(at[2] - at[1]))


class Skeleton:
    """The bones of a person or cat.

    Attributes
    ----------
    head : dict of str to array, shape (3,)
        The position of each bone's head at rest, m.
    parent : dict of str to str
        The name of each bone's parent.
    """

    def __init__(
        self, bones: tuple[Bone, ...], legs: tuple[tuple[tuple[str, ...], float], ...]
    ) -> None:
        self.bones = bones
        self.head = {b.name: np.array(b.head) for b in bones}
        self.parent = {b.name: b.parent for b in bones}
        self.legs = tuple(Leg(self.head, names, hinge) for names, hinge in legs)


PERSON = Skeleton(_bones(), ((("thigh", "shin", "foot", "toes"), 1.0),))


# The builds of residents.


class Sort(StrEnum):
    """The sorts of body that a resident can have."""

    OLDER_ADULT = "OLDER_ADULT"
    ADULT = "ADULT"
    CHILD = "CHILD"
    CAT = "CAT"


@dataclass(frozen=True)
class Build:
    """The body of a resident: its size, mass and walking speed.

    Attributes
    ----------
    sort : Sort
        Adult, older adult, child or cat.
    stature : float
        The height of a person, or of a cat's back, m.
    mass : float
        The mass, kg.
    speed : float
        The usual walking speed, m/s.
    frame : bool
        Whether the resident uses a walking frame.
    """

    sort: Sort
    stature: float
    mass: float
    speed: float
    frame: bool = False

    @property
    def scale(self) -> float:
        """The size of this body divided by the size of its skeleton at rest."""
        return self.stature / SKELETON_STATURE[self.sort]

    @property
    def stoop(self) -> float:
        """The angle by which the standing resident's back is bent forward, rad."""
        return 0.14 if self.sort is Sort.OLDER_ADULT else 0.0

    @property
    def is_cat(self) -> bool:
        """Whether the body is a cat's."""
        return self.sort is Sort.CAT

    @property
    def step_length(self) -> float:
        """The distance between the landings of the left and the right foot at the usual speed, m.

        It grows roughly with the square root of the speed: 0.60 m at 1.1 m/s for an adult.
        """
        pace = self.speed / (1.1 * self.scale**0.5)
        return float(0.60 * self.scale * pace**0.5)


# The scale of a child's head against the child's other bones.
CHILD_HEAD = 1.29
# Stature of an unscaled skeleton, m: 1.535 up to the head's joint and 0.2 above it.
SKELETON_STATURE = {
    Sort.OLDER_ADULT: 1.735,
    Sort.ADULT: 1.735,
    Sort.CHILD: 1.535 + 0.2 * CHILD_HEAD,
    Sort.CAT: 0.25,
}
OLDER_ADULT = Build(Sort.OLDER_ADULT, 1.65, 68.0, 0.85)
ADULT = Build(Sort.ADULT, 1.735, 72.0, 1.1)
CHILD = Build(Sort.CHILD, 1.22, 23.0, 1.0)
CAT = Build(Sort.CAT, 0.25, 4.5, 0.55)
BUILDS = {build.sort: build for build in (OLDER_ADULT, ADULT, CHILD, CAT)}
