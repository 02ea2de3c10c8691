# SPDX-License-Identifier: GPL-3.0-or-later
"""Plots as SVG, drawn by matplotlib, which `make bench` installs."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sensor_logic.report.svg import (
    BLACK,
    BLUE,
    GREEN,
    ORANGE,
    PURPLE,
    SKY,
    YELLOW,
)

WIDTH = 8.6
COLOURS = (BLUE, SKY, GREEN, PURPLE, ORANGE, YELLOW, BLACK)
STYLES: Mapping[str, Mapping[str, Any]] = {
    "line": {"linewidth": 1.6},
    "thin": {"linewidth": 1.0},
    "dots": {"linestyle": "", "marker": "o", "markersize": 4.0, "markerfacecolor": "white"},
}


@dataclass(frozen=True)
class Series:
    """A line, a `thin` line, or `dots`; without a label it is not in the legend. `names` label its
    points."""

    label: str
    x: Sequence[float]
    y: Sequence[float]
    colour: str
    style: str = "line"
    names: Sequence[str] = ()


@dataclass(frozen=True)
class Panel:
    """Series over one y axis, with its label and unit; `height` in hundredths of an inch; `least`:
    the axis spans at least this much on both sides of zero; `legend`: the title of the legend;
    `log`: a logarithmic axis."""

    label: str
    series: Sequence[Series]
    height: float
    least: float = 0.0
    legend: str = ""
    log: bool = False


def figure(title: str, x_label: str, panels: Sequence[Panel], log_x: bool = False) -> str:
    """Panels below each other over a common x axis, as SVG."""
    heights = [panel.height for panel in panels]
    drawing, axes = _subplots(len(panels), sum(heights) / 100 + 0.9, height_ratios=heights)
    drawing.suptitle(title, fontweight="bold")
    for axis, panel in zip(axes, panels, strict=True):
        for series in panel.series:
            label = series.label or "_"
            style = STYLES[series.style]
            axis.plot(series.x, series.y, color=series.colour, label=label, **style)
            for name, *at in zip(series.names, series.x, series.y, strict=False):
                axis.annotate(name, at, xytext=(5, 4), textcoords="offset points", fontsize="small")
        if any(series.names for series in panel.series):
            # Room for those of the outermost.
            axis.margins(x=0.3, y=0.1)
        axis.set_ylabel(panel.label)
        if panel.least:
            axis.update_datalim([(panel.series[0].x[0], y) for y in (-panel.least, panel.least)])
            axis.autoscale_view()
        if panel.log:
            axis.set_yscale("log")
            _plain_numbers(axis.yaxis)
        if any(series.label for series in panel.series):
            axis.legend(
                title=panel.legend, loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False
            )
    if log_x:
        axes[-1].set_xscale("log")
        _plain_numbers(axes[-1].xaxis)
    axes[-1].set_xlabel(x_label)
    return _svg(drawing)


def bars(title: str, unit: str, rows: Sequence[tuple[str, Mapping[str, float], str]]) -> str:
    """Stacked bars from rows (name, value by part, text behind the bar), as SVG."""
    drawing, (axis,) = _subplots(1, 0.45 * len(rows) + 1.3)
    drawing.suptitle(title, fontweight="bold")
    names, left = [name for name, _, _ in rows], [0.0] * len(rows)
    for part, colour in zip(rows[0][1], COLOURS, strict=False):
        drawn = axis.barh(names, [row[part] for _, row, _ in rows], left=left, color=colour)
        drawn.set_label(part)
        left = [start + row[part] for start, (_, row, _) in zip(left, rows, strict=True)]
    for name, end, (_, _, behind) in zip(names, left, rows, strict=True):
        axis.annotate(behind, (end, name), xytext=(6, 0), textcoords="offset points", va="center")
    axis.invert_yaxis()
    axis.set_xlabel(unit)
    axis.margins(x=0.1)
    axis.legend(ncols=4, loc="lower left", bbox_to_anchor=(0.0, 1.0), frameon=False)
    return _svg(drawing)


def _plain_numbers(axis: Any) -> None:
    """Ticks at 1, 2 and 5 times powers of ten, without exponents."""
    from matplotlib.ticker import LogLocator, NullFormatter

    axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axis.set_major_formatter("{x:g}")
    axis.set_minor_formatter(NullFormatter())


def _subplots(rows: int, height: float, **ratios: Any) -> tuple[Any, Any]:
    from matplotlib.figure import Figure

    drawing = Figure(figsize=(WIDTH, height), layout="constrained")
    axes = drawing.subplots(rows, 1, sharex=True, squeeze=False, gridspec_kw=ratios)[:, 0]
    for axis in axes:
        axis.grid(color="#ddd")
        axis.set_axisbelow(True)
    return drawing, axes


def _svg(drawing: Any) -> str:
    """The SVG, with the same bytes for the same numbers, and with text as text."""
    import matplotlib

    out = io.StringIO()
    with matplotlib.rc_context({"svg.hashsalt": "angen", "svg.fonttype": "none"}):
        drawing.savefig(out, format="svg", metadata={"Date": None})
    return "\n".join(line.rstrip() for line in out.getvalue().splitlines()) + "\n"
