# SPDX-License-Identifier: GPL-3.0-or-later
"""The lamps that the viewport shows, as numbers, with Blender's radiometric conventions."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .nodes import has_nodes

Array = NDArray[np.float64]
ROUND = {"DISK", "ELLIPSE"}
TWO_SIZES = {"RECTANGLE", "ELLIPSE"}


@dataclass(frozen=True)
class Lamp:
    """One lamp. `power` (3,): linear colour times watts (sun: W/m² across its beam).

    `place` (3,), `axis` (3,): where it stands and shines to. `sides` (2, 3): edges of an area lamp
    in the world. `radius`: of a point or spot lamp's ball; `angle`: of a sun's disk across or a
    spot's cone.
    """

    name: str
    type: str
    power: Array
    place: Array
    axis: Array
    radius: float
    angle: float
    blend: float
    sides: Array
    round: bool
    soft: bool
    normalize: bool
    shadow: bool

    @property
    def area(self) -> float:
        full = float(np.linalg.norm(np.cross(self.sides[0], self.sides[1])))
        return full * (math.pi / 4 if self.round else 1.0)

    @property
    def intensity(self) -> float:
        """W/sr to every side of a point or spot lamp, for a power of 1."""
        if self.normalize or self.radius == 0.0:
            return 1.0 / (4.0 * math.pi)
        return self.radius**2

    @property
    def flux(self) -> Array:
        """W (3,) that it sends out; a sun's is not known without the scene."""
        if self.type == "AREA":
            return self.power * (1.0 if self.normalize else self.area)
        if self.type == "SUN":
            return np.zeros(3)
        share = 1.0
        if self.type == "SPOT":
            # Mean of the smooth edge over the cosine: half of it counts.
            edge = math.cos(self.angle / 2)
            share = (1.0 - edge) * (1.0 - self.blend / 2) / 2
        return self.power * self.intensity * 4.0 * math.pi * share


def lamps_of(depsgraph: Any, view_layer: Any) -> list[Lamp]:
    """The shown lamps, in the order of their names; without those that are off or no number."""
    found = []
    for instance in depsgraph.object_instances:
        seen = instance.object
        if seen.type != "LIGHT" or not instance.show_self:
            continue
        owner = (instance.parent or seen).original if instance.is_instance else seen.original
        if owner.visible_get(view_layer=view_layer) and not owner.angen_ignored:
            found.append(_lamp(seen, np.array(instance.matrix_world, np.float64)))
    lamps = [lamp for lamp in found if np.isfinite(lamp.power).all() and lamp.power.any()]
    return sorted(lamps, key=lambda lamp: (lamp.name, lamp.place.tolist()))


def _lamp(seen: Any, matrix: Array) -> Lamp:
    data = seen.data
    power = data.energy * tint_of(data) * _strength(data)
    if data.type == "AREA" and getattr(data.cycles, "is_portal", False):
        power = power * 0.0
    size = getattr(data, "size", 0.0)
    size_y = data.size_y if getattr(data, "shape", "") in TWO_SIZES else size
    axis = -matrix[:3, 2]
    length = float(np.linalg.norm(axis))
    return Lamp(
        seen.name,
        data.type,
        power,
        matrix[:3, 3],
        axis / length if length > 0.0 else np.array([0.0, 0.0, -1.0]),
        float(getattr(data, "shadow_soft_size", 0.0)),
        float(getattr(data, "angle", 0.0) if data.type == "SUN" else getattr(data, "spot_size", 0)),
        float(getattr(data, "spot_blend", 0.0)),
        np.stack([matrix[:3, 0] * size, matrix[:3, 1] * size_y]),
        getattr(data, "shape", "") in ROUND,
        bool(getattr(data, "use_soft_falloff", True)),
        bool(getattr(data, "normalize", True)),
        bool(data.use_shadow),
    )


def tint_of(data: Any) -> Array:
    """(3,): what a lamp's energy is multiplied with, beside what its nodes do."""
    tint = np.array(data.color, np.float64) * 2.0 ** getattr(data, "exposure", 0.0)
    return tint * np.array(data.temperature_color) if getattr(data, "use_temperature", 0) else tint


def emission_of(data: Any) -> Any | None:
    """The emission node of a lamp whose nodes do no more than colour it; None where they do."""
    tree = data.node_tree
    outputs = [n for n in tree.nodes if n.type == "OUTPUT_LIGHT" and n.is_active_output]
    if not outputs or not outputs[0].inputs[0].links:
        return None
    node = outputs[0].inputs[0].links[0].from_node
    plain = node.type == "EMISSION" and not any(socket.is_linked for socket in node.inputs)
    return node if plain else None


def _strength(data: Any) -> Array:
    """What its nodes multiply the light with."""
    node = emission_of(data) if has_nodes(data) else None
    if node is None:
        return np.ones(3)
    colour = np.array(node.inputs["Color"].default_value[:3], np.float64)
    return colour * node.inputs["Strength"].default_value
