# SPDX-License-Identifier: GPL-3.0-or-later
"""What reads the scene for the sensors: one of each probe, and only those that they need."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from ...sensor_logic.forces.world import PadForces
from ...sensor_logic.model import Answers, LightSample
from ..scene.changes import LightChanges
from ..scene.forces.bodies import Pad
from ..scene.forces.tracker import ContactTracker
from ..scene.instances import Uid
from ..scene.light.cycles import CyclesLight, Steps, request_key
from ..scene.light.probe import LightRequest, measuring
from ..scene.rays.caster import RayCaster, Rays
from ..scene.rays.frames import FrameCopies
from ..scene.rays.reference import SceneRayCaster
from ..scene.rays.sweep import Sweeper
from ..scene.sensors import Sensor, unit_scale
from ..scene.surfaces import Reflectance, Warmth
from . import state


def make_caster(scene: Any) -> RayCaster | SceneRayCaster:
    """The ray caster that the scene chose, told of every change from now on."""
    caster = SceneRayCaster(scene) if scene.angen_ray_caster == "SCENE" else RayCaster()
    state.CACHE.watch(caster.solids)
    return caster


NOT_MEASURED = (None, LightSample())


class Probes:
    """The probes for the sensors of a scene, which cast with `caster`, if given. `names`: of the
    solids that `met` knows, by number; also of those that are gone."""

    def __init__(self, scene: Any, caster: RayCaster | None = None) -> None:
        self.caster = caster or make_caster(scene)
        # Blender's own ray cast, the reference for ranges, tells nothing of what was met.
        own = self.caster
        self._exact = own if isinstance(own, RayCaster) else RayCaster(own.solids)
        self.warmth = Warmth(self._exact)
        self.reflectance = Reflectance(self._exact)
        self.sweeper = Sweeper(self.caster)
        self._solids = self.caster.solids
        self._contacts = ContactTracker(self._solids)
        self._pads: list[Pad] = []
        self._told = 0
        self.names: dict[int, str] = {}
        self._named = -1
        # Of the pad that is asked about, by whole frames.
        self.known_forces: dict[int, PadForces] = {}
        # The number of the frame that is looked at alone.
        self.frame = 0
        self._copies: FrameCopies | None = None
        # By the sensor's name, what was asked in which state of the scene, and what was found.
        self._measured: dict[str, tuple[Any, LightSample]] = {}
        self._lighting = LightChanges()
        self._light = CyclesLight()
        state.CACHE.watch(self._lighting)

    def serve(self, sensors: Iterable[Sensor]) -> None:
        """From now on the probes look at what these sensors need."""
        self._pads = [Pad(s.uid, s.object) for s in sensors if s.kind.requires_forces]

    @property
    def edits(self) -> int:
        """How often more than the frame may have changed."""
        return self._solids.edits + self._told

    def note_edits(self) -> None:
        """Others had their turn, and may have changed what Blender tells of at the next evaluation
        only."""
        self._told += 1

    def look(self, depsgraph: Any, frame: int | None, due: Sequence[Sensor] = ()) -> None:
        """Brings the probes to the scene as it is now evaluated.

        `frame`: the whole frame that this is, or None where its motion is not needed; `due`: pads
        whose forces at this frame will be asked for.
        """
        self._update(depsgraph)
        if frame is not None:
            self.look_at_motion(depsgraph, frame, due)

    def expect_light(self, is_asked: bool) -> None:
        """Whether light is measured at the frame that comes."""
        self._lighting.is_asked = is_asked

    def look_at_motion(self, depsgraph: Any, frame: int, due: Sequence[Sensor] = ()) -> None:
        """The motion alone, of the solids as they are in the list."""
        if self._pads:
            metres = unit_scale(depsgraph.scene)
            self._contacts.look(depsgraph, frame, metres, self._pads, [pad.uid for pad in due])

    def show(self, frame: int) -> None:
        """Brings the list of solids to one of the frames that are kept, of which it is at the
        last."""
        if len(self.caster.frames) > 1:
            self.caster.frames.show(self._solids, frame)

    @property
    def full(self) -> bool:
        """Whether the frames that are kept are to be sensed now."""
        return self._copies is None or self._copies.full

    @property
    def follows(self) -> bool:
        """Whether the frames to come are those of solids that are listed."""
        return self._copies is not None and not self.must_list

    @property
    def must_list(self) -> bool:
        """Whether things may have come or gone since they were listed."""
        return self._solids.must_list

    def keep(self, watched: Any) -> bool:
        """As `look`, but a frame is only taken down, until `develop`. `watched` is the depsgraph of
        the scene or of what moves in it, which tells the frames. False where things may have come
        or gone: then `keep_first` makes the list anew."""
        return self._copies is not None and self._copies.add(watched)

    def keep_first(self, depsgraph: Any, watched: Any) -> None:
        """Takes down the first frame after all before were sensed, with a new list of solids.
        `depsgraph` is that of the whole scene at this frame."""
        solids = self._solids
        # What is listed anew is sensed alone: instances may be gone at the next frame.
        is_current = solids.is_current(depsgraph) and not isinstance(self.caster, SceneRayCaster)
        self._update(depsgraph)
        self._copies = FrameCopies(solids, watched) if is_current else None
        if self._pads:
            self._contacts.prepare(depsgraph, unit_scale(depsgraph.scene), self._pads)
        if self._copies is not None and not self._copies.add(watched):
            self._copies = None
            solids.forget()
            self._update(depsgraph)

    def _update(self, depsgraph: Any) -> None:
        """Bring the casters to the scene as it is now evaluated."""
        self.caster.update(depsgraph)
        if self._exact is not self.caster:
            self._exact.update(depsgraph)

    def develop(self, depsgraph: Any) -> None:
        """From now on what is asked is answered at the frames that were taken down."""
        if self._copies is not None and len(self._copies):
            self.caster.show(depsgraph, self._copies.finish())

    def met(self, depsgraph: Any, sensor: Uid, bundle: int, rays: Rays, count: int) -> Answers:
        """What the rays met that were cast just now at `count` updates: `RayHits`, which nobody may
        write to."""
        if self._named != self._solids.listing:
            self._named = self._solids.listing
            self.names |= {solid.number: solid.name for solid in self._solids.solids}
        if self._exact is self.caster:
            return self._exact.seen
        last = np.full(count, len(self._exact.frames) - 1)
        return self._exact.see_at(sensor, bundle, rays, last)

    def measure(
        self,
        scene: Any,
        view_layer: Any,
        depsgraph: Any,
        asked: list[LightRequest],
        keep: bool = False,
    ) -> Steps[dict[str, LightSample]]:
        """Renders the light that is asked for, where it can have changed since it was last, and
        returns it by the sensor's name. Yields before each picture, in words what takes long.

        `keep`: nothing but frames will change until the next time; to be ended by `close`.
        Not in a frame handler. Raises AngenError.
        """
        how = scene.angen_luminous_efficacy, scene.angen_light_reference
        state = self._lighting.look(view_layer, depsgraph, self.edits, how)
        keys = {r.name: (state.light, request_key(r)) for r in asked}
        due = [r for r in asked if self._measured.get(r.name, NOT_MEASURED)[0] != keys[r.name]]
        if due:
            efficacy, self._light.reference = how
            kept = self._light if keep else None
            found = yield from measuring(scene, view_layer, due, efficacy, kept, state)
            self._measured |= {r.name: (keys[r.name], found[r.name]) for r in due}
        return {r.name: self._measured[r.name][1] for r in asked}

    def recall_light(self, references: dict[Any, Any]) -> None:
        """Begin with the references of an earlier run of the same scene, and add to them."""
        self._light.recall(references)

    @property
    def reference_done(self) -> float:
        """The share of the light's reference that is traced."""
        return self._light.reference_done

    def close(self) -> None:
        """Removes from the file what was kept there."""
        self._light.close()

    def forces(self, pad: Uid, frame: int) -> PadForces:
        """The contact forces on a pad at a whole frame, after the next one was looked at."""
        return self.known_forces.get(frame) or self._contacts.forces(pad, frame)
