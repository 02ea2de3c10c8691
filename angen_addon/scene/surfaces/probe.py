# SPDX-License-Identifier: GPL-3.0-or-later
"""Base classes of probes, which read properties of the surfaces that rays hit."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, ClassVar

import numpy as np

from ....sensor_logic.model import Answers, Array, Index
from ..instances import Uid
from ..rays.caster import RayCaster, RayHits, Rays


class SurfaceProbe(ABC):
    """Reads properties of the surfaces that rays hit. Its constructor gets the scene's ray caster.

    Attributes
    ----------
    need
        The name of the query, which kinds have in their `needs`.
    reads_shading
        Whether the properties depend on the colours of materials.
    """

    need: ClassVar[str]
    reads_shading: ClassVar[bool] = False

    @staticmethod
    def changes_by_itself(scene: Any) -> bool:
        """Return whether the properties can change with the frame while nothing moves."""
        return False

    def __init__(self, caster: RayCaster) -> None:
        self._rays = caster
        # The caster of the latest call of `see`.
        self._casting = caster
        self._listing = -1

    def see(
        self,
        sensor: Uid,
        bundle: int,
        rays: Rays,
        frames: Index | None = None,
        *details: Any,
    ) -> Answers:
        """Cast a sensor's rays at some frames, and return the properties of the surfaces hit.

        Call it after the caster was updated. Lengths of rays are in Blender units.

        Parameters
        ----------
        sensor, bundle, rays
            As for `RayCaster.cast_at`.
        frames
            Indices (k,) of the frames of the caster; None for the last one.
        *details
            Further arguments of the query.

        Returns
        -------
        Answers
            The properties at each frame.
        """
        self._update()
        if frames is None:
            frames = np.array([len(self._rays.frames) - 1])
        return self._see(sensor, bundle, rays, frames, *details)

    @property
    def _depsgraph(self) -> Any:
        """The evaluated depsgraph at the last frame of the caster."""
        return self._rays.frames.depsgraph

    @property
    def hits(self) -> Answers:
        """The hits of the latest call of `see`, as read-only `RayHits` for each frame."""
        return self._casting.seen

    def ranges(self, sensor: Uid, bundle: int) -> Array:
        """Return the ranges (n,) in Blender units of the rays of the latest call of `see`."""
        return self._casting.last_ranges(sensor, bundle)

    @abstractmethod
    def _update(self) -> None:
        """Read the changes since the last call."""

    @abstractmethod
    def _see(self, sensor: Uid, bundle: int, rays: Rays, frames: Index, *details: Any) -> Answers:
        """Cast the rays, and return the properties at each frame; parameters as for `see`."""


class HitSurfaces(SurfaceProbe):
    """Reads one property of the first surface that each ray hits."""

    def _see(self, sensor: Uid, bundle: int, rays: Rays, frames: Index, *details: Any) -> Answers:
        found = self._rays.see_at(sensor, bundle, rays, frames)
        return Answers([self._values_at(seen) for seen in found.table], found.rows)

    @abstractmethod
    def _values_at(self, seen: RayHits) -> Any:
        """Return the property of the surfaces that the rays of `seen` hit."""
