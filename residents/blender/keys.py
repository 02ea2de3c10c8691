# SPDX-License-Identifier: GPL-3.0-or-later
"""Insert keyframes for a part of a day: for bodies, door leaves, lamps and carried objects.

By default, frame 1 is midnight, and a second has 10 frames. An object has keyframes only where it
moves. In between, and outside the part, its values are constant.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from contextlib import suppress
from math import ceil, floor, pi
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix, Quaternion, Vector
from numpy.typing import ArrayLike

from ...angen_addon.scene.instances import chain
from ...angen_addon.scene.light.scene import BEGINS, reference_frames
from ...angen_addon.scene.sensors import unit_scale
from ...angen_addon.scene.surfaces.warmth import heat_of
from ...sensor_logic.model import Array, Index
from ..acting.places import Places
from ..acting.timeline import Acted, Gesture, Hold, Timeline, openings_at
from ..body.pose import BodyPose
from ..body.poses import palm, upright
from ..body.solve import Bones, channels, solve
from ..body.turns import compose, ease, lerp, rotated, slerp
from ..days.rows import FPS
from .lamps import LampCopies, Power
from .person import body_of
from .settings import above, build_of, is_placed_by_others, straighten_bones

# Custom property of the actions with a day's keyframes, which copies of objects have too.
DAY_MARK = "angen_day"
# Values of Blender's enum of interpolations.
CONSTANT, LINEAR = 0, 1


class Curves:
    """The F-curves of a new action for a datablock.

    In Blender 4.2 this is a legacy action, without slots.
    """

    def __init__(self, owner: bpy.types.ID, name: str) -> None:
        action = bpy.data.actions.new(name)
        action[DAY_MARK] = True
        data = owner.animation_data_create()
        data.action = action
        self.curves: Any
        if hasattr(action, "slots"):
            slot = action.slots.new(owner.id_type, owner.name)
            strip = action.layers.new("Story").strips.new(type="KEYFRAME")
            self.curves = strip.channelbag(slot, ensure=True).fcurves
            data.action_slot = slot
        else:
            self.curves = action.fcurves
        self.action = action
        self.count = 0

    def write(
        self, path: str, index: int, frames: ArrayLike, values: ArrayLike,
        interpolation: ArrayLike = LINEAR,
    ) -> None:  # fmt: skip
        """Replace the keyframes of a curve.

        Parameters
        ----------
        path, index
            Data path and array index of the curve.
        frames
            The frames of the keyframes, strictly increasing, shape (n,).
        values
            The values, shape (n,).
        interpolation
            CONSTANT or LINEAR: one for all keyframes, or one for each, shape (n,).
        """
        at = np.stack([np.asarray(frames, np.float32), np.asarray(values, np.float32)], 1)
        curve = self.curves.find(path, index=index) or self.curves.new(path, index=index)
        points = curve.keyframe_points
        if len(points) != len(at):
            points.clear()
            points.add(len(at))
        points.foreach_set("co", at.ravel())
        points.foreach_set("interpolation", np.full(len(at), interpolation, np.int32))
        curve.update()
        self.count += len(at)


# rad: tilt of a thing from which a person drinks.
TILT = 1.45
# s in which a thing moves between the hand and the place where it is put.
_HANDOVER_S = 0.3


# Data path of whether an object is in use.
IN_USE = "angen_use.in_use"
# Data paths that keys change. rotation_mode is first, because setting it converts the rotation. A
# matrix would not restore every bit.
MOVED = ("rotation_mode", "location", "rotation_euler", "rotation_quaternion",
         "rotation_axis_angle", "scale", "hide_viewport", "hide_render", "energy",
         IN_USE)  # fmt: skip


def moved_values(part: Any, paths: Iterable[str] = MOVED) -> dict[str, Any]:
    """Return the values of a datablock or a bone at data paths, without paths that it lacks."""
    found = {}
    for path in paths:
        with suppress(ValueError):
            value = part.path_resolve(path)
            found[path] = value if isinstance(value, (bool, float, str)) else list(value)
    return found


def set_value(part: Any, path: str, value: Any) -> None:
    """Set the value at a data path; raise ValueError if there is no such path."""
    holder, _, name = path.rpartition(".")
    setattr(part.path_resolve(holder) if holder else part, name, value)


class ReplacedAnimation:
    """A datablock's animation that is replaced by a new action until `restore` is called."""

    def __init__(self, owner: Any) -> None:
        self.owner = owner
        data = owner.animation_data
        self._earlier = (data.action, getattr(data, "action_slot", None)) if data else None
        bones = owner.pose.bones if getattr(owner, "pose", None) else ()
        self._values = [(part, moved_values(part)) for part in (owner, *bones)]
        self.curves = Curves(owner, f"Day {owner.name}")

    def restore(self) -> None:
        """Restore the former action, and the property values that the new action has changed."""
        data, (action, slot) = self.owner.animation_data, self._earlier or (None, None)
        data.action = action
        if action is not None and slot is not None:
            data.action_slot = slot
        if self._earlier is None and not data.drivers:
            self.owner.animation_data_clear()
        for part, values in self._values:
            for path, value in values.items():
                set_value(part, path, value)
        bpy.data.actions.remove(self.curves.action)


