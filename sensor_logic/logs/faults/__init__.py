# SPDX-License-Identifier: GPL-3.0-or-later
"""Simulated faults: change a log as lost messages, wrong clocks and stuck sensors would."""

from .make import FaultyLog, make_faults, truth_csv, undo
from .plan import Fault, FaultPlan, read_plan

__all__ = ["Fault", "FaultPlan", "FaultyLog", "make_faults", "read_plan", "truth_csv", "undo"]
