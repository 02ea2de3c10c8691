# SPDX-License-Identifier: GPL-3.0-or-later
"""A temporary scene to render light in, with the objects that the viewport shows.

It has Blender's factory settings. Stand-ins (`Frozen`, `Instances`) replace objects that it cannot
show unchanged. The user's scene, objects and settings are never changed. The temporary scene is at
the same frame as the user's scene, and a render evaluates it again at that frame. So neither
earlier frames nor unapplied changes of the view have an influence.
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
from ...process.system import standard_output_silenced
from ..animation import is_animated
from ..facts import facts_of
from ..instances import is_holder, shown_in, shown_objects
from ..marks import LIGHT_MARK
from ..sensors import unit_scale
from ..timed import FILM_SOURCES, INSTANCING_MODIFIERS, is_simulated
from ..units import light_factor, peak_power
from .changes import SEEN_OF_OBJECT, object_values
from .materials import Panes, glass_of, glows

# Simulated objects: plain objects with their present shape replace them in a light scene.
#
# A copy of a rigid body or constraint would join the user's simulation, and void its cache. The
# original itself would not be simulated in a light scene, and would be at a wrong place.

SHAPES = {"MESH", "CURVE", "SURFACE", "FONT", "META"}


class Simulated:
    """The objects that physics moves, holds or deforms, and all objects that depend on these.

    Dependence is by parent, and by the targets of constraints and modifiers.
    """

    def __init__(self) -> None:
        self._known: dict[int, bool] = {}

    def look_again(self) -> None:
        """Forget which objects are in the set. Call this after an edit of the file."""
        self._known.clear()

    def __contains__(self, obj: Any) -> bool:
        uid = obj.session_uid
        if uid not in self._known:
            # An object that follows itself is not simulated for that reason.
            self._known[uid] = False
            self._known[uid] = (
                obj.rigid_body is not None
                or obj.rigid_body_constraint is not None
                or any(map(is_simulated, obj.modifiers))
                or any(target in self for target in _dependencies(obj))
            )
        return self._known[uid]


def _dependencies(obj: Any) -> Iterator[Any]:
    """Yield the objects on which an object depends by its parent, constraints and modifiers."""
    for owner in (*obj.constraints, *obj.modifiers):
        target = getattr(owner, "target", None) or getattr(owner, "object", None)
        if isinstance(target, bpy.types.Object):
            yield target
    if obj.parent is not None:
        yield obj.parent


class Frozen:
    """Copies that replace an object and its instances in renders, with the present pose and look.

    The attribute `made` has the copies.

    Parameters
    ----------
    obj
        The user's object.
    depsgraph
        The evaluated depsgraph.
    own
        A function that registers a new datablock and returns it.
    has_instances
        Whether geometry nodes of the object make instances.
    """

    def __init__(
        self, obj: Any, depsgraph: Any, own: Callable[[Any], Any], has_instances: bool = False
    ) -> None:
        self._obj = obj
        evaluated = obj.evaluated_get(depsgraph)
        self.made = [_placed(_stand_in(obj, evaluated, depsgraph, own), evaluated.matrix_world)]
        self._has_instances = has_instances or (obj.type in SHAPES and obj.is_instancer)
        self._seen = _look_and_shape(evaluated)
        if self._has_instances:
            if obj.is_instancer and not obj.show_instancer_for_render:
                self.made.clear()
            self.made += _instances(obj, depsgraph, own)

    def follow(self, depsgraph: Any) -> bool:
        """Move the copies to the present poses; return False if they must be made again.

        They must be made again if the shape or look has changed, or if there are instances. If only
        the mesh of an object were exchanged, Cycles would sometimes keep the earlier one.
        """
        evaluated = self._obj.evaluated_get(depsgraph)
        if self._has_instances or _look_and_shape(evaluated) != self._seen:
            return False
        if self.made[0].matrix_world != evaluated.matrix_world:
            self.made[0].matrix_world = evaluated.matrix_world
        return True


def _look_and_shape(evaluated: Any) -> tuple[str, Any]:
    """Return values for comparison: all settings that change an object's look, and its whole shape.

    For curves, text and metaballs, the shape never equals another.
    """
    looks = repr(object_values(evaluated))
    if evaluated.type == "MESH":
        return looks, repr(facts_of(evaluated.data))
    return looks, object() if evaluated.type in SHAPES else None


def _stand_in(obj: Any, evaluated: Any, depsgraph: Any, own: Callable[[Any], Any]) -> Any:
    if obj.type in SHAPES:
        return _copy_with(evaluated, _shape(evaluated, depsgraph, own), own)
    if obj.rigid_body_constraint is not None:
        made = _copy_with(evaluated, obj.data, own)
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
    """Return copies of all instances that an object makes."""
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
        made.append(_placed(_copy_with(shown, data, own), instance.matrix_world.copy()))
    return made


def _shape(evaluated: Any, depsgraph: Any, own: Callable[[Any], Any]) -> Any:
    return own(
        bpy.data.meshes.new_from_object(
            evaluated, preserve_all_data_layers=True, depsgraph=depsgraph
        )
    )


def _copy_with(evaluated: Any, data: Any, own: Callable[[Any], Any]) -> Any:
    """Return a new object with `data` and all settings of an object that light depends on."""
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
    """Return the custom properties of a datablock that are numbers, texts or lists of numbers."""
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


# Display types of helpers such as cutters of booleans, which should not cast shadows.
LINES = {"WIRE", "BOUNDS"}
# Resolutions of the world's importance map: without an image or a sky, the world is smooth.
SMOOTH_MAP = 64
DETAILED_MAP = 1024
DETAILED = {"TEX_ENVIRONMENT", "TEX_SKY", "TEX_IMAGE", "GROUP"}
# Frames of the user's scene in a frame of the light scene. Blender's sound system copies the
# camera's places at all earlier frames at each new frame: that takes milliseconds late in a day.
LONG = 512
MADE = ("scenes", "collections", "objects", "meshes", "materials", "cameras", "lights", "worlds")
# Handlers of the user and of other add-ons, which would take our renders for the user's.
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
# Twins are tiny and below the scene, whose bounds hardly grow.
TWINS_PLACE, TWINS_SCALE = (0.0, 0.0, -10.0), 1e-6
# Rays that do not see twins. Cycles leaves out objects that no ray sees, so rays scattered in fog
# may still hit one.
TWINS_RAYS = ("camera", "diffuse", "glossy", "transmission", "shadow")


class LightScene:
    """Context manager: on entry, make a temporary scene to render light in; on exit, remove it.

    Use it inside `quietly`. All datablocks registered by `own` are removed on exit, also after an
    error.

    Attributes
    ----------
    scene
        The temporary scene; its `view_layer` is the one to render.
    notes
        Texts for the user about what the scene cannot show as it is.
    frozen
        The copies (`Frozen`) of objects that the scene cannot show unchanged.
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
        # Cycles counts the images of films by the frames of the rendered scene.
        self._has_films = any(image.source in FILM_SOURCES for image in bpy.data.images)

    @property
    def view_layer(self) -> Any:
        """The view layer to render."""
        return self.scene.view_layers[0]

    def own(self, datablock: Any) -> Any:
        """Register a datablock that was made for the light scene, and return it."""
        datablock[LIGHT_MARK] = True
        self._made.append(datablock)
        return datablock

    def disown(self, *datablocks: Any) -> None:
        """Remove some of the datablocks that `own` has registered."""
        for datablock in datablocks:
            self._made.remove(datablock)
        bpy.data.batch_remove(datablocks)

    def __enter__(self) -> LightScene:
        with ExitStack() as undo:
            undo.callback(self.close)
            # A copy of the user's scene would have all of its settings.
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
        """Remove all datablocks that were made for the light scene."""
        made, self._made = self._made, []
        if self.scene is not None and _alive(self.scene):
            # Free Cycles's data now: Blender 4.2 crashes if it frees them when it ends.
            self.scene.render.use_persistent_data = False
        self.scene = None
        # The "Render Result" that a render leaves, where there was none.
        left = [i for i in bpy.data.images if i.session_uid not in self._images]
        made += [image for image in left if image.type == "RENDER_RESULT"]
        # If another file was opened, the datablocks are gone already.
        bpy.data.batch_remove([d for d in made if _alive(d)])

    def _begin(self) -> None:
        self.scene.camera = self._user_scene.camera
        # Off in new scenes, unlike in new files.
        self.scene.eevee.use_shadows = True

    def move_frozen_copies(self) -> bool:
        """Move the copies in `frozen` to their present poses; return False if one is outdated."""
        return all(found.follow(self._user_layer.depsgraph) for found in self.frozen)

    def follow(self, reference: int | None = None) -> None:
        """Set the frame, and copy the settings of the user's scene that drivers and nodes read.

        `reference` is the frame at which a reference is rendered; None for the present frame.
        Frozen objects and animated custom properties are known only at the present frame. A
        reference leaves them out.
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
        # `frame_current` alone would leave the subframe unchanged.
        frame = user.frame_float if reference is None else float(reference)
        if scene.render.frame_map_old == scene.render.frame_map_new and not self._has_films:
            scene.render.frame_map_old, scene.render.frame_map_new = LONG, 1
            # LONG is a power of two: the division is exact.
            frame /= LONG
        if frame < 0.0:
            # Only `frame_set` accepts negative frames whatever the user's preferences are.
            whole = math.floor(frame)
            with _handlers_quiet():
                scene.frame_set(whole, subframe=frame - whole)
        elif scene.frame_float != frame:
            scene.frame_float = frame

    def _show(self) -> None:
        """Add the objects that the viewport shows, even those that are hidden in renders."""
        # Link objects before a scene has the collection: otherwise each one updates the scene.
        shown = self.own(bpy.data.collections.new(".angen_light"))
        housings = Housings()
        self._by_nodes = instancing_lamps_by_nodes(self._user_scene, self._user_layer.depsgraph)
        panes = Panes(self._user_scene, self._user_layer.depsgraph, self.own)
        instances = Instances(self.own, self._user_scene, housings, panes)
        for obj in list(shown_objects(self._user_layer)):
            if not is_left_out(obj, housings):
                for seen in self._stand_ins(obj):
                    shown.objects.link(instances.stand_in(seen, is_copy=seen != obj))
        shown.objects.link(twins(list(shown.objects), self.own))
        # Hide them in viewports: operators called from Python evaluate the viewport first.
        shown.hide_viewport = True
        self.scene.collection.children.link(shown)

    def _stand_ins(self, obj: Any) -> Iterator[Any]:
        if is_portal(obj) and self._user_scene.world is None:
            # Blender 5.2 crashes with a portal and no world.
            return
        made = [obj]
        by_nodes = obj in self._by_nodes
        if by_nodes or must_be_frozen(obj, self._simulated):
            self.frozen.append(Frozen(obj, self._user_layer.depsgraph, self.own, by_nodes))
            made = self.frozen[-1].made
        for seen in made:
            if seen.type != "LIGHT" or is_portal(seen):
                yield seen
            elif (lamp := self._lamp(obj, seen)) is not None:
                yield lamp

    def _lamp(self, obj: Any, lamp: Any) -> Any | None:
        """Return the object that represents a lamp in the light scene; None to leave it out.

        `obj` is the user's lamp. `lamp` is the same object, or a copy that was made for this scene.
        """
        return brightened(lamp, self._user_scene, self.own)

    def _world(self) -> None:
        """Limit the size of the world's importance map, which Cycles computes at each start."""
        world = self.scene.world = self._user_scene.world
        if world is None or getattr(world.cycles, "sampling_method", "") != "AUTOMATIC":
            return
        nodes = world.node_tree.nodes if world.node_tree else ()
        detailed = any(node.type in DETAILED for node in nodes)
        world = self.scene.world = self.own(world.copy())
        world.cycles.sampling_method = "MANUAL"
        world.cycles.sample_map_resolution = DETAILED_MAP if detailed else SMOOTH_MAP


