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
from dataclasses import replace
from itertools import chain, pairwise
from typing import Any

import numpy as np
from angen_sensors.residents.body import moves
from angen_sensors.residents.body.gait import Stance
from angen_sensors.residents.body.pose import BodyPose, single
from angen_sensors.residents.body.poses import sitting
from angen_sensors.residents.body.turns import compose, ease, rotation_y, rotation_z
from angen_sensors.sensor_logic.model import Array

from . import movements as people
from .common import apart, progress
from .measured_stage import LOG_HZ, Situation, Stage, Trial
from .movements import Movement, Spot

# s. A fresh person begins with movement, since only movement switches a radar on.
ARRIVES = 4.0
# Processes that simulate all situations, two at a time.
SHARES = 10
# Seconds of a quick trial, and of its begin that is left out.
QUICK = (25.0, 10.0)


# The movements that only these situations have.


def empty(times: Array, spot: Spot) -> None:
    """Nobody is there."""


def arriving(then: Movement) -> Movement:
    """Return a movement that begins with walking on the spot, and goes on with `then`."""

    def moved(times: Array, spot: Spot) -> BodyPose:
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
    """Crouch on the heels, bent forward under a table; sway by 3 mm once settled."""
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
    since = times - times[0]
    settling = 0.06 * np.sin(2 * np.pi * since) * ease(ARRIVES - since)
    sway = 0.003 * np.sin(2 * np.pi * 0.3 * since)
    ahead = (settling + sway)[:, None] * np.array([1.0, 0.0, 0.0])
    return replace(pose.repeated(len(times)), pelvis=pose.pelvis + ahead)


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


# The farthest gate in the series by angle: 2.
NEAR = {"range_max": 1.5}
RADAR: dict[str, Any] = {}
PIR: dict[str, Any] = {}


def _by_panel(panel: str, metres: float, movement: Movement) -> Situation:
    return Situation(movement, metres, panel=panel, radar=RADAR)


def _crossing(metres: float, place: str = "ROOM", preset: str = "HC_SR501") -> Situation:
    # Only at the end of the reach does it differ from trial to trial.
    trials = 2 if place == "CORRIDOR" else 1
    return Situation(people.crosses, metres, place=place, pir=PIR, preset=preset, trials=trials)


def _resting(movement: Movement, metres: float, trials: int = 1) -> Situation:
    return Situation(movement, metres, seconds=120.0, skipped=20.0, radar=RADAR, trials=trials)


def _trunk(degrees: float) -> Situation:
    return Situation(people.trunk_sways, 1.0, degrees, radar=NEAR, pir=PIR)


def _corridor(metres: float, trials: int = 2) -> Situation:
    return Situation(people.sways, metres, place="CORRIDOR", radar=RADAR, trials=trials)


