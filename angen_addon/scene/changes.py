# SPDX-License-Identifier: GPL-3.0-or-later
"""Find out whether anything that readings depend on has changed, by digests of datablocks.

A `Fingerprint` has the digests of all settings of a scene. A comparison of the fingerprint of a run
with the present one shows whether the recording is stale, and what has changed since. Fingerprints
leave out the pixels of image files, simulations baked to disk, and data that other add-ons read in
handlers and drivers.

`LightChanges` has digests of the values that light depends on, as keyframes and drivers set them at
the present frame. Blender's list of updates names each datablock that may have changed. At a frame
change these are all animated datablocks. `LightChanges` compares only the values of datablocks in
the list. Datablocks that cannot be compared (nodes that make geometry, images, volumes) count as
changed.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import bpy
import numpy as np
from numpy.typing import NDArray

from ...sensor_logic.kinds import KINDS, owner_properties
from ...sensor_logic.parameters import specs
from .facts import (
    Facts,
    animation_facts,
    corners_and_faces,
    custom_facts,
    default_owner_properties,
    facts_of,
    hashed,
    part_facts,
    plain,
    present_facts,
    setting_facts,
    weights_of,
)
from .instances import shown_objects
from .marks import COVERAGE_MARK, LIGHT_MARK
from .sensors import Sensor, all_sensors
from .timed import DEFORMING_MODIFIERS, films

SCENE, SHOWN = "scene", "shown"
# The objects renamed since a run: by present name, the name at the run.
Renamed = Mapping[str, str]
NONE_RENAMED: Renamed = {}
# Datablocks that no sensor notices, and actions, which are in the digests of their users.
PASSED_OVER = (
    bpy.types.Action, bpy.types.Brush, bpy.types.Camera, bpy.types.FreestyleLineStyle,
    bpy.types.Mask, bpy.types.MovieClip, bpy.types.PaintCurve, bpy.types.Palette,
    bpy.types.Scene, bpy.types.Screen, bpy.types.Sound, bpy.types.Speaker, bpy.types.Text,
    bpy.types.WindowManager, bpy.types.WorkSpace,
)  # fmt: skip
# Datablocks that only light sensors notice. Textures displace vertices.
SHADING = (
    bpy.types.Image, bpy.types.Light, bpy.types.Material, bpy.types.ShaderNodeTree, bpy.types.World,
)  # fmt: skip
OF_SCENE = ("frame_start", "use_gravity", "gravity")
# Scene settings of the extension that change no reading: they are for display, or for results. All
# others count.
OF_THE_VIEW = {
    "angen_coverage", "angen_day", "angen_live", "angen_overlay", "angen_recording",
    "angen_recording_aside", "angen_show_places", "angen_site", "angen_start", "angen_timeline",
}  # fmt: skip
OF_RENDER = (
    "fps", "fps_base", "frame_map_new", "frame_map_old", "use_simplify", "simplify_subdivision",
)  # fmt: skip
OF_UNITS = ("system", "scale_length")
# A camera without other users than these changes no reading.
HARMLESS_USERS = (
    bpy.types.Collection, bpy.types.Scene, bpy.types.Screen, bpy.types.WindowManager,
    bpy.types.WorkSpace,
)  # fmt: skip

# Properties of objects, rigid bodies and lamps in every version of Blender: see `portable`.
OF_OBJECT = (
    "location", "rotation_mode", "rotation_euler", "rotation_quaternion", "rotation_axis_angle",
    "scale", "delta_location", "delta_rotation_euler", "delta_scale", "hide_viewport",
    "display_type", "instance_type", "angen_ignored",
)  # fmt: skip
OF_BODY = ("type", "enabled", "kinematic", "mass", "collision_shape", "friction", "restitution")
OF_LIGHT = ("type", "energy", "color", "shadow_soft_size", "shape", "size", "size_y", "spot_size",
            "angle")  # fmt: skip
SHAPED = {"CURVE", "CURVES", "FONT", "META", "SURFACE"}

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

# By kind of sensor, its parameters that refer to text datablocks.
READS_TEXTS = {
    kind.identifier: names
    for kind in KINDS.values()
    if (names := [n for n, spec in specs(kind.parameters).items() if spec.pointer == "Text"])
}


@dataclass
class Fingerprint:
    """The digests of the datablocks of a view layer.

    Attributes
    ----------
    view_layer
        The name of the view layer.
    light
        Whether datablocks that only light sensors notice are included.
    digests
        Digests by datablock (its `key_of`), and digests of the scene's settings and visibility.
    portable
        The digests that the function `portable` returns.
    """

    view_layer: str
    light: bool
    digests: dict[str, str] = field(default_factory=dict)
    portable: dict[str, str] = field(default_factory=dict)

    def differences(self, other: Fingerprint) -> dict[str, str]:
        """Return a text for the user about each datablock that differs from `other`.

        The texts are by key, as in `digests`.
        """
        found = {}
        for key in sorted(self.digests.keys() | other.digests.keys()):
            text = _difference(key, self.digests.get(key), other.digests.get(key))
            if text:
                found[key] = text
        return found

    def difference(self, key: str, digest: str | None) -> str:
        """Return a text for the user if one datablock has another digest than `digest`.

        The text is empty if the digests are equal. A digest is None for a datablock that does not
        exist.
        """
        return _difference(key, self.digests.get(key), digest)


def fingerprint_of(
    scene: Any, depsgraph: Any, light: bool, renamed: Renamed = NONE_RENAMED
) -> Fingerprint:
    """Return the fingerprint of an evaluated scene.

    Parameters
    ----------
    scene
        The scene.
    depsgraph
        Its evaluated depsgraph, which also gives the view layer.
    light
        Whether to include datablocks that only light sensors notice.
    renamed
        The objects renamed since an earlier run, as a mapping from present names to earlier names.
    """
    view_layer = scene.view_layers[depsgraph.view_layer.name]
    made = Fingerprint(view_layer.name, light)
    originals = [evaluated.original for evaluated in depsgraph.ids]
    read_by_drivers = {key_of(target) for target in _driver_targets(originals)}
    harmless = set(harmless_cameras(originals))
    for original in originals:
        key = key_of(original)
        if original in harmless or not is_looked_at(original):
            continue
        if light or not isinstance(original, SHADING) or key in read_by_drivers:
            made.digests[key_of(original, renamed)] = digest_of(original, renamed)
        made.digests.update(warmth_of(original))
    made.digests[SCENE] = own_settings(scene, all_sensors(view_layer), light, renamed)
    made.digests[SHOWN] = what_is_shown(view_layer, renamed)
    return made


def own_settings(
    scene: Any, sensors: Iterable[Sensor], light: bool, renamed: Renamed = NONE_RENAMED
) -> str:
    """Return a digest of the scene's settings, and of the text datablocks that sensors read.

    It is fast enough for every frame. The parameters are as for `fingerprint_of`.
    """
    own: list[Any] = [*scene_facts(scene), animation_facts(scene), custom_facts(scene)]
    own += [scene.world.name_full if scene.world and light else None]
    own += [part_facts(scene, scene.rigidbody_world), list(_texts_read(sensors))]
    return digest(own, renamed)


def what_is_shown(
    view_layer: Any, renamed: Renamed = NONE_RENAMED, without: Container[Any] = ()
) -> str:
    """Return a digest of the names and visibility of objects and collections.

    Parameters
    ----------
    view_layer
        The view layer.
    renamed
        As for `fingerprint_of`.
    without
        Objects to leave out.
    """
    shown = [
        (_name_at_run(obj, renamed), obj.hide_get(view_layer=view_layer), _is_disabled(obj))
        for obj in view_layer.objects
        if obj.type != "CAMERA" and not _is_of_a_map(obj) and obj not in without
    ]
    layers = list(_layers(view_layer.layer_collection))
    return digest([sorted(shown), layers])


def scene_facts(scene: Any) -> list[Any]:
    """Return the settings of a scene that change readings, with None for animated values."""
    return [
        setting_facts(scene, part, names)
        for part, names in (
            (scene, [*OF_SCENE, *_names_of_own()]),
            (scene.render, OF_RENDER),
            (scene.unit_settings, OF_UNITS),
        )
    ]


def _names_of_own() -> list[str]:
    """Return the names of the extension's scene settings that readings depend on."""
    return sorted(
        prop.identifier
        for prop in bpy.types.Scene.bl_rna.properties
        if prop.identifier.startswith("angen_") and prop.identifier not in OF_THE_VIEW
    )


