# SPDX-License-Identifier: GPL-3.0-or-later
"""Find out whether anything that light depends on has changed, by digests of datablocks.

Keyframes and drivers set values at each frame. Blender's list of updates names each datablock that
may have changed. At a frame change these are all animated datablocks. `LightChanges` compares only
the values of datablocks in the list. Datablocks that cannot be compared (nodes that make geometry,
images, volumes) count as changed.
"""

from __future__ import annotations

import hashlib
from collections.abc import Container, Sequence
from typing import Any, NamedTuple

import bpy
import numpy as np
from numpy.typing import NDArray

from ....sensor_logic.kinds import owner_properties
from ..facts import Facts, custom_facts, hashed, plain, present_facts
from ..instances import shown_objects
from ..marks import LIGHT_MARK
from ..timed import DEFORMING_MODIFIERS, films

# Datablocks that only light sensors notice. Textures displace vertices.
SHADING = (
    bpy.types.Image, bpy.types.Light, bpy.types.Material, bpy.types.ShaderNodeTree, bpy.types.World,
)  # fmt: skip
# Properties that light depends on, apart from an object's place, shape and visibility.
SEEN_OF_OBJECT = (
    "angen_ignored", "color", "display_type", "hide_render", "is_holdout", "is_shadow_catcher",
    "pass_index", "visible_camera", "visible_diffuse", "visible_glossy", "visible_shadow",
    "visible_transmission", "visible_volume_scatter",
)  # fmt: skip
# Properties of a lamp in which light is linear.
POWER = frozenset(
    ("color", "energy", "exposure", "temperature", "temperature_color", "use_temperature")
)
# Updates name node trees separately. No light depends on the warmth of a material.
OF_MATERIAL = frozenset(made.attribute for made in owner_properties("Material"))
NO_LOOK = OF_MATERIAL | {"node_tree", "angen_warmth"}
# Modifiers that change nothing but vertices and faces, which are compared.
SHAPING = DEFORMING_MODIFIERS | {"SUBSURF"}
# Types of objects without influence on light.
LIGHTLESS = {"EMPTY", "CAMERA", "ARMATURE", "SPEAKER", "LATTICE"}
# Datablocks whose changes are found through objects, or that light does not depend on.
TOLD_ELSEWHERE = (
    bpy.types.Action, bpy.types.Armature, bpy.types.Camera, bpy.types.Collection, bpy.types.Key,
    bpy.types.Scene, bpy.types.Speaker,
)  # fmt: skip


class LightState(NamedTuple):
    """Counters of the changes that affect light. Equal states have equal light.

    Attributes
    ----------
    power
        Changes of the power of lamps.
    motion
        Changes of the places and shapes of objects, and of the images of films.
    values
        Changes of all other values.
    edits
        Possible edits, as the caller counts them.
    """

    power: int
    motion: int
    values: int
    edits: int

    @property
    def light(self) -> tuple[int, int, int]:
        """The counters without `edits`, since an edit may leave all values as they were."""
        return self[:3]


# The state before the first call of `look`.
NEVER = LightState(-1, -1, -1, -1)


