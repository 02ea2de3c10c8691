# SPDX-License-Identifier: GPL-3.0-or-later
"""Mesh helpers: a builder that collects simple rounded shapes into one mesh with its normals."""

from collections.abc import Callable, Iterable, Sequence
from itertools import product
from math import cos, pi, sin

import bpy
import numpy as np
from mathutils import Matrix

from . import materials

Vec = Sequence[float]
IDENTITY = Matrix.Identity(4)
# Two neighbouring steps of a profile are shaded as one surface below this angle's cosine.
SMOOTH_COS = 0.64
# Coordinates are whole multiples of 1/8192 m, about 0.1 mm, which makes the file smaller.
GRAIN = 2.0**-13


class MeshBuilder:
    """Shapes of one mesh: `matrix` moves the next shapes, `build` makes the mesh."""

    def __init__(self, material: str = "white paint") -> None:
        self.material = material
        self.matrix = IDENTITY
        self._verts: list[np.ndarray] = []
        self._normals: list[np.ndarray] = []
        self._faces: list[list[int]] = []
        self._face_materials: list[str] = []
        self._count = 0

    def add(
        self,
        verts: Iterable[Vec],
        faces: Iterable[Sequence[int]],
        normals: Iterable[Vec] | None = None,
        material: str | None = None,
    ) -> None:
        """Add a shape; without normals they are averaged over the faces (smooth)."""
        v = np.asarray(list(verts), dtype=np.float64)
        f = [list(face) for face in faces]
        n = smooth_normals(v, f) if normals is None else np.asarray(list(normals), float)
        matrix = np.array(self.matrix)
        rotation = np.linalg.inv(matrix[:3, :3]).T
        v = v @ matrix[:3, :3].T + matrix[:3, 3]
        n = n @ rotation.T
        n /= np.maximum(np.linalg.norm(n, axis=1, keepdims=True), 1e-12)
        if np.linalg.det(matrix[:3, :3]) < 0:
            f = [face[::-1] for face in f]
        self._verts.append(v)
        self._normals.append(n)
        self._faces += [[i + self._count for i in face] for face in f]
        self._face_materials += [material or self.material] * len(f)
        self._count += len(v)

    # --- shapes -----------------------------------------------------------------------
    def box(self, lo: Vec, hi: Vec, bevel: float = 0.006, material: str | None = None) -> None:
        """Add a box from its low to its high corner with rounded edges (sharp for a bevel of 0)."""
        lo_, hi_ = np.minimum(lo, hi), np.maximum(lo, hi)
        b = min(bevel, *(0.45 * (hi_ - lo_)))
        verts, normals, index = [], [], {}
        for signs in product((0, 1), repeat=3):
            corner = np.where(signs, hi_, lo_)
            inward = np.where(signs, -b, b)
            for axis in range(3):
                index[signs, axis] = len(verts)
                p = corner + inward
                p[axis] = corner[axis]
                verts.append(p)
                normal = np.zeros(3)
                normal[axis] = 1.0 if signs[axis] else -1.0
                normals.append(normal)
        faces = []
        for axis in range(3):
            u, w = (axis + 1) % 3, (axis + 2) % 3
            for side in (0, 1):
                ring = []
                for su, sw in ((0, 0), (1, 0), (1, 1), (0, 1)):
                    s = [0, 0, 0]
                    s[axis], s[u], s[w] = side, su, sw
                    ring.append(index[tuple(s), axis])
                faces.append(ring if side else ring[::-1])
            if b <= 0.0:
                continue
            for su, sw in product((0, 1), repeat=2):  # the edge along `axis`
                a, c = [0, 0, 0], [0, 0, 0]
                a[u] = c[u] = su
                a[w] = c[w] = sw
                c[axis] = 1
                quad = [index[tuple(a), u], index[tuple(c), u],
                        index[tuple(c), w], index[tuple(a), w]]  # fmt: skip
                faces.append(quad if su != sw else quad[::-1])
        for signs in product((0, 1), repeat=3) if b > 0.0 else ():
            tri = [index[signs, axis] for axis in range(3)]
            faces.append(tri if sum(signs) % 2 else tri[::-1])
        self.add(verts, faces, normals, material)

    def lathe(
        self,
        profile: Sequence[tuple[float, float]],
        at: Vec = (0, 0, 0),
        segments: int = 16,
        material: str | None = None,
    ) -> None:
        """Turn a profile of (radius, height), from below to above, about a vertical axis."""
        points = np.asarray(profile, float)
        steps = np.diff(points, axis=0)
        flat = np.stack([steps[:, 1], -steps[:, 0]], 1)
        flat /= np.maximum(np.linalg.norm(flat, axis=1, keepdims=True), 1e-12)
        rows: list[tuple[np.ndarray, np.ndarray]] = []  # (radius, z), normal
        quads: list[tuple[int, int]] = []
        for i, normal in enumerate(flat):
            ends = []
            for j, other in ((i, i - 1), (i + 1, i + 1)):
                n = normal
                if 0 <= other < len(flat) and normal @ flat[other] > SMOOTH_COS:
                    n = normal + flat[other]
                ends.append(len(rows))
                rows.append((points[j], n / np.linalg.norm(n)))
            quads.append((ends[0], ends[1]))
        verts, normals, faces = [], [], []
        for (radius, z), (nr, nz) in rows:
            for k in range(segments):
                c, s = cos(2 * pi * k / segments), sin(2 * pi * k / segments)
                verts.append((at[0] + radius * c, at[1] + radius * s, at[2] + z))
                normals.append((nr * c, nr * s, nz))
        for low, high in quads:
            r_low, r_high = rows[low][0][0], rows[high][0][0]
            a, b = low * segments, high * segments
            for k in range(segments):
                m = (k + 1) % segments
                face = [a + k, a + m, b + m, b + k]
                if r_low < 1e-9:
                    face = [a + k, b + m, b + k]
                elif r_high < 1e-9:
                    face = [a + k, a + m, b + k]
                faces.append(face)
        self.add(verts, faces, normals, material)

    def cylinder(
        self,
        at: Vec,
        radius: float,
        height: float,
        segments: int = 16,
        material: str | None = None,
        top: float | None = None,
    ) -> None:
        """Add a standing closed cylinder with bevelled edges (a truncated cone with `top`)."""
        t = radius if top is None else top
        b = min(0.004, 0.3 * radius, 0.3 * t, 0.3 * height)
        self.lathe(
            [(0, 0), (radius - b, 0), (radius, b), (t, height - b), (t - b, height), (0, height)],
            at, segments, material,
        )  # fmt: skip

    def rod(
        self, a: Vec, b: Vec, radius: float, segments: int = 8, material: str | None = None
    ) -> None:
        """Add a round rod between two points."""
        self.tube([a, b], radius, segments, material)

    def tube(
        self, path: Sequence[Vec], radius: float, segments: int = 8, material: str | None = None
    ) -> None:
        """Add a round tube along a polyline, closed at its ends."""
        points = np.asarray(path, float)
        tangents = np.gradient(points, axis=0)
        tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
        start = np.array([0.0, 0.0, 1.0])
        if abs(tangents[0] @ start) > 0.9:
            start = np.array([1.0, 0.0, 0.0])
        side = np.cross(tangents[0], start)
        verts, normals, faces = [], [], []
        for p, t in zip(points, tangents, strict=True):
            side = side - (side @ t) * t
            side /= np.linalg.norm(side)
            up = np.cross(t, side)
            for k in range(segments):
                angle = 2 * pi * k / segments
                n = cos(angle) * side + sin(angle) * up
                verts.append(p + radius * n)
                normals.append(n)
        for i in range(len(points) - 1):
            for k in range(segments):
                m = (k + 1) % segments
                a, b = i * segments, (i + 1) * segments
                faces.append([a + k, a + m, b + m, b + k])
        for first, normal in ((0, -tangents[0]), (len(points) - 1, tangents[-1])):
            base = len(verts)
            ring = [verts[first * segments + k] for k in range(segments)]
            verts += ring
            normals += [normal] * segments
            cap = [base + k for k in range(segments)]
            faces.append(cap if first else cap[::-1])
        self.add(verts, faces, normals, material)

    def cushion(
        self,
        lo: Vec,
        hi: Vec,
        radius: float = 0.05,
        puff: float = 0.0,
        material: str | None = None,
        cuts: int = 4,
    ) -> None:
        """Add a soft box: round edges of `radius`, wide faces that bulge by `puff` m."""
        lo_, hi_ = np.minimum(lo, hi), np.maximum(lo, hi)
        centre, half = (lo_ + hi_) / 2, (hi_ - lo_) / 2
        r = min(radius, *half)
        # Grid lines are denser near the edges, where the surface bends.
        ticks = []
        for h in half:
            inner = h - r
            steps = 3 if r >= 0.035 else 2
            bend = [inner + r * sin((k + 1) * pi / (2 * steps)) for k in range(steps)]
            middle = list(np.linspace(-inner, inner, cuts))
            ticks.append([-b for b in bend[::-1]] + middle + bend)
        verts, faces, known = [], [], {}

        def vertex(p: tuple[float, float, float]) -> int:
            key = tuple(round(c, 7) for c in p)
            if key not in known:
                q = np.array(p)
                core = np.clip(q, r - half, half - r)
                arm = q - core
                length = np.linalg.norm(arm)
                out = core + arm * (r / length if length > 1e-9 else 0.0)
                share = np.clip(1 - (q / half) ** 2, 0, 1)
                for axis in range(3):
                    if abs(abs(p[axis]) - half[axis]) < 1e-9:
                        other = share[(axis + 1) % 3] * share[(axis + 2) % 3]
                        swell = puff if half[axis] == min(half) else puff / 4
                        out[axis] += swell * other * (1 if p[axis] > 0 else -1)
                known[key] = len(verts)
                verts.append(centre + out)
            return known[key]

        for axis in range(3):
            u, w = (axis + 1) % 3, (axis + 2) % 3
            for sign in (-1, 1):
                for i, j in product(range(len(ticks[u]) - 1), range(len(ticks[w]) - 1)):
                    face = []
                    for di, dj in ((0, 0), (1, 0), (1, 1), (0, 1)):
                        p = [0.0, 0.0, 0.0]
                        p[axis] = sign * half[axis]
                        p[u], p[w] = ticks[u][i + di], ticks[w][j + dj]
                        face.append(vertex((p[0], p[1], p[2])))
                    if len(set(face)) >= 3:
                        faces.append(face if sign > 0 else face[::-1])
        self.add(verts, faces, None, material)

    def surface(
        self,
        point: Callable[[float, float], Vec],
        columns: int,
        rows: int,
        material: str | None = None,
    ) -> None:
        """Add a sheet: `point(u, v)` for u, v in 0…1."""
        verts = [point(i / columns, j / rows) for j in range(rows + 1) for i in range(columns + 1)]
        faces = []
        for j, i in product(range(rows), range(columns)):
            a = j * (columns + 1) + i
            faces.append([a, a + 1, a + columns + 2, a + columns + 1])
        self.add(verts, faces, None, material)

    def polygon(self, points: Sequence[Vec], material: str | None = None) -> None:
        """Add one flat face."""
        self.add(points, [list(range(len(points)))], None, material)

    # --- result -----------------------------------------------------------------------
    def build(self, name: str) -> bpy.types.Mesh:
        """Return the mesh of all shapes."""
        mesh = bpy.data.meshes.new(name)
        verts, normals = np.concatenate(self._verts), np.concatenate(self._normals)
        verts = np.round(verts / GRAIN) * GRAIN
        mesh.from_pydata(verts.tolist(), [], self._faces)
        slots = list(dict.fromkeys(self._face_materials))
        for slot in slots:
            mesh.materials.append(materials.get(slot))
        order = {slot: i for i, slot in enumerate(slots)}
        mesh.polygons.foreach_set("material_index", [order[m] for m in self._face_materials])
        mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
        mesh.normals_split_custom_set_from_vertices(normals.tolist())
        mesh.update()
        return mesh


