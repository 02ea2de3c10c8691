# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the viewport writes beside its sensors: each label beside its own, none over another."""

import math
import types

import numpy as np
import pytest

OFF = 8.0
WINDOW = (0.0, 0.0, 1057.0, 618.0)
SIDEBAR = (766.0, 0.0, 1057.0, 564.0)
# The bathroom and the closet of the home in a window of 1280 × 720.
CLOSE = [(481.0, 351.0), (502.0, 349.0), (520.0, 349.0), (446.0, 341.0), (451.0, 321.0)]


@pytest.fixture
def arranged(addon_part):
    arrange = addon_part("angen_addon.view.overlay.labels").arrange

    def run(markers, sizes, wanted=(), covered=(SIDEBAR,)):
        order = range(len(markers))
        return arrange(markers, sizes, order, frozenset(wanted), WINDOW, covered, OFF)

    return run


def distance(plate, point):
    x = max(plate[0] - point[0], 0.0, point[0] - plate[2])
    y = max(plate[1] - point[1], 0.0, point[1] - plate[3])
    return math.hypot(x, y)


def covers(one, two):
    return one[0] < two[2] and two[0] < one[2] and one[1] < two[3] and two[1] < one[3]


@pytest.mark.parametrize("seed", range(5))
def test_each_label_is_beside_its_own_marker_and_covers_nothing(arranged, seed):
    random = np.random.default_rng(seed)
    markers = [*CLOSE, *map(tuple, random.uniform((60, 10), (750, 600), (25, 2)).tolist())]
    sizes = [(float(w), 17.0) for w in random.uniform(60, 190, len(markers))]
    plates = arranged(markers, sizes)
    assert 8 <= len(plates) < len(markers), "what does not fit is hidden"
    for number, plate in plates.items():
        assert plate[2] - plate[0] == pytest.approx(sizes[number][0])
        nearest = min(range(len(markers)), key=lambda n: distance(plate, markers[n]))
        assert nearest == number and distance(plate, markers[number]) <= OFF + 1e-6
        others = [m for n, m in enumerate(markers) if n != number]
        assert min(distance(plate, m) for m in others) >= 2 * OFF
        assert not covers(plate, SIDEBAR)
        assert plate[0] >= 0 and plate[2] <= 1057 and plate[1] >= 0 and plate[3] <= 618
        assert not any(covers(plate, other) for n, other in plates.items() if n != number)


def test_what_is_selected_or_hovered_has_its_label_in_any_crowd(arranged):
    sizes = [(150.0, 17.0)] * len(CLOSE)
    alone = arranged(CLOSE, sizes)
    hidden = set(range(len(CLOSE))) - set(alone)
    assert hidden
    for number in hidden:
        plates = arranged(CLOSE, sizes, wanted=[number])
        assert distance(plates[number], CLOSE[number]) <= OFF + 1e-6
        assert not any(covers(plates[number], p) for n, p in plates.items() if n != number)
    at_the_edge = arranged([(762.0, 300.0), (4.0, 4.0)], [(150.0, 17.0)] * 2, wanted=[0, 1])
    assert at_the_edge[0][2] <= 766 and at_the_edge[1][0] >= 0 and at_the_edge[1][1] >= 0


def test_what_lies_over_a_view_of_a_small_window(addon_part):
    """As Blender 4.3 has it at 1280 × 720, sidebar and toolbar open."""
    part = types.SimpleNamespace
    regions = [
        ("HEADER", 0, 666, 1057, 27), ("TOOL_HEADER", 0, 639, 1057, 27),
        ("ASSET_SHELF", 0, 75, 1, 1), ("TOOLS", 0, 75, 58, 564), ("UI", 766, 75, 291, 564),
        ("HUD", 58, 75, 1, 1), ("WINDOW", 0, 75, 1057, 618),
    ]  # fmt: skip
    area = part(regions=[part(type=t, x=x, y=y, width=w, height=h) for t, x, y, w, h in regions])
    overlay = part(show_overlays=True, show_text=True, show_stats=False)
    space = part(show_gizmo=True, show_gizmo_navigate=True, overlay=overlay)
    view = part(mini_axis_type="GIZMO", gizmo_size_navigate_v3d=80, show_navigate_ui=True)
    preferences = part(system=part(ui_scale=1.0), view=view)
    covered = addon_part("angen_addon.view.overlay.labels").covered
    found = covered(area, area.regions[-1], space, preferences)

    def free(x, y):
        """A place in the picture, from its upper left."""
        low = 720 - y - 75
        return not any(r[0] < x < r[2] and r[1] < low < r[3] for r in found)

    for x, y in ((900, 300), (30, 300), (500, 41), (500, 68)):
        assert not free(x, y), "under a panel"
    for x, y in ((713, 119), (745, 145), (743, 285), (683, 121)):
        assert not free(x, y), "under a gizmo"
    assert not free(200, 118) and free(400, 118), "the texts at the upper left"
    assert free(700, 285) and free(500, 400) and free(740, 400)
    space.show_gizmo = overlay.show_text = False
    found = covered(area, area.regions[-1], space, preferences)
    assert free(713, 119) and free(200, 118)


def test_the_marker_under_the_mouse(addon_part):
    nearest = addon_part("angen_addon.view.overlay.hover").nearest
    markers = {7: (100.0, 100.0), 8: (112.0, 100.0)}
    assert nearest(markers, (104, 101), 11.0) == 7 and nearest(markers, (108, 99), 11.0) == 8
    assert nearest(markers, (100, 120), 11.0) is None and nearest({}, (0, 0), 11.0) is None


def test_places_on_the_screen(addon_part):
    to_screen = addon_part("angen_addon.view.overlay.labels").to_screen
    matrix = np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, -1, 0]], float)
    points = np.array([[0, 0, -1.0], [1, 1, -2.0], [0, 0, 1.0]])
    found = to_screen(points, matrix, 200, 100)
    assert found[0] == pytest.approx([100, 50]) and found[1] == pytest.approx([150, 75])
    assert np.isnan(found[2]).all()
