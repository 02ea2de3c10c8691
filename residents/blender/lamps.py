# SPDX-License-Identifier: GPL-3.0-or-later
"""What a lamp is that residents switch, and the copies of lights and materials for that time.

A lamp is all that belongs to the marked object: it and its children, as far as they are lights or
have materials that glow. While a day is shown or simulated, a lamp has its own copy of a light that
other lamps use too or whose power is driven, and of materials that glow.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

import bpy

from ...angen_addon.runtime.time_base import evaluated_depsgraph
from ...angen_addon.scene.animation import action_curves
from ...angen_addon.scene.light.materials import glows, has_nodes
from .unmovable import Finding

# The inputs of shader nodes that scale the light of a surface.
STRENGTHS = {"EMISSION": "Strength", "BSDF_PRINCIPLED": "Emission Strength"}


class Power(NamedTuple):
    """A number that a lamp's light is proportional to: its datablock, data path and full value."""

    owner: Any
    path: str
    full: float


def family_of(lamp: Any) -> list[Any]:
    """Return an object and all its children, at any depth."""
    return [lamp, *sorted(lamp.children_recursive, key=lambda child: child.name)]


def shining(lamp: Any) -> list[Any]:
    """Return the lights and glowing objects of a lamp."""
    return [one for one in family_of(lamp) if one.type == "LIGHT" or _glowing_slots(one)]


def lamp_of(obj: Any) -> Any:
    """Return the lamp of a marked object: a single light in it, its parent light, or itself."""
    found = shining(obj)
    if obj not in found and len(found) == 1 and found[0].type == "LIGHT":
        return found[0]
    if not found and obj.parent is not None and obj.parent.type == "LIGHT":
        return obj.parent
    return obj


def lights_of(lamp: Any) -> set[Any]:
    """Return the light data of a lamp object and its descendants, which are switched together."""
    return {one.data for one in family_of(lamp) if one.type == "LIGHT"}


def _glowing_slots(obj: Any) -> list[Any]:
    return [s for s in obj.material_slots if s.material is not None and glows(s.material)]


class Lent(NamedTuple):
    """A copy of a light or material that a lamp has for some time.

    Attributes
    ----------
    object
        The object that has the copy.
    original, copy
        The light or material, and its copy.
    link
        The link of the material slot before: to the object, or to its data.
    before
        The material that the slot had when it was linked to the object; None for a light.
    """

    object: Any
    original: Any
    copy: Any
    link: str = ""
    before: Any = None


class LampCopies:
    """The copies of lights and materials that lamps have while residents switch them (`lent`)."""

    def __init__(self) -> None:
        self.lent: list[Lent] = []

    def switchable_powers(self, lamp: Any) -> list[Power]:
        """Return the numbers to set to zero for the lamp to be off; make the copies for that."""
        members = family_of(lamp)
        for obj in members:
            if obj.type == "LIGHT" and obj.library is None and _needs_copy(obj.data, members):
                self._copy_light(obj)
        lights = sorted(lights_of(lamp), key=lambda light: str(light.name))
        found = [Power(light, "energy", full_power(light)) for light in lights]
        for obj in members:
            for slot in _glowing_slots(obj) if obj.library is None else ():
                found += _strengths(self._copy_material(obj, slot))
        return found

    def _copy_light(self, obj: Any) -> None:
        light = obj.data
        copy = light.copy()
        if _is_driven(light):
            copy.driver_remove("energy")
            copy.energy = light.evaluated_get(evaluated_depsgraph()).energy
        obj.data = copy
        self.lent.append(Lent(obj, light, copy))

    def _copy_material(self, obj: Any, slot: Any) -> Any:
        material, link = slot.material, slot.link
        slot.link = "OBJECT"
        before = slot.material
        slot.material = material.copy()
        self.lent.append(Lent(obj, material, slot.material, link, before))
        return slot.material

    def give_back(self) -> None:
        """Give the lamps their own lights and materials again, and remove the copies."""
        give_back(self.lent)
        self.lent.clear()


def give_back(lent: Iterable[Lent]) -> None:
    """Undo what `LampCopies.lent` lists, as far as its objects and datablocks still exist.

    What the user has given a lamp meanwhile stays.
    """
    for one in reversed(list(lent)):
        if one.object is None or one.original is None or one.copy is None:
            continue
        slots = [slot for slot in one.object.material_slots if slot.material == one.copy]
        if one.object.data == one.copy:
            one.object.data = one.original
        for slot in slots:
            slot.material = one.before
            slot.link = one.link
        if not one.copy.users:
            _remove(one.copy)


def _remove(copy: Any) -> None:
    """Remove a copy with its own actions and node groups."""
    groups = list(_group_copies(copy.node_tree)) if copy.node_tree else []
    owners = [copy, *([copy.node_tree] if copy.node_tree else []), *groups]
    actions = [one.animation_data.action for one in owners if one.animation_data]
    data = bpy.data.lights if isinstance(copy, bpy.types.Light) else bpy.data.materials
    data.remove(copy)
    for group in groups:
        bpy.data.node_groups.remove(group)
    for action in {action for action in actions if action is not None}:
        if not action.users:
            bpy.data.actions.remove(action)


