# SPDX-License-Identifier: GPL-3.0-or-later
"""Check the paths to which a log is written in a format, and find the path of each file."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from ..error import InputError
from ..files import check_folder, check_target, is_same_file
from . import Format, FormatFiles


def check_installed(target: Format) -> None:
    """Raise InputError if the package that a format needs is not installed."""
    if not target.is_installed:
        raise InputError(
            f"{target.name} needs {target.needs}, which is not installed: "
            f"pip install {target.needs}, or choose another format"
        )


def check_out(target: Format, out: Path, sources: Iterable[Path] = (), flag: str = "--out") -> None:
    """Raise InputError if the files of a format cannot be written to `out`.

    `sources` are files that the same command reads, and that `out` must not replace. `flag` is the
    option or the argument that names `out`.
    """
    check_installed(target)
    if any(is_same_file(out, source) for source in sources):
        raise InputError(f"{flag}: {out} is also read; give another name")
    if not target.is_folder and out.is_dir():
        raise InputError(f"{flag}: {out} is a folder; {target.name} is a file, give its name")
    if target.is_folder and out.exists() and not out.is_dir():
        raise InputError(f"{flag}: {out} is a file; {target.name} is a folder, give its name")
    check_folder(out if target.is_folder and out.exists() else out.parent, flag)
    check_target(out, flag)


def check_apart(flag: str, path: Path, others: Iterable[Path]) -> None:
    """Raise InputError if the file `path` cannot be written, or is one of `others`.

    `others` are the files that the same command also reads or writes. `flag` is the option of the
    command line that names the file.
    """
    if path.is_dir():
        raise InputError(f"{flag}: {path} is a folder, not a file name")
    if any(is_same_file(path, other) for other in others):
        raise InputError(f"{flag}: {path} is also read or written; give another name")
    check_folder(path.parent, flag)
    check_target(path, flag)


def output_files(target: Format, out: Path, written: FormatFiles) -> dict[Path, str | bytes]:
    """Return the contents that a format's writer made, by the path of each file.

    The files are in the folder `out` if the format is a folder. Else they are `out` itself and
    files beside it.
    """
    if target.is_folder:
        return {out / name: content for name, content in written.files.items()}
    return {
        out.with_name(f"{out.name}{suffix}") if suffix else out: content
        for suffix, content in written.files.items()
    }