def _is_disabled(obj: Any) -> bool:
    """Return whether the monitor icon hides an object, and no animation sets that icon.

    Blender does not evaluate the object then, and reports no update when it is shown again.
    """
    return obj.hide_viewport and bool(setting_facts(obj, obj, ["hide_viewport"])[0])


def _texts_read(sensors: Iterable[Sensor]) -> Iterator[str]:
    """Yield the contents of the text datablocks that sensors read, such as lens tables."""
    # Blender reports no edits of text datablocks, so their texts are compared.
    for sensor in sensors:
        names = READS_TEXTS.get(sensor.kind.identifier)
        if names is not None:
            group = getattr(sensor.settings, sensor.kind.attribute)
            for text in (getattr(group, name) for name in names):
                if text is not None:
                    yield text.as_string()


def key_of(original: Any, renamed: Renamed = NONE_RENAMED) -> str:
    """Return the key of a datablock in a fingerprint: its type and its name.

    An object in `renamed` (see `fingerprint_of`) has the name that it had at an earlier run.
    """
    return f"{original.bl_rna.identifier} {_name_at_run(original, renamed)}"


def _name_at_run(original: Any, renamed: Renamed) -> str:
    """Return the name that a datablock had at an earlier run, before objects were `renamed`."""
    name: str = original.name_full
    return renamed.get(name, name) if isinstance(original, bpy.types.Object) else name


