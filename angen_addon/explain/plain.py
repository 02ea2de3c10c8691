# SPDX-License-Identifier: GPL-3.0-or-later
"""The explanation of any sensor: what it published at an update, and with which parameters."""

from __future__ import annotations

from ...sensor_logic.kind import RAYS
from ...sensor_logic.parameters import is_chosen, specs, value_text
from ...sensor_logic.wording import quoted
from .facts import Explanation, Facts
from .replay import Replay


def explain_plainly(replay: Replay, index: int) -> Explanation:
    """Update `index` of a sensor of a kind that tells no more of itself. Raises AngenError."""
    pending, kind = replay.take(index), replay.sensor.kind
    if pending is None:
        return replay.off(index)
    track, lengths = replay.track, replay.lengths
    facts: Facts = []
    for field in kind.samples:
        value = track.columns[field.name][index]
        text = field.text(value, lengths) if field.type is float else str(value)
        facts.append((field.name, ("yes" if value else "no") if field.type is bool else text))
    if list(kind.needs) == [RAYS]:
        pending.reading()
        facts.append(("Nearest", _nearest(replay)))
    for name, spec in specs(kind.parameters).items():
        if is_chosen(pending.parameters, spec.used_when):
            value = getattr(pending.parameters, name)
            facts.append(
                (
                    spec.label,
                    value_text(value, spec, kind.unit_of(spec, pending.parameters), lengths),
                )
            )
    word = kind.active_label if track.active[index] else kind.idle_label
    reading = track.reading_at(index).text(track.value[index], lengths)
    return replay.explanation(index, f"{word}: {reading}", facts)


def _nearest(replay: Replay) -> str:
    """The object that the sensor's rays met first."""
    ranges, names = replay.seen
    met = [(length, name) for length, name in zip(ranges.tolist(), names, strict=True) if name]
    if not met:
        return "nothing"
    length, name = min(met)
    return f"{quoted(name)}, {replay.lengths.text(length * replay.metres)} away"
