# SPDX-License-Identifier: GPL-3.0-or-later
"""The poses of a body as arrays, one entry for each time, and how poses are interpolated."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from ...sensor_logic.model import Array, Index
from .skeleton import Build
from .turns import add_axes, lerp, slerp

# Fields that hold rotations: these are interpolated with `slerp`.
TURNS = frozenset({"turn", "toes"})


def _each(first: Any, *others: Any, do: Callable[..., Array], inner: Any = None) -> Any:
    """Return a new dataclass with `do(name, *arrays)` in place of each array.

    Arrays of nested `PoseArrays` are treated likewise, unless `inner` is given: `inner` then takes
    the nested objects and returns the new one.
    """
    # `dataclasses.replace` is too slow for the some 10,000 poses of a day.
    new = object.__new__(type(first))
    parts = new.__dict__
    rest = [other.__dict__ for other in others]
    for name, value in first.__dict__.items():
        if isinstance(value, np.ndarray):
            value = do(name, value, *[other[name] for other in rest])
        elif isinstance(value, PoseArrays):
            values = value, *[other[name] for other in rest]
            value = inner(*values) if inner else _each(*values, do=do)
        parts[name] = value
    return new


def _lengths(moments: Any) -> Iterator[int]:
    """Yield the length of each array, those of nested `PoseArrays` included."""
    for value in moments.__dict__.values():
        if isinstance(value, np.ndarray):
            yield len(value)
        elif isinstance(value, PoseArrays):
            yield from _lengths(value)


@dataclass(frozen=True)
class PoseArrays:
    """Arrays with the same first axis: one entry for each time."""

    def take(self, index: Any) -> Self:
        """Return the entries that an index, a mask or a slice selects."""
        taken: Self = _each(self, do=lambda _name, a: a[index])
        return taken

    def interpolated(self, other: Self, t: float | Array) -> Self:
        """Interpolate from this pose (t = 0) to the other (t = 1).

        Arrays of length 1 are broadcast.
        """

        def blend(name: str, a: Array, b: Array) -> Array:
            return (slerp if name in TURNS else lerp)(a, b, t)

        result: Self = _each(self, other, do=blend, inner=lambda a, b: a.interpolated(b, t))
        return result


@dataclass(frozen=True)
class Feet(PoseArrays):
    """The two feet, or a cat's four paws, arrays of shape (n, f, …).

    Paws are in the order hind left, hind right, fore left, fore right.
    """

    ankle: Array  # (n, f, 3) in the world
    turn: Array  # (n, f, 4) rotation of the sole
    toes: Array  # (n, f, 4) rotation of the toes
    knee: Array  # (n, f, 3) the direction in which the knee points


def _arms(value: float, *shape: int) -> Callable[[], Array]:
    return lambda: np.full((1, 2, *shape), value)


@dataclass(frozen=True)
class Arms(PoseArrays):
    """Both arms, left and right: joint angles against the chest, and targets of the wrists.

    `grip`, 0 … 1, is the weight of the wrist's `target` against the joint angles. A cat's arms are
    ignored.
    """

    forward: Array = field(default_factory=_arms(0.03))  # (n, 2) rad, as the next three
    away: Array = field(default_factory=_arms(0.09))
    inward: Array = field(default_factory=_arms(0.25))  # rotation about the arm's long axis
    elbow: Array = field(default_factory=_arms(0.22))
    target: Array = field(default_factory=_arms(0.0, 3))  # of the wrist, in the world, m
    grip: Array = field(default_factory=_arms(0.0))

    def interpolated(self, other: Self, t: float | Array) -> Self:
        """Interpolate the angles, and weight each target by its grip."""
        # A target with a grip of 0 has no meaning: it must not move the other target.
        a, b = (
            self.grip * add_axes(1 - np.asarray(t), self.grip),
            other.grip * add_axes(t, other.grip),
        )
        both = a + b
        part = np.where(both > 0, b / np.where(both > 0, both, 1.0), 1.0)[..., None]
        target = self.target + (other.target - self.target) * part
        return replace(super().interpolated(other, t), target=target)

    def one(self, side: int, **values: Array | float) -> Self:
        """Return a copy with new values for the arm of one side, each (n,), (n, 3) or a number."""
        new = {}
        for name, value in values.items():
            old: Array = getattr(self, name)
            size = max(len(old), len(value) if isinstance(value, np.ndarray) else 1)
            array = np.array(np.broadcast_to(old, (size, *old.shape[1:])))
            array[:, side] = value
            new[name] = array
        return replace(self, **new)


@dataclass(frozen=True)
class BodyPose(PoseArrays):
    """The whole body at n times.

    `spine` and `look` are angles of the trunk and of neck and head: roll to the right, pitch
    forward, yaw to the left. `tail` has the same angles for a cat's tail.
    """

    build: Build
    heading: Array  # (n,) rad of the armature object, continuous (not wrapped to one turn)
    pelvis: Array  # (n, 3) m
    turn: Array  # (n, 4) rotation of the pelvis
    feet: Feet
    arms: Arms
    spine: Array  # (n, 3) rad
    look: Array  # (n, 3) rad
    walker: Array  # (n, 4) m, rad: x, y, z on the floor and yaw of the walking frame
    tail: Array = field(default_factory=lambda: np.zeros((1, 3)))

    def __len__(self) -> int:
        return max(_lengths(self))

    def repeated(self, count: int) -> Self:
        """Return the first pose repeated `count` times, in new arrays."""
        return self.take(np.zeros(count, np.intp))

    def put(self, index: Index, part: Self) -> None:
        """Write `part` into the poses at `index`, in place.

        The arrays of this pose must be writable and of full length, as `repeated` makes them.
        """

        def write(_name: str, whole: Array, new: Array) -> Array:
            whole[index] = new
            return whole

        _each(self, part, do=write)

    def take(self, index: Any) -> Self:
        """Return the poses that an index, a mask or a slice selects."""
        count = len(self)

        def taken(_name: str, values: Array) -> Array:
            # An array with a single entry holds for all n poses.
            is_full = len(values) == count
            return (values if is_full else np.broadcast_to(values, (count, *values.shape[1:])))[
                index
            ]

        result: Self = _each(self, do=taken)
        return result


def single(values: ArrayLike) -> Array:
    """Return `values` with a first axis of length 1, as a single pose has it."""
    return np.asarray(values, float)[None]
