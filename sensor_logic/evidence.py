# SPDX-License-Identifier: GPL-3.0-or-later
"""Evidence: why a sensor read what it did.

A recording stores it for each update. The objects that decided a reading, each with its share, are
stored as a text.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .arrays import Index
from .model import Answers


class Cause(NamedTuple):
    """What caused the reading at an update.

    Attributes
    ----------
    objects
        The names of the objects that caused it, the most important first; empty if none did.
    part
        The part of the sensor that decided, such as "tilt 2, ray 17" or "gate 3"; empty if the
        sensor has no parts, or none decided.
    measure
        The quantity that decided, with its unit as in the names of fields, such as "range_m".
    before, after
        This quantity at the update before and at this update; NaN if it is not known.
    """

    objects: tuple[str, ...] = ()
    part: str = ""
    measure: str = ""
    before: float = math.nan
    after: float = math.nan


def measured_cause(track: Any, index: int, objects: Iterable[str], part: str = "") -> Cause:
    """Return the cause of update `index` of a `Track`; its quantity is the main field."""
    measure = track.reading_at(index).name
    before = track.columns[measure][index - 1] if index else math.nan
    after = track.columns[measure][index]
    return Cause(tuple(objects), part, measure, float(before), float(after))


def rows_text(rows: Iterable[Sequence[Any]]) -> str:
    """Return rows, each with an object's name and numbers, as a text; empty without rows."""
    found = [list(row) for row in rows]
    return json.dumps(found, ensure_ascii=False, separators=(",", ":")) if found else ""


def rows_of(text: str) -> tuple[tuple[Any, ...], ...]:
    """Return the rows that `rows_text` has written."""
    return tuple(map(tuple, json.loads(text or "[]")))


def names_hit(
    answers: Answers, ray: Index, hit: NDArray[np.bool_], name_of: Callable[[int], str]
) -> NDArray[np.object_]:
    """Return the name of the object that one ray hits at each of n updates; empty without a hit.

    Parameters
    ----------
    answers
        The answers to a query that casts rays, with a table of t answers.
    ray
        For each answer in the table, the number (t,) of the ray.
    hit
        Whether that ray hits anything (t,).
    name_of
        A function that returns the name of the solid with a number.
    """
    if answers.hits is None:
        return np.full(len(answers.rows), "", object)
    table = answers.hits.table
    pairs = answers.rows * len(table) + answers.hits.rows
    found, where = np.unique(pairs, return_inverse=True)
    names = [
        name_of(int(table[hits].solids[ray[row]])) if hit[row] else ""
        for row, hits in (divmod(pair, len(table)) for pair in found.tolist())
    ]
    return np.array(names, object)[where]
