# SPDX-License-Identifier: GPL-3.0-or-later
"""Studies, measured by `study_runs` in a process without Blender, as that of a driver is."""

from __future__ import annotations

import json
import subprocess
import sys
from typing import Any


def measure(quick: bool) -> dict[str, Any]:
    command = [sys.executable, "-m", "benchmarks.study_runs", "quick" if quick else "whole"]
    told = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout
    found: dict[str, Any] = json.loads(told)
    return found
