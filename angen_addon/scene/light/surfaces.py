# SPDX-License-Identifier: GPL-3.0-or-later
"""What materials' nodes tell of a surface: its colour, whether light passes, whether it glows."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
GREY = np.full(3, 0.5)
CLEAR = {"BSDF_TRANSPARENT", "BSDF_GLASS", "BSDF_REFRACTION"}
DEEPEST = 8
# Of window glass (n = 1.5) from the front.
FRONT_FRESNEL = 0.04
COLOURED = {"BSDF_DIFFUSE", "BSDF_TRANSLUCENT", "BSDF_GLOSSY", "BSDF_METALLIC"}


class Surfaces:
    """The colours of materials by their session uids, as they are now."""

    def __init__(self) -> None:
        self._materials: dict[int, Any] = {}
        self._known: dict[int, Array] = {0: np.full(3, 0.8)}

    def reflectance(self, uid: int) -> Array:
        """Return the reflectance (3,) of a material; of no material, 0, Cycles's grey."""
        if uid not in self._known:
            self._materials = self._materials or {m.session_uid: m for m in bpy.data.materials}
            material = self._materials.get(uid)
            self._known[uid] = self._known[0] if material is None else _reflectance(material)
        return self._known[uid]


def _reflectance(material: Any) -> Array:
    """Return the reflectance (3,) of a material's surface nodes."""
    shown = np.array(material.diffuse_color[:3], np.float64)
    tree = material.node_tree
    outputs = [n for n in tree.nodes if n.type == "OUTPUT_MATERIAL"] if tree else []
    if not outputs or not outputs[0].inputs["Surface"].links:
        return shown
    return _reflected(outputs[0].inputs["Surface"], shown, DEEPEST)


def _reflected(socket: Any, shown: Array, depth: int) -> Array:
    """Return the share (3,) that the shader linked to a socket reflects; half where not known."""
    if not socket.links or depth == 0:
        return np.zeros(3)
    node = socket.links[0].from_node
    if node.type == "MIX_SHADER":
        one, two = (_reflected(node.inputs[i], shown, depth - 1) for i in (1, 2))
        factor = _factor(node.inputs[0], depth - 1)
        return np.asarray((1.0 - factor) * one + factor * two, np.float64)
    if node.type == "BSDF_PRINCIPLED":
        through, alpha = _value(node, "Transmission Weight"), _value(node, "Alpha")
        return _colour(node, "Base Color", shown) * alpha * (1.0 - through)
    if node.type in COLOURED:
        return _colour(node, "Color", shown)
    return np.zeros(3) if node.type in CLEAR | {"EMISSION"} else GREY


def _factor(socket: Any, depth: int) -> float:
    """A mixing factor as a shadow ray finds it from the front."""
    if not socket.is_linked or depth == 0:
        return float(socket.default_value)
    link = socket.links[0]
    node = link.from_node
    if node.type == "LIGHT_PATH":
        return float(link.from_socket.name == "Is Shadow Ray")
    if node.type == "NEW_GEOMETRY":
        return 0.0
    if node.type == "FRESNEL":
        return FRONT_FRESNEL
    if node.type == "MATH" and node.operation == "MULTIPLY":
        return _factor(node.inputs[0], depth - 1) * _factor(node.inputs[1], depth - 1)
    return 0.5


def _value(node: Any, name: str) -> float:
    socket = node.inputs.get(name)
    return 0.0 if socket is None else float(socket.default_value)


def _colour(node: Any, name: str, otherwise: Array) -> Array:
    socket = node.inputs[name]
    return otherwise if socket.is_linked else np.array(socket.default_value[:3], np.float64)


def glows(material: Any) -> bool:
    """Whether its nodes can send out light."""
    for node in _nodes(material.node_tree, set()):
        if node.type == "EMISSION":
            return True
        strength = node.inputs.get("Emission Strength")
        if strength is not None and (strength.is_linked or strength.default_value != 0.0):
            colour = node.inputs.get("Emission Color")
            if colour is None or colour.is_linked or any(colour.default_value[:3]):
                return True
    return False


def is_clear(material: Any) -> bool:
    """Whether its nodes can let light pass."""
    for node in _nodes(material.node_tree, set()):
        if node.type in CLEAR or node.type == "BSDF_TRANSLUCENT":
            return True
        for name, opaque in (("Alpha", 1.0), ("Transmission Weight", 0.0)):
            socket = node.inputs.get(name) if node.type == "BSDF_PRINCIPLED" else None
            if socket is not None and (socket.is_linked or socket.default_value != opaque):
                return True
    return False


def _nodes(tree: Any, seen: set[int]) -> Any:
    """All nodes of a tree and of its groups."""
    if tree is None or tree.as_pointer() in seen:
        return
    seen.add(tree.as_pointer())
    for node in tree.nodes:
        yield node
        if node.type == "GROUP":
            yield from _nodes(node.node_tree, seen)
