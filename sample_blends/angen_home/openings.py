# SPDX-License-Identifier: GPL-3.0-or-later
"""The fillings of the walls' openings: hinged doors with frames, windows, the balcony's glazing."""

from math import pi

import bpy
from mathutils import Vector

from . import plan
from .meshes import MeshBuilder, moved, place

LINING = 0.022  # thickness of a door's lining
REBATE = 0.012  # overlap of the frame's head and the leaf
CASING = 0.06  # width of the strips around a doorway
FLAG_THICKNESS = 0.004
HANDLE_Z = 1.05


def _leaf(door: plan.Door) -> MeshBuilder:
    """Return the leaf in its own frame: hinge on the z axis, leaf along +x."""
    lo, hi = (0.004, 0.0, plan.LEAF_BOTTOM), (door.leaf_width - 0.004, plan.LEAF_THICKNESS,
                                              plan.LEAF_TOP)  # fmt: skip
    outside = door.name in ("entrance", "balcony")
    leaf = MeshBuilder("walnut z" if door.name == "entrance" else "white paint")
    if door.name == "balcony":
        rail = 0.1
        leaf.box(lo, (lo[0] + rail, hi[1], hi[2]))
        leaf.box((hi[0] - rail, lo[1], lo[2]), hi)
        leaf.box((lo[0] + rail, lo[1], lo[2]), (hi[0] - rail, hi[1], lo[2] + 0.3))
        leaf.box((lo[0] + rail, lo[1], hi[2] - rail), (hi[0] - rail, hi[1], hi[2]))
        leaf.box((lo[0] + rail - 0.01, 0.027, lo[2] + 0.29), (hi[0] - rail + 0.01, 0.033,
                 hi[2] - rail + 0.01), 0.0, "glass")  # fmt: skip
    else:
        leaf.box(lo, hi)
        # Sunk panels on both faces, drawn by thin raised mouldings.
        margin = 0.11 if door.leaf_width > 0.7 else 0.08
        for z0, z1 in ((0.18, 0.82), (0.95, plan.LEAF_TOP - 0.12)):
            for y0, y1 in ((-0.003, 0.004), (hi[1] - 0.004, hi[1] + 0.003)):
                frame(leaf, (margin, z0), (door.leaf_width - margin, z1), y0, y1, 0.022)
    for hinge_z in (0.3, 1.05, 1.8):
        leaf.cylinder((0.004, -0.004, hinge_z - 0.045), 0.008, 0.09, 8, "steel")
    x = door.leaf_width - 0.07
    for y, out in ((0.0, -1), (plan.LEAF_THICKNESS, 1)):
        leaf.box((x - 0.02, y, HANDLE_Z - 0.1), (x + 0.02, y + 0.006 * out, HANDLE_Z + 0.06),
                 0.003, "steel")  # fmt: skip
        end = y + 0.05 * out
        leaf.rod((x, y, HANDLE_Z), (x, end, HANDLE_Z), 0.009, 8, "steel")
        leaf.tube(
            [(x + 0.008, end, HANDLE_Z), (x - 0.06, end, HANDLE_Z), (x - 0.12, end - 0.008 * out,
             HANDLE_Z)], 0.009, 8, "steel",
        )  # fmt: skip
    if outside and door.name == "entrance":
        leaf.cylinder((door.leaf_width / 2, plan.LEAF_THICKNESS - 0.002, 1.5), 0.012, 0.006, 10,
                      "brass")  # fmt: skip
    return leaf


def frame(
    builder: MeshBuilder,
    lo: tuple[float, float],
    hi: tuple[float, float],
    y0: float,
    y1: float,
    width: float,
    material: str | None = None,
) -> None:
    """Add four bars around the rectangle lo…hi in the x–z plane, between y0 and y1."""
    bevel = min(0.004, width / 4)
    builder.box((lo[0], y0, lo[1]), (lo[0] + width, y1, hi[1]), bevel, material)
    builder.box((hi[0] - width, y0, lo[1]), (hi[0], y1, hi[1]), bevel, material)
    builder.box((lo[0] + width, y0, lo[1]), (hi[0] - width, y1, lo[1] + width), bevel, material)
    builder.box((lo[0] + width, y0, hi[1] - width), (hi[0] - width, y1, hi[1]), bevel, material)


