# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures whose pixels look from sensors, by Cycles; and the four views of each sensor that looks
at four walls, as rays and in such a picture."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix

from ....sensor_logic.model import Array
from ..animation import stays
from .materials import Nodes, is_clear
from .scene import Housings, Simulated, is_left_out

# Pictures whose pixels look from anywhere to anywhere: one Cycles render for all sensors.
#
# The camera looks at a sheet of squares, one a pixel, far from the scene. Each square is a ray
# portal: what enters it goes on from a sensor's place, as from a camera of its own there. A
# pixel's place decides its random numbers, and each sensor's pixels come from its own name: so
# what it reads is the same to the bit whatever other sensors there are.

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


WALLS = 4
# Pixels of a request, and what their radiance is multiplied with.
COUNT, FACTOR = WALLS, 1.0
NEAREST_CLIP = 1e-6
WIDEST = math.radians(170.0)
# In so narrow a view, what is on its axis and its edges is taken to be all over it.
NARROW = math.radians(3.0)
# What a view does not see any more is seen from here on: nothing but the world.
BEYOND = 1e8
# The lid at the end of a view is this much larger than the view.
OVERLAP = 1.01
# A lid knows rays of its own view by their length, within this share.
SAME_LENGTH = 1e-3
# So many things that may go away, or let light pass, are looked through; and from this far behind
# each, in Blender units.
THROUGH, STEP = 16, 1e-4


def lids(request: Any, walls: StillWalls) -> tuple[int, ...]:
    """The views (0 … 3) that may reach their far clip plane, and need a lid there."""
    if request.field_of_view > NARROW:
        return tuple(range(WALLS))
    length = request.clip_end - max(request.clip_start, NEAREST_CLIP)
    views = enumerate(_views(request))
    return tuple(n for n, view in views if not _is_closed(request, view, length, walls))


def collide(scene: Any, walls: StillWalls, one: Seen, other: Seen) -> bool:
    """Whether a view of one request may meet the lid of one of the other, no wall before it: where
    paths go through one more surface, Cycles draws other random numbers."""
    return _meets_lid(one, other, walls) or _meets_lid(other, one, walls)


def rays(scene: Any, request: Any) -> list[tuple[Array, Array]]:
    """Of each pixel, where the rays through its corners start (4, 3), and their directions."""
    start, found = max(request.clip_start, NEAREST_CLIP), []
    for view in _views(request):
        ways = _rays(request, view)
        found.append((request.matrix[:3, 3] + start * ways, ways))
    return found


def furnish(picture: Picture, scene: Any, together: Sequence[Seen]) -> None:
    """Adds a square at the far clip plane of each open view, from which only the world is seen."""
    corners, reaches = [], []
    for seen in together:
        request = seen.request
        for wall in seen.lids:
            ways = _rays(request, _views(request)[wall], OVERLAP)
            corners.append(request.matrix[:3, 3] + request.clip_end * ways)
            reaches.append((request.clip_end - max(request.clip_start, NEAREST_CLIP)) * ways)
        if request.field_of_view > WIDEST:
            picture.notes.append(f"'{request.name}' sees {math.degrees(WIDEST):.0f}° at most")
    if corners:
        picture.add_squares(corners, {"angen_reach": reaches}, _lid(picture.own))


def view_rays(request: Any) -> tuple[Array, Array, Array]:
    """Origins (4, 5, 3), unit directions (4, 5, 3) and reach (4, 5), in Blender units, of what a
    light sensor asks (a LightRequest): the axis and the corners of each view along −Z, −X, +Z, +X.

    They start on the plane at clip_start and reach that at clip_end.
    """
    ways = np.array([[view[:, 2], *_rays(request, view)] for view in _views(request)])
    size = np.linalg.norm(ways, axis=-1)
    start = max(request.clip_start, NEAREST_CLIP)
    origins = request.matrix[:3, 3] + start * ways
    return origins, ways / size[..., None], (request.clip_end - start) * size


def _views(request: Any) -> list[Array]:
    """Axes (3, 3) of the four views, columns right, up, ahead; each a quarter turn on."""
    x, y, z = (request.matrix[:3, i] for i in range(3))
    return [np.stack(axes, axis=1) for axes in ((x, y, -z), (-z, y, -x), (-x, y, z), (z, y, x))]


def _slope(request: Any) -> float:
    return math.tan(min(request.field_of_view, WIDEST) / 2)


def _rays(request: Any, view: Array, enlarged: float = 1.0) -> Array:
    """Vectors (4, 3) from the sensor to the corners of its view a metre ahead."""
    half = _slope(request) * enlarged
    return np.array([view @ (half * a, half * b, 1.0) for a, b in 2 * CORNERS - 1])


