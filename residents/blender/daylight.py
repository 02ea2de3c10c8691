# SPDX-License-Identifier: GPL-3.0-or-later
"""The sun and sky of a home, animated by date, hour and place on Earth.

The strengths of sun and sky in the blend file hold for the sun's altitude in the file. At another
altitude both are multiplied by the ratio that `residents/days/sun.py` computes. Sun and sky change
every ten minutes.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import astuple
from datetime import date, datetime, time, timedelta
from itertools import pairwise
from typing import Any

import bpy
import numpy as np
from mathutils import Vector

from ...angen_addon.scene.light.materials import has_nodes
from ...angen_addon.scene.light.scene import remove_part_starts, store_part_starts
from ...angen_addon.scene.sensors import Sensor
from ...sensor_logic.kind import LIGHT
from ...sensor_logic.model import Array
from ..days.rows import LEAD_S, frame_at
from ..days.sun import Site, direction, position, skylight, sunlight
from ..days.truth import DAY_S
from .keys import CONSTANT, Curves

# s between two positions of the sun.
EVERY = 600.0
# Below this altitude, the sun of the file does not say how strong sunlight is.
LOWEST = math.radians(5.0)


class Daylight:
    """Context manager: on entry, animate sun and sky over a day; on exit, remove the keyframes.

    Sun and sky stay as in the file if the home has no sun, or if latitude or longitude is not set.
    They also stay if no light sensor is simulated.
    """

    def __init__(self, scene: Any, sensors: Sequence[Sensor], day: date) -> None:
        self._scene, self._day = scene, day
        self._site = site_of(scene)
        self._has_light_sensors = has_light_sensors = any(s.kind.requires(LIGHT) for s in sensors)
        found = [obj for obj in scene.objects if obj.type == "LIGHT" and obj.data.type == "SUN"]
        free = [obj for obj in found if not _driven(obj) and not _driven(obj.data)]
        self.sun: Any = free[0] if free and has_light_sensors and self._site else None
        self._before: list[tuple[Any, str, Any]] = []
        self._keyed: list[Any] = []

    def __enter__(self) -> Daylight:
        self.insert_keys()
        return self

    def __exit__(self, *_: object) -> None:
        remove_part_starts(self._scene)
        for owner in self._keyed:
            bpy.data.actions.remove(owner.animation_data.action)
        for owner, name, value in reversed(self._before):
            setattr(owner, name, value)

    def skies(self) -> Iterator[tuple[Any, str, Any]]:
        """Yield the strength of a sky that follows the sun, as node tree, data path and socket."""
        if self.sun is not None:
            yield from _skies(self._scene.world)

    def insert_keys(self) -> None:
        """Insert the keyframes, and store the frames at which references of light are measured.

        A reference is a precise picture of the light, by which later readings are corrected. The
        caller restores the earlier values.
        """
        if self._has_light_sensors:
            store_part_starts(self._scene, [frame_at(-LEAD_S)])
        if self.sun is not None and self._site is not None:
            self._write(self.sun, self._site)

    def changes(self) -> list[float]:
        """Return the times at which the direct sunlight changes, s since midnight."""
        if self.sun is None or self._site is None:
            return []
        starts, positions = self._sun_positions(self._site)
        up = [sunlight(altitude) > 0.0 for altitude, _ in positions]
        parts = zip(starts[1:], pairwise(up), strict=True)
        return [start for start, shines in parts if any(shines) and start > -LEAD_S]

    def _sun_positions(self, site: Site) -> tuple[list[float], list[tuple[float, float]]]:
        """Return the times at which the sun moves, s since midnight, and its position after each.

        Times while the sun is below the horizon are included.
        """
        begin = datetime.combine(self._day, time())
        starts = np.arange(-math.ceil(LEAD_S / EVERY) * EVERY, DAY_S, EVERY).tolist()
        # The position in the middle of each interval.
        moments = [begin + timedelta(seconds=start + EVERY / 2) for start in starts]
        return starts, [position(site, moment) for moment in moments]

    def _write(self, sun: Any, site: Site) -> None:
        starts, positions = self._sun_positions(site)
        frames = np.array([frame_at(start) for start in starts])
        store_part_starts(self._scene, [frame_at(start) for start in (-LEAD_S, *self.changes())])
        away = sun.matrix_world.to_3x3() @ Vector((0.0, 0.0, 1.0))
        authored = max(math.asin(max(-1.0, min(1.0, away.normalized().z))), LOWEST)
        above = sun.parent.matrix_world.to_quaternion().inverted() if sun.parent else None
        turns = []
        for altitude, azimuth in positions:
            turn = Vector(direction(site, altitude, azimuth)).to_track_quat("Z", "Y")
            turns.append(above @ turn if above is not None else turn)
        powers = [sun.data.energy * sunlight(a) / sunlight(authored) for a, _ in positions]
        # Restored in reverse order: setting rotation_mode converts the rotation.
        self._store_attributes(sun, "rotation_quaternion", "rotation_euler", "rotation_mode")
        sun.rotation_mode = "QUATERNION"
        self._insert_curves(sun, "rotation_quaternion", frames, np.array(turns))
        self._store_attributes(sun.data, "energy")
        self._insert_curves(sun.data, "energy", frames, np.array(powers)[:, None])
        skies = np.array([skylight(a) for a, _ in positions]) / skylight(authored)
        for tree, path, socket in self.skies():
            self._store_attributes(socket, "default_value")
            self._insert_curves(tree, path, frames, socket.default_value * skies[:, None])

    def _insert_curves(self, owner: Any, path: str, frames: Array, values: Array) -> None:
        """Insert keyframes at n frames; each column of `values` (n, k) is a curve."""
        curves = Curves(owner, "Daylight")
        self._keyed.append(owner)
        for index, column in enumerate(values.T):
            curves.write(path, index, frames, column, CONSTANT)

    def _store_attributes(self, owner: Any, *names: str) -> None:
        """Store the present values of attributes, to restore them on exit."""
        for name in names:
            value = getattr(owner, name)
            self._before.append((owner, name, value.copy() if hasattr(value, "copy") else value))


def _driven(owner: Any) -> bool:
    return owner.animation_data is not None and bool(owner.animation_data.drivers)


def site_values(scene: Any) -> list[Any]:
    """Return the place on Earth as plain values, with None if latitude or longitude is not set."""
    site = site_of(scene)
    return [None] if site is None else list(astuple(site))


def site_of(scene: Any) -> Site | None:
    """Return where on Earth the home is, or None if latitude or longitude is not set."""
    found = scene.angen_site
    if not (found.is_property_set("latitude") and found.is_property_set("longitude")):
        return None
    return Site(found.latitude, found.longitude, found.utc_offset, found.north)


def _skies(world: Any) -> Iterator[tuple[Any, str, Any]]:
    """Yield the strength of a world's background as node tree, data path and socket.

    Yield nothing if the world has several backgrounds, or if a link or driver sets the strength.
    """
    if world is None or not has_nodes(world) or _driven(world.node_tree):
        return
    tree = world.node_tree
    backgrounds = [node for node in tree.nodes if node.bl_idname == "ShaderNodeBackground"]
    if len(backgrounds) == 1 and not backgrounds[0].inputs["Strength"].is_linked:
        socket = backgrounds[0].inputs["Strength"]
        yield tree, socket.path_from_id("default_value"), socket
