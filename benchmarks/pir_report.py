# SPDX-License-Identifier: GPL-3.0-or-later
"""The motion detector's section of the page and its plot, from data."""

from __future__ import annotations

from typing import Any

from .plot import BLACK, BLUE, GREEN, ORANGE, PURPLE, SKY, Panel, Series, figure
from .tables import percent, table

COLOURS = (BLUE, SKY, GREEN, PURPLE, ORANGE, BLACK)
TEXT = """\
## The motion detector

Detection, latency and false alarms by the settings of the range scan: {passes} passes of each
walker through a furnished room of 4.6 × 4 m, with the detector 2.2 m up in the middle of a wall.
Each setting has the same passes, each with another phase of the sweep. A cell shows the share of
passes detected, the median latency after the body starts, and the share of updates during the pass
that report motion (a NEMA walker stands still for most of it). Rays hit the bodies in closed form.
Where all {passes} passes were detected, the true share is above {least} with 97.5 % confidence. The
thesis's setting: 120 rays, one tilt of 10° per update (saw-tooth), 10 Hz, threshold 0.05 m.

Walkers: NEMA WD 7's person at 4 ft/s who stops for 2 s after every 3 ft; the same without stops;
0.3 m/s; a child of 1.05 m at 0.8 m/s; a cat at 0.5 m/s; NEMA's minor motion, an arm of
3 × 3 × 15 in, 36 in up, turned by 90° in a second and back.

{chosen}
**Recommended where a reading must be trusted:** 160 rays, all tilts, 5° apart, 10 Hz, threshold
0.05 m (with noise σ: at least 7·σ·√2). {missed}

{picture}One setting changed at a time, from the thesis's:

{groups}
False alarms: how often noise on the ranges turns the output on in an empty room, counted
over {empty} and scaled to an hour, so that one false alarm counts as {one}; without noise there are
none. An output that noise keeps on throughout is one false alarm.
"""
PICTURE = "![Share of updates that report motion, over the rays](pictures/bench_pir.svg)\n\n"


def section(data: dict[str, Any]) -> str:
    rows = data["rows"]
    groups = list(dict.fromkeys(row["group"] for row in rows))
    # As long as an empty room is watched (benchmarks/pir.py).
    empty = 1 if data["quick"] else 10
    return TEXT.format(
        passes=data["passes"],
        empty=f"{empty} minute" if empty == 1 else f"{empty} minutes",
        one=60 // empty,
        least=percent(data["least_share"]),
        chosen=_table([row for row in rows if row["group"] == "chosen"]),
        missed=_missed(rows),
        picture=PICTURE if _panels(data) else "",
        groups="\n".join(
            f"*{group[0].upper()}{group[1:]}*\n\n"
            + _table([row for row in rows if row["group"] == group])
            for group in groups
            if group != "chosen"
        )
        or "(in the full measurement)\n",
    )


def _table(rows: list[dict[str, Any]]) -> str:
    walkers = list(rows[0]["walkers"])
    noisy = any(row["false_alarms_an_hour"] for row in rows)
    return table(
        ("setting", "rays a second", *walkers, *(["false alarms an hour"] if noisy else [])),
        (
            (
                row["name"],
                f"{row['rays_a_second']:.0f}",
                *(_cell(row["walkers"][name]) for name in walkers),
                *([f"{row['false_alarms_an_hour']:.0f}"] if noisy else []),
            )
            for row in rows
        ),
    )


def _cell(seen: dict[str, Any]) -> str:
    latency = "–" if seen["latency_s"] is None else f"{seen['latency_s']:.2f} s"
    return f"{percent(seen['detected'])}, {latency}, {percent(seen['said'])}"


def _missed(rows: list[dict[str, Any]]) -> str:
    """The passes and updates that the thesis's setting misses and the recommended one detects."""
    named = {row["name"]: row["walkers"] for row in rows if row["group"] == "chosen"}
    thesis, best = named["thesis"], named["recommended"]
    parts = []
    for walker, seen in thesis.items():
        other = best[walker]
        if seen["detected"] < other["detected"]:
            parts.append(
                f"{percent(seen['detected'])} of the passes of the {walker} instead of "
                f"{percent(other['detected'])}"
            )
    said = [(w, s["said"] / best[w]["said"]) for w, s in thesis.items() if best[w]["said"]]
    least, most = min(said, key=lambda pair: pair[1]), max(said, key=lambda pair: pair[1])
    text = "The thesis's setting detects " + ("; ".join(parts) if parts else "as many passes")
    return (
        f"{text}. It reports motion at {percent(least[1])} ({least[0]}) to {percent(most[1])} "
        f"({most[0]}) of the updates at which the recommended one does: its output flickers, and "
        "it can miss a movement shorter than a sweep of 0.9 s."
    )


def figures(data: dict[str, Any]) -> dict[str, str]:
    title = "Share of updates that report motion"
    panels = _panels(data)
    return {"bench_pir.svg": figure(title, "rays of a fan", panels, log_x=True)} if panels else {}


def _panels(data: dict[str, Any]) -> list[Panel]:
    panels = []
    for group in ("rays, all tilts", "rays, saw-tooth"):
        rows = [row for row in data["rows"] if row["group"] == group]
        if not rows:
            # A quick measurement does not vary the rays.
            continue
        rays = [int(row["name"]) for row in rows]
        panels.append(
            Panel(
                f"{group[6:]}: motion, %",
                [
                    Series(name, rays, [100 * row["walkers"][name]["said"] for row in rows], colour)
                    for name, colour in zip(rows[0]["walkers"], COLOURS, strict=True)
                ],
                220,
            )
        )
    return panels