def _group_copies(tree: Any) -> Iterator[Any]:
    for node in tree.nodes:
        if node.type == "GROUP" and node.node_tree is not None:
            yield from _group_copies(node.node_tree)
            if node.node_tree.users == 1:
                yield node.node_tree


def _strengths(material: Any) -> list[Power]:
    """Return the strengths of a material's emission, in it and in copies of its node groups."""
    if not has_nodes(material):
        return []
    return _strengths_in(material.node_tree)


def _strengths_in(tree: Any) -> list[Power]:
    found = []
    for node in list(tree.nodes):
        if node.type == "GROUP" and node.node_tree is not None:
            node.node_tree = node.node_tree.copy()
            found += _strengths_in(node.node_tree)
        socket = node.inputs.get(STRENGTHS[node.type]) if node.type in STRENGTHS else None
        if socket is None:
            continue
        if socket.links:
            # What is linked stays, times a factor.
            product = tree.nodes.new("ShaderNodeMath")
            product.operation = "MULTIPLY"
            tree.links.new(socket.links[0].from_socket, product.inputs[0])
            tree.links.new(product.outputs[0], socket)
            socket = product.inputs[1]
            socket.default_value = 1.0
        path = socket.path_from_id("default_value")
        tree.driver_remove(path)
        found.append(Power(tree, path, _full_value(tree, path, socket.default_value)))
    return found


def _needs_copy(light: Any, members: list[Any]) -> bool:
    """Return whether a light has other users than the lamp with these members, or is driven."""
    others = (obj for obj in bpy.data.objects if obj.data == light and obj not in members)
    return light.library is not None or _is_driven(light) or next(others, None) is not None


def _is_driven(light: Any) -> bool:
    data = light.animation_data
    return data is not None and any(curve.data_path == "energy" for curve in data.drivers)


def full_power(light: Any) -> float:
    """Return the power that a light has when it is on.

    This is the largest of its present power and the values in the file's own keyframes.
    """
    return _full_value(light, "energy", light.energy)


def _full_value(owner: Any, path: str, now: float) -> float:
    data = owner.animation_data
    if data is None:
        return float(now)
    curves = action_curves(data.action, getattr(data, "action_slot", None))
    keys = [k.co[1] for curve in curves if curve.data_path == path for k in curve.keyframe_points]
    return float(max([now, *keys]))


# What residents cannot switch.


def unswitchable(lamps: Iterable[Any], depsgraph: Any) -> Iterator[Finding]:
    """Yield a finding for each lamp that residents cannot switch, or not alone."""
    for lamp in lamps:
        found = shining(lamp)
        modified = [one for one in family_of(lamp) if _glows_by_modifiers(one, depsgraph)]
        linked = [one for one in found if one.library is not None]
        around = [o for o in bpy.data.objects if _instances_any(o, found)]
        dark = not any(power > 0 for power in map(full_power, lights_of(lamp)))
        if modified:
            yield (
                f"'{lamp.name}' stays on: its modifiers make '{modified[0].name}' glow",
                "Give the object the glowing material itself (Material tab)",
                (lamp.name, modified[0].name),
            )
        if not found and not modified:
            yield (
                f"'{lamp.name}' is marked as a lamp, but nothing in it shines",
                "Mark the object that its lights or glowing meshes are parented to",
                (lamp.name,),
            )
        elif found and dark and all(one.type == "LIGHT" for one in found):
            yield (
                f"'{lamp.name}' is marked as a lamp, but its power is zero at the first frame",
                "Give it the power that it has when it is on",
                (lamp.name,),
            )
        if linked:
            yield (
                f"'{lamp.name}' stays on: '{linked[0].name}' is linked from another file",
                "Make a library override of it (Object → Relations), or make it local",
                (lamp.name, linked[0].name),
            )
        if around:
            yield (
                f"'{lamp.name}' is switched together with its instance '{around[0].name}'",
                "Make the instance real (Ctrl+A), and mark each lamp",
                (lamp.name, around[0].name),
            )


def _glows_by_modifiers(obj: Any, depsgraph: Any) -> bool:
    """Return whether modifiers give an object a glowing material that its slots do not have."""
    if obj.type != "MESH" or not obj.modifiers:
        return False
    own = {slot.material.name for slot in obj.material_slots if slot.material is not None}
    made = obj.evaluated_get(depsgraph).data.materials
    return any(m is not None and m.name not in own and glows(m.original) for m in made)


def _instances_any(obj: Any, members: list[Any]) -> bool:
    if obj.instance_type != "COLLECTION" or obj.instance_collection is None:
        return False
    inside = obj.instance_collection.all_objects
    return any(one.name in inside for one in members)
