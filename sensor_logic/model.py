# SPDX-License-Identifier: GPL-3.0-or-later
"""The interface of sensor models: updates come in, readings go out."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from .arrays import Array as Array
from .arrays import Index as Index
from .forces.world import PadForces

FIRST: Index = np.zeros(1, np.intp)
P = TypeVar("P")
T = TypeVar("T")
# The problem of a pressure reading until the frames beside its own have been evaluated.
NOT_YET = "three frames in a row are not known"


@dataclass(frozen=True)
class Pose:
    """A sensor's position and orientation: origin (3,) in metres, axes (3, 3) with columns x, y, z.

    The axes are orthonormal and right-handed: scale, shear and mirroring of the object and its
    parents change its housing only.
    """

    origin: Array
    axes: Array

    def same(self, other: Pose) -> bool:
        """Whether another is equal."""
        return np.array_equal(self.origin, other.origin) and np.array_equal(self.axes, other.axes)


@dataclass(frozen=True)
class Emission:
    """Thermal radiation sources that n rays hit: `temperature` in K and `emissivity` (n,) of the
    surfaces, and the `ambient` temperature in K, which also stands where a ray hits nothing."""

    temperature: Array
    emissivity: Array
    ambient: float


@dataclass(frozen=True)
class PadContact:
    """The contacts of a pressure pad: the `forces` at the update's frame, the pad's own weight (3,)
    in N, and session uids of the only objects to measure (None: all)."""

    forces: PadForces
    weight: Array
    chosen: frozenset[int] | None


@dataclass(frozen=True)
class LightShare:
    """The part of a `LightSample` that comes from one source, in the sample's unit and before its
    rounding and limits. `names`: the lamp objects, several where they share one light datablock;
    empty for a `source` that is no lamp."""

    names: tuple[str, ...]
    source: str
    light: float


@dataclass(frozen=True)
class LightSample:
    """Light at a sensor, before noise and quantisation: the one of the two quantities that its
    method measures. `note`: a remark for the reader. `shares`: its parts by source, None where the
    engine does not tell sources apart."""

    luminance_percent: float | None = None
    illuminance_lux: float | None = None
    note: str = ""
    shares: tuple[LightShare, ...] | None = None


@dataclass(frozen=True)
class Answers:
    """The scene's answers at n updates: `table[rows[i]]` is that of update i. Updates between which
    nothing changed share a row."""

    table: Sequence[Any] | Array
    rows: Index

    def __getitem__(self, i: Any) -> Any:
        return self.table[int(self.rows[i])]


# The questions of a model, by the names in `kind.py`, and the answer at each update:
#   RAYS (bundle, origins, directions, length): ranges (n,) in m along unit vectors (n, 3) from
#       origins (n, 3); a ray that hits nothing within `length` (n,) reads `length`. `bundle` is a
#       number for rays that are cast together, the same at each update.
#   WARMTH (as RAYS): the `Emission` where the rays hit.
#   REFLECTANCE (as RAYS): the reflectance (n,), 0 to 1, where the rays hit.
#   CROSSINGS (origins, directions, length): `RayCrossings` of rigid solids and these rays since the
#       step before; None where the sensor did not observe that step.
#   FORCES (): `PadContact`.     LIGHT (): `LightSample`.
#   POSES (parameter): the `Pose` of the object that the pointer parameter names; None without one.
Ask = Callable[..., Any]


@dataclass(frozen=True)
class Update:
    """One update of a sensor: its number, its time in s, the sensor's pose, and the functions that
    answer the model's questions about the `scene`. `noise` makes the update's random generator,
    `device_noise` the device's, which gives the same numbers at each update."""

    number: int
    time: float
    pose: Pose
    scene: Mapping[str, Ask] = field(default_factory=dict)
    noise: Callable[[], np.random.Generator] = np.random.default_rng
    device_noise: Callable[[], np.random.Generator] = np.random.default_rng

    def ask(self, need: str, *question: Any) -> Any:
        """The scene's answer at this update."""
        return self.scene[need](*question)


