# SPDX-License-Identifier: GPL-3.0-or-later
"""Noise: one generator for each sensor, so that no sensor's noise depends on another sensor."""

from __future__ import annotations

import zlib

import numpy as np


def generator(scene_seed: int, sensor: str, update: int) -> np.random.Generator:
    """The random numbers of one update of one sensor.

    Seeded by the update's number too: a run that starts later, or a jump of the playhead, draws
    the same noise at the same update as a run from the start.
    """
    key = zlib.crc32(sensor.encode())
    seed = np.random.SeedSequence([scene_seed & 0xFFFFFFFF, key, update])
    return np.random.Generator(np.random.PCG64(seed))
