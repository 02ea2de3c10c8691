# SPDX-License-Identifier: GPL-3.0-or-later
"""Build a resident as Blender objects: an armature and one skinned mesh."""

from __future__ import annotations

from functools import cache
from typing import Any

import bpy
import numpy as np

from ...angen_addon.scene.sensors import unit_scale
from ...sensor_logic.model import Array, Index
from ..body import surface
from ..body.cat import cat_parts, cat_weights
from ..body.skeleton import BUILDS, CHILD_HEAD, Skeleton, Sort
from ..body.skin import person_parts, weights
from ..body.solve import skeleton_of

# Red, green, blue and roughness by part.
Colours = dict[str, tuple[float, float, float, float]]
_PERSON: Colours = {
    "skin": (0.62, 0.36, 0.25, 0.5),
    "hand": (0.62, 0.36, 0.25, 0.5),
    "hair": (0.055, 0.030, 0.016, 0.6),
    "shirt": (0.055, 0.16, 0.26, 0.85),
    "trousers": (0.060, 0.062, 0.075, 0.9),
    "shoe": (0.35, 0.33, 0.30, 0.7),
    "eye white": (0.75, 0.73, 0.70, 0.3),
    "iris": (0.05, 0.035, 0.025, 0.2),
    "lips": (0.50, 0.20, 0.16, 0.45),
}
COLOURS: dict[Sort, Colours] = {
    Sort.ADULT: _PERSON,
    Sort.OLDER_ADULT: _PERSON
    | {
        "skin": (0.60, 0.38, 0.29, 0.55),
        "hand": (0.60, 0.38, 0.29, 0.55),
        "hair": (0.55, 0.54, 0.52, 0.6),
        "shirt": (0.30, 0.10, 0.11, 0.9),
        "trousers": (0.18, 0.15, 0.12, 0.9),
        "shoe": (0.09, 0.06, 0.05, 0.6),
    },
    Sort.CHILD: _PERSON
    | {
        "hair": (0.25, 0.13, 0.05, 0.6),
        "shirt": (0.62, 0.40, 0.06, 0.85),
        "trousers": (0.08, 0.14, 0.30, 0.9),
        "shoe": (0.55, 0.55, 0.55, 0.7),
    },
    Sort.CAT: {"fur": (0.33, 0.17, 0.07, 0.9), "eye": (0.35, 0.42, 0.05, 0.2)},
}
LABELS = {
    Sort.OLDER_ADULT: "Older adult",
    Sort.ADULT: "Adult",
    Sort.CHILD: "Child",
    Sort.CAT: "Cat",
}


def add_person(
    collection: bpy.types.Collection, sort: Sort = Sort.ADULT, name: str = ""
) -> bpy.types.Object:
    """Add an armature with a skinned mesh, in the usual size of a sort; return the armature.

    The armature is called `name`, and the mesh `name` and "body". Blender appends a number to a
    name that another object has.
    """
    build = BUILDS[sort]
    rig = _armature(collection, name or LABELS[sort], skeleton_of(build))
    body = bpy.data.objects.new(f"{rig.name} body", _mesh(f"{rig.name} body", sort))
    collection.objects.link(body)
    _skin(body, sort)
    body.parent = rig
    modifier = body.modifiers.new("Armature", "ARMATURE")
    modifier.object = rig
    modifier.use_deform_preserve_volume = True
    size = build.scale / unit_scale(bpy.context.scene)
    rig.scale = (size, size, size)
    return rig


def body_of(rig: Any) -> Any:
    """Return the skinned mesh of an armature, or None if it was deleted."""
    for child in rig.children:
        if child.type == "MESH" and any(
            m.type == "ARMATURE" and m.object == rig for m in child.modifiers
        ):
            return child
    return None


def _armature(
    collection: bpy.types.Collection, name: str, skeleton: Skeleton
) -> bpy.types.Object:  # fmt: skip
    data = bpy.data.armatures.new(name)
    rig = bpy.data.objects.new(name, data)
    # Edit Mode needs a visible object, and the chosen collection may be hidden.
    root = bpy.context.scene.collection
    root.objects.link(rig)
    rig.show_in_front = True
    data.display_type = "STICK"
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    for bone in skeleton.bones:
        edit = data.edit_bones.new(bone.name)
        edit.head, edit.tail = bone.head, bone.tail
        if bone.parent:
            edit.parent = data.edit_bones[bone.parent]
    bpy.ops.object.mode_set(mode="OBJECT")
    if collection != root:
        root.objects.unlink(rig)
        collection.objects.link(rig)
    for bone in rig.pose.bones:
        bone.rotation_mode = "QUATERNION"
    return rig


def _reduced(points: Array, quads: Index, triangles: int) -> tuple[Array, Index]:
    mesh = bpy.data.meshes.new("reduced")
    mesh.from_pydata(points.tolist(), [], quads.tolist())
    thing = bpy.data.objects.new("reduced", mesh)
    bpy.context.scene.collection.objects.link(thing)
    decimate = thing.modifiers.new("Decimate", "DECIMATE")
    decimate.ratio = min(1.0, triangles / (2 * len(quads)))
    decimate.use_collapse_triangulate = True
    evaluated = thing.evaluated_get(bpy.context.evaluated_depsgraph_get())
    small = evaluated.to_mesh()
    out = np.empty(len(small.vertices) * 3)
    small.vertices.foreach_get("co", out)
    faces = np.empty(len(small.loops), np.intp)
    small.loops.foreach_get("vertex_index", faces)
    evaluated.to_mesh_clear()
    bpy.data.objects.remove(thing)
    bpy.data.meshes.remove(mesh)
    return out.reshape(-1, 3), faces.reshape(-1, 3)


