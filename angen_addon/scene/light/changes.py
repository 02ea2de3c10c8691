# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether anything that light depends on has changed since the last look.

Blender's list of updates names everything that may have changed, and every animated datablock at
every frame. So it says where to look, and values decide: those that datablocks have now, as keys
and drivers set them. What cannot be compared (nodes that make geometry, images, volumes) counts as
changed.

The fuller lists of `scene.facts` take 8 times as long for a tree of nodes.
"""

from __future__ import annotations

import hashlib
from collections.abc import Container, Sequence
from functools import cache
from typing import Any, NamedTuple

import bpy
import numpy as np
from numpy.typing import NDArray

from ..animation import only_moves
from ..instances import shown_objects
from ..marks import LIGHT_MARK
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


class LightState(NamedTuple):
    """How often what light depends on was found changed: where two states are equal, so is the
    light. `power`: of lamps; `motion`: place and shape of objects, and which picture of a film they
    show; `values`: all else. `edits`: how often more than the frame may have changed."""

    power: int
    motion: int
    values: int
    edits: int

    @property
    def light(self) -> tuple[int, int, int]:
        """What readings depend on: an edit that changes none of it changes no light."""
        return self[:3]


# Before the first look.
NEVER = LightState(-1, -1, -1, -1)


class LightChanges:
    """Remembers the state of a scene as digests. To be told of updates as they come."""

    def __init__(self) -> None:
        self._state = NEVER
        self.forget()

    def forget(self) -> None:
        """The next look finds everything changed: after undo, or when a file was opened."""
        # Changes of values and of shapes.
        self._count = self._reshaped = 0
        self._known: dict[int, bytes] = {}
        # Of power, motion and values, as in `LightState`.
        self._digests: tuple[bytes | None, ...] = (None, None, None)
        self._empties_matter = False
        # Pictures that change by themselves: Blender's list of updates does not tell of them.
        self._has_films = False
        # By object, whether frames can change where it is, and no other value of its own.
        self._only_moves: dict[int, bool] = {}
        # What nodes look up in the view layer, the scene and the world.
        self._names: set[str] = set()
        # Whether anybody asks about the frames that come: each names all that frames can change.
        self.is_asked = True

    def note(self, depsgraph: Any, edited: bool = False, by_frame: bool = False) -> None:
        """Takes down what was evaluated anew; to be called in the handlers of each evaluation:
        later the list is empty. `edited`: by more than a change of frame."""
        if not self._known or (by_frame and not edited and not self.is_asked):
            return
        if edited:
            self._only_moves.clear()
        for update in depsgraph.updates:
            changed = update.id
            if isinstance(changed, TOLD_ELSEWHERE):
                continue
            if isinstance(changed, bpy.types.Object):
                if edited or self._may_change(changed.original):
                    self._compare(changed.original, object_values(changed))
                if update.is_updated_geometry and changed.type not in LIGHTLESS | {"LIGHT"}:
                    self._compare_shape(changed)
            elif isinstance(changed, bpy.types.Mesh) and not edited:
                # Its object tells of the shape.
                self._compare(changed.original, own_properties(changed))
            else:
                self._compare(changed.original, self._values_of(changed))

    def look(
        self, view_layer: Any, depsgraph: Any, edits: int = 0, asked: Any = None
    ) -> LightState:
        """The state of the scene, and of what is `asked` of it; `edits` as in the state."""
        if not self._known:
            self._know_all(depsgraph)
        scene = view_layer.id_data
        world = scene.world.session_uid if scene.world else 0
        names = [(name, looked_up(name, view_layer)) for name in sorted(self._names)]
        shown = list(shown_objects(view_layer))
        apart, other = powers(shown)
        uids = [obj.session_uid for obj in shown]
        found = (
            _digest(apart),
            self._motion(view_layer, depsgraph),
            _digest([self._count, world, asked, names, other, uids]),
        )
        known = zip(self._state.light, self._digests, found, strict=True)
        counts = [count + (was != now) for count, was, now in known]
        self._state, self._digests = LightState._make([*counts, edits]), found
        return self._state

    def _may_change(self, original: Any) -> bool:
        """Whether a frame can change more of an object than where it is, and its shape."""
        uid = original.session_uid
        if uid not in self._only_moves:
            self._only_moves[uid] = only_moves(original)
        return not self._only_moves[uid]

    def _compare(self, original: Any, found: Any) -> None:
        key, digest = original.as_pointer(), _digest(found)
        if digest is None or self._known.get(key) != digest:
            self._count += 1
            self._known[key] = digest or b""

    def _compare_shape(self, evaluated: Any) -> None:
        original = evaluated.original
        # Beside the object's own entry.
        key, digest = -original.as_pointer(), _digest(shape_values(evaluated))
        if digest is None or self._known.get(key) != digest:
            self._reshaped += 1
            self._known[key] = digest or b""

    def _know_all(self, depsgraph: Any) -> None:
        """The state against which updates are compared from now on."""
        self._known[0] = b""
        for obj in depsgraph.objects:
            self._known[obj.original.as_pointer()] = _digest(object_values(obj)) or b""
            if obj.type == "MESH" and (obj.original.modifiers or obj.original.data.shape_keys):
                self._compare_shape(obj)
        data = bpy.data
        for mesh in data.meshes:
            self._known[mesh.as_pointer()] = _digest(own_properties(mesh)) or b""
        for group in (data.worlds, data.materials, data.lights, data.node_groups):
            for original in group:
                evaluated = original.evaluated_get(depsgraph)
                self._known[original.as_pointer()] = _digest(self._values_of(evaluated)) or b""
                tree = getattr(original, "node_tree", None)
                if tree is not None and group is not data.node_groups:
                    found = self._values_of(evaluated.node_tree)
                    self._known[tree.as_pointer()] = _digest(found) or b""

    def _values_of(self, datablock: Any) -> Any:
        """The values of a datablock that light may depend on; None where they cannot be told."""
        if isinstance(datablock, bpy.types.NodeTree):
            self._empties_matter |= looks_at_places(datablock)
            self._has_films |= bool(films(datablock))
            self._names |= names_looked_up(datablock)
            return tree_values(datablock)
        if isinstance(datablock, bpy.types.Light):
            # Their power is looked at at each update. An embedded tree is told of by itself too.
            return lamp_values(datablock, power=False)
        if isinstance(datablock, (bpy.types.Material, bpy.types.World)):
            tree = datablock.node_tree
            return values(datablock), self._values_of(tree) if tree else ()
        return None

    def _motion(self, view_layer: Any, depsgraph: Any) -> bytes:
        """A digest of where everything is, of changes of shapes, and of the pictures of films."""
        digest, objects = hashlib.blake2b(digest_size=16), depsgraph.objects
        matrices = np.empty(len(objects) * 16, np.float32)
        objects.foreach_get("matrix_world", matrices)
        if not self._empties_matter:
            matter = np.fromiter((o.type not in LIGHTLESS for o in objects), bool, len(objects))
            matrices = matrices.reshape(-1, 16)[matter]
        digest.update(matrices.tobytes())
        film = view_layer.id_data.frame_float if self._has_films else None
        digest.update(repr((self._reshaped, film)).encode())
        if any(obj.is_instancer for obj in view_layer.objects):
            for instance in depsgraph.object_instances:
                if instance.is_instance:
                    seen = instance.object.session_uid, instance.show_self
                    digest.update(repr(seen).encode())
                    digest.update(np.array(instance.matrix_world, np.float32).tobytes())
        return digest.digest()


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
        if LIGHT_MARK not in data:
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


def _digest(found: Any) -> bytes | None:
    if found is None:
        return None
    return hashlib.blake2b(repr(found).encode(), digest_size=16).digest()
