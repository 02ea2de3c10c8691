# SPDX-License-Identifier: GPL-3.0-or-later
"""Radiance that tiny views see, by one Cycles render of one picture, a pixel a view.

The camera looks at a sheet of squares, one a pixel, far from the scene. Each square is a ray
portal: what enters it goes on from a sensor's place, as from a camera of its own there. A pixel's
place decides its random numbers, and each sensor's pixels come from its own name: so what it reads
is the same to the bit whatever other sensors there are.
"""

from __future__ import annotations

import hashlib
import math
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix
from numpy.typing import NDArray

from . import exr
from .light_colour import to_rec709
from .light_ways import Ways

Array = NDArray[np.float64]
WALLS = 4
# Pixels a side. Cycles visits the empty ones too; fewer would make names collide more often.
SIDE = 16
SLOTS = SIDE * SIDE // WALLS
# Where the sheet lies, under everything: nothing else is between the clip planes of its camera.
SHEET = (0.0, 0.0, -1e5)
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
CORNERS = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
UNSEEN_BY = ("diffuse", "glossy", "transmission", "shadow", "volume_scatter")


@dataclass(frozen=True)
class Seen:
    """A request, and the walls (0 … 3) whose views reach their far clip plane: they need a lid."""

    request: Any
    lids: tuple[int, ...]


def batches(requests: Sequence[Any], ways: Ways) -> list[dict[int, Seen]]:
    """The requests by their slots in a picture; in as many pictures as they need."""
    found = []
    left = [Seen(request, _open_views(request, ways)) for request in requests]
    while left:
        together: dict[int, Seen] = {}
        for seen in left:
            slot = slot_of(seen.request.name)
            if slot not in together and not any(
                _meets_lid(*pair, ways)
                for other in together.values()
                for pair in ((seen, other), (other, seen))
            ):
                together[slot] = seen
        found.append(together)
        left = [seen for seen in left if all(seen is not other for other in together.values())]
    return found


class Views:
    """The views of one batch of requests in a light scene, of so many light paths a request."""

    def __init__(self, light_scene: Any, together: dict[int, Seen], samples: int) -> None:
        self._slots = list(together)
        scene = self._scene = light_scene.scene
        scene.camera = _camera(light_scene)
        _sheet(light_scene, together)
        if any(seen.lids for seen in together.values()):
            _lids(light_scene, list(together.values()))
        scene.cycles.samples = max(1, math.ceil(samples / WALLS))
        render, settings = scene.render, scene.render.image_settings
        render.resolution_x = render.resolution_y = SIDE
        if hasattr(settings, "media_type"):
            settings.media_type = "IMAGE"
        settings.file_format = "OPEN_EXR"
        settings.color_mode, settings.color_depth, settings.exr_codec = "RGB", "32", "NONE"
        for seen in together.values():
            if seen.request.field_of_view > WIDEST:
                light_scene.notes.append(
                    f"'{seen.request.name}' sees {math.degrees(WIDEST):.0f}° at most"
                )

    def radiance(self) -> list[Array]:
        """Linear radiance (4, 3) of the views along −Z, −X, +Z, +X of each request."""
        with tempfile.TemporaryDirectory(prefix="angen_light_") as folder:
            self._scene.render.filepath = str(Path(folder, "views"))
            bpy.ops.render.render(write_still=True, scene=self._scene.name)
            picture = exr.read_rgb(Path(folder, "views.exr"))
        pixels = to_rec709(picture).reshape(SLOTS, WALLS, 3)
        return [pixels[slot] for slot in self._slots]


def slot_of(name: str) -> int:
    digest = hashlib.blake2b(name.encode(), digest_size=8).digest()
    return int.from_bytes(digest, "little") % SLOTS


def _views(request: Any) -> list[Array]:
    """Axes (3, 3) of the four views, columns right, up, ahead; each a quarter turn on."""
    x, y, z = (request.matrix[:3, i] for i in range(3))
    return [np.stack(axes, axis=1) for axes in ((x, y, -z), (-z, y, -x), (-x, y, z), (z, y, x))]


def _rays(request: Any, view: Array, enlarged: float = 1.0) -> Array:
    """Vectors (4, 3) from the sensor to the corners of its view a metre ahead."""
    half = math.tan(min(request.field_of_view, WIDEST) / 2) * enlarged
    return np.array([view @ (half * a, half * b, 1.0) for a, b in 2 * CORNERS - 1])


def _axis_and_edges(request: Any, view: Array) -> Array:
    """Vectors (5, 3) along which a view is looked through, a metre ahead."""
    return np.vstack([view[:, 2], _rays(request, view)])


def _open_views(request: Any, ways: Ways) -> tuple[int, ...]:
    """The walls that may be farther away than the far clip plane."""
    if request.field_of_view > NARROW:
        return tuple(range(WALLS))
    start = max(request.clip_start, NEAREST_CLIP)
    found = []
    for wall, view in enumerate(_views(request)):
        rays = _axis_and_edges(request, view)
        starts = request.matrix[:3, 3] + start * rays
        if not ways.are_closed(starts, rays, request.clip_end - start):
            found.append(wall)
    return tuple(found)


