# SPDX-License-Identifier: GPL-3.0-or-later
"""From temperatures to the power on the elements.

All powers are per square metre of lenslet and before its transmission: both are the same for the
target with which the threshold is calibrated, and cancel. The elements are taken to feel all
wavelengths; behind the usual window of 5 to 14 µm the power rises a little faster with the
temperature than with its fourth power, which again the calibration takes up near room
temperature.
"""

from __future__ import annotations

import math

import numpy as np

from ....model import Array, Emission

# W/(m²·K⁴), CODATA 2018.
STEFAN_BOLTZMANN = 5.670374419e-8


def leaving(seen: Emission) -> Array:
    """W/m² (n,) that leaves the surfaces seen: what they emit, and what they reflect of
    surroundings at the ambient temperature."""
    own = seen.emissivity * seen.temperature**4
    reflected = (1.0 - seen.emissivity) * seen.ambient**4
    result: Array = STEFAN_BOLTZMANN * (own + reflected)
    return result


def net_power(weights: Array, seen: Emission) -> float:
    """W per m² of lenslet on the elements, signed by their polarity, for rays with signed weights
    (n,) in sr. Surfaces send equally in all directions: radiance is a π-th of what leaves."""
    # Against the ambient: what all zones see alike would cost digits and nothing more.
    excess = leaving(seen) - STEFAN_BOLTZMANN * seen.ambient**4
    return float(weights @ excess) / math.pi + balance(weights, seen.ambient)


def balance(weights: Array, ambient: float) -> float:
    """The power of surroundings at one temperature (K), where the polarities do not cancel."""
    return float(np.sum(weights)) * STEFAN_BOLTZMANN * ambient**4 / math.pi
