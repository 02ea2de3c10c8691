# SPDX-License-Identifier: GPL-3.0-or-later
"""Render light by EEVEE: the views of all sensors in one render, each by a camera of its own."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix

from ....sensor_logic.model import Array
from . import engine
from .faces import face, face_size, white
from .views import NEAREST_CLIP, WALLS, WIDEST

# The least size of a picture that Blender renders.
PIXELS = 4
# EEVEE's samples vary the place on the lamps, and converge sooner than light paths do.
EEVEE_SAMPLES = 64
LENS_MM = 500.0
WIDE_LENS_MM = 10.0
# The distance of the camera from the sensor's white face, in sides of the face.
FACE_DISTANCE = 4.0
# EEVEE's shadows are too coarse for the face that a bake uses.
EEVEE_FACE = 10.0


def four_walls(light_scene: Any, requests: Sequence[Any], samples: int) -> list[Array]:
    """Render the four views of each light sensor; return the linear radiance (4, 3) of each.

    The views look along the sensor's own axes −Z, −X, +Z and +X, as if at four walls around it.
    Each view is a row of the result.
    """
    scene = light_scene.scene
    scene.eevee.taa_render_samples = min(EEVEE_SAMPLES, max(1, samples // WALLS))
    cameras = []
    for request in requests:
        if request.field_of_view > WIDEST:
            light_scene.notes.append(
                f"the field of view of '{request.name}' is limited to {math.degrees(WIDEST):.0f}°"
            )
        for wall in range(WALLS):
            data = light_scene.own(bpy.data.cameras.new(".angen_light"))
            _set_angle(data, request.field_of_view)
            data.clip_start = max(request.clip_start, NEAREST_CLIP)
            data.clip_end = request.clip_end
            turn = np.array(Matrix.Rotation(wall * math.pi / 2, 4, "Y"), np.float64)
            cameras.append((data, request.matrix @ turn))
    views = _render(light_scene, cameras)
    return list(views.reshape(len(requests), WALLS, 3))


def faces(light_scene: Any, requests: Sequence[Any], samples: int) -> list[Array]:
    """Return the irradiance (3,) in W/m² on the −Z face of each light request's pose.

    Cameras look at white faces, since EEVEE cannot bake.
    """
    scene = light_scene.scene
    scene.eevee.taa_render_samples = min(EEVEE_SAMPLES, max(1, samples))
    cameras, probes = [], []
    material = white(light_scene.own)
    for request in requests:
        size = EEVEE_FACE * face_size(scene, request.matrix)
        mesh = light_scene.own(bpy.data.meshes.new(".angen_light"))
        mesh.from_pydata(face(request.matrix, size).tolist(), [], [(0, 1, 2, 3)])
        mesh.materials.append(material)
        probe = light_scene.own(bpy.data.objects.new(".angen_light", mesh))
        probe.visible_shadow = False
        probes.append(probe)
        scene.collection.objects.link(probe)
        data = light_scene.own(bpy.data.cameras.new(".angen_light"))
        data.type = "ORTHO"
        data.ortho_scale = size / 2
        data.clip_start, data.clip_end = size, FACE_DISTANCE * 2 * size
        pose = request.matrix.copy()
        pose[:3, 3] -= pose[:3, 2] * (FACE_DISTANCE + 1) * size
        # Looks back at the face: half a turn about its own Y.
        pose[:3, 0] *= -1.0
        pose[:3, 2] *= -1.0
        cameras.append((data, pose))
    colours = _render(light_scene, cameras)
    for probe in probes:
        scene.collection.objects.unlink(probe)
    return [math.pi * colour for colour in colours]


def _set_angle(data: Any, angle: float) -> None:
    half = math.tan(min(angle, WIDEST) / 2)
    data.sensor_fit = "HORIZONTAL"
    # Blender bounds the angle itself more narrowly than the sensor and the lens.
    data.lens = LENS_MM if half < 0.1 else WIDE_LENS_MM
    data.sensor_width = 2 * half * data.lens


def _render(light_scene: Any, cameras: Sequence[tuple[Any, Array]]) -> Array:
    """Return the mean linear colour (n, 3) that each of n cameras sees from its pose."""
    scene = light_scene.scene
    render = scene.render
    render.resolution_x = render.resolution_y = PIXELS
    settings = render.image_settings
    if hasattr(settings, "media_type"):
        settings.media_type = "IMAGE"
    settings.file_format = "OPEN_EXR"
    settings.color_mode, settings.color_depth, settings.exr_codec = "RGB", "32", "NONE"
    objects = []
    for data, pose in cameras:
        obj = bpy.data.objects.new(".angen_light", data)
        scene.collection.objects.link(obj)
        obj.matrix_world = Matrix(pose.tolist())
        objects.append(obj)
    names = _name_views(scene, objects)
    with tempfile.TemporaryDirectory(prefix="angen_light_", dir=bpy.app.tempdir) as folder:
        render.filepath = str(Path(folder, "view"))
        bpy.ops.render.render(write_still=True, scene=scene.name)
        pictures = [engine.read_layers(Path(folder, f"view{name}.exr"))[""] for name in names]
    for obj in objects:
        # The cameras of the next render get the same names.
        bpy.data.objects.remove(obj)
    return engine.to_rec709(np.array([picture.mean(axis=(0, 1)) for picture in pictures]))


def _name_views(scene: Any, objects: Sequence[Any]) -> list[str]:
    """Make each camera a view of a multiview render; return the names of the views.

    Blender finds the camera of a view by the end of the camera's name.
    """
    render = scene.render
    scene.camera = objects[0]
    if len(objects) == 1:
        return [""]
    render.use_multiview = True
    render.views_format = "MULTIVIEW"
    render.image_settings.views_format = "INDIVIDUAL"
    while len(render.views) > len(objects):
        render.views.remove(render.views[len(render.views) - 1])
    while len(render.views) < len(objects):
        render.views.new("view")
    names = [f"_{number:05d}" for number in range(len(objects))]
    for view, obj, name in zip(render.views, objects, names, strict=True):
        view.name = view.camera_suffix = name
        view.use = True
        obj.name = f".angen_light{name}"
    return names
