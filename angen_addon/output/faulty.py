# SPDX-License-Identifier: GPL-3.0-or-later
"""`--faults FILE.toml --truth FILE.csv` of the commands that write logs."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from ...sensor_logic.error import InputError
from ...sensor_logic.faults import FaultPlan, make_faults, read_plan, truth_csv
from ...sensor_logic.formats import Log


def add_options(parser: Any, path: Any) -> None:
    parser.add_argument(
        "--faults",
        type=path,
        metavar="FILE.toml",
        help="make the log faulty on purpose: messages lost, late or doubled, clocks that drift, "
        "batteries that die, stuck sensors, false alarms",
    )
    parser.add_argument(
        "--truth",
        type=path,
        metavar="FILE.csv",
        help="list of what --faults did to the log (default: LOG.truth.csv beside it)",
    )


class Faults:
    """A faults file, and the file that will list what it did to a log. Without a faults file, logs
    stay as they are."""

    def __init__(self, faults: Path | None, truth: Path | None, log: Path | None) -> None:
        """`log`: the file of the faulty log. Raises InputError, which names what is wrong and
        where, and OSError."""
        if faults is None and truth is not None:
            raise InputError("--truth lists what --faults did: give --faults FILE.toml too")
        if faults is not None and truth is None:
            if log is None:
                raise InputError(
                    "--faults changes the log: give --truth FILE.csv for the list of changes"
                )
            truth = log.with_name(f"{log.name}.truth.csv")
        self.file, self.truth = faults, truth
        self.plan: FaultPlan | None = read_plan(faults) if faults else None

    def check_names(self, sensors: Iterable[str]) -> None:
        """Raises InputError where the faults file names a sensor that is not one of these."""
        if self.plan:
            self.plan.check_names(sensors)

    def of(self, log: Log) -> tuple[Log, dict[Path, str]]:
        """The log with its faults, and the texts of further files by path."""
        if not (self.plan and self.truth):
            return log, {}
        faulty = make_faults(log, self.plan)
        return faulty.log, {self.truth: truth_csv(faulty)}