def _take_over(of: Any, to: Any, *names: str) -> None:
    """Copy the settings `names` from `of` to `to` if they differ.

    Blender evaluates the scene again after each assignment, even of an equal value.
    """
    for name in names:
        if getattr(to, name) != getattr(of, name):
            setattr(to, name, getattr(of, name))


def contents(scene: Any, view_layer: Any, simulated: Simulated) -> Hashable:
    """Return a hashable value that is equal for equal contents of a light scene.

    The contents are the world, and the objects that a light scene would have.
    """
    housings = Housings()
    by_nodes = instancing_lamps_by_nodes(scene, view_layer.depsgraph)
    # One a material, within this call; without this cache each slot of each object takes 20 µs.
    glass = cache(glass_of)
    shown = tuple(
        (obj.session_uid, obj in by_nodes, must_be_frozen(obj, simulated), *_glass(obj, glass))
        for obj in shown_objects(view_layer)
        if not is_left_out(obj, housings)
    )
    return scene.world.session_uid if scene.world else 0, shown, _brightness(scene)


def _glass(obj: Any, glass: Callable[[Any], Hashable]) -> Iterator[Hashable]:
    """Yield the glass of an object's materials. The function `glass` reads it from a material."""
    for slot in obj.material_slots:
        made_of = slot.material and glass(slot.material)
        if made_of:
            yield made_of


