# SPDX-License-Identifier: GPL-3.0-or-later
"""A home of two rooms whose resident follows a routine, for `angen day`.

It is built and simulated once per process. conftest.py makes its fixtures known to all files.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import pytest

ROUTINE = """
schema = 1
[person.anna]
resident = "Adult"
begins = "Sleep"
[activity.Sleep]
do = ["switch Lamp off", "lie Bed"]
while = []
labels = { casas = "Sleeping" }
[activity.Sit]
do = ["switch Lamp on", "sit Seat"]
while = [{ do = "shift", every = "4 h" }]
[[plan]]
person = "anna"
entries = [
  { at = "09:00", spread = "10 min", activity = "Sit", lasts = "90 min" },
  { at = "22:00", spread = "20 min", activity = "Sleep", until = "08:00" },
]
"""
# Made once in this process: the home's file, and folders of so many days.
BUILT: list[bytes] = []
LIVED: dict[int, dict[str, bytes]] = {}


def build(world: Any, addon_part: Callable[[str], Any]) -> None:
    """Add two rooms with a door between them, a person, and sensors."""
    import bpy
    from mathutils import Vector
    from test_places import Flat

    flat = Flat(world)
    door = flat.door()
    for obj, use in ((flat.chair, "SIT"), (flat.bed, "LIE"), (door, "DOOR")):
        obj.angen_place.use = use
    lamp = world.link("Lamp", bpy.data.lights.new("Lamp", "POINT"), (1.5, 2, 2.4))
    lamp.data.energy, lamp.angen_place.use = 40.0, "LAMP"
    sort = addon_part("residents.body.skeleton").Sort.ADULT
    adding = addon_part("residents.blender.settings")
    adding.add_resident(bpy.context, sort, Vector((1.5, 2.5, 0)), 0.0)
    for name, x, yaw in (("PIR left", 0.06, -math.pi / 2), ("PIR right", 5.94, math.pi / 2)):
        pir = world.pir(name, update_rate=10.0, rays=15, vertical_fov=0.6)
        pir.location, pir.rotation_euler = (x, 3.2, 2.0), (math.radians(65), 0, yaw)
        pir.angen_sensor.room = name.removeprefix("PIR ")
    reed = world.sensor("CONTACT", "Contact", update_rate=0.5)
    magnet = world.link("Magnet", None, (2.97, 2.3, 1.9))
    magnet.parent = door
    magnet.matrix_parent_inverse = door.matrix_basis.inverted()
    reed.location, reed.angen_sensor.contact.magnet = (2.97, 2.305, 1.905), magnet


@pytest.fixture
def lived_home(world: Any, addon_part: Callable[[str], Any], tmp_path: Path) -> Path:
    """Open the file of `build`, with its routine beside it; return its path."""
    import bpy

    path = tmp_path / "home.blend"
    if not BUILT:
        build(world, addon_part)
        bpy.ops.wm.save_as_mainfile(filepath=str(path))
        BUILT.append(path.read_bytes())
    path.write_bytes(BUILT[0])
    bpy.ops.wm.open_mainfile(filepath=str(path), load_ui=False)
    (tmp_path / "week.toml").write_text(ROUTINE, encoding="utf-8")
    return path


def words_of(home: Path, *more: object, out: str = "out", days: int = 2) -> list[str]:
    """Return the command's arguments after the file."""
    given = ["--routine", home.parent / "week.toml", "--start", "2026-03-02", "--days", days]
    given += ["--seed", 1, "--format", "casas", "--out", home.parent / out, *more]
    return [str(word) for word in given]


@pytest.fixture
def angen_day(
    lived_home: Path, addon_part: Callable[[str], Any], capsys: pytest.CaptureFixture[str]
) -> Callable[..., tuple[int, str]]:
    """Run `angen day` on the open home in this process; return its status and standard error."""

    def run(*more: object, out: str = "out", days: int = 2) -> tuple[int, str]:
        command = addon_part("angen_addon.commands.command_line").run_command
        status = command(["day", *words_of(lived_home, *more, out=out, days=days)])
        return status, capsys.readouterr().err

    return run


@pytest.fixture
def lived(angen_day: Any, lived_home: Path) -> Callable[..., Path]:
    """Return a copy of the folder of a whole run of so many days."""

    def put(days: int, out: str = "out") -> Path:
        folder = lived_home.parent / out
        if days not in LIVED:
            # The first of two days equals a run of one day: another test holds this.
            write(folder, FIRST_DAY if days == 1 else (), LIVED.get(2, {}))
            status, told = angen_day(days=days, out=out)
            assert status == 0, told
            LIVED[days] = content(folder)
        write(folder, LIVED[days], LIVED[days])
        return folder

    return put


def write(folder: Path, names: Iterable[str], files: dict[str, bytes]) -> None:
    """Write the named files into the folder."""
    for name in names:
        if name in files:
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(files[name])


FIRST_DAY = ("days/run.txt", "days/2026-03-02.json")


def rows(path: Path) -> list[dict[str, str]]:
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def content(folder: Path) -> dict[str, bytes]:
    return {p.relative_to(folder).as_posix(): p.read_bytes() for p in folder.rglob("*.*")}
