# SPDX-License-Identifier: GPL-3.0-or-later
"""The ray layer's section of the benchmark page, from data."""

from __future__ import annotations

from typing import Any

from .tables import columns, median, short

INTRODUCTION = """\
## The ray layer

The fast ray layer compared with Blender's own `scene.ray_cast`, on the same {frames} frames in one
process: milliseconds per frame of sensing alone, in alternating rounds ({rounds}; in the last row
of the full measurement one), and their ratio. *Start*: the milliseconds that the fast layer spends
once in its first second on everything that stands still. *Evaluation*: Blender's evaluation of a
frame, which both need. Detectors update at 10 Hz, the scene runs at 24 fps. *Updates that differ*
compares the output of every detector at every update.

"""

ACCURACY = """
### Accuracy of a range

All {rays} rays of the home's seven detectors that hit a face, at some of the frames above, compared
with the float64 intersection of the same triangle. Errors in metres; the last column is the worst
error of the {apart} rays where the two layers differ by more than 1e-5 m.

| | rms | worst | worst where they differ |
|---|---|---|---|
| fast layer | {fast_rms_m:.1e} | {fast_m:.1e} | {apart_fast_m:.1e} |
| `scene.ray_cast` | {reference_rms_m:.1e} | {reference_m:.1e} | {apart_reference_m:.1e} |

`scene.ray_cast` gets a ray's start in world coordinates of single precision; 10 m from the origin
that moves the start by half a micrometre, and the hit of a ray that grazes a face by many times
that. The fast layer intersects each object in its local space, where numbers are smaller.
"""

COLUMNS = (
    "scene",
    "objects",
    "PIRs=pirs",
    "rays",
    "sweep",
    "start=start_ms:.0f",
    "fast ms=fast_ms:spread",
    "reference ms=reference_ms:spread",
    "evaluation ms=evaluation_ms:.2f",
    "ratio=ratio:spread",
    "worst range difference m=worst_range_error_m:.1e",
)


def section(data: dict[str, Any]) -> str:
    layer = data["ray_layer"]
    text = INTRODUCTION.format(**layer)
    rows = [
        {**row, "differ": f"{row['updates_that_differ']} of {row['updates']}"}
        for row in layer["rows"]
    ]
    text += columns(rows, *COLUMNS, "updates that differ=differ")
    if len({row["pirs"] for row in layer["rows"]}) > 1:
        text += "\n" + _cost_of_a_detector(layer["rows"])
    return text + ACCURACY.format(**data["ray_accuracy"])


def ratios(data: dict[str, Any]) -> list[tuple[str, str, str]]:
    found = [median(row["ratio"]) for row in data["ray_layer"]["rows"]]
    fast = f"{short(min(found), 2)} to {short(max(found), 2)} times as fast"
    return [("the rays of detectors", "Blender's `scene.ray_cast`", fast)]


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