# Without the cache, each further body takes 0.6 s more.
@cache
def _surfaces(cat: bool) -> list[tuple[Array, Index]]:
    """Return the points (n, 3) and triangles (m, 3) of each part of a body, before it is scaled."""
    return [
        _reduced(*surface.mesh(part.shape, part.low, part.high, part.cell), part.triangles)
        for part in (cat_parts() if cat else person_parts())
    ]


def _mesh(name: str, sort: Sort) -> bpy.types.Mesh:
    """Return the mesh of all parts of a body.

    Its vertex attribute "part" has the number of each vertex's part.
    """
    names = list(COLOURS[sort])
    points: list[Array] = []
    faces: list[Index] = []
    materials: list[int] = []
    owner: list[int] = []
    first = 0
    cat = sort is Sort.CAT
    parts = zip(cat_parts() if cat else person_parts(), _surfaces(cat), strict=True)
    for number, (part, (p, f)) in enumerate(parts):
        points.append(p)
        faces.append(f + first)
        materials += [names.index(part.material)] * len(f)
        owner += [number] * len(p)
        first += len(p)
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(np.concatenate(points).tolist(), [], np.concatenate(faces).tolist())
    for material in names:
        mesh.materials.append(_material(sort, material))
    mesh.polygons.foreach_set("material_index", materials)
    mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
    mesh.attributes.new("part", "INT", "POINT").data.foreach_set("value", owner)
    mesh.update()
    return mesh


def _points(mesh: bpy.types.Mesh) -> Array:
    points = np.empty(len(mesh.vertices) * 3)
    mesh.vertices.foreach_get("co", points)
    return points.reshape(-1, 3)


def _skin(body: bpy.types.Object, sort: Sort) -> None:
    """Add a vertex group for each bone; each vertex is in at most four groups."""
    mesh, skeleton = body.data, skeleton_of(BUILDS[sort])
    points = _points(mesh)
    owner = np.empty(len(points), np.intp)
    mesh.attributes["part"].data.foreach_get("value", owner)
    table = np.zeros((len(points), len(skeleton.bones)))
    index = {bone.name: k for k, bone in enumerate(skeleton.bones)}
    cat = sort is Sort.CAT
    for number, part in enumerate(cat_parts() if cat else person_parts()):
        mine = np.flatnonzero(owner == number)
        moved_by = (cat_weights if cat else weights)(points[mine], part.region)
        for name, w in moved_by.items():
            table[mine, index[name]] += w
    table = _smoothed(mesh, table)
    weakest = np.sort(table, axis=1)[:, -5:-4]
    table[table <= np.maximum(weakest, 0.004)] = 0.0
    table /= table.sum(1, keepdims=True)
    for bone in skeleton.bones:
        group = body.vertex_groups.new(name=bone.name)
        column = table[:, index[bone.name]]
        for vertex in np.flatnonzero(column):
            group.add([int(vertex)], float(column[vertex]), "REPLACE")
    mesh.attributes.remove(mesh.attributes["part"])
    if sort is Sort.CHILD:
        _enlarge_head(mesh, table[:, index["head"]], skeleton.head["head"])


def _enlarge_head(mesh: bpy.types.Mesh, weight: Array, joint: Array) -> None:
    points = _points(mesh)
    points += (CHILD_HEAD - 1.0) * weight[:, None] * (points - joint)
    mesh.vertices.foreach_set("co", points.ravel())
    mesh.update()


def _smoothed(mesh: bpy.types.Mesh, table: Array) -> Array:
    """Return the skinning weights averaged along the mesh's edges, to smooth the skin."""
    edges = np.empty(len(mesh.edges) * 2, np.intp)
    mesh.edges.foreach_get("vertices", edges)
    a, b = edges.reshape(-1, 2).T
    degree = np.bincount(edges, minlength=len(table))[:, None]
    for _ in range(3):
        around = np.zeros_like(table)
        np.add.at(around, a, table[b])
        np.add.at(around, b, table[a])
        table = 0.5 * table + 0.5 * around / np.maximum(degree, 1)
    return table


def _material(sort: Sort, part: str) -> bpy.types.Material:
    name = f"{LABELS[sort]} {part}"
    material = bpy.data.materials.get(name)
    if material is not None:
        return material
    red, green, blue, roughness = COLOURS[sort][part]
    material = bpy.data.materials.new(name)
    if not material.node_tree:
        material.use_nodes = True
    material.diffuse_color = (red, green, blue, 1.0)
    shader = next(n for n in material.node_tree.nodes if n.type == "BSDF_PRINCIPLED")
    shader.inputs["Base Color"].default_value = (red, green, blue, 1.0)
    shader.inputs["Roughness"].default_value = roughness
    return material
