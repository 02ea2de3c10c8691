# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs a study on Dask: finds workers, in processes here or at a scheduler elsewhere, hands them
runs, a few ahead at a time, and keeps what comes back."""

from __future__ import annotations

import json
import logging
import math
import pickle
import platform
import shutil
import tempfile
import time
import warnings
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import dask
import distributed

from ..angen_addon.commands.console import note
from ..angen_addon.process import standalone
from ..sensor_logic.error import AngenError, InputError, explained
from ..sensor_logic.files import write_files
from . import settings, tasks
from .results import DAYS, FACTS, Row, Store, write_tables
from .settings import HomeFacts
from .study import HOME, ROUTINE, SENSORS, Run, Study, count_of, runs_of
from .tasks import Done, File, Task, digest_of, digest_of_bytes

# Runs that wait at the scheduler for each worker, so that none is idle between two.
AHEAD = 3
# s between two looks at who works, and between two writings of the tables.
LOOK_S, TABLES_S = 5.0, 60.0
# s: who answers later than this at an address is not there.
ANSWERS_S = 10.0
# Runs that live a home together at most; fewer where their logs are kept, which a worker has in
# memory until the last of them is written.
MOST_TOGETHER, MOST_WITH_LOGS = 1000, 64
# In each process of this machine: the package is importable, installed or not; what lies in the
# current folder is not, for nobody would see that it changed; Ctrl-C, which a terminal sends to all
# of them, is the driver's.
PRELOAD = f"""
import os, runpy, signal, sys
sys.path[:] = [path for path in sys.path if os.path.abspath(path) != os.getcwd()]
runpy.run_path({standalone.__file__!r})["load_extension"]()
signal.signal(signal.SIGINT, signal.SIG_IGN)
"""
# Dask has its workers give each freed array back to the system, an eighth of the time of living
# a day. These (bytes) keep what is freed for the next array, and leave no large holes. Nor does
# anybody look at the profile that Dask takes of each worker, a hundred times a second.
SETTINGS = {
    "distributed.worker.profile.enabled": False,
    "distributed.nanny.pre-spawn-environ.MALLOC_TRIM_THRESHOLD_": 16 << 20,
    "distributed.nanny.pre-spawn-environ.MALLOC_MMAP_THRESHOLD_": 4 << 20,
}
T = TypeVar("T")


# Workers.


@contextmanager
def here(jobs: int) -> Iterator[distributed.Client]:
    """A client of `jobs` processes of this machine, each with one thread."""
    with (
        dask.config.set(SETTINGS),
        tempfile.TemporaryDirectory(prefix="angen-study-") as folder,
        distributed.LocalCluster(
            n_workers=jobs,
            threads_per_worker=1,
            processes=True,
            memory_limit=0,
            dashboard_address=":0",
            local_directory=folder,
            preload=[PRELOAD],
            silence_logs="CRITICAL",
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        yield client


@contextmanager
def elsewhere(address: str) -> Iterator[distributed.Client]:
    """A client of a scheduler that runs at an address. Raises InputError."""
    # What is wrong is told in a line of our own.
    warnings.simplefilter("ignore", distributed.versions.VersionMismatchWarning)
    logging.disable()
    try:
        client = distributed.Client(address, timeout=ANSWERS_S)
    except (OSError, TimeoutError, ValueError, TypeError) as error:
        why = f": {error}" if isinstance(error, ValueError) else ""
        raise InputError(
            f"no scheduler answers at {address}{why}; start one with `dask scheduler`, which says "
            "its address"
        ) from None
    with client:
        yield client


def check_workers(client: distributed.Client) -> dict[str, str]:
    """The versions that all workers have. Raises InputError."""
    for address, threads in client.nthreads().items():
        if threads != 1:
            raise InputError(
                f"the worker {address} has {threads} threads, and Blender works in one: start it "
                "with --nthreads 1 (and --nworkers for more processes)"
            )
    _check_pythons(client)
    # As tasks, not by client.run, which works in another thread: Blender's module crashes where one
    # thread loads it and another one opens a file.
    told = {
        address: submit(client, "tasks.versions", None, workers=[address])
        for address in client.nthreads()
    }
    first: tuple[str, dict[str, str]] | None = None
    for address, future in told.items():
        try:
            versions = future.result()
        except Exception as error:
            raise InputError(f"the worker {address} cannot simulate: {_cause(error)}") from None
        first = first or (address, versions)
        differ = tasks.differences(first[1], versions)
        if differ:
            raise InputError(
                f"the workers {first[0]} and {address} differ: {differ}; results of both would not "
                "go together: give them the same"
            )
    assert first is not None
    return first[1]


def _check_pythons(client: distributed.Client) -> None:
    """Raises InputError where the scheduler or a worker has another Python: it cannot read the
    functions that it is sent, and does not always survive that."""
    told = client.get_versions()
    known = {"the scheduler": told["scheduler"]}
    known |= {f"the worker {address}": facts for address, facts in told["workers"].items()}
    ours = platform.python_version()
    for name, facts in known.items():
        theirs = facts["host"]["python"].partition(".final")[0]
        if theirs.split(".")[:2] != ours.split(".")[:2]:
            raise InputError(
                f"{name} has Python {theirs}, and this is Python {ours}: start it with "
                f"Python {ours.rpartition('.')[0]}"
            )


def _cause(error: Exception) -> str:
    # Dask may have put the error into another.
    if "No module named" in str(error) and "pip install" not in str(error):
        return f'{error}: pip install "angen-sensors[study]" there'
    return str(error)


def submit(
    client: distributed.Client, name: str, argument: Any, workers: list[str] | None = None
) -> distributed.Future:
    """Has some worker, or one of `workers`, call a function: `MODULE.FUNCTION` of this folder."""

    # The scheduler takes tasks apart, and need not have this package: a function within another is
    # sent as it stands here, and its argument as bytes.
    def call(name: str, argument: bytes) -> Any:
        import importlib
        import pickle

        module, _, function = name.partition(".")
        found = importlib.import_module(f"angen_sensors.studies.{module}")
        return getattr(found, function)(pickle.loads(argument))

    return client.submit(call, name, pickle.dumps(argument), pure=False, workers=workers)


def send(client: distributed.Client, files: Mapping[File, bytes]) -> None:
    """Has all workers, now and later, know these files."""
    name = f"angen-study-{hash(frozenset(file.digest for file in files)):x}"
    client.register_plugin(tasks.FilesOfStudy(name, files))


# The runs.


@dataclass
class Tasks:
    """What a study's runs are to workers: its `homes` and `files` are by their paths."""

    study: Study
    files: Mapping[str, File]
    homes: Mapping[str, HomeFacts]
    versions: dict[str, str]
    days_in: str = ""

    def of(self, run: Run) -> Task:
        """All that a run needs, with the digest by which it is known."""
        study = self.study
        home = str(run.setting.get(HOME, study.homes[0]))
        routine = str(run.setting.get(ROUTINE, study.routines[0])) if study.routines else ""
        facts = self.homes[home]
        set_to = settings.settings_of(facts, {**study.fixed, **run.setting}, study.choice)
        goes_in: dict[str, Any] = {
            "seed": run.seed,
            "settings": set_to,
            "measure": study.measure,
            "functions": tuple((f.label, f.name, f.source) for f in study.functions),
            "keep": study.keep,
            "versions": self.versions,
            "frames": study.frames,
            "start": study.start.isoformat() if study.start else "",
            "days": study.days,
            "empty_for": study.empty_for,
        }
        lives = self.files[routine] if routine else None
        of_files = {"home": facts.digest, "routine": lives.digest if lives else ""}
        return Task(
            digest=digest_of(goes_in | of_files),
            home=self.files[home],
            routine=lives,
            of_the_home=settings.of_the_home(facts, set_to),
            days_in=self.days_in,
            **goes_in,
        )

    def life(self, run: Run) -> str:
        """The same for runs that can live the home together."""
        task = self.of(run)
        if not self.study.together:
            return task.digest
        files = [task.home.digest, task.routine.digest if task.routine else ""]
        return digest_of({"files": files, "seed": task.seed, "home": task.of_the_home})


