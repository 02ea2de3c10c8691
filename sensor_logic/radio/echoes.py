# SPDX-License-Identifier: GPL-3.0-or-later
"""The query of radars to the scene: what their rays hit, how it moves, and what they passed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..model import Array

# The query (bundle, origins, directions, length, frequency): the `Echoes` of the rays; the first
# four arguments are those of RAYS, `frequency` is the carrier frequency in GHz.
ECHOES = "echoes"


@dataclass(frozen=True)
class Echoes:
    """What n rays of a radar hit. Metres, seconds and hertz.

    Attributes
    ----------
    ranges
        The distance (n,) in m to the nearest surface that stops the waves. A ray without one has
        its `length`.
    moved
        How far (n,) in m the material point at the hit moved along the ray since the previous query
        of this bundle: positive if it moved away. 0 at the first query, and without a hit.
    breathing
        The peak-to-peak displacement (n,) in m of the chest of the body that the ray hits. 0 if it
        hits anything else.
    rate
        The breathing rate (n,) in Hz of that body; 0 if the ray hits anything else.
    loss
        The one-way attenuation (n,) in dB by everything that the ray passed before its hit, at the
        carrier frequency.
    reflectance
        The share (n,) of the power that the surface at the hit reflects at normal incidence, at the
        carrier frequency; 0 without a hit.
    solid
        A number (n,) that identifies the object at the hit; 0 without a hit.
    through
        The names of the objects that a ray passed before its hit, by the index of the ray. Rays
        that passed none are left out.
    """

    ranges: Array
    moved: Array
    breathing: Array
    rate: Array
    loss: Array
    reflectance: Array
    solid: NDArray[np.intp]
    through: Mapping[int, tuple[str, ...]] = field(default_factory=dict)
