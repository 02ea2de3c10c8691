# SPDX-License-Identifier: GPL-3.0-or-later
"""Share the days of `angen day --jobs` among several worker processes.

This process sends each worker the number of one day at a time, over the worker's standard input.
When this process ends for any reason, the system closes that pipe, and the worker ends too.
"""

from __future__ import annotations

import queue
import signal
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass

import bpy

from ...angen_addon.process.console import BAD_INPUT, DONE, FAILED, SIGNALS, leave_hard, note
from .folder import Folder

# s between two checks of the workers, and until a worker that does not end is killed.
POLL_S, PATIENCE_S = 0.2, 2.0
# The option of the command that makes its process a worker.
WORKER = "--worker"


def worker_command() -> list[str]:
    """Return the command line that starts a worker: this process's own with `--worker` added."""
    if bpy.app.binary_path:
        # With several processes, threads within each cost more than they gain.
        return [bpy.app.binary_path, "--threads", "1", *sys.argv[1:], "--quiet", WORKER]
    # Only the Python package has this module.
    from ...angen_addon.process.standalone import python_command

    return [*python_command(), *sys.argv[1:], "--quiet", WORKER]


def days_of_worker() -> Iterator[int]:
    """Yield the numbers of the days that this worker gets on its standard input.

    When the input is closed, the worker ends at once, even in the middle of a day.
    """
    for number in SIGNALS:
        # The exit status then shows which signal ended the worker.
        signal.signal(number, signal.SIG_DFL)
    handed: queue.SimpleQueue[int] = queue.SimpleQueue()

    def read() -> None:
        for text in sys.stdin:
            handed.put(int(text))
        leave_hard(DONE)

    threading.Thread(target=read, daemon=True).start()
    while True:
        yield handed.get()


@dataclass
class _Worker:
    process: subprocess.Popen[bytes]
    day: int | None = None


class SharedDays:
    """Context manager: on entry, start worker processes that simulate days; on exit, end them.

    Parameters
    ----------
    folder
        The folder into which the days are written.
    days
        The numbers of the days to simulate.
    workers
        The number of worker processes.
    """

    def __init__(self, folder: Folder, days: Sequence[int], workers: int) -> None:
        self._folder, self._pending, self._count = folder, deque(days), workers
        self._workers: list[_Worker] = []
        self._polled = 0.0

    def __enter__(self) -> SharedDays:
        for _ in range(self._count):
            # A new session, or group on Windows, so that Ctrl-C in a terminal reaches only this
            # process.
            process = subprocess.Popen(
                worker_command(),
                stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL,
                start_new_session=True,
                creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),
            )
            self._workers.append(_Worker(process))
        # The first day is this process's own.
        for worker, day in zip(self._workers, list(self._pending)[1:], strict=False):
            self._send_day(worker, day)
        return self

    def __exit__(self, *_: object) -> None:
        for worker in self._workers:
            _close(worker.process)
        until = time.monotonic() + PATIENCE_S
        for worker in self._workers:
            with suppress(subprocess.TimeoutExpired):
                worker.process.wait(max(until - time.monotonic(), 0.0))
            worker.process.kill()
            worker.process.wait()

    def own_days(self, waiting: Callable[[], object]) -> Iterator[int]:
        """Yield the numbers of the days that this process simulates itself.

        End when all days are done, or when a worker has failed. Call `waiting` every `POLL_S` s
        while workers simulate the last days.
        """
        while True:
            self.poll_workers()
            if self._pending:
                yield self._pending.popleft()
            elif any(worker.day is not None for worker in self._workers):
                waiting()
                time.sleep(POLL_S)
            else:
                return

    def poll_workers(self) -> None:
        """Send a day to each worker without one, and take back the days of workers that have ended.

        Calls within `POLL_S` s of the last one do nothing.
        """
        if time.monotonic() - self._polled < POLL_S:
            return
        self._polled = time.monotonic()
        for worker in list(self._workers):
            status = worker.process.poll()
            if worker.day is not None and self._folder.has(worker.day):
                worker.day = None
            if status is not None:
                self._workers.remove(worker)
                self._take_back_day(worker, status)
            elif worker.day is None and self._pending:
                self._send_day(worker, self._pending[0])

    def _send_day(self, worker: _Worker, day: int) -> None:
        self._pending.remove(day)
        worker.day = day
        assert worker.process.stdin is not None
        with suppress(OSError):
            # If the worker has ended, `poll_workers` takes the day back.
            worker.process.stdin.write(b"%d\n" % day)
            worker.process.stdin.flush()

    def _take_back_day(self, worker: _Worker, status: int) -> None:
        """Take back the day of a worker that has ended; after an error, begin no new days."""
        _close(worker.process)
        if status in (FAILED, BAD_INPUT):
            # The worker has printed its error. No new days begin; those under way are finished.
            self._pending.clear()
            return
        # On Windows a crash has a positive status.
        how = f"by the signal {_name_of(-status)}" if status < 0 else f"with status {status:#x}"
        text = f"a process of --jobs was ended {how}"
        if worker.day is not None:
            self._pending.appendleft(worker.day)
            text += f"; another process simulates {self._folder.date_of(worker.day)} again"
        note(text)


def _close(process: subprocess.Popen[bytes]) -> None:
    assert process.stdin is not None
    with suppress(OSError):
        process.stdin.close()


def _name_of(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"
