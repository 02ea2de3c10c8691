# SPDX-License-Identifier: GPL-3.0-or-later
"""The bodies that can press on pads of pressure sensors.

These are rigid bodies, animated bodies with a mass, and the pads themselves. A tuple of integers
identifies a body: its *key*, as in `Solid.key`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....sensor_logic.forces.underside import is_closed
from ....sensor_logic.model import Array
from ..bearers import armatures, bearer, candidates
from ..instances import Uid, chain
from ..rays.solids import Solid, Solids
from ..sensors import is_placed
from ..units import kilograms
from .colliders import Collider, rigid_body_collider, surface_collider

# Friction of objects without a rigid body.
FRICTION = 0.7


@dataclass(frozen=True)
class BodySettings:
    """The physical settings of a body at one frame.

    Attributes
    ----------
    load_mass
        The mass from the panel Weight on Sensors, in kg.
    simulated
        Whether the physics engine moves the body.
    mass
        The mass as a rigid body, in kg.
    friction
        The friction coefficient.
    linear_damping, angular_damping
        The damping of the rigid body.
    """

    load_mass: float
    simulated: bool = False
    mass: float = 0.0
    friction: float = FRICTION
    linear_damping: float = 0.0
    angular_damping: float = 0.0


def read_settings(evaluated: Any, metres: float) -> BodySettings:
    """Return the physical settings of an evaluated object.

    `metres` is the length of a Blender unit.
    """
    load = float(evaluated.angen_load.mass)
    body = evaluated.rigid_body
    if body is None:
        return BodySettings(load)
    return BodySettings(
        load,
        is_simulated(evaluated),
        kilograms(body, metres),
        body.friction,
        body.linear_damping,
        body.angular_damping,
    )


def is_simulated(obj: Any) -> bool:
    """Return whether the physics engine moves an object."""
    body = obj.rigid_body
    return body is not None and body.enabled and body.type == "ACTIVE" and not body.kinematic


Key = tuple[int, ...]
GROUND: Key = ()
# Types of force fields, each with the property of its effector weight.
FIELDS = {
    "FORCE": "force", "WIND": "wind", "VORTEX": "vortex", "MAGNET": "magnetic",
    "HARMONIC": "harmonic", "CHARGE": "charge", "LENNARDJ": "lennardjones", "TEXTURE": "texture",
    "TURBULENCE": "turbulence", "DRAG": "drag", "FLUID_FLOW": "smokeflow",
}  # fmt: skip
# Blender units by which bounds are widened, for the collision margin of meshes.
MARGIN = 0.05


class Pad(NamedTuple):
    """The surface of a pressure sensor.

    Attributes
    ----------
    uid
        The identifier, which differs for each collection instance of the pad.
    original
        The object in the file.
    """

    uid: Uid
    original: Any


class ContactBody:
    """A rigid body, an animated body with a mass, or a pad. A body can be several of these.

    Attributes
    ----------
    key
        The tuple of integers that identifies the body.
    original
        The object in the file with the settings of the body.
    rigid, pad, animated
        Whether the body is a rigid body, a pad, or an animated body with a mass.
    solids
        The solids of an animated body, or of a pad without physics.
    owner
        The key of the rigid body that a pad without physics is a part of; None for other bodies.
    uid
        The session uid of `original`.
    objects
        The session uids of all objects that make up the body.
    middle, half
        The middle and half size (3,) of the body's shapes, in its own space without scale.
    """

    def __init__(self, key: Key, original: Any) -> None:
        self.key = key
        self.original = original
        self.rigid = False
        self.pad = False
        self.animated = False
        self.solids: list[Solid] = []
        self.owner: Key | None = None
        self.uid: Uid = original.session_uid
        self.objects: frozenset[int] = frozenset({original.session_uid})
        self.half = np.zeros(3)
        self.middle = np.zeros(3)
        # Shapes by scale, until the scene is edited: a convex hull takes milliseconds.
        self._colliders: dict[tuple[float, ...], Collider] = {}
        self._last: tuple[tuple[float, ...], Collider] | None = None
        # The triangles of the last test for closed surfaces, and its result. A test is slow.
        self._closed: tuple[list[Any], bool] | None = None

    @property
    def tolerance(self) -> float:
        """The largest gap in m between an animated body and the support on which it stands."""
        return max(float(self.original.angen_load.tolerance), 1e-4)

    @property
    def loose_pad(self) -> bool:
        """Whether the body is a pad that neither physics nor keyframes nor a parent moves.

        Such a pad lies on the surface below it. It passes the weight that is on it to that surface.
        """
        return self.pad and not self.rigid and not self.animated and self.owner is None

    @property
    def stiff(self) -> bool:
        """Whether neither armatures nor shape keys bend the body.

        A body that bends counts as soft: its underside adapts to the surface below.
        """
        if self.original.type == "ARMATURE":
            return False
        bent = (s.original for s in self.solids if s.original is not None)
        return not any(armatures(o) or getattr(o.data, "shape_keys", None) for o in bent)

    @property
    def weighs(self) -> bool:
        """Whether the body has a weight: it is simulated, or animated with a mass."""
        return self.animated or (self.rigid and is_simulated(self.original))

    @property
    def collides(self) -> bool:
        """Whether the body has a collider, as a rigid body or as a pad."""
        return self.rigid or self.pad

    def collider(self, depsgraph: Any, scale: Array, metres: float) -> Collider:
        """Return the collider of the body for a scale (3,).

        `metres` is the length of a Blender unit.
        """
        exact = (*scale.tolist(), metres)
        if self._last is not None and self._last[0] == exact:
            return self._last[1]
        # Rotation changes the last digits of a scale from frame to frame. The shapes are made
        # without those digits, so that they do not depend on which frame needs them first.
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
        """Return whether each surface of the body encloses a volume.

        `topologies` has the triangles (n, 3) of each surface, as vertex indices.
        """
        known = self._closed
        if (
            known is None
            or len(known[0]) != len(topologies)
            or any(a is not b for a, b in zip(known[0], topologies, strict=True))
        ):
            known = (topologies, all(is_closed(corners) for corners in topologies))
            self._closed = known
        return known[1]


class ContactBodies:
    """All contact bodies of a scene, and the body that each solid belongs to.

    Attributes
    ----------
    by_key
        The bodies by key.
    of_solid
        The key of each solid's body, by number of the solid; GROUND for no body.
    constraints
        The objects with a rigid-body constraint.
    fields
        The objects with a force field.
    resting
        The solids of active rigid bodies, each with its object. Such a solid has no mass from the
        panel Weight on Sensors, so it weighs nothing unless physics moves it.
    keys
        The keys in the order of `middle`, `half` and `is_cubic`.
    row
        The index of each key in `keys`.
    middle, half
        The middle and half size (n, 3) of each body, as in `ContactBody`.
    is_cubic
        Mask (n,) of the bodies whose size is the same along all axes.
    pads
        The key of each pad, by its identifier.
    """

    def __init__(self) -> None:
        self.by_key: dict[Key, ContactBody] = {}
        self.of_solid: dict[int, Key] = {}
        self.constraints: list[Any] = []
        self.fields: list[Any] = []
        self.resting: list[tuple[Solid, Any]] = []
        self.keys: list[Key] = []
        self.row: dict[Key, int] = {}
        self.middle, self.half = np.empty((0, 3)), np.empty((0, 3))
        self.is_cubic = np.empty(0, bool)
        self._supports: dict[Key, NDArray[np.intp]] = {}
        self._listing = -1
        self.pads: dict[Uid, Key] = {}
        self._pad_uids: list[Uid] = []

    def sync(self, depsgraph: Any, solids: Solids, pads: Sequence[Pad]) -> bool:
        """List the bodies again if solids or pads have changed; return whether they have."""
        uids = [pad.uid for pad in pads]
        if solids.listing == self._listing and uids == self._pad_uids:
            return False
        self._listing, self._pad_uids = solids.listing, uids
        self.pads = {pad.uid: _key_of(pad, solids) for pad in pads}
        self.by_key = {}
        scene = depsgraph.scene.original
        for original in rigid_bodies(scene):
            body = self._body((original.session_uid,), original)
            body.rigid = True
            family = (original, *original.children_recursive)
            body.objects = frozenset(obj.session_uid for obj in family)
            body.middle, body.half = _bounds(depsgraph, original)
        for pad in pads:
            body = self._body(self.pads[pad.uid], pad.original)
            body.pad, body.uid = True, pad.uid
            if not body.rigid:
                body.middle, body.half = _box(pad.original.evaluated_get(depsgraph))
        self._find_animated(solids)
        self._find_owners(solids, pads)
        self._find_resting(solids)
        self.fields = fields_in(depsgraph)
        world = scene.rigidbody_world
        self._finish()
        objects = world.constraints.objects if world and world.constraints else []
        self.constraints = [obj for obj in objects if obj.rigid_body_constraint]
        return True

    def is_current(self, solids: Solids) -> bool:
        """Return whether the bodies were listed after the present list of solids was made."""
        return solids.listing == self._listing

    def supports_of(self, body: ContactBody, solids: Solids) -> NDArray[np.intp]:
        """Return the rows of the solids on which a body may stand.

        These are all solids that do not belong to the body, and all pads even if they belong to it.
        """
        rows = self._supports.get(body.key)
        if rows is None:
            chosen = []
            for solid in solids.solids:
                key = self.of_solid.get(solid.number, GROUND)
                pad = key in self.by_key and self.by_key[key].pad
                if key != body.key and (pad or body.uid not in solid.owners):
                    chosen.append(solid.row)
            rows = self._supports[body.key] = np.array(chosen, np.intp)
        return rows

    def _finish(self) -> None:
        self._supports.clear()
        known = list(self.by_key.values())
        self.keys = list(self.by_key)
        self.row = {key: row for row, key in enumerate(self.keys)}
        self.middle = np.array([body.middle for body in known]).reshape(-1, 3)
        self.half = np.array([body.half for body in known]).reshape(-1, 3)
        self.is_cubic = self.half.max(axis=1, initial=0.0) == self.half.min(axis=1, initial=np.inf)

    def _body(self, key: Key, original: Any) -> ContactBody:
        return self.by_key.setdefault(key, ContactBody(key, original))

    def _find_animated(self, solids: Solids) -> None:
        first_keys = {_instance_key(s): s.key for s in solids.solids if _in_collection(s)}
        for solid in solids.solids:
            source = solid.original
            heavy = bearer(source)
            if heavy is None:
                continue
            body = self._body(_body_key(solid, heavy, first_keys), heavy)
            body.animated = True
            body.solids.append(solid)
            body.objects |= {obj.session_uid for obj in (solid.owner, *candidates(source))}

    def _find_resting(self, solids: Solids) -> None:
        self.resting = []
        for solid in solids.solids:
            body = next((obj for obj in chain(solid.original) if obj.rigid_body is not None), None)
            if body is None or bearer(solid.original) is not None:
                continue
            while is_part_of_compound(body):
                body = body.parent
            pad = self.by_key.get(self.of_solid[solid.number])
            if body.rigid_body.type == "ACTIVE" and not (pad is not None and pad.pad):
                self.resting.append((solid, body))

    def _find_owners(self, solids: Solids, pads: Sequence[Pad]) -> None:
        """Find the body of each solid, and the `owner` of each pad without physics."""
        self.of_solid = {}
        own = {solid.number: body.key for body in self.by_key.values() for solid in body.solids}
        for solid in solids.solids:
            key = own.get(solid.number)
            if solid.key in self.by_key and self.by_key[solid.key].pad:
                key = solid.key
                self.by_key[key].solids = [solid]
            if key is None:
                key = next((found for found in _keys_of(solid) if found in self.by_key), GROUND)
            self.of_solid[solid.number] = key
        for pad in pads:
            body = self.by_key[self.pads[pad.uid]]
            # Physics moves no instances.
            if isinstance(pad.uid, int) and not body.rigid and not body.animated:
                parents = ((obj.session_uid,) for obj in chain(pad.original.parent))
                owner = next((key for key in parents if key in self.by_key), None)
                if owner is not None and self.by_key[owner].rigid:
                    body.owner = owner


def _key_of(pad: Pad, solids: Solids) -> Key:
    """Return the key of a pad. In a collection instance, it is the key of the pad's solid there."""
    if isinstance(pad.uid, int):
        return (pad.uid,)
    own = pad.original.session_uid
    return next((s.key for s in solids.solids if s.key[0] == own and pad.uid in s.owners), pad.uid)


