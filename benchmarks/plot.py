# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw the plots of the pages as SVG with matplotlib, which `make bench` installs."""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from sensor_logic.palette import BLACK, BLUE, GREEN, ORANGE, PURPLE, SKY, YELLOW

WIDTH = 8.6
COLOURS = (BLUE, SKY, GREEN, PURPLE, ORANGE, YELLOW, BLACK)
STYLES: Mapping[str, Mapping[str, Any]] = {
    "line": {"linewidth": 1.6},
    "thin": {"linewidth": 1.0},
    "dots": {"linestyle": "", "marker": "o", "markersize": 4.0, "markerfacecolor": "white"},
}


@dataclass(frozen=True)
class Series:
    """A line, a `thin` line, or `dots`.

    Without a label it is not in the legend. `names` label its points.
    """

    label: str
    x: Sequence[float]
    y: Sequence[float]
    colour: str
    style: str = "line"
    names: Sequence[str] = ()


@dataclass(frozen=True)
class Panel:
    """Series over one y axis, with its label and unit.

    `height` is in hundredths of an inch. The axis spans at least `least` on both sides of zero.
    `legend` is the title of the legend; `log` makes the axis logarithmic.
    """

    label: str
    series: Sequence[Series]
    height: float
    least: float = 0.0
    legend: str = ""
    log: bool = False


def figures(parts: Mapping[str, dict[str, Any]]) -> dict[str, str]:
    """Return the SVGs by file name."""
    drawn = {"home": _home, "pir": _pir, "switch": _switch, "pressure": _pressure}
    drawn |= {"growth": _growth, "light": _light}
    found: dict[str, str] = {}
    for part, data in parts.items():
        found |= dict(drawn[part](data)) if part in drawn else {}
    return found


Drawn = Iterator[tuple[str, str]]


def _home(data: dict[str, Any]) -> Drawn:
    rays, counts = data["rays"], data["counts"]
    speed = Panel("times real time", _ranged("rays", rays, "seven PIRs"), 200, log=True)
    kept = [Series("kept", _column(rays, "rays"), _column(rays, "kept", 100), BLUE)]
    title = "Speed and accuracy over the rays of a fan, seven detectors"
    panels = [speed, Panel("updates kept, %", kept, 160)]
    yield "bench_rays.svg", figure(title, "rays", panels, log_x=True)
    title = "Speed over the number of motion detectors, 120 rays each"
    panels = [Panel("times real time", _ranged("pirs", counts, "home"), 220, log=True)]
    yield "bench_pirs.svg", figure(title, "motion detectors", panels, log_x=True)
    title = f"Where {data['seconds']:.0f} s of the Ängen home go"
    yield "bench_home.svg", bars(title, "seconds of real time", data["cases"])


def _pir(data: dict[str, Any]) -> Drawn:
    panels, colours = [], (BLUE, SKY, GREEN, PURPLE, ORANGE, BLACK)
    # A quick measurement has no rows with other numbers of rays.
    for group in ("rays, all tilts", "rays, saw-tooth"):
        rows = [row for row in data["rows"] if row["group"] == group]
        rays, walkers = [int(row["name"]) for row in rows], rows[0]["walkers"] if rows else {}
        said = {name: [100 * row["walkers"][name]["said"] for row in rows] for name in walkers}
        series = [Series(n, rays, y, c) for (n, y), c in zip(said.items(), colours, strict=False)]
        panels += [Panel(f"{group[6:]}: motion, %", series, 220)] if rows else []
    if panels:
        title = "Share of updates that report motion"
        yield "bench_pir.svg", figure(title, "rays of a fan", panels, log_x=True)


def _switch(data: dict[str, Any]) -> Drawn:
    series = []
    names = dict.fromkeys(_column(data["flags"], "name"))
    for name, colour in zip(names, (BLUE, ORANGE, GREEN, PURPLE), strict=True):
        rows = [row for row in data["flags"] if row["name"] == name]
        substeps = _column(rows, "substeps")
        series.append(Series(name.partition(",")[0], substeps, _column(rows, "exact", 100), colour))
        series.append(Series("", substeps, _column(rows, "seen", 100), BLACK, "dots"))
    panel = Panel("crossings seen, %", series, 260, legend="lines: exact\ndots: measured")
    title = "Flags seen at 24 frames a second"
    yield "bench_switch.svg", figure(title, "substeps", [panel], log_x=True)


def _pressure(data: dict[str, Any]) -> Drawn:
    """Draw measured (dots) and exact (lines) forces, with their difference below."""
    data = data["table"]
    time, shown = data["time_s"], [i for i, known in enumerate(data["known"]) if known]
    forces, residuals = [], []
    for colour, leg in zip((BLUE, ORANGE, GREEN, PURPLE), data["exact"], strict=True):
        exact, measured = data["exact"][leg], data["measured"][leg]
        dots = [time[i] for i in shown[::4]], [measured[i] for i in shown[::4]]
        forces += [Series(leg, time, exact, colour), Series("", *dots, colour, "dots")]
        off = [measured[i] - exact[i] for i in shown]
        residuals.append(Series("", [time[i] for i in shown], off, colour))
    residuals.append(Series("", [time[0], time[-1]], [0.0, 0.0], BLACK, "thin"))
    weight, carrier = data["weight_kg"], data["table_kg"]
    title = f"A weight of {weight:g} kg moves from leg to leg of a table of {carrier:g} kg"
    top = Panel("force under the leg [N]", forces, 330, legend="lines: exact\ndots: measured")
    below = Panel("measured − exact [N]", residuals, 120, least=0.002)
    yield "pressure_table.svg", figure(title, "time [s]", [top, below])


