# SPDX-License-Identifier: GPL-3.0-or-later
"""A day keys only the uses that something reads: sensors read the same as with all of them."""

from datetime import date

import bpy
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.scene.sensors import all_sensors
from bl_ext.user_default.angen_sensors.residents.blender import keys as keyed
from bl_ext.user_default.angen_sensors.residents.blender import run


def furnish(world):
    """Add sensors of many kinds, a seat that warms up, and a flag that is up over a bed."""
    bed, seat = bpy.data.objects["Bed"], bpy.data.objects["Seat"]
    above = {"Pyro": "PIR", "Array": "THERMAL_ARRAY", "Radar": "PRESENCE_RADAR", "Beam": "DISTANCE"}
    for number, (name, kind) in enumerate(above.items()):
        sensor = world.sensor(kind, name, update_rate=2.0)
        sensor.location = *seat.matrix_world.translation.xy, 2.3
        sensor.location.x += 0.1 * number
    bpy.data.objects["Pyro"].angen_sensor.pir.model = "PYROELECTRIC"
    plug = world.sensor("APPLIANCE", "Plug", update_rate=2.0)
    plug.angen_sensor.appliance.watched = seat
    seat.angen_heat.sort = "RADIATOR"
    flag = world.box((0.3, 0.3, 0.3), (*seat.matrix_world.translation.xy, 1.6), "Flag")
    driver = flag.driver_add("location", 2).driver
    variable = driver.variables.new()
    variable.targets[0].id, variable.targets[0].data_path = bed, "angen_use.in_use"
    driver.expression = f"1.2 + 0.4 * {variable.name}"
    bpy.context.view_layer.update()


QUICK = ["Plug", "Beam", "PIR left", "Contact"]


@pytest.mark.parametrize(
    "names",
    [
        pytest.param(QUICK, id="quick"),
        pytest.param(
            [*QUICK, "Pyro", "Array", "Radar", "PIR right"], id="many", marks=pytest.mark.slow
        ),
    ],
)
def test_a_day_is_equal_with_the_keys_of_all_uses(lived_home, world, monkeypatch, names):
    furnish(world)
    scene = bpy.context.scene
    sensors = [s for s in all_sensors(bpy.context.view_layer) if s.name in names]
    plan = run.Plan.read(lived_home.parent / "week.toml")
    household = run.HouseholdDays(scene, sensors, plan, date(2026, 3, 2), 1)
    # One gets up, switches the lamp on, and sits down.
    (start, _), *_ = household.acted(0).times_in_use()["Seat"]
    shown, write = set(), keyed.KeyedStretch._show_use

    def show_use(keys, name, *what):
        shown.add(name)
        write(keys, name, *what)

    monkeypatch.setattr(keyed.KeyedStretch, "_show_use", show_use)

    def lived():
        shown.clear()
        (day,) = run.run_days(household, [0], between=(start - 25.0, start + 5.0))
        return (day.events, day.people), set(shown)

    few, read = lived()
    monkeypatch.setattr(run, "_uses_read", lambda sensors: None)
    every, all_of_them = lived()
    assert (read, all_of_them) == ({"Bed", "Seat"}, {"Bed", "Seat", "Lamp"})
    assert few == every
    changed = {event.sensor for event in few[0] if event.time > (start - 25.0) * 1e6}
    assert {"Array", "Beam", "Contact", "Plug", "Radar"}.intersection(names) <= changed
