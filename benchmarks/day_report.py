# SPDX-License-Identifier: GPL-3.0-or-later
"""A day in the home: the section of the page, from data."""

from __future__ import annotations

from typing import Any

from .tables import columns, short

TEXT = """\
## A day

{seconds} s of the home, whose story of 172 s is told every {every} s; else nothing moves. The scene
is evaluated where keys, strips of the NLA or anything else that may follow the frame can change
something; the steps between are sensed at once. *Evaluated*: the share of the steps at which it
was; *over evaluation alone*: the run over Blender's evaluation of these; *memory*: the most that
the process had, Blender's own included.

{cases}
Where nothing moves is found in {strips_s} s where the story is repeated by strips of the NLA, and
in {keys_s} s where it is by keys, which take {keys_mib} MiB. The first {checked} s, evaluated at
every step, take {plain} s instead of {skipping} s; {same} of {sensors} tracks are the same to the
bit.
"""


def section(data: dict[str, Any]) -> str:
    forms = {row["form"]: row for row in data["forms"]}
    cases = [
        {
            **row,
            "share": row["evaluated"] / row["steps"],
            "over": row["wall_s"] / row["evaluation_alone_s"],
            "speed": data["seconds"] / row["wall_s"],
        }
        for row in data["cases"]
    ]
    checked = data["checked"]
    return TEXT.format(
        seconds=f"{data['seconds']:,}",
        every=f"{data['every_s']:,}",
        cases=columns(
            cases,
            "sensors=name",
            "readings=readings:,",
            "real time s=wall_s:.1f",
            "speed=speed:.0f",
            "evaluated=share:percent",
            "over evaluation alone=over:.2f times",
            "memory MiB=most_mib:.0f",
            "recording MiB=tracks_mib:.1f",
        ),
        strips_s=short(forms["strips"]["find_s"], 2),
        keys_s=short(forms["keys"]["find_s"], 2),
        keys_mib=f"{forms['keys']['scene_mib']:.0f}",
        checked=f"{checked['seconds']:,}",
        same=checked["same"],
        sensors=checked["sensors"],
        plain=short(checked["plain_s"]),
        skipping=short(checked["skipping_s"]),
    )