def is_left_out(obj: Any, housings: Housings) -> bool:
    """Return whether an object is left out of light scenes."""
    if obj.angen_ignored or obj in housings:
        return True
    return bool(obj.hide_render and obj.type != "LIGHT" and obj.display_type in LINES)


def must_be_frozen(obj: Any, simulated: Simulated) -> bool:
    """Return whether an object needs a stand-in that keeps its present shape and place."""
    return obj.hide_render or obj in simulated


def instancing_lamps_by_nodes(scene: Any, depsgraph: Any) -> set[Any]:
    """Return the objects whose nodes instance lamps that a light scene must make brighter.

    Nodes name the user's lamps, so that these objects need copies of the instances.
    """
    if unit_scale(scene) == 1.0:
        return set()
    return {
        one.parent.original
        for one in depsgraph.object_instances
        if one.is_instance
        and one.object.type == "LIGHT"
        and not (is_holder(one.parent.original) or one.parent.original.is_instancer)
    }


def is_portal(obj: Any) -> bool:
    """Return whether an object is a Cycles light portal.

    A light portal is a dark area lamp that guides rays to the world.
    """
    return bool(obj.type == "LIGHT" and obj.data.type == "AREA" and obj.data.cycles.is_portal)


class Housings:
    """The set of light sensors and their descendants, which would shade the sensors.

    They are left out for all light sensors, so that none changes the light of another. Lamps are
    never in the set.
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
    """Context manager: on entry, silence standard output and handlers; on exit, restore both."""
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


def remove_leftover_scenes() -> None:
    """Remove light scenes that remain in a file or undo step which was saved during a run."""
    if any(LIGHT_MARK in scene for scene in bpy.data.scenes):
        left = [d for group in MADE for d in getattr(bpy.data, group) if LIGHT_MARK in d]
        bpy.data.batch_remove(left)


def _alive(datablock: Any) -> bool:
    try:
        return datablock.session_uid != 0
    except ReferenceError:
        return False


class Instances:
    """Makes stand-ins, which replace panes and collection instances in a light scene.

    Panes of a stand-in let light pass. Housings, which would shade their light sensors, are left
    out of collection instances. Lamps in these are as bright as they are in metres.

    Parameters
    ----------
    own
        A function that registers a new datablock and returns it.
    scene
        The user's scene.
    housings
        The objects to leave out.
    panes
        Makes the stand-ins for panes.
    """

    def __init__(
        self, own: Callable[[Any], Any], scene: Any, housings: Container[Any], panes: Panes
    ) -> None:
        self._own = own
        self._scene = scene
        self._housings = housings
        self._panes = panes
        self._differs: dict[Any, bool] = {}
        self._made: dict[Any, Any] = {}

    def stand_in(self, obj: Any, is_copy: bool = False) -> Any:
        """Return an object, or a copy of it without housings and with panes that let light pass.

        An object that has neither is returned as it is. If `is_copy`, the object was made for this
        scene, and is changed itself.
        """
        if not is_holder(obj):
            return self._panes.stand_in(obj, is_copy)
        if not self._is_changed(obj.instance_collection):
            return obj
        copy = obj if is_copy else self._own(obj.copy())
        copy.instance_collection = self._without_housings(obj.instance_collection)
        return copy

    def _is_changed(self, collection: Any) -> bool:
        if collection not in self._differs:
            # In a damaged file a collection may contain itself.
            self._differs[collection] = False
            self._differs[collection] = any(
                obj in self._housings
                or self._panes.is_pane(obj)
                or (obj.type == "LIGHT" and light_factor(obj.data, self._scene) != 1.0)
                or (is_holder(obj) and self._is_changed(obj.instance_collection))
                for obj in shown_in(collection)
            )
        return self._differs[collection]

    def _without_housings(self, collection: Any) -> Any:
        if collection not in self._made:
            made = self._made[collection] = self._own(bpy.data.collections.new(".angen_light"))
            made.instance_offset = collection.instance_offset
            for obj in shown_in(collection):
                if obj.type == "LIGHT":
                    made.objects.link(brightened(obj, self._scene, self._own))
                elif obj not in self._housings:
                    made.objects.link(self.stand_in(obj))
        return self._made[collection]


def brightened(lamp: Any, scene: Any, own: Callable[[Any], Any]) -> Any:
    """Return a lamp, or a copy of it that gives a render the light that the lamp gives in metres.

    Its colour is multiplied, so that the copy still follows the animation of its power.
    """
    factor = light_factor(lamp.data, scene)
    if factor == 1.0:
        return lamp
    copy = own(lamp.copy())
    copy.data = own(lamp.data.copy())
    copy.data.color = [factor * part for part in copy.data.color]
    return copy


def _brightness(scene: Any) -> Hashable:
    """Return what the copies that `brightened` makes of a scene's lamps depend on."""
    if unit_scale(scene) == 1.0:
        return ()
    lamps = [data for data in bpy.data.lights if LIGHT_MARK not in data]
    return tuple((d.session_uid, light_factor(d, scene), peak_power(d), *d.color) for d in lamps)


