# SPDX-License-Identifier: GPL-3.0-or-later
"""Replaces choices of parameters that the open file has from earlier versions of the extension."""

from __future__ import annotations

from typing import Any

import bpy

from ...sensor_logic.kinds import KINDS
from ...sensor_logic.parameters import FormerChoice, former_text, specs


def stored_settings(obj: Any) -> Any | None:
    """Return the settings of an object's sensor as the file stores them, with numbers for choices;
    None where it has none."""
    stored = getattr(obj, "bl_system_properties_get", None)
    groups = stored() if stored is not None else obj
    return groups.get("angen_sensor") if groups is not None else None


def replace_former_choices() -> str:
    """Replace former choices of all objects, linked ones too; return a sentence on them, empty
    without any."""
    found: list[tuple[str, str, FormerChoice]] = []
    for obj in bpy.data.objects:
        settings = stored_settings(obj)
        if settings is None:
            continue
        for kind in KINDS.values():
            group = settings.get(kind.attribute)
            for name, spec in specs(kind.parameters).items() if group is not None else ():
                for former in spec.former:
                    if group.get(name) == former.number:
                        setattr(getattr(obj.angen_sensor, kind.attribute), name, former.now)
                        obj.update_tag()
                        if obj.angen_sensor.kind == kind.identifier:
                            found.append((obj.name, name, former))
    return former_text(found)
