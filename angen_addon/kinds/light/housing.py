# SPDX-License-Identifier: GPL-3.0-or-later
"""A photoresistor."""

from __future__ import annotations

from ...authoring.housing import Housing, looking


def _photoresistor() -> Housing:
    """GL55: a disk of 5 mm (ednieuw.home.xs4all.nl, GL55xx LDRs); its 2 mm are chosen."""
    return looking(Housing().lathe([(0.0025, 0.0), (0.0025, 0.002)]))


HOUSINGS = {"": _photoresistor}
