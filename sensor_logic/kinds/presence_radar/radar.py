# SPDX-License-Identifier: GPL-3.0-or-later
"""Presence radar: the model.

Rays sample the field of view, and each returns a power by the radar equation. The power counts as
moving if the radial speed is high enough. Of a breathing body, a share of the power counts as
still. Each distance gate sums both, and compares them with thresholds. See docs/presence_radar.md.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...model import Array, Index, Model, PerPose, Pose, Readings, Updates
from ...physics import OutputTiming
from ...radio.echoes import ECHOES, Echoes
from ...radio.substances import reflectance
from .parameters import FASTEST, NEVER, RadarParameters

# The standard person, who is just detected at the ranges of a data sheet: as high and wide (m) as
# the walker of coverage maps, with quiet breathing (m, peak to peak).
PERSON_HEIGHT, PERSON_WIDTH = 1.7, 0.4
PERSON_BREATHING = 0.005
# The share of a body's echo that comes from its breathing trunk: trunk of the front of the body by
# the rule of nines (Wallace 1951), 18 of 50 %.
TRUNK = 0.36
# The scale of energies: 100 points are 40 dB. Makers publish no scale.
POINTS_PER_DB = 2.5
# Targets are not nearer than this (m), so that powers are finite.
NEAREST = 0.01
# Angles of the mean that gives J₀: exact to rounding for arguments up to 60.
SAMPLES = 96
_SINES = np.sin((np.arange(SAMPLES) + 0.5) * (math.pi / SAMPLES))
# The golden ratio spaces the rows' offsets most evenly.
GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0


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


def radar_beams(parameters: RadarParameters, pose: Pose) -> Beams:
    """Return the rays of a radar.

    Rows of equal elevation divide the field of view, and the rays of a row its azimuths. Each row
    is offset by a different part of the spacing, so that no body is missed between two columns.
    """
    across, up = parameters.rays_across, parameters.rays_up
    width, height = parameters.horizontal_fov / across, parameters.vertical_fov / up
    row = np.arange(up) - (up - 1) / 2.0
    elevation = row * height
    offset = (0.5 + row * GOLDEN) % 1.0
    azimuth = (np.arange(across) + offset[:, None]) * width - parameters.horizontal_fov / 2.0
    solid = width * (np.sin(elevation + height / 2.0) - np.sin(elevation - height / 2.0))
    weight = solid[:, None] * two_way_gain(parameters, azimuth, elevation[:, None])
    level = np.cos(elevation)[:, None]
    rise = np.broadcast_to(np.sin(elevation)[:, None], azimuth.shape)
    local = np.stack([np.sin(azimuth) * level, rise, -np.cos(azimuth) * level], axis=-1)
    directions = local.reshape(-1, 3) @ pose.axes.T
    origins = np.broadcast_to(pose.origin, directions.shape)
    length = np.full(len(directions), parameters.range_max)
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


def bessel_j0(x: ArrayLike) -> Array:
    """Return the Bessel function J₀(x): the mean of cos(x·sin θ) over half a turn of θ.

    The mean over equally spaced θ converges faster than any power of their number, because the
    function is periodic and smooth.

    References
    ----------
    Abramowitz and Stegun (1964), Handbook of Mathematical Functions, 9.1.18.
    """
    found: Array = np.cos(np.asarray(x, np.float64)[..., None] * _SINES).mean(axis=-1)
    return found


def modulated_share(breathing: ArrayLike, wavelength: float) -> Array:
    """Return the share of an echo's power that breathing moves out of the still echo.

    A surface that swings by A·sin(Ωt) along the ray modulates the phase of its echo by
    4πA/λ·sin(Ωt). The line of the still echo keeps J₀²(4πA/λ) of the power; all the rest is in
    sidebands at multiples of the breathing rate.

    Parameters
    ----------
    breathing
        The displacement 2A in m from peak to peak.
    wavelength
        The wavelength λ in m.
    """
    phase = 2.0 * math.pi * np.asarray(breathing, np.float64) / wavelength
    found: Array = 1.0 - bessel_j0(phase) ** 2
    return found


def echo_powers(parameters: RadarParameters, weight: Array, echoes: Echoes) -> Array:
    """Return the power (n,) that each ray returns, in m⁻².

    By the radar equation, the power of a target of cross-section σ falls with R⁴. A ray of the
    solid angle ΔΩ covers ΔΩ·R² of a surface, so its echo is ρ·ΔΩ·G²/R² · 10^(−2L/10), with the
    reflectance ρ, the two-way gain G² and the one-way loss L in dB. `weight` (n,) is ΔΩ·G².
    """
    near = np.maximum(echoes.ranges, NEAREST)
    power = echoes.reflectance * weight / near**2 * 10.0 ** (-0.2 * echoes.loss)
    seen = (echoes.ranges < parameters.range_max) & (echoes.ranges >= parameters.range_min)
    return np.where(seen, power, 0.0)


@dataclass(frozen=True)
class Calibration:
    """The powers in m⁻² that the standard person returns at the ranges of the data sheet.

    Attributes
    ----------
    moving, still
        The power of a walking person at moving_range, and of a breathing one at still_range.
    moving_energy, still_energy
        The energies there: the thresholds of these gates.
    moving_needed, still_needed
        The powers (gates,) above which each gate detects; inf for a gate that never detects.
    """

    moving: float
    still: float
    moving_energy: float
    still_energy: float
    moving_needed: Array
    still_needed: Array


def person_power(parameters: RadarParameters, distance: float) -> float:
    """Return the power in m⁻² that the standard person returns who walks straight ahead.

    The person is a plate across the view axis at `distance` (m), with its middle on the axis. The
    parts at the elevation ε are at d/cos ε, and seen under an angle: ρ·w/d⁴·∫ G²·cos⁵ε dz.
    """
    steps = 64
    height = ((np.arange(steps) + 0.5) / steps - 0.5) * PERSON_HEIGHT
    elevation = np.arctan2(height, distance)
    mean = float(np.mean(two_way_gain(parameters, 0.0, elevation) * np.cos(elevation) ** 5))
    area = PERSON_HEIGHT * PERSON_WIDTH * mean
    return reflectance("BODY", parameters.frequency) * area / distance**4


def breathing_share(parameters: RadarParameters) -> float:
    """Return the share of the standard person's power that breathing modulates."""
    return TRUNK * float(modulated_share(PERSON_BREATHING, parameters.wavelength))


