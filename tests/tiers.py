# SPDX-License-Identifier: GPL-3.0-or-later
"""What `make test` runs of a parametrised test: a few representative cases."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pytest


def mostly_slow(cases: Iterable[Any], *kept: Any) -> list[Any]:
    """Mark all cases but those in `kept` as slow, which leaves them to `make test-all`.

    Where two such lists are combined, the cases stay whose values are kept in both.
    """
    cases = list(cases)
    missing = [case for case in kept if case not in cases]
    assert not missing, f"no such cases: {missing}"
    return [
        case
        if case in kept
        else pytest.param(*(case if isinstance(case, tuple) else (case,)), marks=pytest.mark.slow)
        for case in cases
    ]