def _meets_lid(beam: Seen, other: Seen, ways: Ways) -> bool:
    """Whether a view of `beam` may meet the lid at the end of one of `other`, no wall before it.

    Where paths go through one more surface, Cycles draws other random numbers.
    """
    if not other.lids:
        return False
    one, two = beam.request, other.request
    slopes = [math.sqrt(2) * math.tan(min(r.field_of_view, WIDEST) / 2) for r in (one, two)]
    start, size = max(one.clip_start, NEAREST_CLIP), OVERLAP * slopes[1] * two.clip_end
    beams, ends = _views(one), _views(two)
    ahead = np.array([view[:, 2] for view in beams])
    lids = np.array([ends[wall][:, 2] * two.clip_end for wall in other.lids])
    lids += two.matrix[:3, 3] - one.matrix[:3, 3]
    along = np.clip(lids @ ahead.T, 0.0, one.clip_end)
    apart = np.linalg.norm(lids[:, None, :] - along[:, :, None] * ahead, axis=2)
    for end, number in np.argwhere(apart <= slopes[0] * (along + size) + size):
        rays = _axis_and_edges(one, beams[number])
        starts = one.matrix[:3, 3] + start * rays
        if one.field_of_view > NARROW or not ways.are_closed(
            starts, rays, float(along[end, number]) - size - start
        ):
            return True
    return False


def _camera(light_scene: Any) -> Any:
    """Sees the sheet and nothing else, upright: its first row of pixels is the picture's."""
    own = light_scene.own
    data = own(bpy.data.cameras.new(".angen_light"))
    data.type = "ORTHO"
    data.ortho_scale = SIDE
    data.clip_start, data.clip_end = 0.5, 1.5
    camera = own(bpy.data.objects.new(".angen_light", data))
    camera.matrix_world = Matrix.Translation((SHEET[0], SHEET[1], SHEET[2] + 1.0))
    light_scene.scene.collection.objects.link(camera)
    return camera


def _sheet(light_scene: Any, together: dict[int, Seen]) -> None:
    """A square a view, that sends what comes in on from the near clip plane of the view."""
    corners, places, ways = [], [], []
    for slot, seen in together.items():
        request = seen.request
        for wall, view in enumerate(_views(request)):
            row, column = divmod(slot * WALLS + wall, SIDE)
            middle = np.array([column - SIDE / 2, SIDE / 2 - 1 - row])
            rays = _rays(request, view)
            corners.append(np.c_[CORNERS + middle, np.zeros(WALLS)] + SHEET)
            places.append(request.matrix[:3, 3] + max(request.clip_start, NEAREST_CLIP) * rays)
            ways.append(rays)
    material = _portal(light_scene.own)
    _squares(light_scene, corners, {"angen_place": places, "angen_way": ways}, material)


def _lids(light_scene: Any, together: Sequence[Seen]) -> None:
    """A square at the far clip plane of each open view, from which only the world is seen."""
    corners, reaches = [], []
    for seen in together:
        request = seen.request
        for wall in seen.lids:
            rays = _rays(request, _views(request)[wall], OVERLAP)
            corners.append(request.matrix[:3, 3] + request.clip_end * rays)
            reaches.append((request.clip_end - max(request.clip_start, NEAREST_CLIP)) * rays)
    _squares(light_scene, corners, {"angen_reach": reaches}, _lid(light_scene.own))


def _squares(
    light_scene: Any, corners: list[Array], vectors: dict[str, list[Array]], material: Any
) -> None:
    """Adds squares with vectors at their corners, which only camera rays see."""
    own = light_scene.own
    mesh = own(bpy.data.meshes.new(".angen_light"))
    faces = np.arange(WALLS * len(corners)).reshape(-1, WALLS).tolist()
    mesh.from_pydata(np.concatenate(corners).tolist(), [], faces)
    for name, found in vectors.items():
        attribute = mesh.attributes.new(name, "FLOAT_VECTOR", "POINT")
        attribute.data.foreach_set("vector", np.concatenate(found).astype(np.float32).ravel())
    mesh.materials.append(material)
    squares = own(bpy.data.objects.new(".angen_light", mesh))
    for rays in UNSEEN_BY:
        setattr(squares, f"visible_{rays}", False)
    light_scene.scene.collection.objects.link(squares)


class _Nodes:
    """A new material's nodes, to be linked together."""

    def __init__(self, own: Any) -> None:
        self.material = own(bpy.data.materials.new(".angen_light"))
        if not self.material.node_tree:
            self.material.use_nodes = True
        self._tree = self.material.node_tree
        self._tree.nodes.clear()

    def add(self, kind: str, operation: str = "", **inputs: Any) -> Any:
        node = self._tree.nodes.new(kind)
        if operation:
            node.operation = operation
        for name, source in inputs.items():
            to = node.inputs[int(name[1:]) if name[1:].isdigit() else name.capitalize()]
            if isinstance(source, bpy.types.NodeSocket):
                self._tree.links.new(source, to)
            else:
                to.default_value = source
        return node

    def vector(self, name: str) -> Any:
        node = self.add("ShaderNodeAttribute")
        node.attribute_name = name
        return node.outputs["Vector"]


def _portal(own: Any) -> Any:
    nodes = _Nodes(own)
    way = nodes.add("ShaderNodeVectorMath", "NORMALIZE", _0=nodes.vector("angen_way"))
    portal = nodes.add(
        "ShaderNodeBsdfRayPortal",
        position=nodes.vector("angen_place"),
        direction=way.outputs["Vector"],
    )
    nodes.add("ShaderNodeOutputMaterial", surface=portal.outputs[0])
    return nodes.material


def _lid(own: Any) -> Any:
    """Lets rays pass that do not come from its own view: theirs have another length."""
    nodes = _Nodes(own)
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
