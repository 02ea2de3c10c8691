# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the sun stands at a time and place on Earth, and how much light it and the sky give.

Position: the Astronomical Almanac's low-precision formulas as Michalsky gives them (Solar Energy
40, 1988, p. 227), 0.01° from 1950 to 2050, and refraction after Saemundsson (Sky and Telescope 72,
1986, p. 70). Light, relative to that at another altitude: of the sun behind the clear air of
Kasten and Young's air mass (Applied Optics 28, 1989, p. 4735) by Meinel's 0.7^(m^0.678); of the
sky 300 + 21000 sin h lx (Krochmann and Seidl, Lighting Research and Technology 6, 1974, p. 165),
and in the twilight a straight line, in its logarithm, through the Explanatory Supplement's values.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from datetime import datetime, timedelta
from itertools import pairwise

J2000 = datetime(2000, 1, 1, 12)
DAY = timedelta(days=1)
# Altitude in degrees and lx of a clear sky without sun and moon.
TWILIGHT = ((-18.0, 6.5e-4), (-12.0, 8.3e-3), (-6.0, 3.4), (0.0, 300.0))
# The sun has set when its upper edge has: that is how far below the horizon its middle is then.
RADIUS = math.radians(0.267)


@dataclass(frozen=True)
class Site:
    """A place on Earth: `latitude` and `longitude` in rad, north and east positive; `utc_offset`,
    the hours by which its clocks are ahead of UTC; `north`, in rad, by which north is turned from
    the home's +Y, seen from above counter-clockwise."""

    latitude: float
    longitude: float
    utc_offset: float = 0.0
    north: float = 0.0


def position(site: Site, local: datetime) -> tuple[float, float]:
    """Altitude (with refraction) and azimuth from north over east, in rad, when a clock at the site
    shows `local`."""
    days = (local - timedelta(hours=site.utc_offset) - J2000) / DAY
    mean = math.radians((280.460 + 0.9856474 * days) % 360.0)
    anomaly = math.radians((357.528 + 0.9856003 * days) % 360.0)
    along = mean + math.radians(1.915 * math.sin(anomaly) + 0.020 * math.sin(2 * anomaly))
    tilt = math.radians(23.439 - 4e-7 * days)
    ascension = math.atan2(math.cos(tilt) * math.sin(along), math.cos(along))
    declination = math.asin(math.sin(tilt) * math.sin(along))
    sidereal = math.radians((280.46062 + 360.98564737 * days) % 360.0) + site.longitude
    hour = sidereal - ascension
    sin_lat, cos_lat = math.sin(site.latitude), math.cos(site.latitude)
    east = -math.cos(declination) * math.sin(hour)
    north = cos_lat * math.sin(declination) - sin_lat * math.cos(declination) * math.cos(hour)
    up = sin_lat * math.sin(declination) + cos_lat * math.cos(declination) * math.cos(hour)
    altitude = math.asin(max(-1.0, min(1.0, up)))
    return altitude + _refraction(altitude), math.atan2(east, north) % math.tau


def _refraction(altitude: float) -> float:
    """By how much air lifts what is at a true altitude, rad; nothing far below the horizon."""
    degrees = math.degrees(altitude)
    if degrees < -1.0:
        return 0.0
    minutes = 1.02 / math.tan(math.radians(degrees + 10.3 / (degrees + 5.11)))
    return math.radians(max(minutes, 0.0) / 60.0)


def direction(site: Site, altitude: float, azimuth: float) -> tuple[float, float, float]:
    """The unit vector to the sun in the home's own axes, z up."""
    bearing = math.pi / 2 + site.north - azimuth
    flat = math.cos(altitude)
    return flat * math.cos(bearing), flat * math.sin(bearing), math.sin(altitude)


def sunlight(altitude: float) -> float:
    """What a face turned to the sun gets, of what it would get without air; 0 once it has set."""
    if altitude <= -RADIUS:
        return 0.0
    degrees = max(math.degrees(altitude), 0.0)
    mass = 1.0 / (math.sin(math.radians(degrees)) + 0.50572 * (degrees + 6.07995) ** -1.6364)
    risen = min((altitude + RADIUS) / (2 * RADIUS), 1.0)
    return float(risen * 0.7 ** (mass**0.678))


def skylight(altitude: float) -> float:
    """Illuminance (lx) of the sky on a level face."""
    degrees = math.degrees(altitude)
    if degrees >= 0.0:
        return 300.0 + 21_000.0 * math.sin(altitude)
    for (below, dark), (above, light) in pairwise(TWILIGHT):
        if below <= degrees < above:
            return float(dark * (light / dark) ** ((degrees - below) / (above - below)))
    return TWILIGHT[0][1]
