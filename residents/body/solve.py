# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes the turn of each bone and the place of its head from a pose, and from these the channels
of an armature."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from ...sensor_logic.model import Array
from .cat_skeleton import CAT
from .pose import BodyPose
from .skeleton import FOREARM, PERSON, SIDES, SIGN, UPPER_ARM, Build, Leg, Skeleton
from .turns import (
    about_axis,
    about_x,
    about_y,
    about_z,
    back,
    chained,
    cross,
    from_columns,
    mix_turns,
    times,
    turned,
    unit,
)

THIGH, SHIN = PERSON.legs[0].upper, PERSON.legs[0].lower
_ARM_HINGE = np.array([0.0, -1.0, 0.0])


@dataclass(frozen=True)
class Bones:
    """The turn (n, 4) of each bone and the place (n, 3) of its head, both in the world."""

    turn: dict[str, Array]
    at: dict[str, Array]


def _frame(along: Array, hinge: Array) -> Array:
    """The turn of a frame along a bone, its second axis as near to the hinge as can be."""
    a = unit(along)
    h = unit(hinge - a * (hinge * a).sum(-1, keepdims=True))
    return from_columns(a, h, cross(a, h))


def _rest(skeleton: Skeleton, bone: str, child: str, hinge: Array) -> Array:
    """Back from the frames of a limb's bones at rest, (2, 4): left and right."""
    along = [skeleton.head[f"{child}.{side}"] - skeleton.head[f"{bone}.{side}"] for side in SIDES]
    return back(_frame(np.array(along), hinge))


_ARM = (("upper_arm", "forearm"), ("forearm", "hand"))
_RESTS = {(PERSON, pair[0]): _rest(PERSON, *pair, _ARM_HINGE) for pair in _ARM} | {
    (skeleton, leg.names[k]): _rest(skeleton, leg.names[k], leg.names[k + 1], leg.hinge)
    for skeleton in (PERSON, CAT)
    for leg in skeleton.legs
    for k in (0, 1)
}


def skeleton_of(build: Build) -> Skeleton:
    return CAT if build.is_cat else PERSON


def _limb(skeleton: Skeleton, bone: str, along: Array, hinge: Array) -> Array:
    """Turns (n, 2, 4) of both sides' bones."""
    return times(_frame(along, hinge), _RESTS[skeleton, bone])


def two_bones(
    start: Array, end: Array, first: float, second: float, pole: Array
) -> tuple[Array, Array, Array]:
    """Directions of two bones from start to end, and the hinge between them, all (…, 3).

    The joint lies on the pole's side. Law of cosines; an end out of reach is reached for.
    """
    span = end - start
    length = np.linalg.norm(span, axis=-1, keepdims=True)
    reach = np.clip(length, abs(first - second) + 1e-4, first + second - 1e-4)
    along = unit(span)
    side = unit(pole - along * (pole * along).sum(-1, keepdims=True))
    cosine = (first**2 + reach**2 - second**2) / (2 * first * reach)
    joint = first * (along * cosine + side * np.sqrt(np.maximum(0.0, 1 - cosine**2)))
    return unit(joint), unit(along * reach - joint), cross(along, -side)


def _bend(angles: Array, share: float) -> Array:
    x, y, z = np.moveaxis(angles * share, -1, 0)
    return chained(about_z(z), about_y(y), about_x(x))


def _follow(found: Bones, pose: BodyPose, bone: str, bend: Array, share: float) -> None:
    """A bone that is bent against the one above it."""
    found.at[bone] = joint(found, pose, bone)
    found.turn[bone] = times(found.turn[skeleton_of(pose.build).parent[bone]], _bend(bend, share))


def trunk(pose: BodyPose, head: bool = True) -> Bones:
    """Pelvis, spine and chest; neck and head."""
    pose = pose.take(slice(None))
    found = Bones({"pelvis": pose.turn}, {"pelvis": pose.pelvis})
    follows = [("spine", pose.spine, 0.5), ("chest", pose.spine, 0.5)]
    if head:
        follows += [("neck", pose.look, 0.4), ("head", pose.look, 0.6)]
    for bone, bend, share in follows:
        _follow(found, pose, bone, bend, share)
    return found


def joint(bones: Bones, pose: BodyPose, bone: str) -> Array:
    """The place (n, 3) of a bone's head, at the bone above it."""
    skeleton = skeleton_of(pose.build)
    above = skeleton.parent[bone]
    offset = (skeleton.head[bone] - skeleton.head[above]) * pose.build.scale
    return bones.at[above] + turned(bones.turn[above], offset)


def solve(pose: BodyPose) -> Bones:
    """All bones of the body."""
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
    """Where the heads of both sides' bones are, (n, 2, 3); it notes them."""
    for side in SIDES:
        bones.at[f"{bone}.{side}"] = joint(bones, pose, f"{bone}.{side}")
    return np.stack([bones.at[f"{bone}.{side}"] for side in SIDES], 1)


def _turn_both(bones: Bones, pose: BodyPose, turns: dict[str, Array]) -> None:
    """Notes heads and turns (n, 2, 4) of both sides' bones, from the trunk on."""
    for bone, turn in turns.items():
        _both(bones, pose, bone)
        for k, side in enumerate(SIDES):
            bones.turn[f"{bone}.{side}"] = turn[:, k]


def _solve_legs(pose: BodyPose, bones: Bones, leg: Leg, first: int) -> None:
    """A pair of legs to the feet `first` and the next."""
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
    arms, chest, scale = pose.arms, bones.turn["chest"][:, None], pose.build.scale
    whole = chained(
        chest,
        about_y(-arms.forward),
        about_x(SIGN * arms.away),
        about_z(-SIGN * arms.inward),
    )
    hinge, along = turned(whole, _ARM_HINGE), turned(whole, (0.0, 0.0, -1.0))
    upper = _limb(PERSON, "upper_arm", along, hinge)
    fore = _limb(PERSON, "forearm", turned(about_axis(hinge, arms.elbow), along), hinge)
    shoulders = _both(bones, pose, "upper_arm")
    if arms.grip.max() > 0:
        pole = turned(chest, [(-0.35, 0.45, -0.8), (-0.35, -0.45, -0.8)])
        a, b, axis = two_bones(shoulders, arms.target, UPPER_ARM * scale, FOREARM * scale, pole)
        # Who reaches for nothing is as exactly as alone, whatever others do.
        drawn = arms.grip[..., None] > 0
        gripping = mix_turns(upper, _limb(PERSON, "upper_arm", a, axis), arms.grip)
        upper = np.where(drawn, gripping, upper)
        fore = np.where(drawn, mix_turns(fore, _limb(PERSON, "forearm", b, axis), arms.grip), fore)
    upper, fore = (np.broadcast_to(turn, (len(shoulders), 2, 4)) for turn in (upper, fore))
    _turn_both(bones, pose, {"upper_arm": upper, "forearm": fore, "hand": fore})


# Makes the values of an armature's animated channels from poses.

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
