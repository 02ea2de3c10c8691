# SPDX-License-Identifier: GPL-3.0-or-later
"""The report's files: valid, self-contained, reproducible, and small for any length of run.

The lines of its plan are compared with closed forms and scipy; also its columns of time.
"""

import base64
import itertools
import math
import re
import struct
import xml.etree.ElementTree as ET
import zlib
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from angen_sensors.sensor_logic.clock import Clock
from angen_sensors.sensor_logic.kinds import KINDS
from angen_sensors.sensor_logic.recording.columns import Column
from angen_sensors.sensor_logic.recording.tracks import Recording, Track
from angen_sensors.sensor_logic.report import page, timeline
from angen_sensors.sensor_logic.report.facts import (
    PlanShape,
    PlanStorey,
    Report,
    ReportedSensor,
    SensorInPlan,
    figures,
    quantity,
)
from angen_sensors.sensor_logic.report.frames import chosen_rows, png, strip
from angen_sensors.sensor_logic.report.sections import Line, cut, from_above, joined, simplified
from angen_sensors.sensor_logic.report.svg import (
    HUES,
    INKS,
    hue,
    plain_style,
    safe,
    shortened,
    spread,
    style,
    text_width,
    ticks,
)
from angen_sensors.sensor_logic.report.timeline import columns, runs
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import spatial
from solids import CORNERS, TRIANGLES

SVG = "{http://www.w3.org/2000/svg}"
SQUARE = np.array([(0, 0), (5, 0), (5, 4), (0, 4)], float)


def track(name: str, kind: str, times: Any, active: Any, values: Any) -> Track:
    made = Track(name, kind)
    n = len(times)
    made.frames.extend(np.asarray(times, float) * 24 + 1)
    made.times.extend(np.asarray(times, float))
    made.active.extend(np.asarray(active, np.int8))
    made.value.extend(np.asarray(values, float))
    quantity = {"PRESSURE": "force_n", "LIGHT": "luminance_percent"}.get(kind)
    for field in KINDS[kind].samples:
        column = made.columns[field.name]
        if field.name == quantity:
            column.extend(made.value)
        elif field.type is bool:
            column.extend(made.active if field.name != "valid" else np.ones(n, np.int8))
        elif field.type is float:
            column.extend(np.full(n, np.nan))
        else:
            column.extend([0] * n if field.type is int else [""] * n)
    return made


def report(tracks: list[Track], seconds: float, rooms: Any = None, **facts: Any) -> Report:
    recording = Recording({t.sensor: t for t in tracks}, Clock(1, 24), 1, round(seconds * 24))
    named = rooms or itertools.repeat("")
    sensors = tuple(
        ReportedSensor(t.sensor, t.kind_name, room, float(np.diff(t.times).min()))
        for t, room in zip(tracks, named, strict=False)
    )
    return Report("home", (("File", "a.blend"),), sensors, recording, **facts)


def home(names: tuple[str, ...] = ("Hall", "Door", "Sofa", "Lamp"), room: str = "hall") -> Report:
    times = np.arange(20.0)
    on = (times > 5) & (times < 9)
    kinds = ("PIR", "OPTICAL_SWITCH", "PRESSURE", "LIGHT")
    tracks = [
        track(name, kind, times, on, on * 50.0) for name, kind in zip(names, kinds, strict=True)
    ]
    placed = tuple(
        SensorInPlan(name, np.array([1.0 + i, 2.0]), np.array([0.0, 1.0]), 2.0, *seen)
        for i, (name, seen) in enumerate(
            zip(names, [((SQUARE,),), ((), (SQUARE[:2],)), ((), (), SQUARE / 9), ()], strict=True)
        )
    )
    shapes = (
        PlanShape("wall", (Line(SQUARE, True),), 1.1),
        PlanShape("low", (Line(SQUARE / 2, True),), 1),
    )
    storey = PlanStorey(0.0, 1.1, np.array([(-1.0, -1.0), (6.0, 5.0)]), shapes, placed)
    return report(tracks, 20.0, [room] * 4, storeys=(storey,), plan_frame=1)


def parsed(text: str) -> ET.Element:
    return ET.fromstring(text.removeprefix("<!DOCTYPE html>"))


def texts(root: ET.Element) -> list[str]:
    return [t.strip() for t in root.itertext() if t.strip()]


