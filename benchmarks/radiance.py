# SPDX-License-Identifier: GPL-3.0-or-later
"""Compare Cycles with Radiance (Ward and others, LBNL), which share no code, in the Ängen home.

The home is simplified to what both engines represent in the same way: every surface is diffuse and
grey, and transparent objects (panes, shades) are removed. Lamps are spheres of their own radius and
power, the sun is a disk, the sky has one radiance. This needs pyradiance.

`measure` compares the irradiance of both engines at faces in every room. `measure_speed` compares
the seconds of one reading of all light sensors, with everything that must be redone after an object
moved. There each engine's errors are relative to its own result with many more rays.
"""

from __future__ import annotations

import math
import subprocess
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from angen_sensors.angen_addon.scene.instances import shown_objects
from angen_sensors.angen_addon.scene.light import probe
from angen_sensors.angen_addon.scene.light.changes import tint_of
from angen_sensors.angen_addon.scene.light.faces import face_size
from angen_sensors.angen_addon.scene.light.materials import Surfaces, glows, is_clear
from angen_sensors.angen_addon.scene.light.probe import LightRequest
from angen_sensors.angen_addon.scene.light.scene import Housings, is_portal
from angen_sensors.sensor_logic.physics import luminance

from .bounds import CYCLES, LEAST_W_M2, RADIANCE
from .common import open_home, progress, rms, spread

FRAME = 1500
SKY = 1.0
# Radiance's options for high quality: no approximation of light sources, no interpolation. Ambient
# bounces sample the sky, even if surfaces are black.
QUALITY = ["-ds", "0.02", "-dj", "0.9", "-dt", "0", "-dc", "1", "-u+"]
QUALITY += ["-aa", "0", "-as", "0", "-lw", "1e-7", "-lr", "-100"]
DIVISIONS = 8_192
# A window is a small part of a face's view: with too few divisions no ray would hit it.
SKY_DIVISIONS = 1_048_576
# Ten bounces would miss 4 % of the light in the white closet and 16 % in the bathroom.
DIRECT_BOUNCES, BOUNCES = 1, 30
# The rms error at which the speeds of both engines are compared.
SAME = 0.03
# Cycles's paths and Radiance's ambient divisions; errors are relative to the last of each.
RAYS = {CYCLES: (32, 128, 512, 2048, 8192), RADIANCE: (16, 64, 256, 1024)}
EXACT = {CYCLES: 65_536, RADIANCE: 4_096}


def measure(samples: int) -> dict[str, Any]:
    """Return the irradiance of both engines at faces in every room, by day and by lamp.

    It is given for the direct light alone, and for all light.
    """
    rows = []
    for time_of_day in ("day", "lamp"):
        open_home().frame_set(FRAME)
        simplify(time_of_day)
        requests = faces()
        with tempfile.TemporaryDirectory() as folder:
            for part in ("direct", "whole"):
                progress("radiance", len(rows), 4 * len(requests), f"{time_of_day}, {part}")
                set_reflecting(part == "whole")
                octree = compiled(exported(Path(folder), part == "whole"))
                way = (BOUNCES, DIVISIONS) if part == "whole" else (DIRECT_BOUNCES, SKY_DIVISIONS)
                theirs = traced(octree, requests, *way)
                ours = rendered(requests, samples)
                for face, a, b in zip(requests, ours, theirs, strict=True):
                    told = {"time": time_of_day, "part": part, "at": face.name}
                    rows.append({**told, "cycles": a, "radiance": b})
    return {"rows": rows, "samples": samples, "divisions": DIVISIONS}