def twins(objects: Iterable[Any], own: Callable[[Any], Any]) -> Any:
    """Return an object that shows some of `objects` a second time, where hardly a ray sees them.

    This saves time at each picture. In a background render, Cycles puts all meshes that are shown
    once into one BVH tree. It builds this tree again if anything moves. A mesh that is shown twice
    has a separate tree, which Cycles keeps. `own` is a function that registers each new datablock.
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
    # Cycles sends rays to glowing objects and volumes wherever they are.
    return not any(glows(material) or _has_volume(material) for material in materials)


def _has_volume(material: Any) -> bool:
    tree = material.node_tree
    return tree is not None and any(
        node.type == "OUTPUT_MATERIAL" and node.inputs["Volume"].is_linked for node in tree.nodes
    )


def store_part_starts(scene: Any, frames: Sequence[int]) -> None:
    """Store the frames at which references of the light are traced, for `reference_frames`.

    The first is the first frame of the run. In a day, the first frame of each part follows.
    """
    scene[BEGINS] = list(frames)


def remove_part_starts(scene: Any) -> None:
    """Remove the frames that `store_part_starts` stored."""
    scene.pop(BEGINS, None)


def reference_frames(scene: Any, frame: float) -> tuple[int, int]:
    """Return the two frames whose references of the light can be used at `frame`.

    They are the first frame of all, and the first frame of the part of the day that `frame` is in.
    """
    begins = scene.get(BEGINS, [scene.frame_start])
    return int(begins[0]), int(begins[max(bisect_right(begins, frame) - 1, 0)])
