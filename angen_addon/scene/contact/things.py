# SPDX-License-Identifier: GPL-3.0-or-later
"""What of the scene can press on a pad: rigid bodies, animated bodies with a mass, and the pads."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....sensor_logic.contact.underside import is_closed
from ..animation import is_animated
from ..instances import Uid
from ..rays.solids import Solid, Solids
from .colliders import Collider, rigid_body_collider, surface_collider
from .facts import is_simulated

Array = np.typing.NDArray[np.float64]
Key = tuple[int, ...]
GROUND: Key = ()
# The engine's mesh margin, in units: bounds are widened by it.
MARGIN = 0.05


class Pad(NamedTuple):
    """A pad's object, and what tells it from others: an instance of a collection may have it."""

    uid: Uid
    original: Any


class Thing:
    """A rigid body, an animated body with a mass, a pad, or more than one of these.

    `surfaces`: the solids that make up an animated body or a pad without physics. `owner`: the
    simulated body that such a pad is a part of. `middle`, `half` (3,): bounds of its shapes,
    unscaled, in its own space.
    """

    def __init__(self, key: Key, original: Any) -> None:
        self.key = key
        self.original = original
        self.rigid = False
        self.pad = False
        self.carried = False
        self.surfaces: list[Solid] = []
        self.owner: Key | None = None
        self.uid: Uid = original.session_uid
        self.objects: frozenset[int] = frozenset({original.session_uid})
        self.half = np.zeros(3)
        self.middle = np.zeros(3)
        self._colliders: dict[tuple[float, ...], Collider] = {}
        self._last: tuple[tuple[float, ...], Collider] | None = None
        self._closed: tuple[list[Any], bool] | None = None

    @property
    def tolerance(self) -> float:
        """m: an animated body this far above something stands on it."""
        return max(float(self.original.angen_load.tolerance), 1e-4)

    @property
    def laid(self) -> bool:
        """Whether it is a pad that nothing simulates, carries or holds: it lies on what is below
        it, and passes on what is on it."""
        return self.pad and not self.rigid and not self.carried and self.owner is None

    @property
    def stiff(self) -> bool:
        """Whether nothing bends it: what is bent by an armature or shape keys has soft soles."""
        if self.original.type == "ARMATURE":
            return False
        bent = (s.original for s in self.surfaces if s.original is not None)
        return not any(_armatures(o) or getattr(o.data, "shape_keys", None) for o in bent)

    @property
    def weighs(self) -> bool:
        """Whether it has a weight of its own: it is simulated, or animated with a mass."""
        return self.carried or (self.rigid and is_simulated(self.original))

    @property
    def collides(self) -> bool:
        return self.rigid or self.pad

    def collider(self, depsgraph: Any, scale: Array, metres: float) -> Collider:
        """Its shapes at a scale (3,), read when first asked for."""
        exact = (*scale.tolist(), metres)
        if self._last is not None and self._last[0] == exact:
            return self._last[1]
        # As turns leave the last digits of a scale to chance, the shapes are made without them:
        # they must not depend on the frame at which they were asked for first.
        rounded = np.array([float(f"{part:.6g}") for part in scale.tolist()])
        named = (*rounded.tolist(), metres)
        if named not in self._colliders:
            evaluated = self.original.evaluated_get(depsgraph)
            if len(self._colliders) > 4:
                self._colliders.clear()
            if self.rigid:
                made = rigid_body_collider(depsgraph, evaluated, rounded, metres)
            else:
                made = surface_collider(evaluated, rounded, metres)
            self._colliders[named] = made
        self._last = exact, self._colliders[named]
        return self._last[1]

    def is_closed(self, topologies: list[Any]) -> bool:
        """Whether its surfaces, given by their triangles (n, 3) of vertices, all have an inside."""
        known = self._closed
        if (
            known is None
            or len(known[0]) != len(topologies)
            or any(a is not b for a, b in zip(known[0], topologies, strict=True))
        ):
            known = (topologies, all(is_closed(corners) for corners in topologies))
            self._closed = known
        return known[1]


