# SPDX-License-Identifier: GPL-3.0-or-later
"""One moment of the body: what it is described by, and the bones' turns that follow from it.

A turn is a quaternion from the bone's rest to its pose, in world axes. Lengths are metres,
angles radians; the sides are 0 for left, 1 for right.
"""

from dataclasses import dataclass, field, replace
from math import sqrt

from mathutils import Matrix, Quaternion, Vector

from .skeleton import ANKLE as _ANKLE
from .skeleton import BALL, FOREARM, HEAD, HEEL_X, PARENT, TOE, UPPER_ARM

SIDES = ("L", "R")
SIGN = (1.0, -1.0)
ANKLE_HEIGHT = float(_ANKLE[2])
BALL_AHEAD = float(BALL[0] - _ANKLE[0])  # of the ankle, along the sole
TOE_AHEAD = float(TOE[0] - _ANKLE[0])
HEEL_BEHIND = float(_ANKLE[0] - HEEL_X)
STAND_HEIGHT = 0.932  # of the pelvis above the sole: the knees are not quite straight
_REST = {name: Vector(head) for name, head in HEAD.items()}
THIGH = (_REST["shin.L"] - _REST["thigh.L"]).length
SHIN = (_REST["foot.L"] - _REST["shin.L"]).length

Pair = tuple[Vector, Vector]


def about_z(angle: float) -> Quaternion:
    return Quaternion((0, 0, 1), angle)


def about_y(angle: float) -> Quaternion:
    return Quaternion((0, 1, 0), angle)


def about_x(angle: float) -> Quaternion:
    return Quaternion((1, 0, 0), angle)


def ease(t: float) -> float:
    """0 to 1 with soft ends."""
    t = min(max(t, 0.0), 1.0)
    return t * t * (3 - 2 * t)


def mix(a: float, b: float, t: float) -> float:
    return a + (b - a) * t


@dataclass
class Foot:
    """The ankle in the world, the sole's turn, the toes' turn."""

    ankle: Vector
    turn: Quaternion
    toes: Quaternion
    knee: Vector  # the direction in which the knee points

    def mixed(self, other: "Foot", t: float) -> "Foot":
        return Foot(
            self.ankle.lerp(other.ankle, t),
            self.turn.slerp(other.turn, t),
            self.toes.slerp(other.toes, t),
            self.knee.lerp(other.knee, t),
        )


@dataclass
class Arm:
    """Angles against the chest, and where the wrist is drawn to (grip 0 … 1)."""

    forward: float = 0.03
    away: float = 0.09
    inward: float = 0.25  # the arm's turn about itself
    elbow: float = 0.22
    target: Vector = field(default_factory=Vector)
    grip: float = 0.0

    def mixed(self, other: "Arm", t: float) -> "Arm":
        # Each target counts as much as its grip: one without says nothing.
        a, b = self.grip * (1 - t), other.grip * t
        target = self.target.lerp(other.target, b / (a + b)) if a + b > 0 else other.target
        angles = {
            name: mix(getattr(self, name), getattr(other, name), t)
            for name in ("forward", "away", "inward", "elbow", "grip")
        }
        return Arm(target=target, **angles)


@dataclass
class Pose:
    """The whole body; spine and look are (roll to the right, forward pitch, yaw to the left)."""

    heading: float  # of the armature object, continuous (not folded into one turn)
    pelvis: Vector
    turn: Quaternion
    feet: tuple[Foot, Foot]
    arms: tuple[Arm, Arm] = field(default_factory=lambda: (Arm(), Arm()))
    spine: Vector = field(default_factory=Vector)
    look: Vector = field(default_factory=Vector)

    def mixed(self, other: "Pose", t: float) -> "Pose":
        return Pose(
            mix(self.heading, other.heading, t),
            self.pelvis.lerp(other.pelvis, t),
            self.turn.slerp(other.turn, t),
            (self.feet[0].mixed(other.feet[0], t), self.feet[1].mixed(other.feet[1], t)),
            (self.arms[0].mixed(other.arms[0], t), self.arms[1].mixed(other.arms[1], t)),
            self.spine.lerp(other.spine, t),
            self.look.lerp(other.look, t),
        )

    def with_arm(self, side: int, arm: Arm) -> "Pose":
        arms = (arm, self.arms[1]) if side == 0 else (self.arms[0], arm)
        return replace(self, arms=arms)


def flat_foot(x: float, y: float, yaw: float, floor: float) -> Foot:
    """A foot that stands on the floor; (x, y) is under the ankle."""
    turn = about_z(yaw)
    return Foot(Vector((x, y, floor + ANKLE_HEIGHT)), turn, turn, turn @ Vector((1, 0, 0)))


