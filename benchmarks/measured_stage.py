# SPDX-License-Identifier: GPL-3.0-or-later
"""A room and a corridor with a radar, a motion detector and two residents, for a trial at a time.

Set-ups as far as they are known, and what is assumed: docs/measured.md.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from angen_sensors.residents.blender.api import Home
from angen_sensors.residents.blender.keys import Curves
from angen_sensors.residents.blender.person import body_of
from angen_sensors.residents.body.solve import channels
from angen_sensors.sensor_logic.kind import Preset
from angen_sensors.sensor_logic.kinds.pir.presets import PRESETS as DETECTORS
from angen_sensors.sensor_logic.kinds.pir.range_scan import PirParameters
from angen_sensors.sensor_logic.kinds.presence_radar.parameters import RadarParameters
from angen_sensors.sensor_logic.kinds.presence_radar.presets import PRESETS as RADARS
from angen_sensors.sensor_logic.model import Array

from .common import box_mesh, link, new_scene
from .movements import Movement, Spot

FPS, RADAR_HZ = 20, 5.0
# The log of the measurements has 5 rows a second.
LOG_HZ = 5.0
CELSIUS, HEIGHT = 27.0, 0.85
# s between the movements of two trials of a situation, and of two people.
BETWEEN, APART = 600.0, 77.0
# Noise is drawn by the number of the update: trials at other frames have other noise.
BETWEEN_FRAMES = 20_000


@dataclass(frozen=True)
class Situation:
    """What is before the sensors in a trial.

    Attributes
    ----------
    movement, metres, degrees, aside
        What the person does, and where: distance and bearing from the sensors, and how far to the
        left of the axis (m).
    other
        What a second person does, at which distance and how far aside; none by default.
    seconds, skipped
        The seconds of a trial, and those of its begin that are left out.
    place
        ROOM, CORRIDOR, TABLE (the sensors are under a table) or SHUT (the door is shut).
    panel
        The name of a panel of `PANELS` before the sensors; none by default.
    radar, pir
        Parameters of the sensors besides their presets; None without this sensor.
    preset
        The preset of the motion detector.
    trials
        How often it is repeated, with other movements and other noise.
    """

    movement: Movement
    metres: float = 1.0
    degrees: float = 0.0
    aside: float = 0.0
    other: tuple[Movement, float, float] | None = None
    seconds: float = 60.0
    skipped: float = 10.0
    place: str = "ROOM"
    panel: str = ""
    radar: dict[str, Any] | None = None
    pir: dict[str, Any] | None = None
    preset: str = "HC_SR501"
    trials: int = 1

    @property
    def work(self) -> float:
        """About how long it takes, relative to others: by the solid angle of the person."""
        sensors = (self.radar is not None) + (self.pir is not None)
        return sensors * self.trials * self.seconds * (0.2 + 1.0 / self.metres**2)


@dataclass(frozen=True)
class Trial:
    """The readings of a trial after the seconds left out, as a log with 5 rows a second.

    Attributes
    ----------
    times, presence, moving, metres
        Times (n,) in s since the begin of the trial, and fields (n,) of the radar.
    moving_gates, still_gates
        Energies (n, gates) of the radar.
    still_thresholds, moving_thresholds
        The thresholds (gates,) of the radar.
    pir
        Whether the motion detector is on (n,).
    """

    times: Array
    presence: Any = None
    moving: Any = None
    metres: Any = None
    moving_gates: Any = None
    still_gates: Any = None
    moving_thresholds: Any = None
    still_thresholds: Any = None
    pir: Any = None


# Substance, its thickness (m) and the half angle that the panel covers (degrees), 0.20 m before the
# sensors. Of corrugated board only the paper counts, and glass fibre in resin is taken as glass.
PANELS = {
    "plasterboard": ("PLASTERBOARD", 0.010, 63.0),
    "cardboard": ("WOOD", 0.0015, 54.0),
    "glass fibre": ("GLASS", 0.001, 70.0),
    "glass": ("GLASS", 0.005, 61.0),
    "wood": ("WOOD", 0.010, 54.0),
    "metal": ("METAL", 0.001, 50.0),
}
# A hollow door is two boards.
DOOR = ("CHIPBOARD", 0.008)


class Stage:
    """A scene with the room, the corridor, two people and both sensors, for one trial at a time."""

    def __init__(self) -> None:
        self.scene = new_scene(FPS, 1_000_000)
        self.scene.angen_ambient_temperature = CELSIUS
        self._home = Home.open(Path("measured.blend"))
        self._shown: dict[str, tuple[str, ...]] = _build_places()
        self._panel = link("Panel", box_mesh([((0.5, 0.5, 0.5), (0, 0, 0))]))
        self._panel.angen_radar.substance = "WOOD"
        self._people = [self._person("A"), self._person("B")]
        for kind, name in (("PRESENCE_RADAR", "Radar"), ("PIR", "PIR")):
            self._home.add(kind, name, (0.0, 0.0, HEIGHT), (1.0, 0.0, 0.0))

    def _person(self, name: str) -> Any:
        return bpy.data.objects[self._home.add_resident("ADULT", name)]

    def trial(self, situation: Situation, number: int) -> Trial:
        """Return the log of a trial. Each trial has other movements and other noise."""
        first = 1 + number * BETWEEN_FRAMES
        count = round(situation.seconds * FPS)
        times = np.arange(count) / FPS + BETWEEN * number
        self._show(situation)
        ahead = math.radians(situation.degrees)
        x, y = situation.metres * math.cos(ahead), situation.metres * math.sin(ahead)
        self._move(self._people[0], first, times, situation.movement, x, y + situation.aside)
        if situation.other is not None:
            movement, metres, aside = situation.other
            self._move(self._people[1], first, times + APART, movement, metres, aside)
        else:
            self._people[1].hide_viewport = body_of(self._people[1]).hide_viewport = True
        chosen = [
            name
            for name, given in (("Radar", situation.radar), ("PIR", situation.pir))
            if given is not None
        ]
        self._place_sensors(situation)
        recording = self._home.simulate((first, first + count - 1), chosen)
        return _log(recording, situation, self._home)

    def _move(
        self, rig: Any, first: int, times: Array, movement: Movement, x: float, y: float
    ) -> None:
        pose = movement(times, Spot(x, y, math.atan2(-y, -x)))
        rig.hide_viewport = body_of(rig).hide_viewport = pose is None
        if pose is None:
            return
        if rig.animation_data is not None and rig.animation_data.action is not None:
            bpy.data.actions.remove(rig.animation_data.action)
        rest = {bone.name: np.array(bone.matrix_local.to_quaternion()) for bone in rig.data.bones}
        rig.rotation_mode = "XYZ"
        frames = np.arange(first, first + len(times), dtype=float)
        curves = Curves(rig, "Movement")
        for path, index, values in channels(pose, rest):
            curves.write(path, index, frames, np.broadcast_to(values, frames.shape))
        for axis in (0, 1):
            curves.write("rotation_euler", axis, frames[:1], [0.0])

    def _show(self, situation: Situation) -> None:
        for place, names in self._shown.items():
            for name in names:
                bpy.data.objects[name].hide_viewport = place not in _parts_of(situation.place)
        self._panel.hide_viewport = not situation.panel
        if situation.panel:
            substance, thickness, half_angle = PANELS[situation.panel]
            half = 0.2 * math.tan(math.radians(half_angle))
            self._panel.location = 0.2, 0.0, HEIGHT
            self._panel.scale = 0.002, 2.0 * half, 2.0 * half
            self._panel.angen_radar.substance = substance
            self._panel.angen_radar.thickness = thickness

    def _place_sensors(self, situation: Situation) -> None:
        height = {"CORRIDOR": 0.80, "TABLE": 0.70}.get(situation.place, HEIGHT)
        pitch = math.radians(-30.0) if situation.place == "TABLE" else 0.0
        for name, preset, given in (
            ("Radar", "LD2410", situation.radar),
            ("PIR", situation.preset, situation.pir),
        ):
            obj = bpy.data.objects[name]
            obj.location = (0.0, 0.0, height)
            obj.rotation_euler = (math.pi / 2 + pitch, 0.0, -math.pi / 2)
            sensor = self._home.sensor(name)
            sensor.enabled = given is not None
            for key, value in {**preset_values(name, preset), **(given or {})}.items():
                setattr(sensor, key, value)
            sensor.update_rate = RADAR_HZ if name == "Radar" else FPS


def preset_values(name: str, preset: str) -> dict[str, Any]:
    """Return all parameters of a sensor by its preset; a motion detector is long since warm."""
    if name == "Radar":
        return {**vars(RadarParameters()), **_values(RADARS, preset)}
    values = {**vars(PirParameters()), **_values(DETECTORS, preset), "warm_up_time": 0.0}
    # The table of a lens is a text in the file, and these lenses have none.
    return {key: value for key, value in values.items() if key != "lens_table"}


def _values(presets: tuple[Preset, ...], identifier: str) -> dict[str, Any]:
    return dict(next(p for p in presets if p.identifier == identifier).values)


def _parts_of(place: str) -> tuple[str, ...]:
    return {"SHUT": ("ROOM", "SHUT"), "TABLE": ("ROOM", "TABLE")}.get(place, (place,))


def _build_places() -> dict[str, tuple[str, ...]]:
    """Build all places, and return the names of their objects.

    Parts are given as (half size, middle) in metres; the view axis is +X.
    """
    # m: half of the width of a room whose size was not published.
    side, height, end = 1.7, 2.7, 5.5
    wall = 0.08
    room = [
        ((3.4, side, 0.1), (2.4, 0.0, -0.1)),
        ((3.4, side, 0.1), (2.4, 0.0, height + 0.1)),
        ((3.4, wall, height / 2), (2.4, side + wall, height / 2)),
        ((3.4, wall, height / 2), (2.4, -side - wall, height / 2)),
        ((wall, side, height / 2), (-0.9 - wall, 0.0, height / 2)),
        ((wall, side, height / 2), (end + wall, 0.0, height / 2)),
        # The wall at 3.8 m with a doorway 0.9 m wide and 2.05 m high.
        ((0.05, (side - 0.45) / 2, height / 2), (3.8, 0.45 + (side - 0.45) / 2, height / 2)),
        ((0.05, (side - 0.45) / 2, height / 2), (3.8, -0.45 - (side - 0.45) / 2, height / 2)),
        ((0.05, 0.45, (height - 2.05) / 2), (3.8, 0.0, (height + 2.05) / 2)),
    ]
    furniture = [((0.2, 0.35, 0.6), (3.45, 1.2, 0.6)), ((0.35, 0.6, 0.02), (-0.40, 0.0, 0.78))]
    corridor = [
        ((5.0, 0.6, 0.1), (4.2, 0.0, -0.1)),
        ((2.45, 0.6, 0.1), (1.6, 0.0, 2.4)),
        ((2.5, 0.6, 0.1), (6.6, 0.0, 3.3)),
        ((5.0, wall, 1.65), (4.2, 0.6 + wall, 1.65)),
        ((5.0, wall, 1.65), (4.2, -0.6 - wall, 1.65)),
        ((wall, 0.6, 1.65), (9.0 + wall, 0.0, 1.65)),
        ((wall, 0.6, 1.65), (-0.9, 0.0, 1.65)),
    ]
    for at, opening in ((4.0, 0.35), (5.0, 0.40)):
        jamb = (0.6 - opening) / 2
        corridor += [((0.05, jamb, 1.15), (at, s * (0.6 - jamb), 1.15)) for s in (1, -1)]
        corridor.append(((0.05, 0.6, 0.5), (at, 0.0, 2.6)))
    made = {
        "ROOM": ("Walls", room),
        "FURNITURE": ("Furniture", furniture),
        "CORRIDOR": ("Corridor", corridor),
        "SHUT": ("Door", [((0.02, 0.45, 1.025), (3.8, 0.0, 1.025))]),
        "TABLE": ("Table above", [((0.4, 0.6, 0.015), (0.4, 0.0, 0.76))]),
    }
    for name, parts in made.values():
        link(name, box_mesh(parts))
    for name in ("Furniture", "Table above"):
        bpy.data.objects[name].angen_radar.substance = "CHIPBOARD"
    door = bpy.data.objects["Door"].angen_radar
    door.substance, door.thickness = DOOR
    return {
        "ROOM": ("Walls", "Furniture"),
        "CORRIDOR": ("Corridor",),
        "SHUT": ("Door",),
        "TABLE": ("Table above",),
    }


def _log(recording: Any, situation: Situation, home: Any) -> Trial:
    """Return the samples of a trial as a log with 5 rows a second, without its begin."""
    found: dict[str, Any] = {}
    rows = round(situation.seconds * LOG_HZ)
    skipped = round(situation.skipped * LOG_HZ)
    if situation.radar is not None:
        samples = recording.samples("Radar")
        step = round(RADAR_HZ / LOG_HZ)
        kept = slice(0, rows * step, step)
        energies = [
            [gate.split("/") for gate in text.split(";")] for text in samples["gates"][kept]
        ]
        both = np.array(energies, float)
        found["presence"], found["moving"] = samples["presence"][kept], samples["moving"][kept]
        found["metres"] = samples["distance_m"][kept]
        found["moving_gates"], found["still_gates"] = both[..., 0], both[..., 1]
    if situation.pir is not None:
        samples = recording.samples("PIR")
        step = round(FPS / LOG_HZ)
        found["pir"] = samples["moved"][0 : rows * step : step]
    logged = {key: np.asarray(value)[skipped:] for key, value in found.items()}
    if situation.radar is not None:
        count = logged["moving_gates"].shape[1]
        for channel in ("moving", "still"):
            text = getattr(home.sensor("Radar"), f"{channel}_thresholds")
            numbers = [float(word) for word in text.replace(",", " ").split()]
            numbers += numbers[-1:] * (count - len(numbers))
            logged[f"{channel}_thresholds"] = np.array(numbers[:count])
    length = len(next(iter(logged.values())))
    times = (np.arange(length) + skipped) / LOG_HZ
    return Trial(times, **logged)