def rigid_bodies(scene: Any) -> Iterator[Any]:
    """Yield the rigid bodies of a scene, except the parts of a compound."""
    world = scene.rigidbody_world
    if world is None or not world.enabled or world.collection is None:
        return
    for original in world.collection.objects:
        if original.rigid_body is not None and not is_part_of_compound(original):
            yield original


def is_part_of_compound(obj: Any) -> bool:
    """Return whether an object's parent is a rigid body with the shape Compound Parent."""
    parent = obj.parent
    body = parent.rigid_body if parent is not None else None
    return body is not None and body.collision_shape == "COMPOUND"


def fields_in(depsgraph: Any) -> list[Any]:
    """Return the objects with force fields that act on rigid bodies."""
    world = depsgraph.scene.original.rigidbody_world
    group = world.effector_weights.collection if world is not None else None
    objects = depsgraph.view_layer.objects if group is None else group.all_objects
    return [
        obj
        for obj in objects
        if obj.field is not None and obj.field.type in FIELDS and is_placed(obj, depsgraph)
    ]


def _keys_of(solid: Solid) -> Iterator[Key]:
    """Yield the keys that the body of a solid may have, nearest first.

    They are the keys of the solid, of its object and its owner, and of all parents of these two.
    """
    yield solid.key
    for obj in (*chain(solid.original), *chain(solid.owner)):
        yield (obj.session_uid,)


