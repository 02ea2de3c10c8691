# SPDX-License-Identifier: GPL-3.0-or-later
"""Keep a list of the solids that the viewport shows, and update it cheaply from frame to frame.

Solids are what `scene.ray_cast` hits: evaluated meshes, curves with a surface, text, metaballs and
instances of these. Objects that are hidden in the viewport, or have `angen_ignored`, are left out.
"""

from __future__ import annotations

from collections import defaultdict
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ....sensor_logic.model import Array
from ..animation import may_set
from ..instances import UNUSED_LEVEL, Paths, Uid, chain, is_housing, parts_of_instances
from ..timed import INSTANCING_MODIFIERS
from .geometry import SURFACE_TYPES, Geometry, MadeByNodes, made_shape, mesh_shared_by


def pointers_of(depsgraph: Any) -> list[int]:
    """Return the pointers of a depsgraph's objects, which change if objects appear or vanish."""
    return [evaluated.as_pointer() for evaluated in depsgraph.objects]


def name_of(original: Any, owner: Any, made_by_nodes: bool) -> str:
    """Return the name of a solid as users see it.

    It is the name of the object `owner`, or "OBJECT in OWNER" if that object instances another one.
    """
    if original == owner or made_by_nodes:
        return str(owner.name)
    return f"{original.name} in {owner.name}"


def is_own_surface(instance: Any, original: Any, owner: Any) -> bool:
    """Return whether an instance is merely the mesh of a curve or text object.

    Blender lists curves and text twice: as themselves, and as an instance of their mesh.
    """
    return (
        original == owner and original.type != "MESH" and instance.persistent_id[1] == UNUSED_LEVEL
    )


def is_transient(depsgraph: Any, seen: Any, original: Any) -> bool:
    """Return whether geometry nodes made an instance's mesh, so that no object in the file has it.

    `seen` is the evaluated object of the instance, and `original` its object in the file.
    """
    data = original.evaluated_get(depsgraph).data
    return data is None or seen.data.as_pointer() != data.as_pointer()


# Bounds are widened by this many Blender units, and by the rounding of single precision at their
# distance. So rays that hit a flat object also cross its bounds.
PADDING = 1e-5
RELATIVE_PADDING = 1e-6
# Indices of the next row or column of a 3 × 3 matrix, and of the one after, in cyclic order.
BELOW = RIGHT = np.array([1, 2, 0])
ABOVE = LEFT = np.array([2, 0, 1])


def matrices_of(flat: NDArray[np.float32]) -> Array:
    """Return matrices (n, 4, 4) from values (n, 16) that `foreach_get` wrote column by column."""
    return flat.reshape(-1, 4, 4).transpose(0, 2, 1).astype(np.float64)


def invertible(matrix: Array) -> NDArray[np.bool_]:
    """Return the mask (…,) of the matrices (…, 4, 4) that have an inverse."""
    with np.errstate(all="ignore"):
        determinant = _determinant(matrix, _cofactors(matrix))
        good = np.isfinite(matrix).all(axis=(-2, -1)) & (determinant != 0.0)
        result: NDArray[np.bool_] = good & np.isfinite(determinant)
    return result


def inverted(matrix: Array) -> Array:
    """Return the inverses of affine, invertible matrices (…, 4, 4), by their cofactors."""
    # numpy's `inv` calls LAPACK, whose threads wait for each other: 4 ms a matrix inside Blender.
    cofactors = _cofactors(matrix)
    inverse = np.zeros_like(matrix)
    turn = inverse[..., :3, :3]
    turn[...] = cofactors.swapaxes(-2, -1) / _determinant(matrix, cofactors)[..., None, None]
    inverse[..., :3, 3] = -(turn @ matrix[..., :3, 3:])[..., 0]
    inverse[..., 3, 3] = 1.0
    return inverse


def _cofactors(matrix: Array) -> Array:
    """Return the cofactors (…, 3, 3) of the linear parts of matrices (…, 4, 4)."""
    right, left = matrix[..., RIGHT], matrix[..., LEFT]
    return right[..., BELOW, :] * left[..., ABOVE, :] - left[..., BELOW, :] * right[..., ABOVE, :]


