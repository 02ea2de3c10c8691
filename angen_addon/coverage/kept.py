# SPDX-License-Identifier: GPL-3.0-or-later
"""Keeps what panels show of the last map: plain values in the scene, so that undo and saving take
care of them."""

from __future__ import annotations

import json
from typing import Any

from ...sensor_logic.coverage.grid import CoverageMap

KEY = "angen_coverage_summary"


def keep(scene: Any, coverage: CoverageMap) -> None:
    rooms = [
        (room.name, room.cells * room.area, room.share, room.dead * room.area)
        for room in [*coverage.rooms(), coverage.total()]
    ]
    facts = {"motion": coverage.motion.label, "sensors": len(coverage.sensors), "rooms": rooms}
    scene[KEY] = json.dumps(facts)


def summary(scene: Any) -> dict[str, Any] | None:
    """`motion`, number of `sensors`, `rooms` as (name, m², share, dead m²), all rooms last."""
    if KEY not in scene:
        return None
    try:
        found = json.loads(scene[KEY])
        return found if {"motion", "sensors", "rooms"} <= set(found) else None
    except (ValueError, TypeError):
        return None


def forget(scene: Any) -> None:
    scene.pop(KEY, None)
