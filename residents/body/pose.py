# SPDX-License-Identifier: GPL-3.0-or-later
"""The poses of a body as arrays, and their interpolation.

The first axis of each array is time, with one entry for each pose.
"""

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


def _map_arrays(first: Any, *others: Any, do: Callable[..., Array], inner: Any = None) -> Any:
    """Return a copy of a dataclass in which `do(name, *arrays)` replaces each array.

    `do` gets the name of a field, and the field's arrays in `first` and `others`. Nested objects
    are replaced by the result of `inner` or, without it, copied in the same way.
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
            value = inner(*values) if inner else _map_arrays(*values, do=do)
        parts[name] = value
    return new


def _lengths(moments: Any) -> Iterator[int]:
    for value in moments.__dict__.values():
        if isinstance(value, np.ndarray):
            yield len(value)
        elif isinstance(value, PoseArrays):
            yield from _lengths(value)


@dataclass(frozen=True)
class PoseArrays:
    """A dataclass of arrays whose first axis is time.

    An array has one entry for each pose, or a single entry for all.
    """

    def take(self, index: Any) -> Self:
        """Return a copy with the entries at `index`: an index, a mask or a slice."""
        taken: Self = _map_arrays(self, do=lambda _name, a: a[index])
        return taken

    def interpolated(self, other: Self, t: float | Array) -> Self:
        """Interpolate from this pose (t = 0) to the other (t = 1).

        Arrays with a single entry are broadcast.
        """

        def blend(name: str, a: Array, b: Array) -> Array:
            return (slerp if name in TURNS else lerp)(a, b, t)

        result: Self = _map_arrays(self, other, do=blend, inner=lambda a, b: a.interpolated(b, t))
        return result


@dataclass(frozen=True)
class Feet(PoseArrays):
    """The two feet, or a cat's four paws, at n times; their number f is 2 or 4.

    Feet are in the order left, right. Paws are in the order hind left, hind right, fore left, fore
    right.
    """

    ankle: Array  # (n, f, 3) in the world
    turn: Array  # (n, f, 4) rotation of the sole
    toes: Array  # (n, f, 4) rotation of the toes
    knee: Array  # (n, f, 3) the direction in which the knee points


def _arms(value: float, *shape: int) -> Callable[[], Array]:
    return lambda: np.full((1, 2, *shape), value)


@dataclass(frozen=True)
class Arms(PoseArrays):
    """Both arms at n times, in the order left, right.

    The angles are in rad, against the chest. The wrist is at `target` where its weight `grip` is 1,
    and follows from the angles where `grip` is 0. A cat's arms are ignored.
    """

    forward: Array = field(default_factory=_arms(0.03))  # (n, 2) rad, as the next three
    away: Array = field(default_factory=_arms(0.09))
    inward: Array = field(default_factory=_arms(0.25))  # rotation about the arm's long axis
    elbow: Array = field(default_factory=_arms(0.22))
    target: Array = field(default_factory=_arms(0.0, 3))  # of the wrist, in the world, m
    grip: Array = field(default_factory=_arms(0.0))

    def interpolated(self, other: Self, t: float | Array) -> Self:
        """Interpolate angles and wrist targets from these arms (t = 0) to the other arms (t = 1).

        Each of the two targets is weighted by its `grip`: how far the wrist follows it, 0 to 1.
        """
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
        """Return a copy with new values for one arm: side 0 is left, 1 is right.

        `values` are given by field name, as a number or an array (n,) or (n, 3).
        """
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

    `spine` has the angles of the trunk, `look` the angles of neck and head, and `tail` the angles
    of a cat's tail. Their columns are roll to the right, pitch forward and yaw to the left.
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
        """Write the poses `part` into this object's arrays at `index`, in place.

        The arrays must be writable and have one entry for each pose, as `repeated` makes them.
        """

        def write(_name: str, whole: Array, new: Array) -> Array:
            whole[index] = new
            return whole

        _map_arrays(self, part, do=write)

    def take(self, index: Any) -> Self:
        """Return the poses at `index`: an index, a mask or a slice."""
        count = len(self)

        def taken(_name: str, values: Array) -> Array:
            # An array with a single entry holds for all n poses.
            is_full = len(values) == count
            return (values if is_full else np.broadcast_to(values, (count, *values.shape[1:])))[
                index
            ]

        result: Self = _map_arrays(self, do=taken)
        return result


def single(values: ArrayLike) -> Array:
    """Return `values` with a new first axis of length 1, for one pose (n = 1)."""
    return np.asarray(values, float)[None]
