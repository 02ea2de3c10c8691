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


@pytest.mark.parametrize("what", ["lamp", "wall"])
def test_a_run_of_one_sensor_reads_what_it_reads_among_all(
    world: Any, command: Callable[..., tuple[int, str, str]], tmp_path: Any, what: str
) -> None:
    """The switch, which the run leaves out, lights the lamp and moves the wall."""
    world.door(5, 9, 14, 15, 20)
    world.switch("switch")
    lamp(world, "POINT", at=(5.5, 0.0, 0.5), energy=50.0).name = "Bulb"
    world.sensor(
        "LIGHT", "lux", method="ILLUMINANCE", samples=4, update_rate=24.0, threshold=1.0
    ).location = (5.5, 0.0, 1.0)
    pir = world.pir("pir")
    pir.location, pir.rotation_euler = (4.0, 0.0, 0.0), (1.5707963, 0.0, -1.5707963)
    world.box((0.1, 4.0, 3.0), at=(8.0, 0.0, 0.0), name="wall")
    lamp_lit(world) if what == "lamp" else moved(world)
    world.scene.frame_end = 24
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "home.blend"))
    name = "lux" if what == "lamp" else "pir"
    all_rows = command("simulate", "--quiet")[1].splitlines()
    status, out, told = command("simulate", "--sensor", name)
    rows = out.splitlines()
    assert status == 0 and rows == [r for r in all_rows if r.split(",")[2] in ("sensor", name)]
    assert len(rows) > 4
    assert "simulated too, since drivers read their outputs: 'switch'" in told
    # Only what is chosen is written.
    expected = tmp_path / "expected.csv"
    expected.write_text(out, encoding="utf-8")
    samples = tmp_path / "samples"
    assert command("check", expected, "--sensor", name)[0] == 0
    assert command("simulate", "--sensor", name, "--samples", samples)[0] == 0
    assert [path.name for path in samples.iterdir()] == [f"{name}.csv"]
