# SPDX-License-Identifier: GPL-3.0-or-later
"""Fixtures of tests that read our files with other programs.

`make readers` installs those programs and runs the tests; elsewhere the tests are skipped.
"""

from __future__ import annotations

import os
from importlib import import_module
from types import ModuleType

import pytest
from log_of_a_year import write


@pytest.fixture
def reader():
    """Import a reader's module; in `make readers`, a missing one is a failure."""

    def import_it(name: str) -> ModuleType:
        if os.environ.get("ANGEN_READERS"):
            return import_module(name)
        return pytest.importorskip(name, reason=f"{name}: make readers")

    return import_it


@pytest.fixture
def written(tmp_path):
    """Write a log in a format; return the path."""
    return lambda log, name, to="out": write(log, name, tmp_path / to)
