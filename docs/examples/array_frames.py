# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames of an infrared array on a ceiling, with a person who stands, sits or lies, as a table:

    python docs/examples/array_frames.py FRAMES.csv [--people 40] [--preset D6T_1616L]
        [--height 2.2] [--room 19 20] [--places 8] [--seed 1]

Needs the package (`pip install .`). Each person has a size, clothes and a room of their own, and
takes each posture at several places. `postures.py` learns from the table. A row is a frame:
posture, person, columns of the frame, and its temperatures, row by row with semicolons.
"""

from __future__ import annotations

import argparse
import csv
import math
import sys
import tempfile
from pathlib import Path
from typing import Any

try:
    import angen_sensors
    import bpy
    import numpy as np
except ModuleNotFoundError as error:
    raise SystemExit(
        f"array_frames: {error}: run `pip install .` in the repository's folder"
    ) from None

# The places are so far from the point below the array at most: a share of the ceiling's height.
ASIDE = 0.6
# m: heights of a seat, and of what bears a lying person: the floor or a mattress.
SEATS, BEDS = (0.38, 0.50), (0.0, 0.05, 0.10, 0.20)
# The room's things are warmer or colder than it by up to this, K.
SPOTS = 0.7


def box(name: str, size: tuple[float, float, float], at: tuple[float, float, float]) -> Any:
    bpy.ops.mesh.primitive_cube_add(size=1.0, location=at)
    made = bpy.context.object
    made.name, made.scale = name, size
    return made


def make_room(path: Path) -> None:
    """Save a room with a chair, a mattress and some spots of another temperature on its floor."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    box("Floor", (8.0, 8.0, 0.1), (0.0, 0.0, -0.05))
    box("Mattress", (2.0, 0.9, 1.0), (0.0, 0.0, -5.0))
    box("Seat", (0.42, 0.42, 0.04), (0.0, 0.0, -5.0))
    box("Back", (0.04, 0.42, 0.45), (0.0, 0.0, -5.0))
    for number in range(4):
        box(f"Spot {number}", (1.0, 1.0, 0.01), (0.0, 0.0, 0.0))
    bpy.ops.wm.save_as_mainfile(filepath=str(path))


def dress(body: Any, rng: np.random.Generator) -> None:
    """Give a body random clothes: their insulation, and how loose they are."""
    # Light summer clothes have 0.5 clo, indoor clothes in winter 1 clo.
    body.angen_warmth.insulation = rng.uniform(0.5, 1.3)
    loose = body.modifiers.get("Loose clothes") or body.modifiers.new("Loose clothes", "DISPLACE")
    loose.mid_level = 0.0
    loose.strength = rng.uniform(0.0, 0.05)


def furnish(rng: np.random.Generator, room: float, aside: float) -> None:
    """Set the temperature of the room in °C, and move the spots on its floor."""
    bpy.context.scene.angen_ambient_temperature = room
    for number in range(4):
        spot = bpy.data.objects[f"Spot {number}"]
        spot.location = (*rng.uniform(-2.0 * aside, 2.0 * aside, 2), 0.0)
        spot.scale = (*rng.uniform(0.2, 2.0, 2), 0.01)
        spot.angen_warmth.use_temperature = True
        spot.angen_warmth.temperature = room + rng.uniform(-SPOTS, SPOTS)


def put(home: Any, person: str, posture: str, at: Any, yaw: float, rng: Any) -> None:
    """Put a person into a posture at a point (x, y), with the chair or mattress that bears it."""
    x, y = at
    along = np.array([math.cos(yaw), math.sin(yaw)])
    height = {"standing": 0.0, "sitting": rng.uniform(*SEATS), "lying": rng.choice(BEDS)}[posture]
    mattress, seat, back = (bpy.data.objects[name] for name in ("Mattress", "Seat", "Back"))
    for thing in (mattress, seat, back):
        thing.location.z, thing.rotation_euler.z = -5.0, yaw
    if posture == "sitting":
        seat.location = (*(np.array(at) + 0.05 * along), height - 0.02)
        back.location = (*(np.array(at) - 0.20 * along), height + 0.22)
    elif posture == "lying" and height > 0.0:
        mattress.location, mattress.scale.z = (x, y, height / 2), height
    home.pose(person, posture, (x, y, height), yaw, side=int(rng.choice((0, 0, 1, -1))))


def main() -> None:
    said = argparse.ArgumentParser(description=(__doc__ or "").partition("\n\n")[0])
    said.add_argument("table", type=Path, metavar="FRAMES.csv")
    said.add_argument("--people", type=int, default=40, help="number of persons")
    said.add_argument("--places", type=int, default=8, help="frames of each posture and person")
    said.add_argument("--preset", default="D6T_1616L", help="preset of the array")
    said.add_argument("--height", type=float, default=2.2, help="height of the array, m")
    said.add_argument("--room", type=float, nargs=2, default=(19.0, 20.0), metavar="°C")
    said.add_argument("--seed", type=int, default=1)
    asked = said.parse_args()
    rng = np.random.default_rng(asked.seed)
    with tempfile.TemporaryDirectory() as folder, asked.table.open("w", newline="") as file:
        room = Path(folder) / "room.blend"
        make_room(room)
        home = angen_sensors.open(room)
        try:
            array = home.add(
                "THERMAL_ARRAY", "Array", at=(0.0, 0.0, asked.height), preset=asked.preset
            )
        except angen_sensors.AngenError as error:
            raise SystemExit(f"array_frames: {error}") from None
        netd, pattern = array.netd, array.fixed_pattern
        people = {sort: home.add_resident(sort) for sort in ("ADULT", "OLDER_ADULT")}
        usual = {name: bpy.data.objects[name].angen_resident.stature for name in people.values()}
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(["posture", "person", "columns", "frame_c"])
        for number in range(asked.people):
            sort = "OLDER_ADULT" if rng.random() < 0.25 else "ADULT"
            for other, name in people.items():
                bpy.data.objects[name].location.z = 0.0
                bpy.data.objects[name].children[0].hide_viewport = other != sort
            person = people[sort]
            rig = bpy.data.objects[person]
            rig.angen_resident.stature = usual[person] * rng.uniform(0.9, 1.1)
            dress(rig.children[0], rng)
            furnish(rng, rng.uniform(*asked.room), ASIDE * asked.height)
            # Devices differ, and a part's noise depends on how it is read.
            array.netd = netd * math.exp(rng.uniform(math.log(0.5), math.log(6.0)))
            array.fixed_pattern = pattern * rng.uniform(0.0, 3.0)
            for posture in ("standing", "sitting", "lying"):
                for _ in range(asked.places):
                    # A new seed for each frame: else all have the same draws of noise.
                    bpy.context.scene.angen_seed = int(rng.integers(1 << 30))
                    at = rng.uniform(-ASIDE, ASIDE, 2) * asked.height
                    put(home, person, posture, at, rng.uniform(-math.pi, math.pi), rng)
                    frame = home.simulate(frames=(1, 1)).samples("Array")["frame_c"][0]
                    rows.writerow([posture, f"person {number}", array.columns, frame])
            print(f"{number + 1} of {asked.people} people", file=sys.stderr, flush=True)
        home.close()


if __name__ == "__main__":
    main()
