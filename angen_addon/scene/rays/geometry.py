# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces of evaluated objects and instances, with BVH trees for casting rays at them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from mathutils.bvhtree import BVHTree
from numpy.typing import NDArray

from ....sensor_logic.geometry.trees import RayTree
from ....sensor_logic.model import Array
from ..timed import DEFORMING_MODIFIERS

SURFACE_TYPES = {"MESH", "CURVE", "SURFACE", "FONT", "META"}
# A mesh that is this many times farther from its origin than it is large loses digits in single
# precision. Its tree is built about its centre.
FAR_FROM_OWN_ORIGIN = 8.0
# From this many triangles on, a tree of Blender's takes too much time and memory.
LARGE = 250_000
# The most faces that are counted along a ray.
MOST_FACES = 200
# The bounds of an empty mesh.
NOWHERE: tuple[Array, Array] = (np.full(3, np.inf), np.full(3, -np.inf))


@dataclass(eq=False)
class Surface:
    """A copy of an evaluated mesh at one frame.

    Attributes
    ----------
    points
        Coordinates (3, n) of the vertices. A row for each axis is the faster layout for numpy.
    corners
        The vertex index (k,) of each face corner (Blender's loops).
    faces
        The number of faces.
    lo, hi
        Bounds (3,); inf and -inf for a mesh without faces.
    """

    points: NDArray[np.float32]
    corners: NDArray[np.int32]
    faces: int
    _triangles: tuple[NDArray[np.intp], NDArray[np.intp]] | None = None
    _tree: RayTree | None = None

    def __post_init__(self) -> None:
        self.lo, self.hi = _bounds(self.points) if self.faces else NOWHERE

    @property
    def plain(self) -> bool:
        """Whether all faces are triangles."""
        return len(self.corners) == 3 * self.faces

    @property
    def large(self) -> bool:
        """Whether the mesh has LARGE triangles or more.

        Rays are then cast with a `RayTree`. The module `changing_shapes` and Blender's trees would
        take too long.
        """
        return len(self.corners) - 2 * self.faces >= LARGE

    @property
    def bytes(self) -> int:
        """Estimated memory in bytes, including arrays that are computed later."""
        return self.points.nbytes * (4 if self.large else 1)

    def meet(self, starts: Array, ways: Array) -> tuple[Array, NDArray[np.intp]]:
        """Cast rays at a large surface; return their distances and the hit faces.

        Parameters
        ----------
        starts
            Origins (n, 3) of the rays, in the object's space.
        ways
            Directions (n, 3) of the rays, of any length.

        Returns
        -------
        tuple
            Distances (n,) in multiples of each direction's length, inf for a miss; and indices (n,)
            of the hit faces.
        """
        corners, face = (self.corners.reshape(-1, 3), None) if self.plain else self.triangles
        if self._tree is None:
            by_triangle = corners if face is None else corners.T
            points = np.ascontiguousarray(self.points.T)
            self._tree = RayTree(points, np.ascontiguousarray(by_triangle, np.int32))
        far, faces = self._tree.meet(starts, ways, np.full(len(starts), np.inf))
        return far / np.linalg.norm(ways, axis=1), faces if face is None else face[faces]

    @property
    def triangles(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """The vertex indices (3, m) of the triangles, and the face index (m,) of each triangle.

        For a mesh with quads or n-gons, `read_surface` must have been called with `with_triangles`.
        """
        if self._triangles is None:
            by_corner = np.ascontiguousarray(self.corners.reshape(-1, 3).T).astype(np.intp)
            self._triangles = by_corner, np.arange(self.faces)
        return self._triangles

    def has_faces_of(self, other: Surface) -> bool:
        """Return whether another surface has the same faces; if so, share its arrays of faces."""
        known = self.corners is other.corners
        if self.faces != other.faces or not (known or np.array_equal(self.corners, other.corners)):
            return False
        self.corners = other.corners
        if self.plain:
            self._triangles = other._triangles
        return True

    def same(self, other: Surface) -> bool:
        """Return whether another surface has the same faces and points; if so, share triangles."""
        if not (self.has_faces_of(other) and np.array_equal(self.points, other.points)):
            return False
        # Either may have been read without its triangles.
        self._triangles = other._triangles = self._triangles or other._triangles
        return True


@dataclass
class Built:
    """The BVH tree of a surface, shared by all objects of one mesh.

    Attributes
    ----------
    tree
        The tree; None before the first ray.
    pivot
        The origin (3,) of the tree, in the object's space.
    by_triangle
        Whether the tree's faces are triangles; otherwise they are the faces of the mesh.
    """

    tree: BVHTree | RayTree | None = None
    pivot: Array = field(default_factory=lambda: np.zeros(3))
    by_triangle: bool = False


class Geometry:
    """The surface of one object.

    Attributes
    ----------
    original
        The object in the file. References to evaluated objects must not be stored.
    lo, hi
        Bounds (3,) in the object's space; inf and -inf for an empty surface.
    deforms
        Whether Blender has reported a changed shape at a frame change.
    lasting
        Whether the surface belongs to an object in the file. Geometry nodes make all other
        surfaces.
    """

    lasting = True

    __slots__ = (
        "_built",
        "_corners",
        "_surface",
        "_triangles",
        "deforms",
        "hi",
        "lo",
        "original",
    )

    def __init__(self, original: Any) -> None:
        self.original = original
        self.lo, self.hi = NOWHERE
        self.deforms = False
        self._surface: Surface | None = None
        self._built = Built()
        self._corners: NDArray[np.int32] | None = None
        self._triangles = np.empty((0, 3), np.int32)

    @property
    def keeps_faces(self) -> bool:
        """Whether animation leaves the faces as they are, so that only an edit can change them."""
        original = self.original
        plain = original.type == "MESH" and original.mode == "OBJECT"
        return plain and all(m.type in DEFORMING_MODIFIERS for m in original.modifiers)

    @property
    def pivot(self) -> Array:
        """The origin (3,) of the BVH tree, in the object's space."""
        return self._built.pivot

    @property
    def state(self) -> Any:
        """The present `Surface`.

        It stays the same Python object until the surface changes, so compare states with `is`.
        """
        return self._surface

    @property
    def vertices(self) -> NDArray[np.float32]:
        """The vertices (n, 3), in the object's space."""
        if self._surface is None:
            return np.empty((0, 3), np.float32)
        return np.ascontiguousarray(self._surface.points.T)

    def triangles(self, depsgraph: Any) -> NDArray[np.int32]:
        """Return the vertex indices (m, 3) of the triangles.

        The array stays the same Python object until a face changes.
        """
        assert self._surface is not None
        corners = self._surface.corners
        if self._corners is None or not np.array_equal(corners, self._corners):
            self._corners = corners
            if self._surface.plain:
                self._triangles = corners.reshape(-1, 3)
            else:
                self._triangles = triangles_of(self.original.evaluated_get(depsgraph))[1]
        return self._triangles

    def read(self, evaluated: Any) -> bool:
        """Read the surface from the evaluated object; return whether the surface changed."""
        return self.take_over(read_surface(evaluated, self.deforms))

    def take_over(self, surface: Surface) -> bool:
        """Replace the surface by a new one; return whether the two differ."""
        if surface is self._surface:
            return False
        if self._surface is not None and surface.same(self._surface):
            return False
        self._surface = surface
        self._built = Built()
        self.lo, self.hi = surface.lo, surface.hi
        return True

    def share(self, other: Geometry) -> bool:
        """Use the surface and the tree of another object of the same mesh.

        Return whether the surface differs from the earlier one.
        """
        before, self._surface = self._surface, other._surface
        self._built, self.lo, self.hi = other._built, other.lo, other.hi
        if before is None or other._surface is None:
            return True
        return before is not other._surface and not before.same(other._surface)

    def tree(self, depsgraph: Any) -> BVHTree | RayTree:
        """Return the BVH tree over all faces; the first call builds it."""
        if self._built.tree is None:
            self._built.tree = self._tree_of(self.original, depsgraph)
        return self._built.tree

    def meet(
        self, depsgraph: Any, starts: Array, ways: Array, limits: Array
    ) -> tuple[Array, NDArray[np.intp]]:
        """Cast rays at the tree; return their distances and the hit faces.

        Parameters
        ----------
        depsgraph
            The evaluated depsgraph.
        starts
            Origins (n, 3) in the object's space, relative to `pivot`.
        ways
            Directions (n, 3), of any length.
        limits
            Maximum distances (n,).

        Returns
        -------
        tuple
            Distances (n,), inf for a miss; and indices (n,) of the hit faces, -1 for a miss.
        """
        tree = self.tree(depsgraph)
        if isinstance(tree, RayTree):
            return tree.meet(starts, ways, limits)
        far, faces = np.full(len(starts), np.inf), np.full(len(starts), -1, np.intp)
        rays = zip(starts.tolist(), ways.tolist(), limits.tolist(), strict=True)
        for ray, (start, way, limit) in enumerate(rays):
            _, _, face, distance = tree.ray_cast(start, way, limit)
            if face is not None:
                far[ray], faces[ray] = distance, face
        return far, faces

    def material_slots(self, depsgraph: Any) -> NDArray[np.int32]:
        """Return the material slot index (n,) of each face of the tree."""
        if not self.deforms:
            self.tree(depsgraph)
        by_triangle = self._built.by_triangle and not self.deforms
        return slots_of(self.original.evaluated_get(depsgraph), by_triangle)

    def materials(self, depsgraph: Any) -> list[int]:
        """Return the session uid of each slot's material; 0 for an empty slot."""
        return uids_of(evaluated_materials(self.original.evaluated_get(depsgraph)))

    def _tree_of(self, source: Any, depsgraph: Any) -> BVHTree | RayTree:
        """Build the tree, with epsilon 0 so that Blender does not shrink the faces."""
        if self._surface is not None and self._surface.large:
            self._built.by_triangle = True
            self._built.pivot = np.zeros(3)
            return RayTree(self.vertices, self.triangles(depsgraph))
        centre = (self.lo + self.hi) / 2
        size = float(np.linalg.norm(self.hi - self.lo))
        self._built.pivot = np.zeros(3)
        if float(np.linalg.norm(centre)) > FAR_FROM_OWN_ORIGIN * size:
            self._built.pivot = centre
            return self._tree_of_triangles(source, depsgraph)
        try:
            return BVHTree.FromObject(source, depsgraph, epsilon=0.0)
        except (ValueError, SystemError):
            # The object is hidden but instanced. Blender 4.2 raises SystemError then.
            return self._tree_of_triangles(source, depsgraph)

    def _tree_of_triangles(self, source: Any, depsgraph: Any) -> BVHTree:
        """Build the tree relative to the pivot, which is slower than `FromObject`."""
        self._built.by_triangle = True
        points, triangles = triangles_of(source.evaluated_get(depsgraph))
        return BVHTree.FromPolygons(
            (points - self.pivot).tolist(), triangles.tolist(), all_triangles=True, epsilon=0.0
        )


def faces_along(tree: Any, point: Array, ahead: Array, step: float) -> int:
    """Return the number of a tree's faces along a ray; 0 if there are MOST_FACES or more.

    Parameters
    ----------
    tree
        The BVH tree.
    point
        Origin (3,) of the ray.
    ahead
        Unit direction (3,) of the ray.
    step
        Faces less than this far apart count as one.
    """
    for count in range(MOST_FACES):
        found = tree.ray_cast(point, ahead)[0]
        if found is None:
            return count
        point = np.array(found) + ahead * step
    return 0


def mesh_shared_by(original: Any) -> int:
    """Return the session uid of the mesh that an object shows unmodified, or 0.

    The result is 0 for an object with modifiers or shape keys, and outside Object Mode. Objects
    with the same uid have the same surface.
    """
    own = original.modifiers or original.mode != "OBJECT"
    if original.type != "MESH" or own or original.data.shape_keys or original.data.is_editmode:
        return 0
    return int(original.data.session_uid)


def evaluated_materials(evaluated: Any) -> Iterator[Any]:
    """Yield the material of each slot of an evaluated object; None for an empty slot."""
    slots = evaluated.material_slots
    # Modifiers can add materials for which the object has no slots.
    of_data = evaluated.data.materials if evaluated.type == "MESH" else ()
    for i in range(max(len(slots), len(of_data))):
        own = i < len(slots) and (slots[i].link == "OBJECT" or i >= len(of_data))
        yield slots[i].material if own else of_data[i]


def uids_of(materials: Iterable[Any]) -> list[int]:
    """Return the session uid of each material; 0 for None."""
    return [material.original.session_uid if material else 0 for material in materials]


def slots_of(evaluated: Any, by_triangle: bool) -> NDArray[np.int32]:
    """Return the material slot index of each face; of each triangle if `by_triangle` is True."""
    with surface_mesh(evaluated) as mesh:
        slots = np.zeros(len(mesh.polygons) if mesh else 0, np.int32)
        if not len(slots):
            return slots
        mesh.polygons.foreach_get("material_index", slots)
        if by_triangle:
            mesh.calc_loop_triangles()
            polygons = np.empty(len(mesh.loop_triangles), np.int32)
            mesh.loop_triangles.foreach_get("polygon_index", polygons)
            slots = slots[polygons]
        return slots


@contextmanager
def surface_mesh(evaluated: Any) -> Iterator[Any]:
    """Context manager: on entry, give the mesh of an object's surface or None; on exit, free it.

    The mesh is valid only within the `with` block.
    """
    # In Edit Mode the evaluated mesh is empty, and `to_mesh` gives the shown mesh.
    if evaluated.type == "MESH" and not evaluated.data.is_editmode:
        yield evaluated.data
        return
    mesh = evaluated.to_mesh()
    try:
        yield mesh
    finally:
        evaluated.to_mesh_clear()


def _bounds(axes: NDArray[np.float32]) -> tuple[Array, Array]:
    """Return the bounds (3,), (3,) of the finite points among n points (3, n)."""
    lo, hi = axes.min(axis=1), axes.max(axis=1)
    if not (np.isfinite(lo).all() and np.isfinite(hi).all()):
        # A vertex that is not finite removes its own faces, not the others.
        axes = axes[:, np.isfinite(axes).all(axis=0)]
        if not axes.size:
            return NOWHERE
        lo, hi = axes.min(axis=1), axes.max(axis=1)
    return lo.astype(np.float64), hi.astype(np.float64)


def read_surface(
    evaluated: Any, with_triangles: bool = False, like: Surface | None = None
) -> Surface:
    """Return a copy of the surface of an evaluated object.

    Parameters
    ----------
    evaluated
        The evaluated object.
    with_triangles
        Whether to copy the triangles of quads and n-gons too.
    like
        A surface of the object with the same faces, whose array `corners` is shared; None to copy.
    """
    with surface_mesh(evaluated) as mesh:
        if mesh is None or not len(mesh.polygons):
            return Surface(np.empty((3, 0), np.float32), np.empty(0, np.int32), 0)
        # Attributes are copied as a whole; vertex by vertex takes 500 times as long.
        coordinates = np.empty(len(mesh.vertices) * 3, np.float32)
        mesh.attributes["position"].data.foreach_get("vector", coordinates)
        if like is not None and len(like.corners) == len(mesh.loops):
            corners = like.corners
        else:
            corners = np.empty(len(mesh.loops), np.int32)
            mesh.attributes[".corner_vert"].data.foreach_get("value", corners)
        faces, triangles = len(mesh.polygons), None
        if with_triangles and len(corners) != 3 * faces:
            # The triangles of a face can change with its shape.
            triangles = _cut_into_triangles(mesh)
    points = np.ascontiguousarray(coordinates.reshape(-1, 3).T)
    return Surface(points, corners, faces, triangles)


def _cut_into_triangles(mesh: Any) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    mesh.calc_loop_triangles()
    count = len(mesh.loop_triangles)
    triangles, of = np.empty(count * 3, np.int32), np.empty(count, np.int32)
    mesh.loop_triangles.foreach_get("vertices", triangles)
    mesh.loop_triangles.foreach_get("polygon_index", of)
    return np.ascontiguousarray(triangles.reshape(-1, 3).T).astype(np.intp), of.astype(np.intp)


def triangles_of(evaluated: Any) -> tuple[Array, NDArray[np.int32]]:
    """Return the vertices (n, 3) and triangles (m, 3) of a surface, in the object's space."""
    if evaluated.type not in SURFACE_TYPES:
        return np.empty((0, 3)), np.empty((0, 3), np.int32)
    with surface_mesh(evaluated) as mesh:
        if mesh is None or not len(mesh.polygons):
            return np.empty((0, 3)), np.empty((0, 3), np.int32)
        coordinates = np.empty(len(mesh.vertices) * 3, np.float32)
        mesh.attributes["position"].data.foreach_get("vector", coordinates)
        mesh.calc_loop_triangles()
        triangles = np.empty(len(mesh.loop_triangles) * 3, np.int32)
        mesh.loop_triangles.foreach_get("vertices", triangles)
    return coordinates.reshape(-1, 3).astype(np.float64), triangles.reshape(-1, 3)


class MadeByNodes(Geometry):
    """The surface of an instance whose mesh was made by geometry nodes.

    No object in the file has this mesh, and Blender frees it once the next instance is listed. So
    all data are copied while `seen`, the evaluated object of the instance, is valid.
    """

    __slots__ = ("_faces", "_materials", "_slots")

    lasting = False

    def __init__(self, seen: Any) -> None:
        super().__init__(None)
        self.read(seen)
        self._materials = uids_of(evaluated_materials(seen))
        self._faces = self._slots = slots_of(seen, by_triangle=False)

    def same(self, other: Any) -> bool:
        """Return whether another surface has the same points, faces and materials."""
        return (
            isinstance(other, MadeByNodes)
            and self._surface is not None
            and other._surface is not None
            and self._surface.same(other._surface)
            and self._materials == other._materials
            and np.array_equal(self._faces, other._faces)
        )

    def finish(self, seen: Any, depsgraph: Any) -> None:
        """Copy the triangles and build the tree.

        Call this only if the surface has changed, since it takes long.
        """
        self._triangles = triangles_of(seen)[1]
        if np.isfinite(self.lo).all():
            self._built.tree = self._tree_of(seen, depsgraph)
            if self._built.by_triangle:
                self._slots = slots_of(seen, by_triangle=True)

    def triangles(self, depsgraph: Any) -> NDArray[np.int32]:
        """Return the vertex indices (m, 3) of the triangles, as copied."""
        return self._triangles

    def tree(self, depsgraph: Any) -> BVHTree | RayTree:
        """Return the tree that `finish` built."""
        assert self._built.tree is not None, "rays hit only objects that have a bounding box"
        return self._built.tree

    def material_slots(self, depsgraph: Any) -> NDArray[np.int32]:
        """Return the material slot index (n,) of each face, as copied."""
        return self._slots

    def materials(self, depsgraph: Any) -> list[int]:
        """Return the session uid of each slot's material, as copied."""
        return self._materials


def made_shape(
    depsgraph: Any, seen: Any, made: dict[int, MadeByNodes], last: Geometry | None
) -> MadeByNodes:
    """Return the surface of an instance whose mesh was made by geometry nodes.

    All instances of one mesh share the surface.

    Parameters
    ----------
    depsgraph
        The evaluated depsgraph.
    seen
        The evaluated object of the instance.
    made
        Surfaces from this pass over the instances, by pointer of the mesh; a new one is added.
    last
        The instance's surface at the previous pass; it is returned if nothing has changed.
    """
    pointer = seen.data.as_pointer()
    if pointer not in made:
        found = MadeByNodes(seen)
        if isinstance(last, MadeByNodes) and found.same(last):
            found = last
        else:
            found.finish(seen, depsgraph)
        made[pointer] = found
    return made[pointer]