class KeyedStretch:
    """Keyframes for one part of a day at a time, in place of the home's own animation.

    `clear` restores the home. Make it before the animation of the home is held.

    Parameters
    ----------
    residents
        The armature of each person.
    places
        The marked places, doors and lamps.
    fps
        The number of frames in a second.
    begins
        The time of frame 1, in s of the day.
    uses
        The names of the objects whose use has keyframes; None for all objects.
    """

    def __init__(
        self,
        residents: Mapping[str, Any],
        places: Places,
        fps: int = FPS,
        begins: float = 0.0,
        uses: Collection[str] | None = None,
    ) -> None:
        self._residents, self._places, self._uses = dict(residents), places, uses
        self._fps, self._begins = fps, begins
        self._replaced: dict[Any, ReplacedAnimation] = {}
        self._rest = {
            name: {b.name: np.array(b.matrix_local.to_quaternion()) for b in rig.data.bones}
            for name, rig in residents.items()
        }
        self._world: dict[str, Matrix] = {}
        # Before any keyframe: the scale of each walking frame, in Blender units.
        self._frame_scales = {
            name: _frame_scale(rig)
            for name, rig in residents.items()
            if rig.angen_resident.walking_frame is not None
        }
        self._powers: dict[str, list[Power]] = {}
        lamps = (bpy.data.objects.get(lamp.object) for lamp in places.lamps.values())
        self.copies = LampCopies(filter(None, lamps))

    def clear(self) -> None:
        for replaced in self._replaced.values():
            replaced.restore()
        self._replaced.clear()
        self.copies.give_back()
        self._powers.clear()

    def show(self, acted: Acted, start: float, end: float) -> None:
        """Insert keyframes for what the residents do from `start` to `end` (s of the day).

        Remove the keyframes of an earlier call. `acted` holds all motions of the day.
        """
        first, last = self._frame_at(start), self._frame_at(end)
        frames = np.arange(ceil(first - 1e-6), floor(last + 1e-6) + 1)
        scene = bpy.context.scene
        if BEGINS in scene:
            # Light references, which correct later readings, are measured at the start of the day
            # and of each part.
            frames = np.union1d(frames, reference_frames(scene, int(frames[0])))
        shown: dict[str, tuple[Array, BodyPose, Bones]] = {}
        for person, line in acted.bodies.items():
            if person in self._residents:
                shown[person] = self._show_body(person, line, frames)
        for name, swings in acted.swings.items():
            self._show_leaf(name, swings, frames)
        lamps: dict[str, list[tuple[float, bool]]] = {}
        for switch in acted.switches:
            lamps.setdefault(switch.object, []).append((switch.time, switch.on))
        for name, changes in lamps.items():
            self._show_lamp(name, changes, frames)
        for name, spans in acted.times_in_use().items():
            if self._uses is None or name in self._uses:
                self._show_use(name, spans, frames)
        for name, holds in acted.holds.items():
            self._show_carried(name, holds, acted.sips.get(name, ()), frames, shown)

    def _show_body(
        self, person: str, line: Timeline, frames: Index
    ) -> tuple[Array, BodyPose, Bones]:  # fmt: skip
        """Insert keyframes for a resident's armature and walking frame.

        Return the frames that have keyframes, the poses at these frames, and the bones of the
        poses.
        """
        rig = self._residents[person]
        at = self._moving_frames(frames, line.moving())
        pose = line.poses(self._seconds_at(at))
        bones = solve(pose)
        curves = self._curves(rig)
        metres = unit_scale(bpy.context.scene)
        straighten_bones(rig)
        found = list(channels(pose, self._rest[person], bones))
        place = np.stack([values for path, _, values in found if path == "location"], -1) / metres
        size = rig.scale.copy()
        if is_placed_by_others(rig):
            size = Vector([pose.build.scale / metres] * 3)
            self._write_local(rig, at, _upright_at(place, pose.heading, size), True)
            found = [one for one in found if one[0].startswith("pose.bones")]
        else:
            rig.rotation_mode = "XYZ"
            for axis in (0, 1):
                curves.write("rotation_euler", axis, at[:1], [0.0])
        for path, index, values in found:
            kept = _yaw_interpolation(values) if path == "rotation_euler" else LINEAR
            values = values / metres if path == "location" else values
            curves.write(path, index, at, values, kept)
        frame = rig.angen_resident.walking_frame
        if frame is not None and is_placed_by_others(frame):
            worlds = _upright_at(
                pose.walker[:, :3] / metres, pose.walker[:, 3], self._frame_scales[person]
            )
            over = None
            if rig in chain(frame.parent):
                # The resident moves what is parented to it.
                fixed = rig.matrix_world.inverted_safe() @ above(frame)
                over = [world @ fixed for world in _upright_at(place, pose.heading, size)]
            self._write_local(frame, at, worlds, True, over)
        elif frame is not None:
            curves = self._curves(frame)
            frame.rotation_mode = "XYZ"
            for axis in range(3):
                curves.write("location", axis, at, pose.walker[:, axis] / metres)
            yaw = pose.walker[:, 3]
            curves.write("rotation_euler", 2, at, yaw, _yaw_interpolation(yaw))
        for obj in (body_of(rig), frame):
            if obj is not None:
                self._show_or_hide(obj, line.away(), frames)
        return at, pose, bones

    def _show_or_hide(self, obj: Any, away: Array, frames: Index) -> None:
        """Hide an object from sensors, cameras and lamps while its person is away."""
        if obj not in self._replaced and not len(away):
            return
        seconds = self._seconds_at(frames)
        gone = np.zeros(len(frames), bool)
        for begins, ends in away:
            gone |= (seconds >= begins) & (seconds < ends)
        at = np.unique([0, *np.flatnonzero(np.diff(gone)) + 1])
        for path in ("hide_viewport", "hide_render"):
            self._curves(obj).write(path, 0, frames[at], gone[at], CONSTANT)

    def _show_leaf(self, name: str, swings: Any, frames: Index) -> None:
        obj, door = bpy.data.objects[name], self._places.doors[name]
        spans = np.array([(swing.start, swing.end) for swing in swings]).reshape(-1, 2)
        at = self._moving_frames(frames, spans)
        resting = swings[0].before if swings else 0.0
        openings = openings_at(swings, self._seconds_at(at), resting)
        before = self._world_of(obj)
        metres = unit_scale(bpy.context.scene)
        units, back = Matrix.Scale(1 / metres, 4), Matrix.Scale(metres, 4)
        moved = [units @ Matrix(door.moved(float(one)).tolist()) @ back @ before
                 for one in openings]  # fmt: skip
        self._write_local(obj, at, moved)

    def _show_lamp(self, name: str, changes: list[tuple[float, bool]], frames: Index) -> None:
        seconds = self._seconds_at(frames)
        on = np.full(len(frames), not changes[0][1])
        for time, state in changes:
            on[seconds >= time - 1e-6] = state
        at = np.unique([0, *np.flatnonzero(np.diff(on)) + 1])
        if name not in self._powers:
            self._powers[name] = self.copies.switchable_powers(bpy.data.objects[name])
        for owner, path, power in self._powers[name]:
            # The first key has the full power, also if the lamp stays off: Cycles samples lights
            # by the power that it finds there.
            keyed = np.r_[frames[0] - 1, frames[at]]
            values = np.r_[power, np.where(on[at], power, 0.0)]
            self._curves(owner).write(path, 0, keyed, values, CONSTANT)

    def _show_use(self, name: str, spans: Array, frames: Index) -> None:
        """Insert keyframes for whether an object is in use; `spans` are start and end of each."""
        obj, seconds = bpy.data.objects[name], self._seconds_at(frames)
        if obj.library is not None:
            return
        if heat_of(obj) is not None:
            # How warm it is depends on all its uses of the day so far.
            edges = np.ceil([self._frame_at(one) - 1e-6 for one in spans[spans < seconds[0]]])
            frames = np.unique(np.r_[edges.astype(frames.dtype), frames])
            seconds = self._seconds_at(frames)
        used = np.zeros(len(frames), bool)
        for start, end in spans:
            used |= (seconds >= start - 1e-6) & (seconds < end - 1e-6)
        at = np.unique([0, *np.flatnonzero(np.diff(used)) + 1])
        self._curves(obj).write(IN_USE, 0, frames[at], used[at], CONSTANT)

    def _show_carried(
        self, name: str, holds: list[Hold], sips: Sequence[Gesture], frames: Index,
        shown: Mapping[str, tuple[Array, BodyPose, Bones]],
    ) -> None:  # fmt: skip
        """Insert keyframes for an object that is carried, put down or drunk from.

        In a hand, the centre of its bounding box is in the palm. Put down, the middle of its
        underside is at the place.
        """
        obj = bpy.data.objects[name]
        before = self._world_of(obj)
        metres = unit_scale(bpy.context.scene)
        corners = np.array([before @ Matrix.Translation(c).translation for c in obj.bound_box])
        origin = np.array(before.translation)
        middle = (corners.min(0) + corners.max(0)) / 2
        under = np.array([*middle[:2], corners[:, 2].min()])
        turn = np.array(before.to_quaternion())
        spans = [(hold.start, hold.start + _HANDOVER_S) for hold in holds]
        at = self._moving_frames(frames, np.array(spans))
        at = np.unique(np.concatenate([at, *(keyed for keyed, _, _ in shown.values())]))
        seconds = self._seconds_at(at)
        tilt = sum((TILT * sip.weight(seconds) for sip in sips), 0.0 * seconds)
        where, how = np.tile(origin * metres, (len(at), 1)), np.tile(turn, (len(at), 1))
        for hold in holds:
            begun = np.flatnonzero(seconds >= hold.start - 1e-6)
            if not len(begun):
                continue
            share = ease((seconds[begun] - hold.start) / _HANDOVER_S)
            if hold.hand is None:
                point = under * metres if hold.at is None else hold.at
                new = np.tile((origin - under) * metres + point, (len(begun), 1))
                turns = np.tile(turn, (len(begun), 1))
            else:
                new, turns = _pose_in_hand(hold, at[begun], tilt[begun], shown[hold.person], turn,
                                           (origin - middle) * metres)  # fmt: skip
            where[begun], how[begun] = (
                lerp(where[begun], new, share), slerp(how[begun], turns, share),
            )  # fmt: skip
        placed = [
            Matrix.LocRotScale(w / metres, Quaternion(q), before.to_scale())
            for w, q in zip(where, how, strict=True)
        ]
        self._write_local(obj, at, placed)

    def _frame_at(self, time: float) -> float:
        return 1 + self._fps * (time - self._begins)

    def _seconds_at(self, frames: Array | Index) -> Array:
        return self._begins + (frames - 1) / self._fps

    def _moving_frames(self, frames: Index, spans: Array) -> Array:
        """Return the frames at which a moving object needs keyframes.

        Each movement has keyframes from the frame before to the frame after. The first and the last
        of `frames` have one, and so has the first one after a gap. `spans` (n, 2) are start and end
        of each movement, s.
        """
        keyed = np.zeros(len(frames), bool)
        keyed[[0, -1]] = True
        keyed[1:][np.diff(frames) > 1] = True
        for start, end in spans:
            # The body can jump at the start, for example when a person comes home.
            low, high = ceil(self._frame_at(start)) - 1, ceil(self._frame_at(end))
            keyed[slice(*np.searchsorted(frames, (low, high + 1)))] = True
        return np.asarray(frames[keyed], np.float64)

    def _curves(self, owner: Any) -> Curves:
        if owner not in self._replaced:
            self._replaced[owner] = ReplacedAnimation(owner)
        return self._replaced[owner].curves

    def _world_of(self, obj: Any) -> Matrix:
        """Return the world matrix that an object has in the file, before keyframes are inserted."""
        if obj.name not in self._world:
            self._world[obj.name] = obj.matrix_world.copy()
        return self._world[obj.name]

    def _write_local(
        self, obj: Any, at: Array, worlds: list[Matrix], scales: bool = False,
        parents: list[Matrix] | None = None,
    ) -> None:  # fmt: skip
        """Insert keyframes at frames `at` that give an object world matrices.

        Blender adds the delta transforms to the keyframes, and applies what the parent adds.

        Parameters
        ----------
        obj, at, worlds
            The object, the frames (n,) and the n matrices.
        scales
            Whether to key the scale too, which stays that of the first matrix.
        parents
            The n matrices that the parent adds; None if it does not move.
        """
        undone = [one.inverted_safe() for one in parents or [above(obj)] * len(worlds)]
        parts = [(back @ world).decompose() for back, world in zip(undone, worlds, strict=True)]
        spare = obj.delta_rotation_quaternion.inverted()
        turns = np.array([spare @ part[1] for part in parts])
        flips = np.sign((turns[1:] * turns[:-1]).sum(1))
        turns[1:] *= np.cumprod(np.where(flips < 0, -1.0, 1.0))[:, None]
        curves = self._curves(obj)
        obj.rotation_mode = "QUATERNION"
        places = np.array([part[0] - obj.delta_location for part in parts])
        for axis in range(3):
            curves.write("location", axis, at, places[:, axis])
        for axis in range(4):
            curves.write("rotation_quaternion", axis, at, turns[:, axis])
        for axis in range(3) if scales else ():
            kept = parts[0][2][axis] / (obj.delta_scale[axis] or 1.0)
            curves.write("scale", axis, at[:1], [kept])


