# SPDX-License-Identifier: GPL-3.0-or-later
"""Days without Blender: where the sun stands, where a day is cut, and how days become tables."""

from __future__ import annotations

import csv
import io
import math
import tomllib
from dataclasses import replace
from datetime import date, datetime
from typing import Any

import numpy as np
import pytest
from angen_sensors.residents.acting.timeline import (
    AWAY,
    SITTING,
    WALKING,
    Acted,
    ActedActivity,
    Stay,
)
from angen_sensors.residents.days.rows import DAY_US, Day, DayRows, attributed, stretches, toml
from angen_sensors.residents.days.sun import Site, direction, position, skylight, sunlight
from angen_sensors.residents.days.truth import Whereabouts, activities, people
from angen_sensors.sensor_logic.formats.log import LoggedActivity
from angen_sensors.sensor_logic.log import Event

D = math.radians


@pytest.mark.parametrize(
    ("site", "when", "altitude", "azimuth"),
    [
        # Reda and Andreas, NREL/TP-560-34302, appendix A.5: zenith 50.11162°, azimuth 194.34024°.
        (Site(D(39.742476), D(-105.1786), -7), "2003-10-17T12:30:30", 39.88838, 194.34024),
        # Meeus, Astronomical Algorithms, example 25.a: declination -7.78507° and ascension
        # 198.38083° on 1992-10-13, 0 h; seen from the pole its altitude is the declination.
        (Site(D(89.9999), 0.0), "1992-10-13T00:00", -7.78507, None),
        # The northern solstice of 2024 was on June 20 at 20:51 UTC, at 23.438° of declination.
        (Site(D(89.9999), 0.0), "2024-06-20T20:51", 23.438 + 0.038, None),
        # At the equinox of 2024, March 20 at 03:06 UTC, it was on the equator: on the horizon
        # there, lifted by half a degree.
        (Site(D(89.9999), 0.0), "2024-03-20T03:06", 0.483, None),
    ],
)
def test_the_sun_stands_where_almanacs_say(
    site: Site, when: str, altitude: float, azimuth: float | None
) -> None:
    found = position(site, datetime.fromisoformat(when))
    assert math.degrees(found[0]) == pytest.approx(altitude, abs=0.015)
    if azimuth is not None:
        assert math.degrees(found[1]) == pytest.approx(azimuth, abs=0.015)


