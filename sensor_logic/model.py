# SPDX-License-Identifier: GPL-3.0-or-later
"""What every sensor model shares: how it asks the scene for rays and answers with a reading."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from .contact.world import PadForces
    from .light import LightSample
    from .sweep import Passes

Array = NDArray[np.float64]
# The problem of a reading that the frames to come will make sure of.
NOT_YET = "three frames in a row are not known"


@dataclass(frozen=True)
class Pose:
    """Where a sensor stands: origin (3,) in metres, axes (3, 3) whose columns are x, y, z.

    The axes are orthonormal and right-handed: scale, shear and mirroring of the object and its
    parents change its housing only.
    """

    origin: Array
    axes: Array


class CastRays(Protocol):
    """Ranges in metres of `directions` (n, 3), unit vectors, from `origins` (n, 3).

    Nothing within `length` metres (n,) reads `length`. `bundle` names the rays for the caches of
    the caster: the same sensor and number, normally the same rays. The same array, not writeable,
    says that nothing changed.
    """

    def __call__(self, bundle: int, origins: Array, directions: Array, length: Array) -> Array: ...


@dataclass(frozen=True)
class Emission:
    """What rays meet, as a source of heat: `temperature` in K and `emissivity` (n,) of the
    surfaces, and the temperature of what is around, `ambient` in K. A ray that meets nothing sees
    the ambient."""

    temperature: Array
    emissivity: Array
    ambient: float


class SeeWarmth(Protocol):
    """As `CastRays`, but tells the warmth of what the rays meet."""

    def __call__(
        self, bundle: int, origins: Array, directions: Array, length: Array
    ) -> Emission: ...


def _no_warmth(bundle: int, origins: Array, directions: Array, length: Array) -> Emission:
    raise LookupError("nobody told this update how warm things are")


class SweepRays(Protocol):
    """What rays, given as to `CastRays`, met on the way since the step of the clock before, while
    they and rigid things moved. None: nobody looked then, as at the first time."""

    def __call__(self, origins: Array, directions: Array, length: Array) -> Passes | None: ...


def _no_sweep(origins: Array, directions: Array, length: Array) -> Passes | None:
    raise LookupError("nobody told this update what moved since the one before")


@dataclass(frozen=True)
class PadContact:
    """What a pressure pad is told of its contacts: the `forces` at the update's frame, the pad's
    own weight (3,) in N, and session uids of the objects to measure alone (None: all)."""

    forces: PadForces
    weight: Array
    chosen: frozenset[int] | None


@dataclass(frozen=True)
class Update:
    """What a model gets at each of its updates, which follow each other without a gap.

    `noise` makes the update's random generator, `part` that of the device, the same each time.
    `contact` tells a pressure pad what presses on it, `light` a light sensor what shines on it,
    `warmth` a pyroelectric detector how warm the things are that it sees, `sweep` a swept switch
    what went through its beam.
    """

    number: int
    time: float
    pose: Pose
    cast: CastRays
    noise: Callable[[], np.random.Generator]
    part: Callable[[], np.random.Generator]
    contact: Callable[[], PadContact]
    light: Callable[[], LightSample]
    warmth: SeeWarmth = _no_warmth
    sweep: SweepRays = _no_sweep


@dataclass(frozen=True)
class Reading:
    """One update's result: `active` and `value` as shown, `fields` as published."""

    active: bool
    value: float
    fields: dict[str, Any]


def pose_from_matrix(matrix: Array, unit_scale: float = 1.0) -> Pose:
    """The pose that a 4 × 4 world matrix gives, `unit_scale` metres a unit.

    Raises ValueError where the matrix does not define the −Z and +Y directions.
    """
    matrix = np.asarray(matrix, dtype=np.float64)
    if not np.isfinite(matrix).all():
        raise ValueError(
            "its transform is not a number at this frame: see its keys, drivers and constraints"
        )
    z, y = matrix[:3, 2], matrix[:3, 1]
    z_length, y_length = float(np.linalg.norm(z)), float(np.linalg.norm(y))
    if z_length == 0.0 or y_length == 0.0:
        raise ValueError("its scale is zero, so it looks nowhere; clear its scale (Alt+S)")
    z, y = z / z_length, y / y_length
    y = y - z * (y @ z)
    y_length = float(np.linalg.norm(y))
    if y_length < 1e-6:
        raise ValueError(
            "its transform is sheared flat, so it looks nowhere; clear its scale (Alt+S)"
        )
    y = y / y_length
    axes = np.stack([np.cross(y, z), y, z], axis=1)
    return Pose(matrix[:3, 3] * unit_scale, axes)
