# SPDX-License-Identifier: GPL-3.0-or-later
"""The warmth that people leave in seats and beds.

Upholstery is a slab in which heat flows inwards only. While a body rests on it, skin warms its
surface through compressed clothes. Afterwards the surface loses heat to the room. The same slab,
cut into layers, serves both: its state is known exactly at any time after the last change.

References
----------
H. S. Carslaw, J. C. Jaeger, Conduction of Heat in Solids, 2nd ed., 1959: 2.7 (a half-space that
exchanges heat with a medium), 2.9 (a half-space with a constant flux).
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .model import Array, Index

# W·√s/(m²·K). Effusivity √(k·ρ·c) of upholstery: foam alone has 40, woven covers 100 to 200.
# Assumed: 80.
EFFUSIVITY = 80.0
# W/(m²·K). From skin into the surface: clothes that are compressed to 0.2 clo. Assumed.
OF_CONTACT = 1.0 / (0.2 * 0.155)
# W/(m²·K). From the surface into a room without draught: 5.5 by radiation and 3.5 by convection.
OF_ROOM = 9.0
# √s. The depth of the slab is its thickness over the root of its diffusivity: 0.16 m of foam.
# The layers begin thin enough for contacts of a second, and grow with depth.
DEPTH, FIRST_LAYER, GROWTH = 250.0, 0.3, 1.5
# m. The side of a cell of a print, and how far surface and print may be apart in height.
CELL, HEIGHT = 0.05, 0.08
# s. Contacts are looked for this often.
LOOK_S = 1.0
# Temperatures are computed anew whenever the time since the last change has grown by this part.
# The excess then changes by less than half of it.
FINENESS = 1.0 / 32.0
# K. A cell without contact is forgotten when its surface is below this, at the next change of the
# contacts. Else a warm body that moves on the floor all day would leave ever more cells.
FORGOTTEN = 0.03


class _Exchange(NamedTuple):
    """The slab while its surface exchanges heat with a body or with the room.

    Attributes
    ----------
    rates
        The rate (n,) in 1/s at which each mode decays.
    to_modes, to_layers
        The matrices (n, n) from temperatures of the layers to the amplitudes of modes, and back.
    near
        The share of the medium in the temperature of the surface; the first layer has the rest.
    """

    rates: Array
    to_modes: Array
    to_layers: Array
    near: float


# Without the cache, each change of temperatures would cost 0.2 ms more.
@cache
def _exchange(transfer: float) -> _Exchange:
    """Return the slab with a heat transfer coefficient in W/(m²·K) at its surface."""
    count = math.ceil(math.log1p(DEPTH * (GROWTH - 1.0) / FIRST_LAYER) / math.log(GROWTH))
    layers = FIRST_LAYER * GROWTH ** np.arange(count)
    inner = 2.0 / (layers[:-1] + layers[1:])
    surface = EFFUSIVITY / transfer
    conductances = np.diag(
        np.append(inner, 0.0) + np.append(1.0 / (surface + layers[0] / 2), inner)
    )
    conductances -= np.diag(inner, 1) + np.diag(inner, -1)
    root = np.sqrt(layers)
    rates, vectors = np.linalg.eigh(conductances / np.outer(root, root))
    near = layers[0] / 2 / (surface + layers[0] / 2)
    return _Exchange(rates, vectors * root[:, None], (vectors / root[:, None]).T, near)


def layers_after(state: Array, seconds: float, source: Array) -> Array:
    """Return the excess (m, n) in K of the layers of m slabs, some seconds later.

    Parameters
    ----------
    state
        The excess (m, n) of the layers before.
    seconds
        The time that passes.
    source
        The excess (m,) of the skin that each slab touches; NaN if nothing touches it.
    """
    found = np.empty_like(state)
    for touched, transfer in ((False, OF_ROOM), (True, OF_CONTACT)):
        which = np.isnan(source) != touched
        slab = _exchange(transfer)
        medium = np.nan_to_num(source[which])[:, None]
        amplitudes = (state[which] - medium) @ slab.to_modes
        found[which] = medium + (amplitudes * np.exp(-slab.rates * seconds)) @ slab.to_layers
    return found


def surface_of(state: Array, source: Array) -> Array:
    """Return the excess (m,) in K of the surfaces; the parameters are as for `layers_after`."""
    touched = ~np.isnan(source)
    near = np.where(touched, _exchange(OF_CONTACT).near, _exchange(OF_ROOM).near)
    found: Array = near * np.nan_to_num(source) + (1.0 - near) * state[:, 0]
    return found


def no_layers(count: int) -> Array:
    """Return the state (count, n) of slabs that are as warm as the room."""
    return np.zeros((count, len(_exchange(OF_ROOM).rates)))


class Imprint(NamedTuple):
    """Where bodies touch one solid, as points in a frame of the solid that does not tilt with it.

    Attributes
    ----------
    points
        Points (k, 3) in m that are `CELL` apart: across the surface, and along its normal.
    source
        How much warmer than the surface the skin of the body at each point is (k,), in K.
    """

    points: Array
    source: Array


class Spots(NamedTuple):
    """Where rays hit a print.

    Attributes
    ----------
    ray
        The indices (k,) of the rays.
    cell
        The indices (k, 4) of the cells around each hit.
    weight
        The weights (k, 4) of these cells.
    """

    ray: Index
    cell: Index
    weight: Array


def _keys(columns: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return one integer (…,) for each cell, from its two coordinates (…, 2)."""
    found: NDArray[np.int64] = (columns[..., 0] << 32) + columns[..., 1]
    return found


