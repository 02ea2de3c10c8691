# SPDX-License-Identifier: GPL-3.0-or-later
"""`angen doctor`: the findings as lines or as JSON."""

from __future__ import annotations

import json

import bpy

from ...sensor_logic.wording import plural
from . import Finding, examine


def findings() -> list[Finding]:
    """The findings in the scene of the present context."""
    context = bpy.context
    return examine(context.scene, context.view_layer, context.evaluated_depsgraph_get())


def as_text(found: list[Finding], as_json: bool) -> str:
    """Two lines for each finding, what is wrong and the way to mend it; or a JSON list."""
    if as_json:
        entries = [finding._asdict() for finding in found]
        return json.dumps(entries, indent=1, ensure_ascii=False) + "\n"
    return "".join(f"{one.check}: {one.text}\n    {one.mend}\n" for one in found)


def count(found: list[Finding]) -> str:
    return f"{plural(len(found), 'thing')} to mend" if found else "nothing to mend was found"
