# SPDX-License-Identifier: GPL-3.0-or-later
"""Explains the reading of a distance sensor: its nearest zone, and what the rays there hit."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

from ....sensor_logic.kinds.distance.model import sigma
from ....sensor_logic.kinds.distance.parameters import DistanceParameters
from ....sensor_logic.wording import named, quoted
from ...explain.facts import Explanation, Facts, at_frame
from ...explain.replay import Replay

# m: if the recorded distance differs by more, the scene has changed.
TOLERANCE = 1e-6
NAMES_SHOWN = 3


@dataclass(frozen=True)
class DistanceCause:
    """`zone`: the nearest one, counted row by row from the upper left, or None; `met`: the objects
    that its rays hit with the number of rays, the most first; `distance` in m; `targets`: the
    number of zones that see something."""

    zone: int | None
    met: tuple[tuple[str, int], ...]
    distance: float
    targets: int

    @property
    def because(self) -> str:
        return self.met[0][0] if self.met else ""


def explain_distance(replay: Replay, index: int) -> Explanation:
    """Explains update `index` of a distance sensor. Raises AngenError."""
    pending = replay.take(index)
    if pending is None:
        return replay.off(index)
    parameters: DistanceParameters = pending.parameters
    reading = replay.runner.model.update(parameters, pending.update)
    cause = _cause(replay, parameters, reading.fields["zones_m"], reading.value)
    track, text = replay.track, replay.lengths.text
    recorded = float(track.value[index])
    doubt = ""
    if abs(recorded - cause.distance) > TOLERANCE:
        doubt = (
            f"{text(recorded)} was recorded, {text(cause.distance)} is found now: something has "
            "changed since. Simulate again"
        )
    facts = _facts(replay, parameters, cause)
    if index > 0:
        when = at_frame(track.frames[index - 1], track.times[index - 1])
        facts.append(("Before", f"{text(track.value[index - 1])}, at {when}"))
    word = replay.sensor.kind.active_label if track.active[index] else replay.sensor.kind.idle_label
    headline = f"{word}: {_headline(replay, parameters, cause)}"
    return replay.explanation(index, headline, facts, doubt, cause)


def _cause(
    replay: Replay, parameters: DistanceParameters, zones: str, distance: float
) -> DistanceCause:
    read = [float(text) if text else float("inf") for text in zones.split(";")]
    nearest = min(range(len(read)), key=lambda zone: read[zone])
    targets = sum(value < float("inf") for value in read)
    if not targets:
        return DistanceCause(None, (), distance, 0)
    rays = parameters.rays**2
    names = replay.seen.names[nearest * rays : (nearest + 1) * rays]
    met = Counter(name for name in names if name)
    return DistanceCause(nearest, tuple(met.most_common()), distance, targets)


def _facts(replay: Replay, parameters: DistanceParameters, cause: DistanceCause) -> Facts:
    lengths = replay.lengths
    limit = f"threshold {lengths.typed(parameters.threshold)}"
    facts = [("Distance", f"{lengths.text(cause.distance)}, {limit}")]
    zones = parameters.zones_across * parameters.zones_up
    if cause.zone is None:
        return [*facts, ("Seen", f"nothing within {lengths.typed(parameters.range_max)}")]
    if zones > 1:
        row, column = divmod(cause.zone, parameters.zones_across)
        where = f"row {row + 1} from above, column {column + 1} from the left"
        facts += [("Nearest zone", where), ("Zones that see", f"{cause.targets} of {zones}")]
    rays = parameters.rays**2
    met = [f"{quoted(name)} by {count} of {rays} rays" for name, count in cause.met[:NAMES_SHOWN]]
    facts.append(("It meets", ", ".join(met)))
    spread = float(sigma(parameters, cause.distance))
    if spread > 0.0:
        facts.append(("Noise", f"{lengths.text(spread)} (standard deviation) at this distance"))
    return facts


def _headline(replay: Replay, parameters: DistanceParameters, cause: DistanceCause) -> str:
    lengths = replay.lengths
    if cause.zone is None:
        return f"it sees nothing within {lengths.typed(parameters.range_max)}"
    what = named(name for name, _ in cause.met[:NAMES_SHOWN])
    return f"{what}, {lengths.text(cause.distance)} away"
