# SPDX-License-Identifier: GPL-3.0-or-later
"""Figures of the home: rooms, walls, openings, doors, furniture footprints, sensors, lamps.

Plain data, no bpy. Metres; x east, y north, z up; the finished floor lies at `FLOOR_Z`. Angles are
degrees; a yaw of 0 faces +x, counter-clockwise seen from above. The walls, doors, switches and
lamps follow the figures of the real research apartment. We chose the furniture of living room,
kitchen, bathroom and hall.
"""

from dataclasses import dataclass

FLOOR_Z = 0.055
WALL_TOP = 3.0
DOOR_HEAD = 2.25
WINDOW_SILL = 0.75
WINDOW_HEAD = 2.25
FPS = 24


@dataclass(frozen=True)
class Box:
    """An axis-aligned box: its low and high corner."""

    x0: float
    y0: float
    z0: float
    x1: float
    y1: float
    z1: float


# --- rooms -----------------------------------------------------------------------------
# Free floor of each room as rectangles (x0, y0, x1, y1). Hall and living room have no wall between
# them; we chose the line.
ROOMS: dict[str, tuple[tuple[float, float, float, float], ...]] = {
    "workroom": ((0.0, 6.3, 3.5, 8.3),),
    "kitchen": ((0.0, 3.3, 3.5, 6.0),),
    "bedroom": ((0.0, 0.3, 3.5, 3.0),),
    "bathroom": ((3.7, 0.3, 6.7, 1.6),),
    "closet": ((5.7, 1.8, 6.2, 2.8), (6.2, 1.8, 6.7, 2.7)),
    "hall": ((3.7, 1.8, 5.5, 8.3), (5.5, 3.0, 6.2, 8.3)),
    "living room": ((6.2, 3.0, 10.665, 7.0),),
    "balcony": ((10.965, 3.0, 12.165, 7.0),),
}
LANDING = (3.4, 8.5, 6.6, 10.3)  # the stairwell's floor outside the entrance

# --- walls, as boxes (full solids; openings are the gaps between boxes) ----------------
_T, _S, _H, _D = WALL_TOP, WINDOW_SILL, WINDOW_HEAD, DOOR_HEAD
OUTER_WALLS: tuple[Box, ...] = (
    Box(-0.4, 0.0, 0, 7.0, 0.3, _T),
    Box(6.7, 0.3, 0, 7.0, 2.7, _T),
    Box(6.2, 2.7, 0, 10.965, 3.0, _T),
    Box(6.2, 7.0, 0, 10.965, 7.3, _T),
    Box(6.2, 7.3, 0, 6.5, 8.5, _T),
    Box(5.4, 8.3, 0, 6.2, 8.5, _T),
    Box(-0.4, 8.3, 0, 4.4, 8.5, _T),
    Box(4.4, 8.3, _D, 5.4, 8.5, _T),  # over the entrance
    Box(-0.4, 0.3, 0, 0.0, 8.3, _S),  # under the west windows
    Box(-0.4, 0.3, _H, 0.0, 8.3, _T),
    Box(-0.4, 0.3, _S, 0.0, 1.7, _H),
    Box(-0.4, 2.7, _S, 0.0, 3.3, _H),
    Box(-0.4, 5.3, _S, 0.0, 7.3, _H),
    Box(10.665, 3.0, 0, 10.965, 3.65, _T),
    Box(10.665, 3.65, 0, 10.965, 5.65, _S),
    Box(10.665, 3.65, _H, 10.965, 5.65, _T),
    Box(10.665, 5.65, 0, 10.965, 5.85, _T),
    Box(10.665, 5.85, _D, 10.965, 6.85, _T),  # over the balcony door
    Box(10.665, 6.85, 0, 10.965, 7.0, _T),
)
INNER_WALLS: tuple[Box, ...] = (
    Box(0.0, 6.0, 0, 3.5, 6.3, _T),
    Box(0.0, 3.0, 0, 3.5, 3.3, _T),
    Box(3.5, 8.1, 0, 3.7, 8.3, _T),
    Box(3.5, 7.1, _D, 3.7, 8.1, _T),  # over the workroom's door
    Box(3.5, 5.0, 0, 3.7, 7.1, _T),
    Box(3.5, 4.0, _D, 3.7, 5.0, _T),  # over the kitchen's door
    Box(3.5, 2.8, 0, 3.7, 4.0, _T),
    Box(3.5, 1.8, _D, 3.7, 2.8, _T),  # over the bedroom's door
    Box(3.5, 0.3, 0, 3.7, 1.8, _T),
    Box(3.7, 1.6, 0, 4.2, 1.8, _T),
    Box(4.2, 1.6, _D, 5.2, 1.8, _T),  # over the bathroom's door
    Box(5.2, 1.6, 0, 6.7, 1.8, _T),
    Box(5.5, 1.8, 0, 5.7, 2.0, _T),
    Box(5.5, 2.0, _D, 5.7, 2.6, _T),  # over the closet's door
    Box(5.5, 2.6, 0, 5.7, 2.8, _T),
    Box(5.5, 2.8, 0, 6.2, 3.0, _T),
)
BALCONY_WALLS: tuple[Box, ...] = (
    Box(10.965, 7.0, 0, 12.465, 7.3, 1.0),
    Box(12.165, 3.0, 0, 12.465, 7.0, 1.0),
    Box(10.965, 2.7, 0, 12.465, 3.0, 1.0),
    Box(10.965, 7.0, _H, 12.465, 7.3, _T),
    Box(12.165, 3.0, _H, 12.465, 7.0, _T),
    Box(10.965, 2.7, _H, 12.465, 3.0, _T),
)
BALCONY_GLAZING: tuple[Box, ...] = (
    Box(10.965, 7.2, 1.0, 12.465, 7.3, _H),
    Box(12.365, 2.8, 1.0, 12.465, 7.2, _H),
    Box(10.965, 2.7, 1.0, 12.465, 2.8, _H),
)
FLOOR_SLABS: tuple[tuple[float, float, float, float], ...] = (
    (-0.4, 0.0, 7.0, 2.7),
    (-0.4, 2.7, 12.465, 7.3),
    (-0.4, 7.3, 6.5, 8.5),
)