def test_both_files_are_well_formed_and_tell_every_sensor() -> None:
    assert page.html(home()) == page.html(home()) and page.svg(home()) == page.svg(home())
    for root in (parsed(page.html(home())), parsed(page.svg(home()))):
        shown = texts(root)
        for name in ("Hall", "Door", "Sofa", "Lamp", "hall", "Motion detector (PIR)"):
            assert name in shown
        assert any(s.startswith("Frame 1; cut 1.10 m above the floor") for s in shown)


def test_names_are_text_whatever_they_hold() -> None:
    bad = ('<script>alert("1")</script>', "a & b", "\x07\ud800]]>", "'\"ÅÄÖ 居間")
    for text in (page.html(home(bad, "<i>")), page.svg(home(bad, "<i>"))):
        root = parsed(text)
        text.encode("utf-8")
        assert {element.tag.rpartition("}")[2] for element in root.iter()} & {
            "script",
            "i",
        } == set()
        assert "a & b" in texts(root) and "'\"ÅÄÖ 居間" in texts(root)


def test_the_page_needs_nothing_else() -> None:
    text = page.html(home())
    assert not re.search(r"<script|<link|@import|src=|href=", text)
    assert re.findall(r"url\(([^)]*)\)", text) and all(
        f'id="{name[1:]}"' in text for name in re.findall(r"url\(([^)]*)\)", text)
    )
    identifiers = re.findall(r' id="([^"]*)"', text)
    assert len(identifiers) == len(set(identifiers))
    assert "prefers-color-scheme:dark" in text and "@media print" in text
    assert "$" not in style(dict.fromkeys(INKS, "c"))
    # An image for papers contains its colours, because many viewers know no CSS variables.
    assert "var(" not in page.svg(home()) and INKS["ink"][0] in plain_style()


def test_active_spans_stand_at_their_times() -> None:
    """Active from 6 s to 9 s of 20 s: at 30 % to 45 % of the row's 540 px."""
    name = f"bar{hue('OPTICAL_SWITCH')}"
    paths = [e for e in parsed(page.svg(home())).iter(f"{SVG}path") if e.get("class") == name]
    strokes = [e.get("d", "") for e in paths]
    assert [d for d in strokes if "m" in d] == ["M0 11.5m162 0h81"], "that of the legend apart"


def test_what_was_not_simulated_and_what_is_not_valid_look_different() -> None:
    tracks = [
        track("pad", "PRESSURE", np.arange(10.0), np.zeros(10), np.zeros(10)),
        track("late", "PIR", np.arange(5.0, 10.0), np.zeros(5), np.zeros(5)),
    ]
    tracks[0].columns["valid"] = Column(bool, np.arange(10) != 2)
    made = report(tracks, 10.0)
    made = replace(made, sensors=(*made.sensors, ReportedSensor("off", "PIR", "", 1.0)))
    drawn = [
        (e.get("fill"), float(e.get("x", "nan")), float(e.get("width", "nan")))
        for e in parsed(page.svg(made)).iter(f"{SVG}rect")
        if "url" in e.get("fill", "") and e.get("x")
    ]
    assert sorted(drawn, key=str) == [
        ("url(#timeline1-invalid)", 108.0, 54.0),
        ("url(#timeline1-off)", 0.0, 270.0),
        ("url(#timeline1-off)", 0.0, 540.0),
    ]
    assert "not simulated" in texts(parsed(page.html(made)))
    alone = report([track("a", "PIR", [0.0, 1.0], [0, 0], [0, 0])], 2.0)
    assert "What one sensor reported in 2 s." in texts(parsed(page.html(alone)))
    parsed(page.svg(alone))


@pytest.mark.slow
def test_a_day_of_500_busy_sensors_is_small() -> None:
    """Each flickers at random all day; the largest kind has a curve and two sorts of bars."""
    random, times = np.random.default_rng(3), np.arange(0.0, 86_400.0, 240.0)
    tracks = [
        track(f"S {i:03}", "LIGHT", times, random.random(360) < 0.5, random.random(360) * 90)
        for i in range(500)
    ]
    text = page.html(report(tracks, 86_400.0, [f"room {i // 7}" for i in range(500)]))
    assert len(text.encode()) < 3_000_000
    assert text.count('aria-label="Timeline of sensors') == 13


