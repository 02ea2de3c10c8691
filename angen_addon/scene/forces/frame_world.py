# SPDX-License-Identifier: GPL-3.0-or-later
"""The contacts and loads of all bodies at one frame, from which the forces on pads are computed.

The *required load* of a body is a force and a moment. The contacts of the body must add up to it,
so that the body moves as it does. A `Node` is a body as this calculation uses it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ....sensor_logic.forces import motion
from ....sensor_logic.forces.balance import Load
from ....sensor_logic.forces.covered import Contact
from ....sensor_logic.forces.patches import contact_patch
from ....sensor_logic.forces.shapes import Shape, perpendiculars
from ....sensor_logic.forces.world import Constraint, Node, RequiredLoad, Support
from ....sensor_logic.model import Array
from ..units import gravity_factor
from .bodies import (
    FIELDS,
    FRICTION,
    BodySettings,
    ContactBodies,
    ContactBody,
    Key,
    is_simulated,
    read_settings,
)
from .colliders import Collider, read_constraint
from .frame_state import FrameState

# Contacts of two bodies by reach, with the poses and scales of both, until the scene is edited. So
# bodies at rest take no time after their first frame.
KnownContacts = dict[tuple[Key, Key, float], tuple[Array, list[Contact]]]
# m/s², vertical and in any direction. No person accelerates as much: either the body jumps to
# another place, or its animation starts with a jerk.
JERK, JUMP = 15.0, 80.0
# Softness of the load of an animated body. Supports must carry its weight, balance its moments as
# far as they can, and need no sideways force: muscles give that.
SOFT_MOMENT, FREE = 1e-4, 1e3
# An active mesh hops if its vertical acceleration is more than this fraction of gravity.
HOP = 0.02
# Softness of the moments of a simulated body that moves.
MOVING_MOMENT = 1e-4


class FrameWorld:
    """The middle one of three successive frames, as a `sensor_logic.forces.world.World`."""

    def __init__(
        self,
        depsgraph: Any,
        bodies: ContactBodies,
        states: Sequence[FrameState],
        metres: float,
        known_contacts: KnownContacts,
    ) -> None:
        self.frame = states[1].frame
        self._depsgraph = depsgraph
        self._bodies = bodies
        self._states = states
        self._metres = metres
        scene = depsgraph.scene
        self._gravity, self.up = states[1].gravity, states[1].up
        self.gravity = float(np.linalg.norm(self._gravity))
        render = scene.render
        self._frame_time = render.fps_base / render.fps
        world = scene.rigidbody_world
        # The engine reads the stored gravity in Blender units. What falls more slowly than by
        # gravity in m/s² is a motion in slower time.
        slow = metres / gravity_factor(scene.gravity, metres)
        self._time_scale = math.sqrt(slow) * (world.time_scale if world is not None else 1.0)
        self._nodes: dict[Key, Node] = {}
        self._required: dict[Key, RequiredLoad] = {}
        self._constraints: dict[Key, list[Constraint]] | None = None
        # Pairs between which a constraint switches collisions off.
        self._no_collision: set[frozenset[Key]] = set()
        self._known_contacts = known_contacts
        self._contacts: dict[tuple[Key, Key, float, int], list[Contact]] = {}
        self._placed: dict[tuple[Key, int], list[Shape]] = {}
        rows = [[state.row.get(key, -1) for key in states[1].row] for state in states]
        self._lo = np.min([m.lo[r] for m, r in zip(states, rows, strict=True)], axis=0)
        self._hi = np.max([m.hi[r] for m, r in zip(states, rows, strict=True)], axis=0)
        self._keys = list(states[1].row)

    def _evaluated(self, body: ContactBody) -> Any:
        return body.original.evaluated_get(self._depsgraph)

    def _settings(self, key: Key) -> BodySettings:
        """Return the settings of a body at the middle frame."""
        # Stored only for bodies near a pad that published; for other bodies, the present frame's
        # are used.
        settings = self._states[1].settings
        if key not in settings:
            settings[key] = read_settings(self._evaluated(self._bodies.by_key[key]), self._metres)
        return settings[key]

    def node(self, key: Key) -> Node:
        """Return the `Node`, a body as the calculation of forces uses it, for a key."""
        known = self._nodes.get(key)
        if known is None:
            known = self._nodes[key] = self._make_node(key)
        return known

    def _make_node(self, key: Key) -> Node:
        body = self._bodies.by_key.get(key)
        if body is None:
            return Node(key, "", False, False, FRICTION)
        settings = self._settings(key)
        animated = key in self._states[1].posed and settings.load_mass > 0.0
        if body.loose_pad and key in self._states[1].supports:
            # A pad on a floor passes its load on to the floor, whose load no sensor reads.
            animated = any(self._passes_weight_on(s.node) for s in self._states[1].supports[key])
        simulated = not animated and body.rigid and settings.simulated
        friction = settings.friction if body.rigid else FRICTION
        margin = self._collider(key, 0).margin if body.rigid else 0.0
        if body.pad:
            # The margin of a mesh below keeps bodies away from it: they press on the pad between.
            margin = max([margin, *(self._margin_of_ground(other) for other in self.near(key))])
        return Node(
            key,
            body.original.name,
            animated or simulated,
            animated,
            friction,
            margin,
            body.owner,
            body.objects,
        )

    def _passes_weight_on(self, key: Key) -> bool:
        """Return whether a body passes a weight that stands on it to other bodies."""
        body = self._bodies.by_key.get(key)
        if body is None:
            return False
        settings = self._settings(key)
        return (
            body.loose_pad
            or body.owner is not None
            or settings.load_mass > 0.0
            or settings.simulated
        )

    def near(self, key: Key) -> list[Key]:
        """Return the keys of the bodies near a body.

        Their bounds overlap its bounds, swept over the three frames, or they stand on it, perhaps
        through a mattress.
        """
        row = self._states[1].row.get(key)
        if row is None:
            return []
        overlaps = ((self._lo <= self._hi[row]) & (self._hi >= self._lo[row])).all(axis=1)
        keys = [self._keys[other] for other in np.flatnonzero(overlaps).tolist() if other != row]
        supports = self._states[1].supports
        standing = (k for k, below in supports.items() if any(s.node == key for s in below))
        keys += [other for other in standing if other != key and other not in keys]
        # A body that the next frame lacks, such as a person who has left, touches nothing.
        return [key for key in keys if key in self._bodies.by_key]

    def animated_near(self, pad: Key, beside: float, above: float) -> list[Key]:
        """Return the keys of the animated bodies near a pad.

        A body is near if it is at most `beside` m next to the pad, or `above` m over it.
        """
        row = self._states[1].row[pad]
        lo, hi = self._lo[row] - beside, self._hi[row] + beside
        lo, hi = np.minimum(lo, lo + self.up * above), np.maximum(hi, hi + self.up * above)
        overlaps = ((self._lo <= hi) & (self._hi >= lo)).all(axis=1)
        keys = [self._keys[other] for other in np.flatnonzero(overlaps).tolist()]
        supported = self._states[1].supports
        return [key for key in keys if key in supported and self.node(key).animated]

    def supports_of(self, key: Key) -> list[Support]:
        """Return the surfaces on which an animated body stands; an empty list for other bodies."""
        return self._states[1].supports.get(key, [])

    def constraints_of(self, key: Key) -> list[Constraint]:
        """Return the rigid-body constraints of a body."""
        return self._all_constraints().get(key, [])

    def _all_constraints(self) -> dict[Key, list[Constraint]]:
        if self._constraints is None:
            self._constraints = {}
            keys = set(self._keys)
            for obj in self._bodies.constraints:
                made = read_constraint(obj.evaluated_get(self._depsgraph), keys, self._metres)
                if made is None:
                    continue
                constraint, collide = made
                ends = [end for end in (constraint.one, constraint.two) if end is not None]
                if not collide:
                    self._no_collision.add(frozenset(ends))
                for end in dict.fromkeys(ends):
                    self._constraints.setdefault(end, []).append(constraint)
        return self._constraints

    def contacts(self, one: Key, two: Key, reach: float, when: int) -> list[Contact]:
        """Return the contacts between two bodies.

        Parameters
        ----------
        one, two
            Keys of the bodies.
        reach
            The largest distance in m between two surfaces in contact.
        when
            −1, 0 or 1: the frame before, the middle frame or the frame after.
        """
        named = (one, two, reach, when)
        known = self._contacts.get(named)
        if known is None:
            known = self._contacts[named] = self._stored_or_new_contacts(one, two, reach, when)
        return known

    def _stored_or_new_contacts(self, one: Key, two: Key, reach: float, when: int) -> list[Contact]:
        state = self._states[1 + when]
        if one not in state.row or two not in state.row:
            return []
        rows = [state.row[one], state.row[two]]
        place = np.concatenate([state.poses[rows].ravel(), state.scales[rows].ravel()])
        last = self._known_contacts.get((one, two, reach))
        if last is not None and np.array_equal(last[0], place):
            return last[1]
        found = self._find_contacts(one, two, reach, when)
        if when == 0:
            self._known_contacts[one, two, reach] = place, found
        return found

    def _find_contacts(self, one: Key, two: Key, reach: float, when: int) -> list[Contact]:
        nodes = self.node(one), self.node(two)
        # A part acts as its owner.
        acting = [node if node.owner is None else self.node(node.owner) for node in nodes]
        if not self._collide(one, two) or not any(n.weighs and not n.animated for n in acting):
            return []
        if one == nodes[1].owner or two == nodes[0].owner:
            return []
        self._all_constraints()
        if frozenset((one, two)) in self._no_collision:
            return []
        first, second = self._shapes(one, when, two, reach), self._shapes(two, when, one, reach)
        found = []
        for shape_a in first:
            for shape_b in second:
                patch = contact_patch(shape_a, shape_b, reach)
                if patch is not None:
                    found.append(Contact(0, 1, patch, shape_a, shape_b))
        return found

    def _collide(self, one: Key, two: Key) -> bool:
        """Return whether two bodies can touch, by the collision collections of rigid bodies.

        A pad without physics can touch all rigid bodies.
        """
        first, second = self._bodies.by_key[one], self._bodies.by_key[two]
        if not (first.collides and second.collides) or not (first.rigid or second.rigid):
            return False
        if first.rigid and second.rigid:
            layers = [self._evaluated(t).rigid_body.collision_collections for t in (first, second)]
            return any(a and b for a, b in zip(*layers, strict=True))
        return True

    def _collider(self, key: Key, when: int) -> Collider:
        state = self._states[1 + when]
        scale = state.scales[state.row[key]]
        return self._bodies.by_key[key].collider(self._depsgraph, scale, self._metres)

    def _margin_of_ground(self, key: Key) -> float:
        body = self._bodies.by_key[key]
        if not body.rigid or is_simulated(self._evaluated(body)):
            return 0.0
        return self._collider(key, 0).margin

    def _shapes(self, key: Key, when: int, other: Key, reach: float) -> list[Shape]:
        state = self._states[1 + when]
        row = state.row[key]
        collider = self._collider(key, when)
        if collider.depends_on_box:
            near = state.row[other]
            lo, hi = state.lo[near] - reach, state.hi[near] + reach
            return collider.placed(state.poses[row], lo, hi)
        named = (key, when)
        if named not in self._placed:
            nowhere = np.zeros(3)
            self._placed[named] = collider.placed(state.poses[row], nowhere, nowhere)
        return self._placed[named]

    def required_load(self, key: Key) -> RequiredLoad:
        """Return the force and moment to which the contacts of a body must add up."""
        known = self._required.get(key)
        if known is None:
            animated = self.node(key).animated
            find = self._required_of_animated if animated else self._required_of_simulated
            known = self._required[key] = find(key)
        return known

    def _required_of_simulated(self, key: Key) -> RequiredLoad:
        body = self._bodies.by_key[key]
        settings = self._settings(key)
        if any(key not in state.row for state in self._states):
            return _unknown_load(f"'{body.original.name}' has just appeared")
        poses = [state.poses[state.row[key]] for state in self._states]
        collider = self._collider(key, 0)
        size = max(float(np.linalg.norm(collider.hi - collider.lo)) / 2.0, 1e-4)
        dt = self._frame_time * self._time_scale
        if dt > 0.0:
            rest = motion.MARGIN_REST_SPEED if collider.margin else motion.REST_SPEED
            moved = motion.motion(poses[0], poses[1], poses[2], dt, size, rest)
        else:
            moved = motion.motion(poses[1], poses[1], poses[1], 1.0, size)
        wrench = motion.wrench(
            moved,
            poses[1],
            settings.mass,
            collider.inertia * settings.mass,
            self._gravity,
            settings.linear_damping,
            settings.angular_damping,
        )
        centres = np.array([pose[:3, 3] for pose in poses])
        # The contacts of a tumbling body move within a frame: its moments are uncertain.
        soft = MOVING_MOMENT if moved.moving else 0.0
        load = Load(centres[1], wrench, size, np.array([0.0, 0.0, 0.0, soft, soft, soft]))
        problem = self._force_field_problem(body)
        if collider.depends_on_box and abs(moved.acceleration @ self.up) > HOP * self.gravity:
            problem = (
                f"the collision margin of {collider.margin * 1000.0:.3g} mm keeps the active mesh "
                f"'{body.original.name}' off the surface below, where it bounces: choose Convex "
                "Hull or Compound as its shape (Physics tab, Collisions)"
            )
        if not np.isfinite(wrench).all():
            problem = (
                f"the position of '{body.original.name}' is not a number (NaN): check its "
                "keyframes and drivers"
            )
        return RequiredLoad(load, centres, settings.mass, moved.reach, problem)

    def _force_field_problem(self, body: ContactBody) -> str:
        """Return a text for the user if a force field may push a body; "" if none may."""
        for obj in self._bodies.fields:
            field = obj.evaluated_get(self._depsgraph).field
            weights = self._depsgraph.scene.rigidbody_world.effector_weights
            strong = field.strength or field.type in {"TEXTURE", "DRAG"}
            if strong and weights.all * getattr(weights, FIELDS[field.type]):
                return (
                    f"the force field '{obj.name}' may push '{body.original.name}' with an "
                    "unknown force: set the weight of this kind of field to 0 (Scene tab, Rigid "
                    "Body World, Field Weights)"
                )
        return ""

    def _required_of_animated(self, key: Key) -> RequiredLoad:
        body = self._bodies.by_key[key]
        name = body.original.name
        if any(key not in state.posed for state in self._states):
            return _unknown_load(f"'{name}' has just appeared")
        mass = 0.0 if body.loose_pad else self._settings(key).load_mass
        posed = [state.posed[key] for state in self._states]
        centres = np.array([one.centre for one in posed])
        acceleration = (centres[2] - 2.0 * centres[1] + centres[0]) / self._frame_time**2
        problem = ""
        if abs(float(acceleration @ self.up)) > JERK or np.linalg.norm(acceleration) > JUMP:
            problem = f"'{name}' moves too abruptly for its weight to be computed"
        push = max(float(mass * (acceleration - self._gravity) @ self.up), 0.0)
        size = max(float(np.linalg.norm(posed[1].hi - posed[1].lo)) / 2.0, 1e-4)
        load = Load(
            centres[1],
            np.concatenate([push * self.up, np.zeros(3)]),
            size,
            np.array([0.0, FREE, FREE, FREE, SOFT_MOMENT, SOFT_MOMENT]),
            np.stack([self.up, *perpendiculars(self.up)]),
        )
        reach = float(np.abs(np.diff(centres, axis=0)).max())
        return RequiredLoad(load, centres, mass, reach, problem)


def _unknown_load(problem: str) -> RequiredLoad:
    load = Load(np.zeros(3), np.zeros(6), 1.0, np.ones(6))
    return RequiredLoad(load, np.zeros((3, 3)), 0.0, 0.0, problem)
