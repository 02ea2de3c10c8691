# SPDX-License-Identifier: GPL-3.0-or-later
"""The 22 sensors with their housings: 7 motion detectors, 7 door switches, 7 light sensors, 1 pad.

A sensor that senses along a direction is an empty with its housing as a child; the direction is its
local −Z, with +Y up. Housings are built facing +y with z up, and turned once.
"""

from math import cos, pi, radians, sin

import bpy
from angen_sensors.residents.blender import person as people
from angen_sensors.residents.blender.settings import make_resident
from angen_sensors.residents.body.skeleton import Sort

from . import plan
from .architecture import CEILING_Z
from .meshes import MeshBuilder, collection, moved, place

Span = tuple[float, float]
PATHS = {
    "PIR": "Sensors/Motion detectors",
    "OPTICAL_SWITCH": "Sensors/Door switches",
    "LIGHT": "Sensors/Light sensors",
    "PRESSURE": "Sensors/Pressure sensors",
}


def _looking(
    name: str, kind: str, room: str, at: tuple[float, float, float], yaw: float
) -> bpy.types.Object:
    """Return a sensor that senses level along `yaw` (degrees)."""
    obj = bpy.data.objects.new(name, None)
    obj.empty_display_type = "PLAIN_AXES"
    obj.empty_display_size = 0.05
    obj.location = at
    obj.rotation_euler = (pi / 2, 0.0, radians(yaw - 90.0))
    collection(PATHS[kind]).objects.link(obj)
    obj.angen_sensor.kind = kind
    obj.angen_sensor.room = room
    return obj


def _house(sensor: bpy.types.Object, kind: str, mesh: bpy.types.Mesh | MeshBuilder) -> None:
    """Give a sensor its housing."""
    housing = place(f"{sensor.name} housing", mesh, PATHS[kind], parent=sensor)
    housing.rotation_euler = (-pi / 2, 0.0, 0.0)


def _pir_housing() -> MeshBuilder:
    """Return a white body on a swivel foot, whose domed lens reaches slightly beyond y = 0."""
    b = MeshBuilder("sensor body")
    b.box((-0.034, -0.042, -0.055), (0.034, -0.01, 0.055), 0.009)
    b.tube([(0, -0.042, 0), (0, -0.075, 0)], 0.013, 12)
    b.tube([(0, -0.068, 0), (0, -0.076, 0)], 0.028, 16)
    columns, rows = 12, 7

    def lens(u: float, v: float) -> tuple[float, float, float]:
        # A segmented Fresnel lens: a barrel with shallow grooves.
        angle = (u - 0.5) * pi
        rise = (v - 0.5) * 1.7
        groove = 0.0009 if round(u * columns) % 2 else 0.0
        r = 0.026 - groove
        return (-r * sin(angle), -0.012 + r * cos(angle) * cos(rise * 0.75), 0.04 * rise / 0.85)

    b.surface(lens, columns, rows, "sensor lens")
    b.box((-0.004, -0.011, -0.05), (0.004, -0.0085, -0.044), 0.001, "red")
    return b


def add_motion_detectors() -> None:
    """Add seven PIRs, level, high in the rooms' corners, on brackets that reach the corner."""
    mesh = _pir_housing().build("PIR housing")
    for name, mount in plan.PIRS.items():
        sensor = _looking(name, "PIR", mount.room, mount.at, mount.yaw)
        sensor.angen_sensor.pir.range_max = mount.range_max
        _house(sensor, "PIR", mesh)


def _switch_housing(wall_side: float, wall: float) -> MeshBuilder:
    """Return a fork about the beam, which runs along y from 0 to the gap's end.

    `wall` is the distance from the beam to the wall on the side ±x. The fork is open downwards and
    to the room, so that the flag can pass.
    """
    gap, b = plan.SWITCH_GAP, MeshBuilder("sensor dark")
    s = wall_side

    def box(x0: float, x1: float, y: Span, z: Span, what: str) -> None:
        b.box((s * x0, y[0], z[0]), (s * x1, y[1], z[1]), 0.002, what)

    dark, body = "sensor dark", "sensor body"
    for y in ((-0.02, -0.0005), (gap + 0.0005, gap + 0.02)):
        box(-0.012, 0.012, y, (-0.012, 0.034), dark)
    box(-0.012, wall - 0.001, (-0.02, gap + 0.02), (0.034, 0.052), body)
    box(wall - 0.004, wall, (-0.03, gap + 0.03), (-0.012, 0.07), body)
    box(-0.0125, -0.011, (gap / 2 - 0.006, gap / 2 + 0.006), (0.04, 0.046), "sensor green")
    return b