def _growth(data: dict[str, Any]) -> Drawn:
    for name, rows in data["sweeps"].items():
        x = _column(rows, "size")

        def series(what: str, unit: str, colour: str, x: Any = x, rows: Any = rows) -> Series:
            return Series(what, x, _medians(rows, f"{what}_{unit}"), colour)

        times = [series("sensing", "ms", ORANGE), series("evaluation", "ms", BLUE)]
        sizes = [series("scene", "mib", GREEN), series("run", "mib", PURPLE)]
        panels = [Panel("ms per update step", times, 180, log=True)]
        panels.append(Panel("MiB", sizes, 150, log=True))
        title = f"Cost over the number of {name}"
        yield f"bench_growth_{name}.svg", figure(title, name, panels, log_x=True)


def _light(data: dict[str, Any]) -> Drawn:
    """Draw the rms error over milliseconds per sensor, of updates of seven sensors and of runs."""
    methods = (("ILLUMINANCE", "Illuminance", ORANGE), ("FOUR_WALL", "Four walls", BLUE))
    speed, run = [], []
    for method, title, colour in methods:
        rows = [row for row in data.get(method, {}).get("rows", ()) if row["sensors"] == 7]
        points = _column(rows, "ms_a_sensor"), _column(rows, "rms", 100)
        speed.append(Series(title, *points, colour))
        speed.append(Series("", *points, colour, "dots", [f"{row['samples']}" for row in rows]))
        rows = [row for row in data.get("run", {}).get("rows", ()) if row["method"] == method]
        points = _column(rows, "ms_a_sensor"), _column(rows, "rms", 100)
        run.append(Series(title, *points, colour, "dots", [_paths_label(row) for row in rows]))
    panel = Panel("rms error, %", speed, 330, legend="numbers: light paths", log=True)
    title = "Seven light sensors of the Ängen home: error over time"
    yield "light_benchmarks.svg", figure(title, "ms a sensor and update", [panel], log_x=True)
    legend = "numbers: light paths\nof an update + of the reference"
    panel = Panel("rms error, %", run, 330, legend=legend, log=True)
    title = "A run of the Ängen home: error over time"
    yield "light_run.svg", figure(title, "ms a sensor", [panel], log_x=True)


def _paths_label(row: dict[str, Any]) -> str:
    """Return the light paths of a row as a label."""
    paths = f"{row['samples']} + {row['reference']}" if row["reference"] else f"{row['samples']}"
    return paths if row["code"] == "this" else f"{paths}, former"


def _column(rows: Sequence[dict[str, Any]], key: str, times: int = 1) -> list[Any]:
    """Return a field of all rows, multiplied by `times`."""
    return [row[key] if times == 1 else times * row[key] for row in rows]


def _medians(rows: Sequence[dict[str, Any]], key: str, of: str = "median") -> list[float]:
    """Return the medians of a field of all rows."""
    return [row[key][of] for row in rows]


def _ranged(key: str, rows: list[dict[str, Any]], label: str) -> list[Series]:
    """Return the median speed as a line, the least and the greatest as dots."""
    x, repeated = _column(rows, key), rows[0]["speed"]["runs"] > 1
    dots = [
        Series("", x, _medians(rows, "speed", of), BLACK, "dots")
        for of in (("low", "high") if repeated else ())
    ]
    return [Series(label, x, _medians(rows, "speed"), ORANGE), *dots]


def figure(title: str, x_label: str, panels: Sequence[Panel], log_x: bool = False) -> str:
    """Return panels below each other over a common x axis, as SVG."""
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
            # Space for the names of the outermost points.
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


def bars(title: str, unit: str, rows: Sequence[Mapping[str, Any]]) -> str:
    """Return stacked bars of the seconds of each part of the runs, as SVG."""
    drawing, (axis,) = _subplots(1, 0.45 * len(rows) + 1.3)
    drawing.suptitle(title, fontweight="bold")
    names, left = [row["name"] for row in rows], [0.0] * len(rows)
    for part, colour in zip(rows[0]["parts_s"], COLOURS, strict=False):
        seconds = [row["parts_s"][part] for row in rows]
        axis.barh(names, seconds, left=left, color=colour).set_label(part)
        left = [start + more for start, more in zip(left, seconds, strict=True)]
    for row, end in zip(rows, left, strict=True):
        at, behind = (end, row["name"]), f"{row['speed']['median']:#.3g}".rstrip(".") + " ×"
        axis.annotate(behind, at, xytext=(6, 0), textcoords="offset points", va="center")
    axis.invert_yaxis()
    axis.set_xlabel(unit)
    axis.margins(x=0.1)
    axis.legend(ncols=4, loc="lower left", bbox_to_anchor=(0.0, 1.0), frameon=False)
    return _svg(drawing)


def _plain_numbers(axis: Any) -> None:
    """Set ticks at 1, 2 and 5 times powers of ten, without exponents."""
    axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axis.set_major_formatter("{x:g}")
    axis.set_minor_formatter(NullFormatter())


def _subplots(rows: int, height: float, **ratios: Any) -> tuple[Any, Any]:
    drawing = Figure(figsize=(WIDTH, height), layout="constrained")
    axes = drawing.subplots(rows, 1, sharex=True, squeeze=False, gridspec_kw=ratios)[:, 0]
    for axis in axes:
        axis.grid(color="#ddd")
        axis.set_axisbelow(True)
    return drawing, axes


def _svg(drawing: Any) -> str:
    """Return the SVG: the same bytes for the same numbers, and text as text."""
    out = io.StringIO()
    with matplotlib.rc_context({"svg.hashsalt": "angen", "svg.fonttype": "none"}):
        drawing.savefig(out, format="svg", metadata={"Date": None})
    return "\n".join(line.rstrip() for line in out.getvalue().splitlines()) + "\n"
