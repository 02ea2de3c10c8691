# SPDX-License-Identifier: GPL-3.0-or-later
"""Compute the bones of a pose by inverse kinematics, and the animation of an armature."""

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
    """The rotations and positions of the bones of a pose, by bone name.

    Attributes
    ----------
    turn : dict of str to array, shape (n, 4)
        The rotation of each bone in the world.
    at : dict of str to array, shape (n, 3)
        The position of each bone's head in the world, m.
    """

    turn: dict[str, Array]
    at: dict[str, Array]


def _frame(along: Array, hinge: Array) -> Array:
    """Return the rotation of axes whose first one is along a bone.

    The second axis is perpendicular to the bone, and as near to `hinge` as possible.
    """
    a = normalised(along)
    h = normalised(hinge - a * (hinge * a).sum(-1, keepdims=True))
    return from_columns(a, h, cross(a, h))


def _rest_rotations(skeleton: Skeleton, bone: str, child: str, hinge: Array) -> Array:
    """Return the inverse rotations (2, 4) of the axes of a left and right bone at rest.

    The bone extends to the head of `child`. Its second axis is near to `hinge`.
    """
    along = [skeleton.head[f"{child}.{side}"] - skeleton.head[f"{bone}.{side}"] for side in SIDES]
    return inverse(_frame(np.array(along), hinge))


_ARM = (("upper_arm", "forearm"), ("forearm", "hand"))
_RESTS = {(PERSON, pair[0]): _rest_rotations(PERSON, *pair, _ARM_HINGE) for pair in _ARM} | {
    (skeleton, leg.names[k]): _rest_rotations(skeleton, leg.names[k], leg.names[k + 1], leg.hinge)
    for skeleton in (PERSON, CAT)
    for leg in skeleton.legs
    for k in (0, 1)
}


def skeleton_of(build: Build) -> Skeleton:
    """Return the skeleton of a body model (`build`): of a person or of a cat."""
    return CAT if build.is_cat else PERSON


def _limb_rotations(skeleton: Skeleton, bone: str, along: Array, hinge: Array) -> Array:
    """Return the rotations (n, 2, 4) of a left and right bone that point along `along`."""
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


def _bend_rotation(angles: Array, share: float) -> Array:
    """Return the rotations by `share` times the angles (…, 3) of roll, pitch and yaw."""
    x, y, z = np.moveaxis(angles * share, -1, 0)
    return compose_all(rotation_z(z), rotation_y(y), rotation_x(x))


def _add_bone(bones: Bones, pose: BodyPose, bone: str, bend: Array, share: float) -> None:
    """Add a bone to `bones`, rotated against its parent by the angles `bend` times `share`."""
    bones.at[bone] = joint(bones, pose, bone)
    bones.turn[bone] = compose(
        bones.turn[skeleton_of(pose.build).parent[bone]], _bend_rotation(bend, share)
    )


def trunk(pose: BodyPose, head: bool = True) -> Bones:
    """Return the bones of the trunk and, if `head` is True, also of neck and head."""
    pose = pose.take(slice(None))
    found = Bones({"pelvis": pose.turn}, {"pelvis": pose.pelvis})
    follows = [("spine", pose.spine, 0.5), ("chest", pose.spine, 0.5)]
    if head:
        follows += [("neck", pose.look, 0.4), ("head", pose.look, 0.6)]
    for bone, bend, share in follows:
        _add_bone(found, pose, bone, bend, share)
    return found


def joint(bones: Bones, pose: BodyPose, bone: str) -> Array:
    """Return the position (n, 3) of a bone's head, computed from the bone's parent."""
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
            _add_bone(bones, pose, bone, pose.tail, 1.0)
    else:
        _solve_arms(pose, bones)
    return bones


def _store_heads(bones: Bones, pose: BodyPose, bone: str) -> Array:
    """Store and return the positions (n, 2, 3) of the heads of a left and a right bone."""
    for side in SIDES:
        bones.at[f"{bone}.{side}"] = joint(bones, pose, f"{bone}.{side}")
    return np.stack([bones.at[f"{bone}.{side}"] for side in SIDES], 1)


def _store_rotations(bones: Bones, pose: BodyPose, turns: dict[str, Array]) -> None:
    """Store rotations (n, 2, 4) of left and right bones, and the positions of their heads.

    In `turns`, parents come before their children.
    """
    for bone, turn in turns.items():
        _store_heads(bones, pose, bone)
        for k, side in enumerate(SIDES):
            bones.turn[f"{bone}.{side}"] = turn[:, k]


def _solve_legs(pose: BodyPose, bones: Bones, leg: Leg, first: int) -> None:
    """Solve a pair of legs; `first` is the index of the pair's left foot in the pose."""
    skeleton, scale = skeleton_of(pose.build), pose.build.scale
    ankle, knee, sole, toes = (
        getattr(pose.feet, name)[:, first : first + 2] for name in ("ankle", "knee", "turn", "toes")
    )
    upper, lower, foot, tip = leg.names
    hips = _store_heads(bones, pose, upper)
    thigh, shin, hinge = two_bones(hips, ankle, leg.upper * scale, leg.lower * scale, knee)
    turns = (
        _limb_rotations(skeleton, upper, thigh, hinge),
        _limb_rotations(skeleton, lower, shin, hinge),
    )
    _store_rotations(bones, pose, {upper: turns[0], lower: turns[1], foot: sole, tip: toes})


def _solve_arms(pose: BodyPose, bones: Bones) -> None:
    arms, chest, scale = pose.arms, bones.turn["chest"][:, None], pose.build.scale
    whole = compose_all(
        chest,
        rotation_y(-arms.forward),
        rotation_x(SIGN * arms.away),
        rotation_z(-SIGN * arms.inward),
    )
    hinge, along = rotated(whole, _ARM_HINGE), rotated(whole, (0.0, 0.0, -1.0))
    upper = _limb_rotations(PERSON, "upper_arm", along, hinge)
    fore = _limb_rotations(PERSON, "forearm", rotated(axis_angle(hinge, arms.elbow), along), hinge)
    shoulders = _store_heads(bones, pose, "upper_arm")
    if arms.grip.max() > 0:
        pole = rotated(chest, [(-0.35, 0.45, -0.8), (-0.35, -0.45, -0.8)])
        a, b, axis = two_bones(shoulders, arms.target, UPPER_ARM * scale, FOREARM * scale, pole)
        # A pose without grip must not depend on the other poses of the array, by no bit.
        drawn = arms.grip[..., None] > 0
        gripping = slerp(upper, _limb_rotations(PERSON, "upper_arm", a, axis), arms.grip)
        upper = np.where(drawn, gripping, upper)
        fore = np.where(
            drawn, slerp(fore, _limb_rotations(PERSON, "forearm", b, axis), arms.grip), fore
        )
    upper, fore = (np.broadcast_to(turn, (len(shoulders), 2, 4)) for turn in (upper, fore))
    _store_rotations(bones, pose, {"upper_arm": upper, "forearm": fore, "hand": fore})


# The animated channels of an armature.

# Path, index and values (n,) of a channel.
Channel = tuple[str, int, Array]


def channels(
    pose: BodyPose, rest: Mapping[str, Array], bones: Bones | None = None
) -> Iterator[Channel]:
    """Yield the animated channels of an armature object.

    The object gets its location on the floor and its heading. The pose bones get the height of the
    pelvis and their rotations.

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

    `rest` has the orientation of each bone's axes at rest. Consecutive quaternions have signs that
    keep them close.
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
