# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets of commercial slotted switches, and the thesis's."""

from __future__ import annotations

from ...kind import Preset


def _slotted(identifier: str, label: str, gap_mm: float, aperture_mm: float, source: str) -> Preset:
    """A slotted switch that is open where its gap is empty.

    Its hysteresis is a ratio of light of about 0.75 (Sharp), as of the comparator's levels 0.45 and
    0.60. Its response time of microseconds, far less than a frame, is neglected.
    """
    values = {
        "range_min": 0.0,
        "range_max": gap_mm / 1000,
        "threshold": gap_mm / 1000,
        "aperture_rays": 9 if aperture_mm else 1,
        "aperture": aperture_mm / 1000,
        "hysteresis": 0.15,
        "noise_sigma": 0.0,
    }
    return Preset(identifier, label, values, source)


VISHAY_83764 = "Vishay data sheet TCST1103, TCST1202, TCST1300, document 83764: gap, aperture"
SHARP_GP1A50 = "Sharp GP1A50HR/51HR/52HR/53HR data sheet: gap, slit, hysteresis 0.75 typical"
OMRON_EE_SX67 = "Omron EE-SX47/67 data sheet CSM_EE-SX47/67_DS_E: slot; its aperture is not given"

PRESETS: tuple[Preset, ...] = (
    Preset(
        "THESIS",
        "Thesis (Gazebo laser switch)",
        {
            "range_min": 0.001,
            "range_max": 0.5,
            "threshold": 0.05,
            "aperture_rays": 1,
            "aperture": 0.0,
            "noise_sigma": 0.0,
        },
        "laser switch of the thesis's Gazebo plugin",
    ),
    _slotted("TCST1103", "Vishay TCST1103 (3.1 mm)", 3.1, 1.0, VISHAY_83764),
    _slotted("TCST1202", "Vishay TCST1202 (3.1 mm, fine)", 3.1, 0.5, VISHAY_83764),
    _slotted("TCST1300", "Vishay TCST1300 (3.1 mm, finest)", 3.1, 0.25, VISHAY_83764),
    _slotted("GP1A51HR", "Sharp GP1A51HR (3 mm)", 3.0, 0.5, SHARP_GP1A50),
    _slotted("GP1A53HR", "Sharp GP1A53HR (5 mm)", 5.0, 0.5, SHARP_GP1A50),
    _slotted("EE_SX670", "Omron EE-SX670 (5 mm)", 5.0, 0.0, OMRON_EE_SX67),
)
