# SPDX-License-Identifier: GPL-3.0-or-later
"""Show coverage maps and proposals in the scene, and store their figures for the panels.

A map is a mesh with a square for each cell. A proposed detector is shown as an empty. The figures
are numbers such as the coverage of each room.
"""

from __future__ import annotations

import json
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix

from ...sensor_logic.coverage.grid import CoverageMap
from ...sensor_logic.coverage.picture import LEVELS, VIRIDIS, levels, linear
from ...sensor_logic.kind import Kind, Preset
from ...sensor_logic.kinds import KINDS
from ...sensor_logic.logs.error import AngenError
from ...sensor_logic.logs.wording import listed
from ...sensor_logic.parameters import specs
from ..recording.followed_map import FollowedMap
from ..recording.results import RESULTS
from ..runtime import handlers
from ..runtime.sensor_runner import matrix_of
from ..scene.marks import COVERAGE_MARK
from ..scene.sensors import Sensor, decimal, read_parameters, unit_scale
from .maps import MAPPED, check_mapped
from .proposal import Proposal

COLLECTION = "Coverage"
# m. The map is this far above the floor, so that rugs do not hide it. The side of a square relative
# to its cell: gaps separate the squares.
ABOVE_M, FILLED = 0.03, 0.94
CORNERS = np.array([(-0.5, -0.5, 0.0), (0.5, -0.5, 0.0), (0.5, 0.5, 0.0), (-0.5, 0.5, 0.0)])


def show_map(scene: Any, coverage: CoverageMap) -> Any:
    """Show a map in the scene, in place of an earlier map of the same motion; return its object.

    Maps of other motions are hidden, because all maps have the same place. The object is ignored by
    sensors, hidden in renders, and not selectable.
    """
    name = f"{COLLECTION} {coverage.motion.label.lower()}"
    remove(scene, coverage.motion.identifier)
    made = bpy.data.objects.new(name, _mesh(scene, coverage, name))
    made[COVERAGE_MARK] = coverage.motion.identifier
    made.angen_ignored = True
    made.hide_render = True
    made.hide_select = True
    collection(scene).objects.link(made)
    _show_only(scene, coverage.motion.identifier)
    return made


def _show_only(scene: Any, mark: str) -> None:
    """Hide all maps but that with this mark, which is the identifier of its motion."""
    for obj in scene.objects:
        if is_map(obj):
            obj.hide_viewport = obj[COVERAGE_MARK] != mark


def is_map(obj: Any) -> bool:
    """Return whether an object is a coverage map."""
    return COVERAGE_MARK in obj and obj.type == "MESH"


def remove(scene: Any, motion: str = "") -> int:
    """Remove the coverage maps of a motion, by default of all motions; return their number.

    By default, maps that are hidden while a proposal is shown are removed too.
    """
    shown = [
        obj for obj in scene.objects if is_map(obj) and (not motion or obj[COVERAGE_MARK] == motion)
    ]
    for obj in shown:
        mesh = obj.data
        bpy.data.objects.remove(obj)
        if mesh is not None and not mesh.users:
            bpy.data.meshes.remove(mesh)
    remove_own_collection(scene)
    return len(shown)


def remove_own_collection(scene: Any) -> None:
    """Remove the collection of maps and proposals if it is empty."""
    for child in list(scene.collection.children):
        if COVERAGE_MARK in child and not child.objects and not child.children:
            bpy.data.collections.remove(child)


def collection(scene: Any) -> Any:
    """Return the scene's collection for maps and proposals; add it if it is missing."""
    for child in scene.collection.children:
        if COVERAGE_MARK in child:
            return child
    made = bpy.data.collections.new(COLLECTION)
    made[COVERAGE_MARK] = True
    made.hide_render = True
    scene.collection.children.link(made)
    return made


def _mesh(scene: Any, coverage: CoverageMap, name: str) -> Any:
    cells, metres = coverage.cells, unit_scale(scene)
    middle = cells.at + np.array([0.0, 0.0, ABOVE_M])
    points = (middle[:, None, :] + CORNERS * cells.size * FILLED).reshape(-1, 3) / metres
    mesh = bpy.data.meshes.new(name)
    mesh[COVERAGE_MARK] = True
    mesh.from_pydata(points.tolist(), [], np.arange(len(points)).reshape(-1, 4).tolist())
    level = levels(coverage)
    colours = np.ones((len(points), 4))
    colours[:, :3] = np.repeat(linear(VIRIDIS)[level], 4, axis=0)
    layer = mesh.color_attributes.new(COLLECTION, "FLOAT_COLOR", "POINT")
    layer.data.foreach_set("color", colours.ravel().astype(np.float32))
    mesh.color_attributes.active_color = layer
    facts = {"noticed": coverage.best, "margin": np.minimum(coverage.margin, 1e6)}
    for attribute, values in facts.items():
        data = mesh.attributes.new(attribute, "FLOAT", "FACE").data
        data.foreach_set("value", values.astype(np.float32))
    data = mesh.attributes.new("sensors", "INT", "FACE").data
    data.foreach_set("value", coverage.count.astype(np.int32))
    # The solid view shows materials, unless the user chooses attributes.
    for number, label in enumerate(LEVELS):
        mesh.materials.append(_material(f"{COLLECTION}: {label}", number))
    mesh.polygons.foreach_set("material_index", level.astype(np.int32))
    return mesh


