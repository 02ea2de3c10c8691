# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs a study: hands its runs to workers, a few ahead at a time, and keeps what comes back."""

from __future__ import annotations

import json
import shutil
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import distributed

from ...sensor_logic.error import AngenError, InputError
from ...sensor_logic.files import write_files
from ...sensor_logic.study import draws, targets, together
from ...sensor_logic.study.digest import digest_of, digest_of_bytes
from ...sensor_logic.study.draws import Run
from ...sensor_logic.study.study import HOME, ROUTINE, SENSORS, Study
from ...sensor_logic.study.targets import HomeFacts
from ..commands.console import note
from . import cluster
from .results import DAYS, FACTS, Row, Store, Table, write_tables
from .tasks import Done, File, Task

# Runs that wait at the scheduler for each worker, so that none is idle between two.
AHEAD = 3
# s between two looks at who works, and between two writings of the tables.
LOOK_S, TABLES_S = 5.0, 60.0


class Tasks:
    """What a study's runs are to workers: its `homes` and `files` are by their paths."""

    def __init__(
        self,
        study: Study,
        files: Mapping[str, File],
        homes: Mapping[str, HomeFacts],
        versions: dict[str, str],
        days_in: str = "",
    ) -> None:
        self._days_in = days_in
        self._study, self._files, self._homes = study, files, homes
        self._versions = versions

    def of(self, run: Run) -> Task:
        """All that a run needs, with the digest by which it is known."""
        study = self._study
        home = str(run.setting.get(HOME, study.homes[0]))
        routine = str(run.setting.get(ROUTINE, study.routines[0])) if study.routines else ""
        facts = self._homes[home]
        settings = targets.settings_of(facts, {**study.fixed, **run.setting}, study.choice)
        goes_in: dict[str, Any] = {
            "seed": run.seed,
            "settings": settings,
            "measure": study.measure,
            "functions": tuple((f.label, f.name, f.source) for f in study.functions),
            "keep": study.keep,
            "versions": self._versions,
            "frames": study.frames,
            "start": study.days.start.isoformat() if study.days else "",
            "days": study.days.days if study.days else 0,
            "empty_for": study.empty_for,
        }
        of_files = {
            "home": facts.digest,
            "routine": self._files[routine].digest if routine else "",
        }
        return Task(
            digest=digest_of(goes_in | of_files),
            home=self._files[home],
            routine=self._files[routine] if routine else None,
            of_the_home=together.of_the_home(facts, settings),
            days_in=self._days_in,
            **goes_in,
        )

    def life(self, run: Run) -> str:
        """The same for runs that can live the home together."""
        task = self.of(run)
        if not self._study.together:
            return task.digest
        files = [task.home.digest, task.routine.digest if task.routine else ""]
        return digest_of({"files": files, "seed": task.seed, "home": task.of_the_home})


