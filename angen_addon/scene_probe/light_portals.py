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
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix
from numpy.typing import NDArray

from . import exr
from .light_colour import to_rec709

Array = NDArray[np.float64]
WALLS = 4
# Pixels a side. Cycles visits the empty ones too; fewer would make names collide more often.
SIDE = 16
SLOTS = SIDE * SIDE // WALLS
# Where the sheet lies, under everything: nothing else is between the clip planes of its camera.
SHEET = (0.0, 0.0, -1e5)
NEAREST_CLIP = 1e-6
WIDEST = math.radians(170.0)
# What a view does not see any more is seen from here on: nothing but the world.
BEYOND = 1e8
# The lid at the end of a view is this much larger than the view.
OVERLAP = 1.01
# A lid knows rays of its own view by their length, within this share.
SAME_LENGTH = 1e-3
CORNERS = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
UNSEEN_BY = ("diffuse", "glossy", "transmission", "shadow", "volume_scatter")


def four_walls(light_scene: Any, requests: Sequence[Any], samples: int) -> list[Array]:
    """Linear radiance (4, 3) of the views along −Z, −X, +Z, +X of each request."""
    light_scene.scene.cycles.samples = max(1, math.ceil(samples / WALLS))
    found: dict[str, Array] = {}
    left = list(requests)
    while left:
        together: dict[int, Any] = {}
        for request in left:
            slot = slot_of(request.name)
            if slot not in together and not any(
                _meets_lid(light_scene, *pair)
                for other in together.values()
                for pair in ((request, other), (other, request))
            ):
                together[slot] = request
        for request, colours in zip(together.values(), _render(light_scene, together), strict=True):
            found[request.name] = colours
        left = [request for request in left if request.name not in found]
    return [found[request.name] for request in requests]


def slot_of(name: str) -> int:
    digest = hashlib.blake2b(name.encode(), digest_size=8).digest()
    return int.from_bytes(digest, "little") % SLOTS


def angle_of(light_scene: Any, request: Any) -> float:
    """The field of view in radians, as wide as can be; a note tells where it was not."""
    if request.field_of_view > WIDEST:
        light_scene.notes.append(f"'{request.name}' sees {math.degrees(WIDEST):.0f}° at most")
    return float(min(request.field_of_view, WIDEST))


def _views(request: Any) -> list[Array]:
    """Axes (3, 3) of the four views, columns right, up, ahead; each a quarter turn on."""
    x, y, z = (request.matrix[:3, i] for i in range(3))
    return [np.stack(axes, axis=1) for axes in ((x, y, -z), (-z, y, -x), (-x, y, z), (z, y, x))]


def _rays(request: Any, view: Array, enlarged: float = 1.0) -> Array:
    """Vectors (4, 3) from the sensor to the corners of its view a metre ahead."""
    half = math.tan(min(request.field_of_view, WIDEST) / 2) * enlarged
    return np.array([view @ (half * a, half * b, 1.0) for a, b in 2 * CORNERS - 1])


def _meets_lid(light_scene: Any, beam: Any, other: Any) -> bool:
    """Whether a view of `beam` may meet the lid at the end of one of `other`, no wall before it.

    Where paths go through one more surface, Cycles draws other random numbers.
    """
    slopes = [math.sqrt(2) * math.tan(min(r.field_of_view, WIDEST) / 2) for r in (beam, other)]
    start = max(beam.clip_start, NEAREST_CLIP)
    for view in _views(beam):
        for end in _views(other):
            lid = other.matrix[:3, 3] + end[:, 2] * other.clip_end - beam.matrix[:3, 3]
            along = float(np.clip(lid @ view[:, 2], 0.0, beam.clip_end))
            apart = float(np.linalg.norm(lid - along * view[:, 2]))
            size = OVERLAP * slopes[1] * other.clip_end
            if apart <= slopes[0] * (along + size) + size and any(
                light_scene.is_open(beam.matrix[:3, 3] + start * ray, ray, along - size - start)
                for ray in (view[:, 2], *_rays(beam, view))
            ):
                return True
    return False


