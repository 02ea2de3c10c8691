# SPDX-License-Identifier: GPL-3.0-or-later
"""Random numbers for the noise of sensors.

Each sensor has its own generator, so its numbers do not depend on other sensors.
"""

from __future__ import annotations

import zlib

import numpy as np


def generator(scene_seed: int, sensor: str, update: int) -> np.random.Generator:
    """Return the random generator for one update of one sensor.

    The seed includes the number of the update. So the noise of an update does not depend on the
    frame at which a run started.
    """
    key = zlib.crc32(sensor.encode())
    seed = np.random.SeedSequence([scene_seed & 0xFFFFFFFF, key, update])
    return np.random.Generator(np.random.PCG64(seed))
