# SPDX-License-Identifier: GPL-3.0-or-later
"""Find the steps at which nothing that sensors read can change, so that a run skips them.

The times of changes come from keyframes and NLA strips. If anything else can change the scene with
time, no frame is skipped, and a text gives the reason. Examples are drivers that read the frame,
physics, simulation zones and movie textures.

Two other parts also save time. A temporary scene has only the moving objects (`MovingScene`). The
forces on pads are not computed again while nothing moves (`Pads`).
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
from ...sensor_logic.kind import CROSSINGS, FORCES, POSES, RAYS
from ...sensor_logic.model import Array, Index
from ..scene.animation import action_curves, all_animated, may_set, time_stretch
from ..scene.changes import SHADING
from ..scene.marks import LIGHT_MARK
from ..scene.rays.geometry import SURFACE_TYPES
from ..scene.surfaces import SURFACES
from ..scene.timed import is_timeless_driver
from ..scene.timed import reasons as timed_reasons
from . import state
from .probes import Probes
from .sensor_runner import PendingUpdates, Read, SensorRunner, SensorSteps

# Quantities that do not depend on datablocks of the types in SHADING, unless a driver reads one.
BLIND_TO_SHADING = {RAYS, CROSSINGS, FORCES, POSES} | {
    need for need, probe in SURFACES.items() if not probe.reads_shading
}
# Spans (n, 2) of time.
NEVER = np.empty((0, 2))
ALWAYS = np.array([[-np.inf, np.inf]])
# Interpolations of keyframes, as Blender numbers them.
CONSTANT, LINEAR, BEZIER = 0, 1, 2
# At a time nearer than 0.0001 to a keyframe, Blender evaluates the keyframe itself.
NEAR_A_KEY = 1e-3


@dataclass(frozen=True)
class Stillness:
    """The times at which the scene can change; at all others it stays the same.

    Attributes
    ----------
    busy
        The spans of time (n, 2) in which the scene can change, in frames of the F-curves. They are
        in order and do not overlap.
    reasons
        Texts on why no frame can be skipped; empty if frames can be skipped.
    stretch
        The number of frames of the F-curves in one frame of the scene (time stretching).
    timed
        Whether anything other than keyframes can make the scene differ between frames.
    """

    busy: Array
    reasons: tuple[str, ...] = ()
    stretch: float = 1.0
    timed: bool = False

    @property
    def why(self) -> str:
        """A text with the first reason and the number of further ones; empty without a reason."""
        more = len(self.reasons) - 1
        return "".join(self.reasons[:1]) + (f" (and {more} more)" if more > 0 else "")

    def fresh(self, frames: Any, subframes: Any = 0.0) -> np.typing.NDArray[np.bool_]:
        """Return whether the scene at each frame can differ from the scene one frame before, (n,).

        The times are `frames` (n,), ascending, plus `subframes` (n,) from 0 to 1. The first value
        is always true.
        """
        # Blender computes the time in single precision.
        times = np.asarray(frames, np.float32) + np.asarray(subframes, np.float32)
        times = (times * np.float32(self.stretch)).astype(np.float64)
        if self.reasons:
            return np.ones(len(times), bool)
        begun = np.searchsorted(self.busy[:, 0], times[1:])
        ended = np.searchsorted(self.busy[:, 1], times[:-1], side="right")
        return np.concatenate([[True], begun > ended])


def find_stillness(scene: Any, needs: Iterable[str], other_handlers: bool = False) -> Stillness:
    """Return the times at which the scene can change in a way that sensors read.

    `needs` are the quantities that the sensors read, such as RAYS. `other_handlers` says whether
    other code has frame handlers, which could change anything at any frame.
    """
    owners = [owner for owner in all_animated() if _is_evaluated(owner, scene)]
    shading = not BLIND_TO_SHADING.issuperset(needs) or any(
        isinstance(target.id, SHADING)
        for owner in owners
        for curve in _drivers(owner, shading=False)
        for target in _targets(curve.driver)
    )
    reasons = ["a script has added a frame change handler"] if other_handlers else []
    if state.are_driven():
        reasons.append("drivers read the outputs of sensors")
    reasons += [
        *_driver_reasons(owners, shading),
        *timed_reasons(scene, shading),
    ]
    parts, timed = [], bool(reasons)
    for owner in owners:
        spans = _busy_spans(owner, shading)
        if np.isinf(spans).any():
            reasons.append(
                f"'{owner.name}' has animation without an end (cycles or other "
                "modifiers, extrapolation)"
            )
        parts.append(spans)
    different = tuple(dict.fromkeys(reasons))
    return Stillness(_join_spans(parts), different, time_stretch(scene), timed)


def _is_evaluated(owner: Any, scene: Any) -> bool:
    if isinstance(owner, bpy.types.Scene):
        shown = scene
        while shown is not None and shown != owner:
            shown = shown.background_set
        return shown is not None
    return not isinstance(owner, bpy.types.CompositorNodeTree)


def _affects_sensors(owner: Any, curve: Any, shading: bool) -> bool:
    """Return whether an F-curve or driver of `owner` animates data that sensors can read.

    If sensors read shading (`shading`), every curve counts. Otherwise, curves of materials and
    other shading data count only if they animate the extension's own properties. Outputs of sensors
    never count, since `find_stillness` checks the drivers that read them.
    """
    if shading:
        return True
    if isinstance(owner, SHADING):
        return str(curve.data_path).startswith("angen_")
    return curve.data_path not in {state.ACTIVE_PATH, state.VALUE_PATH}


def _busy_spans(owner: Any, shading: bool) -> Array:
    """Return the spans (n, 2) in which keyframes and NLA strips can change a datablock."""
    animation = owner.animation_data
    found = action_curves(animation.action, getattr(animation, "action_slot", None))
    curves = [curve for curve in found if _affects_sensors(owner, curve, shading)]
    parts = [_curve_spans(curve) for curve in curves]
    tracks = animation.nla_tracks
    if len(tracks):
        # The action then acts as a strip, which may have no effect before and after its keys.
        playing = [s for track in tracks if track.is_solo or not track.mute for s in track.strips]
        parts += [_strip_spans(playing), *(_key_range(curve) for curve in found)]
    if animation.use_tweak_mode:
        parts.append(ALWAYS)
    return _join_spans(parts)


def _drivers(owner: Any, shading: bool) -> list[Any]:
    found = owner.animation_data.drivers
    return [c for c in found if not c.mute and _affects_sensors(owner, c, shading)]


def _targets(driver: Any) -> Iterator[Any]:
    return (target for variable in driver.variables for target in variable.targets)


def _driver_reasons(owners: Iterable[Any], shading: bool) -> Iterator[str]:
    for owner in owners:
        for curve in _drivers(owner, shading):
            driver = curve.driver
            if driver.type == "SCRIPTED" and not is_timeless_driver(driver):
                yield f"a driver of '{owner.name}' may follow the frame: {driver.expression}"
            if any("frame" in target.data_path for target in _targets(driver)):
                yield f"a driver of '{owner.name}' reads the frame number"


def _curve_spans(curve: Any) -> Array:
    """Return the spans (n, 2) in which the value of an F-curve can change."""
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
    """Return the spans (m, 2) in which the value of an F-curve with n keyframes can change.

    Parameters
    ----------
    keys
        The time and the value of each keyframe (n, 2).
    into, out_of
        The values of the handles at the end and at the start of each segment (n − 1,). A segment
        lies between two keyframes.
    kinds
        The interpolation of each segment (n − 1,), as Blender's integer.
    """
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
    """Return the spans (n, 2) of NLA strips, longer by one frame at both ends.

    Outside of its span, a strip holds its value or has no effect.
    """
    playing = [strip for strip in strips if not strip.mute]
    if any(s.use_animated_influence or s.use_animated_time or s.modifiers for s in playing):
        return ALWAYS
    ends = [[strip.frame_start - 1.0, strip.frame_end + 1.0] for strip in playing]
    return np.array(ends) if ends else NEVER


def _key_range(curve: Any) -> Array:
    """Return one span (1, 2) around all keyframes of an F-curve; shape (0, 2) without keyframes."""
    points = curve.keyframe_points
    if not len(points):
        return NEVER
    return np.array([[points[0].co[0] - 1.0, points[-1].co[0] + 1.0]])


def _join_spans(parts: Sequence[Array]) -> Array:
    """Return all spans (n, 2) in order, with overlapping ones joined."""
    spans = np.concatenate([NEVER, *parts])
    if not len(spans):
        return NEVER
    spans = spans[np.argsort(spans[:, 0], kind="stable")]
    reached = np.maximum.accumulate(spans[:, 1])
    first = np.flatnonzero(np.concatenate([[True], spans[1:, 0] > reached[:-1]]))
    return np.stack([spans[first, 0], reached[np.append(first[1:], len(spans)) - 1]], axis=1)


# A temporary scene that has only the moving objects: Blender evaluates its frames in half the time.
# If no object depends on the scene that it is in, the poses are exactly the same.

# Render settings of a scene that decide at what time each frame is.
TIME = ("fps", "fps_base", "frame_map_old", "frame_map_new")
# If fewer objects than this are at rest, a second scene saves no time.
LEAST_OBJECTS = 20


class MovingScene:
    """A temporary scene with only the moving objects, evaluated in place of the user's scene."""

    def __init__(self, scene: Any, objects: Sequence[Any]) -> None:
        self._scene = bpy.data.scenes.new(".angen_moving")
        self._scene[LIGHT_MARK] = True
        for name in TIME:
            setattr(self._scene.render, name, getattr(scene.render, name))
        for obj in objects:
            self._scene.collection.objects.link(obj)
        # The first evaluation updates every object, which handlers must not see as changes.
        handlers = list(bpy.app.handlers.frame_change_post)
        bpy.app.handlers.frame_change_post.clear()
        try:
            self.evaluate(scene.frame_current, 0.0)
        finally:
            bpy.app.handlers.frame_change_post.extend(handlers)

    def evaluate(self, frame: int, subframe: float) -> Any:
        """Evaluate the scene at a frame, and return its depsgraph."""
        self._scene.frame_set(frame, subframe=subframe)
        return self._scene.view_layers[0].depsgraph

    def close(self) -> None:
        """Remove the scene from the file."""
        # Undo, or another file, may have removed it.
        with suppress(ReferenceError):
            # Blender 4.3 without windows crashes where a scene is removed by itself.
            bpy.data.batch_remove([self._scene])


