# SPDX-License-Identifier: GPL-3.0-or-later
"""The bodies of the scene as they move: what the contact forces on pads are worked out from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ....sensor_logic.contact.pad_forces import ABOVE, BESIDE, pad_forces
from ....sensor_logic.contact.world import PadForces
from ....sensor_logic.model import NOT_YET
from ..instances import Uid
from ..rays.frames import Frames
from ..rays.solids import Solids
from .columns import Surfaces
from .cut_off import CutOff
from .facts import facts_of, is_simulated
from .frame_world import FrameWorld, Resting
from .moments import Moment, gravity_of
from .near_pads import NEARBY, states_near
from .standing import Surroundings, standing
from .things import Key, Pad, Things

Array = np.typing.NDArray[np.float64]
MOST_RESTING = 20_000
FRAMES_NEEDED = 3


class Bodies:
    """Follows the scene a frame at a time; knows the forces at the frame before the newest."""

    def __init__(self, solids: Solids) -> None:
        self._solids = solids
        self._surfaces = Surfaces(solids)
        self._things = Things()
        self._moments: list[Moment] = []
        self._newest: Moment | None = None
        self._world: FrameWorld | None = None
        self._depsgraph: Any = None
        self._metres = 1.0
        self._stale = ""
        self._resting: Resting = {}

    def prepare(self, depsgraph: Any, metres: float, pads: Sequence[Pad]) -> None:
        """Makes what must not depend on the frame at which it is asked for first."""
        self._things.sync(depsgraph, self._solids, pads)
        for thing in self._things.by_key.values():
            for solid in thing.surfaces:
                solid.geometry.triangles(depsgraph)
                if thing.pad:
                    scale = np.linalg.norm(self._solids.matrix[solid.row, :3, :3], axis=0)
                    thing.collider(depsgraph, scale, metres)

    def states_near(
        self, pad: Uid, frames: Frames, scene: Any, metres: float
    ) -> list[bytes] | None:
        """What tells apart, at each of some frames (k,), all that a pad can feel; None where bounds
        do not tell."""
        key = self._things.pads.get(pad)
        if key is None or not self._things.by_key[key].surfaces:
            return None
        up = gravity_of(scene, metres)[1]
        return states_near(key, self._things, self._solids, frames, up, metres)

    def look(
        self, depsgraph: Any, frame: int, metres: float, pads: Sequence[Pad], due: Sequence[Uid]
    ) -> None:
        """Takes down the scene at a frame, after the solids were synced. `pads` are all
        pads, `due` tells those whose forces at this frame will be asked for after the next."""
        last = self._newest if metres == self._metres else None
        if last is None or frame != last.frame + 1:
            self._moments = []
        self._depsgraph, self._metres, self._world = depsgraph, metres, None
        if self._things.sync(depsgraph, self._solids, pads) or len(self._resting) > MOST_RESTING:
            self._resting.clear()
        moves = any(t.rigid and is_simulated(t.original) for t in self._things.by_key.values())
        self._stale = _stale(depsgraph.scene, frame) if moves else ""
        moment = Moment(frame, depsgraph, self._things, self._solids, metres, last)
        self._moments = [*self._moments[1 - FRAMES_NEEDED :], moment]
        self._newest = moment
        parts = self._solids, self._surfaces, self._things
        around = Surroundings(depsgraph, *parts, moment.up, metres)
        for pad in due:
            for key in _reachable(self._things.pads[pad], moment, self._things, moment.up):
                original = self._things.by_key[key].original
                moment.facts[key] = facts_of(original.evaluated_get(depsgraph))
                if key in moment.bodies and key not in moment.standing:
                    thing, body = self._things.by_key[key], moment.bodies[key]
                    moment.standing[key] = standing(around, thing, body)
        cut_off = CutOff(around, moment)
        for key in (self._things.pads[pad] for pad in due):
            moment.cut_off[key] = cut_off.problem(key)

    def forces(self, pad: Uid, frame: int) -> PadForces:
        """The forces on a pad at a frame that was looked at; to be asked for once the next frame
        was looked at too. Where the frames beside it are not known, they are those at rest."""
        key = self._things.pads.get(pad, ())
        at = next((i for i, moment in enumerate(self._moments) if moment.frame == frame), None)
        if at is None or key not in self._moments[at].row:
            return PadForces(problem="the pad has just appeared", usable=False)
        moment = self._moments[at]
        thing = self._things.by_key[key]
        if not np.isfinite(moment.lo[moment.row[key]]).all():
            return PadForces(problem=f"'{thing.original.name}' has no place (NaN)", usable=False)
        scale = moment.scales[moment.row[key]]
        if thing.collider(self._depsgraph, scale, self._metres).empty:
            return PadForces(problem=f"'{thing.original.name}' has no surface", usable=False)
        known = 0 < at < len(self._moments) - 1
        moments = self._moments[at - 1 : at + 2] if known else [moment] * FRAMES_NEEDED
        if self._world is None or self._world.frame != frame:
            self._world = FrameWorld(
                self._depsgraph, self._things, moments, self._metres, self._resting
            )
        found = pad_forces(key, self._world)
        doubt = self._stale or moment.cut_off.get(key, "") or ("" if known else NOT_YET)
        return replace(found, problem=found.problem or doubt)


def _stale(scene: Any, frame: int) -> str:
    """Why the simulated poses at a frame are not to be trusted; empty where they are."""
    world = scene.rigidbody_world
    cache = world.point_cache
    if frame < cache.frame_start:
        return f"the rigid-body cache starts at frame {cache.frame_start}"
    if cache.is_outdated:
        return "the rigid-body cache is out of date: play from its start"
    if frame > cache.frame_end:
        return f"the rigid-body cache ends at frame {cache.frame_end}"
    return ""


def _reachable(pad: Key, moment: Moment, things: Things, up: Array) -> set[Key]:
    """Everything with a weight beside and above the pad, and in a chain of overlapping bounds from
    there: no less than its contact island."""
    seen, waiting = {pad}, [pad]
    near = moment.overlapping(pad, BESIDE, up * ABOVE)
    while waiting:
        near += moment.overlapping(waiting.pop(), NEARBY)
        for key in near:
            thing = things.by_key[key]
            if key not in seen and (thing.carried or thing.pad or is_simulated(thing.original)):
                seen.add(key)
                waiting.append(key)
        near = []
    return seen
