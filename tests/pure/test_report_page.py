# SPDX-License-Identifier: GPL-3.0-or-later
"""The report's files: valid, whole in themselves, the same each time, and small however long the
run and however many the sensors."""

import itertools
import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from angen_sensors.sensor_logic.clock import Clock
from angen_sensors.sensor_logic.kinds import KINDS
from angen_sensors.sensor_logic.recording.columns import Column
from angen_sensors.sensor_logic.recording.tracks import Recording, Track
from angen_sensors.sensor_logic.report import page
from angen_sensors.sensor_logic.report.facts import (
    PlanShape,
    PlanStorey,
    Report,
    ReportedSensor,
    SensorInPlan,
)
from angen_sensors.sensor_logic.report.sections import Line
from angen_sensors.sensor_logic.report.svg import (
    HUES,
    INKS,
    fitting,
    hue,
    plain_style,
    safe,
    style,
    text_width,
    ticks,
)

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
    # A picture for papers has its colours in it: many readers know no variables.
    assert "var(" not in page.svg(home()) and INKS["ink"][0] in plain_style()


def test_the_same_run_gives_the_same_bytes() -> None:
    assert page.html(home()) == page.html(home())
    assert page.svg(home()) == page.svg(home())


def test_the_table_has_the_figures() -> None:
    rows = [
        ["".join(cell.itertext()) for cell in row] for row in parsed(page.html(home())).iter("tr")
    ]
    assert rows[3][:5] == ["3", "Lamp", "Light sensor", "hall", "2.00"] or len(rows[3]) == 11
    by_name = {row[1]: row for row in rows if len(row) == 11}
    assert by_name["Hall"][5:] == ["2", "6.0", "9.0", "15.0%", "", ""]
    assert by_name["Sofa"][5:] == ["4", "6.0", "9.0", "15.0%", "50.0 N", ""]


def bars(text: str, kind: str) -> list[str]:
    """The paths of the strokes of a kind, those of the legend apart."""
    found = [e for e in parsed(text).iter(f"{SVG}path") if e.get("class") == f"bar{hue(kind)}"]
    return [e.get("d", "") for e in found if "m" in e.get("d", "")]


def test_active_spans_stand_at_their_times() -> None:
    """Active from 6 s to 9 s of 20 s: at 30 % to 45 % of the row's 540 px."""
    assert bars(page.svg(home()), "OPTICAL_SWITCH") == ["M0 11.5m162 0h81"]


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


def test_a_report_of_one_still_sensor_without_a_home() -> None:
    made = report([track("a", "PIR", [0.0, 1.0], [0, 0], [0, 0])], 2.0)
    assert "What one sensor reported in 2 s." in texts(parsed(page.html(made)))
    parsed(page.svg(made))


@pytest.mark.slow
def test_a_day_of_500_busy_sensors_is_small() -> None:
    """Each flickers at random all day; the heaviest kind, a curve and two sorts of bars."""
    random = np.random.default_rng(3)
    times = np.arange(0.0, 86_400.0, 240.0)
    tracks = [
        track(f"S {i:03}", "LIGHT", times, random.random(360) < 0.5, random.random(360) * 90)
        for i in range(500)
    ]
    turn = np.linspace(-1, 1, 120)
    fans = tuple(np.stack([np.cos(turn), np.sin(turn)], axis=1) * (4 - 0.3 * k) for k in range(9))
    placed = tuple(
        SensorInPlan(t.sensor, at, np.ones(2), 2.0, tuple(fan + at for fan in fans))
        for t, at in zip(tracks, random.uniform(0, 60, (500, 2)), strict=True)
    )
    view = np.array([(-4.0, -4.0), (64.0, 64.0)])
    leaves = tuple(
        PlanShape("low", (Line(SQUARE * s + at, True),), 1.0)
        for s, at in zip(random.uniform(0.1, 0.4, 6_000), random.uniform(0, 60, (6_000, 2)),
                         strict=True)
    )  # fmt: skip
    rooms = [f"room {i // 7}" for i in range(500)]
    storey = PlanStorey(0.0, 1.1, view, leaves, placed)
    made = report(tracks, 86_400.0, rooms, storeys=(storey,))
    text = page.html(made)
    assert len(text.encode()) < 3_000_000
    assert text.count('aria-label="Timeline of sensors') == 13


def test_texts_are_cut_to_their_place() -> None:
    assert fitting("short", 100, 12) == "short"
    cut = fitting("a very long name of a sensor in the hall", 100, 12)
    assert cut.endswith("…") and text_width(cut, 12) <= 100
    assert safe("<&>") == "&lt;&amp;&gt;"
    assert ticks(0.0, 9.5, 5) == [0.0, 2.0, 4.0, 6.0, 8.0, 10.0]


def test_every_kind_has_its_own_colour_and_shape() -> None:
    assert len(KINDS) <= HUES
    assert len({hue(kind) for kind in KINDS}) == len(KINDS)
    with pytest.raises(KeyError):
        hue("NONE")
