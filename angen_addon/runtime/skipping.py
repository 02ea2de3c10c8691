# SPDX-License-Identifier: GPL-3.0-or-later
"""When nothing that sensors read can change, so that the scene need not be evaluated anew.

What keys and strips do is told from them. What else can change with time (drivers on the frame,
physics, simulation zones, films …), and what is not known here, keeps every frame from being
skipped, with the reason in words.

Beside it stand two ways to sense cheaply: a temporary scene of what moves (`MovingScene`), and pads
whose forces hold while nothing moves (`Pads`).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

import bpy
import numpy as np

from ...sensor_logic.clock import Clock
from ...sensor_logic.forces.world import PadForces
from ...sensor_logic.kind import CROSSINGS, FORCES, POSES, RAYS, WARMTH
from ...sensor_logic.model import Array, Index
from ..scene.animation import action_curves, all_animated, may_set, time_stretch
from ..scene.changes import SHADING
from ..scene.marks import LIGHT_MARK
from ..scene.rays.geometry import SURFACE_TYPES
from ..scene.timed import is_timeless_driver
from ..scene.timed import reasons as timed_reasons
from . import state
from .probes import Probes
from .sensor_runner import Dates, PendingUpdates, Read, SensorRunner

# What sensors need of the scene that do not notice SHADING, unless a driver does.
BLIND_TO_SHADING = {RAYS, WARMTH, CROSSINGS, FORCES, POSES}
# Spans (n, 2) of time.
NEVER = np.empty((0, 2))
ALWAYS = np.array([[-np.inf, np.inf]])
# Interpolations of keys, as Blender numbers them.
CONSTANT, LINEAR, BEZIER = 0, 1, 2
# Blender takes a time that is nearer than 0.0001 to a key for the key's own.
NEAR_A_KEY = 1e-3


@dataclass(frozen=True)
class Stillness:
    """`busy` (n, 2): spans of time in which something may change, in order and apart, as F-curves
    count time; `reasons`: why nothing can be skipped, in words; `stretch`: frames of theirs in one
    of the scene (Time Stretching); `timed`: whether anything but keys may follow the frame."""

    busy: Array
    reasons: tuple[str, ...] = ()
    stretch: float = 1.0
    timed: bool = False

    @property
    def why(self) -> str:
        """The first of the reasons, and how many more there are; empty where there is none."""
        more = len(self.reasons) - 1
        return "".join(self.reasons[:1]) + (f" (and {more} more)" if more > 0 else "")

    def fresh(self, frames: Any, subframes: Any = 0.0) -> np.typing.NDArray[np.bool_]:
        """Of moments (n,) in order, each a frame and a part of one: at which of them something may
        be otherwise than at the one before. The first is one of them."""
        # As Blender works the time out, in single precision.
        times = np.asarray(frames, np.float32) + np.asarray(subframes, np.float32)
        times = (times * np.float32(self.stretch)).astype(np.float64)
        if self.reasons:
            return np.ones(len(times), bool)
        begun = np.searchsorted(self.busy[:, 0], times[1:])
        ended = np.searchsorted(self.busy[:, 1], times[:-1], side="right")
        return np.concatenate([[True], begun > ended])


def find(scene: Any, needs: Iterable[str], others_act: bool = False) -> Stillness:
    """When nothing can change in a scene that is run, of what sensors read that have such `needs`;
    `others_act`: other code has handlers that may change anything at any frame."""
    owners = [owner for owner in all_animated() if _is_evaluated(owner, scene)]
    shading = not BLIND_TO_SHADING.issuperset(needs) or any(
        isinstance(target.id, SHADING)
        for owner in owners
        for curve in _drivers(owner, shading=False)
        for target in _targets(curve.driver)
    )
    reasons = ["other code acts at each frame (a frame handler)"] if others_act else []
    if state.are_driven():
        reasons.append("drivers read what sensors say")
    reasons += [
        *_of_drivers(owners, shading),
        *timed_reasons(scene, shading),
    ]
    parts, timed = [], bool(reasons)
    for owner in owners:
        spans = _spans_of(owner, shading)
        if np.isinf(spans).any():
            reasons.append(f"keys of '{owner.name}' go on without end (modifiers, extrapolation)")
        parts.append(spans)
    every = tuple(dict.fromkeys(reasons))
    return Stillness(_joined(parts), every, time_stretch(scene), timed)


def _is_evaluated(owner: Any, scene: Any) -> bool:
    if isinstance(owner, bpy.types.Scene):
        shown = scene
        while shown is not None and shown != owner:
            shown = shown.background_set
        return shown is not None
    return not isinstance(owner, bpy.types.CompositorNodeTree)


def _counts(owner: Any, curve: Any, shading: bool) -> bool:
    """Whether sensors can read what a curve or driver sets. How warm a material is, is not of its
    shading; what sensors say, nobody reads (see `outputs.are_driven`)."""
    if shading:
        return True
    if isinstance(owner, SHADING):
        return str(curve.data_path).startswith("angen_")
    return curve.data_path not in {state.ACTIVE_PATH, state.VALUE_PATH}


def _spans_of(owner: Any, shading: bool) -> Array:
    """Where keys and strips of a datablock may change something."""
    animation = owner.animation_data
    found = action_curves(animation.action, getattr(animation, "action_slot", None))
    curves = [curve for curve in found if _counts(owner, curve, shading)]
    parts = [_curve_spans(curve) for curve in curves]
    tracks = animation.nla_tracks
    if len(tracks):
        # The action is one of the strips then: it may have no effect before its keys and after.
        playing = [s for track in tracks if track.is_solo or not track.mute for s in track.strips]
        parts += [_strip_spans(playing), *(_reach(curve) for curve in found)]
    if animation.use_tweak_mode:
        parts.append(ALWAYS)
    return _joined(parts)


def _drivers(owner: Any, shading: bool) -> list[Any]:
    found = owner.animation_data.drivers
    return [c for c in found if not c.mute and _counts(owner, c, shading)]


def _targets(driver: Any) -> Iterator[Any]:
    return (target for variable in driver.variables for target in variable.targets)


def _of_drivers(owners: Iterable[Any], shading: bool) -> Iterator[str]:
    for owner in owners:
        for curve in _drivers(owner, shading):
            driver = curve.driver
            if driver.type == "SCRIPTED" and not is_timeless_driver(driver):
                yield f"a driver of '{owner.name}' may follow the frame: {driver.expression}"
            if any("frame" in target.data_path for target in _targets(driver)):
                yield f"a driver of '{owner.name}' reads a frame"


def _curve_spans(curve: Any) -> Array:
    """Spans (n, 2) in which an F-curve may change its value."""
    if curve.mute:
        return NEVER
    count = len(curve.keyframe_points)
    if any(not m.mute for m in curve.modifiers) or len(curve.sampled_points):
        return ALWAYS
    if count == 0:
        return NEVER
    if curve.extrapolation != "CONSTANT":
        return ALWAYS
    points = {
        name: np.empty((count, 2), np.float32) for name in ("co", "handle_left", "handle_right")
    }
    kinds = np.empty(count, np.int32)
    for name, values in points.items():
        curve.keyframe_points.foreach_get(name, values.ravel())
    curve.keyframe_points.foreach_get("interpolation", kinds)
    return _key_spans(
        points["co"], points["handle_left"][1:, 1], points["handle_right"][:-1, 1], kinds[:-1]
    )


def _key_spans(keys: Any, into: Any, out_of: Any, kinds: Any) -> Array:
    """Of keys (n, 2), with the heights (n − 1,) of the handles that end and begin each segment,
    and how it is interpolated."""
    times, values = keys[:, 0].astype(np.float64), keys[:, 1]
    lengths = np.diff(times)
    if not (np.isfinite(times).all() and (lengths >= 0.0).all()):
        return ALWAYS
    first, last = values[:-1], values[1:]
    level = (first == last) & (out_of == first) & (into == first)
    flat = (kinds == CONSTANT) | ((first == last) & (kinds == LINEAR)) | (level & (kinds == BEZIER))
    jumps = flat & (first != last)
    crowded = lengths < 2 * NEAR_A_KEY
    early = np.where(jumps | crowded, NEAR_A_KEY, 0.0)
    begins = np.where(flat & ~crowded, times[1:], times[:-1]) - early
    ends = times[1:] + np.where(crowded, NEAR_A_KEY, 0.0)
    return np.stack([begins, ends], axis=1)[~flat | jumps | crowded]


def _strip_spans(strips: Any) -> Array:
    """Spans of strips of the NLA, which hold what they end with, or nothing."""
    playing = [strip for strip in strips if not strip.mute]
    if any(s.use_animated_influence or s.use_animated_time or s.modifiers for s in playing):
        return ALWAYS
    ends = [[strip.frame_start - 1.0, strip.frame_end + 1.0] for strip in playing]
    return np.array(ends) if ends else NEVER


def _reach(curve: Any) -> Array:
    """A span around all keys of an F-curve: where an action that is one of several strips acts."""
    points = curve.keyframe_points
    if not len(points):
        return NEVER
    return np.array([[points[0].co[0] - 1.0, points[-1].co[0] + 1.0]])


def _joined(parts: Sequence[Array]) -> Array:
    """The same spans in order, without overlaps."""
    spans = np.concatenate([NEVER, *parts])
    if not len(spans):
        return NEVER
    spans = spans[np.argsort(spans[:, 0], kind="stable")]
    reached = np.maximum.accumulate(spans[:, 1])
    first = np.flatnonzero(np.concatenate([[True], spans[1:, 0] > reached[:-1]]))
    return np.stack([spans[first, 0], reached[np.append(first[1:], len(spans)) - 1]], axis=1)


# A passing scene of what moves alone: its frames take Blender half the time of the user's own, and
# are the same to the bit where nothing can look at the scene that it is in.

# Of the scene, what the time of its frames depends on.
TIME = ("fps", "fps_base", "frame_map_old", "frame_map_new")
# Less of the scene at rest is not worth a scene of its own.
LEAST_OBJECTS = 20


class MovingScene:
    """To be asked for a frame (`go`) in place of the user's scene, and to be closed."""

    def __init__(self, scene: Any, objects: Sequence[Any]) -> None:
        self._scene = bpy.data.scenes.new(".angen_moving")
        self._scene[LIGHT_MARK] = True
        for name in TIME:
            setattr(self._scene.render, name, getattr(scene.render, name))
        for obj in objects:
            self._scene.collection.objects.link(obj)
        # The first time all of it is new: nobody is to take that for what changes at a frame.
        heard = list(bpy.app.handlers.frame_change_post)
        bpy.app.handlers.frame_change_post.clear()
        try:
            self.go(scene.frame_current, 0.0)
        finally:
            bpy.app.handlers.frame_change_post.extend(heard)

    def go(self, frame: int, subframe: float) -> Any:
        """Evaluates it; returns its depsgraph."""
        self._scene.frame_set(frame, subframe=subframe)
        return self._scene.view_layers[0].depsgraph

    def close(self) -> None:
        """Removes it from the file."""
        # Undo, or another file, may have taken it away.
        with suppress(ReferenceError):
            # Blender 4.3 without windows crashes where a scene is removed by itself.
            bpy.data.batch_remove([self._scene])


