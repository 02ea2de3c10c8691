# SPDX-License-Identifier: GPL-3.0-or-later
"""The lamps and the world of a light scene, each in a Cycles light group of its own.

A picture tells the light of each group apart, at a power that stays. Light is linear in power: in
any state of the lamps it is a weighted sum, and a lamp that is switched or dimmed needs no new
picture. What glows in no group (meshes, lamps in instances) is what the groups leave of the whole.

Cycles sends shadow rays to lamps by their power. So lamps have equal powers here, and sun and sky
less than their own: they would take most rays also in rooms that they do not reach.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ....sensor_logic.model import Array, LightShare
from ..animation import curves, is_animated
from ..changes import POWER, tint_of
from ..facts import present_facts
from .materials import has_nodes

# What a lamp has where nobody knows how bright the lamps become, W.
LAMP = 20.0
# W/m² of a sun for each W of a lamp. The same of the world's strength, at most, and its share of
# what it is at its brightest.
SUN, WORLD, WORLD_SHARE = 0.01, 0.015, 0.1
TINY = 1e-9
WORLD_SOURCE = "World"


@dataclass
class _Group:
    """Lamps that share the user's `data`; in the light scene, `made`: a copy of these with another
    `power`, made when what else they hold was `values`. `users`: names of the user's objects."""

    name: str
    data: Any
    power: float
    values: str = ""
    made: Any = None
    lamps: list[Any] = field(default_factory=list)
    users: list[str] = field(default_factory=list)


class LightGroups:
    """The light groups of a light scene; `lamps`: its lamps' data, whose median power all get."""

    def __init__(self, light_scene: Any, lamps: Iterable[Any]) -> None:
        self._light_scene = light_scene
        self._groups: dict[int, _Group] = {}
        self._strength: Callable[[], float] | None = None
        self._world_share = 1.0
        known = [power for data in lamps if data.type != "SUN" and (power := _highest_power(data))]
        self._power = float(np.median(known)) if known else LAMP

    def add(self, lamp: Any, user: str) -> Any | None:
        """Gives a lamp that was made for the light scene, for the user's object of a name, a power
        and a group; None: it never shines."""
        data = lamp.data
        group = self._groups.get(data.session_uid)
        if group is None:
            if _highest_power(data) == 0.0:
                return None
            power = SUN * self._power if data.type == "SUN" else self._power
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
        """Puts the world in a group; `world`: a copy made for the light scene.

        A background at the end of its nodes is made darker, and its strength is told apart.
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
            # Keys of what becomes linked count no more; the original's say how bright it is.
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
        """Takes over what of the lamps' data has changed beside their power."""
        for group in self._groups.values():
            if repr(present_facts(group.data, POWER)) != group.values:
                before = group.made
                self._make_data(group)
                for lamp in group.lamps:
                    lamp.data = group.made
                self._light_scene.disown(before)

    @property
    def names(self) -> list[str]:
        world = ["world"] if self._strength else []
        return [group.name for group in self._groups.values()] + world

    @property
    def sources(self) -> list[LightShare]:
        """The source of each group's light, with no light yet."""
        lamps = [LightShare(tuple(g.users), "", 0.0) for g in self._groups.values()]
        return lamps + ([LightShare((), WORLD_SOURCE, 0.0)] if self._strength else [])

    @property
    def state(self) -> Hashable:
        """What beside the lamps' present power decides the light of the groups, as it is now."""
        lamps = tuple((group.values, group.power) for group in self._groups.values())
        return lamps, self._world_share

    def weights(self) -> Array:
        """(groups, 3): how bright each is now in the user's scene, as a multiple of here."""
        found = [g.data.energy * tint_of(g.data) / g.power for g in self._groups.values()]
        if self._strength:
            found.append(np.full(3, self._strength()))
        return np.array(found).reshape(-1, 3)

    def _make_data(self, group: _Group) -> None:
        """A copy of the lamps' data and nodes as they are now, and stay."""
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
    """The highest power that a lamp's data have in the file: 0 only where they never shine, None
    where nobody knows."""
    tinted = any(is_animated(data, path) for path in POWER if path != "energy")
    energy = None if tinted else _highest(data, "energy", data.energy)
    found = None if energy is None else energy * float(np.abs(tint_of(data)).max())
    return found if found is None or math.isfinite(found) else None


def _highest(owner: Any, path: str, now: float) -> float | None:
    """The same of a value that is `now` so much."""
    if owner.animation_data is None:
        return abs(float(now))
    if not is_animated(owner, path) and not owner.animation_data.nla_tracks:
        return abs(float(now))
    # What is driven, or 0 at all keys.
    keys = [abs(key.co.y) for curve in curves(owner, {path}) for key in curve.keyframe_points]
    return max(keys, default=0.0) or None


def _background(world: Any) -> Any | None:
    """The background node that is all of a world; None where there is more to it, or no nodes."""
    if not has_nodes(world):
        return None
    outputs = [n for n in world.node_tree.nodes if n.type == "OUTPUT_WORLD" and n.is_active_output]
    links = outputs[0].inputs["Surface"].links if outputs else ()
    node = links[0].from_node if links else None
    return node if node is not None and node.type == "BACKGROUND" else None
