# SPDX-License-Identifier: GPL-3.0-or-later
"""Which labels find a place beside their markers, where it is plain whose they are. Pixels."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

Point = tuple[float, float]
# Left, low, right, high.
Rect = tuple[float, float, float, float]

# A label stays this many times as far from other markers as from its own.
APART = 2.0
# Where labels may stand, from the marker: sideways, upwards, in the order they are tried.
SIDES = ((1, 0), (-1, 0), (1, 1), (1, -1), (-1, 1), (-1, -1), (0, 1), (0, -1))
DIAGONAL = 0.7


def arrange(
    markers: Sequence[Point],
    sizes: Sequence[Point],
    order: Iterable[int],
    wanted: frozenset[int],
    free: Rect,
    covered: Sequence[Rect],
    off: float,
) -> dict[int, Rect]:
    """Plates of `sizes` beside `markers`, `off` from them, by their number; of those in `order`
    the ones that fit. They lie in `free`, on nothing that is `covered`, on no other plate, and
    near no marker but their own. Those `wanted` come first and are shown wherever there is room.
    """
    placed: dict[int, Rect] = {}
    turns = list(order)
    for number in [n for n in turns if n in wanted] + [n for n in turns if n not in wanted]:
        taken = [*covered, *placed.values()]
        plates = _beside(markers[number], sizes[number], off)
        inside = [plate for plate in plates if _holds(free, plate)]
        fit = (p for p in inside if not any(_meet(p, other) for other in taken))
        if number in wanted:
            others: Sequence[Point] = ()
            least = [p for p in inside if not any(_meet(p, other) for other in covered)]
        else:
            others = [m for n, m in enumerate(markers) if n != number]
            least = []
        clear = [p for p in fit if not any(_near(p, m, APART * off) for m in others)]
        found = clear or least
        if found:
            placed[number] = min(found, key=lambda p: _crowd(p, markers, number, off))
    return placed


def _crowd(plate: Rect, markers: Sequence[Point], own: int, off: float) -> int:
    """The number of other markers near a plate."""
    return sum(n != own and _near(plate, m, APART * off) for n, m in enumerate(markers))


def _beside(marker: Point, size: Point, off: float) -> list[Rect]:
    (x, y), (width, height) = marker, size
    found = []
    for aside, up in SIDES:
        away = off * DIAGONAL if aside and up else off
        left = x - width / 2 if not aside else x + away if aside > 0 else x - away - width
        low = y - height / 2 if not up else y + away if up > 0 else y - away - height
        found.append((left, low, left + width, low + height))
    return found


def _holds(free: Rect, plate: Rect) -> bool:
    return (
        free[0] <= plate[0] and free[1] <= plate[1] and plate[2] <= free[2] and plate[3] <= free[3]
    )


def _meet(one: Rect, two: Rect) -> bool:
    return one[0] < two[2] and two[0] < one[2] and one[1] < two[3] and two[1] < one[3]


def _near(plate: Rect, point: Point, distance: float) -> bool:
    """Whether a point is less than a distance from a plate."""
    x = max(plate[0] - point[0], 0.0, point[0] - plate[2])
    y = max(plate[1] - point[1], 0.0, point[1] - plate[3])
    return x * x + y * y < distance * distance
