# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of missing files, and of names."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

from ...sensor_logic.kind import LIGHT
from ...sensor_logic.wording import capital
from ..advice import lacking
from .examined import Examined, Found


def lacks(home: Examined) -> Iterator[Found]:
    """Reports missing libraries and files, drivers that cannot run, sensors of unknown kinds."""
    for text, mend in lacking.lacks(home.view_layer, bool(home.requiring(LIGHT))):
        yield capital(text), capital(mend)


def same_names(home: Examined) -> Iterator[Found]:
    """Reports sensors of the same name, which a log cannot tell apart."""
    for name, count in Counter(sensor.name for sensor in home.sensors).items():
        if count > 1:
            files = [s.library or "this file" for s in home.sensors if s.name == name]
            yield (
                f"{count} sensors are called '{name}' (from {', '.join(files)})",
                "Rename one (F2), so that the log can tell them apart",
                (name,),
            )