def moving_scene(
    scene: Any, runners: Sequence[SensorRunner], stored: set[str], still: Stillness, first: int
) -> MovingScene | None:
    """Return a scene with only the moving objects, for a run that begins at frame `first`.

    Return None if its readings could differ from readings in the user's scene, or if it would save
    little time. Light is always measured in the user's scene.

    Parameters
    ----------
    scene
        The user's scene.
    runners
        The runners of the sensors in the run.
    stored
        The quantities that can be queried later, since the run stores each frame.
    still
        The times at which the scene can change.
    first
        The first frame of the run.
    """
    keeping = [r for r in runners if set(r.sensor.kind.needs) <= stored]
    if not keeping or still.timed or not _can_move_alone(scene, keeping):
        return None
    moved = _find_moving(scene, first)
    view_layer = bpy.context.view_layer
    # Blender may not report an object that is hidden now and shown later.
    shown = [
        obj for obj in view_layer.objects if obj and (obj in moved or may_set(obj, "hide_viewport"))
    ]
    if len(view_layer.objects) - len(shown) < LEAST_OBJECTS or any(map(_depends_on_scene, shown)):
        return None
    return MovingScene(scene, [obj for obj in shown if obj.type in SURFACE_TYPES])


def _can_move_alone(scene: Any, keeping: Sequence[SensorRunner]) -> bool:
    """Return whether the moving objects would move in the same way in a scene of their own.

    Return false for physics, drivers, instances, objects in Edit Mode or animation of the scene
    itself. Also return false if the parameters or the pose of a sensor in `keeping` can change.
    """
    if scene.rigidbody_world or scene.render.use_simplify or scene.animation_data:
        return False
    if not all(runner.steady for runner in keeping):
        return False
    if any(len(owner.animation_data.drivers) for owner in all_animated()):
        return False
    return not any(obj.mode != "OBJECT" or obj.instance_type != "NONE" for obj in scene.objects)


