# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of the light on light sensors."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ...sensor_logic.kind import LIGHT
from ...sensor_logic.wording import named
from ..advice import sensing
from ..scene.animation import curves, is_animated
from ..scene.light.engine import why_no_eevee
from ..scene.light.materials import has_nodes
from ..scene.light.scene import is_portal
from .examined import Examined, Found

# W of light: no household lamp emits more. The electrical power of a lamp is several times its
# light.
MOST_WATTS = 50.0
# W/m² of light: the sun gives no more.
MOST_SUN = 150.0
USUAL_LUMENS = 800


def electrical_watts(home: Examined) -> Iterator[Found]:
    """Reports lamps that seem to be set to their electrical power."""
    if not home.requiring(LIGHT):
        return
    efficacy = home.scene.angen_luminous_efficacy
    for lamp in _lamps(home):
        data, sun = lamp.data, lamp.data.type == "SUN"
        most, unit = (MOST_SUN, "W/m²") if sun else (MOST_WATTS, "W")
        power = _peak(data)
        if power <= most:
            continue
        what = "lx" if sun else "lm"
        usual = "up to 100 W/m² at noon" if sun else f"{USUAL_LUMENS / efficacy:.2g} W"
        yield (
            f"'{lamp.name}' shines with {power:g} {unit} of light, "
            f"{power * efficacy:,.0f} {what}: is that the lamp's electrical power?",
            f"Blender's watts are light: divide lumens by {efficacy:g} (a household lamp of "
            f"{USUAL_LUMENS} lm: {usual}); Light tab, {'Strength' if sun else 'Power'}",
            (lamp.name,),
        )


def none_lit(home: Examined) -> Iterator[Found]:
    """Reports light sensors in a scene without any light."""
    sensors = home.requiring(LIGHT)
    lit = any(lamp.data.energy > 0 or _is_switched(lamp.data) for lamp in _lamps(home))
    if not sensors or lit or _world_shines(home.scene.world) or _something_shines(home):
        return
    yield (
        f"No lamp, no sky and nothing that glows lights {named(s.name for s in sensors)}",
        "Add a lamp (Shift+A, Light) or a sky (World tab, Color), or show those that are hidden",
        tuple(s.name for s in sensors),
    )


def opaque_glass(home: Examined) -> Iterator[Found]:
    """Reports glass that keeps lamps and the sun from light sensors."""
    if home.requiring(LIGHT):
        yield from sensing.opaque_glass(home.view_layer)


def eevee_cannot_run(home: Examined) -> Iterator[Found]:
    """Reports light sensors that are set to EEVEE where it cannot run."""
    sensors = [s for s in home.requiring(LIGHT) if getattr(s.parameters, "engine", "") == "EEVEE"]
    reason = why_no_eevee() if sensors else ""
    if reason:
        names = tuple(s.name for s in sensors)
        yield f"{named(names)}: {reason}", "Set Engine to Cycles", names


def _lamps(home: Examined) -> list[Any]:
    """The visible lamps."""
    lamps = dict.fromkeys(obj for obj, _ in home.seen if obj.type == "LIGHT")
    return [lamp for lamp in lamps if not is_portal(lamp)]


def _peak(lamp: Any) -> float:
    """Its greatest power among its setting and its keys."""
    keyed = [point.co[1] for curve in curves(lamp, {"energy"}) for point in curve.keyframe_points]
    return float(max([lamp.energy, *keyed]))


def _is_switched(lamp: Any) -> bool:
    return is_animated(lamp, "energy")


def _world_shines(world: Any) -> bool:
    if world is None:
        return False
    if not has_nodes(world):
        return any(part > 0 for part in world.color)
    return any(_shines(node) for node in world.node_tree.nodes if node.type == "BACKGROUND")


def _shines(node: Any) -> bool:
    """Whether an emission or background node gives light, or may, since an input is linked."""
    strength = next((s for s in node.inputs if s.name in {"Strength", "Emission Strength"}), None)
    names = {"Color", "Emission Color", "Emission"}
    colour = next((s for s in node.inputs if s.name in names), None)
    lit = strength is None or strength.is_linked or strength.default_value > 0
    coloured = (
        colour is None or colour.is_linked or any(part > 0 for part in colour.default_value[:3])
    )
    return bool(lit and coloured)


def _something_shines(home: Examined) -> bool:
    return any(
        _shines(node)
        for obj in home.shown()
        for slot in obj.material_slots
        if slot.material is not None and slot.material.node_tree is not None
        for node in slot.material.node_tree.nodes
        if node.type in {"EMISSION", "BSDF_PRINCIPLED"}
    )
