# SPDX-License-Identifier: GPL-3.0-or-later
"""Choose sensors by name, pattern and kind."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from difflib import SequenceMatcher
from fnmatch import fnmatchcase

from .error import InputError
from .kinds import KINDS
from .wording import hint, listed

WILDCARDS = "*?["


def fitting(pattern: str, names: Iterable[str]) -> list[str]:
    """Return the name that equals `pattern`; if none does, all names that match it.

    A pattern can have wildcards, as in `PIR*`.
    """
    names = list(names)
    return [pattern] if pattern in names else [n for n in names if fnmatchcase(n, pattern)]


@dataclass(frozen=True)
class SensorChoice:
    """A choice of sensors by name and kind.

    Attributes
    ----------
    patterns
        The name of a chosen sensor equals or matches one of these. If empty, all names are chosen.
    kinds
        The kind of a chosen sensor is one of these. If empty, all kinds are chosen.
    light
        Whether light sensors can be chosen.
    """

    patterns: tuple[str, ...] = ()
    kinds: tuple[str, ...] = ()
    light: bool = True

    def takes(self, name: str, kind: str) -> bool:
        """Return whether a sensor with this name, of the kind with this identifier, is chosen."""
        by_name = not self.patterns or any(fitting(p, [name]) for p in self.patterns)
        by_kind = not self.kinds or kind in self.kinds
        return by_name and by_kind and (self.light or not measures_light(kind))

    def of(self, kinds: Mapping[str, str]) -> list[str]:
        """Return the names of the chosen sensors of a home.

        `kinds` maps the name of each sensor of the home to its kind. Raise InputError if a pattern
        matches no sensor, or if no sensor is chosen.
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
    """Return whether sensors of the kind with this identifier need rendered light."""
    return kind in KINDS and KINDS[kind].requires_light


def not_found(pattern: str, names: Iterable[str], of: str = "") -> str:
    """Return the error text for a pattern that no sensor matches.

    It includes the names that are most similar to the pattern. `of` says where the sensors are,
    such as " of this home".
    """
    text = pattern.strip("*?").lower()
    near = sorted(
        names, key=lambda name: SequenceMatcher(None, text, name.lower()).ratio(), reverse=True
    )
    is_pattern = any(sign in pattern for sign in WILDCARDS)
    what = "matches" if is_pattern else "is called"
    return f"no sensor{of} {what} '{pattern}'; {hint(text, near)}"
