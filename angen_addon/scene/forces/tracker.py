# SPDX-License-Identifier: GPL-3.0-or-later
"""Follow the contact bodies from frame to frame, and compute the contact forces on pads."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ....sensor_logic.forces.pad_forces import ABOVE, BESIDE, pad_forces
from ....sensor_logic.forces.world import PadForces
from ....sensor_logic.model import NOT_YET, Array
from ..capture import Frames
from ..instances import Uid
from ..rays.solids import Solids
from ..sensors import unit_scale
from .bodies import ContactBodies, Key, Pad, is_simulated, read_settings
from .frame_state import FrameState, gravity_of
from .frame_world import FrameWorld, KnownContacts
from .missing_mass import MissingMass
from .near_pads import NEARBY, states_near
from .posed_bodies import WorldTriangles
from .supports import THICKEST, Surroundings, find_supports

MOST_KNOWN_CONTACTS = 20_000
FRAMES_NEEDED = 3


class ContactTracker:
    """Computes the forces on pads at a frame, once the next frame has been read too.

    Accelerations depend on the next frame.

    Attributes
    ----------
    pads
        All pads.
    """

    def __init__(self, solids: Solids) -> None:
        self.pads: Sequence[Pad] = ()
        self._solids = solids
        self._surfaces = WorldTriangles(solids)
        self._bodies = ContactBodies()
        self._states: list[FrameState] = []
        self._newest: FrameState | None = None
        self._world: FrameWorld | None = None
        self._depsgraph: Any = None
        self._metres = 1.0
        self._cache_doubt = ""
        self._known_contacts: KnownContacts = {}

    def prepare(self, depsgraph: Any) -> None:
        """Make the colliders and triangles of all bodies now.

        Otherwise the first frame at which a body is near a pad would make them, and they would
        depend on that frame.
        """
        if not self.pads:
            return
        metres = unit_scale(depsgraph.scene)
        self._bodies.sync(depsgraph, self._solids, self.pads)
        for body in self._bodies.by_key.values():
            for solid in body.solids:
                solid.geometry.triangles(depsgraph)
                if body.pad:
                    scale = np.linalg.norm(self._solids.matrix[solid.row, :3, :3], axis=0)
                    body.collider(depsgraph, scale, metres)

    def look(self, depsgraph: Any, frame: int, due: Sequence[Uid]) -> None:
        """Read the bodies at a frame. The solids must be at this frame.

        What solids do not have of a body, such as the pose that physics gives it, is read from the
        scene: if it can change with the frame, a batch of captured frames is a single frame.

        Parameters
        ----------
        depsgraph
            The evaluated depsgraph.
        frame
            The number of the frame.
        due
            Identifiers of the pads whose forces at this frame will be queried. The query comes
            after the next `look`, because these forces also depend on the motion to the next frame.
        """
        if not self.pads:
            return
        metres = unit_scale(depsgraph.scene)
        last = self._newest if metres == self._metres else None
        if last is None or frame != last.frame + 1:
            self._states = []
        self._depsgraph, self._metres, self._world = depsgraph, metres, None
        edited = self._bodies.sync(depsgraph, self._solids, self.pads)
        if edited or len(self._known_contacts) > MOST_KNOWN_CONTACTS:
            self._known_contacts.clear()
        moves = any(b.rigid and is_simulated(b.original) for b in self._bodies.by_key.values())
        self._cache_doubt = _cache_problem(depsgraph.scene, frame) if moves else ""
        state = FrameState(frame, depsgraph, self._bodies, self._solids, metres, last)
        self._states = [*self._states[1 - FRAMES_NEEDED :], state]
        self._newest = state
        parts = self._solids, self._surfaces, self._bodies
        around = Surroundings(depsgraph, *parts, state.up, metres)
        reachable = {}
        for pad in due:
            reachable[pad] = _reachable(self._bodies.pads[pad], state, self._bodies, state.up)
            for key in reachable[pad]:
                original = self._bodies.by_key[key].original
                state.settings[key] = read_settings(original.evaluated_get(depsgraph), metres)
                if key in state.posed and key not in state.supports:
                    body, posed = self._bodies.by_key[key], state.posed[key]
                    state.supports[key] = find_supports(around, body, posed)
        missing_mass = MissingMass(around, state)
        for pad in due:
            key = self._bodies.pads[pad]
            state.missing_mass[key] = missing_mass.problem(key, reachable[pad])

    def furniture(self, pad: Uid) -> list[str]:
        """Return the names of the objects that `MissingMass.furniture` finds on a pad.

        Call this after `look`.
        """
        assert self._newest is not None
        parts = self._solids, self._surfaces, self._bodies
        around = Surroundings(self._depsgraph, *parts, self._newest.up, self._metres)
        return list(MissingMass(around, self._newest).furniture(self._bodies.pads[pad]))

    def states_near(
        self, pad: Uid, frames: Frames, scene: Any, metres: float
    ) -> list[bytes] | None:
        """Return a state for each frame; at frames with equal states, the pad feels the same.

        Return None if bounds cannot tell, or before the first `look` at the present list of solids.
        """
        key = self._bodies.pads.get(pad)
        if key is None or not self._bodies.is_current(self._solids):
            return None
        if not self._bodies.by_key[key].solids:
            return None
        up = gravity_of(scene, metres)[1]
        return states_near(key, self._bodies, self._solids, frames, up, metres)

    def forces(self, pad: Uid, frame: int) -> PadForces:
        """Return the forces on a pad at a frame that `look` has read.

        Call this once `look` has read the next frame too. If the frame before or after is unknown,
        bodies count as at rest.
        """
        key = self._bodies.pads.get(pad, ())
        at = next((i for i, state in enumerate(self._states) if state.frame == frame), None)
        if at is None or key not in self._states[at].row:
            return PadForces(problem="the pad has just appeared", usable=False)
        state = self._states[at]
        body = self._bodies.by_key[key]
        if not np.isfinite(state.lo[state.row[key]]).all():
            return PadForces(
                problem=f"the position of '{body.original.name}' is not a number "
                "(NaN): check its keyframes and drivers",
                usable=False,
            )
        scale = state.scales[state.row[key]]
        if body.collider(self._depsgraph, scale, self._metres).empty:
            return PadForces(problem=f"'{body.original.name}' has no surface", usable=False)
        known = 0 < at < len(self._states) - 1
        states = self._states[at - 1 : at + 2] if known else [state] * FRAMES_NEEDED
        if self._world is None or self._world.frame != frame:
            self._world = FrameWorld(
                self._depsgraph, self._bodies, states, self._metres, self._known_contacts
            )
        found = pad_forces(key, self._world)
        doubt = self._cache_doubt or state.missing_mass.get(key, "") or ("" if known else NOT_YET)
        return replace(found, problem=found.problem or doubt)


def _cache_problem(scene: Any, frame: int) -> str:
    """Return why the rigid-body cache may have wrong poses at a frame; "" if it has right ones."""
    world = scene.rigidbody_world
    cache = world.point_cache
    if frame < cache.frame_start:
        return f"the rigid-body cache starts at frame {cache.frame_start}"
    if cache.is_outdated:
        return "the rigid-body cache is out of date: play from its start"
    if frame > cache.frame_end:
        return f"the rigid-body cache ends at frame {cache.frame_end}"
    return ""


def _reachable(pad: Key, state: FrameState, bodies: ContactBodies, up: Array) -> set[Key]:
    """Return the keys of all bodies that may press on a pad, directly or through other bodies.

    These are bodies with a weight beside or above the pad, and all bodies that are connected with
    them by overlapping bounds.
    """
    seen, waiting = {pad}, [pad]
    near = state.overlapping(pad, BESIDE, up * ABOVE)
    while waiting:
        # What lies on a mattress may stand on the body below it.
        near += state.overlapping(waiting.pop(), NEARBY, up * THICKEST)
        for key in near:
            body = bodies.by_key[key]
            if key not in seen and (body.animated or body.pad or is_simulated(body.original)):
                seen.add(key)
                waiting.append(key)
        near = []
    return seen
