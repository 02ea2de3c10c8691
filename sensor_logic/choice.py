# SPDX-License-Identifier: GPL-3.0-or-later
"""Chooses sensors by name, pattern and kind."""

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
    """The name that is the pattern itself, or else all that fit it (`PIR*`)."""
    names = list(names)
    return [pattern] if pattern in names else [n for n in names if fnmatchcase(n, pattern)]


@dataclass(frozen=True)
class SensorChoice:
    """The sensors whose name is, or fits, one of the `patterns`, and that are of one of the
    `kinds`; all where these are empty. Without `light`, none that measures light."""

    patterns: tuple[str, ...] = ()
    kinds: tuple[str, ...] = ()
    light: bool = True

    def takes(self, name: str, kind: str) -> bool:
        """Whether it is one of them, by its name and its kind's identifier."""
        by_name = not self.patterns or any(fitting(p, [name]) for p in self.patterns)
        by_kind = not self.kinds or kind in self.kinds
        return by_name and by_kind and (self.light or not measures_light(kind))

    def of(self, kinds: Mapping[str, str]) -> list[str]:
        """The names of those that it takes from a home, whose kinds are by name. Raises
        InputError."""
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
            raise InputError(f"no sensor is left by what is asked for; there are {known}")
        return found


ALL_SENSORS = SensorChoice()


def measures_light(kind: str) -> bool:
    return kind in KINDS and KINDS[kind].requires_light


def not_found(pattern: str, names: Iterable[str], of: str = "") -> str:
    """The sentence that no sensor `of` a home has a name, or fits a pattern, and which are near."""
    text = pattern.strip("*?").lower()
    near = sorted(
        names, key=lambda name: SequenceMatcher(None, text, name.lower()).ratio(), reverse=True
    )
    is_pattern = any(sign in pattern for sign in WILDCARDS)
    what = "fits" if is_pattern else "is called"
    return f"no sensor{of} {what} '{pattern}'; {hint(text, near)}"
