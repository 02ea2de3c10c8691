# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows of values at updates, of which a row is stored only where it differs from the one before.

The evidence of readings is stored so: for most updates of a day, it is that of the update before.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from .columns import BITS, Column


class Rows:
    """Rows of named values, one for each update.

    Attributes
    ----------
    updates
        The number of updates.
    starts
        The index (rows,) of the first update of each stored row, ascending.
    columns
        The values (rows,) of the stored rows, by name.
    """

    def __init__(self, types: Mapping[str, type]) -> None:
        self.updates = 0
        self.starts = Column(int)
        self.columns = {name: Column(of) for name, of in types.items()}
        # The bits of each value in the last row, for the comparison with the next one.
        self._last: dict[str, Any] = {}

    def extend(self, values: Mapping[str, Any], count: int) -> None:
        """Append the rows of `count` updates.

        `values` has an array or list (count,) for each column, or None for missing values.
        """
        if not count:
            return
        new = np.zeros(count, bool)
        new[0] = not self.updates
        found = {}
        for name, column in self.columns.items():
            # One number stands for all where they are missing.
            size = 1 if values[name] is None else count
            numbers = found[name] = column.as_numbers(values[name], size)
            bits = numbers.view(BITS[numbers.itemsize])
            new[0] |= self._last.get(name) != bits[0]
            if size > 1:
                new[1:] |= bits[1:] != bits[:-1]
            self._last[name] = bits[-1]
        which = np.flatnonzero(new)
        if len(which):
            self.starts.extend(which + self.updates)
            for name, column in self.columns.items():
                column.extend_numbers(np.broadcast_to(found[name], count)[which])
        self.updates += count

    def value(self, name: str, update: int) -> Any:
        """Return the value of a column at an update."""
        return self.columns[name][self.starts.until(update) - 1]

    def all_columns(self) -> list[Column]:
        """Return `starts`, and then all `columns`."""
        return [self.starts, *self.columns.values()]

    def __eq__(self, other: object) -> bool:
        """Return whether the rows of all updates are equal to the bit."""
        return (
            isinstance(other, Rows)
            and (self.updates, list(self.columns)) == (other.updates, list(other.columns))
            and self.all_columns() == other.all_columns()
        )
