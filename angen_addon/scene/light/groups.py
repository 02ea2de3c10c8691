# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps and world of a light scene, each in a separate Cycles light group.

A picture has a separate pass for the light of each group, at a fixed power. Light is linear in
power. So for any state of the lamps the light is a weighted sum. A lamp that is switched or dimmed
needs no new picture. Light without a group (from glowing meshes, and lamps in instances) is the
whole picture minus all groups.

Cycles sends more shadow rays to lamps with more power. So all lamps have equal powers here, and sun
and sky have less than their real power. Otherwise sun and sky would take most rays, also in rooms
that they do not reach.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Iterable
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from ....sensor_logic.model import Array, LightShare
from ..animation import curves, is_animated
from ..facts import present_facts
from ..sensors import unit_scale
from ..units import light_factor
from .changes import POWER, tint_of
from .materials import has_nodes

# W: the power of a lamp if the power of all lamps is unknown.
LAMP = 20.0
# W/m² of a sun for each W of a lamp; the largest strength of the world for each W of a lamp; and
# the largest strength of the world as a fraction of its brightest.
SUN, WORLD, WORLD_SHARE = 0.01, 0.015, 0.1
TINY = 1e-9
WORLD_SOURCE = "World"


@dataclass
class _Group:
    """Lamps that share the same data (`bpy.types.Light`).

    Attributes
    ----------
    name
        The name of the light group.
    data
        The user's data.
    power
        The power of the lamps in the light scene.
    values
        The settings of the data when `made` was copied, as text.
    made
        The copy of the data in the light scene.
    lamps
        The lamp objects in the light scene.
    users
        The names of the user's objects that `lamps` represent.
    """

    name: str
    data: Any
    power: float
    values: str = ""
    made: Any = None
    lamps: list[Any] = field(default_factory=list)
    users: list[str] = field(default_factory=list)


