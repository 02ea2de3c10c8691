# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the story happens in the home: places, and the ways between them.

Plain data, no bpy, in the units of `plan`.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Place:
    """Where a person stands (x, y) and which way she looks; `seat` is the point of the hips'
    underside when she sits (or lies), with the seat's height above z = 0."""

    x: float
    y: float
    yaw: float
    seat: tuple[float, float, float] | None = None
    waypoint: str = ""  # the waypoint to reach it from


SOFA_SEAT_Z = 0.47
BED_TOP_Z = 0.56
TOILET_SEAT_Z = 0.475
PLACES: dict[str, Place] = {
    "outside_entrance": Place(4.95, 9.6, -90.0, waypoint="landing"),
    "entrance_handle_outside": Place(5.1, 8.95, -90.0, waypoint="landing_door"),
    "entrance_handle_inside": Place(5.49, 7.52, 130.0, waypoint="entry"),
    "coat_hook": Place(5.8, 7.95, 0.0, waypoint="coat"),
    "shoe_bench": Place(5.55, 7.32, 180.0, seat=(5.98, 7.32, 0.5), waypoint="entry_east"),
    "fridge": Place(3.22, 4.72, 90.0, waypoint="kitchen_fridge"),
    "kitchen_counter": Place(1.5, 5.04, 90.0, waypoint="kitchen_counter"),
    "sink": Place(0.95, 5.04, 90.0, waypoint="kitchen_sink"),
    "stove": Place(2.05, 5.04, 90.0, waypoint="kitchen_stove"),
    "kitchen_seat": Place(1.2, 4.85, 180.0, seat=(0.93, 4.3, 0.51), waypoint="kitchen_counter"),
    "dining_seat": Place(7.6, 5.35, -90.0, seat=(7.25, 4.76, 0.51), waypoint="living_middle"),
    "sofa_seat": Place(8.66, 5.69, -90.0, seat=(8.66, 6.42, SOFA_SEAT_Z), waypoint="sofa"),
    "sofa_seat_east": Place(
        9.49, 5.69, -90.0, seat=(9.49, 6.42, SOFA_SEAT_Z), waypoint="sofa_east"
    ),
    "living_window": Place(10.2, 4.6, 0.0, waypoint="living_east"),
    "tv": Place(9.1, 4.1, -90.0, waypoint="tv"),
    "bookcase": Place(7.0, 6.2, 90.0, waypoint="bookcase"),
    "balcony_rail": Place(11.78, 6.3, 0.0, waypoint="balcony_north"),
    "balcony_seat": Place(11.84, 4.62, 45.0, seat=(11.43, 3.98, 0.49), waypoint="balcony_south"),
    "toilet": Place(5.5, 1.28, 90.0, seat=(5.5, 0.66, TOILET_SEAT_Z), waypoint="bathroom_toilet"),
    "washbasin": Place(4.9, 1.0, -90.0, waypoint="bathroom"),
    "shower": Place(6.3, 0.9, 180.0, waypoint="bathroom_shower"),
    "washing_machine": Place(5.7, 2.3, 0.0, waypoint="door_closet"),
    "bedside": Place(2.5, 2.14, -90.0, waypoint="bedroom"),
    "bed_edge": Place(2.5, 2.14, 90.0, seat=(2.5, 1.55, BED_TOP_Z), waypoint="bedroom"),
    # Lying: the yaw is the way from feet to head; `seat` is under the hips.
    "bed_lie": Place(2.5, 2.14, 0.0, seat=(2.3, 1.1, BED_TOP_Z), waypoint="bedroom"),
    "bedroom_window": Place(1.45, 2.2, 180.0, waypoint="bedroom_west"),
    "workroom_seat": Place(1.75, 7.5, -90.0, seat=(1.08, 7.25, 0.52), waypoint="workroom"),
    "workroom_window": Place(0.4, 7.95, 180.0, waypoint="workroom_west"),
}

