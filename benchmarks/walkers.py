# SPDX-License-Identifier: GPL-3.0-or-later
"""Moving bodies in front of a motion detector, built of boxes, in a furnished room.

People, a child, a cat and an arm. Pure numpy: closed-form intersections of rays and boxes in
float64.

NEMA WD 7: major motion is a person who walks at 4 ft/s and stops for 2 s at the edge of every 3 ft
cell. Minor motion is an arm of 3 × 3 × 15 in that turns by 90° at 90°/s, 36 in above the floor.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from angen_sensors.sensor_logic.model import Pose

Array = np.typing.NDArray[np.float64]
INCH, FOOT = 0.0254, 0.3048
# Extents of the room in metres; the detector hangs in the middle of the wall x = 0.
ROOM = (4.6, 4.0, 2.5)
SENSOR = Pose(np.array([0.02, 2.0, 2.2]), np.array([[0, 0, -1], [-1, 0, 0], [0, 1, 0]], np.float64))
# Lower and upper corners of the walls and of the furniture.
WALLS = (
    ((-0.1, -0.1, 0.0), (0.0, 4.1, 2.5)),
    ((4.6, -0.1, 0.0), (4.7, 4.1, 2.5)),
    ((-0.1, -0.1, 0.0), (4.7, 0.0, 2.5)),
    ((-0.1, 4.0, 0.0), (4.7, 4.1, 2.5)),
    ((-0.1, -0.1, -0.1), (4.7, 4.1, 0.0)),
    ((-0.1, -0.1, 2.5), (4.7, 4.1, 2.6)),
)
FURNITURE = (
    ((1.2, 0.05, 0.0), (3.2, 0.9, 0.42)),  # sofa: seat
    ((1.2, 0.0, 0.42), (3.2, 0.2, 0.85)),  # sofa: back
    ((3.9, 2.6, 0.0), (4.55, 3.9, 1.9)),  # cupboard
    ((1.9, 1.5, 0.38), (2.7, 1.95, 0.42)),  # low table: top
    ((1.92, 1.52, 0.0), (1.97, 1.57, 0.38)),
    ((2.63, 1.88, 0.0), (2.68, 1.93, 0.38)),
    ((0.5, 3.2, 0.7), (1.7, 3.9, 0.74)),  # desk: top
    ((0.5, 3.25, 0.0), (0.55, 3.9, 0.7)),
    ((1.65, 3.25, 0.0), (1.7, 3.9, 0.7)),
)
# Walkers keep at least this distance (m) from furniture and walls.
CLEAR = 0.3


@dataclass(frozen=True)
class Boxes:
    """Boxes in any orientation.

    Attributes
    ----------
    centre
        Centres (n, 3), m.
    half
        Half sizes (n, 3), m.
    axes
        Rotations (n, 3, 3), whose columns are the boxes' own axes.
    """

    centre: Array
    half: Array
    axes: Array

    @classmethod
    def upright(cls, corners: Sequence[tuple[Sequence[float], Sequence[float]]]) -> Boxes:
        """Return axis-aligned boxes from their low and high corners."""
        lo = np.array([corner[0] for corner in corners])
        hi = np.array([corner[1] for corner in corners])
        return cls((lo + hi) / 2, (hi - lo) / 2, np.broadcast_to(np.eye(3), (len(lo), 3, 3)))

    def corners(self) -> Array:
        """Return the boxes' corners (n, 8, 3)."""
        signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], np.float64)
        return self.centre[:, None] + np.einsum(
            "nij,nkj->nki", self.axes, signs[None] * self.half[:, None]
        )

    def same_as(self, other: Boxes) -> bool:
        """Return whether all boxes have the same positions and axes."""
        return np.array_equal(self.centre, other.centre) and np.array_equal(self.axes, other.axes)

    def bounds(self) -> tuple[Array, Array]:
        """Return the low and high corner (3,) around all boxes."""
        corners = self.corners().reshape(-1, 3)
        return corners.min(axis=0), corners.max(axis=0)


