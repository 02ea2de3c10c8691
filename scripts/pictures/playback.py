# SPDX-License-Identifier: GPL-3.0-or-later
r"""Measure what live readings and the overlay cost playback in a window.

blender --factory-startup --addons bl_ext.user_default.angen_sensors \
    sample_blends/angen.blend --python scripts/pictures/playback.py

The settings take turns: nothing shown, live readings, live readings drawn in the view, and both of
them with the sidebar open. Frames 900 to 1100 are played without a recording. Prints the median
over the rounds, in milliseconds per frame. *Own* is the processor time of the extension's own
Python: its handlers, draw functions, panels and gizmos. *Driver* is the time that these spend in
Blender's modules `gpu` and `blf`, which depends on the graphics driver. *Frame* is the clock's time
of a whole frame.

With PROFILE=FILE the profile of the own Python is written to this file, for the module `pstats`.
ROUNDS=N sets the number of rounds.
"""

from __future__ import annotations

import cProfile
import os
import statistics
import sys
import time
from collections.abc import Callable
from types import ModuleType
from typing import Any

import blf
import bpy
import gpu
from bl_ext.user_default import angen_sensors as extension
from bl_ext.user_default.angen_sensors.angen_addon.runtime import handlers
from bl_ext.user_default.angen_sensors.angen_addon.scene.sensors import all_sensors
from bl_ext.user_default.angen_sensors.angen_addon.view.overlay import draw
from bl_ext.user_default.angen_sensors.angen_addon.view.timeline import draw as timeline

# Frames of a round; the first few do not count, because the sensors start anew in them.
ROUNDS, FRAMES, FIRST = int(os.environ.get("ROUNDS", "5")), 40, 14
EXTENSION = f"{extension.__name__}."
METHODS = {
    *("poll", "draw", "draw_header", "draw_item", "filter_items"),
    *("draw_prepare", "refresh", "test_select"),
}
# Live readings, the overlay, and the sidebar.
SETTINGS = {
    "nothing": (False, False, False),
    "live": (True, False, False),
    "live and drawn": (True, True, False),
    "and sidebar": (True, True, True),
}
rounds_left = list(SETTINGS) * ROUNDS
current = "nothing"
frame = drawn = 0
began = 0.0
took: dict[str, list[list[float]]] = {name: [] for name in SETTINGS}
profile = cProfile.Profile(time.thread_time) if os.environ.get("PROFILE") else None


