# SPDX-License-Identifier: GPL-3.0-or-later
"""What the preview of light knows of surfaces: colour, whether light passes, whether they glow."""

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
    """Facts of materials by their session uids, as they are now."""

    def __init__(self) -> None:
        self._materials: dict[int, Any] = {}
        self._known: dict[int, tuple[Array, Array]] = {0: (np.full(3, 0.8), np.zeros(3))}
        self._clear: dict[int, bool] = {}

    def of(self, uid: int) -> tuple[Array, Array]:
        """Reflectance (3,) and transmittance (3,); of no material, 0, Cycles's grey."""
        if uid not in self._known:
            material = self._material(uid)
            self._known[uid] = self._known[0] if material is None else _facts(material)
        return self._known[uid]

    def are_clear(self, uid: int) -> bool:
        """Whether light can pass, by ways that these facts do not hold."""
        if uid not in self._clear:
            material = self._material(uid)
            self._clear[uid] = material is not None and is_clear(material)
        return self._clear[uid]

    def _material(self, uid: int) -> Any:
        self._materials = self._materials or {m.session_uid: m for m in bpy.data.materials}
        return self._materials.get(uid)


def _facts(material: Any) -> tuple[Array, Array]:
    """Reflectance and transmittance to shadow rays, of the material's surface nodes."""
    shown = np.array(material.diffuse_color[:3], np.float64)
    tree = material.node_tree
    outputs = [n for n in tree.nodes if n.type == "OUTPUT_MATERIAL"] if tree else []
    if not outputs or not outputs[0].inputs["Surface"].links:
        return shown, np.zeros(3)
    return _shader(outputs[0].inputs["Surface"], shown, DEEPEST)


def _shader(socket: Any, shown: Array, depth: int) -> tuple[Array, Array]:
    """What the shader linked to a socket reflects and lets pass; half grey where not known."""
    if not socket.links or depth == 0:
        return np.zeros(3), np.zeros(3)
    node = socket.links[0].from_node
    if node.type == "MIX_SHADER":
        one, two = (_shader(node.inputs[i], shown, depth - 1) for i in (1, 2))
        factor = _factor(node.inputs[0], depth - 1)
        return tuple((1.0 - factor) * a + factor * b for a, b in zip(one, two, strict=True))  # type: ignore[return-value]
    if node.type == "BSDF_PRINCIPLED":
        through, alpha = _value(node, "Transmission Weight"), _value(node, "Alpha")
        colour = _colour(node, "Base Color", shown)
        clear = (1.0 - alpha) + alpha * through * colour
        return colour * alpha * (1.0 - through), clear
    if node.type in CLEAR:
        return np.zeros(3), _colour(node, "Color", np.ones(3))
    if node.type in COLOURED:
        return _colour(node, "Color", shown), np.zeros(3)
    return (np.zeros(3) if node.type == "EMISSION" else GREY), np.zeros(3)


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
