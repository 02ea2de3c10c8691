# SPDX-License-Identifier: GPL-3.0-or-later
"""Electrical properties of building materials and of the human body at radar frequencies.

For millimetre waves, walls of plasterboard, wooden doors and panes are half transparent. Concrete
attenuates strongly, metal reflects everything. See docs/presence_radar.md.

References
----------
- ITU-R P.2040-3 (08/2023), Effects of building materials and structures on radiowave propagation
  above about 100 MHz: table 3 and annex 1, section 2.1.
- S. Gabriel, R. W. Lau, C. Gabriel (1996), The dielectric properties of biological tissues: III,
  Phys. Med. Biol. 41, 2271–2293: dry skin. IFAC-CNR publishes the same values as tables.
- Design and Study of an mmWave Wearable Textile Based Compact Antenna for Healthcare Applications,
  Int. J. Antennas Propag. (2021) 6506128, table 2: cotton, ε′ = 1.63.
- J. E. Bjarnason et al. (2004), Millimeter-wave, terahertz, and mid-infrared transmission through
  common clothing, Appl. Phys. Lett. 85, 519–521: eight cloths lose less than 3 dB up to 300 GHz.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping
from dataclasses import dataclass

LIGHT_SPEED = 299_792_458.0  # m/s
VACUUM_PERMITTIVITY = 8.8541878128e-12  # F/m
# dB. Greater losses are not told apart: nothing returns.
OPAQUE = 300.0


@dataclass(frozen=True)
class BuildingMaterial:
    """A building material of ITU-R P.2040-3, table 3: ε′ = a·f^b, σ = c·f^d, f in GHz.

    `highest` is the highest frequency in GHz of the measurements. Above it, the values are
    extrapolated.
    """

    a: float
    b: float
    c: float
    d: float
    highest: float = 100.0

    def permittivity(self, frequency: float) -> complex:
        """Return the complex relative permittivity ε′ − jσ/(2πfε₀) at `frequency` (GHz)."""
        conductivity = self.c * frequency**self.d
        imaginary = conductivity / (2.0 * math.pi * frequency * 1e9 * VACUUM_PERMITTIVITY)
        return complex(self.a * frequency**self.b, -imaginary)


@dataclass(frozen=True)
class ColeCole:
    """A tissue of Gabriel (1996): two dispersions (Δε, τ in s, α) and a static conductivity.

    ε = ε∞ + Σ Δεₙ / (1 + (jωτₙ)^(1−αₙ)) + σ / (jωε₀).
    """

    infinite: float
    dispersions: tuple[tuple[float, float, float], ...]
    conductivity: float

    def permittivity(self, frequency: float) -> complex:
        """Return the complex relative permittivity at `frequency` (GHz)."""
        omega = 2.0 * math.pi * frequency * 1e9
        found = complex(self.infinite) + self.conductivity / (1j * omega * VACUUM_PERMITTIVITY)
        for step, time, spread in self.dispersions:
            found += step / (1.0 + (1j * omega * time) ** (1.0 - spread))
        return found


SUBSTANCES: Mapping[str, BuildingMaterial | ColeCole] = {
    "CONCRETE": BuildingMaterial(5.24, 0.0, 0.0462, 0.7822),
    "BRICK": BuildingMaterial(3.91, 0.0, 0.0238, 0.16, 40.0),
    "PLASTERBOARD": BuildingMaterial(2.73, 0.0, 0.0085, 0.9395),
    "WOOD": BuildingMaterial(1.99, 0.0, 0.0047, 1.0718),
    "GLASS": BuildingMaterial(6.31, 0.0, 0.0036, 1.3394),
    "CHIPBOARD": BuildingMaterial(2.58, 0.0, 0.0217, 0.78),
    "PLYWOOD": BuildingMaterial(2.71, 0.0, 0.33, 0.0, 40.0),
    "METAL": BuildingMaterial(1.0, 0.0, 1e7, 0.0),
    # Dry skin. The waves enter it by less than a millimetre, so that what is below has no effect.
    "BODY": ColeCole(4.0, ((32.0, 7.234e-12, 0.0), (1100.0, 32.481e-9, 0.2)), 0.0002),
    # Cotton, dense as cloth. Its loss tangent of 0.04 is assumed: a cloth of 1 mm then loses 1.5 dB
    # at 300 GHz.
    "TEXTILE": BuildingMaterial(1.63, 0.0, 0.0036, 1.0),
}


def permittivity(substance: str, frequency: float) -> complex:
    """Return the complex relative permittivity of a substance at `frequency` (GHz)."""
    return SUBSTANCES[substance].permittivity(frequency)


def reflectance(substance: str, frequency: float) -> float:
    """Return the share of the power that a plane surface reflects at normal incidence.

    It is |(1 − √ε)/(1 + √ε)|² with the complex relative permittivity ε at `frequency` (GHz).
    """
    root = cmath.sqrt(permittivity(substance, frequency))
    return abs((1.0 - root) / (1.0 + root)) ** 2


def attenuation(substance: str, thickness: float, frequency: float) -> float:
    """Return the loss in dB of a wave that passes a slab once, at normal incidence.

    It is the absorption inside, and the reflection at both faces. Interference between the two
    faces is left out, because it depends on tenths of a millimetre. The result is at most `OPAQUE`.

    Parameters
    ----------
    substance
        A name in `SUBSTANCES`.
    thickness
        The length of the path in the slab in m; 0 gives no loss at all.
    frequency
        The carrier frequency in GHz.

    References
    ----------
    ITU-R P.2040-3, annex 1, section 2.1.2.5. The absorption is 20·lg e · (2πf/c) · |Im √ε| in dB/m.
    In a dielectric (σ small), this becomes 1636·σ/√ε′.
    """
    if thickness <= 0.0:
        return 0.0
    root = cmath.sqrt(permittivity(substance, frequency))
    wave_number = 2.0 * math.pi * frequency * 1e9 / LIGHT_SPEED
    inside = 20.0 * math.log10(math.e) * wave_number * abs(root.imag) * thickness
    passed = max(1.0 - reflectance(substance, frequency), 1e-30)
    return min(inside - 20.0 * math.log10(passed), OPAQUE)
