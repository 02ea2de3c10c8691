# SPDX-License-Identifier: GPL-3.0-or-later
"""What the pyroelectric detector is held to: many rays and updates, and who must not be seen."""

from __future__ import annotations

from typing import Any

from .bounds import Bounds

# Relative error (rms) of the peak signal by rays a zone and rate, against 300 rays at 120 Hz.
# Measured over 12 walks: 4.2 % by the default at 24 Hz, 0.8 % by many rays at 60 Hz.
RMS = {(12, 60.0): 0.05, (12, 24.0): 0.075, (48, 60.0): 0.015, (48, 24.0): 0.03}
PERSONS = ("NEMA walk", "walk", "slow walk", "child")
# Least share of passes detected: 75 % of a child's, the least of them.
SEEN = 0.6
# There is nothing to feel where a body is as warm as the room, and too little half a degree above.
UNFELT = ("walk of something as warm as the room", "walk, room of 31 °C")
CAT = "cat"
# The range scan sees them all, as it needs no warmth.
SCANNED = (*PERSONS, CAT, *UNFELT, "walk, room of 28 °C", "walk at 0.1 m/s")


def check(data: dict[str, Any], bounds: Bounds) -> None:
    error = {(row["zone_rays"], row["rate"]): row for row in data["error"]}
    bounds.measured("rays a zone and rates", error, RMS)
    for (rays, rate), most in RMS.items():
        name = f"{rays} rays a zone at {rate:g} Hz: error of the peak, rms"
        bounds.at_most(name, error[rays, rate]["rms"], most)
    for row in data["cost"]:
        name = f"{row['model']}, {row['rays']} rays, in the home: updates"
        bounds.at_least(name, row["updates"], 1)
    scan = [row["active"] for row in data["cost"] if row["model"] == "RANGE_SCAN"]
    bounds.at_least("range scan in the home: updates with movement", min(scan), 1)
    models = {row["situation"]: row for row in data["models"]}
    bounds.measured("situations", models, SCANNED)
    for name in PERSONS:
        felt = models[name]["pyroelectric"]["detected"]
        bounds.at_least(f"{name}: passes felt", felt, SEEN)
    for name in UNFELT:
        felt = models[name]["pyroelectric"]["detected"]
        bounds.equal(f"{name}: passes felt", felt, 0.0)
    for name in SCANNED:
        seen = models[name]["all tilts"]["detected"]
        bounds.equal(f"{name}: passes scanned", seen, 1.0)