def calibration(parameters: RadarParameters) -> Calibration:
    """Return the calibration of a radar to the ranges of its data sheet."""
    moving = person_power(parameters, parameters.moving_range)
    still = person_power(parameters, parameters.still_range) * breathing_share(parameters)
    found = []
    for power, name, distance in (
        (moving, "moving_thresholds", parameters.moving_range),
        (still, "still_thresholds", parameters.still_range),
    ):
        thresholds = parameters.thresholds(name)
        energy = float(thresholds[gate_of(parameters, np.array([distance]))[0]])
        needed = power * 10.0 ** ((thresholds - energy) / (10.0 * POINTS_PER_DB))
        found.append((energy, np.where(thresholds < NEVER, needed, np.inf)))
    return Calibration(moving, still, found[0][0], found[1][0], found[0][1], found[1][1])


def energies(power: Array, reference: float, energy: float) -> Array:
    """Return powers as energies from 0 to 100: 2.5 points a dB.

    A power of `reference` has the energy `energy`.
    """
    with np.errstate(divide="ignore"):
        found = energy + 10.0 * POINTS_PER_DB * np.log10(power / reference)
    return np.clip(found, 0.0, 100.0)


def gate_of(parameters: RadarParameters, ranges: Array) -> Index:
    """Return the numbers (n,) of the gates in which ranges (n,) in m are, from 0."""
    gate = (ranges / parameters.gate_length).astype(np.intp)
    return np.minimum(gate, parameters.gates - 1)


def in_gates(gate: Index, power: Array, gates: int) -> Array:
    """Return the sums (gates,) of the powers (n,) of rays in each gate; `gate` (n,) is theirs."""
    return np.bincount(gate, power, gates).astype(np.float64)


@dataclass(frozen=True)
class Target:
    """One target: what cannot be separated in distance and angle.

    `distance` is in m, `azimuth` in radians to the right, `speed` in m/s away from the radar.
    `power` is in m⁻², and `rays` (k,) has the numbers of its rays.
    """

    distance: float
    azimuth: float
    speed: float
    power: float
    rays: Index


@dataclass(frozen=True)
class Sweep:
    """What a radar measures at one update, without noise.

    Attributes
    ----------
    moving_power, still_power
        The powers (n,) in m⁻² that the rays return from what moves and from what breathes.
    speed
        The radial speed (n,) in m/s at the hit of each ray, positive away from the radar.
    gate
        The gate (n,) of each ray.
    moving, still
        The sums (gates,) of these powers in each gate.
    """

    moving_power: Array
    still_power: Array
    speed: Array
    gate: Index
    moving: Array
    still: Array


