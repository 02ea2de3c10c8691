# SPDX-License-Identifier: GPL-3.0-or-later
"""Poses and boxes for tests of contact and of plans."""

import numpy as np
from angen_sensors.sensor_logic.forces.shapes import rotation_about

# A box's sides, as indices of `CORNERS`, and their triangles, outwards.
CORNERS = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
QUADS = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
TRIANGLES = np.array([t for a, b, c, d in QUADS for t in ((a, b, c), (a, c, d))])


def at(x=0.0, y=0.0, z=0.0, axis=(0, 0, 1), angle=0.0, scale=1.0):
    """Return the matrix of a turn about an axis, then a move to a place."""
    matrix = np.eye(4)
    axis = np.array(axis, float)
    matrix[:3, :3] = rotation_about(axis / np.linalg.norm(axis), angle) * scale
    matrix[:3, 3] = x, y, z
    return matrix
