# SPDX-License-Identifier: GPL-3.0-or-later
"""Apply a layout, which lists the sensors of a home, to the open home: all of it or nothing."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import Any, NamedTuple

import bpy
import numpy as np
from mathutils import Euler, Matrix, Quaternion, Vector

from ...sensor_logic.kinds import NO_KIND
from ...sensor_logic.layout.entries import Layout, LayoutEntry, read_layout
from ...sensor_logic.logs.error import explained
from ...sensor_logic.logs.wording import named, plural
from ...sensor_logic.parameters import former_text, specs
from ..appearance.housing import Housing, housing_mesh
from ..authoring.of_kind import housing_of
from ..runtime.time_base import evaluated_depsgraph
from ..scene.instances import chain, is_sensor
from ..scene.sensors import Sensor, named_block, unit_scale
from .describe import named_blocks
from .marks import mark_changes, remove_mark, unlisted
from .measured import face_bounds
from .plan import Planner, SensorChange

EMPTY_SIZE_M = 0.1
# The keys that `_check_done` does not compare, because it compares the place and each empty itself.
CHECKED_ELSE = ("location", "rotation", "look", "relative_to", "empties", "texts")
CHANNELS = ("location", "rotation_euler", "rotation_quaternion", "rotation_axis_angle", "scale")
# Relative tolerance of the bounds by which a housing is recognised.
SAME_SIZE = 1e-3


class Applied(NamedTuple):
    """The changes that a layout made to the sensors of a home.

    Attributes
    ----------
    added, changed, unchanged, removed
        Names of sensors.
    cleared
        The names of removed sensors whose objects stay, such as furniture.
    marked
        The names of objects whose marks were set or changed.
    unmarked
        The names of objects whose marks were removed.
    replaced
        A sentence that lists values of older versions and the present values that replace them;
        empty without any.
    """

    added: list[str]
    changed: list[str]
    unchanged: list[str]
    removed: list[str]
    cleared: list[str]
    marked: list[str]
    unmarked: list[str]
    replaced: str = ""

    @property
    def text(self) -> str:
        """The changes in a sentence."""
        parts = [f"{len(self.added)} added", f"{len(self.changed)} changed"]
        parts += [f"{len(self.removed)} removed"] if self.removed else []
        found = ", ".join([*parts, f"{len(self.unchanged)} as they were"])
        if self.marked:
            found += f"; {plural(len(self.marked), 'object')} marked"
        if self.unmarked:
            found += f"; no longer marked: {named(self.unmarked)}"
        if self.cleared:
            found += f"; no longer sensors: {named(self.cleared)}"
        return f"{found}; {self.replaced}" if self.replaced else found


def apply_layout(path: Path, remove: bool = False) -> Applied:
    """Add and change sensors in the current scene to match a layout file.

    If `remove` is True, delete the sensors that are not in the layout, and the empties and texts
    that nothing else uses; remove the marks that it lacks if it has marks. If the layout is wrong,
    raise `InputError` and change nothing.
    """
    layout = read_layout(path)
    view_layer = bpy.context.view_layer
    view_layer.update()
    # No change is needed to sensors that are removed.
    kept = Layout(layout.sensors, marks=layout.marks) if remove else layout
    planner = Planner(kept, view_layer, evaluated_depsgraph())
    plans = planner.changes()
    others = unlisted(layout.marks, view_layer) if remove and layout.marks is not None else []
    left_out = planner.to_delete() if remove else []
    unchanged = [plan.entry.name for plan in plans if not plan.changes]
    added = [plan.entry.name for plan in plans if plan.sensor is None]
    doing = [plan for plan in plans if plan.changes]
    changed = [plan.entry.name for plan in doing if plan.sensor is not None]
    with _Rollback() as rollback:
        # Callbacks run in reverse, so this runs last.
        rollback.callback(view_layer.update)
        _make_changes(plans, rollback)
        _check_done(doing)
        # Sensors and empties of the layout can be marked too.
        marks = mark_changes(layout.marks or [], view_layer)
        for mark in marks:
            mark.make(rollback)
        rollback.pop_all()
    unmarked = [remove_mark(obj) for obj in others]
    removed = [sensor.name for sensor in left_out]
    belongings = {block for sensor in left_out for block in named_blocks(sensor)}
    cleared = [sensor.name for sensor in left_out if not _delete(sensor)]
    _delete_unused(belongings)
    view_layer.update()
    former = [choice for plan in plans for choice in plan.entry.former_choices(plan.kind)]
    marked = [mark.name for mark in marks]
    replaced = former_text(former)
    return Applied(added, changed, unchanged, removed, cleared, marked, unmarked, replaced)


class _Rollback(ExitStack):
    """Context manager: on exit, undo the changes, unless `pop_all` has been called.

    Property changes are made by `set`. Other changes are undone by callbacks.
    """

    def set(self, owner: Any, name: str, value: Any) -> None:
        """Set a property, which the rollback restores."""
        before = getattr(owner, name)
        if isinstance(before, (Vector, Euler, Quaternion, Matrix)):
            before = before.copy()
        self.callback(setattr, owner, name, before)
        setattr(owner, name, value)


def _with_empties(sensors: list[SensorChange]) -> list[SensorChange]:
    """Return the changes of sensors and of their empties, each once."""
    found = {id(plan): plan for sensor in sensors for plan in (*sensor.empties, sensor)}
    return list(found.values())


def _make_changes(sensors: list[SensorChange], rollback: _Rollback) -> None:
    for sensor in sensors:
        for name, content in sensor.texts.items():
            _write_text(name, content, rollback)
    plans = _with_empties(sensors)
    objects = {id(plan): _object_of(plan, rollback) for plan in plans}
    for plan in plans:
        obj = objects[id(plan)]
        wrong = TypeError, ValueError, OverflowError, RuntimeError, AttributeError
        with explained(plan.entry.where(), *wrong):
            _set(plan, obj, rollback)
        if "collection" in plan.moves:
            _move_to_collection(obj, plan.moves["collection"], rollback)
    for plan in plans:
        if "parent" in plan.moves:
            _set_parent(objects[id(plan)], plan.moves["parent"], rollback)
    # A child is placed after its parent, even if only the parent moves.
    for plan in sorted(plans, key=lambda plan: len(list(chain(objects[id(plan)])))):
        obj = objects[id(plan)]
        if plan.displaced or (plan.origin is not None and obj.parent and obj.is_editable):
            _move_to_pose(plan, obj, rollback)


def _object_of(plan: SensorChange, rollback: _Rollback) -> Any:
    """Return the object of the sensor that is changed; for a new sensor, add an object."""
    if plan.sensor is not None:
        return plan.sensor.object
    metres = unit_scale(bpy.context.scene)
    housing = _housing(plan)
    mesh = housing_mesh(housing, plan.kind.label, metres) if housing else None
    obj = bpy.data.objects.new(plan.entry.name, mesh)
    if mesh is None:
        obj.empty_display_size = EMPTY_SIZE_M / metres
    else:
        rollback.callback(bpy.data.meshes.remove, mesh)
    rollback.callback(bpy.data.objects.remove, obj)
    if obj.name != plan.entry.name:
        raise plan.entry.error(
            "this name is taken, so Blender calls the new object "
            f"'{obj.name}': give the sensor another name",
            "name",
        )
    if "collection" not in plan.moves:
        _usable_collection().objects.link(obj)
    return obj


def _usable_collection() -> Any:
    """Return the active collection, or the scene's if the active one is linked or excluded."""
    active = bpy.context.view_layer.active_layer_collection
    usable = active.collection.is_editable and not active.exclude
    return active.collection if usable else bpy.context.scene.collection