def _render(light_scene: Any, together: dict[int, Any]) -> list[Array]:
    scene = light_scene.scene
    made = [_camera(light_scene), _sheet(light_scene, together)]
    made.append(_lids(light_scene, list(together.values())))
    for obj in made:
        scene.collection.objects.link(obj)
    scene.camera = made[0]
    render, settings = scene.render, scene.render.image_settings
    render.resolution_x = render.resolution_y = SIDE
    if hasattr(settings, "media_type"):
        settings.media_type = "IMAGE"
    settings.file_format = "OPEN_EXR"
    settings.color_mode, settings.color_depth, settings.exr_codec = "RGB", "32", "NONE"
    with tempfile.TemporaryDirectory(prefix="angen_light_") as folder:
        render.filepath = str(Path(folder, "views"))
        bpy.ops.render.render(write_still=True, scene=scene.name)
        picture = exr.read_rgb(Path(folder, "views.exr"))
    for obj in made:
        scene.collection.objects.unlink(obj)
    pixels = to_rec709(picture).reshape(SLOTS, WALLS, 3)
    return [pixels[slot] for slot in together]


def _camera(light_scene: Any) -> Any:
    """Sees the sheet and nothing else, upright: its first row of pixels is the picture's."""
    own = light_scene.own
    data = own(bpy.data.cameras.new(".angen_light"))
    data.type = "ORTHO"
    data.ortho_scale = SIDE
    data.clip_start, data.clip_end = 0.5, 1.5
    camera = own(bpy.data.objects.new(".angen_light", data))
    camera.matrix_world = Matrix.Translation((SHEET[0], SHEET[1], SHEET[2] + 1.0))
    return camera


def _sheet(light_scene: Any, together: dict[int, Any]) -> Any:
    """A square a view, that sends what comes in on from the near clip plane of the view."""
    corners, places, ways = [], [], []
    for slot, request in together.items():
        for wall, view in enumerate(_views(request)):
            row, column = divmod(slot * WALLS + wall, SIDE)
            middle = np.array([column - SIDE / 2, SIDE / 2 - 1 - row])
            rays = _rays(request, view)
            corners.append(np.c_[CORNERS + middle, np.zeros(WALLS)] + SHEET)
            places.append(request.matrix[:3, 3] + max(request.clip_start, NEAREST_CLIP) * rays)
            ways.append(rays)
    sheet = _squares(light_scene, corners, {"angen_place": places, "angen_way": ways})
    sheet.data.materials.append(_portal(light_scene.own))
    return sheet


def _lids(light_scene: Any, requests: Sequence[Any]) -> Any:
    """A square at the far clip plane of each view, from which only the world is seen."""
    corners, reaches = [], []
    for request in requests:
        for view in _views(request):
            rays = _rays(request, view, OVERLAP)
            corners.append(request.matrix[:3, 3] + request.clip_end * rays)
            reaches.append((request.clip_end - max(request.clip_start, NEAREST_CLIP)) * rays)
    lids = _squares(light_scene, corners, {"angen_reach": reaches})
    lids.data.materials.append(_lid(light_scene.own))
    return lids


def _squares(light_scene: Any, corners: list[Array], vectors: dict[str, list[Array]]) -> Any:
    """An object of squares with vectors at their corners, which only camera rays see."""
    own = light_scene.own
    mesh = own(bpy.data.meshes.new(".angen_light"))
    faces = np.arange(WALLS * len(corners)).reshape(-1, WALLS).tolist()
    mesh.from_pydata(np.concatenate(corners).tolist(), [], faces)
    for name, found in vectors.items():
        attribute = mesh.attributes.new(name, "FLOAT_VECTOR", "POINT")
        attribute.data.foreach_set("vector", np.concatenate(found).astype(np.float32).ravel())
    squares = own(bpy.data.objects.new(".angen_light", mesh))
    for rays in UNSEEN_BY:
        setattr(squares, f"visible_{rays}", False)
    return squares


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
