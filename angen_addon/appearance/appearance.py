# SPDX-License-Identifier: GPL-3.0-or-later
"""The functions that draw and explain each kind of sensor in Blender (`Appearance`)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from typing import Any

from ...sensor_logic.kind import Kind
from ..runtime.trace import CastRays, SensorRays, Trace
from .facts import Explanation
from .figures import Figure, beams, plain_figure
from .handles import Handle, SizeHandle
from .housing import Housing, Stand, looking_out
from .recorded import RecordedSensor, explain_plainly


def model_rays(sight: Trace, metres: float) -> SensorRays:
    """Return the rays that the model casts: the default of `Appearance.plan_rays`.

    `sight` is the `Trace` of the sensor's rays, and `metres` the length of a Blender unit in m.
    """
    return sight.rays(metres)


def no_rows(layout: Any, context: Any, sensor: Any, seen: Any) -> None:
    """Add no rows to the panel: the default of `Appearance.details`."""


def no_reading_figure(seen: Any, fields: Mapping[str, Any], metres: float) -> None:
    """Return no figure: the default of `Appearance.reading_figure`."""


def no_more_facts(recorded: RecordedSensor, index: int, found: Explanation) -> Explanation:
    """Return the explanation `found` unchanged: the default of `Appearance.lacking`."""
    return found


def no_scan_figure(seen: Any, number: int, cast: CastRays, metres: float) -> None:
    """Return no figure: the default of `Appearance.scan_figure`."""


def no_lit_figure(seen: Any, number: int, cast: CastRays, before: Any, metres: float) -> None:
    """Return no figure: the default of `Appearance.lit_figure`."""


@dataclass(frozen=True)
class Appearance:
    """The appearance of a kind of sensor. Each attribute has a default, which a kind may replace.

    The functions that draw get the sensor (a `DrawnSensor`) and return a `Figure` in world space.
    Some draw a bundle: rays that the sensor casts together. They also get the number of the bundle
    and its rays with their ranges (`CastRays`). The last parameter of each is the length of a
    Blender unit in m.

    Attributes
    ----------
    housings
        Functions that return a housing, by the identifier of a preset. The function for "" serves
        all presets without a function. Default: a cube.
    stand
        Function that orients a new sensor on a surface. Default: it looks away from the surface.
    plan_rays
        Function that returns the rays of the floor plan. Default: the rays of the model.
    figure
        Draws the sensor itself. Default: a cross if it casts no rays.
    rays_figure
        Draws a bundle of its rays. Default: a line for each ray.
    scan_figure
        Draws a bundle of rays that the sensor cast at its last update. Default: nothing.
    lit_figure
        Draws the rays of such a bundle that detected movement. It also gets the ranges (n,) of the
        scan before. Default: nothing.
    reading_figure
        Draws a reading from the sensor and the published fields. Default: nothing.
    drawn_fields
        Names of the fields that `reading_figure` needs.
    handles
        The handles to drag in 3D views.
    outlined
        Whether the view outlines the upper side of the body, as for a pad, which senses there.
    explain
        Explains an update. Default: it lists the fields and parameters.
    lacking
        Adds facts to an explanation: what must change until the output is active. Default: none.
    sections
        Titles of sections of the panel, each with the names of its parameters. The first is open.
    details
        Draws further rows of the panel: warnings, and the reading in full.
    """

    housings: Mapping[str, Callable[[], Housing]] = field(default_factory=dict)
    stand: Stand = looking_out
    plan_rays: Callable[[Trace, float], SensorRays] = model_rays
    figure: Callable[[Any, float], Figure] = plain_figure
    rays_figure: Callable[[Any, int, CastRays, float], Figure] = beams
    scan_figure: Callable[[Any, int, CastRays, float], Figure | None] = no_scan_figure
    lit_figure: Callable[[Any, int, CastRays, Any, float], Figure | None] = no_lit_figure
    reading_figure: Callable[[Any, Mapping[str, Any], float], Figure | None] = no_reading_figure
    drawn_fields: tuple[str, ...] = ()
    handles: tuple[Handle | SizeHandle, ...] = ()
    outlined: bool = False
    explain: Callable[[RecordedSensor, int], Explanation] = explain_plainly
    lacking: Callable[[RecordedSensor, int, Explanation], Explanation] = no_more_facts
    sections: tuple[tuple[str, tuple[str, ...]], ...] = ()
    details: Callable[[Any, Any, Any, Any], None] = no_rows


def appearance_of(kind: Kind) -> Appearance:
    """Return the appearance of a kind of sensor, from its module in `angen_addon.kinds`."""
    return _appearance(kind.attribute)


# Each of the many calls in a redraw takes 2.5 µs longer without the cache.
@cache
def _appearance(name: str) -> Appearance:
    # Imported here, because the modules of the kinds import this module.
    kinds = f"{__package__.rpartition('.')[0]}.kinds"
    if find_spec(f"{kinds}.{name}") is None:
        return Appearance()
    found: Appearance = import_module(f"{kinds}.{name}").APPEARANCE
    return found
