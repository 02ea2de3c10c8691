# SPDX-License-Identifier: GPL-3.0-or-later
"""The collision shapes of Blender's rigid bodies, and the constraints between two bodies.

A collision shape differs from the mesh. A primitive has the size of the bounding box, but its
centre is at the object's origin. A child of a compound loses its own scale. A scaled hull has a
margin that is not scaled. All this was measured with resting bodies in Blender 4.2, 4.5 and 5.2
(tests/blender/test_pressure_shapes.py).
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import bmesh
import numpy as np

from ....sensor_logic.forces import shapes
from ....sensor_logic.forces.shapes import Shape
from ....sensor_logic.forces.world import Constraint, Key
from ....sensor_logic.model import Array
from ..rays.geometry import triangles_of

MARGIN = 0.04
UNIT_SCALE_SLACK = 1e-4
LEAST_EXTENT = 1e-6


class Collider:
    """The collision shapes of one rigid body or pad, scaled, in its own space.

    Attributes
    ----------
    convex
        The convex shapes.
    triangles
        Triangles (n, 3, 3) of the surfaces that are not convex.
    shell
        Triangles (n, 3, 3) of a convex mesh. It is hollow: another body can be inside.
    margin
        The distance in m at which meshes and cones keep other bodies off.
    lo, hi
        Bounds (3,) in m.
    inertia
        The inertia (3,) divided by the mass, in m².
    """

    def __init__(self) -> None:
        self.convex: list[Shape] = []
        self.triangles: Array = np.empty((0, 3, 3))
        self.shell: Array = np.empty((0, 3, 3))
        self.margin = 0.0
        self.inertia = np.zeros(3)

    @property
    def empty(self) -> bool:
        """Whether the collider has no shapes."""
        return not self.convex and not self.meshy

    @property
    def meshy(self) -> bool:
        """Whether the collider has a surface that is not convex."""
        return len(self.triangles) > 0

    def finish(self) -> None:
        """Compute the bounds and the inertia. Call this once all shapes are added.

        For most shapes the physics engine uses the inertia of a box of the same size.
        """
        corners = [c for shape in self.convex for c in (shape.lo, shape.hi)]
        if self.meshy:
            flat = self.triangles.reshape(-1, 3)
            corners += [flat.min(axis=0), flat.max(axis=0)]
        self.lo = np.min(corners, axis=0) if corners else np.full(3, np.inf)
        self.hi = np.max(corners, axis=0) if corners else np.full(3, -np.inf)
        if corners and not self.inertia.any():
            self.inertia = box_inertia(self.hi - self.lo)

    @property
    def depends_on_box(self) -> bool:
        """Whether the result of `placed` depends on its parameters `lo` and `hi`."""
        return self.meshy or len(self.shell) > 0

    def is_in_shell(self, place: Array, pose: Array) -> bool:
        """Return whether the point `place` (3,) is inside the shell at a pose (4, 4)."""
        if not len(self.shell) or len(self.convex) != 1:
            return False
        local = (place - pose[:3, 3]) @ pose[:3, :3]
        hull = self.convex[0]
        return bool((hull.normals @ local < hull.offsets).all())

    def placed(self, pose: Array, lo: Array, hi: Array) -> list[Shape]:
        """Return the shapes at a pose, in the world.

        Parameters
        ----------
        pose
            Pose (4, 4) without scale.
        lo, hi
            The corners (3,), (3,) of a box in the world, in m. Triangles outside the box are left
            out. If the middle of the box is inside the hollow body (`shell`), the triangles of
            `shell` replace the convex shapes and `triangles`.
        """
        inside = self.is_in_shell((lo + hi) / 2.0, pose)
        found = [] if inside else [shape.placed(pose) for shape in self.convex]
        triangles = self.shell if inside else self.triangles
        if len(triangles):
            world = triangles @ pose[:3, :3].T + pose[:3, 3]
            near = (world.min(axis=1) <= hi).all(axis=1) & (world.max(axis=1) >= lo).all(axis=1)
            for triangle in world[near]:
                try:
                    found.append(shapes.polygon(triangle))
                except ValueError:
                    continue  # A triangle without an area.
        return found


def box_inertia(size: Array) -> Array:
    """Return the inertia (3,) of a box divided by its mass, in m².

    `size` (3,) are its edge lengths, in m.
    """
    square = size**2
    return np.array([square[1] + square[2], square[0] + square[2], square[0] + square[1]]) / 12.0


def rigid_body_collider(depsgraph: Any, evaluated: Any, scale: Array, metres: float) -> Collider:
    """Return the collider of an evaluated rigid body.

    Parameters
    ----------
    depsgraph
        The evaluated depsgraph.
    evaluated
        The evaluated object.
    scale
        The scale (3,) in its world matrix.
    metres
        The length of a Blender unit, in m.
    """
    collider = Collider()
    _add(collider, depsgraph, evaluated, np.eye(4), scale, metres)
    collider.finish()
    return collider


def surface_collider(evaluated: Any, scale: Array, metres: float) -> Collider:
    """Return the collider of a pad without a rigid body, which is its evaluated surface."""
    collider = Collider()
    _add_surface(collider, _triangles(evaluated) * scale * metres)
    collider.finish()
    return collider


def _add(
    collider: Collider,
    depsgraph: Any,
    evaluated: Any,
    place: Array,
    scale: Array,
    metres: float,
    part: bool = False,
) -> None:
    body = evaluated.rigid_body
    kind = body.collision_shape
    if kind == "COMPOUND":
        for child in evaluated.original.children:
            if child.rigid_body is not None:
                inner = child.evaluated_get(depsgraph)
                own = place @ _child_place(inner, scale)
                _add(collider, depsgraph, inner, own, scale, metres, part=True)
        return
    if kind == "MESH":
        base = body.mesh_source == "BASE"
        local = _triangles(evaluated.original if base else evaluated) * scale
        local = (local @ place[:3, :3].T + place[:3, 3]) * metres
        convex = len(collider.convex)
        _add_surface(collider, local)
        if len(collider.convex) > convex:
            collider.shell = local
        collider.margin = max(collider.margin, body.collision_margin * metres)
        return
    if kind == "CONVEX_HULL":
        shape = _hull(evaluated, body, scale, part)
        if body.use_margin:
            collider.margin = max(collider.margin, body.collision_margin * metres)
    else:
        shape = _primitive(evaluated, kind, scale)
        if kind == "CONE":
            collider.margin = max(collider.margin, body.collision_margin * metres)
    if shape is None:
        return
    in_metres = np.diag([metres, metres, metres, 1.0])
    placed = shape.placed(in_metres @ place)
    if metres != 1.0:
        placed = _with_radius(placed, shape.radius * metres)
    collider.convex.append(placed)
    if kind in {"SPHERE", "CYLINDER"} and len(collider.convex) == 1:
        collider.inertia = _round_inertia(kind, shape) * metres**2
    elif collider.inertia.any():
        collider.inertia = np.zeros(3)


def _child_place(child: Any, scale: Array) -> Array:
    """Return the matrix (4, 4), without scale, of a compound's child in the space of the compound.

    The compound's `scale` (3,) scales the child's distance from the origin.
    """
    place, turn, _ = child.matrix_local.decompose()
    matrix = np.array(turn.to_matrix().to_4x4(), np.float64)
    matrix[:3, 3] = np.array(place) * scale
    return matrix


def _half_extents(evaluated: Any) -> Array:
    corners = np.array(evaluated.bound_box, np.float64)
    return np.maximum((corners.max(axis=0) - corners.min(axis=0)) / 2.0, LEAST_EXTENT)


def _primitive(evaluated: Any, kind: str, scale: Array) -> Shape:
    """Return a primitive shape, centred on the object's origin, with its axis along the object's z.

    Its size follows from `scale` (3,) as in the physics engine.
    """
    half = _half_extents(evaluated)
    if kind == "BOX":
        return shapes.box(half * scale)
    if kind == "SPHERE":
        return shapes.sphere(float(half.max() * scale[0]))
    radius, height = float(max(half[0], half[1])), float(half[2])
    if kind == "CAPSULE":
        straight = max(height - radius, 0.0)
        return shapes.capsule(radius * float(scale[1]), max(straight * float(scale[2]), 1e-9))
    if kind == "CYLINDER":
        return shapes.cylinder(radius * float(scale[0]), height * float(scale[2]))
    return shapes.cone(radius * float(scale[0] + scale[1]) / 2.0, height * float(scale[2]))


def _round_inertia(kind: str, shape: Shape) -> Array:
    if kind == "SPHERE":
        return np.full(3, 0.4 * shape.radius**2)
    half = (shape.hi - shape.lo) / 2.0
    across = half[0] ** 2 / 4.0 + half[2] ** 2 / 3.0
    return np.array([across, across, half[0] ** 2 / 2.0])


def _hull(evaluated: Any, body: Any, scale: Array, part: bool) -> Shape | None:
    """Return the convex hull as the physics engine uses it; it may lie outside the mesh.

    The engine shrinks the hull by its margin, scales it, and adds the margin again. The added
    margin is scaled by the least of the three scales, or not at all for a `part` of a compound. A
    margin set by the user is added without the shrinking, so that the hull lies outside the mesh.
    """
    shape = convex_hull(np.unique(_triangles(evaluated).reshape(-1, 3), axis=0))
    if shape is None:
        return None
    by_scale = np.diag([*scale, 1.0])
    even = np.ptp(scale) < UNIT_SCALE_SLACK * scale.max()
    unscaled = np.abs(scale - 1.0).max() < UNIT_SCALE_SLACK
    if body.use_margin or unscaled or (even and not part):
        return shape.placed(by_scale)
    shrunk = _shrunk(shape, MARGIN)
    if shrunk is None:
        return shape.placed(by_scale)
    return _with_radius(shrunk.placed(by_scale), MARGIN * (1.0 if part else float(scale.min())))


def _shrunk(shape: Shape, margin: float) -> Shape | None:
    """Return the hull with its faces moved inwards by `margin`; None if nothing is left."""
    centre = shape.vertices.mean(axis=0)
    depth = shape.offsets - shape.normals @ centre
    if len(depth) < 4 or depth.min() <= margin:
        return None
    # The planes moved inwards are dual to the points n / d, whose hull gives the corners.
    dual = convex_hull(shape.normals / (depth - margin)[:, None])
    if dual is None or len(dual.offsets) < 4:
        return None
    return convex_hull(dual.normals / dual.offsets[:, None] + centre)


def convex_hull(points: Array) -> Shape | None:
    """Return the convex hull of points (n, 3); None if they span no volume."""
    mesh = bmesh.new()
    try:
        for point in points:
            mesh.verts.new(point)
        bmesh.ops.convex_hull(mesh, input=mesh.verts, use_existing_faces=False)
        loose = [vertex for vertex in mesh.verts if not vertex.link_faces]
        bmesh.ops.delete(mesh, geom=loose, context="VERTS")
        mesh.verts.index_update()
        corners = np.array([vertex.co for vertex in mesh.verts], np.float64).reshape(-1, 3)
        faces = [[vertex.index for vertex in face.verts] for face in mesh.faces]
    finally:
        mesh.free()
    try:
        return shapes.polytope(corners, faces)
    except ValueError:
        return None


def _with_radius(shape: Shape, radius: float) -> Shape:
    more = radius - shape.radius
    return replace(
        shape,
        radius=radius,
        size=shape.size + 2.0 * more,
        lo=shape.lo - more,
        hi=shape.hi + more,
    )


def _triangles(evaluated: Any) -> Array:
    points, corners = triangles_of(evaluated)
    return points[corners]


def _add_surface(collider: Collider, triangles: Array) -> None:
    """Add a surface to a collider: a convex one as one shape, any other as triangles."""
    if not len(triangles):
        return
    hull = convex_hull(np.unique(triangles.reshape(-1, 3), axis=0))
    if hull is not None and _is_convex(triangles, hull):
        collider.convex.append(hull)
    else:
        collider.triangles = np.concatenate([collider.triangles, triangles])


def _is_convex(triangles: Array, hull: Shape) -> bool:
    middles = triangles.mean(axis=1)
    depth = (hull.offsets - middles @ hull.normals.T).min(axis=1)
    return bool(depth.max() <= 1e-6 * float(np.linalg.norm(hull.hi - hull.lo)))


X, Y, Z = 0, 1, 2
# Axes along which each type of constraint gives forces, and axes about which it gives moments.
# They are in the space of the constraint's object: a hinge turns about z, a slider moves along x.
HELD: dict[str, tuple[tuple[int, ...], tuple[int, ...]]] = {
    "FIXED": ((X, Y, Z), (X, Y, Z)),
    "POINT": ((X, Y, Z), ()),
    "HINGE": ((X, Y, Z), (X, Y)),
    "SLIDER": ((Y, Z), (X, Y, Z)),
    "PISTON": ((Y, Z), (Y, Z)),
    "GENERIC": ((), ()),
    "GENERIC_SPRING": ((), ()),
    "MOTOR": ((), ()),
}
NAMES = "xyz"


def read_constraint(
    evaluated: Any, known: set[Key], metres: float
) -> tuple[Constraint, bool] | None:
    """Return the constraint of an object, and whether its two bodies may collide.

    Return None for a constraint that transmits no force. A limit or a spring counts as transmitting
    one, since statics cannot separate its force from the force of a contact.

    Parameters
    ----------
    evaluated
        The evaluated object with the constraint.
    known
        The keys of all bodies.
    metres
        The length of a Blender unit, in m.
    """
    settings = evaluated.rigid_body_constraint
    if not settings.enabled or settings.type not in HELD:
        return None
    if settings.object1 is None or settings.object2 is None:
        return None
    ends = [_key(settings.object1, known), _key(settings.object2, known)]
    forces, states = (set(axes) for axes in HELD[settings.type])
    for axis, name in enumerate(NAMES):
        spring = settings.type == "GENERIC_SPRING"
        if _flag(settings, f"use_limit_lin_{name}") or (
            spring and _flag(settings, f"use_spring_{name}")
        ):
            forces.add(axis)
        if _flag(settings, f"use_limit_ang_{name}") or (
            spring and _flag(settings, f"use_spring_ang_{name}")
        ):
            states.add(axis)
    if settings.type == "MOTOR":
        forces |= {X} if settings.use_motor_lin else set()
        states |= {X} if settings.use_motor_ang else set()
    if None in ends or not (forces or states):
        return None
    matrix = np.array(evaluated.matrix_world, np.float64)
    axes = matrix[:3, :3] / np.linalg.norm(matrix[:3, :3], axis=0)
    constraint = Constraint(
        evaluated.original.name,
        ends[0],
        ends[1],
        matrix[:3, 3] * metres,
        axes.T[sorted(forces)],
        axes.T[sorted(states)],
    )
    return constraint, not settings.disable_collisions


# The types that use limits. On other types Blender ignores the limits.
LIMITED = {
    "lin": {"GENERIC", "GENERIC_SPRING", "SLIDER", "PISTON"},
    "ang": {"GENERIC", "GENERIC_SPRING", "HINGE", "PISTON"},
}


def _flag(settings: Any, name: str) -> bool:
    if name.startswith("use_limit_") and settings.type not in LIMITED[name[10:13]]:
        return False
    return bool(getattr(settings, name))


def _key(end: Any, known: set[Key]) -> Key | None:
    """Return the key of an object that a constraint connects; None if it is no rigid body."""
    key = (end.original.session_uid,)
    return key if key in known else None
