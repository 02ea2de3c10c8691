# SPDX-License-Identifier: GPL-3.0-or-later
"""The fingerprint of a scene: digests of all settings that readings depend on.

A comparison of the fingerprint of a run with the present one shows whether the recording is stale,
and what has changed since. Fingerprints leave out the pixels of image files, simulations baked to
disk, and data that other add-ons read in handlers and drivers.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Container, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import bpy

from ...sensor_logic.kinds import KINDS
from ...sensor_logic.parameters import specs
from ..scene.facts import (
    animation_facts,
    custom_facts,
    default_owner_properties,
    facts_of,
    part_facts,
    setting_facts,
)
from ..scene.light.changes import OF_MATERIAL, SHADING
from ..scene.marks import COVERAGE_MARK
from ..scene.sensors import Sensor, all_sensors

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
OF_SCENE = ("frame_start", "use_gravity", "gravity")
# Scene settings of the extension that change no reading: they are for display, or for results. All
# others count.
OF_THE_VIEW = {
    "angen_coverage", "angen_day", "angen_live", "angen_overlay", "angen_recording",
    "angen_recording_aside", "angen_show_places", "angen_site", "angen_start", "angen_timeline",
    "angen_topic",
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
    """

    view_layer: str
    light: bool
    digests: dict[str, str] = field(default_factory=dict)

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
    if before is None:
        return f"'{name}' (new)"
    return f"'{name}' (gone)" if now is None else f"'{name}'"