def _depends_on_scene(obj: Any) -> bool:
    """Return whether an object may make instances, or look different in another scene.

    All metaballs of a scene join into one surface, so they depend on the scene.
    """
    return (
        obj.type == "META"
        or obj.is_instancer
        or any(modifier.type == "NODES" for modifier in obj.modifiers)
    )


def _find_moving(scene: Any, first: int) -> set[Any]:
    """Return the objects of a scene that can differ between frames.

    Blender reports all of them at any change of frame, so two changes near frame `first` suffice.
    """
    found: set[Any] = set()

    def note(changed: Any, depsgraph: Any) -> None:
        if changed == scene:
            ids = (update.id.original for update in depsgraph.updates)
            found.update(i for i in ids if isinstance(i, bpy.types.Object))

    # Blender also reports new and edited objects, but only once: evaluate before listening.
    scene.frame_set(first)
    bpy.app.handlers.frame_change_post.append(note)
    try:
        for frame in (first + 1, first):
            scene.frame_set(frame)
    finally:
        bpy.app.handlers.frame_change_post.remove(note)
    return found


# Pads in a run: forces are computed at frames at which something moves. At all other frames, the
# forces before stay valid.

# Identifies a state of the scene; frames between which nothing moves have the same state.
State = tuple[int, ...]


