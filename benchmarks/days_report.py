# SPDX-License-Identifier: GPL-3.0-or-later
"""Days of a routine in the home: the section of the page, from data."""

from __future__ import annotations

from typing import Any

from .tables import columns, short

TEXT = """\
## Days of a routine

Days from 2026-03-02 on, or a stretch of one, of somebody who lives alone in the sample home
(`sample_blends/week.toml`), with the cause of every event and the truth beside it, in one process.
*Took*: seconds of real time for one of them; *moving*: the share of the time in which anything
does; *evaluated*: the share of the steps at which the scene was; *memory*: the most that the
process ever had, Blender's own included.

{cases}
Random stretches of a week in both sample homes, together {checked} s and two minutes before each,
take {skipping} s, and {plain} s where every frame is evaluated with all keys at once. {same} of
{sensors} tracks are the same to the bit. The stretches: {stretches}.
"""


def section(data: dict[str, Any]) -> str:
    checked = data["checked"]
    cases = [
        {
            **row,
            "each": sum(row["day_s"]) / len(row["day_s"]),
            "a_day": sum(row["events"]) // row["days"],
            "moves": sum(row["moving"]) / row["days"],
            "share": row["evaluated"] / row["steps"],
        }
        for row in data["cases"]
    ]
    return TEXT.format(
        cases=columns(
            cases,
            "sensors=name",
            "days=days",
            "of s=seconds:,.0f",
            "took s=each:.0f",
            "events=a_day:,",
            "moving=moves:percent",
            "evaluated=share:percent",
            "memory MiB=most_mib:.0f",
        ),
        checked=f"{checked['seconds']:,.0f}",
        plain=short(checked["plain_s"]),
        skipping=short(checked["skipping_s"]),
        same=checked["same"],
        stretches="; ".join(checked["stretches"]),
        sensors=checked["sensors"],
    )