def _determinant(matrix: Array, cofactors: Array) -> Array:
    return np.asarray((matrix[..., 0, :3] * cofactors[..., 0, :]).sum(axis=-1))


def world_bounds(
    matrix: Array, invertible: NDArray[np.bool_], lo: Array, hi: Array
) -> tuple[Array, Array]:
    """Return the bounds of solids in the world, computed from the bounds in their own spaces.

    Parameters
    ----------
    matrix
        Matrices (…, 4, 4) to the world.
    invertible
        Mask (…,) of the matrices that have an inverse.
    lo, hi
        Bounds (…, 3) in the space of each solid.

    Returns
    -------
    tuple
        Bounds (…, 3), (…, 3), slightly widened. They are empty (inf, -inf) if the matrix has no
        inverse or a bound is not finite.
    """
    turn = matrix[..., :3, :3]
    with np.errstate(all="ignore"):
        good = (invertible & np.isfinite(lo).all(axis=-1))[..., None]
        centre = (turn @ ((lo + hi) / 2)[..., None])[..., 0] + matrix[..., :3, 3]
        half = (np.abs(turn) @ ((hi - lo) / 2)[..., None])[..., 0]
        half += PADDING + RELATIVE_PADDING * (np.abs(centre) + half)
    return np.where(good, centre - half, np.inf), np.where(good, centre + half, -np.inf)


Key = tuple[int, ...]
# Looked up once: each evaluation compares the type of each changed datablock with it.
OBJECT = bpy.types.Object


class Solid:
    """A visible object or instance that rays can hit.

    Attributes
    ----------
    key
        Session uids that identify the solid whenever the solids are listed.
    number
        The solid's number, which no other solid gets later.
    original
        The object in the file whose surface the solid has.
    owner
        The same object, or the object that makes the instance.
    owners
        Session uids of `owner` and its parents, and paths of sensors in instances that hold the
        solid.
    is_housing
        Whether it is the housing of a sensor, which all sensors see through.
    moving
        Whether the solid has changed at least once.
    name
        The name for users.
    geometry
        The surface.
    row
        The row in `Solids`.
    """

    __slots__ = (
        "geometry",
        "is_housing",
        "key",
        "moving",
        "name",
        "number",
        "original",
        "owner",
        "owners",
        "row",
    )

    def __init__(self, key: Key, number: int, moving: bool) -> None:
        self.key = key
        self.number = number
        self.moving = moving
        self.name = ""
        self.original: Any = None
        self.owner: Any = None
        self.owners: frozenset[Uid] = frozenset()
        self.is_housing = False
        self.geometry: Geometry
        self.row = -1

    def is_passed_by(self, uid: Uid) -> bool:
        """Return whether the rays of a sensor pass through the solid."""
        return self.is_housing or uid in self.owners