class LightChanges:
    """Counts changes that affect light, in a `LightState`. Call `note` after each evaluation."""

    def __init__(self) -> None:
        self._state = NEVER
        self.forget()

    def forget(self) -> None:
        """Make the next `look` count everything as changed, as after undo or in a new file."""
        # Changes of values and of shapes.
        self._count = self._reshaped = 0
        # The latest digests: of values by the pointer, and of shapes by the negative pointer.
        self._known: dict[int, str] = {}
        # The digests of power, motion and values, as in `LightState`.
        self._digests: tuple[str | None, ...] = (None, None, None)
        self._empties_matter = False
        # The data of lamps in instances, and what they were found for. To look at each frame would
        # take a microsecond an instance.
        self._instanced: set[Any] = set()
        self._instanced_at: Any = None
        # Whether there are films, whose changes are not in Blender's list of updates.
        self._has_films = False
        # Attributes that nodes look up in the view layer, the scene and the world.
        self._names: set[str] = set()
        # Whether any caller needs the state at the next frames.
        self.is_asked = True

    def note(self, depsgraph: Any, edited: bool = False, by_frame: bool = False) -> None:
        """Compare the datablocks that were just evaluated with their stored digests.

        Call it in the handlers of each evaluation: later, Blender's list of updates is empty.

        Parameters
        ----------
        depsgraph
            The evaluated depsgraph.
        edited
            Whether there may be other changes than by the frame.
        by_frame
            Whether a frame change caused the evaluation.
        """
        if not self._known or (by_frame and not edited and not self.is_asked):
            return
        for update in depsgraph.updates:
            changed = update.id
            if isinstance(changed, TOLD_ELSEWHERE):
                continue
            if isinstance(changed, bpy.types.Mesh) and edited:
                self._count += 1
                continue
            self._count += self._differs(changed)
            if isinstance(changed, bpy.types.Object) and update.is_updated_geometry:
                self._reshaped += self._is_reshaped(changed)

    def look(
        self, view_layer: Any, depsgraph: Any, edits: int = 0, asked: Any = None
    ) -> LightState:
        """Return the present `LightState` of the scene.

        Parameters
        ----------
        view_layer
            The view layer whose objects count.
        depsgraph
            The evaluated depsgraph.
        edits
            The number of edits so far, for `LightState.edits`.
        asked
            Further values that light depends on; their changes count in `LightState.values`.
        """
        if not self._known:
            self._know_all(depsgraph)
        scene = view_layer.id_data
        world = scene.world.session_uid if scene.world else 0
        names = [(name, looked_up(name, view_layer)) for name in sorted(self._names)]
        shown = list(shown_objects(view_layer))
        uids = [obj.session_uid for obj in shown]
        if self._instanced_at != (self._count, uids, edits):
            self._instanced_at = self._count, uids, edits
            self._instanced = _instanced_lights(depsgraph)
        apart, other = lamp_powers(shown, self._instanced)
        found = (
            _digest(apart),
            self._motion(view_layer, depsgraph),
            _digest([self._count, world, asked, names, other, uids]),
        )
        known = zip(self._state.light, self._digests, found, strict=True)
        counts = [count + (was != now) for count, was, now in known]
        self._state, self._digests = LightState._make([*counts, edits]), found
        return self._state

    def _know_all(self, depsgraph: Any) -> None:
        """Store the present digests of all datablocks, for comparison with later ones."""
        for obj in depsgraph.objects:
            self._differs(obj)
            if obj.type == "MESH" and (obj.original.modifiers or obj.original.data.shape_keys):
                self._is_reshaped(obj)
        data = bpy.data
        for group in (data.meshes, data.worlds, data.materials, data.lights, data.node_groups):
            for original in group:
                evaluated = original.evaluated_get(depsgraph)
                self._differs(evaluated)
                tree = getattr(evaluated, "node_tree", None)
                if tree is not None:
                    self._differs(tree)

    def _differs(self, evaluated: Any) -> bool:
        return self._is_new(evaluated.original.as_pointer(), self._values_of(evaluated))

    def _is_reshaped(self, evaluated: Any) -> bool:
        if evaluated.type in LIGHTLESS | {"LIGHT"}:
            return False
        return self._is_new(-evaluated.original.as_pointer(), shape_values(evaluated))

    def _is_new(self, key: int, found: Facts | None) -> bool:
        """Store the digest of values under `key`; return whether the digest has changed.

        If `found` is None, the values are unknown, which counts as a difference.
        """
        now = "" if found is None else _digest(found)
        same = bool(now) and self._known.get(key) == now
        self._known[key] = now
        return not same

    def _values_of(self, evaluated: Any) -> Facts | None:
        """Return the values of a datablock that light may depend on; None if they are unknown."""
        if isinstance(evaluated, bpy.types.Object):
            return object_values(evaluated)
        if isinstance(evaluated, bpy.types.Mesh):
            # The shape is compared through the object.
            return custom_facts(evaluated, present=True)
        if isinstance(evaluated, bpy.types.NodeTree):
            self._empties_matter |= looks_at_places(evaluated)
            self._has_films |= bool(films(evaluated))
            self._names |= names_looked_up(evaluated)
            return present_facts(evaluated)
        if isinstance(evaluated, bpy.types.Light):
            # The power is compared at each look.
            return present_facts(evaluated, POWER)
        if isinstance(evaluated, (bpy.types.Material, bpy.types.World)):
            return present_facts(evaluated, NO_LOOK)
        return None

    def _motion(self, view_layer: Any, depsgraph: Any) -> str:
        """Return a digest of all world matrices, the count of changed shapes, and films' frame."""
        found, objects = hashlib.blake2b(digest_size=16), depsgraph.objects
        matrices = np.empty(len(objects) * 16, np.float32)
        objects.foreach_get("matrix_world", matrices)
        if not self._empties_matter:
            matter = np.fromiter((o.type not in LIGHTLESS for o in objects), bool, len(objects))
            matrices = matrices.reshape(-1, 16)[matter]
        found.update(matrices.tobytes())
        film = view_layer.id_data.frame_float if self._has_films else None
        found.update(repr((self._reshaped, film)).encode())
        if any(obj.is_instancer for obj in view_layer.objects):
            for instance in depsgraph.object_instances:
                if instance.is_instance:
                    seen = instance.object.session_uid, instance.show_self
                    found.update(repr(seen).encode())
                    found.update(np.array(instance.matrix_world, np.float32).tobytes())
        return found.hexdigest()


