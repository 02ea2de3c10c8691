# SPDX-License-Identifier: GPL-3.0-or-later
"""Rebuild what was measured with people before an LD2410B and an HC-SR501 side by side.

`measured_people.csv` has the measured values. `simulate` gives the same figures of the presets,
before the project's own resident in a room and a corridor of that size. Set-ups as far as they are
known, and what is assumed: docs/measured.md.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import chain, pairwise
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from angen_sensors.residents.blender.api import Home
from angen_sensors.residents.blender.keys import Curves
from angen_sensors.residents.blender.person import body_of
from angen_sensors.residents.body import moves
from angen_sensors.residents.body.gait import Stance
from angen_sensors.residents.body.pose import BodyPose, single
from angen_sensors.residents.body.poses import sitting
from angen_sensors.residents.body.solve import channels
from angen_sensors.residents.body.turns import compose, ease, rotation_y, rotation_z
from angen_sensors.sensor_logic.kinds.pir.presets import PRESETS
from angen_sensors.sensor_logic.model import Array

from . import movements as people
from .common import apart, box_mesh, link, new_scene, progress
from .movements import Movement, Spot

FPS, RADAR_HZ = 20, 5.0
# The log of the measurements has 5 rows a second.
LOG_HZ = 5.0
CELSIUS, HEIGHT = 27.0, 0.85
# s. A fresh person begins with movement, since only movement switches a radar on.
ARRIVES = 4.0
# s between the movements of two trials of a situation.
BETWEEN = 600.0
# Seconds of a trial, and of its begin that is left out.
WALKING, STANDING, SITTING = (80.0, 20.0), (120.0, 20.0), (130.0, 30.0)
QUICK = (25.0, 10.0)


# The movements that only these situations have.


def empty(times: Array, spot: Spot) -> None:
    """Nobody is there."""


def arriving(then: Movement) -> Movement:
    """Return a movement that begins with walking on the spot, and goes on with `then`."""

    def moved(times: Array, spot: Spot) -> BodyPose:
        # At rest in the end, so that the pose does not jump.
        share = ease((times - times[0] - ARRIVES + 1.0) / 1.0)
        return people.walks_on_spot(times, spot).interpolated(then(times, spot), share)

    return moved


def sitting_up(then: Movement) -> Movement:
    """Return a movement that begins with a swaying trunk, and goes on with `then`."""

    def moved(times: Array, spot: Spot) -> BodyPose:
        share = ease((times - times[0] - ARRIVES + 1.0) / 1.0)
        return people.trunk_sways(times, spot).interpolated(then(times, spot), share)

    return moved


def crouches(times: Array, spot: Spot) -> BodyPose:
    """Crouch on the heels, bent forward under a table; the first seconds are spent settling."""
    stand = spot.stand()
    back = -0.20 * spot.build.scale
    hips = spot.x + back * math.cos(spot.yaw), spot.y + back * math.sin(spot.yaw), spot.floor + 0.2
    pose = sitting(stand, np.array(hips))
    pose = replace(
        pose,
        turn=compose(rotation_z(pose.heading), rotation_y(0.35)),
        spine=single((0.0, 0.5, 0.0)),
        look=single((0.0, -0.4, 0.0)),
    )
    settled = people._swaying(pose.repeated(len(times)), times, 0.003, 0.003)
    since = times - times[0]
    settling = 0.06 * np.sin(2 * np.pi * since) * ease(ARRIVES - since)
    return replace(settled, pelvis=settled.pelvis + settling[:, None] * np.array([1.0, 0.0, 0.0]))


# s at which the leaving person sets off.
LEAVES = 20.0


def leaves(times: Array, spot: Spot) -> BodyPose | None:
    """Walk on the spot, then at `LEAVES` out of the door at 3.8 m and round its wall."""
    path = np.array([(spot.x, spot.y), (4.3, 0.0), (4.5, -0.8), (4.5, -2.2)])
    corners = [np.linspace(a, b, 40, endpoint=False) for a, b in pairwise(path)]
    smooth = np.concatenate([*corners, path[-1:]])
    stance = Stance.at(spot.x, spot.y, spot.yaw, spot.build)
    walk = moves.Walk(
        moves.footsteps(stance, smooth, None, spot.build), spot.build.speed, 0.0, spot.build
    )
    since = times - times[0]
    before = people.walks_on_spot(times, spot)
    going = walk.pose(np.clip(since - LEAVES, 0.0, walk.duration))
    pose = before.interpolated(going, ease((since - LEAVES + 0.5) / 0.5))
    # Whoever is round the wall is gone.
    gone = since > LEAVES + walk.duration
    far = np.where(gone, -100.0, 0.0)[:, None] * np.array([0.0, 1.0, 0.0])
    feet = replace(pose.feet, ankle=pose.feet.ankle + far[:, None])
    return replace(pose, pelvis=pose.pelvis + far, feet=feet)


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
    seconds: float = WALKING[0]
    skipped: float = WALKING[1]
    place: str = "ROOM"
    panel: str = ""
    radar: dict[str, Any] | None = None
    pir: dict[str, Any] | None = None
    preset: str = "HC_SR501"
    trials: int = 1


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
# The farthest gate in the series by angle: 2.
NEAR = {"range_max": 1.5}
RADAR: dict[str, Any] = {}
PIR: dict[str, Any] = {}


def _by_panel(panel: str, metres: float, movement: Movement) -> Situation:
    return Situation(movement, metres, panel=panel, radar=RADAR, trials=2)


def _crossing(metres: float, place: str = "ROOM", preset: str = "HC_SR501") -> Situation:
    return Situation(people.crosses, metres, place=place, pir=PIR, preset=preset, trials=2)


def _still(movement: Movement, metres: float, lasting: tuple[float, float]) -> Situation:
    seconds, skipped = lasting
    return Situation(arriving(movement), metres, seconds=seconds, skipped=skipped, radar=RADAR)


def _trunk(degrees: float) -> Situation:
    return Situation(people.trunk_sways, 1.0, degrees, radar=NEAR, pir=PIR)


def _corridor(metres: float, movement: Movement = people.sways, trials: int = 2) -> Situation:
    return Situation(movement, metres, place="CORRIDOR", radar=RADAR, trials=trials)


_SEATED = Situation(
    sitting_up(people.sits_still), 2.3, seconds=SITTING[0], skipped=SITTING[1], radar=RADAR, pir=PIR
)
_MARCH = people.walks_on_spot
# The person who stands still at 2 m begins with movement, as everybody does.
_TWO = Situation(arriving(people.stands_still), 2.0, radar=RADAR, seconds=140.0)
SITUATIONS: dict[str, Situation] = {
    "march 1": Situation(_MARCH, 1.0, radar=RADAR, pir=PIR, trials=3),
    "march 2": Situation(_MARCH, 2.0, radar=RADAR, pir=PIR, trials=2),
    "march 3": Situation(_MARCH, 3.0, radar=RADAR, pir=PIR, trials=3),
    "march 5": Situation(_MARCH, 5.0, radar=RADAR, trials=2),
    "stands 1": replace(_still(people.stands_still, 1.0, STANDING), trials=2),
    "micro 1": replace(_still(people.micro_movements, 1.0, STANDING), pir=PIR, trials=2),
    "seated": _SEATED,
    "stands 4": _still(people.stands_still, 4.0, STANDING),
    "corridor sways 5": _corridor(5.0),
    "corridor sways 6": replace(_corridor(6.0), pir=PIR),
    "corridor sways 7": _corridor(7.0, trials=1),
    "empty": Situation(empty, seconds=620.0, radar=RADAR),
    "table": Situation(
        crouches, 0.55, seconds=100.0, skipped=40.0, place="TABLE", radar=RADAR, pir=PIR
    ),
    "trunk 0": _trunk(0.0),
    "trunk 45": replace(_trunk(45.0), trials=2),
    "trunk 75": _trunk(75.0),
    "trunk 120": _trunk(120.0),
    "glass 3": _by_panel("glass", 3.0, _MARCH),
    "wood 3": _by_panel("wood", 3.0, _MARCH),
    "cardboard 3": _by_panel("cardboard", 3.0, _MARCH),
    "glass fibre 3": _by_panel("glass fibre", 3.0, _MARCH),
    "wood sways 5": replace(_by_panel("wood", 5.0, people.sways), trials=1),
    "glass sways 5": replace(_by_panel("glass", 5.0, people.sways), trials=1),
    "plasterboard sways 5": _by_panel("plasterboard", 5.0, people.sways),
    "door": Situation(_MARCH, 4.0, place="SHUT", radar=RADAR, trials=2),
    "beside": replace(_TWO, other=(_MARCH, 4.0, 0.5)),
    "behind": replace(_TWO, other=(_MARCH, 4.0, 0.0)),
    "leaves": Situation(leaves, 2.0, seconds=70.0, skipped=10.0, radar=RADAR, pir=PIR, trials=3),
    "cross 1": _crossing(1.0),
    "cross 4": _crossing(4.0),
    "cross 5": _crossing(5.0),
    "cross 6": _crossing(6.0, "CORRIDOR"),
    "cross 7, end": _crossing(7.0, "CORRIDOR", "HC_SR501_MAX"),
    "cross 5, end": _crossing(5.0, "ROOM", "HC_SR501_MAX"),
    "jogs 1": Situation(people.jogging_arms, 1.0, pir=PIR, trials=2),
    "sways 3": Situation(people.sways, 3.0, pir=PIR, trials=3),
    "glass 1": Situation(_MARCH, 1.0, pir=PIR, panel="glass"),
    "metal 1": Situation(_MARCH, 1.0, pir=PIR, panel="metal"),
    "pulses": Situation(_MARCH, 1.0, seconds=200.0, pir={"retrigger": False}),
    "long pulses": Situation(_MARCH, 1.0, seconds=200.0, pir=PIR, trials=2),
}


# What is computed from the logs, exactly as the measured rows define it.

Trials = list[Trial]


def _percent(flags: Any) -> float:
    return 100.0 * float(np.mean(flags))


def _of_all(trials: Trials, of: Callable[[Trial], Any]) -> Any:
    """Return the values of all trials in one array."""
    return np.concatenate([np.atleast_1d(of(trial)) for trial in trials])


def energy(trials: Trials) -> float:
    """Return the mean energy of the strongest gate over the samples with movement reported.

    Without such samples it is 0.
    """
    found = _of_all(trials, lambda t: t.moving_gates.max(axis=1)[t.moving])
    return float(found.mean()) if len(found) else 0.0


def mean_gates(trials: Trials, channel: str = "moving_gates") -> Array:
    """Return the mean energies (gates,) of a channel."""
    return np.asarray(np.mean(_of_all(trials, lambda t: getattr(t, channel)), axis=0))


def own_gate(trials: Trials, farther: int = 0) -> float:
    """Return the mean energy of the person's gate, the strongest one, or of a farther one."""
    gates = mean_gates(trials)
    return float(gates[np.argmax(gates) + farther])


