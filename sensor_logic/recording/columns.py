# SPDX-License-Identifier: GPL-3.0-or-later
"""A column of a recording: values of one type in time order, compressed in memory.

In a day, a sensor at 10 Hz has 864,000 readings, most of them equal to the one before. Values are
compressed in chunks of equal size. A chunk is stored as runs of equal values, as a repeating
pattern (the tilts of a range scan), or as it is. A column can be read like a list, or as a whole by
numpy.
"""

from __future__ import annotations

import math
from array import array
from bisect import bisect_right
from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

CHUNK = 8192
# The length of the longest pattern that is tried.
LONGEST = 256
CODES = {bool: "b", int: "q", float: "d", str: "I"}
# Values are compared by their bits: a negative zero differs from zero, and a NaN equals itself.
BITS = {1: np.uint8, 4: np.uint32, 8: np.uint64}
# Floats represent all whole numbers up to this one exactly.
LARGEST = 2.0**53

Index = NDArray[np.int64]
Values = NDArray[Any]


class EvenSpacing(NamedTuple):
    """A grid of numbers: `offset` + m × `spacing` for all integers m."""

    offset: int
    spacing: Fraction

    def values(self, steps: Index) -> NDArray[np.float64]:
        """Return the numbers (n,) of the grid for the integers m in `steps` (n,)."""
        spacing = self.spacing
        return np.asarray(self.offset + steps * spacing.numerator / spacing.denominator)

    def steps(self, values: Values) -> Index | None:
        """Return the integer m of each value (n,); None if a value is not exactly on the grid."""
        nearest = np.rint((values - self.offset) / float(self.spacing))
        if not (np.abs(nearest) < LARGEST).all():
            return None
        found = nearest.astype(np.int64)
        return found if _same(self.values(found), values) else None


class _Packed(NamedTuple):
    """A compressed chunk of `size` values.

    Attributes
    ----------
    values
        A pattern to repeat, up to `size` values. If `lengths` are given: the values of runs.
    lengths
        The lengths of the runs.
    start
        The integer m of the first value, if the chunk is on an `EvenSpacing`. The unpacked numbers
        are then the differences between successive m.
    """

    size: int
    values: Values
    lengths: Values | None = None
    start: int | None = None

    def unpacked(self) -> Values:
        if self.lengths is not None:
            return np.repeat(self.values, self.lengths)
        return np.resize(self.values, self.size)


