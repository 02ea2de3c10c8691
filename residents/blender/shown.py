# SPDX-License-Identifier: GPL-3.0-or-later
"""Show a part of a day in the window as animation, and restore the home afterwards.

The earlier state of the home is stored in the scene as text, which survives undo, saving and
opening.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from datetime import date, datetime, time, timedelta
from typing import Any

import bpy

from ...angen_addon.runtime import state
from ...angen_addon.scene.light.scene import take_begins
from ..acting.places import Places
from ..acting.timeline import Acted
from ..days.rows import FPS, frame_at, time_at
from .daylight import Daylight
from .keys import MOVED, KeyedStretch
from .lamps import give_back, lights_of
from .person import body_of
from .still import rests

# s before and after a stretch that can be scrubbed too.
AROUND_S = 2.0
TIME = ("fps", "fps_base", "frame_map_old", "frame_map_new")
RANGE = ("frame_start", "frame_end", "frame_current", "use_preview_range")


def show(
    scene: Any,
    acted: Acted,
    places: Places,
    residents: Mapping[str, Any],
    daylight: Daylight,
    on: date,
    start: float,
    end: float,
) -> None:
    """Animate the home from `start` to `end` (s of the day `on`), in the light of that day.

    `acted` holds what the residents do on that day.

    The scene's property Start becomes the date and time of the first frame.
    """
    leave(scene)
    ranged = {name: getattr(scene, name) for name in RANGE}
    scene.frame_set(scene.frame_start)
    lamps = _lamps(places)
    owners = [*_animated_objects(acted, places, residents, daylight), *_lights(lamps, daylight)]
    skies = [(scene.world, path) for _, path, _ in daylight.skies()]
    before = {
        "time": {name: getattr(scene.render, name) for name in TIME},
        "range": ranged,
        "start": scene.angen_start,
        "owners": [_state_of(owner) for owner in owners] + [_state_of_sky(*sky) for sky in skies],
    }
    state.CACHE.set_aside(scene)
    scene.angen_day.before = json.dumps(before)
    scene.angen_day.rests = rests(acted, max(start - AROUND_S, 0.0), end + AROUND_S)
    keys = KeyedStretch(residents, places)
    for owner in owners:
        data = owner.animation_data
        # Keep the keyframes of lamps: they say with what power a lamp shines when it is on.
        if data is not None and owner not in lamps:
            data.action, data.use_nla = None, False
    daylight.insert_keys()
    first, last = max(start - AROUND_S, 0.0), end + AROUND_S
    keys.show(acted, first - 1.0, last + 1.0)
    before["lent"] = keys.copies.lent
    scene.angen_day.before = json.dumps(before)
    render = scene.render
    render.fps, render.fps_base, render.frame_map_old, render.frame_map_new = FPS, 1.0, 100, 100
    scene.use_preview_range = False
    # In this order, because Blender keeps the first frame before the last.
    scene.frame_end, scene.frame_start = frame_at(last), frame_at(first)
    begin = datetime.combine(on, time()) + timedelta(seconds=time_at(frame_at(first)))
    whole = begin.microsecond == 0
    scene.angen_start = begin.isoformat(timespec="seconds" if whole else "milliseconds")
    scene.frame_set(frame_at(start))


def leave(scene: Any) -> list[str]:
    """Restore the home as it was before `show`; without a shown day, do nothing.

    Return the names of objects and lights that could not be restored fully, because the user has
    changed them.
    """
    if not scene.angen_day.before:
        return []
    changed = []
    before = json.loads(scene.angen_day.before)
    scene.angen_day.before = ""
    take_begins(scene)
    give_back(before.get("lent", ()))
    for noted in before["owners"]:
        owner = getattr(bpy.data, noted["of"]).get(noted["name"])
        if noted["of"] == "worlds" and owner is not None:
            owner = owner.node_tree
        if owner is not None and not _restore(owner, noted):
            changed.append(owner.name)
    for name, value in before["time"].items():
        setattr(scene.render, name, value)
    # Files of earlier versions have no start.
    scene.angen_start = before.get("start", scene.angen_start)
    state.CACHE.take_back(scene)
    wanted = before["range"]
    scene.frame_end, scene.frame_start = wanted["frame_end"], wanted["frame_start"]
    scene.frame_end, scene.use_preview_range = wanted["frame_end"], wanted["use_preview_range"]
    scene.frame_set(wanted["frame_current"])
    return changed


def _animated_objects(
    acted: Acted, places: Places, residents: Mapping[str, Any], daylight: Daylight
) -> list[Any]:
    """Return the objects that the residents' day (`acted`) or the home's own animation can move."""
    objects = bpy.data.objects
    named = [*acted.swings, *acted.holds, *places.doors, *(o.name for o in residents.values())]
    found = {name: objects[name] for name in named if name in objects}
    parts = [daylight.sun]
    for rig in residents.values():
        parts += [body_of(rig), rig.angen_resident.walking_frame]
    found |= {obj.name: obj for obj in parts if obj is not None}
    found |= {o.name: o for o in objects if o.animation_data is not None and o.library is None}
    return [*found.values()]


def _lamps(places: Places) -> set[Any]:
    """Return the lights of the lamps that residents switch."""
    lamps = [bpy.data.objects.get(lamp.object) for lamp in places.lamps.values()]
    return {light for lamp in lamps if lamp for light in lights_of(lamp)}


def _lights(lamps: set[Any], daylight: Daylight) -> set[Any]:
    """Return all lights that can change: of lamps, of the sun, or animated in the home's file."""
    sun = {daylight.sun.data} if daylight.sun is not None else set()
    return lamps | sun | {light for light in bpy.data.lights if light.animation_data is not None}