def reported(trials: Trials) -> float:
    return _percent(_of_all(trials, lambda t: t.moving))


def present(trials: Trials) -> float:
    return _percent(_of_all(trials, lambda t: t.presence))


def on(trials: Trials) -> float:
    return _percent(_of_all(trials, lambda t: t.pir))


def fading(trials: Trials) -> float:
    """Return the sd over mean of the strongest gate's energy, over the samples with movement."""
    found = _of_all(trials, lambda t: t.moving_gates.max(axis=1)[t.moving])
    return float(found.std() / found.mean()) if len(found) else 0.0


def ratio(trials: Trials, rank: int) -> float:
    """Return the mean energy of the second (1) or third (2) strongest gate over the strongest."""
    gates = np.sort(mean_gates(trials))[::-1]
    return float(gates[rank] / gates[0]) if gates[0] else 0.0


def same_gate(trials: Trials) -> float:
    """Return the share of samples whose strongest gate is within one of the reported distance's."""
    found = []
    for t in trials:
        strongest = t.moving_gates.argmax(axis=1)[t.moving]
        found.append(np.abs(strongest - np.round(t.metres[t.moving] / GATE)) <= 1)
    flags = np.concatenate(found)
    return _percent(flags) if len(flags) else 0.0


# m. Middle to middle of the gates of the module.
GATE = 0.75


