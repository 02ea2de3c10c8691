# SPDX-License-Identifier: GPL-3.0-or-later
"""`python light_story.py CHECKOUT METHOD SAMPLES REFERENCE SEED STEP`: the light of the Ängen
home's story by the code of a checkout, every STEP frames; JSON on the last line of its output.

A process of its own, so that also former code can be measured, and processor time alone. What the
same frames cost without light is told beside."""

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
# Where a checkout has its parts: the present one, or one before light was a sum over lamps.
PLACES = (
    ("scene.light.probe", "scene.light.engine", "scene.light.cycles", "CyclesLight"),
    ("scene_probe.light", "scene_probe.light_engine", "scene_probe.light_kept", "KeptScenes"),
)


def parts(root: Path) -> tuple[Any, Any, Any]:
    """The checkout's probe and engine modules, and the class of what is kept in a run."""
    sys.path.insert(0, str(root))
    extension = import_module("angen_addon.standalone").load_extension()
    extension.register()
    for probe, engine, kept, name in PLACES:
        try:
            found = getattr(import_module(f"{PROBE}.{kept}"), name)
        except ImportError:
            continue
        return import_module(f"{PROBE}.{probe}"), import_module(f"{PROBE}.{engine}"), found
    raise SystemExit(f"{root} has no light sensors that this benchmark knows")


def main() -> None:
    root, method = Path(sys.argv[1]).resolve(), sys.argv[2]
    samples, reference, seed, step = map(int, sys.argv[3:7])
    probe, engine, kept = parts(root)
    engine.SEED = seed
    blend = Path(__file__).resolve().parent.parent / "sample_blends" / "angen.blend"
    bpy.ops.wm.open_mainfile(filepath=str(blend), load_ui=False)
    scene, layer = bpy.context.scene, bpy.context.view_layer
    scene.angen_live = False
    own = [o for o in scene.objects if o.angen_sensor.kind == "LIGHT"]
    asked = [
        probe.LightRequest(
            obj.name,
            np.array(obj.matrix_world, np.float64),
            method,
            samples=samples,
            exposure=obj.angen_sensor.light.exposure,
        )
        for obj in sorted(own, key=lambda obj: obj.name)
    ]
    frames = range(scene.frame_start, scene.frame_end + 1, step)
    bare = time.process_time()
    for frame in frames:
        scene.frame_set(frame)
    bare = time.process_time() - bare
    lights, values = kept(reference), []
    seconds, clock = time.process_time(), time.perf_counter()
    for frame in frames:
        scene.frame_set(frame)
        found = probe.measure(scene, layer, asked, kept=lights)
        read = [found[request.name] for request in asked]
        values.append(
            [s.illuminance_lux if method == "ILLUMINANCE" else s.luminance_percent for s in read]
        )
    seconds, clock = time.process_time() - seconds, time.perf_counter() - clock
    lights.close()
    found = {"frames": list(frames), "values": values, "cpu_s": seconds, "wall_s": clock}
    print("\n" + json.dumps({**found, "bare_s": bare}), flush=True)


if __name__ == "__main__":
    main()
