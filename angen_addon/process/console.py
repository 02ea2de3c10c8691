# SPDX-License-Identifier: GPL-3.0-or-later
"""Print messages to standard error, and end a command early.

Standard output is kept free of messages, because the events are written there. A command ends early
by a call of `leave_hard`, or by Ctrl-C and other signals.
"""

from __future__ import annotations

import contextlib
import io
import os
import shutil
import signal
import socket
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NoReturn, TextIO

# Exit statuses.
DONE, FAILED, BAD_INPUT = 0, 1, 2


def note(text: str) -> None:
    """Print a message for the user on one line of standard error."""
    write_message(f"angen: {' '.join(text.split())}\n")


def write_message(text: str, stream: TextIO | None = None) -> None:
    """Write a text to `stream`, by default standard error.

    Ignore errors, such as a closed stream, so that they do not end the command.
    """
    stream = stream or sys.stderr
    if stream is not None:
        with contextlib.suppress(OSError, ValueError):
            stream.write(text)
            stream.flush()


def prepare_output() -> None:
    """Let standard output have UTF-8 and the line ends of the text, whatever the system's are."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        # Windows would write the CR LF of a log as CR CR LF.
        sys.stdout.reconfigure(encoding="utf-8", newline="")


class ProgressText:
    """The progress of a command on standard error.

    In a terminal, each text overwrites the one before. Elsewhere a line is written now and then.

    Parameters
    ----------
    quiet
        Whether to write nothing.
    stream
        By default standard error.
    seconds
        The least time between two lines, elsewhere than in a terminal.
    """

    # s between two texts in a terminal, and the greatest length of a text.
    IN_TERMINAL_S, LENGTH = 0.2, 70

    def __init__(self, quiet: bool, stream: TextIO | None = None, seconds: float = 10.0) -> None:
        self._stream = stream or sys.stderr
        self._quiet = quiet
        self.in_terminal = self._stream is not None and self._stream.isatty()
        self._seconds = self.IN_TERMINAL_S if self.in_terminal else seconds
        self._shown = time.perf_counter()
        self._is_drawn = False

    def is_due(self, has_news: bool = False) -> bool:
        """Return whether to write a text now: the last one is old enough, or there is news."""
        now = time.perf_counter()
        if self._quiet or (now - self._shown < self._seconds and not has_news):
            return False
        self._shown = now
        return True

    def write(self, text: str) -> None:
        """Write a text."""
        self._is_drawn = self.in_terminal
        line = f"\r{text:<{self.LENGTH}}" if self.in_terminal else f"{text}\n"
        write_message(line, self._stream)

    def clear(self) -> None:
        """Remove the text from the terminal."""
        if self._is_drawn:
            write_message(f"\r{'':<{self.LENGTH}}\r", self._stream)


# Ends the process at once.


def leave_hard(status: int) -> NoReturn:
    """End the process at once, without the clean-up of Python and Blender.

    First flush the output, and remove Blender's temporary folder. If drivers have run Python, the
    clean-up of Blender's module would crash or hang.
    """
    bpy = sys.modules.get("bpy")
    folder = Path(bpy.app.tempdir) if bpy is not None else None
    # The folder of this session, not the one shared with other programs.
    if folder is not None and folder.name.startswith("blender_"):
        shutil.rmtree(folder, ignore_errors=True)
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(OSError, ValueError, AttributeError):
            stream.flush()
    os._exit(status)


# Ctrl-C and the signals that end a job, also during a long call into Blender, such as a render.

# s: if the work does not call `check` within this time after Ctrl-C, the process is ended.
PATIENCE_S = 0.7

SIGNALS = {
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
}


class Interrupt:
    """Context manager that handles Ctrl-C and other signals that end a command.

    At a signal it raises nothing: Blender would drop an exception raised in a frame handler.
    Instead, the next call of `check` raises KeyboardInterrupt. A second signal raises at once.

    `leave` is a function that ends the process. It is called if work inside `watched` does not call
    `check` soon after a signal.
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
        """Raise KeyboardInterrupt if a signal was received."""
        if self.came:
            raise KeyboardInterrupt

    @contextmanager
    def watched(self) -> Iterator[None]:
        """Context manager for work during which a signal may end the process at any point.

        Such work must not have written any output yet.
        """
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
