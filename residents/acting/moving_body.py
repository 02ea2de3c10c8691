# SPDX-License-Identifier: GPL-3.0-or-later
"""A body in time: its pose at the present time, and the timeline of its motion so far.

A clip is a piece of the body's motion. A gesture is a movement added to the poses of clips.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ...sensor_logic.model import Array
from ..body.cat import CatWalk
from ..body.gait import Stance, Walk
from ..body.pose import BodyPose
from .timeline import Clip, Gesture, Timeline


class MovingBody:
    """A body at the present time, and its motion so far.

    Times are in seconds since midnight.

    Attributes
    ----------
    now : float
        The present time, at which the timeline's last clip ends.
    stance : Stance
        Where the feet stand, or stood before the person sat down.
    pose : BodyPose
        The pose at the present time (n = 1).
    arrived : float
        The time at which the last walk ended.
    timeline : Timeline
        The motion so far.
    """

    def __init__(self, now: float, stance: Stance, pose: BodyPose) -> None:
        self.now = self.arrived = now
        self.stance, self.pose = stance, pose
        self.timeline = Timeline()
        # Times, s, and the body's positions at them, m. Between them the body moves evenly.
        self._track = [(now, *stance.centre)]

    @property
    def position(self) -> Array:
        """The point (2,) between the feet, m."""
        return np.array(self.stance.centre)

    def positions_at(self, times: Array) -> Array:
        """Return the body's positions (n, 2) at times (n,), m.

        After the last known position, the position stays the same.
        """
        first = bisect_right(self._track, (float(times.min()), math.inf)) - 1
        track = np.array(self._track[max(first, 0) :])
        return np.column_stack([np.interp(times, track[:, 0], track[:, k]) for k in (1, 2)])

    def put(self, stance: Stance, pose: BodyPose) -> None:
        """Set the body's stance and its single pose, without a movement in between."""
        self.stance, self.pose = stance, pose
        self._track.append((self.now, *stance.centre))

    def add_clip(self, seconds: float, pose: Callable[[Array], BodyPose]) -> None:
        """Append a clip of `seconds` s, a piece of motion, to the timeline.

        `pose` takes the seconds (n,) since the start of the clip and returns the poses.
        """
        self.timeline.clips.append(Clip(self.now, self.now + seconds, pose))
        self.now += seconds
        self.pose = pose(np.array([seconds]))

    def add_walk(self, walk: Walk | CatWalk, pose: Callable[[Array], BodyPose]) -> None:
        """Append a walk to the timeline; `pose` is that of `add_clip`."""
        times, points = walk.track()
        self._track.append((self.now, *self.stance.centre))
        self._track += [
            (self.now + float(time), float(x), float(y))
            for time, (x, y) in zip(times, points, strict=True)
        ]
        self.add_clip(walk.duration, pose)
        self.stance, self.arrived = walk.end, self.now
        self._track.append((self.now, *self.stance.centre))

    def keep_still(self, until: float, away: bool) -> None:
        """Append a still clip that ends at a time, s, or extend the last clip if it is still.

        `away` is whether the body is out of the home.
        """
        pose, clips = self.pose, self.timeline.clips
        if clips and clips[-1].still and clips[-1].away == away:
            clips[-1] = replace(clips[-1], end=until)
        else:
            clips.append(Clip(self.now, until, lambda _times: pose, still=True, away=away))
        self.now = until

    def unwind_heading(self, holds_frame: bool, away: bool) -> None:
        """Subtract whole turns (2π) from the heading of a body that is still.

        `holds_frame` is whether a walking frame turns with the body, and `away` whether the body is
        out of the home.
        """
        turn = -2 * math.pi * round(self.stance.yaw / (2 * math.pi))
        left, right = (
            replace(foot, yaw=foot.yaw + turn) for foot in (self.stance.left, self.stance.right)
        )
        self.stance = Stance(left, right)
        walker = self.pose.walker + (0.0, 0.0, 0.0, turn if holds_frame else 0.0)
        self.pose = replace(self.pose, heading=self.pose.heading + turn, walker=walker)
        pose = self.pose
        self.timeline.clips.append(
            Clip(self.now, self.now, lambda _times: pose, still=True, away=away)
        )

    def add_gesture(
        self, seconds: float, rise: float, fall: float,
        apply: Callable[[BodyPose, Array, Array], BodyPose], begins: float = 0.0,
    ) -> None:  # fmt: skip
        """Add a gesture, which changes the poses of clips while its weight is above 0.

        Parameters
        ----------
        seconds : float
            The duration.
        rise, fall : float
            The time in which the weight rises from 0 to 1, and falls to 0 at the end, s.
        apply : callable
            Takes poses, times (n,) and weights (n,), and returns the changed poses.
        begins : float, optional
            The time from now to the start, s.
        """
        start = self.now + begins
        self.timeline.gestures.append(Gesture(start, start + seconds, rise, fall, apply))