def test_texts_are_cut_to_their_place_and_every_kind_has_its_own_colour() -> None:
    assert shortened("short", 100, 12) == "short"
    cut = shortened("a very long name of a sensor in the hall", 100, 12)
    assert "…" in cut and text_width(cut, 12) <= 100
    # Names that differ only at their end, or only at their beginning, are still told apart.
    long = "Motion detector in the corridor upstairs"
    for names in ([f"{long} {n}" for n in (1, 2, 13)], [f"{n} {long}" for n in ("A", "B")]):
        assert len({shortened(name, 100, 12) for name in names}) == len(names)
    assert shortened("wide", 1, 12) == "…"
    assert safe("<&>") == "&lt;&amp;&gt;"
    assert ticks(0.0, 9.5, 5) == [0.0, 2.0, 4.0, 6.0, 8.0, 10.0]
    assert len(KINDS) <= HUES
    assert len({hue(kind) for kind in KINDS}) == len(KINDS)
    with pytest.raises(KeyError):
        hue("NONE")


# Lines of a plan


def box(low: Any, high: Any) -> tuple[Any, Any]:
    """Return corners and outward triangles of a box."""
    low, high = np.array(low, float), np.array(high, float)
    return low + (CORNERS + 1) / 2 * (high - low), TRIANGLES


def merged(*meshes: Any) -> tuple[Any, Any]:
    points, triangles, count = [], [], 0
    for p, t in meshes:
        points.append(p)
        triangles.append(t + count)
        count += len(p)
    return np.concatenate(points), np.concatenate(triangles)


def tube(inner: float, outer: float, n: int = 64) -> tuple[Any, Any]:
    """Return a wall around a round yard, 2 m high, with normals out of the wall."""
    turn = np.linspace(0, 2 * math.pi, n, endpoint=False)
    ring = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    points = np.concatenate(
        [np.column_stack([ring * r, np.full(n, z)]) for r in (inner, outer) for z in (0.0, 2.0)]
    )
    faces = []
    for i in range(n):
        j = (i + 1) % n
        a, b, c, d = (i, j, n + i, n + j)
        faces += [(a, c, b), (b, c, d)]
        faces += [(2 * n + a, 2 * n + b, 2 * n + c), (2 * n + b, 2 * n + d, 2 * n + c)]
    return points, np.array(faces)


def apart(points: Any, triangles: Any) -> tuple[Any, Any]:
    """Return the same faces without shared corners."""
    return points[triangles].reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3)


def divided() -> tuple[Any, Any]:
    """Return a box with T-junctions: its side x = 0 ends between corners of its neighbours."""
    points, triangles = box((0, 0, 0), (1, 1, 3))
    side = (points[triangles][:, :, 0] == 0).all(axis=1)
    extra = np.array([(0, y, z) for z in (0, 0.5, 2.5, 3) for y in (0, 1)], float)
    strips = [t for i in (0, 2, 4) for t in ((i, i + 1, i + 2), (i + 1, i + 3, i + 2))]
    return merged((points, triangles[~side]), (extra, np.array(strips)))


POLYGON = 64 / 2 * math.sin(2 * math.pi / 64)
CUTS = {
    "a box": (box((1, 2, 0), (4, 4, 3)), 1.1, [6.0]),
    # The hole of a wall has the other orientation.
    "a wall around a yard": (tube(2.0, 2.3), 0.7, [-POLYGON * 4.0, POLYGON * 5.29]),
    "where a box stands on a box": (
        merged(box((0, 0, 0), (1, 1, 1)), box((0, 0, 1), (1, 1, 2))),
        1.0,
        [1.0],
    ),
    "below": (box((0, 0, 0), (1, 1, 3)), -0.1, []),
    "above": (box((0, 0, 0), (1, 1, 3)), 3.1, []),
    "nothing": ((np.empty((0, 3)), np.empty((0, 3), int)), 1.0, []),
    "no shared corners": (apart(*box((0, 0, 0), (3, 1, 2))), 1.0, [3.0]),
    "divided edges": (divided(), 1.1, [1.0]),
}


@pytest.mark.parametrize(("mesh", "height", "areas"), CUTS.values(), ids=CUTS)
def test_cuts_are_closed_and_have_their_areas(mesh: Any, height: float, areas: list) -> None:
    lines = cut(*mesh, height)
    assert all(line.closed for line in lines)
    assert sorted(line.area for line in lines) == pytest.approx(areas, rel=1e-9)


def test_a_corner_that_is_nowhere_takes_its_own_faces_only() -> None:
    points, triangles = merged(box((0, 0, 0), (1, 1, 2)), box((5, 0, 0), (6, 1, 2)))
    points[0] = np.nan
    areas = [line.area for line in cut(points, triangles, 1.0) if line.closed]
    assert areas == [pytest.approx(1.0)]