@dataclass(frozen=True)
class Window:
    """An opening in a wall that runs along y, from sill to head; x0, x1 are the wall's faces."""

    name: str
    x0: float
    x1: float
    y0: float
    y1: float
    inside: float  # +1: the room lies towards +x, -1: towards -x


WINDOWS: tuple[Window, ...] = (
    Window("bedroom", -0.4, 0.0, 1.7, 2.7, 1.0),
    Window("kitchen", -0.4, 0.0, 3.3, 5.3, 1.0),
    Window("workroom", -0.4, 0.0, 7.3, 8.3, 1.0),
    Window("living room", 10.665, 10.965, 3.65, 5.65, -1.0),
)


# --- doors and their optical switches ----------------------------------------------------
LEAF_THICKNESS = 0.06
LEAF_BOTTOM = 0.06
LEAF_TOP = 2.06
SWITCH_Z = 2.265
SWITCH_GAP = 0.05
FLAG_Z = (2.06, 2.29)


@dataclass(frozen=True)
class Door:
    """A hinged leaf, whose object has its origin on the hinge at z = 0.

    The leaf runs along local +x from 0 to `leaf_width`. Its face on the swing side lies at local y
    = 0, its back at y = +LEAF_THICKNESS. Every door opens clockwise seen from above (yaw falls).
    """

    name: str
    hinge: tuple[float, float]
    closed_yaw: float
    open_yaw: float
    switch: tuple[float, float]  # the beam's origin (x, y); z is SWITCH_Z
    switch_yaw: float  # the beam's direction
    other_side: str
    swing_side: str = "hall"  # the room the leaf swings into
    leaf_width: float = 1.0
    opening: float = 1.0  # width of the hole in the wall, which starts at `opening_at`
    opening_at: float = 0.0  # local x
    wall_face: float = 0.03  # local y of the wall's face on the swing side
    wall_depth: float = 0.2


