# SPDX-License-Identifier: GPL-3.0-or-later
"""What every sensor model shares: how it asks the scene, and answers with readings."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from .contact.world import PadForces

Array = NDArray[np.float64]
Index = NDArray[np.intp]
FIRST: Index = np.zeros(1, np.intp)
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


@dataclass(frozen=True)
class Emission:
    """What rays meet, as a source of heat: `temperature` in K and `emissivity` (n,) of the
    surfaces, and the temperature of what is around, `ambient` in K. A ray that meets nothing sees
    the ambient."""

    temperature: Array
    emissivity: Array
    ambient: float


@dataclass(frozen=True)
class PadContact:
    """The contacts of a pressure pad: the `forces` at the update's frame, the pad's
    own weight (3,) in N, and session uids of the objects to measure alone (None: all)."""

    forces: PadForces
    weight: Array
    chosen: frozenset[int] | None


@dataclass(frozen=True)
class LightSample:
    """What the scene sends to a sensor: one of the two, as its method asks; and what there is to
    say of it. Not noisy, not quantised by the part."""

    luminance_percent: float | None = None
    illuminance_lux: float | None = None
    note: str = ""


@dataclass(frozen=True)
class Answers:
    """What a scene answers at n updates: `table[rows[i]]` at the i-th; where nothing changed from
    one update to the next, both have the same row (n,) of the table."""

    table: Sequence[Any] | Array
    rows: Index

    def __getitem__(self, i: Any) -> Any:
        return self.table[int(self.rows[i])]


# What a model asks, by the names in `kind.py`, and what it gets at each update:
#   RAYS (bundle, origins, directions, length): ranges (n,) in m of unit vectors (n, 3) from origins
#       (n, 3); nothing within `length` (n,) reads `length`. `bundle` numbers the rays of a sensor
#       that are cast together: normally the same rays under the same number.
#   WARMTH (the same): the `Emission` of what the rays meet.
#   CROSSINGS (origins, directions, length): `Passes`, what rays met on the way since the step of
#       the clock before, while they and rigid things moved; None: nobody looked then.
#   FORCES (): `PadContact`.     LIGHT (): `LightSample`.
Ask = Callable[..., Any]


@dataclass(frozen=True)
class Update:
    """One update of a sensor: its number, its time in s, where the sensor stands, and what answers
    the model's questions about the scene. `noise` makes the update's random generator, `part` that
    of the device, the same each time."""

    number: int
    time: float
    pose: Pose
    scene: Mapping[str, Ask] = field(default_factory=dict)
    noise: Callable[[], np.random.Generator] = np.random.default_rng
    part: Callable[[], np.random.Generator] = np.random.default_rng

    def ask(self, need: str, *question: Any) -> Any:
        """The answer at this update."""
        return self.scene[need](*question)


@dataclass(frozen=True)
class Updates:
    """Updates of one sensor that follow each other without a gap, at one pose with one set of
    parameters: `numbers` (n,) and `times` (n,) in s. At one that is not `due` (n,), a step between
    two updates, a sensor looks and publishes nothing. `noise` makes the random generator of an
    update by its number."""

    numbers: Index
    times: Array
    due: NDArray[np.bool_]
    pose: Pose
    scene: Mapping[str, Ask]
    noise: Callable[[int], np.random.Generator]
    part: Callable[[], np.random.Generator]
    _asked: dict[Any, tuple[Any, Answers]] = field(default_factory=dict)

    @classmethod
    def of(cls, update: Update, due: bool = True) -> Updates:
        """One update alone, or a step between two."""

        def alone(ask: Ask) -> Ask:
            return lambda *question, which=None: Answers([ask(*question)], FIRST)

        return cls(
            np.array([update.number]),
            np.array([update.time]),
            np.array([due]),
            update.pose,
            {need: alone(ask) for need, ask in update.scene.items()},
            lambda _: update.noise(),
            update.part,
        )

    def __len__(self) -> int:
        return len(self.numbers)

    def ask(self, need: str, *question: Any, which: Index | None = None) -> Answers:
        """The answers at all updates, or at those that are listed in `which`."""
        found: Answers = self.scene[need](*question, which=which)
        return found

    def __getitem__(self, i: int) -> Update:
        """One of them; what it asks is asked once for all of them."""

        def one(need: str) -> Ask:
            return lambda *question: self._once(need, question)[i]

        number = int(self.numbers[i])
        scene = {need: one(need) for need in self.scene}
        noise = partial(self.noise, number)
        return Update(number, float(self.times[i]), self.pose, scene, noise, self.part)

    def _once(self, need: str, question: tuple[Any, ...]) -> Answers:
        # Where the bundle has a number, other rays take the place of those before.
        key = need, question[0] if question and isinstance(question[0], int) else None
        known = self._asked.get(key)
        if known is None or not all(map(_same, known[0], question)):
            known = self._asked[key] = question, self.ask(need, *question)
        return known[1]


@dataclass(frozen=True)
class Reading:
    """One update's result: `active` and `value` as shown, `fields` as published."""

    active: bool
    value: float
    fields: dict[str, Any]


@dataclass(frozen=True)
class Readings:
    """The results of n updates: arrays (n,) `active` and `value`, and by the field's name an array
    or list; None where none of them measured it."""

    active: NDArray[np.bool_]
    value: Array
    fields: dict[str, Any]

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


def _same(one: Any, other: Any) -> bool:
    return one is other or np.array_equal(one, other)


def _plain(column: Any, i: int) -> Any:
    """A value as Python has it."""
    value = None if column is None else column[i]
    return value.item() if isinstance(value, np.generic) else value


class Model:
    """What senses for one sensor. A kind's own model says how by `update`, one update at a time;
    one that has many updates to answer for says it by `sense`, for all of them in numpy."""

    def sense(self, parameters: Any, updates: Updates) -> Readings:
        """The readings at those of the updates that are due."""
        due = np.flatnonzero(updates.due).tolist()
        return Readings.of([self.update(parameters, updates[i]) for i in due])

    def update(self, parameters: Any, update: Update) -> Reading:
        """The reading at one update."""
        return self.sense(parameters, Updates.of(update))[0]

    def watch(self, parameters: Any, update: Update) -> None:
        """Looks at a step between two updates."""
        self.sense(parameters, Updates.of(update, due=False))


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