def _upright_at(place: Array, yaw: Array, size: Vector) -> list[Matrix]:
    """Return the matrices of upright things at locations (n, 3), turned by `yaw` (n,) about z."""
    return [
        Matrix.LocRotScale(Vector(point), Quaternion((0.0, 0.0, 1.0), float(turn)), size)
        for point, turn in zip(place.tolist(), yaw, strict=True)
    ]


def _frame_scale(rig: Any) -> Vector:
    """Return the scale of a resident's walking frame in the world, in Blender units.

    It follows the resident: what scales both from above changes neither.
    """
    frame, metres = rig.angen_resident.walking_frame, unit_scale(bpy.context.scene)
    if not is_placed_by_others(frame):
        return frame.scale.copy()
    return frame.scale * (build_of(rig).scale / metres / rig.scale[2])


def _pose_in_hand(
    hold: Hold, at: Array, tilt: Array, shown: tuple[Array, BodyPose, Bones], turn: Array,
    offset: Array,
) -> tuple[Array, Array]:  # fmt: skip
    """Return location (n, 3) in metres and rotation (n, 4) of an object in a hand.

    The object turns with the heading of the body. It is tilted towards the face by `tilt` (n,),
    rad.
    """
    keyed, pose, bones = shown
    # Between two keyframes a body does not move.
    index = np.maximum(np.searchsorted(keyed, at, side="right") - 1, 0)
    carried = upright(pose.take(index), tilt)
    hand = palm(bones, hold.hand or 0, pose.build.scale)[index]
    return hand + rotated(carried, offset), compose(carried, turn)


def _yaw_interpolation(yaw: Array) -> Index:
    """Return the interpolation after each keyframe of a yaw, shape (n,).

    It is constant where the yaw jumps by a whole turn, and linear elsewhere.
    """
    jumps = np.abs(np.diff(yaw, append=yaw[-1:])) > pi
    return np.where(jumps, CONSTANT, LINEAR)