def _body_key(solid: Solid, heavy: Any, first_keys: dict[Key, Key]) -> Key:
    """Return the key of the body that a solid is a part of.

    All solids of one person get the same key. Each collection instance of that person gets another.

    Parameters
    ----------
    solid
        The solid.
    heavy
        The object with the mass that the solid carries.
    first_keys
        The key of one solid of each collection instance, by `_instance_key`.
    """
    uid = heavy.session_uid
    own = uid == solid.key[0]
    if own and not solid.geometry.lasting:
        # All instances that its geometry nodes make are one body.
        return (uid,)
    if own or not _in_collection(solid):
        return solid.key if own else (uid, *solid.key[1:])
    same = (uid, *_instance_key(solid)[1:])
    return first_keys.get(same, same)


def _in_collection(solid: Solid) -> bool:
    return len(solid.key) > 1 and solid.owner.instance_type == "COLLECTION"


def _instance_key(solid: Solid) -> Key:
    """Return a solid's key without the index of its object in the instanced collection.

    All items except the first, the object's uid, are equal for all solids of one instance.
    """
    return (*solid.key[:2], *solid.key[3:])


def _box(evaluated: Any) -> tuple[Array, Array]:
    corners = np.array(evaluated.bound_box, np.float64)
    lo, hi = corners.min(axis=0), corners.max(axis=0)
    return (lo + hi) / 2.0, (hi - lo) / 2.0


def _bounds(depsgraph: Any, original: Any) -> tuple[Array, Array]:
    """Return the middle and half size (3,) of a rigid body's shapes, without scale.

    The size may be too large, but never too small.
    """
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
