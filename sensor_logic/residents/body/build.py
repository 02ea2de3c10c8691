# SPDX-License-Identifier: GPL-3.0-or-later
"""The build of a resident: sorts, sizes, speeds."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Sort(StrEnum):
    """The sorts of residents."""

    OLDER_ADULT = "OLDER_ADULT"
    ADULT = "ADULT"
    CHILD = "CHILD"
    CAT = "CAT"


@dataclass(frozen=True)
class Build:
    """One resident's body. Stature in m (of a cat: the height of its back), mass in kg, the speed
    of its usual walk in m/s; `frame`: walks with a walking frame."""

    sort: Sort
    stature: float
    mass: float
    speed: float
    frame: bool = False

    @property
    def scale(self) -> float:
        """The scale of the bones against the skeleton's."""
        return self.stature / SKELETON_STATURE[self.sort]

    @property
    def stoop(self) -> float:
        """How far the back is bent forward on its feet, rad."""
        return 0.14 if self.sort is Sort.OLDER_ADULT else 0.0

    @property
    def is_cat(self) -> bool:
        return self.sort is Sort.CAT

    @property
    def step_length(self) -> float:
        """m from one foot's landing to the other's at the usual speed.

        Steps grow with the root of the speed, about: 0.60 m at 1.1 m/s for an adult.
        """
        pace = self.speed / (1.1 * self.scale**0.5)
        return float(0.60 * self.scale * pace**0.5)


# How much larger a child's head is against its bones.
CHILD_HEAD = 1.29
# The stature of one with the skeleton's own bones, m: 1.535 to the head's joint, 0.2 above it.
SKELETON_STATURE = {
    Sort.OLDER_ADULT: 1.735,
    Sort.ADULT: 1.735,
    Sort.CHILD: 1.535 + 0.2 * CHILD_HEAD,
    Sort.CAT: 0.25,
}
OLDER_ADULT = Build(Sort.OLDER_ADULT, 1.65, 68.0, 0.85)
ADULT = Build(Sort.ADULT, 1.735, 72.0, 1.1)
CHILD = Build(Sort.CHILD, 1.22, 23.0, 1.0)
CAT = Build(Sort.CAT, 0.25, 4.5, 0.55)
USUAL = {build.sort: build for build in (OLDER_ADULT, ADULT, CHILD, CAT)}
