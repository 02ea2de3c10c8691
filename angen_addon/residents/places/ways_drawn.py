# SPDX-License-Identifier: GPL-3.0-or-later
"""Ways that end before a place, as curves on the floor, which no sensor sees."""

from __future__ import annotations

from typing import Any

import bpy

from ....sensor_logic.residents.places import Places
from ....sensor_logic.residents.reach import Unreached
from ...scene.marks import WAY_MARK
from ...scene.sensors import unit_scale

COLLECTION = "Ways"
# m: above the floor, and its radius.
ABOVE_M, RADIUS_M = 0.05, 0.015
RED = (0.85, 0.12, 0.1, 1.0)


def show(scene: Any, places: Places, lost: list[Unreached]) -> list[Any]:
    """Draws how far residents get towards each lost place, instead of earlier drawings; returns the
    objects."""
    remove(scene)
    drawn = [one for one in lost if len(one.way) > 1]
    if not drawn:
        return []
    own = bpy.data.collections.new(COLLECTION)
    own[WAY_MARK] = True
    own.hide_render = True
    scene.collection.children.link(own)
    found = []
    for one in drawn:
        obj = _curve(scene, one, places.storeys[one.place.storey].height + ABOVE_M)
        own.objects.link(obj)
        found.append(obj)
    return found


def _curve(scene: Any, lost: Unreached, height: float) -> Any:
    metres = unit_scale(scene)
    name = f"Way to {lost.place.name}"
    curve = bpy.data.curves.new(name, "CURVE")
    curve.dimensions, curve.bevel_depth = "3D", RADIUS_M / metres
    spline = curve.splines.new("POLY")
    spline.points.add(len(lost.way) - 1)
    for point, (x, y) in zip(spline.points, lost.way.tolist(), strict=True):
        point.co = (x / metres, y / metres, height / metres, 1.0)
    curve.materials.append(_material())
    obj = bpy.data.objects.new(name, curve)
    obj[WAY_MARK] = lost.place.name
    obj.angen_ignored = obj.hide_render = True
    obj.color = RED
    return obj


def _material() -> Any:
    name = "Way that ends"
    found = bpy.data.materials.get(name)
    if found is None or found.library is not None:
        found = bpy.data.materials.new(name)
        found.diffuse_color = RED
    return found


def remove(scene: Any) -> int:
    """Takes all ways out of the scene; how many there were."""
    shown = [obj for obj in scene.objects if WAY_MARK in obj]
    for obj in shown:
        curve = obj.data
        bpy.data.objects.remove(obj)
        if curve is not None and not curve.users:
            bpy.data.curves.remove(curve)
    for child in list(scene.collection.children):
        if WAY_MARK in child and not child.objects:
            bpy.data.collections.remove(child)
    return len(shown)
