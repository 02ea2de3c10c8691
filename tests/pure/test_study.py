# SPDX-License-Identifier: GPL-3.0-or-later
"""Studies without Blender: the file, its draws, its keys in a home, and the judgement of days.

Also the error of the command where the packages are missing.
"""

from __future__ import annotations

import subprocess
import sys
import zipfile
from datetime import date
from pathlib import Path

import numpy as np
import pytest

import build_zip
from angen_addon.process.standalone import load_extension

load_extension()
from angen_sensors.residents.days.rows import DayRows  # noqa: E402
from angen_sensors.residents.days.truth import Whereabouts  # noqa: E402
from angen_sensors.sensor_logic.choice import SensorChoice  # noqa: E402
from angen_sensors.sensor_logic.logs.error import InputError  # noqa: E402
from angen_sensors.sensor_logic.logs.formats.log import LoggedActivity  # noqa: E402
from angen_sensors.sensor_logic.logs.log import Event  # noqa: E402
from angen_sensors.studies import settings, truth  # noqa: E402
from angen_sensors.studies.settings import StudiedHome  # noqa: E402
from angen_sensors.studies.study import Study, count_of, read, runs_of  # noqa: E402

HOME = StudiedHome(
    "home.blend",
    {"PIR hall": "PIR", "PIR bed": "PIR", "Lamp.001": "LIGHT"},
    "sha256:0",
)


@pytest.fixture
def study(tmp_path: Path):
    """Read a study of a home, with these lines after the first."""
    (tmp_path / "home.blend").write_bytes(b"BLENDER")
    (tmp_path / "score.py").write_text("def score(recording, truth):\n    return 1\n")

    def make(text: str = "") -> Study:
        (tmp_path / "s.toml").write_text(f'home = "home.blend"\n{text}')
        return read(tmp_path / "s.toml")

    return make


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("seeds = 0", "s.toml, line 2: seeds: 0 is not a whole number from 1"),
        ("seeds = [1, 1]", "s.toml, line 2: seeds: give at least one seed"),
        ("frames = [9, 1]", "line 2: frames: the first frame, 9, is after the last, 1"),
        ('draw = "gird"', "line 2: draw: 'gird' is unknown; did you mean 'grid'?"),
        ('draw = "sobol"', "line 1: 'runs' is missing"),
        (
            'measure = ["event"]',
            "line 2: measure: 'event' is not a measure; did you mean 'events'?",
        ),
        ('measure = "no.py:f"', "line 2: measure: cannot read"),
        ('measure = "score.py:scor"', "has no function 'scor'; did you mean 'score'?"),
        ('measure = "truth"', "line 2: truth can be measured only for days: give a routine"),
        (
            'measure = "light_error"\nroutine = "score.py"\nstart = 2026-03-02\ndays = 1',
            "line 2: light_error can be measured only without a routine",
        ),
        ('routine = "score.py"\nstart = 1\ndays = 1', "line 3: start: 1 is not a date"),
        ('best = "score"', 'line 2: best: \'score\' is not "most MEASURE" or "least MEASURE"'),
        ('best = "most noticed"', "line 2: 'noticed' is not among the measures of this study; "),
        ('measure = "active"\nbest = "most events PIR hall"', "line 3: 'events PIR hall' is not"),
        ("measure = []", "line 2: measure: it names no measure"),
        ('keep = "samples"', "line 2: keep: 'samples' cannot be kept"),
        ("vari = 1", "line 2: the key 'vari' is unknown here; did you mean 'vary'?"),
        ("[vary]\nrays = [1]", "line 3: 'rays' is not a parameter: write \"SENSOR.parameter\""),
        ('[vary]\n"PIR*.rays" = 5', "line 3: PIR*.rays: give a list of values"),
        ('[vary]\n"PIR*.rays" = [[1]]', "line 3: PIR*.rays: [1] is not a number"),
        ('[vary]\n"PIR*.rays" = [nan]', "line 3: PIR*.rays: nan is no number"),
        ('[vary]\n"a.b" = { from = 2, to = 1 }', "line 3: 'to' must be above 'from'"),
        ('[vary]\n"a.b" = { from = 0, to = 1, log = true }', "line 3: with log = true"),
        ('[vary]\n"a.b" = { from = 0, to = 1 }', 'line 3: draw = "grid" needs steps'),
        (
            'draw = "list"\n[vary]\n"a.b" = [1]\n"a.c" = [1, 2]',
            'line 4: draw = "list" needs lists of the same length: a.b has 1, a.c has 2',
        ),
        ('[vary]\n"a.b" = [1]\n[set]\n"a.b" = 2', "line 5: 'a.b' also varies"),
        ("[vary]\nsensors = { of = [] }", "line 3: it names no sensor"),
        ("[vary]\nsensors.of = []", "line 3: it names no sensor"),
        ('[vary]\n\nsensors.of = ["a"]\nsensors.least = 2', "line 5: least: 2 is not a whole"),
        (
            '[vary]\nsensors = { of = ["a", "b"], least = 2, most = 1 }',
            "line 3: 'most' (1) must be at least 'least' (2)",
        ),
        ('[vary]\nsensors = { of = ["a", "a"] }', "line 3: 'a' is given twice"),
        (
            '[vary]\nsensors = { of = ["a"], least = 2 }',
            "least: 2 is not a whole number from 1 to 1",
        ),
        (
            f"[vary]\nsensors = {{ of = {[str(n) for n in range(14)]} }}",
            "line 3: there are 16383 combinations of sensors, more than 10000: give fewer sensors",
        ),
        ("[vary", "s.toml, line 2: Expected ']' at the end of a table declaration"),
    ],
)
def test_what_is_wrong_in_a_file_is_told_with_its_line(study, text, told) -> None:
    with pytest.raises(InputError) as error:
        study(text)
    assert told in str(error.value) and "\n" not in str(error.value)


