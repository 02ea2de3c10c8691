# SPDX-License-Identifier: GPL-3.0-or-later
"""Find residents, door leaves and carried things that a day cannot move as it should."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

import bpy
import numpy as np

from ...angen_addon.doctor.examined import Examined
from ...angen_addon.scene.animation import LAST_PART, PLACE
from ...angen_addon.scene.instances import chain
from ...angen_addon.scene.lengths import lengths_of
from ...sensor_logic.logs.wording import named
from ..acting.places import MOVED
from .marks import marked
from .person import body_of
from .settings import above, build_of, drawn_stature, residents_in

# As `Found` of the doctor: the problem, the way to mend it, and the names of the objects with it.
Finding = tuple[str, str, tuple[str, ...]]
# Shares by which scales along two axes, and two statures, may differ.
UNEVEN, APART = 1e-3, 0.01


def unmovable(objects: Iterable[Any], are_upright: bool = True) -> Iterator[Finding]:
    """Yield a finding for each object that its parent or a constraint keeps from its place.

    Objects that are upright turn about the vertical alone, unlike things in hands.
    """
    for obj in objects:
        axes = np.array(above(obj))[:3, :3]
        square = axes @ axes.T
        # Of upright things only the scales along x and y must be the same.
        height = square[2, 2] if are_upright else square[0, 0]
        even = np.diag([square[0, 0], square[0, 0], height])
        if np.abs(square - even).max() > 2.0 * UNEVEN * np.abs(square).max():
            over = obj.parent.name
            yield (
                f"'{obj.name}' cannot turn without distortion: what is above it, '{over}', is "
                "scaled differently along its axes",
                f"Apply the scale of '{over}' (Ctrl+A), or give all axes the same scale",
                (obj.name, over),
            )
        yield from _held(obj)
        over = next((one for one in chain(obj.parent) if any(_driven_by_time(one))), None)
        if over is not None:
            yield (
                f"'{obj.name}' moves with the drivers of '{over.name}' during a day",
                f"Clear its parent (Alt+P, Keep Transformation), or delete the drivers of "
                f"'{over.name}'",
                (obj.name, over.name),
            )


def _held(obj: Any) -> Iterator[Finding]:
    """Yield a finding for what moves an object away from where a day puts it."""
    away = f"'{obj.name}' has {{}}, which move it away from where a day puts it"
    acting = _acting(obj.constraints)
    driven = sorted({curve.data_path for curve in _place_drivers(obj)})
    body = obj.rigid_body
    if acting:
        yield (
            f"{away.format('constraints')}: {named(acting)}",
            "Mute or delete them (Constraints tab)",
            (obj.name,),
        )
    if driven:
        yield (
            f"{away.format('drivers')}: {named(driven)}",
            "Delete them (right-click the field, Delete Drivers)",
            (obj.name,),
        )
    if body is not None and body.type == "ACTIVE" and body.enabled and not body.kinematic:
        yield (
            f"'{obj.name}' is moved by physics, not by a day",
            "Tick Animated (Physics tab, Rigid Body), or remove the rigid body",
            (obj.name,),
        )


def _acting(constraints: Iterable[Any]) -> list[str]:
    return [c.name for c in constraints if c.is_valid and not c.mute and c.influence > 0.0]


def _place_drivers(obj: Any) -> list[Any]:
    """Return the drivers of an object's own location, rotation and scale."""
    drivers = obj.animation_data.drivers if obj.animation_data is not None else ()
    return [one for one in drivers if not one.mute and one.data_path.startswith(PLACE)]


def _driven_by_time(obj: Any) -> Iterator[bool]:
    """Yield for each driver of an object's place whether it can change from frame to frame."""
    for curve in _place_drivers(obj):
        yield "frame" in curve.driver.expression or len(curve.driver.variables) > 0


def unmovable_residents(scene: Any) -> Iterator[Finding]:
    """Yield a finding for what keeps a resident, its body or its walking frame from its place."""
    found = [(rig, rig.angen_resident.walking_frame) for rig in residents_in(scene)]
    yield from unmovable(obj for pair in found for obj in pair if obj is not None)
    for rig in residents_in(scene):
        yield from _bodiless(rig)
        names = [n for bone in rig.pose.bones for n in _acting(bone.constraints)]
        animation = rig.animation_data
        paths = [c.data_path for c in animation.drivers if not c.mute] if animation else []
        names += [path for path in paths if path.startswith("pose.") and _is_place(path)]
        if names:
            yield (
                f"Bones of '{rig.name}' have constraints or drivers, which bend the body away from "
                f"its poses in a day: {named(sorted(set(names)))}",
                "Mute or delete them (Pose Mode, Bone Constraints tab; Drivers Editor)",
                (rig.name,),
            )


def _is_place(path: str) -> bool:
    match = LAST_PART.match(path)
    return match is not None and (match.group(2) or "").startswith(PLACE)


def _bodiless(rig: Any) -> Iterator[Finding]:
    """Yield a finding if the mesh of a resident does not follow its armature."""
    body = body_of(rig)
    if body is None:
        yield (
            f"'{rig.name}' has no body: no mesh that its Armature modifier bends is parented to it",
            "Parent the mesh to the armature again (Ctrl+P, Object), or add a new resident",
            (rig.name,),
        )
        return
    bend = [m for m in body.modifiers if m.type == "ARMATURE" and m.object == rig]
    off = np.array(rig.matrix_world.inverted_safe() @ body.matrix_world)
    yield from _held(body)
    if not any(modifier.show_viewport for modifier in bend):
        yield (
            f"'{body.name}' is not bent by '{rig.name}': its Armature modifier is off",
            "Switch it on (Modifiers tab, monitor icon)",
            (body.name, rig.name),
        )
    elif not np.allclose(off, np.eye(4), atol=APART):
        yield (
            f"'{body.name}' is not where its armature '{rig.name}' is, so a day shows it elsewhere",
            "Clear its own location, rotation and scale (Alt+G, Alt+R, Alt+S; and Delta Transform)",
            (body.name, rig.name),
        )


def examined_residents(home: Examined) -> Iterator[Finding]:
    """Yield findings on residents that a day cannot move, or draws with another stature."""
    yield from unmovable_residents(home.scene)
    if residents_in(home.scene):
        yield from unmovable(o for o in marked(home.view_layer) if o.angen_place.use in MOVED)
    lengths = lengths_of(bpy.context.scene)
    for rig in residents_in(home.scene):
        drawn, stature = drawn_stature(rig), build_of(rig).stature
        if abs(drawn - stature) > APART * stature:
            yield (
                f"'{rig.name}' is {lengths.text(drawn)} tall in the scene, because of what is "
                f"above it, but its Stature, and a day, have {lengths.text(stature)}",
                "Type the Stature again (Resident, sidebar's tab Sensors)",
                (rig.name,),
            )