def moving_scene(
    scene: Any, runners: Sequence[SensorRunner], kept: set[str], still: Stillness, first: int
) -> MovingScene | None:
    """One for a run that begins at frame `first`, and that keeps of frames what is `kept`; None
    where something in the scene may depend on more than what its objects hang on, or little is
    gained: light is asked of the scene itself."""
    keeping = [r for r in runners if set(r.sensor.kind.needs) <= kept]
    if not keeping or still.timed or not _stands_alone(scene, keeping):
        return None
    moved = _moved(scene, first)
    view_layer = bpy.context.view_layer
    # Blender may not name what is hidden at the time, although it comes later.
    shown = [
        obj for obj in view_layer.objects if obj and (obj in moved or may_set(obj, "hide_viewport"))
    ]
    if len(view_layer.objects) - len(shown) < LEAST_OBJECTS or any(map(_looks_around, shown)):
        return None
    return MovingScene(scene, [obj for obj in shown if obj.type in SURFACE_TYPES])


def _stands_alone(scene: Any, keeping: Sequence[SensorRunner]) -> bool:
    """Whether neither physics nor drivers, instances, visibility or moving sensors look at the
    whole scene."""
    if scene.rigidbody_world or scene.render.use_simplify or scene.animation_data:
        return False
    if not all(runner.steady for runner in keeping):
        return False
    if any(len(owner.animation_data.drivers) for owner in all_animated()):
        return False
    return not any(obj.mode != "OBJECT" or obj.instance_type != "NONE" for obj in scene.objects)