def test_it_rises_and_sets_at_published_times() -> None:
    # Stockholm, 2026-06-21, timeanddate.com and the almanac: 03:31 and 22:08 by summer time.
    site = Site(D(59.33), D(18.07), 2.0)
    day = [datetime(2026, 6, 21, minute // 60, minute % 60) for minute in range(1440)]
    up = [minute for minute, now in enumerate(day) if sunlight(position(site, now)[0]) > 0.0]
    assert up[0] == pytest.approx(3 * 60 + 31, abs=2)
    assert up[-1] == pytest.approx(22 * 60 + 8, abs=2)


def test_light_of_sun_and_sky() -> None:
    # North is +Y, so that the sun of noon shines from -Y, and a turned home turns it along.
    assert direction(Site(0, 0), 0.0, D(180)) == pytest.approx((0, -1, 0), abs=1e-12)
    assert direction(Site(0, 0, north=D(90)), 0.0, D(180)) == pytest.approx((1, 0, 0), abs=1e-12)
    # Meinel's formula in the zenith; nothing once the upper edge has set.
    assert sunlight(D(90)) == pytest.approx(0.7, rel=1e-3)
    assert sunlight(D(-0.3)) == 0.0 < sunlight(D(0.1)) < sunlight(D(1))
    assert skylight(D(90)) == 21_300.0
    assert skylight(D(-6)) == pytest.approx(3.4) and skylight(D(-40)) == 6.5e-4
    heights = np.radians(np.linspace(-30, 90, 600))
    assert (np.diff([skylight(h) for h in heights]) >= 0).all()


def test_a_day_is_cut_in_its_rests_if_it_has_any() -> None:
    spans = np.array([[10.0, 60.0], [70.0, 120.0], [121.0, 125.0], [500.0, 900.0]])
    cuts = stretches(spans, -120.0, 1000.0, 100.0)
    assert cuts == [65.0, 312.5, 600.0, 700.0, 800.0]
    moved = [
        np.clip(spans, a, b) @ [-1, 1] for a, b in zip([-120, *cuts], [*cuts, 1000], strict=True)
    ]
    assert max(part.sum() for part in moved) <= 100.0 + 1e-9
    assert stretches(np.zeros((0, 2)), -120.0, 1000.0, 100.0) == []


def test_what_ends_is_of_who_began_it() -> None:
    def event(time: int, *by: str, sensor: str = "PIR") -> Event[int]:
        return moved(time, sensor, True, *by)

    begin = event(0)
    told = [
        event(5, "anna", "Door"),
        event(6),
        event(7, "", "Door"),
        event(8, "", "Wind"),
        event(9),
    ]
    other = event(8, sensor="A")
    found = attributed([*told[2:], other, begin, *told[:2]])
    assert [e.time for e in found] == [0, 5, 6, 7, 8, 8, 9]
    assert [e.person for e in found] == ["", "anna", "anna", "anna", "", "", ""]
    assert found[4].sensor == "A"


class Body:
    """Sits at x = 1 m, walks to x = 121 m from 100 s to 220 s, and sits there."""

    def moving(self) -> Any:
        return np.array([[100.0, 220.0]])

    def away(self) -> Any:
        return np.zeros((0, 2))

    def poses(self, times: Any) -> Any:
        x = np.interp(times, [100.0, 220.0], [1.0, 121.0])
        at = np.column_stack([x, 0 * x, 0 * x + 0.9])
        return type("Pose", (), {"pelvis": at})()


ACTED = Acted(
    {"anna": Body()},
    activities=[
        ActedActivity(-50.0, 100.0, "anna", "Rest", "Sofa"),
        ActedActivity(100.0, 90_000.0, "anna", "Walk", ""),
    ],
    where=[
        Stay(-200.0, 100.0, "anna", "Sofa", SITTING),
        Stay(100.0, 220.0, "anna", "", WALKING),
        Stay(220.0, 50_000.0, "anna", "Chair", SITTING),
        Stay(50_000.0, 99_000.0, "anna", "", AWAY),
    ],
)


def test_the_truth_of_a_day_ends_with_it_and_tells_each_minute_of_movement() -> None:
    rooms = {"Sofa": "living"}
    assert activities(ACTED, lambda place: rooms.get(place, "")) == [
        LoggedActivity(0, 100_000_000, "anna", "Rest", "living"),
        LoggedActivity(100_000_000, DAY_US, "anna", "Walk", ""),
    ]
    # The chair stands in the hall, and belongs to the living room.
    of_places = {"Sofa": "living", "Chair": "living"}.__getitem__
    found = people(ACTED, lambda at: "living" if at[0] < 31.0 else "hall", of_places)
    assert activities(ACTED, lambda place: rooms.get(place, ""), found)[1].room == "living"
    told = [(w.time / 1e6, w.room, w.at and w.at[0], w.posture) for w in found]
    assert told == [
        (0.0, "living", 1.0, SITTING),
        (100.0, "living", 1.0, WALKING),
        (130.0, "hall", 31.0, WALKING),
        (190.0, "hall", 91.0, WALKING),
        (220.0, "living", 121.0, SITTING),
        (50_000.0, "", None, AWAY),
    ]


def moved(time: int, sensor: str, value: bool, person: str = "", because: str = "") -> Event[int]:
    return Event(time, sensor, "moved", 0.0, "PIR", value, 0, person, because)


def day(number: int, begins: bool, *events: Event[int]) -> Day:
    first = moved(0, "pir", begins)
    rest = LoggedActivity(DAY_US - 10, DAY_US, "anna", "Sleep", "bedroom")
    early = LoggedActivity(0, 20, "anna", "Sleep", "bedroom")
    at = (1.0, -0.0, 0.9)
    where = (Whereabouts(0, "anna", "bedroom", at, "lying"),)
    return Day(date(2026, 3, 2 + number), (first, *events), (early, rest), where)


DAYS = [
    day(0, False, moved(1_500_000, "pir", True, "anna", "Anna's body")),
    day(1, True),
    day(2, False),
]


def test_days_become_tables_without_a_seam_at_midnight() -> None:
    files = DayRows.of(DAYS).files()
    rows = {name: list(csv.reader(io.StringIO(text))) for name, text in files.items()}
    assert rows["events.csv"] == [
        ["time", "sensor", "kind", "field", "value", "person", "because"],
        ["2026-03-02T00:00:00.000", "pir", "PIR", "moved", "0", "", ""],
        ["2026-03-02T00:00:01.500", "pir", "PIR", "moved", "1", "anna", "Anna's body"],
        # As it was before midnight is told once; what another day begins with is not hidden.
        ["2026-03-04T00:00:00.000", "pir", "PIR", "moved", "0", "", ""],
    ]
    assert [row[:2] for row in rows["activities.csv"][2:]] == [
        ["2026-03-02T23:59:59.999", "2026-03-03T00:00:00.000"],
        ["2026-03-03T23:59:59.999", "2026-03-04T00:00:00.000"],
        ["2026-03-04T23:59:59.999", "2026-03-05T00:00:00.000"],
    ]
    assert rows["people.csv"][1:] == [
        ["2026-03-02T00:00:00.000", "anna", "bedroom", "1.000", "0.000", "0.900", "lying"]
    ]
    assert Day.of_json(DAYS[0].as_json("run 1"), "run 1") == DAYS[0]
    assert Day.of_json(DAYS[0].as_json("run 1"), "run 2") is None


def test_what_goes_on_over_midnight_is_one_also_from_room_to_room() -> None:
    """As a filler that is drawn before midnight and again after it."""
    late = LoggedActivity(DAY_US - 10, DAY_US, "anna", "Clean", "bedroom")
    early = LoggedActivity(0, 20, "anna", "Clean", "hall")
    again = LoggedActivity(30, 40, "anna", "Clean", "hall")
    days = [replace(DAYS[0], activities=(late,)), replace(DAYS[1], activities=(early, again))]
    assert DayRows.of(days).activities == (
        LoggedActivity(DAY_US - 10, DAY_US + 20, "anna", "Clean", "hall"),
        LoggedActivity(DAY_US + 30, DAY_US + 40, "anna", "Clean", "hall"),
    )


def test_labels_go_into_the_log_of_other_formats() -> None:
    log = DayRows.of(DAYS).log({}, {"home": "home.blend"}, {"Sleep": "Sleeping"})
    assert {activity.activity for activity in log.activities} == {"Sleeping"}
    assert log.start == datetime(2026, 3, 2) and log.changes[1].time == 1_500_000


def test_toml_reads_back() -> None:
    values = {"a b": 'x"y\\\n', "n": 1, "on": True, "at": [0.5, -1e-7], "t": datetime(2026, 3, 2)}
    sensor = {"name": "π", "parameters": {"range": 4.0, "partner": None}, "gone": None}
    text = toml({**values, "versions": {"blender": "4.5"}}, [sensor])
    assert tomllib.loads(text) == {
        **values,
        "versions": {"blender": "4.5"},
        "sensors": [{"name": "π", "parameters": {"range": 4.0}}],
    }