def _housing(plan: SensorChange) -> Housing | None:
    """Return the housing of a new sensor, or None if the new object must be an empty."""
    kind, values = plan.kind, plan.entry.values
    if "bounds" not in values:
        return housing_of(kind.identifier, values.get("preset", ""))
    if values["bounds"] is None:
        return None
    wanted = np.array(values["bounds"], float)
    return _housing_of_size(plan.kind, wanted) or _box(*wanted.tolist())


def _box(low: list[float], high: list[float]) -> Housing:
    return Housing().box(tuple(low), tuple(high))  # type: ignore[arg-type]


def _housing_of_size(kind: Any, bounds: Any) -> Housing | None:
    """Return the housing of one of the kind's presets, by its bounds (2, 3) in m, or None."""
    for preset in ("", *(preset.identifier for preset in kind.presets)):
        housing = housing_of(kind.identifier, preset)
        points = np.array([housing.points[i] for face in housing.faces for i in face])
        box = np.array([points.min(0), points.max(0)]) if len(points) else np.zeros((2, 3))
        if np.abs(box - bounds).max() <= SAME_SIZE * np.abs(bounds).max():
            return housing
    return None


def _set(plan: SensorChange, obj: Any, rollback: _Rollback) -> None:
    settings = obj.angen_sensor
    if "kind" in plan.settings:
        # Setting the kind also sets the update rate.
        rollback.set(settings, "update_rate", settings.update_rate)
    for name, value in plan.settings.items():
        rollback.set(settings, name, value)
    group = getattr(settings, plan.kind.attribute)
    known = specs(plan.kind.parameters)
    for name, value in plan.parameters.items():
        pointer = known[name].pointer
        found = named_block(pointer, value) if pointer and value else value
        rollback.set(group, name, found)
    preset = plan.entry.values.get("preset", settings.preset)
    if preset != settings.preset:
        rollback.set(settings, "preset", preset)


