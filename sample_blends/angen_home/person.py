# SPDX-License-Identifier: GPL-3.0-or-later
"""The person as Blender objects: an armature and one skinned mesh of about 5500 triangles."""

import bpy
import numpy as np

from . import body, surface
from .skeleton import BONES

COLOURS = {
    "Person skin": (0.62, 0.36, 0.25, 0.5),
    "Person hair": (0.055, 0.030, 0.016, 0.6),
    "Person shirt": (0.055, 0.16, 0.26, 0.85),
    "Person trousers": (0.060, 0.062, 0.075, 0.9),
    "Person shoe": (0.35, 0.33, 0.30, 0.7),
    "Person eye white": (0.75, 0.73, 0.70, 0.3),
    "Person iris": (0.05, 0.035, 0.025, 0.2),
    "Person lips": (0.50, 0.20, 0.16, 0.45),
}


def add_person(collection: bpy.types.Collection) -> bpy.types.Object:
    """The armature "Person rig" with its mesh "Person"; returns the armature."""
    rig = _armature(collection)
    mesh = _mesh()
    person = bpy.data.objects.new("Person", mesh)
    collection.objects.link(person)
    _skin(person)
    person.parent = rig
    modifier = person.modifiers.new("Armature", "ARMATURE")
    modifier.object = rig
    modifier.use_deform_preserve_volume = True
    return rig


def _armature(collection: bpy.types.Collection) -> bpy.types.Object:
    data = bpy.data.armatures.new("Person rig")
    rig = bpy.data.objects.new("Person rig", data)
    collection.objects.link(rig)
    rig.show_in_front = True
    data.display_type = "STICK"
    layer = bpy.context.view_layer
    layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    for bone in BONES:
        edit = data.edit_bones.new(bone.name)
        edit.head, edit.tail = bone.head, bone.tail
        if bone.parent:
            edit.parent = data.edit_bones[bone.parent]
    bpy.ops.object.mode_set(mode="OBJECT")
    for bone in rig.pose.bones:
        bone.rotation_mode = "QUATERNION"
    return rig


def _reduced(points: np.ndarray, quads: np.ndarray, triangles: int) -> tuple[np.ndarray, ...]:
    """Fewer triangles, more of them where the surface bends; Blender's Decimate does it."""
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
    faces = np.empty(len(small.loops), int)
    small.loops.foreach_get("vertex_index", faces)
    evaluated.to_mesh_clear()
    bpy.data.objects.remove(thing)
    bpy.data.meshes.remove(mesh)
    return out.reshape(-1, 3), faces.reshape(-1, 3)


def _mesh() -> bpy.types.Mesh:
    """All parts in one mesh; the vertex attribute "part" says which is which."""
    names = list(COLOURS)
    points, faces, materials, owner = [], [], [], []
    first = 0
    for number, part in enumerate(body.parts()):
        p, q = surface.mesh(part.shape, part.low, part.high, part.cell)
        p, f = _reduced(p, q, part.triangles)
        points.append(p)
        faces.append(f + first)
        materials += [names.index(part.material)] * len(f)
        owner += [number] * len(p)
        first += len(p)
    mesh = bpy.data.meshes.new("Person")
    mesh.from_pydata(np.concatenate(points).tolist(), [], np.concatenate(faces).tolist())
    for name in names:
        mesh.materials.append(_material(name))
    mesh.polygons.foreach_set("material_index", materials)
    mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
    mesh.attributes.new("part", "INT", "POINT").data.foreach_set("value", owner)
    mesh.update()
    return mesh


def _skin(person: bpy.types.Object) -> None:
    """Vertex groups: one a bone, four bones a vertex at the most."""
    mesh = person.data
    points = np.empty(len(mesh.vertices) * 3)
    mesh.vertices.foreach_get("co", points)
    points = points.reshape(-1, 3)
    owner = np.empty(len(points), int)
    mesh.attributes["part"].data.foreach_get("value", owner)
    table = np.zeros((len(points), len(BONES)))
    index = {bone.name: k for k, bone in enumerate(BONES)}
    for number, part in enumerate(body.parts()):
        mine = np.flatnonzero(owner == number)
        for name, w in body.weights(points[mine], part.region).items():
            table[mine, index[name]] += w
    table = _smoothed(mesh, table)
    weakest = np.sort(table, axis=1)[:, -5:-4]
    table[table <= np.maximum(weakest, 0.004)] = 0.0
    table /= table.sum(1, keepdims=True)
    for bone in BONES:
        group = person.vertex_groups.new(name=bone.name)
        column = table[:, index[bone.name]]
        for vertex in np.flatnonzero(column):
            group.add([int(vertex)], float(column[vertex]), "REPLACE")
    mesh.attributes.remove(mesh.attributes["part"])


def _smoothed(mesh: bpy.types.Mesh, table: np.ndarray, rounds: int = 3) -> np.ndarray:
    """Weights averaged along the edges: no steps left in the skin."""
    edges = np.empty(len(mesh.edges) * 2, int)
    mesh.edges.foreach_get("vertices", edges)
    a, b = edges.reshape(-1, 2).T
    degree = np.bincount(edges, minlength=len(table))[:, None]
    for _ in range(rounds):
        around = np.zeros_like(table)
        np.add.at(around, a, table[b])
        np.add.at(around, b, table[a])
        table = 0.5 * table + 0.5 * around / np.maximum(degree, 1)
    return table


def _material(name: str) -> bpy.types.Material:
    red, green, blue, roughness = COLOURS[name]
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    material.diffuse_color = (red, green, blue, 1.0)
    shader = material.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (red, green, blue, 1.0)
    shader.inputs["Roughness"].default_value = roughness
    return material
