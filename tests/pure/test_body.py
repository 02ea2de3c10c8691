# SPDX-License-Identifier: GPL-3.0-or-later
"""A resident's body in numpy: what a viewer of the animation would notice if it were wrong."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from angen_sensors.residents.acting.timeline import Clip, Gesture, Timeline
from angen_sensors.residents.body import gait, moves, poses
from angen_sensors.residents.body.cat_skeleton import CAT as CAT_BONES
from angen_sensors.residents.body.skeleton import ADULT, CAT, CHILD, OLDER_ADULT, PERSON
from angen_sensors.residents.body.solve import solve
from angen_sensors.residents.body.turns import turned

PEOPLE = [ADULT, OLDER_ADULT, CHILD, replace(OLDER_ADULT, frame=True)]
WITH_FRAME = ["adult", "older adult", "child", "walking frame"]
SOLE = {"heel": (-0.065, 0.115, 0.0), "ball": (0.12, 0.12, 0.0)}
FLOOR = 0.055
people = pytest.mark.parametrize("build", PEOPLE, ids=WITH_FRAME)


def an_hour_at_home(build):
    """Walks a bend, sits down on a low and a high seat, lies down, turns over, gets up, reaches."""
    line, now = Timeline(), 0.0

    def play(seconds, pose, still=False):
        nonlocal now
        line.clips.append(Clip(now, now + seconds, pose, still=still))
        now += seconds

    def rest(pose):
        play(0.5, lambda t: pose, still=True)

    stand = gait.Stand.at(0.0, 0.0, 0.3, build)
    angle = np.linspace(0.0, 3.0, 200)
    bend = np.stack([2 * np.sin(angle), 2 - 2 * np.cos(angle)], 1)
    rest(gait.standing(stand, FLOOR, build))
    walk = gait.Walk(gait.footsteps(stand, bend, -1.0, build), build.speed, FLOOR, build)
    play(walk.duration, walk.pose)
    upright = gait.standing(walk.end, FLOOR, build)
    rest(upright)
    x, y = walk.end.centre
    back = poses.seat_distance(build) * np.array([-np.cos(-1.0), -np.sin(-1.0)])
    for height in (0.30, 0.47, 0.75):
        seated = poses.sitting(upright, np.array([x + back[0], y + back[1], FLOOR + height]))
        play(1.7, lambda t, s=seated: poses.sitting_down(upright, s, t / 1.7))
        rest(seated)
        play(1.7, lambda t, s=seated: poses.sitting_down(upright, s, 1 - t / 1.7))
    seated = poses.sitting(upright, np.array([x + back[0], y + back[1], FLOOR + 0.5]))
    play(1.7, lambda t: poses.sitting_down(upright, seated, t / 1.7))
    bed = np.array([x + 2 * back[0], y + 2 * back[1], FLOOR + 0.5])
    ways = [poses.lying(seated, bed, -1.0 + np.pi / 2, side) for side in (0, 1, -1, 0)]
    play(3.2, lambda t: poses.lying_down(seated, ways[0], t / 3.2))
    for a, b in pairwise(ways):
        rest(a)
        play(3.0, lambda t, a=a, b=b: poses.turning_over(a, b, t / 3.0))
    play(3.2, lambda t: poses.lying_down(seated, ways[0], 1 - t / 3.2))
    play(1.7, lambda t: poses.sitting_down(upright, seated, 1 - t / 1.7))
    for height in (0.1, 0.6, 1.0, 1.6):
        point = np.array([x + 0.5 * np.cos(-1.0), y + 0.5 * np.sin(-1.0), height * build.scale])
        line.gestures.append(
            Gesture(now, now + 3, 0.9, 0.9,
                    lambda pose, t, w, p=point: poses.reaching(pose, 1, p, w), steady=True)
        )  # fmt: skip
        play(3.0, lambda t: upright, still=True)
    return line


@pytest.fixture(scope="module", params=PEOPLE, ids=WITH_FRAME)
def film(request):
    line = an_hour_at_home(request.param)
    times = np.arange(0.0, line.duration, 1 / 50)
    pose = line.poses(times)
    return request.param, line, times, pose, solve(pose)


def test_bones_keep_their_lengths_and_hang_together(film):
    build, _, _, _, bones = film
    for bone, above in PERSON.parent.items():
        if above:
            length = np.linalg.norm(bones.at[bone] - bones.at[above], axis=1)
            rest = np.linalg.norm(PERSON.head[bone] - PERSON.head[above]) * build.scale
            assert np.abs(length - rest).max() < 1e-9, bone
        assert np.abs(np.linalg.norm(bones.turn[bone], axis=1) - 1).max() < 1e-9


def test_feet_on_the_floor_do_not_slide(film):
    build, _, _, _, bones = film
    landed = 0
    for side, sign in (("L", 1), ("R", -1)):
        for x, y, z in SOLE.values():
            offset = (np.array([x, sign * y, z]) - PERSON.head[f"foot.{side}"]) * build.scale
            point = bones.at[f"foot.{side}"] + turned(bones.turn[f"foot.{side}"], offset)
            down = point[:, 2] < FLOOR + 0.0001
            assert point[:, 2].min() > FLOOR - 0.001
            edges = np.flatnonzero(np.diff(np.concatenate([[0], down, [0]])))
            for a, b in edges.reshape(-1, 2):
                assert np.ptp(point[a:b, :2], axis=0).max() < 0.001, (side, a, b)
            landed += len(edges) // 2
    assert landed > 30


def test_nothing_jumps(film):
    _, _, times, _, bones = film
    step = times[1] - times[0]
    for bone, limit in (("pelvis", 1.7), ("head", 2.2), ("hand.L", 3.5), ("hand.R", 3.5),
                        ("shin.L", 4.5), ("foot.R", 5.5)):  # fmt: skip
        speed = np.linalg.norm(np.diff(bones.at[bone], axis=0), axis=1) / step
        assert speed.max() < limit, f"{bone} at {times[speed.argmax()]:.2f} s"
    for bone, turn in bones.turn.items():
        angle = 2 * np.arccos(np.minimum(1, np.abs((turn[1:] * turn[:-1]).sum(1)))) / step
        assert angle.max() < 16, f"{bone} turns at {times[angle.argmax()]:.2f} s"


def test_a_moment_alone_is_as_among_others(film):
    _, line, times, _, bones = film
    for k in range(5, len(times), 211):
        alone = solve(line.poses(times[k : k + 1]))
        for bone, at in bones.at.items():
            assert np.array_equal(alone.at[bone][0], at[k])


def test_only_what_moves_is_in_the_spans(film):
    _, line, times, _, bones = film
    spans = line.moving()
    inside = np.any((times[:, None] > spans[:, 0]) & (times[:, None] < spans[:, 1]), axis=1)
    moved = np.any(
        [np.any(np.abs(np.diff(at, axis=0)) > 1e-12, axis=1) for at in bones.at.values()], axis=0
    )
    assert not np.any(moved & ~inside[1:] & ~inside[:-1])
    assert np.any(~inside)


@people
@pytest.mark.parametrize("height", [0.25, 0.47, 0.60, 0.80])
def test_a_seat_of_any_height_is_met(build, height):
    upright = gait.standing(gait.Stand.at(1.0, 2.0, 0.7, build), FLOOR, build)
    at = np.array([0.6, 1.7, FLOOR + height])
    bones = solve(poses.sitting(upright, at))
    assert bones.at["pelvis"][0] == pytest.approx(at + [0, 0, 0.13 * build.scale])
    for side in "LR":
        sole = bones.at[f"foot.{side}"][0, 2] - gait.ANKLE_HEIGHT * build.scale
        # On the floor, or hanging from a seat that is too high for the legs.
        legs = 0.46 * build.scale
        assert sole == pytest.approx(max(FLOOR, sole if height > legs else FLOOR), abs=0.002)
        assert sole < FLOOR + max(0.03, height - 0.8 * legs)


@people
@pytest.mark.parametrize("side", [0, 1, -1])
def test_one_lies_on_the_bed_and_not_in_it(build, side):
    upright = gait.standing(gait.Stand.at(0.0, 0.0, 0.0, build), FLOOR, build)
    seated = poses.sitting(upright, np.array([-0.5, 0.0, 0.5]))
    bones = solve(poses.lying(seated, np.array([-1.0, 0.0, 0.5]), 1.2, side))
    heights = [at[0, 2] for at in bones.at.values()]
    assert min(heights) > 0.5 and max(heights) < 0.5 + 0.45 * build.scale
    way = (bones.at["head"] - bones.at["pelvis"])[0, :2]
    assert np.arctan2(way[1], way[0]) == pytest.approx(1.2, abs=0.2)


@people
@pytest.mark.parametrize("height", [0.1, 0.35, 0.6, 0.9, 1.2, 1.6])
def test_the_hand_gets_there(build, height):
    upright = gait.standing(gait.Stand.at(0.0, 0.0, 0.0, build), FLOOR, build)
    point = np.array([0.45, -0.15, height]) * build.scale + [0, 0, FLOOR]
    bones = solve(poses.reaching(upright, 1, point, np.ones(1)))
    wrist = bones.at["hand.R"][0]
    assert np.linalg.norm(wrist - point) == pytest.approx(poses.PALM * build.scale, abs=0.03)
    assert bones.at["foot.L"][0] == pytest.approx(upright.feet.ankle[0, 0], abs=0.002)


@pytest.mark.parametrize("size", [0.2, 0.25, 0.3])
def test_a_cat_walks_on_paws_that_do_not_slide_and_sits_and_lies(size):
    build = replace(CAT, stature=size)
    angle = np.linspace(0.0, 2.5, 200)
    way = np.stack([1.5 * np.sin(angle), 1.5 - 1.5 * np.cos(angle)], 1)
    start = gait.Stand.at(0.0, 0.0, 2.0, build)
    walk = moves.Walk(moves.footsteps(start, way, -1.0, build), build.speed, FLOOR, build)
    stand = moves.standing(walk.end, FLOOR, build)
    seat_at = np.array([*walk.end.centre, FLOOR + 0.4])
    seated = moves.sitting(stand, seat_at)
    curled = moves.lying(seated, seat_at, -1.0, 1)
    line, now = Timeline(), 0.0
    for seconds, pose in (
        (0.5, lambda t: moves.standing(start, FLOOR, build)),
        (walk.duration, walk.pose),
        (1.5, lambda t: moves.sitting_down(stand, seated, t / 1.5)),
        (2.0, lambda t: moves.lying_down(seated, curled, t / 2.0)),
        (2.0, lambda t: moves.turning_over(curled, moves.lying(seated, seat_at, -1.0), t / 2.0)),
    ):
        line.clips.append(Clip(now, now + seconds, pose))
        now += seconds
    times = np.arange(0.0, now, 0.02)
    bones = solve(line.poses(times))
    for bone, above in CAT_BONES.parent.items():
        if above:
            length = np.linalg.norm(bones.at[bone] - bones.at[above], axis=1)
            rest = np.linalg.norm(CAT_BONES.head[bone] - CAT_BONES.head[above]) * build.scale
            assert np.abs(length - rest).max() < 1e-9, bone
    walking = times < 0.5 + walk.duration
    planted = 0
    for paw in ("toes.L", "toes.R", "fingers.L", "fingers.R"):
        at = bones.at[paw]
        down = (at[:, 2] < FLOOR + CAT_BONES.head[paw][2] * build.scale + 1e-4) & walking
        edges = np.flatnonzero(np.diff(np.concatenate([[0], down, [0]])))
        for a, b in edges.reshape(-1, 2):
            assert np.ptp(at[a:b, :2], axis=0).max() < 0.001, (paw, times[a])
        planted += down.sum()
    assert planted > 2.0 * walking.sum()  # of four, two and more bear
    for bone, limit in (("pelvis", 1.5), ("head", 1.8), ("foot.L", 3.0), ("hand.R", 3.0)):
        speed = np.linalg.norm(np.diff(bones.at[bone], axis=0), axis=1) / 0.02
        assert speed.max() < limit, f"{bone} at {times[speed.argmax()]:.2f} s"
    assert min(at[-1, 2] for at in bones.at.values()) > FLOOR + 0.39