def ranges_to(boxes: Boxes, origins: Array, directions: Array, reach: Array) -> Array:
    """Return the ranges (n,) of rays to the nearest box, in closed form (slabs).

    Parameters
    ----------
    boxes
        The boxes that the rays may hit.
    origins, directions
        Rays, shape (n, 3), m; directions are unit vectors.
    reach
        Greatest range of each ray, shape (n,), m.
    """
    lo, hi = boxes.bounds()
    found = reach.copy()
    near = _passing((lo + hi) / 2, float(np.linalg.norm(hi - lo)) / 2, origins, directions)
    near = near[_enter(lo, hi, origins[near], directions[near]) < reach[near]]
    if len(near):
        # All boxes at once, each in its own axes: (boxes, rays, 3).
        starts = (origins[near] - boxes.centre[:, None]) @ boxes.axes
        half = boxes.half[:, None]
        ranges = _enter(-half, half, starts, directions[near] @ boxes.axes)
        found[near] = np.minimum(found[near], ranges.min(axis=0))
    return found


def _passing(centre: Array, radius: float, origins: Array, directions: Array) -> Array:
    """Return the indices of the rays whose line passes within `radius` of `centre`.

    This is a quick test with a bounding sphere.
    """
    aside = origins - centre
    along = np.einsum("ij,ij->i", aside, directions)
    beside = np.einsum("ij,ij->i", aside, aside) - along**2
    return np.flatnonzero(beside <= radius**2 * (1.0 + 1e-9))


def _enter(lo: Array, hi: Array, origins: Array, directions: Array) -> Array:
    """Return the distances at which rays enter a box; inf where they miss it.

    Axis by axis, because numpy is slow at reducing rows of three.
    """
    enter, leave = np.zeros(1), np.full(1, np.inf)
    with np.errstate(divide="ignore", invalid="ignore"):
        for axis in range(3):
            start, way = origins[..., axis], directions[..., axis]
            one, two = (lo[..., axis] - start) / way, (hi[..., axis] - start) / way
            enter = np.fmax(enter, np.fmin(one, two))
            leave = np.fmin(leave, np.fmax(one, two))
    return np.where(leave >= enter, enter, np.inf)


def _turn(yaw: float, pitch: float = 0.0) -> Array:
    """Return the rotation (3, 3) by `pitch` about y, then by `yaw` about z."""
    c, s, cp, sp = math.cos(yaw), math.sin(yaw), math.cos(pitch), math.sin(pitch)
    return np.array([[c * cp, -s, c * sp], [s * cp, c, s * sp], [-sp, 0.0, cp]])


@dataclass(frozen=True)
class Walker:
    """A body that walks along its x axis with `speed` m/s.

    It repeatedly walks `leg` metres and stops for `pause` seconds. `height` is in m.
    """

    name: str
    height: float
    speed: float
    leg: float = math.inf
    pause: float = 0.0
    cat: bool = False
    arm: bool = False

    def distance(self, time: float) -> float:
        """Return the distance (m) walked by `time` (s)."""
        if self.leg == math.inf:
            return self.speed * time
        cycle = self.leg / self.speed + self.pause
        whole, rest = divmod(time, cycle)
        return self.leg * whole + min(rest * self.speed, self.leg)

    def seconds(self, metres: float) -> float:
        """Return the time (s) in which it walks so many metres."""
        if self.arm:
            return 4.0
        if self.leg == math.inf:
            return metres / self.speed
        pauses = math.ceil(metres / self.leg - 1e-9) - 1
        return metres / self.speed + pauses * self.pause

    def boxes(self, start: Array, yaw: float, time: float) -> Boxes:
        """Return its boxes `time` s after it starts at `start` (2,) in the direction `yaw`."""
        if self.arm:
            return _seated(start, yaw, time)
        distance = self.distance(time)
        at = np.array([*start, 0.0]) + distance * np.array([math.cos(yaw), math.sin(yaw), 0.0])
        parts = _cat(distance) if self.cat else _person(self.height, distance)
        frame = _turn(yaw)
        return Boxes(
            np.array([at + frame @ centre for centre, _, _ in parts]),
            np.array([half for _, half, _ in parts]),
            np.array([frame @ _turn(0.0, pitch) for *_, pitch in parts]),
        )


Part = tuple[Array, tuple[float, float, float], float]