def _looks_around(obj: Any) -> bool:
    """Whether what is made of an object may hold instances, or depend on its scene: metaballs join
    with others there."""
    return (
        obj.type == "META"
        or obj.is_instancer
        or any(modifier.type == "NODES" for modifier in obj.modifiers)
    )


def _moved(scene: Any, first: int) -> set[Any]:
    """The objects that can change: Blender names all of them at any change of frame."""
    found: set[Any] = set()

    def note(changed: Any, depsgraph: Any) -> None:
        if changed == scene:
            ids = (update.id.original for update in depsgraph.updates)
            found.update(i for i in ids if isinstance(i, bpy.types.Object))

    # What is new or was edited is named too: that comes first.
    scene.frame_set(first)
    bpy.app.handlers.frame_change_post.append(note)
    try:
        for frame in (first + 1, first):
            scene.frame_set(frame)
    finally:
        bpy.app.handlers.frame_change_post.remove(note)
    return found


# Pads in a run: their forces are worked out at frames at which the scene moves, and hold at all
# others.

# What tells the scene at one frame from that at others.
State = tuple[int, ...]


@dataclass
class _Pad:
    """What is known of a pad, by whole frames as steps: the `states` of the scene at the last steps
    at which the motion was needed, what tells the forces at those at which it is due, and at which
    of these they are to be worked out (`asked`); the `forces` that are known; and the updates that
    wait for the frame after theirs."""

    runner: SensorRunner
    states: dict[int, State] = field(default_factory=dict)
    due: dict[int, State] = field(default_factory=dict)
    asked: dict[int, State] = field(default_factory=dict)
    forces: dict[State, PadForces] = field(default_factory=dict)
    waiting: list[tuple[Dates, list[Read | None]]] = field(default_factory=list)

    @property
    def size(self) -> int:
        """Steps in a frame."""
        return self.runner.clock.substeps

    def note_due(self, steps: Iterable[int]) -> None:
        """Takes down frames at which the forces will be asked for."""
        for step in steps:
            near = [self.states.get(step + self.size * i) for i in (-1, 0, 1)]
            still = near[0] is not None and near[0] == near[1] == near[2]
            state = self.due[step] = (near[1] if still else None) or (step,)
            if state not in self.forces and state not in self.asked.values():
                self.asked[step] = state

    def ready(self) -> Iterator[tuple[Dates, list[Read | None]]]:
        """The updates whose forces are known."""
        waiting, self.waiting = self.waiting, []
        for dates, reads in waiting:
            known = [self.state_at(step) in self.forces for step in dates.steps.tolist()]
            count = known.index(False) if False in known else len(known)
            if count:
                yield dates.part(slice(count)), reads[:count]
            if count < len(known):
                rest = reads[count:] if len(reads) > 1 else reads
                self.waiting.append((dates.part(slice(count, None)), rest))

    def state_at(self, step: int) -> State | None:
        return self.due.get(step - step % self.size)

    def known(self, dates: Dates) -> dict[int, PadForces]:
        """The forces at updates that are ready, by the frame."""
        clock, steps = self.runner.clock, dates.steps.tolist()
        found = {step: self.forces[self.due[step - step % self.size]] for step in steps}
        return {clock.frame_and_subframe(step)[0]: forces for step, forces in found.items()}

    def forget(self) -> None:
        """What is not needed for updates to come, but what held last."""
        self.states = {step: self.states[step] for step in sorted(self.states)[-2:]}
        first = min((dates.steps[0] for dates, _ in self.waiting), default=max(self.due, default=0))
        self.due = {step: state for step, state in self.due.items() if step >= first - self.size}
        last = [*self.forces][-1:]
        kept = {*self.due.values(), *last}
        self.forces = {state: self.forces[state] for state in self.forces if state in kept}


