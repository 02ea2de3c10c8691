# SPDX-License-Identifier: GPL-3.0-or-later
"""The samples of a day: every update of one sensor, also the frames of arrays."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from datetime import date

import numpy as np

from ...sensor_logic.logs.log import COLUMN, format_value, rows_of, to_csv
from ...sensor_logic.recording.events import sampled_fields
from ...sensor_logic.recording.tracks import Track
from .truth import DAY_S


def samples_csv(track: Track, on: date, midnight: float) -> Iterator[str]:
    """Yield the samples of a sensor on one day as CSV, some thousand rows at a time.

    Parameters
    ----------
    track
        The readings of a run.
    on
        The date of the day. The first column is the local date and time, as in the event log.
    midnight
        The time in s of the run at which the day begins. Updates before it are left out.
    """
    fields = sampled_fields(track)
    yield to_csv((COLUMN, *(f.name for f in fields)), ())
    columns = [track.times, *(track.columns[f.name] for f in fields)]
    for parts in zip(*(column.parts() for column in columns), strict=True):
        times, *values = (part for _, part in parts)
        passed = np.rint((times - midnight) * 1000.0).astype(np.int64)
        in_day = (passed >= 0) & (passed < round(DAY_S * 1000.0))
        moments = np.datetime64(on, "ms") + passed[in_day].astype("timedelta64[ms]")
        shown: list[Iterable[str]] = [np.datetime_as_string(moments).tolist()]
        shown += [map(format_value, part[in_day].tolist()) for part in values]
        yield rows_of(zip(*shown, strict=True))
