# SPDX-License-Identifier: GPL-3.0-or-later
r"""Set up Blender's window for a picture of the sample home.

PICTURE=coverage blender --factory-startup --addons bl_ext.user_default.angen_sensors \
    sample_blends/angen.blend --python scripts/pictures/scenes.py

PICTURE is a function below. READY is printed when the window shows it; `make pictures` takes all.
"""

import os
import sys
from collections.abc import Iterator
from math import radians
from pathlib import Path
from typing import Any

import bpy
from mathutils import Vector

sys.path.append(str(Path(__file__).parent))
import window

CAMERA = "Camera living"
# A free piece of wall in the view, from its lower left corner.
MOUSE = (0.33, 0.73)


def place() -> Iterator[None]:
    """Show a new motion detector under the mouse, on a wall of the living room."""
    main = bpy.context.window_manager.windows[0]
    area = window.areas()["VIEW_3D"]
    space = area.spaces[0]
    region = window.region_of(area)
    window.through_camera(space, CAMERA)
    window.plain(space)
    space.show_region_ui = False
    scene = bpy.context.scene
    scene.angen_overlay.fields = scene.angen_show_places = False
    bpy.ops.object.select_all(action="DESELECT")
    bpy.context.view_layer.objects.active = None
    window.play_up_to(1850)
    yield
    x, y = (int(region.x + MOUSE[0] * region.width), int(region.y + MOUSE[1] * region.height))
    main.cursor_warp(x, y)
    yield
    with bpy.context.temp_override(
        window=main, area=area, region=region, space_data=space, region_data=space.region_3d
    ):
        bpy.ops.angen.sensor_place("INVOKE_DEFAULT", kind="PIR", preset="HAA53_SCAN")
    yield
    main.cursor_warp(x + 3, y)
    yield
    yield


def coverage() -> Iterator[None]:
    """Show a coverage map and a proposal."""
    scene = bpy.context.scene
    main = bpy.context.window_manager.windows[0]
    view = window.areas()["VIEW_3D"]
    space = view.spaces[0]
    window.without_ceilings()
    window.only_panels("coverage", "coverage_place")
    window.plain(space)
    space.shading.light = "FLAT"
    scene.angen_overlay.show = False
    window.view_from(space, (6.6, 4.0, 0.0), 16.0, 18.0)
    settings = scene.angen_coverage
    inside = window.region_of(view)
    with bpy.context.temp_override(window=main, area=view, region=inside):
        bpy.context.view_layer.objects.active = bpy.data.objects["PIR bedroom"]
        settings.motion, settings.rooms, settings.count = "CAT", "bedroom, hall", 2
        bpy.ops.angen.place_propose("EXEC_DEFAULT")
        settings.rooms = ""
        bpy.ops.angen.coverage("EXEC_DEFAULT")
    yield
    window.open_sidebar(view)
    yield
    yield
    yield


ROUTINE = Path(__file__).resolve().parents[2] / "sample_blends" / "week.toml"
SHOWN = "Meal preparation"


def day() -> Iterator[None]:
    """Show a stretch of a simulated day."""
    main = bpy.context.window_manager.windows[0]
    view = window.areas()["VIEW_3D"]
    space = view.spaces[0]
    window.without_ceilings()
    window.view_from(space, (4.6, 4.3, 0.0), 13.0, 18.0)
    window.only_panels("day")
    window.plain(space)
    settings = bpy.context.scene.angen_day
    settings.routine = str(ROUTINE)
    settings.date = "2026-03-02"
    inside = window.region_of(view)
    with bpy.context.temp_override(window=main, area=view, region=inside):
        bpy.ops.angen.day_read()
        index = next(i for i, done in enumerate(settings.done) if done.name == SHOWN)
        bpy.ops.angen.day_show(index=index)
    yield
    window.open_sidebar(view)
    start = bpy.context.scene.frame_start
    for frame in range(start, start + 150):
        bpy.context.scene.frame_set(frame)
    yield
    yield
    yield


