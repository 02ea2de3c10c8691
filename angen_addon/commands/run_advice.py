# SPDX-License-Identifier: GPL-3.0-or-later
"""What a run's user should know before it begins, on standard error."""

from __future__ import annotations

import bpy

from ...sensor_logic.kind import FORCES
from ...sensor_logic.wording import uncapitalized
from ..advice import sensing as advice
from ..advice import warmth
from ..scene.sensors import Sensor, simulated
from .console import note


def tell(sensors: list[Sensor], quiet: bool) -> None:
    """Says which sensors are switched off, and, unless `quiet`, what keeps others from reading what
    their user expects."""
    _tell_of_off(sensors)
    if not quiet:
        _tell_of_pads(sensors)
        _tell_of_warmth(sensors)
        _tell_of_warm_up(sensors)


def _tell_of_off(sensors: list[Sensor]) -> None:
    """Says which sensors will report nothing."""
    off = [s.name for s in sensors if not s.settings.enabled]
    if off:
        note(f"switched off: {', '.join(off)}")


def _tell_of_warmth(sensors: list[Sensor]) -> None:
    """Says what keeps pyroelectric detectors from feeling what their user expects."""
    found = warmth.pyroelectric(simulated(sensors))
    cold = warmth.nothing_warm(bpy.context.view_layer) if found else None
    if cold:
        note(uncapitalized(cold.text))
    for sensor in found:
        slow = warmth.too_slow(sensor)
        if slow:
            note(f"'{sensor.name}': {uncapitalized(slow.text)}")


def _tell_of_warm_up(sensors: list[Sensor]) -> None:
    """Says which detectors the animation ends too early for."""
    for sensor in simulated(sensors):
        late = advice.warm_up(sensor, bpy.context.scene)
        if late:
            note(f"'{sensor.name}': {uncapitalized(late.text)}")


def _tell_of_pads(sensors: list[Sensor]) -> None:
    """Says what keeps pressure pads from reading what their user expects."""
    scene, view_layer = bpy.context.scene, bpy.context.view_layer
    pads = [s for s in simulated(sensors) if s.kind.requires(FORCES)]
    for ask in (
        lambda pad: advice.without_surface(pad.object),
        lambda pad: advice.sinks(pad.object, scene),
        lambda pad: advice.weightless(pad.object, scene, view_layer),
    ):
        told = {pad.name: found for pad in pads if (found := ask(pad))}
        if told:
            note(advice.of_several(told))
    short = advice.short_cache(scene) if pads else None
    if short:
        note(short.text)
