# SPDX-License-Identifier: GPL-3.0-or-later
"""The position of the sun, and the light of the sun and the sky.

Position: low-precision formulas of the Astronomical Almanac, as Michalsky gives them (Solar Energy
40, 1988, p. 227), to 0.01° from 1950 to 2050. Refraction: Saemundsson (Sky and Telescope 72, 1986,
p. 70). Light of the sun: 0.7^(m^0.678) by Meinel, with the air mass m by Kasten and Young (Applied
Optics 28, 1989, p. 4735). Light of the sky: 300 + 21000 sin h lx (Krochmann and Seidl, Lighting
Research and Technology 6, 1974, p. 165). In twilight: values of the Explanatory Supplement,
interpolated in their logarithm.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from datetime import datetime, timedelta
from itertools import pairwise

J2000 = datetime(2000, 1, 1, 12)
DAY = timedelta(days=1)
# Altitude of the sun in degrees, and illuminance of a clear moonless sky in lx.
TWILIGHT = ((-18.0, 6.5e-4), (-12.0, 8.3e-3), (-6.0, 3.4), (0.0, 300.0))
# Angular radius of the sun: it has set once its upper edge is below the horizon.
RADIUS = math.radians(0.267)


@dataclass(frozen=True)
class Site:
    """A place on Earth.

    Attributes
    ----------
    latitude, longitude : float
        North and east are positive, rad.
    utc_offset : float
        Positive if local clocks are ahead of UTC, h.
    north : float
        The angle from +y to north, counter-clockwise seen from above, rad.
    """

    latitude: float
    longitude: float
    utc_offset: float = 0.0
    north: float = 0.0


def position(site: Site, local: datetime) -> tuple[float, float]:
    """Return altitude and azimuth of the sun at a local time; the altitude includes refraction.

    Parameters
    ----------
    site : Site
        The place on Earth.
    local : datetime
        The time on a clock at the site.

    Returns
    -------
    altitude, azimuth : float
        In rad; the azimuth is counted from north over east.

    References
    ----------
    Michalsky, Solar Energy 40, 1988, p. 227.
    """
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
    """Return how far refraction lifts the sun, rad; 0 far below the horizon.

    `altitude` is the sun's altitude without refraction, rad.
    """
    degrees = math.degrees(altitude)
    if degrees < -1.0:
        return 0.0
    minutes = 1.02 / math.tan(math.radians(degrees + 10.3 / (degrees + 5.11)))
    return math.radians(max(minutes, 0.0) / 60.0)


def direction(site: Site, altitude: float, azimuth: float) -> tuple[float, float, float]:
    """Return the unit vector towards the sun in the home's axes, with z up.

    Parameters
    ----------
    site : Site
        The place on Earth.
    altitude, azimuth : float
        The position of the sun, rad.
    """
    bearing = math.pi / 2 + site.north - azimuth
    flat = math.cos(altitude)
    return flat * math.cos(bearing), flat * math.sin(bearing), math.sin(altitude)


def sunlight(altitude: float) -> float:
    """Return the transmittance of clear air for direct sunlight, which is 0 after sunset.

    Parameters
    ----------
    altitude : float
        The altitude of the sun, rad.

    References
    ----------
    Meinel; air mass by Kasten and Young, Applied Optics 28, 1989, p. 4735.
    """
    if altitude <= -RADIUS:
        return 0.0
    degrees = max(math.degrees(altitude), 0.0)
    mass = 1.0 / (math.sin(math.radians(degrees)) + 0.50572 * (degrees + 6.07995) ** -1.6364)
    risen = min((altitude + RADIUS) / (2 * RADIUS), 1.0)
    return float(risen * 0.7 ** (mass**0.678))


def skylight(altitude: float) -> float:
    """Return the illuminance of the sky on a horizontal surface, lx.

    Parameters
    ----------
    altitude : float
        The altitude of the sun, rad.

    References
    ----------
    Krochmann and Seidl, Lighting Research and Technology 6, 1974, p. 165.
    """
    degrees = math.degrees(altitude)
    if degrees >= 0.0:
        return 300.0 + 21_000.0 * math.sin(altitude)
    for (below, dark), (above, light) in pairwise(TWILIGHT):
        if below <= degrees < above:
            return float(dark * (light / dark) ** ((degrees - below) / (above - below)))
    return TWILIGHT[0][1]
