# SPDX-License-Identifier: GPL-3.0-or-later
"""What a lamp is that residents switch, and the copies of lights and materials for that time.

A lamp is all that belongs to the marked object: it, its children and what these instance, as far as
they are lights or have materials that glow. While a day is shown or simulated, a lamp has its own
copy of a light that other lamps use too or whose power is driven, and of materials that glow.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

import bpy

from ...angen_addon.runtime.time_base import evaluated_depsgraph
from ...angen_addon.scene.animation import played_curves
from ...angen_addon.scene.instances import chain, is_holder, shown_in
from ...angen_addon.scene.light.materials import glows, has_nodes
from ...angen_addon.scene.light.scene import SHAPES
from .unmovable import Finding

# The inputs of shader nodes that scale the light of a surface.
STRENGTHS = {
    "EMISSION": "Strength",
    "BACKGROUND": "Strength",
    "BSDF_PRINCIPLED": "Emission Strength",
}


class Power(NamedTuple):
    """A number that a lamp's light is proportional to: its datablock, data path and full value."""

    owner: Any
    path: str
    full: float


def family_of(lamp: Any) -> list[Any]:
    """Return an object, its children at all levels, and the objects that they instance."""
    found = [lamp, *sorted(lamp.children_recursive, key=lambda child: child.name)]
    for one in found:
        # A list that grows: instances may contain instances.
        if is_holder(one):
            found += [part for part in shown_in(one.instance_collection) if part not in found]
    return found


def shining(lamp: Any) -> list[Any]:
    """Return the lights and glowing objects of a lamp."""
    return [one for one in family_of(lamp) if _shines(one)]


def _shines(obj: Any) -> bool:
    return obj.type == "LIGHT" or bool(_glowing_slots(obj))


def lamp_of(obj: Any) -> Any:
    """Return the lamp of a marked object: a single light in it, its parent light, or itself."""
    found = shining(obj)
    if len(found) == 1 and found[0].type == "LIGHT" and obj in [*chain(found[0])][1:]:
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
    """The copies of lights and materials that lamps have while residents switch them (`lent`).

    `lamps` are the lamps' objects, before the animation of the home is held: it says with what
    power they shine when they are on.
    """

    def __init__(self, lamps: Iterable[Any] = ()) -> None:
        self.lent: list[Lent] = []
        self._full: FullValues = {}
        for lamp in lamps:
            self._full |= full_values(lamp)

    def switchable_powers(self, lamp: Any) -> list[Power]:
        """Return the numbers to set to zero for the lamp to be off; make the copies for that."""
        members = family_of(lamp)
        for obj in members:
            if obj.type == "LIGHT" and obj.library is None and _needs_copy(obj.data, members):
                self._copy_light(obj)
        lights = sorted(lights_of(lamp), key=lambda light: str(light.name))
        found = [Power(light, "energy", self._full_power(light)) for light in lights]
        for obj in members:
            for slot in _glowing_slots(obj) if obj.library is None else ():
                original = slot.material
                copy = self._copy_material(obj, slot)
                if has_nodes(original):
                    found += self._strengths(copy.node_tree, original.node_tree)
        return found

    def _full_power(self, light: Any) -> float:
        return self._full.get((light.as_pointer(), "energy"), float(light.energy))

    def _copy_light(self, obj: Any) -> None:
        light = obj.data
        copy = light.copy()
        if _is_driven(light):
            copy.driver_remove("energy")
            copy.energy = light.evaluated_get(evaluated_depsgraph()).energy
        self._full[copy.as_pointer(), "energy"] = max(self._full_power(light), copy.energy)
        obj.data = copy
        self.lent.append(Lent(obj, light, copy))

    def _copy_material(self, obj: Any, slot: Any) -> Any:
        material, link = slot.material, slot.link
        slot.link = "OBJECT"
        before = slot.material
        slot.material = material.copy()
        self.lent.append(Lent(obj, material, slot.material, link, before))
        return slot.material

    def _strengths(self, tree: Any, original: Any) -> list[Power]:
        """Return the strengths of emission in a copy of a node tree, with copies of its groups."""
        found = []
        for node, source in zip(list(tree.nodes), list(original.nodes), strict=True):
            if node.type == "GROUP" and node.node_tree is not None:
                node.node_tree = node.node_tree.copy()
                found += self._strengths(node.node_tree, source.node_tree)
            socket = _strength_of(node)
            if socket is None:
                continue
            path = socket.path_from_id("default_value")
            full = self._full.get((original.as_pointer(), path), float(socket.default_value))
            if socket.links:
                # What is linked stays, times a factor.
                product = tree.nodes.new("ShaderNodeMath")
                product.operation = "MULTIPLY"
                tree.links.new(socket.links[0].from_socket, product.inputs[0])
                tree.links.new(product.outputs[0], socket)
                socket, full = product.inputs[1], 1.0
                socket.default_value = full
                path = socket.path_from_id("default_value")
            tree.driver_remove(path)
            found.append(Power(tree, path, full))
        return found

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


