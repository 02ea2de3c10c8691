# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of pressure pads, and of the rigid bodies that press on them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...sensor_logic.kind import FORCES
from ...sensor_logic.wording import named, uncapitalized
from ..advice import sensing as advice
from ..scene.rays.caster import NOTHING
from .examined import Examined, Found

BUNDLE = -41
# m: a pad with nothing this near below it hangs in the air.
GAP = 0.05


def advised(home: Examined) -> Iterator[Found]:
    """Reports pads that nothing can press on, or that sink."""
    for pad in home.requiring(FORCES):
        for warning in (
            advice.without_surface(pad.object),
            advice.sinks(pad.object, home.scene),
            advice.weightless(pad.object, home.scene, home.view_layer),
            advice.hidden_partner(pad, home.view_layer),
        ):
            if warning:
                yield f"'{pad.name}': {uncapitalized(warning.problem)}", warning.mend, (pad.name,)


def margins(home: Examined) -> Iterator[Found]:
    """Reports active meshes, whose collision margin pads feel: readings are not valid while they
    hop."""
    if not home.requiring(FORCES):
        return
    margins = {
        part.name: part.rigid_body.collision_margin * home.metres * 1000.0
        for body in advice.simulated_bodies(home.scene)
        for part in (body, *body.children)
        if part.rigid_body is not None and part.rigid_body.collision_shape == "MESH"
    }
    if margins:
        yield (
            f"Active meshes, which Blender holds off pads by their collision margin (up to "
            f"{max(margins.values()):.3g} mm) and lets hop: {named(sorted(margins))}",
            "Choose Convex Hull or Compound as their shape (Physics tab, Collisions)",
        )


def hanging_in_the_air(home: Examined) -> Iterator[Found]:
    """Reports pads that nothing is below and that are fixed to nothing."""
    for pad in home.requiring(FORCES):
        if pad.object.parent is not None or pad.object.rigid_body is not None:
            continue
        solids = home.home.caster.solids
        own = solids.owned_by(pad.uid)
        lo, hi = solids.lo[own], solids.hi[own]
        if not len(lo) or not np.isfinite(lo).all():
            continue
        middle = (lo.min(axis=0) + hi.max(axis=0)) / 2.0
        start = np.array([[middle[0], middle[1], hi[:, 2].max()]])
        length = np.array([float(hi[:, 2].max() - lo[:, 2].min()) + GAP / home.metres])
        down = np.array([[0.0, 0.0, -1.0]])
        met = home.home.caster.cast_met(pad.uid, BUNDLE, start, down, length)[1]
        if met[0] == NOTHING:
            yield (
                f"'{pad.name}' hangs in the air: nothing is within {GAP * 100:g} cm below it",
                "Lower it onto the floor (its faces may be missing or hidden), or parent it to "
                "what it is part of",
                (pad.name,),
            )


def caches(home: Examined) -> Iterator[Found]:
    """Reports a rigid-body cache that is too short, or older than the last edit."""
    if home.requiring(FORCES):
        yield from filter(None, (advice.short_cache(home.scene), advice.outdated_cache(home.scene)))
