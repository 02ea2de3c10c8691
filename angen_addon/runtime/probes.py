# SPDX-License-Identifier: GPL-3.0-or-later
"""The probes, which read rays, surfaces, forces and light from the scene for the sensors."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from ...sensor_logic.forces.world import PadForces
from ...sensor_logic.model import Answers, LightSample
from ..scene.capture import Frames
from ..scene.forces.bodies import Pad
from ..scene.forces.tracker import ContactTracker
from ..scene.instances import Uid
from ..scene.light.changes import LightChanges
from ..scene.light.cycles import CyclesLight, Steps, request_key
from ..scene.light.probe import LightRequest, measuring
from ..scene.rays.caster import RayCaster, Rays
from ..scene.rays.places import PlaceReader
from ..scene.rays.reference import SceneRayCaster
from ..scene.rays.sweep import Sweeper
from ..scene.sensors import Sensor, unit_scale
from ..scene.surfaces import SURFACES
from .edits import EDITS


def make_caster(scene: Any) -> RayCaster | SceneRayCaster:
    """Return a new ray caster, of the type that the scene's settings name.

    From now on, changes of the scene are reported to its list of solids (objects that rays can
    hit).
    """
    caster = SceneRayCaster(scene) if scene.angen_ray_caster == "SCENE" else RayCaster()
    EDITS.watch(caster.solids)
    return caster


NOT_MEASURED = (None, LightSample())


class Probes:
    """The ray caster and all other probes that read one scene for its sensors.

    Attributes
    ----------
    caster
        The ray caster; by default a new one of the sort that the scene's settings name.
    capture
        Reads the frames of the scene at which the ray caster casts.
    surfaces
        The probes for the properties of the surfaces that rays hit, by the names of the queries.
    sweeper
        Computes what crosses a beam between two steps.
    places
        Reads the places of solids (objects that rays can hit) at captured frames.
    names
        The names of solids (objects that rays can hit) by their numbers. It also has removed
        solids.
    frames
        The batch of frames that the probes read: see `look` and `show_captured`.
    """

    def __init__(self, scene: Any, caster: RayCaster | None = None) -> None:
        self.caster = used = caster or make_caster(scene)
        # Blender's own ray cast, the reference for ranges, returns no surfaces.
        self._exact = used if isinstance(used, RayCaster) else RayCaster(used.solids)
        self.surfaces = {need: probe(self._exact) for need, probe in SURFACES.items()}
        self.sweeper = Sweeper(self.caster)
        self.places = PlaceReader(self._exact)
        self._solids = self.caster.solids
        self._contacts = ContactTracker(self._solids)
        self.names: dict[int, str] = {}
        self._named_listing = -1
        self.capture = self.caster.capture
        self.frames = self.caster.frames
        # By the sensor's name: the request with the state of the scene, and the measured light.
        self._measured: dict[str, tuple[Any, LightSample]] = {}
        self._lighting = LightChanges()
        self._light = CyclesLight()
        EDITS.watch(self._lighting)

    def set_sensors(self, sensors: Iterable[Sensor]) -> None:
        """Set the sensors; the probes prepare only data that these sensors need."""
        found = list(sensors)
        self._contacts.pads = [Pad(s.uid, s.object) for s in found if s.kind.requires_forces]
        self.capture.watch_uses(found)

    def look(self, depsgraph: Any, step: int = 0) -> None:
        """Read the present frame of the evaluated scene, as a batch of this frame alone.

        `step` is the step of the frame.
        """
        self._show(self.capture.read(depsgraph, step))

    def expect_light(self, is_asked: bool) -> None:
        """Set whether light will be measured (`is_asked`) at the frame that is evaluated next."""
        self._lighting.is_asked = is_asked

    def look_at_motion(self, frame: int, due: Sequence[Sensor], index: int = -1) -> None:
        """Read how objects move at the whole frame `frame`.

        `due` lists the pads that publish at this frame, so that their forces at it will be needed.
        `index` is the frame's index in the batch, by default that of the last one.
        """
        self.show(index)
        self._contacts.look(self.frames.depsgraph, frame, [pad.uid for pad in due])

    def states_near(self, pad: Uid, scene: Any) -> list[bytes] | None:
        """Return a state for each frame of the batch, or None if bounds cannot tell.

        The forces on a pad are the same at frames with equal states, if weights do not change.
        """
        return self._contacts.states_near(pad, self.frames, scene, unit_scale(scene))

    def show(self, index: int) -> None:
        """Set the poses of all solids (objects that rays can hit) to those at a captured frame."""
        if len(self.frames) > 1:
            self.frames.show(self._solids, index)

    def prepare_pads(self, depsgraph: Any) -> None:
        """Make what the forces on pads need of all bodies, so that it depends on no later frame."""
        self._contacts.prepare(depsgraph)

    def show_captured(self, depsgraph: Any) -> None:
        """Use the frames captured since the last call from now on.

        `depsgraph` is the evaluated depsgraph of the scene, at the last of these frames.
        """
        self._show(self.capture.finish(depsgraph))

    def _show(self, frames: Frames) -> None:
        self.frames = frames
        self.caster.show(frames)
        if self._exact is not self.caster:
            self._exact.show(frames)

    def hits(self, need: str, sensor: Uid, bundle: int, rays: Rays, count: int) -> Answers:
        """Return the hits of the rays that the last query `need` cast, as read-only `RayHits`.

        There is one answer for each of the `count` updates that the query was for.
        """
        if self._named_listing != self._solids.listing:
            self._named_listing = self._solids.listing
            self.names |= {solid.number: solid.name for solid in self._solids.solids}
        if need in self.surfaces:
            return self.surfaces[need].hits
        if self._exact is self.caster:
            return self._exact.seen
        last = np.full(count, len(self.frames) - 1)
        return self._exact.see_at(sensor, bundle, rays, last)

    def measure(
        self,
        scene: Any,
        view_layer: Any,
        depsgraph: Any,
        requests: list[LightRequest],
        keep: bool = False,
    ) -> Steps[dict[str, LightSample]]:
        """Measure the requested light, but render only for sensors whose light can have changed.

        Light is in no captured frame: Blender renders it from the whole scene, which must be at the
        frame. Do not call this method in a frame handler.

        Parameters
        ----------
        scene, view_layer, depsgraph
            The scene, its view layer and the evaluated depsgraph of that view layer.
        requests
            The requests of the light sensors.
        keep
            Whether to keep the temporary scene for light until the next call of `measure`. This is
            allowed if only the frame changes between the two calls. Call `close` at the end.

        Yields
        ------
        A text before each picture that takes long to render.

        Returns
        -------
        The measured light by the sensor's name.

        Raises
        ------
        AngenError
            If the light cannot be rendered.
        """
        settings = scene.angen_luminous_efficacy, scene.angen_light_reference
        state = self._lighting.look(view_layer, depsgraph, self.capture.edits, settings)
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
        """Use the light references of an earlier run of the same scene.

        These are pictures with many light paths, by which noisy readings are corrected. References
        that are computed later are added to the same dictionary.
        """
        self._light.recall(references)

    @property
    def reference_done(self) -> float:
        """The part of the light references that is computed so far, from 0 to 1."""
        return self._light.reference_done

    def close(self) -> None:
        """Remove the temporary data of the light probe from the file."""
        self._light.close()

    def forces(self, pad: Uid, frame: int) -> PadForces:
        """Return the contact forces on a pad at the whole frame `frame`.

        First call `look_at_motion` at the frame after that, since the forces depend on the motion
        to it.
        """
        return self._contacts.forces(pad, frame)
