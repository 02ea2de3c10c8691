# SPDX-License-Identifier: GPL-3.0-or-later
"""List all settings of a datablock as plain values that are equal in every session: its *facts*.

The properties are those that Blender declares (RNA), so that new modifiers and nodes need no code
here. The facts leave out properties of the interface, values that Blender computes, and the outputs
of sensors. They have keyframes and drivers in place of the values that these set.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Container, Iterable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ...sensor_logic.kinds import KINDS, owner_properties
from ...sensor_logic.parameters import specs
from .animation import action_curves, set_by_animation
from .lengths import SUFFIX
from .marks import COVERAGE_MARK

OUTPUTS = {"active", "value"}
OUTPUT_PATHS = {f"angen_sensor.{name}" for name in OUTPUTS}
# Properties without influence on readings: sensors' outputs, rooms and names of presets, the places
# of residents, and the resolution of images, which Blender reads from the image's file.
WITHOUT_INFLUENCE = {
    "AngenSensor": OUTPUTS | {"room", "preset"}, "Image": {"resolution"}, "Object": {"angen_place"},
}  # fmt: skip
# The property with the parameters of each kind. A sensor reads only the property of its kind.
PARAMETERS = frozenset(kind.attribute for kind in KINDS.values())
# Properties that Blender computes; and below, properties that only the interface uses.
DERIVED = {
    "animation_data", "bl_rna", "bound_box", "children", "dimensions", "id_data", "is_evaluated",
    "library", "library_weak_reference", "matrix", "matrix_basis", "matrix_channel",
    "matrix_local", "matrix_world", "name_full", "original", "override_library", "preview",
    "rna_type", "session_uid", "tag", "users", "asset_data", "execution_time", "warning_count",
    "is_missing", "is_runtime_data", "point_cache", "point_caches", "trail_count",
}  # fmt: skip
INTERFACE = {
    "active_index", "active_material", "active_material_index", "active_node", "active_shape_key",
    "active_shape_key_index", "animation_visualization", "color_tag", "description",
    "display_bounds_type", "expanded", "hide_select", "is_expanded", "lineart",
    "location_absolute", "lock", "use_fake_user", "use_extra_user", "user_clear", "width",
    "width_hidden", "warning_propagation",
}  # fmt: skip
if bpy.app.version >= (5, 0):
    # Reading it gives a deprecation warning.
    INTERFACE.add("use_nodes")
# Types whose location, size and colour only describe how they are drawn in an editor.
ON_SCREEN = ("Node", "NodeTree", "NodeSocket", "FCurve", "NlaTrack", "NlaStrip")
# Beginnings of properties of nodes and sockets that have no influence on a shader.
NO_VALUES = (
    "bl_", "display_shape", "enabled", "hide_value", "internal_links", "link_limit", "node",
    "parent", "pin_gizmo", "show_", "type", "use_custom_color",
)  # fmt: skip
# Types of items in long lists, and the properties of each that are read.
POINTS = {
    "Keyframe": (
        "co", "handle_left", "handle_right", "interpolation", "easing", "amplitude", "back",
        "period",
    ),
    "SplinePoint": ("co", "tilt", "radius", "weight"),
    "BezierSplinePoint": ("co", "handle_left", "handle_right", "tilt", "radius"),
    "ShapeKeyPoint": ("co",),
    "ShapeKeyCurvePoint": ("co", "tilt", "radius"),
    "ShapeKeyBezierPoint": ("co", "handle_left", "handle_right", "tilt", "radius"),
    "LatticePoint": ("co_deform",),
    "MetaElement": ("co", "radius", "stiffness"),
}  # fmt: skip
LOOKS = ("lock_", "select", "show_expanded")
MAX_DEPTH = 12
# Increase it if the facts of an unchanged datablock differ from the facts of earlier versions.
FACTS_VERSION = 2

Facts = list[Any]


def facts_of(datablock: Any) -> Facts:
    """Return all settings of a datablock as nested plain values (lists, tuples, numbers, texts).

    Equal settings have equal `repr`.
    """
    if isinstance(datablock, bpy.types.Mesh):
        return mesh_facts(datablock)
    return _object_facts(datablock)


def facts_without(obj: Any, name: str) -> Facts:
    """Return the settings of an object in the form of `facts_of`, without its property `name`."""
    return _object_facts(obj, frozenset((name,)))


def _object_facts(datablock: Any, without: frozenset[str] = frozenset()) -> Facts:
    facts = _Walk(datablock).facts(without)
    if isinstance(datablock, bpy.types.Object) and datablock.type == "MESH":
        # An object has the names of vertex groups, and its mesh the weights.
        facts.append(weights_of(datablock.data) if datablock.vertex_groups else [])
    return facts


def _properties_of_other_kinds(struct: Any) -> frozenset[str]:
    """Return the names of a sensor's parameter groups that belong to other kinds than its own."""
    if type(struct).__name__ != "AngenSensor":
        return frozenset()
    kind = KINDS.get(struct.kind)
    return PARAMETERS - {kind.attribute} if kind else PARAMETERS