class Solids:
    """The list of n solids, with arrays that have a row for each.

    Attributes
    ----------
    matrix, inverse
        Matrices (n, 4, 4) to the world and back, in float64.
    lo, hi
        World bounds (n, 3).
    moving
        Mask (n,) of the solids that have changed at least once.
    version
        The value (n,) of `syncs` at which the solid last moved or changed shape.
    syncs
        The number of frames that were read so far.
    listing
        The number of times that the whole list was made.
    edits
        The number of calls of `forget`, each after a possible edit.
    gone
        Numbers of still solids that vanished or began to move. Stored hits on them are void.
    instanced
        Session uids of objects that other objects instance.
    must_list
        Whether the whole list must be made again at the next frame.
    reshaped
        Session uids of objects whose shape was reported as changed since `clear_noted`.
    bends
        Session uids of objects that change shape at frame changes.
    """

    def __init__(self) -> None:
        self.solids: list[Solid] = []
        self.matrix = np.empty((0, 4, 4))
        self._inverse = np.empty((0, 4, 4))
        self.lo = np.empty((0, 3))
        self.hi = np.empty((0, 3))
        self.moving = np.empty(0, bool)
        self.version = np.empty(0, np.int64)
        self.listing = 0
        self.gone: list[int] = []
        self._invertible = np.empty(0, bool)
        self._not_inverted: set[int] = set()
        self._by_key: dict[Key, Solid] = {}
        self._by_shape: dict[int, list[Solid]] = {}
        self._shapes: dict[int, Geometry] = {}
        self._numbers = 0
        self.syncs = 0
        self.edits = 0
        self._listed: list[int] = []
        self._same_depsgraph = 0
        self._scene_noted = True
        self.instanced: set[int] = set()
        # Session uids of objects that make instances or are instanced, also in collections.
        self._of_instances: set[int] = set()
        self.must_list = True
        # Session uids of objects without instancing modifiers, until the next edit.
        self._plain: set[int] = set()
        self._unsure = False
        self._touched: set[int] = set()
        # By mesh, a geometry whose surface was read for the present list.
        self._read_now: dict[int, Geometry] = {}
        self.reshaped: set[int] = set()
        self.bends: set[int] = set()

    def note(self, depsgraph: Any, edited: bool, by_frame: bool = True) -> None:
        """Store the changes that a depsgraph reports. Call this in Blender's handlers.

        Parameters
        ----------
        depsgraph
            The evaluated depsgraph.
        edited
            Whether anything but the frame may have changed, such as an object's visibility.
        by_frame
            Whether a frame change caused the report, which then names all changed objects.
        """
        if edited:
            self.forget()
        self._scene_noted |= depsgraph.id_type_updated("SCENE")
        for update in depsgraph.updates:
            changed = update.id
            if not isinstance(changed, OBJECT):
                continue
            original = changed.original
            uid = original.session_uid
            self._touched.add(uid)
            if original.is_instancer or (uid not in self._plain and self._may_instance(original)):
                self.must_list = True
            if update.is_updated_geometry:
                self.reshaped.add(uid)
                if by_frame:
                    self.bends.add(uid)

    def _may_instance(self, original: Any) -> bool:
        may = any(m.type in INSTANCING_MODIFIERS for m in original.modifiers)
        if not may:
            self._plain.add(original.session_uid)
        return may

    def has_noted(self, uids: set[int]) -> bool:
        """Return whether `note` has stored a change of the scene or of one of the objects `uids`.

        Changes are stored until `list_again` or `clear_noted`. These include changes that a
        script made just before it changed the frame.
        """
        return self._scene_noted or not uids.isdisjoint(self._touched)

    def forget(self) -> None:
        """Have everything read again at the next frame. Call this after any edit."""
        self.edits += 1
        self._plain.clear()
        self.must_list = True
        self._unsure = True

    @property
    def inverse(self) -> Array:
        """The inverses (n, 4, 4) of the matrices; undefined for a matrix that has no inverse."""
        if self._not_inverted:
            rows = np.array(sorted(self._not_inverted), np.intp)
            self._not_inverted.clear()
            good = self._invertible[rows, None, None]
            self._inverse[rows] = inverted(np.where(good, self.matrix[rows], np.eye(4)))
        return self._inverse

    def is_current(self, depsgraph: Any) -> bool:
        """Return whether the list has exactly the objects of the depsgraph."""
        return self.is_settled and self.has_objects_of(depsgraph, self._listed)

    def has_objects_of(self, depsgraph: Any, listed: list[int]) -> bool:
        """Return whether a depsgraph holds exactly the objects `listed` (see `pointers_of`).

        The comparison is skipped for the depsgraph from which the list was made. It is needed only
        if keyframes, drivers or scripts can show or hide objects.
        """
        is_same = not self._scene_noted and depsgraph.as_pointer() == self._same_depsgraph
        return is_same or pointers_of(depsgraph) == listed

    @property
    def is_settled(self) -> bool:
        """Whether no stored change requires a new list of solids."""
        return not self.must_list and self._of_instances.isdisjoint(self._touched)

    def owned_by(self, uid: Uid) -> NDArray[np.bool_]:
        """Return the mask (n,) of the solids that belong to a sensor: its mesh and its children."""
        return np.fromiter((uid in s.owners for s in self.solids), bool, len(self.solids))

    def passed_by(self, uid: Uid) -> NDArray[np.bool_]:
        """Return the mask (n,) of the solids that the rays of a sensor pass through.

        These are its own, and the housings of all sensors.
        """
        return np.fromiter((s.is_passed_by(uid) for s in self.solids), bool, len(self.solids))

    def clear_noted(self) -> None:
        """Delete the stored changes, once the list or a copied frame includes them."""
        self._scene_noted = False
        self.reshaped.clear()
        self._touched.clear()

    def shape_of(self, uid: int) -> Geometry | None:
        """Return the surface of the object of session uid `uid`; None if no solid has it."""
        return self._shapes.get(uid)

    def rows_of_shape(self, uid: int) -> list[int]:
        """Return the rows of the solids with the surface of the object of session uid `uid`."""
        return [solid.row for solid in self._by_shape.get(uid, ())]

    def show(
        self,
        rows: NDArray[np.intp],
        matrix: Array,
        lo: Array,
        hi: Array,
        version: NDArray[np.int64],
    ) -> None:
        """Set matrices (k, 4, 4), bounds (k, 3) and versions (k,) of the solids `rows` (k,)."""
        self.matrix[rows], self.lo[rows], self.hi[rows] = matrix, lo, hi
        self.version[rows] = version
        self._mark_inverse(rows)

    def row_of(self, key: Key) -> int | None:
        """Return the row of the solid with a key; None if there is no such solid."""
        solid = self._by_key.get(key)
        return None if solid is None else solid.row

    def name_of(self, number: int) -> str:
        """Return the name for users of the solid with a number; empty if the solid is gone."""
        return next((s.name for s in self.solids if s.number == number), "")

    def _set_moving(self, solid: Solid) -> None:
        if not solid.moving:
            solid.moving = True
            self.moving[solid.row] = True
            self.gone.append(solid.number)

    def set_moving(self, rows: NDArray[np.intp]) -> None:
        for row in rows.tolist():
            self._set_moving(self.solids[row])

    def _mark_inverse(self, rows: NDArray[np.intp]) -> None:
        """Store which matrices `rows` are invertible, and that their inverses are outdated."""
        self._invertible[rows] = invertible(self.matrix[rows])
        self._not_inverted.update(rows.tolist())

    def _update_bounds(self, rows: NDArray[np.intp]) -> None:
        """Compute the world bounds of the solids `rows`.

        They are empty for a solid that is scaled to zero or has coordinates that are not finite.
        """
        self.version[rows] = self.syncs
        shapes = [self.solids[row].geometry for row in rows.tolist()]
        lo, hi = np.array([shape.lo for shape in shapes]), np.array([shape.hi for shape in shapes])
        good = self._invertible[rows]
        self.lo[rows], self.hi[rows] = world_bounds(self.matrix[rows], good, lo, hi)

    def list_again(self, depsgraph: Any) -> None:
        """Make the list from an evaluated scene. Solids that are still present keep their numbers.

        Call this method whenever `is_current` returns False.
        """
        self.syncs += 1
        self._listed = pointers_of(depsgraph)
        before, self._by_key = self._by_key, {}
        self.solids, self.instanced = [], set()
        made: dict[int, MadeByNodes] = {}
        shapes: dict[int, Geometry] = {}
        paths = Paths()
        # The cells of all matrices: one array takes half the time of one array each.
        cells: list[float] = []
        # Present and earlier rows of solids that were still so far; -1: the shape changed.
        stood: list[tuple[int, int]] = []
        holders: set[Any] = set()
        view_layer = depsgraph.scene.original.view_layers[depsgraph.view_layer.name]
        for instance in depsgraph.object_instances:
            seen = instance.object
            if not instance.show_self or seen.type not in SURFACE_TYPES:
                continue
            original = seen.original
            owner = instance.parent.original if instance.is_instance else original
            if instance.is_instance and is_own_surface(instance, original, owner):
                continue
            if instance.is_instance:
                self.instanced.add(original.session_uid)
                holders.add(owner)
            if original.angen_ignored or owner.angen_ignored:
                continue
            # A collection with a closed eye has its objects in the depsgraph all the same.
            if not owner.visible_get(view_layer=view_layer):
                continue
            key: Key = (original.session_uid,)
            if instance.is_instance:
                key += (owner.session_uid, *instance.persistent_id)
            made_by_nodes = instance.is_instance and is_transient(depsgraph, seen, original)
            solid = before.pop(key, None)
            geometry: Geometry
            if made_by_nodes:
                last = solid.geometry if solid is not None else None
                geometry = made_shape(depsgraph, seen, made, last)
                reshaped = geometry is not last
            else:
                geometry, reshaped = self._shape(depsgraph, original, shapes)
            cells += [cell for row in instance.matrix_world for cell in row]
            if solid is None:
                self._numbers += 1
                solid = Solid(key, self._numbers, moving=self.listing > 0)
            elif not solid.moving:
                stood.append((len(self.solids), -1 if reshaped else solid.row))
            solid.geometry = geometry
            solid.name = name_of(original, owner, made_by_nodes)
            solid.original, solid.owner = original, owner
            solid.owners = frozenset(obj.session_uid for obj in chain(owner))
            solid.is_housing = is_housing(original)
            if instance.is_instance:
                solid.owners |= paths.owners(instance)
            self._by_key[key] = solid
            self.solids.append(solid)
        self.gone += [solid.number for solid in before.values() if not solid.moving]
        self._shapes = shapes
        self._of_instances = self.instanced | set(parts_of_instances(holders))
        self._finish_list(depsgraph, np.array(cells).reshape(-1, 4, 4), stood)

    def _finish_list(self, depsgraph: Any, matrices: Array, stood: list[tuple[int, int]]) -> None:
        now, then = np.array(stood, np.intp).reshape(-1, 2).T
        for row in now[(then < 0) | (matrices[now] != self.matrix[then]).any((1, 2))].tolist():
            self.solids[row].moving = True
            self.gone.append(self.solids[row].number)
        count, self.matrix = len(self.solids), matrices
        self._inverse = np.empty((count, 4, 4))
        self._not_inverted.clear()
        self.lo, self.hi = np.empty((count, 3)), np.empty((count, 3))
        self.version = np.empty(count, np.int64)
        self._invertible = np.empty(count, bool)
        self.moving = np.fromiter((s.moving for s in self.solids), bool, count)
        for row, solid in enumerate(self.solids):
            solid.row = row
        if count:
            self._mark_inverse(np.arange(count))
            self._update_bounds(np.arange(count))
        self._by_shape = defaultdict(list)
        for solid in self.solids:
            self._by_shape[solid.key[0]].append(solid)
        self.must_list = self._unsure = False
        self.clear_noted()
        self._read_now.clear()
        hides = any(may_set(obj, "hide_viewport") for obj in bpy.data.objects)
        self._same_depsgraph = 0 if hides else depsgraph.as_pointer()
        self.listing += 1

    def _shape(
        self, depsgraph: Any, original: Any, shapes: dict[int, Geometry]
    ) -> tuple[Geometry, bool]:
        """Return the surface of an object and its instances, and whether that surface changed."""
        uid = original.session_uid
        if uid in shapes:
            return shapes[uid], uid in self.reshaped
        geometry = shapes[uid] = self._shapes.get(uid) or Geometry(original)
        geometry.deforms = uid in self.bends
        known = uid in self._shapes and uid not in self.reshaped and not self._unsure
        if known:
            self._read_now.setdefault(mesh_shared_by(original), geometry)
        changed = not known and self._read(depsgraph, geometry)
        if changed:
            self.reshaped.add(uid)
        else:
            self.reshaped.discard(uid)
        return geometry, changed

    def _read(self, depsgraph: Any, geometry: Geometry) -> bool:
        """Read a surface once for all objects with its mesh; return whether the surface changed."""
        mesh = mesh_shared_by(geometry.original)
        first = self._read_now.setdefault(mesh, geometry) if mesh else geometry
        if first is not geometry and not geometry.deforms:
            return geometry.share(first)
        return geometry.read(geometry.original.evaluated_get(depsgraph))
