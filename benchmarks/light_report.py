# SPDX-License-Identifier: GPL-3.0-or-later
"""The page and the plot of the light sensor's benchmark, from the data."""

from __future__ import annotations

import math
from typing import Any

from . import tables
from .plot import BLUE, ORANGE, Panel, Series, figure

INTRODUCTION = """\
# Light sensor: speed against error

Written by `python -m benchmarks.light`; do not edit. Machine: {machine}, two cores.

The Ängen home at a moment at which lamps and daylight shine, its own seven light sensors, and
copies of them in other places and directions. The error is relative to {reference} light paths
and three seeds, whose own noise (median) stands beside. That nothing changed is found out in
{static:.2f} ms, and then nothing is rendered.

The home is hard for light paths: its lamps stand in shades and close to ceilings and walls, so
that most of the light at a sensor comes from small bright spots that paths find by chance. The
same seeds are used at each update: where nothing moves, a reading does not flicker, it is off by
the same share at each.

![rms error over time a sensor](light_benchmarks.svg)

"""
ERRORS = ("rms=rms:.1%", "median=median:.1%", "worst=worst:.1%")
COLUMNS = ("method", "samples", "sensors", "ms a sensor=ms_a_sensor:.1f", *ERRORS)
RUN = """
## In a run

The home's story with its seven sensors: people, doors and lamps as they go. A *reference* (scene
property *Reference paths*, 0: none) traces many paths once, in the home as it is at the first
frame, for any state of the lamps, and takes what the few paths of an update miss out of its
readings. *Code*: of this checkout, or of another one *beside*.

Errors: at {moments} moments drawn from the story, by {seeds} seeds, against {true_seeds} other
seeds of {paths} paths each, without a reference. The noise of these (their standard error, rms)
stands beside; it is taken out of the rms, but not of the median and the worst. ±: the rms's
standard error over the seeds. *ms a sensor*, *CPU s*: of the story once a second of it ({updates}
updates) with all of that, the ways and the code beside after one another; *times bare*: CPU s as a
multiple of what Blender took to put the home to these frames.

"""
RUN_COLUMNS = (
    "method",
    "code",
    "paths=samples",
    "reference",
    "ms a sensor=ms_a_sensor:.1f",
    "CPU s=cpu_s:.1f",
    "times bare=to_bare:.1f",
    "rms=rms:.2%",
    "±=rms_error:.2%",
    *ERRORS[1:],
    "their noise (rms)=noise_rms:.1%",
)
PLANE = """
## The far plane

The seven sensors at the same moment, looking at four walls, as their far clip plane (*Clip end*)
moves out; nothing else changes. *ms a sensor*: median (least–greatest) of {runs} further updates of
{samples} light paths, in which the planes took turns. *Views that end*: of their {views} views,
those in which something stands before the plane, by Blender's own ray; a view that does not end
sees nothing but the world, here a sky brighter than any wall. The readings: {exact} light paths.

A path tracer's cost is that of its paths: where a view is cut off they are cut short, and where it
is not, they are as long as the rooms make them. So pick the plane for what the sensor should see:
far enough for every wall, not for speed.

"""
RADIANCE = """
## Cycles against Radiance

The home with the same diffuse grey for both, without what light passes through, lamps as spheres
(radius at most 2 cm), disks and bars, by sun and an even sky (*day*) or by the lamps (*lamp*); W/m²
at faces that look down from each light sensor and up from table height. Cycles: {samples} samples;
Radiance's `rtrace -I` with {divisions} ambient divisions, 30 bounces, no interpolation. *Direct*:
black surfaces; the sky is then looked for with a million divisions, as few faces see little of it.
Faces with less than {least} W/m² are not counted.

| light | part | faces | ratio of the sums | rms | worst |
|---|---|---|---|---|---|
"""
LEAST = 0.01
SEVEN = 7
NAMES = {"ILLUMINANCE": "Illuminance", "FOUR_WALL": "Four walls"}
COLOURS = {"ILLUMINANCE": ORANGE, "FOUR_WALL": BLUE}


def rows(data: dict[str, Any]) -> list[dict[str, Any]]:
    """The rows of both methods, as far as they are there."""
    return [row for method in COLOURS if method in data for row in data[method]["rows"]]


def markdown(data: dict[str, Any]) -> str:
    found = rows(data)
    text = ""
    if found:
        speed = data[found[0]["method"]]
        text = INTRODUCTION.format(
            machine=speed["machine"],
            reference=speed["reference_samples"],
            static=speed["static_ms"],
        )
        text += tables.columns(found, *COLUMNS, "reference's noise=reference_noise:.1%")
    for method in COLOURS:
        many = data.get(method, {}).get("many")
        if many:
            text += (
                f"\n{many['sensors']} sensors ({method}, {many['samples']} samples): "
                f"{many['ms_a_sensor']:.1f} ms a sensor.\n"
            )
    if "plane" in data:
        text += _plane(data["plane"])
    if "run" in data:
        text += RUN.format(**data["run"])
        text += tables.columns(data["run"]["rows"], *RUN_COLUMNS)
    if "radiance" in data:
        text += _radiance(data["radiance"])
    return text


