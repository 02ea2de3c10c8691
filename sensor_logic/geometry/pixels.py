# SPDX-License-Identifier: GPL-3.0-or-later
"""The rays of an array of pixels behind a lens, such as the zones of a distance sensor.

A plane perpendicular to the sensor's axis is divided into equal rectangles, one for each pixel. So
all pixels have the same step of the tangent, as behind a lens without distortion.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from ..model import Array, Index

# The table of a blurred sensitivity: its points, and how many standard deviations it goes beyond
# the edges.
QUANTILES, TAILS = 2001, 5.0


def pixel_directions(
    axes: Array,
    field_of_view: tuple[float, float],
    pixels: tuple[int, int],
    split: int,
    cells: tuple[Index, Index],
    blur: float = 0.0,
) -> Array:
    """Return unit directions (rows · columns · n, 3) of the rays of an array of pixels.

    The rays are in the order of their pixels, which are sorted by row from the upper left in the
    sensor's view.

    Parameters
    ----------
    axes
        The axes of the sensor as columns (3, 3). It looks along −z, and +y is up.
    field_of_view
        The horizontal and the vertical angle of all pixels together, in radians.
    pixels
        The numbers of columns and of rows.
    split
        Each pixel is divided into `split` × `split` equal cells. A ray goes through the centre of a
        cell.
    cells
        The columns (n,) and the rows (n,) of the cells of a pixel that have a ray.
    blur
        The standard deviation, in pixels, of a Gaussian with which the lens blurs the picture. The
        columns and rows of cells of a pixel are then as wide as its blurred sensitivity asks, so
        that all rays still have the same weight.
    """
    x = _cell_middles(field_of_view[0], pixels[0], split, blur)[:, cells[0]]
    y = -_cell_middles(field_of_view[1], pixels[1], split, blur)[:, cells[1]]
    through = np.stack(np.broadcast_arrays(x[None], y[:, None]), axis=-1).reshape(-1, 2)
    directions = np.column_stack([through, np.full(len(through), -1.0)]) @ axes.T
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    return directions


def pixel_corners(
    axes: Array, field_of_view: tuple[float, float], pixels: tuple[int, int]
) -> Array:
    """Return unit vectors along the four edges of each pixel, shape (rows · columns, 4, 3).

    The edges of a pixel are in circular order, from the upper left one. The parameters are those of
    `pixel_directions`.
    """
    across, up = pixels
    x = np.tan(field_of_view[0] / 2) * np.linspace(-1.0, 1.0, across + 1)
    y = -np.tan(field_of_view[1] / 2) * np.linspace(-1.0, 1.0, up + 1)
    column, row = np.arange(across * up) % across, np.arange(across * up) // across
    corners = [(column + a, row + b) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
    directions = np.stack([np.stack([x[a], y[b], np.full(len(a), -1.0)], 1) for a, b in corners], 1)
    world = directions @ axes.T
    found: Array = world / np.linalg.norm(world, axis=-1, keepdims=True)
    return found


def all_cells(split: int) -> tuple[Index, Index]:
    """Return the columns and rows of all cells of a pixel, row by row."""
    column = np.arange(split)
    return np.tile(column, split), np.repeat(column, split)


# Without the cache, 1024 rays take 60 ms.
@lru_cache(maxsize=16)
def lattice_cells(rays: int) -> tuple[Index, Index]:
    """Return the columns and rows of `rays` cells of a pixel that is split into `rays` × `rays`.

    Each column and each row has one of them, and they are as far apart as a lattice allows. An
    upright or level edge of an object then divides the pixel with an error of at most half a ray.
    In a grid of as many rays, the error is up to half a row of rays.

    References
    ----------
    H. Niederreiter, Random Number Generation and Quasi-Monte Carlo Methods (1992), chapter 5: good
    lattice points.
    """
    column = np.arange(rays)
    steps = np.array([step for step in range(1, rays + 1) if math.gcd(step, rays) == 1])
    # The distance of each cell from the first one, around the edges of the pixel.
    row = steps[:, None] * column[None, 1:] % rays
    apart = np.minimum(row, rays - row) ** 2 + np.minimum(column[1:], rays - column[1:]) ** 2
    step = int(steps[np.argmax(apart.min(axis=1, initial=rays**2))])
    return column, column * step % rays


def _cell_middles(angle: float, pixels: int, split: int, blur: float = 0.0) -> Array:
    """Return the coordinates (pixels, split) along one axis at which rays cross a plane.

    The plane is perpendicular to the sensor's axis, at distance 1.
    """
    cells = pixels * split
    middles = ((np.arange(cells) + 0.5) / cells * 2.0 - 1.0).reshape(pixels, split)
    if blur > 0.0:
        shares = (np.arange(split) + 0.5) / split
        middles = middles + (blurred_quantiles(shares, blur) - (shares - 0.5)) * (2.0 / pixels)
    return math.tan(angle / 2.0) * middles


def blurred_quantiles(shares: Array, blur: float) -> Array:
    """Return the places (n,) below which `shares` (n,) of a blurred sensitivity of width 1 lie.

    The sensitivity is even from −½ to ½, and blurred by a Gaussian whose standard deviation is
    `blur`. Its distribution is s·[h((x + ½)/s) − h((x − ½)/s)], with h(z) = z·Φ(z) + φ(z), Φ the
    normal distribution and φ its density. Quantiles are interpolated in a table of `QUANTILES`.
    """
    if blur == 0.0:
        return shares - 0.5
    place = np.linspace(-0.5 - TAILS * blur, 0.5 + TAILS * blur, QUANTILES)
    ends = (place + np.array([[0.5], [-0.5]])) / blur
    normal = np.array([0.5 * math.erfc(-z / math.sqrt(2.0)) for z in ends.ravel().tolist()])
    h = ends * normal.reshape(ends.shape) + np.exp(-(ends**2) / 2.0) / math.sqrt(2.0 * math.pi)
    found: Array = np.interp(shares, blur * (h[0] - h[1]), place)
    return found
