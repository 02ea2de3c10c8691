# SPDX-License-Identifier: GPL-3.0-or-later
"""The ray layer's section of the benchmark page, from data."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

INTRODUCTION = """\
## The ray layer

The fast layer against Blender's own `scene.ray_cast`, on the same {frames} frames in one process:
milliseconds a frame of sensing alone, median of the rounds ({rounds}; the last row: one), and
their ratio with its spread. *Start* is what the fast layer's first second costs once, in
milliseconds, when it meets all that stands still. Evaluating a frame of the scene, which both
need, is told beside it. Detectors update at 10 Hz, the scene runs at 24 fps. *Updates that
differ* compares what every detector said at every update.

"""

ACCURACY = """
## Accuracy of a range

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

COLUMNS = (
    ("scene", "{scene}"),
    ("objects", "{objects}"),
    ("PIRs", "{pirs}"),
    ("rays", "{rays}"),
    ("sweep", "{sweep}"),
    ("start", "{start_ms:.0f}"),
    ("fast ms", "{fast_ms:.3f}"),
    ("reference ms", "{reference_ms:.2f}"),
    ("evaluation ms", "{evaluation_ms:.2f}"),
    ("ratio (spread)", "{ratio:.1f} ({ratio_low:.1f}–{ratio_high:.1f})"),
    ("worst range difference m", "{worst_range_error_m:.1e}"),
    ("updates that differ", "{updates_that_differ} of {updates}"),
)


def section(data: dict[str, Any]) -> str:
    layer = data["ray_layer"]
    text = INTRODUCTION.format(**layer)
    text += _line(name for name, _ in COLUMNS) + _line("---" for _ in COLUMNS)
    text += "".join(_line(form.format(**row) for _, form in COLUMNS) for row in layer["rows"])
    if len({row["pirs"] for row in layer["rows"]}) > 1:
        text += "\n" + _cost_of_a_detector(layer["rows"])
    return text + ACCURACY.format(**data["ray_accuracy"])


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
            fast = (many["fast_ms"] - few["fast_ms"]) / added
            slow = (many["reference_ms"] - few["reference_ms"]) / added
            lines.append(f"| {rays} | {fast:.3f} | {slow:.2f} |")
    return "\n".join(lines) + "\n"


def _pirs(row: dict[str, Any]) -> int:
    return int(row["pirs"])