def _write_text(name: str, content: str, rollback: _Rollback) -> None:
    """Write a text of the file, and add it if there is none of this name."""
    text = bpy.data.texts.get(name)
    if text is None:
        text = bpy.data.texts.new(name)
        rollback.callback(bpy.data.texts.remove, text)
    else:
        rollback.callback(text.from_string, text.as_string())
    text.from_string(content)


def _move_to_collection(obj: Any, name: str | None, rollback: _Rollback) -> None:
    """Link an object to the collection `name`, and unlink it from all others.

    If no collection has this name, make one. If `name` is None, use the scene's root collection. On
    `rollback`, the object's former collections return.
    """
    scene = bpy.context.scene
    target = scene.collection if name is None else bpy.data.collections.get(name)
    if target is None:
        made = target = bpy.data.collections.new(name)
        rollback.callback(bpy.data.collections.remove, made)
        scene.collection.children.link(made)
    before = list(obj.users_collection)
    for collection in before:
        collection.objects.unlink(obj)
    target.objects.link(obj)

    def restore() -> None:
        target.objects.unlink(obj)
        for collection in before:
            collection.objects.link(obj)

    rollback.callback(restore)


def _set_parent(obj: Any, name: str | None, rollback: _Rollback) -> None:
    """Set or clear the parent of an object, and keep its world matrix; `name` is the parent's."""
    bpy.context.view_layer.update()
    world = obj.matrix_world.copy()
    _remember_channels(obj, rollback)
    rollback.set(obj, "matrix_parent_inverse", Matrix.Identity(4))
    rollback.set(obj, "parent", None if name is None else bpy.context.view_layer.objects[name])
    bpy.context.view_layer.update()
    obj.matrix_world = world


def _remember_channels(obj: Any, rollback: _Rollback) -> None:
    for name in CHANNELS:
        rollback.set(obj, name, getattr(obj, name))


