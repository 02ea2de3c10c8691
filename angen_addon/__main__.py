# SPDX-License-Identifier: GPL-3.0-or-later
"""The command `angen` with the bpy package: `python -m angen_addon VERB HOME.blend`.

VERB is a subcommand, such as `simulate`.
"""

from __future__ import annotations

import os
import signal
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import NoReturn

from .process.console import leave_hard, note, prepare_output, write_message
from .process.standalone import PACKAGE, load_extension, open_file, unreadable
from .process.system import fill_closed_streams, standard_output_silenced

# Verbs whose blend file is not their first argument, with its position.
HOME_AT = {"apply": 1}
PROGRAM = "python -m angen_addon"
# The name of the command that `pip install` makes.
COMMAND = "angen"
TRUSTED = "--enable-autoexec"
# Set before numpy is loaded. Otherwise each of its threads keeps a core busy while it waits for
# the next small matrix. The processes of `--jobs` use the cores instead.
ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1"}
# Verbs whose `--jobs` option starts processes that each load Blender.
WITH_JOBS = ("day",)
INTERRUPTED = "interrupted; nothing was written"
USAGE = """usage: {0} {{{1}}} HOME.blend [options]
       {0} {{{2}}} [options]
"""


def main(arguments: list[str]) -> int:
    """Run the command line and return its exit status.

    `arguments` are the words after the program's name: the subcommand, the blend file and the
    options.
    """
    prepare_output()
    for name, value in ONE_THREAD.items():
        os.environ.setdefault(name, value)
    extension = load_extension()
    parser = import_module(f"{PACKAGE}.angen_addon.process.parser")
    parts = import_module(f"{PACKAGE}.parts")
    verbs = parser.verbs_here()
    program = COMMAND if Path(sys.argv[0]).stem == COMMAND else PROGRAM
    usage = USAGE.format(program, ",".join(verbs), ",".join(parts.WITHOUT_BLENDER))
    verb, options = arguments[:1], arguments[1:]
    if verb and verb[0] in {"-h", "--help"}:
        sys.stdout.write(usage + "Give --help after the verb for its options.\n")
        return 0
    if verb and verb[0] in parts.WITHOUT_BLENDER and not parser.lacking(verb[0]):
        return int(parts.part(parts.WITHOUT_BLENDER[verb[0]]).main(options, program))
    if verb and verb[0] not in verbs:
        note(parser.wrong_verb(verb[0]))
        return 2
    help_only = "-h" in options or "--help" in options
    file = None
    if not help_only:
        if not options or options[0].startswith("-"):
            missing = "the blend file comes right after the verb" if verb else "give a verb"
            write_message(f"{usage}angen: {missing}\n")
            return 2
        position = HOME_AT.get(verb[0], 0)
        if len(options) <= position:
            write_message(f"usage: {program} {verb[0]} LAYOUT.json HOME.blend [options]\n")
            return 2
        file = Path(options.pop(position))
        problem = unreadable(file)
        if problem:
            note(problem)
            return 2
    with standard_output_silenced(), _ended_by_ctrl_c():
        with _on_one_core(verb[0] in WITH_JOBS and _has_jobs(options)):
            import bpy  # noqa: F401  (Blender 5.2 greets on standard output)

        extension.register()
        command_line = import_module(f"{PACKAGE}.angen_addon.commands.command_line")
        trusted = TRUSTED in options
        options = [option for option in options if option != TRUSTED]
        problem = open_file(file, trusted) if file else ""
    if problem:
        note(problem)
        return 2
    return int(command_line.run_command(verb + options, program))


def _has_jobs(options: list[str]) -> bool:
    line = " ".join([*options, ""]).replace("--jobs=", "--jobs ")
    return "--jobs " in line and "--jobs 1 " not in line


@contextmanager
def _on_one_core(is_wanted: bool) -> Iterator[None]:
    """Context manager: if `is_wanted`, restrict this process to one CPU core; on exit, lift that.

    Blender starts as many threads as it finds cores. With several processes, the threads would wait
    for each other at every frame, and a run would take half as long again.
    """
    if not is_wanted or not hasattr(os, "sched_setaffinity"):
        yield
        return
    cores = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {max(cores)})
    try:
        yield
    finally:
        os.sched_setaffinity(0, cores)


@contextmanager
def _ended_by_ctrl_c() -> Iterator[None]:
    """Context manager: Ctrl-C ends the process at once while Blender starts and opens the file.

    Blender drops exceptions that are raised inside its handlers, so KeyboardInterrupt could be
    lost.
    """
    before = signal.signal(signal.SIGINT, lambda *_: _give_up())
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before or signal.SIG_DFL)


def _give_up() -> NoReturn:
    note(INTERRUPTED)
    leave_hard(1)


def command() -> NoReturn:
    """Run the command line and exit: the entry point of `angen` and `python -m angen_addon`."""
    fill_closed_streams()
    status = 1
    try:
        status = main(sys.argv[1:])
    except SystemExit as stop:
        status = int(stop.code or 0)
    except KeyboardInterrupt:
        note(INTERRUPTED)
    except BaseException:
        traceback.print_exc()
    finally:
        leave_hard(status)


if __name__ == "__main__":
    command()
