# SPDX-License-Identifier: GPL-3.0-or-later
"""The progress of a run in the window, and how often Blender can redraw."""

import contextlib
import io
import itertools
import re
import types

import bpy
import numpy as np
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.appearance.panel_parts import draw_progress
from bl_ext.user_default.angen_sensors.angen_addon.commands import open_home as home
from bl_ext.user_default.angen_sensors.angen_addon.process import console
from bl_ext.user_default.angen_sensors.angen_addon.runtime.simulation import Progress
from bl_ext.user_default.angen_sensors.operators import long_work
from bl_ext.user_default.angen_sensors.sensor_logic import progress
from panel_layout import Layout


class Clock:
    """A clock in place of the computer's: work and redrawing take the time that a test sets."""

    def __init__(self, monkeypatch, *modules):
        self.now = 100.0
        for module in modules:
            monkeypatch.setattr(module, "time", types.SimpleNamespace(perf_counter=self))

    def __call__(self):
        return self.now


@pytest.fixture
def parts(monkeypatch):
    """Return the clock, and the modules of a run in the window."""
    clock = Clock(monkeypatch, long_work, progress, home, console)
    return types.SimpleNamespace(clock=clock, progress=home, Progress=Progress)


class Window:
    """The parts of a window that a modal operator uses; it records timers and texts."""

    def __init__(self):
        self.timers, self.shares = 0, []
        self.window = self.window_manager = self.workspace = self.screen = self
        self.areas, self.texts = (), []

    def progress_begin(self, low, high):
        self.shares.append("begin")

    def progress_update(self, share):
        self.shares.append(share)

    def progress_end(self):
        self.shares.append("end")

    def event_timer_add(self, seconds, window):
        self.timers += 1
        return object()

    def event_timer_remove(self, timer):
        self.timers -= 1

    def modal_handler_add(self, operator):
        pass

    def status_text_set(self, text):
        self.texts.append(text)


class Work(long_work.LongWork):
    """Long work defined by a test; it lists its results and reports."""

    bl_idname, bl_label = "angen.work", "Work"

    def __init__(self, begin):
        self._begin = lambda context: begin()
        self.results, self.told = [], []

    def _finish(self, context, result):
        self.results.append(result)

    def report(self, kind, text):
        self.told.append(text)


def event(kind):
    return types.SimpleNamespace(type=kind, value="PRESS")


def in_window(parts, steps, redraw):
    """Run steps (the seconds of each) in a window that redraws each time that the work yields.

    Returns the seconds in all, the times at which Blender could redraw, and the texts.
    """
    clock = parts.clock

    def run():
        for number, seconds in enumerate(steps):
            clock.now += seconds
            yield progress.Doing(number / len(steps), f"frame {number + 1}")
        return "done"

    window, began, work = Window(), clock.now, Work(run)
    work.invoke(window, event("NONE"))
    turns = []
    while not work.results:
        work.modal(window, event("TIMER"))
        turns.append(clock.now)
        clock.now += redraw
    return clock.now - began, turns, window.texts


def test_a_window_shows_progress_to_the_end(parts):
    closed = []

    def run():
        try:
            for i in range(4):
                parts.clock.now += 1.0
                yield progress.Doing(i / 4, f"part {i}")
            return "done"
        finally:
            closed.append(True)

    window, work = Window(), Work(run)
    assert work.invoke(window, event("NONE")) == {"RUNNING_MODAL"}
    assert work.modal(window, event("MOUSEMOVE")) == {"RUNNING_MODAL"}
    for _ in range(4):
        assert work.modal(window, event("TIMER")) == {"RUNNING_MODAL"}
    assert progress.working.share == 0.75
    assert work.modal(window, event("TIMER")) == {"FINISHED"}
    assert work.results == ["done"] and closed and progress.working is None
    assert window.timers == 0 and window.shares[-1] == "end"
    assert "75 %" in window.texts[-2] and "part 3. Esc cancels" in window.texts[-2]
    assert window.texts[-1] is None


