# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw the timeline: a row for each sensor, which shows its values and when it was active.

Rows are grouped by room.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from ..kinds import KINDS
from ..model import Array
from ..recording.tracks import Track
from .facts import Report, ReportedSensor, quantity
from .svg import coordinate, hue, mark, place, safe, shortened, shown_number, text_width, ticks

# Reduce a track to the columns of a drawing; events narrower than a column stay visible.
#
# A reading holds until the next reading, or for one period if the next reading is missing.

# A smaller share of a column's time is a rounding error.
ROUNDING = 1e-6


@dataclass(frozen=True)
class Columns:
    """A track, reduced to n columns of pixels, which are equally long time spans.

    Attributes
    ----------
    known
        The fraction (n,) of the column for which the sensor was simulated.
    active, invalid
        The fraction (n,) of this time in which the sensor was active, and in which its reading was
        not valid.
    low, high, last
        The least, the greatest and the last value (n,) in the column; NaN if there is none.
    quantity
        The name of the field with these values.
    top
        The greatest valid value in all columns.
    """

    known: Array
    active: Array
    invalid: Array
    low: Array
    high: Array
    last: Array
    quantity: str
    top: float

    @property
    def sometimes(self) -> NDArray[np.bool_]:
        """The mask of the columns in which the sensor was active at least briefly."""
        return self.active > ROUNDING

    @property
    def throughout(self) -> NDArray[np.bool_]:
        """The mask of the columns in which the sensor was active all the time."""
        return self.active > 1.0 - ROUNDING


def columns(track: Track, period: float, step: float, span: tuple[float, float], n: int) -> Columns:
    """Return a track, reduced to `n` columns of pixels.

    `period` is the time between updates, and `step` their longest delay. `span` is the begin of the
    first column and the end of the last one. All times are in s.
    """
    times = np.array(track.times, np.float64)
    if not len(times):
        none, unmeasured = np.zeros(n), np.full(n, np.nan)
        return Columns(none, none, none, unmeasured, unmeasured, unmeasured, "", np.nan)
    ends = np.append(times[1:], np.inf)
    held = np.where(ends - times > 1.5 * period + step, times + period, ends)
    held = np.minimum(held, max(span[1], float(times[-1])))
    edges = np.linspace(*span, n + 1)
    width = (span[1] - span[0]) / n

    def share(mask: NDArray[np.bool_]) -> Array:
        """Return the fraction (n,) of each column that is covered by the readings in the mask."""
        durations = np.where(mask, held - times, 0.0)
        total = np.concatenate([[0.0], np.cumsum(durations)])
        moments = np.stack([times, held], axis=1).ravel()
        amounts = np.stack([total[:-1], total[1:]], axis=1).ravel()
        return np.diff(np.interp(edges, moments, amounts)) / width

    known = share(np.ones(len(times), bool))
    of = np.maximum(known, ROUNDING)
    bad = track.invalid()
    name, values = quantity(track)
    low = high = last = np.full(n, np.nan)
    top = np.nan
    if name:
        low, high, last = _envelope(times, held, values, edges)
        good = values[~bad & np.isfinite(values)]
        top = float(good.max()) if len(good) else np.nan
    active = np.asarray(track.active, dtype=np.int8) != 0
    return Columns(known, share(active) / of, share(bad) / of, low, high, last, name, top)


def _envelope(times: Array, held: Array, values: Array, edges: Array) -> tuple[Array, Array, Array]:
    """Return the least, greatest and last value (n,) in n columns of time.

    `edges` (n + 1,) are the times between which the columns are. A value applies from its time in
    `times` to that in `held`.
    """
    n = len(edges) - 1

    def at(moments: Array, side: str) -> Array:
        """Return the value that applies at each time; with side "left", just before it."""
        index = np.searchsorted(times, moments, "right" if side == "right" else "left") - 1
        exists = index >= 0
        reaches = held[index] > moments if side == "right" else held[index] >= moments
        return np.where(exists & reaches, values[index], np.nan)

    carried, last = at(edges[:-1], "right"), at(edges[1:], "left")
    low, high = np.fmin(carried, last), np.fmax(carried, last)
    where = np.searchsorted(edges, times, "right") - 1
    inside = (where >= 0) & (where < n) & np.isfinite(values)
    np.fmin.at(low, where[inside], values[inside])
    np.fmax.at(high, where[inside], values[inside])
    return low, high, last


