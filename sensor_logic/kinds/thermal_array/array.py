# SPDX-License-Identifier: GPL-3.0-or-later
"""The parameters and the model of an infrared array: a mean temperature for each pixel.

A pixel receives the mean radiance of all surfaces in its cone, and its temperature is that of a
black body with the same radiance. So an object that fills a part of a pixel counts by that part.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...geometry.pixels import lattice_cells, pixel_directions
from ...kind import WARMTH
from ...model import Array, Model, PerPose, Pose, Readings, Updates
from ...parameters import Choice, Parameters, parameter
from ...physics import STEFAN_BOLTZMANN, OutputTiming, radiosity
from ...wording import METRES, ZERO_CELSIUS, Advice, Lengths

MOST_PIXELS = 160
# Many more rays than this fill the memory.
MAX_RAYS = 200_000
GRID_EYE = "Panasonic Grid-EYE AMG8833: 8 × 8 pixels, 60° × 60°"
# m. The length of the rays; beyond it everything has the ambient temperature.
SIGHT = 50.0
# The decimals of a frame in samples.
DECIMALS = 2
LEARNT: dict[str, Any] = {"used_when": (("background", "LEARNT"),)}


@dataclass(frozen=True)
class ThermalArrayParameters(Parameters):
    """The parameters of an infrared array."""

    columns: int = parameter(
        8, "Columns", "Pixels in a row", minimum=1, maximum=MOST_PIXELS, source=GRID_EYE
    )
    rows: int = parameter(8, "Rows", "Rows of pixels", minimum=1, maximum=MOST_PIXELS)
    horizontal_fov: float = parameter(
        math.radians(60.0),
        "Horizontal FOV",
        "Horizontal angle of all pixels together",
        unit="rad",
        positive=True,
        maximum=math.radians(150),
        short="FOV Across",
        source=GRID_EYE,
    )
    vertical_fov: float = parameter(
        math.radians(60.0),
        "Vertical FOV",
        "Vertical angle of all pixels together",
        unit="rad",
        positive=True,
        maximum=math.radians(150),
        short="FOV Up",
    )
    rays: int = parameter(
        34,
        "Rays a pixel",
        "Rays of each pixel. More rays measure edges more exactly and take more time",
        minimum=1,
        maximum=1024,
    )
    threshold: float = parameter(
        2.0,
        "Threshold",
        "A pixel is warm if it exceeds the background by more than this",
        unit="K",
        positive=True,
    )
    min_pixels: int = parameter(
        2, "Warm pixels", "Occupied is on if at least as many pixels are warm", minimum=1
    )
    hold_time: float = parameter(
        5.0, "Hold time", "Occupied stays on for this long after the last warm frame", unit="s"
    )
    background: str = parameter(
        "MEDIAN",
        "Background",
        "With what pixels are compared",
        choices=(
            Choice("MEDIAN", "Median", "The median of all pixels of the frame", 0),
            Choice("LEARNT", "Learnt", "The mean of each pixel while it was not warm", 1),
        ),
    )
    background_time: float = parameter(
        60.0,
        "Learning time",
        "Time constant of the mean of each pixel",
        unit="s",
        positive=True,
        **LEARNT,
    )
    report_step: float = parameter(
        0.5,
        "Report step",
        "Least change of the highest temperature that the event log records",
        unit="K",
        short="Report by",
    )
    netd: float = parameter(
        0.0,
        "Noise",
        "Standard deviation of a pixel from frame to frame. Data sheets: NETD, at the frame rate",
        unit="K",
    )
    offset_sigma: float = parameter(
        0.0,
        "Spread of devices",
        "Standard deviation of the error that all pixels of a device have in common",
        unit="K",
        short="Spread",
    )
    resolution: float = parameter(
        0.0, "Resolution", "Temperatures are multiples of this; 0: exact", unit="K"
    )
    coldest: float = parameter(
        -40.0, "Coldest", "The lowest temperature that a pixel reads", unit="°C", minimum=-273.15
    )
    hottest: float = parameter(
        300.0, "Hottest", "The highest temperature that a pixel reads", unit="°C", minimum=-273.15
    )
    settling_time: float = parameter(
        0.0,
        "Settling time",
        "Time constant with which the pixels follow the radiation; 0: at once",
        unit="s",
    )

    keep_frames: bool = parameter(
        True,
        "Keep frames",
        "Samples have the temperatures of all pixels. A large array with noise fills 5 kB a frame",
    )

    def contradictions(self, lengths: Lengths = METRES) -> list[str]:
        """Return sentences about limits that contradict each other, and about too many rays."""
        problems = self.must_be_smaller("coldest", "hottest", lengths)
        pixels = self.columns * self.rows
        if pixels * self.rays > MAX_RAYS:
            problems.append(
                f"{self.columns} × {self.rows} pixels with {self.rays} rays each are more than "
                f"{MAX_RAYS} rays: take at most {MAX_RAYS // pixels} rays a pixel, or fewer pixels"
            )
        if self.min_pixels > pixels:
            problems.append(
                f"min_pixels ({self.min_pixels}) is more than the array has: "
                f"{self.columns} × {self.rows}"
            )
        return problems

    def unreachable(self, lengths: Lengths = METRES) -> list[Advice]:
        """Return advice if half of the pixels or more would have to be warmer than the median."""
        most = (self.columns * self.rows) // 2
        if self.background != "MEDIAN" or self.min_pixels <= most:
            return []
        return [
            Advice(
                f"Only {most} of {self.columns} × {self.rows} pixels can be warmer than their "
                f"median, and occupied needs {self.min_pixels}: it never goes on",
                "Need fewer warm pixels, or let the sensor learn its background",
            )
        ]

    @property
    def field_of_view(self) -> tuple[float, float]:
        """The horizontal and the vertical angle of all pixels together, in radians."""
        return self.horizontal_fov, self.vertical_fov

    @property
    def pixels(self) -> tuple[int, int]:
        """The numbers of columns and of rows."""
        return self.columns, self.rows


def array_rays(parameters: ThermalArrayParameters, pose: Pose) -> tuple[Array, Array, Array]:
    """Return origins (n, 3), unit directions (n, 3) and lengths (n,) in m of all rays.

    Pixels are sorted by row from the upper left in the sensor's view. All have the same number of
    rays.
    """
    directions = pixel_directions(
        pose.axes,
        parameters.field_of_view,
        parameters.pixels,
        parameters.rays,
        lattice_cells(parameters.rays),
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
        self._output = OutputTiming()
        self._time = math.nan

    def sense(self, parameters: ThermalArrayParameters, updates: Updates) -> Readings:
        """Return the readings; `updates` must continue those of the previous call."""
        answers = updates.ask(WARMTH, 0, *self._rays(parameters, updates.pose))
        shape = parameters.columns * parameters.rows, parameters.rays
        means = np.array([radiosity(seen).reshape(shape).mean(axis=1) for seen in answers.table])
        steps = np.diff(updates.times, prepend=self._time)
        steps[~np.isfinite(steps)] = 0.0
        self._time = float(updates.times[-1])
        settled = self._settling.run(means[answers.rows], steps, parameters.settling_time)
        frames = self._published(parameters, updates, celsius(settled))
        _, warm = self._background.run(parameters, frames, steps)
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
        return Readings(occupied, highest, fields)

    def _published(
        self, parameters: ThermalArrayParameters, updates: Updates, frames: Array
    ) -> Array:
        """Return the frames (n, pixels) in °C with the errors, limits and steps of the device."""
        if parameters.offset_sigma > 0.0:
            frames = frames + updates.device_noise().normal(0.0, parameters.offset_sigma)
        if parameters.netd > 0.0:
            noise = [
                updates.noise(k).normal(size=frames.shape[1]) for k in updates.numbers.tolist()
            ]
            frames = frames + np.array(noise) * parameters.netd
        if parameters.resolution > 0.0:
            frames = np.round(frames / parameters.resolution) * parameters.resolution
        return np.clip(frames, parameters.coldest, parameters.hottest)


def frame_text(frame: Array) -> str:
    """Return the temperatures of a frame (pixels,) as one text: with 2 decimals, and semicolons."""
    return ";".join([f"{value:.{DECIMALS}f}" for value in (frame + 0.0).tolist()])
