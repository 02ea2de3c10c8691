# SPDX-License-Identifier: GPL-3.0-or-later
"""`--faults`: faults in a log, the truth about them, and how the log is restored."""

from __future__ import annotations

import csv
import io
import tempfile
from dataclasses import fields
from datetime import datetime
from pathlib import Path

import pytest
from angen_sensors.sensor_logic.logs.error import InputError
from angen_sensors.sensor_logic.logs.faults import (
    Fault,
    FaultPlan,
    make_faults,
    read_plan,
    truth_csv,
    undo,
)
from angen_sensors.sensor_logic.logs.formats.source import make_log
from angen_sensors.sensor_logic.logs.log import Event, read_events, rows_csv
from hypothesis import given, settings
from hypothesis import strategies as st

ROOT = Path(__file__).resolve().parent.parent.parent
DAY = 86400
FIELDS = [
    ("Door", "OPTICAL_SWITCH", "open"),
    ("Hall [1]", "PIR", "moved"),
    ("Hall 2", "PIR", "moved"),
    ("Pad", "PRESSURE", "pressed"),
    ("Pad", "PRESSURE", "force_n"),
    ("Pad", "PRESSURE", "partners"),
]
Rows = list[tuple[float, str, str, str]]


def log_of(rows: Rows):
    """Return a log of (seconds, sensor, field, value) at 24 frames a second."""
    kinds = {sensor: kind for sensor, kind, _ in FIELDS}
    return make_log([Event(t, s, f, 1 + round(24 * t), kinds[s], v) for t, s, f, v in rows])


def blinking(sensor: str = "Hall 2", count: int = 2000, every: float = 10.0) -> Rows:
    """Return a detector that goes on and off every `every` seconds; it begins off."""
    return [(i * every, sensor, "moved", str(i % 2)) for i in range(count)]


@pytest.fixture
def plan(tmp_path):
    def read(text: str) -> FaultPlan:
        path = tmp_path / "faults.toml"
        path.write_text(text, encoding="utf-8")
        return read_plan(path)

    return read


@pytest.fixture
def faulty(plan):
    """Return the rows of a log with the faults of a text, (seconds, sensor, field, value)."""

    def rows(clean: Rows, text: str) -> Rows:
        found = make_faults(log_of(clean), plan(text)).log
        return [(e.time, e.sensor, e.field, e.row[-1]) for e in (c.event for c in found.changes)]

    return rows


def share(part: float, whole: float) -> float:
    return pytest.approx(part / whole, abs=0.03)


def test_a_share_of_the_messages_is_lost_but_never_the_state_at_the_start(faulty) -> None:
    clean = blinking()
    found = faulty(clean, "[[fault]]\nlost = 0.3\n")
    assert set(found) < set(clean)
    assert 1 - len(found) / len(clean) == share(3, 10)
    assert faulty(clean, "[[fault]]\nlost = 1\n") == clean[:1]
    # Fields that a sensor publishes at one time are lost together.
    both = [(float(t), "Pad", f, str(t % 2)) for t in range(100) for f in ("force_n", "pressed")]
    times = [time for time, *_ in faulty(both, "[[fault]]\nlost = 0.5\n")]
    assert all(times.count(time) == 2 for time in times)
    assert 20 < len(times) < 180


def test_messages_come_late_and_twice(faulty) -> None:
    clean = blinking()
    late = faulty(clean, "[[fault]]\nlate = 0.2\nlate_by = [1, 4]\n")
    moved = sorted(set(late) - set(clean))
    assert len(moved) / len(clean) == share(2, 10)
    assert all(1 <= time % 10 <= 4 for time, *_ in moved)
    assert [row[3] for row in late] == [row[3] for row in clean]
    twice = faulty(clean, "[[fault]]\ndoubled = 0.1\ndoubled_after = 2\n")
    copies = sorted(set(twice) - set(clean))
    assert len(copies) / len(clean) == share(1, 10)
    assert all((time - 2, *rest) in set(clean) for time, *rest in copies)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ('stuck = "on"', [(0, 1)]),
        ('stuck = "off"', [(0, 0)]),
        ('stuck = "held"\nstuck_from = 15', [(0, 0), (10, 1)]),
        ('stuck = "on"\nstuck_from = 15\nstuck_for = 30', [(0, 0), (10, 1), (45, 0), (50, 1)]),
        (
            'stuck = "off"\nstuck_from = 15\nstuck_for = 20',
            [(0, 0), (10, 1), (15, 0), (35, 1), (40, 0), (50, 1)],
        ),
        ('stuck = "off"\nstuck_from = 15\nstuck_for = 15', [(0, 0), (10, 1), (15, 0), (30, 1)]),
        (
            "clock_offset = 0.5\nclock_drift_ppm = 100",
            [(0, 0), (10.501, 1), (20.502, 0), (30.503, 1), (40.504, 0), (50.505, 1)],
        ),
        ("clock_offset = -15", [(0, 0), (0.000001, 1), (5, 0), (15, 1), (25, 0), (35, 1)]),
        ("battery_life = 20", [(0, 0), (10, 1), (20, 0)]),
    ],
)
def test_stuck_sensors_clocks_and_batteries(faulty, text, expected) -> None:
    """A stuck sensor sends its state again once it is free."""
    found = faulty(blinking(count=6), f"[[fault]]\n{text}\n")
    told = [(time, int(value)) for time, _, _, value in found]
    assert told[: len(expected)] == expected and ("battery" not in text or told == expected)


