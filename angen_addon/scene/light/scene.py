# SPDX-License-Identifier: GPL-3.0-or-later
"""A temporary scene to render light in: what the viewport shows, with Blender's factory settings.
Stand-ins (`Frozen`, `Instances`) take the place of what it cannot show as it is.

The user's own scene, objects and settings are never written to. The scene made here stands at the
frame at which the user's stands; a render evaluates it anew there, so neither the frames before
it nor unapplied changes of the view matter.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Container, Hashable, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from functools import cache
from typing import Any

import bpy
from mathutils import Matrix

from ....sensor_logic.kind import LIGHT
from ....sensor_logic.kinds import KINDS
from ...process.standalone import standard_output_silenced
from ..animation import is_animated
from ..changes import SEEN_OF_OBJECT, object_values
from ..facts import facts_of
from ..instances import is_holder, shown_in, shown_objects
from ..marks import LIGHT_MARK
from ..timed import FILM_SOURCES, INSTANCING_MODIFIERS, is_simulated
from .materials import Panes, glass_of, glows

# What a light scene cannot show as it is: plain objects with its present shape stand for it.
#
# They are no copies: of a rigid body, or of what ties some together, Blender would take the copy
# into the user's own simulation, and throw its cache away. Nor is the original put into a light
# scene, where that simulation does not run: it would stand where nothing moved it, and what it
# depends on would be evaluated beside the user's.

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
    for name in SEEN_OF_OBJECT:
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


def own_properties(owner: Any) -> dict[str, Any]:
    """Its custom properties, but groups of them: numbers, texts and rows of numbers."""
    found = {}
    for key, value in sorted(owner.items()):
        if isinstance(value, (bool, int, float, str)):
            found[key] = value
        elif hasattr(value, "to_list"):
            found[key] = value.to_list()
    return found


def _give_materials(made: Any, evaluated: Any) -> None:
    for ours, theirs in zip(made.material_slots, evaluated.material_slots, strict=False):
        ours.link = "OBJECT"
        ours.material = theirs.material.original if theirs.material else None


# Shown only as lines: helpers such as cutters of booleans, which no user expects to cast shadows.
LINES = {"WIRE", "BOUNDS"}
# Unless an image or a sky says where the light is, the world is smooth.
SMOOTH_MAP = 64
DETAILED_MAP = 1024
DETAILED = {"TEX_ENVIRONMENT", "TEX_SKY", "TEX_IMAGE", "GROUP"}
# A frame of the scene takes as many of the user's. Blender's sound keeps the camera's place at
# every frame from 0 on, and copies all of them at each new one: milliseconds late in a day.
LONG = 512
MADE = ("scenes", "collections", "objects", "meshes", "materials", "cameras", "lights", "worlds")
# Handlers of the user and of other add-ons take renders for the user's own.
HANDLERS = (
    "depsgraph_update_post",
    "depsgraph_update_pre",
    "frame_change_post",
    "frame_change_pre",
    "object_bake_cancel",
    "object_bake_complete",
    "object_bake_pre",
    "render_cancel",
    "render_complete",
    "render_init",
    "render_post",
    "render_pre",
    "render_stats",
    "render_write",
)
# Custom property of a scene: the first frames of its parts, from the first to the last.
BEGINS = "angen_light_begins"
# Twins are tiny and out of the way: the bounds of the scene hardly grow.
TWINS_PLACE, TWINS_SCALE = (0.0, 0.0, -10.0), 1e-6
# What no ray at all sees, Cycles leaves out: those that fog scatters might meet such a speck.
TWINS_RAYS = ("camera", "diffuse", "glossy", "transmission", "shadow")


class LightScene:
    """A context: `scene` and `view_layer` to render, `notes` on what could not be carried over.

    Datablocks made by `own` are removed at the end, also after an error. To be used `quietly`.
    """

    def __init__(self, scene: Any, view_layer: Any, simulated: Simulated | None = None) -> None:
        self._user_scene = scene
        self._user_layer = view_layer
        self._simulated = simulated or Simulated()
        self._made: list[Any] = []
        self._images = {image.session_uid for image in bpy.data.images}
        self.notes: list[str] = []
        self.scene: Any = None
        self.frozen: list[Frozen] = []
        # Cycles counts their pictures by the scene's own frames.
        self._has_films = any(image.source in FILM_SOURCES for image in bpy.data.images)

    @property
    def view_layer(self) -> Any:
        return self.scene.view_layers[0]

    def own(self, datablock: Any) -> Any:
        datablock[LIGHT_MARK] = True
        self._made.append(datablock)
        return datablock

    def disown(self, *datablocks: Any) -> None:
        """Removes what was made by `own` and is of no use any more."""
        for datablock in datablocks:
            self._made.remove(datablock)
        bpy.data.batch_remove(datablocks)

    def __enter__(self) -> LightScene:
        with ExitStack() as undo:
            undo.callback(self.close)
            # Not a copy: that would bring every setting of the user's along.
            self.scene = self.own(bpy.data.scenes.new(".angen_light"))
            self._begin()
            self.follow()
            self._show()
            self._world()
            undo.pop_all()
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

    def close(self) -> None:
        made, self._made = self._made, []
        if self.scene is not None and _alive(self.scene):
            # What Cycles kept is freed now, and not when Blender ends: 4.2 crashes then.
            self.scene.render.use_persistent_data = False
        self.scene = None
        # The "Render Result" that a render leaves, where there was none.
        left = [i for i in bpy.data.images if i.session_uid not in self._images]
        made += [image for image in left if image.type == "RENDER_RESULT"]
        # A run may end because another file was opened: then they are gone already.
        bpy.data.batch_remove([d for d in made if _alive(d)])

    def _begin(self) -> None:
        """Sets up the new scene."""
        self.scene.camera = self._user_scene.camera
        # Off in new scenes, unlike in new files.
        self.scene.eevee.use_shadows = True

    def follow_frozen(self) -> bool:
        """Gives frozen copies their originals' present pose; False where one cannot follow."""
        return all(found.follow(self._user_layer.depsgraph) for found in self.frozen)

    def follow(self, reference: int | None = None) -> None:
        """Sets the frame, and copies the user scene's settings that drivers and nodes read.

        `reference`: the frame of one, instead of the present one; what is known only at the present
        frame (frozen copies, animated custom properties) is hidden or left out.
        """
        user, scene = self._user_scene, self.scene
        self._take_over_time(user, reference)
        for found in self.frozen if reference is not None else ():
            for made in found.made:
                made.hide_render = True
        _take_over(user.unit_settings, scene.unit_settings, "system", "scale_length")
        for of, to, path in (
            (user, scene, ""),
            (self._user_layer, self.view_layer, self._user_layer.path_from_id()),
        ):
            before = own_properties(to)
            for key, value in own_properties(of).items():
                if key == BEGINS:
                    continue
                escaped = bpy.utils.escape_identifier(key)
                if reference is not None and is_animated(user, f'{path}["{escaped}"]'):
                    if key in before:
                        del to[key]
                elif before.get(key) != value:
                    to[key] = value

    def _take_over_time(self, user: Any, reference: int | None) -> None:
        scene = self.scene
        _take_over(user, scene, "frame_start", "frame_end")
        _take_over(user.render, scene.render, "fps", "fps_base", "frame_map_old", "frame_map_new")
        # A whole frame too: setting its number alone leaves the sub-frame as it was.
        frame = user.frame_float if reference is None else float(reference)
        if scene.render.frame_map_old == scene.render.frame_map_new and not self._has_films:
            scene.render.frame_map_old, scene.render.frame_map_new = LONG, 1
            # By a power of two: to the bit.
            frame /= LONG
        if frame < 0.0:
            # Unless the user's preferences allow them, those cannot be set otherwise.
            whole = math.floor(frame)
            with _handlers_quiet():
                scene.frame_set(whole, subframe=frame - whole)
        elif scene.frame_float != frame:
            scene.frame_float = frame

    def _show(self) -> None:
        """Puts in what the viewport shows, whatever is hidden in renders."""
        # Linked while no scene holds the collection: else Blender tags the scene for each object.
        shown = self.own(bpy.data.collections.new(".angen_light"))
        housings = Housings()
        panes = Panes(self._user_scene, self._user_layer.depsgraph, self.own)
        instances = Instances(self.own, housings, panes)
        for obj in list(shown_objects(self._user_layer)):
            if not is_left_out(obj, housings):
                for seen in self._stand_ins(obj):
                    shown.objects.link(instances.stand_in(seen, is_copy=seen != obj))
        shown.objects.link(twins(list(shown.objects), self.own))
        # For renders alone: operators from Python first evaluate what the viewport would show.
        shown.hide_viewport = True
        self.scene.collection.children.link(shown)

    def _stand_ins(self, obj: Any) -> Iterator[Any]:
        """The objects that represent an object in the light scene."""
        if is_portal(obj) and self._user_scene.world is None:
            # It would lead nowhere, and Blender 5.2 crash.
            return
        made = [obj]
        if must_be_frozen(obj, self._simulated):
            self.frozen.append(Frozen(obj, self._user_layer.depsgraph, self.own))
            made = self.frozen[-1].made
        for seen in made:
            if seen.type != "LIGHT" or is_portal(seen):
                yield seen
            elif (lamp := self._lamp(obj, seen)) is not None:
                yield lamp

    def _lamp(self, obj: Any, lamp: Any) -> Any | None:
        """The lamp that represents `lamp` here, or None. `obj`: the user's object, which `lamp`
        is or, made for this scene, stands for."""
        return lamp

    def _world(self) -> None:
        """Bounds the size of the world's importance map, which Cycles computes at each start."""
        world = self.scene.world = self._user_scene.world
        if world is None or getattr(world.cycles, "sampling_method", "") != "AUTOMATIC":
            return
        nodes = world.node_tree.nodes if world.node_tree else ()
        detailed = any(node.type in DETAILED for node in nodes)
        world = self.scene.world = self.own(world.copy())
        world.cycles.sampling_method = "MANUAL"
        world.cycles.sample_map_resolution = DETAILED_MAP if detailed else SMOOTH_MAP