@dataclass
class _Pad:
    """A pad in a run. Frames between which nothing moves have the same `State` and forces.

    Attributes
    ----------
    states
        The state of the scene by step, for the last steps at which the motion was read.
    due
        The state that decides the forces, by the step of each whole frame with updates.
    needed
        The state of the scene, by each step at which forces are not computed yet.
    forces
        The computed forces by the state of the scene.
    waiting
        The updates whose forces are not computed yet: their steps, and the parameters and poses.
    """

    runner: SensorRunner
    states: dict[int, State] = field(default_factory=dict)
    due: dict[int, State] = field(default_factory=dict)
    needed: dict[int, State] = field(default_factory=dict)
    forces: dict[State, PadForces] = field(default_factory=dict)
    waiting: list[tuple[SensorSteps, list[Read | None]]] = field(default_factory=list)

    @property
    def size(self) -> int:
        return self.runner.clock.substeps

    def note_due(self, steps: Iterable[int]) -> None:
        """Register the steps of whole frames at which forces will be queried.

        If nothing moves from the frame before to the frame after, the step gets the state of the
        scene. Otherwise the step gets a new state.
        """
        for step in steps:
            near = [self.states.get(step + self.size * i) for i in (-1, 0, 1)]
            still = near[0] is not None and near[0] == near[1] == near[2]
            state = self.due[step] = (near[1] if still else None) or (step,)
            if state not in self.forces and state not in self.needed.values():
                self.needed[step] = state

    def ready(self) -> Iterator[tuple[SensorSteps, list[Read | None]]]:
        """Yield the steps, and the parameters and poses, of updates whose forces are computed."""
        waiting, self.waiting = self.waiting, []
        for sensor_steps, reads in waiting:
            known = [self.state_at(step) in self.forces for step in sensor_steps.steps.tolist()]
            count = known.index(False) if False in known else len(known)
            if count:
                yield sensor_steps.part(slice(count)), reads[:count]
            if count < len(known):
                rest = reads[count:] if len(reads) > 1 else reads
                self.waiting.append((sensor_steps.part(slice(count, None)), rest))

    def state_at(self, step: int) -> State | None:
        """Return the state that decides the forces at a step; None if the pad has no update."""
        return self.due.get(step - step % self.size)

    def known(self, sensor_steps: SensorSteps) -> dict[int, PadForces]:
        """Return the computed forces at the steps of updates, by the whole frame of each step."""
        clock, steps = self.runner.clock, sensor_steps.steps.tolist()
        found = {step: self.forces[self.due[step - step % self.size]] for step in steps}
        return {clock.frame_and_subframe(step)[0]: forces for step, forces in found.items()}

    def forget(self) -> None:
        """Remove the states and forces that no later update needs, except the last forces."""
        self.states = {step: self.states[step] for step in sorted(self.states)[-2:]}
        first = min(
            (sensor_steps.steps[0] for sensor_steps, _ in self.waiting),
            default=max(self.due, default=0),
        )
        self.due = {step: state for step, state in self.due.items() if step >= first - self.size}
        last = [*self.forces][-1:]
        needed = {*self.due.values(), *last}
        self.forces = {state: self.forces[state] for state in self.forces if state in needed}


