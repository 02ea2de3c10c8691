# SPDX-License-Identifier: GPL-3.0-or-later
"""The ray layer: its speed against `scene.ray_cast`, and the error of both."""

from __future__ import annotations

from typing import Any

from . import ray_accuracy, ray_layer


def measure(quick: bool) -> dict[str, Any]:
    return {
        "ray_accuracy": ray_accuracy.measure(frames=12 if quick else 72),
        "ray_layer": ray_layer.measure(quick),
    }