def _take_over(of: Any, to: Any, *names: str) -> None:
    """Copies what differs: Blender evaluates anew whatever is set, even to the same value."""
    for name in names:
        if getattr(to, name) != getattr(of, name):
            setattr(to, name, getattr(of, name))


def contents(scene: Any, view_layer: Any, simulated: Simulated) -> Hashable:
    """The objects that a light scene would hold, and its world, for comparison."""
    housings = Housings()
    # One a material, within this call: without it each slot of each object takes 20 µs.
    glass = cache(glass_of)
    shown = tuple(
        (obj.session_uid, must_be_frozen(obj, simulated), *_glass(obj, glass))
        for obj in shown_objects(view_layer)
        if not is_left_out(obj, housings)
    )
    return scene.world.session_uid if scene.world else 0, shown


def _glass(obj: Any, glass: Callable[[Any], Hashable]) -> Iterator[Hashable]:
    """What a stand-in's material is made from."""
    for slot in obj.material_slots:
        made_of = slot.material and glass(slot.material)
        if made_of:
            yield made_of


def is_left_out(obj: Any, housings: Housings) -> bool:
    if obj.angen_ignored or obj in housings:
        return True
    return bool(obj.hide_render and obj.type != "LIGHT" and obj.display_type in LINES)


def must_be_frozen(obj: Any, simulated: Simulated) -> bool:
    return obj.hide_render or obj in simulated


