# SPDX-License-Identifier: GPL-3.0-or-later
"""The evaluated shape of an object, or of what geometry nodes make: its bounds, and a bounding
volume hierarchy when needed."""

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
# A mesh this many times farther from its own origin than it is large loses digits in single
# precision; its tree is then built about its centre.
FAR_FROM_OWN_ORIGIN = 8.0
# From so many triangles on a tree of Blender's takes too long to build, and too much memory.
LARGE = 250_000
# Most faces to count along a ray.
MOST_FACES = 200
# Bounds of what is empty.
NOWHERE: tuple[Array, Array] = (np.full(3, np.inf), np.full(3, -np.inf))


@dataclass(eq=False)
class Surface:
    """A mesh as it was at a frame: `points` (3, n), by axis, as numpy is quick with; `corners`
    (k,): the point of each corner of its `faces`; `lo`, `hi` (3,): its bounds, inf where it is
    empty."""

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
        """Whether it has too many triangles to be asked one by one, or for a tree of Blender's."""
        return len(self.corners) - 2 * self.faces >= LARGE

    @property
    def bytes(self) -> int:
        """Memory for the points, and for all that is made of them later."""
        return self.points.nbytes * (4 if self.large else 1)

    def meet(self, starts: Array, ways: Array) -> tuple[Array, NDArray[np.intp]]:
        """How far (n,) rays go, in lengths of their ways, to the nearest face of a large surface,
        inf where there is none; and which (n,) that is."""
        corners, face = (self.corners.reshape(-1, 3), None) if self.plain else self.triangles
        if self._tree is None:
            by_triangle = corners if face is None else corners.T
            points = np.ascontiguousarray(self.points.T)
            self._tree = RayTree(points, np.ascontiguousarray(by_triangle, np.int32))
        far, met = self._tree.meet(starts, ways, np.full(len(starts), np.inf))
        return far / np.linalg.norm(ways, axis=1), met if face is None else face[met]

    @property
    def triangles(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """(3, m): the points of triangles, and the face (m,) that each is of. Of one that is not
        plain only where they were asked for when it was read."""
        if self._triangles is None:
            by_corner = np.ascontiguousarray(self.corners.reshape(-1, 3).T).astype(np.intp)
            self._triangles = by_corner, np.arange(self.faces)
        return self._triangles

    def has_faces_of(self, other: Surface) -> bool:
        """Whether another has the same faces; then what is known of them is taken over."""
        known = self.corners is other.corners
        if self.faces != other.faces or not (known or np.array_equal(self.corners, other.corners)):
            return False
        self.corners = other.corners
        if self.plain:
            self._triangles = other._triangles
        return True

    def same(self, other: Surface) -> bool:
        """Whether another is the same mesh in the same place."""
        return self.has_faces_of(other) and np.array_equal(self.points, other.points)


@dataclass
class Built:
    """What is made from a surface when it is needed, once for all objects of one mesh: its `tree`
    about the `pivot` (3,), whose faces are triangles or those of the mesh."""

    tree: BVHTree | RayTree | None = None
    pivot: Array = field(default_factory=lambda: np.zeros(3))
    by_triangle: bool = False


class Geometry:
    """Surface of one object in its own space; `lo`, `hi` (3,) its bounds, inf where empty.

    `original` is the object of the file that has the shape: of it, never of what is evaluated, a
    reference may be kept. `deforms` once Blender named it as one whose shape may change from frame
    to frame.
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
        """Whether nothing but an edit can give it other faces."""
        original = self.original
        plain = original.type == "MESH" and original.mode == "OBJECT"
        return plain and all(m.type in DEFORMING_MODIFIERS for m in original.modifiers)

    @property
    def pivot(self) -> Array:
        """The point (3,) of its space where the tree has its origin."""
        return self._built.pivot

    @property
    def state(self) -> Any:
        """Another object whenever the surface has changed."""
        return self._surface

    @property
    def vertices(self) -> NDArray[np.float32]:
        """(n, 3), in the object's own space."""
        if self._surface is None:
            return np.empty((0, 3), np.float32)
        return np.ascontiguousarray(self._surface.points.T)

    def triangles(self, depsgraph: Any) -> NDArray[np.int32]:
        """(m, 3) vertices of triangles; the same array as long as the faces stay."""
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
        """Reads the surface of the evaluated object; True where it differs from before."""
        return self.take_over(read_surface(evaluated, self.deforms))

    def take_over(self, surface: Surface) -> bool:
        """The surface is another from now on; True where it differs from before."""
        if surface is self._surface:
            return False
        if self._surface is not None and surface.same(self._surface):
            # Its triangles may not have been asked for before.
            self._surface._triangles = self._surface._triangles or surface._triangles
            return False
        self._surface = surface
        self._built = Built()
        self.lo, self.hi = surface.lo, surface.hi
        return True

    def share(self, other: Geometry) -> bool:
        """Takes over the surface of another object of the same mesh, as just read; True where it
        differs from before."""
        before, self._surface = self._surface, other._surface
        self._built, self.lo, self.hi = other._built, other.lo, other.hi
        if before is None or other._surface is None:
            return True
        return before is not other._surface and not before.same(other._surface)

    def tree(self, depsgraph: Any) -> BVHTree | RayTree:
        """The hierarchy over all faces, built when first asked for."""
        if self._built.tree is None:
            self._built.tree = self._tree_of(self.original, depsgraph)
        return self._built.tree

    def meet(
        self, depsgraph: Any, starts: Array, ways: Array, limits: Array
    ) -> tuple[Array, NDArray[np.intp]]:
        """How far (n,) rays go in the space of the tree to its nearest face within their limits,
        inf where there is none, and which (n,) that is, or -1."""
        tree = self.tree(depsgraph)
        if isinstance(tree, RayTree):
            return tree.meet(starts, ways, limits)
        far, met = np.full(len(starts), np.inf), np.full(len(starts), -1, np.intp)
        rays = zip(starts.tolist(), ways.tolist(), limits.tolist(), strict=True)
        for ray, (start, way, limit) in enumerate(rays):
            _, _, face, distance = tree.ray_cast(start, way, limit)
            if face is not None:
                far[ray], met[ray] = distance, face
        return far, met

    def material_slots(self, depsgraph: Any) -> NDArray[np.int32]:
        """The number (n,) of the material slot of each face, as the tree counts faces."""
        if not self.deforms:
            self.tree(depsgraph)
        by_triangle = self._built.by_triangle and not self.deforms
        return slots_of(self.original.evaluated_get(depsgraph), by_triangle)

    def materials(self, depsgraph: Any) -> list[int]:
        """The session uid of the material of each slot; 0 where there is none."""
        return uids_of(evaluated_materials(self.original.evaluated_get(depsgraph)))

    def _tree_of(self, source: Any, depsgraph: Any) -> BVHTree | RayTree:
        """The hierarchy of an object, in the file or as just listed. Epsilon 0 leaks nowhere."""
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
            # A hidden object that is instanced; SystemError is Blender 4.2's way to say so.
            return self._tree_of_triangles(source, depsgraph)

    def _tree_of_triangles(self, source: Any, depsgraph: Any) -> BVHTree:
        """The slower way: through Python, about the pivot."""
        self._built.by_triangle = True
        points, triangles = triangles_of(source.evaluated_get(depsgraph))
        return BVHTree.FromPolygons(
            (points - self.pivot).tolist(), triangles.tolist(), all_triangles=True, epsilon=0.0
        )


def faces_along(tree: Any, point: Array, ahead: Array, step: float) -> int:
    """The number of a tree's faces that a ray meets from `point` (3,) along the unit `ahead` (3,),
    less than `step` apart counted as one; 0 for MOST_FACES and more."""
    for count in range(MOST_FACES):
        found = tree.ray_cast(point, ahead)[0]
        if found is None:
            return count
        point = np.array(found) + ahead * step
    return 0


def mesh_shared_by(original: Any) -> int:
    """What all objects have in common whose surface is this object's mesh as it is; 0: its surface
    is its own."""
    own = original.modifiers or original.mode != "OBJECT"
    if original.type != "MESH" or own or original.data.shape_keys or original.data.is_editmode:
        return 0
    return int(original.data.session_uid)


def evaluated_materials(evaluated: Any) -> Iterator[Any]:
    """The material of each slot of an evaluated object; None where there is none."""
    slots = evaluated.material_slots
    # Modifiers can bring materials that the object has no slots for.
    of_data = evaluated.data.materials if evaluated.type == "MESH" else ()
    for i in range(max(len(slots), len(of_data))):
        own = i < len(slots) and (slots[i].link == "OBJECT" or i >= len(of_data))
        yield slots[i].material if own else of_data[i]


def uids_of(materials: Iterable[Any]) -> list[int]:
    return [material.original.session_uid if material else 0 for material in materials]


def slots_of(evaluated: Any, by_triangle: bool) -> NDArray[np.int32]:
    """The number (n,) of the material slot of each face, or of each triangle."""
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
    """The mesh of an object's surface, which may be None, for as long as the block lasts."""
    # In Edit Mode the evaluated mesh is empty: what is shown is still in the editor's hands.
    if evaluated.type == "MESH" and not evaluated.data.is_editmode:
        yield evaluated.data
        return
    mesh = evaluated.to_mesh()
    try:
        yield mesh
    finally:
        evaluated.to_mesh_clear()


def _bounds(axes: NDArray[np.float32]) -> tuple[Array, Array]:
    """The bounds of the finite ones among points (3, n)."""
    lo, hi = axes.min(axis=1), axes.max(axis=1)
    if not (np.isfinite(lo).all() and np.isfinite(hi).all()):
        # A vertex that is nowhere takes its own faces away, not the others.
        axes = axes[:, np.isfinite(axes).all(axis=0)]
        if not axes.size:
            return NOWHERE
        lo, hi = axes.min(axis=1), axes.max(axis=1)
    return lo.astype(np.float64), hi.astype(np.float64)


def read_surface(
    evaluated: Any, with_triangles: bool = False, like: Surface | None = None
) -> Surface:
    """The surface of an evaluated object, copied; `like`: one that has the same faces."""
    with surface_mesh(evaluated) as mesh:
        if mesh is None or not len(mesh.polygons):
            return Surface(np.empty((3, 0), np.float32), np.empty(0, np.int32), 0)
        # As attributes they are copied whole; vertex by vertex it takes 500 times as long.
        coordinates = np.empty(len(mesh.vertices) * 3, np.float32)
        mesh.attributes["position"].data.foreach_get("vector", coordinates)
        if like is not None and len(like.corners) == len(mesh.loops):
            corners = like.corners
        else:
            corners = np.empty(len(mesh.loops), np.int32)
            mesh.attributes[".corner_vert"].data.foreach_get("value", corners)
        faces, triangles = len(mesh.polygons), None
        if with_triangles and len(corners) != 3 * faces:
            # How a face is cut can change with its shape.
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
    """Vertices (n, 3) and triangles (m, 3) of an object's surface, in its own space."""
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


# The shape of what geometry nodes make and instance: a mesh that no object of the file has.


class MadeByNodes(Geometry):
    """It is gone as soon as Blender lists the next instance: all that is ever asked of it is copied
    then, while it is `seen`."""

    __slots__ = ("_faces", "_materials", "_slots")

    lasting = False

    def __init__(self, seen: Any) -> None:
        super().__init__(None)
        self.read(seen)
        self._materials = uids_of(evaluated_materials(seen))
        self._faces = self._slots = slots_of(seen, by_triangle=False)

    def same(self, other: Any) -> bool:
        """Whether another is made of the same faces and materials."""
        return (
            isinstance(other, MadeByNodes)
            and self._surface is not None
            and other._surface is not None
            and self._surface.same(other._surface)
            and self._materials == other._materials
            and np.array_equal(self._faces, other._faces)
        )

    def finish(self, seen: Any, depsgraph: Any) -> None:
        """Copies what takes long, where no equal one is known."""
        self._triangles = triangles_of(seen)[1]
        if np.isfinite(self.lo).all():
            self._built.tree = self._tree_of(seen, depsgraph)
            if self._built.by_triangle:
                self._slots = slots_of(seen, by_triangle=True)

    def triangles(self, depsgraph: Any) -> NDArray[np.int32]:
        return self._triangles

    def tree(self, depsgraph: Any) -> BVHTree | RayTree:
        assert self._built.tree is not None, "rays meet only what has bounds"
        return self._built.tree

    def material_slots(self, depsgraph: Any) -> NDArray[np.int32]:
        return self._slots

    def materials(self, depsgraph: Any) -> list[int]:
        return self._materials


def made_shape(
    depsgraph: Any, seen: Any, made: dict[int, MadeByNodes], last: Geometry | None
) -> MadeByNodes:
    """The shape of an instance of what nodes made, shared by all instances of the same mesh in this
    listing; `last`, where it is as it was then."""
    pointer = seen.data.as_pointer()
    if pointer not in made:
        found = MadeByNodes(seen)
        if isinstance(last, MadeByNodes) and found.same(last):
            found = last
        else:
            found.finish(seen, depsgraph)
        made[pointer] = found
    return made[pointer]
