# SPDX-License-Identifier: GPL-3.0-or-later
"""The recording of a simulation, for scripts."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ...sensor_logic.logs.error import AngenError
from ...sensor_logic.logs.files import write_files
from ...sensor_logic.logs.formats import FORMATS
from ...sensor_logic.logs.formats.log import DEFAULT_START, Log, SensorFacts
from ...sensor_logic.logs.formats.outputs import check_apart, check_out, output_files
from ...sensor_logic.logs.formats.parquet import event_columns
from ...sensor_logic.logs.formats.source import make_log
from ...sensor_logic.recording.events import events, samples_of, track_events
from ...sensor_logic.recording.evidence import cause_of
from ...sensor_logic.recording.tracks import Recording as Run
from ...sensor_logic.recording.tracks import Track
from ..output.faulty import Faults

DTYPES: dict[type, Any] = {bool: bool, int: np.int64, float: np.float64, str: object}


class EventRow(NamedTuple):
    """A row of the event log, as texts."""

    time_s: str
    frame: str
    sensor: str
    kind: str
    field: str
    value: str


class Evidence(NamedTuple):
    """An event, and what caused it by the sensor's model.

    Attributes
    ----------
    time_s, frame
        The time and the frame of the event.
    field, value
        The published field and its new value.
    objects
        The names of the objects that caused it, the most important first; empty if none did.
    part
        The ray, zone, pixel or gate that decided, such as "tilt 2, ray 17"; empty for none.
    measure
        The quantity that decided, such as "range_m".
    before, after
        This quantity at the update before the event, and at the event; NaN if it is not known.
    """

    time_s: float
    frame: float
    field: str
    value: bool | int | float | str
    objects: tuple[str, ...]
    part: str
    measure: str
    before: float
    after: float


class Recording:
    """The readings of a run.

    A recording can be pickled, and stays usable after its home is closed.
    """

    def __init__(self, run: Run, sensors: dict[str, SensorFacts], about: dict[str, str]) -> None:
        self._run = run
        self._sensors = sensors
        self._about = about

    @property
    def sensors(self) -> list[str]:
        """The names of the simulated sensors."""
        return sorted(self._run.tracks)

    @property
    def events(self) -> list[EventRow]:
        """The rows of the event log: the first value of each field, and each change."""
        return [EventRow(*event.row) for event in events(self._run)]

    def samples(self, sensor: str) -> dict[str, npt.NDArray[Any]]:
        """Return every update of a sensor, as columns (n,).

        The columns are `time_s`, `frame` and each field. A number that the sensor did not measure
        is NaN. Raise AngenError for a sensor that the run did not simulate.
        """
        track = self._track(sensor)
        found = {"time_s": np.array(track.times), "frame": np.array(track.frames)}
        for field in track.kind.samples:
            found[field.name] = np.array(track.columns[field.name], DTYPES[field.type])
        return found

    def evidence(self, sensor: str) -> list[Evidence]:
        """Return what caused each event of a sensor, in the order of the log.

        `angen explain` and the column `because` of days name the same objects. Raise AngenError for
        a sensor that the run did not simulate.
        """
        track = self._track(sensor)
        fields = {field.name: field for field in track.kind.events}
        found = []
        for event in sorted(track_events(track)):
            index = track.at(event.frame)
            assert index is not None
            field = fields[event.field]
            value = field.type(track.columns[field.name][index])
            why = cause_of(track, index)
            found.append(Evidence(event.time, event.frame, field.name, value, *why))
        return found

    def _track(self, sensor: str) -> Track:
        """Return the track of a sensor; raise AngenError if the run did not simulate it."""
        track = self._run.tracks.get(sensor)
        if track is None:
            raise AngenError(
                f"'{sensor}' is not in this recording; its sensors are "
                f"{', '.join(self.sensors) or 'none'}"
            )
        return track

    def to_pandas(self) -> Any:
        """Return the events as a `pandas.DataFrame`, with the time in s as a float.

        Each value is given as text in the column `value`, and as a float in `number`. Raise
        AngenError if pandas is not installed.
        """
        try:
            import pandas
        except ImportError as error:
            raise AngenError(f"to_pandas needs pandas ({error}): pip install pandas") from None
        log = make_log(events(self._run), self._sensors)
        return pandas.DataFrame({name: values for name, (_, values) in event_columns(log).items()})

    def write(
        self,
        path: str | Path,
        format: str = "events",
        start: datetime | None = None,
        faults: str | Path | None = None,
        truth: str | Path | None = None,
    ) -> list[str]:
        """Write the recording in one of the formats of `angen convert`.

        Parameters
        ----------
        path
            The file, or the folder of a format with several files.
        format
            The name of the format.
        start
            The date and time of t = 0.
        faults
            A faults file. Its faults, such as lost messages, are added to the log.
        truth
            The file that then lists the changes made by faults; by default PATH.truth.csv.

        Returns
        -------
        A sentence for each thing that the format cannot hold.

        Raises
        ------
        AngenError
            If an argument is invalid or a file cannot be written.
        """
        if format not in FORMATS:
            raise AngenError(f"format '{format}' is unknown: choose one of {', '.join(FORMATS)}")
        target, out = FORMATS[format], Path(path)
        log, truth_files = self._log(out, faults, truth, start)
        check_out(target, out, flag="path")
        written = target.write(log)
        files = output_files(target, out, written)
        for file in truth_files:
            check_apart("truth", file, files)
        if target.is_folder:
            out.mkdir(exist_ok=True)
        write_files({**files, **truth_files})
        return list(written.notes)

    def _log(
        self,
        out: Path,
        faults: str | Path | None,
        truth: str | Path | None,
        start: datetime | None,
    ) -> tuple[Log, dict[Path, str]]:
        """Return the log of the run with faults added, and the list of these faults.

        The list is a text, in a dict with the path of its file as key. `out` is the file of the
        log, and `truth` the file of the list. Raise AngenError if the faults file is invalid, or
        names an unknown sensor.
        """
        if truth and not faults:
            raise AngenError("truth lists the changes made by faults: give faults too")
        chosen = Faults(Path(faults) if faults else None, Path(truth) if truth else None, out)
        chosen.check_names(self._sensors)
        when = start or DEFAULT_START
        samples = samples_of(self._run)
        log = make_log(events(self._run), self._sensors, when, (), self._about, samples)
        return chosen.of(log)