@settings(deadline=None, max_examples=40)
@given(seed=st.integers(0, 10**6), height=st.floats(-0.8, 0.8))
def test_the_cut_of_a_convex_body_is_its_section(seed: int, height: float) -> None:
    """Points are inside the outline exactly if scipy's half spaces have them inside the body.

    Points within 1 µm of its surface are left out.
    """
    random = np.random.default_rng(seed)
    hull = spatial.ConvexHull(random.normal(size=(24, 3)))
    lines = cut(hull.points, hull.simplices, height)
    probes = np.column_stack([random.uniform(-2, 2, (200, 2)), np.full(200, height)])
    depth = (hull.equations[:, :3] @ probes.T + hull.equations[:, 3:]).max(axis=0)
    if not lines:
        assert depth.min() > -1e-6
        return
    (line,) = lines
    assert line.closed
    for probe, off in zip(probes, depth, strict=True):
        if abs(off) > 2e-4:  # corners are merged within a tenth of a millimetre
            assert _inside(line.points, probe[:2]) == (off < 0)


def _inside(polygon: Any, point: Any) -> bool:
    one, two = polygon - point, np.roll(polygon, -1, axis=0) - point
    turn = np.arctan2(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0], (one * two).sum(axis=1))
    return abs(turn.sum()) > math.pi


def test_from_above_a_table_is_its_top_and_a_floor_with_a_hole_has_two_outlines() -> None:
    top, leg = box((0, 0, 0.7), (2, 1, 0.75)), box((0.1, 0.1, 0), (0.15, 0.15, 0.7))
    lines = from_above(*merged(top, leg))
    assert sorted(line.area for line in lines) == pytest.approx([0.0025, 2.0])
    grid = np.array([(x, y, 0.0) for y in range(4) for x in range(4)])
    cells = [(y * 4 + x) for y in range(3) for x in range(3) if (x, y) != (1, 1)]
    faces = np.array([t for i in cells for t in ((i, i + 1, i + 5), (i, i + 5, i + 4))])
    assert sorted(line.area for line in from_above(grid, faces)) == pytest.approx([-1.0, 9.0])
    assert from_above(grid, faces[:, ::-1]) == []  # seen from below


def test_open_ends_of_a_wall_are_joined_over_its_thickness() -> None:
    sides = [Line(np.array([(0.0, y), (3.0, y)]), False) for y in (0.0, 0.3)]
    (line,) = joined(sides, 0.5)
    assert line.closed and abs(line.area) == pytest.approx(0.9)
    assert [li.closed for li in joined(sides, 0.2)] == [False, False]


def test_what_is_simplified_stays_within_the_tolerance() -> None:
    turn = np.linspace(0, 2 * math.pi, 1000, endpoint=False)
    circle = np.stack([np.cos(turn), np.sin(turn)], axis=1) * 100
    few = simplified(circle, 0.5, closed=True)
    assert 10 < len(few) < 60
    # The sagitta of every side: r − sqrt(r² − (s/2)²).
    side = np.linalg.norm(few - np.roll(few, -1, axis=0), axis=1)
    assert (100 - np.sqrt(100**2 - (side / 2) ** 2)).max() <= 0.5 + 1e-3
    straight = np.stack([np.arange(50.0), np.arange(50.0)], axis=1)
    assert len(simplified(straight, 0.1)) == 2


def test_marks_do_not_cover_each_other() -> None:
    random = np.random.default_rng(1)
    places = np.concatenate([random.uniform(0, 600, (60, 2)), np.full((8, 2), 300.0)])
    found = spread(places, (20.0, 16.0), (0.0, 0.0, 600.0, 600.0))
    gaps = np.abs(found[:, None] - found[None]) / (20.0, 16.0)
    assert (gaps.max(axis=2)[np.triu_indices(len(found), 1)] >= 1.0 - 1e-12).all()
    assert (found >= (10, 8)).all() and (found <= (590, 592)).all()
    assert np.linalg.norm(found - places, axis=1).max() < 80
    alone = spread(np.array([[50.0, 60.0]]), (20.0, 16.0), (0.0, 0.0, 600.0, 600.0))
    np.testing.assert_array_equal(alone, [[50, 60]])


# Columns of time


