# SPDX-License-Identifier: GPL-3.0-or-later
"""The workers of a study: processes here, or whatever runs at a scheduler elsewhere."""

from __future__ import annotations

import logging
import pickle
import platform
import tempfile
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import dask
import distributed

from ...sensor_logic.error import AngenError, InputError
from . import tasks
from .tasks import File

# In each process of this machine: the package is importable, installed or not; what lies in the
# current folder is not, for nobody would see that it changed; Ctrl-C, which a terminal sends to all
# of them, is the driver's.
STANDALONE = Path(__file__).resolve().parents[1] / "process" / "standalone.py"
PRELOAD = f"""
import os, runpy, signal, sys
sys.path[:] = [path for path in sys.path if os.path.abspath(path) != os.getcwd()]
runpy.run_path({str(STANDALONE)!r})["load_extension"]()
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
# s: who answers later than this at an address is not there.
ANSWERS_S = 10.0


class FilesOfStudy(distributed.WorkerPlugin):
    """Brings files to each worker that does not see the driver's, also to one that comes late."""

    def __init__(self, name: str, files: Mapping[File, bytes]) -> None:
        self.name = name
        self._files = dict(files)

    def setup(self, worker: Any) -> None:
        for file, content in self._files.items():
            try:
                tasks.found(file)
            except AngenError:
                tasks.put(file.name, file.digest, content)


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
        address: submit(client, "versions", None, workers=[address])
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
        return f'{error}: pip install "angen-sensors[sweep]" there'
    return str(error)


def submit(
    client: distributed.Client, name: str, argument: Any, workers: list[str] | None = None
) -> distributed.Future:
    """Asks some worker, or one of `workers`, for a function of `worker`."""

    # The scheduler takes tasks apart, and need not have this package: a function within another is
    # sent as it stands here, and its argument as bytes.
    def call(name: str, argument: bytes) -> Any:
        import importlib
        import pickle

        worker = importlib.import_module("angen_sensors.angen_addon.study.worker")
        return getattr(worker, name)(pickle.loads(argument))

    return client.submit(call, name, pickle.dumps(argument), pure=False, workers=workers)


def send(client: distributed.Client, files: Mapping[File, bytes]) -> None:
    """Has all workers, now and later, know these files."""
    name = f"angen-study-{hash(frozenset(file.digest for file in files)):x}"
    client.register_plugin(FilesOfStudy(name, files))