# Frame, centre of the view (m), its distance (m), its tilt from above and its turn (degrees), and
# the active sensor.
VIEWS: dict[str, tuple[int, tuple[float, float, float], float, float, float, str]] = {
    "motion": (1586, (7.9, 4.6, 0.8), 9.0, 52.0, -35.0, "PIR living room"),
    "home": (700, (5.0, 4.0, 0.0), 19.0, 30.0, 0.0, "PIR hall"),
    "door": (84, (5.0, 8.2, 2.15), 1.3, 80.0, 15.0, "Switch entrance"),
    "sofa": (1876, (8.7, 6.2, 0.75), 3.0, 62.0, -30.0, "Pressure sofa"),
    "light": (1500, (7.9, 4.6, 1.0), 9.0, 45.0, 25.0, "Light sensor living room"),
}


def overlay() -> Iterator[None]:
    """Show the signs of the sensors in the viewport: one of `VIEWS` by the variable VIEW."""
    frame, middle, distance, tilt, turn, name = VIEWS[os.environ.get("VIEW", "motion")]
    view = window.areas()["VIEW_3D"]
    space = view.spaces[0]
    window.select(name)
    window.plain(space)
    space.overlay.show_extras = False
    window.view_from(space, middle, distance, tilt, turn)
    bpy.context.scene.angen_overlay.which = os.environ.get("WHICH", "ALL")
    yield
    window.play_up_to(frame)
    yield
    window.open_sidebar(view)
    yield
    yield
    yield


def pyroelectric() -> Iterator[None]:
    """Show the panel of a pyroelectric detector."""
    areas = window.areas()
    space = areas["VIEW_3D"].spaces[0]
    window.select("Person rig")
    bpy.ops.angen.warmth_set(sort="PERSON")
    sensor = window.select("PIR living room")
    sensor.angen_sensor.update_rate = 24.0
    sensor.angen_sensor.pir.model = "PYROELECTRIC"
    sensor.angen_sensor.pir.lens = "HC_SR501"
    sensor.angen_sensor.pir.range_max = 7.0
    window.through_camera(space, CAMERA)
    window.plain(space)
    space.show_region_ui = False
    bpy.context.scene.angen_show_places = False
    areas["PROPERTIES"].spaces[0].context = "PHYSICS"
    # The outliner's height goes to the properties.
    window.close("OUTLINER")
    yield
    window.play_up_to(1640)
    yield
    window.redraw()
    yield
    yield


def only_places() -> None:
    """Hide what the sensors see and read, so that the marks of the places remain."""
    overlay = bpy.context.scene.angen_overlay
    overlay.fields = overlay.names = overlay.values = False


def places() -> Iterator[None]:
    """Show the home's places, one door unmarked."""
    main = bpy.context.window_manager.windows[0]
    view = window.areas()["VIEW_3D"]
    space = view.spaces[0]
    window.without_ceilings()
    window.view_from(space, (4.6, 4.3, 0.0), 13.0, 18.0)
    window.only_panels("places")
    window.plain(space)
    space.shading.light = "FLAT"
    only_places()
    inside = window.region_of(view)
    with bpy.context.temp_override(window=main, area=view, region=inside):
        window.select("Door kitchen")
        bpy.data.objects["Door bedroom"].angen_place.use = "NONE"
        bpy.ops.angen.places_check()
    yield
    window.open_sidebar(view)
    yield
    yield
    yield


PLACES = (("ADULT", 1.3, 0.3), ("CHILD", 2.2, 0.0), ("CAT", 2.9, -0.5), ("OLDER_ADULT", 0.2, 0.0))


def residents() -> Iterator[None]:
    """Show all types of residents, and the panel of one, without a home."""
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    cursor = bpy.context.scene.cursor
    for sort, x, y in PLACES:
        cursor.location, cursor.rotation_euler = (x, y, 0.0), (0.0, 0.0, -0.5)
        bpy.ops.angen.resident_add(sort=sort, walking_frame=sort == "OLDER_ADULT")
    space = window.areas()["VIEW_3D"].spaces[0]
    window.plain(space)
    window.view_from(space, (1.8, 0.0, 0.8), 4.4, 69.0)
    window.only_panels("sidebar_resident")
    yield
    window.open_sidebar(window.areas()["VIEW_3D"])
    yield
    yield


FRAMES = 1, 700
EVENT = 69
# Share of the window's height that the timeline gets.
TIMELINE = 0.45


