# SPDX-License-Identifier: GPL-3.0-or-later
"""Polls that operators share. Each returns whether the operator can run; if not, it sets the poll
message."""

from __future__ import annotations

from typing import Any

from bpy.types import Context

from ..angen_addon.runtime import state
from ..sensor_logic.kinds import NO_KIND


def is_idle(operator: Any) -> bool:
    """Whether no simulation is running."""
    return not _refuse(operator, state.CACHE.running, "A simulation is running")


def can_look(operator: Any, context: Context) -> bool:
    """For operators that look at the whole scene."""
    return is_idle(operator) and not _refuse(
        operator, context.mode != "OBJECT", "Switch to Object Mode first"
    )


def can_add(operator: Any, context: Context) -> bool:
    """For operators that add sensors."""
    return not (
        _refuse(operator, context.mode != "OBJECT", "Switch to Object Mode to add a sensor")
        or _refuse(
            operator,
            not context.collection.is_editable,
            "The active collection is linked: choose one of this file",
        )
    )


def has_sensor(operator: Any, context: Context) -> bool:
    """Whether the active object is a sensor."""
    obj = context.object
    is_sensor = obj is not None and obj.angen_sensor.kind != NO_KIND
    return not _refuse(operator, not is_sensor, "Select a sensor")


def can_change_sensor(operator: Any, context: Context) -> bool:
    """For operators that change the active sensor."""
    return has_sensor(operator, context) and not _refuse(
        operator,
        not context.object.is_editable,
        "The sensor is linked: make it local or a library override",
    )


def _refuse(operator: Any, problem: bool, message: str) -> bool:
    """Sets the poll message if there is a problem; returns whether there is."""
    if problem:
        operator.poll_message_set(message)
    return problem