class Things:
    """The things of a scene by key, and what each of the solids belongs to.

    `keys` and `row` give them an order; in it `middle`, `half` (n, 3) are their bounds, unscaled,
    and `even` (n,) tells which are equally large on all axes.
    """

    def __init__(self) -> None:
        self.by_key: dict[Key, Thing] = {}
        self.of_solid: dict[int, Key] = {}
        self.constraints: list[Any] = []
        self.keys: list[Key] = []
        self.row: dict[Key, int] = {}
        self.middle, self.half = np.empty((0, 3)), np.empty((0, 3))
        self.even = np.empty(0, bool)
        self._supports: dict[Key, NDArray[np.intp]] = {}
        self._listing = -1
        # By what tells a pad, its key.
        self.pads: dict[Uid, Key] = {}
        self._named: list[Uid] = []

    def sync(self, depsgraph: Any, solids: Solids, pads: Sequence[Pad]) -> bool:
        """Lists the things anew where the scene was edited; whether it did."""
        named = [pad.uid for pad in pads]
        if solids.listing == self._listing and named == self._named:
            return False
        self._listing, self._named = solids.listing, named
        self.pads = {pad.uid: _key_of(pad, solids) for pad in pads}
        self.by_key = {}
        scene = depsgraph.scene.original
        for original in rigid_bodies(scene):
            thing = self._thing((original.session_uid,), original)
            thing.rigid = True
            thing.objects = frozenset(_family(original))
            thing.middle, thing.half = _bounds(depsgraph, original)
        for pad in pads:
            thing = self._thing(self.pads[pad.uid], pad.original)
            thing.pad, thing.uid = True, pad.uid
            if not thing.rigid:
                thing.middle, thing.half = _box(pad.original.evaluated_get(depsgraph))
        self._find_carried(solids)
        self._find_owners(solids, pads)
        world = scene.rigidbody_world
        self._finish()
        links = world.constraints.objects if world and world.constraints else []
        self.constraints = [link for link in links if link.rigid_body_constraint]
        return True

    def supports_of(self, thing: Thing, solids: Solids) -> NDArray[np.intp]:
        """Rows of the solids, as last synced, that a thing may stand on: not its own parts, but for
        the pads among these."""
        rows = self._supports.get(thing.key)
        if rows is None:
            chosen = []
            for solid in solids.solids:
                key = self.of_solid.get(solid.number, GROUND)
                pad = key in self.by_key and self.by_key[key].pad
                if key != thing.key and (pad or thing.uid not in solid.owners):
                    chosen.append(solid.row)
            rows = self._supports[thing.key] = np.array(chosen, np.intp)
        return rows

    def _finish(self) -> None:
        self._supports.clear()
        known = list(self.by_key.values())
        self.keys = list(self.by_key)
        self.row = {key: row for row, key in enumerate(self.keys)}
        self.middle = np.array([thing.middle for thing in known]).reshape(-1, 3)
        self.half = np.array([thing.half for thing in known]).reshape(-1, 3)
        self.even = self.half.max(axis=1, initial=0.0) == self.half.min(axis=1, initial=np.inf)

    def _thing(self, key: Key, original: Any) -> Thing:
        return self.by_key.setdefault(key, Thing(key, original))

    def _find_carried(self, solids: Solids) -> None:
        together = {_together(s): s.key for s in solids.solids if _in_collection(s)}
        for solid in solids.solids:
            bearer = _bearer(solid)
            if bearer is None:
                continue
            key = _body_key(solid, bearer, together)
            thing = self._thing(key, bearer)
            thing.carried = True
            thing.surfaces.append(solid)
            source = solid.original
            known_by = (source, solid.owner, *_armatures(source), *_parents(source))
            thing.objects |= {obj.session_uid for obj in known_by}

    def _find_owners(self, solids: Solids, pads: Sequence[Pad]) -> None:
        """What each solid is a part of, and what a pad that nothing simulates is fixed to."""
        self.of_solid = {}
        surfaces = {
            solid.number: thing.key for thing in self.by_key.values() for solid in thing.surfaces
        }
        for solid in solids.solids:
            key = surfaces.get(solid.number)
            if solid.key in self.by_key and self.by_key[solid.key].pad:
                key = solid.key
                self.by_key[key].surfaces = [solid]
            if key is None:
                key = next((found for found in _chain_keys(solid) if found in self.by_key), GROUND)
            self.of_solid[solid.number] = key
        for pad in pads:
            thing = self.by_key[self.pads[pad.uid]]
            # What an instance shows, no physics moves.
            if isinstance(pad.uid, int) and not thing.rigid and not thing.carried:
                parents = ((parent.session_uid,) for parent in _parents(pad.original))
                owner = next((key for key in parents if key in self.by_key), None)
                if owner is not None and self.by_key[owner].rigid:
                    thing.owner = owner


