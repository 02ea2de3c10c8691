# SPDX-License-Identifier: GPL-3.0-or-later
"""What reads a sensor's outputs follows them in a run, whatever it drives; the run reads the same
as one that looks at all of the scene anew after each frame."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import bpy
import pytest
from light_stage import lamp


def drive(owner: Any, path: str, index: int = -1) -> None:
    """By `active` of the switch."""
    driver = owner.driver_add(path, index).driver if index >= 0 else owner.driver_add(path).driver
    driver.type, variable = "SUM", driver.variables.new()
    variable.targets[0].id = bpy.data.objects["switch"]
    variable.targets[0].data_path = "angen_sensor.active"


def screen(world: Any, name: str = "screen") -> Any:
    """Before the detector, and beside the lamp."""
    return world.box((0.02, 1.5, 1.5), at=(6.0, 0.0, 0.0), name=name)


def moved(world: Any) -> None:
    drive(screen(world), "location", 1)


def parent_turned(world: Any) -> None:
    above = world.link("above", None)
    screen(world).parent = above
    drive(above, "rotation_euler", 2)


def hidden(world: Any) -> None:
    drive(screen(world), "hide_viewport")


def reshaped(world: Any) -> None:
    obj = screen(world)
    obj.shape_key_add(name="Basis")
    other = obj.shape_key_add(name="other")
    for point in other.data:
        point.co.x += 1.0
    drive(obj.data.shape_keys, 'key_blocks["other"].value')


def bent(world: Any) -> None:
    modifier = screen(world).modifiers.new("d", "DISPLACE")
    modifier.strength = 0.0
    drive(modifier.id_data, 'modifiers["d"].strength')


def modifier_shown(world: Any) -> None:
    modifier = screen(world).modifiers.new("a", "ARRAY")
    modifier.use_relative_offset, modifier.use_constant_offset = False, True
    modifier.constant_offset_displace = -1.0, 0.5, 0.0
    drive(modifier.id_data, 'modifiers["a"].show_viewport')


def held(world: Any) -> None:
    far = world.link("far", None, at=(4.0, 0.5, 0.0))
    constraint = screen(world).constraints.new("COPY_LOCATION")
    constraint.target = far
    drive(constraint.id_data, 'constraints["Copy Location"].influence')


def instanced(world: Any) -> None:
    group = bpy.data.collections.new("group")
    group.objects.link(bpy.data.objects.new("leaf", screen(world).data))
    holder = world.link("holder", None, at=(5.0, 0.0, 0.0))
    holder.instance_type, holder.instance_collection = "COLLECTION", group
    drive(holder, "location", 1)


def lamp_lit(world: Any) -> None:
    drive(bpy.data.objects["Bulb"].data, "energy")


def of_another_sensor(world: Any) -> None:
    screen(world)
    drive(bpy.data.objects["range"], "location", 1)


CASES = [
    moved, parent_turned, hidden, reshaped, bent, modifier_shown, held, instanced, lamp_lit,
    of_another_sensor,
]  # fmt: skip


def _follow(*_: Any) -> None:
    """A handler of other code."""


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.__name__)
def test_what_follows_the_outputs_is_sensed_as_if_all_were_looked_at_anew(
    world: Any, case: Callable[[Any], None]
) -> None:
    world.door(5, 9, 14, 15, 20)
    world.switch("switch")
    pir = world.pir("pir")
    pir.location, pir.rotation_euler = (2.0, 0.0, 0.0), (1.5707963, 0.0, -1.5707963)
    lamp(world, "POINT", at=(6.5, 0.0, 1.0), energy=50.0).name = "Bulb"
    world.sensor(
        "LIGHT", "lux", method="ILLUMINANCE", samples=16, update_rate=24.0, threshold=1.0
    ).location = (5.5, 0.0, 1.0)
    ranger = world.sensor("DISTANCE", "range", update_rate=24.0, noise_sigma=0.0)
    ranger.location, ranger.rotation_euler = (4.5, 0.0, 0.0), pir.rotation_euler
    world.box((0.1, 4.0, 3.0), at=(8.0, 0.0, 0.0), name="wall")
    case(world)
    world.scene.frame_end = 24
    found = world.run()
    # Beside other code that follows edits, everything is looked at anew at each of them.
    followers = bpy.app.handlers.depsgraph_update_post
    followers.append(_follow)
    try:
        plain = world.run()
    finally:
        followers.remove(_follow)
    assert found.tracks == plain.tracks
    # Something came of the drivers.
    told = ("lux",) if case is lamp_lit else ("pir", "range", "lux")
    assert any(len(set(found.tracks[name].value)) > 1 for name in told), case.__name__
