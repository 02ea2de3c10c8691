# SPDX-License-Identifier: GPL-3.0-or-later
"""Show a part of a day in the window as animation, and restore the home afterwards.

The earlier state of the home is stored in the scene, where it survives undo, saving and opening.
Objects and lights are known by pointers, since users rename them while a day is shown.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable, Mapping
from datetime import date, datetime, time, timedelta
from typing import Any

import bpy

from ...angen_addon.recording.results import RESULTS
from ...angen_addon.scene.animation import all_animated
from ...angen_addon.scene.light.scene import remove_part_starts
from ..acting.places import Places
from ..acting.timeline import Acted
from ..days.rows import FPS, frame_at, time_at
from .daylight import Daylight, site_values
from .followed_day import note_home
from .keys import DAY_MARK, IN_USE, KeyedStretch, moved_values, set_value
from .lamps import Lent, give_back, lights_of
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
    # The day changes nothing else of what is only used: users may move it meanwhile.
    used = [o for name in acted.times_in_use() if (o := bpy.data.objects[name]) not in owners]
    before = {
        "time": {name: getattr(scene.render, name) for name in TIME},
        "range": ranged,
        "start": scene.angen_start,
        "followed": scene.angen_day.followed,
        "site": site_values(scene),
    }
    RESULTS.set_aside(scene)
    scene.angen_day.before = json.dumps(before)
    _note_home(scene, owners, daylight)
    for obj in used:
        _note(scene, obj, obj, {"values": moved_values(obj, [IN_USE]), "bones": {}})
    owners += used
    scene.angen_day.rests = rests(acted, max(start - AROUND_S, 0.0), end + AROUND_S)
    keys = KeyedStretch(residents, places)
    # What else moves or changes by itself, such as shape keys, is held as in a run of days.
    others = _note_others(scene, owners, daylight)
    for owner in (*owners, *others):
        data = owner.animation_data
        if data is not None:
            data.action, data.use_nla = None, False
    daylight.insert_keys()
    first, last = max(start - AROUND_S, 0.0), end + AROUND_S
    keys.show(acted, first - 1.0, last + 1.0)
    for lent in keys.copies.lent:
        stored = scene.angen_day.lent.add()
        for name, value in lent._asdict().items():
            setattr(stored, name, value)
    render = scene.render
    render.fps, render.fps_base, render.frame_map_old, render.frame_map_new = FPS, 1.0, 100, 100
    scene.use_preview_range = False
    # In this order, because Blender keeps the first frame before the last.
    scene.frame_end, scene.frame_start = frame_at(last), frame_at(first)
    begin = datetime.combine(on, time()) + timedelta(seconds=time_at(frame_at(first)))
    whole = begin.microsecond == 0
    scene.angen_start = begin.isoformat(timespec="seconds" if whole else "milliseconds")
    scene.frame_set(frame_at(start))
    if scene.angen_day.followed:
        note_home(scene)


def has_its_light(scene: Any) -> bool:
    """Return whether the shown activity has the light of the home's present place on Earth."""
    return bool(json.loads(scene.angen_day.before).get("site") == site_values(scene))


def leave(scene: Any) -> list[str]:
    """Restore the home as it was before `show`; without a shown day, do nothing.

    Return the names of objects and lights that could not be restored fully, because the user has
    changed them.
    """
    if not scene.angen_day.before:
        return []
    day = scene.angen_day
    before = json.loads(day.before)
    lent = [Lent(*(getattr(one, name) for name in Lent._fields)) for one in day.lent]
    earlier = [
        (one.owner, one.of_data, one.of_tree, one.action, json.loads(one.values))
        for one in day.earlier
    ]
    day.before, day.followed = "", before.get("followed", "")
    # The pointers count as users.
    day.lent.clear()
    day.earlier.clear()
    remove_part_starts(scene)
    give_back(lent)
    changed = []
    for owner, of_data, of_tree, action, values in earlier:
        part = owner.data if of_data and owner is not None else owner
        part = part.node_tree if of_tree and part is not None else part
        if part is not None and not _restore(part, action, values):
            changed.append(owner.name)
    for action in [action for action in bpy.data.actions if DAY_MARK in action]:
        bpy.data.actions.remove(action)
    for name, value in before["time"].items():
        setattr(scene.render, name, value)
    # Files of earlier versions have no start.
    scene.angen_start = before.get("start", scene.angen_start)
    RESULTS.take_back(scene)
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