def _state_of(owner: Any) -> dict[str, Any]:
    of = "lights" if isinstance(owner, bpy.types.Light) else "objects"
    bones = owner.pose.bones if getattr(owner, "pose", None) else ()
    found = _state_of_animation(owner) | {
        "of": of,
        "name": owner.name,
        "values": _property_values(owner),
    }
    return found | {"bones": {bone.name: _property_values(bone) for bone in bones}}


def _state_of_sky(world: Any, path: str) -> dict[str, Any]:
    """Return the state of a world's sky; `path` is the data path of its strength."""
    found = _state_of_animation(world.node_tree) | {"of": "worlds", "name": world.name, "bones": {}}
    return found | {"values": {path: world.node_tree.path_resolve(path)}}


def _state_of_animation(owner: Any) -> dict[str, Any]:
    """Return what is needed to restore a datablock's animation, such as the action's name.

    The action gets a fake user, so that saving the file does not drop it.
    """
    data = owner.animation_data
    action, slot = (data.action, getattr(data, "action_slot", None)) if data else (None, None)
    if action is not None:
        # Without a user, saving the file would drop the action.
        fake, action.use_fake_user = action.use_fake_user, True
    return {
        "animated": data is not None,
        "action": action.name if action is not None else "",
        "fake": fake if action is not None else False,
        "slot": slot.identifier if slot is not None else "",
        "use_nla": data.use_nla if data is not None else True,
    }


def _property_values(part: Any) -> dict[str, Any]:
    """Return the values of the properties that a day's keyframes change."""
    found = {name: getattr(part, name) for name in MOVED if hasattr(part, name)}
    return {n: v if isinstance(v, (bool, float, str)) else list(v) for n, v in found.items()}


def _restore(owner: Any, stored: Mapping[str, Any]) -> bool:
    """Restore a datablock to the state `stored`; return whether all that it needs still exists."""
    is_whole = True
    data = owner.animation_data
    ours = data.action if data is not None else None
    if data is not None:
        data.action = bpy.data.actions.get(stored["action"])
        data.use_nla = stored["use_nla"]
        if data.action is not None:
            data.action.use_fake_user = stored["fake"]
            if stored["slot"]:
                data.action_slot = data.action.slots.get(stored["slot"])
                is_whole = data.action_slot is not None
    # Blender 4.2 still counts a world's node tree as a user.
    unused = stored["of"] == "worlds" or (ours is not None and ours.users == 0)
    if ours is not None and unused and ours.name != stored["action"]:
        bpy.data.actions.remove(ours)
    if data is not None and not stored["animated"] and not data.drivers:
        owner.animation_data_clear()
    parts = [(owner, stored["values"])]
    for name, values in stored["bones"].items():
        bone = owner.pose.bones.get(name)
        is_whole &= bone is not None
        if bone is not None:
            parts.append((bone, values))
    for part, values in parts:
        for path, value in values.items():
            holder, _, name = path.rpartition(".")
            try:
                setattr(part.path_resolve(holder) if holder else part, name, value)
            except ValueError:
                # A node that the path names is gone.
                is_whole = False
    return is_whole
