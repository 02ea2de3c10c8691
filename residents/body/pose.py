# SPDX-License-Identifier: GPL-3.0-or-later
"""The body at n moments: what it is described by, and how poses are mixed and put together."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from ...sensor_logic.model import Array, Index
from .skeleton import Build
from .turns import mix, mix_turns, share

# Which fields are turns: they are mixed along the sphere.
TURNS = frozenset({"turn", "toes"})


def _each(first: Any, *others: Any, do: Callable[..., Array], inner: Any = None) -> Any:
    """The same dataclass with `do(name, *arrays)` for each of its arrays, and for those of the
    moments in it, unless `inner` says what becomes of these."""
    # Without `replace`: what it does beside counts with some 10,000 poses a day.
    new = object.__new__(type(first))
    parts = new.__dict__
    rest = [other.__dict__ for other in others]
    for name, value in first.__dict__.items():
        if isinstance(value, np.ndarray):
            value = do(name, value, *[other[name] for other in rest])
        elif isinstance(value, Moments):
            values = value, *[other[name] for other in rest]
            value = inner(*values) if inner else _each(*values, do=do)
        parts[name] = value
    return new


def _lengths(moments: Any) -> Iterator[int]:
    """Of its arrays, and those of the moments in it."""
    for value in moments.__dict__.values():
        if isinstance(value, np.ndarray):
            yield len(value)
        elif isinstance(value, Moments):
            yield from _lengths(value)


@dataclass(frozen=True)
class Moments:
    """Arrays with the same first axis: one entry for each moment."""

    def take(self, index: Any) -> Self:
        """The moments of an index, a mask or a slice."""
        taken: Self = _each(self, do=lambda _name, a: a[index])
        return taken

    def mixed(self, other: Self, t: float | Array) -> Self:
        """The poses from this one (t = 0) to the other (1); a single moment is held."""

        def blend(name: str, a: Array, b: Array) -> Array:
            return (mix_turns if name in TURNS else mix)(a, b, t)

        result: Self = _each(self, other, do=blend, inner=lambda a, b: a.mixed(b, t))
        return result


@dataclass(frozen=True)
class Feet(Moments):
    """Both feet, or a cat's four paws (hind left, hind right, fore left, fore right), (n, f, …)."""

    ankle: Array  # (n, f, 3) in the world
    turn: Array  # (n, f, 4) of the sole
    toes: Array  # (n, f, 4)
    knee: Array  # (n, f, 3) the direction in which the knee points


def _arms(value: float, *shape: int) -> Callable[[], Array]:
    return lambda: np.full((1, 2, *shape), value)


@dataclass(frozen=True)
class Arms(Moments):
    """Left and right (n, 2): angles against the chest, and where the wrist is drawn to (n, 2, 3),
    by how much (grip 0 … 1). A cat's are left alone."""

    forward: Array = field(default_factory=_arms(0.03))
    away: Array = field(default_factory=_arms(0.09))
    inward: Array = field(default_factory=_arms(0.25))  # the arm's turn about itself
    elbow: Array = field(default_factory=_arms(0.22))
    target: Array = field(default_factory=_arms(0.0, 3))
    grip: Array = field(default_factory=_arms(0.0))

    def mixed(self, other: Self, t: float | Array) -> Self:
        # Each target counts as much as its grip: one without says nothing.
        a, b = self.grip * share(1 - np.asarray(t), self.grip), other.grip * share(t, other.grip)
        both = a + b
        part = np.where(both > 0, b / np.where(both > 0, both, 1.0), 1.0)[..., None]
        target = self.target + (other.target - self.target) * part
        return replace(super().mixed(other, t), target=target)

    def one(self, side: int, **values: Array | float) -> Self:
        """The pose with other values for one arm, each (n,), (n, 3) or a number."""
        new = {}
        for name, value in values.items():
            old: Array = getattr(self, name)
            size = max(len(old), len(value) if isinstance(value, np.ndarray) else 1)
            array = np.array(np.broadcast_to(old, (size, *old.shape[1:])))
            array[:, side] = value
            new[name] = array
        return replace(self, **new)


@dataclass(frozen=True)
class BodyPose(Moments):
    """The whole body at n moments; spine and look are (roll to the right, forward pitch, yaw to the
    left), tail those of a cat's tail."""

    build: Build
    heading: Array  # (n,) rad of the armature object, continuous (not folded into one turn)
    pelvis: Array  # (n, 3) m
    turn: Array  # (n, 4) of the pelvis
    feet: Feet
    arms: Arms
    spine: Array  # (n, 3) rad
    look: Array  # (n, 3) rad
    walker: Array  # (n, 4) m, rad: x, y, z on the floor and yaw of the walking frame
    tail: Array = field(default_factory=lambda: np.zeros((1, 3)))

    def __len__(self) -> int:
        return max(_lengths(self))

    def spread(self, count: int) -> Self:
        """The first moment, held for `count`, in arrays of its own."""
        return self.take(np.zeros(count, np.intp))

    def put(self, index: Index, part: Self) -> None:
        """Writes other poses in place of the moments at the index, of a pose with arrays of its own
        for all of its moments."""

        def write(_name: str, whole: Array, new: Array) -> Array:
            whole[index] = new
            return whole

        _each(self, part, do=write)

    def take(self, index: Any) -> Self:
        count = len(self)

        def taken(_name: str, values: Array) -> Array:
            # Those of a single moment are repeated.
            held = len(values) == count
            return (values if held else np.broadcast_to(values, (count, *values.shape[1:])))[index]

        result: Self = _each(self, do=taken)
        return result


def held(values: ArrayLike) -> Array:
    """What has no axis of moments, as one moment: (1, …)."""
    return np.asarray(values, float)[None]
