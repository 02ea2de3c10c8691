# SPDX-License-Identifier: GPL-3.0-or-later
"""What a sensor reads at the playhead, in words: `playhead` says what, and where it comes from.

States differ by icon and by word, never by colour alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from ..angen_addon.runtime import playhead, state
from ..angen_addon.runtime.playhead import Playhead, Told
from ..angen_addon.scene.sensors import Sensor
from ..angen_addon.scene.units import lengths_of
from ..sensor_logic.kind import Field, Kind
from ..sensor_logic.model import NOT_YET, Reading
from ..sensor_logic.physics.output_timing import waiting
from ..sensor_logic.quantities import NOTHING
from ..sensor_logic.wording import capital

ACTIVE, IDLE, OFF, DOUBTFUL, WRONG = "RADIOBUT_ON", "RADIOBUT_OFF", "X", "QUESTION", "ERROR"
UNKNOWN, OLD, BAKED, NOT_SURE = "DOT", "TIME", "KEYFRAME_HLT", "SORTTIME"
# s: the age of a reading is told from here on, and where there is little room.
AGE_TOLD, AGE_TOLD_IN_SHORT = 0.2, 1.0
ORIGINS = {
    playhead.RECORDED: "Recorded at frame {0:g}",
    playhead.LIVE: "Live, read at frame {0:g}",
    playhead.BAKED: "Baked keys at frame {0:g}",
}


class Shown(NamedTuple):
    """`text` in full, `short` where there is little room, `brief` where there is less and the age
    is left to the `icon`, which is that of the state; `problem`:
    why the reading is not valid, or there is none; `fields`: what was published, None where nothing
    is known of it; `recorded`: not live; `origin`: where it comes from, in words; `old`: why it is
    old, and what brings a new one; `keys`: what baked keys say."""

    text: str
    icon: str
    problem: str = ""
    fields: Mapping[str, Any] | None = None
    recorded: bool = False
    brief: str = ""
    origin: str = ""
    old: str = ""
    keys: str = ""
    age: str = ""

    @property
    def short(self) -> str:
        return ", ".join(filter(None, (self.brief or self.text, self.age)))


class Readings:
    """What sensors read at a scene's playhead, in words. Not to be kept."""

    def __init__(self, scene: Any) -> None:
        self._scene, self._lengths = scene, lengths_of(scene)
        self._playhead = Playhead(scene)

    def of(self, sensor: Sensor) -> Shown:
        """What the sensor reads, or why nothing."""
        if not sensor.settings.enabled:
            return Shown("Off", OFF)
        if state.CACHE.running:
            # What stands is of the frame where the playhead was before the run.
            return Shown("Simulating", UNKNOWN, brief=NOTHING)
        quantity = sensor.reading
        told = self._playhead.of(sensor, quantity)
        warming_up = _warming_up(sensor, told, self._scene)
        ages = age_text(told, AGE_TOLD), age_text(told, AGE_TOLD_IN_SHORT)
        said = quantity, told._replace(age=0.0), warming_up, ages, self._lengths
        kept = state.CACHE.words.get(sensor.name)
        if kept is None or kept[0] is not sensor.kind or kept[1] != said:
            words = warming_up or _words(sensor.kind, quantity, told, ages[0], self._lengths)
            shown = _shown(sensor.kind, quantity, told, words, ages[1], self._lengths)
            kept = state.CACHE.words[sensor.name] = sensor.kind, said, shown
        found: Shown = kept[2]
        return found


def shown(sensor: Sensor, scene: Any) -> Shown:
    """What one sensor reads, in words, or why nothing."""
    return Readings(scene).of(sensor)


def _shown(
    kind: Kind, quantity: Field, told: Told, words: tuple[str, str, str], age: str, lengths: Any
) -> Shown:
    text, icon, brief = words
    return Shown(
        text,
        icon,
        told.problem,
        told.reading.fields or None if told.reading else None,
        told.origin == playhead.RECORDED,
        brief,
        ORIGINS[told.origin].format(told.frame) if told.reading else "",
        told.old,
        state_text(kind, quantity, told.keys, lengths) if told.keys else "",
        "" if told.problem or not told.reading else age,
    )


def _words(kind: Kind, quantity: Field, told: Told, age: str, lengths: Any) -> tuple[str, str, str]:
    """In full, the icon, and in short."""
    reading = told.reading
    if told.problem:
        if reading is None:
            return "Invalid", WRONG, "Invalid"
        # What stands is the last known reading, if there was any.
        value = quantity.text(reading.value, lengths)
        if told.problem == NOT_YET:
            return f"Not yet sure, {value}", NOT_SURE, f"{quantity.short(reading.value, lengths)}?"
        return f"Invalid, {value}" if reading.value else "Invalid", DOUBTFUL, "Invalid"
    if reading is None:
        return "No reading", UNKNOWN, NOTHING
    text = state_text(kind, quantity, reading, lengths)
    brief = text.partition(",")[0]
    if kind.has_analog_reading:
        brief = quantity.short(reading.value, lengths)
    if told.origin == playhead.BAKED:
        return f"Baked: {text}", BAKED, f"Baked: {brief}"
    icon = OLD if told.old else ACTIVE if reading.active else IDLE
    age = age or ("old" if told.old else "")
    return ", ".join(filter(None, (text, age))), icon, brief


def _warming_up(sensor: Sensor, told: Told, scene: Any) -> tuple[str, str, str] | None:
    """The same of a motion detector that cannot report anything yet."""
    plain = told.origin in (playhead.RECORDED, playhead.LIVE) and not (told.problem or told.old)
    if told.reading is None or not plain or told.reading.active:
        return None
    warm_up = getattr(sensor.parameters, "warm_up_time", 0.0)
    frames = told.frame - scene.frame_start
    text = waiting(warm_up, 0.0, frames * scene.render.fps_base / scene.render.fps)
    return (capital(text), NOT_SURE, "Warm-up") if text else None


def state_text(kind: Kind, quantity: Field, reading: Reading, lengths: Any) -> str:
    """The state and the main reading, in full."""
    word = kind.active_label if reading.active else kind.idle_label
    return f"{word}, {quantity.text(reading.value, lengths)}"


def age_text(told: Told, least: float) -> str:
    """How old a reading is, where that is `least` seconds or more; or at which later frame it was
    read."""
    if told.age < 0.0:
        return f"at frame {told.frame:g}"
    if told.age < least:
        return ""
    return f"{told.age:.{0 if told.age >= 9.95 else 1}f} s ago"
