# SPDX-License-Identifier: GPL-3.0-or-later
"""A light scene that Cycles renders again and again, and what it finds in each light group.

No render lasts long: many light paths are traced a part at a time, so that whoever waits can be
told how far they are, and can leave.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Generator
from pathlib import Path
from typing import Any, TypeVar

import bpy
import numpy as np

from ....sensor_logic.model import Array, LightShare
from ..instances import shown_objects
from . import engine
from .changes import has_stiff_films
from .frozen import Simulated
from .groups import LightGroups
from .picture import Part, Picture, Seen, camera
from .scene import LightScene, is_portal, quietly

T = TypeVar("T")
# Yields before each picture, in words what takes long, else nothing; the result comes last.
Steps = Generator[str, None, T]
FIRST_PICTURE = "Cycles takes the scene in"
# Paths in all that a picture begins with, and the seconds that it should last: more pixels are
# rendered at once, or fewer, by the time that the last picture took.
PATHS, LONGEST_S, SHORTEST_S = 1 << 16, 0.4, 0.15
# So few cost less than what Blender needs for any picture.
FEWEST = 1 << 12
# What glows in no light group: surfaces, and lamps in instances.
OTHERS = "Other sources"
# What the groups leave of the whole is a difference of single-precision sums: less is nothing.
ROUNDING = 1e-5


def finished(steps: Steps[T]) -> T:
    """The result, with no break."""
    while True:
        try:
            next(steps)
        except StopIteration as end:
            return end.value  # type: ignore[no-any-return]


class CyclesScene(LightScene):
    """Stands at the user's present frame, but while a reference is traced. Lamps and the world are
    in light groups."""

    def __init__(self, scene: Any, view_layer: Any, simulated: Simulated) -> None:
        super().__init__(scene, view_layer, simulated)
        self._paths_at_once = PATHS
        self._is_new = True
        self._folder = tempfile.TemporaryDirectory(
            prefix="angen_light_", dir=bpy.app.tempdir, ignore_cleanup_errors=True
        )
        self.has_stiff_films = has_stiff_films()
        self._pictures: list[Picture] = []
        lamps = [o for o in shown_objects(view_layer) if o.type == "LIGHT" and not is_portal(o)]
        self._lamps = [lamp.data for lamp in lamps]
        self.groups: LightGroups
        with quietly():
            self.__enter__()

    def _begin(self) -> None:
        scene = self.scene
        engine.set_up(scene, "CYCLES")
        render, settings = scene.render, scene.render.image_settings
        render.use_persistent_data = True
        if hasattr(settings, "media_type"):
            settings.media_type = "MULTI_LAYER_IMAGE"
        if hasattr(settings, "use_exr_interleave"):
            settings.use_exr_interleave = True
        settings.file_format = "OPEN_EXR_MULTILAYER"
        settings.color_depth, settings.exr_codec = "32", "NONE"
        # Facts of a render that are written into its file.
        for prop in render.bl_rna.properties:
            if prop.identifier.startswith("use_stamp_"):
                setattr(render, prop.identifier, False)
        scene.camera = camera(self.own)
        scene.collection.objects.link(scene.camera)
        self.groups = LightGroups(self, self._lamps)

    def _lamp(self, obj: Any, lamp: Any) -> Any | None:
        return self.groups.add(self.own(lamp.copy()) if lamp is obj else lamp, obj.name)

    def _world(self) -> None:
        super()._world()
        world = self.scene.world
        if world is not None:
            original = self._user_scene.world
            if world == original:
                world = self.scene.world = self.own(world.copy())
            self.groups.add_world(world, original)

    def close(self) -> None:
        super().close()
        self._folder.cleanup()

    def follow(self, reference: int | None = None) -> None:
        super().follow(reference)
        self.groups.follow()

    def picture(self, method: Any, together: dict[int, Seen]) -> Picture:
        """A new picture of requests by their first pixels."""
        with quietly():
            made = Picture(self, method, together)
        self._pictures.append(made)
        return made

    def drop(self, picture: Picture) -> None:
        self._pictures.remove(picture)
        self.disown(*picture.made)

    def weights(self) -> Array:
        """(groups, 3): the present brightness of each group, and of what is in none."""
        return np.concatenate([self.groups.weights(), np.ones((1, 3))])

    @property
    def sources(self) -> list[LightShare]:
        """The source of each group's light, and of what is in none, with no light yet."""
        return [*self.groups.sources, LightShare((), OTHERS, 0.0)]

    def traced(
        self,
        picture: Picture,
        first: int,
        last: int,
        doing: str = "",
        only: int | None = None,
        of: int = 0,
    ) -> Steps[Array]:
        """The light paths `first` … `last` of each pixel: sums (groups, requests, pixels, 3) of
        their radiance; of the request of that number `only`, if told. `of` so many paths, it is
        told how far they are."""
        total = np.zeros((1, *picture.pixels.shape, 3))
        self._show_only(picture)
        at_once = engine.at_once(self.scene)
        for start in range(first, last, at_once):
            count = min(at_once, last - start)
            parts = picture.parts(self._paths_at_once // count)
            for part in parts if only is None else [picture.part_of(only)]:
                far = f": {100 * start // of} % done" if of else ""
                yield FIRST_PICTURE if self._is_new else doing + far
                began, was_new = time.perf_counter(), self._is_new
                total = total + count * self._render(start, count, part, picture)
                if not was_new:
                    self._learn(time.perf_counter() - began)
        return total

    def _show_only(self, picture: Picture) -> None:
        for other in self._pictures:
            other.show(other is picture)
        render, data = self.scene.render, self.scene.camera.data
        if render.resolution_x != picture.side:
            render.resolution_x = render.resolution_y = data.ortho_scale = picture.side

    def _learn(self, seconds: float) -> None:
        if seconds > LONGEST_S:
            self._paths_at_once = max(FEWEST, self._paths_at_once // 2)
        elif seconds < SHORTEST_S:
            self._paths_at_once = min(PATHS, 2 * self._paths_at_once)

    def _render(self, start: int, count: int, part: Part, picture: Picture) -> Array:
        """(groups, requests, pixels, 3)"""
        engine.trace(self.scene, start, count)
        render, (row, column, end_row, end_column) = self.scene.render, part
        side, path = picture.side, Path(self._folder.name, "views")
        render.use_border = end_row - row < side
        render.border_min_x, render.border_max_x = column / side, end_column / side
        render.border_min_y, render.border_max_y = 1 - end_row / side, 1 - row / side
        render.filepath = str(path)
        # Named as an argument, a scene is put to the frame of the user's.
        own = {"scene": self.scene, "view_layer": self.view_layer}
        with quietly(), bpy.context.temp_override(**own):
            bpy.ops.render.render(write_still=True)
        self._is_new = False
        layers = engine.read_layers(path.with_suffix(".exr"))
        passes = {
            name.rpartition(".")[2]: pixels.reshape(-1, 3)[picture.pixels]
            for name, pixels in layers.items()
        }
        whole = passes["Combined"]
        found = [passes[f"Combined_{name}"] for name in self.groups.names]
        left = whole - sum(found, np.zeros_like(whole))
        left[np.abs(left) < ROUNDING * np.abs(whole)] = 0.0
        return np.array([*found, left])
