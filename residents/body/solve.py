# SPDX-License-Identifier: GPL-3.0-or-later
"""Compute bone rotations and positions from a pose, and from these an armature's animation."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from ...sensor_logic.model import Array
from .cat_skeleton import CAT
from .pose import BodyPose
from .skeleton import FOREARM, PERSON, SIDES, SIGN, UPPER_ARM, Build, Leg, Skeleton
from .turns import (
    axis_angle,
    compose,
    compose_all,
    cross,
    from_columns,
    inverse,
    normalised,
    rotated,
    rotation_x,
    rotation_y,
    rotation_z,
    slerp,
)

THIGH, SHIN = PERSON.legs[0].upper, PERSON.legs[0].lower
_ARM_HINGE = np.array([0.0, -1.0, 0.0])


@dataclass(frozen=True)
class Bones:
    """The solved bones of a pose, by name.

    `turn` has the rotation (n, 4) of each bone, and `at` the position (n, 3) of its head, in the
    world.
    """

    turn: dict[str, Array]
    at: dict[str, Array]


def _frame(along: Array, hinge: Array) -> Array:
    """Return the rotation of a frame whose first axis is along a bone.

    The second axis is perpendicular to the bone, and as near to `hinge` as possible.
    """
    a = normalised(along)
    h = normalised(hinge - a * (hinge * a).sum(-1, keepdims=True))
    return from_columns(a, h, cross(a, h))


def _rest(skeleton: Skeleton, bone: str, child: str, hinge: Array) -> Array:
    """Return the inverses of the frames (2, 4) of a left and right bone at rest.

    The bone extends to the head of `child`. The second axis of its frame is near to `hinge`.
    """
    along = [skeleton.head[f"{child}.{side}"] - skeleton.head[f"{bone}.{side}"] for side in SIDES]
    return inverse(_frame(np.array(along), hinge))


_ARM = (("upper_arm", "forearm"), ("forearm", "hand"))
_RESTS = {(PERSON, pair[0]): _rest(PERSON, *pair, _ARM_HINGE) for pair in _ARM} | {
    (skeleton, leg.names[k]): _rest(skeleton, leg.names[k], leg.names[k + 1], leg.hinge)
    for skeleton in (PERSON, CAT)
    for leg in skeleton.legs
    for k in (0, 1)
}


def skeleton_of(build: Build) -> Skeleton:
    """Return the skeleton of a build."""
    return CAT if build.is_cat else PERSON


def _limb(skeleton: Skeleton, bone: str, along: Array, hinge: Array) -> Array:
    """Return the rotations (n, 2, 4) of a left and right bone, along the directions `along`."""
    return compose(_frame(along, hinge), _RESTS[skeleton, bone])


def two_bones(
    start: Array, end: Array, first: float, second: float, pole: Array
) -> tuple[Array, Array, Array]:
    """Solve the two-bone inverse kinematics by the law of cosines.

    Parameters
    ----------
    start, end : array, shape (…, 3)
        Head of the first bone, and target of the second bone's tail, m.
    first, second : float
        Lengths of the bones, m.
    pole : array, shape (…, 3)
        The direction in which the joint between the bones points.

    Returns
    -------
    first_direction, second_direction : array, shape (…, 3)
        Unit vectors along the bones. If the target is out of reach, the bones point at it.
    hinge : array, shape (…, 3)
        The axis of the joint.
    """
    span = end - start
    length = np.linalg.norm(span, axis=-1, keepdims=True)
    reach = np.clip(length, abs(first - second) + 1e-4, first + second - 1e-4)
    along = normalised(span)
    side = normalised(pole - along * (pole * along).sum(-1, keepdims=True))
    cosine = (first**2 + reach**2 - second**2) / (2 * first * reach)
    joint = first * (along * cosine + side * np.sqrt(np.maximum(0.0, 1 - cosine**2)))
    return normalised(joint), normalised(along * reach - joint), cross(along, -side)


def _bend(angles: Array, share: float) -> Array:
    """Return the rotations by a share of the angles (…, 3), which are roll, pitch and yaw."""
    x, y, z = np.moveaxis(angles * share, -1, 0)
    return compose_all(rotation_z(z), rotation_y(y), rotation_x(x))


def _follow(found: Bones, pose: BodyPose, bone: str, bend: Array, share: float) -> None:
    """Add a bone to `found`, rotated against its parent by a share of the angles `bend`."""
    found.at[bone] = joint(found, pose, bone)
    found.turn[bone] = compose(found.turn[skeleton_of(pose.build).parent[bone]], _bend(bend, share))


def trunk(pose: BodyPose, head: bool = True) -> Bones:
    """Return pelvis, spine and chest, and, if `head` is True, neck and head."""
    pose = pose.take(slice(None))
    found = Bones({"pelvis": pose.turn}, {"pelvis": pose.pelvis})
    follows = [("spine", pose.spine, 0.5), ("chest", pose.spine, 0.5)]
    if head:
        follows += [("neck", pose.look, 0.4), ("head", pose.look, 0.6)]
    for bone, bend, share in follows:
        _follow(found, pose, bone, bend, share)
    return found


def joint(bones: Bones, pose: BodyPose, bone: str) -> Array:
    """Return the position (n, 3) of a bone's head, which follows from the bone's parent."""
    skeleton = skeleton_of(pose.build)
    above = skeleton.parent[bone]
    offset = (skeleton.head[bone] - skeleton.head[above]) * pose.build.scale
    return bones.at[above] + rotated(bones.turn[above], offset)


def solve(pose: BodyPose) -> Bones:
    """Return the rotations and positions of all bones in a pose."""
    pose = pose.take(slice(None))
    bones = trunk(pose)
    for number, leg in enumerate(skeleton_of(pose.build).legs):
        _solve_legs(pose, bones, leg, 2 * number)
    if pose.build.is_cat:
        for bone in ("tail.1", "tail.2", "tail.3"):
            _follow(bones, pose, bone, pose.tail, 1.0)
    else:
        _solve_arms(pose, bones)
    return bones


def _both(bones: Bones, pose: BodyPose, bone: str) -> Array:
    """Store and return the positions (n, 2, 3) of the heads of a left and a right bone."""
    for side in SIDES:
        bones.at[f"{bone}.{side}"] = joint(bones, pose, f"{bone}.{side}")
    return np.stack([bones.at[f"{bone}.{side}"] for side in SIDES], 1)


def _turn_both(bones: Bones, pose: BodyPose, turns: dict[str, Array]) -> None:
    """Store the rotations (n, 2, 4) of left and right bones, and the positions of their heads.

    `turns` has parents before their children.
    """
    for bone, turn in turns.items():
        _both(bones, pose, bone)
        for k, side in enumerate(SIDES):
            bones.turn[f"{bone}.{side}"] = turn[:, k]


def _solve_legs(pose: BodyPose, bones: Bones, leg: Leg, first: int) -> None:
    """Solve a pair of legs, whose feet are number `first` and `first + 1` of the pose."""
    skeleton, scale = skeleton_of(pose.build), pose.build.scale
    ankle, knee, sole, toes = (
        getattr(pose.feet, name)[:, first : first + 2] for name in ("ankle", "knee", "turn", "toes")
    )
    upper, lower, foot, tip = leg.names
    hips = _both(bones, pose, upper)
    thigh, shin, hinge = two_bones(hips, ankle, leg.upper * scale, leg.lower * scale, knee)
    turns = _limb(skeleton, upper, thigh, hinge), _limb(skeleton, lower, shin, hinge)
    _turn_both(bones, pose, {upper: turns[0], lower: turns[1], foot: sole, tip: toes})


def _solve_arms(pose: BodyPose, bones: Bones) -> None:
    """Solve both arms from their angles and from the targets of the wrists."""
    arms, chest, scale = pose.arms, bones.turn["chest"][:, None], pose.build.scale
    whole = compose_all(
        chest,
        rotation_y(-arms.forward),
        rotation_x(SIGN * arms.away),
        rotation_z(-SIGN * arms.inward),
    )
    hinge, along = rotated(whole, _ARM_HINGE), rotated(whole, (0.0, 0.0, -1.0))
    upper = _limb(PERSON, "upper_arm", along, hinge)
    fore = _limb(PERSON, "forearm", rotated(axis_angle(hinge, arms.elbow), along), hinge)
    shoulders = _both(bones, pose, "upper_arm")
    if arms.grip.max() > 0:
        pole = rotated(chest, [(-0.35, 0.45, -0.8), (-0.35, -0.45, -0.8)])
        a, b, axis = two_bones(shoulders, arms.target, UPPER_ARM * scale, FOREARM * scale, pole)
        # A pose without grip must not depend on the other poses of the array, by no bit.
        drawn = arms.grip[..., None] > 0
        gripping = slerp(upper, _limb(PERSON, "upper_arm", a, axis), arms.grip)
        upper = np.where(drawn, gripping, upper)
        fore = np.where(drawn, slerp(fore, _limb(PERSON, "forearm", b, axis), arms.grip), fore)
    upper, fore = (np.broadcast_to(turn, (len(shoulders), 2, 4)) for turn in (upper, fore))
    _turn_both(bones, pose, {"upper_arm": upper, "forearm": fore, "hand": fore})


# The animated channels of an armature.

# Path, index and values (n,) of a channel.
Channel = tuple[str, int, Array]


def channels(
    pose: BodyPose, rest: Mapping[str, Array], bones: Bones | None = None
) -> Iterator[Channel]:
    """Yield the animated channels of an armature object.

    These are the object's location on the floor under the pelvis, its heading, the height of the
    pelvis, and the rotations of the pose bones.

    Parameters
    ----------
    pose : BodyPose
        The poses at n times.
    rest : mapping of str to array, shape (4,)
        The orientation of each bone's axes at rest.
    bones : Bones, optional
        The result of `solve` for the pose, if the caller has it.

    Yields
    ------
    path, index, values
        Data path and array index of the channel, and its values (n,) in m or rad.
    """
    bones = bones or solve(pose)
    scale = pose.build.scale
    at_rest = skeleton_of(pose.build).head["pelvis"]
    root = pose.pelvis - rotated(rotation_z(pose.heading), at_rest * scale)
    lift = (root[:, 2:] - pose.walker[:, 2:3]) / scale * np.array([0.0, 0.0, 1.0])
    root = np.concatenate([root[:, :2], pose.walker[:, 2:3]], 1)
    for axis in range(3):
        yield "location", axis, root[:, axis]
    yield "rotation_euler", 2, pose.heading
    moved = rotated(inverse(rest["pelvis"]), lift)
    for axis in range(3):
        yield 'pose.bones["pelvis"].location', axis, moved[:, axis]
    for bone, turn in local_rotations(pose, bones, rest).items():
        for axis in range(4):
            yield f'pose.bones["{bone}"].rotation_quaternion', axis, turn[:, axis]


def local_rotations(pose: BodyPose, bones: Bones, rest: Mapping[str, Array]) -> dict[str, Array]:
    """Return the rotations (n, 4) of the pose bones against their parents, in bone axes.

    `rest` has the orientation of each bone's axes at rest. The signs of the quaternions are such
    that consecutive ones are close.
    """
    local = {}
    for bone, turn in bones.turn.items():
        above = skeleton_of(pose.build).parent[bone]
        base = bones.turn[above] if above else rotation_z(pose.heading)
        own = compose_all(inverse(rest[bone]), inverse(base), turn, rest[bone])
        flips = np.sign((own[1:] * own[:-1]).sum(1))
        own[1:] *= np.cumprod(np.where(flips < 0, -1.0, 1.0))[:, None]
        local[bone] = own
    return local
