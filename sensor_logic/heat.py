# SPDX-License-Identifier: GPL-3.0-or-later
"""How warm things are that are used, such as a stove: while they are in use, and afterwards.

The excess over the room follows its value in use with one time constant, and falls to zero with
another one. docs/pir.md tells where the constants are from.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

from .kind import OwnerProperties
from .parameters import Choice, Parameters, parameter


@dataclass(frozen=True)
class Heat:
    """How warm one sort of thing becomes in use.

    Attributes
    ----------
    label
        What it is.
    excess
        How much warmer than the room its surface is after long use, K.
    rise, fall
        The time constants in s with which the excess approaches that, and goes.
    runs_on
        How long it stays on after each use, s: the kettle boils, the pot cooks on.
    """

    label: str
    excess: float
    rise: float
    fall: float
    runs_on: float = 0.0


# Temperatures are read again when they have changed by this, K.
STEP = 1.0
NO_HEAT = "NONE"
HEATS = {
    # A pot that boils. Two litres at 1.5 kW: 8.4 kJ/K, 80 K in 7 minutes. The zone and the pot
    # lose 9 W/m²K and vapour.
    "STOVE": Heat("Stove", 75.0, 240.0, 1200.0, 300.0),
    # One litre at 2.2 kW boils after 150 s. Measured on a kettle: 72 °C at its hottest.
    "KETTLE": Heat("Kettle", 50.0, 90.0, 2400.0, 150.0),
    # Water of 38 to 40 °C on the wall and the tray.
    "SHOWER": Heat("Shower or bath", 15.0, 30.0, 180.0),
    "BASIN": Heat("Basin", 10.0, 15.0, 90.0),
    # 80 W over both sides of 0.85 m², at 9 W/m²K; the lower half more.
    "SCREEN": Heat("Television or screen", 8.0, 600.0, 900.0),
    # Water of 50 to 55 °C, in a radiator that cools down over half an hour.
    "RADIATOR": Heat("Radiator", 30.0, 600.0, 1800.0),
}


@dataclass(frozen=True)
class HeatInUse(Parameters):
    """What an object is that becomes warm in use."""

    sort: str = parameter(
        NO_HEAT,
        "Warm in Use",
        "What becomes warm while it is in use, and cools down afterwards. It is that much warmer "
        "than the room, whatever its temperature is otherwise",
        choices=(
            Choice(NO_HEAT, "None", "Use changes no temperature", 0),
            *(
                Choice(key, one.label, f"{one.excess:g} K above the room after long use", number)
                for number, (key, one) in enumerate(HEATS.items(), 1)
            ),
        ),
    )


HEAT = OwnerProperties(
    "angen_heat",
    ("Object",),
    "Warm in Use",
    "What this object is, if it becomes warm while it is in use",
    HeatInUse,
)


def warm_share(heat: Heat, uses: Sequence[tuple[float, float]], time: float) -> float:
    """Return the share of the excess that a thing has at a time, 0 to 1.

    Parameters
    ----------
    heat
        The thing.
    uses
        Start and end of each use, s, sorted and without overlaps.
    time
        The time, s. Later uses do not count.
    """
    share = 0.0
    for start, end, to, scale, before in _phases(heat, uses):
        if start >= time:
            break
        share = to + (before - to) * math.exp(-(min(end, time) - start) / scale)
    return share


def warm_steps(heat: Heat, uses: Sequence[tuple[float, float]]) -> list[float]:
    """Return the times at which the excess has changed by `STEP`, s."""
    found = []
    for start, end, to, scale, before in _phases(heat, uses):
        if not math.isfinite(start):
            continue
        far = heat.excess * abs(to - before)
        for k in range(1, math.ceil(far / STEP)):
            time = start + scale * math.log(far / (far - k * STEP))
            if time >= end:
                break
            found.append(time)
        if math.isfinite(end):
            found.append(end)
    return found


def _phases(
    heat: Heat, uses: Sequence[tuple[float, float]]
) -> Iterator[tuple[float, float, float, float, float]]:
    """Yield each time in which a thing warms up or cools down.

    Each has its start and end, s, the share of the excess that it goes to, its time constant, s,
    and the share at the start.
    """
    share = 0.0
    for (start, stop), (after, _) in pairwise([*_spans_on(heat, uses), (math.inf, math.inf)]):
        for begins, ends, to, scale in (
            (start, stop, 1.0, heat.rise), (stop, after, 0.0, heat.fall)
        ):  # fmt: skip
            if begins < ends:
                yield begins, ends, to, scale, share
                share = to + (share - to) * math.exp(-(ends - begins) / scale)


def _spans_on(heat: Heat, uses: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return start and end of each time for which a thing is on, which can outlast its use."""
    found: list[tuple[float, float]] = []
    for start, end in uses:
        end += heat.runs_on
        if found and start <= found[-1][1]:
            found[-1] = found[-1][0], max(end, found[-1][1])
        else:
            found.append((start, end))
    return found
