# SPDX-License-Identifier: GPL-3.0-or-later
"""`python light_story.py JOB`: the light of the Ängen home at some frames of its story, by the code
of a checkout, with each of some seeds; JSON on the last line of its output.

A process of its own, so that also former code can be measured, and processor time alone. `JOB` is
JSON with `root`, `method`, `samples`, `reference`, `seeds` and `frames`.
"""

from __future__ import annotations

import json
import sys
import time
from importlib import import_module
from pathlib import Path
from typing import Any

import bpy
import numpy as np

PROBE = "angen_sensors.angen_addon"
HOME = Path(__file__).resolve().parent.parent / "sample_blends" / "angen.blend"
# Where a checkout has its parts: the present one, or one before light was a sum over lamps.
PRESENT = (
    "angen_addon.process.standalone",
    *("scene.light.probe", "scene.light.engine", "scene.light.cycles", "CyclesLight"),
)
FORMER = (
    "angen_addon.standalone",
    *("scene_probe.light", "scene_probe.light_engine", "scene_probe.light_kept", "KeptScenes"),
)


def parts(root: Path) -> tuple[Any, Any, Any]:
    """The checkout's probe and engine modules, and the class of what is kept in a run."""
    sys.path.insert(0, str(root))
    is_present = (root / "angen_addon" / "scene" / "light").is_dir()
    standalone, probe, engine, kept, name = PRESENT if is_present else FORMER
    extension = import_module(standalone).load_extension()
    extension.register()
    found = getattr(import_module(f"{PROBE}.{kept}"), name)
    return import_module(f"{PROBE}.{probe}"), import_module(f"{PROBE}.{engine}"), found


def requests(probe: Any, method: str, samples: int) -> list[Any]:
    """What the home's own sensors ask, in the order of their names."""
    own = [o for o in bpy.context.scene.objects if o.angen_sensor.kind == "LIGHT"]
    return [
        probe.LightRequest(
            obj.name,
            np.array(obj.matrix_world, np.float64),
            method,
            samples=samples,
            exposure=obj.angen_sensor.light.exposure,
        )
        for obj in sorted(own, key=lambda obj: obj.name)
    ]


def story(probe: Any, asked: list[Any], frames: list[int], lights: Any) -> dict[str, Any]:
    """Values (frames, sensors), and the seconds that all of it took; `bare_s`: of these, what
    Blender took to put the home to its frames."""
    scene, layer, values, bare = bpy.context.scene, bpy.context.view_layer, [], 0.0
    cpu, wall = time.process_time(), time.perf_counter()
    for frame in frames:
        before = time.process_time()
        scene.frame_set(frame)
        bare += time.process_time() - before
        found = probe.measure(scene, layer, asked, kept=lights)
        samples = [found[request.name] for request in asked]
        read = [(s.illuminance_lux, s.luminance_percent) for s in samples]
        values.append([percent if lux is None else lux for lux, percent in read])
    cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
    lights.close()
    return {"values": values, "cpu_s": cpu, "wall_s": wall, "bare_s": bare}


def main() -> None:
    job = json.loads(sys.argv[1])
    probe, engine, kept = parts(Path(job["root"]).resolve())
    bpy.ops.wm.open_mainfile(filepath=job.get("blend", str(HOME)), load_ui=False)
    bpy.context.scene.angen_live = False
    asked = requests(probe, job["method"], job["samples"])
    found = []
    for engine.SEED in job["seeds"]:
        found.append(story(probe, asked, job["frames"], kept(job["reference"])))
    print("\n" + json.dumps(found), flush=True)


if __name__ == "__main__":
    main()
