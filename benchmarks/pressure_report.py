# SPDX-License-Identifier: GPL-3.0-or-later
"""The tables of docs/pressure.md and the pressure sensor's section of the benchmark page, from
data.

It needs no Blender: `python -m benchmarks.pressure_report` writes them again from the last data.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from .plot import BLACK, BLUE, GREEN, ORANGE, PURPLE, Panel, Series, figure
from .tables import columns, filled_in, table

COLOURS = (BLUE, ORANGE, GREEN, PURPLE)
DOCS = Path(__file__).resolve().parent.parent / "docs"
PAGE, DATA = DOCS / "pressure.md", DOCS / "data" / "pressure.json"
FIGURE = "pressure_table.svg"
COMMAND = "python -m benchmarks --only pressure"
GROUPS = {
    "rest": "Resting and stacked",
    "four legs": "Four legs, the worst of them",
    "sitter": "Animated sitter, the worst leg, and the sum",
    "drop": "Impulse of a drop",
    "moving": "Moving",
    "shapes": "Collision shapes, at rest",
    "extremes": "Extremes, at rest",
    "piles": "Random piles, sum against the weight",
}


def left_out(data: dict[str, Any]) -> list[str]:
    """The engines that this run left out, as texts."""
    return [] if data["mujoco"] else ["the same scenes in MuJoCo, which is not installed"]


def section(data: dict[str, Any]) -> str:
    """The pressure sensor's section of the benchmark page."""
    rows = data["accuracy"]
    resting = [row for row in rows if row["group"] in {"rest", "extremes"}]
    drops = [row for row in rows if row["group"] == "drop"]
    return (
        "## The pressure sensor\n\n"
        f"{len(rows)} scenes against closed forms: at rest within "
        f"{_percent(max(row['error'] for row in resting))}, impulses of drops within "
        f"{_percent(max(row['error'] for row in drops))}, legs of the sample's table within "
        f"{data['table']['worst_newtons']:.2g} N. All of it: [pressure.md](pressure.md).\n\n"
        + tables(data)["speed"]
    )


def tables(data: dict[str, Any]) -> dict[str, str]:
    """The tables by the name of their markers."""
    speed = data["speed"]
    island = table(
        ("bodies in the island", "ms a frame", "slowest frame", "worst error", "valid"),
        ((f"{row['bodies']}", *_cost(row)) for row in speed["island"]),
    )
    scene = table(
        ("bodies elsewhere", "ms a frame", "slowest frame", "worst error", "valid"),
        ((f"{row['elsewhere']}", *_cost(row)) for row in speed["scene"]),
    )
    return {
        "accuracy": _accuracy(data),
        "resistor": _resistor(data["resistor"]),
        "speed": f"Machine: {data['machine']}. Median of {speed['frames']} frames of one pad.\n\n"
        + island
        + "\nOne box on the pad, and others that lie about:\n\n"
        + scene,
        "table": f"![Force under four legs as a weight moves over the table]"
        f"(pictures/{FIGURE})\n\nLargest difference from the exact curves: "
        f"{data['table']['worst_newtons']:.2g} N, {_percent(data['table']['worst_share'])}, in "
        f"{data['table']['valid']} valid updates of each leg.\n",
    }


def _cost(row: dict[str, Any]) -> tuple[str, ...]:
    return (
        f"{row['ms']:.1f}",
        f"{row['ms_worst']:.1f}",
        _percent(row["error"]),
        f"{row['valid']} of {row['updates']}",
    )


def _accuracy(data: dict[str, Any]) -> str:
    text = ""
    for group, title in GROUPS.items():
        rows = [row for row in data["accuracy"] if row["group"] == group]
        if not rows:
            continue
        text += f"**{title}**\n\n"
        text += table(
            ("scene", "exact", "error", "from MuJoCo", "valid", "residual"),
            (
                (
                    row["scene"],
                    f"{_numbers(row['exact'])} {row['unit']}",
                    _error(row),
                    "—" if row["mujoco"] is None else _percent(row["mujoco"]),
                    f"{row['valid']} of {row['updates']}",
                    f"{row['residual']:.0e}",
                )
                for row in rows
            ),
        )
        text += "\n"
    if not data["mujoco"]:
        text += "MuJoCo was not installed for this run.\n"
    return text


def _error(row: dict[str, Any]) -> str:
    newtons = row.get("error_newtons")
    return _percent(row["error"]) + ("" if newtons is None else f" ({newtons:.2g} N)")


def _numbers(values: Iterable[float]) -> str:
    return " / ".join(f"{value:.5g}" for value in values)


def _percent(share: float) -> str:
    """A share in percent with two digits, or "< 0.001 %"."""
    if math.isnan(share):
        return "none"
    return "< 0.001 %" if share < 1e-5 else f"{100.0 * share:.2g} %"


def _resistor(rows: list[dict[str, Any]]) -> str:
    shown = [{**row, "hand": "" if row["by_hand"] is None else row["by_hand"]} for row in rows]
    return columns(
        shown,
        "force N=force_n:g",
        "resistance Ω=resistance_ohm:.0f",
        "divider V=voltage_v:.3f",
        "ADC=adc",
        "by hand=hand",
    )


def filled(page: str, data: dict[str, Any]) -> str:
    """docs/pressure.md with new tables."""
    return filled_in(page, COMMAND, tables(data))


def figures(data: dict[str, Any]) -> dict[str, str]:
    """The plot of measured (dots) and exact (lines) forces, with their difference below."""
    data = data["table"]
    time = data["time_s"]
    shown = [i for i, known in enumerate(data["known"]) if known]
    forces, residuals = [], []
    for colour, leg in zip(COLOURS, data["exact"], strict=True):
        exact, measured = data["exact"][leg], data["measured"][leg]
        forces.append(Series(leg, time, exact, colour))
        dots = shown[::4]
        forces.append(
            Series("", [time[i] for i in dots], [measured[i] for i in dots], colour, "dots")
        )
        off = [measured[i] - exact[i] for i in shown]
        residuals.append(Series("", [time[i] for i in shown], off, colour))
    residuals.append(Series("", [time[0], time[-1]], [0.0, 0.0], BLACK, "thin"))
    title = (
        f"A weight of {data['weight_kg']:g} kg moves from leg to leg of a table "
        f"of {data['table_kg']:g} kg"
    )
    top = Panel("force under the leg [N]", forces, 330, legend="lines: exact\ndots: measured")
    below = Panel("measured − exact [N]", residuals, 120, least=0.002)
    return {FIGURE: figure(title, "time [s]", [top, below])}


def write(data: dict[str, Any]) -> None:
    """Writes the data and the tables."""
    DATA.write_text(dumped(data), encoding="utf-8")
    PAGE.write_text(filled(PAGE.read_text(encoding="utf-8"), data), encoding="utf-8")


def dumped(data: dict[str, Any]) -> str:
    """JSON with one line for each innermost list, for readable diffs."""
    text = json.dumps(data, indent=1, ensure_ascii=False)
    return re.sub(r"\[[^][{}]*\]", lambda m: re.sub(r"\s*\n\s*", " ", m[0]), text) + "\n"


if __name__ == "__main__":
    write(json.loads(DATA.read_text(encoding="utf-8")))