def switch(times: list[float], opened: list[bool]) -> Track:
    track = Track("door", "OPTICAL_SWITCH")
    track.frames.extend(1 + 24 * t for t in times)
    track.times.extend(times)
    track.active.extend(opened)
    track.value.extend([0.1] * len(times))
    track.columns["open"].extend(opened)
    track.columns["range_m"].extend([0.1] * len(times))
    return track


def pad(force: list[float], valid: list[bool]) -> Track:
    track = Track("pad", "PRESSURE")
    n, pressed = len(force), [f > 1 for f in force]
    track.frames.extend(range(1, n + 1))
    track.times.extend(range(n))
    track.active.extend(pressed)
    track.value.extend(force)
    filled = {"force_n": force, "pressed": pressed, "valid": valid}
    for name, column in track.columns.items():
        column.extend(filled.get(name, ["" if column.type is str else 0] * n))
    return track


def test_a_short_event_of_a_long_day_is_seen_and_so_is_a_short_pause() -> None:
    times = np.arange(0, 86_400, 0.5)
    for quiet in (False, True):
        state = np.full(len(times), quiet)
        state[100_000] = not quiet
        seen = columns(switch(times.tolist(), state.tolist()), 0.5, 1 / 24, (0.0, 86_400.0), 1080)
        changed = runs(seen.sometimes & ~seen.throughout)
        assert changed == [(int(times[100_000] / 80), int(times[100_000] / 80) + 1)]


@given(
    opened=st.lists(st.booleans(), min_size=1, max_size=60),
    n=st.integers(1, 100),
    step=st.floats(0.05, 3.0),
)
def test_no_time_is_lost_or_made(opened: list[bool], n: int, step: float) -> None:
    times = [i * step for i in range(len(opened))]
    span = (0.0, len(opened) * step)
    seen = columns(switch(times, opened), step, 1e-3, span, n)
    width = span[1] / n
    assert (seen.active * seen.known).sum() * width == pytest.approx(sum(opened) * step, rel=1e-6)
    assert seen.known.sum() * width == pytest.approx(span[1], rel=1e-9)


def test_where_readings_stop_coming_nothing_is_known() -> None:
    """On for a second each: switched off from 3 to 7, and not yet on before 1."""
    seen = columns(switch([1, 2, 7, 8], [True] * 4), 1.0, 1 / 24, (0.0, 9.0), 9)
    np.testing.assert_allclose(seen.known, [0, 1, 1, 0, 0, 0, 0, 1, 1])
    assert not seen.sometimes[3:7].any()
    nothing = columns(Track("door", "OPTICAL_SWITCH"), 1.0, 0.1, (0.0, 9.0), 9)
    assert not nothing.known.any() and nothing.quantity == ""


def test_figures_and_the_envelope() -> None:
    force = [0.0, 5.0, 700.0, 5.0, 5.0, -1.0, 5.0, 5.0]
    seen = columns(pad(force, [True] * 8), 1.0, 1 / 24, (0.0, 8.0), 2)
    np.testing.assert_allclose(seen.high, [700, 5])
    np.testing.assert_allclose(seen.low, [0, -1])
    np.testing.assert_allclose(seen.last, [5, 5])
    fine = columns(pad(force, [True] * 8), 1.0, 1 / 24, (0.0, 8.0), 16)
    np.testing.assert_allclose(fine.high, np.repeat(force, 2))
    np.testing.assert_allclose(fine.low, np.repeat(force, 2))
    track = pad([0.0, 900.0, 70.0, 0.0], [True, False, True, True])
    seen = columns(track, 1.0, 1 / 24, (0.0, 4.0), 4)
    np.testing.assert_allclose(seen.invalid, [0, 1, 0, 0])
    assert seen.top == 70.0
    told = figures(track)
    assert (told.greatest, told.unit, told.invalid) == (70.0, "N", 0.25)
    told = figures(switch([0, 1, 2, 3], [True, False, False, True]))
    assert (told.updates, told.events, told.first, told.last, told.active) == (4, 2, 1.0, 3.0, 0.5)
    assert told.greatest is None and quantity(switch([0], [True]))[0] == ""
    still = figures(switch([0, 1], [False, False]))
    assert (still.events, still.first, still.last) == (0, None, None)


