# SPDX-License-Identifier: GPL-3.0-or-later
"""Fingerprints of scenes: digests of everything that readings depend on. Comparing two of them
shows whether the scene has changed, and what.

They leave out the pixels of image files, simulations baked to disk, and whatever other add-ons'
handlers and functions in drivers read.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import bpy

from ...sensor_logic.kinds import KINDS
from ...sensor_logic.parameters import specs
from ..scene.facts import (
    Facts,
    animation_facts,
    corners_and_faces,
    custom_facts,
    facts_of,
    part_facts,
    setting_facts,
    weights_of,
)
from ..scene.marks import COVERAGE_MARK
from ..scene.sensors import Sensor, all_sensors

SCENE, SHOWN = "scene", "shown"
# The objects renamed since a run: their names at the run, by their names now.
Renamed = Mapping[str, str]
NONE_RENAMED: Renamed = {}
# Datablocks that no sensor notices, and actions, which are in the digests of what uses them.
PASSED_OVER = (
    bpy.types.Action, bpy.types.Brush, bpy.types.Camera, bpy.types.FreestyleLineStyle,
    bpy.types.Mask, bpy.types.MovieClip, bpy.types.PaintCurve, bpy.types.Palette,
    bpy.types.Scene, bpy.types.Screen, bpy.types.Sound, bpy.types.Speaker, bpy.types.Text,
    bpy.types.WindowManager, bpy.types.WorkSpace,
)  # fmt: skip
# Datablocks that only light sensors notice.
SHADING = (
    bpy.types.Image, bpy.types.Light, bpy.types.Material, bpy.types.ShaderNodeTree,
    bpy.types.Texture, bpy.types.World,
)  # fmt: skip
OF_SCENE = ("frame_start", "use_gravity", "gravity")
# The extension's settings of a scene that change no reading: what it shows, and what it does with
# results. All others count.
OF_THE_VIEW = {
    "angen_cleared", "angen_coverage", "angen_day", "angen_live", "angen_overlay",
    "angen_show_places", "angen_site", "angen_timeline",
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

# What every version of Blender has of objects, rigid bodies and lamps: see `portable`.
OF_OBJECT = (
    "location", "rotation_mode", "rotation_euler", "rotation_quaternion", "rotation_axis_angle",
    "scale", "delta_location", "delta_rotation_euler", "delta_scale", "hide_viewport",
    "display_type", "instance_type", "angen_ignored",
)  # fmt: skip
OF_BODY = ("type", "enabled", "kinematic", "mass", "collision_shape", "friction", "restitution")
OF_LIGHT = ("type", "energy", "color", "shadow_soft_size", "shape", "size", "size_y", "spot_size",
            "angle")  # fmt: skip
SHAPED = {"CURVE", "CURVES", "FONT", "META", "SURFACE"}

# By kind of sensor, its parameters that refer to text datablocks.
READS_TEXTS = {
    kind.identifier: names
    for kind in KINDS.values()
    if (names := [n for n, spec in specs(kind.parameters).items() if spec.pointer == "Text"])
}


@dataclass
class Fingerprint:
    """`digests` of the datablocks of a view layer by type and name; `light`: whether they include
    those that only light sensors notice; `portable`: see portable.py."""

    view_layer: str
    light: bool
    digests: dict[str, str] = field(default_factory=dict)
    portable: dict[str, str] = field(default_factory=dict)

    def differences(self, other: Fingerprint) -> dict[str, str]:
        """The differing datablocks by key, as texts for the user."""
        found = {}
        for key in sorted(self.digests.keys() | other.digests.keys()):
            text = _difference(key, self.digests.get(key), other.digests.get(key))
            if text:
                found[key] = text
        return found

    def difference(self, key: str, digest: str | None) -> str:
        """One datablock as a text for the user; empty where its digest is the same."""
        return _difference(key, self.digests.get(key), digest)


def fingerprint_of(
    scene: Any, depsgraph: Any, light: bool, renamed: Renamed = NONE_RENAMED
) -> Fingerprint:
    """The fingerprint of an evaluated scene, with the names that objects had at the run."""
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
    """A digest of the scene's own settings, and of the texts that its sensors read. It is cheap
    enough for every frame."""
    own: list[Any] = [*scene_facts(scene), animation_facts(scene), custom_facts(scene)]
    own += [scene.world.name_full if scene.world and light else None]
    own += [part_facts(scene, scene.rigidbody_world), list(_texts_read(sensors))]
    return digest(own, renamed)


def what_is_shown(view_layer: Any, renamed: Renamed = NONE_RENAMED) -> str:
    """A digest of the names and visibility of objects and collections."""
    shown = [
        (_name_at_run(obj, renamed), obj.hide_get(view_layer=view_layer), _is_disabled(obj))
        for obj in view_layer.objects
        if obj.type != "CAMERA" and not _is_of_a_map(obj)
    ]
    layers = list(_layers(view_layer.layer_collection))
    return digest([sorted(shown), layers])


def scene_facts(scene: Any) -> list[Any]:
    """The scene's settings that readings depend on, without animated values."""
    return [
        setting_facts(scene, part, names)
        for part, names in (
            (scene, [*OF_SCENE, *_names_of_own()]),
            (scene.render, OF_RENDER),
            (scene.unit_settings, OF_UNITS),
        )
    ]


