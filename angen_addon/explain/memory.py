# SPDX-License-Identifier: GPL-3.0-or-later
"""The explanation that panels show: of one sensor, until its recording goes."""

from __future__ import annotations

import weakref

from ...sensor_logic.recording.tracks import Recording
from ..scene.instances import Uid
from .facts import Explanation


class Memory:
    """Keeps the last explanation. It holds for the recording that it was made of, which undo, a
    file load and edits take away."""

    def __init__(self) -> None:
        self._of: weakref.ref[Recording] | None = None
        self._uid: Uid = 0
        self._kept: Explanation | None = None

    def keep(self, recording: Recording, uid: Uid, explanation: Explanation) -> None:
        """`uid`: session uid of the sensor's object."""
        self._of, self._uid, self._kept = weakref.ref(recording), uid, explanation

    def recall(self, recording: Recording, uid: Uid, index: int | None) -> Explanation | None:
        """The last explanation, if it is that of update `index` of this sensor; else None."""
        kept = self._kept
        if kept is None or self._of is None or self._of() is not recording:
            return None
        return kept if (self._uid, kept.index) == (uid, index) else None

    def clear(self) -> None:
        self._of, self._uid, self._kept = None, 0, None


MEMORY = Memory()
