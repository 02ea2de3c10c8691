# SPDX-License-Identifier: GPL-3.0-or-later
"""The motions that a coverage map tests: a step, an arm, crawling, a cat, sitting still.

Bodies are boxes and cylinders. The step and the arm are from NEMA WD 7, the test of occupancy
sensors. In it, a person walks at 4 ft/s through cells of 3 ft. An arm of 3 × 3 × 15 in, 36 in above
the floor, turns by 90° in a second.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..logs.error import AngenError
from ..model import Array

# The directions in which bodies start, counter-clockwise from +X.
DIRECTIONS = 8
HEADINGS: Array = np.linspace(0.0, 2.0 * math.pi, DIRECTIONS, endpoint=False)
FOOT, INCH = 0.3048, 0.0254
# In m. A direction with a shorter free path is not possible.
SHORTEST = 0.3
# In m. Margin of the quick tests, which leave close cases to the exact test.
CLOSE = 1e-6


@dataclass(frozen=True)
class Motion:
    """A body and its motion, in m, s and radians.

    Attributes
    ----------
    bottom, top
        The heights of the body's bottom and top above the floor.
    step
        The largest distance that a walking body moves, else the angle by which it turns.
    speed
        The speed of the motion, per second.
    radius
        The radius of a cylinder; 0 for a box.
    length, width
        The size of a box along its heading and across.
    walks
        Whether the body moves straight ahead. If not, it is a horizontal bar that begins at the
        cell's centre and turns about it.
    """

    identifier: str
    label: str
    tip: str
    bottom: float
    top: float
    step: float
    speed: float
    radius: float = 0.0
    length: float = 0.0
    width: float = 0.0
    walks: bool = True

    @property
    def height(self) -> float:
        """The height in m that `at_height` sets: of the top, or of the middle above the floor."""
        return self.top if self.bottom == 0.0 else (self.bottom + self.top) / 2.0

    @property
    def room(self) -> float:
        """The distance in m around the cell's centre that must be free for the body."""
        return self.radius or self.width / 2.0

    @property
    def reach(self) -> float:
        """The largest horizontal distance in m of a point of the body from its axis."""
        return self.radius or math.hypot(self.length, self.width) / 2.0

    @property
    def longest(self) -> float:
        """The largest distance in m from the start that any part of the body reaches."""
        return self.reach + (self.step if self.walks else self.length)

    def at_height(self, height: float) -> Motion:
        """Return the same motion with another `height` in m. Raise AngenError if impossible."""
        if self.bottom == 0.0:
            low, high = 0.0, height
        else:
            half = (self.top - self.bottom) / 2.0
            low, high = height - half, height + half
        if not 0.0 <= low < high <= HIGHEST:
            raise AngenError(f"a height of {height:g} m: it must be above 0 and below {HIGHEST} m")
        return replace(self, bottom=low, top=high)

    def seconds(self, start: Start) -> float:
        """Return how long the longest of the motions takes in s; 0 for a still body."""
        return float(start.length.max(initial=0.0)) / self.speed if self.speed else 0.0

    def lengths(self, clearance: Array) -> Array:
        """Return how far the body can move in each direction (…, 8), in m or radians.

        `clearance` (…, 8) is the free distance in m from the cell's centre in each direction. The
        result is 0 where the body cannot move. A still body, whose speed is 0, has SHORTEST there
        wherever it fits.
        """
        if not self.speed:
            return np.where(clearance >= self.room, SHORTEST, 0.0)
        if self.walks:
            most = np.minimum(clearance - max(self.radius, self.length / 2.0), self.step)
            result: Array = np.where(most >= SHORTEST - 1e-9, most, 0.0)
            return result
        free = clearance >= self.length
        swept = free & np.roll(free, -1, axis=-1) & np.roll(free, -2, axis=-1)
        return np.where(swept, self.step, 0.0)