_MARCH = people.walks_on_spot
_STANDS = arriving(people.stands_still)
SITUATIONS: dict[str, Situation] = {
    "march 1": Situation(_MARCH, 1.0, radar=RADAR, pir=PIR, trials=2),
    "march 2": Situation(_MARCH, 2.0, radar=RADAR, pir=PIR, trials=2),
    "march 3": Situation(_MARCH, 3.0, radar=RADAR, pir=PIR, trials=3),
    "march 5": Situation(_MARCH, 5.0, radar=RADAR, trials=2),
    "stands 1": _resting(_STANDS, 1.0, trials=2),
    "micro 1": Situation(arriving(people.micro_movements), 1.0, radar=RADAR, pir=PIR, trials=2),
    "seated": replace(_resting(sitting_up(people.sits_still), 2.3), pir=PIR),
    "stands 4": _resting(_STANDS, 4.0),
    "corridor sways 5": _corridor(5.0),
    "corridor sways 6": replace(_corridor(6.0), pir=PIR),
    "corridor sways 7": _corridor(7.0, trials=1),
    "empty": Situation(empty, 6.0, seconds=610.0, radar=RADAR),
    "table": Situation(
        crouches, 0.55, seconds=100.0, skipped=40.0, place="TABLE", radar=RADAR, pir=PIR
    ),
    "trunk 0": _trunk(0.0),
    "trunk 45": _trunk(45.0),
    "trunk 75": _trunk(75.0),
    "trunk 120": _trunk(120.0),
    "glass 3": _by_panel("glass", 3.0, _MARCH),
    "wood 3": _by_panel("wood", 3.0, _MARCH),
    "cardboard 3": _by_panel("cardboard", 3.0, _MARCH),
    "glass fibre 3": _by_panel("glass fibre", 3.0, _MARCH),
    "wood sways 5": _by_panel("wood", 5.0, people.sways),
    "glass sways 5": _by_panel("glass", 5.0, people.sways),
    "plasterboard sways 5": _by_panel("plasterboard", 5.0, people.sways),
    "door": Situation(_MARCH, 4.0, place="SHUT", radar=RADAR, trials=2),
    "beside": replace(_resting(_STANDS, 2.0), other=(_MARCH, 4.0, 0.5)),
    "behind": replace(_resting(_STANDS, 2.0), other=(_MARCH, 4.0, 0.0)),
    "leaves": Situation(leaves, 2.0, seconds=70.0, skipped=10.0, radar=RADAR, pir=PIR, trials=2),
    "cross 1": _crossing(1.0),
    "cross 4": _crossing(4.0),
    "cross 5": _crossing(5.0),
    "cross 6": _crossing(6.0, "CORRIDOR"),
    "cross 7, end": replace(_crossing(7.0, "CORRIDOR", "HC_SR501_MAX"), trials=2),
    "cross 5, end": _crossing(5.0, "ROOM", "HC_SR501_MAX"),
    "jogs 1": Situation(people.jogging_arms, 1.0, pir=PIR),
    "sways 3": Situation(people.sways, 3.0, pir=PIR, trials=3),
    "glass 1": Situation(_MARCH, 1.0, pir=PIR, panel="glass"),
    "metal 1": Situation(_MARCH, 1.0, pir=PIR, panel="metal"),
    "pulses": Situation(people.crosses, 3.0, pir={"retrigger": False}),
}


# What is computed from the logs, exactly as the measured rows define it.

Trials = list[Trial]


def _percent(flags: Any) -> float:
    return 100.0 * float(np.mean(flags))


def _of_all(trials: Trials, of: Callable[[Trial], Any]) -> Any:
    """Return the values of all trials in one array."""
    return np.concatenate([np.atleast_1d(of(trial)) for trial in trials])


def energy(trials: Trials) -> float:
    """Return the mean energy of the target over the samples with movement reported, or 0."""
    found = _of_all(trials, lambda t: _target(t).max(axis=1)[t.moving])
    return float(found.mean()) if len(found) else 0.0


def _target(t: Trial, channel: str = "moving") -> Any:
    """Return the energies (n, gates) of the gates above their thresholds, and 0 for the others.

    The strongest of them is the target of the module: the floor of a gate is none.
    """
    gates, thresholds = getattr(t, f"{channel}_gates"), getattr(t, f"{channel}_thresholds")
    return np.where(gates > thresholds, gates, 0.0)


def mean_gates(trials: Trials, channel: str = "moving_gates") -> Array:
    """Return the mean energies (gates,) of a channel."""
    return np.asarray(np.mean(_of_all(trials, lambda t: getattr(t, channel)), axis=0))


def own(trials: Trials) -> int:
    """Return the gate of the person: that with the most energy above its threshold."""
    return int(_of_all(trials, _target).sum(axis=0).argmax())


def own_gate(trials: Trials, farther: int = 0) -> float:
    """Return the mean energy of the person's gate, or of a farther one, over all samples."""
    return float(mean_gates(trials)[own(trials) + farther])


def reported(trials: Trials) -> float:
    return _percent(_of_all(trials, lambda t: t.moving))


def present(trials: Trials) -> float:
    return _percent(_of_all(trials, lambda t: t.presence))


def on(trials: Trials) -> float:
    return _percent(_of_all(trials, lambda t: t.pir))


