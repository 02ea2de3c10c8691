# SPDX-License-Identifier: GPL-3.0-or-later
"""A sensor in a recording, whose updates are explained by the evidence that the recording holds."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from ...sensor_logic.clock import Schedule
from ...sensor_logic.logs.wording import quoted
from ...sensor_logic.parameters import is_chosen, label_of, specs, value_text
from ...sensor_logic.recording.evidence import cause_of, check_evidence
from ...sensor_logic.recording.tracks import Recording, Track
from ..scene.lengths import lengths_of
from ..scene.sensors import Sensor, decimal, unit_scale
from .facts import Explanation, Facts, at_frame


class RecordedSensor:
    """A sensor with its recorded updates, to explain them.

    Attributes
    ----------
    scene, recording
        The scene, and the recording with the sensor.
    track
        The recorded updates of the sensor.
    metres
        Metres in a Blender unit.
    lengths
        Formats lengths in the scene's unit.
    """

    def __init__(self, scene: Any, sensor: Sensor, recording: Recording) -> None:
        track, clock = recording.track_of(sensor.uid), recording.clock
        if sensor.variant:
            # The variants of a sensor in a study have the same uid, but different names.
            track = recording.tracks[sensor.name]
        assert track is not None and clock is not None
        self.scene, self.recording = scene, recording
        self.sensor = sensor
        self.track: Track = track
        self.clock = clock
        self.metres = unit_scale(scene)
        self.lengths = lengths_of(scene)
        self._schedule = Schedule(clock, decimal(sensor.settings.update_rate))

    def parameters_at(self, index: int) -> Any:
        """Return the parameters that the sensor had at update `index`.

        Raise `AngenError` if the recording does not tell why the sensor read what it did.
        """
        check_evidence(self.track)
        return self.track.parameters_at(index)

    def evidence(self, name: str, index: int) -> Any:
        """Return the value of a field of the kind's evidence at update `index`."""
        return self.track.evidence.value(name, index)

    def step_of(self, index: int) -> int:
        """Return the step (a frame or a part of it) of update `index` of the track."""
        return round((self.track.frames[index] - self.clock.frame_start) * self.clock.substeps)

    def update_number(self, index: int) -> int:
        """Return the number of update `index` of the track, counted from t = 0.

        The track can begin later than t = 0, or have gaps.
        """
        return self._schedule.last_update(self.step_of(index))

    def index_of(self, number: int, index: int) -> int | None:
        """Convert the number of an update, counted from t = 0, to its index in the track.

        Return None if the track has a gap between that update and update `index`. A sensor loses
        its state in a gap.
        """
        back = self.update_number(index) - number
        if back > index or self.update_number(index - back) != number:
            return None
        return index - back

    def word(self, index: int) -> str:
        """Return the word for the output at update `index`, such as "Near"."""
        kind = self.sensor.kind
        return kind.active_label if self.track.active[index] else kind.idle_label

    def when(self, index: int) -> str:
        """Return a text with the frame and the time of update `index`."""
        return at_frame(self.track.frames[index], self.track.times[index])

    def explanation(
        self,
        index: int,
        headline: str,
        facts: Iterable[tuple[str, str]],
        doubt: str = "",
        cause: Any = None,
    ) -> Explanation:
        """Return an explanation of update `index`, with the sensor's name, the frame and the time.

        `cause_name` is the first object of the evidence. The other parameters are the attributes of
        `Explanation`.
        """
        frame, time = self.track.frames[index], self.track.times[index]
        name, facts = self.sensor.name, tuple(facts)
        objects = cause_of(self.track, index).objects
        cause_name = objects[0] if objects else ""
        return Explanation(name, index, frame, time, headline, facts, doubt, cause, cause_name)


def explain_plainly(recorded: RecordedSensor, index: int) -> Explanation:
    """Explain update `index` of a sensor whose kind has no explanation of its own.

    The explanation lists the published fields, the evidence and the parameters of the sensor.
    """
    kind, track, lengths = recorded.sensor.kind, recorded.track, recorded.lengths
    facts: Facts = []
    values = [
        *((field, track.columns[field.name][index]) for field in kind.samples),
        *((field, recorded.evidence(field.name, index)) for field in kind.evidence),
    ]
    for field, value in values:
        if field.type is float:
            text = field.text(value, lengths)
        elif field.type is str:
            text = quoted(value) if value else "none"
        else:
            text = str(value) if field.type is int else ("yes" if value else "no")
        facts.append((field.name, text))
    parameters = recorded.parameters_at(index)
    for name, spec in specs(kind.parameters).items():
        if is_chosen(parameters, spec.used_when):
            unit = kind.unit_of(spec, parameters)
            text = value_text(getattr(parameters, name), spec, unit, lengths)
            facts.append((label_of(spec, parameters), text))
    reading = track.reading_at(index).text(track.value[index], lengths)
    return recorded.explanation(index, f"{recorded.word(index)}: {reading}", facts)