HIGHEST = 2.5
ADULT_RADIUS = 0.2
MOTIONS: Mapping[str, Motion] = {
    motion.identifier: motion
    for motion in (
        Motion(
            "STEP",
            "Step",
            "A person of 1.7 m walks at most 3 ft at 4 ft/s (NEMA WD 7)",
            bottom=0.0,
            top=1.7,
            step=3 * FOOT,
            speed=4 * FOOT,
            radius=ADULT_RADIUS,
        ),
        Motion(
            "CHEST",
            "Chest",
            "The chest of a walking person, without legs and head: the part that is visible over "
            "furniture",
            bottom=1.0,
            top=1.45,
            step=3 * FOOT,
            speed=4 * FOOT,
            radius=ADULT_RADIUS,
        ),
        Motion(
            "ARM",
            "Arm",
            "An arm of 3 × 3 × 15 in, 36 in above the floor, turns by 90° in a second (NEMA WD 7)",
            bottom=36 * INCH - 1.5 * INCH,
            top=36 * INCH + 1.5 * INCH,
            step=math.pi / 2,
            speed=math.pi / 2,
            length=15 * INCH,
            width=3 * INCH,
            walks=False,
        ),
        Motion(
            "CRAWL",
            "Crawling",
            "A person who crawls at 0.5 m/s, 0.5 m high, as after a fall",
            bottom=0.0,
            top=0.5,
            step=3 * FOOT,
            speed=0.5,
            length=0.8,
            width=0.4,
        ),
        Motion(
            "CAT",
            "Cat",
            "A cat, 0.45 m long and 0.25 m high, walks at 0.5 m/s",
            bottom=0.0,
            top=0.25,
            step=0.5,
            speed=0.5,
            length=0.45,
            width=0.15,
        ),
        Motion(
            "STILL",
            "Sitting still",
            "The trunk and head of a person who sits and only breathes",
            bottom=0.6,
            top=1.25,
            step=0.0,
            speed=0.0,
            radius=ADULT_RADIUS,
        ),
    )
}


@dataclass(frozen=True)
class Walker:
    """A walking person as an upright cylinder; the default is an adult.

    `height` and `radius` are in m, `speed` in m/s. `celsius` is the mean temperature of the surface
    of skin and clothing.
    """

    height: float = 1.7
    radius: float = 0.2
    speed: float = 1.0
    celsius: float = 29.0
    emissivity: float = 0.95


# The moving body of all motions is as warm as a person with clothes; a cat is about as warm.
WALKER = Walker()


class BodyHits(NamedTuple):
    """Hits of rays on bodies.

    Attributes
    ----------
    body, ray
        The index (n,) of the body and of the ray of each hit.
    enter, leave
        The distances (n,) in m along the ray at which it enters and leaves the body. If the ray
        starts inside the body, `enter` is negative.
    """

    body: NDArray[np.intp]
    ray: NDArray[np.intp]
    enter: Array
    leave: Array


@dataclass(frozen=True)
class Start:
    """The start of m motions.

    Attributes
    ----------
    feet
        The points (m, 3) on the floor where the bodies start.
    heading
        The headings (m,) of the bodies in radians.
    length
        How far each body moves (m,), in m or radians.
    """

    feet: Array
    heading: Array
    length: Array

    def part(self, rows: slice | NDArray[np.intp] | NDArray[np.bool_]) -> Start:
        """Return only the motions with the indices or the mask `rows`."""
        return Start(self.feet[rows], self.heading[rows], self.length[rows])

    def __len__(self) -> int:
        return len(self.feet)


