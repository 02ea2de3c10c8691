# SPDX-License-Identifier: GPL-3.0-or-later
"""`angen learn ACTIVITIES`: learns habits from a log, and draws days; needs no Blender."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ...angen_addon.process.console import DONE, note
from ...angen_addon.process.parser import Parser, argument_type, path, tells_errors, whole_number
from ...sensor_logic.logs.error import InputError, explained
from ...sensor_logic.logs.files import check_folder, read_text, write_files
from ...sensor_logic.logs.formats import activities
from ...sensor_logic.logs.formats.activities import SOMEBODY, DoneActivity
from ...sensor_logic.logs.formats.label_map import read_map
from ...sensor_logic.logs.formats.outputs import check_apart
from ...sensor_logic.logs.log import parse_date
from ...sensor_logic.logs.wording import named, plural
from ..routine import file
from ..routine.learn import LivedDays, learn, lived_days
from ..routine.routine import AWAY, Person, Routine, RoutineActivity
from ..routine.text import diary_texts, duration, routine_text
from ..routine.timetable import OTHER, timetable

# What stands in for the steps of an activity: one stays where one is.
NO_STEPS = ("wait 5 s",)
# In the labels of an activity: what the log calls it.
VOCABULARY = "log"
UNSAID = "Say in 'do' what is done: until then one stays where one is."


@tells_errors
def main(arguments: list[str], program: str) -> int:
    """Learn habits, and return the exit status.

    `arguments` are those after `learn`. `program` is the text before `learn` in the help. Raise
    SystemExit if the arguments are wrong.
    """
    options = make_parser(program).parse_args(arguments)
    sources = [p for p in (options.activities, options.routine, options.labels) if p]
    if options.out is None and options.diaries is None:
        raise InputError("learn has nothing to write: give --out, --diaries or both")
    if options.out is not None:
        check_apart("--out", options.out, sources)
    if options.diaries is None:
        write_files(_learnt(options))
        return DONE
    folder = options.diaries[1]
    check_folder(folder if folder.exists() else folder.parent, "--diaries")
    written = _learnt(options)
    kept = set(folder.glob("*.csv")) - written.keys()
    if kept or folder.resolve() in {source.resolve().parent for source in sources}:
        raise InputError(f"--diaries: {folder} has other files than these diaries; name a new one")
    folder.mkdir(exist_ok=True)
    write_files(written)
    return DONE


def _learnt(options: argparse.Namespace) -> dict[Path, str]:
    """Return the texts of the files that the options ask for: a routine, and diaries.

    Raise `InputError` if a file is wrong, or OSError if it cannot be read.
    """
    found, notes = activities.read(options.activities)
    for text in notes:
        note(text)
    labels = read_map(options.labels).labels if options.labels else {}
    home = file.read(read_text(options.routine), str(options.routine)) if options.routine else None
    renamed = [one._replace(activity=labels.get(one.activity, one.activity)) for one in found]
    persons = _persons(renamed, options.person, home)
    lived, learnt = {}, []
    for person, done in persons:
        with explained(str(options.activities), InputError):
            lived[person.name] = lived_days(done)
            learnt.append(learn(lived[person.name], person))
    text = _routine_text(options, _joined(learnt), lived, home, _words(found, labels))
    written = {} if options.out is None else {options.out: text}
    if options.diaries is not None:
        days, folder = options.diaries
        start = options.start or min(min(log.begun) for log in lived.values())
        segments = timetable(file.read(text, "the learnt routine"), start, days, options.seed)
        texts = diary_texts(segments, start, days, OTHER)
        written |= {folder / name: diary for name, diary in texts.items()}
    return written


def _persons(
    found: Iterable[DoneActivity], wanted: str | None, home: Routine | None
) -> list[tuple[Person, list[DoneActivity]]]:
    """Return the persons of a log with what they did; those of a home's routine if it has them."""
    by_name: dict[str, list[DoneActivity]] = {}
    for one in found:
        by_name.setdefault(one.person, []).append(one)
    if wanted is not None:
        if wanted not in by_name:
            raise InputError(f"nobody is called {wanted!r}: there are {named(sorted(by_name))}")
        by_name = {wanted: by_name[wanted]}
    known = dict(home.persons) if home else {}
    people = []
    for name, done in sorted(by_name.items()):
        person = known.get(name)
        if person is None and len(by_name) == 1 and known:
            person = next(iter(known.values()))
        person = person or Person(name or SOMEBODY, name or SOMEBODY, False, "")
        people.append((replace(person, visitor=False), done))
    return people


def _joined(routines: Iterable[Routine]) -> Routine:
    """Return the routine of all persons."""
    found = Routine({}, {}, (), (), (), ())
    for one in routines:
        found = Routine(
            {**found.persons, **one.persons},
            {**found.activities, **one.activities},
            found.plans + one.plans,
            found.fillers + one.fillers,
            found.interruptions + one.interruptions,
            (),
        )
    return found