def _names_of_own() -> list[str]:
    """Names of the extension's scene settings that readings depend on: all but OF_THE_VIEW, so that
    a new setting counts unless it is listed there."""
    return sorted(
        prop.identifier
        for prop in bpy.types.Scene.bl_rna.properties
        if prop.identifier.startswith("angen_") and prop.identifier not in OF_THE_VIEW
    )


def _is_disabled(obj: Any) -> bool:
    """Whether the monitor icon hides it, without animation. Blender does not evaluate it then, and
    reports no update when it is shown again."""
    return obj.hide_viewport and bool(setting_facts(obj, obj, ["hide_viewport"])[0])


def _texts_read(sensors: Iterable[Sensor]) -> Iterator[str]:
    """Contents of the texts that sensors read, such as lens tables; Blender reports no edits of
    them."""
    for sensor in sensors:
        names = READS_TEXTS.get(sensor.kind.identifier)
        if names is not None:
            group = getattr(sensor.settings, sensor.kind.attribute)
            for text in (getattr(group, name) for name in names):
                if text is not None:
                    yield text.as_string()


def key_of(original: Any, renamed: Renamed = NONE_RENAMED) -> str:
    return f"{original.bl_rna.identifier} {_name_at_run(original, renamed)}"


def _name_at_run(original: Any, renamed: Renamed) -> str:
    """The name of a datablock at the run."""
    name: str = original.name_full
    return renamed.get(name, name) if isinstance(original, bpy.types.Object) else name


def digest_of(original: Any, renamed: Renamed = NONE_RENAMED) -> str:
    return digest(facts_of(original), renamed)


def warmth_of(original: Any) -> dict[str, str]:
    """By key, a digest of a material's warmth alone, which pyroelectric detectors notice; its look
    they do not."""
    if not isinstance(original, bpy.types.Material):
        return {}
    facts = [part_facts(original, original.angen_warmth), animation_facts(original)]
    return {f"Warmth {original.name_full}": digest(facts)}


def is_looked_at(original: Any) -> bool:
    if isinstance(original, PASSED_OVER) or original.is_embedded_data:
        return False
    return not _is_of_a_map(original)


def _is_of_a_map(original: Any) -> bool:
    """Whether it belongs to a coverage map or a proposal that no sensor can see."""
    if COVERAGE_MARK not in original:
        return False
    if isinstance(original, bpy.types.Object):
        return original.type == "EMPTY" or bool(original.angen_ignored)
    return True


def digest(facts: Any, renamed: Renamed = NONE_RENAMED) -> str:
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
        return "the scene's settings" if key == SCENE else "what is shown or hidden"
    name = key.partition(" ")[2]
    return f"'{name}' (new)" if before is None else f"'{name}'{' (gone)' if now is None else ''}"


def portable(scene: Any, depsgraph: Any) -> dict[str, str]:
    """Digests by the keys of a fingerprint, to compare scenes between versions of Blender."""
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