def test_a_stuck_pad_has_its_output_forced_and_its_force_as_it_was(faulty) -> None:
    clean = [(0.0, "Pad", "force_n", "5"), (0.0, "Pad", "pressed", "0")]
    clean += [(9.0, "Pad", "force_n", "7"), (9.5, "Pad", "force_n", "8")]
    found = faulty(clean, '[[fault]]\nstuck = "on"\nstuck_from = 4\nstuck_for = 5.25\n')
    freed = [(9.25, "Pad", "force_n", "7"), (9.25, "Pad", "pressed", "0")]
    assert found == [*clean[:2], (4.0, "Pad", "pressed", "1"), *freed, clean[3]]


def test_false_alarms_come_at_their_rate_and_last_as_asked(faulty) -> None:
    clean = [(0.0, "Hall 2", "moved", "0"), (100.0 * DAY, "Hall 2", "moved", "1")]
    alarms = faulty(clean, "[[fault]]\nfalse_alarms_per_day = 5\nfalse_alarm_lasts = [2, 3]\n")
    times = [time for time, *_ in alarms[1:-1]]
    assert len(times) / 2 == pytest.approx(500, abs=70)
    assert all(2 <= end - begin <= 3 for begin, end in zip(times[::2], times[1::2], strict=True))
    # Readings in between are not lost: the output goes off when both are over.
    always = "[[fault]]\nfalse_alarms_per_day = 86400\nfalse_alarm_lasts = 1000\n"
    assert [row[3] for row in faulty(blinking(count=20), always)] == ["0", "1"]


def test_patterns_and_kinds_say_whom_it_concerns(faulty) -> None:
    clean = [(0.0, s, f, "0") for s, _, f in FIELDS] + [(9.0, s, f, "1") for s, _, f in FIELDS]

    def lost(choice: str) -> set[str]:
        kept = faulty(clean, f"[[fault]]\nlost = 1\n{choice}\n")
        return {s for s, _, _ in FIELDS} - {s for t, s, _, _ in kept if t == 9.0}

    assert lost("") == {"Door", "Hall [1]", "Hall 2", "Pad"}
    assert lost('sensors = "Hall*"') == {"Hall [1]", "Hall 2"}
    assert lost('sensors = ["Hall [1]", "Pad"]') == {"Hall [1]", "Pad"}
    assert lost('kinds = ["PIR", "PRESSURE"]\nsensors = "*2"') == {"Hall 2"}


EVERYTHING = """
seed = 4
[[fault]]
lost = 0.1
late = 0.1
late_by = [0, 20]
doubled = 0.1
clock_drift_ppm = [-50, 50]
false_alarms_per_day = 500
false_alarm_lasts = [1, 30]
battery_life = [9000, 15000]
"""


def test_another_sensor_or_another_rate_changes_nothing_of_the_rest(faulty, plan) -> None:
    one, two = blinking("Hall 2"), blinking("Hall [1]", count=1500, every=12.0)
    alone = faulty(one, EVERYTHING)
    both = faulty(sorted(one + two), EVERYTHING)
    assert [row for row in both if row[1] == "Hall 2"] == alone
    assert faulty(one, EVERYTHING) == alone
    assert faulty(one, EVERYTHING.replace("seed = 4", "seed = 5")) != alone
    # Which messages are doubled does not depend on the number of lost ones.
    lost = faulty(one, "[[fault]]\nlost = 0.1\n")
    after = faulty(one, "[[fault]]\nlost = 0.1\nclock_offset = 1\n")
    assert [row[0] + 1 for row in lost[1:]] == [row[0] for row in after[1:]]


