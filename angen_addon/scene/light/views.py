# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures by Cycles whose pixels look from sensors, and the four views of a light sensor.

A *lid* is a square at the far clip plane of a view. It makes the view see the world there, in place
of the objects behind it.
"""

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
from ..animation import is_static
from .materials import Nodes, is_clear
from .scene import Housings, Simulated, is_left_out

# Pictures whose pixels look from any place in any direction: one Cycles render for all sensors.
#
# The camera looks at a sheet of squares, one a pixel, far from the scene. Each square is a ray
# portal: a ray that enters it goes on from a sensor, as from a camera there. The place of a pixel
# decides its random numbers, and the name of a sensor decides its pixels. So a reading has the
# same bits whatever other sensors exist.

# Pixels of each view, with independent random numbers.
TWICE = 2
# The number of first pixels for names. Cycles renders empty pixels too, but with fewer pixels more
# names would collide.
PLACES = 72
# The place of the sheet, far below the scene: nothing else is between the camera's clip planes.
SHEET = (0.0, 0.0, -1e5)
# The height of its camera above it: as little as single precision allows, because of fog.
ABOVE = 1.0 / 32.0
# The places of the picture that is rendered, and of others.
SHOWN, AWAY = (0.0, 0.0, 0.0), (0.0, 0.0, -2e5)
CORNERS = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
UNSEEN_BY = ("diffuse", "glossy", "transmission", "shadow", "volume_scatter")
# First row and column of pixels, and those behind the last.
Part = tuple[int, int, int, int]


@dataclass(frozen=True)
class Seen:
    """A light request, with the numbers (0 to 3) of its views that need a lid.

    A *lid* is a square at the far clip plane of a view, which makes the view see the world there.
    """

    request: Any
    lids: tuple[int, ...]


def pixel_of(name: str, count: int) -> int:
    """Return the first pixel of a request, which has `count` neighbouring pixels.

    It follows from a hash of the request's name.
    """
    digest = hashlib.blake2b(name.encode(), digest_size=8).digest()
    return int.from_bytes(digest, "little") % PLACES * count


def share_out(
    wanted: list[Seen], views: int, collide: Callable[[Seen, Seen], bool]
) -> list[dict[int, Seen]]:
    """Distribute requests over few pictures, so that no two requests in a picture collide.

    Parameters
    ----------
    wanted
        The requests.
    views
        The number of views of a request.
    collide
        Function that returns whether two requests must not be in the same picture.

    Returns
    -------
    list
        A dictionary for each picture: the requests, by the number of their first pixel.
    """
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
    """A square of pixels in a light scene, with the views of some light sensors.

    Each light request has `count` neighbouring pixels: first a pixel for each of its views, then a
    second pixel for each view. The datablocks made for the picture are visible only while it is
    shown.

    Parameters
    ----------
    light_scene
        The light scene.
    method
        The module that says what the pixels look at: `views` or `faces`.
    together
        The requests, by the first pixel of each.

    Attributes
    ----------
    count
        The number of pixels of a request.
    side
        The number of pixels along each side of the square.
    first
        The first pixel (requests,) of each request.
    pixels
        All pixels (requests, count) of each request, counted row by row.
    notes
        Texts for the user.
    made
        The datablocks made for the picture.
    """

    def __init__(self, light_scene: Any, method: Any, together: dict[int, Seen]) -> None:
        self.count: int = TWICE * method.COUNT
        self.side = math.isqrt(PLACES * self.count)
        self.first = np.array(list(together))
        # (requests, count): the pixels of each request, counted row by row.
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
        # An instance that is moved away to hide the picture: hiding it takes Cycles longer.
        self._holder = self.own(bpy.data.objects.new(".angen_light", None))
        self._holder.instance_type = "COLLECTION"
        self._holder.instance_collection = self.collection
        light_scene.scene.collection.objects.link(self._holder)
        self._shown = True

    def own(self, datablock: Any) -> Any:
        """Register a datablock that was made for the picture, and return it."""
        self.made.append(self._light_scene.own(datablock))
        return datablock

    def show(self, shown: bool) -> None:
        """Show or hide the picture."""
        if shown != self._shown:
            self._holder.location = SHOWN if shown else AWAY
            self._shown = shown

    def parts(self, at_most: int) -> list[Part]:
        """Return the parts of the picture to render one after the other.

        It is the whole picture if that has at most `at_most` used pixels, and else a part for each
        request.
        """
        if self.first.size * self.count <= at_most:
            return [(0, 0, self.side, self.side)]
        return [self.part_of(request) for request in range(self.first.size)]

    def part_of(self, request: int) -> Part:
        """Return the part of the picture with the pixels of the request of index `request`."""
        row, column = divmod(int(self.first[request]), self.side)
        return row, column, row + 1, column + self.count

    def add_squares(
        self, corners: list[Array], vectors: dict[str, list[Array]], material: Any
    ) -> None:
        """Add squares that only camera rays see.

        Parameters
        ----------
        corners
            Corners (4, 3) of each square.
        vectors
            Vectors (4, 3) at the corners of each square, by name of the attribute.
        material
            The material of the squares.
        """
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
    """Return a camera that sees the sheet of squares and nothing else.

    It is upright, so that the first row of pixels is at the top. `own` registers a new datablock.
    """
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
# Pixels of a request, and the factor of their radiance.
COUNT, FACTOR = WALLS, 1.0
NEAREST_CLIP = 1e-6
WIDEST = math.radians(170.0)
# In a view as narrow as this, its axis and edges stand for all of it.
NARROW = math.radians(3.0)
# Blender units: rays behind a lid go on from this distance, where only the world is.
BEYOND = 1e8
# The lid at the end of a view is this much larger than the view.
OVERLAP = 1.01
# A lid recognises the rays of its view by their length, within this fraction.
SAME_LENGTH = 1e-3
# The most surfaces that are no walls along a ray, and the step behind each, in Blender units.
THROUGH, STEP = 16, 1e-4


def lids(request: Any, walls: StillWalls) -> tuple[int, ...]:
    """Return the numbers (0 to 3) of the views that need a lid.

    These are the views that may reach their far clip plane.
    """
    if request.field_of_view > NARROW:
        return tuple(range(WALLS))
    length = request.clip_end - max(request.clip_start, NEAREST_CLIP)
    views = enumerate(_views(request))
    return tuple(n for n, view in views if not _is_closed(request, view, length, walls))


def collide(scene: Any, walls: StillWalls, one: Seen, other: Seen) -> bool:
    """Return whether the lids of either of two requests may disturb the views of the other.

    A *lid* is a square at the far clip plane of a view. Rays of other views pass through it, but
    Cycles then draws different random numbers for them, so that a reading would depend on the other
    sensor. A still wall in front of the lid prevents this.
    """
    return _may_hit_lid(one, other, walls) or _may_hit_lid(other, one, walls)


def rays(scene: Any, request: Any) -> list[tuple[Array, Array]]:
    """Return the rays through each pixel's corners: origins (4, 3) and directions (4, 3)."""
    start, found = max(request.clip_start, NEAREST_CLIP), []
    for view in _views(request):
        ways = _rays(request, view)
        found.append((request.matrix[:3, 3] + start * ways, ways))
    return found