def still(trials: Trials, gate: int | None = None) -> float:
    """Return the mean still energy of a gate, or of the strongest gate."""
    gates = mean_gates(trials, "still_gates")
    return float(gates.max() if gate is None else gates[gate])


def centimetres(trials: Trials, of: Callable[[Any], Any], when: str = "moving") -> float:
    """Return `of` of the distances (cm) of the samples with movement or presence, trial by trial.

    It is the mean over the trials; 0 without such samples.
    """
    each = [100.0 * t.metres[getattr(t, when)] for t in trials]
    values = [of(metres) for metres in each if len(metres)]
    return float(np.mean(values)) if values else 0.0


def both_channels(trials: Trials) -> float:
    """Return the share of samples with movement and a still gate above its threshold."""
    return _percent(_of_all(trials, lambda t: t.moving & _above(t).any(axis=1)))


def _above(t: Trial, channel: str = "still") -> Any:
    """Return which gates (n, gates) of a channel are above their thresholds."""
    gates, thresholds = getattr(t, f"{channel}_gates"), getattr(t, f"{channel}_thresholds")
    return (gates > thresholds) & (gates > 0)


def of_other(trials: Trials, metres: float = 4.0) -> float:
    """Return the share of samples in which a channel's strongest gate is that of a distance."""

    def said(t: Trial) -> Any:
        found = np.zeros(len(t.times), bool)
        for channel in ("moving", "still"):
            above = _above(t, channel)
            strongest = np.where(above, getattr(t, f"{channel}_gates"), -1.0).argmax(axis=1)
            found |= above.any(axis=1) & (np.abs(strongest - metres / GATE) <= 1.0)
        return found

    return _percent(_of_all(trials, said))