def test_a_key_that_is_given_by_dots_has_its_line(study) -> None:
    where = study('seeds = 1\n[vary]\nsensors.of = ["a", "b"]').where("sensors")
    assert Path(where).name == "s.toml, line 4"


def test_choices_of_sensors_are_all_of_their_sets(study) -> None:
    few = study('[vary]\nsensors = { of = ["a", "b*", "c"], least = 2 }')
    assert few.vary["sensors"] == (("a", "b*"), ("a", "c"), ("b*", "c"), ("a", "b*", "c"))
    all_of_seven = study(f"[vary]\nsensors = {{ of = {list('abcdefg')} }}")
    assert count_of(all_of_seven) == 2**7 - 1


def test_a_home_that_is_missing_is_named(tmp_path) -> None:
    (tmp_path / "s.toml").write_text('home = "none.blend"')
    with pytest.raises(InputError, match=r"line 1: home: the file .*none.blend does not exist"):
        read(tmp_path / "s.toml")
    with pytest.raises(InputError, match=r"cannot read .*no\.toml: No such file"):
        read(tmp_path / "no.toml")


@pytest.mark.parametrize(
    ("vary", "told"),
    [
        ('"PIR attic.rays" = [5]', "line 3: no sensor of home.blend is called 'PIR attic'"),
        ('"PIR hall.reach" = [5]', "line 3: 'PIR hall' has no parameter 'reach'"),
        ('"*.rays" = [5]', "line 3: 'Lamp.001' has no parameter 'rays'"),
        ('"PIR*.hold_time" = [1, -1]', "line 3: hold_time is -1 s: it must be at least 0 s"),
        ('"PIR*.hold_time" = { from = -1, to = 5, steps = 3 }', "hold_time is -1 s: it must be"),
        ('"PIR*.rays" = [1.5]', "line 3: rays is 1.5: it must be a whole number"),
        ('"PIR*.rays" = { from = 1, to = 9, steps = 3 }', "add whole = true to its range"),
        ('"PIR*.model" = ["SONAR"]', "line 3: model is 'SONAR': choose one of RANGE_SCAN"),
        ('"PIR*.preset" = ["HC"]', "line 3: preset 'HC' is unknown: did you mean HC_SR501"),
        ('"PIR*.enabled" = [1]', "line 3: enabled is 1: it must be true or false"),
        ('"PIR*.update_rate" = [0]', "line 3: update_rate is 0: it must be a number above 0"),
        ('"PIR*.move_z" = ["up"]', "line 3: move_z is 'up': it must be a number"),
        ('sensors = [["PIR*", "Door"]]', "line 3: no sensor of home.blend is called 'Door'"),
    ],
)
def test_what_the_home_does_not_have_is_told_before_a_run(study, vary, told) -> None:
    with pytest.raises(InputError) as error:
        settings.check(study(f"[vary]\n{vary}"), [HOME])
    assert told in str(error.value) and "\n" not in str(error.value)