def _corners(points: Array) -> tuple[NDArray[np.int64], Array]:
    """Return the cells (k, 4) around points (k, 2) in m, as keys, and their bilinear weights."""
    place = points / CELL - 0.5
    first = np.floor(place)
    part = (place - first)[:, None]
    ahead = np.array([[0, 0], [0, 1], [1, 0], [1, 1]])
    weight = np.where(ahead, part, 1.0 - part).prod(axis=2)
    return _keys(first.astype(np.int64)[:, None] + ahead), weight


class Print:
    """The excess of a surface in cells, each with its own slab.

    Attributes
    ----------
    since
        The time in s of the last change of the contacts.
    revision
        The number of changes so far.
    """

    def __init__(self, time: float) -> None:
        self.since = time
        self.revision = 0
        self._key = np.zeros(0, np.int64)
        self._height = np.zeros(0)
        self._source = np.zeros(0)
        self._state = no_layers(0)

    @property
    def touched(self) -> bool:
        """Whether a body touches the surface."""
        return not np.isnan(self._source).all()

    def touch(self, time: float, contact: Imprint | None) -> None:
        """Set the contacts from `time` on; None if no body touches the surface any more."""
        key, height, source = _touched_cells(contact)
        before = ~np.isnan(self._source)
        same = np.array_equal(key, self._key[before])
        if same and np.array_equal(source, self._source[before]):
            return
        state = layers_after(self._state, time - self.since, self._source)
        self.since, self.revision = time, self.revision + 1
        warm = surface_of(state, np.full(len(state), np.nan)) >= FORGOTTEN
        kept = warm | np.isin(self._key, key)
        state = state[kept]
        every = np.union1d(self._key[kept], key)
        known, now = np.searchsorted(every, self._key[kept]), np.searchsorted(every, key)
        heights = np.zeros(len(every))
        heights[known], heights[now] = self._height[kept], height
        self._key, self._height, self._source = every, heights, np.full(len(every), np.nan)
        self._source[now] = source
        self._state = no_layers(len(every))
        self._state[known] = state

    def excess(self, time: float) -> Array:
        """Return the excess (m,) in K of the surface of each cell at `time`."""
        return surface_of(layers_after(self._state, time - self.since, self._source), self._source)

    def spots(self, rays: Index, points: Array) -> Spots:
        """Return which of the rays (k,) hit the print, given their hits (k, 3) in m."""
        keys, weight = _corners(points[:, :2])
        cell = np.searchsorted(self._key, keys)
        cell[cell == len(self._key)] = 0
        near = np.abs(self._height[cell] - points[:, 2:]) < HEIGHT
        weight = np.where(near & (self._key[cell] == keys), weight, 0.0)
        hit = weight.any(axis=1)
        return Spots(rays[hit], cell[hit], weight[hit])


def _touched_cells(contact: Imprint | None) -> tuple[NDArray[np.int64], Array, Array]:
    """Return keys, heights and sources (k,) of the cells of which the body covers half or more."""
    if contact is None:
        return np.zeros(0, np.int64), np.zeros(0), np.zeros(0)
    corners, weight = _corners(contact.points[:, :2])
    keys, cell = np.unique(corners, return_inverse=True)
    cell, weight = cell.ravel(), weight.ravel()
    whole = np.bincount(cell, weight)
    covered = whole >= 0.5
    by_cell = [np.repeat(values, 4) for values in (contact.points[:, 2], contact.source)]
    sums = [np.bincount(cell, weight * values) for values in by_cell]
    height, source = (total[covered] / whole[covered] for total in sums)
    return keys[covered], height, source


# Identifies a print: the number of the solid, and the axis of the solid that points upwards.
Place = tuple[int, int]


@dataclass
class WarmthLeft:
    """The warmth that bodies have left in the surfaces of a scene, since a sensor began to sense.

    Each thermal array has a `WarmthLeft` as part of its state, and hands it to the scene with each
    query. So the readings of an array depend on its own updates alone.

    Attributes
    ----------
    prints
        The prints by their place.
    scene
        The state of the scene when contacts were last looked for; None before the first time.
    """

    prints: dict[Place, Print] = field(default_factory=dict)
    scene: Hashable = None
    _tick: float = -math.inf

    def looks(self, times: Array) -> NDArray[np.bool_]:
        """Return at which of successive updates, at `times` (n,), to look for contacts."""
        ticks = np.floor(times / LOOK_S + 1e-6)
        found: NDArray[np.bool_] = np.diff(ticks, prepend=self._tick) != 0.0
        self._tick = float(ticks[-1])
        return found

    def touch(self, time: float, contacts: Mapping[Place, Imprint]) -> None:
        """Set where bodies touch the solids of the scene from `time` on."""
        for place in contacts.keys() - self.prints.keys():
            self.prints[place] = Print(time)
        for place, one in list(self.prints.items()):
            one.touch(time, contacts.get(place))
            if not one.touched and one.excess(time).max(initial=0.0) < FORGOTTEN:
                del self.prints[place]


def ages(times: Array, since: float) -> NDArray[np.int64]:
    """Return the number (n,) of the interval in which the excess at each time is taken as equal.

    Intervals begin at `since`, and grow with the time since then.
    """
    past = np.maximum(times - since, 0.0)
    found: NDArray[np.int64] = np.floor(np.log1p(past) / math.log1p(FINENESS)).astype(np.int64)
    return found


def start_of(age: int, since: float) -> float:
    """Return the time at which an interval of `ages` begins."""
    return since + math.expm1(age * math.log1p(FINENESS))
