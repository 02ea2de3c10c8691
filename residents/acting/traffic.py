# SPDX-License-Identifier: GPL-3.0-or-later
"""The people in a home, and who is in whose way.

People check their paths before they walk, so that they do not walk through each other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...sensor_logic.model import Array
from .actor import Actor
from .timeline import LYING, SITTING

# Least distance between the middles of two people, m. People at two places less than AT_PLACE, but
# more than SAME_PLACE apart are no obstacle to each other.
APART, AT_PLACE, SAME_PLACE = 0.42, 0.6, 0.3
# Two people who block each other notice after AGREED s that one must step aside.
AGREED = 2.0


@dataclass(frozen=True, eq=False)
class Clash:
    """A person who is in the way of another person.

    Attributes
    ----------
    at : array, shape (2,)
        The point at which the person is in the way, m.
    since, until : float
        The person is there from `since` until at least `until`, s.
    who : Actor
        The person in the way.
    """

    at: Array
    since: float
    until: float
    who: Actor

    def is_standing_at(self, time: float) -> bool:
        """Return whether the person in the way stands still at a time, s."""
        return self.since <= time


@dataclass(frozen=True, eq=False)
class BlockedWalk:
    """The path (n, 2) on which a person waits for others to pass, and since when, s."""

    path: Array
    since: float


class Traffic:
    """The people in a home, and the walks that other people block.

    Attributes
    ----------
    people : list of Actor
        The persons and cats.
    """

    def __init__(self) -> None:
        self.people: list[Actor] = []
        self._blocked: dict[str, BlockedWalk] = {}
        # The names of the people who had no room when they should last step aside.
        self._cornered: set[str] = set()

    def others(self, person: Actor) -> list[Actor]:
        """Return all people who can be in the way of `person`."""
        return [other for other in self.people if other is not person and not other.is_ignored]

    def find_clash(self, person: Actor, path: Array) -> Clash | None:
        """Return the first clash on a path that `person` begins to walk now.

        Parameters
        ----------
        person : Actor
            The person who walks.
        path : array, shape (n, 2)
            The corner points of the path, m.

        Returns
        -------
        Clash or None
            The first person in the way; None if nobody is.
        """
        others = self.others(person)
        lengths = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])
        if person.is_ignored or not others or not lengths[-1]:
            return None
        along = np.arange(0.0, lengths[-1] + 0.1, 0.1)
        here = np.column_stack([np.interp(along, lengths, path[:, k]) for k in (0, 1)])
        times = person.now + 0.3 + along / person.build.speed
        for other in others:
            there = other.body.positions_at(times)
            near = np.hypot(*(here - there).T) < APART
            # People at the next place, or beside the start, are not in the way.
            ends = (np.hypot(*(there - path[-1]).T) < AT_PLACE) & (
                np.hypot(*(there - path[-1]).T) > SAME_PLACE
            )
            beside = np.hypot(*(there - path[0]).T) < AT_PLACE
            # People who sit or lie are not on the walkable floor.
            rests = (other.posture in (SITTING, LYING)) & (times >= other.body.arrived)
            in_way = np.flatnonzero(near & ~ends & ~beside & ~rests)
            if len(in_way):
                return Clash(there[in_way[0]], other.body.arrived, other.now, other)
        return None

    def will_come_near(self, other: Actor, person: Actor) -> bool:
        """Return whether another person's path comes near to `person` in the next 3.5 s."""
        times = person.now + np.linspace(0.0, 3.5, 8)
        off = other.body.positions_at(times) - person.body.positions_at(np.array([person.now]))
        return other.now > person.now and float(np.hypot(*off.T).min()) < 2 * APART

    # People who block each other.

    def block(self, person: Actor, path: Array) -> None:
        """Record that others now block the person's path (n, 2), given by closely spaced points."""
        known = self._blocked.get(person.name)
        since = person.now if known is None else known.since
        self._blocked[person.name] = BlockedWalk(path, since)

    def unblock(self, person: Actor) -> None:
        """Record that the person waits for nobody; do nothing if that is known."""
        self._blocked.pop(person.name, None)

    def blocked_path(self, person: Actor) -> Array | None:
        """Return the path (n, 2) on which a person waits for others to pass, or None."""
        blocked = self._blocked.get(person.name)
        return None if blocked is None else blocked.path

    def record_cornered(self, person: Actor, cornered: bool) -> None:
        """Record whether a person has no room to step aside."""
        (self._cornered.add if cornered else self._cornered.discard)(person.name)

    def is_cornered(self, person: Actor) -> bool:
        """Return whether a person had no room when the person should last step aside."""
        return person.name in self._cornered

    def person_to_let_pass(self, person: Actor) -> Actor | None:
        """Return the person for whom `person` should step aside now, or None.

        Of two people who wait for each other, the one who has waited less steps aside.
        """
        here = person.body.positions_at(np.array([person.now]))[0]
        waiting = [
            (blocked.since, other)
            for other in self.others(person)
            if (blocked := self._blocked.get(other.name)) is not None
            and float(np.hypot(*(blocked.path - here).T).min()) < APART
        ]
        since, other = min(waiting, key=lambda entry: entry[0], default=(0.0, None))
        if other is None or person.now < since + AGREED:
            return None
        own = self._blocked.get(person.name)
        first = own is not None and (own.since, person.name) < (since, other.name)
        return None if first and not self.is_cornered(other) else other
