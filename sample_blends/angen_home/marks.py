# SPDX-License-Identifier: GPL-3.0-or-later
"""The places of the home, marked with what residents do there in its story and a week's routine."""

from math import radians

import bpy

from . import plan
from .meshes import place

PATH = "Places"
# Marked objects: the use, and the yaw (degrees) of a person there, or of the head of one who lies.
# None: any direction with free floor.
THINGS: dict[str, tuple[str, float | None]] = {
    "Bed": ("LIE", 0.0),
    "Toilet": ("SIT", 90.0),
    "Kitchen chair 1": ("SIT", 90.0),
    "Kitchen chair 2": ("SIT", 180.0),
    "Dining chair 1": ("SIT", -90.0),
    "Dining chair 2": ("SIT", -90.0),
    "Dining chair 3": ("SIT", 90.0),
    "Dining chair 4": ("SIT", 90.0),
    "Bedroom chair": ("SIT", 180.0),
    "Shoe bench": ("SIT", 180.0),
    "Balcony chair": ("SIT", 45.0),
    "Washbasin": ("TAP", -90.0),
    "Kitchen sink": ("TAP", 90.0),
    "Stove": ("APPLIANCE", 90.0),
    "Fridge": ("APPLIANCE", 90.0),
    "Kettle": ("APPLIANCE", 90.0),
    "Washing machine": ("APPLIANCE", 0.0),
    "Printer": ("APPLIANCE", 90.0),
    "Television": ("APPLIANCE", -90.0),
    "Bread board": ("USE", 90.0),
    "Cup": ("USE", 180.0),
    "Wall cupboards": ("USE", 90.0),
    "Bookcase": ("USE", 90.0),
    "Coffee table": ("USE", -90.0),
    "Bottle": ("USE", 90.0),
    "Coat hooks": ("USE", 0.0),
    "Hall cabinet": ("USE", 180.0),
    "Bedroom shelf 1": ("USE", 90.0),
    "Bedroom shelf 2": ("USE", 90.0),
    "Workroom shelf": ("USE", 90.0),
    "Laundry basket": ("USE", 180.0),
    "Towel": ("USE", 180.0),
    "Plant living room": ("USE", -45.0),
    "Curtain south": ("CURTAIN", None),
    "Curtain north": ("CURTAIN", None),
    "Kitchen drawer 1": ("DRAWER", 90.0),
    "Kitchen drawer 2": ("DRAWER", 90.0),
    "Kitchen drawer 3": ("DRAWER", 90.0),
    "TV bench drawer left": ("DRAWER", -90.0),
    "TV bench drawer right": ("DRAWER", -90.0),
}
# The doors of cupboards, and the yaw (degrees) of a person who opens them. They open by 85°, and so
# miss walls beside them.
CUPBOARDS: dict[str, float] = {
    **{f"Cupboard shutter {n}": 90.0 for n in range(1, 6)},
    **{f"Base cupboard door {n}": 90.0 for n in range(1, 4)},
    **{f"Hall cabinet door {side}": 180.0 for side in ("left", "right")},
    **{f"Washbasin cupboard door {side}": -90.0 for side in ("left", "right")},
}
# Empties for uses without an object: a point (m) and a yaw (degrees).
POINTS: dict[str, tuple[str, tuple[float, float, float], float]] = {
    "Sofa west": ("SIT", (8.66, 6.42, plan.SOFA_SEAT_Z), -90.0),
    "Sofa east": ("SIT", (9.49, 6.42, plan.SOFA_SEAT_Z), -90.0),
    "Bed edge": ("SIT", (2.5, 1.55, plan.BED_TOP_Z), 90.0),
    "Desk west": ("SIT", (1.08, 7.25, 0.52), -90.0),
    "Desk east": ("SIT", (2.8, 6.9, 0.52), -90.0),
    "Coffee table end": ("USE", (8.8, 5.24, 0.47), -90.0),
    "Shower place": ("STAND", (6.3, 0.9, plan.FLOOR_Z), 180.0),
    "Living room window": ("STAND", (10.2, 4.6, plan.FLOOR_Z), 0.0),
    "Bedroom window": ("STAND", (1.45, 2.2, plan.FLOOR_Z), 180.0),
    "Workroom window": ("STAND", (0.4, 7.95, plan.FLOOR_Z), 180.0),
    "Balcony rail": ("STAND", (11.78, 6.3, plan.FLOOR_Z), 0.0),
    "Outside": ("STAND", (4.95, 9.6, plan.FLOOR_Z), -90.0),
}
# Where on the wall each lamp is switched.
SWITCHES: dict[str, tuple[float, float, float]] = {
    "Lamp hall": (5.55, 8.29, 1.1),
    "Lamp entry": (5.65, 8.29, 1.1),
    "Lamp kitchen": (3.49, 5.15, 1.1),
    "Lamp bedroom": (3.71, 2.95, 1.1),
    "Lamp workroom": (3.49, 8.2, 1.1),
    "Lamp bathroom": (5.35, 1.81, 1.1),
    "Lamp closet": (5.49, 1.9, 1.1),
    "Lamp living room": (6.3, 6.99, 1.1),
    "Lamp balcony": (10.655, 5.75, 1.1),
}
# Lamps that are switched where they stand.
HANDY = ("Floor lamp", "Bedside lamp")


