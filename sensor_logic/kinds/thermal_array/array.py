# SPDX-License-Identifier: GPL-3.0-or-later
"""The model of an infrared array: a mean temperature for each pixel.

A pixel receives the mean radiance of all surfaces in its cone, and its temperature is that of a
black body with the same radiance. So an object that fills a part of a pixel counts by that part.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ...geometry.pixels import lattice_cells, pixel_directions
from ...kind import WARMTH
from ...logs.wording import ZERO_CELSIUS
from ...model import Array, Model, PerPose, Pose, Readings, Updates, joined_readings
from ...physics import STEFAN_BOLTZMANN, OutputTiming, radiosity
from ...warmth_left import WarmthLeft
from .device import Device, RunningMean
from .parameters import ThermalArrayParameters
from .pixel_evidence import PixelEvidence

# m. The length of the rays; beyond it everything has the ambient temperature.
SIGHT = 50.0
# Updates with so many rays are answered at once. While warmth that is left in seats fades, each
# update of a long still time can have temperatures of its own.
AT_ONCE = 10_000_000
# The decimals of a frame in samples.
DECIMALS = 2


def array_rays(parameters: ThermalArrayParameters, pose: Pose) -> tuple[Array, Array, Array]:
    """Return origins (n, 3), unit directions (n, 3) and lengths (n,) in m of all rays.

    Pixels are sorted by row from the upper left in the sensor's view. All have the same number of
    rays. Those of a blurred pixel are spread over its neighbours, also beyond the frame.
    """
    directions = pixel_directions(
        pose.axes,
        parameters.field_of_view,
        parameters.pixels,
        parameters.rays,
        lattice_cells(parameters.rays),
        parameters.blur,
    )
    origins = np.broadcast_to(pose.origin, directions.shape)
    return origins, directions, np.full(len(directions), SIGHT)


def celsius(radiosities: Array) -> Array:
    """Return the temperature (…) in °C of black bodies with these radiosities (…) in W/m²."""
    found: Array = (radiosities / STEFAN_BOLTZMANN) ** 0.25 - ZERO_CELSIUS
    return found


class Settling:
    """A first-order filter of each pixel, which starts in the steady state of the first frame.

    It is exact for radiation that changes linearly between two updates, at any interval:
    with u₀ and u₁ at its ends, s = (u₁ − u₀)/Δt, and time constant τ,
    y₁ = u₁ − sτ + (y₀ − u₀ + sτ)·exp(−Δt/τ).
    """

    def __init__(self) -> None:
        self._input: Array | None = None
        self._output: Array | None = None

    def run(self, frames: Array, steps: Array, time_constant: float) -> Array:
        """Return the filtered frames (n, pixels).

        Parameters
        ----------
        frames
            The frames (n, pixels) at the updates.
        steps
            The time (n,) in s from the previous update to each update.
        time_constant
            In s; 0 returns the frames unchanged.
        """
        found = frames if time_constant <= 0.0 else np.empty_like(frames)
        before, output = self._input, self._output
        if before is None or output is None or before.shape != frames.shape[1:]:
            before = output = frames[0]
        if time_constant > 0.0:
            for k, (now, step) in enumerate(zip(frames, steps.tolist(), strict=True)):
                if step > 0.0:
                    lag = (now - before) * (time_constant / step)
                    output = now - lag + (output - before + lag) * math.exp(-step / time_constant)
                before, found[k] = now, output
        self._input, self._output = frames[-1], found[-1]
        return found


class Background:
    """The temperature with which the pixels of a frame are compared: what the host computes.

    `MEDIAN` is the median of the frame. `LEARNT` is a mean of each pixel with an exponential weight
    of the past, from the first frame on; a pixel that is warm does not change it.

    References
    ----------
    A. Beltran, V. L. Erickson, A. E. Cerpa, ThermoSense: Occupancy Thermal Based Sensing for HVAC
    Control, BuildSys 2013: an exponential mean of each pixel of a Grid-EYE.
    """

    def __init__(self) -> None:
        self._learnt: Array | None = None

    def run(
        self, parameters: ThermalArrayParameters, frames: Array, steps: Array
    ) -> tuple[Array, NDArray[np.bool_]]:
        """Return the background (n, pixels) in °C of each frame, and which pixels are warm.

        Parameters
        ----------
        parameters
            The parameters of the sensor.
        frames
            The frames (n, pixels) in °C.
        steps
            The time (n,) in s from the previous frame to each frame.
        """
        if parameters.background == "MEDIAN":
            found = np.broadcast_to(np.median(frames, axis=1)[:, None], frames.shape)
            return found, frames - found > parameters.threshold
        learnt = self._learnt
        if learnt is None or learnt.shape != frames.shape[1:]:
            learnt = frames[0]
        found, warm = np.empty_like(frames), np.empty(frames.shape, bool)
        for k, (frame, step) in enumerate(zip(frames, steps.tolist(), strict=True)):
            found[k] = learnt
            warm[k] = frame - learnt > parameters.threshold
            share = -math.expm1(-max(step, 0.0) / parameters.background_time)
            learnt = np.where(warm[k], learnt, learnt + share * (frame - learnt))
        self._learnt = learnt
        return found, warm


class ThermalArray(Model):
    """The model of one array. Its state is that of its pixels, its background and its output."""

    def __init__(self) -> None:
        self._rays = PerPose(array_rays)
        self._settling, self._background = Settling(), Background()
        self._mean, self._device = RunningMean(), Device()
        self._output = OutputTiming()
        self._left = WarmthLeft()
        self._evidence = PixelEvidence()
        self._time = math.nan

    def sense(self, parameters: ThermalArrayParameters, updates: Updates) -> Readings:
        """Return the readings; `updates` must continue those of the previous call."""
        count = len(updates)
        size = max(1, AT_ONCE // (parameters.columns * parameters.rows * parameters.rays))
        parts = [updates.part(i, min(i + size, count)) for i in range(0, count, size)]
        return joined_readings([self._sense_part(parameters, part) for part in parts])

    def _sense_part(self, parameters: ThermalArrayParameters, updates: Updates) -> Readings:
        rays = self._rays(parameters, updates.pose)
        answers = updates.ask(WARMTH, 0, *rays, updates.times, self._left)
        shape = parameters.columns * parameters.rows, parameters.rays
        means = np.array([radiosity(hits).reshape(shape).mean(axis=1) for hits in answers.table])
        steps = np.diff(updates.times, prepend=self._time)
        steps[~np.isfinite(steps)] = 0.0
        self._time = float(updates.times[-1])
        settled = self._settling.run(means[answers.rows], steps, parameters.settling_time)
        seen = celsius(self._mean.run(settled, parameters.mean_of))
        frames = self._device.publish(parameters, updates, seen)
        background, warm = self._background.run(parameters, frames, steps)
        count = np.count_nonzero(warm, axis=1)
        enough = count >= parameters.min_pixels
        occupied = self._output.run(updates.times, enough, parameters.hold_time, 0.0, 0.0)
        highest = frames.max(axis=1)
        fields = {
            "occupied": occupied,
            "warm_pixels": count,
            "max_c": highest,
            "mean_c": frames.mean(axis=1),
            "frame_c": [frame_text(f) for f in frames] if parameters.keep_frames else None,
        }
        seen_in = parameters, updates, answers
        evidence = self._evidence.columns(*seen_in, frames, background, warm)
        return Readings(occupied, highest, fields, evidence=evidence)


def frame_text(frame: Array) -> str:
    """Return the temperatures of a frame (pixels,) as one text: with 2 decimals, and semicolons."""
    return ";".join([f"{value:.{DECIMALS}f}" for value in (frame + 0.0).tolist()])