def smooth_normals(verts: np.ndarray, faces: list[list[int]]) -> np.ndarray:
    """Return the area-weighted normals of the vertices."""
    normals = np.zeros_like(verts)
    for face in faces:
        p = verts[face]
        n = sum((np.cross(p[k], p[k - len(p) + 1]) for k in range(len(p))), np.zeros(3))
        normals[face] += n
    return normals


def collection(path: str) -> bpy.types.Collection:
    """Return the collection at a path such as 'Home/Furniture/Kitchen', made if missing."""
    parent = bpy.context.scene.collection
    for name in path.split("/"):
        child = parent.children.get(name)
        if child is None:
            child = bpy.data.collections.new(name)
            parent.children.link(child)
        parent = child
    return parent


def place(
    name: str,
    shape: MeshBuilder | bpy.types.Mesh | None,
    path: str,
    at: Vec = (0, 0, 0),
    yaw: float = 0.0,
    parent: bpy.types.Object | None = None,
    hinge: Vec | None = None,
) -> bpy.types.Object:
    """Make an object of a builder, of a shared mesh or (None) an empty, and link it.

    `at` and `yaw` (degrees) are in the parent's space if there is a parent. With a `hinge` instead,
    the builder's points are in the parent's space, and the hinge becomes the object's origin.
    """
    data = shape.build(name) if isinstance(shape, MeshBuilder) else shape
    if hinge is not None:
        at = (np.round(np.array(hinge) / GRAIN) * GRAIN).tolist()
        data.transform(Matrix.Translation(at).inverted())
    obj = bpy.data.objects.new(name, data)
    obj.location = at
    obj.rotation_euler = (0.0, 0.0, yaw * pi / 180)
    if parent is not None:
        obj.parent = parent
    collection(path).objects.link(obj)
    return obj


def moved(x: float = 0.0, y: float = 0.0, z: float = 0.0, yaw: float = 0.0) -> Matrix:
    """Return a matrix that turns by `yaw` degrees about z, then moves."""
    return Matrix.Translation((x, y, z)) @ Matrix.Rotation(yaw * pi / 180, 4, "Z")
