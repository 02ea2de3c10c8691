# SPDX-License-Identifier: GPL-3.0-or-later
"""Import a home into Blender, and add a walking person and a sensor of every kind and model.

python furnish.py HOME.{blend,glb,gltf,obj} OUT.blend REFERENCE.blend

Rays find the places for them. Saves two blend files; REFERENCE uses `scene.ray_cast`.
"""

from __future__ import annotations

import atexit
import math
import os
import shutil
import sys
import tempfile
from collections import Counter
from importlib import import_module
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
ADDON = "bl_ext.user_default.angen_sensors"
FRAMES = 72
# Heights of eyes, person and sensors, and distance from a wall (m).
EYES, TALL, CEILING, ASIDE = 1.2, 1.7, 2.2, 0.05
CELLS = 24


def enable() -> None:
    """Enable the extension of this checkout in an empty user folder."""
    resources = Path(tempfile.mkdtemp(prefix="angen_foreign_"))
    atexit.register(shutil.rmtree, resources, ignore_errors=True)
    extensions = resources / "extensions" / "user_default"
    extensions.mkdir(parents=True)
    (extensions / "angen_sensors").symlink_to(ROOT)
    os.environ["BLENDER_USER_RESOURCES"] = str(resources)
    import bpy  # noqa: F401  (it looks for its folders now, and makes addon_utils importable)

    import_module("addon_utils").enable(ADDON, default_set=True)


def load(home: Path) -> None:
    """Open or import a home."""
    import addon_utils
    import bpy

    if home.suffix == ".blend":
        bpy.ops.wm.open_mainfile(filepath=str(home), load_ui=False)
        return
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    if home.suffix == ".obj":
        bpy.ops.wm.obj_import(filepath=str(home), up_axis="Z", forward_axis="Y")
    else:
        addon_utils.enable("io_scene_gltf2")
        bpy.ops.import_scene.gltf(filepath=str(home))


class Rays:
    """Rays through the home, in metres."""

    def __init__(self) -> None:
        import bpy

        self.scene = bpy.context.scene
        self.metres = self.scene.unit_settings.scale_length
        self.depsgraph = bpy.context.evaluated_depsgraph_get()
        corners = [
            self.metres * (instance.matrix_world @ _vector(corner))
            for instance in self.depsgraph.object_instances
            if _is_shown(instance.object)
            for corner in instance.object.bound_box
        ]
        finite = [c for c in corners if all(math.isfinite(x) for x in c)]
        if not finite:
            sys.exit("no mesh is shown in this file")
        self.lo = [min(c[i] for c in finite) for i in range(3)]
        self.hi = [max(c[i] for c in finite) for i in range(3)]

    def far(self, start: Any, way: Any, most: float = 1000.0) -> float:
        """Return the length of a ray up to its hit, at most `most` m."""
        hit, place, *_ = self.scene.ray_cast(
            self.depsgraph,
            _vector(start) / self.metres,
            _vector(way),
            distance=most / self.metres,
        )
        return (place * self.metres - _vector(start)).length if hit else most


def _is_shown(seen: Any) -> bool:
    """Return whether an evaluated object is a visible mesh with faces."""
    return seen.type == "MESH" and len(seen.data.polygons) > 0 and seen.original.visible_get()


def _vector(numbers: Any) -> Any:
    from mathutils import Vector

    return Vector(numbers)


def floors(rays: Rays) -> list[Any]:
    """Return points on the floor with headroom for a person, of the storey with most of them."""
    found: Counter[int] = Counter()
    points: dict[int, list[Any]] = {}
    lo, hi = rays.lo, rays.hi
    for i in range(1, CELLS):
        for j in range(1, CELLS):
            x, y = (lo[k] + (hi[k] - lo[k]) * n / CELLS for k, n in ((0, i), (1, j)))
            z = hi[2] + 0.1
            while (down := rays.far((x, y, z), (0, 0, -1))) < 1000.0:
                z -= down
                if rays.far((x, y, z + 0.02), (0, 0, 1)) > TALL + 0.1:
                    level = round(z / 0.2)
                    # A point under a roof counts more than one on it.
                    covered = rays.far((x, y, z + 0.02), (0, 0, 1)) < 5.0
                    found[level] += 10 if covered else 1
                    points.setdefault(level, []).append((x, y, z))
                z -= 0.05
    if not found:
        return [(0.0, 0.0, lo[2])]
    return points[found.most_common(1)[0][0]]


