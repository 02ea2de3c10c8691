# SPDX-License-Identifier: GPL-3.0-or-later
"""Simulation zones of geometry nodes: what they make depends on the frames before."""

from __future__ import annotations

from typing import Any

from .timed import has_node


def has_simulation_zone(modifier: Any) -> bool:
    """Also in a group within its nodes."""
    group = getattr(modifier, "node_group", None)
    return has_node(group, lambda node: node.bl_idname == "GeometryNodeSimulationOutput")
