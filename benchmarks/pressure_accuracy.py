# SPDX-License-Identifier: GPL-3.0-or-later
"""Error of the pressure pads against closed forms, and against MuJoCo where it has the scene.

Resting: statics (of an elastic foundation where it takes one). Falling: the momentum theorem. A
row tells the worst valid frame of the second half of its scene, in which things are at rest.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
from mathutils import Quaternion, Vector

from .pressure_rows import G, Row, at_rest, row, total, validity
from .pressure_scenes import (
    box,
    carried,
    compound,
    floor,
    follow,
    new_scene,
    pad,
    solid,
)
from .pressure_table import legs_exactly
from .progress import progress

PAD = 0.01
PILES = 100


def measure(quick: bool) -> list[Row]:
    cases = QUICK if quick else CASES
    rows = []
    for done, case in enumerate(cases):
        progress("pressure", done, len(cases), case.__name__)
        rows += case()
    return rows


def resting() -> Iterator[Row]:
    scene = ground()
    box("box", (0.1, 0.1, 0.1), (0, 0, PAD + 0.1), 5.0)
    yield row("rest", "box of 5 kg", follow(scene), {"pad": 5 * G}, mujoco=True)


def stacks() -> Iterator[Row]:
    scene = ground()
    for i, mass in enumerate((4.0, 2.0, 1.0)):
        box(f"box {i}", (0.1, 0.1, 0.05), (0.005 * i, 0, PAD + 0.05 + 0.1 * i), mass)
    yield row("rest", "stack of 4, 2 and 1 kg", follow(scene), {"pad": 7 * G}, mujoco=True)
    scene = ground()
    for x, mass in ((-0.1, 3.0), (0.08, 1.0)):
        box(f"box {mass}", (0.05, 0.05, 0.05), (x, 0, PAD + 0.05), mass)
    yield row(
        "rest", "two boxes side by side, 3 and 1 kg", follow(scene), {"pad": 4 * G}, None, True
    )


def ground(fps: int = 24, last: int = 48, half: float = 0.15, **settings: Any) -> Any:
    """A floor with one pad on it."""
    scene = new_scene(fps, last)
    floor(**settings)
    pad("pad", (half, half, PAD / 2), (0, 0, PAD / 2), **settings)
    return scene


LEGS = [(-0.5, -0.3), (0.5, -0.3), (-0.5, 0.3), (0.5, 0.3)]


def table(at: tuple[float, float]) -> Row:
    """20 kg on four legs, 10 kg on it."""
    leg, high, top = 0.025, 0.35, 0.025
    parts = [((0.6, 0.4, top), (0.0, 0.0, 0.0))]
    parts += [((leg, leg, high), (x, y, -top - high)) for x, y in LEGS]
    scene = new_scene()
    floor()
    names = [f"pad {i}" for i in range(len(LEGS))]
    for name, (x, y) in zip(names, LEGS, strict=True):
        pad(name, (0.05, 0.05, PAD / 2), (x, y, PAD / 2))
    height = PAD + 2 * high + top
    compound("table", parts, (0, 0, height), 20.0)
    box("load", (0.05, 0.05, 0.05), (*at, height + top + 0.05), 10.0)
    exact = legs_exactly(np.array(LEGS), leg, [(20 * G, (0, 0)), (10 * G, at)])
    name = f"table of 20 kg, 10 kg at ({at[0]:g}, {at[1]:g}) m"
    return row(
        "four legs", name, follow(scene), dict(zip(names, exact.tolist(), strict=True)), None, True
    )


def tables() -> Iterator[Row]:
    for at in ((0.0, 0.0), (0.25, 0.15), (0.4, 0.25)):
        yield table(at)


def one_table() -> Iterator[Row]:
    yield table((0.25, 0.15))


SEAT = [(-0.2, -0.2), (0.2, -0.2), (-0.2, 0.2), (0.2, 0.2)]


def sitters() -> Iterator[Row]:
    """70 kg, animated, on a chair of 6 kg that is simulated; also sunk in, or floating a bit."""
    leg, high, top = 0.02, 0.21, 0.02
    parts = [((0.22, 0.22, top), (0.0, 0.0, 0.0))]
    parts += [((leg, leg, high), (x, y, -top - high)) for x, y in SEAT]
    for (x, y), sink, say in (
        ((0.0, 0.0), 0.0, "in the middle"),
        ((0.05, 0.03), 0.0, "5 and 3 cm aside"),
        ((0.05, 0.03), 0.05, "aside, sunk 5 cm into the seat"),
        ((0.05, 0.03), -0.02, "aside, 2 cm above the seat"),
    ):
        scene = new_scene(last=24)
        floor()
        names = [f"pad {i}" for i in range(len(SEAT))]
        for name, at in zip(names, SEAT, strict=True):
            pad(name, (0.04, 0.04, PAD / 2), (*at, PAD / 2))
        height = PAD + 2 * high + top
        compound("chair", parts, (0, 0, height), 6.0)
        carried("sitter", (0.15, 0.15, 0.2), (x, y, height + top + 0.2 - sink), 70.0)
        exact = legs_exactly(np.array(SEAT), leg, [(6 * G, (0, 0)), (70 * G, (x, y))])
        followed = follow(scene)
        shares = dict(zip(names, exact.tolist(), strict=True))
        engine = sink == 0.0
        yield row("sitter", f"70 kg on a chair, {say}", followed, shares, None, engine)
        yield total(f"70 kg on a chair, {say}: sum of the legs", followed, 76 * G)


def drop(height: float, bounce: float, fps: int) -> Row:
    """2 kg, from rest to rest: the impulse is the weight's over the whole time. A reading stands
    for the time half a frame about it; the first of them, at the release, is not known."""
    mass, seconds = 2.0, 4.0
    scene = ground(fps, int(seconds * fps), restitution=bounce)
    box("box", (0.1,) * 3, (0, 0, PAD + 0.1 + height), mass, restitution=bounce, linear_damping=0.0)
    followed = follow(scene)
    force = followed.tracks["pad"].force[1:]
    impulse, exact = sum(force) / fps, mass * G * (len(force) + 0.5) / fps
    return {
        "group": "drop",
        "scene": f"2 kg from {height:g} m, e = {bounce:g}, {fps} fps",
        "exact": [exact],
        "measured": [impulse],
        "unit": "N·s",
        "error": abs(impulse / exact - 1.0),
        "peak": max(force),
        "mujoco": None,
        **validity(followed),
    }


def drops() -> Iterator[Row]:
    for height in (0.1, 0.5, 2.0):
        for bounce in (0.0, 0.5):
            for fps in (24, 60):
                yield drop(height, bounce, fps)


def one_drop() -> Iterator[Row]:
    yield drop(0.5, 0.0, 24)


def slopes() -> Iterator[Row]:
    """Things that slide and roll down a pad: m·g·cos of its angle."""

    def sloped(angle: float, friction: float) -> tuple[Any, Quaternion, Callable[[float], Vector]]:
        turn = Quaternion((0, 1, 0), math.radians(angle))
        scene = new_scene(last=30)
        pad("pad", (2.0, 0.5, PAD / 2), (0, 0, 0), rotation=turn, friction=friction)
        return scene, turn, lambda high: turn @ Vector((-1.5, 0.0, PAD / 2 + high))

    scene, turn, at = sloped(20.0, 0.3)
    box("box", (0.1,) * 3, at(0.1), 5.0, rotation=turn, friction=1.0)
    exact = {"pad": 5 * G * math.cos(math.radians(20.0))}
    yield row("moving", "box sliding down 20°, μ = 0.3", follow(scene), exact)
    scene, turn, at = sloped(5.0, 0.5)
    solid("ball", "SPHERE", 0.1, at(0.1), 5.0, friction=1.0)
    exact = {"pad": 5 * G * math.cos(math.radians(5.0))}
    yield row("moving", "sphere rolling down 5°", follow(scene), exact)
    scene, turn, at = sloped(5.0, 0.5)
    lying = turn @ Quaternion((1, 0, 0), math.pi / 2)
    solid("roll", "CAPSULE", 0.2, at(0.1), 5.0, rotation=lying, friction=1.0)
    yield row("moving", "capsule rolling down 5°", follow(scene), exact)


def lift() -> Iterator[Row]:
    """A pad that is moved up and down 0.1 m once a second with a box on it: m(g + a)."""
    for fps in (24, 60):
        scene = new_scene(fps, 2 * fps)
        high = {frame: 0.1 * math.sin(2 * math.pi * frame / fps) for frame in range(2 * fps + 2)}
        lifted = pad("pad", (0.15, 0.15, PAD / 2), (0, 0, PAD / 2 + high[1]))
        lifted.rigid_body.kinematic = True
        for frame, z in high.items():
            lifted.location.z = z + PAD / 2
            lifted.keyframe_insert("location", frame=frame)
        box("box", (0.1,) * 3, (0, 0, PAD + 0.1 + high[1]), 5.0)
        followed = follow(scene)
        track = followed.tracks["pad"]
        exact = [5 * (G - (2 * math.pi) ** 2 * high[1 + i]) for i in range(len(track.force))]
        late = slice(fps // 2, None)
        off = np.array(track.force[late]) - np.array(exact[late])
        rms = float(np.sqrt(np.mean(off**2)))
        yield {
            "group": "moving",
            "scene": f"pad lifting 5 kg by ±0.1 m at 1 Hz, {fps} fps, rms",
            "exact": [5 * G],
            "measured": [5 * G + rms],
            "unit": "N",
            "error": rms / (5 * G),
            "error_newtons": rms,
            "mujoco": None,
            **validity(followed),
        }


def shapes() -> Iterator[Row]:
    for shape in ("SPHERE", "CAPSULE", "CYLINDER", "CONE", "CONVEX_HULL", "MESH"):
        scene = ground(last=60)
        margin = 0.04 if shape in {"CONE", "MESH"} else 0.0
        solid("body", shape, 0.1, (0, 0, PAD + 0.1 + margin), 5.0)
        name = shape.lower().replace("_", " ")
        yield row("shapes", f"{name} of 5 kg", follow(scene), {"pad": 5 * G}, None, True)


def scales() -> Iterator[Row]:
    for mass, half in ((0.001, 0.01), (500.0, 0.4)):
        scene = ground(half=max(0.05, 1.5 * half))
        box("box", (half,) * 3, (0, 0, PAD + half), mass)
        yield row(
            "extremes", f"box of {mass:g} kg", follow(scene), {"pad": mass * G}, None, mass > 1
        )
    scene = ground()
    for i, mass in enumerate((1000.0, 1.0)):
        box(f"box {i}", (0.1,) * 3, (0, 0, PAD + 0.1 + 0.2 * i), mass)
    yield row("extremes", "1 kg on 1000 kg", follow(scene), {"pad": 1001 * G}, None, True)
    far = Vector((2000.0, 0.0, 0.0))
    scene = new_scene()
    floor(far + Vector((0, 0, -0.5)))
    pad("pad", (0.15, 0.15, PAD / 2), far + Vector((0, 0, PAD / 2)))
    for i in range(2):
        box(f"box {i}", (0.1,) * 3, far + Vector((0, 0, PAD + 0.1 + 0.2 * i)), 5.0)
    yield row("extremes", "two boxes 2 km from the origin", follow(scene), {"pad": 10 * G})
    for thin in (4.5e-4, 1e-4):
        scene = new_scene()
        floor()
        pad("pad", (0.15, 0.15, thin / 2), (0, 0, thin / 2))
        box("box", (0.1,) * 3, (0, 0, thin + 0.1), 5.0)
        say = f"pad {thin * 1e3:g} mm thin"
        yield row("extremes", say, follow(scene), {"pad": 5 * G}, None, True)
    scene = new_scene()
    floor()
    pad("pad", (0.15, 0.15, PAD / 2), (0, 0, PAD / 2), physics=False)
    box("box", (0.1,) * 3, (0, 0, 0.1), 5.0)
    yield row("extremes", "virtual pad that the box goes through", follow(scene), {"pad": 5 * G})


def piles(count: int = PILES) -> Iterator[Row]:
    """Bodies dropped at random on a pad that is all of the floor; judged where all rest."""
    worst, judged, rested, invalid, updates, weight = 0.0, 0, 0, 0, 0, 0.0
    problems: set[str] = set()
    residual = 0.0
    for seed in range(count):
        scene, bodies = _pile(random.Random(seed))
        followed = follow(scene, bodies)
        found = validity(followed)
        invalid += found["updates"] - found["valid"]
        updates += found["updates"]
        problems |= set(found["problems"])
        residual = max(residual, found["residual"])
        weight = sum(body.rigid_body.mass for body in bodies) * G
        still = at_rest(followed, 1.0 / scene.render.fps)
        tracks = list(followed.tracks.values())
        before = judged
        for index in np.flatnonzero(still).tolist():
            if all(track.valid[index] for track in tracks):
                force = sum(track.force[index] for track in tracks)
                worst = max(worst, abs(force / weight - 1.0))
                judged += 1
        rested += judged > before
    yield {
        "group": "piles",
        "scene": f"{count} random piles of 6 bodies ({rested} came to rest: {judged} frames)",
        "exact": [1.0],
        "measured": [1.0 + worst],
        "unit": "of the weight",
        "error": worst,
        "mujoco": None,
        "valid": updates - invalid,
        "updates": updates,
        "problems": sorted(problems),
        "residual": residual,
    }


def _pile(chance: random.Random) -> tuple[Any, list[Any]]:
    scene = new_scene(last=96)
    pad("pad", (4.0, 4.0, 0.05), (0, 0, -0.05))
    bodies = []
    for i in range(6):
        shape, form = chance.choice(
            (("BOX", "BOX"), ("CYLINDER", "CYLINDER"), ("CONVEX_HULL", "ICOSAHEDRON"))
        )
        mass = 10.0 ** chance.uniform(-1.0, 1.3)
        turn = Quaternion([chance.gauss(0.0, 1.0) for _ in range(4)]).normalized()
        at = (chance.uniform(-0.2, 0.2), chance.uniform(-0.2, 0.2), 0.25 + 0.3 * i)
        radius = chance.uniform(0.05, 0.12)
        body = solid(f"body {i}", shape, radius, at, mass, rotation=turn, form=form)
        # What rolls comes to rest before long.
        body.rigid_body.angular_damping, body.rigid_body.linear_damping = 0.9, 0.3
        bodies.append(body)
    return scene, bodies


QUICK: Sequence[Callable[[], Iterator[Row]]] = (resting, one_table, one_drop)
CASES: Sequence[Callable[[], Iterator[Row]]] = (
    resting,
    stacks,
    tables,
    sitters,
    drops,
    slopes,
    lift,
    shapes,
    scales,
    piles,
)