def _last(t: Trial, flags: Any) -> float:
    """Return the time after the last sample with a flag; NaN without one."""
    where = np.flatnonzero(flags)
    return float(t.times[where[-1]] + 1.0 / LOG_HZ) if len(where) else math.nan


def later(trials: Trials, first: Callable[[Trial], Any], second: Callable[[Trial], Any]) -> float:
    """Return by how many seconds the last flag of `second` is later than that of `first`."""
    found = [_last(t, second(t)) - _last(t, first(t)) for t in trials]
    return float(np.mean(found))


def pulses(trials: Trials) -> float:
    """Return the mean length (s) of the whole pulses of the motion detector; 0 without any."""
    lengths: list[float] = []
    for t in trials:
        edges = np.flatnonzero(np.diff(t.pir.astype(int)))
        rising = t.pir[edges + 1] if len(edges) else np.empty(0, bool)
        times = t.times[edges]
        lengths += [b - a for (a, up), (b, _) in pairwise(zip(times, rising, strict=True)) if up]
    return float(np.mean(lengths)) if lengths else 0.0


def alarms(trials: Trials) -> float:
    """Return how often presence switches on, per hour."""
    count = sum(int(np.sum(np.diff(t.presence.astype(int)) > 0)) for t in trials)
    return 3600.0 * count / sum(t.times[-1] - t.times[0] for t in trials)


def _radar_off(t: Trial) -> Any:
    return t.presence


def _pir_off(t: Trial) -> Any:
    return t.pir


