# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene's units: what lengths are shown in."""

from __future__ import annotations

from typing import Any

from ...sensor_logic.parameters import READING
from ...sensor_logic.quantities import METRES, Lengths

# By Blender's names of the units that a scene can be set to.
UNITS = {
    "KILOMETERS": Lengths("km", 1000.0),
    "METERS": METRES,
    "CENTIMETERS": Lengths("cm", 0.01),
    "MILLIMETERS": Lengths("mm", 0.001),
    "MICROMETERS": Lengths("µm", 1e-6),
    "MILES": Lengths("mi", 1609.344),
    "FEET": Lengths("ft", 0.3048),
    "INCHES": Lengths("in", 0.0254),
    "THOU": Lengths("thou", 2.54e-5),
}
# Units that Blender shows in a field, converts, and reads, by the subtype of the property.
SUBTYPES = {"m": "DISTANCE", "rad": "ANGLE", "s": "TIME_ABSOLUTE"}


def with_unit(label: str, unit: str, scene: Any = None) -> str:
    """A label with the unit of what stands beside it, unless Blender shows that in the field; in a
    scene without units it shows degrees alone."""
    shown = ("rad",) if scene is not None and scene.unit_settings.system == "NONE" else SUBTYPES
    return label if unit in ("", READING, *shown) else f"{label} ({unit})"


def lengths_of(scene: Any) -> Lengths:
    """The unit in which the scene shows lengths; metres if its settings name none."""
    settings = scene.unit_settings
    if settings.system == "NONE":
        return METRES
    adaptive = UNITS["FEET"] if settings.system == "IMPERIAL" else METRES
    return UNITS.get(settings.length_unit, adaptive)
