# SPDX-License-Identifier: GPL-3.0-or-later
"""Spellings of names for other formats, without duplicates."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable, Iterable


def unique(names: Iterable[str], spell: Callable[[str], str]) -> dict[str, str]:
    """Name → its spelling; of two equal spellings the one of the later name gets a number."""
    found: dict[str, str] = {}
    taken: set[str] = set()
    for name in sorted(set(names)):
        stem, number = spell(name), 1
        spelling = stem
        while spelling.casefold() in taken:
            number += 1
            spelling = f"{stem}_{number}"
        taken.add(spelling.casefold())
        found[name] = spelling
    return found


def slug(name: str) -> str:
    """Lower-case ASCII letters, digits and single underscores, a letter first: `pir_hall`."""
    plain = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode().lower()
    words = re.sub(r"[^a-z0-9]+", "_", plain).strip("_")
    return words if words[:1].isalpha() else f"sensor_{words}".rstrip("_")


def camel(name: str) -> str:
    """One word in camel case, of ASCII letters and digits: `PIR hall` → `PIRHall`."""
    plain = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode()
    words = re.findall(r"[A-Za-z0-9]+", plain)
    return "".join(word[0].upper() + word[1:] for word in words) or "Sensor"


def label(activity: str) -> str:
    """An activity as a CASAS label, one word: `Bed to toilet` → `Bed_to_toilet`."""
    return re.sub(r"\W+", "_", activity).strip("_") or "Activity"
