# SPDX-License-Identifier: GPL-3.0-or-later
"""What a run in the window shows while it goes on, and how often Blender has its turn."""

import io
import itertools
import re
import types

import numpy as np
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.commands import home
from bl_ext.user_default.angen_sensors.angen_addon.runtime.simulation import Progress
from bl_ext.user_default.angen_sensors.operators import simulate


class Clock:
    """Stands for the computer's: work and redrawing take the time that a test says."""

    def __init__(self, monkeypatch, *modules):
        self.now = 100.0
        for module in modules:
            monkeypatch.setattr(module, "time", types.SimpleNamespace(perf_counter=self))

    def __call__(self):
        return self.now


@pytest.fixture
def parts(monkeypatch):
    """The clock, and the parts that a run in the window is made of."""
    clock = Clock(monkeypatch, simulate, home)
    return types.SimpleNamespace(
        clock=clock,
        operator=simulate.ANGEN_OT_simulate,
        slices=simulate.Slices,
        progress=home,
        Progress=Progress,
    )


class Window:
    """Stands for what the operator asks of a window: takes down the texts of the status bar."""

    def __init__(self):
        self.window_manager = self.workspace = self
        self.texts = []

    def progress_update(self, share):
        pass

    def status_text_set(self, text):
        self.texts.append(text)


def in_window(parts, steps, redraw):
    """Runs the operator's own `modal` over steps (seconds each takes) of a run; each time that it
    returns to Blender this redraws for so many seconds. The seconds in all, and the texts."""
    clock, total = parts.clock, float(len(steps))

    def run():
        for number, seconds in enumerate(steps):
            clock.now += seconds
            yield parts.Progress(float(number), total, number + 1.0)

    window, began = Window(), clock.now
    ended = []
    stub = types.SimpleNamespace(
        _run=run(), _slices=parts.slices(), _left=parts.progress.TimeLeft()
    )
    stub._advance = lambda: parts.operator._advance(stub)
    stub._stop = ended.append
    turns = []
    while not ended:
        parts.operator.modal(stub, window, types.SimpleNamespace(type="TIMER"))
        turns.append(clock.now)
        clock.now += redraw
    return clock.now - began, turns, window.texts


@pytest.mark.parametrize("redraw", [0.005, 0.05, 0.3])
def test_a_run_in_the_window_redraws_a_few_times_a_second_and_heeds_esc(parts, redraw):
    steps = [0.02] * 1000
    whole, turns, _ = in_window(parts, steps, redraw)
    work = sum(steps)
    assert len(turns) / whole <= 4.0
    assert whole <= work * (1.12 if redraw < 0.1 else 1.45), "it was 3 times as long and more"
    assert max(b - a for a, b in itertools.pairwise(turns)) <= 0.75 + 0.02 + redraw + 1e-6


def test_no_time_left_is_told_until_it_is_worth_something(parts):
    """As the home: pictures of the light at the start take long, what follows does not."""
    _, _, texts = in_window(parts, [5.0, 5.0, 5.0, *[0.1] * 1000], 0.05)
    told = [text.partition("%")[2] for text in texts if text]
    assert told[0] == ". Esc keeps what is done"
    lefts = [text for text in told if "left" in text]
    # It takes some 115 s in all; what the start alone says is an hour and more.
    assert "h" not in "".join(lefts).replace("what", "") and len(lefts) > len(told) / 2
    first = lefts[0]
    assert first in {f", about {n} min left. Esc keeps what is done" for n in (1, 2, 3)}
    assert lefts[-1].startswith(", about 5 s left")


def test_the_time_left_of_a_day_falls_though_most_of_it_is_rest(parts, addon_part, monkeypatch):
    """Movement from 6 to 9 and from 18 to 22 o'clock; 10 s of work an hour of it, none of rest."""
    progress = addon_part("residents.blender.command")
    clock = Clock(monkeypatch, progress)
    hours = 3600.0 * np.array([[6.0, 9.0], [18.0, 22.0]])
    acted = types.SimpleNamespace(spans=lambda first, last: np.clip(hours, first, last))
    stream = io.StringIO()
    monkeypatch.setattr(progress, "LOG_S", 0.0)
    kept = types.SimpleNamespace(has=lambda number: False)
    line = progress.DayLine(stream, False, 1, kept)
    real = []
    for hour in range(1, 25):
        clock.now += 10.0 if 6 < hour <= 9 or 18 < hour <= 22 else 0.0
        line.show(parts.Progress(3600.0 * hour, 86400.0, 1.0), acted)
        real.append(70.0 - (clock.now - 100.0))
    told = [re.search(r"about (\d+) (s|min) left", text) for text in stream.getvalue().splitlines()]
    assert [bool(one) for one in told] == [hour > 6 for hour in range(1, 25)]
    left = [int(one[1]) * (60 if one[2] == "min" else 1) for one in told if one]
    assert left == pytest.approx(real[6:])


def test_the_command_line_tells_the_same(parts):
    stream = io.StringIO()
    line = parts.progress.ProgressLine(stream, quiet=False)
    for number in range(1000):
        parts.clock.now += 12.0 if number == 0 else 0.1
        line.show(parts.Progress(float(number), 1000.0, number + 1.0))
    told = stream.getvalue().splitlines()
    assert "left" not in told[0] and told[0].startswith("frame 1, 0 %")
    assert told[-1].endswith("left") and "about" in told[-1]
