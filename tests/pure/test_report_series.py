# SPDX-License-Identifier: GPL-3.0-or-later
"""Tracks in columns: every moment is told, however many there are."""

import numpy as np
import pytest
from angen_sensors.sensor_logic.recording.tracks import Track
from angen_sensors.sensor_logic.report import timeline
from angen_sensors.sensor_logic.report.facts import figures, quantity
from angen_sensors.sensor_logic.report.timeline import columns, runs
from hypothesis import given
from hypothesis import strategies as st


def switch(times: list[float], opened: list[bool]) -> Track:
    track = Track("door", "OPTICAL_SWITCH")
    track.frames.extend(1 + 24 * t for t in times)
    track.times.extend(times)
    track.active.extend(opened)
    track.value.extend([0.1] * len(times))
    track.columns["open"].extend(opened)
    track.columns["range_m"].extend([0.1] * len(times))
    return track


def pad(force: list[float], valid: list[bool]) -> Track:
    track = Track("pad", "PRESSURE")
    n = len(force)
    track.frames.extend(range(1, n + 1))
    track.times.extend(range(n))
    track.active.extend(f > 1 for f in force)
    track.value.extend(force)
    filled = {"force_n": force, "pressed": [f > 1 for f in force], "valid": valid}
    for name, column in track.columns.items():
        like = "" if isinstance(column, list) else 0
        column.extend(filled.get(name, [like] * n))
    return track


def test_shares_of_columns_are_exact() -> None:
    seen = columns(switch([0, 1, 2, 3], [False, True, False, True]), 1.0, 1 / 24, (0.0, 4.0), 8)
    np.testing.assert_allclose(seen.active, [0, 0, 1, 1, 0, 0, 1, 1])
    np.testing.assert_allclose(seen.known, 1.0)
    halves = columns(switch([0, 1, 2, 3], [False, True, True, True]), 1.0, 1 / 24, (0.0, 4.0), 2)
    np.testing.assert_allclose(halves.active, [0.5, 1.0])
    assert runs(halves.sometimes & ~halves.throughout) == [(0, 1)]


def test_a_short_event_of_a_long_day_is_seen_and_so_is_a_short_pause() -> None:
    times = np.arange(0, 86_400, 0.5)
    for quiet in (False, True):
        state = np.full(len(times), quiet)
        state[100_000] = not quiet
        seen = columns(switch(times.tolist(), state.tolist()), 0.5, 1 / 24, (0.0, 86_400.0), 1080)
        changed = runs(seen.sometimes & ~seen.throughout)
        assert changed == [(int(times[100_000] / 80), int(times[100_000] / 80) + 1)]


@given(
    opened=st.lists(st.booleans(), min_size=1, max_size=60),
    n=st.integers(1, 100),
    step=st.floats(0.05, 3.0),
)
def test_no_time_is_lost_or_made(opened: list[bool], n: int, step: float) -> None:
    times = [i * step for i in range(len(opened))]
    span = (0.0, len(opened) * step)
    seen = columns(switch(times, opened), step, 1e-3, span, n)
    width = span[1] / n
    assert (seen.active * seen.known).sum() * width == pytest.approx(sum(opened) * step, rel=1e-6)
    assert seen.known.sum() * width == pytest.approx(span[1], rel=1e-9)


def test_where_readings_stop_coming_nothing_is_known() -> None:
    """On for a second each: switched off from 3 to 7, and not yet on before 1."""
    seen = columns(switch([1, 2, 7, 8], [True] * 4), 1.0, 1 / 24, (0.0, 9.0), 9)
    np.testing.assert_allclose(seen.known, [0, 1, 1, 0, 0, 0, 0, 1, 1])
    assert not seen.sometimes[3:7].any()


def test_a_track_without_readings_is_nowhere_known() -> None:
    seen = columns(Track("door", "OPTICAL_SWITCH"), 1.0, 0.1, (0.0, 9.0), 9)
    assert not seen.known.any() and seen.quantity == ""


def test_the_envelope_holds_every_value() -> None:
    force = [0.0, 5.0, 700.0, 5.0, 5.0, -1.0, 5.0, 5.0]
    seen = columns(pad(force, [True] * 8), 1.0, 1 / 24, (0.0, 8.0), 2)
    np.testing.assert_allclose(seen.high, [700, 5])
    np.testing.assert_allclose(seen.low, [0, -1])
    np.testing.assert_allclose(seen.last, [5, 5])
    fine = columns(pad(force, [True] * 8), 1.0, 1 / 24, (0.0, 8.0), 16)
    np.testing.assert_allclose(fine.high, np.repeat(force, 2))
    np.testing.assert_allclose(fine.low, np.repeat(force, 2))


def test_invalid_readings_are_marked_and_are_not_the_greatest() -> None:
    track = pad([0.0, 900.0, 70.0, 0.0], [True, False, True, True])
    seen = columns(track, 1.0, 1 / 24, (0.0, 4.0), 4)
    np.testing.assert_allclose(seen.invalid, [0, 1, 0, 0])
    assert seen.top == 70.0
    told = figures(track)
    assert (told.greatest, told.unit, told.invalid) == (70.0, "N", 0.25)


def test_figures_count_changes_after_the_first_update() -> None:
    told = figures(switch([0, 1, 2, 3], [True, False, False, True]))
    assert (told.updates, told.events, told.first, told.last, told.active) == (4, 2, 1.0, 3.0, 0.5)
    assert told.greatest is None and quantity(switch([0], [True]))[0] == ""
    still = figures(switch([0, 1], [False, False]))
    assert (still.events, still.first, still.last) == (0, None, None)


@pytest.mark.parametrize(
    ("span", "labels"),
    [
        ((0.0, 171.7), ["0", "20", "40", "60", "80", "100", "120", "140", "160"]),
        ((0.0, 0.4), ["0", "0.05", "0.1", "0.15", "0.2", "0.25", "0.3", "0.35", "0.4"]),
        ((0.0, 1200.0), ["0:00", "5:00", "10:00", "15:00", "20:00"]),
        ((0.0, 86_400.0), [f"{h}:00" for h in range(0, 25, 3)]),
        ((0.0, 7 * 86_400.0), [str(d) for d in range(8)]),
    ],
)
def test_ticks_of_time_are_round(span: tuple[float, float], labels: list[str]) -> None:
    found = timeline.moments(*span, 9)
    assert [timeline.time_label(t, span[1] - span[0]) for t in found] == labels