class Meter:
    """Seconds of processor time that the extension has spent, in all and in the driver."""

    def __init__(self) -> None:
        self.total = self.driver = 0.0
        self._depth = 0
        self._inside_driver = False

    def own(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """Return a function of the extension that adds its time to `total`."""

        def run(*args: Any, **named: Any) -> Any:
            self._depth += 1
            start = time.thread_time()
            if profile is not None and self._depth == 1:
                profile.enable()
            try:
                return function(*args, **named)
            finally:
                self._depth -= 1
                if self._depth == 0:
                    if profile is not None:
                        profile.disable()
                    self.total += time.thread_time() - start

        return run

    def outside(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """Return a function of Blender that adds its time to `driver`."""

        def run(*args: Any, **named: Any) -> Any:
            if self._inside_driver:
                return function(*args, **named)
            self._inside_driver = True
            start = time.thread_time()
            try:
                return function(*(getattr(a, "_measured", a) for a in args), **named)
            finally:
                self._inside_driver = False
                self.driver += time.thread_time() - start

        return run


meter = Meter()


class Measured:
    """An object of the module `gpu` whose methods count as the driver's time."""

    def __init__(self, one: Any) -> None:
        self._measured = one

    def __getattr__(self, name: str) -> Any:
        found = getattr(self._measured, name)
        found = meter.outside(found) if callable(found) else found
        setattr(self, name, found)
        return found


def _makes_measured(function: Callable[..., Any]) -> Callable[..., Any]:
    return lambda *args, **named: Measured(meter.outside(function)(*args, **_bare(named)))


def _bare(named: dict[str, Any]) -> dict[str, Any]:
    return {name: getattr(value, "_measured", value) for name, value in named.items()}


def measured_module(module: Any, objects: tuple[str, ...] = ()) -> ModuleType:
    """Return a module whose functions count as the driver's time.

    `objects` are the names of functions and classes that make an object with methods.
    """
    made = ModuleType(module.__name__)
    for name in dir(module):
        found = getattr(module, name)
        if name in objects:
            found = _makes_measured(found)
        elif isinstance(found, ModuleType):
            found = measured_module(found, objects)
        elif callable(found) and not isinstance(found, type):
            found = meter.outside(found)
        setattr(made, name, found)
    return made


def measure_the_extension() -> None:
    """Have the meter count the time of all that the extension does while frames are played."""
    bases = bpy.types.Panel, bpy.types.UIList, bpy.types.GizmoGroup, bpy.types.Gizmo
    subclasses = [found for base in bases for found in base.__subclasses__()]
    registered = [found for found in subclasses if found.__module__.startswith(EXTENSION)]
    sys.modules["blf"] = measured_module(blf)
    sys.modules["gpu"] = measured_module(gpu, ("from_builtin", "GPUBatch", "GPUVertBuf"))
    # Blender crashes if a method of a registered class is replaced.
    extension.unregister()
    for module, names in (
        (draw, ("draw_fields", "draw_labels")),
        (timeline, ("draw_window", "draw_channels")),
    ):
        for name in names:
            setattr(module, name, meter.own(getattr(module, name)))
    for found in registered:
        for owner in found.__mro__:
            if owner.__module__.startswith(EXTENSION):
                for name in vars(owner).keys() & METHODS:
                    _measure_method(owner, name)
    extension.register()
    for name in ("on_frame_change", "on_edit"):
        function = getattr(handlers, name)
        run = bpy.app.handlers.persistent(meter.own(function))
        setattr(handlers, name, run)
        # Live sensing takes a frame handler that it does not know for one that edits the scene.
        handlers.frame_handlers.add(run)
        for listed in (bpy.app.handlers.frame_change_post, bpy.app.handlers.depsgraph_update_post):
            if function in listed:
                listed[listed.index(function)] = run


def _measure_method(owner: Any, name: str) -> None:
    function = vars(owner)[name]
    plain = getattr(function, "__func__", function)
    # Blender registers only methods with the right number of parameters.
    names = ", ".join(plain.__code__.co_varnames[: plain.__code__.co_argcount])
    run = eval(f"lambda {names}: run({names})", {"run": meter.own(plain)})
    setattr(owner, name, classmethod(run) if isinstance(function, classmethod) else run)


def count() -> None:
    """Count a drawn frame, and end the round after `FRAMES` of them.

    This is no frame handler, because other handlers make live sensing assume that anything changed.
    """
    global frame, drawn, began
    if frame != bpy.context.scene.frame_current:
        frame = bpy.context.scene.frame_current
        drawn += 1
        if drawn == 0:
            began, meter.total, meter.driver = time.perf_counter(), 0.0, 0.0
        elif drawn == FRAMES:
            spent = meter.total - meter.driver, meter.driver, time.perf_counter() - began
            took[current].append([seconds / FRAMES * 1000 for seconds in spent])
            bpy.app.timers.register(next_round, first_interval=0.01)


def view_3d() -> Any:
    screen = bpy.context.window_manager.windows[0].screen
    return next(area for area in screen.areas if area.type == "VIEW_3D")


def start() -> None:
    scene = bpy.context.scene
    bpy.ops.angen.clear_recording()
    scene.sync_mode = "NONE"
    scene.use_preview_range = True
    scene.frame_preview_start, scene.frame_preview_end = 900, 1100
    measure_the_extension()
    bpy.types.SpaceView3D.draw_handler_add(count, (), "WINDOW", "POST_PIXEL")
    area = view_3d()
    window = bpy.context.window_manager.windows[0]
    with bpy.context.temp_override(window=window, area=area, region=area.regions[-1]):
        bpy.ops.screen.animation_play()
    bpy.app.timers.register(next_round, first_interval=2.0)


def next_round() -> None:
    """Begin the next round, or print the result after the last."""
    global current, drawn
    if rounds_left:
        current = rounds_left.pop(0)
        area, scene = view_3d(), bpy.context.scene
        scene.angen_live, scene.angen_overlay.show, sidebar = SETTINGS[current]
        area.spaces.active.show_region_ui = sidebar
        if sidebar:
            bpy.app.timers.register(_show_sensors_tab, first_interval=0.5)
        drawn = -FIRST
        return
    sensors = len(all_sensors(bpy.context.view_layer))
    print(f"{sensors} sensors, Blender {bpy.app.version_string}", flush=True)
    for name, rounds in took.items():
        own, driver, clock = (statistics.median(column) for column in zip(*rounds, strict=True))
        print(
            f"{name:15} own {own:5.2f} ms, driver {driver:5.2f} ms, frame {clock:6.1f} ms",
            "own by round:",
            " ".join(f"{row[0]:.1f}" for row in rounds),
            flush=True,
        )
    if profile is not None:
        profile.dump_stats(os.environ["PROFILE"])
    print("READY", flush=True)


def _show_sensors_tab() -> None:
    region = next(region for region in view_3d().regions if region.type == "UI")
    region.active_panel_category = "Sensors"
    region.tag_redraw()


bpy.app.timers.register(start, first_interval=3.0)
