# SPDX-License-Identifier: GPL-3.0-or-later
"""Movements of a person before a sensor, as in public measurements: marching, swaying, arms.

The measurements publish what a person did, and not by how much. Lengths and times that they do give
are named as such; all others are assumed, from usual human movement, and stand at the top of each
function. A movement varies from cycle to cycle, as people's do, and is the same in each run.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from angen_sensors.residents.body.gait import Stance, standing
from angen_sensors.residents.body.pose import BodyPose
from angen_sensors.residents.body.poses import sitting
from angen_sensors.residents.body.skeleton import ADULT, SIGN, Build
from angen_sensors.residents.body.turns import compose_all, ease, rotated, rotation_x, rotation_z
from angen_sensors.sensor_logic.model import Array

# m. A chair's seat.
SEAT = 0.45


@dataclass(frozen=True)
class Spot:
    """Where a person is: the point between the feet or under the hips, m, and the heading, rad."""

    x: float
    y: float
    yaw: float
    build: Build = ADULT
    floor: float = 0.0

    def stand(self) -> BodyPose:
        """Return one pose (n = 1), standing."""
        return standing(Stance.at(self.x, self.y, self.yaw, self.build), self.floor, self.build)

    def sit(self) -> BodyPose:
        """Return one pose (n = 1), sitting upright on a chair."""
        ahead = 0.42 * self.build.scale
        at = self.x + ahead * np.cos(self.yaw), self.y + ahead * np.sin(self.yaw)
        stand = replace(self, x=float(at[0]), y=float(at[1])).stand()
        return sitting(stand, np.array([self.x, self.y, self.floor + SEAT]))


Movement = Callable[[Array, Spot], BodyPose]


def _wander(times: Array, seconds: float, name: str) -> Array:
    """Return a random curve (n,) of unit variance that changes within about `seconds`.

    It is a cubic curve through random values, and depends on the name alone.
    """
    random = np.random.default_rng(zlib.crc32(name.encode()))
    values = random.normal(size=4096)
    at = np.asarray(times, float) / seconds
    k = np.floor(at).astype(int) % 4000
    share = ease(at - np.floor(at))
    # Interpolation takes variance away: on average 0.74 is left.
    curve: Array = (values[k] * (1 - share) + values[k + 1] * share) / 0.74**0.5
    return curve


def _cycles(times: Array, hertz: float, vary: float, name: str) -> tuple[Array, Array]:
    """Return the phase (n,) in cycles, and the amplitude (n,) about 1, of a repeated movement.

    `vary` is the standard deviation of the amplitude; the period varies by a third of it.
    """
    late = _wander(times, 4.0 / hertz, f"{name} period") * vary
    size = 1.0 + vary * _wander(times, 1.0 / hertz, f"{name} size")
    return np.asarray(times, float) * hertz + late, np.clip(size, 0.2, 2.0)


def _aside(
    pose: BodyPose, left: Array, ahead: Array | float = 0.0, up: Array | float = 0.0
) -> Array:
    """Return offsets (n, 3) in the world to the left, ahead and up of the person, m."""
    parts = np.broadcast_arrays(np.asarray(ahead, float), left, np.asarray(up, float))
    offset: Array = rotated(rotation_z(pose.heading), np.stack(parts, -1))
    return offset


def _turned(pose: BodyPose, roll: Array | float, yaw: Array | float, count: int) -> Array:
    """Return rotations (n, 4) of the pelvis, with a roll to the right and a turn to the left."""
    roll, yaw = (np.broadcast_to(a, count).astype(float) for a in (roll, yaw))
    return compose_all(pose.turn, rotation_z(yaw), rotation_x(roll))


def stands_still(times: Array, spot: Spot) -> BodyPose:
    """Stand: the body sways by 5 mm (rms) sideways, and to and fro at 5 mm/s, and breathes."""
    return _swaying(spot.stand().repeated(len(times)), times, 0.005, 0.005)


def sits_still(times: Array, spot: Spot) -> BodyPose:
    """Sit and read: the trunk sways by 2 mm, and breathes."""
    return _swaying(spot.sit().repeated(len(times)), times, 0.002, 0.002)


def _swaying(pose: BodyPose, times: Array, side: float, forth: float) -> BodyPose:
    """Add a standing person's sway with standard deviations `side` and `forth` (m), and breath."""
    metres = 1.0 * pose.build.scale  # from the ankles to the middle of the body
    left = side * _wander(times, 1.5, "sway left")
    ahead = forth * _wander(times, 1.8, "sway ahead")
    breath = 0.006 * np.sin(2 * np.pi * 0.25 * np.asarray(times, float))
    lean = np.stack([-left / metres, ahead / metres + breath, 0 * left], -1)
    return replace(pose, pelvis=pose.pelvis + _aside(pose, left, ahead), spine=pose.spine + lean)


