# SPDX-License-Identifier: GPL-3.0-or-later
"""Read and guess the marks of objects, which say what residents do there and how doors open."""

from __future__ import annotations

import math
from typing import Any

import bpy
import numpy as np
from bpy.props import BoolProperty, EnumProperty, FloatProperty, PointerProperty, StringProperty
from bpy.types import Context, Object

from ...angen_addon.scene.bearers import candidates
from ...angen_addon.scene.door_motion import MOTIONS, Leaf, leaves_of, shutting_of
from ...angen_addon.scene.home.evaluated_home import EvaluatedHome
from ...angen_addon.scene.home.floor import free_ways
from ...angen_addon.scene.instances import is_holder, objects_of
from ...angen_addon.scene.lengths import OVERRIDABLE, property_group
from ...angen_addon.scene.sensors import NotPlaced, known_rooms, placed_matrix, unit_scale
from ...sensor_logic.logs.error import AngenError
from ...sensor_logic.model import Array
from ...sensor_logic.progress import finished
from ..acting import places as known
from ..acting.places import CUPBOARD, CURTAIN, DRAWER, LEAVES, LIE, SIT, Door
from .settings import is_resident

# Uses whose objects face a direction.
FACING = (
    known.STAND, known.SIT, known.LIE, known.USE, known.TAP, known.APPLIANCE, known.DRAWER,
    known.CUPBOARD,
)  # fmt: skip


def facing_of(obj: Any, matrix: Any) -> Array:
    """Return the direction in which a marked object faces, a unit vector (2,) on the floor."""
    angle = obj.angen_place.facing
    local = np.array([math.sin(angle), -math.cos(angle), 0.0])
    found: Array = (np.array(matrix)[:3, :3] @ local)[:2]
    size = float(np.linalg.norm(found))
    # The front of an object that lies on its back faces up or down: it has no direction.
    return found / size if size > 1e-9 else local[:2]


def set_facing(obj: Any, matrix: Any, look: Array) -> None:
    """Set the mark's angle so that the object faces along `look` (2,) on the floor.

    `matrix` is the object's world matrix.
    """
    axes = np.array(matrix)[:2, :2]
    if abs(np.linalg.det(axes)) < 1e-12:
        return
    local = np.linalg.solve(axes, look)
    obj.angen_place.facing = math.atan2(local[0], -local[1])


def is_living_body(obj: Any) -> bool:
    """Return whether an object belongs to the body of a resident or of an animated walker.

    A walker's body has an armature and a mass, each on the object or one of its parents.
    """
    owners = list(candidates(obj))
    rigged = any(owner.type == "ARMATURE" for owner in owners)
    return any(map(is_resident, owners)) or (
        rigged and any(owner.angen_load.mass > 0.0 for owner in owners)
    )


DOWN = np.array([0.0, 0.0, -1.0])


