# SPDX-License-Identifier: GPL-3.0-or-later
"""Compare a layout with the open home, and find errors before any change is made."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix, Vector

from ...sensor_logic.kind import Kind
from ...sensor_logic.kinds import KINDS, NO_KIND
from ...sensor_logic.layout.entries import Layout, LayoutEntry
from ...sensor_logic.logs.error import InputError, explained
from ...sensor_logic.logs.wording import hint, named
from ...sensor_logic.model import Array, pose_from_matrix
from ...sensor_logic.parameters import specs
from ..scene.animation import is_animated, motion_paths
from ..scene.instances import is_holder
from ..scene.sensors import (
    NotPlaced,
    Sensor,
    all_sensors,
    decimal,
    named_block,
    placed_matrix,
    pointed_at,
    unit_scale,
)
from .describe import describe, is_belonging, place_of

# Tolerances of a pose. The place: relative to its distance from the origin, or to 1 m if nearer,
# for single precision. The axes: in radians.
SAME_PLACE, SAME_ANGLE = 2e-6, 2e-6
COMMON = ("room", "enabled", "update_rate")


@dataclass
class SensorChange:
    """The changes that a layout makes to one sensor.

    Attributes
    ----------
    sensor
        The sensor, or None for a new one.
    settings, parameters
        The values to set, by name.
    moves
        The names of its new parent and collection, under "parent" and "collection".
    origin, axes
        Its new pose: shape (3,) in m, and (3, 3). Both are None if the layout gives no pose.
    angles
        The axes as XYZ Euler angles.
    displaced
        Whether the new pose differs from the present one.
    empties
        The changes of the empties that the sensor refers to. Each is a change without settings.
    texts
        The new contents of the texts that the sensor refers to, by name.
    """

    entry: LayoutEntry
    kind: Kind
    sensor: Sensor | None
    settings: dict[str, Any] = field(default_factory=dict)
    parameters: dict[str, Any] = field(default_factory=dict)
    moves: dict[str, str | None] = field(default_factory=dict)
    origin: Array | None = None
    axes: Array | None = None
    angles: Sequence[float] = ()
    displaced: bool = False
    empties: list[SensorChange] = field(default_factory=list)
    texts: dict[str, str] = field(default_factory=dict)

    @property
    def changes(self) -> bool:
        """Whether there is anything to change."""
        return bool(
            self.sensor is None
            or self.settings
            or self.parameters
            or self.moves
            or self.displaced
            or self.texts
            or any(empty.changes for empty in self.empties)
        )


class Planner:
    """Compares a layout with the sensors of a view layer at the current frame."""

    def __init__(self, layout: Layout, view_layer: Any, depsgraph: Any) -> None:
        self._entries, self._others = layout.sensors, layout.others
        self._view_layer = view_layer
        self._depsgraph = depsgraph
        self._sensors = all_sensors(view_layer)
        # The objects and texts that the layout describes, as values of parameters.
        self.described: dict[str, dict[str, str]] = {"Object": {}, "Text": {}}
        for entry in self._entries:
            self.described["Object"] |= {empty.name: empty.name for empty in entry.empties}
            self.described["Text"] |= entry.texts
        self._empties: dict[str, SensorChange] = {}

    def changes(self) -> list[SensorChange]:
        """Return the change of each sensor in the layout.

        A layout can also have settings for all sensors that it does not list. Their changes come
        last. Raise `InputError` if the layout is wrong.
        """
        found = [self.change(entry) for entry in self._entries]
        self._check_parents([*found, *self._empties.values()])
        if self._others is not None:
            for sensor in self.left_out():
                names = {"name": sensor.name, "library": sensor.library}
                entry = replace(self._others, values={**names, **self._others.values})
                found.append(self.change(entry))
        return found

    def left_out(self) -> list[Sensor]:
        """Return the sensors that are not in the layout.

        Raise `InputError` if a name is ambiguous.
        """
        listed = {sensor.uid for entry in self._entries if (sensor := self.sensor(entry))}
        return [sensor for sensor in self._sensors if sensor.uid not in listed]

    def to_delete(self) -> list[Sensor]:
        """Return the sensors that are not in the layout and must be deleted.

        Raise `InputError` if one of them cannot be deleted.
        """
        found = self.left_out()
        stuck = [s for s in found if s.holders or s.object.library or s.object.override_library]
        if stuck:
            raise InputError(
                f"--remove cannot delete {named(s.name for s in stuck)}: Blender would bring back "
                "linked objects and library overrides. Keep it in the layout, switched off "
                '("enabled": false) where it is an override, or delete it in its own file'
            )
        return found

    def sensor(self, entry: LayoutEntry) -> Sensor | None:
        """Return the sensor that an entry of the layout names, or None if there is none.

        Raise `InputError` if several sensors have this name, or if its library is not linked.
        """
        library = entry.values.get("library")
        found = [
            s
            for s in self._sensors
            if s.name == entry.name and (library is None or s.library == library)
        ]
        if len(found) > 1:
            raise entry.error(
                f"{len(found)} sensors of the home have this name: rename one, or give the "
                "library of a linked one"
            )
        if not found and library:
            raise entry.error(
                f"no sensor of this name is linked from {library}: link that file first, or leave "
                "this sensor out",
                "library",
            )
        return found[0] if found else None

    def change(self, entry: LayoutEntry) -> SensorChange:
        """Return the change that a layout entry makes. Raise `InputError` if the entry is wrong."""
        sensor = self.sensor(entry)
        taken = None if sensor else self._same_name(entry)
        kind = self._kind(entry, sensor)
        change = SensorChange(
            entry, kind, sensor or (Sensor(entry.name, kind, taken) if taken else None)
        )
        if change.sensor is None:
            self._check_new(entry)
            listed: dict[str, Any] = {"parameters": {}}
        else:
            listed = describe(Sensor(entry.name, kind, change.sensor.object, change.sensor.holders))
            listed["kind"] = change.sensor.settings.kind
        self._plan_place(change, listed)
        self._plan_settings(change, listed)
        if change.sensor is not None and change.changes:
            _check_editable(change)
        if taken is not None and change.displaced:
            raise entry.error(
                "an object of this name exists at another place and is not a sensor: give the "
                "sensor another name, or leave location and rotation out to make that object a "
                "sensor"
            )
        for empty in entry.empties:
            if empty.name not in self._empties:
                self._empties[empty.name] = self.empty(empty, kind)
            change.empties.append(self._empties[empty.name])
        change.texts = {name: text for name, text in entry.texts.items() if _is_new(entry, name)}
        return change

    def empty(self, entry: LayoutEntry, kind: Kind) -> SensorChange:
        """Return the change of an empty that a sensor of this kind refers to, such as a magnet.

        Raise `InputError` if the entry is wrong.
        """
        obj = self._same_name(entry)
        if obj is not None and not is_belonging(obj):
            raise entry.error(
                "an object of this name exists and is not an empty: give the empty another name, "
                "or leave it out of empties"
            )
        if obj is None and "location" not in entry.values:
            raise entry.error("there is no empty of this name yet, and a new one needs a location")
        change = SensorChange(entry, kind, None if obj is None else Sensor(entry.name, kind, obj))
        self._plan_place(change, place_of(change.sensor) if change.sensor else {})
        if change.sensor is not None and change.changes:
            _check_editable(change)
        return change

    def _same_name(self, entry: LayoutEntry) -> Any:
        """Return the object with an entry's name that is not yet a sensor, or None.

        Raise `InputError` if the object is not in the view layer.
        """
        obj = next((o for o in bpy.data.objects if o.name == entry.name and not o.library), None)
        if obj is None or obj in set(self._view_layer.objects):
            return obj
        raise entry.error(
            f"an object of this name exists, but not in the view layer '{self._view_layer.name}': "
            "give the sensor another name, or tick the object's collection in the Outliner"
        )

    def _kind(self, entry: LayoutEntry, sensor: Sensor | None) -> Kind:
        if "kind" in entry.values:
            return KINDS[entry.values["kind"]]
        if sensor is not None:
            return sensor.kind
        known = hint(entry.name, [s.name for s in self._sensors])
        raise entry.error(f"no sensor has this name, and a new one needs a kind; {known}")

    def _check_new(self, entry: LayoutEntry) -> None:
        """Raise `InputError` if a new sensor cannot be made from the entry."""
        holder = self._view_layer.objects.get(entry.name.partition("/")[0])
        if "/" in entry.name and holder is not None and is_holder(holder):
            known = [s.name for s in self._sensors if s.holders]
            raise entry.error(f"the instance has no such sensor; {hint(entry.name, known)}")
        longest = bpy.types.ID.bl_rna.properties["name"].length_max - 1
        if len(entry.name.encode()) > longest or not entry.name.isprintable():
            raise entry.error(
                f"a new name must have at most {longest} bytes of UTF-8 and no control characters",
                "name",
            )
        if "location" not in entry.values:
            raise entry.error("there is no sensor of this name yet, and a new one needs a location")

    # The place of a sensor

    def _plan_place(self, change: SensorChange, listed: dict[str, Any]) -> None:
        entry, values = change.entry, change.entry.values
        bounds = values.get("bounds", listed.get("bounds"))
        if change.sensor is not None and not _same_bounds(bounds, listed["bounds"]):
            raise entry.error(
                "a layout cannot change the bounds of an existing sensor: scale it in Blender, "
                "delete it first, or leave bounds out",
                "bounds",
            )
        for key in ("parent", "collection"):
            if key in values and (change.sensor is None or values[key] != listed[key]):
                change.moves[key] = values[key]
        given = [key for key in ("location", "rotation", "look") if key in values]
        if not given:
            return
        change.origin, change.axes, change.angles = self._target(change)
        as_listed = not values.keys() & {"relative_to", "look"}
        if as_listed and all(_is_same(values[key], listed.get(key)) for key in given):
            return
        change.displaced = change.sensor is None or not self.has_new_pose(change)

    def _object(self, entry: LayoutEntry, key: str, name: str) -> Any:
        """Return the object with this name. Raise `InputError` if there is none.

        `key` is the entry's key that holds the name, for the error message.
        """
        found = self._view_layer.objects.get(name)
        if found is None:
            known = [obj.name for obj in self._view_layer.objects]
            raise entry.error(f"{key}: no object is called '{name}'; {hint(name, known)}", key)
        return found

    def _target(self, change: SensorChange) -> tuple[Array, Array, Sequence[float]]:
        """Compute the new pose of a sensor from an entry of the layout.

        Return the origin (3,) in m, the axes (3, 3) and the XYZ Euler angles. The angles are empty
        if the axes do not change.
        """
        entry, values = change.entry, change.entry.values
        metres = unit_scale(self._depsgraph.scene)
        origin, axes = np.zeros(3), np.eye(3)
        if "relative_to" in values:
            base = self._object(entry, "relative_to", values["relative_to"])
            where = entry.where("relative_to")
            with explained(where, NotPlaced), explained(f"{where}: '{base.name}'", ValueError):
                matrix = placed_matrix(base, self._depsgraph)
                pose = pose_from_matrix(np.array(matrix), metres)
            origin, axes = pose.origin, pose.axes
        now = self._pose(change.sensor) if change.sensor else None
        at = np.array(values["location"]) if "location" in values else None
        place = origin + axes @ at if at is not None else now[0] if now else origin
        if not np.isfinite(place.astype(np.float32) / np.float32(metres)).all():
            raise entry.error("location is too far away: move it nearer to the origin", "location")
        if "look" in values:
            turned = _axes_looking(axes @ np.array(values["look"], float))
        elif "rotation" in values:
            if "relative_to" not in values:
                angles = values["rotation"]
                return place, _axes(angles), angles
            turned = axes @ _axes(values["rotation"])
        else:
            if now is not None:
                return place, now[1], ()
            turned = axes
        return place, turned, tuple(Matrix(turned.tolist()).to_euler("XYZ"))

    def _pose(self, sensor: Sensor) -> tuple[Array, Array] | None:
        """Return origin (3,) in m and axes (3, 3) of a sensor, or None if its scale is 0."""
        matrix = np.array(sensor.world_matrix(self._depsgraph))
        try:
            pose = pose_from_matrix(matrix, unit_scale(self._depsgraph.scene))
        except ValueError:
            return None
        return pose.origin, pose.axes

    def has_new_pose(self, change: SensorChange, sensor: Sensor | None = None) -> bool:
        """Return whether a sensor has the new pose of `change`, within tolerances.

        `sensor` is by default the sensor of the change.
        """
        found = sensor or change.sensor
        now = self._pose(found) if found else None
        if now is None or change.origin is None or change.axes is None:
            return False
        near = SAME_PLACE * max(1.0, float(np.abs(change.origin).max()))
        return bool(
            np.abs(now[0] - change.origin).max() <= near
            and np.abs(now[1] - change.axes).max() <= SAME_ANGLE
        )

    def _check_parents(self, changes: Sequence[SensorChange]) -> None:
        """Raise `InputError` if new parents are missing, or if parents would form a loop."""
        parents = {o.name: o.parent.name for o in self._view_layer.objects if o and o.parent}
        new = {change.entry.name for change in changes if change.sensor is None}
        for change in changes:
            if "parent" in change.moves:
                parent = change.moves["parent"]
                parents.pop(change.entry.name, None)
                if parent is not None:
                    parents[change.entry.name] = parent
                    if parent not in new:
                        self._object(change.entry, "parent", parent)
        for change in changes:
            above, seen = parents.get(change.entry.name), set()
            while above is not None and above not in seen:
                if above == change.entry.name:
                    raise change.entry.error(
                        "it would be a parent of itself: give another parent", "parent"
                    )
                seen.add(above)
                above = parents.get(above)

    # The settings of a sensor

    def _plan_settings(self, change: SensorChange, listed: dict[str, Any]) -> None:
        entry, kind = change.entry, change.kind
        if listed.get("kind", NO_KIND) != kind.identifier:
            change.settings["kind"] = kind.identifier
        preset = next((p for p in kind.presets if p.identifier == entry.values.get("preset")), None)
        given = entry.values
        if preset is not None and preset.rate:
            given = {"update_rate": preset.rate, **given}
        for name in COMMON:
            if name in given and not _is_same(given[name], listed.get(name)):
                change.settings[name] = given[name]
        wanted = entry.settings(kind)
        for name, value in wanted.items():
            if name not in listed["parameters"] or not _is_same(value, listed["parameters"][name]):
                change.parameters[name] = value
        rate = change.settings.get("update_rate", 1.0)
        if not rate > 0.0:
            raise entry.error(f"update_rate is {rate:g} Hz: it must be above 0", "update_rate")
        if change.parameters or "kind" in change.settings:
            self._check_parameters(change, listed)

    def _check_parameters(self, change: SensorChange, listed: dict[str, Any]) -> None:
        """Raise `InputError` if an object is missing, or if the panel would report a problem."""
        entry, kind = change.entry, change.kind
        merged = listed["parameters"] | change.parameters
        for name, spec in specs(kind.parameters).items():
            if name not in merged:
                continue
            if not spec.pointer:
                merged[name] = math.nan if merged[name] is None else merged[name]
            elif merged[name] is not None:
                described = self.described.get(spec.pointer, {})
                if merged[name] in described:
                    merged[name] = described[merged[name]]
                    continue
                try:
                    found = named_block(spec.pointer, merged[name], described)
                except InputError as error:
                    raise entry.error(f"{name}: {error}", "parameters", name) from None
                merged[name] = pointed_at(found, spec.pointer)
        problems = kind.parameters(**merged).problems()
        if problems:
            raise entry.error(problems[0], "parameters", problems[0].split(" ")[0])


def _is_new(entry: LayoutEntry, name: str) -> bool:
    """Return whether a text of an entry differs from the text of this name in the file.

    Raise `InputError` if that text is linked.
    """
    text = bpy.data.texts.get(name)
    if text is None or text.as_string().splitlines() == entry.texts[name].splitlines():
        return text is None
    if text.library:
        raise entry.error(f"the text '{name}' is linked from a library: rename it", "texts", name)
    return True


def _check_editable(change: SensorChange) -> None:
    """Raise `InputError` if a property to be changed is linked, animated or driven."""
    sensor, entry = change.sensor, change.entry
    assert sensor is not None
    if sensor.holders:
        raise entry.error(
            f"it is in the instance '{sensor.handle.name}', which shows another sensor's settings "
            "and place: change that sensor, or use Override Linked Home"
        )
    if not sensor.object.is_editable:
        raise entry.error(
            f"it is linked from {sensor.library}: change it in that file, or make a "
            "library override of it"
        )
    if change.displaced and motion_paths(sensor.object):
        how = motion_paths(sensor.object)[0]
        raise entry.error(
            f"its location or rotation is animated or constrained ({how}): remove that, or leave "
            "location and rotation out"
        )
    group = f"angen_sensor.{change.kind.attribute}"
    paths = {name: f"angen_sensor.{name}" for name in change.settings}
    paths |= {name: f"{group}.{name}" for name in change.parameters}
    for name, path in paths.items():
        if is_animated(sensor.object, path):
            raise entry.error(
                f"{name} is animated or driven: remove the keyframes or driver, or leave it out",
                name,
            )


def _is_same(value: Any, listed: Any) -> bool:
    """Return whether two values of `list --json` are equal, floats as `decimal` rounds them."""
    if isinstance(value, list):
        return isinstance(listed, list) and all(map(_is_same, value, listed))
    numbers = isinstance(value, float) or isinstance(listed, float)
    if numbers and value is not None and listed is not None:
        one, two = (decimal(float(np.float32(v))) for v in (value, listed))
        return one == two
    return bool(value == listed) and isinstance(value, bool) == isinstance(listed, bool)


def _same_bounds(wanted: Any, listed: Any) -> bool:
    if wanted is None or listed is None:
        return bool(wanted == listed)
    size = max(float(np.abs(listed).max()), 1e-9)
    return float(np.abs(np.array(wanted) - listed).max()) <= 1e-4 * size


def _axes(angles: Sequence[float]) -> Array:
    """Return the rotation matrix (3, 3) of XYZ Euler angles."""
    (a, b, c), identity = angles, np.eye(3)
    turns = [
        identity if not angle else np.array(Matrix.Rotation(angle, 3, axis))
        for angle, axis in ((c, "Z"), (b, "Y"), (a, "X"))
    ]
    return turns[0] @ turns[1] @ turns[2]


def _axes_looking(direction: Array) -> Array:
    """Return the axes (3, 3) of a sensor that looks in this direction, +Y as far up as possible."""
    return np.array(
        Vector(direction / np.linalg.norm(direction)).to_track_quat("-Z", "Y").to_matrix()
    )
