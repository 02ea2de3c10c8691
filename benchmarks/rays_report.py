# SPDX-License-Identifier: GPL-3.0-or-later
"""The ray layer's section of the benchmark page, from data."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from .tables import median, short, spread

INTRODUCTION = """\
## The ray layer

The fast layer against Blender's own `scene.ray_cast`, on the same {frames} frames in one process:
milliseconds a frame of sensing alone, in rounds that take turns ({rounds}; the last row of the
full measurement: one), and their ratio. *Start* is what the fast layer's first second costs once,
in milliseconds, when it meets all that stands still. Evaluating a frame of the scene, which both
need, is told beside it. Detectors update at 10 Hz, the scene runs at 24 fps. *Updates that
differ* compares what every detector said at every update.

"""

ACCURACY = """
### Accuracy of a range

Every ray of the home's seven detectors that meets a face, at some of the frames above, {rays} in
all, against the float64 intersection with the triangle that it meets. Errors in metres; the last
column is the worst error on the {apart} rays where the two are more than 1e-5 m apart.

| | rms | worst | worst where they differ |
|---|---|---|---|
| fast layer | {fast_rms_m:.1e} | {fast_m:.1e} | {apart_fast_m:.1e} |
| `scene.ray_cast` | {reference_rms_m:.1e} | {reference_m:.1e} | {apart_reference_m:.1e} |

`scene.ray_cast` takes a ray's start in world coordinates of single precision; 10 m from the
origin that moves it by half a micrometre, and a ray that grazes a face meets it many times
that sooner or later. The fast layer meets each object in the object's own space, where
numbers are smaller.
"""

COLUMNS: tuple[tuple[str, Callable[[dict[str, Any]], str]], ...] = (
    ("scene", lambda row: f"{row['scene']}"),
    ("objects", lambda row: f"{row['objects']}"),
    ("PIRs", lambda row: f"{row['pirs']}"),
    ("rays", lambda row: f"{row['rays']}"),
    ("sweep", lambda row: f"{row['sweep']}"),
    ("start", lambda row: f"{row['start_ms']:.0f}"),
    ("fast ms", lambda row: spread(row["fast_ms"])),
    ("reference ms", lambda row: spread(row["reference_ms"])),
    ("evaluation ms", lambda row: f"{row['evaluation_ms']:.2f}"),
    ("ratio", lambda row: spread(row["ratio"])),
    ("worst range difference m", lambda row: f"{row['worst_range_error_m']:.1e}"),
    ("updates that differ", lambda row: f"{row['updates_that_differ']} of {row['updates']}"),
)


def section(data: dict[str, Any]) -> str:
    layer = data["ray_layer"]
    text = INTRODUCTION.format(**layer)
    text += _line(name for name, _ in COLUMNS) + _line("---" for _ in COLUMNS)
    text += "".join(_line(cell(row) for _, cell in COLUMNS) for row in layer["rows"])
    if len({row["pirs"] for row in layer["rows"]}) > 1:
        text += "\n" + _cost_of_a_detector(layer["rows"])
    return text + ACCURACY.format(**data["ray_accuracy"])


def headline(data: dict[str, Any]) -> list[str]:
    ratios = [median(row["ratio"]) for row in data["ray_layer"]["rows"]]
    differ = sum(row["updates_that_differ"] for row in data["ray_layer"]["rows"])
    return [
        f"The ray layer is {short(min(ratios), 2)} to {short(max(ratios), 2)} times as fast as "
        f"Blender's `scene.ray_cast` in the same run; {differ} updates differ."
    ]


def _line(cells: Iterable[str]) -> str:
    return f"| {' | '.join(cells)} |\n"


def _cost_of_a_detector(rows: list[dict[str, Any]]) -> str:
    """What each further detector adds, from the fewest to the most."""
    lines = ["A further detector costs, in milliseconds a frame:", ""]
    lines += ["| rays | fast | reference |", "|---|---|---|"]
    for rays in sorted({row["rays"] for row in rows}):
        same = [
            row
            for row in rows
            if row["rays"] == rays and row["sweep"] == "SAWTOOTH" and row["scene"] == "Ängen home"
        ]
        few, many = min(same, key=_pirs), max(same, key=_pirs)
        if few is not many:
            added = many["pirs"] - few["pirs"]
            fast = (median(many["fast_ms"]) - median(few["fast_ms"])) / added
            slow = (median(many["reference_ms"]) - median(few["reference_ms"])) / added
            lines.append(f"| {rays} | {fast:.3f} | {slow:.2f} |")
    return "\n".join(lines) + "\n"


def _pirs(row: dict[str, Any]) -> int:
    return int(row["pirs"])
