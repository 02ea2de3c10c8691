# SPDX-License-Identifier: GPL-3.0-or-later
"""Select sensors by name, wildcard pattern and kind."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from difflib import SequenceMatcher
from fnmatch import fnmatchcase

from .kinds import KINDS
from .logs.error import InputError
from .logs.wording import hint, listed

WILDCARDS = "*?["


def fitting(pattern: str, names: Iterable[str]) -> list[str]:
    """Return the name that equals `pattern`. If none does, return all names that match it.

    A pattern can have wildcards, as in `PIR*`.
    """
    names = list(names)
    return [pattern] if pattern in names else [n for n in names if fnmatchcase(n, pattern)]


@dataclass(frozen=True)
class SensorChoice:
    """A selection of sensors by name and kind.

    Attributes
    ----------
    patterns
        Names, or patterns with wildcards, of the selected sensors; empty selects all names.
    kinds
        The kinds of the selected sensors; empty selects all kinds.
    light
        Whether light sensors can be selected.
    """

    patterns: tuple[str, ...] = ()
    kinds: tuple[str, ...] = ()
    light: bool = True

    def takes(self, name: str, kind: str) -> bool:
        """Return whether a sensor with this name and kind is selected."""
        by_name = not self.patterns or any(fitting(p, [name]) for p in self.patterns)
        by_kind = not self.kinds or kind in self.kinds
        return by_name and by_kind and (self.light or not measures_light(kind))

    def of(self, kinds: Mapping[str, str]) -> list[str]:
        """Return the names of the selected sensors of a home.

        `kinds` maps the name of each sensor of the home to its kind. Raise InputError if a pattern
        matches no sensor, or if no sensor is selected.
        """
        for pattern in self.patterns:
            if not fitting(pattern, kinds):
                raise InputError(not_found(pattern, kinds))
        named = {n for pattern in self.patterns for n in fitting(pattern, kinds)}
        rest = SensorChoice((), self.kinds, self.light)
        found = [
            name
            for name, kind in kinds.items()
            if (name in named or not self.patterns) and rest.takes(name, kind)
        ]
        if kinds and not found:
            known = listed([f"{name} ({kind})" for name, kind in kinds.items()])
            raise InputError(f"no sensor matches all the given options; the sensors are {known}")
        return found


ALL_SENSORS = SensorChoice()


def measures_light(kind: str) -> bool:
    """Return whether sensors of a kind, given by its identifier, need rendered light."""
    return kind in KINDS and KINDS[kind].requires_light


def not_found(pattern: str, names: Iterable[str], of: str = "") -> str:
    """Return the error text for a pattern that no sensor matches, with the most similar names.

    `of` tells where the sensors were searched, such as " of this home".
    """
    text = pattern.strip("*?").lower()
    near = sorted(
        names, key=lambda name: SequenceMatcher(None, text, name.lower()).ratio(), reverse=True
    )
    is_pattern = any(sign in pattern for sign in WILDCARDS)
    what = "matches" if is_pattern else "is called"
    return f"no sensor{of} {what} '{pattern}'; {hint(text, near)}"