def _note_home(scene: Any, owners: Iterable[Any], daylight: Daylight) -> None:
    """Store the present state of objects and lights, and of the sky, in the scene."""
    users = {obj.data: obj for obj in scene.objects if obj.type == "LIGHT"}
    for owner in owners:
        bones = owner.pose.bones if getattr(owner, "pose", None) else ()
        found = {
            "values": moved_values(owner),
            "bones": {bone.name: moved_values(bone) for bone in bones},
        }
        # A pointer to the light would be one of its users, by which light groups are chosen.
        _note(scene, owner, users.get(owner, owner), found)
    for tree, path, _ in daylight.skies():
        values = {path: tree.path_resolve(path)}
        _note(scene, tree, scene.world, {"values": values, "bones": {}})


def _note_others(scene: Any, owners: Collection[Any], daylight: Daylight) -> list[Any]:
    """Store the animation of datablocks other than `owners` and the sky; return the datablocks."""
    noted = {*owners, *(tree for tree, *_ in daylight.skies())}
    others = [o for o in all_animated() if o.library is None and o not in noted]
    data = bpy.data
    trees = {
        block.node_tree: block
        for group in (data.lights, data.materials, data.worlds)
        for block in group
        if block.node_tree is not None
    }
    users = {obj.data: obj for obj in scene.objects if obj.type == "LIGHT"}
    found = []
    for owner in others:
        holder = trees.get(owner, owner)
        # Compositors, for example, have no part in a day.
        if holder is not owner or not owner.is_embedded_data:
            _note(scene, owner, users.get(holder, holder), {"values": {}, "bones": {}})
            found.append(owner)
    return found


def _note(scene: Any, owner: Any, pointed: Any, values: dict[str, Any]) -> None:
    """Store `values` of a datablock, and its animation; `pointed` leads to the datablock."""
    data = owner.animation_data
    slot = getattr(data, "action_slot", None) if data else None
    stored = scene.angen_day.earlier.add()
    stored.owner = pointed
    stored.of_data = isinstance(pointed, bpy.types.Object) and pointed != owner
    stored.of_tree = isinstance(owner, bpy.types.NodeTree) and pointed != owner
    stored.action = data.action if data else None
    animation = {
        "animated": data is not None,
        "slot": slot.handle if slot is not None else 0,
        "use_nla": data.use_nla if data is not None else True,
    }
    stored.values = json.dumps(values | animation)


def _restore(owner: Any, action: Any, stored: Mapping[str, Any]) -> bool:
    """Restore a datablock's action and values; return whether all that it needs still exists."""
    is_whole = True
    data = owner.animation_data
    if data is not None:
        data.action, data.use_nla = action, stored["use_nla"]
        if action is not None and stored["slot"]:
            slots = (slot for slot in action.slots if slot.handle == stored["slot"])
            data.action_slot = next(slots, None)
            is_whole = data.action_slot is not None
    if data is not None and not stored["animated"] and not data.drivers:
        owner.animation_data_clear()
    parts = [(owner, stored["values"])]
    bones = _bones_by_former_name(owner, stored["bones"])
    is_whole &= len(bones) == len(stored["bones"])
    parts += [(bone, stored["bones"][name]) for name, bone in bones.items()]
    for part, values in parts:
        for path, value in values.items():
            try:
                set_value(part, path, value)
            except ValueError:
                # A node that the path names is gone.
                is_whole = False
    return is_whole


def _bones_by_former_name(owner: Any, former: Collection[str]) -> dict[str, Any]:
    """Return the pose bones of an armature by the names that they had, in this order.

    A bone without its name has been renamed if the armature has as many bones as before: Blender
    keeps their order then.
    """
    if not former:
        return {}
    bones = owner.pose.bones
    found = {name: bones.get(name) for name in former}
    if len(bones) == len(former):
        pairs = zip(former, bones, strict=True)
        found |= {name: bone for name, bone in pairs if found[name] is None}
    return {name: bone for name, bone in found.items() if bone is not None}
