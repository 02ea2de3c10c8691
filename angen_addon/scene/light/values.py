# SPDX-License-Identifier: GPL-3.0-or-later
"""What light depends on: the values of datablocks, in a form that can be compared."""

from __future__ import annotations

import hashlib
from collections.abc import Container, Sequence
from functools import cache
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ..timed import DEFORMING_MODIFIERS, films

SIMPLE = {"BOOLEAN", "INT", "FLOAT", "ENUM", "STRING", "POINTER"}
# Bookkeeping and looks, which change by themselves.
NO_VALUES = {
    "is_evaluated",
    "is_updated",
    "location",
    "location_absolute",
    "name",
    "name_full",
    "select",
    "session_uid",
    "tag",
    "use_fake_user",
    "users",
    "width",
    "height",
}
if bpy.app.version >= (5, 0):
    # Always on, and to be asked no more.
    NO_VALUES.add("use_nodes")
OF_OBJECT = (
    "angen_ignored",
    "color",
    "display_type",
    "hide_render",
    "is_holdout",
    "is_shadow_catcher",
    "pass_index",
    "visible_camera",
    "visible_diffuse",
    "visible_glossy",
    "visible_shadow",
    "visible_transmission",
    "visible_volume_scatter",
)
# What light is linear in.
POWER = {"color", "energy", "exposure", "temperature", "temperature_color", "use_temperature"}
# Modifiers that touch nothing but vertices and faces, which are compared.
SHAPING = DEFORMING_MODIFIERS | {"SUBSURF"}
# Objects whose place alone matters to no light.
LIGHTLESS = {"EMPTY", "CAMERA", "ARMATURE", "SPEAKER", "LATTICE"}
# Datablocks that are told of by the objects, or that light does not depend on.
TOLD_ELSEWHERE = (
    bpy.types.Action,
    bpy.types.Armature,
    bpy.types.Camera,
    bpy.types.Collection,
    bpy.types.Key,
    bpy.types.Scene,
    bpy.types.Speaker,
)
# Custom property by which what was made for light scenes is known from what the user made.
MARK = "angen_light_made"


def object_values(evaluated: Any) -> list[Any]:
    """What beside its place, shape and visibility decides how an object meets light."""
    found = [_flat(getattr(evaluated, name)) for name in OF_OBJECT]
    found.append(evaluated.angen_sensor.kind)
    found.append(
        [s.material.original.session_uid if s.material else 0 for s in evaluated.material_slots]
    )
    found.append([_flat(v) for k, v in sorted(evaluated.items()) if k != "angen_sensor"])
    linking = getattr(evaluated, "light_linking", None)
    if linking is not None:
        for collection in (linking.receiver_collection, linking.blocker_collection):
            found.append([o.session_uid for o in collection.all_objects] if collection else 0)
    return found


def shape_values(evaluated: Any) -> Any:
    """The shape of an object; None where it cannot be told."""
    original, mesh = evaluated.original, evaluated.data
    deformed = original.type == "MESH" and all(m.type in SHAPING for m in original.modifiers)
    if not deformed or mesh.is_editmode:
        return None
    points = np.empty(len(mesh.vertices) * 3, np.float32)
    mesh.attributes["position"].data.foreach_get("vector", points)
    digest = hashlib.blake2b(points.tobytes(), digest_size=16).digest()
    return digest, len(mesh.loops), len(mesh.polygons)


def tree_values(tree: Any) -> list[Any]:
    """Values of all nodes and their links."""
    found: list[Any] = [
        [(k.from_socket.path_from_id(), k.to_socket.path_from_id()) for k in tree.links]
    ]
    for node in tree.nodes:
        found.append(values(node))
        for socket in (*node.inputs, *node.outputs):
            if hasattr(socket, "default_value"):
                found.append(_flat(socket.default_value))
        ramp = getattr(node, "color_ramp", None)
        if ramp is not None:
            found += [(e.position, *e.color) for e in ramp.elements]
        curves = getattr(node, "mapping", None)
        if isinstance(curves, bpy.types.CurveMapping):
            found += [tuple(p.location) for c in curves.curves for p in c.points]
    return found