def default_owner_properties(
    struct: Any, animated: Container[tuple[int, str]] = frozenset()
) -> frozenset[str]:
    """Return the names of the groups of `Kind.owner_properties` that have all default values.

    They are left out, so that a new kind of sensor changes no facts of earlier files. `animated`
    has the address of the struct and the name of each property that animation sets: such a value is
    no default, at whatever frame.
    """
    found = []
    for made in owner_properties(type(struct).__name__):
        group = getattr(struct, made.attribute)
        known, pointer = group.bl_rna.properties, group.as_pointer()
        if all(
            getattr(group, name) == known[name].default and (pointer, name) not in animated
            for name in specs(made.parameters)
        ):
            found.append(made.attribute)
    return frozenset(found)


def present_facts(evaluated: Any, without: frozenset[str] = frozenset()) -> Facts:
    """Return the values of an evaluated datablock as keyframes and drivers set them at this frame.

    The properties named in `without` are left out.
    """
    return _Walk(evaluated, present=True)._struct(evaluated, 0, without)


class _Walk:
    """Lists the settings of a datablock and of the datablocks embedded in it.

    If `present` is True, it reads animated properties as they are at the present frame. It then
    skips some properties that are the same at every frame.
    """

    def __init__(self, datablock: Any, present: bool = False) -> None:
        self._id = datablock
        self._present = present
        self._seen: set[tuple[int, type]] = set()
        self._set_by_animation = {} if present else dict(set_by_animation(datablock))

    def facts(self, without: frozenset[str] = frozenset()) -> Facts:
        if self._present:
            return self._struct(self._id, 0)
        return [animation_facts(self._id), self._struct(self._id, 0, without)]

    def _struct(self, struct: Any, depth: int, without: frozenset[str] = frozenset()) -> Facts:
        made_of: Any = type(struct)
        key = (struct.as_pointer(), made_of)
        if key in self._seen or depth > MAX_DEPTH:
            # Names of sockets are not unique: the two inputs of a Mix Shader have the same.
            is_socket = isinstance(struct, bpy.types.NodeSocket)
            return [struct.identifier if is_socket else getattr(struct, "name", "")]
        self._seen.add(key)
        found: Facts = []
        left_out = without | _properties_of_other_kinds(struct)
        left_out |= default_owner_properties(struct, self._set_by_animation)
        for name, kind in _reading_plan_of(struct, self._present):
            if name in left_out:
                continue
            value = getattr(struct, name, None)
            if kind == "VALUE":
                found.append(self._masked(key[0], name, value))
            elif kind == "FILE":
                found.append(_file_facts(struct, value, self._id.library))
            elif kind == "POINTER":
                found.append(self._pointer(value, depth))
            elif value is not None:
                found.append(self._items(value, depth))
        found.append(self._custom(struct, key[0]) if _has_custom(made_of) else [])
        return found

    def _masked(self, pointer: int, name: str, value: Any) -> Any:
        """Return a value as plain numbers, with None in place of numbers that animation sets.

        `pointer` is the address of the struct that has the property `name`.
        """
        found = plain(value)
        animated = self._set_by_animation.get((pointer, name)) if self._set_by_animation else None
        if animated is None:
            return found
        if isinstance(found, tuple):
            return tuple(None if i in animated else v for i, v in enumerate(found))
        return None

    def _pointer(self, value: Any, depth: int) -> Any:
        if value is None:
            return None
        if isinstance(value, bpy.types.ID):
            if getattr(value, "is_embedded_data", False) and value != self._id:
                walk = _Walk(value, self._present)
                return walk.facts() if depth < MAX_DEPTH else None
            return value.name_full
        if value.id_data is not None and value.id_data != self._id:
            return getattr(value, "name", "")
        return self._struct(value, depth + 1)

    def _items(self, items: Any, depth: int) -> Any:
        count = len(items)
        if not count:
            return 0
        first = items[0]
        kind = first.rna_type.identifier if first is not None else ""
        if kind in POINTS:
            return _points(items, count, POINTS[kind])
        return [self._pointer(item, depth) for item in items]

    def _custom(self, struct: Any, pointer: int) -> Facts:
        """Return the custom properties, among them the inputs of a geometry-nodes modifier."""
        known = struct.bl_rna.properties
        try:
            names = [name for name in struct.keys() if name not in known and name != "cycles"]  # noqa: SIM118
        except TypeError:
            return []
        return [
            (name, self._masked(pointer, name, _as_saved(struct[name])))
            for name in sorted(names)
            if not name.startswith(("_", COVERAGE_MARK))
        ]


