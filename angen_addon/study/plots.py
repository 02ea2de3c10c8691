# SPDX-License-Identifier: GPL-3.0-or-later
"""The pictures of a study's report as SVG, drawn by matplotlib."""

from __future__ import annotations

import io
from collections.abc import Sequence
from itertools import zip_longest
from typing import Any

import numpy as np

from ...sensor_logic.report.svg import BLUE, GREEN, ORANGE, PURPLE, SKY, YELLOW
from ...sensor_logic.study.summary import (
    Level,
    Mean,
    Results,
    levels,
    mean_over_seeds,
    numeric,
    pick,
)

COLOURS = (BLUE, ORANGE, GREEN, PURPLE, SKY, YELLOW)
MARKS = "osD^v<"
WIDTH, HEIGHT = 9.0, 2.9
ACROSS = 3
# More lines than this cannot be told apart.
MOST_LINES = 6


def curves(results: Results, measures: Sequence[str], label: str) -> str:
    """How measures respond to each key that varied: the mean over all runs, with its confidence
    interval over seeds. Several measures are lines of one picture."""
    keys = list(results.varied)
    drawing, axes = _axes(len(keys))
    for axis, key in zip_longest(axes, keys):
        if key is None:
            axis.set_visible(False)
            continue
        found = levels(results.varied[key])
        for number, measure in enumerate(measures[:MOST_LINES]):
            means = [_mean(results, measure, level.rows) for level in found]
            name = measure.removeprefix(label).strip() if len(measures) > 1 else "_"
            _line(axis, found, means, number, name, numeric(results.varied[key]))
        axis.set_xlabel(key)
        axis.grid(color="#ddd")
        axis.set_axisbelow(True)
    axes[0].set_ylabel(label)
    if len(measures) > 1:
        axes[0].legend(frameon=False, fontsize="small")
    return _svg(drawing)


def _line(
    axis: Any, found: Sequence[Level], means: Sequence[Mean], number: int, name: str, line: bool
) -> None:
    at = [level.at for level in found]
    values = [mean.value for mean in means]
    halves = np.nan_to_num([mean.half for mean in means])
    axis.errorbar(
        at,
        values,
        yerr=halves if halves.any() else None,
        color=COLOURS[number],
        marker=MARKS[number],
        markersize=4,
        capsize=3,
        linestyle="-" if line else "",
        label=name,
    )
    if not line:
        axis.set_xticks(at, [level.label[:24] for level in found], rotation=25, ha="right")
        axis.margins(x=0.15)


def heat_map(results: Results, measure: str, keys: tuple[str, str]) -> str:
    """The mean of a measure over two keys, with half of its confidence interval over seeds."""
    across, up = (levels(results.varied[key]) for key in keys)
    means = [[_mean(results, measure, _both(a, b)) for a in across] for b in up]
    values = np.array([[mean.value for mean in row] for row in means])
    drawing, (axis,) = _axes(1, height=max(2.2, 0.36 * len(up) + 1.2))
    image = axis.imshow(values, origin="lower", aspect="auto", cmap="cividis")
    for y, row in enumerate(means):
        for x, mean in enumerate(row):
            if np.isfinite(mean.value) and len(across) <= 10:
                half = "" if np.isnan(mean.half) else f"\n± {mean.half:.2g}"
                dark = values[y, x] < (np.nanmin(values) + np.nanmax(values)) / 2
                colour = "white" if dark else "black"
                text = f"{mean.value:.3g}{half}"
                axis.text(x, y, text, ha="center", va="center", fontsize=7, color=colour)
    axis.set_xticks(range(len(across)), [level.label[:24] for level in across])
    axis.set_yticks(range(len(up)), [level.label[:24] for level in up])
    axis.set_xlabel(keys[0])
    axis.set_ylabel(keys[1])
    drawing.colorbar(image, ax=axis, label=measure)
    return _svg(drawing)


def _both(one: Level, other: Level) -> list[int]:
    return sorted(set(one.rows) & set(other.rows))


def _mean(results: Results, measure: str, rows: Sequence[int]) -> Mean:
    return mean_over_seeds(pick(results.measured[measure], rows), [results.seeds[i] for i in rows])


def _axes(count: int, height: float = HEIGHT) -> tuple[Any, Any]:
    from matplotlib.figure import Figure

    across = min(max(count, 1), ACROSS)
    down = -(-max(count, 1) // across)
    width = WIDTH if across > 1 else WIDTH * 0.6
    drawing = Figure(figsize=(width, height * down), layout="constrained")
    return drawing, drawing.subplots(down, across, sharey=count > 1, squeeze=False).ravel()


def _svg(drawing: Any) -> str:
    """The same bytes for the same numbers; text stays text. Without the head of a file."""
    import matplotlib

    out = io.StringIO()
    with matplotlib.rc_context({"svg.hashsalt": "angen", "svg.fonttype": "none"}):
        drawing.savefig(out, format="svg", metadata={"Date": None})
    return out.getvalue().partition("<svg")[1] + out.getvalue().partition("<svg")[2]
