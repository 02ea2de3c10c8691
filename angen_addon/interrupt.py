# SPDX-License-Identifier: GPL-3.0-or-later
"""Ctrl-C on the command line, also amid a render or a search that nothing else can break off."""

from __future__ import annotations

import os
import shutil
import signal
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import bpy

# s: who works on a step that takes longer is not waited for.
PATIENCE_S = 0.7


class Interrupt:
    """Takes note of Ctrl-C: an exception would be lost where it strikes in a frame handler.

    The second one strikes at once. `leave` ends the process, where work that is `watched` takes no
    notice of the first.
    """

    def __init__(self, leave: Callable[[], None]) -> None:
        self.came = False
        self._leave = leave

    def on_signal(self, *_: Any) -> None:
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
            if signal.SIGINT in signals and not over.wait(PATIENCE_S):
                self._leave()


def leave_hard(status: int) -> None:
    """Ends the process where it stands, with what Blender itself would take away."""
    shutil.rmtree(bpy.app.tempdir, ignore_errors=True)
    os._exit(status)
