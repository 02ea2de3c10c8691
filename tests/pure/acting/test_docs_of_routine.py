# SPDX-License-Identifier: GPL-3.0-or-later
"""The page of residents: its routine can be read, and it has all words and keys."""

import re
from pathlib import Path

from angen_sensors.residents.acting import words
from angen_sensors.residents.routine import file, timetable

ROOT = Path(__file__).resolve().parents[3]
PAGE = (ROOT / "docs/residents.md").read_text(encoding="utf-8")


def test_the_page_has_a_routine_that_can_be_read_and_all_words() -> None:
    text = re.search(r"```toml\n(schema.*?)```", PAGE, re.DOTALL).group(1)
    routine = file.read(text, "week.toml")
    assert set(routine.activities) == {"Sleeping", "Toilet", "Relaxing"}
    table = PAGE[PAGE.index("### Words") : PAGE.index("### How it is acted")]
    steps = re.findall(r"`([^`]+)`", "".join(re.findall(r"^\| (`.*?) \|", table, re.MULTILINE)))
    told = {word for step in steps for word in words._WORDS if step.startswith(word)}
    assert told == set(words._WORDS)


def test_the_page_has_a_diary_that_can_be_read() -> None:
    rows = re.search(r"    start,end.*?(?=\n\n)", PAGE, re.DOTALL).group().replace("    ", "")
    assert [s.activity for s in timetable.read(rows, "diary.csv")[1]][1::2] == [
        "Toilet",
        "Relaxing",
    ]