class Pads:
    """All pads of a run, with their updates that wait until the probes have computed forces."""

    def __init__(self, runners: Sequence[SensorRunner], clock: Clock, probes: Probes) -> None:
        self._pads = {r: _Pad(r) for r in runners if r.sensor.kind.requires_forces}
        self._probes = probes
        self._clock = clock

    def wait(
        self, runner: SensorRunner, sensor_steps: SensorSteps, reads: list[Read | None]
    ) -> None:
        """Add updates of a pad, which wait for its forces.

        `reads` has the parameters and pose at each step, or a single entry for all steps.
        """
        self._pads[runner].waiting.append((sensor_steps, reads))

    def sense(
        self, steps: Index, frames: Index, due: dict[SensorRunner, Index], depsgraph: Any
    ) -> Iterator[PendingUpdates]:
        """Yield the updates of pads whose forces are known, since the next frame was evaluated.

        Parameters
        ----------
        steps
            The steps (n,) of whole frames at which the motion is to be read.
        frames
            The index (n,) of each step's frame among the stored frames.
        due
            For each pad, the steps of the whole frames with updates.
        depsgraph
            The evaluated depsgraph of the last frame.
        """
        needed = set(steps[-2:].tolist())
        syncs = self._probes.caster.solids.syncs
        states = {s: (syncs, f) for s, f in zip(steps.tolist(), frames.tolist(), strict=True)}
        for runner, pad in self._pads.items():
            pad.states |= states
            pad.note_due(due[runner].tolist())
            needed.update(step + pad.size * i for step in pad.needed for i in (-1, 0, 1))
        for step, frame in zip(steps.tolist(), frames.tolist(), strict=True):
            if step in needed:
                self._look(step, frame, depsgraph)
        self._probes.show(-1)
        for runner, pad in self._pads.items():
            for sensor_steps, reads in pad.ready():
                self._probes.known_forces = pad.known(sensor_steps)
                yield from runner.pending(
                    sensor_steps, sensor_steps.steps * 0, reads, depsgraph, self._probes
                )
                self._probes.known_forces = {}
            pad.forget()

    def _look(self, step: int, frame: int, depsgraph: Any) -> None:
        """Read how objects move at a step, and compute the needed forces at the frame before.

        `frame` is the index of the step's frame among the stored frames.
        """
        due = [pad.runner.sensor for pad in self._pads.values() if step in pad.needed]
        whole = self._clock.frame_and_subframe(step)[0]
        self._probes.show(frame)
        self._probes.look_at_motion(depsgraph, whole, due)
        for pad in self._pads.values():
            state = pad.needed.pop(step - self._clock.substeps, None)
            if state is not None:
                pad.forces[state] = self._probes.forces(pad.runner.uid, whole - 1)
