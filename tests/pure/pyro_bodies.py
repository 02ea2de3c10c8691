# SPDX-License-Identifier: GPL-3.0-or-later
"""Bodies in closed form that pass a pyroelectric detector, and its readings."""

import math

import numpy as np
from angen_sensors.sensor_logic.kind import WARMTH
from angen_sensors.sensor_logic.kinds.pir.pyroelectric import PyroelectricDetector
from angen_sensors.sensor_logic.kinds.pir.range_scan import PirParameters
from angen_sensors.sensor_logic.model import Emission, Pose, Update
from angen_sensors.sensor_logic.noise import generator

ZERO = 273.15
# The detector at (0, 0, height) faces world +Y, up is Z; one on a ceiling faces down.
LEVEL = np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])
DOWN = np.eye(3)


def level_at(height):
    return Pose(np.array([0.0, 0.0, height]), LEVEL)


class Body:
    """An upright box, sizes (3,) in m, whose feet are at a place; a plate is a thin one."""

    def __init__(self, size, celsius, emissivity=1.0):
        self.half = np.array(size) / 2
        self.kelvin, self.emissivity = celsius + ZERO, emissivity

    def seen(self, feet, ambient):
        def warmth(bundle, origins, directions, length):
            middle = np.array(feet) + (0, 0, self.half[2])
            with np.errstate(divide="ignore", invalid="ignore"):
                one = (middle - self.half - origins) / directions
                two = (middle + self.half - origins) / directions
            enter = np.fmax.reduce(np.fmin(one, two), axis=1)
            leave = np.fmin.reduce(np.fmax(one, two), axis=1)
            hit = (leave >= enter) & (leave > 0) & (enter < length)
            n = len(directions)
            return Emission(
                np.where(hit, self.kelvin, ambient + ZERO),
                np.where(hit, self.emissivity, np.ones(n)),
                ambient + ZERO,
            )

        return warmth


class FacingPlate:
    """An upright plate that always faces the detector, as in the note."""

    half = np.array([0.125, 0.0, 0.35])

    def __init__(self, celsius):
        self.kelvin = celsius + ZERO

    def seen(self, feet, ambient):
        def warmth(bundle, origins, directions, length):
            middle = np.array(feet) + (0, 0, self.half[2])
            away = middle - origins[0]
            facing = np.array([away[0], away[1], 0.0]) / math.hypot(away[0], away[1])
            right = np.array([facing[1], -facing[0], 0.0])
            ahead = directions @ facing
            with np.errstate(divide="ignore", invalid="ignore"):
                there = directions * ((away @ facing) / ahead)[:, None] - away
            hit = (ahead > 0) & (np.abs(there @ right) <= self.half[0])
            hit &= np.abs(there[:, 2]) <= self.half[2]
            kelvin = np.where(hit, self.kelvin, ambient + ZERO)
            return Emission(kelvin, np.ones(len(directions)), ambient + ZERO)

        return warmth


def updated(parameters, warmths, pose, rate):
    """Return readings at `rate` a second, one for each warmth.

    Parameters and pose may be functions of the update's number.
    """
    detector = PyroelectricDetector()

    def of(value, k):
        return value(k) if callable(value) else value

    return [
        detector.update(
            of(parameters, k),
            Update(k, k / rate, of(pose, k), {WARMTH: warmth}, lambda k=k: generator(0, "pir", k)),
        )
        for k, warmth in enumerate(warmths)
    ]


def sense(parameters, pose, body, places, rate, ambient=20.0):
    """Return readings at `rate` a second, with the body's feet at the places (n, 3) in turn."""
    return updated(parameters, [body.seen(feet, ambient) for feet in places], pose, rate)


def walk(start, end, speed, rate, before=2.0, after=3.0):
    """Return places on a straight line at a speed, with rest before and after."""
    start, end = np.array(start, float), np.array(end, float)
    seconds = np.linalg.norm(end - start) / speed
    share = np.clip(
        (np.arange(int((before + seconds + after) * rate)) / rate - before) / seconds, 0, 1
    )
    return start + (end - start) * share[:, None]


def peak(readings):
    return max(abs(r.fields["signal"]) for r in readings)


def pyro(**settings):
    fine = {"model": "PYROELECTRIC", "zone_rays": 24, "range_max": 5.0}
    return PirParameters(**{**fine, **settings})


PLATE = Body((0.25, 0.001, 0.7), 24.0)
PERSON = Body((0.45, 0.3, 1.7), 28.0, 0.95)


def crossing(distance, speed=1.0, body=PLATE, rate=50, ambient=20.0, up=0.0, **settings):
    """Return the peak, in thresholds, of a body that passes the detector.

    The detector is at the body's middle height, or `up` m below it.
    """
    reach = min(distance, 3.0)
    pose = level_at(body.half[2])
    places = walk((-reach, distance, up), (reach, distance, up), speed, rate, 0.2, 1.5)
    return peak(sense(pyro(**settings), pose, body, places, rate, ambient))
