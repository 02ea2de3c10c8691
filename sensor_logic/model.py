# SPDX-License-Identifier: GPL-3.0-or-later
"""The interface of sensor models. A model computes readings from updates."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from .arrays import Array as Array
from .arrays import Index as Index
from .arrays import are_equal
from .forces.world import PadForces

FIRST: Index = np.zeros(1, np.intp)
P = TypeVar("P")
T = TypeVar("T")
# The problem of a pressure reading until the frames before and after it have been evaluated.
NOT_YET = "three frames in a row are not known"


@dataclass(frozen=True)
class Pose:
    """A sensor's position and orientation.

    `origin` (3,) is in metres. The columns of `axes` (3, 3) are the sensor's x, y and z axes,
    orthonormal and right-handed. Scale, shear and mirroring of the object or a parent do not change
    the pose.
    """

    origin: Array
    axes: Array

    def same(self, other: Pose) -> bool:
        """Return whether two poses are equal."""
        return are_equal((self.origin, self.axes), (other.origin, other.axes))


@dataclass(frozen=True)
class Emission:
    """Thermal radiation of the surfaces that n rays hit.

    Attributes
    ----------
    temperature
        The temperature (n,) in K of the surface at each hit. For a ray without a hit, it is
        `ambient`.
    emissivity
        The emissivity (n,) of that surface.
    ambient
        The ambient temperature in K.
    left
        The part (n,) of the temperatures in K that people have left in seats and beds; None without
        any.
    """

    temperature: Array
    emissivity: Array
    ambient: float
    left: Array | None = None


@dataclass(frozen=True)
class PadContact:
    """The contacts of a pressure pad at one frame.

    Attributes
    ----------
    forces
        The forces on the pad.
    weight
        The pad's own weight (3,) in N.
    chosen
        The session uids of the objects whose forces are measured; None means all objects.
    """

    forces: PadForces
    weight: Array
    chosen: frozenset[int] | None


@dataclass(frozen=True)
class ObjectUse:
    """The name of the object that a sensor watches, and whether it is in use."""

    name: str
    in_use: bool


@dataclass(frozen=True)
class LightShare:
    """The part of a `LightSample` that comes from one source.

    Attributes
    ----------
    names
        The names of the source's lamp objects. Lamps that share a light datablock are one source.
        Empty for a source that is not a lamp.
    source
        The name of the source.
    light
        The light in the unit of the sample, before rounding and limits.
    """

    names: tuple[str, ...]
    source: str
    light: float


@dataclass(frozen=True)
class LightSample:
    """The light at a sensor, before noise and quantisation.

    Attributes
    ----------
    luminance_percent, illuminance_lux
        The two quantities. The one that the sensor's method does not measure is None.
    note
        A remark for the user.
    shares
        The parts of the light by source; None if the render engine cannot separate the sources.
    """

    luminance_percent: float | None = None
    illuminance_lux: float | None = None
    note: str = ""
    shares: tuple[LightShare, ...] | None = None


@dataclass(frozen=True)
class Answers:
    """The scene's answers to one query, for n updates.

    The answer at update i is `table[rows[i]]`. Successive updates with equal answers share a row of
    the table.

    Attributes
    ----------
    hits
        For a query that casts rays: their hits at each update, with the attributes `solids` (n,),
        numbers of solids (0 for none), and `ranges` (n,), in units of the scene. None if the scene
        knows no solids.
    """

    table: Sequence[Any] | Array
    rows: Index
    hits: Answers | None = None

    def __getitem__(self, i: Any) -> Any:
        return self.table[int(self.rows[i])]


# The queries of a model, by the names in `kind.py`: arguments, and the answer at each update.
#   RAYS (bundle, origins, directions, length): ranges (n,) in m along unit vectors (n, 3) from
#       origins (n, 3); a ray that hits nothing within `length` (n,) reads `length`. `bundle` is a
#       number that identifies rays cast together, the same at each update.
#   WARMTH (as RAYS, or with times, left): the `Emission` at the hits. With the times (n,) of the
#       updates and the sensor's own `WarmthLeft`, also of seats and beds after somebody left them.
#   REFLECTANCE (as RAYS): the reflectance (n,), 0 to 1, at the hits.
#   CROSSINGS (origins, directions, length): `RayCrossings` of rigid solids and these rays since the
#       step before; None where the sensor did not observe that step.
#   FORCES (): `PadContact`.     LIGHT (): `LightSample`.
#   POSES (parameter): the `Pose` of the object that the pointer parameter names; None without one.
#   USES (): the `ObjectUse` of the object that the sensor watches; None without one.
Ask = Callable[..., Any]


def no_name(number: int) -> str:
    """Return an empty name: the scene knows no solids."""
    return ""


@dataclass(frozen=True)
class Update:
    """One update of a sensor.

    Attributes
    ----------
    number, time
        The number of the update and its time in s.
    pose
        The pose of the sensor.
    scene
        A function for each query, by the query's name. It returns the scene's answer.
    noise
        A function that returns the random generator of this update.
    device_noise
        A function that returns the random generator of the device. It draws the same numbers at
        each update.
    hits
        A function for each query that casts rays, by the query's name. It returns their hits, as in
        `Answers.hits`; None if the scene knows no solids.
    name_of
        A function that returns the name of the solid with a number; empty for no solid.
    """

    number: int
    time: float
    pose: Pose
    scene: Mapping[str, Ask] = field(default_factory=dict)
    noise: Callable[[], np.random.Generator] = np.random.default_rng
    device_noise: Callable[[], np.random.Generator] = np.random.default_rng
    hits: Mapping[str, Ask] = field(default_factory=dict)
    name_of: Callable[[int], str] = no_name

    def ask(self, need: str, *question: Any) -> Any:
        """Return the scene's answer to the query `need`, with the arguments `question`."""
        return self.scene[need](*question)

    def solids_hit(self, need: str, *question: Any) -> Index | None:
        """Return the numbers (n,) of the solids that the rays of a query hit, 0 for none.

        Return None if the scene knows no solids.
        """
        found = self.hits[need](*question) if need in self.hits else None
        return None if found is None else found.solids

    def names_hit(self, need: str, *question: Any) -> list[str]:
        """Return the names (n,) of the objects that the rays of a query hit, empty for none."""
        found = self.solids_hit(need, *question)
        return [""] * len(question[1]) if found is None else list(map(self.name_of, found.tolist()))


