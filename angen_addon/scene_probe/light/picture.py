# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures whose pixels look from anywhere to anywhere: one Cycles render for all sensors.

The camera looks at a sheet of squares, one a pixel, far from the scene. Each square is a ray
portal: what enters it goes on from a sensor's place, as from a camera of its own there. A pixel's
place decides its random numbers, and each sensor's pixels come from its own name: so what it reads
is the same to the bit whatever other sensors there are.
"""

from __future__ import annotations

import hashlib
import tempfile
from collections.abc import Callable, Generator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import bpy
import numpy as np
from mathutils import Matrix
from numpy.typing import NDArray

from . import exr
from .colour import to_rec709
from .nodes import Nodes
from .scene import quietly

Array = NDArray[np.float64]
# Pixels a side. Cycles visits the empty ones too; fewer would make names collide more often.
SIDE = 16
# Where the sheet lies, under everything: nothing else is between the clip planes of its camera.
SHEET = (0.0, 0.0, -1e5)
# Its camera is that much above it: as near as single precision allows there, for the sake of fog.
ABOVE = 1.0 / 32.0
CORNERS = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
UNSEEN_BY = ("diffuse", "glossy", "transmission", "shadow", "volume_scatter")


T = TypeVar("T")
# Yields before each picture, in words what takes long, else nothing; the result comes last.
Steps = Generator[str, None, T]


def finished(steps: Steps[T]) -> T:
    """The result, with no break."""
    while True:
        try:
            next(steps)
        except StopIteration as end:
            return end.value  # type: ignore[no-any-return]


@dataclass(frozen=True)
class Seen:
    """A request; of four walls, those (0 … 3) whose views reach their far clip plane: they need
    a lid there."""

    request: Any
    lids: tuple[int, ...] = ()


def pixel_of(name: str, count: int) -> int:
    """The first of `count` neighbouring pixels that belong to a name."""
    digest = hashlib.blake2b(name.encode(), digest_size=8).digest()
    return int.from_bytes(digest, "little") % (SIDE * SIDE // count) * count


def share_out(
    wanted: list[Seen], count: int, collide: Callable[[Seen, Seen], bool]
) -> list[dict[int, Seen]]:
    """What is wanted by its first of `count` pixels; in as many pictures as it takes, so that no
    two in one collide."""
    found = []
    while wanted:
        together: dict[int, Seen] = {}
        left = []
        for seen in wanted:
            pixel = pixel_of(seen.request.name, count)
            if pixel in together or any(collide(seen, other) for other in together.values()):
                left.append(seen)
            else:
                together[pixel] = seen
        found.append(together)
        wanted = left
    return found


class Picture:
    """A picture of a light scene. `rays`: by pixel, where the rays through the corners of its
    square start (4, 3), and their directions (4, 3), not normalised; corners as `CORNERS`."""

    def __init__(
        self, light_scene: Any, rays: dict[int, tuple[Array, Array]], samples: int
    ) -> None:
        scene = self._scene = light_scene.scene
        scene.camera = _camera(light_scene)
        corners = []
        for pixel in rays:
            row, column = divmod(pixel, SIDE)
            middle = np.array([column - SIDE / 2, SIDE / 2 - 1 - row])
            corners.append(np.c_[CORNERS + middle, np.zeros(4)] + SHEET)
        vectors = {
            "angen_place": [places for places, _ in rays.values()],
            "angen_way": [ways for _, ways in rays.values()],
        }
        add_squares(light_scene, corners, vectors, _portal(light_scene.own))
        scene.cycles.samples = samples
        render, settings = scene.render, scene.render.image_settings
        render.resolution_x = render.resolution_y = SIDE
        if hasattr(settings, "media_type"):
            settings.media_type = "IMAGE"
        settings.file_format = "OPEN_EXR"
        settings.color_mode, settings.color_depth, settings.exr_codec = "RGB", "32", "NONE"

    def pixels(self) -> Array:
        """Linear radiance (n, 3) of all pixels, row by row from the top."""
        with tempfile.TemporaryDirectory(prefix="angen_light_", dir=bpy.app.tempdir) as folder:
            self._scene.render.filepath = str(Path(folder, "views"))
            # Named as an argument, a scene is put to the frame of the user's.
            own = {"scene": self._scene, "view_layer": self._scene.view_layers[0]}
            with quietly(), bpy.context.temp_override(**own):
                bpy.ops.render.render(write_still=True)
            picture = exr.read_rgb(Path(folder, "views.exr"))
        return to_rec709(picture).reshape(SIDE * SIDE, 3)


def _camera(light_scene: Any) -> Any:
    """Sees the sheet and nothing else, upright: its first row of pixels is the picture's."""
    own = light_scene.own
    data = own(bpy.data.cameras.new(".angen_light"))
    data.type = "ORTHO"
    data.ortho_scale = SIDE
    data.clip_start, data.clip_end = ABOVE / 2, ABOVE * 1.5
    camera = own(bpy.data.objects.new(".angen_light", data))
    camera.matrix_world = Matrix.Translation((SHEET[0], SHEET[1], SHEET[2] + ABOVE))
    light_scene.scene.collection.objects.link(camera)
    return camera


def add_squares(
    light_scene: Any, corners: list[Array], vectors: dict[str, list[Array]], material: Any
) -> None:
    """Adds squares with vectors at their corners, which only camera rays see."""
    own = light_scene.own
    mesh = own(bpy.data.meshes.new(".angen_light"))
    faces = np.arange(4 * len(corners)).reshape(-1, 4).tolist()
    mesh.from_pydata(np.concatenate(corners).tolist(), [], faces)
    for name, found in vectors.items():
        attribute = mesh.attributes.new(name, "FLOAT_VECTOR", "POINT")
        attribute.data.foreach_set("vector", np.concatenate(found).astype(np.float32).ravel())
    mesh.materials.append(material)
    squares = own(bpy.data.objects.new(".angen_light", mesh))
    for rays in UNSEEN_BY:
        setattr(squares, f"visible_{rays}", False)
    light_scene.scene.collection.objects.link(squares)


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
