# SPDX-License-Identifier: GPL-3.0-or-later
"""What the light paths of an update miss, told by many more paths in a scene that is like it.

A control variate: the reference scene is the home as it stands at its first frame, in the present
light of its lamps. Its picture by the update's own few paths, with the same random numbers, errs
much as the update's picture does; by many paths it hardly errs. Their difference corrects the
update's picture. It adds no bias, whatever moved since the first frame: what moved only makes the
two errors less alike. As long as the lamps stay as they are the difference is known, so many paths
are traced once for each state of the lamps, not for each update.

Glasserman, Monte Carlo Methods in Financial Engineering, section 4.1, on control variates;
Rousselle, Jarosz, Novák, Image-space control variates for rendering, 2016, on pictures.
"""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .light_scene import LightScene, must_be_frozen
from .light_values import settable_values

Array = NDArray[np.float64]
# What these make depends on the frames before, and those a reference does not go through.
PHYSICS = {"CLOTH", "DYNAMIC_PAINT", "FLUID", "PARTICLE_SYSTEM", "SOFT_BODY"}
Taken = tuple["ReferenceScene", Any]
# As many states of the lamps are remembered.
STATES = 512


class ReferenceScene(LightScene):
    """The home at its first frame, without what physics moves, with lamps of its own."""

    def __init__(self, scene: Any, view_layer: Any) -> None:
        super().__init__(scene, view_layer)
        self._lamps: list[tuple[Any, Any]] = []

    def light_lamps(self) -> None:
        """Sets the lamps as the user's are now; they stand where they stood at the first frame."""
        depsgraph = self._user_layer.depsgraph
        for original, own in self._lamps:
            now = settable_values(original.evaluated_get(depsgraph).data)
            was = settable_values(own.data)
            for name, value in now.items():
                if was.get(name) != value:
                    setattr(own.data, name, value)

    def _stand_at_moment(self, user: Any) -> None:
        if self.scene.frame_current != user.frame_start:
            self.scene.frame_current = user.frame_start

    def _stand_in(self, obj: Any) -> Any:
        if must_be_frozen(obj) or any(_goes_through_frames(m) for m in obj.modifiers):
            return None
        if obj.type != "LIGHT":
            return obj
        own = self.own(obj.copy())
        own.data = self.own(obj.data.copy())
        own.data.animation_data_clear()
        self._lamps.append((obj, own))
        return own


class Reference:
    """The reference of one picture: what corrects it in each state of the lamps.

    `few`, `many`: a scene with its picture each, as Cycles draws other random numbers in a scene
    whose number of light paths has been another before.
    """

    def __init__(self, few: Taken, many: Taken) -> None:
        self._few, self._many = few, many
        self._known: dict[Hashable, list[Array]] = {}

    def correction(self, lamps: Hashable) -> list[Array]:
        """What is to be added to each reading, the lamps being in the state `lamps`: what many
        light paths find beyond few."""
        if lamps not in self._known:
            pairs = zip(_light(self._many), _light(self._few), strict=True)
            # What is no number is told where it is read.
            found = [np.nan_to_num(a - b, nan=0.0, posinf=0.0, neginf=0.0) for a, b in pairs]
            while len(self._known) >= STATES:
                self._known.pop(next(iter(self._known)))
            self._known[lamps] = found
        return self._known[lamps]

    @property
    def states(self) -> int:
        """Of how many states of the lamps it knows the correction."""
        return len(self._known)

    def close(self) -> None:
        self._few[0].close()
        self._many[0].close()


def _light(taken: Taken) -> list[Array]:
    light_scene, picture = taken
    light_scene.light_lamps()
    return picture.light()


def state_of_lamps(view_layer: Any) -> Hashable:
    """What a reference takes over from the lamps at the present frame."""
    depsgraph = view_layer.depsgraph
    return tuple(
        (obj.session_uid, *settable_values(obj.evaluated_get(depsgraph).data).values())
        for obj in view_layer.objects
        if obj.type == "LIGHT"
    )


def _goes_through_frames(modifier: Any) -> bool:
    tree = modifier.node_group if modifier.type == "NODES" else None
    simulated = tree is not None and any(n.type == "SIMULATION_INPUT" for n in tree.nodes)
    return simulated or modifier.type in PHYSICS