Row = tuple[tuple[str, ...], Callable[..., float]]
# The situations of each row, and its figure; a change is that of the first to the second.
ROWS: dict[str, Row] = {
    "E1": (("march 1",), energy),
    "E2": (("march 2",), energy),
    "E5": (("march 5",), energy),
    "E7": (("corridor sways 5",), energy),
    "E8": (("corridor sways 6",), energy),
    "D1": (("stands 1",), energy),
    "D4": (("stands 1",), own_gate),
    "D5": (("micro 1",), own_gate),
    "D7": (("stands 1",), lambda t: own_gate(t, 1)),
    "D8": (("micro 1",), lambda t: own_gate(t, 1)),
    "D10": (("stands 1",), reported),
    "F1": (("march 3",), fading),
    "F3": (("march 5",), reported),
    "F5": (("march 2",), reported),
    "G3": (("march 5",), lambda t: ratio(t, 1)),
    "G4": (("march 5",), lambda t: ratio(t, 2)),
    "G5": (("march 2",), lambda t: ratio(t, 1)),
    "G7": (("march 3",), same_gate),
    "S1": (("seated",), still),
    "S2": (("seated",), lambda t: still(t, 4)),
    "S3": (("seated",), lambda t: still(t, 5)),
    "S8": (("stands 4",), still),
    "S10": (("corridor sways 7",), lambda t: still(t, -1)),
    "S11": (("stands 1",), lambda t: max(still(t, 0), still(t, 1))),
    "N1": (("empty",), lambda t: float(mean_gates(t)[1])),
    "N2": (("empty",), lambda t: float(mean_gates(t)[2:].mean())),
    "N5": (("empty",), lambda t: float(mean_gates(t)[0])),
    "Q1": (("empty",), alarms),
    "X1": (("march 1",), lambda t: centimetres(t, np.mean)),
    "X3": (("march 3",), lambda t: centimetres(t, np.mean)),
    "X5": (("march 5",), lambda t: centimetres(t, np.mean)),
    "X7": (("march 1",), lambda t: centimetres(t, np.std)),
    "X8": (("march 2",), lambda t: centimetres(t, np.std)),
    "X11": (("march 5",), lambda t: centimetres(t, np.std)),
    "X12": (("stands 1",), lambda t: centimetres(t, np.std, "presence")),
    "X15": (("corridor sways 6",), lambda t: centimetres(t, np.max, "presence")),
    "M2": (("seated",), present),
    "M3": (("stands 1",), present),
    "M4": (("corridor sways 5",), present),
    "M5": (("corridor sways 6",), present),
    "M10": (("table",), present),
    "A0": (("trunk 0",), present),
    "A1": (("trunk 45",), present),
    "A3": (("trunk 75",), present),
    "A5": (("trunk 120",), present),
    "T2": (("glass 3", "march 3"), energy),
    "T3": (("wood 3", "march 3"), energy),
    "T6": (("cardboard 3", "march 3"), energy),
    "T7": (("glass fibre 3", "march 3"), energy),
    "T12": (("wood sways 5",), present),
    "T13": (("glass sways 5",), present),
    "T14": (("plasterboard sways 5",), energy),
    "T16": (("door",), reported),
    "P1": (("beside",), both_channels),
    "P4": (("beside",), of_other),
    "P6": (("behind",), of_other),
    "P9": (("beside",), present),
    "L3": (("leaves",), lambda t: later(t, _pir_off, _radar_off)),
    "L4": (("leaves",), lambda t: later(t, lambda s: s.moving, _radar_off)),
    "L5": (("leaves",), lambda t: later(t, lambda s: _above(s).any(axis=1), _radar_off)),
    "K1": (("cross 1",), on),
    "K4": (("cross 4",), on),
    "K5": (("cross 5",), on),
    "K6": (("cross 6",), on),
    "K9": (("cross 7, end",), on),
    "K11": (("cross 5, end",), on),
    "O1": (("march 1",), on),
    "O2": (("march 2",), on),
    "O3": (("march 3",), on),
    "V2": (("micro 1",), on),
    "V4": (("jogs 1",), on),
    "V6": (("trunk 0",), on),
    "V7": (("seated",), on),
    "V8": (("sways 3",), on),
    "V10": (("corridor sways 6",), on),
    "V13": (("table",), on),
    "Z1": (("trunk 45",), on),
    "Z5": (("trunk 120",), on),
    "Y2": (("glass 1",), on),
    "Y4": (("metal 1",), on),
    "U1": (("pulses",), pulses),
    "U3": (("long pulses",), pulses),
}
# With --quick: a radar's energy, spill, distance and presence, and a motion detector's share.
QUICK_ROWS = ("E5", "G3", "X5", "M3", "K4", "O3", "Z5", "Y4")


def simulate(quick: bool) -> dict[str, float]:
    """Return the simulated figure of each row of measured_people.csv that can be rebuilt."""
    rows = QUICK_ROWS if quick else tuple(ROWS)
    names = list(dict.fromkeys(chain.from_iterable(ROWS[row][0] for row in rows)))
    if quick:
        return figures(rows, trials_of(names, True))
    # Two processes, each with half of the situations; the rows of both need few in common.
    seconds = {name: SITUATIONS[name].seconds * SITUATIONS[name].trials for name in names}
    halves: tuple[list[str], list[str]] = ([], [])
    for name in sorted(names, key=lambda name: -seconds[name]):
        min(halves, key=lambda half: sum(seconds[one] for one in half)).append(name)
    with ThreadPoolExecutor(2) as pool:
        found = list(pool.map(lambda half: apart("measured_people.plain_trials", half), halves))
    return figures(rows, {name: trials for half in found for name, trials in restored(half)})


