# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures whose pixels look from anywhere to anywhere: one Cycles render for all sensors.

The camera looks at a sheet of squares, one a pixel, far from the scene. Each square is a ray
portal: what enters it goes on from a sensor's place, as from a camera of its own there. A pixel's
place decides its random numbers, and each sensor's pixels come from its own name: so what it reads
is the same to the bit whatever other sensors there are.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix

from ....sensor_logic.model import Array
from .materials import Nodes

# Each view has so many pixels, whose random numbers have nothing in common.
TWICE = 2
# So many first pixels there are for names. Cycles visits the empty ones too; fewer would collide
# more often.
PLACES = 72
# Where the sheet lies, under everything: nothing else is between the clip planes of its camera.
SHEET = (0.0, 0.0, -1e5)
# Its camera is that much above it: as near as single precision allows there, for the sake of fog.
ABOVE = 1.0 / 32.0
# Where pictures are that are not rendered now.
SHOWN, AWAY = (0.0, 0.0, 0.0), (0.0, 0.0, -2e5)
CORNERS = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
UNSEEN_BY = ("diffuse", "glossy", "transmission", "shadow", "volume_scatter")
# First row and column of pixels, and those behind the last.
Part = tuple[int, int, int, int]


@dataclass(frozen=True)
class Seen:
    """A request; of four walls, those (0 … 3) whose views need a lid at their far clip plane."""

    request: Any
    lids: tuple[int, ...]


def pixel_of(name: str, count: int) -> int:
    """The first of `count` neighbouring pixels that belong to a name."""
    digest = hashlib.blake2b(name.encode(), digest_size=8).digest()
    return int.from_bytes(digest, "little") % PLACES * count


def share_out(
    wanted: list[Seen], views: int, collide: Callable[[Seen, Seen], bool]
) -> list[dict[int, Seen]]:
    """What is wanted of so many views each, by its first pixel; in as many pictures as it takes, so
    that no two in one collide."""
    found = []
    while wanted:
        together: dict[int, Seen] = {}
        left = []
        for seen in wanted:
            pixel = pixel_of(seen.request.name, TWICE * views)
            if pixel in together or any(collide(seen, other) for other in together.values()):
                left.append(seen)
            else:
                together[pixel] = seen
        found.append(together)
        wanted = left
    return found


class Picture:
    """A square of pixels, `side` a side, in a light scene: those of some requests, `count` of each,
    by the first of them. They are all views of a request, and then all again.

    `method`: the module that says what they look at. What is made for them is seen only while the
    picture is `shown`.
    """

    def __init__(self, light_scene: Any, method: Any, together: dict[int, Seen]) -> None:
        self.count: int = TWICE * method.COUNT
        self.side = math.isqrt(PLACES * self.count)
        self.first = np.array(list(together))
        # (requests, count): which pixels, row by row, are theirs.
        self.pixels = self.first[:, None] + np.arange(self.count)
        self.notes: list[str] = []
        self.made: list[Any] = []
        self._light_scene = light_scene
        self.collection = self.own(bpy.data.collections.new(".angen_light"))
        corners, starts, ways = [], [], []
        for first, seen in together.items():
            rays = TWICE * method.rays(light_scene.scene, seen.request)
            for number, (places, directions) in enumerate(rays):
                row, column = divmod(first + number, self.side)
                middle = np.array([column - self.side / 2, self.side / 2 - 1 - row])
                corners.append(np.c_[CORNERS + middle, np.zeros(4)] + SHEET)
                starts.append(places)
                ways.append(directions)
        vectors = {"angen_place": starts, "angen_way": ways}
        self.add_squares(corners, vectors, _portal(self.own))
        method.furnish(self, light_scene.scene, list(together.values()))
        # Shown by this, which is moved away: that costs Cycles less than what comes and goes.
        self._holder = self.own(bpy.data.objects.new(".angen_light", None))
        self._holder.instance_type = "COLLECTION"
        self._holder.instance_collection = self.collection
        light_scene.scene.collection.objects.link(self._holder)
        self._shown = True

    def own(self, datablock: Any) -> Any:
        """Takes charge of what is made for the picture."""
        self.made.append(self._light_scene.own(datablock))
        return datablock

    def show(self, shown: bool) -> None:
        if shown != self._shown:
            self._holder.location = SHOWN if shown else AWAY
            self._shown = shown

    def parts(self, at_most: int) -> list[Part]:
        """Parts of the picture with so many used pixels at most, or one request each."""
        if self.first.size * self.count <= at_most:
            return [(0, 0, self.side, self.side)]
        return [self.part_of(request) for request in range(self.first.size)]

    def part_of(self, request: int) -> Part:
        """The part with one request, by its number."""
        row, column = divmod(int(self.first[request]), self.side)
        return row, column, row + 1, column + self.count

    def add_squares(
        self, corners: list[Array], vectors: dict[str, list[Array]], material: Any
    ) -> None:
        """Adds squares with vectors at their corners, which only camera rays see."""
        mesh = self.own(bpy.data.meshes.new(".angen_light"))
        faces = np.arange(4 * len(corners)).reshape(-1, 4).tolist()
        mesh.from_pydata(np.concatenate(corners).tolist(), [], faces)
        for name, found in vectors.items():
            attribute = mesh.attributes.new(name, "FLOAT_VECTOR", "POINT")
            attribute.data.foreach_set("vector", np.concatenate(found).astype(np.float32).ravel())
        mesh.materials.append(material)
        squares = self.own(bpy.data.objects.new(".angen_light", mesh))
        for rays in UNSEEN_BY:
            setattr(squares, f"visible_{rays}", False)
        self.collection.objects.link(squares)


def camera(own: Any) -> Any:
    """Sees the sheet and nothing else, upright: its first row of pixels is the picture's."""
    data = own(bpy.data.cameras.new(".angen_light"))
    data.type = "ORTHO"
    data.clip_start, data.clip_end = ABOVE / 2, ABOVE * 1.5
    made = own(bpy.data.objects.new(".angen_light", data))
    made.matrix_world = Matrix.Translation((SHEET[0], SHEET[1], SHEET[2] + ABOVE))
    return made


def _portal(own: Any) -> Any:
    nodes = Nodes(own)
    way = nodes.add("ShaderNodeVectorMath", "NORMALIZE", _0=nodes.vector("angen_way"))
    portal = nodes.add(
        "ShaderNodeBsdfRayPortal",
        position=nodes.vector("angen_place"),
        direction=way.outputs["Vector"],
    )
    nodes.add("ShaderNodeOutputMaterial", surface=portal.outputs[0])
    return nodes.material