class MarkedObject:
    """An object that is marked as a place, with its children except residents.

    Raise `NotPlaced` if the object is not in the evaluated scene.

    Attributes
    ----------
    at
        The object's origin, shape (3,), m.
    points
        The vertices of the object and its children, shape (n, 3), m.
    rows
        The numbers of their solids in the home, shape (k,).
    """

    def __init__(self, home: EvaluatedHome, obj: Any) -> None:
        self.obj = obj
        self.matrix = placed_matrix(obj, home.depsgraph).copy()
        self.at = np.array(self.matrix.translation) * home.metres
        uid = obj.session_uid
        self.home = home.part(
            lambda solid: uid in solid.owners and not is_living_body(solid.original)
        )
        self.rows = self.home.rows
        wanted = np.zeros(len(home.caster.solids.solids), bool)
        wanted[self.rows] = True
        parts = [surface.points for surface in home.surfaces(wanted)] if len(self.rows) else []
        points = np.concatenate(parts) if parts else np.empty((0, 3))
        self.points = points[np.isfinite(points).all(axis=1)]

    @property
    def solid(self) -> bool:
        """Whether the object or a child has a surface."""
        return bool(len(self.points))

    @property
    def middle(self) -> Array:
        """The middle of the bounding box, shape (3,), m; without a surface, the object's origin."""
        if not self.solid:
            return self.at
        middle: Array = (self.points.min(axis=0) + self.points.max(axis=0)) / 2.0
        return middle

    @property
    def size(self) -> float:
        """The largest side of the bounding box, m."""
        return float(np.ptp(self.points, axis=0).max()) if self.solid else 0.0

    def reach(self, way: Array) -> tuple[float, float]:
        """Return the least and the greatest coordinate of the object along a direction, m.

        `way` is a horizontal unit vector, shape (2,).
        """
        if not self.solid:
            here = float(self.at[:2] @ way)
            return here, here
        along = self.points[:, :2] @ way
        return float(along.min()), float(along.max())

    def box(self, look: Array) -> tuple[Array, float, float]:
        """Return middle (2,), half length and half width of the object on the floor, m.

        The length is along the unit vector `look`, and the width is across it.
        """
        across = np.array([-look[1], look[0]])
        near, far = self.reach(look)
        right, left = self.reach(across)
        middle: Array = look * (near + far) / 2.0 + across * (right + left) / 2.0
        return middle, (far - near) / 2.0, (left - right) / 2.0

    def heights(self, points: Array) -> Array:
        """Return the heights of the object's top at points (n, 2), m; NaN beside the object."""
        if not self.solid:
            return np.full(len(points), np.nan)
        top, bottom = float(self.points[:, 2].max()) + 0.05, float(self.points[:, 2].min()) - 0.05
        starts = np.column_stack([points, np.full(len(points), top)])
        ranges = finished(free_ways(self.home, starts, DOWN, top - bottom))
        return np.where(ranges < top - bottom - 1e-6, top - ranges, np.nan)


UP = np.array([0.0, 0.0, 1.0])
# m: height of a handle above the floor, and its largest distance from the free edge. On a narrow
# leaf the distance is INSET of the width.
HANDLE_M, INSET_M, INSET = 1.05, 0.11, 0.15
# A leaf slides by this share of its width or depth, unless the mark sets a length.
SLIDES = 0.9


def leaf_of(obj: Any) -> tuple[Leaf, Any]:
    """Return the leaf that a marked door or curtain most likely has, and the matrix that shuts it.

    The leaf is in the shut position. Raise `AngenError` if the object cannot be a leaf.
    """
    mark = obj.angen_place
    if is_holder(obj):
        raise AngenError(
            "it is an instance of a collection: make it real (Object → Apply → Make Instances "
            "Real), and mark the leaf"
        )
    motion = "SLIDING" if mark.use == CURTAIN else mark.motion
    shutting = shutting_of(obj)
    leaf = leaves_of(obj, motion, shutting)[0][0]
    if mark.other_side:
        turned = leaf.turned_round()
        if leaf.slides:
            # A sliding leaf moves to its other end.
            corner = leaf.corner - leaf.edge * leaf.width
            turned = Leaf(corner, -leaf.edge, leaf.out, leaf.up, leaf.width, leaf.thickness, True)
        leaf = turned
    return leaf, shutting


def opening_angle(leaf: Leaf, angle: float) -> float:
    """Return the turn about Z that opens a leaf towards its vector `out`: ±`angle`, rad."""
    return angle if leaf.up.cross(leaf.edge).dot(leaf.out) > 0.0 else -angle


