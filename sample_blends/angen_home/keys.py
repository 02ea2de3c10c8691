# SPDX-License-Identifier: GPL-3.0-or-later
"""Plain keyframes out of one value a frame, with as few keys as the tolerance allows."""

import numpy as np
from angen_sensors.residents.blender.keys import Curves


def needed(values: np.ndarray, tolerance: float) -> list[int]:
    """Indices to key, so that straight lines between them miss no value by more than that."""
    keep = {0, len(values) - 1}
    open_spans = [(0, len(values) - 1)]
    while open_spans:
        a, b = open_spans.pop()
        if b - a < 2:
            continue
        line = np.linspace(values[a], values[b], b - a + 1)
        miss = np.abs(values[a : b + 1] - line)
        worst = int(miss.argmax())
        if miss[worst] > tolerance:
            keep.add(a + worst)
            open_spans += [(a, a + worst), (a + worst, b)]
    kept = sorted(keep)
    if len(kept) == 2 and abs(values[kept[1]] - values[kept[0]]) <= tolerance:
        kept = kept[:1]
    return kept


def at_rest(values: np.ndarray, tolerance: float) -> np.ndarray:
    """The values of keys without creep: what differs by no more than that from the key before
    stands still."""
    found = values.copy()
    for number in range(1, len(found)):
        if abs(values[number] - found[number - 1]) <= tolerance:
            found[number] = found[number - 1]
    return found


def bake(curves: Curves, path: str, index: int, values: np.ndarray, tolerance: float) -> None:
    """Keys for one value a frame, the first at frame 1."""
    kept = needed(values, tolerance)
    curves.write(path, index, np.array(kept) + 1, at_rest(values[kept], tolerance))
