# SPDX-License-Identifier: GPL-3.0-or-later
"""Model of a motion detector as it is built: lens, two elements, amplifier, comparator."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...kind import WARMTH
from ...logs.wording import ZERO_CELSIUS
from ...model import Array, Emission, Model, PerPose, Pose, Readings, Updates
from ...physics import STEFAN_BOLTZMANN, OutputTiming, RadioTiming, radiosity
from .lenses import LENSES, Zone, ZoneRays, Zones, read_table, zone_rays

if TYPE_CHECKING:
    from .range_scan import PirParameters
from .warm_evidence import WarmEvidence

# The power on the elements, from surface temperatures.
#
# All powers are per square metre of lenslet and before its transmission. Area and transmission
# cancel, because they apply equally to the target that calibrates the threshold. The elements are
# assumed to respond to all wavelengths. Behind the usual window of 5 to 14 µm, the power rises a
# little faster than with the fourth power of the temperature. The calibration compensates for that
# near room temperature.


def net_power(weights: Array, seen: Emission) -> float:
    """Return the power on the positive minus that on the negative elements, in W per m² of lenslet.

    `weights` (n,) are the solid angles of the rays in sr, with the sign of their element's
    polarity. Surfaces are Lambertian: radiance is radiosity / π.
    """
    # The ambient part is subtracted first, to keep precision.
    excess = radiosity(seen) - STEFAN_BOLTZMANN * seen.ambient**4
    return float(weights @ excess) / math.pi + balance(weights, seen.ambient)


def balance(weights: Array, ambient: float) -> float:
    """Return the net power from surroundings of one temperature, `ambient` in K.

    The power is in W per m² of lenslet. It is 0 if the positive and the negative weights cancel.
    """
    return float(np.sum(weights)) * STEFAN_BOLTZMANN * ambient**4 / math.pi


# The signal at the comparator, from the power on the elements, as an exact solution.
#
# The element and its two amplifier stages are a chain of first-order filters:
#
#     V/P = [sτE/(1+sτE)] · [1/(1+sτT)] · [s/(s+ωh)] · [1/(1+s/ωl)]²
#
# with the electrical and the thermal time constant τE and τT of the element and the amplifier's
# pass band from ωh to ωl. The whole chain is integrated at once, for power that changes linearly
# between updates (a first-order hold). This takes one exponential of the augmented matrix, after
# Van Loan, "Computing integrals involving the matrix exponential", IEEE Trans. Automatic Control
# 23 (1978). It is stable and exact for steps of any length, unlike Euler's rule.

STATES = 5
# In s. The longest interval between samples of the signal, so that no peak is missed.
SAMPLE_EVERY = 0.02
# The coefficients of the [13/13] Padé approximant, and the largest 1-norm for which it is exact to
# double precision: Higham, "The scaling and squaring method for the matrix exponential
# revisited", SIAM J. Matrix Anal. Appl. 26 (2005), table 2.3.
PADE = (
    64764752532480000.0,
    32382376266240000.0,
    7771770303897600.0,
    1187353796428800.0,
    129060195264000.0,
    10559470521600.0,
    670442572800.0,
    33522128640.0,
    1323241920.0,
    40840800.0,
    960960.0,
    16380.0,
    182.0,
    1.0,
)
LARGEST_NORM = 5.371920351148152


@dataclass(frozen=True)
class Response:
    """The filters between the power on the elements and the comparator.

    Attributes
    ----------
    electrical, thermal
        The time constants of the elements in s, above 0.
    low_cut, high_cut
        The limits of the amplifier's pass band in Hz, above 0.
    """

    electrical: float
    thermal: float
    low_cut: float
    high_cut: float

    def at(self, hertz: float) -> complex:
        """Return the complex transfer function, signal over power, at a frequency."""
        s = 2j * math.pi * hertz
        low, high = 2 * math.pi * self.low_cut, 2 * math.pi * self.high_cut
        element = s * self.electrical / (1 + s * self.electrical) / (1 + s * self.thermal)
        return complex(element * s / (s + low) / (1 + s / high) ** 2)

    def matrices(self) -> tuple[Array, Array]:
        """Return A (5, 5) and B (5,) of dx/dt = A x + B P, where P is the power.

        The last component of x is the signal. The first one follows the power, so at rest x = (P,
        0, 0, 0, 0).
        """
        e, t = 1.0 / self.electrical, 1.0 / self.thermal
        low, high = 2 * math.pi * self.low_cut, 2 * math.pi * self.high_cut
        a = np.array(
            [
                [-e, 0.0, 0.0, 0.0, 0.0],
                [-t, -t, 0.0, 0.0, 0.0],
                [0.0, low, -low, 0.0, 0.0],
                [0.0, high, -high, -high, 0.0],
                [0.0, 0.0, 0.0, high, -high],
            ]
        )
        return a, np.array([e, t, 0.0, 0.0, 0.0])


class StepMatrices(NamedTuple):
    """The matrices of one time step: `carry` (5, 5), `level` (5,) and `change` (5,).

    Let x be the state and P the power at the begin, and let the power change linearly by ΔP. The
    state at the end is then carry · x + level · P + change · ΔP.
    """

    carry: Array
    level: Array
    change: Array


def expm(matrix: Array) -> Array:
    """Return the exponential of a square matrix.

    References
    ----------
    Scaling and squaring with the [13/13] Padé approximant: Higham 2005.
    """
    norm = float(np.abs(matrix).sum(axis=0).max())
    squarings = max(0, math.ceil(math.log2(norm / LARGEST_NORM))) if norm > 0.0 else 0
    a = matrix / 2.0**squarings
    b, one = PADE, np.eye(len(a))
    a2 = a @ a
    a4 = a2 @ a2
    a6 = a4 @ a2
    odd = a6 @ (b[13] * a6 + b[11] * a4 + b[9] * a2)
    odd = a @ (odd + b[7] * a6 + b[5] * a4 + b[3] * a2 + b[1] * one)
    even = a6 @ (b[12] * a6 + b[10] * a4 + b[8] * a2)
    even = even + b[6] * a6 + b[4] * a4 + b[2] * a2 + b[0] * one
    result: Array = np.asarray(np.linalg.solve(even - odd, even + odd), np.float64)
    for _ in range(squarings):
        result = result @ result
    return result


def step(response: Response, dt: float) -> StepMatrices:
    """Return the matrices of a time step of `dt` s in which the power changes linearly."""
    a, b = response.matrices()
    augmented = np.zeros((STATES + 2, STATES + 2))
    augmented[:STATES, :STATES] = a * dt
    augmented[:STATES, STATES] = b * dt
    augmented[STATES, STATES + 1] = 1.0
    done = expm(augmented)
    return StepMatrices(done[:STATES, :STATES], done[:STATES, STATES], done[:STATES, STATES + 1])


def filtered(response: Response, power: Array, dt: float) -> Array:
    """Return the signals (k, …) for powers (k, …) at intervals of `dt` s.

    The filters start in the steady state of the first power.
    """
    once, flat = step(response, dt), power.reshape(len(power), -1)
    state = np.zeros((STATES, flat.shape[1]))
    state[0] = flat[0]
    signal = np.zeros_like(flat)
    driven = once.level[:, None] * flat[:-1, None] + once.change[:, None] * np.diff(
        flat[:, None], axis=0
    )
    for k, drive in enumerate(driven, 1):
        state = once.carry @ state + drive
        signal[k] = state[-1]
    return signal.reshape(power.shape)


class Chain:
    """The filters of one detector. They start in the steady state of the first power."""

    def __init__(self, response: Response) -> None:
        self.response = response
        # The state x, the power, and a slot for the change of the power.
        self._state: Array | None = None
        # The matrix that left the state as it was, and its peak: each further update of the same
        # power gives the same bits. A room is at rest for most of a day: 10 % of its time.
        self._rest: tuple[Array | None, float] = None, 0.0

    def advance(self, power: Array, dt: Array) -> Array:
        """Return the signal (n,) of largest magnitude in each of n successive intervals.

        The intervals last `dt` (n,) s. In each one, the power changes linearly to the next value of
        `power` (n,).
        """
        peaks = np.zeros(len(power))
        state = np.zeros(STATES + 2) if self._state is None else self._state
        for k, (now, seconds) in enumerate(zip(power.tolist(), dt.tolist(), strict=True)):
            if self._state is None or seconds <= 0.0:
                state[:] = 0.0
                state[0] = now
                self._state, self._rest = state, (None, 0.0)
            else:
                matrix = _samples(self.response, seconds)
                if self._rest[0] is not matrix or state[STATES] != now:
                    self._rest = self._step(state, matrix, now)
                peaks[k] = self._rest[1]
            state[STATES] = now
        return peaks

    @staticmethod
    def _step(state: Array, matrix: Array, power: float) -> tuple[Array | None, float]:
        """Advance the state by one interval; return the next value of `_rest`."""
        state[STATES + 1] = power - state[STATES]
        before, found = state[: STATES + 1].tobytes(), matrix @ state
        state[:STATES] = found[:STATES]
        state[STATES] = power
        peak = max(found[STATES:].tolist(), key=abs)
        return (matrix if state[: STATES + 1].tobytes() == before else None), peak


# Keyed by response and interval: without the caches, each update takes 0.3 ms more.
@lru_cache(maxsize=256)
def _samples(response: Response, dt: float) -> Array:
    """Return the matrix (5 + n, 7) of a step of `dt` s with n samples of the signal.

    The matrix multiplies a vector of the state (5,), the power, and the change of the power. The
    product has the state (5,) after the step and the n samples.
    """
    parts = max(1, math.ceil(dt / SAMPLE_EVERY - 1e-9))
    # Rounded, because rounding errors of frame times would make every interval different.
    return _samples_of_parts(response, parts, round(dt / parts, 12))


# One array for intervals that differ by rounding errors: without it, rest is seldom recognised.
@lru_cache(maxsize=256)
def _samples_of_parts(response: Response, parts: int, dt: float) -> Array:
    """Return the same for a step of n = `parts` intervals of `dt` s."""
    once = step(response, dt)
    state, signals = np.eye(STATES, STATES + 2), []
    level, change = np.eye(2, STATES + 2, STATES)
    for part in range(parts):
        before = level + change * (part / parts)
        state = once.carry @ state
        state += np.outer(once.level, before) + np.outer(once.change, change / parts)
        signals.append(state[-1])
    return np.concatenate([state, signals])


# The threshold of the comparator, from the detection distance in a data sheet.
#
# Data sheets give the distance at which a standard target is just detected: a plate of the size of
# a person's trunk, a few degrees warmer than its surroundings, that crosses the view at walking
# pace. Measurements give the distance at which a person who crosses is just detected. The threshold
# is the largest signal of that crossing. So lenslet area, transmission, responsivity and gain,
# which no data sheet gives together, are not needed.

# Width and height (m) of the targets: Panasonic's plate, and the silhouette of a person who stands
# upright. Their speed (m/s), and the room's temperature (K).
TARGETS = {"PLATE": (0.25, 0.7), "PERSON": (0.4, 1.7)}
SPEED = 1.0
ROOM = ZERO_CELSIUS + 20.0
# Rays per zone, sampling interval (s), and time at rest before and after the crossing (s).
DENSE, INTERVAL, REST = 400, 0.01, 3.0
# In m. The target moves this far to both sides of the middle, or as far as its distance if less.
REACH = 3.0


# Keyed by the parameters: without the cache, each update takes 150 ms more.
@lru_cache(maxsize=256)
def threshold(
    zones: Zones,
    response: Response,
    distance: float,
    contrast: float,
    target: str = "PLATE",
    blur: float = 0.0,
) -> float:
    """Return the threshold: the largest signal of the standard target, in W per m² of lenslet.

    The parameters are as for `crossing_peak`.
    """
    return crossing_peak(zones, response, distance, contrast, target, blur)


def crossing_peak(
    zones: Zones,
    response: Response,
    distance: float,
    contrast: float,
    target: str = "PLATE",
    blur: float = 0.0,
) -> float:
    """Return the largest magnitude of the signal while the standard target crosses the lens's axis.

    The target crosses once at the elevation of each zone.

    Parameters
    ----------
    distance
        The distance of the target in m.
    contrast
        The temperature of the target minus the temperature of the room, in K.
    target
        The key of the target in `TARGETS`.
    blur
        The blur of the lens in rad; see `zone_rays`.

    Returns
    -------
    The magnitude of the signal in W per m² of lenslet.
    """
    heights = sorted({zone.elevation for zone in zones})
    rays, size = zone_rays(zones, DENSE, blur), TARGETS[target]
    powers = [_crossing(rays, size, distance, contrast, height) for height in heights]
    return float(np.abs(filtered(response, np.stack(powers, axis=1), INTERVAL)).max())


def _crossing(
    rays: ZoneRays, size: tuple[float, float], distance: float, contrast: float, elevation: float
) -> Array:
    """Return the power (k,) on the elements while a target crosses at `elevation` (rad).

    `size` is the width and the height of the target in m.
    """
    width, height = size
    ahead = Zone(0.0, elevation, 0.0, 0.0, 1)
    depth = rays.directions @ ahead.axis
    seen = depth > 1e-3
    scale = distance / depth[seen]
    across = rays.directions[seen] @ ahead.right * scale
    above = rays.directions[seen] @ np.cross(ahead.right, ahead.axis) * scale
    level = np.abs(above) <= height / 2
    order = np.argsort(across[level])
    places = across[level][order]
    summed = np.concatenate([[0.0], np.cumsum(rays.weights[seen][level][order])])
    reach = min(distance, REACH)
    middle = np.arange(-reach, reach, SPEED * INTERVAL)
    still = int(REST / INTERVAL)
    middle = np.concatenate([np.full(still, middle[0]), middle, np.full(still, middle[-1])])
    covered = summed[np.searchsorted(places, middle + width / 2)]
    covered = covered - summed[np.searchsorted(places, middle - width / 2)]
    excess = STEFAN_BOLTZMANN * ((ROOM + contrast) ** 4 - ROOM**4) / math.pi
    power: Array = covered * excess
    return power


# The detector. A warm object that moves from one zone to the next changes the power on the
# elements, which respond only to changes.

# In m. The length of the rays; beyond it everything has the ambient temperature.
SIGHT = 50.0


def zones_of(parameters: PirParameters) -> Zones:
    """Return the zones of the detector's lens. Raise InputError if the user's table is invalid."""
    if parameters.lens_table is not None:
        return read_table(parameters.lens_table)
    return LENSES[parameters.lens].zones


def rays_of(parameters: PirParameters) -> ZoneRays:
    """Return the rays of the detector's lens. Raise InputError if the user's table is invalid."""
    return zone_rays(zones_of(parameters), parameters.zone_rays, parameters.lens_blur)


def response_of(parameters: PirParameters) -> Response:
    """Return the filters of the detector."""
    return Response(
        parameters.electrical_time,
        parameters.thermal_time,
        parameters.low_cut,
        parameters.high_cut,
    )


def threshold_of(parameters: PirParameters) -> float:
    """Return the magnitude of the signal that means movement, in W per m² of lenslet."""
    return threshold(
        zones_of(parameters),
        response_of(parameters),
        parameters.range_max,
        parameters.target_contrast,
        parameters.target,
        parameters.lens_blur,
    )


class _Optics(NamedTuple):
    """The lens's rays in world space, and the detector's response, for one pose and parameters.

    The n rays have `origins` (n, 3), `directions` (n, 3), lengths `reach` (n,) in m and `weights`
    (n,) in sr. `lens` is the lens's zones and their blur in rad.
    """

    lens: tuple[Zones, float]
    origins: Array
    directions: Array
    reach: Array
    weights: Array
    response: Response
    threshold: float


class PyroelectricDetector(Model):
    """Model of one detector. Its state is the state of its filters and its output timing."""

    def __init__(self) -> None:
        self._wired, self._radio = OutputTiming(), RadioTiming()
        self._optics = PerPose(_optics)
        self._lens: tuple[Zones, float] = (), 0.0
        self._chain: Chain | None = None
        self._time = 0.0
        self._evidence = WarmEvidence()

    def sense(self, parameters: PirParameters, updates: Updates) -> Readings:
        """Return the readings; `updates` must follow the updates of the previous call."""
        optics = self._optics(parameters, updates.pose)
        if optics.lens != self._lens:
            # A change of the power caused by another lens is not movement.
            self._lens, self._chain = optics.lens, None
            self._evidence.forget()
        answers = updates.ask(WARMTH, 0, optics.origins, optics.directions, optics.reach)
        powers = np.array([net_power(optics.weights, emission) for emission in answers.table])
        signal = self._filter(optics.response, powers[answers.rows], updates.times)
        signal /= optics.threshold
        if parameters.signal_noise > 0.0:
            numbers = updates.numbers.tolist()
            signal += [updates.noise(k).normal(0.0, parameters.signal_noise) for k in numbers]
        module = (
            parameters.hold_time,
            parameters.blocking_time,
            parameters.warm_up_time,
            parameters.retrigger,
        )
        triggered, arrivals = np.abs(signal) > 1.0, None
        if parameters.is_wireless:
            blanking, delay = parameters.blanking_time, partial(_delay, parameters, updates)
            radio = self._radio.run(updates.times, triggered, *module, blanking, delay)
            moved, arrivals = radio
        else:
            moved = self._wired.run(updates.times, triggered, *module)
        fields = {"angle_rad": None, "moved": moved, "signal": signal}
        evidence = self._evidence.columns(updates, answers, optics.weights)
        return Readings(moved, signal, fields, arrivals, evidence)

    def _filter(self, response: Response, power: Array, times: Array) -> Array:
        """Return, for each update, the signal of largest magnitude since the previous update.

        The signal is in W per m² of lenslet. `power` (n,) is the power at the updates, at `times`
        (n,) in s. The filters start in their steady state if the response has changed.
        """
        if self._chain is None or self._chain.response != response:
            self._chain = Chain(response)
        peaks = self._chain.advance(power, np.diff(times, prepend=self._time))
        self._time = float(times[-1])
        return peaks


def _delay(parameters: PirParameters, updates: Updates, i: int) -> float:
    """Return a random delay in s of the message of update i, exponentially distributed."""
    # The first random number of an update is the noise of the signal.
    return float(updates.noise(int(updates.numbers[i])).exponential(size=2)[1]) * (
        parameters.message_delay
    )


def _optics(parameters: PirParameters, pose: Pose) -> _Optics:
    local = rays_of(parameters)
    directions = local.directions @ pose.axes.T
    origins = pose.origin + directions * parameters.range_min
    reach = np.full(len(directions), SIGHT)
    lens = zones_of(parameters), parameters.lens_blur
    rays = lens, origins, directions, reach, local.weights
    return _Optics(*rays, response_of(parameters), threshold_of(parameters))
