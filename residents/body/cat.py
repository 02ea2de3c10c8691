# SPDX-License-Identifier: GPL-3.0-or-later
"""The poses of a cat (standing, walking, sitting and lying), and the shape of its fur.

A cat's position is the point under the middle of its body. Its paws are in the order hind left,
hind right, fore left, fore right.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from math import ceil, pi

import numpy as np

from ...sensor_logic.model import Array
from . import surface as sf
from .cat_skeleton import BACK_HEIGHT, CAT, HIP, HOCK, SHOULDER, WRIST
from .gait import Footstep, Stance, near_turn
from .pose import Arms, BodyPose, Feet
from .skeleton import Build
from .skin import Part
from .surface import Shape
from .turns import X, compose, ease, rotated, rotation_y, rotation_z

_PAWS = tuple((leg.names[3], leg.names[2], side) for leg in CAT.legs for side in "LR")
# Contact points of the paws, and the joints above the paws from there, at rest, (4, 3) m.
_BALLS = np.array([CAT.head[f"{tip}.{side}"] for tip, _, side in _PAWS])
_ABOVE = np.array([CAT.head[f"{foot}.{side}"] for _, foot, side in _PAWS]) - _BALLS
_KNEES = np.array([X, X, -X, -X])
# Shares of a cycle: when each paw lands, and how long a paw stays on the floor.
_LANDS, _BEARS = np.array([0.0, 0.5, 0.25, 0.75]), 0.62
_STRIDE = 0.30  # length of a cycle at the usual speed, m
_LIFT = 0.035
_TURN_LENGTH = 0.12  # m of walking that take as long as a turn by 1 rad
_PELVIS = CAT.head["pelvis"]


def _posture(
    build: Build, middle: Array, yaw: Array, balls: Array, soles: Array,
    bend: tuple[Array, Array, Array], pitch: float = 0.0, sink: tuple[float, float] = (0.0, 0.0),
) -> BodyPose:  # fmt: skip
    """Return the poses of a cat over points `middle` (n, 3).

    Parameters
    ----------
    build : Build
        The cat's build.
    middle : array, shape (n, 3)
        The point under the middle of the body, m.
    yaw : array, shape (n,)
        The direction of the body, rad.
    balls : array, shape (n, 4, 3)
        The balls of the paws, m.
    soles : array, shape (n, 4, 4)
        The rotations of the paws, as quaternions.
    bend : tuple of 3 arrays, shape (n, 3)
        The angles of spine, head and tail, rad.
    pitch : float
        The angle by which the chest is lifted, rad.
    sink : tuple of 2 floats
        The distance of the hips in front of and below their standing position, m.
    """
    scale = build.scale
    ahead = rotation_z(yaw)
    hips = _PELVIS + np.array([sink[0], 0.0, -sink[1]])
    feet = Feet(
        balls + rotated(soles, _ABOVE * scale), soles, soles, rotated(ahead[:, None], _KNEES)
    )  # fmt: skip
    spine, look, tail = bend
    turn = compose(ahead, rotation_y(np.full(len(yaw), -pitch)))
    return BodyPose(
        build, yaw, middle + rotated(ahead, hips * scale), turn, feet, Arms(), spine, look,
        np.concatenate([middle, yaw[:, None]], 1), tail,
    )  # fmt: skip


def _at(x: float, y: float, z: float, yaw: float) -> tuple[Array, Array]:
    return np.array([[x, y, z]]), np.array([yaw])


def _points_around(middle: Array, yaw: Array, offsets: Array, scale: float) -> Array:
    """Return the points (n, 4, 3) at `offsets` (4, 3) from the points under the body.

    The offsets turn with the body's `yaw` and are multiplied by `scale`.
    """
    return middle[:, None] + rotated(rotation_z(yaw)[:, None], offsets * scale)


_TAIL_DOWN = np.array([[0.0, 0.10, 0.0]])


def standing(stand: Stance, floor: float, build: Build) -> BodyPose:
    """Return one pose (n = 1) of a cat that stands on four paws."""
    middle, yaw = _at(*stand.centre, floor, stand.yaw)
    soles = np.broadcast_to(rotation_z(yaw)[:, None], (1, 4, 4))
    balls = _points_around(middle, yaw, _BALLS, build.scale)
    still = np.zeros((1, 3))
    return _posture(build, middle, yaw, balls, soles, (still, still, _TAIL_DOWN))


def sitting(stand: BodyPose, seat: Array) -> BodyPose:
    """Return one pose (n = 1) of a cat that sits at a point (3,), with the heading of `stand`."""
    build, yaw = stand.build, stand.heading[:1]
    middle = np.asarray(seat, float)[None]
    offsets = _BALLS + np.array([[0.02, 0.0, 0.0]] * 2 + [[0.0, 0.0, 0.0]] * 2)
    flat = np.array([-1.265, -1.265, 0.0, 0.0])
    soles = compose(rotation_z(yaw)[:, None], rotation_y(flat))
    bend = (
        np.array([[0.0, -0.10, 0.0]]), np.array([[0.0, 0.62, 0.0]]), np.array([[0.0, -0.16, 0.45]]),
    )  # fmt: skip
    balls = _points_around(middle, yaw, offsets, build.scale)
    return _posture(build, middle, yaw, balls, soles, bend, 0.58, (0.03, BACK_HEIGHT - 0.100))


def lying(seated: BodyPose, bed: Array, yaw: float, side: int = 0) -> BodyPose:
    """Return one pose (n = 1) of a cat that lies on its belly on the point `bed` (3,).

    The body is straight (side 0), or curled to the left (1) or right (−1).
    """
    build = seated.build
    x, y, z = map(float, bed)
    middle, heading = _at(x, y, z, near_turn(yaw, float(seated.heading[0])))
    offsets = _BALLS + np.array([[0.06, 0.0, 0.0]] * 2 + [[0.05, 0.0, 0.0]] * 2)
    soles = compose(
        rotation_z(heading)[:, None], rotation_y(np.array([-1.265, -1.265, -1.3, -1.3]))
    )
    bend = (
        np.array([[0.0, 0.0, 0.45 * side]]),
        np.array([[0.0, 0.30 - 0.1 * abs(side), 0.5 * side]]),
        np.array([[0.0, -0.03, -0.55 * side]]),
    )
    balls = _points_around(middle, heading, offsets, build.scale)
    sink = (0.0, BACK_HEIGHT - 0.075)
    return _posture(build, middle, heading, balls, soles, bend, sink=sink)


def going(before: BodyPose, after: BodyPose, t: Array) -> BodyPose:
    """Interpolate between two postures, from `before` (t = 0) to `after` (t = 1).

    If the cat gets to another position, it leaps.
    """
    s = ease(t)
    pose = before.interpolated(after, s)
    way = float(np.linalg.norm(after.walker[0, :3] - before.walker[0, :3]))
    rise = abs(float(after.walker[0, 2] - before.walker[0, 2]))
    up = (0.02 * pose.build.scale + 0.4 * rise + 0.05 * way) * np.sin(pi * s)
    lift = up[:, None] * np.array([0.0, 0.0, 1.0])
    feet = replace(pose.feet, ankle=pose.feet.ankle + lift[:, None])
    whole = 1.0 if way > 0.05 else 0.0
    return replace(pose, pelvis=pose.pelvis + whole * lift, feet=feet)


def shifted(pose: BodyPose, _times: Array, weight: Array) -> BodyPose:
    """Return the poses with the head raised and turned; `weight` (n,) is 0 … 1."""
    w = weight[:, None]
    return replace(pose, look=pose.look + w * (0.0, -0.35, 0.6), tail=pose.tail + w * (0, 0, 0.35))


def footsteps(start: Stance, path: Array, end_yaw: float | None, build: Build) -> list[Footstep]:
    """Return points of the cat's path as footsteps, each with the heading there.

    Turns on the spot at both ends are included.
    """
    found = [Footstep(0, *start.centre, start.yaw)]

    def turn(to: float) -> None:
        here = found[-1]
        count = ceil(abs(to - here.yaw) / 0.1)
        for k in range(1, count + 1):
            found.append(replace(here, yaw=here.yaw + (to - here.yaw) * k / count))

    gaps = np.diff(path, axis=0)
    lengths = np.hypot(*gaps.T)
    if lengths.sum() > 0.04:
        bends = np.unwrap(np.arctan2(gaps[:, 1], gaps[:, 0])[lengths > 1e-9])
        points = path[1:][lengths > 1e-9]
        bends += near_turn(float(bends[0]), start.yaw) - bends[0]
        turn(float(bends[0]))
        for (x, y), yaw in zip(points, bends, strict=True):
            found.append(Footstep(0, float(x), float(y), float(yaw)))
    if end_yaw is not None:
        turn(near_turn(end_yaw, found[-1].yaw))
    return found if len(found) > 1 else [found[0]] * 2


class CatWalk:
    """A cat's walk along the points from `footsteps`.

    `speed` is in m/s, and `floor` is the height of the floor in m.
    """

    def __init__(self, steps: list[Footstep], speed: float, floor: float, build: Build) -> None:
        self.build, self.floor, self.speed = build, floor, speed
        way = np.array([(step.x, step.y, step.yaw) for step in steps])
        gaps = np.abs(np.diff(way, axis=0))
        length = np.hypot(gaps[:, 0], gaps[:, 1]) + _TURN_LENGTH * build.scale * gaps[:, 2]
        keep = np.concatenate([[True], length > 1e-9])
        self._way, self._along = way[keep], np.concatenate([[0.0], np.cumsum(length)])[keep]
        self.length = float(self._along[-1])
        self.stride = _STRIDE * build.scale * (speed / 0.55) ** 0.5
        self.soft = min(self.stride / 6, self.length / 2)
        self.last = self.length + 1.5 * self.stride
        self.duration = self.last / speed

    @property
    def end(self) -> Stance:
        """The stance at the end of the walk."""
        x, y, yaw = map(float, self._way[-1])
        return Stance.at(x, y, yaw, self.build)

    def track(self) -> tuple[Array, Array]:
        """Return times (k,) since the start, s, and the body's positions (k, 2) at them, m."""
        return (self._along + self.stride / 2) / self.speed, self._way[:, :2]

    def _body_distance(self, w: Array) -> Array:
        """Return how far the body is along the path when the paws have gone `w` m, shape (…,)."""

        def ramp(x: Array) -> Array:
            soft = max(self.soft, 1e-9)
            return np.where(x < -soft, 0.0, np.where(x < soft, (x + soft) ** 2 / (4 * soft), x))

        return self.length - ramp(self.length - ramp(w - self.stride / 2))

    def _position_on_path(self, along: Array) -> Array:
        """Return x, y and yaw (…, 3) at distances along the path.

        The yaw is averaged over a short piece of the path.
        """
        xy = [np.interp(along, self._along, self._way[:, k]) for k in (0, 1)]
        offsets = np.linspace(-0.08, 0.08, 9) * self.build.scale
        room = np.minimum(along, self.length - along)[..., None]
        around = along[..., None] + np.clip(offsets, -room, room)
        yaw = np.interp(around, self._along, self._way[:, 2]).mean(-1)
        return np.stack([*xy, yaw], -1)

    def pose(self, seconds: Array) -> BodyPose:
        """Return the poses at times `seconds` (n,) since the start of the walk."""
        w = np.clip(np.asarray(seconds, float) / self.duration, 0.0, 1.0) * self.last
        body = self._position_on_path(self._body_distance(w))
        yaw = np.ascontiguousarray(body[:, 2])
        middle = np.concatenate([body[:, :2], np.full((len(w), 1), self.floor)], 1)
        balls, paws_yaw = self._paw_positions(w)
        scale = self.build.scale
        # A paw tilts while it stays on the floor and the body moves on.
        local = rotated(rotation_z(-yaw)[:, None], balls - middle[:, None]) / scale - _BALLS
        soles = compose(rotation_z(paws_yaw), rotation_y(np.clip(-6.0 * local[..., 0], -0.8, 0.8)))
        ahead = (
            self._position_on_path(np.minimum(self._body_distance(w) + 0.12 * scale, self.length))[
                :, 2
            ]
            - yaw
        )
        beat = 2 * pi * w / self.stride
        busy = ease(np.minimum(w, self.last - w) / (self.stride / 2))
        spine = np.stack([0 * w, 0 * w, np.clip(0.6 * ahead, -0.4, 0.4) * busy], -1)
        look = np.stack([0 * w, 0.04 * np.sin(beat) * busy, np.clip(ahead, -0.6, 0.6) * busy], -1)
        tail = _TAIL_DOWN + busy[:, None] * np.stack(
            [0 * w, -0.22 + 0 * w, 0.10 * np.sin(beat / 2)], -1
        )  # fmt: skip
        pose = _posture(self.build, middle, yaw, balls, soles, (spine, look, tail))
        bob = 0.006 * scale * busy * (np.cos(2 * beat) - 1)
        return replace(pose, pelvis=pose.pelvis + bob[:, None] * np.array([0.0, 0.0, 1.0]))

    def _paw_positions(self, w: Array) -> tuple[Array, Array]:
        """Return positions (n, 4, 3) and yaws (n, 4) of the paws after distances `w` (n,), m."""
        phase = w[:, None] / self.stride - _LANDS
        number = np.floor(phase)
        lands = (number + _LANDS) * self.stride
        here = self._position_on_path(self._body_distance(lands + _BEARS / 2 * self.stride))
        after = self._position_on_path(self._body_distance(lands + (1 + _BEARS / 2) * self.stride))
        # At the start all paws are on the floor.
        leaves = np.maximum(lands + _BEARS * self.stride, 0.0)
        air = np.clip((w[:, None] - leaves) / (lands + self.stride - leaves), 0.0, 1.0)
        feet = [
            np.concatenate([at[..., :2], np.full((*at.shape[:2], 1), self.floor)], -1)
            + rotated(rotation_z(at[..., 2]), _BALLS * self.build.scale)
            for at in (here, after)
        ]
        balls = feet[0] + ease(air)[..., None] * (feet[1] - feet[0])
        far = np.linalg.norm(feet[1] - feet[0], axis=-1)
        lift = _LIFT * self.build.scale * np.minimum(1.0, far / (0.5 * self.stride))
        balls[..., 2] += lift * np.sin(pi * air) ** 2
        return balls, here[..., 2] + ease(air) * (after[..., 2] - here[..., 2])