def looks_at_places(tree: Any) -> bool:
    """Whether its nodes look at places of objects, or attributes, which anything can drive."""
    return any(getattr(n, "object", None) or n.type == "ATTRIBUTE" for n in tree.nodes)


def has_stiff_films() -> bool:
    """Whether nodes of the file show films that Cycles does not follow in a scene that it keeps."""
    data = bpy.data
    owners = [*data.materials, *data.lights, *data.worlds]
    trees = [*data.node_groups, *(o.node_tree for o in owners if o.node_tree)]
    return any(not node.image_user.use_auto_refresh for tree in trees for node in films(tree))


def values(struct: Any, without: Container[str] = ()) -> list[Any]:
    """The plain values of a datablock or a node."""
    made_of: Any = type(struct)
    return [_flat(getattr(struct, name)) for name in _names(made_of) if name not in without]


def lamp_values(lamp: Any, power: bool = True) -> list[Any]:
    """All values of a lamp's data: its own, with or without its power, Cycles' and the user's, and
    those of its nodes."""
    nodes = tree_values(lamp.node_tree) if lamp.node_tree else None
    own = values(lamp, set() if power else POWER)
    return [own, values(lamp.cycles), own_properties(lamp), nodes]


def powers(shown: Sequence[Any]) -> tuple[list[Any], list[Any]]:
    """Power of the lamps among the shown objects, and of those that others too, such as instances,
    have."""
    users: dict[Any, int] = {}
    for obj in shown:
        if obj.type == "LIGHT":
            users[obj.data] = users.get(obj.data, 0) + 1
    apart: list[Any] = []
    other: list[Any] = []
    for data in bpy.data.lights:
        if MARK not in data:
            is_apart = data.users - data.use_fake_user == users.get(data)
            power = data.session_uid, data.energy, *tint_of(data)
            (apart if is_apart else other).append(power)
    return apart, other


def tint_of(data: Any) -> NDArray[np.float64]:
    """(3,): what a lamp's energy is multiplied with, beside what its nodes do."""
    tint = np.array(data.color, np.float64) * 2.0 ** getattr(data, "exposure", 0.0)
    return tint * np.array(data.temperature_color) if getattr(data, "use_temperature", 0) else tint


def own_properties(owner: Any) -> dict[str, Any]:
    """Its custom properties, but groups of them: numbers, texts and rows of numbers."""
    found = {}
    for key, value in sorted(owner.items()):
        if isinstance(value, (bool, int, float, str)):
            found[key] = value
        elif hasattr(value, "to_list"):
            found[key] = value.to_list()
    return found


def names_looked_up(tree: Any) -> set[str]:
    """What its nodes look up in the view layer, the scene and the world."""
    return {
        node.attribute_name
        for node in tree.nodes
        if node.type == "ATTRIBUTE" and node.attribute_type == "VIEW_LAYER" and node.attribute_name
    }


def looked_up(name: str, view_layer: Any) -> Any:
    """What a node finds by a name in the view layer, the scene or the world; None for nothing."""
    scene = view_layer.id_data
    for owner in filter(None, (view_layer, scene, scene.world)):
        for path in (f'["{bpy.utils.escape_identifier(name)}"]', name):
            try:
                return _flat(owner.path_resolve(path))
            except ValueError:
                continue
    return None


# One a type, until Blender ends; without it 40 to 150 µs more for each struct that is read.
@cache
def _names(kind: Any) -> tuple[str, ...]:
    return tuple(
        p.identifier
        for p in kind.bl_rna.properties
        if p.type in SIMPLE
        and p.identifier not in NO_VALUES
        and not p.identifier.startswith(("bl_", "is_", "show_", "rna_", "node_tree", "preview"))
        and (
            p.type != "POINTER"
            or issubclass(getattr(bpy.types, p.fixed_type.identifier, object), bpy.types.ID)
        )
    )


def _flat(value: Any) -> Any:
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    if isinstance(value, bpy.types.ID):
        return value.original.session_uid
    try:
        return tuple(value)
    except TypeError:
        return str(value)
