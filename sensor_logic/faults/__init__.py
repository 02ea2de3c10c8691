# SPDX-License-Identifier: GPL-3.0-or-later
"""Faults on purpose: a log as it would be with lost messages, bad clocks and stuck sensors."""

from .make import Faulty, make_faults
from .plan import Fault, Plan, read_plan
from .truth import truth_csv, undo

__all__ = ["Fault", "Faulty", "Plan", "make_faults", "read_plan", "truth_csv", "undo"]
