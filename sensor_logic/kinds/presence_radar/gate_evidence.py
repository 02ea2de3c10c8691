# SPDX-License-Identifier: GPL-3.0-or-later
"""Why a presence radar detects somebody or nobody: the gate that decides, and what is in it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...arrays import Array, Index
from ...evidence import Cause, rows_of, rows_text
from ...kind import Field
from ...radio.echoes import Echoes
from .parameters import NEVER, OFF, THRESHOLDS, RadarParameters
from .window import hann

FIELDS = (
    Field(
        "gate",
        int,
        tip="Number of the strongest gate that detects; else of the one nearest to its threshold",
    ),
    Field("detects", bool, tip="Whether this gate detects"),
    Field("by_movement", bool, tip="Whether it is chosen for movement, not for breathing"),
    Field("speed", float, "m/s", tip="Mean radial speed in it, weighted by power, away positive"),
    Field("loss", float, "dB", tip="Mean one-way loss of the waves to what is in it"),
    Field("objects", str, tip="Objects in it that return power, the strongest first"),
    Field("through", str, tip="Objects that the waves passed on the way to the strongest"),
    Field("stops", str, tip="Objects that stop most waves, if no gate detects"),
)


def cause(track: Any, index: int) -> Cause:
    """Return the cause of update `index` of a `Track`: what is in the gate that detects most."""
    gate, detects, by_movement = (
        track.evidence.value(name, index) for name in ("gate", "detects", "by_movement")
    )
    objects = rows_of(track.evidence.value("objects", index)) if detects else ()
    energies = [
        gate_energies(track.columns["gates"][at])[gate][0 if by_movement else 1]
        for at in range(max(index - 1, 0), index + 1)
    ]
    before = energies[0] if index else math.nan
    names = tuple(name for (name,) in objects)
    return Cause(names, f"gate {gate}", "energy", before, energies[-1])


def gate_energies(text: str) -> list[tuple[float, float]]:
    """Return the energies of movement and breathing of each gate from the field `gates`."""
    pairs = [gate.partition("/") for gate in text.split(";")] if text else []
    return [(float(moving), float(still)) for moving, _, still in pairs]


def is_off(thresholds: Any) -> Any:
    """Return whether a gate with the threshold (…) never detects."""
    return (thresholds <= OFF) | (thresholds >= NEVER)


class Received:
    """What a radar receives at one update, to name the objects in its gates.

    Parameters
    ----------
    echoes
        What the n rays hit.
    powers, speed
        The powers (2, n) in m⁻² of the rays, as moving and as still, and their speeds (n,) in m/s.
    in_gates
        The mean amplitudes (2, gates) of the echoes alone.
    weight
        The weights (n,) of the rays.
    name_of
        A function that returns the name of the solid with a number.
    """

    def __init__(
        self,
        parameters: RadarParameters,
        echoes: Echoes,
        powers: Array,
        speed: Array,
        in_gates: Array,
        weight: Array,
        name_of: Callable[[int], str],
    ) -> None:
        self._echoes, self._powers, self._speed, self._weight = echoes, powers, speed, weight
        self._in_gates = in_gates
        self._name_of = name_of
        self._bin_length = parameters.bin_length
        needed = np.stack([parameters.by_gate(name) for name in THRESHOLDS])
        shares = np.where(is_off(needed), 0.0, in_gates / needed.clip(1e-9))
        # Where all gates that receive anything are switched off, take the strongest.
        nearest = int(np.argmax(shares if shares.any() else in_gates))
        self._nearest = divmod(nearest, in_gates.shape[1])
        self._known: dict[tuple[int, int, bool], dict[str, Any]] = {}

    def evidence(self, energies: Array, detects: NDArray[np.bool_]) -> dict[str, Any]:
        """Return the evidence of an update with these echoes by field.

        `energies` (2, gates) has the reported energies, and `detects` (2, gates) whether each is
        above its threshold.
        """
        which, gate = self._nearest
        is_any = bool(detects.any())
        if is_any:
            which = 0 if detects[0].any() else 1
            energy = np.maximum(energies[which], self._in_gates[which])
            gate = int(np.where(detects[which], energy, -1).argmax())
        key = which, gate, is_any
        if key not in self._known:
            self._known[key] = self._of_gate(*key)
        return self._known[key]

    def _of_gate(self, which: int, gate: int, detects: bool) -> dict[str, Any]:
        echoes, power = self._echoes, self._powers[which]
        rays = np.flatnonzero(power)
        share = power[rays] * hann(echoes.ranges[rays] / self._bin_length - gate) ** 2
        total = float(share.sum())
        share = share / total if total else share
        objects = self._names(rays, share)
        stops: list[str] = []
        if not detects:
            every = np.flatnonzero(echoes.reflectance > 0.0)
            stops = self._names(every, self._weight[every])
        return {
            "gate": gate,
            "detects": detects,
            "by_movement": which == 0,
            "speed": float(share @ self._speed[rays]),
            "loss": float(share @ echoes.loss[rays]),
            "objects": _text(objects),
            "through": _text(self._passed(rays[share > 0.0], objects)),
            "stops": _text(stops),
        }

    def _names(self, rays: Index, share: Array) -> list[str]:
        """Return the names of the objects that some rays (k,) hit, by their `share` (k,)."""
        numbers, of = np.unique(self._echoes.solid[rays], return_inverse=True)
        found: dict[str, float] = {}
        for number, part in zip(numbers.tolist(), np.bincount(of, share).tolist(), strict=True):
            if part > 0.0:
                name = self._name_of(number)
                found[name] = found.get(name, 0.0) + part
        return sorted(found, key=lambda name: -found[name])

    def _passed(self, rays: Index, objects: list[str]) -> Iterable[str]:
        """Return the names of the objects that rays to the first of the `objects` passed."""
        through, solid = self._echoes.through, self._echoes.solid
        names = [
            name
            for ray in rays.tolist()
            if ray in through and self._name_of(int(solid[ray])) == objects[0]
            for name in through[ray]
        ]
        return dict.fromkeys(names)


def _text(names: Iterable[str]) -> str:
    return rows_text((name,) for name in names)