def door_of(home: EvaluatedHome, obj: Any, floor: float, room: str, number: int) -> Door:
    """Return the door of a marked object.

    Parameters
    ----------
    floor
        The height of the storey's floor, m.
    room
        The name of the room.
    number
        The storey's index; 0 is the lowest.

    Raises
    ------
    AngenError
        If the object cannot be a leaf.
    """
    if obj.angen_place.use == DRAWER:
        return _drawer(home, obj, room, number)
    leaf, shutting = leaf_of(obj)
    mark, metres = obj.angen_place, home.metres
    edge, out, up = (np.array(v) for v in (leaf.edge, leaf.out, leaf.up))
    corner = np.array(leaf.corner) * metres
    width, thick = leaf.width * metres, leaf.thickness * metres
    low_z = float(MarkedObject(home, obj).points[:, 2].min(initial=corner[2]))
    hinge = corner - edge * width
    if leaf.pivot is not None and not leaf.slides:
        hinge = np.array(leaf.pivot) * metres
    hinge = np.array([hinge[0], hinge[1], low_z])
    frame = np.column_stack([edge, np.cross(up, edge), up])
    # The leaf's bounding box in that frame, computed from its free upper corner.
    free = (corner - hinge) @ frame
    side = float(out @ frame[:, 1])
    faces = sorted((free[1], free[1] - side * thick))
    low = np.array([free[0] - width, faces[0], 0.0])
    high = np.array([free[0], faces[1], float(corner[2] - low_z)])
    handle = _handle_point(low, high, floor - low_z)
    if leaf.slides:
        way = -edge
        slide = mark.slide or SLIDES * width
        shut = float(np.array(shutting.translation) * metres @ way)
        return Door(
            obj.name, mark.use, hinge - way * shut, way, shut, shut + slide, frame, low, high,
            handle, True, mark.entrance, room, number,
        )  # fmt: skip
    about, turned = shutting.to_quaternion().to_axis_angle()
    shut = turned if about.z >= 0.0 else -turned
    back = np.array(shutting.to_3x3().normalized().inverted())
    opened = shut + opening_angle(leaf, mark.angle)
    return Door(
        obj.name, mark.use, hinge, UP, shut, opened, back @ frame, low, high, handle, False,
        mark.entrance, room, number,
    )  # fmt: skip


def _handle_point(low: Array, high: Array, floor: float) -> Array:
    """Return the handle in the leaf's own coordinates, shape (3,), m.

    `low` and `high` are the corners of the leaf's box, and `floor` is the floor's height, in these
    coordinates.
    """
    width, height = float(high[0] - low[0]), float(high[2])
    at = floor + HANDLE_M
    if not 0.1 * height <= at <= 0.95 * height:
        at = height / 2.0
    inset = min(INSET_M, INSET * width)
    return np.array([high[0] - inset, (low[1] + high[1]) / 2.0, at])


def _drawer(home: EvaluatedHome, obj: Any, room: str, number: int) -> Door:
    """Return a drawer as a door that slides towards the person in front of it."""
    marked = MarkedObject(home, obj)
    if not marked.solid:
        raise AngenError("it has no surface: mark the drawer's mesh object")
    look = facing_of(obj, marked.matrix)
    middle, deep, wide = marked.box(look)
    low_z, high_z = float(marked.points[:, 2].min()), float(marked.points[:, 2].max())
    way = np.array([*-look, 0.0])
    across = np.cross(UP, way)
    hinge = np.array([*(middle - look * deep), low_z]) - across * wide
    frame = np.column_stack([across, -way, UP])
    high = np.array([2 * wide, 2 * deep, high_z - low_z])
    handle = np.array([wide, 0.0, high[2] / 2.0])
    slide = obj.angen_place.slide or SLIDES * 2 * deep
    return Door(
        obj.name, DRAWER, hinge, way, 0.0, slide, frame, np.zeros(3), high, handle, True, False,
        room, number,
    )  # fmt: skip


def describe_leaf(obj: Any) -> tuple[str, bool]:
    """Return a panel's text on how a marked leaf moves, and whether the leaf slides."""
    try:
        leaf, _ = leaf_of(obj)
    except AngenError as error:
        return str(error), False
    if leaf.slides:
        return "Slides along its width", True
    hinge = "at its origin" if leaf.pivot is not None else "at the edge of its bounding box"
    text = f"Hinge {hinge}"
    if leaf.guessed:
        text = f"Hinge {hinge} (a guess: if it is wrong, choose another Motion)"
    return text, False


# m: an object whose top varies by less has no back.
UNEVEN_M = 0.08
# m: free room is measured up to FAR_M, from BEYOND_M outside the bounding box.
FAR_M, BEYOND_M = 3.0, 0.01
# m: more free room than this is not better. Lower objects do not block the view across them.
ENOUGH_M, LOW_M = 1.0, 1.3


