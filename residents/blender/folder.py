# SPDX-License-Identifier: GPL-3.0-or-later
"""A folder of days: each day is kept when it is whole, and the tables are made of those."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from datetime import date, datetime, time
from pathlib import Path
from typing import Any

import bpy

from ...angen_addon.authoring.presets import preset_of
from ...angen_addon.output.describe import parameters_of
from ...angen_addon.output.run_log import about, sensor_facts
from ...angen_addon.runtime.time_base import evaluated_depsgraph
from ...angen_addon.scene.sensors import Sensor, decimal, unit_scale
from ...sensor_logic.error import AngenError, explained
from ...sensor_logic.files import check_folder, write_files
from ...sensor_logic.formats import FORMATS
from ...sensor_logic.formats.outputs import check_installed, check_out, output_files
from ...sensor_logic.formats.source import format_labels
from ..days.rows import Day, DayRows, toml
from ..days.truth import DAY_S
from .daylight import site_of
from .run import Household

# The folder of whole days in that of a run, and the file that says which run that is.
DAYS, MARK = "days", "days/run.txt"


def check_dates(start: date, days: int, formats: Iterable[str]) -> None:
    """Raises InputError where the days, or a format, do not hold such dates."""
    begin = datetime.combine(start, time())
    for name in ("events", *formats):
        FORMATS[name].check_dates(begin, 0.0, days * DAY_S)


class Folder:
    """Where a run of days goes. What is there of the same run is gone on with."""

    def __init__(self, path: Path, household: Household, formats: Sequence[str]) -> None:
        """Raises AngenError where the folder is another run's, or cannot be written."""
        self._path, self._household = path, household
        self._formats = [FORMATS[name] for name in dict.fromkeys(formats) if name != "events"]
        self._digest = digest_of(household)
        for target in self._formats:
            check_installed(target)
        self._claim()
        for target in self._formats:
            check_out(target, path / f"{target.name}{target.extension}")

    def _claim(self) -> None:
        path, mark = self._path, self._path / MARK
        self._is_new = not path.exists()
        check_folder(path if path.exists() else path.resolve().parent, "--out")
        if not mark.is_file():
            if path.is_dir() and any(path.iterdir()):
                raise AngenError(f"--out: {path} is not empty and holds no days; give a new folder")
            with explained(f"--out: cannot make {path}", OSError, raised=AngenError):
                (path / DAYS).mkdir(parents=True, exist_ok=True)
            write_files({mark: f"{self._digest}\n"})
        elif mark.read_text(encoding="utf-8").strip() != self._digest:
            raise AngenError(
                f"--out: {path} holds another run: its home, routine, start, seed, sensors or "
                "version differ; give a new folder, or remove it"
            )

    def date_of(self, number: int) -> date:
        return self._household.date_of(number)

    def _file(self, on: date) -> Path:
        return self._path / DAYS / f"{on.isoformat()}.json"

    def has(self, number: int) -> bool:
        return self._file(self.date_of(number)).is_file()

    def read(self, number: int) -> Day | None:
        """A day that is kept; None where it is not. Raises AngenError."""
        path = self._file(self.date_of(number))
        try:
            return Day.of_json(path.read_text(encoding="utf-8"), self._digest)
        except FileNotFoundError:
            return None
        except (OSError, ValueError) as error:
            raise AngenError(f"cannot read {path}: {error}; remove it to have it anew") from None

    def keep(self, day: Day) -> None:
        """Raises AngenError, and keeps nothing then."""
        write_files({self._file(day.date): day.as_json(self._digest)})

    def discard(self) -> None:
        """Removes what was made here for a run, unless it has any day."""
        if list((self._path / DAYS).iterdir()) != [self._path / MARK]:
            return
        (self._path / MARK).unlink()
        (self._path / DAYS).rmdir()
        if self._is_new:
            with suppress(OSError):
                # Somebody else may have put something into it.
                self._path.rmdir()

    def finish(self, days: int) -> tuple[int, list[str]]:
        """Writes the tables of the whole days from the first on, `days` at most; how many there
        were, and what the formats could not hold. Raises AngenError."""
        found: list[Day] = []
        while len(found) < days and (day := self.read(len(found))) is not None:
            found.append(day)
        if not found:
            return 0, []
        whole = DayRows.of(found)
        texts: dict[Path, Any] = {self._path / n: text for n, text in whole.files().items()}
        texts[self._path / "home.toml"] = self._home(len(found))
        notes = self._add_formats(whole, texts)
        write_files(texts)
        return len(found), notes

    def _add_formats(self, whole: DayRows, texts: dict[Path, Any]) -> list[str]:
        notes = []
        sensors = {s.name: sensor_facts(s) for s in self._household.sensors}
        labels = self._labels()
        for target in self._formats:
            out = self._path / f"{target.name}{target.extension}"
            log = whole.log(sensors, self._about(), format_labels(target.name, labels))
            written = target.write(log)
            if target.is_folder:
                out.mkdir(exist_ok=True)
            texts |= output_files(target, out, written)
            notes += [f"{target.name}: {text}" for text in written.notes]
        return notes

    def _labels(self) -> dict[str, dict[str, str]]:
        """What other vocabularies call the routine's activities, by vocabulary and activity."""
        found: dict[str, dict[str, str]] = {}
        for activity in self._household.plan.routine.activities.values():
            for vocabulary, label in activity.labels.items():
                found.setdefault(vocabulary, {})[activity.name] = label
        return found

    def _about(self) -> dict[str, str]:
        house = self._household
        return about(house.scene) | {"seed": str(house.seed), "routine": house.plan.name}

    def _home(self, days: int) -> str:
        house = self._household
        found: dict[str, Any] = {
            "start": datetime.combine(house.start, time()),
            "days": days,
            "run": self._digest,
            "routine_digest": f"sha256:{_sha(house.plan.text.encode())}",
        }
        versions: dict[str, str] = {}
        for key, value in self._about().items():
            table, _, name = key.rpartition(".")
            (versions if table else found)[name] = value
        found["seed"] = house.seed
        found["versions"] = versions
        if labels := self._labels():
            found["labels"] = labels
        return toml(found, map(_sensor, sorted(house.sensors, key=lambda s: s.name)))


def _sensor(sensor: Sensor) -> Mapping[str, Any]:
    """Where it is (m), and what it is."""
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


def digest_of(household: Household) -> str:
    """Of all that goes into a day: home with what it reads, routine, start, seed, sensors and
    versions. How many days are asked for is not of it."""
    house = household
    parts: list[Any] = [about(house.scene) | {"seed": str(house.seed)}, house.start.isoformat()]
    parts += [[_sensor(sensor) for sensor in house.sensors], site_of(house.scene)]
    files = sorted(path for path in bpy.utils.blend_paths(absolute=True) if Path(path).is_file())
    parts += [_sha(Path(path).read_bytes()) for path in files]
    return f"sha256:{_sha((repr(parts) + house.plan.text).encode())}"


def _sha(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()