def timeline() -> Iterator[None]:
    """Show the sensors' timeline and an explanation over the first half minute."""
    main = bpy.context.window_manager.windows[0]
    scene = bpy.context.scene
    areas = window.areas()
    # A higher timeline replaces the low one at the bottom.
    window.close("DOPESHEET_EDITOR")
    yield
    with bpy.context.temp_override(window=main, area=areas["VIEW_3D"]):
        bpy.ops.screen.area_split(direction="HORIZONTAL", factor=TIMELINE)
    yield
    views = [area for area in main.screen.areas if area.type == "VIEW_3D"]
    timeline, view = sorted(views, key=lambda area: area.y)
    timeline.ui_type = "TIMELINE"
    yield
    timeline.spaces.active.show_region_ui = False
    window.only_panels("events")
    yield
    for obj in bpy.data.objects:
        if obj.angen_sensor.kind == "LIGHT":
            obj.angen_sensor.light.samples = 4
    scene.frame_end = FRAMES[1]
    yield
    window.select("PIR hall")
    yield
    bpy.ops.angen.simulate("EXEC_DEFAULT")
    scene.frame_set(EVENT)
    bpy.ops.angen.explain()
    space = view.spaces[0]
    space.show_region_ui = True
    space.shading.color_type = "MATERIAL"
    yield
    for area in (view, timeline):
        region = window.region_of(area)
        with bpy.context.temp_override(window=main, area=area, region=region):
            if area is view:
                scene.camera = bpy.data.objects[CAMERA]
                space.region_3d.view_perspective = "CAMERA"
            else:
                bpy.ops.action.view_all()
    yield
    window.open_sidebar(view)
    yield
    yield


def scrub() -> Iterator[None]:
    """The playhead goes through the living room's story: a picture at each SHOT."""
    view = window.areas()["VIEW_3D"]
    space = view.spaces[0]
    window.select("PIR living room")
    window.plain(space)
    space.overlay.show_extras = False
    window.view_from(space, *VIEWS["motion"][1:5])
    bpy.context.scene.angen_overlay.which = "SELECTED"
    bpy.context.scene.angen_show_places = False
    yield
    window.open_sidebar(view)
    first = VIEWS["motion"][0] - 60
    window.play_up_to(first)
    yield
    for frame in range(first, first + 96, 4):
        for number in range(frame - 3, frame + 1):
            bpy.context.scene.frame_set(number)
        window.redraw()
        yield
        print("SHOT", flush=True)
        yield


def atelier() -> Iterator[None]:
    """The studio of `atelier.blend` from above, with its places."""
    space = window.areas()["VIEW_3D"].spaces[0]
    window.without_ceilings()
    window.plain(space)
    space.show_region_ui = False
    space.shading.light = "FLAT"
    space.overlay.show_extras = False
    only_places()
    bpy.context.scene.angen_show_places = True
    window.select("Bath door")
    window.view_from(space, (14.5, 0.3, 0.4), 13.5, 30.0, 27.0)
    yield
    yield


BEDROOM = (0.0, 0.0, 0.2)


def imported() -> Iterator[None]:
    """Show the bedroom of `docs/your_own_home.md` as its glTF file has it, without its ceiling."""
    view = empty_scene()
    bpy.ops.import_scene.gltf(filepath=os.environ["HOME_MODEL"])
    bpy.data.objects["wall(Clone).036"].hide_set(True)
    bpy.ops.object.select_all(action="DESELECT")
    bpy.context.view_layer.objects.active = None
    view.spaces[0].show_region_ui = False
    view.spaces[0].overlay.show_floor = True
    window.close("OUTLINER", "PROPERTIES")
    yield
    window.view_from(view.spaces[0], BEDROOM, 6.2, 42.0, -30.0)
    yield
    yield


def prepared() -> Iterator[None]:
    """Show the bedroom as the commands of `docs/your_own_home.md` leave it."""
    view = window.areas()["VIEW_3D"]
    window.plain(view.spaces[0])
    view.spaces[0].overlay.show_extras = False
    window.close("OUTLINER", "PROPERTIES")
    window.only_panels("table", "simulation", "events")
    detector = next(o for o in bpy.data.objects if o.angen_sensor.kind == "PIR")
    window.select(detector.name)
    main = bpy.context.window_manager.windows[0]
    with bpy.context.temp_override(window=main, area=view, region=window.region_of(view)):
        bpy.ops.angen.simulate("EXEC_DEFAULT")
    yield
    window.view_from(view.spaces[0], (0.7, -0.3, 0.4), 6.2 * 1.94, 42.0, -30.0)
    window.play_up_to(142)
    window.open_sidebar(view)
    yield
    yield


