# SPDX-License-Identifier: GPL-3.0-or-later
"""A home with a recording, and the state of that recording."""

from importlib import import_module

import bpy

ADDON = "bl_ext.user_default.angen_sensors"
ops = bpy.ops.angen


def results():
    return import_module(f"{ADDON}.angen_addon.recording.results").RESULTS


def stale():
    """Return why the recording is stale; "" if it is fresh, None without one."""
    kept = results().kept(bpy.context.scene)
    return kept.stale if kept is not None else None


def columns():
    recording = results().kept(bpy.context.scene).recording
    return {
        name: [track.frames, track.times, track.active, track.value]
        for name, track in recording.tracks.items()
    }


def recorded(world):
    """Add a door that opens before a switch, a lamp, a skinned flag and nodes; record them."""
    world.door(13)
    world.switch("Front door")
    shelf = world.box((1, 1, 1), at=(3, 0, 0), name="shelf")
    material = bpy.data.materials.new("paint")
    shelf.data.materials.append(material)
    shelf.modifiers.new("copies", "ARRAY").count = 2
    tree = bpy.data.node_groups.new("nodes", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    math = tree.nodes.new("ShaderNodeMath")
    math.inputs[0].default_value = 0.25
    shelf.modifiers.new("nodes", "NODES").node_group = tree
    texture = bpy.data.textures.new("bumps", "CLOUDS")
    shelf.modifiers.new("bumps", "DISPLACE").texture = texture
    shelf.shape_key_add(name="Basis")
    shelf.shape_key_add(name="wide")
    group = shelf.vertex_groups.new(name="top")
    group.add([0, 1], 0.5, "REPLACE")
    lamp = world.link("lamp", bpy.data.lights.new("lamp", "POINT"), (0, 0, 3))
    lamp.parent = shelf
    world.link("camera", bpy.data.cameras.new("camera"))
    hidden = world.box((1, 1, 1), at=(9, 0, 0), name="hidden")
    hidden.hide_set(True)
    world.update()
    assert ops.simulate() == {"FINISHED"}
    assert stale() == ""
    bpy.ops.ed.undo_push(message="recorded")
    return world


def named(name):
    return bpy.data.objects[name]


def move(obj):
    obj.location.x += 0.5


def save_and_load(path):
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    assert not bpy.data.texts, "it is a part of files alone"
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    assert stale() is None
    bpy.ops.wm.open_mainfile(filepath=str(path))
