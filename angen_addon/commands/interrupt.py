# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles Ctrl-C and the signals that end a job, also during a long call into Blender, such as a
render, that nothing else can end."""

from __future__ import annotations

import signal
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

# s: a step that goes on for longer than this after Ctrl-C is ended with the process.
PATIENCE_S = 0.7

SIGNALS = {
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
}


class Interrupt:
    """A context manager that notes Ctrl-C and the like, for `check` to raise later: an exception
    raised inside a frame handler would be lost in Blender.

    A second Ctrl-C raises at once. `leave` is called to end the process where `watched` work does
    not reach its next `check` in time.
    """

    def __init__(self, leave: Callable[[], None]) -> None:
        self.came = False
        self._leave = leave
        self._before: dict[int, Any] = {}

    def __enter__(self) -> Interrupt:
        for number in SIGNALS:
            # Blender handles Ctrl-C itself, and would run on; nohup ignores SIGHUP.
            if number == signal.SIGINT or signal.getsignal(number) != signal.SIG_IGN:
                self._before[number] = signal.signal(number, self._on_signal)
        return self

    def __exit__(self, *_: object) -> None:
        for number, before in self._before.items():
            signal.signal(number, before or signal.SIG_DFL)

    def _on_signal(self, *_: Any) -> None:
        if self.came:
            raise KeyboardInterrupt
        self.came = True

    def check(self) -> None:
        """Raises KeyboardInterrupt if a signal has come."""
        if self.came:
            raise KeyboardInterrupt

    @contextmanager
    def watched(self) -> Iterator[None]:
        """Wraps work that can be ended at any point, since it has written nothing yet."""
        # During a call into Blender, Python runs no signal handler. But the signal still wakes a
        # file descriptor, and another thread can read that, since rendering releases Python's lock.
        ours, theirs = socket.socketpair()
        theirs.setblocking(False)
        before = signal.set_wakeup_fd(theirs.fileno(), warn_on_full_buffer=False)
        over = threading.Event()
        watcher = threading.Thread(target=self._watch, args=(ours, over), daemon=True)
        watcher.start()
        try:
            yield
        finally:
            over.set()
            signal.set_wakeup_fd(before)
            theirs.close()
            watcher.join()
            ours.close()

    def _watch(self, woken: socket.socket, over: threading.Event) -> None:
        while signals := woken.recv(16):
            if SIGNALS.intersection(signals) and not over.wait(PATIENCE_S):
                self._leave()