def walks_on_spot(times: Array, spot: Spot) -> BodyPose:
    """March on the mark: 110 steps a minute, feet lifted by 0.15 m, arms swung by 23°."""
    hertz, lift, sway, arms = 110 / 60 / 2, 0.15, 0.035, np.radians(23)
    roam, turn = 0.03, np.radians(4)
    pose = spot.stand().repeated(len(times))
    phase, size = _cycles(times, hertz, 0.15, "march")
    beat, scale = 2 * np.pi * phase, spot.build.scale
    # At phase 0 the weight is on the left foot, and the right one is in the air.
    weight = np.cos(beat)
    air = np.stack([np.clip(-weight, 0, None), np.clip(weight, 0, None)], -1) ** 0.8
    raised = lift * scale * size[:, None] * air
    feet = replace(
        pose.feet,
        ankle=pose.feet.ankle
        + rotated(
            rotation_z(pose.heading)[:, None],
            np.stack([-0.4 * raised, 0 * raised, raised], -1),
        ),
    )
    left = scale * (sway * weight + roam * _wander(times, 6.0, "march left"))
    ahead = scale * roam * _wander(times, 6.0, "march ahead")
    yaw = turn * _wander(times, 6.0, "march yaw") + np.radians(3) * np.sin(beat) * size
    roll = np.radians(2) * weight * size
    # The left arm goes ahead with the right leg.
    swing = arms * size[:, None] * SIGN * np.sin(beat + np.pi / 4)[:, None]
    moved = replace(
        pose.arms,
        forward=0.06 + swing,
        away=np.full_like(swing, 0.12),
        inward=np.full_like(swing, 0.25),
        elbow=0.35 + 0.4 * (arms + swing),
        target=np.zeros((len(times), 2, 3)),
        grip=np.zeros_like(swing),
    )
    drop = -0.012 * scale * (1 + np.cos(2 * beat)) / 2
    spine = pose.spine + np.stack([-0.9 * roll, 0 * roll, -1.5 * np.radians(3) * np.sin(beat)], -1)
    feet = replace(
        feet, ankle=feet.ankle + _aside(pose, left - scale * sway * weight, ahead)[:, None]
    )
    return replace(
        pose,
        pelvis=pose.pelvis + _aside(pose, left, ahead, drop),
        turn=_turned(pose, roll, yaw, len(times)),
        feet=feet,
        arms=moved,
        spine=spine,
    )


def crosses(times: Array, spot: Spot) -> BodyPose:
    """Go 1 m to and fro across the view at 1 m/s (both published), facing the sensor."""
    phase, size = _cycles(times, 0.5, 0.05, "cross")
    return _carried(walks_on_spot(times, spot), 0.5 * size * _to_and_fro(phase))


def sways(times: Array, spot: Spot) -> BodyPose:
    """Stand and move sideways by 0.5 m to and fro (published), once in 2.5 s."""
    phase, size = _cycles(times, 0.4, 0.15, "sways")
    pose = stands_still(times, spot)
    left = 0.25 * size * np.sin(2 * np.pi * phase)
    # The feet stay 0.5 m apart, the knees bend in turn, and the trunk leans over.
    scale = spot.build.scale
    apart = _aside(pose, np.full(len(times), 0.16 * scale))[:, None] * SIGN[:, None]
    feet = replace(pose.feet, ankle=pose.feet.ankle + apart)
    lean = np.stack([-0.35 * left, 0 * left, 0 * left], -1)
    down = -0.06 * scale - 0.25 * np.abs(left)
    return replace(
        pose, pelvis=pose.pelvis + _aside(pose, 0.85 * left, 0.0, down), feet=feet,
        spine=pose.spine + lean,
    )  # fmt: skip


