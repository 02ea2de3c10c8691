# SPDX-License-Identifier: GPL-3.0-or-later
"""The text of a reading and the icon of its state, which panels, table and view share.

States differ by icon and by word, never by colour alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

ACTIVE, IDLE, OFF, DOUBTFUL, WRONG = "RADIOBUT_ON", "RADIOBUT_OFF", "X", "QUESTION", "ERROR"
UNKNOWN, OLD, BAKED, NOT_SURE = "DOT", "TIME", "KEYFRAME_HLT", "SORTTIME"


class ReadingText(NamedTuple):
    """Texts for one reading.

    Attributes
    ----------
    text
        The full text.
    icon
        The icon of the state.
    problem
        Why the reading is missing or not valid; empty if it is valid.
    fields
        The values that the sensor publishes, by name; None if unknown.
    recorded
        True if the reading is from the recording, False if it is live.
    brief
        A text for narrow columns.
    origin
        A text that says where the reading comes from.
    old
        Why the reading is out of date, and how to update it; empty if it is up to date.
    keys
        The value of baked keyframes.
    age
        How long ago the reading was made.
    """

    text: str
    icon: str
    problem: str = ""
    fields: Mapping[str, Any] | None = None
    recorded: bool = False
    brief: str = ""
    origin: str = ""
    old: str = ""
    keys: str = ""
    age: str = ""

    @property
    def short(self) -> str:
        """The brief text with the age of the reading, for columns of medium width."""
        return ", ".join(filter(None, (self.brief or self.text, self.age)))
