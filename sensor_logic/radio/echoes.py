# SPDX-License-Identifier: GPL-3.0-or-later
"""The query of radars to the scene: what their rays hit, how it moves, and what they passed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..model import Array

# The query (bundle, origins, directions, length, frequency, integration_time): the `Echoes` of the
# rays. The first four arguments are those of RAYS, `frequency` is the carrier frequency in GHz, and
# `integration_time` the time in s before the update over which speeds are sampled.
ECHOES = "echoes"


@dataclass(frozen=True)
class Echoes:
    """What n rays of a radar hit. Metres, seconds and hertz.

    Attributes
    ----------
    ranges
        The distance (n,) in m to the nearest surface that stops the waves. A ray without one has
        its `length`.
    speed
        The radial speed (m, n) in m/s of the material point at the hit, in each of m ≥ 1 parts of
        the integration time, the earliest first: positive if it moves away. A part is the time
        between two steps of the scene. If the integration time is shorter than a step, the only
        part is the step before the update. Where nothing moved, there is one part of zeros; so at
        the first update, and after a jump of the playhead. Zeros without a hit.
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
    speed: Array
    breathing: Array
    rate: Array
    loss: Array
    reflectance: Array
    solid: NDArray[np.intp]
    through: Mapping[int, tuple[str, ...]] = field(default_factory=dict)