def digest_of(original: Any, renamed: Renamed = NONE_RENAMED) -> str:
    """Return the digest of all settings of a datablock.

    `renamed` is as for `fingerprint_of`.
    """
    return digest(facts_of(original), renamed)


def warmth_of(original: Any) -> dict[str, str]:
    """Return the digest of a material's temperature settings, by a key of `Fingerprint.digests`.

    It is empty for other datablocks. Pyroelectric detectors notice the temperature of a material,
    but not its look.
    """
    if not isinstance(original, bpy.types.Material):
        return {}
    groups = sorted(OF_MATERIAL - default_owner_properties(original))
    facts = [
        part_facts(original, original.angen_warmth),
        *(part_facts(original, getattr(original, name)) for name in groups),
        animation_facts(original),
    ]
    return {f"Warmth {original.name_full}": digest(facts)}


def is_looked_at(original: Any) -> bool:
    """Return whether a change of a datablock can change any reading."""
    if isinstance(original, PASSED_OVER) or original.is_embedded_data:
        return False
    return not _is_of_a_map(original)


def _is_of_a_map(original: Any) -> bool:
    """Return whether a datablock belongs to a coverage map or a proposal, unseen by sensors."""
    if COVERAGE_MARK not in original:
        return False
    if isinstance(original, bpy.types.Object):
        return original.type == "EMPTY" or bool(original.angen_ignored)
    return True


def digest(facts: Any, renamed: Renamed = NONE_RENAMED) -> str:
    """Return the digest of nested plain values, such as `facts_of` returns.

    Names in `renamed` (see `fingerprint_of`) are replaced by the earlier names.
    """
    text = repr(facts)
    if renamed:
        # A datablock that refers to a renamed one, such as its child, has not changed.
        names = "|".join(re.escape(repr(now)) for now in renamed)
        then = {repr(now): repr(name) for now, name in renamed.items()}
        text = re.sub(names, lambda found: then[found.group()], text)
    return hashlib.blake2b(text.encode(), digest_size=9).hexdigest()


def _layers(layer: Any) -> Iterator[tuple[Any, ...]]:
    if COVERAGE_MARK not in layer.collection:
        yield layer.name, layer.exclude, layer.hide_viewport, layer.collection.hide_viewport
    for child in layer.children:
        yield from _layers(child)