def _basis(along: Vector, hinge: Vector) -> Matrix:
    """Columns: along the bone, the hinge's axis made square to it, their product."""
    a = along.normalized()
    h = (hinge - a * hinge.dot(a)).normalized()
    return Matrix((a, h, a.cross(h))).transposed()


def _rest_basis(bone: str, child: str, hinge: Vector) -> Matrix:
    return _basis(_REST[child] - _REST[bone], hinge)


_ARM_HINGE, _LEG_HINGE = Vector((0, -1, 0)), Vector((0, 1, 0))
_LIMB_REST = {
    bone: _rest_basis(bone, child, hinge).transposed()
    for side in SIDES
    for bone, child, hinge in (
        (f"upper_arm.{side}", f"forearm.{side}", _ARM_HINGE),
        (f"forearm.{side}", f"hand.{side}", _ARM_HINGE),
        (f"thigh.{side}", f"shin.{side}", _LEG_HINGE),
        (f"shin.{side}", f"foot.{side}", _LEG_HINGE),
    )
}


def two_bones(
    start: Vector, end: Vector, first: float, second: float, pole: Vector
) -> tuple[Vector, Vector, Vector]:
    """Directions of two bones from start to end, and the hinge between them.

    The joint lies on the pole's side. Law of cosines; an end out of reach is reached for.
    """
    span = end - start
    reach = min(max(span.length, abs(first - second) + 1e-4), first + second - 1e-4)
    along = span.normalized()
    side = (pole - along * pole.dot(along)).normalized()
    cosine = (first**2 + reach**2 - second**2) / (2 * first * reach)
    joint = along * (first * cosine) + side * (first * sqrt(max(0.0, 1 - cosine**2)))
    return joint.normalized(), (along * reach - joint).normalized(), along.cross(-side)


def _limb_turn(bone: str, along: Vector, hinge: Vector) -> Quaternion:
    return (_basis(along, hinge) @ _LIMB_REST[bone]).to_quaternion()


def _euler(v: Vector, share: float) -> Quaternion:
    return about_z(v.z * share) @ about_y(v.y * share) @ about_x(v.x * share)


def solve(pose: Pose) -> tuple[dict[str, Quaternion], dict[str, Vector]]:
    """The turn of every bone and where its head is, both in the world."""
    turn = {"pelvis": pose.turn}
    at = {"pelvis": pose.pelvis}

    def joint(bone: str) -> Vector:
        above = PARENT[bone]
        at[bone] = at[above] + turn[above] @ (_REST[bone] - _REST[above])
        return at[bone]

    for bone, bend, share in (
        ("spine", pose.spine, 0.5),
        ("chest", pose.spine, 0.5),
        ("neck", pose.look, 0.4),
        ("head", pose.look, 0.6),
    ):
        joint(bone)
        turn[bone] = turn[PARENT[bone]] @ _euler(bend, share)
    for k, side in enumerate(SIDES):
        _solve_leg(pose.feet[k], side, turn, joint)
        _solve_arm(pose.arms[k], k, turn, joint)
    return turn, at


def _solve_leg(foot: Foot, side: str, turn: dict, joint) -> None:
    thigh, shin, hinge = two_bones(joint(f"thigh.{side}"), foot.ankle, THIGH, SHIN, foot.knee)
    turn[f"thigh.{side}"] = _limb_turn(f"thigh.{side}", thigh, hinge)
    joint(f"shin.{side}")
    turn[f"shin.{side}"] = _limb_turn(f"shin.{side}", shin, hinge)
    joint(f"foot.{side}")
    turn[f"foot.{side}"] = foot.turn
    joint(f"toes.{side}")
    turn[f"toes.{side}"] = foot.toes


def _solve_arm(arm: Arm, k: int, turn: dict, joint) -> None:
    side, sign, chest = SIDES[k], SIGN[k], turn["chest"]
    upper_bone, fore_bone = f"upper_arm.{side}", f"forearm.{side}"
    swing = about_y(-arm.forward) @ about_x(sign * arm.away) @ about_z(-sign * arm.inward)
    whole = chest @ swing
    hinge = whole @ _ARM_HINGE
    along = whole @ Vector((0, 0, -1))
    upper = _limb_turn(upper_bone, along, hinge)
    fore = _limb_turn(fore_bone, Quaternion(hinge, arm.elbow) @ along, hinge)
    shoulder = joint(upper_bone)
    if arm.grip > 0:
        pole = chest @ Vector((-0.35, 0.45 * sign, -0.8))
        a, b, axis = two_bones(shoulder, arm.target, UPPER_ARM, FOREARM, pole)
        upper = upper.slerp(_limb_turn(upper_bone, a, axis), arm.grip)
        fore = fore.slerp(_limb_turn(fore_bone, b, axis), arm.grip)
    turn[upper_bone] = upper
    joint(fore_bone)
    turn[fore_bone] = fore
    joint(f"hand.{side}")
    turn[f"hand.{side}"] = fore
