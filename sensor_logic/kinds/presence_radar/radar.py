# SPDX-License-Identifier: GPL-3.0-or-later
"""Presence radar: the model.

Rays sample the field of view, and each returns a power by the radar equation, weighted by the speed
of what it hits. Gates are bins of a spectrum over the distance: each has an amplitude, which fades
from update to update. Movement is compared with thresholds at once, and who only breathes by a mean
over seconds. See docs/presence_radar.md.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...model import Answers, Array, Index, Model, PerPose, Pose, Readings, Updates
from ...physics import OutputTiming
from ...radio.echoes import ECHOES, Echoes
from ...radio.substances import reflectance
from .gate_evidence import FIELDS, Received
from .parameters import DECIBELS, FASTEST, FLOORS, NEVER, OFF, THRESHOLDS, RadarParameters
from .window import CELLS, LOBE, hann

# The standard person, who has the energies of a data sheet: as high and wide (m) as the walker of
# coverage maps, with quiet breathing (m from peak to peak, Hz).
PERSON_HEIGHT, PERSON_WIDTH = 1.7, 0.4
PERSON_BREATHING, PERSON_RATE = 0.005, 0.25
# The shares of the power of a plate of this size that a resident returns, whose front is round, and
# that a resident who walks on the spot returns as moving. Both are from simulated residents, the
# second chosen with the measured energy at 5 m in view: it sets the scale of movement.
ROUND, WALKING = 0.53, 0.27
# Targets are not nearer than this (m), so that powers are finite.
NEAREST = 0.01
# The golden ratio spaces the rows' offsets most evenly.
GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0
# Rays go up to this share of the angles from the axis to the edges of the field of view, and not
# farther from the axis than OUTERMOST (rad): rays beyond cost much and weigh little.
BEYOND, OUTERMOST = 1.5, math.radians(78)
# A Rayleigh distribution with a mean of 1 is the length of a complex number, of which both parts
# have this standard deviation.
UNIT_RAYLEIGH = math.sqrt(2.0 / math.pi)
# Random numbers are drawn for so many successive updates at once.
BLOCK = 64
# The most random numbers that are kept in one batch, to bound the memory.
AT_ONCE = 1_000_000
# The mean of the still energies is added up anew after so many time constants.
SPAN = 32.0


@dataclass(frozen=True)
class Beams:
    """The n rays of a radar.

    Attributes
    ----------
    origins, directions, length
        The rays in the world: origins and unit directions (n, 3), lengths (n,) in m.
    azimuth
        The angle (n,) in radians between the view axis and the ray in the sensor's XZ plane,
        positive to the right.
    weight
        The solid angle (n,) in sr of each ray times the antenna's two-way gain, which is 1 ahead.
    """

    origins: Array
    directions: Array
    length: Array
    azimuth: Array
    weight: Array


def edge_of(field_of_view: float) -> float:
    """Return the angle in radians between the view axis and the outermost rays."""
    return min(BEYOND * field_of_view / 2.0, OUTERMOST)


def ray_angles(share: ArrayLike, field_of_view: float) -> Array:
    """Return the angles (n,) in radians between rays and the view axis.

    The `share` (n,) of a ray is from −1, the outermost ray on one side, to 1, that on the other.
    Evenly spaced shares give rays that are densest near the axis. There, they are as dense as if
    they covered only the field of view.
    """
    edge, u = edge_of(field_of_view), np.asarray(share, np.float64)
    linear = min(field_of_view / 2.0 / edge, 1.0)
    found: Array = edge * u * (linear + (1.0 - linear) * u * u)
    return found


def radar_beams(parameters: RadarParameters, pose: Pose) -> Beams:
    """Return the rays of a radar.

    Rows of equal elevation divide the angles in front of the board, and the rays of a row its
    azimuths, up to OUTERMOST from the axis. Each row is offset by a different part of the spacing,
    so that no body is missed between two columns.
    """
    across, up = parameters.rays_across, parameters.rays_up
    wide, high = parameters.horizontal_fov, parameters.vertical_fov
    row = np.arange(up)
    elevation = ray_angles((2.0 * row + 1.0) / up - 1.0, high)
    offset = (0.5 + (row - (up - 1) / 2.0) * GOLDEN) % 1.0
    outermost = np.arccos(np.minimum(math.cos(OUTERMOST) / np.cos(elevation), 1.0))
    narrower = np.minimum(outermost / edge_of(wide), 1.0)[:, None]
    azimuth = (
        ray_angles(2.0 * (np.arange(across) + offset[:, None]) / across - 1.0, wide) * narrower
    )
    width = np.diff(ray_angles(2.0 * np.arange(across + 1) / across - 1.0, wide)) * narrower
    height = np.diff(np.sin(ray_angles(2.0 * np.arange(up + 1) / up - 1.0, high)))
    weight = width * height[:, None] * two_way_gain(parameters, azimuth, elevation[:, None])
    level = np.cos(elevation)[:, None]
    rise = np.broadcast_to(np.sin(elevation)[:, None], azimuth.shape)
    local = np.stack([np.sin(azimuth) * level, rise, -np.cos(azimuth) * level], axis=-1)
    directions = local.reshape(-1, 3) @ pose.axes.T
    origins = np.broadcast_to(pose.origin, directions.shape)
    length = np.full(len(directions), parameters.reach)
    return Beams(origins, directions, length, azimuth.ravel(), weight.ravel())


def two_way_gain(parameters: RadarParameters, azimuth: ArrayLike, elevation: ArrayLike) -> Array:
    """Return the two-way power gain of the antenna in a direction, relative to straight ahead.

    The one-way pattern is Gaussian, with half of the power at the edges of the field of view.
    Transmitter and receiver have the same pattern.
    """
    x = np.asarray(azimuth) / (parameters.horizontal_fov / 2.0)
    y = np.asarray(elevation) / (parameters.vertical_fov / 2.0)
    found: Array = np.exp2(-2.0 * (x * x + y * y))
    return found


def echo_powers(parameters: RadarParameters, weight: Array, echoes: Echoes) -> Array:
    """Return the power (n,) that each ray returns, in m⁻².

    By the radar equation, the power of a target of cross-section σ falls with R⁴. A ray of the
    solid angle ΔΩ covers ΔΩ·R² of a surface, so its echo is ρ·ΔΩ·G²/R² · 10^(−2L/10), with the
    reflectance ρ, the two-way gain G² and the one-way loss L in dB. `weight` (n,) is ΔΩ·G².
    """
    near = np.maximum(echoes.ranges, NEAREST)
    power = echoes.reflectance * weight / near**2 * 10.0 ** (-0.2 * echoes.loss)
    nearest = parameters.range_min / parameters.range_scale
    seen = (echoes.ranges < parameters.reach) & (echoes.ranges >= nearest)
    return np.where(seen, power, 0.0)


def breathing_speed(breathing: ArrayLike, rate: ArrayLike) -> Array:
    """Return the mean speed in m/s of a breathing chest, by fourth powers as `doppler_weight`.

    `breathing` is its displacement in m from peak to peak, and `rate` is in Hz.
    """
    found: Array = math.pi * np.asarray(breathing) * np.asarray(rate) * 0.375**0.25
    return found


def doppler_weight(speed: ArrayLike, corner: float) -> Array:
    """Return the share of the power at a radial speed that counts: (v²/(v² + c²))².

    `speed` v and `corner` c are in m/s. This is a high-pass filter of the second order, as of a
    radar that takes differences between sweeps twice to remove what stands still.
    """
    square = np.asarray(speed, np.float64) ** 2
    found: Array = (square / (square + corner**2)) ** 2
    return found


def doppler_weights(parameters: RadarParameters, echoes: Echoes) -> Array:
    """Return the shares (2, n) of the powers that count as moving, and in the still energies.

    A living body moves as fast as its chest, also where it seems to be still: its balance keeps the
    rest of it moving.
    """
    speed = np.where(np.abs(echoes.speed) <= FASTEST, echoes.speed, 0.0)
    speed = np.hypot(speed, breathing_speed(echoes.breathing, echoes.rate))
    corners = parameters.moving_corner, parameters.still_corner
    return np.stack([doppler_weight(speed, corner).mean(axis=0) for corner in corners])


def person_power(parameters: RadarParameters, distance: float) -> float:
    """Return the power in m⁻² of a plate of the size of a person straight ahead.

    The plate is across the view axis at `distance` (m), with its middle on the axis. The
    parts at the elevation ε are at d/cos ε, and seen under an angle: ρ·w/d⁴·∫ G²·cos⁵ε dz.
    """
    steps = 64
    height = ((np.arange(steps) + 0.5) / steps - 0.5) * PERSON_HEIGHT
    elevation = np.arctan2(height, distance)
    mean = float(np.mean(two_way_gain(parameters, 0.0, elevation) * np.cos(elevation) ** 5))
    area = PERSON_HEIGHT * PERSON_WIDTH * mean
    return reflectance("BODY", parameters.frequency) * area / distance**4


@dataclass(frozen=True)
class Calibration:
    """What relates powers to energies; first of movement, then of who only breathes.

    Attributes
    ----------
    gain
        The amplitudes (2,), in points of a linear scale, of a power of 1 m⁻².
    floors
        The amplitudes (2, gates) in an empty room.
    thresholds
        The energies (2, gates) above which gates detect; inf for a gate that never detects.
    is_on
        Whether each gate reports energies (2, gates).
    """

    gain: Array
    floors: Array
    thresholds: Array
    is_on: NDArray[np.bool_]


def calibration(parameters: RadarParameters) -> Calibration:
    """Return the calibration of a radar by the energies of the standard person."""
    breath = breathing_speed(PERSON_BREATHING, PERSON_RATE)
    gain = [
        amplitude(parameters, energy) / math.sqrt(person_power(parameters, distance) * share)
        for energy, distance, share in (
            (parameters.moving_energy, parameters.moving_range, WALKING),
            (
                parameters.still_energy,
                parameters.still_range,
                ROUND * float(doppler_weight(breath, parameters.still_corner)),
            ),
        )
    ]
    floors = np.stack([parameters.by_gate(name) for name in FLOORS])
    needed = np.stack([parameters.by_gate(name) for name in THRESHOLDS])
    is_on = needed > OFF
    thresholds = np.where(is_on & (needed < NEVER), needed, np.inf)
    floors = np.where(floors > 0.0, amplitude(parameters, floors), 0.0)
    return Calibration(np.array(gain), floors, thresholds, is_on)


def amplitude(parameters: RadarParameters, energy: Any) -> Any:
    """Return the amplitude (…) that is reported as an energy (…)."""
    return 10.0 ** (energy / 20.0) if parameters.scale == DECIBELS else energy


def energy_of(parameters: RadarParameters, amplitudes: Array) -> Array:
    """Return amplitudes (…) on the scale of reported energies, not clipped to 0 … 100."""
    if parameters.scale != DECIBELS:
        return amplitudes
    with np.errstate(divide="ignore"):
        return 20.0 * np.log10(amplitudes)


# Gates: bins of a spectrum.


WINDOW = hann(np.arange(1 - LOBE, LOBE) / CELLS)


def cells_of(parameters: RadarParameters) -> int:
    """Return the number of cells of distance that the gates sum."""
    return CELLS * (parameters.gates - 1) + LOBE


def in_cells(parameters: RadarParameters, ranges: Array, power: Array) -> Array:
    """Return the powers (cells,) by distance, with the tail of echoes by way of the room.

    The powers (n,) of rays at `ranges` (n,) in m are divided between the two nearest cells. Cell c
    is at c/CELLS of a gate length.
    """
    size = cells_of(parameters)
    # What returns no power can be beyond the last cell.
    place = np.where(power > 0.0, ranges, 0.0) * (CELLS / parameters.bin_length)
    cell = place.astype(np.intp)
    beyond = place - cell
    found = np.bincount(cell, power * (1.0 - beyond), size) + np.bincount(
        cell + 1, power * beyond, size
    )
    cells: Array = np.convolve(found, tail(parameters))[:size].astype(np.float64)
    return cells


# Each sweep of rays takes 0.02 ms longer without the cache.
@lru_cache(maxsize=16)
def tail(parameters: RadarParameters) -> Array:
    """Return the power (k,) that a power of 1 in a cell gives in that cell and those behind it."""
    # Beyond five lengths, less than 1 % of the amplitude is left.
    step = parameters.bin_length / CELLS / parameters.tail_length
    count = min(cells_of(parameters), math.ceil(5.0 / step))
    power: Array = parameters.tail_share**2 / CELLS * np.exp(-2.0 * step * np.arange(count))
    power[0] = 1.0
    return power


def gate_sums(cells: Array, window: Array, gates: int) -> Array:
    """Return the sums (…, gates) of cells (…, cells) around each gate, weighted by a window."""
    padded = np.concatenate([np.zeros((*cells.shape[:-1], LOBE - 1)), cells], axis=-1)
    end = CELLS * (gates - 1) + 1
    # Not as a matrix product, whose rounding depends on the number of rows.
    found = np.zeros((*cells.shape[:-1], gates))
    for i, weight in enumerate(window):
        found += weight * padded[..., i : i + end : CELLS]
    return found


class RandomNumbers(NamedTuple):
    """The random numbers of n updates, all normal.

    Attributes
    ----------
    cells
        The real and imaginary parts (n, 2, cells) of each cell's sum of echoes; None without
        fading.
    floors, energies
        The deviations (n, 2, gates) of floors and energies, in their standard deviations.
    targets
        The deviations (n, targets + 1, 2) of distances and directions; the last are those of the
        distance that is read.
    """

    cells: Array | None
    floors: Array
    energies: Array
    targets: Array

    @classmethod
    def of_block(cls, parameters: RadarParameters, generator: np.random.Generator) -> RandomNumbers:
        """Draw the numbers of a whole block of updates."""
        gates = BLOCK, 2, parameters.gates
        return cls(
            generator.standard_normal((BLOCK, 2, cells_of(parameters)))
            if parameters.fading
            else None,
            generator.standard_normal(gates),
            generator.standard_normal(gates) if parameters.energy_noise else np.zeros(gates),
            generator.standard_normal((BLOCK, parameters.max_targets + 1, 2))
            if parameters.range_noise or parameters.angle_noise
            else np.zeros((BLOCK, parameters.max_targets + 1, 2)),
        )

    def rows(self, which: Any) -> RandomNumbers:
        """Return the numbers of the updates that the index `which` selects."""
        cells = None if self.cells is None else self.cells[which]
        return RandomNumbers(cells, *(part[which] for part in self[1:]))


class Noise:
    """Draws the random numbers of updates by their numbers, and keeps the last block."""

    def __init__(self) -> None:
        self._last: tuple[RadarParameters, int, RandomNumbers] | None = None

    def draw(
        self,
        parameters: RadarParameters,
        numbers: Index,
        noise: Callable[[int], np.random.Generator],
    ) -> RandomNumbers:
        """Return the random numbers of updates (n,), in ascending order of their numbers.

        `noise` returns the random generator of a number. The block of an update is its number.
        """
        blocks, parts = numbers // BLOCK, []
        for block in np.unique(blocks).tolist():
            if self._last is None or self._last[:2] != (parameters, block):
                drawn = RandomNumbers.of_block(parameters, noise(block))
                self._last = parameters, block, drawn
            parts.append(self._last[2].rows(numbers[blocks == block] - block * BLOCK))
        if len(parts) == 1:
            return parts[0]
        cells, *others = zip(*parts, strict=True)
        joined = None if cells[0] is None else np.concatenate(cells)
        return RandomNumbers(joined, *map(np.concatenate, others))


class Profile(NamedTuple):
    """The mean amplitudes of what some rays return, first as moving, then as still.

    `cells` (2, cells) are those by distance, and `gates` (2, gates) those of the gates.
    """

    cells: Array
    gates: Array


def profile(
    parameters: RadarParameters, known: Calibration, ranges: Array, powers: Array
) -> Profile:
    """Return the profile of rays at `ranges` (n,) in m with weighted powers (2, n)."""
    cells = np.stack([in_cells(parameters, ranges, power) for power in powers])
    in_gates = gate_sums(cells, WINDOW**2, parameters.gates)
    gain = known.gain[:, None]
    return Profile(gain * np.sqrt(cells), gain * np.sqrt(in_gates))


def amplitudes(
    parameters: RadarParameters, cells: Array, gates: Array, drawn: RandomNumbers
) -> Array:
    """Return the amplitudes (n, 2, gates) of echoes at n updates, faded.

    `cells` (n, 2, cells) and `gates` (n, 2, gates) are those of the profiles at the updates.
    """
    if drawn.cells is None:
        return gates.copy()
    found = np.zeros(gates.shape)
    for i in range(2):
        rows = np.flatnonzero(gates[:, i].any(axis=-1))
        if len(rows):
            sums = gate_sums(drawn.cells[rows] * cells[rows, i, None], WINDOW, parameters.gates)
            found[rows, i] = UNIT_RAYLEIGH * np.hypot(sums[:, 0], sums[:, 1])
    return found


def with_floors(
    parameters: RadarParameters, known: Calibration, echo: Array, drawn: RandomNumbers
) -> Array:
    """Return the amplitudes (n, 2, gates) of echoes and floors together: their powers add."""
    floors = known.floors * (1.0 + parameters.floor_noise * drawn.floors)
    found: Array = np.hypot(echo, np.maximum(floors, 0.0))
    return found


def read_distance(parameters: RadarParameters, amplitudes: Array, detects: Any) -> Array:
    """Return the distances (n,) in m of the strongest gates that detect; NaN where none does.

    The distance is interpolated between the gate and the stronger one beside it, as the peak of a
    spectrum with a Hann window.

    Parameters
    ----------
    amplitudes
        The amplitudes (n, gates).
    detects
        Whether each gate detects anything (n, gates).
    """
    rows = np.arange(len(amplitudes))
    gate = np.where(detects, amplitudes, -1.0).argmax(axis=1)
    beside = np.pad(amplitudes, ((0, 0), (1, 1)))
    nearer, peak, farther = (beside[rows, gate + i] for i in range(3))
    side = np.where(farther >= nearer, 1.0, -1.0)
    ratio = np.maximum(nearer, farther) / np.maximum(peak, 1e-300)
    # The ratio of two neighbours of a Hann window, solved for the place of the peak.
    shift = np.clip((2.0 * ratio - 1.0) / (1.0 + ratio), 0.0, 1.0)
    found = (gate + side * shift) * parameters.gate_length
    found = np.clip(found, parameters.range_min, parameters.range_max)
    return np.where(detects.any(axis=1), found, np.nan)


class LeakyMean:
    """A mean of the last seconds: older values count exponentially less."""

    def __init__(self) -> None:
        self._sum: Array | None = None
        self._start = self._time = 0.0
        self._constant = 1.0

    def run(self, times: Array, values: Array, constant: float) -> Array:
        """Return the mean (n, …) at each of the `times` (n,) in s, of values (n, …) up to then.

        `constant` is the time constant in s. The first value is the mean before it, also after a
        change of the number of values. The result does not depend on how updates are divided into
        calls.
        """
        found = np.empty(values.shape)
        spans = np.floor(times / (SPAN * constant))
        begins = np.flatnonzero(np.diff(spans, prepend=np.nan) != 0.0)
        shape = -1, *[1] * (values.ndim - 1)
        for begin, end in zip(begins, [*begins[1:], len(times)], strict=True):
            part, start = slice(begin, end), float(spans[begin]) * SPAN * constant
            before = self._sum
            if before is None or before.shape != values.shape[1:]:
                self._start, self._time = start, float(times[0])
                before = values[0] * math.exp((self._time - start) / constant)
            elif constant != self._constant:
                grown_before = (self._time - self._start) / self._constant
                before = before * math.exp((self._time - start) / constant - grown_before)
            elif start != self._start:
                before = before * math.exp((self._start - start) / constant)
            step = np.diff(times[part], prepend=self._time)
            grown = np.exp((times[part] - start) / constant).reshape(shape)
            added = -np.expm1(-step / constant).reshape(shape) * values[part] * grown
            # In order, so that a sum that goes on in another call has the same bits.
            sums = np.cumsum(np.concatenate([before[None], added]), axis=0)[1:]
            found[part] = sums / grown
            self._sum, self._start, self._time = sums[-1], start, float(times[end - 1])
            self._constant = constant
        return found


# Targets.


@dataclass(frozen=True)
class Target:
    """One target: what cannot be separated in distance and angle.

    `distance` is in m, `azimuth` in radians to the right, and `speed` in m/s away from the radar.
    """

    distance: float
    azimuth: float
    speed: float


@dataclass(frozen=True)
class EchoGroup:
    """Rays that are one target if a gate detects them; the strongest group is that of most power.

    `rays` (k,) has their numbers, `power` is in m⁻², and `profile` has their amplitudes.
    """

    target: Target
    rays: Index
    power: float
    profile: Profile


def separate(
    ranges: Array, azimuth: Array, gate_length: float, angle_resolution: float
) -> Iterator[Index]:
    """Yield the groups of rays that can be separated, as their numbers.

    Two groups are separate if a gap of more than `gate_length` lies between their ranges (n,), or
    a gap of more than `angle_resolution` between their azimuths (n,). Each part is divided again,
    along both axes in turn, until no part has a gap.
    """
    axes = ((ranges, gate_length), (azimuth, angle_resolution))
    # Rays, the axis to try next, and along how many axes they have no gap.
    waiting: list[tuple[Index, int, int]] = [(np.arange(len(ranges)), 0, 0)]
    while waiting:
        rays, axis, tried = waiting.pop()
        values, apart = axes[axis]
        order = rays[np.argsort(values[rays], kind="stable")]
        cuts = np.flatnonzero(np.diff(values[order]) > apart) + 1
        if len(cuts):
            waiting += [(part, 1 - axis, 1) for part in np.split(order, cuts)]
        elif tried == 0:
            waiting.append((rays, 1 - axis, 1))
        elif len(rays):
            yield rays


@dataclass(frozen=True)
class Sweep:
    """What a radar receives at one update, on the mean over the fading and without floors.

    Attributes
    ----------
    powers
        The powers (2, n) in m⁻² that the rays return: as moving, and in the still energies.
    speed
        The mean radial speed (n,) in m/s at the hit of each ray, positive away from the radar.
    profile
        The amplitudes by distance.
    groups
        The groups of rays, if the module reports targets; the nearest first.
    echoes
        What the rays hit.
    """

    powers: Array
    speed: Array
    profile: Profile
    groups: tuple[EchoGroup, ...]
    echoes: Echoes


def sweep(parameters: RadarParameters, known: Calibration, beams: Beams, echoes: Echoes) -> Sweep:
    """Return what a radar with the rays `beams` receives; `echoes` has what they hit."""
    # Most rays hit what neither moves nor lives.
    rays = np.flatnonzero(echoes.speed.any(axis=0) | (echoes.breathing > 0.0))
    part = replace(
        echoes,
        ranges=echoes.ranges[rays],
        speed=echoes.speed[:, rays],
        **{
            name: getattr(echoes, name)[rays]
            for name in ("breathing", "rate", "loss", "reflectance")
        },
    )
    powers, speed = np.zeros((2, len(beams.weight))), np.zeros(len(beams.weight))
    powers[:, rays] = echo_powers(parameters, beams.weight[rays], part) * doppler_weights(
        parameters, part
    )
    speed[rays] = np.where(np.abs(part.speed) <= FASTEST, part.speed, 0.0).mean(axis=0)
    found = profile(parameters, known, part.ranges, powers[:, rays])
    grouped: tuple[EchoGroup, ...] = ()
    if parameters.max_targets:
        grouped = tuple(groups(parameters, known, beams, echoes.ranges, powers, speed))
    return Sweep(powers, speed, found, grouped, echoes)


def groups(
    parameters: RadarParameters,
    known: Calibration,
    beams: Beams,
    ranges: Array,
    powers: Array,
    speed: Array,
) -> list[EchoGroup]:
    """Return the groups of rays that can be separated, ordered by distance.

    Distance and direction are means weighted by power; so is the speed, over what moves. `ranges`
    and `speed` (n,) and `powers` (2, n) are those of the rays.
    """
    total = powers.sum(axis=0)
    rays = np.flatnonzero(total > 0.0)
    found = []
    apart = parameters.bin_length, parameters.angle_resolution
    for part in separate(ranges[rays], beams.azimuth[rays], *apart):
        which = rays[part]
        weight, moving = total[which], powers[0, which]
        power = float(weight.sum())
        distance = float(weight @ ranges[which]) / power
        azimuth = float(weight @ beams.azimuth[which]) / power
        mean = float(moving @ speed[which]) / max(float(moving.sum()), 1e-300)
        seen = profile(parameters, known, ranges[which], powers[:, which])
        target = Target(distance * parameters.range_scale, azimuth, mean)
        found.append(EchoGroup(target, which, power, seen))
    return sorted(found, key=lambda group: group.target.distance)


def find_targets(
    parameters: RadarParameters, known: Calibration, seen: Sweep, drawn: RandomNumbers
) -> list[list[Target]]:
    """Return the strongest targets at each of n updates, at most max_targets, the nearest first.

    A group is a target if its own rays exceed the threshold of movement in a gate, or that of
    breathing on the mean: targets have no identity, and so no memory.
    """
    detects, count = [], len(drawn.floors)
    floors_vary = known.floors.any() and parameters.floor_noise
    if drawn.cells is None and not (parameters.energy_noise or floors_vary):
        # The same at each update.
        drawn = drawn.rows(slice(0, 1))
    for group in seen.groups:
        shape = len(drawn.floors)
        cells, gates = (np.broadcast_to(one, (shape, *one.shape)) for one in group.profile)
        echo = amplitudes(parameters, cells, gates, drawn)
        echo[:, 1] = group.profile.gates[1]
        energy = energies(parameters, with_floors(parameters, known, echo, drawn), drawn)
        detects.append((energy > known.thresholds).any(axis=(1, 2)))
    order = sorted(range(len(detects)), key=lambda i: -seen.groups[i].power)
    found = []
    for update in np.stack(detects, axis=1).tolist() if detects else [[]]:
        strongest = [i for i in order if update[i]][: parameters.max_targets]
        found.append([seen.groups[i].target for i in sorted(strongest)])
    return found if len(found) == count else found * count


def energies(parameters: RadarParameters, found: Array, drawn: RandomNumbers) -> Array:
    """Return amplitudes (n, 2, gates) as energies with their noise, not clipped."""
    return energy_of(parameters, found) + parameters.energy_noise * drawn.energies


def _with_noise(parameters: RadarParameters, found: list[Target], noise: Array) -> list[Target]:
    """Return targets with noise (targets, 2); distances stay within the range."""
    if not (parameters.range_noise or parameters.angle_noise):
        return found
    pairs = zip(found, noise.tolist(), strict=False)
    return [
        Target(
            min(
                max(one.distance + far * parameters.range_noise, parameters.range_min),
                parameters.range_max,
            ),
            one.azimuth + aside * parameters.angle_noise,
            one.speed,
        )
        for one, (far, aside) in pairs
    ]


def _set_up(parameters: RadarParameters, pose: Pose) -> tuple[Beams, Calibration]:
    return radar_beams(parameters, pose), calibration(parameters)


class Sensed(NamedTuple):
    """What a radar measures at n updates.

    Attributes
    ----------
    energies
        The reported energies (n, 2, gates), of movement and of who only breathes.
    detects
        Whether each of them is above its threshold (n, 2, gates).
    distance
        The distance (n,) in m of what moves, else of what only breathes; NaN without a detection.
    targets, sweeps
        The targets, and what the radar receives, at each update.
    """

    energies: Array
    detects: NDArray[np.bool_]
    distance: Array
    targets: list[list[Target]]
    sweeps: list[Sweep]


class PresenceRadar(Model):
    """The model of one radar.

    Its state is the mean of the still energies, the last distance and the output with its hold
    time.
    """

    def __init__(self) -> None:
        self._set_up = PerPose(_set_up)
        self._noise = Noise()
        self._mean = LeakyMean()
        self._output = OutputTiming()
        self._has_started: bool | None = None
        self._distance = math.nan
        self._last: tuple[Any, Echoes, Sweep] | None = None
        self._received: tuple[Sweep, Received] | None = None

    def sense(self, parameters: RadarParameters, updates: Updates) -> Readings:
        """Return the readings; `updates` must continue those of the previous call."""
        beams, _ = self._set_up(parameters, updates.pose)
        rays = beams.origins, beams.directions, beams.length
        how = parameters.frequency, parameters.integration_time
        answers = updates.ask(ECHOES, 0, *rays, *how)
        size = max(1, AT_ONCE // (2 * cells_of(parameters)))
        parts = [
            self._sensed(parameters, updates, answers, slice(first, first + size))
            for first in range(0, len(updates), size)
        ]
        reported, above, read = map(np.concatenate, list(zip(*parts, strict=True))[:3])
        targets = [one for part in parts for one in part.targets]
        found = Sensed(reported, above, read, targets, [s for part in parts for s in part.sweeps])
        presence = self._presence(parameters, updates.times, np.any(above, axis=2))
        distance = self._distances(parameters, presence, found.distance)
        evidence = self._evidence(parameters, updates, presence, found)
        return replace(_readings(updates.due, presence, distance, found), evidence=evidence)

    def _evidence(
        self,
        parameters: RadarParameters,
        updates: Updates,
        presence: NDArray[np.bool_],
        found: Sensed,
    ) -> dict[str, list[Any]]:
        """Return the evidence of the updates that are due, by field."""
        beams, _ = self._set_up(parameters, updates.pose)
        rows = []
        for i in np.flatnonzero(updates.due).tolist():
            seen = found.sweeps[i]
            if self._received is None or self._received[0] is not seen:
                of = seen.echoes, seen.powers, seen.speed, seen.profile.gates, beams.weight
                self._received = seen, Received(parameters, *of, updates.name_of)
            # Without an earlier movement, the still energies do not count.
            detects = found.detects[i] & np.array([[True], [presence[i]]])
            rows.append(self._received[1].evidence(found.energies[i], detects))
        return {field.name: [row[field.name] for row in rows] for field in FIELDS}

    def _sensed(
        self, parameters: RadarParameters, updates: Updates, answers: Answers, part: slice
    ) -> Sensed:
        """Return what the radar measures at some of the updates."""
        _, known = self._set_up(parameters, updates.pose)
        rows, where = np.unique(answers.rows[part], return_inverse=True)
        seen = [self._sweep(parameters, updates.pose, answers.table[row]) for row in rows.tolist()]
        drawn = self._noise.draw(parameters, updates.numbers[part], updates.noise)
        cells, gates = (np.stack([one.profile[i] for one in seen])[where] for i in range(2))
        found = with_floors(parameters, known, amplitudes(parameters, cells, gates, drawn), drawn)
        found[:, 1] = self._mean.run(updates.times[part], found[:, 1], parameters.still_time)
        energy = energies(parameters, found, drawn)
        detects = energy > known.thresholds
        moving, still = (read_distance(parameters, found[:, i], detects[:, i]) for i in range(2))
        distance = np.where(np.isnan(moving), still, moving)
        if parameters.range_noise:
            distance = distance + parameters.range_noise * drawn.targets[:, -1, 0]
            distance = np.clip(distance, parameters.range_min, parameters.range_max)
        reported = np.where(known.is_on, np.clip(energy, 0.0, 100.0), 0.0)
        targets: list[list[Target]] = [[] for _ in where]
        for i, one in enumerate(seen if parameters.max_targets else ()):
            which = np.flatnonzero(where == i)
            each = drawn.rows(which)
            made = find_targets(parameters, known, one, each)
            for k, list_of, noise in zip(which.tolist(), made, each.targets, strict=True):
                targets[k] = _with_noise(parameters, list_of, noise)
        sweeps = [seen[row] for row in where.tolist()]
        return Sensed(reported, detects, distance, targets, sweeps)

    def _sweep(self, parameters: RadarParameters, pose: Pose, echoes: Echoes) -> Sweep:
        """Return what the radar receives, again for the echoes of the update before.

        So an update of a still scene takes 0.01 ms instead of 0.2 ms, 20 times less.
        """
        beams, known = set_up = self._set_up(parameters, pose)
        last = self._last
        if last is not None and last[0] is set_up and last[1] is echoes:
            return last[2]
        found = sweep(parameters, known, beams, echoes)
        self._last = set_up, echoes, found
        return found

    def _presence(
        self, parameters: RadarParameters, times: Array, detects: NDArray[np.bool_]
    ) -> NDArray[np.bool_]:
        """Return whether presence is on (n,); `detects` (n, 2) has movement, and breathing."""
        either: NDArray[np.bool_] = detects[:, 0] | detects[:, 1]
        held = self._output.run(times, either, parameters.hold_time, 0.0, 0.0)
        if not parameters.movement_starts or not len(held):
            return held
        # Presence is on from the first movement of a time of detections.
        starts = detects[:, 0].copy()
        if self._has_started is None:
            # Who was there before the run began has moved then.
            starts[0] = detects[0].any()
            self._has_started = False
        count = np.cumsum(starts)
        begins = held & ~np.concatenate([[False], held[:-1]])
        begins[0] = held[0] and not self._has_started
        before = np.maximum.accumulate(np.where(begins, count - starts, -1))
        found: NDArray[np.bool_] = held & (count > before)
        self._has_started = bool(found[-1])
        return found

    def _distances(
        self, parameters: RadarParameters, presence: NDArray[np.bool_], distance: Array
    ) -> Array:
        """Return the distances (n,) to report: the last one while presence is held."""
        distance = np.where(presence, distance, parameters.range_max)
        known = np.concatenate([[self._distance], distance])
        last = np.maximum.accumulate(np.where(np.isnan(known), 0, np.arange(len(known))))
        found: Array = known[last][1:]
        if len(found):
            self._distance = float(found[-1])
        return found


def _readings(
    due: NDArray[np.bool_], presence: NDArray[np.bool_], distance: Array, found: Sensed
) -> Readings:
    """Return the readings at the updates that are `due`."""
    which = np.flatnonzero(due)
    chosen = [found.targets[i] for i in which.tolist()]
    fields: dict[str, Any] = {
        "presence": presence[which],
        "moving": found.detects[which, 0].any(axis=1),
        "distance_m": distance[which],
        "targets": [len(one) for one in chosen],
        "x_m": _joined(chosen, x_of),
        "y_m": _joined(chosen, y_of),
        "speed_mps": _joined(chosen, lambda target: target.speed),
        "gates": gates_texts(found.energies[which]),
    }
    return Readings(presence[which], distance[which], fields)


def x_of(target: Target) -> float:
    """Return the x coordinate of a target in m: to the right as seen by the radar."""
    return target.distance * math.sin(target.azimuth)


def y_of(target: Target) -> float:
    """Return the y coordinate of a target in m: ahead of the radar.

    Modules do not measure elevations: the distance along the ray counts as a level one.
    """
    return target.distance * math.cos(target.azimuth)


def _joined(updates: list[list[Target]], value: Callable[[Target], float]) -> list[str]:
    """Return a value of the targets at each update as a text, joined by semicolons."""
    return [";".join([f"{value(target):.3f}" for target in one]) if one else "" for one in updates]


# The texts of all pairs of whole energies, since formatting each takes longer than the model.
_PAIRS = [f"{moving}/{still}" for moving in range(101) for still in range(101)]


def gates_texts(reported: Array) -> list[str]:
    """Return reported energies (n, 2, gates) as the field `gates`, such as "100/0;35/12"."""
    whole = np.rint(reported).astype(np.intp)
    pairs = whole[:, 0] * 101 + whole[:, 1]
    return [";".join([_PAIRS[pair] for pair in row]) for row in pairs.tolist()]
