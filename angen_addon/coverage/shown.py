# SPDX-License-Identifier: GPL-3.0-or-later
"""Shows in the scene what was found: a coverage map as a mesh with a square for each cell, proposed
detectors as empties, and the figures that panels show."""

from __future__ import annotations

import json
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix

from ...sensor_logic.coverage.detectors import DETECTOR, PirParameters
from ...sensor_logic.coverage.grid import CoverageMap
from ...sensor_logic.coverage.picture import LEVELS, VIRIDIS, levels, linear
from ...sensor_logic.error import AngenError
from ...sensor_logic.parameters import specs
from ..runtime.sensor_runner import matrix_of
from ..scene.marks import COVERAGE_MARK
from ..scene.sensors import Sensor, decimal, read_parameters, unit_scale
from .proposal import Proposal

COLLECTION = "Coverage"
# m above the floor, so that rugs do not hide it; squares leave a gap, which shows the cells.
ABOVE_M, FILLED = 0.03, 0.94
CORNERS = np.array([(-0.5, -0.5, 0.0), (0.5, -0.5, 0.0), (0.5, 0.5, 0.0), (-0.5, 0.5, 0.0)])


def show_map(scene: Any, coverage: CoverageMap) -> Any:
    """The object that shows a map; it takes the place of the one of the same motion. No sensor
    sees it, no render shows it, and nothing is selected by a click on it."""
    name = f"{COLLECTION} {coverage.motion.label.lower()}"
    remove(scene, coverage.motion.identifier)
    made = bpy.data.objects.new(name, _mesh(scene, coverage, name))
    made[COVERAGE_MARK] = coverage.motion.identifier
    made.angen_ignored = True
    made.hide_render = True
    made.hide_select = True
    collection(scene).objects.link(made)
    return made


def is_map(obj: Any) -> bool:
    return COVERAGE_MARK in obj and obj.type == "MESH"


def remove(scene: Any, motion: str = "") -> int:
    """Takes the maps of a motion, or all, out of the scene; how many there were."""
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
    """Removes the collection of maps if it is empty."""
    for child in list(scene.collection.children):
        if COVERAGE_MARK in child and not child.objects and not child.children:
            bpy.data.collections.remove(child)


def collection(scene: Any) -> Any:
    """The scene's collection for maps and proposals."""
    for child in scene.collection.children:
        if COVERAGE_MARK in child:
            return child
    own = bpy.data.collections.new(COLLECTION)
    own[COVERAGE_MARK] = True
    own.hide_render = True
    scene.collection.children.link(own)
    return own


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
    # Solid view shows materials, as long as nobody chooses attributes there.
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


# Proposed detectors in the scene: empties, which no sensor sees, until they are accepted.

PROPOSAL = "PROPOSAL"
# m: as large as an empty is drawn.
SHOWN_M = 0.25
LIKE, PRESET = "angen_like", "angen_preset"


def show_proposal(scene: Any, proposal: Proposal, like: str = "", preset: str = "") -> list[Any]:
    """Empties at the proposed poses, in place of those of an earlier proposal; `like` is the
    sensor, `preset` the preset, whose parameters they get when accepted."""
    discard(scene)
    made = []
    for candidate, name in zip(proposal.chosen, proposal.names, strict=True):
        ghost = bpy.data.objects.new(name, None)
        ghost.empty_display_type = "CONE"
        ghost.empty_display_size = SHOWN_M / unit_scale(scene)
        ghost.matrix_world = Matrix(matrix_of(candidate.pose, unit_scale(scene)).tolist())
        ghost.show_name = True
        ghost[COVERAGE_MARK] = PROPOSAL
        ghost.angen_sensor.room = candidate.room
        ghost[LIKE], ghost[PRESET] = like, preset
        collection(scene).objects.link(ghost)
        made.append(ghost)
    return made


def proposed(scene: Any) -> list[Any]:
    """The empties of a proposal, by name."""
    found = [obj for obj in scene.objects if obj.get(COVERAGE_MARK) == PROPOSAL]
    return sorted(found, key=lambda obj: obj.name)


def discard(scene: Any) -> int:
    """Takes a proposal out of the scene; of how many detectors it was."""
    found = proposed(scene)
    for ghost in found:
        bpy.data.objects.remove(ghost)
    remove_own_collection(scene)
    return len(found)


def pattern(sensor: Sensor | None, preset: str) -> tuple[PirParameters, float]:
    """Parameters and update rate (Hz) of detectors to place: those of a sensor, or of a preset, or
    the defaults. Raises AngenError."""
    if sensor is not None:
        parameters = read_parameters(sensor, sensor.settings)
        if not isinstance(parameters, PirParameters):
            raise AngenError(f"'{sensor.name}' is no motion detector (PIR)")
        return parameters, decimal(sensor.settings.update_rate)
    rate = DETECTOR.update_rate
    if not preset:
        return PirParameters(), rate
    known = {p.identifier: p for p in DETECTOR.presets}
    if preset not in known:
        raise AngenError(f"no preset is called '{preset}': there are {', '.join(known)}")
    return PirParameters(**known[preset].values), rate


def copy_settings(source: Any, target: Any) -> None:
    """Gives a sensor the parameters and the update rate of another one."""
    target.update_rate = source.update_rate
    old, new = (getattr(owner, DETECTOR.attribute) for owner in (source, target))
    for name in specs(DETECTOR.parameters):
        setattr(new, name, getattr(old, name))


# Keeps what panels show of the last map: plain values in the scene, so that undo and saving take
# care of them.

KEY = "angen_coverage_summary"


def keep(scene: Any, coverage: CoverageMap) -> None:
    rooms = [
        (room.name, room.cells * room.area, room.share, room.dead * room.area)
        for room in [*coverage.rooms(), coverage.total()]
    ]
    facts = {"motion": coverage.motion.label, "sensors": len(coverage.sensors), "rooms": rooms}
    scene[KEY] = json.dumps(facts)


def summary(scene: Any) -> dict[str, Any] | None:
    """`motion`, number of `sensors`, `rooms` as (name, m², share, dead m²), all rooms last."""
    if KEY not in scene:
        return None
    try:
        found = json.loads(scene[KEY])
        return found if {"motion", "sensors", "rooms"} <= set(found) else None
    except (ValueError, TypeError):
        return None


def forget(scene: Any) -> None:
    scene.pop(KEY, None)
