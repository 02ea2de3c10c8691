# SPDX-License-Identifier: GPL-3.0-or-later
"""How a kind of sensor looks in Blender, and what panels and explanations say of it."""

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


def model_rays(sight: Trace, metres: float) -> SensorRays:
    """Return the rays that the model casts."""
    return sight.rays(metres)


def no_rows(layout: Any, context: Any, sensor: Any, seen: Any) -> None:
    """Add no rows to the panel."""


def no_reading_figure(pose: Any, fields: Mapping[str, Any], metres: float) -> None:
    """Draw no figure for a reading."""


def no_more_facts(replay: Replay, index: int, found: Explanation) -> Explanation:
    """Return an explanation without further facts."""
    return found


def no_scan_figure(seen: Any, number: int, met: RaysMet, metres: float) -> None:
    """Draw no figure for the last update."""


def no_lit_figure(seen: Any, number: int, met: RaysMet, before: Any, metres: float) -> None:
    """Draw no figure for a change since the update before."""


@dataclass(frozen=True)
class Appearance:
    """The appearance of a kind. Each attribute has a default, which a kind may replace.

    Attributes
    ----------
    housings
        Functions that return the housing of a preset's part; "" for all other presets. Default: a
        cube.
    stand
        How a sensor is turned on a surface. Default: it looks away from the surface.
    plan_rays
        The rays that the floor plan shows. Default: the rays of the model.
    figure
        Draws a sensor (a `DrawnSensor`). Default: a cross if it casts no rays.
    rays_figure
        Draws a bundle of its rays, given the number of the bundle and its hits. Default: beams.
    scan_figure
        Draws a bundle that was cast at the last update.
    lit_figure
        Draws what moved in that bundle, given the ranges (n,) of the scan before.
    reading_figure
        Draws a reading that has the `drawn_fields`.
    drawn_fields
        Names of the fields that `reading_figure` needs.
    handles
        The handles to drag in 3D views.
    outlined
        Whether the sensor senses with the upper side of its body, which is then outlined.
    explain
        Explains an update. Default: its fields and parameters.
    lacking
        Adds to an explanation what would have to change for the output to be active.
    sections
        Titles of sections of the panel, each with the names of its parameters. The first is open.
    details
        Draws further rows of the panel: warnings, and the reading in full.
    """

    housings: Mapping[str, Callable[[], Housing]] = field(default_factory=dict)
    stand: Stand = looking_out
    plan_rays: Callable[[Trace, float], SensorRays] = model_rays
    figure: Callable[[Any, float], Figure] = plain_figure
    rays_figure: Callable[[Any, int, RaysMet, float], Figure] = beams
    scan_figure: Callable[[Any, int, RaysMet, float], Figure | None] = no_scan_figure
    lit_figure: Callable[[Any, int, RaysMet, Any, float], Figure | None] = no_lit_figure
    reading_figure: Callable[[Any, Mapping[str, Any], float], Figure | None] = no_reading_figure
    drawn_fields: tuple[str, ...] = ()
    handles: tuple[Handle | SizeHandle, ...] = ()
    outlined: bool = False
    explain: Callable[[Replay, int], Explanation] = explain_plainly
    lacking: Callable[[Replay, int, Explanation], Explanation] = no_more_facts
    sections: tuple[tuple[str, tuple[str, ...]], ...] = ()
    details: Callable[[Any, Any, Any, Any], None] = no_rows
