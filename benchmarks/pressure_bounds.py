# SPDX-License-Identifier: GPL-3.0-or-later
"""What the pressure sensor is held to: closed forms, MuJoCo, and the data sheet by hand."""

from __future__ import annotations

from typing import Any

from .bounds import Bounds

# Relative error against the closed form, by group. At rest 4.3e-8, Blender's gravity in single
# precision; on several legs what Bullet's own contacts leave open (9e-4, 5e-3 under a sitter); of
# an impulse 7e-4; of things that slide or are lifted 9e-3.
ERROR = {
    "rest": 1e-6,
    "four legs": 2e-3,
    "sitter": 8e-3,
    "drop": 1.2e-3,
    "moving": 1.3e-2,
    "shapes": 1e-6,
    "extremes": 1e-6,
    "piles": 1e-6,
}
SUM = 1e-6
# Relative difference from MuJoCo: 1.9e-6 at rest, 5.7e-3 where legs share a load.
MUJOCO = {"rest": 1e-5, "shapes": 1e-5, "extremes": 1e-5, "four legs": 8e-3, "sitter": 1e-2}
# Least share of valid updates. Piles tumble for seconds: 80 % of their updates are valid. It was
# 93 % before bodies settled on their contacts (b156a93). An active mesh hops at first.
VALID, VALID_MOVING = 1.0, {"shapes": 0.95, "mesh": 0.6, "piles": 0.75}
IN_A_GLANCE = ("rest", "four legs", "drop")
# Newtons and updates of the sample's table.
TABLE_N, TABLE_UPDATES = 2e-3, 230
# Relative error over the size of an island: more than 20 bodies lean on each other less exactly.
ISLAND, LARGE_ISLAND, LARGE = 1e-6, 5e-3, 20


def check(data: dict[str, Any], bounds: Bounds) -> None:
    groups = {row["group"] for row in data["accuracy"]}
    bounds.measured("groups of scenes", groups, IN_A_GLANCE if data["quick"] else ERROR)
    for row in data["accuracy"]:
        group, name = row["group"], f"{row['group']}, {row['scene'].partition(' (')[0]}"
        most = SUM if row["scene"].endswith("sum of the legs") else ERROR[group]
        bounds.at_most(f"{name}: error", row["error"], most)
        if row["mujoco"] is not None:
            bounds.at_most(f"{name}: difference from MuJoCo", row["mujoco"], MUJOCO[group])
        share = row["valid"] / row["updates"]
        moving = "mesh" if row["scene"].startswith("mesh ") else group
        bounds.at_least(f"{name}: valid updates", share, VALID_MOVING.get(moving, VALID))
    if data["mujoco"]:
        bounds.at_least(
            "scenes in MuJoCo", sum(row["mujoco"] is not None for row in data["accuracy"]), 2
        )
    by_hand = [row for row in data["resistor"] if row["by_hand"] is not None]
    bounds.at_least("forces worked out by hand", len(by_hand), 5)
    for row in by_hand:
        bounds.equal(f"ADC at {row['force_n']:g} N", row["adc"], row["by_hand"])
    bounds.at_most("legs of the sample's table, worst N", data["table"]["worst_newtons"], TABLE_N)
    bounds.at_least("valid updates of the sample's table", data["table"]["valid"], TABLE_UPDATES)
    for row in (*data["speed"]["island"], *data["speed"]["scene"]):
        name = f"island of {row['bodies']}, {row['elsewhere']} bodies elsewhere"
        most = LARGE_ISLAND if row["bodies"] > LARGE else ISLAND
        bounds.at_most(f"{name}: error", row["error"], most)
        bounds.equal(f"{name}: valid updates", row["valid"], row["updates"])
