# SPDX-License-Identifier: GPL-3.0-or-later
"""Random numbers for the noise of sensors.

Each sensor has its own generator. What other sensors draw does not change its numbers.
"""

from __future__ import annotations

import zlib

import numpy as np


def generator(scene_seed: int, sensor: str, update: int) -> np.random.Generator:
    """Return the random generator for one update of one sensor.

    The number of the update is a part of the seed. So an update has the same noise whether a run
    started before it, or the playhead jumped to it.
    """
    key = zlib.crc32(sensor.encode())
    seed = np.random.SeedSequence([scene_seed & 0xFFFFFFFF, key, update])
    return np.random.Generator(np.random.PCG64(seed))