# The shapes of the fur at rest, and the weights of its bones.

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
    """Return the shape of a cat's fur."""
    at = CAT.head
    hind = _leg(HIP - np.array([0.0, 0.0, 0.01]), at["shin.L"], HOCK, at["toes.L"], 0.046)
    fore = _leg(SHOULDER, at["forearm.L"], WRIST, at["fingers.L"], 0.032)
    tail = [at[f"tail.{k}"] for k in (1, 2, 3)] + [np.array([-0.39, 0.0, 0.165])]
    parts = [sf.capsule(a, b, 0.016, 0.014) for a, b in pairwise(tail)]
    legs = [sf.union(0.004, leg, sf.mirrored(leg)) for leg in (hind, fore)]
    return sf.union(0.022, sf.union(0.03, _trunk(), _head()), *legs, *parts)


def cat_parts() -> list[Part]:
    """Return the closed surfaces of a cat: its fur and its eyes."""
    low, high = (-0.42, -0.085, -0.005), (0.26, 0.085, 0.34)
    parts = [Part("fur", "fur", fur(), low, high, 0.008, 2200, "cat")]
    for sign, side in ((1.0, "L"), (-1.0, "R")):
        eye = sf.ball((0.229, sign * 0.020, 0.276), (0.007, 0.007, 0.007))
        low, high = (0.21, sign * 0.02 - 0.015, 0.26), (0.245, sign * 0.02 + 0.015, 0.292)
        parts.append(Part(f"eye.{side}", "eye", eye, low, high, 0.003, 60, "cat"))
    return parts


def cat_weights(points: Array, _region: str) -> dict[str, Array]:
    """Return the skinning weights (n,) of each bone at points (n, 3), by the bone's name.

    Bones near to a point have larger weights. The weights at a point sum to 1.
    """
    near = {}
    # The pelvis also moves the rump behind it.
    ends = {bone.name: (np.array(bone.head), np.array(bone.tail)) for bone in CAT.bones[1:]}
    ends["pelvis"] = CAT.head["pelvis"] - np.array([0.04, 0, 0]), CAT.head["spine"]
    for name, (start, end) in ends.items():
        axis = end - start
        along = np.clip((points - start) @ axis / (axis @ axis), 0.0, 1.0)
        away = np.linalg.norm(points - start - along[:, None] * axis, axis=1)
        # A leg moves no point of the other side.
        other = {"L": points[:, 1] < -0.002, "R": points[:, 1] > 0.002}.get(name[-1:])
        weight = 1.0 / (away + 0.004) ** 4
        near[name] = weight if other is None else np.where(other, 0.0, weight)
    whole = np.sum(list(near.values()), axis=0)
    return {name: weight / whole for name, weight in near.items()}