def is_portal(obj: Any) -> bool:
    """Whether it is a Cycles light portal: a dark area lamp that guides rays to the world."""
    return bool(obj.type == "LIGHT" and obj.data.type == "AREA" and obj.data.cycles.is_portal)


class Housings:
    """Membership: objects that are a light sensor, or hang on one, and would shade it.

    They are left out for all light sensors, so that none reads another light because of how the
    others are measured. Lamps stay.
    """

    def __init__(self) -> None:
        self._known: dict[int, bool] = {}

    def __contains__(self, obj: Any) -> bool:
        return obj.type != "LIGHT" and self._is_part(obj)

    def _is_part(self, obj: Any) -> bool:
        uid = obj.session_uid
        if uid not in self._known:
            kind = KINDS.get(obj.angen_sensor.kind)
            self._known[uid] = (kind is not None and kind.requires(LIGHT)) or (
                obj.parent is not None and self._is_part(obj.parent)
            )
        return self._known[uid]


@contextmanager
def quietly() -> Iterator[None]:
    """Silences the handlers of others and standard output while the sensors' scenes render."""
    with _handlers_quiet(), standard_output_silenced():
        yield


@contextmanager
def _handlers_quiet() -> Iterator[None]:
    lists = [getattr(bpy.app.handlers, n) for n in HANDLERS if hasattr(bpy.app.handlers, n)]
    before = [list(handlers) for handlers in lists]
    for handlers in lists:
        handlers.clear()
    try:
        yield
    finally:
        for handlers, functions in zip(lists, before, strict=True):
            handlers[:] = functions


