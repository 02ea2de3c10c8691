# SPDX-License-Identifier: GPL-3.0-or-later
"""Explain an infrared array: which objects are in its warm pixels, and why it is occupied."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....sensor_logic.kind import WARMTH
from ....sensor_logic.kinds.thermal_array.array import Background, array_rays
from ....sensor_logic.kinds.thermal_array.parameters import ThermalArrayParameters
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
    track = replay.track
    recorded = track.columns["frame_c"][index]
    pixels = parameters.columns * parameters.rows
    frame = values_of(recorded or "")
    if recorded and len(frame) != pixels:
        return _untold(replay, parameters, index, "it had another number of pixels then")
    emission = taken.update.ask(WARMTH, 0, *array_rays(parameters, taken.update.pose))
    names = replay.seen.names
    # The first frame of a new model has no past: neither filter nor background change it.
    shown = replace(parameters, keep_frames=True)
    again = values_of(replay.sensor.kind.model().update(shown, taken.update).fields["frame_c"])
    if not recorded:
        if parameters.lags or parameters.background == "LEARNT":
            return _untold(replay, parameters, index)
        highest, mean = (track.columns[name][index] for name in ("max_c", "mean_c"))
        if max(abs(again.max() - highest), abs(again.mean() - mean)) > TOLERANCE:
            doubt = _changed(highest, again)
            return _untold(replay, parameters, index, doubt=doubt)
        frame = again
    background = _background(replay, parameters, index, frame)
    if background is None:
        return _untold(replay, parameters, index)
    # As many as in the run: the decimals of a frame can move a pixel across the threshold.
    count = track.columns["warm_pixels"][index]
    warm = np.zeros(pixels, bool)
    warm[np.argsort(background - frame, kind="stable")[:count]] = True
    which = warm if warm.any() else np.arange(len(frame)) == int(np.argmax(frame - background))
    excess = radiosity(emission).reshape(len(frame), -1)
    excess = excess - _black_body(background)[:, None]
    # Alone, an update does not see what was left before it: the rest of the frame.
    rest = np.zeros(len(frame)) if parameters.lags else frame - again
    left = np.maximum(rest, 0.0) if replay.scene.angen_warmth_left else rest * 0.0
    if left.max() > TOLERANCE:
        excess = excess + (_black_body(again + left) - _black_body(again))[:, None]
    cause = ThermalCause(frame, background, warm, _objects(excess, names, which))
    doubt = ""
    if np.abs(rest - left).max() > TOLERANCE:
        doubt = _changed(frame.max(), again)
    facts = [*_facts(parameters, cause), *_before(replay, index)]
    if left.max() > TOLERANCE:
        facts.append(("Warmth left", f"up to {left.max():.1f} K, of who rested there before"))
    headline = f"{_word(replay, index)}: {_headline(parameters, cause, bool(track.active[index]))}"
    return replay.explanation(index, headline, facts, doubt, cause)


def _black_body(celsius: Array) -> Array:
    """Return the radiosities (n,) in W/m² of black bodies at temperatures (n,) in °C."""
    found: Array = STEFAN_BOLTZMANN * (celsius + ZERO_CELSIUS) ** 4
    return found


def _untold(
    replay: Replay,
    parameters: ThermalArrayParameters,
    index: int,
    why: str = "frames were not kept",
    doubt: str = "",
) -> Explanation:
    """Explain update `index` by its recorded fields alone, where its frame is not known.

    `why` says why it is not known.
    """
    values = {name: column[index] for name, column in replay.track.columns.items()}
    count, is_on = values["warm_pixels"], bool(replay.track.active[index])
    if count:
        text = "1 pixel is warm" if count == 1 else f"{count} pixels are warm"
        text += f", the highest is {_celsius(values['max_c'])}"
    else:
        text = _none_warm(is_on)
    mend = "simulate again"
    if not parameters.keep_frames:
        mend = f"switch on Keep frames and {mend}"
    facts = [
        ("Highest", _celsius(values["max_c"])),
        ("Mean", _celsius(values["mean_c"])),
        ("Warm pixels", f"{count}; {parameters.min_pixels} are needed"),
        ("Which were warm", f"cannot be told because {why}: {mend}"),
        *_before(replay, index),
    ]
    text += _needed(parameters, count, is_on) if count else ""
    return replay.explanation(index, f"{_word(replay, index)}: {text}", facts, doubt)


def _changed(before: float, again: Array) -> str:
    """Return the doubt about a frame that had the maximum `before`; `again` is it now."""
    return (
        f"the recording has up to {_celsius(before)}, but the scene now gives "
        f"{_celsius(again.max())}: something has changed since the run. Simulate again"
    )


def _word(replay: Replay, index: int) -> str:
    kind = replay.sensor.kind
    return kind.active_label if replay.track.active[index] else kind.idle_label


def _before(replay: Replay, index: int) -> Facts:
    """Return the fact about the update before update `index`."""
    track = replay.track
    if index == 0:
        return []
    when = at_frame(track.frames[index - 1], track.times[index - 1])
    return [("Before", f"{_celsius(track.value[index - 1])}, at {when}")]


def _background(
    replay: Replay, parameters: ThermalArrayParameters, index: int, frame: Array
) -> Array | None:
    """Return the background (pixels,) in °C at update `index`; None if it is not known.

    A learnt background follows from all recorded frames until then.
    """
    first = 0 if parameters.background == "LEARNT" else index
    texts = replay.track.columns["frame_c"]
    frames = [values_of(texts[k] or "") for k in range(first, index)]
    if any(len(known) != len(frame) for known in frames):
        return None
    times = np.array(replay.track.times[first : index + 1])
    steps = np.diff(times, prepend=times[0])
    background: Array = Background().run(parameters, np.array([*frames, frame]), steps)[0][-1]
    return background


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
        return _none_warm(is_on)
    what = named(name for name, _ in cause.objects[:NAMES_SHOWN]) or "the noise"
    pixels = "one pixel" if count == 1 else f"{count} pixels"
    warm = "warm" if len(cause.objects) > 1 else "warms"
    text = f"{what} {warm} {pixels}, up to {_celsius(cause.frame[cause.warm].max())}"
    return text + _needed(parameters, count, is_on)


def _none_warm(is_on: bool) -> str:
    return "held, no pixel is warm now" if is_on else "no pixel is warm"


def _needed(parameters: ThermalArrayParameters, count: int, is_on: bool) -> str:
    """Return what follows the number of warm pixels if it is too small."""
    if count >= parameters.min_pixels:
        return ""
    return f"; {parameters.min_pixels} are needed" + ", so it is held" * is_on


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
