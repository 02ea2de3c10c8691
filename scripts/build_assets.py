# SPDX-License-Identifier: GPL-3.0-or-later
"""Build an asset library for Blender's Asset Browser, with a sensor for each preset.

build_assets.py FOLDER [KIND …]

Each sensor has its housing. Without a KIND, such as PIR, the library has all kinds.
"""

import sys
import uuid
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import bpy
from mathutils import Vector

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))
PACKAGE = "angen_sensors"

# The namespace of catalog ids, which stay the same from build to build.
CATALOGS = uuid.UUID("5a0a1c55-3f0f-4b43-9c3e-6b2f6f3d7f10")
PREVIEW = 128
FILE, CATALOG_FILE = "angen_sensors.blend", "blender_assets.cats.txt"


def build(folder: Path, only: Sequence[str] = ()) -> int:
    """Write the library, of all kinds or only of some, to a folder; return the count of assets."""
    import_module("angen_addon.process.standalone").load_extension().register()
    kinds = import_module(f"{PACKAGE}.sensor_logic.kinds")
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    stage()
    folder.mkdir(parents=True, exist_ok=True)
    # With the catalog above them too: Blender would add it, and show the library as not saved.
    lines, made = ["VERSION 1", "", f"{uuid.uuid5(CATALOGS, 'SENSORS')}:Sensors:Sensors"], set()
    for name, kind in kinds.KINDS.items():
        if only and name not in only:
            continue
        catalog = str(uuid.uuid5(CATALOGS, kind.identifier))
        lines.append(f"{catalog}:Sensors/{kind.label}:{kind.label}")
        for preset in kind.presets:
            sensor = asset(kind, preset, catalog)
            picture(sensor, folder / ".preview.png")
            # The next sensors are rendered without this one.
            sensor.hide_render = True
            made.add(sensor)
    (folder / ".preview.png").unlink(missing_ok=True)
    for sensor in made:
        sensor.hide_render = False
    (folder / CATALOG_FILE).write_text("\n".join(lines) + "\n", encoding="utf-8")
    bpy.data.libraries.write(str(folder / FILE), made, fake_user=True, compress=True)
    return len(made)


def asset(kind: Any, preset: Any, catalog: str) -> Any:
    """Return the sensor of a preset, named as the part and marked as an asset."""
    presets = import_module(f"{PACKAGE}.angen_addon.authoring.presets")
    sensor = presets.new_sensor(bpy.context, kind.identifier, preset, preset.label)
    sensor.asset_mark()
    facts = sensor.asset_data
    facts.catalog_id = catalog
    facts.author = "Ängen Sensors"
    facts.license = "GPL-3.0-or-later"
    facts.description = f"{kind.label}. Source: {preset.source}"[:255]
    facts.tags.new("sensor")
    facts.tags.new(kind.identifier.lower())
    return sensor


def stage() -> None:
    """Add a camera and light for the previews."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising = 16, False
    scene.render.resolution_x = scene.render.resolution_y = PREVIEW
    scene.render.film_transparent = True
    world = bpy.data.worlds.new("preview")
    world.color = (0.5, 0.5, 0.5)
    scene.world = world
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.type = "ORTHO"
    camera.data.clip_start = 1e-4
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    sun.data.energy = 2.0
    sun.rotation_euler = (0.6, 0.3, 0.4)
    for obj in (camera, sun):
        scene.collection.objects.link(obj)
    scene.camera = camera


def picture(sensor: Any, path: Path) -> None:
    """Render the sensor from its sensing side as its preview."""
    scene = bpy.context.scene
    mesh = sensor.data
    # Only vertices of faces: the edges that show the viewing direction reach beyond the housing.
    shown = {vertex for face in mesh.polygons for vertex in face.vertices}
    points = [mesh.vertices[vertex].co for vertex in shown]
    low, high = (Vector(map(of, zip(*points, strict=True))) for of in (min, max))
    middle, size = (low + high) / 2, (high - low).length
    side = 1.0 if sensor.angen_sensor.kind == "PRESSURE" else -1.0
    way = Vector((0.5, 0.6, side)).normalized()
    scene.camera.location = middle + way * size * 3
    scene.camera.rotation_euler = way.to_track_quat("Z", "Y").to_euler()
    scene.camera.data.ortho_scale = size * 1.1
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    # Not as a custom preview from the file: Blender caches those by path and second, so that a
    # sensor would get the picture of another one rendered in the same second.
    image = bpy.data.images.load(str(path))
    preview = sensor.preview_ensure()
    preview.image_size = image.size
    preview.image_pixels_float = image.pixels[:]
    bpy.data.images.remove(image)


if __name__ == "__main__":
    target = Path(sys.argv[1])
    with import_module("angen_addon.process.system").standard_output_silenced():
        count = build(target, sys.argv[2:])
    print(f"{count} assets in {target / FILE}")