def table(data: dict[str, Any]) -> str:
    """For docs/light.md: seven sensors."""
    seven = [row for row in rows(data) if row["sensors"] == SEVEN]
    told = [{**row, "method": NAMES[row["method"]]} for row in seven]
    columns = ("method", "samples", "ms a sensor=ms_a_sensor:.1f", "rms error=rms:.1%")
    text = tables.columns(told, *columns, *ERRORS[1:])
    return (
        "Seven sensors in the Ängen home, an update, on two cores; the reference's own noise is "
        + ", ".join(f"{data[m]['rows'][0]['reference_noise']:.1%}" for m in COLOURS if m in data)
        + f" (median):\n\n{text}"
    )


def run_table(data: dict[str, Any]) -> str:
    """For docs/light.md: a whole run, with and without a reference."""
    found = data.get("run", {}).get("rows", ())
    table = tables.columns(
        [{**r, "method": NAMES[r["method"]]} for r in found if r["code"] == "this"],
        "method",
        "samples",
        "reference paths=reference",
        "ms a sensor and update=ms_a_sensor:.1f",
        "rms error=rms:.1%",
        "median=median:.1%",
    )
    return f"![rms error over time a sensor](light_run.svg)\n\n{table}"


def _plane(data: dict[str, Any]) -> str:
    first = data["rows"][0]
    rooms = [name.removeprefix("Light sensor ") for name in first["percent"]]
    return PLANE.format(
        runs=first["ms_a_sensor"]["runs"],
        views=first["views"],
        samples=data["samples"],
        exact=data["exact"],
    ) + tables.table(
        ("far plane m", "ms a sensor", "views that end", *(f"{room} %" for room in rooms)),
        (
            (
                f"{row['far_m']:g}",
                tables.spread(row["ms_a_sensor"]),
                f"{row['ended']}",
                *(f"{value:.2f}" for value in row["percent"].values()),
            )
            for row in data["rows"]
        ),
    )


def _radiance(data: dict[str, Any]) -> str:
    text = RADIANCE.format(least=LEAST, **data)
    groups: dict[tuple[str, str], list[tuple[float, float]]] = {}
    for row in data["rows"]:
        if max(row["cycles"], row["radiance"]) >= LEAST:
            pair = row["cycles"], row["radiance"]
            groups.setdefault((row["time"], row["part"]), []).append(pair)
    for (time, part), pairs in groups.items():
        ratio = sum(a for a, _ in pairs) / sum(b for _, b in pairs)
        errors = [abs(a / b - 1.0) if b else 1.0 for a, b in pairs]
        rms = math.sqrt(sum(e * e for e in errors) / len(errors))
        text += (
            f"| {time} | {part} | {len(pairs)} | {ratio:.4f} | {rms:.1%} | {max(errors):.1%} |\n"
        )
    return text


def plot(found: list[dict[str, Any]]) -> str:
    """An SVG: rms error over milliseconds a sensor, both logarithmic; seven sensors."""
    series = []
    for method, colour in COLOURS.items():
        seven = [r for r in found if r["method"] == method and r["sensors"] == SEVEN]
        names = [f"{r['samples']}" for r in seven]
        x, y = [r["ms_a_sensor"] for r in seven], [100 * r["rms"] for r in seven]
        series.append(Series(NAMES[method], x, y, colour))
        series.append(Series("", x, y, colour, "dots", names))
    panel = Panel("rms error, %", series, 330, legend="numbers: light paths", log=True)
    title = "Seven light sensors of the Ängen home: error over time"
    return figure(title, "ms a sensor and update", [panel], log_x=True)


def run_plot(found: list[dict[str, Any]]) -> str:
    """An SVG: rms error of runs over milliseconds a sensor and update, both logarithmic."""
    series = []
    for method, colour in COLOURS.items():
        rows = [row for row in found if row["method"] == method]
        names = [_way(row) for row in rows]
        x, y = [row["ms_a_sensor"] for row in rows], [100 * row["rms"] for row in rows]
        series.append(Series(NAMES[method], x, y, colour, "dots", names))
    legend = "numbers: light paths\nof an update + of the reference"
    panel = Panel("rms error, %", series, 330, legend=legend, log=True)
    return figure("A run of the Ängen home: error over time", "ms a sensor", [panel], log_x=True)


def _way(row: dict[str, Any]) -> str:
    paths = f"{row['samples']} + {row['reference']}" if row["reference"] else f"{row['samples']}"
    return paths if row["code"] == "this" else f"{paths}, former"
