# SPDX-License-Identifier: GPL-3.0-or-later
"""Typical temperatures of things, and advice if sensors of warmth have nothing to sense."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from ...sensor_logic.kind import WARMTH
from ...sensor_logic.logs.wording import Advice
from ..scene.bearers import candidates
from ..scene.instances import with_instanced
from ..scene.rays.geometry import evaluated_materials
from ..scene.rays.solids import SURFACE_TYPES
from ..scene.sensors import Sensor
from ..scene.surfaces.warmth import collection_parents, inherited_warmth

# °C: the mean temperature of skin at rest in comfort (ISO 7730: 35.7 − 0.028·M, M = 75 W/m²).
SKIN_CELSIUS = 33.5


@dataclass(frozen=True)
class Usual:
    """A sort of thing, such as a person, with its typical warmth.

    Attributes
    ----------
    celsius, emissivity
        The temperature in °C, beneath the insulation, and the emissivity.
    insulation
        The insulation over it in clo.
    """

    identifier: str
    label: str
    tip: str
    celsius: float
    emissivity: float = 0.95
    insulation: float = 0.0


@dataclass(frozen=True)
class BodyPart:
    """A part of a person: a material belongs to it if its name contains one of `words`.

    The first part with such a word counts. `insulation` is in clo, `emissivity` that of its
    surface.
    """

    words: tuple[str, ...]
    insulation: float
    emissivity: float = 0.95


# Assumed: hair is as a light garment. Hands lose more heat than they get by blood, as if under
# 0.2 clo: 31 °C in a room of 20 °C. All else is under clothes.
PARTS = (
    BodyPart(("hair", "beard"), 0.5),
    BodyPart(("hand", "finger"), 0.2, 0.98),
    BodyPart(("skin", "face", "head", "lip", "eye", "iris", "body", "flesh"), 0.0, 0.98),
)


USUAL: dict[str, Usual] = {
    usual.identifier: usual
    for usual in (
        Usual(
            "PERSON",
            "Person",
            "Skin of 33.5 °C under clothes of 1 clo: 26 °C in a room of 20 °C. Materials named "
            "like skin are bare, those named like hair or hands between",
            SKIN_CELSIUS,
            insulation=1.0,
        ),
        Usual(
            "PET",
            "Pet",
            "The fur of a cat or dog: 27 °C in a room of 20 °C",
            36.0,
            insulation=1.05,
        ),
        Usual("HEATER", "Heater", "A warm radiator, 50 °C", 50.0),
        Usual("KETTLE", "Kettle", "A boiling kettle of plastic or painted metal, 90 °C", 90.0),
        Usual("SCREEN", "Warm screen", "A screen that is on, 35 °C", 35.0),
        Usual("SUN", "Sunlit patch", "Floor or furniture in the sun, 35 °C", 35.0),
        Usual("COLD", "Cold window", "A window pane in winter, 12 °C", 12.0),
    )
}


def surfaces_of(obj: Any, view_layer: Any) -> list[Any]:
    """Return the surfaces of an object: itself, its children, and the meshes that it deforms."""
    return [
        other
        for other in view_layer.objects
        if other.type in SURFACE_TYPES and obj in list(candidates(other))
    ]


def warm(obj: Any, usual: Usual, view_layer: Any) -> tuple[list[Any], list[Any]]:
    """Set the typical temperature `usual` on all surfaces of an object.

    Return the surfaces, and the materials that are other parts of a person than the clothes.
    """
    surfaces = [surface for surface in surfaces_of(obj, view_layer) if surface.is_editable]
    parts = []
    for surface in surfaces:
        _set(surface, usual.celsius, usual)
        for material in {slot.material for slot in surface.material_slots} - {None}:
            if usual.identifier != "PERSON" or not material.is_editable or material in parts:
                continue
            name = material.name.lower()
            part = next((p for p in PARTS if any(word in name for word in p.words)), None)
            if part is not None:
                _set(material, usual.celsius, part)
                parts.append(material)
    return surfaces, parts


def _set(owner: Any, celsius: float, values: Usual | BodyPart) -> None:
    owner.angen_warmth.temperature = celsius
    owner.angen_warmth.emissivity = values.emissivity
    owner.angen_warmth.insulation = values.insulation
    owner.angen_warmth.use_temperature = True


def warm_things(view_layer: Any) -> Iterator[Any]:
    """Yield the visible surfaces with a temperature: their own, a material's or a collection's."""
    parents = collection_parents()
    for obj, handle in with_instanced(view_layer):
        ignored = obj.type not in SURFACE_TYPES or obj.angen_ignored
        if ignored or not handle.visible_get(view_layer=view_layer):
            continue
        materials = [m for m in evaluated_materials(obj) if m is not None]
        if (
            obj.angen_warmth.use_temperature
            or any(m.angen_warmth.use_temperature for m in materials)
            or inherited_warmth(obj, parents) is not None
        ):
            yield obj


def sensing_warmth(sensors: Iterable[Sensor]) -> list[Sensor]:
    """Return the sensors among `sensors` that sense heat radiation."""
    return [s for s in sensors if s.kind.requires(WARMTH, s.parameters)]


def nothing_warm(view_layer: Any) -> Advice | None:
    """Return a warning if no object in the scene has a temperature."""
    if next(warm_things(view_layer), None) is not None:
        return None
    return Advice(
        "Nothing in the scene has a temperature: everything is as warm as the room, so "
        "detectors sense nobody",
        "Select the person, then Physics tab, Temperature, Set Usual, Person",
    )


def too_slow(sensor: Sensor) -> Advice | None:
    """Return a warning if a sensor's update rate is too low for its signal."""
    if sensor.settings.update_rate >= sensor.kind.signal_rate:
        return None
    return Advice(
        f"At {sensor.settings.update_rate:g} updates per second the signal of a walker is up to "
        "10 % too low",
        "Set the update rate to the frame rate",
    )