class LightGroups:
    """The light groups of a light scene.

    All lamps except suns get the same power. It is the median of the powers of `lamps`, which are
    `bpy.types.Light` data. `scene` is the user's scene.
    """

    def __init__(self, light_scene: Any, scene: Any, lamps: Iterable[Any]) -> None:
        self._light_scene = light_scene
        self._groups: dict[int, _Group] = {}
        self._strength: Callable[[], float] | None = None
        self._world_share = 1.0
        self._factor = partial(light_factor, scene=scene)
        # The power, per square Blender unit, that gives as much light as a watt does per m².
        self._of_watt = 1.0 / unit_scale(scene) ** 2
        known = [
            power * self._factor(data) / self._of_watt
            for data in lamps
            if data.type != "SUN" and (power := _highest_power(data))
        ]
        self._power = float(np.median(known)) if known else LAMP

    def add(self, lamp: Any, user: str) -> Any | None:
        """Set the power and light group of a lamp; return the lamp, or None if it never shines.

        `lamp` is an object of the light scene, and `user` the name of the user's object for which
        it stands.
        """
        data = lamp.data
        group = self._groups.get(data.session_uid)
        if group is None:
            if _highest_power(data) == 0.0:
                return None
            share = SUN if data.type == "SUN" else self._of_watt
            power = share * self._power
            name = f"lamp{len(self._groups):05d}"
            group = self._groups[data.session_uid] = _Group(name, data, power)
            self._light_scene.view_layer.lightgroups.add(name=name)
            self._make_data(group)
        group.lamps.append(lamp)
        if user not in group.users:
            group.users.append(user)
        lamp.data, lamp.lightgroup = group.made, group.name
        return lamp

    def add_world(self, world: Any, original: Any) -> None:
        """Put a world into a light group. `world` is a copy of the user's world `original`.

        If the world's output comes from a background node, the copy is made darker by a factor.
        This factor, and the strength of the user's node, then give the weight of the group.
        """
        self._light_scene.view_layer.lightgroups.add(name="world")
        world.lightgroup = "world"
        self._strength = lambda: 1.0
        background = _background(world)
        if background is None:
            return
        socket, tree = background.inputs["Strength"], world.node_tree
        scale = tree.nodes.new("ShaderNodeMath")
        scale.operation = "MULTIPLY"
        share = WORLD_SHARE
        if socket.is_linked:
            tree.links.new(socket.links[0].from_socket, scale.inputs[0])
            self._strength = lambda: 1.0 / share
        else:
            # Animation of a linked socket has no effect: read the strength from the original world.
            path, now = socket.path_from_id("default_value"), socket.default_value
            highest = _highest(original.node_tree, path, now)
            highest = math.inf if highest is None else highest
            share = max(min(WORLD * self._power, WORLD_SHARE * highest), TINY)
            scale.inputs[0].default_value = 1.0
            users: Any = _background(original)
            self._strength = lambda: users.inputs["Strength"].default_value / share
        scale.inputs[1].default_value = self._world_share = share
        tree.links.new(scale.outputs[0], socket)

    def follow(self) -> None:
        """Copy the data of lamps again if settings other than their power have changed."""
        for group in self._groups.values():
            if repr(present_facts(group.data, POWER)) != group.values:
                before = group.made
                self._make_data(group)
                for lamp in group.lamps:
                    lamp.data = group.made
                self._light_scene.disown(before)

    @property
    def names(self) -> list[str]:
        """The names of the groups; the world comes last."""
        world = ["world"] if self._strength else []
        return [group.name for group in self._groups.values()] + world

    @property
    def sources(self) -> list[LightShare]:
        """The lamp or world of each light group, as a `LightShare` without a measurement."""
        lamps = [LightShare(tuple(g.users), "", 0.0) for g in self._groups.values()]
        return lamps + ([LightShare((), WORLD_SOURCE, 0.0)] if self._strength else [])

    @property
    def state(self) -> Hashable:
        """All values that the light of the groups depends on, except the lamps' present power."""
        lamps = tuple((group.values, group.power) for group in self._groups.values())
        return lamps, self._world_share

    def weights(self) -> Array:
        """Return the present factors (groups, 3) of the light groups.

        A factor is the power in the user's scene divided by the power in the light scene.
        """
        found = [
            g.data.energy * self._factor(g.data) * tint_of(g.data) / g.power
            for g in self._groups.values()
        ]
        if self._strength:
            found.append(np.full(3, self._strength()))
        return np.array(found).reshape(-1, 3)

    def _make_data(self, group: _Group) -> None:
        """Copy the user's data and nodes with the present values, without animation."""
        made = group.made = self._light_scene.own(group.data.copy())
        group.values = repr(present_facts(group.data, POWER))
        made.animation_data_clear()
        if made.node_tree is not None:
            made.node_tree.animation_data_clear()
        made.energy, made.color = group.power, (1.0, 1.0, 1.0)
        if hasattr(made, "exposure"):
            made.exposure = 0.0
        if hasattr(made, "use_temperature"):
            made.use_temperature = False


def _highest_power(data: Any) -> float | None:
    """Return the highest power that a lamp's data have at any frame; None if it is unknown.

    The result is 0 only if the lamp never shines.
    """
    tinted = any(is_animated(data, path) for path in POWER if path != "energy")
    energy = None if tinted else _highest(data, "energy", data.energy)
    found = None if energy is None else energy * float(np.abs(tint_of(data)).max())
    return found if found is None or math.isfinite(found) else None


def _highest(owner: Any, path: str, now: float) -> float | None:
    """Return the highest value of a property at any frame; None if it is unknown.

    `now` is its present value.
    """
    if owner.animation_data is None:
        return abs(float(now))
    if not is_animated(owner, path) and not owner.animation_data.nla_tracks:
        return abs(float(now))
    # A driven value, or one that is 0 at all keyframes, is unknown.
    keys = [abs(key.co.y) for curve in curves(owner, {path}) for key in curve.keyframe_points]
    return max(keys, default=0.0) or None


def _background(world: Any) -> Any | None:
    """Return the background node that gives a world's output; None if another node does."""
    if not has_nodes(world):
        return None
    outputs = [n for n in world.node_tree.nodes if n.type == "OUTPUT_WORLD" and n.is_active_output]
    links = outputs[0].inputs["Surface"].links if outputs else ()
    node = links[0].from_node if links else None
    return node if node is not None and node.type == "BACKGROUND" else None
