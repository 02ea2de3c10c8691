# SPDX-License-Identifier: GPL-3.0-or-later
"""The probes, which read the scene for the sensors: rays, surfaces, forces and light."""

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
    """Return the ray caster of the scene's settings, notified of changes from now on."""
    caster = SceneRayCaster(scene) if scene.angen_ray_caster == "SCENE" else RayCaster()
    state.CACHE.watch(caster.solids)
    return caster


NOT_MEASURED = (None, LightSample())


class Probes:
    """The probes for the sensors of a scene.

    They cast rays with `caster`, by default the one of the scene's settings. `names` has the names
    of solids by their numbers, also of solids that are gone.
    """

    def __init__(self, scene: Any, caster: RayCaster | None = None) -> None:
        self.caster = used = caster or make_caster(scene)
        # Blender's own ray cast, the reference for ranges, returns no surfaces.
        self._exact = used if isinstance(used, RayCaster) else RayCaster(used.solids)
        self.warmth = Warmth(self._exact)
        self.reflectance = Reflectance(self._exact)
        self.sweeper = Sweeper(self.caster)
        self._solids = self.caster.solids
        self._contacts = ContactTracker(self._solids)
        self._pads: list[Pad] = []
        self._edits = 0
        self.names: dict[int, str] = {}
        self._named_listing = -1
        # Forces of the pad that senses now, by whole frames.
        self.known_forces: dict[int, PadForces] = {}
        # The index of a single frame among the stored frames.
        self.frame = 0
        self._copies: FrameCopies | None = None
        # By the sensor's name: the request with the state of the scene, and the measured light.
        self._measured: dict[str, tuple[Any, LightSample]] = {}
        self._lighting = LightChanges()
        self._light = CyclesLight()
        state.CACHE.watch(self._lighting)

    def set_sensors(self, sensors: Iterable[Sensor]) -> None:
        """Set the sensors; the probes prepare only what these sensors need."""
        self._pads = [Pad(s.uid, s.object) for s in sensors if s.kind.requires_forces]

    @property
    def edits(self) -> int:
        """The number of changes so far that may be more than a change of frame."""
        return self._solids.edits + self._edits

    def note_edits(self) -> None:
        """Count a possible edit, because code outside of the run could change the scene.

        Blender reports such an edit only at the next evaluation.
        """
        self._edits += 1

    def look(self, depsgraph: Any, frame: int | None, due: Sequence[Sensor] = ()) -> None:
        """Update the probes to the evaluated scene.

        `frame` is the present whole frame, or None if the motion is not needed. `due` lists the
        pads whose forces at this frame will be queried.
        """
        self._update(depsgraph)
        if frame is not None:
            self.look_at_motion(depsgraph, frame, due)

    def expect_light(self, is_asked: bool) -> None:
        """Set whether light is measured at the next frame."""
        self._lighting.is_asked = is_asked

    def look_at_motion(self, depsgraph: Any, frame: int, due: Sequence[Sensor] = ()) -> None:
        """Read the motion of the listed solids alone."""
        if self._pads:
            metres = unit_scale(depsgraph.scene)
            self._contacts.look(depsgraph, frame, metres, self._pads, [pad.uid for pad in due])

    def show(self, frame: int) -> None:
        """Bring the listed solids to a stored frame."""
        if len(self.caster.frames) > 1:
            self.caster.frames.show(self._solids, frame)

    @property
    def is_full(self) -> bool:
        """Whether the memory for stored frames is full, so that they must be sensed now."""
        return self._copies is None or self._copies.full

    @property
    def can_store_next(self) -> bool:
        """Whether the next frame can be stored with the present list of solids."""
        return self._copies is not None and not self.must_list

    @property
    def must_list(self) -> bool:
        """Whether objects may have come or gone since the solids were listed."""
        return self._solids.must_list

    def store_frame(self, watched: Any) -> bool:
        """Store a frame for later queries; return False if objects may have come or gone.

        Call `store_first_frame` then, to list the solids anew. `watched` is the depsgraph of the
        scene, or of its moving objects, from which the poses are stored.
        """
        return self._copies is not None and self._copies.add(watched)

    def store_first_frame(self, depsgraph: Any, watched: Any) -> None:
        """Store the first frame of a batch, with a new list of solids.

        `depsgraph` is that of the whole scene at this frame, `watched` the one of later frames.
        """
        solids = self._solids
        # A frame with a new list is sensed alone: instances may be gone at the next frame.
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
        """Update the casters to the evaluated scene."""
        self.caster.update(depsgraph)
        if self._exact is not self.caster:
            self._exact.update(depsgraph)

    def query_stored_frames(self, depsgraph: Any) -> None:
        """Make the stored frames the ones that the next queries are about."""
        if self._copies is not None and len(self._copies):
            self.caster.show(depsgraph, self._copies.finish())

    def hits(self, depsgraph: Any, sensor: Uid, bundle: int, rays: Rays, count: int) -> Answers:
        """Return the hits of the last cast at `count` updates, as read-only `RayHits`."""
        if self._named_listing != self._solids.listing:
            self._named_listing = self._solids.listing
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
        requests: list[LightRequest],
        keep: bool = False,
    ) -> Steps[dict[str, LightSample]]:
        """Measure the requested light; render only where it can have changed.

        Do not call this method in a frame handler.

        Parameters
        ----------
        requests
            The requests of the light sensors.
        keep
            Whether nothing but the frame changes until the next call, so that the light scene can
            be kept; call `close` at the end.

        Yields
        ------
        A text before each picture that takes long.

        Returns
        -------
        The measured light by the sensor's name.

        Raises
        ------
        AngenError
            If the light cannot be rendered.
        """
        settings = scene.angen_luminous_efficacy, scene.angen_light_reference
        state = self._lighting.look(view_layer, depsgraph, self.edits, settings)
        keys = {r.name: (state.light, request_key(r)) for r in requests}
        changed = [
            r for r in requests if self._measured.get(r.name, NOT_MEASURED)[0] != keys[r.name]
        ]
        if changed:
            efficacy, self._light.reference = settings
            kept = self._light if keep else None
            found = yield from measuring(scene, view_layer, changed, efficacy, kept, state)
            self._measured |= {r.name: (keys[r.name], found[r.name]) for r in changed}
        return {r.name: self._measured[r.name][1] for r in requests}

    def recall_light(self, references: dict[Any, Any]) -> None:
        """Begin with the light references of an earlier run of the same scene, and add to them."""
        self._light.recall(references)

    @property
    def reference_done(self) -> float:
        """The share of the light reference that is traced, 0 to 1."""
        return self._light.reference_done

    def close(self) -> None:
        """Remove the temporary data of the light probe from the file."""
        self._light.close()

    def forces(self, pad: Uid, frame: int) -> PadForces:
        """Return the contact forces on a pad at a whole frame, after `look` at the next one."""
        return self.known_forces.get(frame) or self._contacts.forces(pad, frame)