def test_the_draws(study) -> None:
    def values(text: str, name: str = "a.b") -> list:
        return [run.setting[name] for run in runs_of(study(text))]

    grid = study(
        'seeds = 2\n[vary]\n"a.b" = [1, 2]\n"a.c" = { from = 1, to = 100, steps = 3, log = true }'
    )
    assert count_of(grid) == 12
    assert [tuple(r.setting.values()) + (r.seed,) for r in runs_of(grid)][:3] == [
        (1, 1.0, 1),
        (1, 1.0, 2),
        (1, pytest.approx(10.0), 1),
    ]
    assert values('[vary]\n"a.b" = { from = 1, to = 4, steps = 9, whole = true }') == [1, 2, 3, 4]
    rows = study('draw = "list"\n[vary]\n"a.b" = [1, 2]\n"a.c" = ["x", "y"]')
    assert [list(r.setting.values()) for r in runs_of(rows)] == [[1, "x"], [2, "y"]]
    for draw in ("random", "sobol"):
        head = f'draw = "{draw}"\nruns = 600\n[vary]\n"a.b" = '
        found = np.array(values(head + "{ from = -1, to = 3 }"))
        assert len(found) == 600 and found.min() >= -1 and found.max() <= 3
        assert abs(found.mean() - 1.0) < (0.01 if draw == "sobol" else 0.2)
        whole = values(head + "{ from = 1, to = 3, whole = true }")
        assert {type(v) for v in whole} == {int}
        assert all(abs(whole.count(v) - 200) < 60 for v in (1, 2, 3))
        assert values(head + "{ from = -1, to = 3 }") == found.tolist()
    assert count_of(study()) == 1 and next(runs_of(study())).setting == {}


def test_keys_set_the_sensors_that_they_fit() -> None:
    found = settings.settings_of(
        HOME,
        {"PIR*.rays": 9.0, "sensors": ("PIR hall", "Lamp*"), "PIR hall.move_z": 0.5},
    )
    assert found == {
        "PIR hall": {"enabled": True, "rays": 9, "move_z": 0.5},
        "PIR bed": {"enabled": False, "rays": 9},
        "Lamp.001": {"enabled": True},
    }
    assert isinstance(found["PIR hall"]["rays"], int)
    # As `--sensor` and `--no-light` choose.
    chosen = SensorChoice(("PIR*",), light=False)
    assert settings.settings_of(HOME, {}, chosen) == {"Lamp.001": {"enabled": False}}
    (preset,) = settings.settings_of(HOME, {"PIR bed.preset": "HC_SR501"}).values()
    assert preset["range_max"] == 5.0 and preset["hold_time"] == 3.46