def _material(name: str, level: int) -> Any:
    found = bpy.data.materials.get(name)
    if found is None or found.library is not None:
        found = bpy.data.materials.new(name)
        found[COVERAGE_MARK] = True
    found.diffuse_color = (*linear(VIRIDIS)[level].tolist(), 1.0)
    return found


# The value of the mark on proposed detectors. They are empties, which no sensor sees.
PROPOSAL = "PROPOSAL"
# m. Size of the empties.
SHOWN_M = 0.25
LIKE, PRESET = "angen_like", "angen_preset"


def show_proposal(scene: Any, proposal: Proposal, like: str = "", preset: str = "") -> list[Any]:
    """Show an empty at each proposed pose, and the coverage map of the proposed detectors.

    They replace an earlier proposal. If the user accepts the detectors, they get the parameters of
    the sensor named `like`, or else of the preset. Return the empties.
    """
    discard(scene)
    made = []
    for candidate, name in zip(proposal.chosen, proposal.names, strict=True):
        ghost = bpy.data.objects.new(name, None)
        ghost.empty_display_type = "CONE"
        ghost.empty_display_size = SHOWN_M / unit_scale(scene)
        ghost.matrix_world = Matrix(matrix_of(candidate.pose, unit_scale(scene)).tolist())
        ghost.show_name = ghost.show_in_front = True
        ghost[COVERAGE_MARK] = PROPOSAL
        ghost.angen_sensor.room = candidate.room
        ghost[LIKE], ghost[PRESET] = like, preset
        collection(scene).objects.link(ghost)
        made.append(ghost)
    put_aside(scene, proposal.map.motion.identifier)
    show_map(scene, proposal.map)
    keep(scene, proposal.map)
    return made


def proposed(scene: Any) -> list[Any]:
    """Return the empties that show proposed detectors, sorted by name."""
    found = [obj for obj in scene.objects if obj.get(COVERAGE_MARK) == PROPOSAL]
    return sorted(found, key=lambda obj: obj.name)


def discard(scene: Any) -> int:
    """Remove a proposal and show the earlier map again; return the number of proposed detectors."""
    found = proposed(scene)
    for ghost in found:
        bpy.data.objects.remove(ghost)
    bring_back(scene)
    remove_own_collection(scene)
    return len(found)


# While the map of a proposal is shown, the map of the home is hidden.
BEFORE, ASIDE = "angen_coverage_before", "ASIDE "


def is_of_proposal(scene: Any) -> bool:
    """Return whether the map in the scene is that of a proposal."""
    return BEFORE in scene


def put_aside(scene: Any, motion: str) -> None:
    """Mark the map of this motion as hidden and store the last map's figures.

    `show_map` hides the marked map, and `bring_back` restores it.
    """
    for obj in scene.objects:
        if is_map(obj) and obj[COVERAGE_MARK] == motion:
            obj[COVERAGE_MARK] = ASIDE + motion
    facts = {key: scene[key] for key in (KEY, FollowedMap.KEY) if key in scene}
    scene[BEFORE] = json.dumps({"motion": motion, "facts": facts})


def bring_back(scene: Any) -> None:
    """Remove a proposal's map, and show the last map before the proposal, if there is one."""
    if not is_of_proposal(scene):
        return
    before = json.loads(scene.pop(BEFORE))
    remove(scene, before["motion"])
    forget(scene)
    for key, text in before["facts"].items():
        scene[key] = text
    for obj in scene.objects:
        if is_map(obj) and obj[COVERAGE_MARK] == ASIDE + before["motion"]:
            obj[COVERAGE_MARK] = before["motion"]
    _show_only(scene, _motion(summary(scene)) or before["motion"])


def accept_map(scene: Any) -> None:
    """Make the map of an accepted proposal the map of the home, and mark it as out of date.

    The map lacks the home's other detectors, and the user may have moved some of the new ones.
    """
    if is_of_proposal(scene):
        remove(scene, ASIDE + json.loads(scene.pop(BEFORE))["motion"])


def pattern(sensor: Sensor | None, identifier: str) -> tuple[Kind, Any, float]:
    """Return the kind, the parameters and the update rate (Hz) of the detectors to place.

    They are those of the sensor, or without one those of the preset, or without both the defaults.
    Raise `AngenError` if the sensor has no coverage map or the preset is unknown.
    """
    if sensor is not None:
        check_mapped(sensor)
        rate = decimal(sensor.settings.update_rate)
        return sensor.kind, read_parameters(sensor, sensor.settings), rate
    kind, preset = preset_of(identifier)
    if preset is None:
        return kind, kind.parameters(), kind.update_rate
    return kind, kind.parameters(**preset.values), preset.rate or kind.update_rate


