# SPDX-License-Identifier: GPL-3.0-or-later
"""Texts for the reading of a sensor at the current frame, in the language of the interface.

States differ by icon and by word, never by colour alone.
"""

from __future__ import annotations

from typing import Any

from ...sensor_logic import progress
from ...sensor_logic.kind import Kind
from ...sensor_logic.logs.fields import Field
from ...sensor_logic.logs.wording import NOTHING, capital
from ...sensor_logic.model import NOT_YET, Reading
from ...sensor_logic.physics import waiting
from ..appearance.reading_text import (
    ACTIVE,
    BAKED,
    DOUBTFUL,
    IDLE,
    NOT_SURE,
    OFF,
    OLD,
    UNKNOWN,
    WRONG,
    ReadingText,
)
from ..runtime import playhead
from ..runtime.edits import EDITS
from ..runtime.live import LIGHT_AT_REST, LIGHT_BEFORE
from ..runtime.playhead import Playhead, PlayheadReading
from ..runtime.running import is_running
from ..scene.lengths import lengths_of
from ..scene.sensors import Sensor
from ..translations.interface import language, translated

# s: in full and in short texts, readings younger than this are shown without their age.
LEAST_AGE, LEAST_AGE_IN_SHORT = 0.2, 1.0
ORIGINS = {
    playhead.RECORDED: "Recorded at frame {0:g}",
    playhead.LIVE: "Live, read at frame {0:g}",
    playhead.BAKED: "Baked keyframes at frame {0:g}",
}


class ReadingTexts:
    """Makes the texts of the sensors' readings at the current frame; create one for each redraw."""

    def __init__(self, scene: Any) -> None:
        self._scene, self._lengths = scene, lengths_of(scene)
        self._playhead = Playhead(scene)

    def of(self, sensor: Sensor) -> ReadingText:
        """Return the texts for a sensor's reading. If there is no reading, the texts say why."""
        if not sensor.settings.enabled:
            return ReadingText(translated("Off"), OFF)
        if is_running():
            # During a run the readings belong to the frame before it.
            work = progress.working
            measures = work is not None and work.operator == "angen.measure_light"
            text = translated("Measuring" if measures else "Simulating")
            return ReadingText(text, UNKNOWN, brief=NOTHING)
        quantity = sensor.reading
        found = self._playhead.of(sensor, quantity)
        warming = _warming_up(sensor, found, self._scene)
        if warming:
            found = found._replace(problem=warming)
            words = (translated(capital(warming)), NOT_SURE, translated("Warm-up"))
        else:
            words = _texts(sensor.kind, quantity, found, self._lengths)
        return _text_of(sensor.kind, quantity, found, words, self._lengths)

    def source(self, sensor: Sensor) -> Any:
        """Return a value that changes whenever the sensor's icon or `short` text may change."""
        source = self._playhead.source(sensor, LEAST_AGE_IN_SHORT)
        return language(), sensor.settings.enabled, is_running(), EDITS.revision, source


def reading_text(sensor: Sensor, scene: Any) -> ReadingText:
    """Return the texts for a sensor's reading. If there is no reading, the texts say why."""
    return ReadingTexts(scene).of(sensor)


def _text_of(
    kind: Kind,
    quantity: Field,
    found: PlayheadReading,
    words: tuple[str, str, str],
    lengths: Any,
) -> ReadingText:
    """Combine the reading `found` with `words`: its full text, icon and brief text."""
    text, icon, brief = words
    return ReadingText(
        text,
        icon,
        found.problem,
        found.reading.fields or None if found.reading else None,
        found.origin == playhead.RECORDED,
        brief,
        translated(ORIGINS[found.origin].format(found.frame)) if found.reading else "",
        found.old,
        state_text(kind, quantity, found.keys, lengths) if found.keys else "",
        "" if found.problem or not found.reading else age_text(found, LEAST_AGE_IN_SHORT),
    )


def _texts(
    kind: Kind, quantity: Field, found: PlayheadReading, lengths: Any
) -> tuple[str, str, str]:
    """Return the full text, the icon and the brief text for a reading."""
    reading = found.reading
    if found.problem:
        invalid = translated("Invalid")
        if reading is None:
            return invalid, WRONG, invalid
        # The value is the last valid one, or 0 if there was none.
        value = quantity.text(reading.value, lengths)
        if found.problem == NOT_YET:
            return (
                translated(f"Not yet sure, {value}"),
                NOT_SURE,
                f"{quantity.short(reading.value, lengths)}?",
            )
        text = translated(f"Invalid, {value}") if reading.value else invalid
        return text, DOUBTFUL, invalid
    if reading is None:
        if found.old in (LIGHT_AT_REST, LIGHT_BEFORE):
            return translated("Measured at rest"), UNKNOWN, translated("at rest")
        return translated("No reading"), UNKNOWN, NOTHING
    text = state_text(kind, quantity, reading, lengths)
    brief = text.partition(",")[0]
    if kind.has_analog_reading and (reading.active or kind.value_when_idle):
        brief = translated(quantity.short(reading.value, lengths))
    if found.origin == playhead.BAKED:
        return translated(f"Baked: {text}"), BAKED, translated(f"Baked: {brief}")
    icon = OLD if found.old else ACTIVE if reading.active else IDLE
    age = age_text(found, LEAST_AGE) or (translated("old") if found.old else "")
    return ", ".join(filter(None, (text, age))), icon, brief


def _warming_up(sensor: Sensor, found: PlayheadReading, scene: Any) -> str:
    """Return why a reading is not valid during a detector's warm-up time; empty after it."""
    plain = found.origin in (playhead.RECORDED, playhead.LIVE) and not (found.problem or found.old)
    if found.reading is None or not plain:
        return ""
    warm_up = getattr(sensor.parameters, "warm_up_time", 0.0)
    frames = found.frame - scene.frame_start
    return waiting(warm_up, 0.0, frames * scene.render.fps_base / scene.render.fps)


def state_text(kind: Kind, quantity: Field, reading: Reading, lengths: Any) -> str:
    """Return a text with the state of a sensor, such as on or off, and its main value."""
    word = translated(kind.active_label if reading.active else kind.idle_label)
    if not (reading.active or kind.value_when_idle):
        return word
    what = f"{translated(quantity.word)} " if quantity.word else ""
    return f"{word}, {what}{translated(quantity.text(reading.value, lengths))}"


def age_text(found: PlayheadReading, least: float) -> str:
    """Return how long ago a reading was made, such as "3 s ago"; empty below `least` seconds.

    If the reading is from a later frame than the current one, return that frame instead.
    """
    if found.age < 0.0:
        return translated(f"at frame {found.frame:g}")
    if found.age < least:
        return ""
    if found.age < 59.5:
        return translated(f"{found.age:.{0 if found.age >= 9.95 else 1}f} s ago")
    hours, minutes = divmod(round(found.age / 60.0), 60)
    return translated(f"{hours} h {minutes} min ago" if hours else f"{minutes} min ago")