DOORS: dict[str, Door] = {
    door.name: door
    for door in (
        Door("entrance", (4.4, 8.25), 0.0, -97.0, (4.875, 8.285), 0.0, "landing", wall_face=0.05),
        Door("workroom", (3.73, 7.1), 90.0, -53.2, (3.715, 7.575), 90.0, "workroom"),
        Door("kitchen", (3.73, 4.0), 90.0, -53.2, (3.715, 4.475), 90.0, "kitchen"),
        # A full swing would hit the bathroom's wall.
        Door("bedroom", (3.73, 1.83), 90.0, 3.0, (3.715, 2.245), 90.0, "bedroom",
             leaf_width=0.96, opening_at=-0.03),
        Door("bathroom", (4.2, 1.56), 0.0, -95.0, (4.67, 1.58), 0.0, "hall",
             swing_side="bathroom", wall_face=0.04),
        Door("balcony", (11.0, 5.85), 90.0, -75.0, (10.98, 6.325), 90.0, "living room",
             swing_side="balcony", wall_face=0.035, wall_depth=0.3),
        # Hung on the north jamb, so that the open leaf keeps clear of the bathroom's doorway.
        Door("closet", (5.465, 2.6), -90.0, -235.0, (5.475, 2.275), 90.0, "closet",
             leaf_width=0.6, opening=0.6, wall_face=0.035),
    )
}  # fmt: skip

# --- furniture footprints: obstacles for walkers -----------------------------------------
SOFA_SEAT_Z, BED_TOP_Z, TOILET_SEAT_Z = 0.47, 0.56, 0.475
FURNITURE: dict[str, Box] = {
    # living room
    "Sofa": Box(8.15, 6.05, 0.055, 10.0, 6.97, 0.85),
    "Coffee table": Box(8.6, 4.78, 0.055, 9.6, 5.33, 0.47),
    "TV bench": Box(8.35, 3.02, 0.055, 9.85, 3.42, 0.55),
    "Dining table": Box(6.95, 3.8, 0.055, 8.25, 4.6, 0.795),
    "Dining chair 1": Box(7.04, 4.5, 0.055, 7.46, 5.06, 0.92),
    "Dining chair 2": Box(7.74, 4.5, 0.055, 8.16, 5.06, 0.92),
    "Dining chair 3": Box(7.04, 3.34, 0.055, 7.46, 3.9, 0.92),
    "Dining chair 4": Box(7.74, 3.34, 0.055, 8.16, 3.9, 0.92),
    "Bookcase": Box(6.5, 6.68, 0.055, 7.5, 6.995, 1.95),
    "Floor lamp": Box(7.65, 6.52, 0.055, 8.01, 6.88, 1.65),
    "Plant living room": Box(10.02, 3.02, 0.055, 10.64, 3.64, 1.5),
    # kitchen
    "Kitchen base": Box(0.0, 5.38, 0.055, 2.86, 6.0, 0.95),
    "Fridge": Box(2.88, 5.37, 0.055, 3.48, 5.99, 1.90),
    "Kitchen table": Box(0.05, 3.95, 0.055, 0.8, 4.65, 0.795),
    "Kitchen chair 1": Box(0.22, 3.35, 0.055, 0.64, 3.91, 0.92),
    "Kitchen chair 2": Box(0.66, 4.09, 0.055, 1.22, 4.51, 0.92),
    # bedroom
    "Bed": Box(1.28, 0.33, 0.055, 3.48, 1.77, 0.95),
    "Bedroom desk": Box(0.01, 1.85, 0.055, 0.61, 2.95, 0.74),
    "Bedroom shelf 1": Box(1.3, 2.63, 0.055, 2.38, 2.99, 1.615),
    "Bedroom shelf 2": Box(2.4, 2.63, 0.055, 3.48, 2.99, 1.615),
    "Armchair": Box(0.02, 0.315, 0.055, 0.86, 1.155, 1.0),
    "Bedroom chair": Box(0.55, 1.94, 0.055, 1.11, 2.39, 0.92),
    # workroom
    "Workroom desk 1": Box(0.22, 6.32, 0.055, 1.67, 7.0, 0.68),
    "Workroom desk 2": Box(1.95, 6.32, 0.055, 3.42, 7.0, 0.68),
    "Office chair 1": Box(0.76, 6.95, 0.055, 1.4, 7.6, 1.05),
    "Office chair 2": Box(2.48, 6.55, 0.055, 3.12, 7.2, 1.05),
    "Workroom shelf": Box(1.98, 8.0, 0.055, 3.3, 8.29, 0.9),
    # bathroom
    "Toilet": Box(5.31, 0.3, 0.055, 5.69, 0.95, 0.95),
    "Washbasin": Box(4.68, 0.3, 0.055, 5.12, 0.67, 0.9),
    "Shower screen": Box(5.89, 0.3, 0.055, 5.91, 0.95, 2.05),
    "Laundry basket": Box(3.72, 0.32, 0.055, 4.02, 0.62, 0.6),
    # closet
    "Washing machine": Box(6.09, 1.81, 0.055, 6.69, 2.41, 0.92),
    # hall
    "Shoe bench": Box(5.88, 7.04, 0.055, 6.2, 7.6, 0.5),
    "Hall cabinet": Box(3.7, 5.2, 0.055, 4.0, 6.1, 0.9),
    # balcony
    "Balcony chair": Box(11.0, 3.55, 0.055, 11.8, 4.35, 0.9),
    "Balcony table": Box(11.12, 3.03, 0.055, 11.56, 3.47, 0.6),
    "Balcony plants": Box(11.6, 3.02, 0.055, 12.15, 3.54, 1.3),
    "Balcony plant 3": Box(11.82, 6.58, 0.055, 12.14, 6.9, 0.7),
    # landing
    "Landing plant": Box(5.85, 8.53, 0.055, 6.35, 9.03, 1.2),
}


