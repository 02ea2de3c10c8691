# SPDX-License-Identifier: GPL-3.0-or-later
"""Hands at work: washing, cooking, tidying, and on the handles of doors."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from ...model import Array
from ...routine.draws import Stream
from ..body.turns import ease
from ..places import Door
from .ground import yaw_to

# Hands are so long at a spot, s (median, log-normal), and go so fast to another, up to so far to
# the sides and nearer, m.
AT_SPOT, GOES, WIDE, DEEP = (2.5, 1.0), 0.7, 0.18, 0.08
# A hand follows a leaf about so far (rad, or m of what slides), where it opens to and behind it.
FOLLOWS = {1.0: 0.73, -1.0: 0.49}
SLIDES_ALONG = 0.6
GRIP = 0.05  # from the middle of a leaf to the hand on its handle, m


def hands_at_work(
    point: Array, yaw: float, began: float, seconds: float, stream: Stream
) -> Callable[[float, Array], Array]:
    """The places (n, 3) of a hand, +1 the left and -1 the right, at times (n,), of a person who
    looks along a yaw and works for so many seconds: now here, now there about a point, never
    still."""
    across = np.array([-math.sin(yaw), math.cos(yaw), 0.0])
    nearer = -np.array([math.cos(yaw), math.sin(yaw), 0.0])
    begins, spots = _spots(seconds, stream)
    spots = spots @ np.stack([across, nearer])

    def hand(sign: float, times: Array) -> Array:
        since = times - began
        index = np.searchsorted(begins, since, side="right") - 1
        share = ease((since - begins[index]) / GOES)[:, None]
        spot = spots[index] + (spots[index + 1] - spots[index]) * share
        rub = np.stack(
            [0.02 * np.sin(7 * since), 0 * since, 0.012 * np.sin(5.1 * since + sign)], -1
        )
        moved: Array = spot + point + sign * (0.045 * across + rub)
        return moved

    return hand


def hand_on_leaf(
    door: Door, here: Array, moves: tuple[float, float], start: float, seconds: float
) -> Callable[[Array], Array]:
    """The places (n, 3) of a hand on the handle at times (n,), of a person who stands `here` (2,),
    while the leaf moves from one opening to another; the hand follows while it reaches."""
    limit = SLIDES_ALONG if door.slides else FOLLOWS[door.side(here)]
    away = yaw_to(door.handle_at(door.closed), here)
    towards = GRIP * np.array([math.cos(away), math.sin(away), 0.0])
    before, after = moves

    def grip(times: Array) -> Array:
        out = before + (after - before) * ease((times - start) / seconds) - door.closed
        near = door.closed + limit * np.tanh(out / limit)
        return np.array([door.handle_at(float(one)) for one in near]) + towards

    return grip


def _spots(seconds: float, stream: Stream) -> tuple[Array, Array]:
    """When hands at work go elsewhere (n,), s, the first at 0, and where they are before and after
    (n + 1, 2): m to the left and towards the body."""
    begins, spots = [0.0], [(0.0, 0.0), (0.0, 0.0)]
    while (after := begins[-1] + max(stream.log_normal(*AT_SPOT), GOES)) < seconds:
        begins.append(after)
        spots.append((WIDE * (2 * stream.uniform() - 1), DEEP * stream.uniform()))
    return np.array(begins), np.array(spots)