def _as_saved(value: Any) -> Any:
    """Return a value as it is after saving and loading, which turn booleans into numbers."""
    return int(value) if isinstance(value, bool) else value


def _file_facts(struct: Any, path: Any, library: Any) -> Facts:
    """Return the name and size of the file at a path; the size is -1 if there is no such file."""
    # The folder is not compared, since Save As rewrites relative paths.
    name = re.split(r"[/\\]", path.rstrip("/\\"))[-1]
    packed = getattr(struct, "packed_file", None)
    if packed is not None:
        return [name, packed.size]
    size = -1
    with suppress(OSError, ValueError):
        found = Path(bpy.path.abspath(path, library=library))
        size = found.stat().st_size if found.is_file() else -1
    return ["" if name in {".", ".."} else name, size]


def plain(value: Any) -> Any:
    """Return a value as numbers, texts and tuples of them; a datablock becomes its name."""
    if value is None or isinstance(value, (bool, int, float, str, bytes)):
        return value
    if isinstance(value, (set, frozenset)):
        return tuple(sorted(value))
    if isinstance(value, bpy.types.ID):
        return value.name_full
    if hasattr(value, "to_dict"):
        return repr(value.to_dict())
    if hasattr(value, "to_list"):
        return tuple(value.to_list())
    try:
        return tuple(plain(v) for v in value)
    except TypeError:
        return str(value)


def forget_types() -> None:
    """Empty the caches, which hold references to classes of add-ons.

    Blender 4.2 as a module crashes at exit while any such reference is left.
    """
    _reading_plan.cache_clear()
    _has_custom.cache_clear()


def _reading_plan_of(struct: Any, present: bool = False) -> tuple[tuple[str, str], ...]:
    """Return the properties to read of an RNA struct: pairs of a name and how to read it.

    The pairs and `present` are as for `_reading_plan`, which caches its result for each type. The
    plan of the inputs of a nodes modifier (Blender 5.2) is not cached, since their properties
    change with its node group.
    """
    made_of: Any = type(struct)
    is_passing = made_of.__name__.startswith("GeometryNodesInterface")
    return (_reading_plan.__wrapped__ if is_passing else _reading_plan)(made_of, present)