def object_values(evaluated: Any) -> Facts:
    """Return the values of an object that light depends on, except place, shape and visibility."""
    materials = [slot.material for slot in evaluated.material_slots]
    found: Facts = [
        [plain(getattr(evaluated, name)) for name in SEEN_OF_OBJECT],
        evaluated.angen_sensor.kind,
        [material.original.session_uid if material else 0 for material in materials],
        custom_facts(evaluated, present=True),
    ]
    linking = getattr(evaluated, "light_linking", None)
    if linking is not None:
        for collection in (linking.receiver_collection, linking.blocker_collection):
            found.append([o.session_uid for o in collection.all_objects] if collection else 0)
    return found


def shape_values(evaluated: Any) -> Facts | None:
    """Return values that identify an object's shape; None if the shape cannot be read."""
    original, mesh = evaluated.original, evaluated.data
    deformed = original.type == "MESH" and all(m.type in SHAPING for m in original.modifiers)
    if not deformed or mesh.is_editmode:
        return None
    points = np.empty(len(mesh.vertices) * 3, np.float32)
    mesh.attributes["position"].data.foreach_get("vector", points)
    return [hashed(points), len(mesh.loops), len(mesh.polygons)]


def looks_at_places(tree: Any) -> bool:
    """Return whether nodes of a tree read objects, or attributes, which anything can drive."""
    return any(getattr(n, "object", None) or n.type == "ATTRIBUTE" for n in tree.nodes)


def _instanced_lights(depsgraph: Any) -> set[Any]:
    """Return the data of lamps in instances, as collections, nodes, vertices or particles make."""
    return {
        one.object.data.original
        for one in depsgraph.object_instances
        if one.is_instance and one.object.type == "LIGHT"
    }


def lamp_powers(
    shown: Sequence[Any], instanced: Container[Any] = ()
) -> tuple[list[Any], list[Any]]:
    """Return the powers of lamps that light groups can separate, and the powers of all other lamps.

    A lamp can be separated if all objects that use its data are among `shown`, the objects that the
    viewport shows, and if its data are not among `instanced`, the data of lamps in instances.
    """
    users: dict[Any, int] = {}
    for obj in shown:
        if obj.type == "LIGHT":
            users[obj.data] = users.get(obj.data, 0) + 1
    apart: list[Any] = []
    other: list[Any] = []
    for data in bpy.data.lights:
        if LIGHT_MARK not in data:
            is_apart = data.users - data.use_fake_user == users.get(data) and data not in instanced
            power = data.session_uid, data.energy, *tint_of(data)
            (apart if is_apart else other).append(power)
    return apart, other


def tint_of(data: Any) -> NDArray[np.float64]:
    """Return the RGB factors (3,) by which a lamp's colour settings multiply its energy.

    They are for colour, exposure and colour temperature.
    """
    tint = np.array(data.color, np.float64) * 2.0 ** getattr(data, "exposure", 0.0)
    return tint * np.array(data.temperature_color) if getattr(data, "use_temperature", 0) else tint


def names_looked_up(tree: Any) -> set[str]:
    """Return the names of the attributes of type View Layer that a tree's nodes read.

    Blender looks them up in the view layer, the scene and the world.
    """
    return {
        node.attribute_name
        for node in tree.nodes
        if node.type == "ATTRIBUTE" and node.attribute_type == "VIEW_LAYER" and node.attribute_name
    }


def looked_up(name: str, view_layer: Any) -> Any:
    """Return the value of an attribute of type View Layer, as nodes read it; None if there is none.

    It is a property of the view layer, the scene or the world.
    """
    scene = view_layer.id_data
    for owner in filter(None, (view_layer, scene, scene.world)):
        for path in (f'["{bpy.utils.escape_identifier(name)}"]', name):
            try:
                return plain(owner.path_resolve(path))
            except ValueError:
                continue
    return None


def _digest(facts: Facts) -> str:
    return hashed(repr(facts).encode())
