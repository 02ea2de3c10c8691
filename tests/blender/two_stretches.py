# SPDX-License-Identifier: GPL-3.0-or-later
"""Both stretches of a day that is cut once, for one process to live one and then the other."""

from __future__ import annotations

from typing import Any


def two_stretches(of: Any, cut: float) -> tuple[Any, Any, list[Any]]:
    """`of`: the module of stretches; `cut` in s since midnight. Last, where the states of the
    sensors at the cut come: as the first stretch ends and as the second begins."""
    states: list[Any] = []
    lasts: list[Any] = []

    def meets(_: int, state: Any) -> bool:
        states.append(state)
        return True

    first = of.DayStretch(0, (cut,), None, meets, None, lambda _, last: lasts.append(last))
    second = of.DayStretch(1, (cut,), states.append, None, lambda: lasts[0], None)
    return first, second, states