class Pads:
    """The pads among the sensors of a run, whose probes tell the forces."""

    def __init__(self, runners: Sequence[SensorRunner], clock: Clock, probes: Probes) -> None:
        self._pads = {r: _Pad(r) for r in runners if r.sensor.kind.requires_forces}
        self._probes = probes
        self._clock = clock

    def wait(self, runner: SensorRunner, dates: Dates, reads: list[Read | None]) -> None:
        """Updates to be sensed, with what was read of the pad at each."""
        self._pads[runner].waiting.append((dates, reads))

    def sense(
        self, steps: Index, frames: Index, due: dict[SensorRunner, Index], depsgraph: Any
    ) -> Iterator[PendingUpdates]:
        """The updates whose next frame has come. Of the `steps` (n,) at which the motion is needed,
        whole frames, `frames` (n,) tells which of those that the probes keep they are; at which of
        them pads are `due`."""
        needed = set(steps[-2:].tolist())
        syncs = self._probes.caster.solids.syncs
        states = {s: (syncs, f) for s, f in zip(steps.tolist(), frames.tolist(), strict=True)}
        for runner, pad in self._pads.items():
            pad.states |= states
            pad.note_due(due[runner].tolist())
            needed.update(step + pad.size * i for step in pad.asked for i in (-1, 0, 1))
        for step, frame in zip(steps.tolist(), frames.tolist(), strict=True):
            if step in needed:
                self._look(step, frame, depsgraph)
        self._probes.show(-1)
        for runner, pad in self._pads.items():
            for dates, reads in pad.ready():
                self._probes.known_forces = pad.known(dates)
                yield from runner.pending(dates, dates.steps * 0, reads, depsgraph, self._probes)
                self._probes.known_forces = {}
            pad.forget()

    def _look(self, step: int, frame: int, depsgraph: Any) -> None:
        """Looks at the motion at a step, and works out the forces at the frame before."""
        due = [pad.runner.sensor for pad in self._pads.values() if step in pad.asked]
        whole = self._clock.frame_and_subframe(step)[0]
        self._probes.show(frame)
        self._probes.look_at_motion(depsgraph, whole, due)
        for pad in self._pads.values():
            state = pad.asked.pop(step - self._clock.substeps, None)
            if state is not None:
                pad.forces[state] = self._probes.forces(pad.runner.uid, whole - 1)
