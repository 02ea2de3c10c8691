# SPDX-License-Identifier: GPL-3.0-or-later
"""Why an infrared array is occupied or not: its warm pixels, and the objects that warm them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...arrays import Array
from ...evidence import Cause, measured_cause, rows_of, rows_text
from ...kind import Field
from ...logs.wording import ZERO_CELSIUS
from ...model import Answers, Emission, Updates
from ...physics import STEFAN_BOLTZMANN, radiosity
from .parameters import ThermalArrayParameters

# Objects that give a smaller share of the warmth are left out.
LITTLE = 0.01
FIELDS = (
    Field("hottest", int, tip="Number of the hottest pixel, row by row from the upper left"),
    Field("warm_max_c", float, "°C", tip="Highest temperature of a warm pixel"),
    Field("background_min_c", float, "°C", tip="Lowest temperature of the background"),
    Field("background_max_c", float, "°C", tip="Highest temperature of the background"),
    Field(
        "last_excess_k",
        float,
        "K",
        tip="Excess over the background of the least warm of the pixels that are needed",
    ),
    Field("left_k", float, "K", tip="Highest excess of a pixel by warmth that people have left"),
    Field(
        "objects",
        str,
        tip="Objects in the warm pixels, or in the warmest if none is, with their shares of the "
        "radiation above the background",
    ),
)


def cause(track: Any, index: int) -> Cause:
    """Return the cause of update `index` of a `Track`: the objects in its warm pixels, if any."""
    is_warm = track.columns["warm_pixels"][index] > 0
    objects = rows_of(track.evidence.value("objects", index)) if is_warm else ()
    part = f"pixel {track.evidence.value('hottest', index)}"
    return measured_cause(track, index, (name for name, _ in objects), part)


class PixelEvidence:
    """The evidence of successive updates. It keeps the objects found at the last one."""

    def __init__(self) -> None:
        self._known: Any = None
        self._objects = ""

    def columns(
        self,
        parameters: ThermalArrayParameters,
        updates: Updates,
        answers: Answers,
        frames: Array,
        background: Array,
        warm: NDArray[np.bool_],
    ) -> dict[str, Any]:
        """Return the evidence of n updates by field.

        `answers` has the `Emission` at the hits of the rays. `frames`, `background` (in °C) and
        `warm` are arrays (n, pixels).
        """
        excess = frames - background
        needed = min(parameters.min_pixels, frames.shape[1])
        last = -np.partition(-excess, needed - 1, axis=1)[:, needed - 1]
        hottest = np.where(warm, frames, -np.inf).max(axis=1)
        warmest = np.zeros_like(warm)
        np.put_along_axis(warmest, excess.argmax(axis=1)[:, None], True, axis=1)
        which = np.where(warm.any(axis=1, keepdims=True), warm, warmest)
        left = np.array([_left(emission, parameters) for emission in answers.table])
        return {
            "hottest": frames.argmax(axis=1),
            "warm_max_c": np.where(np.isfinite(hottest), hottest, np.nan),
            "background_min_c": background.min(axis=1),
            "background_max_c": background.max(axis=1),
            "last_excess_k": last,
            "left_k": left[answers.rows],
            "objects": self._objects_of(parameters, updates, answers, background, which),
        }

    def _objects_of(
        self,
        parameters: ThermalArrayParameters,
        updates: Updates,
        answers: Answers,
        background: Array,
        which: NDArray[np.bool_],
    ) -> NDArray[np.object_]:
        """Return the field `objects` at n updates, of the pixels `which` (n, pixels)."""
        found = np.full(len(which), "", object)
        if answers.hits is None:
            return found
        for i, pixels in enumerate(which):
            emission, solids = answers[i], answers.hits[i].solids
            # Rounded: else noise would have the shares computed anew at each update.
            level = np.round(background[i, pixels], 1)
            some, last = pixels.tobytes() + level.tobytes(), self._known
            if last is None or last[0] is not emission or last[1] is not solids or last[2] != some:
                self._known = emission, solids, some
                given = _given(emission, solids, pixels, level, parameters.rays)
                self._objects = _shares(given, updates.name_of)
            found[i] = self._objects
        return found


def _given(
    emission: Emission, solids: Any, pixels: NDArray[np.bool_], background: Array, rays: int
) -> dict[int, float]:
    """Return the radiosity above the background in some pixels, by the number of the solid.

    `pixels` (pixels,) says which pixels, and `background` has their temperatures in °C.
    """
    at = (np.flatnonzero(pixels)[:, None] * rays + np.arange(rays)).ravel()
    seen = Emission(emission.temperature[at], emission.emissivity[at], emission.ambient)
    level = STEFAN_BOLTZMANN * (np.repeat(background, rays) + ZERO_CELSIUS) ** 4
    numbers, of = np.unique(solids[at], return_inverse=True)
    given = np.bincount(of, np.maximum(radiosity(seen) - level, 0.0))
    return dict(zip(numbers.tolist(), given.tolist(), strict=True))


def _shares(given: dict[int, float], name_of: Callable[[int], str]) -> str:
    by_name: dict[str, float] = {}
    for number, value in given.items():
        if value > 0.0 and (name := name_of(number)):
            by_name[name] = by_name.get(name, 0.0) + value
    whole = sum(by_name.values())
    ordered = sorted(by_name.items(), key=lambda item: -item[1])
    return rows_text((n, round(v / whole, 3)) for n, v in ordered if v > LITTLE * whole)


def _left(emission: Emission, parameters: ThermalArrayParameters) -> float:
    """Return the highest mean excess in K of a pixel by warmth that people have left."""
    if emission.left is None:
        return 0.0
    return float(emission.left.reshape(-1, parameters.rays).mean(axis=1).max())
