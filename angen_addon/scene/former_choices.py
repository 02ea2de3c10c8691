# SPDX-License-Identifier: GPL-3.0-or-later
"""Replace enum values of parameters that earlier versions of the extension wrote to a file."""

from __future__ import annotations

from typing import Any

import bpy

from ...sensor_logic.kinds import KINDS
from ...sensor_logic.parameters import FormerChoice, former_text, specs
from .animation import played_curves


def stored_settings(obj: Any) -> Any | None:
    """Return the settings of an object's sensor as the file stores them; None without a sensor.

    In these settings, an enum is the number of its item.
    """
    stored = getattr(obj, "bl_system_properties_get", None)
    groups = stored() if stored is not None else obj
    return groups.get("angen_sensor") if groups is not None else None


def replace_former_choices() -> str:
    """Replace enum values of earlier versions in all objects (also linked) and in keyframes.

    Return a sentence about the replaced values for the user; empty if there were none.
    """
    found: list[tuple[str, str, FormerChoice]] = []
    for obj in bpy.data.objects:
        settings = stored_settings(obj)
        if settings is None:
            continue
        for kind in KINDS.values():
            group = settings.get(kind.attribute)
            for name, spec in specs(kind.parameters).items() if group is not None else ():
                numbers = {choice.identifier: choice.number for choice in spec.choices}
                for former in spec.former:
                    path = f"angen_sensor.{kind.attribute}.{name}"
                    keyed = _replace_keys(obj, path, former.number, numbers[former.now])
                    if group.get(name) == former.number:
                        setattr(getattr(obj.angen_sensor, kind.attribute), name, former.now)
                    elif not keyed:
                        continue
                    obj.update_tag()
                    if obj.angen_sensor.kind == kind.identifier:
                        found.append((obj.name, name, former))
    return former_text(found)


def _replace_keys(obj: Any, path: str, before: int, now: int) -> bool:
    """Replace the value `before` by `now` in the keyframes of a data path.

    Return whether any keyframe had the value `before`.
    """
    curves = [curve for curve in played_curves(obj) if curve.data_path == path]
    keys = [key for curve in curves for key in curve.keyframe_points if key.co.y == before]
    for key in keys:
        key.co.y = now
    for curve in curves if keys else ():
        curve.update()
        curve.id_data.update_tag()
    return bool(keys)