def _person(height: float, distance: float) -> list[Part]:
    """Return trunk, head, and legs and arms that swing once per step of 0.4 of the height."""
    h = height
    swing = 0.45 * math.sin(math.pi * distance / (0.4 * h))
    parts: list[Part] = [
        (np.array([0, 0, 0.65 * h]), (0.07 * h, 0.13 * h, 0.17 * h), 0.0),
        (np.array([0, 0, 0.92 * h]), (0.055 * h, 0.045 * h, 0.075 * h), 0.0),
    ]
    for side in (-1, 1):
        parts.append(_hanging((0, side * 0.06 * h, 0.48 * h), 0.48 * h, 0.045 * h, side * swing))
        parts.append(_hanging((0, side * 0.155 * h, 0.8 * h), 0.42 * h, 0.025 * h, -side * swing))
    return parts


def _cat(distance: float) -> list[Part]:
    """Return a cat 0.25 m high and 0.5 m long."""
    swing = 0.5 * math.sin(math.pi * distance / 0.15)
    parts: list[Part] = [
        (np.array([0, 0, 0.19]), (0.18, 0.06, 0.06), 0.0),
        (np.array([0.21, 0, 0.24]), (0.05, 0.04, 0.04), 0.0),
    ]
    for x, y, sign in ((0.14, 0.04, 1), (0.14, -0.04, -1), (-0.14, 0.04, -1), (-0.14, -0.04, 1)):
        parts.append(_hanging((x, y, 0.14), 0.14, 0.015, sign * swing))
    return parts


def _hanging(joint: tuple[float, float, float], length: float, half: float, angle: float) -> Part:
    """Return a limb that hangs from a joint, rotated about y."""
    down = np.array([-math.sin(angle), 0.0, -math.cos(angle)])
    return np.array(joint) + down * length / 2, (half, half, length / 2), angle


def _seated(start: Array, yaw: float, time: float) -> Boxes:
    """Return a seated person who turns one arm to the side, and back after a second."""
    phase = time % 4.0
    angle = math.pi / 2 * min(max(min(phase, 3.0 - phase), 0.0), 1.0)
    at = np.array([*start, 0.0])
    arm = _turn(yaw + math.pi / 4 - angle)
    length, half = 15 * INCH, 1.5 * INCH
    shoulder = at + _turn(yaw) @ np.array([0.1, 0.2, 36 * INCH])
    centres = [
        at + np.array([0, 0, 0.75]),
        at + np.array([0, 0, 1.15]),
        shoulder + arm @ np.array([length / 2, 0, 0]),
    ]
    halves = [(0.12, 0.2, 0.3), (0.09, 0.08, 0.12), (length / 2, half, half)]
    return Boxes(np.array(centres), np.array(halves), np.array([_turn(yaw), _turn(yaw), arm]))


WALKERS = (
    Walker("NEMA walk", 1.70, 4 * FOOT, 3 * FOOT, 2.0),
    Walker("walk", 1.70, 1.2),
    Walker("slow walk", 1.70, 0.3),
    Walker("child", 1.05, 0.8),
    Walker("cat", 0.25, 0.5, cat=True),
    Walker("arm (NEMA minor)", 1.2, 0.0, arm=True),
)


def passes(walker: Walker, count: int) -> list[tuple[Array, float, float]]:
    """Return reproducible paths through the room: start (2,), direction, length (m).

    For an arm, the start is any place where a person could stand.
    """
    chance = np.random.default_rng(sum(walker.name.encode()))
    found: list[tuple[Array, float, float]] = []
    while len(found) < count:
        start, end = (chance.uniform(CLEAR, np.array(ROOM[:2]) - CLEAR) for _ in range(2))
        length = float(np.linalg.norm(end - start))
        steps = start + np.linspace(0, 1, 40)[:, None] * (end - start)
        if walker.arm:
            steps = steps[:1]
        elif not 1.5 <= length <= 3.0:
            continue
        if _is_free(steps):
            found.append((start, float(np.arctan2(*(end - start)[::-1])), length))
    return found


def _is_free(points: Array) -> bool:
    lo = np.array([corner[0][:2] for corner in FURNITURE]) - CLEAR
    hi = np.array([corner[1][:2] for corner in FURNITURE]) + CLEAR
    inside = (points[:, None] > lo) & (points[:, None] < hi)
    return not inside.all(axis=2).any()