def fading(trials: Trials) -> float:
    """Return the sd over mean of the target's energy, over the samples with movement reported."""
    found = _of_all(trials, lambda t: _target(t).max(axis=1)[t.moving])
    return float(found.std() / found.mean()) if len(found) else 0.0


def ratio(trials: Trials, rank: int) -> float:
    """Return the mean energy of the stronger (1) or weaker (2) gate beside the person's over it."""
    gates, gate = np.pad(mean_gates(trials), 1), own(trials) + 1
    beside = sorted((gates[gate - 1], gates[gate + 1]), reverse=True)
    return float(beside[rank - 1] / gates[gate]) if gates[gate] else 0.0


def same_gate(trials: Trials) -> float:
    """Return the share of samples whose strongest gate is within one of the reported distance's."""
    found = _of_all(
        trials,
        lambda t: np.abs(_target(t).argmax(axis=1) - np.round(t.metres / GATE))[t.moving] <= 1,
    )
    return _percent(found) if len(found) else 0.0


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
    return _percent(_of_all(trials, lambda t: t.moving & _is_still(t)))


def _is_still(t: Trial) -> Any:
    return _target(t, "still").any(axis=1)


def of_other(trials: Trials, metres: float = 4.0) -> float:
    """Return the share of samples in which a channel's strongest gate is that of a distance."""

    def said(t: Trial) -> Any:
        found = np.zeros(len(t.times), bool)
        for target in (_target(t), _target(t, "still")):
            found |= target.any(axis=1) & (np.abs(target.argmax(axis=1) - metres / GATE) <= 1.0)
        return found

    return _percent(_of_all(trials, said))


def _last(t: Trial, flags: Any) -> float:
    """Return the time after the last sample with a flag; NaN without one."""
    where = np.flatnonzero(flags)
    return float(t.times[where[-1]] + 1.0 / LOG_HZ) if len(where) else math.nan


def later(trials: Trials, first: Callable[[Trial], Any], second: Callable[[Trial], Any]) -> float:
    """Return by how many seconds the last flag of `second` is later than that of `first`.

    Trials without a flag, such as of a motion detector that did not notice the person, are left
    out.
    """
    found = np.array([_last(t, second(t)) - _last(t, first(t)) for t in trials])
    known = found[np.isfinite(found)]
    return float(known.mean()) if len(known) else math.nan


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
    "L3": (("leaves",), lambda t: later(t, lambda s: s.pir, lambda s: s.presence)),
    "L4": (("leaves",), lambda t: later(t, lambda s: s.moving, lambda s: s.presence)),
    "L5": (("leaves",), lambda t: later(t, _is_still, lambda s: s.presence)),
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
    "U3": (("march 1",), pulses),
}
# With --quick: a radar's energies, spill, distance and presence, and a motion detector's share.
QUICK_ROWS = ("E5", "F3", "G3", "X5", "D4", "D7", "M3", "K4", "O3", "Z5", "Y4")


def simulate(quick: bool) -> dict[str, float]:
    """Return the simulated figure of each row of measured_people.csv that can be rebuilt."""
    rows = QUICK_ROWS if quick else tuple(ROWS)
    names = list(dict.fromkeys(chain.from_iterable(ROWS[row][0] for row in rows)))
    if quick:
        return figures(rows, trials_of(names, True))
    # Two processes at a time. Each has some of the long situations, and some of the short ones.
    order = sorted(names, key=lambda name: -SITUATIONS[name].work)
    shares = [order[k::SHARES] for k in range(SHARES)]
    with ThreadPoolExecutor(2) as pool:
        found = list(pool.map(lambda share: apart("measured_people.plain_trials", share), shares))
    return figures(rows, {name: trials for share in found for name, trials in restored(share)})


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


def restored(share: dict[str, Any]) -> list[tuple[str, Trials]]:
    """Return the logs of situations from JSON values."""
    return [
        (name, [Trial(**{key: np.array(v) for key, v in one.items()}) for one in trials])
        for name, trials in share.items()
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