def _driver_targets(originals: Iterable[Any]) -> Iterator[Any]:
    for original in originals:
        animation = getattr(original, "animation_data", None)
        for curve in animation.drivers if animation else ():
            for variable in curve.driver.variables:
                yield from (target.id for target in variable.targets if target.id)


def harmless_cameras(originals: Iterable[Any]) -> Iterator[Any]:
    """Yield the cameras that only collections, scenes and windows use: they change no reading."""
    cameras = {
        original
        for original in originals
        if isinstance(original, bpy.types.Object)
        and original.type == "CAMERA"
        and original.angen_sensor.kind == "NONE"
    }
    if cameras:
        for camera, users in bpy.data.user_map(subset=cameras).items():
            if camera in cameras and all(isinstance(user, HARMLESS_USERS) for user in users):
                yield camera


def _difference(key: str, before: str | None, now: str | None) -> str:
    if before == now:
        return ""
    if key in {SCENE, SHOWN}:
        return "the scene's settings" if key == SCENE else "which objects are shown"
    name = key.partition(" ")[2]
    return f"'{name}' (new)" if before is None else f"'{name}'{' (gone)' if now is None else ''}"


def portable(scene: Any, depsgraph: Any) -> dict[str, str]:
    """Return digests that are the same in all versions of Blender, as in `Fingerprint.digests`.

    They cover fewer properties than those digests.
    """
    layer = scene.view_layers[depsgraph.view_layer.name]
    found = {
        SCENE: digest([scene_facts(scene), animation_facts(scene)]),
        SHOWN: what_is_shown(layer),
    }
    originals = [evaluated.original for evaluated in depsgraph.ids]
    harmless = set(harmless_cameras(originals))
    for original in originals:
        if original not in harmless and is_looked_at(original):
            found[key_of(original)] = digest(list(_facts(original)))
    return found


def _facts(original: Any) -> Iterator[Any]:
    yield animation_facts(original)
    if isinstance(original, bpy.types.Object):
        yield from _object(original)
    elif isinstance(original, bpy.types.Mesh):
        yield from _mesh(original)
    elif isinstance(original, bpy.types.Armature):
        yield [
            (bone.name, bone.parent.name if bone.parent else "", *bone.head_local, *bone.tail_local)
            for bone in original.bones
        ]
    elif isinstance(original, bpy.types.Light):
        yield setting_facts(original, original, [n for n in OF_LIGHT if hasattr(original, n)])


def _object(obj: Any) -> Iterator[Facts]:
    yield [obj.type, *(getattr(other, "name_full", "") for other in (obj.data, obj.parent))]
    yield [getattr(slot.material, "name_full", "") for slot in obj.material_slots]
    yield setting_facts(obj, obj, OF_OBJECT)
    yield [tuple(row) for row in obj.matrix_parent_inverse]
    yield [(modifier.name, modifier.type, modifier.show_viewport) for modifier in obj.modifiers]
    yield [(constraint.name, constraint.type, constraint.mute) for constraint in obj.constraints]
    yield [part_facts(obj, obj.angen_sensor), part_facts(obj, obj.angen_load)]
    groups = {made.attribute for made in owner_properties("Object")}
    for name in sorted(groups - default_owner_properties(obj)):
        yield part_facts(obj, getattr(obj, name))
    if obj.rigid_body is not None:
        yield setting_facts(obj, obj.rigid_body, OF_BODY)
    if obj.type == "MESH" and obj.vertex_groups:
        yield weights_of(obj.data)
    if obj.type in SHAPED:
        # Each version stores their points in another way.
        yield [tuple(round(c, 4) for c in corner) for corner in obj.bound_box]


def _mesh(mesh: Any) -> Iterator[Any]:
    if mesh.is_editmode:
        yield "is edited"
        return
    yield from corners_and_faces(mesh)


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
        apart, other = powers(shown, self._instanced)
        found = (
            digest(apart),
            self._motion(view_layer, depsgraph),
            digest([self._count, world, asked, names, other, uids]),
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
        now = "" if found is None else digest(found)
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


def powers(shown: Sequence[Any], instanced: Container[Any] = ()) -> tuple[list[Any], list[Any]]:
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