def remove_left() -> None:
    """Removes light scenes that came back with a file or an undo step that was saved while a run
    used them."""
    if any(LIGHT_MARK in scene for scene in bpy.data.scenes):
        left = [d for group in MADE for d in getattr(bpy.data, group) if LIGHT_MARK in d]
        bpy.data.batch_remove(left)


def _alive(datablock: Any) -> bool:
    try:
        return datablock.session_uid != 0
    except ReferenceError:
        return False


class Instances:
    """Stand-ins for panes that let light pass, and for instances of collections with panes or
    housings of light sensors in them, which would shade these. `own`: takes charge of what is
    made."""

    def __init__(self, own: Callable[[Any], Any], housings: Container[Any], panes: Panes) -> None:
        self._own = own
        self._housings = housings
        self._panes = panes
        self._differs: dict[Any, bool] = {}
        self._made: dict[Any, Any] = {}

    def stand_in(self, obj: Any, is_copy: bool = False) -> Any:
        """The object, or a copy of it that instances the same without housings, or whose panes let
        light pass; `is_copy`: it is one that may be changed."""
        if not is_holder(obj):
            return self._panes.stand_in(obj, is_copy)
        if not self._is_changed(obj.instance_collection):
            return obj
        copy = obj if is_copy else self._own(obj.copy())
        copy.instance_collection = self._without(obj.instance_collection)
        return copy

    def _is_changed(self, collection: Any) -> bool:
        if collection not in self._differs:
            # A damaged file may have it within itself.
            self._differs[collection] = False
            self._differs[collection] = any(
                obj in self._housings
                or self._panes.is_pane(obj)
                or (is_holder(obj) and self._is_changed(obj.instance_collection))
                for obj in shown_in(collection)
            )
        return self._differs[collection]

    def _without(self, collection: Any) -> Any:
        if collection not in self._made:
            made = self._made[collection] = self._own(bpy.data.collections.new(".angen_light"))
            made.instance_offset = collection.instance_offset
            for obj in shown_in(collection):
                if obj not in self._housings:
                    made.objects.link(self.stand_in(obj))
        return self._made[collection]


def twins(objects: Iterable[Any], own: Callable[[Any], Any]) -> Any:
    """Return an object that shows those of `objects` a second time that may be. `own`: takes
    charge of what is made.

    This spares Cycles from building its tree of triangles anew at each picture. In a background
    render Cycles puts all meshes that are shown once into one tree, which is built again whatever
    moved. A mesh that is shown twice has a tree of its own, which is kept. So each is shown a
    second time, where hardly a ray sees it.
    """
    again = own(bpy.data.collections.new(".angen_light"))
    for obj in objects:
        if _may_be_twice(obj):
            again.objects.link(obj)
    holder = own(bpy.data.objects.new(".angen_light", None))
    holder.instance_type, holder.instance_collection = "COLLECTION", again
    tiny = Matrix.Diagonal((TWINS_SCALE, TWINS_SCALE, TWINS_SCALE, 1.0))
    holder.matrix_world = Matrix.Translation(TWINS_PLACE) @ tiny
    for rays in TWINS_RAYS:
        setattr(holder, f"visible_{rays}", False)
    return holder


def _may_be_twice(obj: Any) -> bool:
    if obj.type != "MESH" or obj.instance_type != "NONE":
        return False
    if any(modifier.type in INSTANCING_MODIFIERS for modifier in obj.modifiers):
        return False
    materials = [slot.material for slot in obj.material_slots if slot.material]
    # What glows or fills a space is looked for wherever it is.
    return not any(glows(material) or _fills(material) for material in materials)


def _fills(material: Any) -> bool:
    tree = material.node_tree
    return tree is not None and any(
        node.type == "OUTPUT_MATERIAL" and node.inputs["Volume"].is_linked for node in tree.nodes
    )


def tell_begins(scene: Any, frames: Sequence[int]) -> None:
    """Note at which frames references of light stand: the first of all, and of a day, whose sun
    goes on, the first of each part. So they are the same for whoever asks."""
    scene[BEGINS] = list(frames)


def take_begins(scene: Any) -> None:
    scene.pop(BEGINS, None)


def begins_of(scene: Any, frame: float) -> tuple[int, int]:
    """The frames at which references stand for a frame of a scene: the first of all, and that of
    its part."""
    begins = scene.get(BEGINS, [scene.frame_start])
    return int(begins[0]), int(begins[max(bisect_right(begins, frame) - 1, 0)])
