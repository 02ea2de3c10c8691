# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene at one frame as the contact forces on pads ask for it: what meets what, and what each
body needs to move as it does."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ....sensor_logic.contact import motion
from ....sensor_logic.contact.balance import Load
from ....sensor_logic.contact.covered import Contact
from ....sensor_logic.contact.patches import contact_patch
from ....sensor_logic.contact.shapes import Shape, perpendiculars
from ....sensor_logic.contact.world import Link, Need, Node, Standing
from .colliders import Collider
from .facts import FRICTION, Facts, facts_of, is_simulated
from .links import links_of
from .moments import Moment
from .things import Key, Thing, Things

Array = np.typing.NDArray[np.float64]
# Contacts of two things as last found, by the reach they were looked for with, and the poses and
# scales that the two had.
Resting = dict[tuple[Key, Key, float], tuple[Array, list[Contact]]]
# m/s²: no person goes up or down like the one, or moves at all like the other; the body was put
# elsewhere, or its animation starts with a jerk.
JERK, JUMP = 15.0, 80.0
# Of an animated body the weight must be met. Its moments are met as far as its supports can, and
# what it pushes sideways is its muscles' affair.
SOFT_MOMENT, FREE = 1e-4, 1e3
# Of a simulated body that moves.
MOVING_MOMENT = 1e-4


