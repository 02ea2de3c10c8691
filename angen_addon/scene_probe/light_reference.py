# SPDX-License-Identifier: GPL-3.0-or-later
"""What the light paths of an update miss, told by many more paths in a scene that is like it.

A control variate: the reference scene is the home as it stands at its first frame, in the present
light of its lamps. Its picture by the update's own few paths, with the same random numbers, errs
much as the update's picture does; by many paths it hardly errs. Their difference corrects the
update's picture. Whatever moved since the first frame, it adds no bias: what moved only makes the
two errors less alike. As long as the lamps stay as they are the difference is known, so many paths
are traced once for each state of the lamps, not for each update.

Cycles sends a path's shadow rays to one of all lamps, and to the sun most often, also in rooms that
it does not reach. So where there are suns and other lamps the many paths are traced for each of the
two apart. What neither of them brings, such as glowing things, is in both, and taken away once.

Errors grow with the light. Where it is darker than in the reference, as at night or behind a door
that was shut, the difference is taken in proportion: a closed box reads nothing, whatever day it
was at the first frame. Such a ratio has a bias of the second order in the errors.

Glasserman, Monte Carlo Methods in Financial Engineering, section 4.1, on control variates;
Cochran, Sampling Techniques, chapter 6, on ratio estimates;
Rousselle, Jarosz, Novák, Image-space control variates for rendering, 2016, on pictures.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from enum import Enum
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ..animation import is_animated
from .light_scene import LightScene, is_portal, must_be_frozen, shown_objects
from .light_values import lamp_values
from .zones import has_simulation_zone

Array = NDArray[np.float64]
# What these make depends on the frames before, and those a reference does not go through.
PHYSICS = {"CLOTH", "DYNAMIC_PAINT", "FLUID", "PARTICLE_SYSTEM", "SOFT_BODY"}
Taken = tuple["ReferenceScene", Any]
# Whose drivers can look at a frame; those of lamps do not matter.
DRIVEN = (
    "armatures",
    "curves",
    "materials",
    "meshes",
    "node_groups",
    "objects",
    "shape_keys",
    "worlds",
)
# Of each request, what few and what many light paths find.
Found = list[tuple[Array, Array]]


class Part(Enum):
    """What shines in a reference: all; or all but the suns and the world, all but the other
    lamps, all but both."""

    ALL = "all"
    ROOM = "room"
    DAY = "day"
    REST = "rest"


class ReferenceScene(LightScene):
    """The home at its first frame, without what physics moves, with lamps of its own."""

    def __init__(self, scene: Any, view_layer: Any, part: Part = Part.ALL) -> None:
        super().__init__(scene, view_layer)
        self._part = part
        # Each with its copy here, and the values that this has.
        self._lamps: list[tuple[Any, Any, str]] = []

    def light_lamps(self) -> None:
        """Sets the lamps as the user's are now; they stand where they stood at the first frame."""
        for number, (original, own, values) in enumerate(self._lamps):
            now = repr(lamp_values(original.data))
            if values != now:
                before, own.data = own.data, self._lamp_of(original)
                self.disown(before)
                self._lamps[number] = original, own, now

    def _stand_at_moment(self, user: Any) -> None:
        if self.scene.frame_current != user.frame_start:
            self.scene.frame_current = user.frame_start

    def _stand_in(self, obj: Any) -> Any:
        if must_be_frozen(obj) or any(_goes_through_frames(m) for m in obj.modifiers):
            return None
        if obj.type != "LIGHT":
            return obj
        if self._leads_nowhere(obj) or self._part not in (
            Part.ALL,
            Part.DAY if _is_of_day(obj) else Part.ROOM,
        ):
            return None
        own = self._copy_of(obj)
        own.data = self._lamp_of(obj)
        self._lamps.append((obj, own, repr(lamp_values(obj.data))))
        return own

    def _world(self) -> None:
        if self._part in (Part.ALL, Part.DAY):
            super()._world()

    def _is_seen(self, path: str) -> bool:
        """What is animated says what is now."""
        return not is_animated(self._user_scene, path)

    def _lamp_of(self, obj: Any) -> Any:
        """A copy of a lamp's data and nodes as they are now, and stay."""
        own = self.own(obj.data.copy())
        own.animation_data_clear()
        if own.node_tree is not None:
            own.node_tree.animation_data_clear()
        return own


class Reference:
    """The reference of one picture.

    `few`, `many`: a scene with its picture each, as Cycles draws other random numbers in a scene
    whose number of light paths has been another before. `once`: makes one of many paths for a part;
    None where all lamps are measured together.
    """

    def __init__(
        self, few: Taken, many: Taken, once: Callable[[Part], Taken] | None = None
    ) -> None:
        self._few, self._many, self._once = few, many, once
        self._rest: list[Array] | None = None
        self._days: dict[Hashable, list[Array]] = {}

    def light(self, suns: Hashable) -> Found:
        """What few and many light paths find of each request, the lamps being as they are now, the
        `suns` among them in that state."""
        few, many = _light(self._few), _light(self._many)
        if self._once is not None:
            if suns not in self._days:
                self._days.clear()
                self._days[suns] = _light_once(self._once(Part.DAY))
            if self._rest is None:
                self._rest = _light_once(self._once(Part.REST))
            days = zip(many, self._days[suns], self._rest, strict=True)
            many = [room + day - rest for room, day, rest in days]
        return list(zip(few, many, strict=True))

    def close(self) -> None:
        self._few[0].close()
        self._many[0].close()


def _light(taken: Taken) -> list[Array]:
    light_scene, picture = taken
    light_scene.light_lamps()
    return picture.light()


def _light_once(taken: Taken) -> list[Array]:
    try:
        return _light(taken)
    finally:
        taken[0].close()


def corrected(light: Array, few: Array, many: Array) -> Array:
    """What few paths found, with what many find beyond few in the reference; never negative."""
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(light < few, light / few, 1.0)
        more = share * (many - few)
    # What is no number is told where it is read.
    return light + np.nan_to_num(more, nan=0.0, posinf=0.0, neginf=0.0)


def states_of_lamps(view_layer: Any) -> tuple[tuple[Hashable, ...], tuple[Hashable, ...]]:
    """What a reference takes over at the present frame from the suns, and from the other lamps."""
    suns: list[Hashable] = []
    others: list[Hashable] = []
    for obj in shown_objects(view_layer):
        if obj.type == "LIGHT" and not must_be_frozen(obj):
            state = obj.session_uid, repr(lamp_values(obj.data))
            (suns if _is_of_day(obj) else others).append(state)
    return tuple(suns), tuple(others)


def _is_of_day(obj: Any) -> bool:
    """A sun, or a portal: that guides paths to the world."""
    return bool(obj.data.type == "SUN") or is_portal(obj)


def looks_at_frame() -> bool:
    """Whether a driver asks the user's scene for its frame: no other scene can stand at the first
    one for it."""
    for group in DRIVEN:
        for datablock in getattr(bpy.data, group):
            for owner in (datablock, getattr(datablock, "node_tree", None)):
                animation = getattr(owner, "animation_data", None)
                if animation is not None and any(map(_asks_for_frame, animation.drivers)):
                    return True
    return False


def _asks_for_frame(curve: Any) -> bool:
    return any(
        target.id_type == "SCENE" and target.data_path.startswith("frame_")
        for variable in curve.driver.variables
        for target in variable.targets
    )


def _goes_through_frames(modifier: Any) -> bool:
    return modifier.type in PHYSICS or has_simulation_zone(modifier)