def guess(obj: Any, depsgraph: Any) -> None:
    """Guess the settings of an object's mark: where it faces, or how far a door opens."""
    mark = obj.angen_place
    if mark.use in LEAVES:
        try:
            leaf, _ = leaf_of(obj)
        except AngenError:
            return
        if mark.use == CUPBOARD:
            _guess_front(obj, leaf, depsgraph)
        keyed = leaf.opening
        if keyed is not None and keyed.pivot and keyed.turn:
            mark.angle = abs(keyed.turn)
        if keyed is not None and leaf.slides and keyed.way.length:
            mark.slide = keyed.way.length * unit_scale(depsgraph.scene)
    elif mark.use in FACING:
        home = EvaluatedHome(depsgraph)
        try:
            marked = MarkedObject(home, obj)
        except NotPlaced:
            return
        look = _guess_facing(home, marked, mark.use)
        if look is not None:
            set_facing(obj, marked.matrix, look)


def _guess_front(obj: Any, leaf: Leaf, depsgraph: Any) -> None:
    """Guess the side of a cupboard's leaf on which people stand: the side with more room.

    Without keyframes, the leaf opens to this side.
    """
    home = EvaluatedHome(depsgraph)
    try:
        marked = MarkedObject(home, obj)
    except NotPlaced:
        return
    out = np.array(leaf.out)[:2] / max(math.hypot(*leaf.out.xy), 1e-9)
    if leaf.opening is None and _free_distance(home, marked, -out) > _free_distance(
        home, marked, out
    ):
        obj.angen_place.other_side = not obj.angen_place.other_side
        out = -out
    set_facing(obj, marked.matrix, -out)


def _guess_facing(home: EvaluatedHome, marked: MarkedObject, use: str) -> Array | None:
    """Return the direction in which an object most likely faces, shape (2,).

    Return None if the object has no surface.
    """
    axes = np.array(marked.matrix)[:2, :2].T
    sizes = np.linalg.norm(axes, axis=1)
    if sizes.min() < 1e-9:
        axes, sizes = np.eye(2), np.ones(2)
    x, y = axes / sizes[:, None]
    ways = [-y, x, y, -x]
    if not marked.solid:
        return None
    if use == LIE:
        _, deep, wide = marked.box(x)
        ways = [x, -x] if deep > wide else [y, -y]
    tops = [_top_height_at(marked, way) for way in ways]
    free = [_free_distance(home, marked, way) for way in ways]
    if max(tops) - min(tops) > UNEVEN_M and use in (SIT, LIE):
        high = int(np.argmax(tops))
        return ways[high] if use == LIE else -ways[high]
    # A person is on the side with free room and a wall opposite; else at the object's front.
    room = np.round(np.minimum(free, ENOUGH_M), 1)
    back = room[[2, 3, 0, 1]] if len(ways) == 4 else room[::-1]
    front = ways[int(np.argmax(room - back))]
    return front if use == SIT else -front


def _top_height_at(marked: MarkedObject, way: Array) -> float:
    """Return the height of the object's top near its end in the direction `way`, m."""
    middle, deep, wide = marked.box(way)
    across = np.array([-way[1], way[0]])
    points = [
        middle + way * (deep - inset * deep) + across * wide * k
        for inset in (0.04, 0.1, 0.16)
        for k in (-0.5, 0.0, 0.5)
    ]
    heights = marked.heights(np.array(points))
    return float(np.nanmax(heights)) if np.isfinite(heights).any() else 0.0


def _free_distance(home: EvaluatedHome, marked: MarkedObject, way: Array) -> float:
    """Return the distance without an obstacle beyond the object's end in the direction `way`, m."""
    middle, deep, wide = marked.box(way)
    across = np.array([-way[1], way[0]])
    rows = set(marked.rows.tolist())
    others = home.part(lambda solid: solid.row not in rows)
    # Measure above a low object, which may be built into something, such as a sink.
    low, top = float(marked.points[:, 2].min()), float(marked.points[:, 2].max())
    level = top + 0.05 if top - low < LOW_M else (low + top) / 2.0
    edge = middle + way * (deep + BEYOND_M)
    starts = [[*(edge + across * wide * k), level] for k in (-0.6, 0.0, 0.6)]
    ranges = finished(free_ways(others, np.array(starts), np.array([*way, 0.0]), FAR_M))
    return float(np.mean(ranges))


