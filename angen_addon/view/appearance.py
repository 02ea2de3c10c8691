# SPDX-License-Identifier: GPL-3.0-or-later
"""What a kind of sensor looks like in Blender, and what Blender's windows say of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from ..authoring.housing import Housing, Stand, looking_out
from ..explain.facts import Explanation
from ..explain.replay import Replay, explain_plainly
from ..runtime.trace import RaysMet, SensorRays, Trace
from .handles import Handle, SizeHandle
from .overlay.figures import Figure, beams, plain_figure


def own_rays(sight: Trace, metres: float) -> SensorRays:
    """The rays that its model casts."""
    return sight.rays(metres)


def nothing(layout: Any, context: Any, sensor: Any, seen: Any) -> None:
    """Draws no rows."""


def no_figure(pose: Any, fields: Mapping[str, Any], metres: float) -> None:
    """Draws nothing of a reading."""


def nothing_lacking(replay: Replay, index: int, found: Explanation) -> Explanation:
    return found


def no_scan(seen: Any, number: int, met: RaysMet, metres: float) -> None:
    """Draws nothing of the last update alone."""


def nothing_lit(seen: Any, number: int, met: RaysMet, before: Any, metres: float) -> None:
    """Draws nothing of what changed since the update before."""


@dataclass(frozen=True)
class Appearance:
    """Each part has a default, which a kind replaces with what is its own.

    `housings`: what makes the body of a preset's part, of "" for all others; else a cube.
    `stand`: which way it looks on a surface; else out of it.
    `plan_rays`: what the plan draws it to see with; else what it casts.
    `figure`: the sensor (a DrawnSensor) as lines; else a cross where it casts no rays.
    `rays_figure`: a bundle of its rays, by its number, and what they met; else beams.
    `scan_figure`: a bundle that it cast at its last update; `lit_figure`: what moved there, seen
    from the ranges (n,) that the bundle found before.
    `reading_figure`: what a reading with the `drawn_fields` adds to these.
    `handles`: what of it can be dragged in 3D views.
    `outlined`: the upper side of its body is what it senses with.
    `explain`: why an update is as it is; else its fields and parameters. `lacking`: that with what
    would have to change for one that is not active to be so.
    `sections`: titles, and names of parameters, of what its panel has in sections of which the
    first is open. `details`: what its panel shows besides: warnings, the reading in full.
    """

    housings: Mapping[str, Callable[[], Housing]] = field(default_factory=dict)
    stand: Stand = looking_out
    plan_rays: Callable[[Trace, float], SensorRays] = own_rays
    figure: Callable[[Any, float], Figure] = plain_figure
    rays_figure: Callable[[Any, int, RaysMet, float], Figure] = beams
    scan_figure: Callable[[Any, int, RaysMet, float], Figure | None] = no_scan
    lit_figure: Callable[[Any, int, RaysMet, Any, float], Figure | None] = nothing_lit
    reading_figure: Callable[[Any, Mapping[str, Any], float], Figure | None] = no_figure
    drawn_fields: tuple[str, ...] = ()
    handles: tuple[Handle | SizeHandle, ...] = ()
    outlined: bool = False
    explain: Callable[[Replay, int], Explanation] = explain_plainly
    lacking: Callable[[Replay, int, Explanation], Explanation] = nothing_lacking
    sections: tuple[tuple[str, tuple[str, ...]], ...] = ()
    details: Callable[[Any, Any, Any, Any], None] = nothing
