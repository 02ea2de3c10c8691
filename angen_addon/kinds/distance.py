# SPDX-License-Identifier: GPL-3.0-or-later
"""The appearance of distance sensors: housings, zones in the viewport, and explanations."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...sensor_logic.evidence import rows_of
from ...sensor_logic.geometry.pixels import pixel_corners
from ...sensor_logic.kinds.distance import DistanceParameters, sigma, zone_rays
from ...sensor_logic.logs.wording import named, quoted
from ...sensor_logic.model import Array, Pose
from ..appearance.appearance import Appearance
from ..appearance.facts import Explanation, Facts
from ..appearance.figures import Figure, corners_of, pairs
from ..appearance.handles import ahead, edge
from ..appearance.housing import Housing, looking, looking_level
from ..appearance.recorded import RecordedSensor
from ..runtime.trace import CastRays, SensorRays, Trace

NAMES_SHOWN = 3


@dataclass(frozen=True)
class DistanceCause:
    """The nearest zone of a distance sensor, which decides its reading.

    Attributes
    ----------
    zone
        The number of the nearest zone, counted row by row from the upper left; None without a hit.
    hits
        The objects that the rays of this zone hit, with their numbers of rays, in descending order.
    distance
        The distance of this zone in m.
    targets
        The number of zones with a hit.
    """

    zone: int | None
    hits: tuple[tuple[str, float], ...]
    distance: float
    targets: int


def explain_distance(recorded: RecordedSensor, index: int) -> Explanation:
    """Explain update `index` of a distance sensor by its nearest zone."""
    parameters: DistanceParameters = recorded.parameters_at(index)
    track, text = recorded.track, recorded.lengths.text
    zone = recorded.evidence("zone", index)
    cause = DistanceCause(
        zone if zone >= 0 else None,
        rows_of(recorded.evidence("hits", index)),
        float(track.value[index]),
        sum(map(bool, track.columns["zones_m"][index].split(";"))),
    )
    facts = _facts(recorded, parameters, cause)
    if index > 0:
        facts.append(("Before", f"{text(track.value[index - 1])}, at {recorded.when(index - 1)}"))
    headline = f"{recorded.word(index)}: {_headline(recorded, parameters, cause)}"
    return recorded.explanation(index, headline, facts, "", cause)


def _facts(recorded: RecordedSensor, parameters: DistanceParameters, cause: DistanceCause) -> Facts:
    lengths = recorded.lengths
    limit = f"threshold {lengths.typed(parameters.threshold)}"
    facts = [("Distance", f"{lengths.text(cause.distance)}, {limit}")]
    zones = parameters.zones_across * parameters.zones_up
    if cause.zone is None:
        return [*facts, ("Seen", f"nothing within {lengths.typed(parameters.range_max)}")]
    if zones > 1:
        row, column = divmod(cause.zone, parameters.zones_across)
        where = f"row {row + 1} from above, column {column + 1} from the left"
        facts += [("Nearest zone", where), ("Zones with a hit", f"{cause.targets} of {zones}")]
    rays = parameters.rays**2
    hits = [f"{quoted(name)} by {count} of {rays} rays" for name, count in cause.hits[:NAMES_SHOWN]]
    facts.append(("Hits", ", ".join(hits)))
    spread = float(sigma(parameters, cause.distance))
    if spread > 0.0:
        facts.append(("Noise", f"{lengths.text(spread)} (standard deviation) at this distance"))
    return facts


def _headline(
    recorded: RecordedSensor, parameters: DistanceParameters, cause: DistanceCause
) -> str:
    lengths = recorded.lengths
    if cause.zone is None:
        return f"nothing within {lengths.typed(parameters.range_max)}"
    what = named(name for name, _ in cause.hits[:NAMES_SHOWN])
    return f"{what}, {lengths.text(cause.distance)} away"


# Number of rays from side to side in the floor plan.
ACROSS = 25


def plan_rays(sight: Trace, metres: float) -> SensorRays:
    """Return a horizontal fan of rays for the floor plan, as wide as all zones together.

    `sight` is the `Trace` with the sensor's parameters and pose. `metres` is the length of a
    Blender unit in m.
    """
    wide = replace(sight.parameters, zones_across=1, zones_up=1, rays=ACROSS)
    origins, directions, reach = zone_rays(wide, sight.pose)
    level = slice(ACROSS * (ACROSS // 2), ACROSS * (ACROSS // 2 + 1))
    return SensorRays(origins[level] / metres, directions[level], reach[level] / metres)


def zones_figure(seen: Any, number: int, cast: CastRays, metres: float) -> Figure:
    """Draw a rectangle at the far end of each zone, and the four outer edges of the field of view.

    A rectangle is filled if all rays of its zone hit something. `seen` is the `DrawnSensor`, and
    `number` the number of the ray bundle. `cast` has the rays with their ranges. `metres` is the
    length of a Blender unit in m.
    """
    drawn = Figure()
    across, up = seen.parameters.zones_across, seen.parameters.zones_up
    corners = zone_corners(seen.parameters, seen.pose)
    ends = corners_of(cast, seen.pose.origin, corners, metres)
    hits = np.all((cast.ranges < cast.reach).reshape(len(corners), -1), axis=1).tolist()
    for zone, hit in zip(ends, hits, strict=True):
        edges = pairs(zone, np.roll(zone, -1, axis=0))
        drawn.add("outline" if hit else "limit", edges)
        if hit:
            drawn.fill("pad", (zone[[0, 1, 2]], zone[[0, 2, 3]]))
    outer = ((0, 0), (across - 1, 1), (across * up - 1, 2), (across * (up - 1), 3))
    for one, corner in outer:
        drawn.add("edge", (seen.pose.origin / metres, ends[one, corner]))
    return drawn


def zone_corners(parameters: Any, pose: Pose) -> Array:
    """Return unit vectors along the four edges of each zone in world space, shape (zones, 4, 3).

    The edges of a zone are in circular order, from the upper left one.
    """
    angles = parameters.horizontal_fov, parameters.vertical_fov
    return pixel_corners(pose.axes, angles, (parameters.zones_across, parameters.zones_up))


# Housings. The sizes of chips are from ST's data sheets; the boards have usual sizes.


def _chip(across: float, up: float, deep: float) -> Housing:
    """Return a chip of size `across`, `up` and `deep` (m) on a board of 25 × 18 mm."""
    x, y = across / 2, up / 2
    housing = Housing().box((-x, -y, 0.0), (x, y, deep))
    return looking(housing.box((-0.0125, -0.009, deep), (0.0125, 0.009, deep + 0.0016)))


def _hc_sr04() -> Housing:
    """Return a board of 45 × 20 × 15 mm with two transducers of 16 mm, 26 mm apart.

    The sizes are from hackster.io.
    """
    housing = Housing()
    for x in (-0.013, 0.013):
        barrel = Housing().lathe([(0.008, 0.0), (0.008, 0.012)])
        moved = [(px + x, py, pz) for px, py, pz in barrel.points]
        first = len(housing.points)
        housing.points += moved
        housing.faces += [tuple(first + i for i in face) for face in barrel.faces]
    return looking(housing.box((-0.0225, -0.01, 0.012), (0.0225, 0.01, 0.015)))


HOUSINGS = {
    "": lambda: _chip(0.0049, 0.0025, 0.00156),
    "VL53L0X": lambda: _chip(0.0044, 0.0024, 0.001),
    "VL53L5CX": lambda: _chip(0.0064, 0.003, 0.0015),
    "HC_SR04": _hc_sr04,
}


APPEARANCE = Appearance(
    HOUSINGS,
    looking_level,
    plan_rays,
    rays_figure=zones_figure,
    handles=(
        ahead("range_max"),
        ahead("threshold"),
        edge("horizontal_fov", (1.0, 0.0), 0.5),
        edge("vertical_fov", (0.0, 1.0), 0.5),
    ),
    explain=explain_distance,
)
