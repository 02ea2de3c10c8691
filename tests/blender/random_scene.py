# SPDX-License-Identifier: GPL-3.0-or-later
"""Random scenes, and random changes to them, for comparing the ray casters."""

import math
import random

import bpy
from mathutils import Vector

LAST_FRAME = 24


class RandomScene:
    """Objects of every solid type: scaled, mirrored, parented, modified, instanced, hidden, moving.

    The same seed makes the same scene and the same changes.
    """

    def __init__(self, seed: int, instances: bool) -> None:
        self.random = random.Random(seed)
        self.scene = bpy.context.scene
        self.scene.frame_start, self.scene.frame_end = 1, LAST_FRAME
        self.count = 0
        self.meshes = [self._cube(), self._ball(), self._plane()]
        for make in (self._mesh, self._mesh, self._mesh, self._curve, self._text, self._metaball):
            make()
        for _ in range(14):
            self._mesh()
        self._armature()
        if instances:
            self._collection_instance()
            self._vertex_instances()
            self._nodes()
        for _ in range(5):
            self._animate(self.random.choice(list(self.scene.objects)))
        bpy.context.view_layer.update()

    # Meshes

    def _cube(self) -> bpy.types.Mesh:
        corners = [(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]
        faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
        return self._new_mesh(corners, faces)

    def _ball(self) -> bpy.types.Mesh:
        rings, around = 7, 10
        points = [
            (
                0.5 * math.sin(math.pi * i / rings) * math.cos(2 * math.pi * j / around),
                0.5 * math.sin(math.pi * i / rings) * math.sin(2 * math.pi * j / around),
                0.5 * math.cos(math.pi * i / rings),
            )
            for i in range(rings + 1)
            for j in range(around)
        ]
        faces = [
            (i * around + j, i * around + (j + 1) % around, k + (j + 1) % around, k + j)
            for i in range(rings)
            for k in [(i + 1) * around]
            for j in range(around)
        ]
        return self._new_mesh(points, faces)

    def _plane(self) -> bpy.types.Mesh:
        return self._new_mesh([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [(0, 1, 2, 3)])

    def _new_mesh(self, points: list, faces: list) -> bpy.types.Mesh:
        mesh = bpy.data.meshes.new("mesh")
        mesh.from_pydata(points, [], faces)
        return mesh

    # Objects

    def _link(self, name: str, data: bpy.types.ID | None) -> bpy.types.Object:
        self.count += 1
        obj = bpy.data.objects.new(f"{name} {self.count}", data)
        self.scene.collection.objects.link(obj)
        self._place(obj)
        return obj

    def _place(self, obj: bpy.types.Object) -> None:
        pick = self.random.uniform
        obj.location = (pick(-2, 2), pick(-2, 2), pick(-2, 2))
        obj.rotation_euler = (pick(-3, 3), pick(-3, 3), pick(-3, 3))
        obj.scale = [math.exp(pick(-1, 1.2)) * self.random.choice((1, 1, 1, -1)) for _ in range(3)]

    def _mesh(self) -> None:
        obj = self._link("mesh", self.random.choice(self.meshes))
        if self.random.random() < 0.3:
            others = [o for o in self.scene.objects if o is not obj and o.parent is None]
            obj.parent = self.random.choice(others) if others else None
        if self.random.random() < 0.2:
            obj.data = obj.data.copy()
            obj.modifiers.new("s", "SUBSURF").levels = 1
        elif self.random.random() < 0.2:
            obj.modifiers.new("a", "ARRAY").count = 3
        elif self.random.random() < 0.2:
            wave = obj.modifiers.new("w", "WAVE")
            wave.height = 0.3
        if self.random.random() < 0.15:
            obj.hide_viewport = True
        if self.random.random() < 0.15:
            obj.hide_render = True
        if self.random.random() < 0.1:
            obj.angen_ignored = True
        if self.random.random() < 0.1:
            obj.display_type = "WIRE"

    def _curve(self) -> None:
        data = bpy.data.curves.new("curve", "CURVE")
        data.dimensions = "3D"
        data.bevel_depth = 0.1
        spline = data.splines.new("BEZIER")
        spline.bezier_points.add(2)
        for point in spline.bezier_points:
            point.co = [self.random.uniform(-1, 1) for _ in range(3)]
            point.handle_left_type = point.handle_right_type = "AUTO"
        self._link("curve", data)

    def _text(self) -> None:
        data = bpy.data.curves.new("text", "FONT")
        data.body = "Ängen"
        data.extrude = 0.1
        self._link("text", data)

    def _metaball(self) -> None:
        data = bpy.data.metaballs.new("ball")
        data.elements.new().radius = 1.0
        self._link("metaball", data)

    def _armature(self) -> None:
        """Add a mesh bent by two keyed bones."""
        armature = bpy.data.armatures.new("armature")
        rig = self._link("rig", armature)
        rig.scale = (1, 1, 1)
        bpy.context.view_layer.objects.active = rig
        bpy.ops.object.mode_set(mode="EDIT")
        for i in range(2):
            bone = armature.edit_bones.new(f"bone {i}")
            bone.head, bone.tail = (0, 0, i * 0.5), (0, 0, i * 0.5 + 0.5)
        bpy.ops.object.mode_set(mode="OBJECT")
        skin = self._link("skin", self._ball())
        skin.parent = rig
        skin.matrix_local.identity()
        for i in range(2):
            group = skin.vertex_groups.new(name=f"bone {i}")
            upper = [v.index for v in skin.data.vertices if (v.co.z > 0) == bool(i)]
            group.add(upper, 1.0, "REPLACE")
        skin.modifiers.new("armature", "ARMATURE").object = rig
        bone = rig.pose.bones["bone 1"]
        bone.rotation_mode = "XYZ"
        for frame in (1, LAST_FRAME):
            bone.rotation_euler.x = frame * 0.05
            bone.keyframe_insert("rotation_euler", frame=frame)

    def _collection_instance(self) -> None:
        collection = bpy.data.collections.new("source")
        inner = bpy.data.objects.new("inner", self.meshes[0])
        collection.objects.link(inner)
        for _ in range(2):
            instance = self._link("instance", None)
            instance.instance_type = "COLLECTION"
            instance.instance_collection = collection

    def _vertex_instances(self) -> None:
        parent = self._link("instancer", self.meshes[2])
        child = self._link("instanced", self.meshes[1])
        child.parent = parent
        child.scale = (0.2, 0.2, 0.2)
        parent.instance_type = "VERTS"
        parent.show_instancer_for_viewport = self.random.random() < 0.5

    def _nodes(self) -> None:
        """Add geometry nodes that scatter cubes which no object of the file has."""
        tree = bpy.data.node_groups.new("scatter", "GeometryNodeTree")
        tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
        grid = tree.nodes.new("GeometryNodeMeshGrid")
        cube = tree.nodes.new("GeometryNodeMeshCube")
        cube.inputs["Size"].default_value = (0.2, 0.2, 0.2)
        put = tree.nodes.new("GeometryNodeInstanceOnPoints")
        out = tree.nodes.new("NodeGroupOutput")
        tree.links.new(grid.outputs[0], put.inputs["Points"])
        tree.links.new(cube.outputs[0], put.inputs["Instance"])
        tree.links.new(put.outputs[0], out.inputs[0])
        self._link("scatter", self.meshes[0].copy()).modifiers.new("n", "NODES").node_group = tree

    # Movement and changes

    def _animate(self, obj: bpy.types.Object) -> None:
        way = self.random.choice(("location", "rotation_euler", "scale", "hide_viewport"))
        for frame in (1, LAST_FRAME // 2, LAST_FRAME):
            if way == "hide_viewport":
                obj.hide_viewport = self.random.random() < 0.5
            else:
                value = getattr(obj, way)
                value[self.random.randrange(3)] += self.random.uniform(0.1, 1.0)
            obj.keyframe_insert(way, frame=frame)

    def change(self) -> str:
        """Make a random edit, as a user or a script does between two frames; return its name."""
        ways = (
            self._add,
            self._remove,
            self._move,
            self._hide_eye,
            self._hide_viewport,
            self._edit_mesh,
            self._swap,
            self._ignore,
            self._animate_one,
        )
        way = self.random.choice(ways)
        way()
        return way.__name__

    def _some(self) -> bpy.types.Object:
        return self.random.choice(sorted(self.scene.objects, key=lambda obj: obj.name))

    def _add(self) -> None:
        self._mesh()

    def _remove(self) -> None:
        if len(self.scene.objects) > 8:
            bpy.data.objects.remove(self._some())

    def _move(self) -> None:
        self._place(self._some())

    def _hide_eye(self) -> None:
        obj = self._some()
        obj.hide_set(not obj.hide_get())

    def _hide_viewport(self) -> None:
        obj = self._some()
        obj.hide_viewport = not obj.hide_viewport

    def _edit_mesh(self) -> None:
        mesh = self.random.choice(self.meshes)
        mesh.vertices[0].co.x += 0.3
        mesh.update()

    def _swap(self) -> None:
        """Remove an object and add another one at the same time and place."""
        shown, hidden = self._some(), self._some()
        shown.hide_viewport, hidden.hide_viewport = True, False
        hidden.matrix_world = shown.matrix_world

    def _ignore(self) -> None:
        obj = self._some()
        obj.angen_ignored = not obj.angen_ignored

    def _animate_one(self) -> None:
        self._animate(self._some())

    # Rays

    def rays(self, count: int) -> tuple[list[Vector], list[Vector]]:
        """Return origins within the scene and unit directions."""
        pick = self.random.uniform
        origins = [Vector((pick(-3, 3), pick(-3, 3), pick(-3, 3))) for _ in range(count)]
        ways = [Vector((pick(-1, 1), pick(-1, 1), pick(-1, 1))).normalized() for _ in origins]
        return origins, ways