def furnish(picture: Picture, scene: Any, together: Sequence[Seen]) -> None:
    """Add lids to a picture, for the views that need one.

    A lid is a square at the far clip plane of a view, which makes the view see the world there.
    """
    corners, reaches = [], []
    for seen in together:
        request = seen.request
        for wall in seen.lids:
            ways = _rays(request, _views(request)[wall], OVERLAP)
            corners.append(request.matrix[:3, 3] + request.clip_end * ways)
            reaches.append((request.clip_end - max(request.clip_start, NEAREST_CLIP)) * ways)
        if request.field_of_view > WIDEST:
            picture.notes.append(
                f"the field of view of '{request.name}' is limited to {math.degrees(WIDEST):.0f}°"
            )
    if corners:
        picture.add_squares(corners, {"angen_reach": reaches}, _lid(picture.own))


def view_rays(request: Any) -> tuple[Array, Array, Array]:
    """Return the rays along the axis and the corners of each view of a light sensor.

    The views are along −Z, −X, +Z and +X. Rays start on the plane at `clip_start`, and reach the
    plane at `clip_end`.

    Parameters
    ----------
    request
        The `LightRequest` of the sensor.

    Returns
    -------
    tuple
        Origins (4, 5, 3), unit directions (4, 5, 3) and lengths (4, 5), in Blender units.
    """
    ways = np.array([[view[:, 2], *_rays(request, view)] for view in _views(request)])
    size = np.linalg.norm(ways, axis=-1)
    start = max(request.clip_start, NEAREST_CLIP)
    origins = request.matrix[:3, 3] + start * ways
    return origins, ways / size[..., None], (request.clip_end - start) * size


