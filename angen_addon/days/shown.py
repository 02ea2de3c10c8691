# SPDX-License-Identifier: GPL-3.0-or-later
"""A stretch of a day in the window: its keys in the home, and the way back from there.

How the home was is noted in the scene as text, so that it survives undo, saving and opening.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any

import bpy

from ...sensor_logic.days.times import FPS, frame_at
from ...sensor_logic.residents.acted import Acted
from ...sensor_logic.residents.places import Places
from ..residents.keys import MOVED, KeyedStretch
from ..residents.person import body_of

# s before and after a stretch that can be scrubbed into.
AROUND_S = 2.0
TIME = ("fps", "fps_base", "frame_map_old", "frame_map_new")
RANGE = ("frame_start", "frame_end", "frame_current", "use_preview_range")


def show(
    scene: Any, acted: Acted, places: Places, residents: Mapping[str, Any], start: float, end: float
) -> None:
    """What happens from `start` to `end` (s of the day) as animation at the home's frames."""
    leave(scene)
    ranged = {name: getattr(scene, name) for name in RANGE}
    scene.frame_set(scene.frame_start)
    owners = list(_owners(acted, places, residents))
    before = {
        "time": {name: getattr(scene.render, name) for name in TIME},
        "range": ranged,
        "owners": [_noted(owner) for owner in owners],
    }
    scene.angen_day.before = json.dumps(before)
    keys = KeyedStretch(residents, places)
    lights = {light for owner in owners for light in [owner] if isinstance(light, bpy.types.Light)}
    for owner in owners:
        data = owner.animation_data
        if data is not None and owner not in lights:
            data.action, data.use_nla = None, False
    first, last = max(start - AROUND_S, 0.0), end + AROUND_S
    keys.show(acted, first - 1.0, last + 1.0)
    render = scene.render
    render.fps, render.fps_base, render.frame_map_old, render.frame_map_new = FPS, 1.0, 100, 100
    scene.use_preview_range = False
    # In this order, for the one pushes the other.
    scene.frame_end, scene.frame_start = frame_at(last), frame_at(first)
    scene.frame_set(frame_at(start))


def leave(scene: Any) -> None:
    """The home as it was before; nothing where no stretch is shown."""
    if not scene.angen_day.before:
        return
    before = json.loads(scene.angen_day.before)
    scene.angen_day.before = ""
    for noted in before["owners"]:
        owner = getattr(bpy.data, noted["of"]).get(noted["name"])
        if owner is not None:
            _give_back(owner, noted)
    for name, value in before["time"].items():
        setattr(scene.render, name, value)
    wanted = before["range"]
    scene.frame_end, scene.frame_start = wanted["frame_end"], wanted["frame_start"]
    scene.frame_end, scene.use_preview_range = wanted["frame_end"], wanted["use_preview_range"]
    scene.frame_set(wanted["frame_current"])


def _owners(acted: Acted, places: Places, residents: Mapping[str, Any]) -> Iterator[Any]:
    """Whatever a day moves, and whatever the home's own story moves."""
    objects = bpy.data.objects
    named = [*acted.swings, *acted.holds, *places.doors, *(o.name for o in residents.values())]
    found = {name: objects[name] for name in named if name in objects}
    for rig in residents.values():
        for obj in (body_of(rig), rig.angen_resident.walking_frame):
            if obj is not None:
                found[obj.name] = obj
    found |= {o.name: o for o in objects if o.animation_data is not None and o.library is None}
    yield from found.values()
    lamps = {objects[lamp.object] for lamp in places.lamps.values() if lamp.object in objects}
    parts = {one for lamp in lamps for one in (lamp, *lamp.children_recursive)}
    lights = {one.data for one in parts if one.type == "LIGHT"}
    yield from lights | {light for light in bpy.data.lights if light.animation_data is not None}


def _noted(owner: Any) -> dict[str, Any]:
    data = owner.animation_data
    action, slot = (data.action, getattr(data, "action_slot", None)) if data else (None, None)
    if action is not None:
        # Else it would be lost where the file is saved meanwhile.
        fake, action.use_fake_user = action.use_fake_user, True
    bones = owner.pose.bones if getattr(owner, "pose", None) else ()
    return {
        "of": "lights" if isinstance(owner, bpy.types.Light) else "objects",
        "name": owner.name,
        "animated": data is not None,
        "action": action.name if action is not None else "",
        "fake": fake if action is not None else False,
        "slot": slot.identifier if slot is not None else "",
        "use_nla": data.use_nla if data is not None else True,
        "values": _values(owner),
        "bones": {bone.name: _values(bone) for bone in bones},
    }


def _values(part: Any) -> dict[str, Any]:
    found = {name: getattr(part, name) for name in MOVED if hasattr(part, name)}
    return {n: v if isinstance(v, (bool, float, str)) else list(v) for n, v in found.items()}


def _give_back(owner: Any, noted: Mapping[str, Any]) -> None:
    data = owner.animation_data
    ours = data.action if data is not None else None
    if data is not None:
        data.action = bpy.data.actions.get(noted["action"])
        data.use_nla = noted["use_nla"]
        if data.action is not None:
            data.action.use_fake_user = noted["fake"]
            if noted["slot"]:
                data.action_slot = data.action.slots[noted["slot"]]
    if ours is not None and ours.name != noted["action"] and ours.users == 0:
        bpy.data.actions.remove(ours)
    if data is not None and not noted["animated"] and not data.drivers:
        owner.animation_data_clear()
    parts = [(owner, noted["values"])]
    parts += [(owner.pose.bones[name], values) for name, values in noted["bones"].items()]
    for part, values in parts:
        for name, value in values.items():
            setattr(part, name, value)
