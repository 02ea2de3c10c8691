# SPDX-License-Identifier: GPL-3.0-or-later
"""Type names for numpy arrays: an `Array` has floats, an `Index` has integer indices."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.intp]
