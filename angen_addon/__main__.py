# SPDX-License-Identifier: GPL-3.0-or-later
"""`python -m angen_addon simulate HOME.blend …`: the command line through the bpy wheel."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path

from .quiet import standard_output_silenced
from .standalone import PACKAGE, load_extension

VERBS = "{simulate,list,check,explain,coverage,place,convert,compare}"
# Verbs that read logs alone, each in the module of its name.
WITHOUT_BLENDER = ("convert", "compare")
PROGRAM = "python -m angen_addon"
USAGE = f"usage: python -m angen_addon {VERBS} HOME.blend [options]\n"


def main(arguments: list[str]) -> int:
    if len(arguments) == 1 and arguments[0] in {"-h", "--help"}:
        sys.stdout.write(USAGE + "Give --help after the verb for its options.\n")
        return 0
    verb, options = arguments[:1], arguments[1:]
    if verb and verb[0] in WITHOUT_BLENDER:
        load_extension()
        return int(import_module(f"{PACKAGE}.angen_addon.{verb[0]}").main(options, PROGRAM))
    help_only = "-h" in options or "--help" in options
    file = None
    if not help_only:
        if not options or options[0].startswith("-"):
            sys.stderr.write(USAGE + "angen: the blend file comes right after the verb\n")
            return 2
        file, options = Path(options[0]), options[1:]
        problem = unreadable(file)
        if problem:
            sys.stderr.write(f"angen: {problem}\n")
            return 2
    with standard_output_silenced():
        import bpy  # noqa: F401  (Blender 5.2 greets on standard output)
    extension = load_extension()
    extension.register()
    try:
        command_line = import_module(f"{PACKAGE}.angen_addon.command_line")
        problem = open_file(file) if file else ""
        if problem:
            sys.stderr.write(f"angen: {problem}\n")
            return 2
        return int(command_line.run_command(verb + options, PROGRAM))
    finally:
        # A handler that is still registered keeps the process from ending after a render.
        extension.unregister()


def unreadable(file: Path) -> str:
    """Why `file` cannot be a blend file, where that can be told without Blender."""
    try:
        with open(file, "rb") as opened:
            start = opened.read(7)
    except IsADirectoryError:
        return f"{file} is a folder; give a blend file"
    except OSError as error:
        return f"cannot read {file}: {error.strerror}"
    if not start:
        return f"{file} is empty"
    # Plain, gzip and Zstandard blend files.
    if not (start == b"BLENDER" or start[:2] == b"\x1f\x8b" or start[:4] == b"\x28\xb5\x2f\xfd"):
        return f"{file} is not a blend file"
    return ""


def open_file(file: Path) -> str:
    """Opens `file`; returns why that failed, in a line."""
    import bpy

    try:
        with standard_output_silenced():
            bpy.ops.wm.open_mainfile(filepath=str(file.absolute()), load_ui=False)
    except RuntimeError as error:
        reason = " ".join(str(error).removeprefix("Error:").split())
        return f"cannot open {file}: {reason}"
    return ""


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