def preset_of(identifier: str) -> tuple[Kind, Preset | None]:
    """Return the preset with an identifier, and its kind; without an identifier, a default kind.

    Raise `AngenError` if no kind with coverage maps has the preset.
    """
    if not identifier:
        return MAPPED[0], None
    known = {preset.identifier: (kind, preset) for kind in MAPPED for preset in kind.presets}
    if identifier not in known:
        raise AngenError(f"no preset is called '{identifier}': choose one of {', '.join(known)}")
    return known[identifier]


def copy_settings(source: Any, target: Any) -> None:
    """Copy the parameters and the update rate of one sensor to another."""
    target.update_rate, target.preset = source.update_rate, source.preset
    kind = KINDS[source.kind]
    old, new = (getattr(owner, kind.attribute) for owner in (source, target))
    for name in specs(kind.parameters):
        setattr(new, name, getattr(old, name))


# The figures of the last map, for panels. They are plain values in the scene, so that undo and
# saving include them.
KEY = "angen_coverage_summary"
# The settings that a map depends on.
SETTINGS = ("motion", "height", "cell", "rooms", "selected")


def keep(scene: Any, coverage: CoverageMap) -> None:
    """Store the figures of a map, and the settings with which it was made, in the scene."""
    rooms = [
        (room.name, room.cells * room.area, room.share, room.dead * room.area)
        for room in [*coverage.rooms(), coverage.total()]
    ]
    facts = {
        "motion": coverage.motion.label,
        "sensors": len(coverage.sensors),
        "names": list(coverage.sensors),
        "rooms": rooms,
        "frame": scene.frame_current,
        "settings": _settings(scene),
    }
    RESULTS.note_result(scene, bpy.context.evaluated_depsgraph_get(), FollowedMap)
    scene[KEY] = json.dumps(facts)
    # While the map was made, Blender has reported it as an edit.
    _marking.note_edit(scene)


def legend() -> list[tuple[Any, str]]:
    """Return the material of each colour of maps in this file, with what it means."""
    found = ((bpy.data.materials.get(f"{COLLECTION}: {label}"), label) for label in LEVELS)
    return [(material, label) for material, label in found if material is not None]


def _settings(scene: Any) -> dict[str, Any]:
    return {name: getattr(scene.angen_coverage, name) for name in SETTINGS}


def summary(scene: Any) -> dict[str, Any] | None:
    """Return the stored figures of the last map, or None if there are none.

    The keys are `motion`, `sensors` (their number), `names` (of the sensors) and `rooms`. A room
    has a name, its area in m², its coverage (0 to 1), and its uncovered area in m². The last entry
    is for all rooms together.
    Files of earlier versions lack the keys `frame`, `names` and `settings`.
    """
    if KEY not in scene:
        return None
    try:
        found = json.loads(scene[KEY])
        return found if {"motion", "sensors", "rooms"} <= set(found) else None
    except (ValueError, TypeError):
        return None


def _motion(found: dict[str, Any] | None) -> str | None:
    """Return the identifier of the motion of the last map from its figures, if they have it."""
    return (found or {}).get("settings", {}).get("motion")


def why_stale(scene: Any) -> str:
    """Return why the map no longer matches the scene, in a few words; empty if it matches."""
    found = summary(scene)
    if found is None:
        return ""
    followed = RESULTS.result(scene, FollowedMap)
    if followed is None:
        return "it was made by an earlier version of Ängen Sensors"
    if followed.stale:
        return followed.stale
    was, names = found.get("settings", {}), scene.angen_coverage.bl_rna.properties
    changed = [names[n].name for n, v in _settings(scene).items() if was.get(n, v) != v]
    return f"changed since: {listed(changed, 3)}" if changed else ""


def forget(scene: Any) -> None:
    """Remove all stored figures of maps, also those that `put_aside` stored."""
    for key in (KEY, FollowedMap.KEY, BEFORE):
        scene.pop(key, None)


class _Marking:
    """Draws maps as wire that no longer match the scene.

    Undo does not restore the display type, so it is checked again after each undo.
    """

    def wants_rays(self, scene: Any) -> bool:
        """Return False, because drawing the map needs no rays."""
        return False

    def follow(self, scene: Any, view_layer: Any, depsgraph: Any) -> None:
        """Check after a frame change whether the map still matches the scene."""
        self.note_edit(scene)

    def note_edit(self, scene: Any) -> None:
        """Draw the last map textured if it matches the scene, and all other maps as wire.

        Only the last map is known to match: the scene stores no fingerprint of the others.
        """
        found = summary(scene)
        if found is None:
            return
        is_stale, motion = why_stale(scene), _motion(found)
        for obj in scene.objects:
            if not is_map(obj) or obj[COVERAGE_MARK].startswith(ASIDE):
                continue
            is_last = motion in (None, obj[COVERAGE_MARK])
            look = "TEXTURED" if is_last and not is_stale else "WIRE"
            if obj.display_type != look:
                obj.display_type = look


_marking = _Marking()


def register() -> None:
    handlers.add_view(_marking)


def unregister() -> None:
    handlers.remove_view(_marking)