class Rays:
    """Rays from one point, sorted by bearing.

    Attributes
    ----------
    origin
        The point (3,).
    directions
        Unit vectors (n, 3).
    free
        The ranges (n,) in m in the room without a body.
    order
        The indices (n,) of the rays in the order of their bearings.
    far
        The horizontal lengths (n,) of the rays in m.
    rise
        The rise (n,) of each ray per horizontal metre; inf for vertical rays.
    """

    def __init__(self, origin: Array, directions: Array, free: Array) -> None:
        self.origin, self.directions, self.free = origin, directions, free
        bearing = np.arctan2(directions[:, 1], directions[:, 0])
        self.order = np.argsort(bearing, kind="stable")
        once, turn = bearing[self.order], 2.0 * math.pi
        # The bearings three times, so that no interval wraps around at ±π.
        self._bearings = np.concatenate([once - turn, once, once + turn])
        # The horizontal length of each ray, and its rise per horizontal metre.
        flat = np.hypot(directions[:, 0], directions[:, 1])
        self.far = free * flat
        with np.errstate(divide="ignore", invalid="ignore"):
            self.rise = np.where(flat > 1e-9, directions[:, 2] / flat, np.inf)

    def beside(
        self, towards: Array, reach: Array | float
    ) -> tuple[Array, NDArray[np.intp], NDArray[np.intp]]:
        """Return, for each of m bodies, the rays in its direction as seen from above.

        Parameters
        ----------
        towards
            The horizontal vectors (m, 2) from the origin to the bodies.
        reach
            The radius of the bodies in m.

        Returns
        -------
        apart
            The distances (m,) of the bodies from the origin.
        first, count
            The rays (m,) whose lines come within `reach` of each body. They are successive in the
            order of bearings: `first` is the position of the first ray, `count` their number.
        """
        apart = np.linalg.norm(towards, axis=1)
        outside = apart > reach * (1.0 + 1e-9)
        half = np.arcsin(reach / np.where(outside, apart, reach)) + 1e-9
        middle = np.arctan2(towards[:, 1], towards[:, 0])
        first = np.searchsorted(self._bearings, middle - half)
        count = np.searchsorted(self._bearings, middle + half, side="right") - first
        # A body above or below the origin can be hit by rays of any bearing.
        rays = len(self.order)
        return apart, np.where(outside, first, rays), np.where(outside, count, rays)

    def may_hit(self, motion: Motion, start: Start) -> NDArray[np.bool_]:
        """Return whether any ray can hit the body during each motion, (m,).

        The test compares bearings, distances and heights. It is true for every body that `hits`
        would find at some time, and for some others.
        """
        if not len(start):
            return np.zeros(0, bool)
        half = start.length / 2.0 if motion.walks else np.zeros(len(start))
        ahead = np.stack([np.cos(start.heading), np.sin(start.heading)], axis=1)
        towards = start.feet[:, :2] + ahead * half[:, None] - self.origin[:2]
        reach = motion.reach + (half if motion.walks else motion.length / 2.0)
        apart, first, count = self.beside(towards, reach)
        ends = np.stack([first, first + count], axis=1).ravel()
        enter, leave = self._height_interval(
            float(start.feet[:, 2].min()) + motion.bottom - self.origin[2] - CLOSE,
            float(start.feet[:, 2].max()) + motion.top - self.origin[2] + CLOSE,
        )
        # An extra value at the end, because `reduceat` needs a valid index for empty intervals too.
        nearest = np.minimum.reduceat(np.append(np.tile(enter, 3), np.inf), ends)[::2]
        farthest = np.maximum.reduceat(np.append(np.tile(leave, 3), -np.inf), ends)[::2]
        is_hit: NDArray[np.bool_] = (count > 0) & (farthest >= apart - reach - CLOSE)
        return is_hit & (nearest <= apart + reach + CLOSE)

    def _height_interval(self, low: float, high: float) -> tuple[Array, Array]:
        """Return the horizontal interval in which each ray is at a height from `low` to `high`.

        The result is the nearest and the farthest distance (n,), in the order of bearings. They are
        inf and −inf for a ray that is never at such a height. All values are in m, relative to the
        origin.
        """
        rise, far = self.rise[self.order], self.far[self.order]
        with np.errstate(divide="ignore", invalid="ignore"):
            one, two = low / rise, high / rise
        level = (rise == 0.0) | ~np.isfinite(rise)
        inside = ~np.isfinite(rise) | ((low <= 0.0) & (high >= 0.0))
        enter = np.where(level, np.where(inside, 0.0, np.inf), np.minimum(one, two))
        leave = np.where(level, np.where(inside, np.inf, -np.inf), np.maximum(one, two))
        enter, leave = np.maximum(enter, 0.0), np.minimum(leave, far)
        never = leave < enter - CLOSE
        return np.where(never, np.inf, enter), np.where(never, -np.inf, leave)


