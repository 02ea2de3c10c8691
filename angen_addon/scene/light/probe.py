# SPDX-License-Identifier: GPL-3.0-or-later
"""Measure the light at all sensors at the scene's present frame.

Never call it in a frame handler or during a user's render. In a frame handler, a render crashes
Blender.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import bpy
import numpy as np

from ....sensor_logic.logs.error import AngenError
from ....sensor_logic.model import Array, LightSample
from ....sensor_logic.physics import EFFICACY, illuminance, luminance_percent
from ....sensor_logic.progress import finished
from . import eevee, engine
from .changes import LightState
from .cycles import CyclesLight, Light, Steps
from .scene import LightScene, quietly

# Metres. At a larger distance from the origin, single precision is too coarse for a sensor's face
# and the walls of its room.
FARTHEST = 100_000.0
THROUGH_WALLS = "EEVEE lets the world's light through walls"
BUSY_JOBS = ("RENDER", "OBJECT_BAKE")


@dataclass(frozen=True)
class LightRequest:
    """The settings of one light sensor. Lengths are in Blender units.

    Attributes
    ----------
    name
        The name of the sensor.
    matrix
        The sensor's pose (4, 4) in the world, with orthonormal axes.
    method
        FOUR_WALL renders four views from the sensor; ILLUMINANCE renders the light on its face.
    engine
        CYCLES or EEVEE.
    samples
        The light paths of a reading.
    clip_start, clip_end
        The clip distances of each of the four views.
    field_of_view
        The angle of each of the four views, in radians.
    exposure
        With FOUR_WALL, a radiance of 1/exposure reads 100 %.
    steady
        Whether nothing in the file animates these settings.
    """

    name: str
    matrix: Array
    method: str = "FOUR_WALL"
    engine: str = "CYCLES"
    samples: int = 1024
    clip_start: float = 0.5
    clip_end: float = 5.0
    field_of_view: float = 0.02
    exposure: float = 1.0
    steady: bool = True


def busy() -> bool:
    """Return whether the user renders or bakes, so that the light sensors must wait."""
    return any(bpy.app.is_job_running(job) for job in BUSY_JOBS)


def measure(*asked: Any, **options: Any) -> Mapping[str, LightSample]:
    """Run `measuring` to its end, and return its result."""
    return finished(measuring(*asked, **options))


def measuring(
    scene: Any,
    view_layer: Any,
    requests: Iterable[LightRequest],
    efficacy: float = EFFICACY,
    kept: CyclesLight | None = None,
    state: LightState | None = None,
) -> Steps[dict[str, LightSample]]:
    """Measure the light of each request; return the samples by name of the request.

    A sample does not depend on the other requests. The generator yields a text for the user before
    each picture. Until it continues, nothing may change the scene.

    Parameters
    ----------
    scene, view_layer
        The user's scene and view layer.
    requests
        The settings of the light sensors.
    efficacy
        Luminous efficacy in lm/W.
    kept
        Keeps light scenes and references for the next call; None to remove them at the end.
    state
        The state of the scene, from which `kept` tells what has changed; None if unknown.

    Raises
    ------
    AngenError
        If a request cannot be measured, or a render is running.
    """
    if busy():
        raise AngenError("a render is running: the light sensors wait for its end")
    view_layer.update()
    asked = sorted(requests, key=lambda request: request.name)
    _check(scene, asked)
    samples: dict[str, LightSample] = {}
    groups: dict[tuple[str, str, int, bool], list[LightRequest]] = {}
    for request in asked:
        # A moving sensor would need new pictures for all sensors that share one with it.
        apart = kept is not None and kept.refers(request.samples) and not request.steady
        key = request.engine, request.method, request.samples, apart
        groups.setdefault(key, []).append(request)
    lights = kept or CyclesLight()
    try:
        if any(by == "CYCLES" for by, *_ in groups):
            lights.look(scene, view_layer, state)
        for (by, *_), group in sorted(groups.items()):
            if by == "CYCLES":
                found, notes = yield from lights.light(group)
            else:
                yield "light by EEVEE"
                with quietly():
                    found, notes = _by_eevee(scene, view_layer, group)
            note = "; ".join(notes)
            samples |= {r.name: _sample(r, found[r.name], efficacy, note) for r in group}
    finally:
        if kept is None:
            lights.close()
    return samples


def _by_eevee(
    scene: Any, view_layer: Any, group: list[LightRequest]
) -> tuple[dict[str, Light], list[str]]:
    """Return the light by name of the request, and notes for the user.

    All requests must have the same method and number of samples.
    """
    with LightScene(scene, view_layer) as light_scene:
        engine.set_up(light_scene.scene, "EEVEE")
        way = eevee.four_walls if group[0].method == "FOUR_WALL" else eevee.faces
        light = way(light_scene, group, group[0].samples)
        if light_scene.scene.world is not None:
            light_scene.notes.append(THROUGH_WALLS)
        found = {r.name: Light(colours) for r, colours in zip(group, light, strict=True)}
        return found, light_scene.notes


def _check(scene: Any, requests: list[LightRequest]) -> None:
    names = [request.name for request in requests]
    if len(set(names)) != len(names):
        raise AngenError("two light sensors have the same name: rename one")
    metres = scene.unit_settings.scale_length if scene.unit_settings.system != "NONE" else 1.0
    for request in requests:
        place = request.matrix[:3, 3]
        if not np.isfinite(request.matrix).all():
            raise AngenError(f"'{request.name}': its transform is not a number")
        if float(np.abs(place).max()) * metres > FARTHEST:
            raise AngenError(
                f"'{request.name}' is {float(np.abs(place).max()) * metres / 1000:.0f} km from "
                "the scene's origin, where Blender's coordinates are too coarse for light: "
                "move the scene nearer to the origin"
            )
    if any(request.engine == "EEVEE" for request in requests):
        reason = engine.why_no_eevee()
        if reason:
            raise AngenError(reason)


def _sample(request: LightRequest, light: Light, efficacy: float, note: str) -> LightSample:
    colours = light.colours
    if not np.isfinite(colours).all():
        colours = np.nan_to_num(colours, nan=0.0, posinf=0.0, neginf=0.0)
        note = "; ".join(filter(None, [note, "light whose strength is not a number was left out"]))
    is_walls = request.method == "FOUR_WALL"
    unit = 100.0 * request.exposure if is_walls else efficacy
    shares = light.shares and tuple(replace(s, light=unit * s.light) for s in light.shares)
    if is_walls:
        return LightSample(luminance_percent(colours, request.exposure), None, note, shares)
    return LightSample(None, illuminance(colours, efficacy), note, shares)
