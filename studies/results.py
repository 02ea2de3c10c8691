# SPDX-License-Identifier: GPL-3.0-or-later
"""Store the results of a study in `runs.jsonl`, a line for each run, and write tables of them.

The tables are `results.csv` and `results.parquet`.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas

from ..parts import installation
from ..sensor_logic.logs.error import AngenError, InputError, replaced
from ..sensor_logic.logs.files import Content, InUseError, check_target, fcntl, write_files

if TYPE_CHECKING:
    from .tasks import RunResult

RUNS, CSV, PARQUET, LOGS = "runs.jsonl", "results.csv", "results.parquet", "logs"
# Folder with the days of unfinished runs.
DAYS = "days"
# File that describes the study for the report.
FACTS = "study.json"
# Parquet types of columns, by the type that pandas infers; all others are text.
TYPES = {
    "boolean": "bool_",
    "integer": "int64",
    "floating": "float64",
    "mixed-integer-float": "float64",
    "empty": "null",
}
Row = dict[str, Any]


class Store:
    """The folder of a study's results; as a context manager, it closes its file on exit.

    Raise `InputError` if the folder cannot be written, or if another study is writing into it.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        taken = InputError(
            f"another process writes a study into {folder}: wait for its end, or give another "
            "folder"
        )
        try:
            folder.mkdir(parents=True, exist_ok=True)
            if fcntl is None:
                # Windows replaces no file that another process has open.
                with replaced(str(taken), InUseError):
                    check_target(folder / RUNS, "")
            self._file = open(folder / RUNS, "a+b")  # noqa: SIM115  (closed by __exit__)
        except OSError as error:
            raise InputError(
                f"cannot write in {folder}: {error.strerror}; give another folder"
            ) from None
        if fcntl is not None:
            try:
                fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                self._file.close()
                raise taken from None
        # Offset of the line of each run in the file, by digest.
        self._at: dict[str, int] = {}
        self.failed: set[str] = set()
        self.read()

    def __enter__(self) -> Store:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def _error(self, error: OSError) -> InputError:
        return InputError(
            f"cannot write in {self.folder}: {error.strerror}; the finished runs are kept: give "
            "the same command again to continue"
        )

    def read(self) -> None:
        """Read `runs.jsonl`, and remove an incomplete last line."""
        self._file.seek(0)
        end = 0
        for line in self._file:
            try:
                row = json.loads(line) if line.endswith(b"\n") else None
            except ValueError:
                row = None
            if isinstance(row, dict) and "digest" in row:
                self._index(row, end)
                end += len(line)
            elif line.endswith(b"\n"):
                raise InputError(
                    f"{self.folder / RUNS} was not written by a study; give another folder"
                )
            else:
                self._file.truncate(end)

    def _index(self, row: Row, at: int) -> None:
        """Store the position of a run's line in the file, and whether the run failed."""
        digest = row["digest"]
        self._at[digest] = at
        (self.failed.add if row["error"] else self.failed.discard)(digest)

    def has(self, digest: str) -> bool:
        """Return whether the run with this digest has a stored result without an error."""
        return digest in self._at and digest not in self.failed

    def add(self, done: RunResult, versions: dict[str, str]) -> None:
        """Store the result `done` of a run, with the versions of the software that simulated it.

        If that fails, raise `InputError`, and store no part of the line.
        """
        row = {
            "digest": done.digest,
            "values": done.values,
            "seconds": round(done.seconds, 4),
            "error": done.error,
            "versions": versions,
        }
        at = self._file.seek(0, os.SEEK_END)
        try:
            for name, text in done.files.items():
                path = self.folder / LOGS / name
                path.parent.mkdir(parents=True, exist_ok=True)
                write_files({path: text})
            self._file.write(json.dumps(row).encode() + b"\n")
            self._file.flush()
            os.fsync(self._file.fileno())
        except OSError as error:
            self._file = _restore_file(self._file, at)
            raise self._error(error) from None
        except AngenError as error:
            raise InputError(f"{error}; the finished runs are kept") from None
        self._index(row, at)

    def row(self, digest: str) -> Row | None:
        """Return the stored result of the run with this digest, or None if there is none."""
        if digest not in self._at:
            return None
        self._file.seek(self._at[digest])
        found: Row = json.loads(self._file.readline())
        return found


def _restore_file(file: Any, at: int) -> Any:
    """Cut the file to `at` bytes, which removes an incomplete line, and return it opened again."""
    path = file.name
    with contextlib.suppress(OSError):
        file.close()
    os.truncate(path, at)
    return open(path, "a+b")


def write_tables(folder: Path, rows: Iterable[Row]) -> list[str]:
    """Write both tables of results; return a list of messages about tables that were not written.

    Raise `InputError` if the folder cannot be written.
    """
    table = pandas.DataFrame(list(rows), dtype=object)
    for name in ("seconds", "digest", "error"):
        table[name] = table.pop(name) if name in table else None
    types = {name: TYPES.get(pandas.api.types.infer_dtype(table[name]), "string") for name in table}
    flags = [name for name, kind in types.items() if kind == "bool_"]
    # Boolean columns are written as 1 and 0.
    plain = table.assign(**{name: table[name].astype("boolean").astype("Int64") for name in flags})
    files: dict[Path, Content] = {folder / CSV: plain.to_csv(index=False, lineterminator="\n")}
    missing = []
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError as error:
        missing = [f"{PARQUET} was not written ({error}): to get it, {installation('studies')}"]
    else:
        texts = [name for name, kind in types.items() if kind == "string"]
        table[texts] = table[texts].map(str, na_action="ignore")
        schema = pyarrow.schema([(name, getattr(pyarrow, kind)()) for name, kind in types.items()])
        found = pyarrow.Table.from_pandas(table, schema).replace_schema_metadata()
        packed = io.BytesIO()
        pyarrow.parquet.write_table(found, packed)
        files[folder / PARQUET] = packed.getvalue()
    try:
        write_files(files)
    except AngenError as error:
        raise InputError(f"{error}; the results of the runs are kept") from None
    return missing