@dataclass(frozen=True)
class Updates:
    """Consecutive updates of one sensor, at one pose with one set of parameters: `numbers` (n,) and
    `times` (n,) in s. One that is not `due` (n,) is a step between two updates, which a sensor
    observes without publishing a reading. `noise` makes an update's random generator by its
    number."""

    numbers: Index
    times: Array
    due: NDArray[np.bool_]
    pose: Pose
    scene: Mapping[str, Ask]
    noise: Callable[[int], np.random.Generator]
    device_noise: Callable[[], np.random.Generator]
    _answered: dict[Any, tuple[Any, Answers]] = field(default_factory=dict)

    @classmethod
    def of(cls, update: Update, due: bool = True) -> Updates:
        """A single update, or, where it is not `due`, a step between two."""

        def alone(ask: Ask) -> Ask:
            return lambda *question, which=None: Answers([ask(*question)], FIRST)

        return cls(
            np.array([update.number]),
            np.array([update.time]),
            np.array([due]),
            update.pose,
            {need: alone(ask) for need, ask in update.scene.items()},
            lambda _: update.noise(),
            update.device_noise,
        )

    def __len__(self) -> int:
        return len(self.numbers)

    def ask(self, need: str, *question: Any, which: Index | None = None) -> Answers:
        """The scene's answers at all updates, or at those whose indices are in `which`."""
        found: Answers = self.scene[need](*question, which=which)
        return found

    def __getitem__(self, i: int) -> Update:
        """Update i; the first to ask a question asks it for all of them."""

        def one(need: str) -> Ask:
            return lambda *question: self._once(need, question)[i]

        number = int(self.numbers[i])
        scene = {need: one(need) for need in self.scene}
        noise = partial(self.noise, number)
        return Update(number, float(self.times[i]), self.pose, scene, noise, self.device_noise)

    def _once(self, need: str, question: tuple[Any, ...]) -> Answers:
        # Other rays under the same bundle number replace the earlier ones.
        key = need, question[0] if question and isinstance(question[0], int) else None
        known = self._answered.get(key)
        if known is None or not all(map(np.array_equal, known[0], question)):
            known = self._answered[key] = question, self.ask(need, *question)
        return known[1]


@dataclass(frozen=True)
class Reading:
    """The result of one update: the outputs `active` and `value`, and the published `fields`."""

    active: bool
    value: float
    fields: dict[str, Any]


@dataclass(frozen=True)
class Readings:
    """The results of n updates: arrays (n,) `active` and `value`, and an array or list for each
    field; None for a field that no update measured. `times` (n,) in s, where a reading is dated
    otherwise than its update: after the update before it, and never after its own."""

    active: NDArray[np.bool_]
    value: Array
    fields: dict[str, Any]
    times: Array | None = None

    @classmethod
    def of(cls, readings: Sequence[Reading]) -> Readings:
        names = readings[0].fields if readings else {}
        return cls(
            np.array([one.active for one in readings], bool),
            np.array([one.value for one in readings], float),
            {name: [one.fields[name] for one in readings] for name in names},
        )

    def __len__(self) -> int:
        return len(self.active)

    def __getitem__(self, i: int) -> Reading:
        fields = {name: _plain(column, i) for name, column in self.fields.items()}
        return Reading(bool(self.active[i]), float(self.value[i]), fields)


def _plain(column: Any, i: int) -> Any:
    """A value of a column as a Python object, not a numpy scalar."""
    value = None if column is None else column[i]
    return value.item() if isinstance(value, np.generic) else value


class PerPose(Generic[P, T]):
    """Keeps what `compute(parameters, pose)` returned until either is another."""

    def __init__(self, compute: Callable[[P, Pose], T]) -> None:
        self._compute = compute
        self._last: tuple[P, Pose, T] | None = None

    def __call__(self, parameters: P, pose: Pose) -> T:
        last = self._last
        if last is None or last[0] != parameters or not last[1].same(pose):
            last = self._last = parameters, pose, self._compute(parameters, pose)
        return last[2]


class Model:
    """Computes the readings of one sensor and holds its state. A kind overrides `update` (one at a
    time) or `sense` (many updates at once, in numpy)."""

    def sense(self, parameters: Any, updates: Updates) -> Readings:
        """The readings at the updates that are due."""
        due = np.flatnonzero(updates.due).tolist()
        return Readings.of([self.update(parameters, updates[i]) for i in due])

    def update(self, parameters: Any, update: Update) -> Reading:
        """The reading at one update."""
        return self.sense(parameters, Updates.of(update))[0]

    def watch(self, parameters: Any, update: Update) -> None:
        """Observes a step between two updates, without a reading."""
        self.sense(parameters, Updates.of(update, due=False))


def pose_from_matrix(matrix: Array, unit_scale: float = 1.0) -> Pose:
    """The pose of an object with this 4 × 4 world matrix; `unit_scale` is metres per Blender unit.

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