# Beside the bed and the sofa of the page.
MORE_PLACES = (("Kitchen", "STAND", (10.0, 2.0, 0.9)), ("Upstairs", "SIT", (6.0, 5.0, 3.2)))


def places_ifc() -> Iterator[None]:
    """Show the places of the FZK-Haus, without its upper floor."""
    view = window.areas()["VIEW_3D"]
    space = view.spaces[0]
    window.plain(space)
    window.close("OUTLINER", "PROPERTIES")
    yield
    window.only_panels("places")
    only_places()
    main = bpy.context.window_manager.windows[0]
    with bpy.context.temp_override(window=main, area=view, region=window.region_of(view)):
        for name, use, at in MORE_PLACES:
            bpy.context.scene.cursor.location = at
            bpy.ops.angen.place_point(use=use)
            bpy.context.object.name = name
        window.select(next(o.name for o in bpy.data.objects if o.name.startswith("Door Innent")))
        bpy.ops.angen.places_check()
    for obj in bpy.data.objects:
        heights = [(obj.matrix_world @ Vector(corner)).z for corner in obj.bound_box]
        slab = obj.name.startswith("Slab") and max(heights) > 1.0
        if min(heights) > 2.0 or slab or obj.name.startswith("Site"):
            obj.hide_set(True)
    window.view_from(space, (7.3, 5.0, 0.0), 18.5, 30.0)
    yield
    window.open_sidebar(view)
    yield
    yield


def empty_scene() -> Any:
    """Removes all objects; returns the 3D view."""
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    view = window.areas()["VIEW_3D"]
    window.plain(view.spaces[0])
    return view


def box(name: str, size: tuple[float, float, float], at: tuple[float, float, float]) -> Any:
    bpy.ops.mesh.primitive_cube_add(size=1.0, location=at)
    obj = bpy.context.object
    obj.name, obj.scale = name, size
    return obj


def sensor(
    kind: str, preset: str, at: tuple[float, float, float], turn: tuple[float, float, float]
) -> Any:
    """A new sensor at a point (m), turned about X, Y and Z (degrees)."""
    bpy.context.scene.cursor.location = at
    bpy.ops.angen.sensor_add(kind=kind, preset=preset)
    obj = bpy.context.object
    obj.rotation_euler = [radians(angle) for angle in turn]
    return obj


def distance() -> Iterator[None]:
    """The zones of a distance sensor on a wall and a column."""
    view = empty_scene()
    box("Floor", (4.0, 4.0, 0.1), (2.0, 2.0, -0.05))
    box("Wall", (0.1, 4.0, 2.0), (4.0, 2.0, 1.0))
    box("Column", (0.3, 0.3, 1.6), (2.0, 2.4, 0.8))
    sensor("DISTANCE", "VL53L5CX", (0.6, 2.0, 1.2), (90.0, 0.0, -90.0))
    window.view_from(view.spaces[0], (2.6, 2.0, 0.7), 6.8, 58.0, -40.0)
    yield
    window.only_panels("table", "active_sensor")
    window.play_up_to(31)
    window.open_sidebar(view)
    yield
    yield


def thermal_array() -> Iterator[None]:
    """The pixels of an infrared array in the living room, and its panel."""
    view = window.areas()["VIEW_3D"]
    window.areas()["PROPERTIES"].spaces[0].context = "PHYSICS"
    window.select("Person rig")
    bpy.ops.angen.warmth_set(sort="PERSON")
    found = window.select("PIR living room")
    found.name, found.angen_sensor.kind = "Array living room", "THERMAL_ARRAY"
    array = found.angen_sensor.thermal_array
    array.columns, array.rows = 16, 12
    array.horizontal_fov, array.vertical_fov = radians(75.0), radians(60.0)
    found.rotation_euler.x -= radians(20.0)
    window.plain(view.spaces[0])
    view.spaces[0].overlay.show_extras = False
    bpy.context.scene.angen_overlay.which = "SELECTED"
    window.without_ceilings()
    window.view_from(view.spaces[0], (8.0, 5.2, 0.9), 6.5, 42.0, 125.0)
    yield
    window.play_up_to(1586)
    view.spaces[0].show_region_ui = False
    yield
    yield
    window.redraw()
    yield


