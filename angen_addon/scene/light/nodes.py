# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes materials of nodes in few lines."""

from __future__ import annotations

from typing import Any

import bpy


def has_nodes(owner: Any) -> bool:
    """Whether a lamp or a world has nodes and uses them: since Blender 5.0 all do."""
    return bool(owner.node_tree and (bpy.app.version >= (5, 0) or owner.use_nodes))


class Nodes:
    """A new material's nodes, to be linked together."""

    def __init__(self, own: Any) -> None:
        self.material = own(bpy.data.materials.new(".angen_light"))
        if not self.material.node_tree:
            self.material.use_nodes = True
        self._tree = self.material.node_tree
        self._tree.nodes.clear()

    def add(self, kind: str, operation: str = "", **inputs: Any) -> Any:
        node = self._tree.nodes.new(kind)
        if operation:
            node.operation = operation
        for name, source in inputs.items():
            to = node.inputs[int(name[1:]) if name[1:].isdigit() else name.capitalize()]
            if isinstance(source, bpy.types.NodeSocket):
                self._tree.links.new(source, to)
            else:
                to.default_value = source
        return node

    def vector(self, name: str) -> Any:
        node = self.add("ShaderNodeAttribute")
        node.attribute_name = name
        return node.outputs["Vector"]