def _is_closed(request: Any, view: Array, length: float, walls: StillWalls) -> bool:
    """Whether still walls close a narrow view within a length, as far as its axis and its edges
    tell."""
    ways = np.vstack([view[:, 2], _rays(request, view)])
    starts = request.matrix[:3, 3] + max(request.clip_start, NEAREST_CLIP) * ways
    return walls.are_between(starts, ways, length)


def _meets_lid(beam: Seen, other: Seen, walls: StillWalls) -> bool:
    """Whether a view of `beam` may meet the lid of one of `other`."""
    if not other.lids:
        return False
    one, two = beam.request, other.request
    wide, size = math.sqrt(2) * _slope(one), OVERLAP * math.sqrt(2) * _slope(two) * two.clip_end
    beams, ends = _views(one), _views(two)
    ahead = np.array([view[:, 2] for view in beams])
    far = np.array([ends[wall][:, 2] * two.clip_end for wall in other.lids])
    far += two.matrix[:3, 3] - one.matrix[:3, 3]
    along = np.clip(far @ ahead.T, 0.0, one.clip_end)
    apart = np.linalg.norm(far[:, None, :] - along[:, :, None] * ahead, axis=2)
    for end, number in np.argwhere(apart <= wide * (along + size) + size):
        length = float(along[end, number]) - size - max(one.clip_start, NEAREST_CLIP)
        if one.field_of_view > NARROW or not _is_closed(one, beams[number], length, walls):
            return True
    return False


def _lid(own: Any) -> Any:
    """Lets rays pass that do not come from its own view: theirs have another length."""
    nodes = Nodes(own)
    reach = nodes.vector("angen_reach")
    length = nodes.add("ShaderNodeVectorMath", "LENGTH", _0=reach).outputs["Value"]
    path = nodes.add("ShaderNodeLightPath").outputs["Ray Length"]
    share = nodes.add("ShaderNodeMath", "DIVIDE", _0=path, _1=length).outputs[0]
    same = nodes.add("ShaderNodeMath", "COMPARE", _0=share, _1=1.0, _2=SAME_LENGTH).outputs[0]
    way = nodes.add("ShaderNodeVectorMath", "NORMALIZE", _0=reach).outputs["Vector"]
    far = nodes.add("ShaderNodeVectorMath", "SCALE", _0=way, scale=BEYOND).outputs["Vector"]
    portal = nodes.add("ShaderNodeBsdfRayPortal", position=far, direction=way).outputs[0]
    clear = nodes.add("ShaderNodeBsdfTransparent").outputs[0]
    mixed = nodes.add("ShaderNodeMixShader", _0=same, _1=clear, _2=portal).outputs[0]
    nodes.add("ShaderNodeOutputMaterial", surface=mixed)
    return nodes.material


class StillWalls:
    """Tells whether a camera could look along a way in the scene at any frame. What stands still
    and is opaque is in the way at all of them. Asks the scene as it is evaluated now."""

    def __init__(self, scene: Any, view_layer: Any, simulated: Simulated) -> None:
        self._scene = scene
        self._depsgraph = view_layer.depsgraph
        self._simulated = simulated
        self._housings = Housings()
        self._closes: dict[int, bool] = {}

    def are_between(self, origins: Array, ways: Array, length: float) -> bool:
        """Whether on all ways (n, 3) from origins (n, 3) something is met within `length` times
        the way. In doubt it is not."""
        reaches = length * np.linalg.norm(ways, axis=1)
        return length > 0.0 and all(map(self._is_between, origins, ways, reaches))

    def _is_between(self, origin: Array, way: Array, reach: float) -> bool:
        way = way / np.linalg.norm(way)
        for _ in range(THROUGH):
            hit, place, _, _, obj, _ = self._scene.ray_cast(
                self._depsgraph, origin.tolist(), way.tolist(), distance=reach
            )
            if not hit or self._is_wall(obj):
                return bool(hit)
            gone = float((np.array(place) - origin) @ way) + STEP
            origin, reach = origin + gone * way, reach - gone
            if reach <= 0.0:
                return False
        return False

    def _is_wall(self, obj: Any) -> bool:
        uid = obj.original.session_uid
        if uid not in self._closes:
            self._closes[uid] = self._closes_ways(obj.original)
        return self._closes[uid]

    def _closes_ways(self, obj: Any) -> bool:
        if not obj.visible_camera or is_left_out(obj, self._housings) or obj in self._simulated:
            return False
        data = obj.data
        still = stays(obj) and not obj.modifiers and not getattr(data, "shape_keys", None)
        return still and not any(
            slot.material and is_clear(slot.material) for slot in obj.material_slots
        )
