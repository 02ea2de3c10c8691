# SPDX-License-Identifier: GPL-3.0-or-later
"""Run an operator's long work in short time slices, with progress, so that Esc can end it."""

from __future__ import annotations

import time
from typing import Any

import bpy
from bpy.types import Context, Event

from ..angen_addon.translations.interface import translated
from ..sensor_logic import progress
from ..sensor_logic.logs.error import AngenError
from ..sensor_logic.progress import Doing, Enough, TimeLeft, Work, finished
from .polls import cancelled

# s: bounds of a slice. Blender then redraws a few times a second, and reacts to Esc soon enough.
MIN_SLICE, MAX_SLICE = 0.25, 0.75
# s: a slow step of the work begins only if this much of the slice is left.
SLOW_STEP = 0.4
# A slice lasts this many times as long as the last redraw: redraws take a tenth of the time.
REDRAW_FACTOR = 9.0


class Slices:
    """Time slices for long work, which are longer the longer Blender's last redraw took."""

    def __init__(self) -> None:
        self._ended: float | None = None

    def begin(self) -> float:
        """Begin a slice, and return the time (`time.perf_counter`) at which it must end."""
        now = time.perf_counter()
        redraw = now - self._ended if self._ended is not None else 0.0
        return now + min(max(redraw * REDRAW_FACTOR, MIN_SLICE), MAX_SLICE)

    def end(self) -> None:
        """End a slice; call this when its work is done."""
        self._ended = time.perf_counter()


# The works that go on in windows.
_going_on: list[LongWork] = []


class LongWork:
    """Mix-in of operators whose work is a generator, of the type `Work`.

    In a script the work runs to its end at once. In a window it runs in time slices. Esc then
    throws the exception `Enough` into the generator.
    """

    # The status bar says what Esc does.
    esc = "Esc cancels"
    # What the operator has.
    bl_idname: str
    bl_label: str
    report: Any
    _run: Work[Any]
    _timer: Any = None
    _slices: Slices
    _left: TimeLeft
    _is_slow = False

    def _begin(self, context: Context) -> Work[Any]:
        """Return the work. Raise `AngenError` if it cannot begin."""
        raise NotImplementedError

    def _finish(self, context: Context, result: Any) -> set[str] | None:
        """Show the result, and return what `execute` will return; None means {"FINISHED"}.

        Raise `AngenError` if the work has failed.
        """
        raise NotImplementedError

    def execute(self, context: Context) -> set[str]:
        try:
            return self._finish(context, finished(self._begin(context))) or {"FINISHED"}
        except AngenError as error:
            return cancelled(self, error)

    def invoke(self, context: Context, event: Event) -> set[str]:
        if context.window is None:
            return self.execute(context)
        try:
            self._run = self._begin(context)
        except AngenError as error:
            return cancelled(self, error)
        self._slices, self._left = Slices(), TimeLeft()
        manager = context.window_manager
        manager.progress_begin(0, 100)
        self._timer = manager.event_timer_add(0.01, window=context.window)
        manager.modal_handler_add(self)
        _going_on.append(self)
        self._show(context, Doing(0.0, ""))
        return {"RUNNING_MODAL"}

    def modal(self, context: Context, event: Event) -> set[str]:
        if event.type not in {"ESC", "TIMER"}:
            # The scene must not change while the generator reads it.
            return {"RUNNING_MODAL"}
        try:
            try:
                doing = self._run.throw(Enough) if event.type == "ESC" else self._advance()
            except StopIteration as end:
                self._close(context)
                return self._finish(context, end.value) or {"FINISHED"}
            if doing is not None:
                self._show(context, doing)
            return {"RUNNING_MODAL"}
        except Enough:
            self._close(context)
            self.report({"INFO"}, translated("Cancelled; nothing has changed"))
            return {"CANCELLED"}
        except AngenError as error:
            self._close(context)
            return cancelled(self, error)
        except BaseException:
            self.cancel(context)
            raise

    def _advance(self) -> Doing | None:
        """Run the work for one time slice, and return its last news.

        Raise `StopIteration` with the result if the work ends.
        """
        until, last = self._slices.begin(), None
        while True:
            now = next(self._run)
            begins, needed = False, 0.0
            if now is not None:
                last = now
                self._left.note(now.share)
                # Of several slow steps only the first is shown when it begins: redraws take time.
                begins, self._is_slow = now.slow and not self._is_slow, now.slow
                needed = SLOW_STEP if now.slow else 0.0
            if begins or until - time.perf_counter() <= needed:
                self._slices.end()
                return last

    def _show(self, context: Context, doing: Doing) -> None:
        """Show the progress in the status bar, at the mouse pointer and in the sidebar."""
        share = 100.0 * doing.share
        context.window_manager.progress_update(share)
        far = ", ".join(filter(None, [f"{share:.0f} %", translated(self._left.text())]))
        how = ", ".join(filter(None, [far, translated(doing.text)]))
        label, esc = translated(self.bl_label), translated(self.esc)
        context.workspace.status_text_set(f"{label}: {how}. {esc}")
        # A running operator's own bl_idname reads ANGEN_OT_work, that of its class angen.work.
        idname = type(self).bl_idname
        progress.working = progress.Working(idname, doing.share, far, doing.text)
        for area in context.window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()

    def _close(self, context: Context) -> None:
        if self._timer is None:
            return
        _going_on.remove(self)
        self._run.close()
        progress.working = None
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.progress_end()
        self._timer = None
        if context.workspace is not None:
            context.workspace.status_text_set(None)

    def cancel(self, context: Context) -> None:
        """Clean up as `_close` does. Blender calls this when it ends the operator itself."""
        self._close(context)


def cancel_all(context: Context) -> None:
    """Cancel all works that go on, as Esc does.

    Blender frees an operator that it unregisters without its `cancel`. The generator of its work
    would go on to exist, and Python would close it at any later time.
    """
    for work in list(_going_on):
        work.cancel(context)
        # A context without a window has no workspace.
        for workspace in bpy.data.workspaces:
            workspace.status_text_set(None)


def register() -> None:
    """Do nothing: users begin works."""


def unregister() -> None:
    cancel_all(bpy.context)
