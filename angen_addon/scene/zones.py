# SPDX-License-Identifier: GPL-3.0-or-later
"""Simulation zones of geometry nodes: what they make depends on the frames before."""

from __future__ import annotations

from typing import Any


def has_simulation_zone(modifier: Any) -> bool:
    """Also in a group within its nodes."""
    group = getattr(modifier, "node_group", None)
    return group is not None and _tree_has_zone(group, set())


def _tree_has_zone(tree: Any, seen: set[str]) -> bool:
    if tree.name_full in seen:
        return False
    seen.add(tree.name_full)
    for node in tree.nodes:
        if node.bl_idname == "GeometryNodeSimulationOutput":
            return True
        inner = getattr(node, "node_tree", None)
        if inner is not None and _tree_has_zone(inner, seen):
            return True
    return False