def add_marks() -> None:
    """Mark the home's objects, after all of them were added."""
    bpy.context.view_layer.update()
    for name, (use, yaw) in THINGS.items():
        _mark(bpy.data.objects[name], use, yaw)
    for name, (use, at, yaw) in POINTS.items():
        obj = _empty(name, at, "ARROWS")
        _mark(obj, use, yaw)
    for name, door in plan.DOORS.items():
        mark = bpy.data.objects[f"Door {name}"].angen_place
        mark.use, mark.angle = "DOOR", radians(abs(door.open_yaw - door.closed_yaw))
        mark.entrance = name == "entrance"
    for name, yaw in CUPBOARDS.items():
        door = bpy.data.objects[name]
        _mark(door, "CUPBOARD", yaw)
        door.angen_place.angle = radians(85.0)
    fridge = bpy.data.objects["Fridge door"]
    fridge.angen_place.use, fridge.angen_place.angle = "DOOR", -fridge["open_yaw"]
    # The hinge does not give the side to which the door opens; these keys do, until the story's.
    for frame, yaw in ((2, fridge["open_yaw"]), (1, 0.0)):
        fridge.rotation_euler.z = yaw
        fridge.keyframe_insert("rotation_euler", index=2, frame=frame)
    for name, at in SWITCHES.items():
        mark = bpy.data.objects[name].angen_place
        mark.use, mark.switch = "LAMP", _empty(f"Switch of {name}", at, "CIRCLE")
    for name in HANDY:
        bpy.data.objects[name].angen_place.use = "LAMP"
    for obj in bpy.data.objects:
        if obj.angen_place.use not in ("NONE", "DOOR"):
            obj.angen_place.room = _room(*obj.matrix_world.translation.xy)


def _room(x: float, y: float) -> str:
    """Return the room at a point, "" outside: hall and living room have no wall between them."""
    for name, parts in plan.ROOMS.items():
        if any(x0 <= x <= x1 and y0 <= y <= y1 for x0, y0, x1, y1 in parts):
            return name
    return ""


def _empty(name: str, at: tuple[float, float, float], shape: str) -> bpy.types.Object:
    """Add an empty."""
    obj = place(name, None, PATH, at)
    obj.empty_display_type, obj.empty_display_size = shape, 0.1
    return obj


def _mark(obj: bpy.types.Object, use: str, yaw: float | None) -> None:
    """Mark an object with its use."""
    obj.angen_place.use = use
    if yaw is not None:
        # The yaw of a mark counts from the object's own front, -Y.
        obj.angen_place.facing = radians(yaw + 90.0) - obj.matrix_world.to_euler().z
