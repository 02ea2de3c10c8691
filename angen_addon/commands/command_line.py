# SPDX-License-Identifier: GPL-3.0-or-later
"""`blender HOME.blend --command angen VERB …`: runs the subcommands of `angen` without a window."""

from __future__ import annotations

import sys
from typing import Any

import bpy

from ...sensor_logic.logs.error import AngenError
from ..output.output_files import Outputs
from ..process.console import FAILED, Interrupt, leave_hard, note, prepare_output
from ..process.parser import parse, verb_of
from ..process.system import fill_closed_streams, standard_output_silenced

INTERRUPTED = "interrupted; nothing was written"


def run_command(arguments: list[str], program: str = "blender FILE.blend --command angen") -> int:
    """Run a subcommand of `angen` on the open file, and return the exit status.

    `arguments` begin with the name of the subcommand. `program` is the text before it in the help.
    """
    fill_closed_streams()
    prepare_output()
    try:
        options = parse(arguments, program)
    except SystemExit as stop:
        return int(stop.code or 0)
    try:
        with Interrupt(_give_up) as options.interrupt, Outputs() as outputs:
            with standard_output_silenced():
                status = verb_of(options.verb).run(options, outputs)
            options.interrupt.check()
            if outputs.printed and sys.stdout is None and options.verb != "check":
                raise AngenError("standard output is closed: redirect it to a file")
            outputs.commit()
            return status
    except AngenError as error:
        note(str(error))
        return error.status
    except BrokenPipeError:
        # The reader of the output has closed it, as `head` does.
        sys.stdout = None  # type: ignore[assignment]
        return FAILED
    except OSError as error:
        # Only standard output is left: errors of files are handled where they are written.
        sys.stdout = None  # type: ignore[assignment]
        note(f"cannot write to standard output: {error.strerror}")
        return FAILED
    except KeyboardInterrupt:
        note(INTERRUPTED)
        return FAILED


def _give_up() -> None:
    note(INTERRUPTED)
    leave_hard(FAILED)


_command: Any = None


def register() -> None:
    """Register the command `angen` of Blender's command line."""
    global _command
    _command = bpy.utils.register_cli_command("angen", run_command)


def unregister() -> None:
    """Unregister the command `angen`."""
    bpy.utils.unregister_cli_command(_command)
