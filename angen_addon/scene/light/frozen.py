# SPDX-License-Identifier: GPL-3.0-or-later
"""What a light scene cannot show as it is: plain objects with its present shape stand for it.

They are no copies: of a rigid body, or of what ties some together, Blender would take the copy into
the user's own simulation, and throw its cache away. Nor is the original put into a light scene,
where that simulation does not run: it would stand where nothing moved it, and what it depends on
would be evaluated beside the user's.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import bpy

from ..facts import facts_of
from ..timed import is_simulated
from .changes import OF_OBJECT, object_values, own_properties

SHAPES = {"MESH", "CURVE", "SURFACE", "FONT", "META"}


class Simulated:
    """Membership: objects that Blender's physics moves, ties or shapes, and what follows them."""

    def __init__(self) -> None:
        self._known: dict[int, bool] = {}

    def look_again(self) -> None:
        self._known.clear()

    def __contains__(self, obj: Any) -> bool:
        uid = obj.session_uid
        if uid not in self._known:
            # What follows itself is not simulated for that.
            self._known[uid] = False
            self._known[uid] = (
                obj.rigid_body is not None
                or obj.rigid_body_constraint is not None
                or any(map(is_simulated, obj.modifiers))
                or any(target in self for target in _followed(obj))
            )
        return self._known[uid]


def _followed(obj: Any) -> Iterator[Any]:
    """What its parent, constraints and modifiers let it depend on."""
    for owner in (*obj.constraints, *obj.modifiers):
        target = getattr(owner, "target", None) or getattr(owner, "object", None)
        if isinstance(target, bpy.types.Object):
            yield target
    if obj.parent is not None:
        yield obj.parent


class Frozen:
    """New objects, `made`, that stand and look as `obj`, and what it makes instances of, do now,
    and that renders show. `own`: takes charge of what is made."""

    def __init__(self, obj: Any, depsgraph: Any, own: Callable[[Any], Any]) -> None:
        self._obj = obj
        evaluated = obj.evaluated_get(depsgraph)
        self.made = [_placed(_stand_in(obj, evaluated, depsgraph, own), evaluated.matrix_world)]
        self._has_instances = obj.type in SHAPES and obj.is_instancer
        self._seen = _seen(evaluated)
        if self._has_instances:
            if not obj.show_instancer_for_render:
                self.made.clear()
            self.made += _instances(obj, depsgraph, own)

    def follow(self, depsgraph: Any) -> bool:
        """Brings them to the present moment; whether that could be done. What stands costs
        nothing, and what moves its matrix. A new shape needs new objects: where the mesh of one is
        exchanged, Cycles now and then goes on with the one before."""
        evaluated = self._obj.evaluated_get(depsgraph)
        if self._has_instances or _seen(evaluated) != self._seen:
            return False
        if self.made[0].matrix_world != evaluated.matrix_world:
            self.made[0].matrix_world = evaluated.matrix_world
        return True


def _seen(evaluated: Any) -> tuple[str, Any]:
    """How it looks, and its whole shape: of one that is no mesh it is never the same."""
    looks = repr(object_values(evaluated))
    if evaluated.type == "MESH":
        return looks, repr(facts_of(evaluated.data))
    return looks, object() if evaluated.type in SHAPES else None


def _stand_in(obj: Any, evaluated: Any, depsgraph: Any, own: Callable[[Any], Any]) -> Any:
    if obj.type in SHAPES:
        return _like(evaluated, _shape(evaluated, depsgraph, own), own)
    if obj.rigid_body_constraint is not None:
        made = _like(evaluated, obj.data, own)
        made.instance_type, made.instance_collection = obj.instance_type, obj.instance_collection
        return made
    copy = own(obj.copy())
    copy.animation_data_clear()
    copy.constraints.clear()
    copy.parent = None
    return copy


def _placed(made: Any, matrix: Any) -> Any:
    made.hide_render = False
    made.matrix_world = matrix
    return made


def _instances(obj: Any, depsgraph: Any, own: Callable[[Any], Any]) -> list[Any]:
    """What its nodes, particles or vertices carry."""
    made = []
    shapes: dict[int, Any] = {}
    for instance in depsgraph.object_instances:
        if not instance.is_instance or instance.parent.original != obj:
            continue
        shown = instance.object
        if shown.type in SHAPES:
            key = shown.data.as_pointer() if shown.data is not None else shown.as_pointer()
            if key not in shapes:
                shapes[key] = _shape(shown, depsgraph, own)
            data = shapes[key]
        elif shown.type == "LIGHT":
            data = shown.data.original
        else:
            continue
        made.append(_placed(_like(shown, data, own), instance.matrix_world.copy()))
    return made


def _shape(evaluated: Any, depsgraph: Any, own: Callable[[Any], Any]) -> Any:
    return own(
        bpy.data.meshes.new_from_object(
            evaluated, preserve_all_data_layers=True, depsgraph=depsgraph
        )
    )


def _like(evaluated: Any, data: Any, own: Callable[[Any], Any]) -> Any:
    """A new object with that data and all of an object that light can depend on."""
    made = own(bpy.data.objects.new(".angen_light", data))
    for name in OF_OBJECT:
        setattr(made, name, getattr(evaluated, name))
    for prop in evaluated.cycles.bl_rna.properties:
        if not prop.is_readonly:
            setattr(made.cycles, prop.identifier, getattr(evaluated.cycles, prop.identifier))
    for key, value in own_properties(evaluated).items():
        made[key] = value
    linking = evaluated.light_linking
    for name in ("receiver_collection", "blocker_collection"):
        collection = getattr(linking, name)
        setattr(made.light_linking, name, collection.original if collection else None)
    _give_materials(made, evaluated)
    return made


def _give_materials(made: Any, evaluated: Any) -> None:
    for ours, theirs in zip(made.material_slots, evaluated.material_slots, strict=False):
        ours.link = "OBJECT"
        ours.material = theirs.material.original if theirs.material else None
