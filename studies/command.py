# SPDX-License-Identifier: GPL-3.0-or-later
"""The commands `angen study run STUDY.toml --out DIR` and `angen study report DIR`.

They run outside Blender: only the worker processes load it.
"""

from __future__ import annotations

import argparse
import os
import signal
import time
from dataclasses import replace

from ..angen_addon.process.console import (
    BAD_INPUT,
    DONE,
    FAILED,
    ProgressText,
    note,
)
from ..angen_addon.process.parser import Parser, add_choice, choice_of, path, whole_number
from ..parts import installation
from ..sensor_logic.logs.error import InputError
from ..sensor_logic.logs.wording import part_is, plural, shown_duration
from . import study

# Packages of the extra [study], which are imported where they are used.
LIBRARIES = (
    "dask",
    "distributed",
    "jinja2",
    "markupsafe",
    "matplotlib",
    "pandas",
    "pyarrow",
    "scipy",
)


def main(arguments: list[str], program: str) -> int:
    """Run a study or write its report, and return the exit status.

    Raise `SystemExit` if an option is invalid.
    """
    options = make_parser(program).parse_args(arguments)
    try:
        work = {"run": _run, "report": _report}[options.what]
        return work(options)
    except ModuleNotFoundError as error:
        if error.name not in LIBRARIES:
            raise
        note(f"{error}: to install it, {installation('studies')}")
    except InputError as error:
        note(str(error))
    return BAD_INPUT


def _run(options: argparse.Namespace) -> int:
    wanted = replace(study.read(options.study), choice=choice_of(options))
    from . import engine, results

    jobs = options.jobs or os.cpu_count() or 1
    clients = (
        engine.remote_client(options.scheduler) if options.scheduler else engine.local_client(jobs)
    )
    line = _ProgressLine()
    # A background job of a shell starts with Ctrl-C ignored, and so do its children.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    with results.Store(options.out) as store, clients as client:
        driver = engine.Driver(wanted, store, client)
        try:
            driver.run(line.show)
        except (InputError, KeyboardInterrupt) as error:
            line.end()
            done = f"{part_is(driver.kept(), driver.total, 'run')} done"
            if isinstance(error, InputError):
                note(f"{done}: {error}")
            else:
                note(f"interrupted: {done} and kept; give the same command again to continue")
            try:
                driver.write_tables()
            except InputError as error:
                # On a full disk the tables fail too.
                note(str(error))
            return FAILED
        line.end()
        driver.write_tables()
    note(f"{part_is(line.done, driver.total, 'run')} in {options.out}; see `study report`")
    if line.failed:
        note(
            f"{line.failed} of {plural(driver.total, 'run')} failed: see the column error of "
            "results.csv"
        )
    return FAILED if line.failed else DONE


def _report(options: argparse.Namespace) -> int:
    # Before the import, which fails without the extra.
    if not options.folder.is_dir():
        raise InputError(f"there is no folder {options.folder}: give the --out of `study run`")
    from . import report

    note(f"written: {report.write(options.folder)}")
    return DONE


class _ProgressLine:
    """The progress of a study on standard error."""

    def __init__(self) -> None:
        self.done = self.failed = self._first = 0
        self._begin = 0.0
        self._text = ProgressText(quiet=False)
        self._started = False

    def show(self, done: int, total: int, failed: int) -> None:
        """Show the progress, if the last text is old enough."""
        if not self._started:
            self._started, self._first = True, done
            self._begin = time.monotonic()
            runs = plural(total, "run")
            note(f"{part_is(done, total, 'run')} already done" if done else runs)
        self.done, self.failed = done, failed
        if not self._text.is_due():
            return
        rate = (done - self._first) / max(time.monotonic() - self._begin, 1e-9)
        left = f", {shown_duration((total - done) / rate)} left" if rate else ""
        bad = f", {failed} failed" if failed else ""
        text = f"{done} of {plural(total, 'run')}, {rate:.1f} a second{left}{bad}"
        self._text.write(text)

    def end(self) -> None:
        """Clear the line."""
        self._text.clear()


def make_parser(program: str) -> Parser:
    """Return the argument parser of both commands."""
    parser = Parser(
        prog=f"{program} study",
        description="Simulate a home many times with different parameters, and report the results.",
    )
    verbs = parser.add_subparsers(dest="what", required=True, metavar="run | report")
    run = verbs.add_parser("run", help="simulate the runs of a study that are not done yet")
    run.add_argument(
        "study",
        type=path,
        metavar="STUDY.toml",
        help="study: the homes, and the parameters that vary",
    )
    run.add_argument(
        "--out", type=path, required=True, metavar="DIR", help="folder for the results"
    )
    where = run.add_mutually_exclusive_group()
    where.add_argument(
        "--jobs",
        type=whole_number(1, 4096),
        metavar="N",
        help="number of processes on this computer (default: one for each core)",
    )
    where.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="address of a Dask scheduler, such as tcp://HOST:8786",
    )
    add_choice(run)
    report = verbs.add_parser("report", help="write DIR/report.html from the results")
    report.add_argument(
        "folder", type=path, metavar="DIR", help="folder of the results, the --out of `run`"
    )
    return parser