@dataclass(frozen=True)
class Updates:
    """Consecutive updates of one sensor, with one pose and one set of parameters.

    Attributes
    ----------
    numbers, times
        The number (n,) and the time (n,) in s of each update.
    due
        Whether the sensor publishes a reading (n,). If not, this is a step between two updates, at
        which the sensor only observes.
    pose
        The pose of the sensor.
    scene
        A function for each query, by the query's name. It returns the answers at all updates.
    noise
        A function that returns the random generator of the update with a given number.
    device_noise
        A function that returns the random generator of the device. It draws the same numbers at
        each update.
    name_of
        A function that returns the name of the solid with a number; empty for no solid.
    """

    numbers: Index
    times: Array
    due: NDArray[np.bool_]
    pose: Pose
    scene: Mapping[str, Ask]
    noise: Callable[[int], np.random.Generator]
    device_noise: Callable[[], np.random.Generator]
    name_of: Callable[[int], str] = no_name
    _answered: dict[Any, tuple[Any, Answers]] = field(default_factory=dict)

    @classmethod
    def of(cls, update: Update, due: bool = True) -> Updates:
        """Return `Updates` with one update, or with one step between updates if not `due`."""

        def alone(ask: Ask) -> Ask:
            return lambda *question, indices=None: Answers([ask(*question)], FIRST)

        return cls(
            np.array([update.number]),
            np.array([update.time]),
            np.array([due]),
            update.pose,
            {need: alone(ask) for need, ask in update.scene.items()},
            lambda _: update.noise(),
            update.device_noise,
            update.name_of,
        )

    def __len__(self) -> int:
        return len(self.numbers)

    def part(self, first: int, last: int) -> Updates:
        """Return the updates from index `first` to before `last`."""
        if (first, last) == (0, len(self)):
            return self
        some = np.arange(first, last)

        def asked(ask: Ask) -> Ask:
            return lambda *question, indices=None: ask(
                *question, indices=some if indices is None else some[indices]
            )

        return replace(
            self,
            numbers=self.numbers[some],
            times=self.times[some],
            due=self.due[some],
            scene={need: asked(ask) for need, ask in self.scene.items()},
            _answered={},
        )

    def ask(self, need: str, *question: Any, indices: Index | None = None) -> Answers:
        """Return the scene's answers to the query `need`, with the arguments `question`.

        `indices` (k,) are those of the updates to answer for; None means all.
        """
        found: Answers = self.scene[need](*question, indices=indices)
        return found

    def __getitem__(self, i: int) -> Update:
        """Return update i.

        The scene answers a query for all updates together, when the first of them makes the query.
        """

        def one(need: str) -> Ask:
            return lambda *question: self._once(need, question)[i]

        def hits(need: str) -> Ask:
            def found(*question: Any) -> Any:
                answers = self._once(need, question).hits
                return None if answers is None else answers[i]

            return found

        number = int(self.numbers[i])
        return Update(
            number,
            float(self.times[i]),
            self.pose,
            {need: one(need) for need in self.scene},
            partial(self.noise, number),
            self.device_noise,
            {need: hits(need) for need in self.scene},
            self.name_of,
        )

    def _once(self, need: str, question: tuple[Any, ...]) -> Answers:
        # Other rays under the same bundle number replace the earlier ones.
        key = need, question[0] if question and isinstance(question[0], int) else None
        known = self._answered.get(key)
        if known is None or not are_equal(known[0], question):
            known = self._answered[key] = question, self.ask(need, *question)
        return known[1]


