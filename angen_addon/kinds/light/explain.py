# SPDX-License-Identifier: GPL-3.0-or-later
"""Explains the reading of a light sensor: the share of each lamp, and the lamp that changed."""

from __future__ import annotations

from dataclasses import dataclass

from ....sensor_logic.kind import LIGHT, Field
from ....sensor_logic.model import LightSample, LightShare
from ....sensor_logic.wording import listed, named, quoted
from ...explain.facts import Explanation, Facts, at_frame, more_needed
from ...explain.replay import Replay

SHOWN = 6
# Shares of the whole light below this get no line.
LITTLE = 1e-3
# A share must change by this part of the whole light to be named.
NOTABLE = 0.01


@dataclass(frozen=True)
class LightCause:
    """The shares of the light at the update and at the one before, in the unit of `field`; empty
    where the engine does not tell lamps apart, or there was no update before."""

    now: tuple[LightShare, ...]
    before: tuple[LightShare, ...]
    field: Field

    @property
    def because(self) -> str:
        """The lamp that changed most."""
        changed = _most_changed(self)
        return changed[1].names[0] if changed is not None and changed[1].names else ""

    @property
    def given(self) -> float:
        """The light that comes, without what lamps of negative power take away again."""
        return max(sum(max(share.light, 0.0) for share in self.now), 1e-9)


def lacking(replay: Replay, index: int, found: Explanation) -> Explanation:
    """Adds why the sensor is not lit, before the other facts."""
    if found.cause is None:
        return found
    light = replay.sensor.parameters
    level = light.threshold + light.hysteresis / 2
    value, unit = replay.track.value[index], replay.sensor.reading.unit
    return found.after([("To be lit", more_needed(level, value, unit))])


def explain_light(replay: Replay, index: int) -> Explanation:
    """Explain update `index` of a light sensor by the light groups of its picture. Raises
    AngenError."""
    track, sensor, text = replay.track, replay.sensor, replay.sensor.reading.text
    before = _light(replay, index - 1) if index > 0 else None
    now = _light(replay, index)
    if now is None:
        return replay.off(index)
    cause = LightCause(now.shares or (), (before and before.shares) or (), sensor.reading)
    engines = sensor.parameters.bl_rna.properties["engine"].enum_items
    facts = [("Reading", f"{text(track.value[index])} ({engines[sensor.parameters.engine].name})")]
    if index > 0:
        when = at_frame(track.frames[index - 1], track.times[index - 1])
        facts.append(("Before", f"{text(track.value[index - 1])}, at {when}"))
    facts += _share_facts(cause)
    if now.note:
        facts.append(("Note", now.note))
    word = sensor.kind.active_label if track.active[index] else sensor.kind.idle_label
    return replay.explanation(index, f"{word}: {_headline(cause)}", tuple(facts), "", cause)


def _light(replay: Replay, index: int) -> LightSample | None:
    """Return the light of an update, without its shares where it is EEVEE's; None where the sensor
    is off."""
    taken = replay.take(index)
    if taken is None or taken.parameters.engine == "EEVEE":
        return None if taken is None else LightSample()
    replay.measure_light(taken)
    found: LightSample = taken.update.ask(LIGHT)
    return found


def _share_facts(cause: LightCause) -> Facts:
    """Return a line for each source that gives or takes light, and one for their sum."""
    if not cause.now:
        return []
    text, whole = cause.field.text, cause.given
    ordered = sorted(cause.now, key=lambda share: -share.light)
    giving = [share for share in ordered if share.light > LITTLE * whole]
    facts = [(_label(s), f"{s.light / whole:.0%}: {text(s.light)}") for s in giving[:SHOWN]]
    if len(giving) > SHOWN:
        left = sum(share.light for share in giving[SHOWN:])
        facts.append((f"{len(giving) - SHOWN} more", f"{left / whole:.0%}: {text(left)}"))
    taking = [share for share in ordered[::-1] if share.light < -LITTLE * whole]
    for share in taking[:SHOWN]:
        facts.append((_label(share), f"takes {-share.light / whole:.0%}: {text(share.light)}"))
    return [*facts, ("All light", text(sum(share.light for share in cause.now)))]


def _headline(cause: LightCause) -> str:
    if not cause.now:
        return "EEVEE cannot tell lamps apart, Cycles can"
    changed, text = _most_changed(cause), cause.field.text
    if changed is not None:
        then, now = changed
        return f"{_quoted(now)} changed from {text(then.light)} to {text(now.light)}"
    most = max(cause.now, key=lambda share: share.light)
    least = min(cause.now, key=lambda share: share.light)
    if least.light < 0.0 and sum(s.light for s in cause.now) <= LITTLE * cause.given:
        return f"{_quoted(least)} takes the light away"
    if most.light <= 0.0:
        return "no light reaches it"
    return f"{_quoted(most)} gives {most.light / cause.given:.0%} of the light"


def _most_changed(cause: LightCause) -> tuple[LightShare, LightShare] | None:
    """Return the share that changed most since the update before, then and now; None where none
    changed notably."""
    if not cause.before or not cause.now:
        return None
    then, now = ({(s.names, s.source): s for s in found} for found in (cause.before, cause.now))
    pairs = [
        (then.get(key, LightShare(*key, 0.0)), now.get(key, LightShare(*key, 0.0)))
        for key in dict.fromkeys([*now, *then])
    ]
    best = max(pairs, key=lambda pair: abs(pair[1].light - pair[0].light))
    whole = max(cause.given, sum(max(s.light, 0.0) for s in cause.before))
    return best if abs(best[1].light - best[0].light) > NOTABLE * whole else None


def _label(share: LightShare) -> str:
    return listed([*share.names], 2) if share.names else share.source


def _quoted(share: LightShare) -> str:
    return named(share.names, 2) if share.names else quoted(share.source)