def _frame(door: plan.Door) -> MeshBuilder:
    """Return lining behind the leaf, casings on both wall faces, panel over the leaf, and sill."""
    u0, u1 = door.opening_at, door.opening_at + door.opening
    front, back = door.wall_face, door.wall_face + door.wall_depth
    head = plan.DOOR_HEAD
    f = MeshBuilder("white paint")
    behind = plan.LEAF_THICKNESS + 0.003
    lining = LINING if door.opening > 0.8 else 0.014
    for a, b in ((u0, u0 + lining), (u1 - lining, u1)):
        f.box((a, behind, plan.FLOOR_Z), (b, back + 0.008, head), 0.003)
    if u0 < 0:  # a filler where the leaf is narrower than the opening
        f.box((u0, front - 0.002, plan.FLOOR_Z), (-0.001, behind, head), 0.003)
        f.box((door.leaf_width + 0.001, front - 0.002, plan.FLOOR_Z), (u1, behind, head), 0.003)
    f.box((u0, max(front + 0.003, 0.02), plan.LEAF_TOP + 0.006), (u1, back + 0.008, head), 0.003)
    # The rebate: behind the leaf the head reaches below its top, as the lining does beside it.
    f.box((u0, behind, plan.LEAF_TOP - REBATE), (u1, back + 0.008, plan.LEAF_TOP + 0.01), 0.003)
    f.box((u0, 0.012, 0.03), (u1, back + 0.01, plan.FLOOR_Z + 0.003), 0.002, "oak")
    # Casings on both sides and over the head, with a gap on the swing side for the switch.
    middle = _flag_u(door)
    for y, out in ((front, -1), (back, 1)):
        y0, y1 = sorted((y, y + 0.012 * out))
        for a, b in ((u0 - CASING, u0), (u1, u1 + CASING)):
            f.box((a, y0, plan.FLOOR_Z), (b, y1, head + CASING), 0.003)
        if out > 0:
            f.box((u0, y0, head), (u1, y1, head + CASING), 0.003)
        else:
            f.box((u0, y0, head), (middle - 0.075, y1, head + CASING), 0.003)
            f.box((middle + 0.075, y0, head), (u1, y1, head + CASING), 0.003)
    return f


def _flag_u(door: plan.Door) -> float:
    """Return where along the leaf the flag stands: in the centre of the switch's gap."""
    hinge = moved(*door.hinge, 0.0, door.closed_yaw).inverted()
    turn = moved(yaw=door.switch_yaw)
    gap = turn @ Vector((plan.SWITCH_GAP / 2, 0.0, 0.0))
    return (hinge @ Vector((door.switch[0] + gap.x, door.switch[1] + gap.y, 0.0))).x


def _flag_y(door: plan.Door) -> float:
    hinge = moved(*door.hinge, 0.0, door.closed_yaw).inverted()
    return (hinge @ Vector((*door.switch, 0.0))).y