def _needs_copy(light: Any, members: list[Any]) -> bool:
    """Return whether a light has other users than the lamp with these members, or is driven."""
    others = (obj for obj in bpy.data.objects if obj.data == light and obj not in members)
    return light.library is not None or _is_driven(light) or next(others, None) is not None


def _is_driven(light: Any) -> bool:
    data = light.animation_data
    return data is not None and any(curve.data_path == "energy" for curve in data.drivers)


# By the address of a light or node tree and the data path of a number: its value when a lamp is on.
FullValues = dict[tuple[int, str], float]


def full_values(lamp: Any) -> FullValues:
    """Return the powers and strengths that the light of a lamp has when it is on.

    Each is the largest of the present value and those of the keyframes in the file. A strength that
    is linked to another node counts as 1.
    """
    members = family_of(lamp)
    found = {
        (light.as_pointer(), "energy"): _full_value(light, "energy", light.energy)
        for light in lights_of(lamp)
    }
    for material in {slot.material for one in members for slot in _glowing_slots(one)}:
        for tree in _trees(material.node_tree):
            for socket in filter(None, map(_strength_of, tree.nodes)):
                path = socket.path_from_id("default_value")
                full = 1.0 if socket.links else _full_value(tree, path, socket.default_value)
                found[tree.as_pointer(), path] = full
    return found


def _full_value(owner: Any, path: str, now: float) -> float:
    played = [curve for curve in played_curves(owner) if curve.data_path == path]
    return float(max([now, *(key.co[1] for curve in played for key in curve.keyframe_points)]))


def _strength_of(node: Any) -> Any:
    """Return the input of a shader node that scales the light of a surface, or None."""
    return node.inputs.get(STRENGTHS[node.type]) if node.type in STRENGTHS else None


def _trees(tree: Any) -> Iterator[Any]:
    """Yield a node tree and the trees of its groups."""
    yield tree
    for node in tree.nodes:
        if node.type == "GROUP" and node.node_tree is not None:
            yield from _trees(node.node_tree)


# What residents cannot switch.


def unswitchable(lamps: Iterable[Any], depsgraph: Any) -> Iterator[Finding]:
    """Yield a finding for each lamp that residents cannot switch, or not alone."""
    instanced = [
        (one.parent.original, one.object.original)
        for one in depsgraph.object_instances
        if one.is_instance and _shines(one.object.original)
    ]
    for lamp in lamps:
        found, members = shining(lamp), family_of(lamp)
        modified = [one for one in members if _glows_by_modifiers(one, depsgraph)]
        linked = [one for one in found if one.library is not None and not _is_keyable(one)]
        whole = [*members, *chain(lamp)]
        around = [over for over, part in instanced if part in found and over not in whole]
        inside = [part for over, part in instanced if over in members and part not in members]
        dark = not any(value > 0.0 for value in full_values(lamp).values())
        if modified:
            yield (
                f"'{lamp.name}' stays on: its modifiers make '{modified[0].name}' glow",
                "Give the object the glowing material itself (Material tab)",
                (lamp.name, modified[0].name),
            )
        if inside:
            yield (
                f"'{lamp.name}' stays on: its modifiers or particles instance '{inside[0].name}'",
                "Make the instances real (Ctrl+A), and parent them to the lamp",
                (lamp.name, inside[0].name),
            )
        if not found and not modified and not inside:
            yield (
                f"'{lamp.name}' is marked as a lamp, but nothing in it shines",
                "Mark the object that its lights or glowing meshes are parented to",
                (lamp.name,),
            )
        elif found and dark:
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


def _is_keyable(linked: Any) -> bool:
    """Return whether a day can switch an object of another file, whose data it cannot exchange."""
    return linked.type == "LIGHT" and not _is_driven(linked.data)


def _glows_by_modifiers(obj: Any, depsgraph: Any) -> bool:
    """Return whether modifiers give an object a glowing material that its slots do not have."""
    if obj.type not in SHAPES or not obj.modifiers:
        return False
    own = {slot.material.name for slot in obj.material_slots if slot.material is not None}
    evaluated = obj.evaluated_get(depsgraph)
    made = list(evaluated.to_mesh().materials)
    evaluated.to_mesh_clear()
    return any(m is not None and m.name not in own and glows(m.original) for m in made)
