# SPDX-License-Identifier: GPL-3.0-or-later
"""From surface temperatures to the power on the elements.

All powers are per square metre of lenslet and before its transmission: both apply equally to the
target that calibrates the threshold, and cancel. The elements are assumed to respond to all
wavelengths. Behind the usual window of 5 to 14 µm the power rises a little faster than with the
fourth power of the temperature; the calibration compensates for that near room temperature.
"""

from __future__ import annotations

import math

import numpy as np

from ....model import Array, Emission

# W/(m²·K⁴), CODATA 2018.
STEFAN_BOLTZMANN = 5.670374419e-8


def radiosity(seen: Emission) -> Array:
    """Radiosity (n,) in W/m² of the surfaces: their emission, and the reflection of surroundings at
    the ambient temperature."""
    own = seen.emissivity * seen.temperature**4
    reflected = (1.0 - seen.emissivity) * seen.ambient**4
    result: Array = STEFAN_BOLTZMANN * (own + reflected)
    return result


def net_power(weights: Array, seen: Emission) -> float:
    """Power on the elements in W per m² of lenslet, signed by their polarity, for rays with signed
    weights (n,) in sr. Surfaces are Lambertian: radiance is radiosity / π."""
    # The ambient part is subtracted first: it would only cost digits.
    excess = radiosity(seen) - STEFAN_BOLTZMANN * seen.ambient**4
    return float(weights @ excess) / math.pi + balance(weights, seen.ambient)


def balance(weights: Array, ambient: float) -> float:
    """The power in W per m² of lenslet of surroundings at one temperature (K): 0 where the
    polarities cancel."""
    return float(np.sum(weights)) * STEFAN_BOLTZMANN * ambient**4 / math.pi
