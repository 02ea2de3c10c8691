# SPDX-License-Identifier: GPL-3.0-or-later
"""A resident's body in numpy, by what a viewer of the animation would notice; and doors.

Paths over a floor are compared with scipy's distance transform and Dijkstra's shortest paths.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from angen_sensors.residents.acting.path_search import Floor, NoPath, find_path, length
from angen_sensors.residents.acting.places import DOOR, Door
from angen_sensors.residents.acting.timeline import (
    Acted,
    Clip,
    Gesture,
    Hold,
    LeafSwing,
    Switch,
    Timeline,
)
from angen_sensors.residents.body import gait, moves, poses
from angen_sensors.residents.body.cat_skeleton import CAT as CAT_BONES
from angen_sensors.residents.body.pose import BodyPose
from angen_sensors.residents.body.skeleton import ADULT, CAT, CHILD, OLDER_ADULT, PERSON
from angen_sensors.residents.body.solve import solve
from angen_sensors.residents.body.turns import rotated

PEOPLE = [ADULT, OLDER_ADULT, CHILD, replace(OLDER_ADULT, frame=True)]
WITH_FRAME = ["adult", "older adult", "child", "walking frame"]
SOLE = {"heel": (-0.065, 0.115, 0.0), "ball": (0.12, 0.12, 0.0)}
FLOOR = 0.055
people = pytest.mark.parametrize("build", PEOPLE, ids=WITH_FRAME)


def an_hour_at_home(build):
    """Walk a bend, sit down on a low and a high seat, lie down, turn over, get up, reach."""
    line, now = Timeline(), 0.0

    def play(seconds, pose, still=False):
        nonlocal now
        line.clips.append(Clip(now, now + seconds, pose, still=still))
        now += seconds

    def rest(pose):
        play(0.5, lambda t: pose, still=True)

    stand = gait.Stance.at(0.0, 0.0, 0.3, build)
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


def assert_whole(bones, skeleton, build):
    """Assert that bones keep their lengths and hang together."""
    for bone, above in skeleton.parent.items():
        if above:
            length = np.linalg.norm(bones.at[bone] - bones.at[above], axis=1)
            rest = np.linalg.norm(skeleton.head[bone] - skeleton.head[above]) * build.scale
            assert np.abs(length - rest).max() < 1e-9, bone
        assert np.abs(np.linalg.norm(bones.turn[bone], axis=1) - 1).max() < 1e-9


def slides(point, down):
    """Return how far a point slides on the floor, in m, and how often it lands there."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], down, [0]]))).reshape(-1, 2)
    return max((np.ptp(point[a:b, :2], axis=0).max() for a, b in edges), default=0.0), len(edges)


def assert_slow(bones, times, limits):
    for bone, limit in limits.items():
        speed = np.linalg.norm(np.diff(bones.at[bone], axis=0), axis=1) / (times[1] - times[0])
        assert speed.max() < limit, f"{bone} at {times[speed.argmax()]:.2f} s"


def test_bones_keep_their_lengths_and_hang_together(film):
    build, _, _, _, bones = film
    assert_whole(bones, PERSON, build)


def test_feet_on_the_floor_do_not_slide(film):
    build, _, _, _, bones = film
    landed = 0
    for side, sign in (("L", 1), ("R", -1)):
        for x, y, z in SOLE.values():
            offset = (np.array([x, sign * y, z]) - PERSON.head[f"foot.{side}"]) * build.scale
            point = bones.at[f"foot.{side}"] + rotated(bones.turn[f"foot.{side}"], offset)
            assert point[:, 2].min() > FLOOR - 0.001
            farthest, landings = slides(point, point[:, 2] < FLOOR + 0.0001)
            assert farthest < 0.001, side
            landed += landings
    assert landed > 30


def test_nothing_jumps(film):
    _, _, times, _, bones = film
    limits = {"pelvis": 1.7, "head": 2.2, "hand.L": 3.5, "hand.R": 3.5, "shin.L": 4.5}
    assert_slow(bones, times, {**limits, "foot.R": 5.5})
    for bone, turn in bones.turn.items():
        angle = 2 * np.arccos(np.minimum(1, np.abs((turn[1:] * turn[:-1]).sum(1))))
        assert angle.max() < 16 * (times[1] - times[0]), f"{bone} at {times[angle.argmax()]:.2f} s"


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
    upright = gait.standing(gait.Stance.at(1.0, 2.0, 0.7, build), FLOOR, build)
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
    upright = gait.standing(gait.Stance.at(0.0, 0.0, 0.0, build), FLOOR, build)
    seated = poses.sitting(upright, np.array([-0.5, 0.0, 0.5]))
    bones = solve(poses.lying(seated, np.array([-1.0, 0.0, 0.5]), 1.2, side))
    heights = [at[0, 2] for at in bones.at.values()]
    assert min(heights) > 0.5 and max(heights) < 0.5 + 0.45 * build.scale
    way = (bones.at["head"] - bones.at["pelvis"])[0, :2]
    assert np.arctan2(way[1], way[0]) == pytest.approx(1.2, abs=0.2)


