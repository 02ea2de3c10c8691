# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the values of an armature's animated channels from poses."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from ...model import Array
from .pose import BodyPose
from .solve import Bones, skeleton_of, solve
from .turns import about_z, back, chained, turned

# Path, index and values (n,) of a channel.
Channel = tuple[str, int, Array]


def channels(
    pose: BodyPose, rest: Mapping[str, Array], bones: Bones | None = None
) -> Iterator[Channel]:
    """The channels of an armature object whose bones' axes at rest are `rest` (4,): its location
    (m) on the floor under the pelvis, its heading, the pelvis's height, the bones' turns."""
    bones = bones or solve(pose)
    scale = pose.build.scale
    at_rest = skeleton_of(pose.build).head["pelvis"]
    root = pose.pelvis - turned(about_z(pose.heading), at_rest * scale)
    lift = (root[:, 2:] - pose.walker[:, 2:3]) / scale * np.array([0.0, 0.0, 1.0])
    root = np.concatenate([root[:, :2], pose.walker[:, 2:3]], 1)
    for axis in range(3):
        yield "location", axis, root[:, axis]
    yield "rotation_euler", 2, pose.heading
    moved = turned(back(rest["pelvis"]), lift)
    for axis in range(3):
        yield 'pose.bones["pelvis"].location', axis, moved[:, axis]
    for bone, turn in local_turns(pose, bones, rest).items():
        for axis in range(4):
            yield f'pose.bones["{bone}"].rotation_quaternion', axis, turn[:, axis]


def local_turns(pose: BodyPose, bones: Bones, rest: Mapping[str, Array]) -> dict[str, Array]:
    """The pose bones' own turns (n, 4), each against its parent, in its bone's axes `rest` (4,).

    Of two quaternions for one turn it is that nearer to the one before.
    """
    local = {}
    for bone, turn in bones.turn.items():
        above = skeleton_of(pose.build).parent[bone]
        base = bones.turn[above] if above else about_z(pose.heading)
        own = chained(back(rest[bone]), back(base), turn, rest[bone])
        flips = np.sign((own[1:] * own[:-1]).sum(1))
        own[1:] *= np.cumprod(np.where(flips < 0, -1.0, 1.0))[:, None]
        local[bone] = own
    return local