@dataclass(frozen=True)
class Reading:
    """The result of one update: the outputs `active` and `value`, and the published `fields`.

    `evidence` is why the sensor read this: the values of the kind's `evidence`, by name.
    """

    active: bool
    value: float
    fields: dict[str, Any]
    evidence: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Readings:
    """The results of n updates.

    Attributes
    ----------
    active, value
        The outputs (n,).
    fields
        An array or list (n,) for each field, or None for a field that no update measured.
    times
        The time (n,) in s of each reading, after the previous update and not after its own update.
        None means the times of the updates.
    evidence
        Why the sensor read this: an array or list (n,) for each of the kind's `evidence`.
    """

    active: NDArray[np.bool_]
    value: Array
    fields: dict[str, Any]
    times: Array | None = None
    evidence: dict[str, Any] = field(default_factory=dict)

    @classmethod
    def of(cls, readings: Sequence[Reading]) -> Readings:
        """Return a list of readings as one `Readings`."""
        names, why = (readings[0].fields, readings[0].evidence) if readings else ({}, {})
        return cls(
            np.array([one.active for one in readings], bool),
            np.array([one.value for one in readings], float),
            {name: [one.fields[name] for one in readings] for name in names},
            evidence={name: [one.evidence[name] for one in readings] for name in why},
        )

    def __len__(self) -> int:
        return len(self.active)

    def __getitem__(self, i: int) -> Reading:
        fields, evidence = (
            {name: _plain(column, i) for name, column in columns.items()}
            for columns in (self.fields, self.evidence)
        )
        return Reading(bool(self.active[i]), float(self.value[i]), fields, evidence)


def _plain(column: Any, i: int) -> Any:
    """Return value i of a column as a Python object, not as a numpy scalar."""
    value = None if column is None else column[i]
    return value.item() if isinstance(value, np.generic) else value


def joined_readings(parts: Sequence[Readings]) -> Readings:
    """Return the readings of successive groups of updates as one `Readings`."""
    if len(parts) == 1:
        return parts[0]

    def column(name: str, of: str) -> Any:
        values = [getattr(part, of)[name] for part in parts]
        if values[0] is None:
            return None
        return [one for part in values for one in part]

    first = parts[0]
    return Readings(
        np.concatenate([part.active for part in parts]),
        np.concatenate([part.value for part in parts]),
        {name: column(name, "fields") for name in first.fields},
        None if first.times is None else np.concatenate([part.times for part in parts]),
        {name: column(name, "evidence") for name in first.evidence},
    )


class PerPose(Generic[P, T]):
    """A cache of the last result of a function `compute(parameters, pose)`."""

    def __init__(self, compute: Callable[[P, Pose], T]) -> None:
        self._compute = compute
        self._last: tuple[P, Pose, T] | None = None

    def __call__(self, parameters: P, pose: Pose) -> T:
        """Return the result for these arguments, computed only if one of them has changed."""
        last = self._last
        if last is None or last[0] != parameters or not last[1].same(pose):
            last = self._last = parameters, pose, self._compute(parameters, pose)
        return last[2]


class Model:
    """Base class of sensor models. A model computes the readings of one sensor and holds its state.

    A subclass overrides either `update`, for one update at a time, or `sense`, for many at once.
    """

    def sense(self, parameters: Any, updates: Updates) -> Readings:
        """Return the readings at the updates that are due."""
        due = np.flatnonzero(updates.due).tolist()
        return Readings.of([self.update(parameters, updates[i]) for i in due])

    def update(self, parameters: Any, update: Update) -> Reading:
        """Return the reading at one update."""
        return self.sense(parameters, Updates.of(update))[0]

    def watch(self, parameters: Any, update: Update) -> None:
        """Observe a step between two updates, without a reading."""
        self.sense(parameters, Updates.of(update, due=False))


def pose_from_matrix(matrix: Array, unit_scale: float = 1.0) -> Pose:
    """Return the pose of an object from its world matrix.

    Parameters
    ----------
    matrix
        The world matrix (4, 4), in Blender units.
    unit_scale
        Metres per Blender unit.

    Raises
    ------
    ValueError
        If the matrix does not define the −Z and +Y directions.
    """
    matrix = np.asarray(matrix, dtype=np.float64)
    if not np.isfinite(matrix).all():
        raise ValueError(
            "its transform is not a number at this frame: check its keyframes, drivers and "
            "constraints"
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