# --- sensors --------------------------------------------------------------------------------
@dataclass(frozen=True)
class Mount:
    """The place of a sensor, and the yaw along which it senses (level, as in the thesis)."""

    room: str
    at: tuple[float, float, float]
    yaw: float
    range_max: float = 4.0


PIRS: dict[str, Mount] = {
    # Bedroom: the pose printed in the thesis; kitchen, workroom, living room, hall: natural
    # corners.
    "PIR bedroom": Mount("bedroom", (3.4, 0.4, 2.9), 146.0),
    "PIR kitchen": Mount("kitchen", (0.1, 3.4, 2.35), 38.0),
    "PIR workroom": Mount("workroom", (0.1, 8.2, 2.35), -38.0),
    "PIR living room": Mount("living room", (10.565, 6.9, 2.35), -138.0, 6.0),
    "PIR hall": Mount("hall", (6.1, 8.2, 2.35), -125.0, 6.0),
    "PIR bathroom": Mount("bathroom", (5.8, 0.34, 2.35), 120.0, 3.0),
    "PIR closet": Mount("closet", (6.6, 2.6, 2.35), -150.0, 2.0),
}
LIGHT_SENSORS: dict[str, Mount] = {
    "Light sensor bedroom": Mount("bedroom", (1.75, 1.65, 2.85), 0.0),
    "Light sensor kitchen": Mount("kitchen", (1.75, 4.65, 2.85), 0.0),
    "Light sensor workroom": Mount("workroom", (1.75, 7.3, 2.85), 0.0),
    "Light sensor living room": Mount("living room", (8.4, 5.0, 2.85), 0.0),
    "Light sensor hall": Mount("hall", (4.6, 5.25, 2.85), 0.0),
    "Light sensor bathroom": Mount("bathroom", (5.2, 0.95, 2.85), 0.0),
    "Light sensor closet": Mount("closet", (6.2, 2.25, 2.85), 0.0),
}
# The loads of the pad: the person, and the cushion on it. The sofa's frame is below the tolerance,
# and does not carry the cushion. PRESSURE_THRESHOLD (N) is above the cushion's weight.
PERSON_MASS = 70.0
CUSHION_MASS = 2.5
CUSHION_TOLERANCE = 0.005
# Kilograms of the cushions on the pad's cushion, which take some weight of a person leaning back.
LEANING_MASSES = {"Pillow rust": 0.5, "Sofa back cushion west": 1.5}
PRESSURE_THRESHOLD = 100.0
# Centre of the pad's upper face and its size (x, y, thickness).
PRESSURE_PAD_AT = (8.66, 6.44, 0.312)
PRESSURE_PAD_SIZE = (0.62, 0.52, 0.012)

# --- lamps: the figures give living room, kitchen, bedroom, workroom and bathroom ----------
LAMPS: dict[str, tuple[float, float, float]] = {
    "Lamp living room": (7.6, 4.2, 1.5),
    "Lamp kitchen": (1.81, 3.59, 2.15),
    "Lamp bedroom": (1.81, 0.6, 2.15),
    "Lamp workroom": (1.81, 6.6, 2.15),
    "Lamp bathroom": (4.9, 0.36, 2.05),
    "Lamp hall": (4.85, 5.9, 2.9),
    "Lamp entry": (4.95, 7.55, 2.9),
    "Lamp closet": (6.2, 2.05, 2.93),
    "Lamp balcony": (11.05, 4.65, 2.3),
}