def _views(request: Any) -> list[Array]:
    """Return the axes (3, 3) of each of the four views. Columns are right, up and ahead."""
    x, y, z = (request.matrix[:3, i] for i in range(3))
    return [np.stack(axes, axis=1) for axes in ((x, y, -z), (-z, y, -x), (-x, y, z), (z, y, x))]


def _slope(request: Any) -> float:
    return math.tan(min(request.field_of_view, WIDEST) / 2)


def _rays(request: Any, view: Array, enlarged: float = 1.0) -> Array:
    """Return vectors (4, 3) from the sensor to the corners of a view, at one unit ahead.

    `view` (3, 3) has the axes of the view, and `enlarged` is a factor for its size.
    """
    half = _slope(request) * enlarged
    return np.array([view @ (half * a, half * b, 1.0) for a, b in 2 * CORNERS - 1])


def _is_closed(request: Any, view: Array, length: float, walls: StillWalls) -> bool:
    """Return whether still walls close a view within a length.

    Rays along the axis and the corners of the view are tested, which is enough for a narrow view.
    """
    ways = np.vstack([view[:, 2], _rays(request, view)])
    starts = request.matrix[:3, 3] + max(request.clip_start, NEAREST_CLIP) * ways
    return walls.are_between(starts, ways, length)


def _may_hit_lid(beam: Seen, other: Seen, walls: StillWalls) -> bool:
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
    """Return the material of a lid.

    The rays of the lid's own view go on beyond the scene, where they see the world. All other rays
    pass. The material recognises the rays of its view by their length.
    """
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
    """Tests whether opaque walls that never move stop rays.

    Only walls that cameras see count. They are tested as the scene is evaluated now.
    """

    def __init__(self, scene: Any, view_layer: Any, simulated: Simulated) -> None:
        self._scene = scene
        self._depsgraph = view_layer.depsgraph
        self._simulated = simulated
        self._housings = Housings()
        self._closes: dict[int, bool] = {}

    def are_between(self, origins: Array, ways: Array, length: float) -> bool:
        """Return whether every one of n rays certainly hits a wall.

        Parameters
        ----------
        origins
            Origins (n, 3), in Blender units.
        ways
            Directions (n, 3), of any length.
        length
            Largest distance, in multiples of the length of each direction.
        """
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
            self._closes[uid] = self._is_still_and_opaque(obj.original)
        return self._closes[uid]

    def _is_still_and_opaque(self, obj: Any) -> bool:
        if not obj.visible_camera or is_left_out(obj, self._housings) or obj in self._simulated:
            return False
        data = obj.data
        still = is_static(obj) and not obj.modifiers and not getattr(data, "shape_keys", None)
        return still and not any(
            slot.material and is_clear(slot.material) for slot in obj.material_slots
        )
