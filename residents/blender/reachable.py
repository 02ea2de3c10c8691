# SPDX-License-Identifier: GPL-3.0-or-later
"""Find the marked places that residents cannot reach, and the objects in the way.

The paths towards these places, up to the first obstacle, can be drawn as curves on the floor.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ...angen_addon.doctor import CHECKS
from ...angen_addon.doctor.building import leaves
from ...angen_addon.doctor.examined import MOVED_WITHOUT_KEYS, Examined, Found
from ...angen_addon.scene.marks import WAY_MARK
from ...angen_addon.scene.sensors import unit_scale
from ...sensor_logic.logs.error import AngenError
from ...sensor_logic.logs.wording import Lengths, named, plural, quoted, uncapitalized
from ...sensor_logic.model import Array
from ...sensor_logic.progress import Work, finished, part_of
from ..acting.places import LAMP, Place, Places
from ..acting.unreached_places import Unreached, unreached_in_steps
from .lamps import lamp_of, unswitchable
from .marks import LABELS, NONE, marked
from .places import read_marks, read_marks_in_steps
from .settings import residents_in
from .standing import WalkedStorey
from .unmovable import examined_residents, unmovable, unmovable_residents

# m above the floor: an object in the way is searched for at this height.
HIP_M = 1.0


@dataclass(frozen=True, eq=False)
class Checked:
    """The result of checking which places residents can reach.

    Attributes
    ----------
    places
        The marked places, doors and lamps.
    marked
        The number of marked objects.
    lost
        The places that residents cannot reach.
    between
        The name of the object in the way to a place, by the place's name.
    shut
        Names of objects that look like doors but are not marked as doors.
    unable
        Sentences on what a day cannot move or switch as it should.
    """

    places: Places
    marked: int
    lost: list[Unreached]
    between: Mapping[str, str]
    shut: tuple[str, ...] = ()
    unable: tuple[str, ...] = ()

    @property
    def count(self) -> str:
        """A text with the number of marked objects, and the number of unreachable places."""
        places = self.places.places
        counts = {
            "place": len(places),
            "door": len(self.places.doors.keys() - places.keys()),
            "lamp": len(self.places.lamps.keys() - places.keys()),
        }
        what = ", ".join(plural(count, name) for name, count in counts.items() if count)
        marked = f"{self.marked} marked"
        if any(list(counts.values())[1:]):
            marked = f"{self.marked} marked ({what})"
        lost, problems = plural(len(self.lost), "place"), len(self.places.problems)
        found = "all places can be reached"
        if self.lost and problems:
            found = f"{lost} cannot be reached, {problems} cannot be read"
        elif self.lost:
            found = f"{lost} cannot be reached"
        elif problems:
            found = f"{problems} cannot be read"
        return f"{marked}: {found}"


def guessed_rooms(home: Examined) -> Iterable[Found]:
    """Yield one finding with all marked places whose room was guessed from sensors nearby."""
    if not marked(home.view_layer):
        return
    try:
        names = read_marks(home.depsgraph).places.guessed
    except AngenError:
        return
    if names:
        yield (
            f"Rooms guessed from the sensors nearby, since no wall separates them: {named(names)}",
            "Set Room in the panel Resident's Place; or draw a box that marks the room (Ignored "
            "by sensors, Room set), or put the objects into a collection named after the room",
            names,
        )


def examined_lamps(home: Examined) -> Iterable[Found]:
    """Yield a finding for each problem of marked lamps.

    A lamp that residents cannot switch has a problem, and so does one that they can only switch
    together with an instance of it.
    """
    lamps = [lamp_of(o) for o in marked(home.view_layer) if o.angen_place.use == LAMP]
    return unswitchable(lamps, home.depsgraph)


def _moved_by_routine(scene: Any, view_layer: Any) -> list[Any]:
    """Return the objects that a routine can move: all marked objects if the home has residents.

    Marked objects are the places, doors and lamps that residents use. Without residents, the list
    is empty.
    """
    return marked(view_layer) if residents_in(scene) else []


# The doctor does not import residents: add their checks here.
CHECKS["rooms"] = guessed_rooms
CHECKS["residents"] = examined_residents
CHECKS["lamps"] = examined_lamps
MOVED_WITHOUT_KEYS.append(_moved_by_routine)


def check_places(depsgraph: Any) -> Checked:
    """Check which marked places residents can reach; raise `AngenError` if none can be read."""
    return finished(check_places_in_steps(depsgraph))


def check_places_in_steps(depsgraph: Any) -> Work[Checked]:
    """Check the places as `check_places` does; yield the progress, and return the result."""
    reading = yield from part_of(read_marks_in_steps(depsgraph), 0.0, 0.8, "floors and places")
    lost = yield from part_of(unreached_in_steps(reading.places), 0.8, 1.0, "ways")
    between = {}
    for one in lost:
        if len(one.way):
            ground = reading.grounds[one.place.storey]
            name = _object_between(ground, reading.marked[one.place.name].rows, one)
            if name:
                between[one.place.name] = name
    count = len(marked(depsgraph.view_layer))
    shut = _unmarked_doors(depsgraph) if lost else ()
    return Checked(reading.places, count, lost, between, shut, _unable(depsgraph, reading.places))


def _unable(depsgraph: Any, places: Places) -> tuple[str, ...]:
    """Return sentences on what a day cannot move or switch as it should."""
    leaves_moved = [bpy.data.objects[name] for name in places.doors]
    lamps = [bpy.data.objects[lamp.object] for lamp in places.lamps.values()]
    found = [
        *unmovable_residents(depsgraph.scene),
        *unmovable(leaves_moved),
        *unswitchable(lamps, depsgraph),
    ]
    return tuple(f"{problem}: {uncapitalized(mend)}" for problem, mend, _ in found)


def _unmarked_doors(depsgraph: Any) -> tuple[str, ...]:
    """Return the names of objects that look like doors but are not marked as doors."""
    home = Examined(depsgraph.scene, depsgraph.view_layer, depsgraph)
    found = {leaf.name for leaf, *_ in leaves(home) if leaf.angen_place.use == NONE}
    return tuple(sorted(found))


def _object_between(ground: WalkedStorey, rows: NDArray[np.intp], lost: Unreached) -> str:
    """Return the name of the object between the end of a path and its place, or ""."""
    home = ground.home
    level = ground.storey.height + HIP_M
    start, end = np.array([*lost.nearest, level]), np.array([*lost.place.at[:2], level])
    length = float(np.linalg.norm(end - start))
    if length < 1e-6:
        return ""
    way = ((end - start) / length)[None]
    others = np.setdiff1d(home.rows, rows)
    _, numbers = home.caster.first_hits(
        others, start[None] / home.metres, way, np.array([length / home.metres])
    )
    names = {solid.number: solid.name for solid in home.caster.solids.solids}
    return names.get(int(numbers[0]), "")


def _grouped_by_obstacle(checked: Checked) -> Iterable[list[Unreached]]:
    """Return the unreachable places in groups with the same obstacle.

    The obstacle is an object or, if none is found, the point where the path ends.
    """
    found: dict[Any, list[Unreached]] = {}
    for one in checked.lost:
        far = tuple(one.nearest) if len(one.way) else ()
        cause = one.start, checked.between.get(one.place.name) or far
        found.setdefault(cause, []).append(one)
    return found.values()


def sentence(checked: Checked, lost: list[Unreached], lengths: Lengths) -> str:
    """Return a line of text on unreachable places with the same obstacle.

    It says where the path begins and ends, and which object is in the way.
    """
    nearest = min(lost, key=lambda one: one.short)
    several = len(lost) > 1
    names = named((one.place.name for one in lost), len(lost))
    if not len(nearest.way):
        why = (
            "they are on another floor, and residents do not climb stairs"
            if several
            else "it is on another floor, and residents do not climb stairs"
        )
        return f"{names} cannot be reached from '{nearest.start}': {why}"
    x, y = (lengths.text(float(c)) for c in nearest.nearest)
    goal = quoted(nearest.place.name) if several else "it"
    why = f"residents get as far as ({x}, {y}), {lengths.text(nearest.short)} short of {goal}"
    if between := checked.between.get(nearest.place.name, ""):
        why = f"{why}; '{between}' is between"
    return f"{names} cannot be reached from '{nearest.start}': {why}"


def sentences(checked: Checked, lengths: Lengths) -> list[str]:
    """Return all problems that a check has found, one line of text for each."""
    shut = f"No resident opens {named(checked.shut)}: mark each that is a door with Use: Door"
    lost = [sentence(checked, group, lengths) for group in _grouped_by_obstacle(checked)]
    return [
        *checked.places.problems,
        *([shut] if checked.shut else []),
        *lost,
        *checked.unable,
    ]


def as_text(checked: Checked, lengths: Lengths) -> str:
    """Return a table of the marked places, followed by the problems."""
    rows = [
        (p.name, LABELS[p.use], p.room + " (guessed)" * p.room_guessed)
        for p in checked.places.places.values()
    ]
    rows += [
        (d.name, "Entrance" if d.entrance else LABELS[d.use], d.room)
        for d in checked.places.doors.values()
        if d.name not in checked.places.places
    ]
    rows += [
        (lamp.name, f"{LABELS['LAMP']}, from anywhere", "")
        for lamp in checked.places.lamps.values()
        if lamp.name not in checked.places.places
    ]
    widths = [max(len(row[k]) for row in rows) for k in (0, 1)]
    lines = [f"{a:<{widths[0]}}  {b:<{widths[1]}}  {c}".rstrip() for a, b, c in sorted(rows)]
    return "\n".join([*lines, *sentences(checked, lengths)]) + "\n"


def as_json(checked: Checked) -> str:
    """Return the check as JSON; lengths in metres, angles in degrees counter-clockwise from +x."""
    lost = {one.place.name: one for one in checked.lost}
    places = [_facts(p, lost.get(p.name), checked) for p in checked.places.places.values()]
    doors = [
        {
            "name": door.name, "use": door.use, "entrance": door.entrance, "slides": door.slides,
            "hinge_m": _point(door.hinge), "width_m": round(door.width, 4),
            "opens_m" if door.slides else "opens_deg": round(_opens(door), 3),
        }
        for door in checked.places.doors.values()
    ]  # fmt: skip
    lamps = [
        {"name": lamp.name, "object": lamp.object, "at_m": _point(lamp.at)}
        for lamp in checked.places.lamps.values()
    ]
    rooms = sorted({name for s in checked.places.storeys for name in s.rooms} - {""})
    report = {
        "places": places, "doors": doors, "lamps": lamps, "rooms": rooms,
        "problems": [*checked.places.problems, *checked.unable],
    }  # fmt: skip
    return json.dumps(report, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def _facts(place: Place, lost: Unreached | None, checked: Checked) -> dict[str, Any]:
    facts: dict[str, Any] = {
        "name": place.name, "use": place.use, "room": place.room,
        "room_guessed": place.room_guessed, "stand_m": _point(place.at),
        "yaw_deg": round(math.degrees(place.yaw), 2), "target_m": _point(place.target),
        "height_m": round(place.height, 4), "reached": lost is None,
    }  # fmt: skip
    if lost is not None:
        facts["from"] = lost.start
        if len(lost.way):
            facts |= {"nearest_m": _point(lost.nearest), "short_m": round(lost.short, 4)}
            facts["between"] = checked.between.get(place.name, "")
    return facts


def _opens(door: Any) -> float:
    opening = door.open - door.closed
    return float(opening) if door.slides else math.degrees(opening)


def _point(at: Array) -> list[float]:
    return [round(float(c), 4) for c in at]


# Curves of the ways that end before a place. Sensors ignore them.

COLLECTION = "Ways"
# m: height of the curve above the floor, and its radius.
ABOVE_M, RADIUS_M = 0.05, 0.015
RED = (0.85, 0.12, 0.1, 1.0)


def show(scene: Any, places: Places, lost: list[Unreached]) -> None:
    """Draw the paths towards unreachable places as curves, and the arrows of all places.

    A path ends where residents get no further.
    """
    scene.angen_show_places = True
    remove(scene)
    drawn = [one for one in lost if len(one.way) > 1]
    if not drawn:
        return
    collection = bpy.data.collections.new(COLLECTION)
    collection[WAY_MARK] = True
    collection.hide_render = True
    scene.collection.children.link(collection)
    for one in drawn:
        collection.objects.link(
            _curve(scene, one, places.storeys[one.place.storey].height + ABOVE_M)
        )


def _curve(scene: Any, lost: Unreached, height: float) -> Any:
    metres = unit_scale(scene)
    name = f"Way to {lost.place.name}"
    curve = bpy.data.curves.new(name, "CURVE")
    curve.dimensions, curve.bevel_depth = "3D", RADIUS_M / metres
    spline = curve.splines.new("POLY")
    spline.points.add(len(lost.way) - 1)
    for point, (x, y) in zip(spline.points, lost.way.tolist(), strict=True):
        point.co = (x / metres, y / metres, height / metres, 1.0)
    curve.materials.append(_material())
    obj = bpy.data.objects.new(name, curve)
    obj[WAY_MARK] = lost.place.name
    obj.angen_ignored = obj.hide_render = True
    obj.color = RED
    return obj


def _material() -> Any:
    name = "Way that ends"
    found = bpy.data.materials.get(name)
    if found is None or found.library is not None:
        found = bpy.data.materials.new(name)
        found.diffuse_color = RED
    return found


def remove(scene: Any) -> None:
    """Remove the curves of `show` from the scene."""
    for obj in [obj for obj in scene.objects if WAY_MARK in obj]:
        curve = obj.data
        bpy.data.objects.remove(obj)
        if curve is not None and not curve.users:
            bpy.data.curves.remove(curve)
    for child in list(scene.collection.children):
        if WAY_MARK in child and not child.objects:
            bpy.data.collections.remove(child)
