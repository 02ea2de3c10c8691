# SPDX-License-Identifier: GPL-3.0-or-later
"""What a scene holds that the preview of light does not model: Cycles is to be asked instead."""

from __future__ import annotations

import math
from typing import Any

from .lamps import emission_of
from .nodes import has_nodes
from .surfaces import glows, is_clear

RAYS = ("diffuse", "glossy", "transmission", "shadow")
FEW = 3


def unmodelled(view_layer: Any, objects: list[Any]) -> str:
    """In words, empty where the preview models everything that `objects` (evaluated) are."""
    found: dict[str, list[str]] = {}
    materials: dict[str, Any] = {}

    def note(what: str, name: str) -> None:
        names = found.setdefault(what, [])
        if name not in names:
            names.append(name)

    for obj in objects:
        if obj.type == "LIGHT":
            data = obj.data
            if has_nodes(data) and emission_of(data) is None:
                note("lamps with nodes", obj.name)
            if data.type == "AREA" and data.spread < math.pi - 1e-3:
                note("area lamps with a narrow spread", obj.name)
        if obj.type == "VOLUME":
            note("volumes", obj.name)
        for slot in obj.material_slots:
            if slot.material is not None:
                materials[slot.material.name_full] = slot.material
        linking = getattr(obj, "light_linking", None)
        if linking and (linking.receiver_collection or linking.blocker_collection):
            note("light linking", obj.name)
        if not all(getattr(obj, f"visible_{rays}") for rays in RAYS):
            note("objects that only some rays see", obj.name)
    for material in materials.values():
        if glows(material):
            note("glowing materials", material.name)
        if is_clear(material):
            note("transparent materials", material.name)
    world = view_layer.id_data.world
    if world is not None and constant_world(world) is None:
        note("world with nodes", world.name)
    return "; ".join(f"{what}: {_few(names)}" for what, names in found.items())


def constant_world(world: Any) -> tuple[float, float, float] | None:
    """Radiance of a world that is the same to all sides; None where it is not."""
    if not has_nodes(world):
        return tuple(world.color)
    outputs = [n for n in world.node_tree.nodes if n.type == "OUTPUT_WORLD" and n.is_active_output]
    if not outputs or not outputs[0].inputs["Surface"].links:
        return (0.0, 0.0, 0.0)
    node = outputs[0].inputs["Surface"].links[0].from_node
    if node.type != "BACKGROUND" or any(socket.is_linked for socket in node.inputs):
        return None
    strength = node.inputs["Strength"].default_value
    red, green, blue = (c * strength for c in node.inputs["Color"].default_value[:3])
    return red, green, blue


def _few(names: list[str]) -> str:
    more = f" and {len(names) - FEW} more" if len(names) > FEW else ""
    return ", ".join(sorted(names)[:FEW]) + more