@pytest.mark.parametrize(
    ("span", "labels"),
    [
        ((0.0, 171.7), ["0", "20", "40", "60", "80", "100", "120", "140", "160"]),
        ((0.0, 0.4), ["0", "0.05", "0.1", "0.15", "0.2", "0.25", "0.3", "0.35", "0.4"]),
        ((0.0, 1200.0), ["0:00", "5:00", "10:00", "15:00", "20:00"]),
        ((0.0, 86_400.0), [f"{h}:00" for h in range(0, 25, 3)]),
        ((0.0, 7 * 86_400.0), [str(d) for d in range(8)]),
    ],
)
def test_ticks_of_time_are_round(span: tuple[float, float], labels: list[str]) -> None:
    found = timeline.moments(*span, 9)
    assert [timeline.time_label(t, span[1] - span[0]) for t in found] == labels


# Strips of pictures


def pictured(active: Any, values: Any, shape: tuple[int, int] = (2, 3)) -> Report:
    """Return a report of one array whose pixels all have the value of the reading."""
    n, (columns, rows) = len(active), shape
    made = track("Eye", "THERMAL_ARRAY", np.arange(float(n)), np.array(active), np.array(values))
    texts = [";".join([f"{value:.2f}"] * columns * rows) for value in values]
    made.columns["frame_c"] = Column(str, texts)
    made_report = report([made], float(n))
    (sensor,) = made_report.sensors
    return replace(made_report, sensors=(replace(sensor, shapes=(("frame_c", shape),)),))


def test_a_strip_has_the_changes_of_state_and_the_highest_picture() -> None:
    active = [False] * 5 + [True] * 4 + [False] * 31
    values = [21.0] * 5 + [28.0, 29.0, 30.0, 28.0] + [21.0] * 31
    made = pictured(active, values)
    page_text = page.html(made)
    assert "What 1 Eye saw" in page_text and "pale yellow 30.0 °C" in page_text
    assert page_text.count("data:image/png;base64,") == 8
    for time in (0, 5, 7, 9):
        assert f">{time}.0 s</text>" in page_text


def test_many_changes_leave_eight_pictures_in_order() -> None:
    made = pictured([i % 2 == 1 for i in range(100)], np.linspace(20, 30, 100))
    rows = chosen_rows(made.recording.tracks["Eye"])
    assert len(rows) == 8 and rows == sorted(rows) and rows[0] == 0 and rows[-1] == 99


def test_a_picture_of_another_shape_is_left_out() -> None:
    made = pictured([True, True], [21.0, 21.0])
    assert strip(made.recording.tracks["Eye"], "frame_c", (8, 8)) is None


def test_a_png_holds_its_colours_row_by_row_from_above() -> None:
    picture = np.array([[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]])
    head, _, text = png(picture).partition(",")
    data = base64.b64decode(text)
    assert head == "data:image/png;base64" and data[:8] == b"\x89PNG\r\n\x1a\n"
    assert struct.unpack(">II", data[16:24]) == (2, 1)
    start = data.index(b"IDAT") + 4
    (length,) = struct.unpack(">I", data[start - 8 : start - 4])
    assert zlib.decompress(data[start : start + length]) == bytes([0, 255, 0, 0, 0, 255, 0])


@pytest.mark.parametrize(
    ("warm_up", "active", "invalid"), [(0.0, 0.25, 0.0), (2.0, 0.5, 0.5), (9.0, None, 1.0)]
)
def test_a_detector_that_warms_up_is_not_valid_and_counts_in_no_share(
    warm_up: float, active: float | None, invalid: float
) -> None:
    pir = track("Hall", "PIR", np.arange(4.0), [False, False, False, True], np.zeros(4))
    pir.warm_up = warm_up
    told = figures(pir)
    assert (told.active, told.invalid, told.updates) == (active, invalid, 4)
    seen = columns(pir, 1.0, 0.0, (0.0, 4.0), 4)
    assert list(seen.invalid) == [float(time < warm_up) for time in range(4)]
    row = re.findall(r"<td[^>]*>([^<]*)</td>", page.html(report([pir], 4.0)))
    cells = ("–" if active is None else f"{active:.1%}", f"{invalid:.1%}" if invalid else "")
    assert (row[-3], row[-1]) == cells


def test_of_a_pad_only_valid_readings_are_in_the_share() -> None:
    pad = track("Sofa", "PRESSURE", np.arange(4.0), [True, True, False, True], np.ones(4))
    pad.columns["valid"] = Column(bool)
    pad.columns["valid"].extend([0, 0, 1, 1])
    assert (figures(pad).active, figures(pad).invalid) == (0.5, 0.5)