def sweep(parameters: RadarParameters, weight: Array, echoes: Echoes) -> Sweep:
    """Return what a radar measures.

    Parameters
    ----------
    weight
        The weights (n,) of the rays, as in `Beams`.
    echoes
        What the rays hit.
    """
    power = echo_powers(parameters, weight, echoes)
    speed = echoes.speed.mean(axis=0)
    is_moving = (np.abs(speed) >= parameters.minimum_speed) & (np.abs(speed) <= FASTEST)
    breathes = (echoes.breathing > 0.0) & ~is_moving & (power > 0.0)
    share = np.zeros(len(power))
    if breathes.any():
        depths, which = np.unique(echoes.breathing[breathes], return_inverse=True)
        share[breathes] = TRUNK * modulated_share(depths, parameters.wavelength)[which]
    moving_power, still_power = np.where(is_moving, power, 0.0), power * share
    gate, gates = gate_of(parameters, echoes.ranges), parameters.gates
    moving, still = in_gates(gate, moving_power, gates), in_gates(gate, still_power, gates)
    return Sweep(moving_power, still_power, speed, gate, moving, still)


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


def targets(
    parameters: RadarParameters,
    known: Calibration,
    beams: Beams,
    echoes: Echoes,
    seen: Sweep,
    noise: Array,
) -> list[Target]:
    """Return the strongest targets, at most max_targets, ordered by distance.

    A target exceeds the threshold of a gate with its own rays, whose powers are multiplied by
    `noise` (2, gates), the factors of movement and of breathing. Its distance and direction are
    means weighted by power; so is its speed, over those rays that move.
    """
    power = seen.moving_power + seen.still_power
    rays = np.flatnonzero(power > 0.0)
    ranges, azimuth = echoes.ranges[rays], beams.azimuth[rays]
    found = []
    for group in separate(ranges, azimuth, parameters.gate_length, parameters.angle_resolution):
        which = rays[group]
        gate, gates = seen.gate[which], parameters.gates
        moving = in_gates(gate, seen.moving_power[which], gates) * noise[0]
        still = in_gates(gate, seen.still_power[which], gates) * noise[1]
        if (moving > known.moving_needed).any() or (still > known.still_needed).any():
            weight, fast = power[which], seen.moving_power[which]
            total = float(weight.sum())
            speed = float(fast @ seen.speed[which]) / max(float(fast.sum()), 1e-300)
            distance, angle = weight @ ranges[group] / total, weight @ azimuth[group] / total
            found.append(Target(float(distance), float(angle), speed, total, which))
    strongest = sorted(found, key=lambda target: -target.power)[: parameters.max_targets]
    return sorted(strongest, key=lambda target: target.distance)


@dataclass(frozen=True)
class Measurement:
    """The result of one update, noise included.

    Attributes
    ----------
    moving_energy, still_energy
        The energies (gates,) from 0 to 100.
    moving, still
        Whether each gate detects movement, and breathing (gates,).
    distance
        The distance in m in the nearest gate that detects anything; None without one.
    targets
        The targets.
    """

    moving_energy: Array
    still_energy: Array
    moving: NDArray[np.bool_]
    still: NDArray[np.bool_]
    distance: float | None
    targets: list[Target]


def measure(
    parameters: RadarParameters,
    known: Calibration,
    beams: Beams,
    echoes: Echoes,
    generator: np.random.Generator | None = None,
) -> Measurement:
    """Return the result of one update.

    Parameters
    ----------
    parameters, known, beams
        The parameters of the radar, its calibration and its rays.
    echoes
        What the rays hit.
    generator
        The random generator of the noise; None for none.
    """
    seen = sweep(parameters, beams.weight, echoes)
    noise = np.ones((2, parameters.gates))
    if generator is not None:
        points = generator.normal(0.0, parameters.energy_noise, noise.shape)
        noise = 10.0 ** (points / (10.0 * POINTS_PER_DB))
    moving, still = np.stack([seen.moving, seen.still]) * noise
    is_moving, is_still = moving > known.moving_needed, still > known.still_needed
    found = []
    if parameters.max_targets:
        found = targets(parameters, known, beams, echoes, seen, noise)
    distance = None
    if (is_moving | is_still).any():
        nearest = int(np.argmax(is_moving | is_still))
        weight = np.where(is_moving[nearest], seen.moving_power, 0.0)
        weight = weight + np.where(is_still[nearest], seen.still_power, 0.0)
        weight = np.where(seen.gate == nearest, weight, 0.0)
        distance = float(weight @ echoes.ranges / weight.sum())
    if generator is not None:
        distance, found = _with_noise(parameters, distance, found, generator)
    return Measurement(
        energies(moving, known.moving, known.moving_energy),
        energies(still, known.still, known.still_energy),
        is_moving,
        is_still,
        distance,
        found,
    )