def runs(mask: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return the runs of true values in a mask, as pairs (begin, end) of indices.

    The index `end` is the one after the last true value.
    """
    change = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8)))
    return [(int(a), int(b)) for a, b in change.reshape(-1, 2)]


# Round times on a time axis, from fractions of a second to days.

MINUTE, HOUR, DAY = 60.0, 3600.0, 86400.0
STEPS = (
    *(MINUTE * m for m in (1 / 6, 1 / 4, 1 / 2, 1, 2, 5, 10, 15, 30)),
    *(HOUR * h for h in (1, 2, 3, 6, 12)),
    *(DAY * d for d in (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)),
)
# Up to this span, labels are in seconds; for longer spans they are clock times.
SECONDS_UP_TO = 300.0


def moments(first: float, last: float, count: int) -> list[float]:
    """Return about `count` round times (s) between `first` and `last`, for the ticks of an axis."""
    span = last - first
    if span <= SECONDS_UP_TO:
        found = ticks(first, last, count)
    else:
        step = next((s for s in STEPS if s * count >= span), STEPS[-1])
        found = [step * i for i in range(math.floor(first / step), math.ceil(last / step) + 1)]
    slack = span * 1e-9
    return [t for t in found if first - slack <= t <= last + slack]


def time_label(time: float, span: float) -> str:
    """Return the label of a time (s) on an axis that spans `span` seconds.

    A longer span gives a coarser label: 90, 1:30 (min:s), 2:15 (h:min), or a number of days.
    """
    if span <= SECONDS_UP_TO:
        return shown_number(time)
    sign, seconds = ("−" if time < 0 else ""), round(abs(time))
    minutes, seconds = divmod(seconds, 60)
    if span < HOUR:
        return f"{sign}{minutes}:{seconds:02}"
    hours, minutes = divmod(minutes, 60)
    if span >= 5 * DAY:
        return f"{sign}{hours / 24:g}"
    return f"{sign}{hours}:{minutes:02}"


def unit(span: float) -> str:
    """Return the title of an axis that spans `span` seconds, with the unit of its labels."""
    if span <= SECONDS_UP_TO:
        return "time in s"
    if span < HOUR:
        return "time in min:s"
    return "time in h:min" if span < 5 * DAY else "time in days"


WIDTH = 880
ROOM, MARK, NAME = 0.0, 100.0, 116.0
LEFT, RIGHT = 272.0, 812.0
TOP, ROW, BOTTOM = 22.0, 22.0, 36.0
# A bar from HIGH to LOW means active for the whole column, a bar from MIDDLE to LOW active for a
# part of the column. A curve is drawn above a low bar.
HIGH, LOW, MIDDLE = 5.0, 18.0, 11.5
CURVE_TOP, CURVE_BASE = 3.0, 16.0
# The narrowest column (px), and the most columns in a whole report.
FINEST, COLUMNS = 0.5, 90_000
MOST_TICKS = 9
LEGEND_HEIGHT = 48.0


def timeline(
    report: Report, numbered: Sequence[tuple[int, ReportedSensor]], name: str
) -> tuple[str, float]:
    """Return the timeline of some sensors as SVG, and its height in px.

    `numbered` has the number and the sensor of each row. All ids in the SVG begin with `name`.
    """
    first, last = report.span
    rooms = any(sensor.room for sensor in report.sensors)
    bottom = TOP + ROW * len(numbered)
    parts = [_patterns(name), *_grid(first, last, bottom)]
    top = TOP
    for room, group in groupby(numbered, key=lambda row: row[1].room):
        members = list(group)
        shown_room = shortened(room or "no room", MARK - 22, 12)
        if rooms:
            parts.append(
                f'<text class="strong" x="{ROOM:g}" y="{top + 15:g}">{safe(shown_room)}'
                f"<title>{safe(room)}</title></text>"
            )
        for number, sensor in members:
            parts += _row(report, number, sensor, top, name, rooms)
            top += ROW
        parts.append(f'<path class="rule" d="M0 {top:g}H{RIGHT:g}"/>')
    return "\n".join(parts), bottom + BOTTOM


def column_width(sensors: int) -> float:
    """Return the width of a timeline's column in px, as small as possible.

    All rows together, one for each of the `sensors`, have at most COLUMNS columns.
    """
    most = round((RIGHT - LEFT) / FINEST)
    whole = [k for k in range(1, most + 1) if most % k == 0]
    return FINEST * next((k for k in whole if sensors * most // k <= COLUMNS), most)


def _patterns(name: str) -> str:
    return (
        f'<defs><pattern id="{name}-invalid" width="5" height="5" patternUnits="userSpaceOnUse" '
        f'patternTransform="rotate(45)"><path class="hatch" d="M0 0V5"/></pattern>'
        f'<pattern id="{name}-off" width="6" height="6" patternUnits="userSpaceOnUse">'
        f'<circle class="dot" cx="3" cy="3" r=".9"/></pattern></defs>'
    )


def _grid(first: float, last: float, bottom: float) -> list[str]:
    span = last - first
    parts = [f'<path class="rule" d="M0 {TOP:g}H{RIGHT:g}"/>']
    for moment in moments(first, last, MOST_TICKS):
        x = coordinate(place(moment, first, last, LEFT, RIGHT))
        label = time_label(moment, span)
        parts.append(f'<path class="grid" d="M{x} {TOP:g}V{bottom:g}"/>')
        parts.append(f'<text class="small quiet mid" x="{x}" y="{TOP - 7:g}">{label}</text>')
        parts.append(f'<text class="small quiet mid" x="{x}" y="{bottom + 15:g}">{label}</text>')
    middle = (LEFT + RIGHT) / 2
    parts.append(
        f'<text class="small quiet mid" x="{middle:g}" y="{bottom + 30:g}">{unit(span)}</text>'
    )
    return parts


def _row(
    report: Report, number: int, sensor: ReportedSensor, top: float, name: str, rooms: bool
) -> list[str]:
    at_mark, at_name = (MARK, NAME) if rooms else (12.0, 28.0)
    shown = shortened(sensor.name, LEFT - at_name - 12, 12)
    kind = KINDS[sensor.kind_name]
    parts = [
        mark(sensor.kind_name, at_mark, top + ROW / 2, str(number)),
        f'<text x="{at_name:g}" y="{top + 15:g}">{safe(shown)}'
        f"<title>{safe(sensor.name)}: {safe(kind.label)}</title></text>",
    ]
    track = report.recording.tracks.get(sensor.name) or Track(sensor.name, sensor.kind_name)
    clock = report.recording.clock
    assert clock is not None
    width = column_width(len(report.sensors))
    n = round((RIGHT - LEFT) / width)
    seen = columns(track, sensor.period, clock.step_time(1), report.span, n)
    body = [*_spans(seen, width, name, hue(sensor.kind_name))]
    parts.append(f'<g transform="translate({LEFT:g} {top:g})">{"".join(body)}</g>')
    if np.isfinite(seen.top) and seen.top > 0.0:
        text = safe(KINDS[sensor.kind_name].fields[seen.quantity].short(seen.top))
        parts.append(f'<text class="small" x="{RIGHT + 8:g}" y="{top + 11:g}">{text}</text>')
    return parts


def _spans(seen: Columns, width: float, name: str, colour: int) -> list[str]:
    """Return the SVG elements of a row, relative to the row's upper left corner."""
    parts = []
    measured = bool(seen.quantity)
    if measured:
        parts.append(_curve(seen, width, colour))
    high, low = (LOW - 2.0, LOW + 1.0) if measured else (HIGH, LOW)
    middle = (high + low) / 2 if measured else MIDDLE
    parts.append(_bars(seen.throughout, width, high, low, colour))
    parts.append(_bars(seen.sometimes & ~seen.throughout, width, middle, low, colour))
    for a, b in runs(seen.invalid > ROUNDING):
        parts.append(_box(a, b, width, f"{name}-invalid"))
    for a, b in runs(seen.known < 1.0 - ROUNDING):
        parts.append(_box(a, b, width, f"{name}-off"))
    return parts


def _bars(mask: np.typing.NDArray[np.bool_], width: float, high: float, low: float, k: int) -> str:
    """Return each run in a mask as a stroke; strokes make a smaller file than rectangles."""
    found = runs(mask)
    if not found:
        return ""
    pen, steps = 0, []
    for a, b in found:
        steps.append(f"m{coordinate((a - pen) * width)} 0h{coordinate((b - a) * width)}")
        pen = b
    middle = coordinate((high + low) / 2)
    return (
        f'<path class="bar{k}" stroke-width="{coordinate(low - high)}" '
        f'd="M0 {middle}{"".join(steps)}"/>'
    )


def _box(a: int, b: int, width: float, pattern: str) -> str:
    return (
        f'<rect x="{coordinate(a * width)}" y="2" width="{coordinate((b - a) * width)}" '
        f'height="{ROW - 4:g}" fill="url(#{pattern})"/>'
    )


def _curve(seen: Columns, width: float, colour: int) -> str:
    """Return the values as an SVG curve with steps, filled down to zero."""
    top = seen.top if np.isfinite(seen.top) and seen.top > 0.0 else 1.0

    def level(values: np.typing.NDArray[np.float64]) -> np.typing.NDArray[np.float64]:
        """Return the heights above the curve's base, in half pixels."""
        # Invalid values can be above the top.
        return np.round(np.clip(values / top, 0.0, 1.1) * (CURVE_BASE - CURVE_TOP) * 2)

    low, high, last = level(seen.low), level(seen.high), level(seen.last)
    parts = []
    for a, b in runs(np.isfinite(seen.high)):
        path, pen, x = [f"M{coordinate(a * width)} {CURVE_BASE:g}"], 0.0, a
        for i in range(a, b):
            ends = [low[i], high[i], low[i] if np.isnan(last[i]) else last[i]]
            if all(e == pen for e in ends):
                continue
            if i > x:
                path.append(f"h{coordinate((i - x) * width)}")
                x = i
            for end in ends:
                if end != pen:
                    path.append(f"v{coordinate((pen - end) / 2)}")
                    pen = end
        path.append(f"h{coordinate((b - x) * width)}v{coordinate(pen / 2)}")
        parts.append("".join(path))
    return f'<path class="curve{colour}" d="{"".join(parts)}"/>' if parts else ""


def legend(report: Report, name: str, y: float) -> str:
    """Return the two lines of the timeline's legend as SVG."""
    named = {sensor.kind_name for sensor in report.sensors}
    kinds = [kind for kind in KINDS.values() if kind.identifier in named]
    parts, x = [], 4.0
    for kind in kinds:
        parts.append(mark(kind.identifier, x + 8, y - 4, ""))
        parts.append(f'<text class="small" x="{x + 22:g}" y="{y:g}">{safe(kind.label)}</text>')
        x += 22 + text_width(kind.label, 10.5) + 14
    x = 4.0
    y += 20
    signs = (
        ('<path class="bar1" stroke-width="12" d="M0 6h22"/>', "active"),
        (
            '<path class="bar1" stroke-width="6" d="M0 9h22"/>',
            "on for a very short time",
        ),
        (f'<rect width="22" height="12" fill="url(#{name}-invalid)"/>', "reading not valid"),
        (f'<rect width="22" height="12" fill="url(#{name}-off)"/>', "not simulated"),
        (
            '<path class="curve1" d="M0 12V8H6V2H14V7H22V12"/>',
            "measured, from 0 to the value at the right",
        ),
    )
    for sign, text in signs:
        parts.append(f'<g transform="translate({coordinate(x)} {y - 10:g})">{sign}</g>')
        parts.append(f'<text class="small" x="{coordinate(x + 28)}" y="{y:g}">{text}</text>')
        x += 28 + text_width(text, 10.5) + 12
    return "\n".join(parts)