def walk(rays: Rays, points: list[Any]) -> tuple[Any, Any]:
    """Return the ends of the longest straight walk that a person can take between two points."""
    best, longest = (points[0], points[0]), 0.0
    for a in points[:: max(1, len(points) // 40)]:
        for b in points[:: max(1, len(points) // 40)]:
            way = _vector(b) - _vector(a)
            way.z = 0.0
            if longest < way.length < 8.0:
                start = (a[0], a[1], a[2] + EYES)
                if rays.far(start, way.normalized(), way.length) >= way.length:
                    best, longest = (a, b), way.length
    return best


def furnish(rays: Rays) -> None:
    """Add the person, the sensors and, if the home has none, a lamp."""
    import bpy

    scene = rays.scene
    scene.frame_start, scene.frame_end = 1, FRAMES
    scene.render.fps, scene.render.fps_base = 24, 1.0
    points = floors(rays)
    start, end = walk(rays, points)
    middle = [(a + b) / 2 for a, b in zip(start, end, strict=True)]
    person = box("Angen person", (0.4, 0.3, TALL), start, rays)
    person.angen_load.mass = 70.0
    person.angen_warmth.use_temperature, person.angen_warmth.temperature = True, 34.0
    lift = TALL / 2 + 0.022
    for frame, place in ((1, start), (FRAMES // 2, middle), (FRAMES, end)):
        person.location = _vector((place[0], place[1], start[2] + lift)) / rays.metres
        person.keyframe_insert("location", frame=frame)
    pad = box("Angen pad", (0.6, 0.6, 0.02), (middle[0], middle[1], start[2] + 0.01), rays)
    sensor(pad, "PRESSURE", update_rate=12.0)
    eyes = (middle[0], middle[1], start[2] + EYES)
    up = min(rays.far(eyes, (0, 0, 1)) - ASIDE, CEILING - EYES)
    for number, model in enumerate(("RANGE_SCAN", "PYROELECTRIC")):
        turn = math.pi * number
        way = (math.cos(turn), math.sin(turn), 0.0)
        far = min(rays.far(eyes, way), 4.0)
        at = [eyes[i] + way[i] * max(far - ASIDE, 0.1) for i in range(3)]
        at[2] = eyes[2] + up
        obj = empty(f"Angen PIR {model.lower()}", at, (math.pi / 2, 0, turn + math.pi / 2), rays)
        sensor(obj, "PIR", model=model, update_rate=12.0)
    for name, settings in (("ray", {}), ("swept", {"swept": True}), ("aperture", APERTURE)):
        at = (middle[0], middle[1] - 0.6, eyes[2])
        obj = empty(f"Angen switch {name}", at, (math.pi / 2, 0, 0), rays)
        obj.angen_sensor.optical_switch.range_max = 2.0
        sensor(obj, "OPTICAL_SWITCH", update_rate=24.0, **settings)
    above = (eyes[0], eyes[1], eyes[2] + up)
    for name, method, engine in LIGHTS:
        obj = empty(f"Angen light {name}", above, (0, 0, 0), rays)
        sensor(obj, "LIGHT", method=method, engine=engine, update_rate=1.0, samples=4)
    if not any(o.type == "LIGHT" for o in bpy.context.view_layer.objects):
        lamp = bpy.data.lights.new("Angen lamp", "POINT")
        lamp.energy = 1.2  # W of light: 800 lm
        obj = bpy.data.objects.new("Angen lamp", lamp)
        obj.location = _vector(above) / rays.metres
        scene.collection.objects.link(obj)


APERTURE = {"aperture_rays": 7, "aperture": 0.01}
LIGHTS = (
    ("walls", "FOUR_WALL", "CYCLES"),
    ("lux", "ILLUMINANCE", "CYCLES"),
    ("Cycles", "ILLUMINANCE", "CYCLES"),
)


def box(name: str, size: Any, at: Any, rays: Rays) -> Any:
    import bpy

    h = [s / 2 / rays.metres for s in size]
    corners = [(x * h[0], y * h[1], z * h[2]) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(corners, [], faces)
    return link(bpy.data.objects.new(name, mesh), at, rays)


def empty(name: str, at: Any, turned: Any, rays: Rays) -> Any:
    import bpy

    obj = link(bpy.data.objects.new(name, None), at, rays)
    obj.rotation_euler = turned
    return obj


def link(obj: Any, at: Any, rays: Rays) -> Any:
    rays.scene.collection.objects.link(obj)
    obj.location = _vector(at) / rays.metres
    return obj


def sensor(obj: Any, kind: str, **settings: Any) -> None:
    obj.angen_sensor.kind = kind
    for key, value in settings.items():
        group = obj.angen_sensor
        setattr(group if hasattr(group, key) else getattr(group, kind.lower()), key, value)


def main(home: str, out: str, reference: str) -> None:
    enable()
    import bpy

    load(Path(home))
    rays = Rays()
    furnish(rays)
    size = [rays.hi[i] - rays.lo[i] for i in range(3)]
    faces = sum(len(o.data.polygons) for o in bpy.data.objects if o.type == "MESH")
    objects = len(bpy.data.objects)
    print(
        f"size: {size[0]:.1f} × {size[1]:.1f} × {size[2]:.1f} m, {objects} objects, {faces} faces"
    )
    bpy.ops.file.make_paths_absolute()
    bpy.ops.wm.save_as_mainfile(filepath=str(Path(out).absolute()))
    bpy.context.scene.angen_ray_caster = "SCENE"
    bpy.ops.wm.save_as_mainfile(filepath=str(Path(reference).absolute()), copy=True)
    sys.stdout.flush()
    # Blender's module can crash as the process ends.
    for folder in (bpy.app.tempdir, os.environ["BLENDER_USER_RESOURCES"]):
        shutil.rmtree(folder, ignore_errors=True)
    os._exit(0)


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    main(*sys.argv[1:])