def test_the_panel_finds_the_work_of_a_real_operator():
    class ANGEN_OT_test_work(long_work.LongWork, bpy.types.Operator):
        bl_idname, bl_label = "angen.test_work", "Work"

        def execute(self, context):
            self._left = progress.TimeLeft()
            self._show(Window(), progress.Doing(0.25, "part 1"))
            return {"FINISHED"}

    bpy.utils.register_class(ANGEN_OT_test_work)
    try:
        bpy.ops.angen.test_work()
        layout = Layout()
        assert draw_progress(layout, "angen.test_work") and not draw_progress(layout, "angen.other")
        assert layout.labels == ["25 %. Esc ends", "Part 1"]
    finally:
        progress.working = None
        bpy.utils.unregister_class(ANGEN_OT_test_work)


def test_work_ends_before_its_operator_is_unregistered(parts):
    """Else Python would end it later, amid other work, and remove a scene that Blender uses."""
    closed = []

    def run():
        try:
            while True:
                yield progress.Doing(0.5, "looking")
                parts.clock.now += 1.0
        finally:
            closed.append(True)

    window, work = Window(), Work(run)
    work.invoke(window, event("NONE"))
    work.modal(window, event("TIMER"))
    for _ in range(2):
        long_work.cancel_all(window)
    assert closed == [True] and progress.working is None
    assert window.timers == 0 and window.shares[-1] == "end" and window.texts[-1] is None


def test_escape_keeps_what_a_search_has(parts):
    def search():
        with contextlib.suppress(progress.Enough):
            while True:
                parts.clock.now += 1.0
                yield progress.Doing(0.5, "looking")
        return "best so far"

    window, work = Window(), Work(search)
    work.invoke(window, event("NONE"))
    work.modal(window, event("TIMER"))
    assert work.modal(window, event("ESC")) == {"FINISHED"}
    assert work.results == ["best so far"]
    assert window.timers == 0 and window.texts[-1] is None


def test_escape_gives_up_and_leaves_nothing(parts):
    def look():
        while True:
            parts.clock.now += 1.0
            yield progress.Doing(0.5, "looking")

    window, work = Window(), Work(look)
    work.invoke(window, event("NONE"))
    work.modal(window, event("TIMER"))
    assert work.modal(window, event("ESC")) == {"CANCELLED"}
    assert work.results == [] and work.told == ["Cancelled; nothing has changed"]
    assert window.timers == 0 and window.texts[-1] is None


@pytest.mark.parametrize("redraw", [0.005, 0.05, 0.3])
def test_a_run_in_the_window_redraws_a_few_times_a_second_and_heeds_esc(parts, redraw):
    steps = [0.02] * 1000
    whole, turns, _ = in_window(parts, steps, redraw)
    work = sum(steps)
    assert len(turns) / whole <= 4.0
    assert whole <= work * (1.12 if redraw < 0.1 else 1.45), "it was 3 times as long and more"
    assert max(b - a for a, b in itertools.pairwise(turns)) <= 0.75 + 0.02 + redraw + 1e-6


def test_no_time_left_is_told_until_it_is_worth_something(parts):
    """As in the home: pictures of the light at the start take long, later frames do not."""
    _, _, texts = in_window(parts, [5.0, 5.0, 5.0, *[0.1] * 1000], 0.05)
    told = [text.partition("%")[2] for text in texts if text]
    assert told[1] == ", frame 1. Esc cancels"
    lefts = [text for text in told if "left" in text]
    # It takes about 115 s in all; by the start alone it would be more than an hour.
    assert "h" not in "".join(lefts) and len(lefts) > len(told) / 2
    assert re.match(", about [123] min left, frame", lefts[0])
    assert lefts[-1].startswith(", about 5 s left")


def test_the_time_left_of_a_day_falls_though_most_of_it_is_rest(parts, addon_part, monkeypatch):
    """Movement from 6 to 9 and from 18 to 22 o'clock: 10 s of work per hour of it, none of rest."""
    days = addon_part("residents.blender.command")
    clock = Clock(monkeypatch, days)
    hours = 3600.0 * np.array([[6.0, 9.0], [18.0, 22.0]])
    acted = types.SimpleNamespace(spans=lambda first, last: np.clip(hours, first, last))
    stream = io.StringIO()
    monkeypatch.setattr(days, "LOG_S", 0.0)
    kept = types.SimpleNamespace(has=lambda number: False)
    line = days.DayLine(stream, False, 1, kept)
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
