# SPDX-License-Identifier: GPL-3.0-or-later
"""Measure the pressure sensor's error and cost, and the figure of the sample's table.

The error is that against closed forms, and against MuJoCo where it has the scene: statics for
resting bodies (of an elastic foundation where the supports are many), the momentum theorem for
falling ones. A row has the worst valid frame in the second half of its scene, when bodies rest.
"""

from __future__ import annotations

import math
import random
import statistics
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import bpy
import numpy as np
from angen_sensors.sensor_logic.kinds.pressure import ForceResistor, PressureParameters
from angen_sensors.sensor_logic.model import NOT_YET
from mathutils import Quaternion, Vector

from .common import SAMPLES, has, open_home, progress, rms
from .pressure_scenes import (
    Followed,
    box,
    carried,
    compound,
    floor,
    follow,
    mujoco_forces,
    new_world,
    pad,
    solid,
)

Row = dict[str, Any]
G = 9.81
PAD = 0.01
# Worked out by hand: a divider with 10 kΩ at 5 V and 10 bits, from the data sheet's curve.
BY_HAND = {0.2: 260, 1.0: 642, 5.0: 854, 10.0: 910, 20.0: 952}
FORCES = (0.0, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 200.0)
LEGS = ("front left", "front right", "back left", "back right")
PILES = 100


def measure(quick: bool) -> dict[str, Any]:
    cases, accuracy = QUICK if quick else CASES, []
    for done, case in enumerate(cases):
        progress("pressure", done, len(cases), case.__name__)
        accuracy += case()
    frames, islands, crowds = 36, (1, 2, 5, 10, 20, 50), (0, 10, 100, 1000)
    if quick:
        frames, islands, crowds = 12, (10,), (0, 100)
    return {
        "mujoco": has("mujoco"),
        "accuracy": accuracy,
        "resistor": [_resistor(force) for force in FORCES],
        "table": sample_table(),
        "speed": {
            "frames": frames,
            "island": [_cost(bodies, 0, frames) for bodies in islands],
            "scene": [_cost(1, crowd, frames) for crowd in crowds],
        },
    }


def _resistor(force: float) -> Row:
    """Return the row of the resistor with its default parameters, fresh, at a force."""
    felt = ForceResistor().update(PressureParameters(), force, 0.0, 0.0)
    told = {name: getattr(felt, name) for name in ("resistance_ohm", "voltage_v", "adc")}
    return {"force_n": force, **told, "by_hand": BY_HAND.get(force)}


def row(
    group: str, scene: str, followed: Followed, exact: Mapping[str, float], **other: Any
) -> Row:
    """Return the errors of pads whose exact forces (N) are known, and of MuJoCo if `mujoco`."""
    found, worst = [], []
    for name, force in exact.items():
        track = followed.tracks[name]
        half = len(track.force) // 2
        pairs = zip(track.force[half:], track.valid[half:], strict=True)
        late = [force for force, valid in pairs if valid]
        found.append(float(np.mean(late)) if late else math.nan)
        worst.append(max((abs(f - force) for f in late), default=math.nan))
    engine = mujoco_forces() if other.pop("mujoco", False) else None
    against = None
    if engine is not None:
        pairs = zip(exact.items(), found, strict=True)
        against = max(abs(value - engine[name]) / force for (name, force), value in pairs)
    error = max(newtons / force for newtons, force in zip(worst, exact.values(), strict=True))
    return _row(group, scene, [*exact.values()], found, error, followed, mujoco=against) | {
        "error_newtons": max(worst)
    }


def _row(
    group: str, scene: str, exact: Any, measured: Any, error: float, *runs: Followed, **other: Any
) -> Row:
    """Return a row with the numbers of valid and of all updates.

    The first update of a run has no frame before it, and is never valid.
    """
    tracks = [track for followed in runs for track in followed.tracks.values()]
    residuals = [zip(track.residual, track.valid, strict=True) for track in tracks]
    return {
        "group": group, "scene": scene, "exact": exact, "measured": measured, "unit": "N",
        "error": error, "mujoco": None, **other,
        "valid": sum(sum(track.valid) for track in tracks),
        "updates": sum(len(track.valid) - 1 for track in tracks),
        "problems": sorted(set().union(*(track.problems for track in tracks)) - {NOT_YET}),
        "residual": max((r for pairs in residuals for r, valid in pairs if valid), default=0.0),
    }  # fmt: skip


