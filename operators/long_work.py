# SPDX-License-Identifier: GPL-3.0-or-later
"""What operators share that work for long: in a window they show progress, and Esc ends them."""

from __future__ import annotations

import time
from collections.abc import Generator
from typing import Any

from bpy.types import Context, Event

from ..angen_addon.progress import Doing, Enough, TimeLeft
from ..angen_addon.runtime import state
from ..sensor_logic.error import AngenError
from .polls import cancelled

# s: a slice is so long that Blender redraws a few times a second, and short enough for Esc.
LEAST, MOST = 0.25, 0.75
# s: a slow step may last so long, which is then left of a slice.
SLOW = 0.4
# A slice lasts this many times as long as Blender's last redraw, which so costs a tenth.
TIMES = 9.0


class Slices:
    """Chooses the length of slices by the time of Blender's redraws: a step of a run may change the
    scene, so that each redraw evaluates and draws everything."""

    def __init__(self) -> None:
        self._ended: float | None = None

    def begin(self) -> float:
        """Begins a slice; returns its end by `time.perf_counter`."""
        now = time.perf_counter()
        away = now - self._ended if self._ended is not None else 0.0
        return now + min(max(away * TIMES, LEAST), MOST)

    def end(self) -> None:
        """Ends a slice, once its work is done."""
        self._ended = time.perf_counter()


class LongWork:
    """Mix-in of operators that run a generator, which yields Doing and last its result: at once, or
    in a window in slices. Esc throws Enough into the generator."""

    # What Esc does once the work has a result.
    esc = "cancels"
    _run: Generator[Any, None, None]
    _timer: Any = None
    _slices: Slices
    _left: TimeLeft
    _is_slow = False

    def _begin(self, context: Context) -> Generator[Any, None, None]:
        """Raises AngenError where the work cannot begin."""
        raise NotImplementedError

    def _finish(self, context: Context, result: Any) -> set[str] | None:
        """Shows the result; returns how the operator ends, if not FINISHED. Raises AngenError."""
        raise NotImplementedError

    def execute(self, context: Context) -> set[str]:
        try:
            result = None
            for result in self._begin(context):  # noqa: B007
                pass
            return self._finish(context, result) or {"FINISHED"}
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
        self._show(context, Doing(0.0, ""))
        return {"RUNNING_MODAL"}

    def modal(self, context: Context, event: Event) -> set[str]:
        if event.type not in {"ESC", "TIMER"}:
            # The scene must not change while the generator reads it.
            return {"RUNNING_MODAL"}
        try:
            result = self._run.throw(Enough) if event.type == "ESC" else self._advance()
            if isinstance(result, Doing):
                self._show(context, result)
                return {"RUNNING_MODAL"}
            self._close(context)
            return self._finish(context, result) or {"FINISHED"}
        except Enough:
            self._close(context)
            self.report({"INFO"}, "Cancelled; nothing has changed")  # type: ignore[attr-defined]
            return {"CANCELLED"}
        except AngenError as error:
            self._close(context)
            return cancelled(self, error)
        except BaseException:
            self.cancel(context)
            raise

    def _advance(self) -> Any:
        """Works for a slice of time; returns the last Doing, or the result."""
        until = self._slices.begin()
        result = None
        for result in self._run:
            if isinstance(result, Doing):
                self._left.note(result.share)
                # The first of several slow steps is shown at once: each redraw costs time.
                begins, self._is_slow = result.slow and not self._is_slow, result.slow
                left = until - time.perf_counter()
                if not begins and left > (SLOW if result.slow else 0.0):
                    continue
            break
        self._slices.end()
        return result

    def _show(self, context: Context, doing: Doing) -> None:
        share = 100.0 * doing.share
        context.window_manager.progress_update(share)
        far = ", ".join(filter(None, [f"{share:.0f} %", self._left.text()]))
        how = ", ".join(filter(None, [far, doing.text]))
        label = self.bl_label  # type: ignore[attr-defined]
        context.workspace.status_text_set(f"{label}: {how}. Esc {self.esc}")
        # Blender calls a running operator ANGEN_OT_work, its class angen.work.
        idname = type(self).bl_idname  # type: ignore[attr-defined]
        state.CACHE.working = idname, doing.share, f"{far}\n{doing.text}"
        for area in context.window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()

    def _close(self, context: Context) -> None:
        if self._timer is None:
            return
        self._run.close()
        state.CACHE.working = None
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.progress_end()
        self._timer = None
        if context.workspace is not None:
            context.workspace.status_text_set(None)

    def cancel(self, context: Context) -> None:
        """Blender calls this where it ends the operator itself."""
        self._close(context)