class Column(Sequence[Any]):
    """A sequence of values of one type (bool, int, float or str), compressed in memory.

    Booleans are stored as 0 and 1, texts as indices into `texts`. For a column of floats, `grid`
    can be the even spacing of most values.
    """

    def __init__(
        self, of: type, values: Iterable[Any] = (), grid: EvenSpacing | None = None
    ) -> None:
        self.type = of
        self._grid = grid
        self._code = CODES[of]
        self.texts: list[str] = []
        self._numbers_of: dict[str, int] = {}
        self._packed: list[_Packed] = []
        # The first number of each chunk, for `until`.
        self._firsts: list[Any] = []
        self._rest = array(self._code)
        # The number and the values of the last unpacked chunk: a cache that saves 4 µs a reading.
        self._known: tuple[int, Values] = (-1, np.empty(0))
        self.extend(values)

    def append(self, value: Any) -> None:
        """Append one value."""
        self._rest.append(self._number(value) if self.type is str else value)
        if len(self._rest) >= CHUNK:
            self._pack_full()

    def extend(self, values: Iterable[Any]) -> None:
        """Append all values of an array, list or other iterable."""
        if self.type is str:
            values = self._text_numbers(values)
        elif not isinstance(values, (np.ndarray, array, Column)):
            values = list(values)
        self.extend_numbers(np.asarray(values, np.dtype(self._code)))

    def extend_numbers(self, numbers: Values) -> None:
        """Append numbers (n,) of the column's own type; those of texts are from `as_numbers`."""
        for start in range(0, len(numbers), CHUNK):
            self._rest.frombytes(numbers[start : start + CHUNK].tobytes())
            if len(self._rest) >= CHUNK:
                self._pack_full()

    def as_numbers(self, values: Any, count: int) -> Values:
        """Return values (count,) of the column's type as numbers; a text as its index into `texts`.

        `values` is an array or list, in which a value that was not measured is None, or None if
        none was measured.
        """
        missing = {str: "", int: -1, bool: False}.get(self.type, math.nan)
        if values is None:
            values = [missing] * count if self.type is str else np.full(count, missing)
        elif isinstance(values, list):
            values = [missing if value is None else value for value in values]
        if self.type is str:
            return self._text_numbers(values)
        return np.asarray(values, np.dtype(self._code))

    def _text_numbers(self, texts: Iterable[str]) -> Values:
        """Return the index (n,) of each text into `texts`, to which new texts are added."""
        # Most texts repeat: looked up together they take half the time.
        all_texts = list(texts)
        for text in dict.fromkeys(all_texts):
            self._number(text)
        numbers = map(self._numbers_of.__getitem__, all_texts)
        return np.fromiter(numbers, np.uint32, len(all_texts))

    def _number(self, text: str) -> int:
        number = self._numbers_of.setdefault(text, len(self.texts))
        if number == len(self.texts):
            self.texts.append(text)
        return number

    def _pack_full(self) -> None:
        values = np.frombuffer(self._rest, self._code)[:CHUNK]
        self._firsts.append(values[0].item())
        self._packed.append(_packed_on(self._grid, values) or _packed(values))
        self._rest = self._rest[CHUNK:]

    def __len__(self) -> int:
        return len(self._packed) * CHUNK + len(self._rest)

    def __getitem__(self, index: Any) -> Any:
        if isinstance(index, slice):
            return [self[i] for i in range(*index.indices(len(self)))]
        if index < 0:
            index += len(self)
        number, within = divmod(index, CHUNK)
        if not 0 <= number <= len(self._packed):
            raise IndexError("no such reading")
        value = self._rest[within] if number == len(self._packed) else self._chunk(number)[within]
        return self._plain(value)

    def __iter__(self) -> Iterator[Any]:
        for _, values in self.parts():
            yield from values.tolist()

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Values:
        numbers = self.numbers()
        if self.type is str:
            numbers = np.array([*self.texts, ""], object)[numbers]
        return numbers if dtype is None else numbers.astype(dtype)

    def __eq__(self, other: object) -> bool:
        """Return whether all values are equal; numbers must be equal to the bit."""
        if isinstance(other, Column) and self.type is other.type and self.type is not str:
            return len(self) == len(other) and all(
                _same(a, b)
                for (_, a), (_, b) in zip(self._numbers(), other._numbers(), strict=True)
            )
        return list(self) == (list(other) if isinstance(other, Iterable) else other)

    @property
    def nbytes(self) -> int:
        """The memory of the values in bytes."""
        packed = sum(
            p.values.nbytes + (0 if p.lengths is None else p.lengths.nbytes) for p in self._packed
        )
        return packed + self._rest.itemsize * len(self._rest)

    def numbers(self) -> Values:
        """Return all values (n,) as numbers; a text is its index into `texts`."""
        parts = [values for _, values in self._numbers()]
        return np.concatenate([np.empty(0, self._code), *parts])

    def parts(self) -> Iterator[tuple[int, Values]]:
        """Yield the values chunk by chunk: the index of the chunk's first value, and the values."""
        names = np.array([*self.texts, ""], object)
        for start, numbers in self._numbers():
            yield start, names[numbers] if self.type is str else numbers

    def changes(self, begin: int = 0) -> NDArray[np.intp]:
        """Return the indices, from `begin` on, of the values that differ from the value before.

        Values are compared by their bits. The value at `begin` always counts as different.
        """
        found, last = [np.empty(0, np.intp)], None
        for start, numbers in self._numbers(begin // CHUNK):
            if start < begin:
                start, numbers = begin, numbers[begin - start :]
            bits = numbers.view(BITS[numbers.itemsize])
            if len(bits):
                if last is None or bits[0] != last:
                    found.append(np.array([start]))
                found.append(np.flatnonzero(bits[1:] != bits[:-1]) + start + 1)
                last = bits[-1]
        return np.concatenate(found)

    def until(self, value: float) -> int:
        """Return how many values are at most `value`, in a column of ascending numbers."""
        number = bisect_right(self._firsts, value) - 1
        if number < 0 and self._packed:
            return 0
        if len(self._rest) and self._rest[0] <= value:
            number = len(self._packed)
        if number in {-1, len(self._packed)}:
            return len(self._packed) * CHUNK + bisect_right(self._rest, value)
        return number * CHUNK + int(np.searchsorted(self._chunk(number), value, side="right"))

    def _numbers(self, first: int = 0) -> Iterator[tuple[int, Values]]:
        """Yield the numbers chunk by chunk, from chunk `first` on, as `parts` does."""
        for number in range(first, len(self._packed)):
            yield number * CHUNK, self._unpacked(number)
        if len(self._rest):
            # A copy: an array cannot grow while numpy views it.
            yield len(self._packed) * CHUNK, np.array(self._rest)

    def _chunk(self, number: int) -> Values:
        if self._known[0] != number:
            self._known = number, self._unpacked(number)
        return self._known[1]

    def _unpacked(self, number: int) -> Values:
        packed = self._packed[number]
        values = packed.unpacked()
        if packed.start is None:
            return values
        assert self._grid is not None
        return self._grid.values(np.cumsum(np.append(packed.start, values)))

    def _plain(self, number: Any) -> Any:
        if self.type is str:
            return self.texts[number]
        return number.item() if isinstance(number, np.generic) else number


def _same(one: Values, other: Values) -> bool:
    return one.tobytes() == other.tobytes()


def _packed_on(grid: EvenSpacing | None, values: Values) -> _Packed | None:
    """Compress values as differences of their integers m on the grid; None if not on the grid."""
    steps = grid.steps(values) if grid is not None else None
    if steps is None:
        return None
    packed = _packed(np.diff(steps))
    return packed._replace(start=int(steps[0]))


def _packed(values: Values) -> _Packed:
    count, size = len(values), values.itemsize
    bits = values.view(BITS[size])
    new = np.flatnonzero(bits[1:] != bits[:-1]) + 1
    if 2 * (len(new) + 1) * (size + 2) < count * size:
        starts = np.append(0, new)
        return _Packed(count, values[starts], np.diff(starts, append=count).astype(np.uint16))
    for period in (np.flatnonzero(bits[1:LONGEST] == bits[0]) + 1).tolist():
        if _same(bits[period:], bits[:-period]):
            return _Packed(count, values[:period].copy())
    return _Packed(count, values.copy())
