# SPDX-License-Identifier: GPL-3.0-or-later
"""Run a study on Dask: find workers, send runs to them, and store the results.

Workers are processes on this machine, or the workers of a Dask scheduler elsewhere.
"""

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

from ..angen_addon.process import standalone
from ..angen_addon.process.console import note
from ..parts import installation
from ..sensor_logic.logs.error import AngenError, InputError, explained
from ..sensor_logic.logs.files import write_files
from . import settings, tasks
from .results import DAYS, FACTS, Row, Store, write_tables
from .settings import StudiedHome
from .study import HOME, ROUTINE, SENSORS, Run, Study, count_of, runs_of
from .tasks import File, RunResult, Task, digest_of, digest_of_bytes

# Runs that wait at the scheduler for each worker, so that no worker is idle between two runs.
AHEAD = 3
# Time between two checks of the workers, and between two writings of the tables, s.
CHECK_S, TABLES_S = 5.0, 60.0
# Timeout for a scheduler to answer, s.
TIMEOUT_S = 10.0
# Most runs that share one simulation of the home. If logs are kept there are fewer, because a
# worker holds all logs of a group in memory.
MOST_TOGETHER, MOST_WITH_LOGS = 1000, 64
# For each local worker: make the package importable, whether installed or not; keep modules of the
# current folder out, since their changes would go unnoticed; leave Ctrl-C to the driver. In ASCII:
# Dask writes it into a file in the code page of Windows, and Python reads that as UTF-8.
PRELOAD = """
import os, runpy, signal, sys
sys.path[:] = [path for path in sys.path if os.path.abspath(path) != os.getcwd()]
runpy.run_path({!a})["load_extension"]()
signal.signal(signal.SIGINT, signal.SIG_IGN)
"""
# By default Dask's workers return each freed array to the system, which costs an eighth of the
# time of a day. These limits (bytes) keep freed memory for the next array. Dask's profile of each
# worker, taken a hundred times a second, is not used.
SETTINGS = {
    "distributed.worker.profile.enabled": False,
    "distributed.nanny.pre-spawn-environ.MALLOC_TRIM_THRESHOLD_": 16 << 20,
    "distributed.nanny.pre-spawn-environ.MALLOC_MMAP_THRESHOLD_": 4 << 20,
}
T = TypeVar("T")


# Workers.


