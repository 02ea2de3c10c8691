# SPDX-License-Identifier: GPL-3.0-or-later
"""Explain an infrared array: which objects are in its warm pixels, and why it is occupied."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....sensor_logic.kind import WARMTH
from ....sensor_logic.kinds.thermal_array.array import (
    Background,
    ThermalArrayParameters,
    array_rays,
)
from ....sensor_logic.model import Array
from ....sensor_logic.physics import STEFAN_BOLTZMANN, radiosity
from ....sensor_logic.wording import ZERO_CELSIUS, measured, named, percent, quoted, typed
from ...explain.facts import Explanation, Facts, at_frame
from ...explain.replay import Replay
from .figure import values_of

NAMES_SHOWN = 4
# Objects that give a smaller share of the warmth get no name.
LITTLE = 0.01
# K. The scene has changed if a pixel of the recorded frame differs by more than this.
TOLERANCE = 0.015


@dataclass(frozen=True)
class ThermalCause:
    """What warms the pixels of an infrared array.

    Attributes
    ----------
    frame
        The recorded frame (pixels,) in °C.
    background
        The temperatures (pixels,) in °C with which it is compared.
    warm
        Which pixels are warm (pixels,).
    objects
        The objects in these pixels, or in the warmest pixel if none is warm, with their shares of
        the radiation above the background, in descending order.
    """

    frame: Array
    background: Array
    warm: NDArray[np.bool_]
    objects: tuple[tuple[str, float], ...]

    @property
    def cause_name(self) -> str:
        """The name of the object that warms the warm pixels most; empty if no pixel is warm."""
        return self.objects[0][0] if self.warm.any() and self.objects else ""


def explain_array(replay: Replay, index: int) -> Explanation:
    """Explain update `index` of an infrared array by its warm pixels.

    Raise `AngenError` if the sensor cannot be read.
    """
    taken = replay.take_update(index)
    if taken is None:
        return replay.explain_off(index)
    parameters: ThermalArrayParameters = taken.parameters
    emission = taken.update.ask(WARMTH, 0, *array_rays(parameters, taken.update.pose))
    names = replay.seen.names
    # The first frame of a new model has no past: neither filter nor background change it.
    shown = replace(parameters, keep_frames=True)
    again = values_of(replay.sensor.kind.model().update(shown, taken.update).fields["frame_c"])
    track = replay.track
    frame = values_of(track.columns["frame_c"][index] or "") if parameters.keep_frames else again
    if len(frame) != parameters.columns * parameters.rows:
        return replay.explanation(index, "It had another number of pixels in the run", ())
    background, warm = _background(replay, parameters, index, frame)
    which = warm if warm.any() else np.arange(len(frame)) == int(np.argmax(frame - background))
    excess = radiosity(emission).reshape(len(frame), -1)
    excess = excess - STEFAN_BOLTZMANN * (background[:, None] + ZERO_CELSIUS) ** 4
    cause = ThermalCause(frame, background, warm, _objects(excess, names, which))
    doubt = ""
    if parameters.settling_time == 0.0 and np.abs(again - frame).max() > TOLERANCE:
        doubt = (
            f"the recording has up to {_celsius(frame.max())}, but the scene now gives "
            f"{_celsius(again.max())}: something has changed since the run. Simulate again"
        )
    facts = _facts(parameters, cause)
    if index > 0:
        when = at_frame(track.frames[index - 1], track.times[index - 1])
        facts.append(("Before", f"{_celsius(track.value[index - 1])}, at {when}"))
    word = replay.sensor.kind.active_label if track.active[index] else replay.sensor.kind.idle_label
    headline = f"{word}: {_headline(parameters, cause, bool(track.active[index]))}"
    return replay.explanation(index, headline, facts, doubt, cause)


def _background(
    replay: Replay, parameters: ThermalArrayParameters, index: int, frame: Array
) -> tuple[Array, NDArray[np.bool_]]:
    """Return the background (pixels,) in °C at update `index`, and which pixels are warm.

    A learnt background follows from all recorded frames until then.
    """
    first = 0 if parameters.background == "LEARNT" and parameters.keep_frames else index
    texts = replay.track.columns["frame_c"]
    frames = [values_of(texts[k] or "") for k in range(first, index)]
    frames = [known for known in frames if len(known) == len(frame)]
    times = np.array(replay.track.times[index - len(frames) : index + 1])
    steps = np.diff(times, prepend=times[0])
    found, warm = Background().run(parameters, np.array([*frames, frame]), steps)
    return found[-1], warm[-1]


def _objects(
    excess: Array, names: list[str], which: NDArray[np.bool_]
) -> tuple[tuple[str, float], ...]:
    """Return the objects in the pixels `which` (pixels,), with their shares of the warmth.

    `excess` (pixels, rays) is the radiosity above the background in W/m². `names` has the object
    that each ray hits.
    """
    given: dict[str, float] = defaultdict(float)
    rays = excess.shape[1]
    for pixel in np.flatnonzero(which).tolist():
        hit = names[pixel * rays : (pixel + 1) * rays]
        for name, value in zip(hit, excess[pixel].tolist(), strict=True):
            if name and value > 0.0:
                given[name] += value
    whole = sum(given.values())
    ordered = sorted(given.items(), key=lambda item: -item[1])
    return tuple((n, value / whole) for n, value in ordered if value > LITTLE * whole)


def _celsius(value: Any) -> str:
    return measured(float(value), "°C", 1)


def _headline(parameters: ThermalArrayParameters, cause: ThermalCause, is_on: bool) -> str:
    count = int(np.count_nonzero(cause.warm))
    if not count:
        return "held, no pixel is warm now" if is_on else "no pixel is warm"
    what = named(name for name, _ in cause.objects[:NAMES_SHOWN]) or "the noise"
    pixels = "one pixel" if count == 1 else f"{count} pixels"
    warm = "warm" if len(cause.objects) > 1 else "warms"
    text = f"{what} {warm} {pixels}, up to {_celsius(cause.frame[cause.warm].max())}"
    if count < parameters.min_pixels:
        text += f"; {parameters.min_pixels} are needed" + ", so it is held" * is_on
    return text


def _facts(parameters: ThermalArrayParameters, cause: ThermalCause) -> Facts:
    row, column = divmod(int(np.argmax(cause.frame)), parameters.columns)
    low, high = float(cause.background.min()), float(cause.background.max())
    same = high - low < 0.05
    how = "the median of the frame" if parameters.background == "MEDIAN" else "learnt"
    background = _celsius(low) if same else f"{_celsius(low)} to {_celsius(high)}"
    facts = [
        (
            "Highest",
            f"{_celsius(cause.frame.max())}, row {row + 1} from above, column {column + 1} "
            "from the left",
        ),
        ("Background", f"{background}, {how}"),
        (
            "Warm pixels",
            f"{np.count_nonzero(cause.warm)} of {len(cause.frame)}: "
            f"{typed(parameters.threshold, 'K')} above it; {parameters.min_pixels} are needed",
        ),
    ]
    if cause.objects:
        where = "In them" if cause.warm.any() else "In the warmest"
        shown = cause.objects[:NAMES_SHOWN]
        facts.append((where, ", ".join(f"{quoted(n)} {percent(share)}" for n, share in shown)))
    return facts


def lacking(replay: Replay, index: int, found: Explanation) -> Explanation:
    """Add a fact to an explanation: how much warmer which pixel must be for the output to go on.

    `found` is the explanation of update `index`. Return it with the fact before its other facts.
    """
    cause = found.cause
    if cause is None:
        return found
    parameters = replay.sensor.parameters
    excess = np.sort(cause.frame - cause.background)[::-1]
    last = float(excess[parameters.min_pixels - 1])
    need = "1 pixel" if parameters.min_pixels == 1 else f"{parameters.min_pixels} pixels"
    text = (
        f"{need} must be {typed(parameters.threshold, 'K')} above the background: "
        f"the {'warmest' if parameters.min_pixels == 1 else 'last of them'} is {last:.1f} K above"
    )
    return found.after([("To be occupied", text.replace("-", "−"))])
