# SPDX-License-Identifier: GPL-3.0-or-later
"""Who walks with a frame leaves it where it fits, does what is to be done, and fetches it."""

import numpy as np
import pytest
from angen_sensors.residents.body.skeleton import Build, Sort

FRAMED = Build(Sort.OLDER_ADULT, 1.65, 68.0, 0.85, frame=True)
ACTIVITIES = """
Sleep = lie Bed
Toilet = sit Toilet 2 min, use Washbasin 20 s
Relax = sit Sofa
Cook = use Stove 1 min
Look = stand at Window
"""
PLAN = [(0, "Sleep"), (60, "Toilet"), (70, "Relax"), (100, "Cook"), (130, "Look"), (160, "Away"),
        (200, "Cook"), (230, "Sleep")]  # fmt: skip


@pytest.fixture
def day(play):
    return play(ACTIVITIES, {"anna": PLAN}, builds={"anna": FRAMED})


def on_furniture(day, times: np.ndarray) -> np.ndarray:
    """(n,): the share of the frame, 0.57 m by 0.63 m, that stands in something."""
    floor = day.places.storeys[0].floor
    u, v = (a.ravel() for a in np.meshgrid(np.linspace(-0.3, 0.3, 9), np.linspace(-0.27, 0.27, 9)))
    found = []
    for x, y, _, yaw in day.acted.bodies["anna"].poses(times).walker:
        points = np.column_stack(
            [x + np.cos(yaw) * u - np.sin(yaw) * v, y + np.sin(yaw) * u + np.cos(yaw) * v]
        )
        cells = np.array([floor.cell(point) for point in points])
        found.append(float(np.mean(~floor.free[cells[:, 0], cells[:, 1]])))
    return np.array(found)


def test_at_a_place_the_frame_stands_in_nothing(day) -> None:
    stays = [s for s in day.acted.where if s.place and s.end - s.start > 15]
    assert {s.place for s in stays} >= {"Bed", "Toilet", "Sofa", "Stove", "Window"}
    middles = np.array([(s.start + s.end) / 2 for s in stays])
    assert on_furniture(day, middles).max() == 0.0
    # It stays there meanwhile, with no hand on it, and within a few steps.
    body = day.acted.bodies["anna"]
    for stay, middle in zip(stays, middles, strict=True):
        pose = body.poses(np.array([middle, stay.end - 1.0]))
        assert np.allclose(pose.walker[0], pose.walker[1])
        assert np.hypot(*(pose.walker[0, :2] - pose.pelvis[0, :2])) < 2.5


def test_it_is_pushed_everywhere_else_and_never_jumps(day) -> None:
    times = day.moving_times("anna")
    times = times[day.seen("anna", times)]
    pose = day.acted.bodies["anna"].poses(times)
    steps = np.hypot(*np.diff(pose.walker[:, :2], axis=0).T)[np.diff(times) < 0.11]
    assert steps.max() < 0.25
    gap = np.hypot(*(pose.walker[:, :2] - pose.pelvis[:, :2]).T)
    walks = [s for s in day.acted.where if s.posture == "walking" and s.end - s.start > 4]
    with_it = [np.median(gap[(times > s.start) & (times < s.end)]) for s in walks]
    assert len(walks) > 8 and np.median(with_it) < 0.5
    # On the way it meets less of what stands about than it did at places.
    assert np.mean(on_furniture(day, times[::7])) < 0.03
