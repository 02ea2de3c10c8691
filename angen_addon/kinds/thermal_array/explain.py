# SPDX-License-Identifier: GPL-3.0-or-later
"""Explain an infrared array: which objects are in its warm pixels, and why it is occupied."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ....sensor_logic.evidence import rows_of
from ....sensor_logic.kinds.thermal_array.parameters import ThermalArrayParameters
from ....sensor_logic.logs.wording import measured, named, percent, quoted, typed
from ...appearance.facts import Explanation, Facts
from ...appearance.recorded import RecordedSensor

NAMES_SHOWN = 4
# K. Less warmth that people have left is not mentioned.
LEAST_LEFT = 0.015


@dataclass(frozen=True)
class ThermalCause:
    """What warms the pixels of an infrared array.

    Attributes
    ----------
    warm
        The number of warm pixels.
    objects
        The objects in these pixels, or in the warmest pixel if none is warm, with their shares of
        the radiation above the background, in descending order.
    last_excess
        The excess in K over the background of the least warm of the pixels that are needed.
    """

    warm: int
    objects: tuple[tuple[Any, ...], ...]
    last_excess: float


def explain_array(recorded: RecordedSensor, index: int) -> Explanation:
    """Explain update `index` of an infrared array by its warm pixels."""
    parameters: ThermalArrayParameters = recorded.parameters_at(index)
    track = recorded.track
    is_on = bool(track.active[index])
    cause = ThermalCause(
        track.columns["warm_pixels"][index],
        rows_of(recorded.evidence("objects", index)),
        recorded.evidence("last_excess_k", index),
    )
    facts = _facts(recorded, parameters, cause, index)
    if index > 0:
        before = _celsius(track.value[index - 1])
        facts.append(("Before", f"{before}, at {recorded.when(index - 1)}"))
    left = recorded.evidence("left_k", index)
    if left > LEAST_LEFT:
        facts.append(("Warmth left", f"up to {left:.1f} K, of who rested there before"))
    text = _headline(parameters, cause, recorded.evidence("warm_max_c", index), is_on)
    return recorded.explanation(index, f"{recorded.word(index)}: {text}", facts, "", cause)


def _celsius(value: Any) -> str:
    return measured(float(value), "°C", 1)


def _headline(
    parameters: ThermalArrayParameters, cause: ThermalCause, highest: float, is_on: bool
) -> str:
    if not cause.warm:
        return "held, no pixel is warm now" if is_on else "no pixel is warm"
    what = named(name for name, _ in cause.objects[:NAMES_SHOWN]) or "the noise"
    pixels = "one pixel" if cause.warm == 1 else f"{cause.warm} pixels"
    text = f"{what} warms {pixels}, up to {_celsius(highest)}"
    if len(cause.objects) > 1:
        text = f"{what} warm {pixels}, up to {_celsius(highest)}"
    if cause.warm >= parameters.min_pixels:
        return text
    if is_on:
        return f"{text}; {parameters.min_pixels} are needed, so it is held"
    return f"{text}; {parameters.min_pixels} are needed"


def _facts(
    recorded: RecordedSensor, parameters: ThermalArrayParameters, cause: ThermalCause, index: int
) -> Facts:
    row, column = divmod(recorded.evidence("hottest", index), parameters.columns)
    low, high = (recorded.evidence(f"background_{end}_c", index) for end in ("min", "max"))
    how = "the median of the frame" if parameters.background == "MEDIAN" else "learnt"
    same = high - low < 0.05
    background = _celsius(low) if same else f"{_celsius(low)} to {_celsius(high)}"
    facts = [
        (
            "Highest",
            f"{_celsius(recorded.track.columns['max_c'][index])}, row {row + 1} from above, "
            f"column {column + 1} from the left",
        ),
        ("Background", f"{background}, {how}"),
        (
            "Warm pixels",
            f"{cause.warm} of {parameters.columns * parameters.rows}: "
            f"{typed(parameters.threshold, 'K')} above it; {parameters.min_pixels} are needed",
        ),
    ]
    if cause.objects:
        where = "In them" if cause.warm else "In the warmest"
        shown = cause.objects[:NAMES_SHOWN]
        facts.append((where, ", ".join(f"{quoted(n)} {percent(share)}" for n, share in shown)))
    return facts


def lacking(recorded: RecordedSensor, index: int, found: Explanation) -> Explanation:
    """Add a fact to an explanation: how much warmer which pixel must be for the output to go on.

    `found` is the explanation of update `index`. Return it with the fact before its other facts.
    """
    parameters: ThermalArrayParameters = recorded.parameters_at(index)
    need = "1 pixel" if parameters.min_pixels == 1 else f"{parameters.min_pixels} pixels"
    last = "warmest" if parameters.min_pixels == 1 else "last of them"
    text = (
        f"{need} must be {typed(parameters.threshold, 'K')} above the background: "
        f"the {last} is {found.cause.last_excess:.1f} K above"
    )
    return found.after([("To be occupied", text.replace("-", "−"))])