@contextmanager
def local_client(jobs: int) -> Iterator[distributed.Client]:
    """Context manager: start `jobs` single-threaded Dask workers on this machine.

    On entry, return their Dask client. On exit, end the workers.
    """
    with (
        dask.config.set(SETTINGS),
        # On Windows a worker that ends can still have a file open.
        tempfile.TemporaryDirectory(prefix="angen-study-", ignore_cleanup_errors=True) as folder,
        distributed.LocalCluster(
            n_workers=jobs,
            threads_per_worker=1,
            processes=True,
            memory_limit=0,
            dashboard_address=":0",
            local_directory=folder,
            preload=[PRELOAD.format(standalone.__file__)],
            silence_logs="CRITICAL",
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        yield client


@contextmanager
def remote_client(address: str) -> Iterator[distributed.Client]:
    """Context manager: connect to the Dask scheduler at an address.

    On entry, return the Dask client, or raise `InputError` if no scheduler answers. On exit,
    disconnect.
    """
    # Dask's own messages are silenced: errors are reported below in one line.
    warnings.simplefilter("ignore", distributed.versions.VersionMismatchWarning)
    logging.disable()
    try:
        client = distributed.Client(address, timeout=TIMEOUT_S)
    except (OSError, TimeoutError, ValueError, TypeError) as error:
        why = f": {error}" if isinstance(error, ValueError) else ""
        raise InputError(
            f"no scheduler answers at {address}{why}; start one with `dask scheduler`, which "
            "prints its address"
        ) from None
    with client:
        yield client


def check_workers(client: distributed.Client) -> dict[str, str]:
    """Return the versions of the workers' software by name, which must be the same on all workers.

    Raise `InputError` if they differ, or if a worker has several threads or cannot simulate.
    """
    for address, threads in client.nthreads().items():
        if threads != 1:
            raise InputError(
                f"the worker {address} has {threads} threads, and Blender works in one: start it "
                "with --nthreads 1 (and --nworkers for more processes)"
            )
    _check_pythons(client)
    # As tasks, not by `client.run`, which uses another thread: Blender's module crashes if one
    # thread loads it and another one opens a file.
    futures = {
        address: submit(client, "tasks.versions", None, workers=[address])
        for address in client.nthreads()
    }
    first: tuple[str, dict[str, str]] | None = None
    for address, future in futures.items():
        try:
            versions = future.result()
        except Exception as error:
            raise InputError(f"the worker {address} cannot simulate: {_cause(error)}") from None
        first = first or (address, versions)
        differ = tasks.differences(first[1], versions)
        if differ:
            raise InputError(
                f"the workers {first[0]} and {address} have different versions: {differ}; install "
                "the same versions on all workers"
            )
    assert first is not None
    return first[1]


def _check_pythons(client: distributed.Client) -> None:
    """Raise `InputError` if the scheduler or a worker has a different version of Python."""
    # Another Python cannot read the functions that it receives, and can crash.
    replies = client.get_versions()
    known = {"the scheduler": replies["scheduler"]}
    known |= {f"the worker {address}": facts for address, facts in replies["workers"].items()}
    ours = platform.python_version()
    for name, facts in known.items():
        theirs = facts["host"]["python"].partition(".final")[0]
        if theirs.split(".")[:2] != ours.split(".")[:2]:
            raise InputError(
                f"{name} has Python {theirs}, and this program has Python {ours}: start it with "
                f"Python {ours.rpartition('.')[0]}"
            )


def _cause(error: Exception) -> str:
    # Dask can wrap the error in another one.
    if "No module named" in str(error) and "pip install" not in str(error):
        return f"{error}: install it there with {installation('studies')}"
    return str(error)


def submit(
    client: distributed.Client, name: str, argument: Any, workers: list[str] | None = None
) -> distributed.Future:
    """Submit a call of a function of this folder, and return its future.

    Parameters
    ----------
    client : Client
        The client of the workers.
    name : str
        The function, as MODULE.FUNCTION.
    argument
        The function's argument.
    workers : list of str, optional
        The addresses of the workers that may run the call; by default any worker.
    """

    # The scheduler unpickles tasks, and need not have this package: a nested function is pickled by
    # value, and its argument is sent as bytes.
    def call(name: str, argument: bytes) -> Any:
        import importlib
        import pickle

        module, _, function = name.partition(".")
        found = importlib.import_module(f"angen_sensors.studies.{module}")
        return getattr(found, function)(pickle.loads(argument))

    return client.submit(call, name, pickle.dumps(argument), pure=False, workers=workers)


def send_files(client: distributed.Client, files: Mapping[File, bytes]) -> None:
    """Send files, given with their contents, to all workers, and to those that connect later."""
    name = f"angen-study-{hash(frozenset(file.digest for file in files)):x}"
    client.register_plugin(tasks.FilesOfStudy(name, files))


# The runs.


@dataclass
class Tasks:
    """Makes the tasks of workers from the runs of a study.

    `files` and `homes` have the paths of files as keys. `versions` are the versions of the workers'
    software. `days_in` is the folder for simulated days of unfinished runs.
    """

    study: Study
    files: Mapping[str, File]
    homes: Mapping[str, StudiedHome]
    versions: dict[str, str]
    days_in: str = ""

    def task_of(self, run: Run) -> Task:
        """Return the task of a run, including the digest that identifies the run."""
        study = self.study
        home = str(run.setting.get(HOME, study.homes[0]))
        routine = str(run.setting.get(ROUTINE, study.routines[0])) if study.routines else ""
        facts = self.homes[home]
        set_to = settings.settings_of(facts, {**study.fixed, **run.setting}, study.choice)
        facts_of_run: dict[str, Any] = {
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
        routine_file = self.files[routine] if routine else None
        digests = {"home": facts.digest, "routine": routine_file.digest if routine_file else ""}
        return Task(
            digest=digest_of(facts_of_run | digests),
            home=self.files[home],
            routine=routine_file,
            shared_settings=settings.shared_settings(facts, set_to),
            days_in=self.days_in,
            **facts_of_run,
        )

    def group_key(self, run: Run) -> str:
        """Return a text that is the same for all runs that can share one simulation."""
        task = self.task_of(run)
        if not self.study.together:
            return task.digest
        files = [task.home.digest, task.routine.digest if task.routine else ""]
        return digest_of({"files": files, "seed": task.seed, "home": task.shared_settings})


def group_runs(
    runs: Iterable[T], key: Callable[[T], str], workers: int, most: int
) -> Iterator[list[T]]:
    """Yield groups of runs that share one simulation.

    Parameters
    ----------
    runs : iterable
        The runs to group.
    key : callable
        Takes a run and returns a text; runs with the same text can share a simulation.
    workers : int
        The number of workers; groups are so small that each worker gets one, if possible.
    most : int
        The largest number of runs in a group.
    """
    groups: defaultdict[str, list[T]] = defaultdict(list)
    for run in runs:
        groups[key(run)].append(run)
    parts = math.ceil(workers / max(len(groups), 1))
    for group in groups.values():
        size = min(math.ceil(len(group) / parts), most)
        for first in range(0, len(group), size):
            yield group[first : first + size]


class Driver:
    """The process that runs a study: it sends runs to workers, and stores their results."""

    def __init__(self, study: Study, store: Store, client: distributed.Client) -> None:
        self._study, self._store, self._client = study, store, client
        if not client.nthreads():
            note("waiting for workers; Ctrl-C ends this")
            client.wait_for_workers(1)
        self._versions = check_workers(client)
        files = {str(path): _file(path) for path in (*study.homes, *study.routines)}
        send_files(client, {file: Path(file.path).read_bytes() for file in files.values()})
        homes = {str(path): self._examine(files[str(path)]) for path in study.homes}
        settings.check(study, homes.values())
        days_in = str(store.folder.resolve() / DAYS)
        self._tasks = Tasks(study, files, homes, self._versions, days_in)
        self.total = count_of(study)
        self._noted: set[str] = set()

    def _examine(self, file: File) -> StudiedHome:
        """Return data about a home, which a worker opens for this."""
        try:
            found: StudiedHome = submit(self._client, "runs.examine", file).result()
        except Exception as error:
            raise InputError(f"{file.name}: {error}") from None
        return found

    def run(self, progress: Callable[[int, int, int], None]) -> None:
        """Run all runs that have no result yet.

        Raise `InputError` if a run cannot be sent or stored. Results stored before that are kept.

        Parameters
        ----------
        progress : callable
            Takes the numbers of finished runs, of all runs and of failed runs.
        """
        missing = list(self._missing())
        ended, failed = self.total - len(missing), 0
        workers = max(len(self._client.nthreads()), 1)
        most = MOST_WITH_LOGS if self._study.keep else MOST_TOGETHER
        groups = group_runs(missing, self._tasks.group_key, workers, most)
        progress(ended, self.total, failed)
        days = self._store.folder / DAYS
        if self._study.days:
            days.mkdir(exist_ok=True)
        pending: dict[Any, list[Task]] = {}
        looked = tables = time.monotonic()
        ahead = AHEAD * workers
        while True:
            for runs in groups:
                group = [*map(self._tasks.task_of, runs)]
                pending[submit(self._client, "runs.run", group)] = group
                if len(pending) >= ahead:
                    break
            if not pending:
                break
            for future in self._wait_for_some(pending):
                for done in self._outcome(future, pending.pop(future)):
                    self._store.add(done, self._versions)
                    failed += bool(done.error)
                    ended += 1
                progress(ended, self.total, failed)
            if time.monotonic() - looked > CHECK_S:
                looked = time.monotonic()
                ahead = AHEAD * max(len(self._client.nthreads()), 1)
            if time.monotonic() - tables > TABLES_S:
                try:
                    self.write_tables()
                except InputError as error:
                    # Such as a table that Excel has open. They are written again at the end.
                    self._note_once(str(error))
                tables = time.monotonic()
        shutil.rmtree(days, ignore_errors=True)

    def kept(self) -> int:
        """Return how many of the study's runs have a stored result, failed runs included."""
        self._store.read()
        rows = (self._store.row(self._tasks.task_of(run).digest) for run in runs_of(self._study))
        return sum(row is not None for row in rows)

    def _missing(self) -> Iterator[Run]:
        """Yield the runs without a stored result, and the runs that failed."""
        for run in runs_of(self._study):
            if not self._store.has(self._tasks.task_of(run).digest):
                yield run

    def _wait_for_some(self, pending: dict[Any, list[Task]]) -> list[Any]:
        """Wait until some of the pending futures have ended, and return these."""
        while True:
            try:
                distributed.wait(list(pending), timeout=CHECK_S, return_when="FIRST_COMPLETED")
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
            "the connection to the scheduler is lost; the finished runs are kept: give the same "
            "command again to continue"
        )

    def _outcome(self, future: Any, group: list[Task]) -> list[RunResult]:
        """Return the results of a group of runs; if its task failed, each result has the error."""
        try:
            done: list[RunResult] = future.result()
            return done
        except AngenError as error:
            raise InputError(f"{error}; install the same versions on all workers") from None
        except distributed.KilledWorker:
            text = (
                "its worker ended repeatedly, possibly because the memory was full: start "
                "fewer workers"
            )
        except (distributed.client.FutureCancelledError, OSError):
            raise self._lost() from None
        except Exception as error:
            text = " ".join(f"{type(error).__name__}: {error}".split())
        return [RunResult(task.digest, {}, 0.0, text) for task in group]

    def write_tables(self) -> None:
        """Write the tables of results, and the file that describes the study for the report."""
        for text in write_tables(self._store.folder, self._rows()):
            self._note_once(text)
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

    def _note_once(self, text: str) -> None:
        if text not in self._noted:
            note(text)
        self._noted.add(text)

    def _rows(self) -> Iterator[Row]:
        """Yield a row of the tables for each run with a result, in the order of the runs."""
        for run in runs_of(self._study):
            row = self._store.row(self._tasks.task_of(run).digest)
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
    """Return a value for the tables: files without folders, and sensors joined by "; "."""
    if key == SENSORS:
        return "; ".join(value)
    return Path(value).name if key in (HOME, ROUTINE) else value


def _file(path: Path) -> File:
    with explained(f"cannot read {path}", OSError):
        return File(str(path), digest_of_bytes(path.read_bytes()))
