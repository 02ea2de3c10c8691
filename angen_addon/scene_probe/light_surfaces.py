# SPDX-License-Identifier: GPL-3.0-or-later
"""What the preview of light knows of surfaces: colour, whether light passes, whether they glow."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
GREY = np.full(3, 0.5)
CLEAR = {"BSDF_TRANSPARENT", "BSDF_GLASS", "BSDF_REFRACTION"}
COLOURED = {"BSDF_DIFFUSE", "BSDF_TRANSLUCENT", "BSDF_GLOSSY"}


class Surfaces:
    """Facts of materials, found once each."""

    def __init__(self) -> None:
        self._known: dict[int, tuple[Array, Array]] = {}

    def of_hit(self, seen: Any, face: int) -> tuple[Array, Array]:
        """Reflectance (3,) and transmittance (3,) of the face of an evaluated object."""
        material = None
        if seen.type == "MESH" and face < len(seen.data.polygons):
            slot = seen.data.polygons[face].material_index
            if slot < len(seen.material_slots):
                material = seen.material_slots[slot].material
        elif seen.material_slots:
            material = seen.material_slots[0].material
        if material is None:
            return np.full(3, 0.8), np.zeros(3)
        key = material.original.session_uid
        if key not in self._known:
            self._known[key] = _facts(material)
        return self._known[key]


def _facts(material: Any) -> tuple[Array, Array]:
    shown = np.array(material.diffuse_color[:3], np.float64)
    if not material.node_tree:
        return shown, np.zeros(3)
    for node in material.node_tree.nodes:
        if node.type == "BSDF_PRINCIPLED":
            through = _value(node, "Transmission Weight")
            alpha = _value(node, "Alpha")
            colour = _colour(node, "Base Color", shown)
            clear = (1.0 - alpha) + alpha * through * colour
            return colour * alpha * (1.0 - through), clear
    clear = np.zeros(3)
    colour = None
    for node in material.node_tree.nodes:
        if node.type in CLEAR:
            clear = _colour(node, "Color", np.ones(3))
        elif node.type in COLOURED and colour is None:
            colour = _colour(node, "Color", shown)
    return (shown if colour is None else colour) * (1.0 - clear), clear


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