# One answer a type; without it 4 µs more a struct.
@cache
def _has_custom(cls: Any) -> bool:
    return issubclass(
        cls, (bpy.types.ID, bpy.types.Bone, bpy.types.PoseBone, bpy.types.NodesModifier)
    )


# One plan a type, until the add-on is switched off; without it 0.1 ms more a datablock.
@cache
def _reading_plan(cls: Any, present: bool) -> tuple[tuple[str, str], ...]:
    """Return the properties to read of an RNA type: pairs of a name and how to read it.

    The second item is VALUE, FILE, POINTER or ITEMS. If `present` is True, the values at the
    present frame are read. Some properties of nodes are then left out, because they are the same at
    every frame.
    """
    plan = []
    on_screen = any(base.__name__ in ON_SCREEN for base in cls.__mro__)
    for prop in cls.bl_rna.properties:
        name = prop.identifier
        if name in DERIVED or name in INTERFACE or name.startswith(LOOKS):
            continue
        if on_screen and (name in {"location", "height", "color", "hide", "dimensions"}):
            continue
        if present and on_screen and name.startswith(NO_VALUES) and name != "bl_idname":
            continue
        # Properties ending in SUFFIX show another one in the scene's unit.
        if name in WITHOUT_INFLUENCE.get(cls.__name__, ()) or name.endswith(SUFFIX):
            continue
        if prop.type == "COLLECTION":
            if not name.startswith("all_"):
                plan.append((name, "ITEMS"))
        elif prop.type == "POINTER":
            plan.append((name, "POINTER"))
        elif not prop.is_readonly:
            is_path = prop.type == "STRING" and prop.subtype in {"FILE_PATH", "DIR_PATH"}
            plan.append((name, "FILE" if is_path else "VALUE"))
    return tuple(plan)


def _points(items: Any, count: int, fields: tuple[str, ...]) -> Facts:
    found: Facts = [count]
    properties = items[0].bl_rna.properties
    for name in fields:
        prop = properties[name]
        size = getattr(prop, "array_length", 0) or 1
        values = np.empty(count * size, np.int32 if prop.type == "ENUM" else np.float32)
        items.foreach_get(name, values)
        found.append(values.tobytes())
    return found


def part_facts(datablock: Any, part: Any) -> Any:
    """Return the settings of a struct within a datablock, in the form of `facts_of`."""
    return _Walk(datablock)._pointer(part, 0)


def setting_facts(datablock: Any, part: Any, names: Iterable[str]) -> Facts:
    """Return the values of the properties `names` of `part`: a datablock, or a struct within it.

    Animated values are None.
    """
    walk = _Walk(datablock)
    pointer = part.as_pointer()
    return [walk._masked(pointer, name, getattr(part, name)) for name in names]


def custom_facts(datablock: Any, present: bool = False) -> Facts:
    """Return the custom properties of a datablock.

    If `present` is True, animated properties have their values at the present frame. Otherwise they
    have None.
    """
    return _Walk(datablock, present)._custom(datablock, datablock.as_pointer())


def animation_facts(datablock: Any) -> Facts:
    """Return the keyframes, drivers and NLA strips of a datablock, except on sensors' outputs.

    The list is empty without animation.
    """
    animation = getattr(datablock, "animation_data", None)
    if animation is None:
        return []
    curves = action_curves(animation.action, getattr(animation, "action_slot", None))
    found: Facts = [_curve(curve) for curve in curves if curve.data_path not in OUTPUT_PATHS]
    found += [_driver(curve) for curve in animation.drivers]
    for track in animation.nla_tracks:
        for strip in track.strips:
            keys = action_curves(strip.action, getattr(strip, "action_slot", None))
            settings = [plain(getattr(strip, name)) for name in STRIP]
            found.append([track.mute, track.is_solo, *settings, [_curve(key) for key in keys]])
    return found


STRIP = (
    "frame_start", "frame_end", "action_frame_start", "action_frame_end", "blend_in", "blend_out",
    "blend_type", "extrapolation", "influence", "mute", "repeat", "scale", "use_reverse",
)  # fmt: skip


