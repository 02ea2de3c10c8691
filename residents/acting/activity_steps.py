# SPDX-License-Identifier: GPL-3.0-or-later
"""Parse the steps of a routine's activities, and check their names against the home's marks."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from ...sensor_logic.logs.error import InputError, explained
from ...sensor_logic.logs.toml_table import suggestion
from ..routine.file import VARIES
from ..routine.routine import AWAY, Routine, RoutineActivity, Spread, StepGroup, UsualUse, seconds
from ..routine.timetable import Stream
from .places import APPLIANCE, LIE, SIT, TAP, USE, Place, Places
from .timeline import AWAY as GONE
from .timeline import LYING, SITTING, STANDING

_DURATION = re.compile(r"\s+((?:\d+(?:\.\d+)?\s*(?:s|min|h)\s*)+)$")
# Each word of a step: the kind of its name, and whether a duration can follow.
_PLACE, _LEAF, _LAMP, _THING, _NONE = "place", "door or drawer", "lamp", "thing", ""
_WORDS = {
    "go": (_PLACE, True),
    "stand at": (_PLACE, True),
    "sit": (_PLACE, True),
    "lie": (_PLACE, True),
    "use": (_PLACE, True),
    "reach": (_PLACE, True),
    "open": (_LEAF, False),
    "close": (_LEAF, False),
    "switch": (_LAMP, False),
    "take": (_THING, False),
    "put": (_THING, False),
    "drink": (_THING, False),
    "wait": (_NONE, True),
    "turn over": (_NONE, False),
    "shift": (_NONE, False),
    "look around": (_NONE, True),
    "leave": (_NONE, False),
}
# The words after which a person is at their place, with the posture there.
POSTURES = {"go": STANDING, "stand at": STANDING, "use": STANDING, "sit": SITTING, "lie": LYING,
            "leave": GONE}  # fmt: skip
_CAT = {"go", "stand at", "sit", "lie", "use", "wait", "turn over", "shift", "look around"}
_NEEDS = {"turn over": (LYING,)}
# How long a step takes without a duration, and for how long a leaf is opened for a while, s.
USUAL, A_WHILE = 10.0, 6.0
# The spread of the durations at a place, by its use, and of those for which a leaf is open for a
# while; docs/residents.md tells where they are from.
SPREADS = {SIT: (0.4, 0.7), USE: (0.4, 0.4), TAP: (0.4, 0.4), APPLIANCE: (1.3, 0.5)}
LEAF_SPREAD = (0.67, 1.25)
# The largest side of a thing that a hand can carry, m.
LARGEST_THING_M = 1.0
# Default mean number of small movements in a row.
BURST = 3.0


@dataclass(frozen=True)
class ActivityStep:
    """A step of an activity, such as "sit sofa" or "switch lamp on".

    Attributes
    ----------
    word, name : str
        What to do, such as "sit", and the name of the object to do it with.
    lasts : float or None
        The median duration, s; None for the default. A leaf that is opened stays open if it is
        None.
    at : str
        The place at which an object is put down, or "".
    on : bool
        True to switch a lamp on, False to switch it off.
    where : str
        The step's position in the routine's file.
    varies : Spread or None
        The spread of the duration; None if the duration does not vary.
    """

    word: str
    name: str
    lasts: float | None
    at: str
    on: bool
    where: str
    varies: Spread | None = None

    def error(self, text: str) -> InputError:
        """Return an `InputError` that names the step and its position in the file."""
        return InputError(f"{self.where}: {' '.join([self.word, self.name]).strip()}: {text}")


def parse_step(
    text: str,
    where: str,
    places: Places,
    uses: Mapping[str, UsualUse],
    varies: Spread | None = None,
) -> ActivityStep:
    """Parse the text of a step; raise `InputError` for an unknown word or name.

    Error texts begin with `where`, the step's position in the file. `uses` is what the file says of
    places and leaves, and `varies` the spread of the duration, if the file gives it for this step.
    """
    word = next((w for w in _WORDS if text == w or text.startswith(w + " ")), None)
    if word is None:
        first = text.split(" ", maxsplit=1)[0]
        raise InputError(
            f"{where}: {text!r} does not begin with the word of a step; {suggestion(first, _WORDS)}"
        )
    kind, may_last = _WORDS[word]
    rest, lasts = text[len(word) :].strip(), None
    if may_last and (found := _DURATION.search(" " + rest)):
        rest = rest[: max(found.start() - 1, 0)].strip()
        with explained(f"{where}: {text}", ValueError):
            lasts = seconds(found.group(1))
    if word == "wait" and lasts is None:
        raise InputError(f'{where}: wait: give a duration, as in "wait 20 s"')
    at, on = "", False
    if word == "open":
        with explained(f"{where}: {text}", ValueError):
            rest, lasts = _open_for(rest)
    if word == "put":
        rest, _, at = rest.partition(" at ")
    if word == "switch":
        rest, _, state = rest.rpartition(" ")
        if state not in ("on", "off"):
            raise InputError(f'{where}: {text!r} must end with "on" or "off"')
        on = state == "on"
    step = ActivityStep(word, rest, lasts, at, on, where, varies)
    if kind == _NONE and rest:
        raise step.error(f"{rest!r} must be left out")
    expected = [(rest, kind)] if kind else []
    for name, one in [*expected, (at, _PLACE)] if word == "put" else expected:
        known = _marked_names(one, places)
        if not name:
            way = ', as in "put Cup at Table"' if word == "put" else ""
            raise step.error(f"the name of a {one} is missing{way}; {suggestion(name, known)}")
        if name not in known:
            raise step.error(f"no {one} is marked {name!r}; {suggestion(name, known)}")
        if one == _THING:
            _check_thing(step, places.places[name])
    return _with_usual_duration(step, places, uses)


def _open_for(rest: str) -> tuple[str, float | None]:
    """Return the name of a leaf that is opened, and for how long, s.

    The duration is None for a leaf that stays open, and 0 for one that is opened for a while. Raise
    `ValueError` if its parts are in the wrong order, as in "20 s 1 min".
    """
    name, _, long = rest.rpartition(" for ")
    if name and long == "a while":
        return name, 0.0
    if name and _DURATION.fullmatch(" " + long):
        return name, seconds(long)
    return rest, None


def _with_usual_duration(
    step: ActivityStep, places: Places, uses: Mapping[str, UsualUse]
) -> ActivityStep:
    """Return a step with the usual duration and spread where its text does not say them."""
    use = uses.get(step.name)
    lasts, varies = step.lasts, step.varies
    if step.word == "open" and lasts is not None:
        usual, spread = A_WHILE, LEAF_SPREAD
        lasts = lasts or None
    elif step.word in ("go", "stand at", "use", "sit", "lie") or (
        step.word == "reach" and lasts is not None
    ):
        usual, spread = USUAL, SPREADS.get(places.places[step.name].use, (VARIES, VARIES))
    else:
        return step
    if lasts is None and use is not None:
        lasts = use.lasts
    if lasts is None and step.word in ("open", "use"):
        lasts = usual
    if varies is None:
        varies = use.varies if use is not None and use.varies is not None else spread
    return replace(step, lasts=lasts, varies=varies)


def _check_thing(step: ActivityStep, thing: Place) -> None:
    """Raise `InputError` if an object cannot be carried: it must be marked as Use, and small."""
    if thing.use != USE:
        raise step.error(
            f"only objects whose Use is Use can be carried, and its Use is {thing.use.title()}"
        )
    if thing.size > LARGEST_THING_M:
        raise step.error(
            f"it is {thing.size:.1f} m large; only objects up to {LARGEST_THING_M:g} m can be "
            "carried"
        )


def _marked_names(kind: str, places: Places) -> Collection[str]:
    if kind == _LEAF:
        return places.doors.keys()
    return places.lamps.keys() if kind == _LAMP else places.places.keys()


def check_can_do(step: ActivityStep, places: Places, is_cat: bool) -> None:
    """Raise `InputError` for a step that a person, or a cat, cannot perform."""
    if is_cat and step.word not in _CAT:
        raise step.error(f"a cat cannot do this; its steps are {', '.join(sorted(_CAT))}")
    allowed = {"sit": (SIT, LIE), "lie": (LIE,)}.get(step.word)
    if not is_cat and allowed and places.places[step.name].use not in allowed:
        fits = sorted(name for name, place in places.places.items() if place.use in allowed)
        there = ", ".join(map(repr, fits)) or "none"
        raise step.error(f"this place is not marked for it; places to {step.word}: {there}")


@dataclass(frozen=True)
class RepeatedSteps:
    """Small movements that are repeated at random times during an activity.

    Attributes
    ----------
    steps : tuple of ActivityStep
        The movements; each time, one of them is drawn at random.
    every : float
        The mean time from one movement to the next, s.
    varies : float
        The standard deviation of the logarithm of the rests between bursts.
    burst : float
        The mean number of movements in a burst, which is several in a row.
    """

    steps: tuple[ActivityStep, ...]
    every: float
    varies: float
    burst: float


# The random numbers of a group of steps, by its name; `daily` are the same all day.
GroupDraws = Callable[[str, bool], Stream]


@dataclass(frozen=True)
class ParsedGroup:
    """A group of steps, as in `StepGroup`, with its steps parsed.

    `name` is the group's position in its activity, such as "2.0"; random numbers belong to it.
    """

    name: str
    rules: StepGroup
    items: tuple[ActivityStep | ParsedGroup, ...]

    def steps(self) -> Iterator[ActivityStep]:
        """Yield all steps, also those of alternatives."""
        for item in self.items:
            yield from [item] if isinstance(item, ActivityStep) else item.steps()

    def draw(self, draws: GroupDraws) -> Iterator[tuple[float | None, tuple[ActivityStep, ...]]]:
        """Yield the steps that are done at one time, each with the part of the activity then over.

        The part is None for steps that follow the step before.
        """
        rules, stream = self.rules, draws(self.name, False)
        if stream.uniform() >= rules.chance:
            return
        least, largest = rules.times
        for _ in range(least + int(stream.uniform() * (largest - least + 1))):
            items = self.items
            if rules.weights:
                drawn = draws(self.name, True) if rules.daily else stream
                items = (items[drawn.weighted_choice(rules.weights)],)
            if rules.any_order:
                left = list(items)
                items = tuple(left.pop(int(stream.uniform() * len(left))) for _ in items)
            if rules.share is None:
                yield from _drawn_items(items, draws)
                continue
            low, high = rules.share
            part = low + (high - low) * stream.uniform()
            yield part, tuple(step for _, steps in _drawn_items(items, draws) for step in steps)


def _drawn_items(
    items: Iterable[ActivityStep | ParsedGroup], draws: GroupDraws
) -> Iterator[tuple[float | None, tuple[ActivityStep, ...]]]:
    """Yield what is done of steps and groups, as `ParsedGroup.draw` does."""
    for item in items:
        if isinstance(item, ActivityStep):
            yield None, (item,)
        else:
            yield from item.draw(draws)


@dataclass(frozen=True)
class DrawnSteps:
    """What is done each time that an activity is begun.

    Attributes
    ----------
    steps : tuple of ActivityStep
        The steps that are done in order, as soon as the activity begins.
    timed : tuple
        Further steps, each with the part of the activity (0 to 1) after which they are done.
    place, posture : str or None
        The place and posture in which the steps in order end; None if no step gives one.
    """

    steps: tuple[ActivityStep, ...]
    timed: tuple[tuple[float, tuple[ActivityStep, ...]], ...]
    place: str | None
    posture: str | None

    @property
    def all_steps(self) -> tuple[ActivityStep, ...]:
        """The steps in order, and then the timed ones in the order of their times."""
        return (*self.steps, *(step for _, steps in self.timed for step in steps))


def _rest(word: str, an_hour: float) -> RepeatedSteps:
    """Return a movement that is repeated so often an hour on average."""
    step = ActivityStep(word, "", None, "", False, "")
    varies = 1.0
    # `every` is a median; the mean of a log-normal rest is longer.
    return RepeatedSteps((step,), 3600.0 / an_hour / math.exp(varies**2 / 2), varies, 1.0)


# How somebody moves who rests and of whom the routine says nothing, by posture.
RESTS = {
    # 1.6 (sd 0.7) changes of posture an hour: Skarpsno et al., Nature and Science of Sleep 9, 2017.
    # Smaller movements are assumed.
    LYING: (_rest("turn over", 1.6), _rest("shift", 3.0)),
    # 7.8 (sd 5.2) an hour: Reenalda et al., J. Rehabilitation Research and Development 46(5), 2009.
    SITTING: (_rest("shift", 7.8),),
}


@dataclass(frozen=True)
class ActivitySteps:
    """The steps of an activity: those that are done when it begins, and those repeated then."""

    items: tuple[ActivityStep | ParsedGroup, ...]
    meanwhile: tuple[RepeatedSteps, ...]
    usual_rest: bool = False

    def rests(self, posture: str | None) -> tuple[RepeatedSteps, ...]:
        """Return how somebody who rests in a posture moves, if the routine leaves it open."""
        return RESTS.get(posture or "", ()) if self.usual_rest else ()

    @property
    def places(self) -> set[str]:
        """The names of the places at which a step has the person stand, sit, lie or work."""
        return {step.name for step in self.all_steps if step.word in POSTURES}

    @property
    def all_steps(self) -> tuple[ActivityStep, ...]:
        """All steps, also those of alternatives: first in order, then those repeated."""
        first = ParsedGroup("", StepGroup((), ()), self.items).steps()
        return (*first, *(step for one in self.meanwhile for step in one.steps))

    def draw(self, draws: GroupDraws) -> DrawnSteps:
        """Draw what is done this time. Without groups of steps no random number is drawn."""
        steps: list[ActivityStep] = []
        timed: list[tuple[float, tuple[ActivityStep, ...]]] = []
        for part, some in _drawn_items(self.items, draws):
            if part is None:
                steps += some
            else:
                timed.append((part, some))
        place: str | None = None
        posture: str | None = None
        for step in steps:
            if step.word in POSTURES:
                place, posture = step.name, POSTURES[step.word]
        timed.sort(key=lambda one: one[0])
        return DrawnSteps(tuple(steps), tuple(timed), place, posture)


def read_activities(routine: Routine, places: Places) -> Mapping[str, ActivitySteps]:
    """Return the steps of each activity by its name, with an activity for being away added.

    Raises `InputError` for a step that cannot be parsed.
    """
    for name, use in routine.uses.items():
        known = {*places.places, *places.doors}
        if name not in known:
            raise InputError(f"{use.where}: nothing is marked {name!r}; {suggestion(name, known)}")
    found = {
        name: _parse_activity(activity, places, routine.uses)
        for name, activity in routine.activities.items()
    }
    found[AWAY] = ActivitySteps((ActivityStep("leave", "", None, "", False, AWAY),), ())
    return found


def _parse_activity(
    activity: RoutineActivity, places: Places, uses: Mapping[str, UsualUse]
) -> ActivitySteps:
    where = activity.where or (activity.name,) * len(activity.do)
    items, postures = _parse_items(activity.do, where, places, uses, {None}, "", None)
    meanwhile = []
    for one in activity.meanwhile:
        lines = zip(one.do, one.where or (activity.name,) * len(one.do), strict=True)
        among = tuple(parse_step(text, at, places, uses) for text, at in lines)
        for step in among:
            _check_posture(step, postures)
            _check_stays(step)
        usual = 1.0 if any(step.word in POSTURES for step in among) else BURST
        meanwhile.append(RepeatedSteps(among, one.every, one.varies, one.burst or usual))
    return ActivitySteps(items, tuple(meanwhile), activity.usual_rest)


def _parse_items(
    do: Sequence[str | StepGroup], where: Sequence[str], places: Places,
    uses: Mapping[str, UsualUse],
    postures: set[str | None], name: str, varies: Spread | None,
    among: bool = False, timed: bool = False,
) -> tuple[tuple[ActivityStep | ParsedGroup, ...], set[str | None]]:  # fmt: skip
    """Parse steps and groups; return them, and the postures in which a person can be afterwards.

    `postures` are those before. `among` is whether they are alternatives, and `timed` whether they
    are done at a time of their own.
    """
    items: list[ActivityStep | ParsedGroup] = []
    before = postures
    ends: set[str | None] = set()
    for number, (one, at) in enumerate(zip(do, where, strict=True)):
        if isinstance(one, str):
            step = parse_step(one, at, places, uses, varies)
            _check_posture(step, postures)
            if timed:
                _check_stays(step)
            items.append(step)
            after: set[str | None] = postures
            if step.word in POSTURES:
                after = {POSTURES[step.word]}
        else:
            path = f"{name}.{number}" if name else str(number)
            spread, later = one.varies or varies, timed or one.share is not None
            parts, after = _parse_items(
                one.do, one.where, places, uses, postures, path, spread, bool(one.weights), later
            )
            items.append(ParsedGroup(path, one, parts))
            if one.share is not None:
                after = postures
            elif one.chance < 1.0 or not one.times[0] or one.any_order:
                after = after | postures
        if among:
            ends |= after
            after = before
        postures = after
    return tuple(items), ends if among else postures


def _check_stays(step: ActivityStep) -> None:
    """Raise `InputError` for the step "leave" during an activity."""
    if step.word == "leave":
        raise step.error(
            'the step "leave" cannot be repeated during an activity; make it a separate activity'
        )


def _check_posture(step: ActivityStep, postures: set[str | None]) -> None:
    needed = _NEEDS.get(step.word)
    if needed and not postures.intersection(needed):
        raise step.error(f"the person must be {' or '.join(needed)}: add a step before it")
