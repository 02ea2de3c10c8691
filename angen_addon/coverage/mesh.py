# SPDX-License-Identifier: GPL-3.0-or-later
"""A coverage map as a mesh in the scene: a square for each cell, just above the floor."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np

from ...sensor_logic.coverage.colours import LEVELS, VIRIDIS, levels, linear
from ...sensor_logic.coverage.grid import CoverageMap
from ..scene.marks import COVERAGE_MARK
from ..scene.sensors import unit_scale

COLLECTION = "Coverage"
# m above the floor, so that rugs do not hide it; squares leave a gap, which shows the cells.
ABOVE_M, FILLED = 0.03, 0.94
CORNERS = np.array([(-0.5, -0.5, 0.0), (0.5, -0.5, 0.0), (0.5, 0.5, 0.0), (-0.5, 0.5, 0.0)])


def show(scene: Any, coverage: CoverageMap) -> Any:
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
