# SPDX-License-Identifier: GPL-3.0-or-later
"""The section of the page on the growth of cost and memory, and its plots, from data."""

from __future__ import annotations

import math
from typing import Any

from .plot import BLUE, GREEN, ORANGE, PURPLE, Panel, Series, figure
from .tables import columns

TEXT = """\
## Growth

A hall with {objects} still objects of {triangles} triangles in all, one moving object, and
{sensors} motion detectors of the thesis over {frames} frames; one of these numbers varies at a
time, and each case runs in its own process. Milliseconds per update step: *sensing* by this
extension, *evaluation* by Blender. *Start*: the cost of the first second. *Scene*: Blender's memory
for the scene in MiB; *run*: the most that the run adds, recording included. *Exponent*: the power
of the number by which the time grows from the row above; 1 is proportional. Exponents above 1.2 are
marked.

{sweeps}
**A recording of {hours:.0f} h** of the home's 22 sensors at the thesis's rates, {rows} readings:
{mib:.0f} MiB, filled in {fill_s:.1f} s; its event log written in {events_s:.1f} s
({events_mib:.1f} MiB); packed for the blend file in {save_s:.1f} s ({file_mib:.1f} MiB), and
read from it in {load_s:.1f} s.
"""
COLUMNS = ("sensing_ms", "evaluation_ms", "start_ms", "scene_mib", "run_mib")
FASTER = 1.2
# ms: shorter times are dominated by noise, and get no exponent.
LEAST_MS = 0.05


def section(data: dict[str, Any]) -> str:
    recording = data["recording"]
    return TEXT.format(
        **data["base"],
        hours=recording["seconds"] / 3600,
        **recording,
        sweeps="\n".join(_sweep(name, rows) for name, rows in data["sweeps"].items()),
    )


def _sweep(name: str, rows: list[dict[str, Any]]) -> str:
    text = f"![Cost over the number of {name}](pictures/bench_growth_{name}.svg)\n\n"
    told = [
        {**row, "exponent": _exponent(rows[i - 1], row) if i else ""} for i, row in enumerate(rows)
    ]
    return text + columns(
        told,
        f"{name}=size",
        "sensing ms=sensing_ms:spread",
        "exponent",
        "evaluation ms=evaluation_ms:spread",
        "start ms=start_ms:spread",
        "scene MiB=scene_mib:median",
        "run MiB=run_mib:median",
    )


def _exponent(before: dict[str, Any], row: dict[str, Any]) -> str:
    few, many = before["sensing_ms"]["median"], row["sensing_ms"]["median"]
    if min(few, many) < LEAST_MS:
        return "–"
    power = math.log(many / few) / math.log(row["size"] / before["size"])
    return f"**{power:.2f}**" if power > FASTER else f"{power:.2f}"


def figures(data: dict[str, Any]) -> dict[str, str]:
    found = {}
    for name, rows in data["sweeps"].items():
        sizes = [row["size"] for row in rows]
        found[f"bench_growth_{name}.svg"] = figure(
            f"Cost over the number of {name}",
            name,
            [
                Panel(
                    "ms per update step",
                    [
                        _series("sensing", "sensing_ms", sizes, rows, ORANGE),
                        _series("evaluation", "evaluation_ms", sizes, rows, BLUE),
                    ],
                    180,
                    log=True,
                ),
                Panel(
                    "MiB",
                    [
                        _series("scene", "scene_mib", sizes, rows, GREEN),
                        _series("run", "run_mib", sizes, rows, PURPLE),
                    ],
                    150,
                    log=True,
                ),
            ],
            log_x=True,
        )
    return found


def _series(
    label: str, key: str, sizes: list[int], rows: list[dict[str, Any]], colour: str
) -> Series:
    return Series(label, sizes, [row[key]["median"] for row in rows], colour)