def test_the_command_says_how_to_get_it_where_the_zip_has_it_not(tmp_path) -> None:
    zipfile.ZipFile(build_zip.build(tmp_path / "zip", None)).extractall(tmp_path / "extension")
    assert not (tmp_path / "extension" / "studies").exists()
    code = (
        "import sys, types; home = sys.modules['home'] = types.ModuleType('home'); "
        "home.__path__ = ['.']; from home.angen_addon.process.parser import wrong_verb; "
        "print(wrong_verb('study'))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tmp_path / "extension",
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout == (
        "study is in the Python package, not in the extension: "
        'pip install ".[study]" in the project\'s folder\n'
    )


def us(clock: str) -> int:
    """Return µs since midnight."""
    hours, minutes, seconds = clock.split(":")
    return round((int(hours) * 3600 + int(minutes) * 60 + float(seconds)) * 1e6)


EVENTS = [
    ("00:00:00", "PIR bed", "PIR", "moved", False, "", ""),
    ("00:00:00", "Door bath", "CONTACT", "open", False, "", ""),
    ("00:00:00", "Lamp", "LIGHT", "lit", False, "", ""),
    ("07:00:04.0009", "PIR bed", "PIR", "moved", True, "Ada", "Ada"),
    ("07:00:06", "PIR bed", "PIR", "moved", False, "Ada", "Ada"),
    ("08:00:00", "Lamp", "LIGHT", "lit", True, "", ""),
    ("08:09:50", "Door bath", "CONTACT", "open", True, "Ada", "Door"),
    ("08:20:00", "Door bath", "CONTACT", "open", False, "Ada", "Door"),
    ("12:00:00", "PIR bed", "PIR", "moved", True, "", "Curtain"),
    ("12:00:05", "PIR bed", "PIR", "moved", False, "", "Curtain"),
]
ACTIVITIES = [
    ("00:00:00", "07:00:00", "Ada", "Sleeping", "bedroom"),
    ("07:00:00", "08:10:00", "Ada", "Dressing", "bedroom"),
    ("08:10:00", "08:12:00", "Ada", "Washing", "bathroom"),
    ("08:12:00", "09:00:00", "Ada", "Breakfast", "kitchen"),
    ("09:00:00", "24:00:00", "Ada", "Away", ""),
]
PEOPLE = [
    ("00:00:00", "Ada", "bedroom", (1.0, 1.0, 0.5), "lying"),
    ("08:09:55", "Ada", "bathroom", (2.0, 1.0, 0.9), "standing"),
    ("08:12:00", "Ada", "kitchen", (2.0, 4.0, 0.9), "standing"),
    ("09:00:00", "Ada", "", None, "away"),
]
ROOMS = {"PIR bed": "bedroom", "Door bath": "bathroom", "Lamp": "bedroom"}


def lived(events=EVENTS) -> truth.StudyDays:
    """The day above, with these events."""
    happened = tuple(
        Event(us(clock), sensor, field, 0.0, kind, value, 0, *by)
        for clock, sensor, kind, field, value, *by in events
    )
    done = tuple(LoggedActivity(us(a), us(b), *row) for a, b, *row in ACTIVITIES)
    where = tuple(Whereabouts(us(clock), *row) for clock, *row in PEOPLE)
    return truth.days_from_rows(DayRows(date(2026, 3, 2), happened, done, where), 1)


def test_sensors_are_judged_by_what_was_done() -> None:
    found = lived()
    # Of Sleeping, Dressing (after 4 s), Washing (its door is open already) and Breakfast two are
    # noticed; at noon nobody is in the bedroom. A lamp that the sun lights tells of nobody.
    assert truth.scores(found, ROOMS, 30.0) == {
        "noticed": 0.5,
        "missed_per_day": 2.0,
        "delay_s": 2.0,
        "false_alarms_per_day": 1.0,
        "activities_per_day": 4.0,
    }
    # The door opens 5 s before she is in its room.
    assert truth.scores(found, ROOMS, 4.0)["false_alarms_per_day"] == 2.0
    assert truth.scores(found, ROOMS, 6.0)["false_alarms_per_day"] == 1.0
    assert found.events[3].person == "Ada" and found.truth.activities[0].activity == "Sleeping"
    # As in the table: to the millisecond.
    assert found.events[3].time_s == 7 * 3600 + 4.0


def test_a_sensor_that_stays_on_is_on_until_the_end() -> None:
    ends = ("07:00:06", "12:00:05")
    found = truth.scores(lived([row for row in EVENTS if row[0] not in ends]), ROOMS, 30.0)
    assert found["false_alarms_per_day"] == 0.0 and found["noticed"] == 0.5


def test_nothing_to_notice_is_no_share() -> None:
    found = truth.scores(truth.days_from_rows(DayRows(date(2026, 3, 2), (), (), ()), 2), {}, 30.0)
    assert found["noticed"] is None and found["delay_s"] is None
    assert found["missed_per_day"] == found["false_alarms_per_day"] == 0.0