@people
@pytest.mark.parametrize("height", [0.1, 0.35, 0.6, 0.9, 1.2, 1.6])
def test_the_hand_gets_there(build, height):
    upright = gait.standing(gait.Stance.at(0.0, 0.0, 0.0, build), FLOOR, build)
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
    start = gait.Stance.at(0.0, 0.0, 2.0, build)
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
    assert_whole(bones, CAT_BONES, build)
    walking, planted = times < 0.5 + walk.duration, 0
    for paw in ("toes.L", "toes.R", "fingers.L", "fingers.R"):
        height = FLOOR + CAT_BONES.head[paw][2] * build.scale + 1e-4
        down = (bones.at[paw][:, 2] < height) & walking
        assert slides(bones.at[paw], down)[0] < 0.001, paw
        planted += down.sum()
    assert planted > 2.0 * walking.sum()  # of four paws, two or more carry
    assert_slow(bones, times, {"pelvis": 1.5, "head": 1.8, "foot.L": 3.0, "hand.R": 3.0})
    assert min(at[-1, 2] for at in bones.at.values()) > FLOOR + 0.39


# Paths over a floor


def flat(rows: str, size: float = 0.25) -> Floor:
    """Return a floor drawn from the top: `#` is not free."""
    lines = rows.strip().split("\n")[::-1]
    free = np.array([[sign != "#" for sign in line.strip()] for line in lines]).T
    return Floor(np.zeros(2), size, free)


def random_floor(seed: int) -> Floor:
    rng = np.random.default_rng(seed)
    free = np.ones((60, 45), bool)
    for _ in range(14):
        x, y = rng.integers(0, 55), rng.integers(0, 40)
        free[x : x + rng.integers(1, 14), y : y + rng.integers(1, 12)] = False
    return Floor(rng.normal(size=2), 0.1, free)


def distance_to_things(floor: Floor, points: np.ndarray) -> np.ndarray:
    """Return the distances from points (n, 2) to the cells that are not free."""
    low = floor.low + np.argwhere(~floor.free) * floor.size
    off = np.maximum(low - points[:, None], points[:, None] - low - floor.size)
    return np.linalg.norm(np.maximum(off, 0.0), axis=2).min(axis=1)


@pytest.mark.parametrize("seed", range(8))
def test_a_way_is_there_where_there_is_one_and_hardly_longer_than_the_shortest(seed: int) -> None:
    ndimage = pytest.importorskip("scipy.ndimage")
    sparse = pytest.importorskip("scipy.sparse")
    from scipy.sparse.csgraph import dijkstra

    floor, radius = random_floor(seed), 0.15
    exact = ndimage.distance_transform_edt(np.pad(floor.free, 1))[1:-1, 1:-1]
    assert np.allclose(floor.clearance, (exact - 0.5) * floor.size)
    wide = floor.clearance >= radius - 1e-9
    cells = np.argwhere(wide)
    number = np.full(wide.shape, -1)
    number[wide] = np.arange(len(cells))
    edges = []
    for dx, dy in ((1, 0), (0, 1), (1, 1), (1, -1)):
        x, y = cells[((cells + (dx, dy) >= 0) & (cells + (dx, dy) < wide.shape)).all(1)].T
        open_ = wide[x + dx, y + dy] & wide[x + dx, y] & wide[x, y + dy]
        x, y = x[open_], y[open_]
        step = np.full(len(x), np.hypot(dx, dy) * floor.size)
        edges.append((number[x, y], number[x + dx, y + dy], step))
    rows, columns, steps = (np.concatenate(part) for part in zip(*edges, strict=True))
    graph = sparse.coo_matrix((steps, (rows, columns)), (len(cells), len(cells))).tocsr()
    rng = np.random.default_rng(seed)
    for _ in range(6):
        a, b = rng.integers(len(cells), size=2).tolist()
        start, goal = (floor.middle(tuple(cells[k])) for k in (a, b))
        shortest = dijkstra(graph, directed=False, indices=a)[b]
        if np.isinf(shortest):
            with pytest.raises(NoPath):
                find_path(floor, start, goal, radius)
            continue
        found = find_path(floor, start, goal, radius)
        assert (found[0] == start).all() and (found[-1] == goal).all()
        straight = np.linalg.norm(goal - start)
        assert straight - 1e-9 <= length(found) <= 1.5 * shortest + 1e-9
        for p, q in pairwise(found):
            between = p + (q - p) * np.linspace(0, 1, 50)[:, None]
            # Between the centres of cells the distance is off by half a diagonal at most.
            assert distance_to_things(floor, between).min() >= radius - 0.71 * floor.size