def hits(motion: Motion, start: Start, time: float, rays: Rays) -> BodyHits:
    """Return the hits of rays on the bodies at `time` s after the bodies start."""
    gone = np.minimum(motion.speed * max(time, 0.0), start.length)
    turned = start.heading if motion.walks else start.heading + gone
    ahead = np.stack([np.cos(turned), np.sin(turned)], axis=1)
    out = gone if motion.walks else np.full(len(start), motion.length / 2.0)
    towards = start.feet[:, :2] + ahead * out[:, None] - rays.origin[:2]
    low = start.feet[:, 2] + motion.bottom - rays.origin[2]
    body, ray = _nearby_pairs(motion, towards, low, rays)
    d = rays.directions[ray]
    if motion.radius:
        enter, leave = _through_circle(towards[body], d[:, :2], motion.radius)
    else:
        c, s = ahead[body, 0], ahead[body, 1]
        t = towards[body]
        along = _through_slab(
            d[:, 0] * c + d[:, 1] * s, t[:, 0] * c + t[:, 1] * s, motion.length / 2.0
        )
        over = _through_slab(
            d[:, 1] * c - d[:, 0] * s, t[:, 1] * c - t[:, 0] * s, motion.width / 2.0
        )
        enter, leave = np.maximum(along[0], over[0]), np.minimum(along[1], over[1])
    half = (motion.top - motion.bottom) / 2.0
    level = _through_slab(d[:, 2], low[body] + half, half)
    enter, leave = np.maximum(enter, level[0]), np.minimum(leave, level[1])
    is_hit = (leave >= enter) & (leave > 0.0)
    return BodyHits(body[is_hit], ray[is_hit], enter[is_hit], leave[is_hit])


def _nearby_pairs(
    motion: Motion, towards: Array, low: Array, rays: Rays
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the indices of pairs of a body and a ray that come near each other, sorted by body.

    The positions of the bodies in m are relative to the rays' origin: horizontally `towards` (m,
    2), and `low` (m,) for the height of the bottom.
    """
    apart, first, count = rays.beside(towards, motion.reach)
    body = np.repeat(np.arange(len(towards)), count)
    within = np.arange(len(body)) - np.repeat(np.cumsum(count) - count, count)
    ray = rays.order[(np.repeat(first, count) + within) % len(rays.order)]
    near, far = np.maximum(apart - motion.reach, 0.0)[body], (apart + motion.reach)[body]
    rise, foot = rays.rise[ray], low[body]
    with np.errstate(invalid="ignore"):
        one, two = rise * near, rise * far
    # Vertical rays are left to the exact test.
    over = np.fmin(one, two) > foot + (motion.top - motion.bottom) + CLOSE
    under = np.fmax(one, two) < foot - CLOSE
    left = ~((over | under) & np.isfinite(rise)) & (rays.far[ray] >= near - CLOSE)
    return body[left], ray[left]


def _through_circle(towards: Array, flat: Array, radius: float) -> tuple[Array, Array]:
    """Return the distances (n,) along rays at which they enter and leave upright cylinders.

    `towards` (n, 2) are the horizontal vectors from the rays' origin to the cylinders' axes. `flat`
    (n, 2) are the horizontal components of the rays' unit directions.
    """
    square = np.einsum("ni,ni->n", flat, flat)
    nearest = np.einsum("ni,ni->n", towards, flat)
    apart = np.einsum("ni,ni->n", towards, towards) - radius**2
    inside = nearest**2 - square * apart
    root = np.sqrt(np.maximum(inside, 0.0))
    upright = square < 1e-18
    safe = np.where(upright, 1.0, square)
    enter, leave = (nearest - root) / safe, (nearest + root) / safe
    missed = np.where(upright, apart > 0.0, inside < 0.0)
    enter = np.where(missed, np.inf, np.where(upright, -np.inf, enter))
    leave = np.where(missed, -np.inf, np.where(upright, np.inf, leave))
    return enter, leave


def _through_slab(direction: Array, middle: Array, half: float) -> tuple[Array, Array]:
    """Return the distances (n,) along rays at which they enter and leave a slab.

    The slab has all points whose coordinate along one axis is within `half` of `middle`.
    `direction` has the component of the rays' directions along that axis.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        one, two = (middle - half) / direction, (middle + half) / direction
    level = direction == 0.0
    within = np.abs(middle) <= half
    enter = np.where(level, np.where(within, -np.inf, np.inf), np.minimum(one, two))
    leave = np.where(level, np.where(within, np.inf, -np.inf), np.maximum(one, two))
    return enter, leave