class Driver:
    """A study, what its workers told of its homes, and where its results go."""

    def __init__(self, study: Study, store: Store, client: distributed.Client) -> None:
        self._study, self._store, self._client = study, store, client
        self._wait_for_workers()
        self._versions = cluster.check_workers(client)
        files = {str(path): _file(path) for path in (*study.homes, *study.routines)}
        cluster.send(client, {file: Path(file.path).read_bytes() for file in files.values()})
        homes = {str(path): self._examined(files[str(path)]) for path in study.homes}
        targets.check(study, homes.values())
        days_in = str(store.folder.resolve() / DAYS)
        self._tasks = Tasks(study, files, homes, self._versions, days_in)
        self.total = draws.count(study)
        self._noted: set[str] = set()

    def _wait_for_workers(self) -> None:
        told = False
        while not self._client.nthreads():
            if not told:
                note("waiting for workers; Ctrl-C ends this")
                told = True
            time.sleep(1.0)

    def _examined(self, file: File) -> HomeFacts:
        try:
            found: HomeFacts = cluster.submit(self._client, "examine", file).result()
        except Exception as error:
            raise InputError(f"{file.name}: {error}") from None
        return found

    def run(self, told: Callable[[int, int, int], None]) -> None:
        """Runs what is missing; `told` gets how many are done, in all, and failed. Raises
        InputError; what is done until then is kept."""
        tasks = self._tasks
        lives = Counter(map(tasks.life, self._missing()))
        there, failed = self.total - lives.total(), 0
        workers = max(len(self._client.nthreads()), 1)
        size = together.size_of(lives, workers, bool(self._study.keep))
        groups = together.grouped(self._missing(), tasks.life, size)
        told(there, self.total, failed)
        days = self._store.folder / DAYS
        if self._study.days:
            days.mkdir(exist_ok=True)
        pending: dict[Any, list[Task]] = {}
        looked = tables = time.monotonic()
        ahead = AHEAD * workers
        while True:
            for runs in groups:
                group = [*map(tasks.of, runs)]
                pending[cluster.submit(self._client, "run", group)] = group
                if len(pending) >= ahead:
                    break
            if not pending:
                break
            for future in self._ended(pending):
                for done in self._outcome(future, pending.pop(future)):
                    self._store.add(done, self._versions)
                    failed += bool(done.error)
                    there += 1
                told(there, self.total, failed)
            if time.monotonic() - looked > LOOK_S:
                looked = time.monotonic()
                ahead = AHEAD * max(len(self._client.nthreads()), 1)
            if time.monotonic() - tables > TABLES_S:
                self.write_tables()
                tables = time.monotonic()
        shutil.rmtree(days, ignore_errors=True)

    def kept(self) -> int:
        """How many of the study's runs have a row, also where `run` was interrupted."""
        self._store.read()
        rows = (self._store.row(self._tasks.of(run).digest) for run in draws.runs(self._study))
        return sum(row is not None for row in rows)

    def _missing(self) -> Iterator[Run]:
        for run in draws.runs(self._study):
            if not self._store.has(self._tasks.of(run).digest):
                yield run

    def _ended(self, pending: dict[Any, list[Task]]) -> list[Any]:
        """Those of the pending futures that are over, once there are some. Raises InputError where
        the scheduler is lost."""
        while True:
            try:
                distributed.wait(list(pending), timeout=LOOK_S, return_when="FIRST_COMPLETED")
            except TimeoutError:
                pass
            except Exception as error:
                raise self._lost() from error
            found = [future for future in pending if future.status in ("finished", "error")]
            if found:
                return found
            if self._client.status != "running" or any(
                future.status in ("cancelled", "lost") for future in pending
            ):
                raise self._lost()

    def _lost(self) -> InputError:
        return InputError(
            "the scheduler is lost; what is done is kept, and the same command goes on from it"
        )

    def _outcome(self, future: Any, group: list[Task]) -> list[Done]:
        try:
            done: list[Done] = future.result()
            return done
        except AngenError as error:
            raise InputError(f"{error}; give all workers the same") from None
        except distributed.KilledWorker:
            text = "it ended its worker again and again: is there too little memory?"
        except (distributed.FutureCancelledError, OSError):
            raise self._lost() from None
        except Exception as error:
            text = " ".join(f"{type(error).__name__}: {error}".split())
        return [Done(task.digest, {}, 0.0, text) for task in group]

    def write_tables(self) -> None:
        """Writes results.csv, results.parquet and what the report needs to know of the study."""
        for text in write_tables(self._store.folder, Table(self._rows)):
            if text not in self._noted:
                note(text)
            self._noted.add(text)
        facts = {
            "name": self._study.name,
            "varied": list(self._study.vary),
            "seeds": len(self._study.seeds),
            "runs": self.total,
            "best": self._study.best,
            "homes": [path.name for path in self._study.homes],
        }
        text = json.dumps(facts, indent=1, ensure_ascii=False) + "\n"
        write_files({self._store.folder / FACTS: text})

    def _rows(self) -> Iterator[Row]:
        """The table's rows, in the order of the runs."""
        for run in draws.runs(self._study):
            row = self._store.row(self._tasks.of(run).digest)
            if row is not None:
                yield {
                    "run": run.number,
                    **{key: _shown(key, value) for key, value in run.setting.items()},
                    "seed": run.seed,
                    **row["values"],
                    **row["versions"],
                    "seconds": row["seconds"],
                    "digest": row["digest"],
                    "error": row["error"],
                }


def _shown(key: str, value: Any) -> Any:
    if key == SENSORS:
        return "; ".join(value)
    return Path(value).name if key in (HOME, ROUTINE) else value


def _file(path: Path) -> File:
    try:
        return File(str(path), digest_of_bytes(path.read_bytes()))
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror}") from None