def test_a_walker_keeps_off_walls_where_there_is_room_and_cuts_corners() -> None:
    floor = flat("""
        ....................
        ....................
        ....................
        ############........
        ....................
        ....................
        ....................
    """)
    found = find_path(floor, np.array([0.6, 0.4]), np.array([0.6, 1.4]), 0.2)
    # Around the end of the wall, at x = 3.
    assert len(found) <= 8 and found[:, 0].max() > 3.3
    assert length(found) < 8.0


def test_where_there_is_no_way_the_nearest_place_is_told() -> None:
    floor = flat("""
        ....#....
        ....#....
        ....#....
    """)
    start, goal = np.array([0.4, 0.4]), np.array([2.0, 0.4])
    with pytest.raises(NoPath) as caught:
        find_path(floor, start, goal, 0.1)
    assert caught.value.nearest[0] == pytest.approx(0.875)
    with pytest.raises(NoPath, match="no floor is wide enough"):
        find_path(floor, start, goal, 2.0)
    # Who stands at a basin gets away from it.
    start = np.array([0.02, 0.5])
    found = find_path(
        Floor(np.zeros(2), 0.25, np.ones((8, 4), bool)), start, np.array([1.5, 0.5]), 0.3
    )
    assert (found[0] == start).all() and length(found) < 1.6


# Doors

UP = np.array([0.0, 0.0, 1.0])


def door(slides: bool = False, opens: float = np.pi / 2, turn: float = 0.0) -> Door:
    """Return a leaf of 0.9 m with its hinge at (2, 1), along x turned by an angle."""
    c, s = np.cos(turn), np.sin(turn)
    frame = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return Door(
        "Door", DOOR, np.array([2.0, 1.0, 0.0]), -frame[:, 0] if slides else UP, 0.0, opens, frame,
        np.array([0.0, -0.02, 0.0]), np.array([0.9, 0.02, 2.0]), np.array([0.8, 0.0, 1.0]), slides,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("leaf", "handle"),
    [
        (door(), (2.0, 1.8, 1.0)),
        (door(opens=-np.pi / 2), (2.0, 0.2, 1.0)),
        (door(turn=np.pi / 2), (1.2, 1.0, 1.0)),
        (door(slides=True, opens=0.85), (1.95, 1.0, 1.0)),
    ],
)
def test_the_handle_goes_with_the_leaf(leaf: Door, handle: tuple) -> None:
    assert np.allclose(leaf.handle_at(leaf.open), handle)


@pytest.mark.parametrize("turn", [0.0, 2.0, -1.0])
@pytest.mark.parametrize("opens", [1.5, -1.5])
def test_the_side_that_a_leaf_opens_to(turn: float, opens: float) -> None:
    leaf = door(opens=opens, turn=turn)
    assert leaf.side(leaf.handle_at(opens)) == 1.0
    assert leaf.side(leaf.handle_at(-opens)) == -1.0


# The activities of a day


def body(*moves: tuple[float, float], away: tuple[tuple[float, float], ...] = ()) -> Timeline:
    """Return a body that moves between the two times of each pair, and is away at times."""
    clips = [Clip(start, end, standing) for start, end in moves]
    return Timeline([*clips, *(Clip(*one, standing, still=True, away=True) for one in away)])


def standing(times: np.ndarray) -> BodyPose:
    raise AssertionError("nobody asks for the pose")


ACTED = Acted(
    {"anna": body((10, 20), (20, 25), (90, 99), away=((99, 100),)), "bo": body((22, 30))},
    {"Door": [LeafSwing(11, 12.5, 0, 1.6, "anna"), LeafSwing(40, 42, 1.6, 0, "bo")]},
    [Switch(0, "Lamp", False, ""), Switch(50, "Lamp", True, "bo")],
    {"Cup": [Hold(0, None), Hold(26, 1, person="bo"), Hold(28, None)]},
)


def test_spans_are_all_that_moves_and_who_moves_it() -> None:
    assert ACTED.spans(0, 60).tolist() == [[0, 0], [10, 30], [40, 42], [50, 50]]
    assert ACTED.spans(80, 120).tolist() == [[90, 99], [100, 100]]
    assert ACTED.spans(15, 41).tolist() == [[15, 30], [40, 41]]
    assert Acted({}).spans(0, 60).shape == (0, 2)
    asked = [("Door", 11), ("Door", 41), ("Lamp", 49), ("Lamp", 50), ("Cup", 20), ("Cup", 29)]
    assert [ACTED.last_mover(*one) for one in asked] == ["anna", "bo", "", "bo", "", "bo"]
    assert ACTED.last_mover("Table", 5) == ""