def _with_noise(
    parameters: RadarParameters,
    distance: float | None,
    found: list[Target],
    generator: np.random.Generator,
) -> tuple[float | None, list[Target]]:
    """Return the distance and the targets with noise; distances stay within the range."""
    noise = generator.normal(0.0, 1.0, (parameters.max_targets + 1, 2))
    noise *= parameters.range_noise, parameters.angle_noise

    def within(value: float) -> float:
        return min(max(value, parameters.range_min), parameters.range_max)

    if distance is not None:
        distance = within(distance + float(noise[-1, 0]))
    pairs = zip(found, noise.tolist(), strict=False)
    return distance, [
        replace(one, distance=within(one.distance + far), azimuth=one.azimuth + aside)
        for one, (far, aside) in pairs
    ]


def _set_up(parameters: RadarParameters, pose: Pose) -> tuple[Beams, Calibration]:
    return radar_beams(parameters, pose), calibration(parameters)


class PresenceRadar(Model):
    """The model of one radar.

    Its state is the last distance and the output with its hold time.
    """

    def __init__(self) -> None:
        self._set_up = PerPose(_set_up)
        self._output = OutputTiming()
        self._distance = math.nan
        self._last: tuple[Echoes, Measurement] | None = None
        self._parameters: RadarParameters | None = None

    def sense(self, parameters: RadarParameters, updates: Updates) -> Readings:
        """Return the readings; `updates` must continue those of the previous call."""
        if parameters != self._parameters:
            self._parameters, self._last = parameters, None
        beams, known = self._set_up(parameters, updates.pose)
        rays = beams.origins, beams.directions, beams.length
        how = parameters.frequency, parameters.integration_time
        answers = updates.ask(ECHOES, 0, *rays, *how)
        is_noisy = bool(parameters.energy_noise or parameters.range_noise or parameters.angle_noise)
        found = []
        for i, number in enumerate(updates.numbers.tolist()):
            generator = updates.noise(number) if is_noisy else None
            found.append(self._measured(parameters, known, beams, answers[i], generator))
        detects = np.array([bool((one.moving | one.still).any()) for one in found])
        presence = self._output.run(updates.times, detects, parameters.hold_time, 0.0, 0.0)
        distance = np.empty(len(found))
        for i, one in enumerate(found):
            if one.distance is not None:
                self._distance = one.distance
            elif not presence[i]:
                self._distance = parameters.range_max
            distance[i] = self._distance
        return _readings(parameters, updates.due, presence, distance, found)

    def _measured(
        self,
        parameters: RadarParameters,
        known: Calibration,
        beams: Beams,
        echoes: Echoes,
        generator: np.random.Generator | None,
    ) -> Measurement:
        """Return the result of one update.

        If nothing moved and the echoes are those of the update before, return its result. So an
        update of a still scene takes 0.01 ms instead of 0.6 ms, 40 times less.
        """
        last = self._last
        if generator is None and last is not None and last[0] is echoes and not echoes.speed.any():
            return last[1]
        measured = measure(parameters, known, beams, echoes, generator)
        self._last = echoes, measured
        return measured


def _readings(
    parameters: RadarParameters,
    due: NDArray[np.bool_],
    presence: NDArray[np.bool_],
    distance: Array,
    found: list[Measurement],
) -> Readings:
    """Return the readings at the updates that are `due`."""
    which = np.flatnonzero(due)
    chosen = [found[i] for i in which.tolist()]
    fields: dict[str, Any] = {
        "presence": presence[which],
        "moving": np.array([bool(one.moving.any()) for one in chosen], bool),
        "distance_m": distance[which],
        "targets": [len(one.targets) for one in chosen],
        "x_m": [_joined(x_of(target) for target in one.targets) for one in chosen],
        "y_m": [_joined(y_of(target) for target in one.targets) for one in chosen],
        "speed_mps": [_joined(target.speed for target in one.targets) for one in chosen],
        "gates": [gates_text(one) for one in chosen],
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


def _joined(values: Iterable[float]) -> str:
    return ";".join(f"{value:.3f}" for value in values)


def gates_text(measured: Measurement) -> str:
    """Return the energies of all gates as the field `gates`, such as "100/0;35/12"."""
    both = zip(measured.moving_energy.tolist(), measured.still_energy.tolist(), strict=True)
    return ";".join(f"{moving:.0f}/{still:.0f}" for moving, still in both)


def gate_energies(text: str) -> list[tuple[float, float]]:
    """Return the energies of movement and breathing of each gate from the field `gates`."""
    pairs = [gate.partition("/") for gate in text.split(";")] if text else []
    return [(float(moving), float(still)) for moving, _, still in pairs]
