# SPDX-License-Identifier: GPL-3.0-or-later
"""Type names for numpy arrays, and their comparison.

An `Array` has floats, an `Index` has integer indices.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.intp]


def are_equal(some: Sequence[Any], others: Sequence[Any]) -> bool:
    """Return whether two sequences hold equal arrays or numbers in the same order."""
    # Most arrays that stay from update to update are the same object.
    return len(some) == len(others) and all(
        one is other or np.array_equal(one, other) for one, other in zip(some, others, strict=True)
    )