NONE = "NONE"
USES = [
    (NONE, "None", "No place for residents", "NONE", 0),
    (known.STAND, "Stand", "Residents stand there", "USER", 1),
    (known.SIT, "Sit", "Residents sit on it", "ASSET_MANAGER", 2),
    (known.LIE, "Lie", "Residents lie on it", "MOD_CLOTH", 3),
    (known.USE, "Use", "Residents stand in front of it and use their hands", "VIEW_PAN", 4),
    (
        known.DOOR,
        "Door",
        "Leaf of a door, which residents open and close as they pass",
        "MOD_ARRAY",
        5,
    ),
    (known.LAMP, "Lamp", "Residents switch it on and off", "LIGHT", 6),
    (known.TAP, "Tap", "Residents take water there", "MOD_FLUIDSIM", 7),
    (
        known.APPLIANCE,
        "Appliance",
        "Residents stand in front of it and operate it",
        "PREFERENCES",
        8,
    ),
    (known.DRAWER, "Drawer", "Residents pull it out and push it in", "REMOVE", 9),
    (known.CURTAIN, "Curtain", "Residents draw it aside along its width", "MOD_OPACITY", 10),
    (
        known.CUPBOARD,
        "Cupboard",
        "Leaf of a cupboard, which residents open, but do not pass",
        "MESH_PLANE",
        11,
    ),
]
LABELS = {identifier: label for identifier, label, *_ in USES}
# Uses for which a person stands at a distance.
WITH_DISTANCE = (known.USE, known.TAP, known.APPLIANCE, known.DRAWER, known.CUPBOARD)


def _use_changed(self: Any, context: Context) -> None:
    obj = self.id_data
    if self.use != NONE and not obj.library and obj.name in context.view_layer.objects:
        guess(obj, context.evaluated_depsgraph_get())


MARK = property_group(
    "AngenPlace",
    {
        "use": EnumProperty(
            name="Use", description="What residents do there", items=USES, update=_use_changed
        ),
        "room": StringProperty(
            name="Room",
            description="Room of the place. Empty: guessed from the sensors nearby",
            search=known_rooms,
            search_options={"SUGGESTION"},
        ),
        "facing": FloatProperty(
            name="Facing",
            description="Direction in which residents look there, or in which the head lies: the "
            "angle about the object's Z from its front (−Y)",
            subtype="ANGLE",
        ),
        "away": FloatProperty(
            name="Distance",
            description="Distance from the front to the resident; 0: as near as possible",
            subtype="DISTANCE",
            min=0.0,
            soft_max=2.0,
        ),
        "motion": EnumProperty(name="Motion", description="How the leaf moves", items=MOTIONS),
        "other_side": BoolProperty(
            name="Other Side",
            description="Open to the other side, or slide to the other end",
        ),
        "angle": FloatProperty(
            name="Opens By",
            description="Angle of the leaf from shut to open",
            subtype="ANGLE",
            default=math.radians(90),
            min=0.0,
            max=math.pi,
        ),
        "slide": FloatProperty(
            name="Slides By",
            description="Distance from shut to open; 0: nearly the whole width, or depth",
            subtype="DISTANCE",
            min=0.0,
            soft_max=3.0,
        ),
        "entrance": BoolProperty(
            name="Entrance", description="Residents enter and leave the home by this door"
        ),
        "switch": PointerProperty(
            name="Switch",
            description="Object where the lamp is switched, such as an empty on a wall. Empty: at "
            "the lamp itself, or from anywhere if the lamp is higher than 2.2 m",
            type=Object,
            options={"ANIMATABLE"},
        ),
    },
    options=set(),
    override=OVERRIDABLE,
)


def marked(view_layer: Any) -> list[Any]:
    """Return the marked objects of a view layer, sorted by name."""
    found = [obj for obj in objects_of(view_layer) if obj.angen_place.use != NONE]
    return sorted(found, key=lambda obj: obj.name)


_register, _unregister = bpy.utils.register_classes_factory((MARK,))


def register() -> None:
    _register()
    Object.angen_place = PointerProperty(type=MARK, override=OVERRIDABLE)


def unregister() -> None:
    del Object.angen_place
    _unregister()