def measure_speed(rounds: int, quick: bool) -> dict[str, Any]:
    open_home().frame_set(FRAME)
    simplify("lamp")
    set_reflecting(True)
    requests = [face for face in faces() if face.name.endswith("down")]
    with tempfile.TemporaryDirectory() as folder:
        text = exported(Path(folder), True)
        engines: dict[str, Callable[[int], list[float]]] = {
            CYCLES: lambda samples: rendered(requests, samples),
            RADIANCE: lambda divisions: traced(compiled(text), requests, BOUNCES, divisions),
        }
        compile_s, _ = _timed(lambda: compiled(text))
        true = {n: np.array(e(EXACT[n] // (8 if quick else 1))) for n, e in engines.items()}
        lit = np.minimum(*true.values()) > LEAST_W_M2
        runs: dict[tuple[str, int], list[tuple[float, Any]]] = defaultdict(list)
        for turn in range(rounds):
            for name, work in engines.items():
                for count in RAYS[name][: -1 if quick and name == CYCLES else None]:
                    progress("peers", turn, rounds, f"{name}, {count}")
                    runs[name, count].append(_timed(lambda w=work, c=count: w(c)))
    rows = [
        {
            "engine": name,
            "rays": count,
            "seconds": spread([seconds for seconds, _ in found]),
            "rms": rms([np.array(values)[lit] / true[name][lit] - 1.0 for _, values in found]),
        }
        for (name, count), found in runs.items()
    ]
    return {
        "rows": rows, "faces": int(lit.sum()),
        "apart_rms": rms(true[CYCLES][lit] / true[RADIANCE][lit] - 1.0), "compile_s": compile_s,
        "same": SAME,
        "seconds": {n: _seconds_at(SAME, [r for r in rows if r["engine"] == n]) for n in engines},
    }  # fmt: skip


def _timed(work: Callable[[], Any]) -> tuple[float, Any]:
    """Return the seconds of `work`, and its result."""
    begin = time.perf_counter()
    found = work()
    return time.perf_counter() - begin, found


def _seconds_at(error: float, rows: list[dict[str, Any]]) -> float:
    """Return the seconds for an rms error, by a power law between the measured rows."""
    known = sorted((-math.log(row["rms"]), math.log(row["seconds"]["median"])) for row in rows)
    return math.exp(np.interp(-math.log(error), *zip(*known, strict=True)))


def simplify(time_of_day: str) -> None:
    """Make materials diffuse and grey, hide transparent objects, and leave lamps or daylight."""
    scene, layer = bpy.context.scene, bpy.context.view_layer
    surfaces, reflects = Surfaces(), {}
    for obj in list(scene.objects):
        materials = [s.material for s in obj.material_slots if s.material]
        if any(is_clear(m) and "ceiling" not in m.name for m in materials):
            obj.hide_set(True)
        if obj.type == "LIGHT":
            by_day = obj.data.type == "SUN" or obj.data.cycles.is_portal
            obj.hide_set(by_day != (time_of_day == "day"))
            obj.data.color = (1, 1, 1)
            if obj.data.type == "POINT":
                obj.data.use_soft_falloff = False
                obj.data.shadow_soft_size = min(obj.data.shadow_soft_size, 0.02)
    for material in bpy.data.materials:
        reflects[material] = 0.3
        if material.node_tree and not glows(material):
            reflectance = luminance(surfaces.reflectance(material.session_uid))
            reflects[material] = float(np.clip(reflectance, 0, 0.85))
    for material, grey in reflects.items():
        shader = _only(material, "ShaderNodeBsdfDiffuse", "ShaderNodeOutputMaterial")
        shader.inputs["Color"].default_value = (grey, grey, grey, 1)
        shader.inputs["Roughness"].default_value = 0.0
        material["grey"] = grey
    background = _only(scene.world, "ShaderNodeBackground", "ShaderNodeOutputWorld")
    background.inputs["Color"].default_value = (1, 1, 1, 1)
    background.inputs["Strength"].default_value = SKY if time_of_day == "day" else 0.0
    layer.update()


def _only(owner: Any, shader: str, output: str) -> Any:
    """Leave a single shader in a material or a world; return its node."""
    nodes = owner.node_tree.nodes
    nodes.clear()
    made = nodes.new(shader)
    owner.node_tree.links.new(made.outputs[0], nodes.new(output).inputs["Surface"])
    return made


def set_reflecting(reflecting: bool) -> None:
    for material in bpy.data.materials:
        grey = material["grey"] if reflecting else 0.0
        for node in material.node_tree.nodes:
            if node.type == "BSDF_DIFFUSE":
                node.inputs["Color"].default_value = (grey, grey, grey, 1)


def faces() -> list[LightRequest]:
    """Return a face at each light sensor that looks down, and one that looks up at table height."""
    found = []
    for obj in sorted(bpy.context.scene.objects, key=lambda o: o.name):
        if obj.angen_sensor.kind == "LIGHT":
            place = np.array(obj.matrix_world.translation, np.float64)
            for way, z, height in (("down", 1.0, place[2]), ("up", -1.0, 1.2)):
                pose = np.diag([1.0, z, z, 1.0])
                pose[:3, 3] = place[0], place[1], height
                name = f"{obj.name.removeprefix('Light sensor ')} {way}"
                found.append(LightRequest(name, pose, "ILLUMINANCE"))
    return found


def rendered(requests: list[LightRequest], samples: int) -> list[float]:
    asked = [replace(request, samples=samples) for request in requests]
    layer = bpy.context.view_layer
    found = probe.measure(bpy.context.scene, layer, asked, efficacy=1.0)
    return [float(found[r.name].illuminance_lux or 0.0) for r in requests]


def exported(folder: Path, reflecting: bool) -> Path:
    """Write the home as a Radiance scene; return its path."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    text, housings = [], Housings()
    for obj in shown_objects(bpy.context.view_layer):
        if obj.type == "MESH" and obj not in housings:
            text.append(_mesh(obj.evaluated_get(depsgraph), reflecting))
    lamps = [obj for obj in shown_objects(bpy.context.view_layer) if obj.type == "LIGHT"]
    for number, obj in enumerate(sorted(lamps, key=lambda obj: obj.name)):
        lamp = obj.evaluated_get(depsgraph)
        power = float(lamp.data.energy * luminance(tint_of(lamp.data)))
        if power > 0.0 and not is_portal(obj):
            text.append(_lamp(lamp, number, power))
    background = bpy.context.scene.world.node_tree.nodes["Background"]
    sky = background.inputs["Strength"].default_value
    if sky > 0.0:
        text.append(f"void glow sky\n0\n0\n4 {sky} {sky} {sky} 0\n")
        text.append("sky source up\n0\n0\n4 0 0 1 180\nsky source down\n0\n0\n4 0 0 -1 180\n")
    scene = folder / "home.rad"
    scene.write_text("".join(text))
    return scene


def compiled(scene: Path) -> Path:
    """Return the octree that `rtrace` needs."""
    octree = scene.with_suffix(".oct")
    octree.write_bytes(_run("oconv", str(scene)))
    return octree


def _lamp(lamp: Any, number: int, power: float) -> str:
    """Return the Radiance text of a lamp of `power` W (of a sun: W/m²), without its shader nodes.

    A sun is a source far away; other lamps are a sphere, or a ring or rectangle that emits to its
    front.
    """
    data, matrix = lamp.data, np.array(lamp.matrix_world, np.float64)
    place, axis = matrix[:3, 3], -matrix[:3, 2] / np.linalg.norm(matrix[:3, 2])
    if data.type == "SUN":
        half = max(math.degrees(data.angle), 0.01)
        solid = 2 * math.pi * (1 - math.cos(math.radians(half) / 2))
        text = f"void light s{number}\n0\n0\n3" + f" {power / solid:.9g}" * 3 + "\n"
        return f"{text}s{number} source s{number}o\n0\n0\n4 {_numbers(*-axis, half)}\n"
    if data.type == "POINT":
        area = 4 * math.pi * data.shadow_soft_size**2
        shape, numbers = "sphere", [*place, data.shadow_soft_size]
    elif data.type == "AREA":
        sizes = data.size, data.size_y if data.shape in {"RECTANGLE", "ELLIPSE"} else data.size
        x, y = (matrix[:3, i] * sizes[i] for i in (0, 1))
        area = float(np.linalg.norm(np.cross(x, y)))
        if data.shape in {"DISK", "ELLIPSE"}:
            area *= math.pi / 4
            shape, numbers = "ring", [*place, *axis, 0.0, float(np.linalg.norm(x)) / 2]
        else:
            shape, signs = "polygon", ((1, 1), (1, -1), (-1, -1), (-1, 1))
            numbers = np.ravel([place + (a * x + b * y) / 2 for a, b in signs]).tolist()
    else:
        raise ValueError(f"'{lamp.name}': a lamp of type {data.type} cannot be carried over")
    text = f"void light l{number}\n0\n0\n3" + f" {power / (math.pi * area):.9g}" * 3 + "\n"
    return f"{text}l{number} {shape} l{number}o\n0\n0\n{len(numbers)} {_numbers(*numbers)}\n"


def _numbers(*numbers: float) -> str:
    return " ".join(f"{c:.9g}" for c in numbers)


def _mesh(evaluated: Any, reflecting: bool) -> str:
    mesh = evaluated.data
    mesh.calc_loop_triangles()
    matrix = np.array(evaluated.matrix_world, np.float64)
    points = np.array([v.co for v in mesh.vertices], np.float64).reshape(-1, 3)
    points = points @ matrix[:3, :3].T + matrix[:3, 3]
    greys, text = {}, []
    for triangle in mesh.loop_triangles:
        slot = evaluated.material_slots[triangle.material_index].material
        grey = (slot.original["grey"] if slot else 0.8) if reflecting else 0.0
        a, b, c = corners = points[list(triangle.vertices)]
        if np.linalg.norm(np.cross(b - a, c - a)) >= 1e-10:
            name = f"g{round(grey * 1e6)}"
            greys[name] = f"void plastic {name}\n0\n0\n5 {grey} {grey} {grey} 0 0\n"
            text.append(f"{name} polygon p\n0\n0\n9 {_numbers(*corners.ravel())}\n")
    return "".join([*greys.values(), *text])


def traced(octree: Path, requests: list[LightRequest], bounces: int, divisions: int) -> list[float]:
    """Return the irradiances at the faces in W/m², by `rtrace`."""
    lines = ""
    for request in requests:
        normal = -request.matrix[:3, 2]
        size = face_size(bpy.context.scene, request.matrix)
        lines += _numbers(*(request.matrix[:3, 3] + normal * size), *normal) + "\n"
    options = [*QUALITY, "-ab", str(bounces), "-ad", str(divisions), str(octree)]
    answer = _run("rtrace", "-I+", "-h", "-n", "2", *options, given=lines).decode()
    return [float(line.split()[0]) for line in answer.splitlines() if line.strip()]


def _run(program: str, *arguments: str, given: str = "") -> bytes:
    import pyradiance

    path = Path(pyradiance.__file__).parent / "bin" / program
    command = [str(path), *arguments]
    return subprocess.run(command, input=given.encode(), capture_output=True, check=True).stdout