def ground(fps: int = 24, last: int = 48, half: float = 0.15, **settings: Any) -> Any:
    """Add a floor with one pad on it."""
    scene = new_world(fps, last)
    floor(**settings)
    pad("pad", (half, half, PAD / 2), (0, 0, PAD / 2), **settings)
    return scene


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
    name = "two boxes side by side, 3 and 1 kg"
    yield row("rest", name, follow(scene), {"pad": 4 * G}, mujoco=True)


def _on_legs(
    name: str, places: Any, leg: float, high: float, top: Any, half: float, mass: float
) -> tuple[list[str], float]:
    """Add a floor and a plate on square legs, each of which stands on a pad.

    `top` are the half sizes of the plate. Returns the names of the pads, and the height of the
    plate's upper side.
    """
    floor()
    names = [f"pad {i}" for i in range(len(places))]
    for pad_name, at in zip(names, places, strict=True):
        pad(pad_name, (half, half, PAD / 2), (*at, PAD / 2))
    parts = [(top, (0.0, 0.0, 0.0))]
    parts += [((leg, leg, high), (x, y, -top[2] - high)) for x, y in places]
    height = PAD + 2 * high + top[2]
    compound(name, parts, (0, 0, height), mass)
    return names, height + top[2]


def tables(
    places: Any = ((0.0, 0.0), (0.25, 0.15), (0.4, 0.25)),
) -> Iterator[Row]:
    """Yield tables of 20 kg on four legs, with 10 kg at several places."""
    legs, leg = [(-0.5, -0.3), (0.5, -0.3), (-0.5, 0.3), (0.5, 0.3)], 0.025
    for at in places:
        scene = new_world()
        names, upper = _on_legs("table", legs, leg, 0.35, (0.6, 0.4, 0.025), 0.05, 20.0)
        box("load", (0.05, 0.05, 0.05), (*at, upper + 0.05), 10.0)
        exact = legs_exactly(np.array(legs), leg, [(20 * G, (0, 0)), (10 * G, at)])
        name = f"table of 20 kg, 10 kg at ({at[0]:g}, {at[1]:g}) m"
        shares = dict(zip(names, exact.tolist(), strict=True))
        yield row("four legs", name, follow(scene), shares, mujoco=True)


def one_table() -> Iterator[Row]:
    return tables(((0.25, 0.15),))


