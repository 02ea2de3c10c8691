# SPDX-License-Identifier: GPL-3.0-or-later
"""The bones of a cat at rest, in metres: the cat stands on four paws and looks along +x."""

from __future__ import annotations

import numpy as np

from .skeleton import Bone, Skeleton, bone, mirrored_limbs

HIP, HOCK = np.array([-0.125, 0.034, 0.195]), np.array([-0.158, 0.040, 0.075])
SHOULDER, WRIST = np.array([0.105, 0.034, 0.185]), np.array([0.088, 0.040, 0.045])
BACK_HEIGHT = 0.215  # height of the pelvis, m


def _bones() -> tuple[Bone, ...]:
    line = {
        "pelvis": (-0.130, 0.0, BACK_HEIGHT), "spine": (-0.055, 0.0, 0.222),
        "chest": (0.030, 0.0, 0.218), "neck": (0.118, 0.0, 0.222), "head": (0.165, 0.0, 0.262),
        "nose": (0.235, 0.0, 0.262),
    }  # fmt: skip
    names = list(line)
    at = [np.array(point) for point in line.values()]
    trunk = [bone("pelvis", "", at[0], at[1])]
    trunk += [bone(names[k], names[k - 1], at[k], at[k + 1]) for k in range(1, 5)]
    tail = [np.array(p) for p in ((-0.150, 0.0, 0.225), (-0.230, 0.0, 0.205),
                                  (-0.310, 0.0, 0.175), (-0.390, 0.0, 0.165))]  # fmt: skip
    above = ("pelvis", "tail.1", "tail.2")
    trunk += [bone(f"tail.{k + 1}", above[k], tail[k], tail[k + 1]) for k in range(3)]
    knee, elbow = np.array([-0.085, 0.042, 0.125]), np.array([0.062, 0.042, 0.118])
    hind, fore = np.array([-0.140, 0.040, 0.018]), np.array([0.096, 0.040, 0.016])
    ahead = np.array([0.038, 0.0, -0.006])
    limbs = (
        ("thigh", "pelvis", HIP, knee),
        ("shin", "thigh", knee, HOCK),
        ("foot", "shin", HOCK, hind),
        ("toes", "foot", hind, hind + ahead),
        ("upper_arm", "chest", SHOULDER, elbow),
        ("forearm", "upper_arm", elbow, WRIST),
        ("hand", "forearm", WRIST, fore),
        ("fingers", "hand", fore, fore + ahead),
    )
    return tuple(trunk + mirrored_limbs(limbs, ("chest", "pelvis")))


CAT = Skeleton(
    _bones(),
    ((("thigh", "shin", "foot", "toes"), 1.0), (("upper_arm", "forearm", "hand", "fingers"), -1.0)),
)
