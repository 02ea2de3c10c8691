# SPDX-License-Identifier: GPL-3.0-or-later
"""Find the F-curves, drivers and NLA strips of a datablock, in every version of Blender."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import bpy
import numpy as np

# Beginnings of the data paths of an object's transform.
PLACE = ("location", "rotation_", "scale", "delta_")
# Relative: how closely a value set by an F-curve equals the curve.
KEY_TOLERANCE = 1e-5
# Splits a data path into the owner of the property and its name, or its custom name.
LAST_PART = re.compile(r'^(?:(.*)\.)?(\w+)$|^(.*)\["((?:[^"\\]|\\.)*)"\]$')


def time_stretch(scene: Any) -> float:
    """Return how many frames of animation correspond to one frame of the scene (Time Stretching).

    The result is rounded as Blender rounds it.
    """
    render = scene.render
    return float(np.float32(render.frame_map_old) / np.float32(render.frame_map_new))


def action_curves(action: Any, slot: Any) -> list[Any]:
    """Return the F-curves that an action has for a slot.

    From Blender 4.4 on, each slot of an action has the F-curves of one datablock. Without a slot,
    the list is empty. Before Blender 4.4, an action has a single list.
    """
    if action is None:
        return []
    if not hasattr(action, "slots"):
        return list(action.fcurves)
    if slot is None:
        return []
    bags = [strip.channelbag(slot) for layer in action.layers for strip in layer.strips]
    return [curve for bag in bags if bag is not None for curve in bag.fcurves]


def _lists(action: Any) -> list[Any]:
    if not hasattr(action, "slots"):
        return [action.fcurves]
    strips = [strip for layer in action.layers for strip in layer.strips]
    return [bag.fcurves for strip in strips for bag in strip.channelbags]


def has_curves(action: Any) -> bool:
    """Return whether an action has any F-curves."""
    return any(len(found) for found in _lists(action))


def remove_curve(action: Any, curve: Any) -> None:
    """Remove an F-curve from an action."""
    for found in _lists(action):
        if curve in list(found):
            found.remove(curve)
            return


def curves(obj: Any, paths: set[str]) -> list[Any]:
    """Return the F-curves with the data paths `paths` in an object's action, without NLA strips."""
    animation = obj.animation_data
    if animation is None:
        return []
    found = action_curves(animation.action, getattr(animation, "action_slot", None))
    return [curve for curve in found if curve.data_path in paths]


def played_curves(owner: Any) -> list[Any]:
    """Return the F-curves of a datablock's action and of its NLA strips."""
    animation = getattr(owner, "animation_data", None)
    if animation is None:
        return []
    strips = [strip for track in animation.nla_tracks for strip in track.strips]
    acting = (animation, *strips)
    return [c for a in acting for c in action_curves(a.action, getattr(a, "action_slot", None))]


def is_off_keys(owner: Any, scene: Any) -> bool | None:
    """Return whether any value differs from its F-curve, as after the user has moved an object.

    The next change of frame sets these values again. Return None if NLA strips set values, because
    their values at a frame cannot be read.
    """
    animation = owner.animation_data
    if animation is None:
        return False
    if animation.use_nla and any(not track.mute for track in animation.nla_tracks):
        return None
    driven = {(curve.data_path, curve.array_index) for curve in animation.drivers}
    frame = scene.frame_float * time_stretch(scene)
    for curve in action_curves(animation.action, getattr(animation, "action_slot", None)):
        path = curve.data_path, curve.array_index
        if curve.mute or path in driven or (curve.group is not None and curve.group.mute):
            continue
        try:
            value = owner.path_resolve(curve.data_path)
        except ValueError:
            continue
        value = value[curve.array_index] if hasattr(value, "__getitem__") else value
        if isinstance(value, float):
            wanted = curve.evaluate(frame)
            if abs(value - wanted) > KEY_TOLERANCE * max(1.0, abs(wanted)):
                return True
    return False


def may_set(owner: Any, *words: str) -> bool:
    """Return whether animation may set a data path that contains one of `words`.

    Animation is F-curves, drivers and NLA strips. A strip that is no clip (such as a meta strip)
    counts as setting any path.
    """
    animation = owner.animation_data
    if animation is None:
        return False
    strips = [strip for track in animation.nla_tracks for strip in track.strips]
    found = (*played_curves(owner), *animation.drivers)
    return any(strip.type != "CLIP" for strip in strips) or any(
        word in curve.data_path for curve in found for word in words
    )


def is_animated(obj: Any, path: str) -> bool:
    """Return whether keyframes, an NLA strip or a driver set a data path."""
    animation = obj.animation_data
    return animation is not None and any(
        curve.data_path == path for curve in (*played_curves(obj), *animation.drivers)
    )


def is_static(obj: Any, *paths: str) -> bool:
    """Return whether nothing in the file moves an object or changes one of the data paths.

    Each of `paths` is the beginning of a data path, such as `scale`. Constraints, physics, NLA
    strips and a parent's shape count as changes even if they do nothing.
    """
    animation, parent = obj.animation_data, obj.parent
    if obj.constraints or obj.rigid_body is not None:
        return False
    if animation is not None:
        slot = getattr(animation, "action_slot", None)
        curves = [*action_curves(animation.action, slot), *animation.drivers]
        if animation.nla_tracks or any(c.data_path.startswith(PLACE + paths) for c in curves):
            return False
    return parent is None or (obj.parent_type == "OBJECT" and is_static(parent))