def _curve(curve: Any) -> Facts:
    points = curve.keyframe_points
    return [
        curve.data_path,
        curve.array_index,
        curve.mute,
        curve.extrapolation,
        curve.auto_smoothing,
        _points(points, len(points), POINTS["Keyframe"]) if len(points) else 0,
        [_modifier(modifier) for modifier in curve.modifiers],
    ]


def _modifier(modifier: Any) -> Facts:
    return [
        (name, plain(getattr(modifier, name)))
        for name, kind in _reading_plan_of(modifier)
        if kind == "VALUE"
    ]


def _driver(curve: Any) -> Facts:
    driver = curve.driver
    return [
        curve.mute,
        curve.data_path,
        curve.array_index,
        driver.type,
        driver.expression if driver.type == "SCRIPTED" else "",
        [_modifier(modifier) for modifier in curve.modifiers],
        [
            [v.name, v.type]
            + [
                [getattr(t.id, "name_full", None), t.data_path, t.bone_target]
                + [t.transform_type, t.transform_space, t.rotation_mode]
                for t in v.targets
            ]
            for v in driver.variables
        ],
    ]


def mesh_facts(mesh: Any) -> Facts:
    """Return the materials, vertices, faces and all attributes of a mesh.

    In Edit Mode, Blender gives no access to a mesh: the list is then `["is edited"]`.
    """
    if mesh.is_editmode:
        return ["is edited"]
    found: Facts = [
        [getattr(m, "name_full", None) for m in mesh.materials],
        mesh.shape_keys.name_full if mesh.shape_keys else None,
    ]
    found += corners_and_faces(mesh)
    found.append(_attribute(mesh.attributes[".edge_verts"]) if mesh.edges else 0)
    for attribute in mesh.attributes:
        name = attribute.name
        if not name.startswith(".") and name not in {"position", "material_index"}:
            found.append((name, attribute.domain, _attribute(attribute)))
    return found


def corners_and_faces(mesh: Any) -> Facts:
    """Return the digests of four arrays of a mesh.

    These are the positions of the vertices and the vertex of each face corner; and the first corner
    and the material index of each face.
    """
    # Attributes are copied as whole arrays; item by item takes 50 times as long.
    found: Facts = [
        _attribute(mesh.attributes[name]) if name in mesh.attributes else 0
        for name in ("position", ".corner_vert")
    ]
    values = np.empty(len(mesh.polygons), np.int32)
    mesh.polygons.foreach_get("loop_start", values)
    found.append(hashed(values))
    # The attribute may be missing where all faces have the first material.
    values[:] = 0
    if "material_index" in mesh.attributes:
        mesh.attributes["material_index"].data.foreach_get("value", values)
    return [*found, hashed(values)]


def hashed(values: Any) -> str:
    """Return the digest of bytes, or of a long array."""
    # As text, an array would take many times its memory.
    return hashlib.blake2b(values, digest_size=16).hexdigest()


def _attribute(attribute: Any) -> Any:
    data = attribute.data
    if not len(data):
        return 0
    name = next((n for n in ("value", "vector", "color") if hasattr(data[0], n)), None)
    if name is None or attribute.data_type == "STRING":
        return [str(getattr(item, "value", "")) for item in data]
    first = getattr(data[0], name)
    flat = np.ravel(first).size
    whole = attribute.data_type.startswith("INT") or (
        isinstance(first, int) and not isinstance(first, bool)
    )
    kind = np.int32 if whole else np.float32
    values = np.empty(len(data) * flat, bool if isinstance(first, bool) else kind)
    data.foreach_get(name, values)
    return hashed(values)


def weights_of(mesh: Any) -> Any:
    """Return the vertex groups and weights of the vertices in vertex groups."""
    return [
        [(g.group, g.weight) for g in vertex.groups] for vertex in mesh.vertices if vertex.groups
    ]
