# SPDX-License-Identifier: GPL-3.0-or-later
"""Find residents, door leaves and carried things that a day cannot move as it should."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

import bpy
import numpy as np

from ...angen_addon.doctor.examined import Examined
from ...angen_addon.scene.lengths import lengths_of
from ...sensor_logic.wording import named
from .settings import above, build_of, drawn_stature, residents_in

# As `Found` of the doctor: the problem, the way to mend it, and the names of the objects with it.
Finding = tuple[str, str, tuple[str, ...]]
# Shares by which scales along two axes, and two statures, may differ.
UNEVEN, APART = 1e-3, 0.01


def unmovable(objects: Iterable[Any]) -> Iterator[Finding]:
    """Yield a finding for each object that its parent or a constraint keeps from its place."""
    for obj in objects:
        uneven = np.array(above(obj))[:3, :3]
        sizes = np.linalg.svd(uneven, compute_uv=False)
        if sizes[0] - sizes[-1] > UNEVEN * sizes[0]:
            over = obj.parent.name
            yield (
                f"'{obj.name}' cannot turn without distortion: what is above it, '{over}', is "
                "scaled differently along its axes",
                f"Apply the scale of '{over}' (Ctrl+A), or give all axes the same scale",
                (obj.name, over),
            )
        acting = [one.name for one in obj.constraints if not one.mute and one.influence > 0.0]
        if acting:
            yield (
                f"'{obj.name}' has constraints, which move it away from where a day puts it: "
                f"{named(acting)}",
                "Mute or delete them (Constraints tab)",
                (obj.name,),
            )


def moved_residents(scene: Any) -> list[Any]:
    """Return the objects that a day moves with residents: armatures and walking frames."""
    found = [(rig, rig.angen_resident.walking_frame) for rig in residents_in(scene)]
    return [obj for pair in found for obj in pair if obj is not None]


def examined_residents(home: Examined) -> Iterator[Finding]:
    """Yield findings on residents that a day cannot move, or draws with another stature."""
    yield from unmovable(moved_residents(home.scene))
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