def _words(found: Iterable[DoneActivity], labels: Mapping[str, str]) -> dict[str, set[str]]:
    """Return the words of the log for each activity."""
    words: dict[str, set[str]] = {}
    for one in found:
        words.setdefault(labels.get(one.activity, one.activity), set()).add(one.activity)
    return words


def _routine_text(
    options: argparse.Namespace,
    routine: Routine,
    lived: Mapping[str, LivedDays],
    home: Routine | None,
    words: Mapping[str, set[str]],
) -> str:
    """Return the routine as TOML; a note names the activities whose steps are unknown."""
    known = _by_word(home.activities.values()) if home else {}
    found: dict[str, RoutineActivity] = {}
    said, unknown = {}, []
    for name in routine.activities:
        if name == AWAY:
            continue
        like = known.get(_plain(name))
        labels = dict(like.labels) if like else {}
        word = words.get(name, set())
        if len(word) == 1 and word != {name}:
            labels[VOCABULARY] = min(word)
        said[name] = _summary(name, lived.values())
        if like is None and name != OTHER:
            unknown.append(name)
            said[name] += f"\n{UNSAID}"
        steps = like or RoutineActivity(name, NO_STEPS)
        found[name] = replace(steps, name=name, labels=labels)
    if unknown and home:
        note(
            f"{options.routine} has no activity for {named(unknown, len(unknown))}: add what is "
            "done to it, or name another of its activities with --labels"
        )
    elif unknown and options.out is not None:
        note(f"fill in what is done ('do') in {options.out}, or give the home's --routine")
    days = max(len(log.begun) for log in lived.values())
    about = [
        f"Habits of {plural(days, 'day')}, learnt by `angen learn` from {options.activities.name}.",
        "docs/residents.md tells what each word means.",
    ]
    uses = home.uses if home else {}
    return routine_text(replace(routine, activities=found, uses=uses), about, said)


def _by_word(known: Iterable[RoutineActivity]) -> dict[str, RoutineActivity]:
    """Return activities by their names and labels, of which the names count first."""
    found: dict[str, RoutineActivity] = {}
    for activity in known:
        for label in activity.labels.values():
            found.setdefault(_plain(label), activity)
    return found | {_plain(activity.name): activity for activity in known}


def _plain(name: str) -> str:
    """Return a name in lower case, without spaces, hyphens and underscores."""
    return re.sub(r"[\s_-]", "", name).lower()


def _summary(name: str, lived: Iterable[LivedDays]) -> str:
    """Return a sentence on how often and how long an activity was done."""
    logs = list(lived)
    lasts = [b.lasts for log in logs for day in log.begun.values() for b in day
             if b.activity == name]  # fmt: skip
    days = sum(len(log.begun) for log in logs)
    if not lasts:
        return "Only when the night's rest is interrupted."
    low, middle, high = (duration(float(q)) for q in np.quantile(lasts, (0.1, 0.5, 0.9)))
    return f"{len(lasts) / days:.1f} times a day, for {middle} ({low} to {high})."


class Diaries(argparse.Action):
    """Reads the number of diaries and their folder."""

    def __call__(self, parser: Any, options: Any, values: Any, flag: Any = None) -> None:
        """Store both as a pair."""
        try:
            setattr(options, self.dest, (whole_number(1, 10_000)(values[0]), path(values[1])))
        except argparse.ArgumentTypeError as error:
            raise argparse.ArgumentError(self, str(error)) from None


def make_parser(program: str) -> Parser:
    """Return the argument parser of `angen learn`."""
    parser = Parser(
        prog=f"{program} learn",
        description="Learn habits from a log of activities, and write them as a routine or as "
        "drawn days.",
    )
    parser.add_argument(
        "activities",
        type=path,
        metavar="ACTIVITIES",
        help="table with the columns start, end and activity; lines of start, end and activity; "
        "CASAS text with begin and end; a folder of days, of diaries, or of pyadlml",
    )
    parser.add_argument("--out", type=path, metavar="ROUTINE.toml", help="file for the routine")
    parser.add_argument(
        "--routine",
        type=path,
        metavar="FILE.toml",
        help="a routine of the home: its persons, and the steps of its activities",
    )
    parser.add_argument(
        "--labels",
        type=path,
        metavar="FILE.toml",
        help="table [labels] with other names for the log's activities",
    )
    parser.add_argument("--person", metavar="NAME", help="learn only from what this person did")
    parser.add_argument(
        "--diaries",
        action=Diaries,
        nargs=2,
        metavar=("N", "DIR"),
        help="draw N days, and write each as a diary into a folder, for `day --diary`",
    )
    parser.add_argument(
        "--start",
        type=argument_type(parse_date),
        metavar="DATE",
        help="date of the first diary (default: the log's)",
    )
    parser.add_argument(
        "--seed",
        type=whole_number(0, 0x7FFFFFFF),
        default=0,
        metavar="S",
        help="seed of the random draws of diaries (default 0)",
    )
    return parser
