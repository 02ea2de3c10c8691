# SPDX-License-Identifier: GPL-3.0-or-later
"""The pressure sensor: its error, its cost, and the figure of the sample's table."""

from __future__ import annotations

from typing import Any

from angen_sensors.sensor_logic.kinds.pressure import ForceResistor, PressureParameters

from . import pressure_accuracy, pressure_mujoco, pressure_speed, pressure_table

# What a divider with 10 kΩ at 5 V and 10 bits reads from the data sheet's curve, by hand.
BY_HAND = {0.2: 260, 1.0: 642, 5.0: 854, 10.0: 910, 20.0: 952}
FORCES = (0.0, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 200.0)


def measure(quick: bool) -> dict[str, Any]:
    return {
        "mujoco": pressure_mujoco.HAS_MUJOCO,
        "accuracy": pressure_accuracy.measure(quick),
        "resistor": resistor(),
        "table": pressure_table.measure(),
        "speed": pressure_speed.measure(quick),
    }


def resistor() -> list[dict[str, Any]]:
    """The resistor with its default parameters, fresh at each force."""
    rows = []
    for force in FORCES:
        felt = ForceResistor().update(PressureParameters(), force, 0.0, 0.0)
        rows.append(
            {
                "force_n": force,
                "resistance_ohm": felt.resistance_ohm,
                "voltage_v": felt.voltage_v,
                "adc": felt.adc,
                "by_hand": BY_HAND.get(force),
            }
        )
    return rows