def add_door_switches() -> None:
    """Add seven optical switches over the doors, their beams across the flags' paths."""
    for door in plan.DOORS.values():
        at = (*door.switch, plan.SWITCH_Z)
        name = f"Switch {door.name}"
        sensor = _looking(name, "OPTICAL_SWITCH", door.swing_side, at, door.switch_yaw)
        sensor["door"] = f"Door {door.name}"
        # The wall lies towards the leaf's local +y: find its side of the beam.
        to_wall = moved(yaw=door.closed_yaw + 90.0).col[0].xyz
        right = moved(yaw=door.switch_yaw - 90.0).col[0].xyz
        hinge = moved(*door.hinge, 0.0, door.closed_yaw).inverted()
        beam_y = (hinge @ sensor.location).y
        side = 1.0 if to_wall.dot(right) > 0 else -1.0
        _house(sensor, "OPTICAL_SWITCH", _switch_housing(side, door.wall_face - beam_y))


def add_light_sensors() -> None:
    """Add seven light sensors below the ceilings, level, so that they see four walls."""
    at = next(iter(plan.LIGHT_SENSORS.values())).at
    up = CEILING_Z - at[2]
    b = MeshBuilder("sensor body")
    b.lathe([(0, -0.016), (0.014, -0.012), (0.021, 0.0), (0.021, 0.012)], segments=16,
            material="sensor lens")  # fmt: skip
    b.lathe([(0.026, 0.01), (0.026, 0.03), (0.012, 0.04), (0.008, 0.045), (0.008, up - 0.018),
             (0.04, up - 0.014), (0.042, up)], segments=16)  # fmt: skip
    b.lathe([(0, 0.01), (0.026, 0.01)][::-1], segments=16)
    mesh = b.build("Light sensor housing")
    for name, mount in plan.LIGHT_SENSORS.items():
        sensor = _looking(name, "LIGHT", mount.room, mount.at, mount.yaw)
        # With the scene's reference, more paths per update reduce the noise little.
        sensor.angen_sensor.light.samples = 256
        _house(sensor, "LIGHT", mesh)


def add_pressure_sensor() -> None:
    """Add a flat pad that lies on the sofa's frame, under the west seat cushion."""
    x, y, z = plan.PRESSURE_PAD_AT
    sx, sy, thick = (c / 2 for c in plan.PRESSURE_PAD_SIZE)
    b = MeshBuilder("sensor dark")
    b.box((-sx, -sy, -thick), (sx, sy, thick), 0.002)
    pad = place("Pressure sofa", b, PATHS["PRESSURE"], (x, y, z - thick))
    pad.angen_sensor.room = "living room"
    pad.angen_sensor.kind = "PRESSURE"
    pad.angen_sensor.pressure.threshold = plan.PRESSURE_THRESHOLD


def add_person() -> bpy.types.Object:
    """Add the resident: the armature "Person rig" with its mesh "Person", in warm clothes."""
    rig = people.add_person(collection("People"), name="Person rig")
    body = people.body_of(rig)
    body.name = body.data.name = "Person"
    make_resident(rig, Sort.ADULT)
    rig.angen_resident.mass = plan.PERSON_MASS
    body.angen_warmth.use_temperature, body.angen_warmth.temperature = True, 28.0
    return rig


def add_masses() -> None:
    """Add the other loads on the pad: the cushion on it, and the cushions that take some weight."""
    cushion = bpy.data.objects["Sofa seat cushion west"].angen_load
    cushion.mass = plan.CUSHION_MASS
    cushion.tolerance = plan.CUSHION_TOLERANCE
    for name, mass in plan.LEANING_MASSES.items():
        load = bpy.data.objects[name].angen_load
        load.mass, load.tolerance = mass, plan.CUSHION_TOLERANCE


def add_sensors() -> None:
    """Add all sensors."""
    add_motion_detectors()
    add_door_switches()
    add_light_sensors()
    add_pressure_sensor()
