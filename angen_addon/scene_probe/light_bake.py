# SPDX-License-Identifier: GPL-3.0-or-later
"""Irradiance at many sensors by one Cycles bake: a small white face for each, one texel a face.

A texel's place decides its random numbers. Each sensor's place comes from its own name, so what it
reads is the same to the bit whatever other sensors there are.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from .light_colour import to_rec709

Array = NDArray[np.float64]
# Texels a side of the image baked into. Cycles visits the empty ones too, for each sample: at 128
# they took as long as seven sensors. A smaller image would make names collide more often.
SIDE = 32
# The face is this large, and stands this far off its origin, in metres: off the wall that the
# sensor sits on. Where coordinates are coarser, as many of their steps.
FACE = 1e-3
STEPS = 16.0
RAYS = ("camera", "diffuse", "glossy", "transmission", "shadow")


def irradiance(light_scene: Any, requests: Sequence[Any], samples: int) -> list[Array]:
    """W/m² (3,) of linear Rec. 709 on the −Z face of each request."""
    light_scene.scene.cycles.samples = samples
    found: dict[str, Array] = {}
    left = list(requests)
    while left:
        # One pair of names in a thousand wants the same texel: those are baked one after the other.
        texels: dict[int, Any] = {}
        for request in left:
            texels.setdefault(texel_of(request.name), request)
        baked = _bake(light_scene, texels)
        for (_, request), colour in zip(texels.items(), baked, strict=True):
            found[request.name] = to_rec709(np.pi * colour)
        left = [request for request in left if request.name not in found]
    return [found[request.name] for request in requests]


def texel_of(name: str) -> int:
    digest = hashlib.blake2b(name.encode(), digest_size=8).digest()
    return int.from_bytes(digest, "little") % (SIDE * SIDE)


def _bake(light_scene: Any, texels: dict[int, Any]) -> Array:
    """Pixels (n, 3), radiance of the white faces."""
    own = light_scene.own
    image = own(bpy.data.images.new(".angen_light", SIDE, SIDE, float_buffer=True, is_data=True))
    probe = _probe(light_scene, texels, image)
    scene, layer = light_scene.scene, light_scene.view_layer
    with bpy.context.temp_override(
        scene=scene, view_layer=layer, active_object=probe, object=probe, selected_objects=[probe]
    ):
        bpy.ops.object.bake(
            type="DIFFUSE",
            pass_filter={"DIRECT", "INDIRECT"},
            target="IMAGE_TEXTURES",
            save_mode="INTERNAL",
            use_clear=True,
            use_selected_to_active=False,
            margin=0,
        )
    pixels = np.empty(SIDE * SIDE * 4, np.float32)
    image.pixels.foreach_get(pixels)
    light_scene.scene.collection.objects.unlink(probe)
    return pixels.reshape(-1, 4)[list(texels), :3].astype(np.float64)


def _probe(light_scene: Any, texels: dict[int, Any], image: Any) -> Any:
    """An object with a face for each request, that nothing but the bake itself sees."""
    own = light_scene.own
    size = face_size(light_scene.scene, [r.matrix for r in texels.values()])
    corners = [c for request in texels.values() for c in face(request.matrix, size)]
    faces = np.arange(len(corners)).reshape(-1, 4).tolist()
    mesh = own(bpy.data.meshes.new(".angen_light"))
    mesh.from_pydata(np.array(corners).tolist(), [], faces)
    places = np.array([(texel % SIDE, texel // SIDE) for texel in texels], np.float64)
    square = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
    coordinates = (places[:, None, :] + square) / SIDE
    mesh.uv_layers.new().data.foreach_set("uv", coordinates.astype(np.float32).ravel())
    mesh.materials.append(white(own, image))
    probe = own(bpy.data.objects.new(".angen_light", mesh))
    for rays in RAYS:
        # Invisible to volume scatter too it would bake nothing at all.
        setattr(probe, f"visible_{rays}", False)
    light_scene.scene.collection.objects.link(probe)
    return probe


def face_size(scene: Any, matrices: Sequence[Array]) -> float:
    """Side of a face, and its distance off its origin, in Blender units."""
    metres = scene.unit_settings.scale_length if scene.unit_settings.system != "NONE" else 1.0
    farthest = max(float(np.abs(matrix[:3, 3]).max()) for matrix in matrices)
    return max(FACE / metres, STEPS * float(np.spacing(np.float32(farthest))))


def face(matrix: Array, size: float) -> Array:
    """Corners (4, 3) of a square that looks along the −Z of a pose, a bit ahead of it."""
    x, y, z = matrix[:3, 0], matrix[:3, 1], matrix[:3, 2]
    middle = matrix[:3, 3] - z * size
    h = size / 2
    # Counter-clockwise seen from −Z, so that this is the front.
    return np.array([middle + h * (a * x + b * y) for a, b in ((1, -1), (-1, -1), (-1, 1), (1, 1))])


def white(own: Any, image: Any = None) -> Any:
    """A material that reflects all light diffusely; a bake goes to `image`."""
    material = own(bpy.data.materials.new(".angen_light"))
    if not material.node_tree:
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    diffuse = tree.nodes.new("ShaderNodeBsdfDiffuse")
    diffuse.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    diffuse.inputs["Roughness"].default_value = 0.0
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(diffuse.outputs[0], output.inputs["Surface"])
    if image is not None:
        target = tree.nodes.new("ShaderNodeTexImage")
        target.image = image
        tree.nodes.active = target
    return material