def grouped(
    runs: Iterable[T], life: Callable[[T], str], workers: int, most: int
) -> Iterator[list[T]]:
    """The runs in groups of `most` at most that live the home together: those of the same `life`,
    shared out so that all workers have something to do."""
    lives: defaultdict[str, list[T]] = defaultdict(list)
    for run in runs:
        lives[life(run)].append(run)
    parts = math.ceil(workers / max(len(lives), 1))
    for group in lives.values():
        size = min(math.ceil(len(group) / parts), most)
        for first in range(0, len(group), size):
            yield group[first : first + size]


class Driver:
    """A study, what its workers told of its homes, and where its results go."""

    def __init__(self, study: Study, store: Store, client: distributed.Client) -> None:
        self._study, self._store, self._client = study, store, client
        if not client.nthreads():
            note("waiting for workers; Ctrl-C ends this")
            client.wait_for_workers(1)
        self._versions = check_workers(client)
        files = {str(path): _file(path) for path in (*study.homes, *study.routines)}
        send(client, {file: Path(file.path).read_bytes() for file in files.values()})
        homes = {str(path): self._examined(files[str(path)]) for path in study.homes}
        settings.check(study, homes.values())
        days_in = str(store.folder.resolve() / DAYS)
        self._tasks = Tasks(study, files, homes, self._versions, days_in)
        self.total = count_of(study)
        self._noted: set[str] = set()

    def _examined(self, file: File) -> HomeFacts:
        try:
            found: HomeFacts = submit(self._client, "runs.examine", file).result()
        except Exception as error:
            raise InputError(f"{file.name}: {error}") from None
        return found

    def run(self, told: Callable[[int, int, int], None]) -> None:
        """Runs what is missing; `told` gets how many are done, in all, and failed. Raises
        InputError; what is done until then is kept."""
        missing = list(self._missing())
        there, failed = self.total - len(missing), 0
        workers = max(len(self._client.nthreads()), 1)
        most = MOST_WITH_LOGS if self._study.keep else MOST_TOGETHER
        groups = grouped(missing, self._tasks.life, workers, most)
        told(there, self.total, failed)
        days = self._store.folder / DAYS
        if self._study.days:
            days.mkdir(exist_ok=True)
        pending: dict[Any, list[Task]] = {}
        looked = tables = time.monotonic()
        ahead = AHEAD * workers
        while True:
            for runs in groups:
                group = [*map(self._tasks.of, runs)]
                pending[submit(self._client, "runs.run", group)] = group
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
        rows = (self._store.row(self._tasks.of(run).digest) for run in runs_of(self._study))
        return sum(row is not None for row in rows)

    def _missing(self) -> Iterator[Run]:
        for run in runs_of(self._study):
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
        except (distributed.client.FutureCancelledError, OSError):
            raise self._lost() from None
        except Exception as error:
            text = " ".join(f"{type(error).__name__}: {error}".split())
        return [Done(task.digest, {}, 0.0, text) for task in group]

    def write_tables(self) -> None:
        """Writes results.csv, results.parquet and what the report needs to know of the study."""
        for text in write_tables(self._store.folder, self._rows()):
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
        for run in runs_of(self._study):
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
    with explained(f"cannot read {path}", OSError):
        return File(str(path), digest_of_bytes(path.read_bytes()))