def _move_to_pose(plan: SensorChange, obj: Any, rollback: _Rollback) -> None:
    """Move an object to the pose that the layout gives, and keep its scale."""
    assert plan.origin is not None and plan.axes is not None
    origin = (plan.origin / unit_scale(bpy.context.scene)).tolist()
    _remember_channels(obj, rollback)
    delta = any(obj.delta_location) or any(obj.delta_rotation_euler)
    if obj.parent is None and obj.rotation_mode == "XYZ" and not delta:
        obj.location = origin
        if plan.angles:
            obj.rotation_euler = plan.angles
        return
    bpy.context.view_layer.update()
    turned = Matrix(plan.axes.tolist()).to_4x4()
    size = Matrix.Diagonal((*obj.matrix_world.to_scale(), 1.0))
    wanted = Matrix.Translation(origin) @ turned @ size
    if not _close(wanted, obj.matrix_world):
        obj.matrix_world = wanted


def _close(a: Matrix, b: Matrix) -> bool:
    difference = np.abs(np.array(a) - np.array(b))
    return bool((difference <= 1e-6 * np.maximum(1.0, np.abs(np.array(a)))).all())


def _check_done(plans: list[SensorChange]) -> None:
    """Raise `InputError` if a change had no effect, for example because a channel is locked."""
    view_layer = bpy.context.view_layer
    view_layer.update()
    again = Planner(Layout([]), view_layer, evaluated_depsgraph())
    empties = {id(empty) for plan in plans for empty in plan.empties}
    for plan in _with_empties(plans):
        values = {key: value for key, value in plan.entry.values.items() if key not in CHECKED_ELSE}
        entry = LayoutEntry(plan.entry.file, values, plan.entry.lines)
        is_empty = id(plan) in empties
        sensor = again.empty(entry, plan.kind).sensor if is_empty else again.sensor(entry)
        if sensor is None:
            raise plan.entry.error(
                "its collection is not in the view layer: tick the collection in the Outliner, or "
                "give another one",
                "collection",
            )
        left = again.empty(entry, plan.kind) if is_empty else again.change(entry)
        what = [*left.settings, *left.parameters, *left.moves]
        what += ["place"] if plan.displaced and not again.has_new_pose(plan, sensor) else []
        if what:
            raise plan.entry.error(
                f"Blender did not set its {', '.join(what)}, which may be locked, driven, "
                "constrained or not overridable: unlock it, or leave it out of the layout"
            )


def _delete(sensor: Sensor) -> bool:
    """Delete a sensor's object and its children, except children that are sensors.

    If the object is more than a sensor, such as furniture, it stays and is no longer a sensor.
    Return False for such an object, else True.
    """
    obj = sensor.object
    if not _is_only_sensor(sensor):
        obj.angen_sensor.kind = NO_KIND
        return False
    below = [child for child in obj.children_recursive if not is_sensor(child)]
    bpy.context.view_layer.update()
    for child in set(obj.children_recursive) - set(below):
        world = child.matrix_world.copy()
        child.parent = None
        child.matrix_world = world
    for part in [*below, obj]:
        bpy.data.objects.remove(part)
    return True


# Data-blocks that use an object or a text only to contain or to show it.
SHOW = ("Collection", "Scene", "Screen", "WindowManager", "WorkSpace")


def _delete_unused(blocks: set[Any]) -> None:
    """Delete the empties and texts among `blocks` that nothing uses any more."""
    users = bpy.data.user_map(subset=blocks) if blocks else {}
    for block in blocks:
        used = any(type(user).__name__ not in SHOW for user in users[block])
        if isinstance(block, bpy.types.Text):
            unused = bpy.data.texts
        elif block.angen_place.use != "NONE":
            continue
        else:
            unused = bpy.data.objects
        if not used:
            unused.remove(block)


def _is_only_sensor(sensor: Sensor) -> bool:
    """Return whether an object is nothing but a sensor, not furniture that also serves as one.

    This is so for an empty, for a mesh without faces, and for a mesh of the size of a housing of
    the sensor's kind.
    """
    if sensor.object.type != "MESH":
        return bool(sensor.object.type == "EMPTY")
    box = face_bounds(sensor.object.data)
    if box is None:
        return True
    return _housing_of_size(sensor.kind, box * unit_scale(bpy.context.scene)) is not None
