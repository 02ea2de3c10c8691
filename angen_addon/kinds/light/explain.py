# SPDX-License-Identifier: GPL-3.0-or-later
"""Explains the reading of a light sensor: the share of each lamp, and the lamp that changed."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from weakref import WeakKeyDictionary

from ....sensor_logic.kind import Field
from ....sensor_logic.wording import quoted
from ...explain.facts import Explanation, at_frame, more_needed
from ...explain.lamps import LampShare, LightParts, light_parts
from ...explain.replay import Replay
from ...runtime.probes import Probes
from ...runtime.time_base import evaluated_depsgraph

LAMPS_SHOWN = 6
SHADOWED_SHOWN = 3
# Shares of the whole light below this get no line.
LITTLE = 1e-3
_last: WeakKeyDictionary[Probes, dict[str, tuple[tuple[int, int], LightParts | None]]] = (
    WeakKeyDictionary()
)


@dataclass(frozen=True)
class LightCause:
    """The parts of the light at the update and at the one before, if any, in the unit of
    `field`."""

    now: LightParts
    before: LightParts | None
    field: Field

    @property
    def unit(self) -> str:
        return self.field.unit

    @property
    def because(self) -> str:
        """The lamp that changed most."""
        changed = _most_changed(self)
        return changed[1].name if changed is not None else ""


def lacking(replay: Replay, index: int, found: Explanation) -> Explanation:
    """Adds why the sensor is not lit, before the other facts."""
    if found.cause is None:
        return found
    light = replay.sensor.parameters
    level = light.threshold + light.hysteresis / 2
    value, unit = replay.track.value[index], replay.sensor.reading.unit
    return found.after([("To be lit", more_needed(level, value, unit))])


def explain_light(replay: Replay, index: int) -> Explanation:
    """Update `index` of a light sensor: its lamps by the closed forms. Raises SensorError."""
    track, sensor = replay.track, replay.sensor
    before = _parts(replay, index - 1) if index > 0 else None
    now = _parts(replay, index)
    if now is None:
        return replay.off(index)
    text = sensor.reading.text
    cause = LightCause(now, before, sensor.reading)
    engine = sensor.parameters.bl_rna.properties["engine"].enum_items
    used = engine[sensor.parameters.engine].name
    if sensor.parameters.engine == "DIRECT" and now.note:
        # The run renders with Cycles where the closed forms do not model something.
        used = "Cycles"
    facts = [
        ("Reading", f"{text(track.value[index])} ({used})"),
        ("Estimate", _estimate(cause)),
    ]
    if index > 0:
        when = at_frame(track.frames[index - 1], track.times[index - 1])
        facts.append(("Before", f"{text(track.value[index - 1])}, at {when}"))
    facts += _lamp_facts(cause)
    if now.note:
        facts.append(("Not estimated", now.note))
    word = sensor.kind.active_label if track.active[index] else sensor.kind.idle_label
    headline = f"{word}: {_headline(cause)}"
    return replay.explanation(index, headline, tuple(facts), "", cause)


def _parts(replay: Replay, index: int) -> LightParts | None:
    """Those of an update; the last of each sensor are kept as long as the probes live and nothing
    but frames changes: the next update asks for them again."""
    known, sensor = _last.setdefault(replay.probes, {}), replay.sensor.name
    when = replay.step(index), replay.probes.edits
    if sensor not in known or known[sensor][0] != when:
        pending, found = replay.take(index), None
        if pending is not None:
            solids, efficacy = replay.probes.caster.solids, replay.scene.angen_luminous_efficacy
            found = light_parts(solids, evaluated_depsgraph(), pending.request, efficacy)
        known[sensor] = when, found
    return known[sensor][1]


def _estimate(cause: LightCause) -> str:
    """Within what the sensor can read, as its reading is."""
    text, total = cause.field.text, cause.now.total
    shown = min(max(total, 0.0), 100.0 if cause.unit == "%" else inf)
    of = "direct light and one mean for the walls"
    if shown != total:
        of += f", which make {text(total)}"
    return f"about {text(shown)} ({of})"


def _lamp_facts(cause: LightCause) -> list[tuple[str, str]]:
    now, text = cause.now, cause.field.text
    whole = max(now.given, 1e-9)
    ordered = sorted(now.lamps.values(), key=lambda lamp: (-lamp.light, lamp.name))
    giving = [lamp for lamp in ordered if lamp.light > LITTLE * whole and not lamp.through]
    facts = [
        (lamp.name, f"{lamp.light / whole:.0%}: {text(lamp.light)}{_shade(lamp)}")
        for lamp in giving[:LAMPS_SHOWN]
    ]
    if len(giving) > LAMPS_SHOWN:
        left = sum(lamp.light for lamp in giving[LAMPS_SHOWN:])
        facts.append((f"{len(giving) - LAMPS_SHOWN} more", f"{left / whole:.0%}"))
    taking = [lamp for lamp in ordered if lamp.light < -LITTLE * whole and not lamp.through]
    for lamp in taking[::-1][:LAMPS_SHOWN]:
        away = f"takes {-lamp.light / whole:.0%} away: {text(lamp.light)}{_shade(lamp)}"
        facts.append((lamp.name, away))
    if abs(now.rest) > LITTLE * whole:
        facts.append(("Walls and sky", f"{now.rest / whole:.0%}: {text(now.rest)}"))
    others = [
        lamp
        for lamp in sorted(ordered, key=lambda lamp: (-abs(lamp.unshaded), lamp.name))
        if lamp not in giving and lamp not in taking and abs(lamp.unshaded) > LITTLE * whole
    ]
    facts += [(lamp.name, _behind(lamp)) for lamp in others if lamp.through]
    dark = [lamp for lamp in others if not lamp.through]
    for lamp in dark[:SHADOWED_SHOWN]:
        facts.append((lamp.name, f"nothing: shadowed by {quoted(lamp.blocker)}"))
    if len(dark) > SHADOWED_SHOWN:
        facts.append((f"{len(dark) - SHADOWED_SHOWN} more", "shadowed"))
    return facts


def _shade(lamp: LampShare) -> str:
    lost = 1.0 - lamp.light / lamp.unshaded if lamp.unshaded else 0.0
    if lost < 0.01:
        return ""
    by = f" by {quoted(lamp.blocker)}" if lamp.blocker else ""
    return f", {lost:.0%} of it shadowed{by}"


def _behind(lamp: LampShare) -> str:
    return f"behind {quoted(lamp.through)}, which lets a part of its light pass: no estimate"


def _headline(cause: LightCause) -> str:
    now, whole = cause.now, max(cause.now.given, 1e-9)
    changed = _most_changed(cause)
    if changed is not None:
        return _change(cause, *changed)
    most = max(now.lamps.values(), key=lambda lamp: lamp.light, default=None)
    if most is not None and most.through and most.unshaded > LITTLE * whole:
        return f"{quoted(most.name)} shines through {quoted(most.through)}"
    least = min(now.lamps.values(), key=lambda lamp: lamp.light, default=None)
    if least is not None and least.light < 0.0 and now.total <= LITTLE * whole:
        return f"{quoted(least.name)} takes the light away"
    if most is None or most.light <= LITTLE * whole:
        return "no lamp shines on it directly"
    return f"{quoted(most.name)} gives {most.light / whole:.0%} of the estimated light"


def _change(cause: LightCause, then: LampShare, now: LampShare) -> str:
    """How a lamp's light changed. The closed forms have no estimate for light that passes through
    an object."""
    name, text = quoted(now.name), cause.field.text
    if now.through and not then.through:
        return f"{name} is behind {quoted(now.through)} now, which lets a part of its light pass"
    if then.through and not now.through:
        return f"{name} is behind {quoted(then.through)} no more"
    if now.through:
        return f"{name}, behind {quoted(now.through)}, changed"
    return f"{name} changed from {text(then.light)} to {text(now.light)} of the estimate"


def _most_changed(cause: LightCause) -> tuple[LampShare, LampShare] | None:
    """The lamp whose part changed most since the update before: its part then and now."""
    if cause.before is None:
        return None
    then, now = cause.before.lamps, cause.now.lamps
    pairs = [
        (then.get(name, _nothing(name)), now.get(name, _nothing(name)))
        for name in sorted({*then, *now})
    ]
    best = max(pairs, key=lambda pair: _difference(*pair), default=None)
    least = LITTLE * max(cause.now.given, cause.before.given, 1e-9)
    return best if best is not None and _difference(*best) > 10 * least else None


def _nothing(name: str) -> LampShare:
    return LampShare(name, 0.0, 0.0, "", "")


def _difference(then: LampShare, now: LampShare) -> float:
    """The largest change of a lamp's part that is possible."""
    if bool(then.through) != bool(now.through):
        return max(then.unshaded, now.unshaded)
    if now.through:
        return abs(now.unshaded - then.unshaded)
    return abs(now.light - then.light)
