# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares a part's figures with their bounds. A missing figure, or NaN, breaks its bound."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class CheckedFigure:
    """A figure and its bound as texts, and whether the bound holds."""

    what: str
    figure: str
    bound: str
    holds: bool

    def __str__(self) -> str:
        return f"{self.what}: {self.figure}, must be {self.bound}"


@dataclass
class Bounds:
    """Collects figures that are compared with their bounds."""

    checked: list[CheckedFigure] = field(default_factory=list)

    def at_most(self, what: str, figure: Any, most: float) -> None:
        self._check(what, figure, f"at most {most:g}", _is_number(figure) and figure <= most)

    def at_least(self, what: str, figure: Any, least: float) -> None:
        self._check(what, figure, f"at least {least:g}", _is_number(figure) and figure >= least)

    def within(self, what: str, figure: Any, least: float, most: float) -> None:
        inside = _is_number(figure) and least <= figure <= most
        self._check(what, figure, f"{least:g} to {most:g}", inside)

    def equal(self, what: str, figure: Any, expected: Any) -> None:
        self._check(what, figure, f"{expected}", bool(figure == expected))

    def measured(self, what: str, found: Any, expected: Any) -> None:
        """Checks that `found` contains all of `expected`."""
        missing = [str(name) for name in expected if name not in list(found)]
        shown = f"{', '.join(missing)} missing" if missing else "all of it"
        self._check(what, shown, "measured", not missing)

    def missing(self, what: str) -> None:
        self._check(what, "missing", "measured", False)

    def _check(self, what: str, figure: Any, bound: str, holds: bool) -> None:
        if figure is None:
            shown = "not measured"
        else:
            shown = f"{figure:.4g}" if isinstance(figure, float) else f"{figure}"
        self.checked.append(CheckedFigure(what, shown, bound, holds))


def _is_number(figure: Any) -> bool:
    return isinstance(figure, int | float) and math.isfinite(figure)
