# SPDX-License-Identifier: GPL-3.0-or-later
"""What a part's figures are held to. A figure that is missing or no number breaks its bound."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Held:
    """One figure and its bound, in words, and whether it is within."""

    what: str
    figure: str
    bound: str
    holds: bool

    def __str__(self) -> str:
        return f"{self.what}: {self.figure}, must be {self.bound}"


@dataclass
class Bounds:
    """Collects figures as they are held to their bounds."""

    held: list[Held] = field(default_factory=list)

    def at_most(self, what: str, figure: Any, most: float) -> None:
        self._hold(what, figure, f"at most {most:g}", _is_number(figure) and figure <= most)

    def at_least(self, what: str, figure: Any, least: float) -> None:
        self._hold(what, figure, f"at least {least:g}", _is_number(figure) and figure >= least)

    def within(self, what: str, figure: Any, least: float, most: float) -> None:
        inside = _is_number(figure) and least <= figure <= most
        self._hold(what, figure, f"{least:g} to {most:g}", inside)

    def equal(self, what: str, figure: Any, expected: Any) -> None:
        self._hold(what, figure, f"{expected}", bool(figure == expected))

    def measured(self, what: str, found: Any, expected: Any) -> None:
        """All of `expected` must be among what was measured."""
        missing = [str(name) for name in expected if name not in list(found)]
        shown = f"{', '.join(missing)} missing" if missing else "all of it"
        self._hold(what, shown, "measured", not missing)

    def missing(self, what: str) -> None:
        self._hold(what, "missing", "measured", False)

    def _hold(self, what: str, figure: Any, bound: str, holds: bool) -> None:
        if figure is None:
            shown = "not measured"
        else:
            shown = f"{figure:.4g}" if isinstance(figure, float) else f"{figure}"
        self.held.append(Held(what, shown, bound, holds))


def _is_number(figure: Any) -> bool:
    return isinstance(figure, int | float) and math.isfinite(figure)