# Free floor points, and the straight walks between them.
WAYPOINTS: dict[str, tuple[float, float]] = {
    "landing": (4.95, 9.6),
    "landing_door": (4.95, 8.95),
    "door_entrance": (4.93, 8.4),
    "entry": (5.0, 7.5),
    "entry_east": (5.5, 7.35),
    "coat": (5.8, 7.95),
    "hall_north": (4.85, 6.7),
    "hall_workroom": (4.6, 7.6),
    "door_workroom": (3.6, 7.6),
    "workroom_east": (3.1, 7.6),
    "workroom": (1.95, 7.66),
    "workroom_middle": (1.4, 7.95),
    "workroom_west": (0.4, 7.95),
    "hall_middle": (4.85, 5.5),
    "hall_kitchen": (4.75, 4.5),
    "door_kitchen": (3.6, 4.5),
    "kitchen_east": (3.1, 4.5),
    "kitchen_fridge": (3.16, 4.72),
    "kitchen": (2.0, 4.5),
    "kitchen_stove": (2.05, 5.04),
    "kitchen_counter": (1.5, 5.04),
    "kitchen_sink": (0.95, 5.04),
    "hall_south": (4.7, 3.3),
    "hall_bathroom": (4.72, 2.4),
    "door_bedroom": (3.6, 2.31),
    "bedroom_east": (3.15, 2.2),
    "bedroom": (2.5, 2.2),
    "bedroom_west": (1.45, 2.2),
    "door_bathroom": (4.72, 1.7),
    "bathroom": (4.85, 1.24),
    "bathroom_toilet": (5.5, 1.28),
    "bathroom_shower": (6.25, 1.28),
    "door_closet": (5.6, 2.3),
    "living_west": (6.3, 5.6),
    "living_middle": (7.6, 5.6),
    "bookcase": (7.0, 6.2),
    "sofa_west": (8.3, 5.69),
    "sofa": (8.66, 5.69),
    "sofa_east": (9.49, 5.69),
    "living_corner": (10.34, 5.7),
    "living_east": (10.2, 5.2),
    "tv_east": (10.1, 4.1),
    "tv": (9.1, 4.1),
    "living_balcony": (10.345, 6.33),
    "door_balcony": (10.815, 6.34),
    "balcony_north": (11.5, 6.38),
    "balcony": (11.83, 5.6),
    "balcony_south": (11.83, 4.68),
}
WAYS: tuple[tuple[str, str], ...] = (
    ("landing", "landing_door"),
    ("landing_door", "door_entrance"),
    ("door_entrance", "entry"),
    ("entry", "coat"),
    ("entry", "entry_east"),
    ("entry", "hall_workroom"),
    ("entry", "hall_north"),
    ("hall_workroom", "hall_north"),
    ("hall_workroom", "door_workroom"),
    ("door_workroom", "workroom_east"),
    ("workroom_east", "workroom"),
    ("workroom", "workroom_middle"),
    ("workroom_middle", "workroom_west"),
    ("hall_north", "hall_middle"),
    ("hall_north", "living_west"),
    ("hall_middle", "living_west"),
    ("hall_middle", "hall_kitchen"),
    ("hall_kitchen", "living_west"),
    ("hall_kitchen", "door_kitchen"),
    ("door_kitchen", "kitchen_east"),
    ("kitchen_east", "kitchen_fridge"),
    ("kitchen_east", "kitchen"),
    ("kitchen_fridge", "kitchen_stove"),
    ("kitchen", "kitchen_stove"),
    ("kitchen", "kitchen_counter"),
    ("kitchen_stove", "kitchen_counter"),
    ("kitchen_counter", "kitchen_sink"),
    ("hall_kitchen", "hall_south"),
    ("hall_middle", "hall_south"),
    ("hall_south", "hall_bathroom"),
    ("hall_bathroom", "door_bedroom"),
    ("hall_bathroom", "door_bathroom"),
    ("hall_bathroom", "door_closet"),
    ("door_bedroom", "bedroom_east"),
    ("bedroom_east", "bedroom"),
    ("bedroom", "bedroom_west"),
    ("door_bathroom", "bathroom"),
    ("bathroom", "bathroom_toilet"),
    ("bathroom_toilet", "bathroom_shower"),
    ("living_west", "living_middle"),
    ("living_west", "bookcase"),
    ("living_middle", "bookcase"),
    ("living_middle", "sofa_west"),
    ("sofa_west", "sofa"),
    ("sofa", "sofa_east"),
    ("sofa_east", "living_corner"),
    ("living_corner", "living_east"),
    ("living_east", "tv_east"),
    ("tv_east", "tv"),
    ("living_corner", "living_balcony"),
    ("living_balcony", "door_balcony"),
    ("door_balcony", "balcony_north"),
    ("balcony_north", "balcony"),
    ("balcony", "balcony_south"),
)