def test_the_truth_tells_what_happened_to_each_row(plan) -> None:
    text = 'seed = 1\n[[fault]]\nstuck = "on"\nstuck_from = 12\nstuck_for = 20\n'
    found = truth_csv(make_faults(log_of(blinking(count=5)), plan(text)))
    rows = list(csv.DictReader(io.StringIO(found)))
    told = [(r["faults"], r["row"], r["true_row"], r["time_s"], r["value"]) for r in rows]
    assert told == [
        ("stuck", "", "", "12.000000", "on until 32.000000 s"),
        ("stuck", "", "3", "20.000000", "0"),
        ("stuck", "", "4", "30.000000", "1"),
    ]


shares = st.sampled_from([0.0, 0.3, 1.0])
ranges = st.tuples(st.floats(0, 60), st.floats(0, 60)).map(lambda pair: sorted(pair))


@st.composite
def plans(draw) -> str:
    """Draw the text of a faults file with any content."""
    parts = [f"seed = {draw(st.integers(0, 9))}\n"]
    for _ in range(draw(st.integers(1, 3))):
        keys = {
            "sensors": draw(st.sampled_from(['"*"', '"Pad"', '["Hall*", "Door"]'])),
            "lost": draw(shares),
            "late": draw(shares),
            "late_by": draw(ranges),
            "doubled": draw(shares),
            "doubled_after": draw(ranges),
            "clock_offset": draw(st.floats(-50, 50)),
            "clock_drift_ppm": draw(st.floats(-1e5, 1e5)),
            "false_alarms_per_day": draw(st.sampled_from([0, 2000, 86400])),
            "false_alarm_lasts": draw(ranges),
        }
        if draw(st.booleans()):
            keys["battery_life"] = draw(ranges)
        if draw(st.booleans()):
            keys["stuck"] = draw(st.sampled_from(['"on"', '"off"', '"held"']))
            keys["stuck_from"] = draw(ranges)
            keys["stuck_for"] = draw(ranges)
        parts += ["[[fault]]\n", *(f"{key} = {value}\n" for key, value in keys.items())]
    return "".join(parts)


@st.composite
def logs(draw) -> Rows:
    """Draw rows sorted by time; rows of one time in any order, possibly with repeated values."""
    times = sorted(draw(st.lists(st.integers(0, 60_000_000), max_size=40)))
    rows = []
    for time in times:
        sensor, _, field = draw(st.sampled_from(FIELDS))
        value = draw(st.sampled_from(["0", "1"]))
        rows.append((time / 1e6, sensor, field, value))
    return [(0.0, s, f, "0") for s, _, f in FIELDS] + rows


@settings(deadline=None)
@given(logs(), plans())
def test_the_log_without_faults_is_had_back_to_the_byte(rows, text) -> None:
    clean = log_of(rows)
    with tempfile.TemporaryDirectory() as folder:
        toml, events, truth = (Path(folder) / name for name in ("f.toml", "e.csv", "t.csv"))
        toml.write_text(text)
        found = make_faults(clean, read_plan(toml))
        events.write_text(rows_csv(c.event for c in found.log.changes), newline="")
        truth.write_text(truth_csv(found), newline="")
        back = undo(read_events(events), truth)
    assert rows_csv(back) == rows_csv(change.event for change in clean.changes)
    times = [change.time for change in found.log.changes]
    assert times == sorted(times)