def _to_and_fro(phase: Array) -> Array:
    """Return a triangle wave (n,) from −1 to 1 with rounded corners."""
    return np.asarray(np.arcsin(0.97 * np.sin(2 * np.pi * phase)) / np.arcsin(0.97), float)


def _carried(pose: BodyPose, left: Array) -> BodyPose:
    offset = _aside(pose, left)
    feet = replace(pose.feet, ankle=pose.feet.ankle + offset[:, None])
    walker = pose.walker + np.concatenate([offset, 0 * offset[:, :1]], -1)
    return replace(pose, pelvis=pose.pelvis + offset, feet=feet, walker=walker)


def jogging_arms(times: Array, spot: Spot) -> BodyPose:
    """Stand and swing bent arms as when jogging: 1.3 times a second, by 35° to both sides."""
    hertz, swing = 1.3, np.radians(35)
    pose = stands_still(times, spot)
    phase, size = _cycles(times, hertz, 0.1, "jog")
    wave = np.sin(2 * np.pi * phase) * size
    both = swing * SIGN * wave[:, None]
    arms = replace(
        pose.arms, forward=0.05 + both, away=np.full_like(both, 0.15),
        inward=np.full_like(both, 0.35), elbow=np.radians(85) + 0.2 * both,
    )  # fmt: skip
    turn = np.radians(3) * wave
    spine = pose.spine + np.stack([0 * turn, 0 * turn, -turn], -1)
    return replace(pose, arms=arms, spine=spine)


def micro_movements(times: Array, spot: Spot) -> BodyPose:
    """Stand, write on a phone, turn a page each 6 s and scratch the head each 15 s."""
    pose = stands_still(times, spot)
    t, scale = np.asarray(times, float), spot.build.scale
    body = np.array([spot.x, spot.y, spot.floor])

    def at(ahead: Array | float, left: Array | float, up: Array | float) -> Array:
        parts = np.broadcast_arrays(*(np.asarray(a, float) + 0 * t for a in (ahead, left, up)))
        return body + rotated(rotation_z(pose.heading), np.stack(parts, -1) * scale)

    type_ = 0.006 * np.sin(2 * np.pi * 2.2 * t) * (1 + 0.5 * _wander(t, 1.0, "type"))
    page = np.sin(np.pi * np.clip((t % 6.0) / 1.2, 0, 1)) ** 2
    into = (t + 5.0) % 15.0
    scratch = ease(into / 0.7) * ease((3.2 - into) / 0.7)
    rub = 0.02 * np.sin(2 * np.pi * 3.0 * t)
    phone = at(0.30, 0.06, 1.14 + type_)
    right = at(0.31 + 0.02 * page, -0.06 + type_ - 0.14 * page, 1.14 + 0.05 * page)
    head = at(0.10, -0.11 + rub, 1.58 + rub)
    right = right + scratch[:, None] * (head - right)
    target = np.stack([phone, right], 1)
    arms = replace(pose.arms, target=target, grip=np.ones((len(t), 2)))
    look = pose.look + np.stack([0 * t, 0.35 - 0.15 * scratch, 0 * t], -1)
    return replace(pose, arms=arms, look=look)


def trunk_sways(times: Array, spot: Spot) -> BodyPose:
    """Sit and move the trunk from side to side by 20°, every 2 s."""
    pose = sits_still(times, spot)
    phase, size = _cycles(times, 0.5, 0.1, "trunk")
    roll = np.radians(20) * size * np.sin(2 * np.pi * phase)
    spine = pose.spine + np.stack([roll, 0 * roll, 0 * roll], -1)
    free = replace(pose.arms, grip=np.zeros((len(times), 2)))
    return replace(pose, spine=spine, arms=free)
