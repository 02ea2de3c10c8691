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

Where the light departs far from the reference's, the two errors need not be alike any more: that
reading is taken anew by several times the paths, and corrected by what as many miss in the
reference. As its few paths say themselves whether it departs, those that find too little of what is
new are not found out: readings near that limit are biased a little low.

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

from ...animation import is_animated
from .frozen import Simulated
from .picture import Steps
from .scene import LightScene, is_portal, must_be_frozen, shown_objects
from .values import lamp_values

Array = NDArray[np.float64]
Taken = tuple["ReferenceScene", Any]
# States of the suns and of the other lamps.
Lamps = tuple[tuple[Hashable, ...], tuple[Hashable, ...]]
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
# Where more of the light than this share has come or gone since the first frame, the errors of few
# paths are not much alike.
ALIKE = 0.1
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

    def __init__(
        self,
        scene: Any,
        view_layer: Any,
        part: Part = Part.ALL,
        simulated: Simulated | None = None,
    ) -> None:
        super().__init__(scene, view_layer, simulated)
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

    def _stand_ins(self, obj: Any) -> list[Any]:
        if must_be_frozen(obj, self._simulated):
            return []
        if obj.type != "LIGHT":
            return [obj]
        if self._leads_nowhere(obj) or self._part not in (
            Part.ALL,
            Part.DAY if _is_of_day(obj) else Part.ROOM,
        ):
            return []
        own = self.own(obj.copy())
        own.data = self._lamp_of(obj)
        self._lamps.append((obj, own, repr(lamp_values(obj.data))))
        return [own]

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

    `make(part, paths)`: a new scene with its picture, by the picture's own few light paths where
    none are given. Few and many have a scene each, as Cycles draws other random numbers in a scene
    whose number of light paths has been another before. `apart`: many paths are traced for suns and
    other lamps each by themselves. Without `many`, it can say what few find.
    """

    def __init__(self, make: Callable[..., Taken], many: int = 0, apart: bool = False) -> None:
        self._make, self._apart, self._paths = make, apart, many
        self._few = make(Part.ALL)
        self._many = make(Part.ROOM if apart else Part.ALL, many) if many else None
        self._rest: list[Array] | None = None
        self._days: dict[Hashable, list[Array]] = {}

    def by_few(self) -> list[Array]:
        """What few light paths find of each request, the lamps being as they are now."""
        return _light(self._few)

    def light(self, suns: Hashable) -> Steps[Found]:
        """What few and many light paths find of each request, the lamps being as they are now, the
        `suns` among them in that state."""
        assert self._many is not None
        doing = f"the light's reference, {self._paths} paths"
        yield doing
        few = self.by_few()
        yield doing
        many = _light(self._many)
        if self._apart:
            if suns not in self._days:
                self._days.clear()
                yield doing
                self._days[suns] = _light_once(self._make(Part.DAY, self._paths))
            if self._rest is None:
                yield doing
                self._rest = _light_once(self._make(Part.REST, self._paths))
            days = zip(many, self._days[suns], self._rest, strict=True)
            many = [room + day - rest for room, day, rest in days]
        return list(zip(few, many, strict=True))

    def close(self) -> None:
        for taken in (self._few, self._many):
            if taken is not None:
                taken[0].close()


def _light(taken: Taken) -> list[Array]:
    light_scene, picture = taken
    light_scene.light_lamps()
    return picture.light()


def _light_once(taken: Taken) -> list[Array]:
    try:
        return _light(taken)
    finally:
        taken[0].close()


def departs(light: Array, few: Array) -> bool:
    """Whether the light is so unlike the reference's that its errors may be too, such as where
    somebody stands close to the sensor or its lamp."""
    change = np.abs(light.sum() - few.sum())
    return bool(change > ALIKE * few.sum())


def corrected(light: Array, few: Array, many: Array) -> Array:
    """What few paths found, with what many find beyond few in the reference; never negative."""
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(light < few, light / few, 1.0)
        more = share * (many - few)
    # What is no number is told where it is read.
    return light + np.nan_to_num(more, nan=0.0, posinf=0.0, neginf=0.0)


def states_of_lamps(view_layer: Any, simulated: Simulated) -> Lamps:
    """What a reference takes over at the present frame from the suns, and from the other lamps."""
    suns: list[Hashable] = []
    others: list[Hashable] = []
    for obj in shown_objects(view_layer):
        if obj.type == "LIGHT" and not must_be_frozen(obj, simulated):
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