def test_the_page_has_an_example_that_works_and_tells_every_key(plan) -> None:
    page = (ROOT / "docs" / "faults.md").read_text(encoding="utf-8")
    plan(page.split("```toml")[1].split("```")[0])
    assert all(f"`{field.name}`" in page for field in fields(Fault))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("x = [", ["Invalid value"]),
        ("seed = -1\n[[fault]]\nlost = 1", ["line 1", "seed is -1"]),
        ("", ["[[fault]]"]),
        ("[[fault]]\n", ["line 1", "this table has no fault"]),
        (
            '[[fault]]\nlost = 0.1\n[[fault]]\nsensors = "*"\n',
            ["line 4", "this table has no fault"],
        ),
        ("sead = 1\n[[fault]]\nlost = 0.1\n", ["line 1", "'sead'", "seed"]),
        ("[[fault]]\nlost = 0.1\n\n[[fault]]\nlots = 0.1\n", ["line 5", "'lots'", "lost"]),
        ("[[fault]]\nlost = 1.5\n", ["line 2", "lost is 1.5", "0 to 1"]),
        ("[[fault]]\nlost = nan\n", ["line 2", "lost is nan"]),
        ("[[fault]]\nlost = true\n", ["line 2", "lost is True"]),
        ("[[fault]]\nlost = [0, 1]\n", ["line 2", "lost is [0, 1]", "a share"]),
        ("[[fault]]\nlate = 0.5\n", ["line 2", "late_by"]),
        ("[[fault]]\nlate = 0.5\nlate_by = [9, 1]\n", ["line 3", "[9, 1]", "[lowest, highest]"]),
        ("[[fault]]\nbattery_life = -1\n", ["line 2", "battery_life"]),
        ('[[fault]]\nstuck = "open"\n', ["line 2", "'open'", "on", "off", "held"]),
        ("[[fault]]\nstuck = [1]\n", ["line 2", "[1]"]),
        ("[[fault]]\nstuck_for = 2\n", ["line 2", "stuck"]),
        ('[[fault]]\nlost = 1\nkinds = "SONAR"\n', ["line 3", "SONAR", "PIR"]),
        ("[[fault]]\nlost = 1\nsensors = 3\n", ["line 3", "sensors is 3"]),
        ('[[fault]]\nlost = 1\nsensors = "Hal 2"\n', ["line 3", "'Hal 2'", "Hall 2"]),
        ("fault = [{ lost = 2 }]\n", ["line 1", "lost is 2"]),
        ("[[fault]]\nlost = 1 2\n", ["line 2", "Expected newline"]),
    ],
)
def test_a_wrong_file_is_told_by_its_line(plan, tmp_path, text, words) -> None:
    with pytest.raises(InputError) as raised:
        plan(text).check_names(["Hall 2"])
    told = str(raised.value)
    assert all(word in told for word in ["faults.toml", *words]), told
    assert "\n" not in told


@pytest.fixture
def convert(tmp_path, angen):
    rows = (change.event for change in log_of(blinking(count=200)).changes)
    text = rows_csv(rows, datetime(2026, 3, 2))
    (tmp_path / "events.csv").write_text(text, newline="")
    (tmp_path / "faults.toml").write_text(EVERYTHING)

    def run(*options: str) -> tuple[int, str]:
        status, _, err = angen("convert", *(one.replace("OUT", str(tmp_path)) for one in options))
        return status, err

    return run


FAULTY = ["OUT/events.csv", "--format", "events", "--out", "OUT/faulty.csv"]
FAULTY += ["--faults", "OUT/faults.toml", "--start", "2026-03-02"]
UNDO = ["OUT/faulty.csv", "--format", "events", "--out", "OUT/back.csv", "--start", "2026-03-02"]


def test_convert_makes_a_log_faulty_and_takes_the_faults_out_again(convert, tmp_path) -> None:
    assert convert(*FAULTY) == (0, "")
    assert convert(*UNDO, "--undo-faults", "OUT/faulty.csv.truth.csv") == (0, "")
    clean = (tmp_path / "events.csv").read_bytes()
    assert (tmp_path / "faulty.csv").read_bytes() != clean
    assert (tmp_path / "back.csv").read_bytes() == clean


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ([*FAULTY[:5], "--truth", "OUT/truth.csv"], ["--faults"]),
        ([*FAULTY, "--truth", "OUT/faulty.csv"], ["--truth", "faulty.csv"]),
        ([*FAULTY, "--truth", "OUT/faults.toml"], ["--truth", "faults.toml"]),
        ([*FAULTY, "--truth", "OUT"], ["--truth", "folder"]),
        ([*FAULTY, "--truth", "OUT/no/truth.csv"], ["does not exist"]),
        ([*FAULTY, "--faults", "OUT/none.toml", "--truth", "OUT/t.csv"], ["none.toml"]),
        ([*FAULTY, "--undo-faults", "OUT/events.csv", "--truth", "OUT/t"], ["line 1", "faults"]),
    ],
)
def test_what_cannot_be_done_is_one_line_and_nothing_is_written(
    convert, tmp_path, options, words
) -> None:
    status, err = convert(*options)
    assert status == 2, err
    assert err.count("\n") == 1
    assert all(word in err for word in words), err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["events.csv", "faults.toml"]


def test_the_truth_of_another_log_is_refused(convert, tmp_path) -> None:
    assert convert(*FAULTY, "--truth", "OUT/truth.csv")[0] == 0
    rows = (tmp_path / "faulty.csv").read_text().splitlines(keepends=True)
    (tmp_path / "faulty.csv").write_text("".join(rows[:1] + rows[2:]), newline="")
    status, err = convert(*UNDO, "--undo-faults", "OUT/truth.csv")
    assert status == 2 and "does not match the log" in err
    assert not (tmp_path / "back.csv").exists()
