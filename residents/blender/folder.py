# SPDX-License-Identifier: GPL-3.0-or-later
"""The folder of a run of days: one file for each complete day, and tables made of these."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from datetime import date, datetime, time
from itertools import chain, takewhile
from pathlib import Path
from typing import Any

import bpy

from ...angen_addon.advice.sensing import open_for_ever
from ...angen_addon.authoring.presets import preset_of
from ...angen_addon.layout.describe import parameters_of
from ...angen_addon.output.run_log import about, sensor_facts
from ...angen_addon.runtime.time_base import evaluated_depsgraph
from ...angen_addon.scene.sensors import Sensor, decimal, unit_scale
from ...sensor_logic.logs.error import AngenError, explained
from ...sensor_logic.logs.files import (
    InUseError,
    check_folder,
    file_names,
    gzipped,
    write_files,
)
from ...sensor_logic.logs.formats import FORMATS
from ...sensor_logic.logs.formats.outputs import check_installed, check_out, output_files
from ...sensor_logic.logs.formats.source import format_labels
from ...sensor_logic.recording.tracks import Track
from ...sensor_logic.recording.validity import often_not_valid
from ..days.rows import EVENTS, Day, DayRows, GrowingEvents, toml
from ..days.samples import samples_csv
from ..days.truth import DAY_S
from .daylight import site_of
from .run import HouseholdDays

# Inside the folder of a run: the folder of its days, and the file with the digest of the run.
DAYS, MARK = "days", "days/run.txt"
# Inside it too: a folder for each sensor, with a file for each day.
SAMPLES = "samples"


def check_dates(start: date, days: int, formats: Iterable[str]) -> None:
    """Raise `InputError` if a date is out of range, or if a file format cannot store the dates."""
    begin = datetime.combine(start, time())
    for name in ("events", *formats):
        FORMATS[name].check_dates(begin, 0.0, days * DAY_S)


class Folder:
    """The folder into which a run writes its days.

    Complete days that the same run has written before are kept.
    """

    def __init__(
        self, path: Path, household: HouseholdDays, formats: Sequence[str], samples: bool = False
    ) -> None:
        """Open or create the folder for the household's run.

        With `samples`, the household's days also write the samples of its sensors, and a day
        without them is not complete. Raise `AngenError` if the folder belongs to another run, or
        cannot be written.
        """
        self._path, self._household = path, household
        # The folder of each sensor's samples, by the sensor's name.
        self._samples: dict[str, Path] = {}
        if samples:
            names = file_names(sensor.name for sensor in household.sensors)
            self._samples = {n: path / SAMPLES / name[: -len(".csv")] for n, name in names.items()}
            household.keep_samples = self.keep_samples
        self._formats = [FORMATS[name] for name in dict.fromkeys(formats) if name != "events"]
        self._digest = digest_of(household)
        self._grown = GrowingEvents()
        for target in self._formats:
            check_installed(target)
        self._create()
        for target in self._formats:
            check_out(target, path / f"{target.name}{target.extension}")

    def _create(self) -> None:
        """Create the folder; raise `AngenError` if it belongs to another run."""
        path, mark = self._path, self._path / MARK
        self._is_new = not path.exists()
        check_folder(path if path.exists() else path.resolve().parent, "--out")
        if not mark.is_file():
            if path.is_dir() and any(path.iterdir()):
                raise AngenError(f"--out: {path} is not empty and holds no days; give a new folder")
            with explained(f"--out: cannot make {path}", OSError, raised=AngenError):
                (path / DAYS).mkdir(parents=True, exist_ok=True)
            write_files({mark: "\n".join([self._digest, *_parts(self._household)]) + "\n"})
            return
        digest, *parts = mark.read_text(encoding="utf-8").splitlines() or [""]
        if digest != self._digest:
            raise AngenError(
                f"--out: {path} holds another run: {_difference(parts, _parts(self._household))}; "
                "give a new folder, or remove this one"
            )

    def date_of(self, number: int) -> date:
        return self._household.date_of(number)

    def _file(self, on: date) -> Path:
        return self._path / DAYS / f"{on.isoformat()}.json"

    def has(self, number: int) -> bool:
        """Return whether the folder has all files of a day."""
        on = self.date_of(number)
        files = [self._file(on), *(self._samples_file(name, on) for name in self._samples)]
        return all(file.is_file() for file in files)

    def _samples_file(self, sensor: str, on: date) -> Path:
        return self._samples[sensor] / f"{on.isoformat()}.csv.gz"

    def keep_samples(self, on: date, tracks: Mapping[str, Track], midnight: float) -> None:
        """Write the samples of a day, all or none of the files; raise `AngenError` on failure.

        `tracks` are the readings of the day's run, and `midnight` is the start of the day in s of
        the run.
        """
        files: dict[Path, Any] = {}
        for name, track in tracks.items():
            file = self._samples_file(name, on)
            with explained(f"--out: cannot make {file.parent}", OSError, raised=AngenError):
                file.parent.mkdir(parents=True, exist_ok=True)
            files[file] = gzipped(samples_csv(track, on, midnight))
        write_files(files)

    def read(self, number: int) -> Day | None:
        """Return a day from the folder, or None; raise `AngenError` if its file is damaged."""
        path = self._file(self.date_of(number))
        try:
            return Day.of_json(path.read_text(encoding="utf-8"), self._digest)
        except FileNotFoundError:
            return None
        except (OSError, ValueError) as error:
            raise AngenError(
                f"cannot read {path}: {error}; remove the file to simulate its day again"
            ) from None

    def keep(self, day: Day) -> None:
        """Write the file of a day, fully or not at all; raise `AngenError` on failure."""
        write_files({self._file(day.date): day.as_json(self._digest)})

    def grow(self, days: int) -> None:
        """Add complete days to `events.csv`, at most `days` in all, if they follow those in it.

        At any moment the file is whole, with the days before the first missing one. The other
        tables are written by `finish`. While another program has the file open on Windows, do
        nothing: a later call writes all days. Raise `AngenError` if it cannot be written otherwise.
        """
        file = self._path / EVENTS
        if not file.is_file():
            self._grown = GrowingEvents()
        before = _pieces(file) if self._grown.days else ()
        texts: list[bytes] = []
        while self._grown.days < days and (day := self.read(self._grown.days)) is not None:
            texts.append(self._grown.text_of(day).encode())
        if texts:
            try:
                write_files({file: chain(before, texts)})
            except InUseError:
                self._grown = GrowingEvents()

    def discard(self) -> None:
        """Remove the files that `__init__` has made; if the folder has a day, do nothing."""
        if list((self._path / DAYS).iterdir()) != [self._path / MARK]:
            return
        (self._path / MARK).unlink()
        (self._path / DAYS).rmdir()
        if self._is_new:
            with suppress(OSError):
                # Another program may have written into the folder.
                self._path.rmdir()

    def finish(self, days: int) -> tuple[int, list[str]]:
        """Write the tables of the days before the first missing one, at most `days` of them.

        Return the number of complete ones, and notes on what the formats could not store. Raise
        `AngenError` if a file cannot be written.
        """
        found: list[Day] = []
        while len(found) < days and (day := self.read(len(found))) is not None:
            found.append(day)
        if not found:
            return 0, []
        whole = DayRows.joined(found)
        texts: dict[Path, Any] = {self._path / n: text for n, text in whole.files().items()}
        texts[self._path / "home.toml"] = self._home_toml(len(found))
        notes = self._add_formats(whole, texts)
        write_files(texts)
        notes += often_not_valid(one for day in found for one in day.not_valid)
        notes += open_for_ever(self._household.sensors, evaluated_depsgraph())
        return len([*takewhile(self.has, range(len(found)))]), notes

    def _add_formats(self, whole: DayRows, texts: dict[Path, Any]) -> list[str]:
        """Add the files of the chosen formats to `texts`; return notes on what was not stored."""
        notes = []
        sensors = {s.name: sensor_facts(s) for s in self._household.sensors}
        labels = self._activity_labels()
        for target in self._formats:
            out = self._path / f"{target.name}{target.extension}"
            log = whole.log(sensors, self._run_values(), format_labels(target.name, labels))
            written = target.write(log)
            if target.is_folder:
                out.mkdir(exist_ok=True)
            texts |= output_files(target, out, written)
            notes += [f"{target.name}: {text}" for text in written.notes]
        return notes

    def _activity_labels(self) -> dict[str, dict[str, str]]:
        """Return the name of each activity in each data set, by data set and activity."""
        found: dict[str, dict[str, str]] = {}
        for activity in self._household.plan.routine.activities.values():
            for vocabulary, label in activity.labels.items():
                found.setdefault(vocabulary, {})[activity.name] = label
        return found

    def _run_values(self) -> dict[str, str]:
        """Return the values that identify the run: versions, file, seed and routine."""
        house = self._household
        return about(house.scene) | {"seed": str(house.seed), "routine": house.plan.name}

    def _home_toml(self, days: int) -> str:
        house = self._household
        found: dict[str, Any] = {
            "start": datetime.combine(house.start, time()),
            "days": days,
            "run": self._digest,
            "routine_digest": f"sha256:{_sha(house.plan.text.encode())}",
        }
        versions: dict[str, str] = {}
        for key, value in self._run_values().items():
            table, _, name = key.rpartition(".")
            (versions if table else found)[name] = value
        found["seed"] = house.seed
        found["versions"] = versions
        if labels := self._activity_labels():
            found["labels"] = labels
        return toml(found, map(_sensor_values, sorted(house.sensors, key=lambda s: s.name)))


def _pieces(file: Path) -> Iterator[bytes]:
    """Yield the content of a file in parts of up to a megabyte."""
    with open(file, "rb") as opened:
        while piece := opened.read(1 << 20):
            yield piece


def _sensor_values(sensor: Sensor) -> Mapping[str, Any]:
    depsgraph = evaluated_depsgraph()
    at = sensor.world_matrix(depsgraph).translation * unit_scale(depsgraph.scene)
    preset, is_edited = preset_of(sensor.object)
    return {
        "name": sensor.name,
        "kind": sensor.kind.identifier,
        "room": sensor.room,
        "place": [round(float(x), 4) for x in at],
        "preset": preset.identifier if preset is not None and not is_edited else "",
        "update_rate": float(decimal(sensor.settings.update_rate)),
        "parameters": parameters_of(sensor),
    }


def _parts(household: HouseholdDays) -> list[str]:
    """Return the parts of a run: for each its name, and its value or the hash of its content."""
    house = household
    values = about(house.scene)
    sensors = repr([_sensor_values(sensor) for sensor in house.sensors]).encode()
    versions = " with Blender ".join(
        values[f"versions.{name}"] for name in ("angen_sensors", "blender")
    )
    return [
        f"home: {values.get('digest', '')}",
        f"routine: {_sha(house.plan.text.encode())}",
        f"start: {house.start.isoformat()}",
        f"seed: {house.seed}",
        f"sensors: {_sha(sensors)}",
        f"version: {versions}",
    ]


# Parts whose values tell a user more than that they differ.
SHOWN_PARTS = ("start", "seed", "version")


def _difference(stored: Sequence[str], current: Sequence[str]) -> str:
    """Return a text that names the parts of a run that differ from those in its folder."""
    before, now = (dict(line.split(": ", 1) for line in lines) for lines in (stored, current))
    if before.keys() != now.keys():
        # Earlier versions stored only the digest of the run.
        return "its home, routine, start, seed, sensors or version differ"
    names = [name for name in now if before[name] != now[name]]
    texts = [
        f"{name} ({before[name]}, not {now[name]})" if name in SHOWN_PARTS else name
        for name in names
    ]
    if not texts:
        return "a file that its home reads, or the home's site, differs"
    last = texts.pop()
    both = f"{', '.join(texts)} and {last}" if texts else last
    return f"its {both} {'differ' if texts else 'differs'}"


def digest_of(household: HouseholdDays) -> str:
    """Return a hash of everything on which a day depends.

    This is the home with its linked files, routine, start date, seed, sensors and versions. The
    number of days is left out.
    """
    house = household
    parts: list[Any] = [about(house.scene) | {"seed": str(house.seed)}, house.start.isoformat()]
    parts += [[_sensor_values(sensor) for sensor in house.sensors], site_of(house.scene)]
    files = sorted(path for path in bpy.utils.blend_paths(absolute=True) if Path(path).is_file())
    parts += [_sha(Path(path).read_bytes()) for path in files]
    return f"sha256:{_sha((repr(parts) + house.plan.text).encode())}"


def _sha(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()
