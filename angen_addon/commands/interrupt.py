# SPDX-License-Identifier: GPL-3.0-or-later
"""Ctrl-C, and the signals that end a job, also amid a render or a search that nothing else can
break off."""

from __future__ import annotations

import signal
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

# s: a step of work that goes on for longer after Ctrl-C is ended with the process.
PATIENCE_S = 0.7

SIGNALS = {
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
}


class Interrupt:
    """A context in which Ctrl-C and the like are taken note of, and `check` raises: Blender would
    swallow an exception that is raised in a frame handler.

    A second Ctrl-C raises at once. `leave` ends the process where work that is `watched` does not
    come to its next `check` in time.
    """

    def __init__(self, leave: Callable[[], None]) -> None:
        self.came = False
        self._leave = leave
        self._before: dict[int, Any] = {}

    def __enter__(self) -> Interrupt:
        for number in SIGNALS:
            # Blender takes Ctrl-C for itself and would go on to the end; nohup has SIGHUP ignored.
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
        """Raises KeyboardInterrupt if it came."""
        if self.came:
            raise KeyboardInterrupt

    @contextmanager
    def watched(self) -> Iterator[None]:
        """Work that has written nothing yet and leaves nothing behind: it is ended hard where it
        would go on for longer."""
        # Blender's C code keeps Python's handlers waiting, but neither the file descriptor that a
        # signal wakes nor, as it renders without Python's lock, another thread.
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
