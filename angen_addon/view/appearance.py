# SPDX-License-Identifier: GPL-3.0-or-later
"""What a kind of sensor looks like in Blender, and what Blender's windows say of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from ..authoring.housing import Housing
from ..authoring.placing import Stand, looking_out
from .explain.facts import Explanation
from .explain.plain import explain_plainly
from .explain.replay import Replay
from .overlay.figures import Figure, plain_figure
from .sight import Rays, Sight


def own_rays(sight: Sight, metres: float) -> Rays:
    """The rays that its model casts."""
    return sight.rays


def nothing(layout: Any, context: Any, sensor: Any, seen: Any) -> None:
    """Draws no rows."""


def no_figure(pose: Any, fields: Mapping[str, Any], metres: float) -> None:
    """Draws nothing of a reading."""


def nothing_lacking(replay: Replay, index: int, found: Explanation) -> Explanation:
    return found


def never(parameters: Any) -> bool:
    return False


@dataclass(frozen=True)
class Appearance:
    """Each part has a default, which a kind replaces with what is its own.

    `housings`: what makes the body of a preset's part, of "" for all others; else a cube.
    `stand`: which way it looks on a surface; else out of it.
    `rays`, `plan_rays`: what viewport and plan draw it to see with; else what it casts.
    `figure`: these rays and what they met (a field.Seen) as lines; else beams, without rays a
    cross. `reading_figure`: what a reading with the `drawn_fields` adds to that.
    `scans`: with which parameters it looks along one row of its rays after the other, and
    `scan_figure`: the row that is its turn; `lit_figure`: what moved there.
    `outlined`: the upper side of its body is what it senses with.
    `explain`: why an update is as it is; else its fields and parameters. `lacking`: that with what
    would have to change for one that is not active to be so.
    `sections`: titles, and names of parameters, of what its panel has in sections of which the
    first is open. `details`: what its panel shows besides: warnings, the reading in full.
    """

    housings: Mapping[str, Callable[[], Housing]] = field(default_factory=dict)
    stand: Stand = looking_out
    rays: Callable[[Sight, float], Rays] = own_rays
    plan_rays: Callable[[Sight, float], Rays] = own_rays
    figure: Callable[[Any, float], Figure] = plain_figure
    reading_figure: Callable[[Any, Mapping[str, Any], float], Figure | None] = no_figure
    drawn_fields: tuple[str, ...] = ()
    scans: Callable[[Any], bool] = never
    scan_figure: Callable[[Any, float], Figure] = plain_figure
    lit_figure: Callable[[Any, float], Figure] = plain_figure
    outlined: bool = False
    explain: Callable[[Replay, int], Explanation] = explain_plainly
    lacking: Callable[[Replay, int, Explanation], Explanation] = nothing_lacking
    sections: tuple[tuple[str, tuple[str, ...]], ...] = ()
    details: Callable[[Any, Any, Any, Any], None] = nothing