def presence_radar() -> Iterator[None]:
    """The gates of a radar in the living room, its target with its speed, and the panel's bars."""
    view = window.areas()["VIEW_3D"]
    found = window.select("PIR living room")
    found.name, found.angen_sensor.kind = "Radar living room", "PRESENCE_RADAR"
    radar = found.angen_sensor.presence_radar
    radar.max_targets, radar.angle_resolution = 3, radians(30.0)
    found.rotation_euler.x = radians(75.0)
    window.plain(view.spaces[0])
    view.spaces[0].overlay.show_extras = False
    window.without_ceilings()
    bpy.context.scene.angen_overlay.which = "SELECTED"
    window.view_from(view.spaces[0], (8.6, 7.2, 1.0), 9.0, 40.0, 25.0)
    yield
    window.only_panels("active_sensor")
    window.play_up_to(1640)
    window.open_sidebar(view)
    yield
    yield
    yield


def contact() -> Iterator[None]:
    """The two distances of a door contact, and its magnet between them."""
    view = empty_scene()
    window.lens(view.spaces[0])
    box("Leaf", (0.9, 0.04, 0.3), (0.47, 0.0, 0.9))
    box("Frame", (0.06, 0.08, 0.5), (-0.06, 0.0, 0.9))
    # 34 mm from the contact, which closes at 32 mm and opens at 36 mm.
    magnet = box("Magnet", (0.01, 0.02, 0.03), (0.0325, -0.03, 0.9))
    found = sensor("CONTACT", "MS_214_1_NDC_L", (0.002, -0.045, 0.9), (90.0, 0.0, 0.0))
    found.angen_sensor.contact.magnet = magnet
    # The label would hide the magnet.
    overlay = bpy.context.scene.angen_overlay
    overlay.names = overlay.values = False
    window.view_from(view.spaces[0], (0.01, -0.04, 0.9), 0.28, 70.0, 20.0)
    yield
    window.only_panels("table", "active_sensor")
    window.play_up_to(31)
    window.open_sidebar(view)
    yield
    yield


def switch() -> Iterator[None]:
    """A card crosses the beam of a swept switch between two frames, and *Explain* tells it."""
    view = empty_scene()
    window.lens(view.spaces[0])
    scene = bpy.context.scene
    scene.frame_end = 48
    box("Floor", (1.0, 1.0, 0.02), (0.0, 0.0, -0.01))
    card = box("Card", (0.001, 0.1, 0.06), (-0.9, 0.0, 0.3))
    card.keyframe_insert("location", frame=1)
    card.location.x = 2.0
    card.keyframe_insert("location", frame=25)
    found = sensor("OPTICAL_SWITCH", "THESIS", (0.0, 0.0, 0.4), (0.0, 0.0, 0.0))
    found.name = "Switch"
    settings = found.angen_sensor.optical_switch
    settings.threshold, settings.swept = 0.3, True
    found.angen_sensor.update_rate = 24.0
    window.view_from(view.spaces[0], (0.0, 0.0, 0.25), 1.3, 65.0, 30.0)
    yield
    bpy.ops.angen.simulate("EXEC_DEFAULT")
    scene.frame_set(1)
    bpy.ops.angen.event_jump(direction="NEXT")
    bpy.ops.angen.explain()
    window.only_panels("table", "events")
    yield
    window.open_sidebar(view)
    yield
    yield


PICTURES = {
    scene.__name__: scene
    for scene in (
        *(place, coverage, day, overlay, pyroelectric, places, residents, timeline),
        *(scrub, atelier, distance, thermal_array, presence_radar, contact, switch),
        *(imported, prepared, places_ifc),
    )
}
# Seconds between two steps, where not half a second.
EVERY = {"place": 0.6, "timeline": 0.3}
picture = os.environ["PICTURE"]
window.show(PICTURES[picture](), EVERY.get(picture, 0.5))
