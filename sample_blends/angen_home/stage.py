# SPDX-License-Identifier: GPL-3.0-or-later
"""What the words of a story can be said of: places, spots, props, doors, lamps."""

from dataclasses import dataclass
from math import cos, sin

import numpy as np
from angen_sensors.residents.acting.places import LIE, SIT, STAND, USE, Place, Places
from angen_sensors.residents.acting.timeline import Acted, swung

from . import places, plan
from .paths import place_yaw
from .story import PROPS, SPOTS

# Where a prop is held, in its own frame; a prop without an entry cannot be in a story.
GRIPS = {"Bottle": (0.0, 0.0, 0.10), "Coat": (-0.09, 0.0, -0.03)}


def _use(name: str, place: places.Place) -> str:
    """SIT where the seat is straight behind one who stands there: one sits down backwards."""
    if place.seat is None:
        return STAND
    yaw = place_yaw(place)
    dx, dy = place.x - place.seat[0], place.y - place.seat[1]
    ahead, beside = dx * cos(yaw) + dy * sin(yaw), dy * cos(yaw) - dx * sin(yaw)
    if abs(beside) <= 0.15 and ahead >= 0.40:
        return SIT
    return LIE if name == "bed_lie" else STAND


@dataclass(frozen=True)
class Hinged:
    """A thing's own door: hinge (x, y), yaws in degrees, its handle in the leaf's frame."""

    box: plan.Box  # the thing itself: what is inside is behind the door
    hinge: tuple[float, float]
    closed_yaw: float
    open_yaw: float
    handle: tuple[float, float, float]

    def handle_at(self, yaw: np.ndarray) -> np.ndarray:
        """Where the handle is (…, 3) at yaws (…,)."""
        c, s = np.cos(np.radians(yaw)), np.sin(np.radians(yaw))
        u, v, z = self.handle
        x, y = self.hinge[0] + u * c - v * s, self.hinge[1] + u * s + v * c
        return np.stack([x, y, np.full_like(x, z)], -1)


_FRIDGE = plan.FURNITURE["Fridge"]
HINGED = {
    "Fridge door": Hinged(
        _FRIDGE, (_FRIDGE.x0, _FRIDGE.y0), 0.0, -105.0,
        (_FRIDGE.x1 - _FRIDGE.x0 - 0.05, -0.035, 1.12),
    )
}  # fmt: skip
CLOSED = {f"Door {name}": door.closed_yaw for name, door in plan.DOORS.items()}
CLOSED |= {name: thing.closed_yaw for name, thing in HINGED.items()}


def _places() -> Places:
    """What the words can be said of."""
    found = {name: Place(name, USE, np.array(at), 0.0, np.array(at)) for name, at in SPOTS.items()}
    found |= {name: Place(name, USE, np.zeros(3), 0.0, np.zeros(3)) for name in PROPS}
    for name, place in places.PLACES.items():
        at = np.array([place.x, place.y, plan.FLOOR_Z])
        target = np.array(place.seat or at)
        found[name] = Place(name, _use(name, place), at, place_yaw(place), target)
    return Places(found, dict.fromkeys(CLOSED), dict.fromkeys(plan.LAMPS))


PLACES = _places()
SEATS = tuple(name for name, place in PLACES.places.items() if place.use == SIT)


def leaf_yaw(acted: Acted, name: str, times: np.ndarray) -> np.ndarray:
    """Yaws (n,) of a leaf at times (n,), degrees."""
    return swung(acted.swings.get(name, ()), times, CLOSED[name])