def figures(rows: tuple[str, ...], trials: dict[str, Trials]) -> dict[str, float]:
    """Return the figure of each row from the logs of all situations."""
    found = {}
    for row in rows:
        names, figure = ROWS[row]
        value = figure(trials[names[0]])
        if len(names) == 2:
            without = figure(trials[names[1]])
            value = 100.0 * (value / without - 1.0) if without else math.nan
        found[row] = value
    return found


def plain_trials(names: list[str]) -> dict[str, Any]:
    """Return the logs of situations as JSON values."""
    return {
        name: [
            {key: value.tolist() for key, value in vars(trial).items() if value is not None}
            for trial in trials
        ]
        for name, trials in trials_of(names, False).items()
    }


def restored(half: dict[str, Any]) -> list[tuple[str, Trials]]:
    """Return the logs of situations from JSON values."""
    return [
        (name, [Trial(**{key: np.array(v) for key, v in one.items()}) for one in trials])
        for name, trials in half.items()
    ]


def trials_of(names: list[str], quick: bool) -> dict[str, Trials]:
    """Return the logs of all trials of situations, by name."""
    stage, found = Stage(), {}
    for done, name in enumerate(names):
        progress("measured", done, len(names), name)
        situation = SITUATIONS[name]
        if quick:
            seconds, skipped = QUICK
            situation = replace(situation, seconds=seconds, skipped=skipped, trials=1)
        found[name] = [stage.trial(situation, number) for number in range(situation.trials)]
    return found


class Stage:
    """A scene with the room, the corridor, two people and both sensors, for one trial at a time."""

    def __init__(self) -> None:
        self.scene = new_scene(FPS, 1_000_000)
        self.scene.angen_ambient_temperature = CELSIUS
        self._home = Home.open(Path("measured.blend"))
        self._frame = 1
        self._shown: dict[str, tuple[str, ...]] = _build_places()
        self._panel = link("Panel", box_mesh([((0.5, 0.5, 0.5), (0, 0, 0))]))
        self._panel.angen_radar.substance = "WOOD"
        self._people = [self._person("A"), self._person("B")]
        for kind, name in (("PRESENCE_RADAR", "Radar"), ("PIR", "PIR")):
            self._home.add(kind, name, (0.0, 0.0, HEIGHT), (1.0, 0.0, 0.0))
            # Only its own part: a housing must not hide the other's view.
            bpy.data.objects[name].angen_ignored = True

    def _person(self, name: str) -> Any:
        return bpy.data.objects[self._home.add_resident("ADULT", name)]

    def trial(self, situation: Situation, number: int) -> Trial:
        """Return the log of a trial. Each trial has other movements and other noise."""
        first = self._frame
        count = round(situation.seconds * FPS)
        self._frame += count + FPS
        times = np.arange(count) / FPS + BETWEEN * number
        self._show(situation)
        ahead = math.radians(situation.degrees)
        x, y = situation.metres * math.cos(ahead), situation.metres * math.sin(ahead)
        self._move(self._people[0], first, times, situation.movement, x, y + situation.aside)
        if situation.other is not None:
            movement, metres, aside = situation.other
            self._move(self._people[1], first, times + 77.0, movement, metres, aside)
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
        yaw = math.atan2(-y, -x) if y and abs(y) > 0.6 else math.pi
        pose = movement(times, Spot(x, y, yaw))
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
            # A real pane would stand in the table: only what is above it counts.
            self._panel.location, self._panel.scale = (0.2, 0.0, HEIGHT), (0.002, 2 * half, 2 * half)
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
    """Return the parameters of a sensor's preset; a motion detector is long since warm."""
    if name == "Radar":
        from angen_sensors.sensor_logic.kinds.presence_radar.presets import PRESETS as RADARS

        return dict(next(p for p in RADARS if p.identifier == preset).values)
    known = {p.identifier: p for p in PRESETS}
    values = dict(known.get(preset, known["HC_SR501"]).values)
    values.pop("lens_table", None)
    return {**values, "warm_up_time": 0.0}


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
