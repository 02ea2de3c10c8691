# SPDX-License-Identifier: GPL-3.0-or-later
"""The options `--faults` and `--truth` of the commands that write logs.

`--faults` adds faults (lost, late or doubled messages) to a log. `--truth` names the file that
lists these faults.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from ...sensor_logic.logs.error import InputError
from ...sensor_logic.logs.faults import FaultPlan, make_faults, read_plan, truth_csv
from ...sensor_logic.logs.formats import Log


def add_options(parser: Any, path: Any) -> None:
    """Add the options `--faults` and `--truth` to a parser; `path` converts their arguments."""
    parser.add_argument(
        "--faults",
        type=path,
        metavar="FILE.toml",
        help="add faults to the log: messages lost, late or doubled, clocks that drift, "
        "batteries that die, stuck sensors, false alarms",
    )
    parser.add_argument(
        "--truth",
        type=path,
        metavar="FILE.csv",
        help="list of the changes made by --faults (default: LOG.truth.csv beside the log)",
    )


class Faults:
    """A faults file, and the file that lists the changes it makes to a log.

    Parameters
    ----------
    faults
        The faults file; None to leave logs unchanged.
    truth
        The file to write with the list of changes; by default beside the log.
    log
        The file of the log with faults; None if the log goes to standard output.

    Raises
    ------
    InputError
        If the options contradict each other or the faults file is invalid.
    OSError
        If the faults file cannot be read.
    """

    def __init__(self, faults: Path | None, truth: Path | None, log: Path | None) -> None:
        if faults is None and truth is not None:
            raise InputError(
                "--truth lists the changes made by --faults: give --faults FILE.toml too"
            )
        if faults is not None and truth is None:
            if log is None:
                raise InputError(
                    "--faults needs --truth FILE.csv, for the list of changes to the log"
                )
            truth = log.with_name(f"{log.name}.truth.csv")
        self.file, self.truth = faults, truth
        self.plan: FaultPlan | None = read_plan(faults) if faults else None

    def check_names(self, sensors: Iterable[str]) -> None:
        """Raise InputError if the faults file names a sensor that is not in `sensors`."""
        if self.plan:
            self.plan.check_names(sensors)

    def of(self, log: Log) -> tuple[Log, dict[Path, str]]:
        """Return the log with the faults, and a dictionary from the path of `truth` to its text.

        Without a faults file, return the same log and an empty dictionary.
        """
        if not (self.plan and self.truth):
            return log, {}
        faulty = make_faults(log, self.plan)
        return faulty.log, {self.truth: truth_csv(faulty)}