class FrameWorld:
    """The scene at the middle one of three frames, as `contact.world.World`."""

    def __init__(
        self,
        depsgraph: Any,
        things: Things,
        moments: Sequence[Moment],
        metres: float,
        resting: Resting,
    ) -> None:
        self.frame = moments[1].frame
        self._depsgraph = depsgraph
        self._things = things
        self._moments = moments
        self._metres = metres
        scene = depsgraph.scene
        self._gravity, self.up = moments[1].gravity, moments[1].up
        self.gravity = float(np.linalg.norm(self._gravity))
        render = scene.render
        self._frame_time = render.fps_base / render.fps
        world = scene.rigidbody_world
        self._time_scale = world.time_scale if world is not None else 1.0
        self._nodes: dict[Key, Node] = {}
        self._needs: dict[Key, Need] = {}
        self._links: dict[Key, list[Link]] | None = None
        self._apart: set[frozenset[Key]] = set()
        self._resting = resting
        self._meetings: dict[tuple[Key, Key, float, int], list[Contact]] = {}
        self._placed: dict[tuple[Key, int], list[Shape]] = {}
        rows = [[moment.row.get(key, -1) for key in moments[1].row] for moment in moments]
        self._lo = np.min([m.lo[r] for m, r in zip(moments, rows, strict=True)], axis=0)
        self._hi = np.max([m.hi[r] for m, r in zip(moments, rows, strict=True)], axis=0)
        self._keys = list(moments[1].row)

    def _evaluated(self, thing: Thing) -> Any:
        return thing.original.evaluated_get(self._depsgraph)

    def _facts(self, key: Key) -> Facts:
        """As taken down at the frame; of what was not near any pad then, as they are now."""
        facts = self._moments[1].facts
        if key not in facts:
            facts[key] = facts_of(self._evaluated(self._things.by_key[key]))
        return facts[key]

    def node(self, key: Key) -> Node:
        known = self._nodes.get(key)
        if known is None:
            known = self._nodes[key] = self._make_node(key)
        return known

    def _make_node(self, key: Key) -> Node:
        thing = self._things.by_key.get(key)
        if thing is None:
            return Node(key, "", False, False, FRICTION)
        facts = self._facts(key)
        carried = key in self._moments[1].bodies and facts.load_mass > 0.0
        if thing.laid and key in self._moments[1].standing:
            # What lies on what does not move need not be asked what it passes on.
            carried = any(self._gives_way(s.node) for s in self._moments[1].standing[key])
        simulated = not carried and thing.rigid and facts.simulated
        friction = facts.friction if thing.rigid else FRICTION
        margin = self._collider(key, 0).margin if thing.rigid else 0.0
        if thing.pad:
            # In a mesh's margin the pad is what lies between.
            margin = max([margin, *(self._margin_of_ground(other) for other in self.near(key))])
        return Node(
            key,
            thing.original.name,
            carried or simulated,
            carried,
            friction,
            margin,
            thing.owner,
            thing.objects,
        )

    def _gives_way(self, key: Key) -> bool:
        """Whether what stands on this thing weighs on something that has a weight of its own."""
        thing = self._things.by_key.get(key)
        if thing is None:
            return False
        facts = self._facts(key)
        return thing.laid or thing.owner is not None or facts.load_mass > 0.0 or facts.simulated

    def near(self, key: Key) -> list[Key]:
        row = self._moments[1].row.get(key)
        if row is None:
            return []
        meets = ((self._lo <= self._hi[row]) & (self._hi >= self._lo[row])).all(axis=1)
        keys = [self._keys[other] for other in np.flatnonzero(meets).tolist() if other != row]
        # What is gone by the next frame, such as who has left the home, touches nothing any more.
        return [key for key in keys if key in self._things.by_key]

    def hovering(self, pad: Key, beside: float, above: float) -> list[Key]:
        row = self._moments[1].row[pad]
        lo, hi = self._lo[row] - beside, self._hi[row] + beside
        lo, hi = np.minimum(lo, lo + self.up * above), np.maximum(hi, hi + self.up * above)
        meets = ((self._lo <= hi) & (self._hi >= lo)).all(axis=1)
        keys = [self._keys[other] for other in np.flatnonzero(meets).tolist()]
        looked_at = self._moments[1].standing
        return [key for key in keys if key in looked_at and self.node(key).carried]

    def standing(self, key: Key) -> list[Standing]:
        return self._moments[1].standing.get(key, [])

    def joints(self, key: Key) -> list[Link]:
        return self._all_links().get(key, [])

    def _all_links(self) -> dict[Key, list[Link]]:
        if self._links is None:
            self._links = {}
            keys = set(self._keys)
            for constraint in self._things.constraints:
                made = links_of(constraint.evaluated_get(self._depsgraph), keys, self._metres)
                if made is None:
                    continue
                link, collide = made
                if not collide:
                    self._apart.add(frozenset(k for k in (link.one, link.two) if k is not None))
                for end in {link.one, link.two} - {None}:
                    assert end is not None
                    self._links.setdefault(end, []).append(link)
        return self._links

    def meeting(self, one: Key, two: Key, reach: float, when: int) -> list[Contact]:
        named = (one, two, reach, when)
        known = self._meetings.get(named)
        if known is None:
            known = self._meetings[named] = self._meet_anew(one, two, reach, when)
        return known

    def _meet_anew(self, one: Key, two: Key, reach: float, when: int) -> list[Contact]:
        """Found again only where one of the two has moved since it was found last."""
        moment = self._moments[1 + when]
        if one not in moment.row or two not in moment.row:
            return []
        rows = [moment.row[one], moment.row[two]]
        place = np.concatenate([moment.poses[rows].ravel(), moment.scales[rows].ravel()])
        last = self._resting.get((one, two, reach))
        if last is not None and np.array_equal(last[0], place):
            return last[1]
        found = self._meet(one, two, reach, when)
        if when == 0:
            self._resting[one, two, reach] = place, found
        return found

    def _meet(self, one: Key, two: Key, reach: float, when: int) -> list[Contact]:
        nodes = self.node(one), self.node(two)
        # A part acts as what it is a part of.
        acting = [node if node.owner is None else self.node(node.owner) for node in nodes]
        if not self._collide(one, two) or not any(n.weighs and not n.carried for n in acting):
            return []
        if one == nodes[1].owner or two == nodes[0].owner:
            return []
        self._all_links()
        if frozenset((one, two)) in self._apart:
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
        """Whether the engine lets two things collide; a pad that it does not know meets all."""
        first, second = self._things.by_key[one], self._things.by_key[two]
        if not (first.collides and second.collides) or not (first.rigid or second.rigid):
            return False
        if first.rigid and second.rigid:
            layers = [self._evaluated(t).rigid_body.collision_collections for t in (first, second)]
            return any(a and b for a, b in zip(*layers, strict=True))
        return True

    def _collider(self, key: Key, when: int) -> Collider:
        moment = self._moments[1 + when]
        scale = moment.scales[moment.row[key]]
        return self._things.by_key[key].collider(self._depsgraph, scale, self._metres)

    def _margin_of_ground(self, key: Key) -> float:
        thing = self._things.by_key[key]
        if not thing.rigid or is_simulated(self._evaluated(thing)):
            return 0.0
        return self._collider(key, 0).margin

    def _shapes(self, key: Key, when: int, other: Key, reach: float) -> list[Shape]:
        moment = self._moments[1 + when]
        row = moment.row[key]
        collider = self._collider(key, when)
        if collider.by_place:
            near = moment.row[other]
            lo, hi = moment.lo[near] - reach, moment.hi[near] + reach
            return collider.placed(moment.poses[row], lo, hi)
        named = (key, when)
        if named not in self._placed:
            nowhere = np.zeros(3)
            self._placed[named] = collider.placed(moment.poses[row], nowhere, nowhere)
        return self._placed[named]

    def need(self, key: Key) -> Need:
        known = self._needs.get(key)
        if known is None:
            carried = self.node(key).carried
            known = self._need_of_carried(key) if carried else self._need_of_simulated(key)
            self._needs[key] = known
        return known

    def _need_of_simulated(self, key: Key) -> Need:
        thing = self._things.by_key[key]
        facts = self._facts(key)
        if any(key not in moment.row for moment in self._moments):
            return _unknown_need(f"'{thing.original.name}' has just appeared")
        poses = [moment.poses[moment.row[key]] for moment in self._moments]
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
            facts.mass,
            collider.inertia * facts.mass,
            self._gravity,
            facts.linear_damping,
            facts.angular_damping,
        )
        centres = np.array([pose[:3, 3] for pose in poses])
        # Where a body tumbles, its contacts wander within a frame: their moments are blurred.
        soft = MOVING_MOMENT if moved.moving else 0.0
        load = Load(centres[1], wrench, size, np.array([0.0, 0.0, 0.0, soft, soft, soft]))
        problem = "" if np.isfinite(wrench).all() else f"'{thing.original.name}' is nowhere (NaN)"
        return Need(load, centres, facts.mass, moved.reach, problem)

    def _need_of_carried(self, key: Key) -> Need:
        thing = self._things.by_key[key]
        name = thing.original.name
        if any(key not in moment.bodies for moment in self._moments):
            return _unknown_need(f"'{name}' has just appeared")
        mass = 0.0 if thing.laid else self._facts(key).load_mass
        bodies = [moment.bodies[key] for moment in self._moments]
        centres = np.array([body.centre for body in bodies])
        acceleration = (centres[2] - 2.0 * centres[1] + centres[0]) / self._frame_time**2
        problem = ""
        if abs(float(acceleration @ self.up)) > JERK or np.linalg.norm(acceleration) > JUMP:
            problem = f"'{name}' moves too abruptly to have a weight"
        push = max(float(mass * (acceleration - self._gravity) @ self.up), 0.0)
        size = max(float(np.linalg.norm(bodies[1].hi - bodies[1].lo)) / 2.0, 1e-4)
        load = Load(
            centres[1],
            np.concatenate([push * self.up, np.zeros(3)]),
            size,
            np.array([0.0, FREE, FREE, FREE, SOFT_MOMENT, SOFT_MOMENT]),
            np.stack([self.up, *perpendiculars(self.up)]),
        )
        reach = float(np.abs(np.diff(centres, axis=0)).max())
        return Need(load, centres, mass, reach, problem)


def _unknown_need(problem: str) -> Need:
    load = Load(np.zeros(3), np.zeros(6), 1.0, np.ones(6))
    return Need(load, np.zeros((3, 3)), 0.0, 0.0, problem)
