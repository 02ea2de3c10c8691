# SPDX-License-Identifier: GPL-3.0-or-later
"""Prints advice to the user before a run, on standard error."""

from __future__ import annotations

import bpy

from ...sensor_logic.kind import FORCES, LIGHT
from ...sensor_logic.wording import uncapitalized
from ..advice import sensing as advice
from ..advice import warmth
from ..scene.sensors import Sensor, simulated
from ..scene.units import lengths_of
from .console import note


def print_advice(sensors: list[Sensor], quiet: bool) -> None:
    """Prints which sensors are switched off, and, unless `quiet`, why others may not read what the
    user expects."""
    off = [s.name for s in sensors if not s.settings.enabled]
    if off:
        note(f"switched off: {', '.join(off)}")
    if not quiet:
        for found in advice.background_sets(bpy.context.scene):
            note(uncapitalized(found.text))
        _advise_on_pads(sensors)
        _advise_on_warmth(sensors)
        _advise_on_warm_up(sensors)
        if any(sensor.kind.requires(LIGHT) for sensor in simulated(sensors)):
            for found in advice.opaque_glass(bpy.context.view_layer):
                note(uncapitalized(found.text))
        _advise_on_parameters(sensors)


def _advise_on_warmth(sensors: list[Sensor]) -> None:
    """Advises on pyroelectric detectors: nothing warm in the home, and rates that are too slow."""
    found = warmth.pyroelectric(simulated(sensors))
    cold = warmth.nothing_warm(bpy.context.view_layer) if found else None
    if cold:
        note(uncapitalized(cold.text))
    for sensor in found:
        slow = warmth.too_slow(sensor)
        if slow:
            note(f"'{sensor.name}': {uncapitalized(slow.text)}")


def _advise_on_warm_up(sensors: list[Sensor]) -> None:
    """Advises on detectors whose warm-up lasts longer than the animation."""
    for sensor in simulated(sensors):
        late = advice.warm_up(sensor, bpy.context.scene)
        if late:
            note(f"'{sensor.name}': {uncapitalized(late.text)}")


def _advise_on_pads(sensors: list[Sensor]) -> None:
    """Advises on pressure pads without a surface, and on bodies that sink in or have no mass."""
    scene, view_layer = bpy.context.scene, bpy.context.view_layer
    pads = [s for s in simulated(sensors) if s.kind.requires(FORCES)]
    for ask in (
        lambda pad: advice.without_surface(pad.object),
        lambda pad: advice.sinks(pad.object, scene),
        lambda pad: advice.weightless(pad.object, scene, view_layer),
        lambda pad: advice.hidden_partner(pad, view_layer),
    ):
        found = {pad.name: problem for pad in pads if (problem := ask(pad))}
        if found:
            note(advice.of_several(found))
    short = advice.short_cache(scene) if pads else None
    if short:
        note(short.text)


def _advise_on_parameters(sensors: list[Sensor]) -> None:
    """Advises on outputs that never switch on, or never off."""
    for sensor in simulated(sensors):
        for found in advice.unreachable(sensor, lengths_of(bpy.context.scene)):
            note(f"'{sensor.name}': {uncapitalized(found.text)}")
