# SPDX-License-Identifier: GPL-3.0-or-later
"""Polls that several operators use, and a function that reports an error."""

from __future__ import annotations

from typing import Any

from bpy.types import Context

from ..angen_addon.runtime.running import is_running
from ..angen_addon.scene.instances import is_sensor, stands_for
from ..angen_addon.translations.interface import translated


def needs(operator: Any, condition: Any, message: str) -> bool:
    """Return whether a condition holds; if it does not, set `message` as the poll message."""
    if not condition:
        operator.poll_message_set(translated(message))
    return bool(condition)


def cancelled(operator: Any, problem: Any) -> set[str]:
    """Report `problem` as an error, and return {"CANCELLED"}."""
    operator.report({"ERROR"}, translated(str(problem)))
    return {"CANCELLED"}


def is_idle(operator: Any, _context: Context) -> bool:
    """Poll: whether no simulation is running."""
    return needs(operator, not is_running(), "A simulation is running: wait, or press Esc")


def can_read_scene(operator: Any, context: Context) -> bool:
    """Poll: whether no simulation is running and the mode is Object Mode."""
    return is_idle(operator, context) and needs(
        operator, context.mode == "OBJECT", "Switch to Object Mode first"
    )


def can_add(operator: Any, context: Context) -> bool:
    """Poll: whether a new object can be added."""
    return needs(
        operator, context.mode == "OBJECT", "Switch to Object Mode to add a sensor"
    ) and has_editable_collection(operator, context)


def has_editable_collection(operator: Any, context: Context) -> bool:
    """Poll: whether the active collection belongs to this file."""
    return needs(
        operator,
        context.collection.is_editable,
        "The active collection is linked: choose one of this file",
    )


def has_sensor(operator: Any, context: Context) -> bool:
    """Poll: whether the active object is a sensor, or its housing."""
    return needs(operator, is_sensor(stands_for(context.object)), "Select a sensor")


def can_change_sensor(operator: Any, context: Context) -> bool:
    """Poll: whether the active object is a sensor that can be edited."""
    return has_sensor(operator, context) and needs(
        operator,
        stands_for(context.object).is_editable,
        "The sensor is linked: make it local or a library override",
    )