def _key_of(pad: Pad, solids: Solids) -> Key:
    """Of a pad in an instance that of the solid that it is there; one of its own without any."""
    if isinstance(pad.uid, int):
        return (pad.uid,)
    own = pad.original.session_uid
    return next((s.key for s in solids.solids if s.key[0] == own and pad.uid in s.owners), pad.uid)


def rigid_bodies(scene: Any) -> Iterator[Any]:
    """Objects that are bodies of their own: not the parts of a compound."""
    world = scene.rigidbody_world
    if world is None or not world.enabled or world.collection is None:
        return
    for original in world.collection.objects:
        parent = original.parent
        part = (
            parent is not None
            and parent.rigid_body is not None
            and parent.rigid_body.collision_shape == "COMPOUND"
        )
        if original.rigid_body is not None and not part:
            yield original


def _family(original: Any) -> Iterator[int]:
    yield original.session_uid
    for child in original.children_recursive:
        yield child.session_uid


def _parents(original: Any) -> Iterator[Any]:
    seen = set()
    parent = original.parent
    while parent is not None and parent.session_uid not in seen:
        seen.add(parent.session_uid)
        yield parent
        parent = parent.parent


def _chain_keys(solid: Solid) -> Iterator[Key]:
    """The solid itself, then what it is a part of, nearest first."""
    original = solid.original
    yield solid.key
    yield (original.session_uid,)
    for parent in _parents(original):
        yield (parent.session_uid,)
    owner = solid.owner
    if owner is not None:
        yield (owner.session_uid,)
        for parent in _parents(owner):
            yield (parent.session_uid,)


def _body_key(solid: Solid, bearer: Any, together: dict[Key, Key]) -> Key:
    """The key of the body that a solid is a part of: all parts of one person have the same, and
    each instance of the person another."""
    uid = bearer.session_uid
    own = uid == solid.key[0]
    if own and not solid.geometry.lasting:
        # All that its nodes make is one body.
        return (uid,)
    if own or not _in_collection(solid):
        return solid.key if own else (uid, *solid.key[1:])
    same = (uid, *_together(solid)[1:])
    return together.get(same, same)


def _in_collection(solid: Solid) -> bool:
    """Whether it is listed as a part of an instanced collection."""
    return len(solid.key) > 1 and solid.owner.instance_type == "COLLECTION"


def _together(solid: Solid) -> Key:
    """Its key without its number in the instanced collection: equal but for the object for all that
    is in it."""
    return (*solid.key[:2], *solid.key[3:])


def _bearer(solid: Solid) -> Any:
    """The object whose mass a solid weighs with: its own, its armature's or a parent's."""
    original = solid.original
    chain: Iterable[Any] = (original, *_armatures(original), *_parents(original))
    for candidate in chain:
        if candidate.angen_load.mass > 0.0 or is_animated(candidate, "angen_load.mass"):
            return candidate
    return None


def _armatures(original: Any) -> list[Any]:
    return [m.object for m in original.modifiers if m.type == "ARMATURE" and m.object is not None]


def _box(evaluated: Any) -> tuple[Array, Array]:
    corners = np.array(evaluated.bound_box, np.float64)
    lo, hi = corners.min(axis=0), corners.max(axis=0)
    return (lo + hi) / 2.0, (hi - lo) / 2.0


def _bounds(depsgraph: Any, original: Any) -> tuple[Array, Array]:
    """Middle and half size of a rigid body's shapes, unscaled, not too small."""
    body = original.rigid_body
    middle, half = _box(original.evaluated_get(depsgraph))
    kind = body.collision_shape
    if kind in {"CONVEX_HULL", "MESH"}:
        return middle, half + body.collision_margin
    if kind == "COMPOUND":
        reach = 0.0
        for child in original.children:
            if child.rigid_body is not None:
                own, size = _bounds(depsgraph, child)
                place = np.array(child.evaluated_get(depsgraph).matrix_local.translation)
                reach = max(reach, float(np.linalg.norm(place + own) + np.linalg.norm(size)))
        return np.zeros(3), np.full(3, reach)
    if kind == "BOX":
        return np.zeros(3), half
    # Round shapes take a radius from one axis and may be scaled by another.
    return np.zeros(3), np.full(3, float(np.linalg.norm(half)))
