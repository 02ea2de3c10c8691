# SPDX-License-Identifier: GPL-3.0-or-later
"""The cases of a parametrised test that `make test` runs: a few representative ones."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pytest


def mostly_slow(cases: Iterable[Any], *kept: Any, tuples: bool = True) -> list[Any]:
    """Mark all cases but those in `kept` as slow, which leaves them to `make test-all`.

    A tuple has the values of several arguments, or of one where `tuples` is false. Where two such
    lists are combined, the cases stay whose values are kept in both.
    """
    cases = list(cases)
    missing = [case for case in kept if case not in cases]
    assert not missing, f"no such cases: {missing}"
    found = []
    for case in cases:
        values = case if tuples and isinstance(case, tuple) else (case,)
        found.append(case if case in kept else pytest.param(*values, marks=pytest.mark.slow))
    return found