def sitters() -> Iterator[Row]:
    """Yield an animated person of 70 kg on a simulated chair of 6 kg; also sunk in or floating."""
    legs, leg = [(-0.2, -0.2), (0.2, -0.2), (-0.2, 0.2), (0.2, 0.2)], 0.02
    for (x, y), sink, say in (
        ((0.0, 0.0), 0.0, "in the middle"),
        ((0.05, 0.03), 0.0, "5 and 3 cm aside"),
        ((0.05, 0.03), 0.05, "aside, sunk 5 cm into the seat"),
        ((0.05, 0.03), -0.02, "aside, 2 cm above the seat"),
    ):
        scene = new_world(last=24)
        names, upper = _on_legs("chair", legs, leg, 0.21, (0.22, 0.22, 0.02), 0.04, 6.0)
        carried("sitter", (0.15, 0.15, 0.2), (x, y, upper + 0.2 - sink), 70.0)
        exact = legs_exactly(np.array(legs), leg, [(6 * G, (0, 0)), (70 * G, (x, y))])
        followed, name = follow(scene), f"70 kg on a chair, {say}"
        shares = dict(zip(names, exact.tolist(), strict=True))
        yield row("sitter", name, followed, shares, mujoco=sink == 0.0)
        tracks = followed.tracks.values()
        sums = np.sum([track.force[len(track.force) // 2 :] for track in tracks], axis=0)
        worst, name = float(np.abs(sums - 76 * G).max()), f"{name}: sum of the legs"
        found = [float(sums.mean())]
        yield _row("sitter", name, [76 * G], found, worst / (76 * G), followed) | {
            "error_newtons": worst
        }


def drop(height: float, bounce: float, fps: int) -> Row:
    """Return the row of 2 kg that fall and come to rest: the impulse is weight times time.

    A reading stands for the time of half a frame before and after it. The first, at the release, is
    not known.
    """
    mass, seconds = 2.0, 4.0
    scene = ground(fps, int(seconds * fps), restitution=bounce)
    box("box", (0.1,) * 3, (0, 0, PAD + 0.1 + height), mass, restitution=bounce, linear_damping=0.0)
    followed = follow(scene)
    force = followed.tracks["pad"].force[1:]
    impulse, exact = sum(force) / fps, mass * G * (len(force) + 0.5) / fps
    name = f"2 kg from {height:g} m, e = {bounce:g}, {fps} fps"
    told = _row("drop", name, [exact], [impulse], abs(impulse / exact - 1.0), followed)
    return told | {"unit": "N·s", "peak": max(force)}


def drops() -> Iterator[Row]:
    for height in (0.1, 0.5, 2.0):
        for bounce in (0.0, 0.5):
            for fps in (24, 60):
                yield drop(height, bounce, fps)


def one_drop() -> Iterator[Row]:
    yield drop(0.5, 0.0, 24)


def slopes() -> Iterator[Row]:
    """Yield bodies that slide and roll down a pad: m·g·cos of the pad's angle."""
    lying = Quaternion((1, 0, 0), math.pi / 2)
    for name, shape, radius, degrees, friction in (
        ("box sliding down 20°, μ = 0.3", "BOX", 0.1, 20.0, 0.3),
        ("sphere rolling down 5°", "SPHERE", 0.1, 5.0, 0.5),
        ("capsule rolling down 5°", "CAPSULE", 0.2, 5.0, 0.5),
    ):
        turn = Quaternion((0, 1, 0), math.radians(degrees))
        scene = new_world(last=30)
        pad("pad", (2.0, 0.5, PAD / 2), (0, 0, 0), rotation=turn, friction=friction)
        at = turn @ Vector((-1.5, 0.0, PAD / 2 + 0.1))
        rotation = {"BOX": turn, "CAPSULE": turn @ lying}.get(shape)
        solid("body", shape, radius, at, 5.0, rotation=rotation, friction=1.0)
        exact = {"pad": 5 * G * math.cos(math.radians(degrees))}
        yield row("moving", name, follow(scene), exact)


def lift() -> Iterator[Row]:
    """Yield a box on a pad that moves up and down 0.1 m once a second: m(g + a)."""
    for fps in (24, 60):
        scene = new_world(fps, 2 * fps)
        high = {frame: 0.1 * math.sin(2 * math.pi * frame / fps) for frame in range(2 * fps + 2)}
        lifted = pad("pad", (0.15, 0.15, PAD / 2), (0, 0, PAD / 2 + high[1]))
        lifted.rigid_body.kinematic = True
        for frame, z in high.items():
            lifted.location.z = z + PAD / 2
            lifted.keyframe_insert("location", frame=frame)
        box("box", (0.1,) * 3, (0, 0, PAD + 0.1 + high[1]), 5.0)
        followed = follow(scene)
        force = followed.tracks["pad"].force
        exact = [5 * (G - (2 * math.pi) ** 2 * high[1 + i]) for i in range(len(force))]
        off = rms((np.array(force) - np.array(exact))[fps // 2 :])
        name = f"pad lifting 5 kg by ±0.1 m at 1 Hz, {fps} fps, rms"
        told = _row("moving", name, [5 * G], [5 * G + off], off / (5 * G), followed)
        yield told | {"error_newtons": off}


def shapes() -> Iterator[Row]:
    for shape in ("SPHERE", "CAPSULE", "CYLINDER", "CONE", "CONVEX_HULL", "MESH"):
        scene = ground(last=60)
        margin = 0.04 if shape in {"CONE", "MESH"} else 0.0
        solid("body", shape, 0.1, (0, 0, PAD + 0.1 + margin), 5.0)
        name = f"{shape.lower().replace('_', ' ')} of 5 kg"
        yield row("shapes", name, follow(scene), {"pad": 5 * G}, mujoco=True)


def scales() -> Iterator[Row]:
    for mass, half in ((0.001, 0.01), (500.0, 0.4)):
        scene = ground(half=max(0.05, 1.5 * half))
        box("box", (half,) * 3, (0, 0, PAD + half), mass)
        exact = {"pad": mass * G}
        yield row("extremes", f"box of {mass:g} kg", follow(scene), exact, mujoco=mass > 1)
    scene = ground()
    for i, mass in enumerate((1000.0, 1.0)):
        box(f"box {i}", (0.1,) * 3, (0, 0, PAD + 0.1 + 0.2 * i), mass)
    yield row("extremes", "1 kg on 1000 kg", follow(scene), {"pad": 1001 * G}, mujoco=True)
    far = Vector((2000.0, 0.0, 0.0))
    scene = new_world()
    floor(far + Vector((0, 0, -0.5)))
    pad("pad", (0.15, 0.15, PAD / 2), far + Vector((0, 0, PAD / 2)))
    for i in range(2):
        box(f"box {i}", (0.1,) * 3, far + Vector((0, 0, PAD + 0.1 + 0.2 * i)), 5.0)
    yield row("extremes", "two boxes 2 km from the origin", follow(scene), {"pad": 10 * G})
    for thin, name in (
        (4.5e-4, "pad 0.45 mm thin"),
        (1e-4, "pad 0.1 mm thin"),
        (PAD, "virtual pad that the box goes through"),
    ):
        is_virtual = thin == PAD
        scene = new_world()
        floor()
        pad("pad", (0.15, 0.15, thin / 2), (0, 0, thin / 2), physics=not is_virtual)
        box("box", (0.1,) * 3, (0, 0, 0.1 if is_virtual else thin + 0.1), 5.0)
        yield row("extremes", name, follow(scene), {"pad": 5 * G}, mujoco=not is_virtual)


def piles(count: int = PILES) -> Iterator[Row]:
    """Yield bodies dropped at random on a pad as large as the floor, judged once all rest."""
    worst, judged, rested, runs = 0.0, 0, 0, []
    for seed in range(count):
        scene, bodies = _pile(random.Random(seed))
        followed = follow(scene, bodies)
        runs.append(followed)
        weight = sum(body.rigid_body.mass for body in bodies) * G
        track, before = followed.tracks["pad"], judged
        for index in np.flatnonzero(at_rest(followed, 1.0 / scene.render.fps)).tolist():
            if track.valid[index]:
                worst = max(worst, abs(track.force[index] / weight - 1.0))
                judged += 1
        rested += judged > before
    name = f"{count} random piles of 6 bodies ({rested} came to rest: {judged} frames)"
    yield _row("piles", name, [1.0], [1.0 + worst], worst, *runs) | {"unit": "of the weight"}


def _pile(chance: random.Random) -> tuple[Any, list[Any]]:
    scene = new_world(last=96)
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
        # Bodies that roll come to rest before long.
        body.rigid_body.angular_damping, body.rigid_body.linear_damping = 0.9, 0.3
        bodies.append(body)
    return scene, bodies


def at_rest(followed: Followed, dt: float) -> Any:
    """Return the mask of frames around which every body, with its rim, is slower than 10 mm/s."""
    count = min(len(track.force) for track in followed.tracks.values())
    still = np.ones(count, bool)
    still[0] = False
    for poses in followed.poses.values():
        points = poses[:, :3, :] @ np.array(
            [[0, 0.1, 0, 0], [0, 0, 0.1, 0], [0, 0, 0, 0.1], [1] * 4]
        )
        speed = np.linalg.norm(np.diff(points, axis=0), axis=1).max(axis=1) / dt
        slow = speed < 0.01
        still[1:] &= slow[: count - 1] & slow[1:count]
    return still


QUICK = (resting, one_table, one_drop)
CASES: tuple[Callable[[], Iterator[Row]], ...] = (
    *(resting, stacks, tables, sitters, drops, slopes, lift, shapes, scales, piles),
)


def _cost(bodies: int, elsewhere: int, frames: int) -> Row:
    """Return what sensing costs for a wall of boxes on one pad, and boxes far from it.

    Blender's own simulation is not timed. The error is that of the same frames. The first second,
    in which shapes are read once, is left out.
    """
    half, width = (0.1, 0.06, 0.04), 5
    scene = new_world(last=frames + 6)
    floor(half=(20, 20, 0.5))
    pad("pad", (0.7, 0.1, PAD / 2), (0, 0, PAD / 2))
    for i in range(bodies):
        level, place = divmod(i, width)
        # Shifted from level to level, so that the columns lean on each other.
        aside = (place - (width - 1) / 2) * 0.21 + 0.03 * (level % 2)
        if bodies < width:
            level, aside = i, 0.0
        box(f"box {i}", half, (aside, 0, PAD + half[2] * (2 * level + 1)), 1.0)
    for i in range(elsewhere):
        x, y = divmod(i, 32)
        box(f"other {i}", (0.1,) * 3, (2.0 + 0.4 * x, 0.4 * (y - 16), 0.1), 1.0)
    followed = follow(scene)
    track = followed.tracks["pad"]
    times = sorted(followed.seconds[7:])
    pairs = zip(track.force[6:], track.valid[6:], strict=True)
    return {
        "bodies": bodies, "elsewhere": elsewhere, "ms": statistics.median(times) * 1e3,
        "ms_worst": times[-1] * 1e3, "start_ms": followed.seconds[0] * 1e3,
        "error": max(abs(force / (bodies * G) - 1.0) for force, valid in pairs if valid),
        "valid": sum(track.valid), "updates": len(track.valid) - 1,
    }  # fmt: skip


def sample_table() -> dict[str, Any]:
    """Return the forces on the legs of the sample's table as the weight moves over it.

    Times are in seconds, the forces of each leg in newtons, measured and exact.
    """
    scene, objects = open_home(SAMPLES / "pressure.blend"), bpy.data.objects
    watched = [objects[name] for name in ("Table", "Weight", *(f"Leg {leg}" for leg in LEGS))]
    followed = follow(scene, watched)
    poses = {name: pose[:, :3, 3] for name, pose in followed.poses.items()}
    half = objects[f"Leg {LEGS[0]}"].dimensions.x / 2.0
    masses = objects["Table"].rigid_body.mass, objects["Weight"].angen_load.mass
    frames = scene.frame_end - scene.frame_start + 1
    exact = np.array([
        legs_exactly(
            np.array([poses[f"Leg {leg}"][i] for leg in LEGS]),
            half,
            ((masses[0] * G, poses["Table"][i]), (masses[1] * G, poses["Weight"][i])),
        )
        for i in range(frames)
    ])  # fmt: skip
    tracks = {leg: followed.tracks[f"Pad {leg}"] for leg in LEGS}
    measured = np.array([track.force for track in tracks.values()]).T
    known = np.array([track.valid for track in tracks.values()]).all(axis=0)
    off = np.abs(measured - exact)[known]
    return {
        "fps": scene.render.fps, "table_kg": masses[0], "weight_kg": masses[1],
        "worst_newtons": float(off.max()), "worst_share": float((off / exact[known]).max()),
        "valid": int(known.sum()),
        "time_s": [round(i / scene.render.fps, 4) for i in range(frames)],
        "measured": dict(zip(LEGS, np.round(measured.T, 4).tolist(), strict=True)),
        "exact": dict(zip(LEGS, np.round(exact.T, 4).tolist(), strict=True)),
        "known": known.astype(int).tolist(),
    }  # fmt: skip


def legs_exactly(places: Any, half: float, loads: Any) -> Any:
    """Return the forces (n,) in N on square legs of an elastic foundation.

    Parameters
    ----------
    places
        Centres of the legs, shape (n, 2) or (n, 3), m.
    half
        Half width of a leg, m.
    loads
        Pairs of newtons and place that the stiff body on the legs carries.
    """
    rows = np.column_stack([np.ones(len(places)), places[:, :2]])
    inner = len(places) * half**2 / 3.0
    moments = rows.T @ rows + np.diag([0.0, inner, inner])
    push = np.sum([newtons * np.array([1.0, *at[:2]]) for newtons, at in loads], axis=0)
    return rows @ np.linalg.solve(moments, push)