def motion_paths(obj: Any) -> list[str]:
    """Return the data paths of an object's transform that keyframes and drivers animate.

    Constraints, NLA strips and physics may rotate the object too. For these the list has texts
    "rotation by …".
    """
    found = ["rotation by constraint" for c in obj.constraints if not c.mute]
    if obj.rigid_body is not None and obj.rigid_body.type == "ACTIVE":
        found.append("rotation by physics")
    animation = obj.animation_data
    if animation is None:
        return found
    curves = action_curves(animation.action, getattr(animation, "action_slot", None))
    paths = [curve.data_path for curve in (*curves, *animation.drivers)]
    found += ["rotation by strip" for track in animation.nla_tracks if not track.mute]
    return found + [path for path in paths if path.startswith(PLACE)]


def playing(owner: Any) -> tuple[list[Any], list[Any]]:
    """Return the F-curves and drivers of a datablock, and its NLA strips, without muted ones."""
    animation = owner.animation_data
    found = action_curves(animation.action, getattr(animation, "action_slot", None))
    curves = [curve for curve in (*found, *animation.drivers) if not _is_muted(curve)]
    tracks = animation.nla_tracks if animation.use_nla else ()
    solo = [track for track in tracks if track.is_solo]
    unmuted = solo or [track for track in tracks if not track.mute]
    return curves, [strip for track in unmuted for strip in track.strips if not strip.mute]


def _is_muted(curve: Any) -> bool:
    return bool(curve.mute or (curve.group is not None and curve.group.mute))


def idle_keys(owner: Any, first: int, last: int) -> Iterator[tuple[str, str]]:
    """Yield the reasons why keyframes, strips or drivers of a datablock have no effect.

    Parameters
    ----------
    owner
        The datablock.
    first, last
        The first and last frame of the range in which an effect counts.

    Yields
    ------
    tuple
        A text with the reason, and a text with the remedy.
    """
    animation = getattr(owner, "animation_data", None)
    if animation is None:
        return
    curves, strips = playing(owner)
    every = [strip for track in animation.nla_tracks for strip in track.strips]
    if every and not animation.use_nla:
        yield "The NLA is switched off", "Switch it on: Action or NLA Editor, tracks' header"
    elif len(strips) < len(every):
        yield (
            "Muted tracks or strips of the NLA do not play",
            "NLA Editor: tick the track's box, or press H on the strip; or delete what is not used",
        )
    if animation.action is not None and getattr(animation, "action_slot", 1) is None:
        yield "An action without a slot does not play", "Action Editor: choose its slot"
    if any(s.action and getattr(s, "action_slot", 1) is None for s in every):
        yield "A strip without a slot does not play", "NLA Editor, sidebar, Strip: choose its slot"
    own = action_curves(animation.action, getattr(animation, "action_slot", None))
    if any(map(_is_muted, own)):
        yield (
            "Muted F-curves do not play",
            "Graph Editor: tick the box of the channel or its group, or delete it",
        )
    if any(map(_is_muted, animation.drivers)):
        yield "Muted drivers do nothing", "Drivers Editor: tick the channel's box, or delete it"
    if strips and all(s.frame_end < first or s.frame_start > last for s in strips):
        yield (
            f"All strips of the NLA are outside frames {first} to {last}",
            "Move them (NLA Editor, G), or set the frame range (Output tab)",
        )
    points = [curve.range() for curve in own if curve in curves and len(curve.keyframe_points)]
    if points and not strips and all(end < first or start > last for start, end in points):
        yield (
            f"All keyframes are outside frames {first} to {last}",
            "Move them (Dope Sheet, G), or set the frame range (Output tab)",
        )


def all_animated() -> Iterator[Any]:
    """Yield every datablock in the file that has animation data, embedded node trees included."""
    for prop in bpy.data.bl_rna.properties:
        # `all_ids` repeats the datablocks of all other collections.
        if prop.type != "COLLECTION" or prop.identifier == "all_ids":
            continue
        for block in getattr(bpy.data, prop.identifier):
            for owner in (block, getattr(block, "node_tree", None)):
                if getattr(owner, "animation_data", None) is not None:
                    yield owner


def set_by_animation(datablock: Any) -> Iterator[tuple[tuple[int, str], set[int]]]:
    """Yield the properties that keyframes and drivers set.

    Yields
    ------
    tuple
        The address of the struct and the name of its property; and the set of array indices.
    """
    animation = getattr(datablock, "animation_data", None)
    if animation is None:
        return
    curves = (*played_curves(datablock), *animation.drivers)
    found: dict[tuple[str, str], set[int]] = {}
    for curve in curves:
        match = LAST_PART.match(curve.data_path)
        if match and not curve.mute:
            owner, name, holder, custom = match.groups()
            found.setdefault((owner or holder or "", name or custom), set()).add(curve.array_index)
    for (owner, name), indices in found.items():
        try:
            struct = datablock.path_resolve(owner) if owner else datablock
            yield (struct.as_pointer(), name), indices
        except (ValueError, AttributeError):
            # The property of the curve is gone.
            continue