def add_doors() -> dict[str, bpy.types.Object]:
    """Add the seven doors, closed, with their frames and the flags that break the beams."""
    leaves = {}
    meshes: dict[str, bpy.types.Mesh] = {}
    for door in plan.DOORS.values():
        at = (*door.hinge, 0.0)
        path = "Home/Doors"
        place(f"Door frame {door.name}", _frame(door), path, at, door.closed_yaw)
        style = door.name if door.name in ("entrance", "balcony") else f"room {door.leaf_width}"
        if style not in meshes:
            meshes[style] = _leaf(door).build(f"Door leaf {style}")
        leaf = place(f"Door {door.name}", meshes[style], path, at, door.closed_yaw)
        u, y = _flag_u(door), _flag_y(door)
        flag = MeshBuilder("sensor flag")
        half = FLAG_THICKNESS / 2
        flag.box((u - half, y - 0.012, plan.FLAG_Z[0] - 0.02), (u + half, y + 0.012,
                 plan.FLAG_Z[1]), 0.0008)  # fmt: skip
        flag.box((u - 0.03, y - 0.012, plan.LEAF_TOP), (u + 0.03, y + 0.012,
                 plan.LEAF_TOP + 0.004), 0.001)  # fmt: skip
        place(f"Flag {door.name}", flag, path, parent=leaf)
        leaf["open_yaw"] = door.open_yaw * pi / 180
        leaves[door.name] = leaf
    return leaves


def add_windows() -> None:
    """Add frames with two casements and a pane each; sills inside."""
    for window in plan.WINDOWS:
        width, height = window.y1 - window.y0, plan.WINDOW_HEAD - plan.WINDOW_SILL
        # Built along x with the room towards −y, then turned into the wall.
        b = MeshBuilder("white paint")
        y0, y1 = -0.035, 0.035
        frame(b, (0, 0), (width, height), y0 - 0.01, y1 + 0.01, 0.05)
        casements = 2 if width > 1.5 else 1
        step = (width - 0.1) / casements
        for i in range(casements):
            x0 = 0.05 + i * step
            frame(b, (x0, 0.05), (x0 + step, height - 0.05), y0, y1, 0.055)
            b.box((x0 + 0.05, -0.004, 0.1), (x0 + step - 0.05, 0.004, height - 0.1), 0, "glass")
            hx = x0 + (step - 0.028 if i == 0 else 0.028)
            b.box((hx - 0.008, y0 - 0.02, 0.6), (hx + 0.008, y0, 0.72), 0.003, "steel")
        depth = window.x1 - window.x0
        into = depth / 2 + 0.035
        b.box((0.0, -into, -0.0), (width, -0.045, 0.022), 0.005)  # sill
        x = (window.x0 + window.x1) / 2
        yaw = 90.0 if window.inside > 0 else -90.0
        y = window.y0 if window.inside > 0 else window.y1
        place(f"Window {window.name}", b, "Home/Windows", (x, y, plan.WINDOW_SILL), yaw)


def add_balcony_glazing() -> None:
    """Add panes in slim posts all around the balcony, and its handrail."""
    panes, posts = MeshBuilder("glass"), MeshBuilder("black metal")
    for box in plan.BALCONY_GLAZING:
        x, y = (box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2
        along_x = box.x1 - box.x0 > box.y1 - box.y0
        if along_x:
            panes.box((box.x0, y - 0.005, box.z0), (box.x1, y + 0.005, box.z1), 0)
        else:
            panes.box((x - 0.005, box.y0, box.z0), (x + 0.005, box.y1, box.z1), 0)
        length = box.x1 - box.x0 if along_x else box.y1 - box.y0
        count = max(2, round(length / 0.9))
        for i in range(count + 1):
            t = i / count
            px = box.x0 + 0.03 + t * (box.x1 - box.x0 - 0.06) if along_x else x
            py = y if along_x else box.y0 + 0.03 + t * (box.y1 - box.y0 - 0.06)
            posts.box((px - 0.02, py - 0.02, box.z0), (px + 0.02, py + 0.02, box.z1), 0.004)
        for z in (box.z0 + 0.015, box.z1 - 0.015):
            lo = (box.x0, y - 0.025, z - 0.015) if along_x else (x - 0.025, box.y0, z - 0.015)
            hi = (box.x1, y + 0.025, z + 0.015) if along_x else (x + 0.025, box.y1, z + 0.015)
            posts.box(lo, hi, 0.004)
    place("Balcony panes", panes, "Home/Windows")
    place("Balcony posts", posts, "Home/Windows")
